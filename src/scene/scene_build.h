/* SPDX-License-Identifier: Apache-2.0 */
/* scene_build: making a scene, by an importer or by hand.
 *
 *     scene_create(&scene);
 *     scene_push_material(scene, material, &number);
 *     scene_push_mesh(scene, mesh, &place);            whose triangles have that number
 *     scene_push_instance(scene, place, scene_identity);
 *     scene_finish(scene, &settings, warnings);
 *
 * After scene_finish the scene is legal (scene.h), and not to be added to. What fails leaves a
 * scene that scene_destroy frees. C and C++.
 */
#ifndef SCENE_BUILD_H
#define SCENE_BUILD_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

struct error;
struct image;
struct scene_settings;
struct warnings;

/* A scene without anything; free with scene_destroy. */
struct error *scene_create(struct scene **scene);

/* Adds a mesh with one material, placed once as it stands; copies the arrays. */
struct error *scene_add_mesh(struct scene *scene, size_t vertex_count, const double *position,
                             size_t triangle_count, const uint32_t *index,
                             const struct scene_material *material);

/* To be called once after the parts were put together by hand or by an importer: leaves out
 * degenerate triangles, computes the box, applies settings, checks every index and that everything
 * is finite. */
struct error *scene_finish(struct scene *scene, const struct scene_settings *settings,
                           struct warnings *warnings);

/* Each takes over what its argument owns (mesh arrays, a material's name, a texture's texels), on
 * errors too. *index, where it is not NULL, is the place in the scene's list. */
struct error *scene_push_mesh(struct scene *scene, struct scene_mesh mesh, size_t *index);
struct error *scene_push_instance(struct scene *scene, size_t mesh, const double transform[12]);
struct error *scene_push_material(struct scene *scene, struct scene_material material,
                                  int32_t *index);
struct error *scene_push_texture(struct scene *scene, struct scene_texture texture, int32_t *index);
struct error *scene_push_light(struct scene *scene, struct scene_light light);

/* Adds a part of this name, of which it takes a copy; *part is its number. */
struct error *scene_push_part(struct scene *scene, enum scene_part_kind kind, const char *name,
                              uint32_t above, uint32_t *part);

/* Adds a copy of a mesh; *copy is its place. */
struct error *scene_copy_mesh(struct scene *scene, size_t number, size_t *copy);

/* Takes the triangles out of a mesh whose flag is set. Vertices stay. */
void scene_mesh_drop(struct scene_mesh *mesh, const bool *drop);

/* The part of scene_finish that is about geometry: what changes meshes later calls it again. */
struct error *scene_finish_geometry(struct scene *scene, struct warnings *warnings);

/* White, opaque (opacity 1, cutoff 0.5), black emission, no maps; name NULL, which push makes
 * "". */
struct scene_material scene_material_default(void);

/* A texture of a decoded picture, whose texels it takes over; repeated, interpolated. */
struct scene_texture scene_texture_of(const struct image *image);

/* A map of this texture that leaves (u, v) alone. */
struct scene_map scene_map_of(int32_t texture);

/* p -> p, for scene_push_instance. */
extern const double scene_identity[12];

#ifdef __cplusplus
}
#endif

#endif
