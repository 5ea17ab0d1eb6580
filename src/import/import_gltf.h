/* SPDX-License-Identifier: Apache-2.0 */
/* import_gltf: what the two halves of the glTF importer share. import_gltf_file.cc opens the file
 * and fetches what it names; import_gltf.cc makes a scene of it. C++ only.
 */
#ifndef IMPORT_GLTF_H
#define IMPORT_GLTF_H

#include "import/import.h"

#include <memory>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

/* Carries an error through C++; scene_read_gltf catches it. */
struct gltf_error {
    struct error *err;
};

[[noreturn]] inline void gltf_fail(struct error *err)
{
    throw gltf_error{err};
}

inline void gltf_check(struct error *err)
{
    if (err)
        gltf_fail(err);
}

/* Bytes, and what keeps them in memory. */
struct gltf_bytes {
    std::shared_ptr<const void> owner;
    const unsigned char *data = nullptr;
    size_t size = 0;
};

/* Where a picture is: in a buffer view, or at a URI. */
struct gltf_picture {
    std::string uri; /* empty: view */
    int view = -1;
};

/* Joints as nodes, and the accessor of their inverse bind matrices; -1: the identity. */
struct gltf_skin {
    std::vector<int> joints;
    int bind = -1;
};

struct gltf_file {
    /* without buffers, images, and what an importer of light has no use for */
    tinygltf::Model model;
    std::vector<gltf_bytes> buffers; /* as long as they say they are */
    std::vector<gltf_picture> pictures;
    std::vector<gltf_skin> skins;
    std::vector<std::vector<double>> weights; /* of each node's morph targets; empty: its mesh's */
};

/* Opens import->path. Throws a gltf_error when a buffer is missing or short, or an unknown
 * extension is required. */
gltf_file gltf_open(struct scene_import *import);

bool gltf_is_data(const std::string &uri); /* whether it is a data: URI */
/* what that holds; nothing where it is damaged */
gltf_bytes gltf_data(const std::string &uri);
/* The name of the file at a URI, for scene_import_find. */
std::string gltf_file_name(const struct scene_import *import, const std::string &uri);

#endif
