/* import: what the importers share.
 *
 * An importer is one function, scene_read_FORMAT(import): it reads import->path and pushes meshes,
 * instances, materials, textures and lights onto import->scene, as the file has them. scene_read
 * then calls scene_finish, which leaves out degenerate triangles, checks every index and number,
 * and applies the settings: importers need not. A half-filled scene is freed by scene_read.
 *
 * Errors say what is wrong; scene_read puts the path in front. Includes from C and from C++.
 */
#ifndef IMPORT_H
#define IMPORT_H

#ifdef __cplusplus
#include <cmath>
#include <cstring>
#include <exception>
#include <math.h>
#include <new>
#include <stdexcept>
extern "C" {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic" /* vec.h has compound literals */
#pragma GCC diagnostic ignored "-Wshadow"   /* C names a struct and a function scene_solids */
#endif

#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/warning.h"
#include "image/image.h"
#include "math/angle.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct texture_entry; /* a texture that was asked for before */

struct scene_import {
    struct scene *scene;
    const char *path;      /* the scene's file */
    const char *directory; /* where the files that it names are found: "", or ending with '/' */
    struct warnings *warnings;
    struct texture_entry *entries; /* owned by import.c */
    size_t entry_count, entry_capacity;
};

/* -- the importers ---------------------------------------------------------------------------- */

struct error *scene_read_obj(struct scene_import *import);  /* OBJ with MTL */
struct error *scene_read_gltf(struct scene_import *import); /* glTF and GLB */
struct error *scene_read_ply(struct scene_import *import);
struct error *scene_read_off(struct scene_import *import);
struct error *scene_read_stl(struct scene_import *import);

/* -- what they push --------------------------------------------------------------------------- */

/* Each takes over what its argument owns (mesh arrays, a material's name, a texture's texels), on
 * errors too. *index, where it is not NULL, is the place in the scene's list. */
struct error *scene_push_mesh(struct scene *scene, struct scene_mesh mesh, size_t *index);
struct error *scene_push_instance(struct scene *scene, size_t mesh, const double transform[12]);
struct error *scene_push_material(struct scene *scene, struct scene_material material,
                                  int32_t *index);
struct error *scene_push_texture(struct scene *scene, struct scene_texture texture, int32_t *index);
struct error *scene_push_light(struct scene *scene, struct scene_light light);

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
};

/* Pushes a mesh of these faces, split into triangles, placed as it stands. Faces of fewer than 3
 * corners and those with a corner out of range are left out with a warning. */
struct error *scene_import_polygons(struct scene_import *import,
                                    const struct scene_polygons *polygons);

/* Faces gathered one by one, all of one grey material (0.8). Start with {0}, free with
 * scene_faces_clear. */
struct scene_faces {
    double *position;
    size_t vertex_count, vertex_capacity;
    uint32_t *size;
    size_t count, capacity;
    uint32_t *corner;
    size_t corner_count, corner_capacity;
};

struct error *scene_faces_vertex(struct scene_faces *faces, double x, double y, double z);
/* a face without corners as yet */
struct error *scene_faces_begin(struct scene_faces *faces);
/* adds a corner to the newest face */
struct error *scene_faces_corner(struct scene_faces *faces, uint32_t vertex);
struct error *scene_import_faces(struct scene_import *import, const struct scene_faces *faces);
void scene_faces_clear(struct scene_faces *faces);

/* The part of scene_finish that is about geometry: what changes meshes later calls it again. */
struct error *scene_finish_geometry(struct scene *scene, struct warnings *warnings);

/* Frees a mesh that was not pushed. */
void scene_mesh_clear(struct scene_mesh *mesh);

/* White, opaque (opacity 1, cutoff 0.5), black emission, no maps; name NULL, which push makes
 * "". */
struct scene_material scene_material_default(void);

/* A map of this texture that leaves (u, v) alone. */
struct scene_map scene_map_of(int32_t texture);

/* p -> p, for scene_push_instance. */
extern const double scene_identity[12];

/* -- files and textures ----------------------------------------------------------------------- */

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
 * sampler. One that is missing or damaged is a warning, and *texture SCENE_NONE; only a shortage of
 * memory is an error. */
struct error *scene_import_texture(struct scene_import *import, const char *name,
                                   enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture);

/* The same for a picture in memory; `name` ("image 3") tells it apart from others, and names it in
 * a warning. */
struct error *scene_import_picture(struct scene_import *import, const char *name, const void *data,
                                   size_t size, enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture);

#ifdef __cplusplus
#pragma GCC diagnostic pop
} /* extern "C" */

/* Runs f, which returns a struct error *, and turns whatever it throws into an error: no exception
 * crosses into C. */
template <class Function> struct error *scene_guard(const Function &f) noexcept
{
    try {
        return f();
    } catch (const std::bad_alloc &) {
        return error_memory();
    } catch (const std::length_error &) {
        return error_memory();
    } catch (const std::exception &e) {
        return error_new("%s", e.what());
    } catch (...) {
        return error_new("an unknown exception was thrown");
    }
}
#endif

#endif
