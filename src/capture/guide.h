/* SPDX-License-Identifier: Apache-2.0 */
/* guide: where a receiver's light comes from, so that more rays go there.
 *
 * Cells of the unit square of a receiver's directions, each with the light that points of surfaces
 * (lit.h) bring through it; rays are drawn by these. Cells stand along a Morton curve, so that
 * numbers which are near make directions that are. Rays of two kinds, some to all directions alike
 * and some by the guide, are divided by the density of both ways together (Veach, "Robust Monte
 * Carlo methods for light transport simulation", 1997, ch. 9, balance heuristic), which is
 * unbiased, whatever the guide says, as long as it does not depend on these rays. Based on: Jensen,
 * "Importance driven path tracing using the photon map", Eurographics rendering workshop, 1995.
 */
#ifndef GUIDE_H
#define GUIDE_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct path_receiver;
struct path_tracer;
struct vec3f;

struct guide {
    int bits;       /* 2^bits rows and twice as many columns */
    size_t cells;   /* 0: none */
    float *density; /* of the unit square, cell by cell along the curve; owned, and so is: */
    double *sum;    /* of densities until there, divided by the number of cells; the last is 1 */
};

/* Cells without light, at least `least`. */
struct error *guide_init(struct guide *guide, size_t least);
void guide_clear(struct guide *guide); /* one of zeros is legal */

/* Adds light at a point of the unit square. */
void guide_add(struct guide *guide, double x, double y, float light);

/* Makes densities of what was added. *gain: how many times as much a ray by the guide finds as one
 * to all directions alike, in the mean: 1 where all cells have as much; 0: no light. */
struct error *guide_make(struct guide *guide, double *gain);

/* Makes the guide of a receiver by `questions` questions, and half as many before, to the sunlit
 * points of the path tracer, numbered from `first` on; none where rays to all directions alike find
 * them as well, which a few questions tell in the open. Leaves receiver->lit false. Needs
 * path->lit. */
struct error *guide_look(struct guide *guide, const struct path_tracer *path,
                         struct path_receiver *receiver, uint64_t seed, uint64_t name,
                         uint32_t first, int questions);

/* The direction of a receiver that (x, y) of the unit square stands for: uniform over the sphere,
 * by equal steps of z (Archimedes); or by the cosine about the normal. */
struct vec3f guide_direction(const struct path_receiver *receiver, float x, double y);

/* A point of the unit square by t, uniform in [0, 1). */
void guide_draw(const struct guide *guide, double t, double *x, double *y);

/* Density of that at a point of the unit square. */
float guide_density(const struct guide *guide, double x, double y);

#endif
