/* SPDX-License-Identifier: Apache-2.0 */
/* stand_in: who answers where no corner of a cell is seen. */
#ifndef STAND_IN_H
#define STAND_IN_H

#include <stdint.h>

struct error;
struct leak_mesh;
struct outside;
struct stars;
struct tracer;

/* Finds each cell's from its sight (leak/sight.h): looks from points of each cell that is walled,
 * where little is left of the corners' weight, for the nearest probes of the cells around, and
 * takes the one that most of them see; the nearest of several. Not all are asked from all points:
 * those that a few see most. -1: the corners that little is left of are seen as well from there.
 * stand_in: one a cell, the caller's. The result does not depend on the threads. */
struct error *stand_in_find(int32_t *stand_in, const float *sight, const struct tracer *tracer,
                            const struct leak_mesh *mesh, const struct stars *stars, int threads);

/* The same for points outside of the hull (outside.h), by the slopes of each cell's corners too (12
 * a cell). */
struct error *stand_in_find_outside(int32_t *stand_in, const float *sight, const float *slope,
                                    const struct tracer *tracer, const struct outside *outside,
                                    const struct stars *stars, int threads);

#endif
