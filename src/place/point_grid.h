/* SPDX-License-Identifier: Apache-2.0 */
/* point_grid: points on surfaces that come one by one, and which of them are near.
 *
 * Each point is an oriented disc: a position, the unit normal of the side that it is on, a radius.
 * It stands in one cell of a grid of cubes, which are at least twice as wide as its radius: there
 * is a grid for each power of two. Cells that have points are found by a hash, and what cells
 * fall together is told apart by the distance, which is asked anyway.
 *
 * Points are added by one thread, and asked for by any number in between.
 */
#ifndef POINT_GRID_H
#define POINT_GRID_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

struct grid_point {
    struct vec3 position;
    struct vec3f normal;
    float radius;
    int32_t next; /* of its cell; -1: it is the last */
};

struct point_grid {
    struct grid_point *point; /* owned, and so is: */
    int32_t *first;           /* by hash, of 2^bits */
    size_t count, capacity;
    int bits, levels;
    double cell; /* of the finest grid; the next is twice as wide */
};

/* Of points whose radii are least to most (above 0). */
struct error *point_grid_init(struct point_grid *grid, double least, double most);
void point_grid_clear(struct point_grid *grid);

/* Adds a point, whose radius may become smaller afterwards. Error: memory. */
struct error *point_grid_add(struct point_grid *grid, struct vec3 position, struct vec3f normal,
                             float radius);

/* Calls visit(context, i) for all points whose squared distance from p is below *square, which the
 * visitor may lower, and for some others, the near ones first, more or less; some come more than
 * once. by_reach: those whose radius is less than half of their distance need not be among them,
 * which makes this cheaper. */
void point_grid_near(const struct point_grid *grid, struct vec3 p, const double *square,
                     bool by_reach, void (*visit)(void *context, size_t i), void *context);

#endif
