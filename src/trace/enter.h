/* SPDX-License-Identifier: Apache-2.0 */
/* enter: which triangles of a scene come into a cell: a point, a segment, a triangle or a
 * tetrahedron.
 *
 * A cell is convex: what no triangle comes into hides no point of it from any other. That is
 * certain where rays are not, however thin a wall is and whichever way it stands. Embree's point
 * query gives the triangles near a cell, and separating axes tell which of them are not in it
 * (Gottschalk, Lin, Manocha, "OBBTree: a hierarchical structure for rapid interference detection",
 * SIGGRAPH 1996, of a triangle and a tetrahedron). What touches a cell comes into it, and so does
 * what is nearer to it than rays' floats can tell. What a surface lets through does not matter: a
 * hole of a cut-out is for rays to find.
 */
#ifndef ENTER_H
#define ENTER_H

#include "math/vec.h"

#include <stdbool.h>
#include <stdint.h>

struct tracer;

/* A triangle that comes into a cell, with its corners in scene units from the cell's first point,
 * as rays meet it. */
struct trace_entering {
    uint32_t instance, triangle; /* of the scene; triangle of that instance's mesh */
    struct vec3 corner[3];
};

/* false: the rest is not wanted. */
typedef bool trace_enter_visit(void *context, const struct trace_entering *entering);

/* Visits the triangles that come into the hull of 1 to 4 points (3 coordinates each, finite,
 * world), in no order. visit NULL: as if it said false. Returns whether there are any. */
bool trace_enter(const struct tracer *tracer, int count, const double *const point[],
                 trace_enter_visit *visit, void *context);

#endif
