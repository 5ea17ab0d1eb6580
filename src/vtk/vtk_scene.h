/* SPDX-License-Identifier: Apache-2.0 */
/* vtk_scene: a scene's triangles as a mesh of named arrays, for looking at: instances placed,
 * fronts counter-clockwise.
 *
 * man/probe-vtk.1 lists the arrays. Textures are averaged over each triangle.
 */
#ifndef VTK_SCENE_H
#define VTK_SCENE_H

#include "vtk/vtk_fields.h"

struct error;
struct scene;

/* Borrows the materials' names from the scene. Starts as {0}. */
struct vtk_scene {
    struct vtk_mesh mesh;
    struct vtk_fields cells;
};

struct error *vtk_scene_init(struct vtk_scene *vtk, const struct scene *scene);
void vtk_scene_clear(struct vtk_scene *vtk);

#endif
