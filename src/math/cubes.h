/* SPDX-License-Identifier: Apache-2.0 */
/* cubes: points by the cube that they are in, for finding those near a place.
 *
 * Space is cut into cubes, hashed into a table: what is within one cube's size of a place is in the
 * 27 cubes around it.
 */
#ifndef CUBES_H
#define CUBES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

struct cubes {
    double size;
    int32_t *head; /* by hash: the last point put there, or -1 */
    int32_t *next; /* by point */
    double *point; /* 3 * count */
    size_t count, mask;
};

/* Room for `room` points (fewer than 2^31), in cubes of this size. */
struct error *cubes_init(struct cubes *cubes, double size, size_t room);
void cubes_clear(struct cubes *cubes);

/* Adds a point: its index is the number of points before it. */
void cubes_add(struct cubes *cubes, const double p[3]);

/* Whether a point nearer to p than `reach` (at most the cubes' size) is accepted; *found is its
 * index, where wanted. */
bool cubes_find(const struct cubes *cubes, const double p[3], double reach,
                bool (*accepts)(void *context, const double *point), void *context, int32_t *found);

#endif
