/* SPDX-License-Identifier: Apache-2.0 */
/* vertices: the points of a scene's surface at which faces meet, each with its normal.
 *
 * Corners of triangles that stand at one place are welded, across meshes and instances, as long as
 * their faces agree: two corners whose faces turn no more than the crease belong together, and so
 * does what is connected by such pairs. So each place has one vertex for each smooth group of faces
 * around it: one on a sphere, three at a cube's corner, two where a sheet is modelled on both
 * sides.
 *
 * The normal of a vertex is the mean of its faces' normals, weighted with the angle that each face
 * has there, so it depends on the surface and not on how that is cut into triangles. Based on:
 * Thuermer and Wuethrich, "Computing vertex normals from polygonal facets", Journal of Graphics
 * Tools 3(1), 1998.
 */
#ifndef VERTICES_H
#define VERTICES_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;

struct vertex {
    /* of the scene; normal: unit, outward where faces are counter-clockwise */
    double position[3], normal[3];
    /* the first of its corners, counted over instances, triangles and their corners */
    size_t corner;
};

struct vertices {
    struct vertex *list; /* owned; in the order of their first corners */
    size_t count, capacity;
    /* the vertex of each corner, counted as `corner` is; SIZE_MAX: of a triangle that has no area;
     * owned */
    size_t *of_corner;
    size_t corners;
};

/* Finds them; crease in degrees, 0 to 180. *vertices starts as {0}. */
struct error *vertices_find(const struct scene *scene, double crease, struct vertices *vertices);

void vertices_clear(struct vertices *vertices);

#endif
