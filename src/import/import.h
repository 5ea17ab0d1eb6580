/* SPDX-License-Identifier: Apache-2.0 */
/* import: what the importers share (import_scene.h is what programs call).
 *
 * An importer is one function, scene_read_FORMAT(import): it reads what scene_import_content gives
 * it and pushes meshes, instances, materials, textures and lights onto import->scene, as the file
 * has them. scene_read then calls scene_finish, which leaves out degenerate triangles, checks every
 * index and number, and applies the settings: importers need not. A half-filled scene is freed by
 * scene_read.
 *
 * Errors say what is wrong; scene_read puts the path in front. Includes from C and from C++.
 */
#ifndef IMPORT_H
#define IMPORT_H

#ifdef __cplusplus
#include "base/error_guard.h"

#include <cmath>
#include <cstring>
#include <math.h>
extern "C" {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic" /* vec.h has compound literals */
#endif

#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/warning.h"
#include "image/image.h"
#include "math/angle.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_shade.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct texture_entry; /* a texture that was asked for before */

struct scene_import {
    struct scene *scene;
    const char *path;      /* the scene's file */
    const char *directory; /* where the files that it names are found: "", or ending with '/' */
    struct warnings *warnings;
    bool lenient; /* what is broken is left out with a warning */
    /* the file's content, which was read once (it may be a pipe), until it is taken; owned */
    char *content;
    size_t content_size;
    size_t broken_line;            /* of the file, where the error is; 0: not known */
    struct texture_entry *entries; /* owned, import_files.c makes them */
    size_t entry_count, entry_capacity;
};

/* -- the importers ---------------------------------------------------------------------------- */

struct error *scene_read_obj(struct scene_import *import);  /* OBJ with MTL */
struct error *scene_read_gltf(struct scene_import *import); /* glTF and GLB */
struct error *scene_read_ply(struct scene_import *import);
struct error *scene_read_off(struct scene_import *import);
struct error *scene_read_stl(struct scene_import *import);

/* -- colours ---------------------------------------------------------------------------------- */

/* Colours of vertices or faces as a file has them, codes of a screen (sRGB) from 0 to 1 or, where
 * any is above 2, to 255; four numbers each. */
struct scene_colours {
    float *rgba; /* owned; red is NaN where nothing is stated */
    size_t count, capacity;
    float unstated; /* the light of what has no colour, from 0 to 1 */
};

/* Sets a colour; those before it that were not set are not stated. An alpha below 0: none, opaque.
 */
struct error *scene_colours_set(struct scene_colours *colours, size_t index, const double rgba[4]);
void scene_colours_clear(struct scene_colours *colours);

/* The same as scene_mesh has them, `count` of them, for the caller to free; sets *blended where one
 * is not opaque. Where all have alpha 0, that is left alone with a warning. */
struct error *scene_import_colours(struct scene_import *import, const struct scene_colours *colours,
                                   size_t count, uint16_t **codes, bool *blended);

/* -- faces ----------------------------------------------------------------------------------- */

/* Faces with any number of corners, for scene_import_polygons. Arrays stay the caller's. */
struct scene_polygons {
    const double *position; /* 3 * vertex_count */
    size_t vertex_count;
    const uint32_t *size; /* count: the corners of each face */
    size_t count;
    /* the faces' corners one after the other: vertices; one that is out of range spoils its face */
    const uint32_t *corner;
    const float *uv;         /* two a corner, or NULL */
    const int32_t *material; /* one a face */
    const uint32_t *line;    /* of the file, one a face, or NULL */
    /* of vertices, and of faces; where vertices have some, those count. None: NULL, or empty */
    const struct scene_colours *colour, *face_colour;
    const struct scene_run *runs; /* parts of the file, whose `first` are faces here */
    size_t run_count;
    bool edges; /* the format draws points and edges as faces of one and two corners */
};

/* Pushes a mesh of these faces, split into triangles, placed as it stands. Faces of fewer than 3
 * corners are broken (`edges`: left out with a warning), and those with a corner out of range.
 * Materials of faces whose colours are not opaque become blended. */
struct error *scene_import_polygons(struct scene_import *import,
                                    const struct scene_polygons *polygons);

/* Faces gathered one by one, all of one material: grey (0.8), or their colour. Start with {0}, free
 * with scene_faces_clear. */
struct scene_faces {
    double *position;
    size_t vertex_count, vertex_capacity;
    uint32_t *size;
    size_t count, capacity;
    uint32_t *corner;
    size_t corner_count, corner_capacity;
    struct scene_colours vertex_colour, face_colour; /* for scene_colours_set */
    bool edges;                                      /* of struct scene_polygons */
};

struct error *scene_faces_vertex(struct scene_faces *faces, double x, double y, double z);
/* a face without corners as yet */
struct error *scene_faces_begin(struct scene_faces *faces);
/* adds a corner to the newest face */
struct error *scene_faces_corner(struct scene_faces *faces, uint32_t vertex);
struct error *scene_import_faces(struct scene_import *import, const struct scene_faces *faces);
void scene_faces_clear(struct scene_faces *faces);

/* -- files and textures ----------------------------------------------------------------------- */

/* The whole of the scene's file, one zero byte behind it; the caller frees it. To be called
 * once. */
void scene_import_content(struct scene_import *import, char **data, size_t *size);

/* Takes off a text what programs of Windows and DOS put around it: a byte order mark before it,
 * zero bytes and Ctrl-Z behind. `text` stays the caller's. */
void scene_import_bare(const char **text, size_t *size);

/* Reads a number of a text, as number_read_f64 does; also what the C libraries of Windows write for
 * one that is not finite, as 1.#QNAN and -nan(ind). */
const char *scene_import_number(const char *from, const char *end, double *value);

/* Something that the file holds and that is lost: an error without the file's name, or where the
 * user said --lenient a warning of this kind. `line` of the file, from 1; 0: none. */
struct error *scene_import_broken(struct scene_import *import, const char *kind, size_t line,
                                  const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Warns where a text ends in a number and nothing ends its last line: what is left of a number that
 * was cut off is a number too. `path` of the text. */
void scene_import_warn_end(struct scene_import *import, const char *path, const char *text,
                           size_t size);

/* The path of a file that the scene names: absolute names as they are, others from
 * import->directory; backslashes are slashes where the name as written does not exist; letters may
 * differ in case from the file's on disk. When nothing is found *path is NULL. The caller frees
 * it. */
struct error *scene_import_find(const struct scene_import *import, const char *name, char **path);

/* How a texture is read between and beyond its texels. */
struct scene_sampler {
    enum scene_wrap wrap_u, wrap_v;
    bool nearest;
};

/* The texture in the file called `name` (found by scene_import_find), read once for each use and
 * sampler. One that is missing or of an unknown format is a warning, and *texture SCENE_NONE; one
 * that is damaged, or that may not be read, is broken. */
struct error *scene_import_texture(struct scene_import *import, const char *name,
                                   enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture);

/* The same for a picture in memory; `name` ("image 3") tells it apart from others, and names it in
 * a warning. */
struct error *scene_import_picture(struct scene_import *import, const char *name, const void *data,
                                   size_t size, enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture);

/* Warns of a material that all light passes, wherever on it. */
void scene_import_warn_hidden(struct scene_import *import, const struct scene_material *m,
                              const char *name);

/* Frees what the helpers keep in it. */
void scene_import_clear(struct scene_import *import);

#ifdef __cplusplus
#pragma GCC diagnostic pop
} /* extern "C" */
#endif

#endif
