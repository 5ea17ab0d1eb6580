/* SPDX-License-Identifier: Apache-2.0 */
/* occluders: spheres that move, and the light that they leave of a point's.
 *
 * Each hides the directions of a cone, of half angle asin(radius / distance); what several leave
 * open is the product of what each does. The light that is hidden is taken away in a fixed set of
 * directions, so where nothing is hidden, nothing changes. Spheres are black: they scatter no
 * light.
 *
 * Beside: Ren et al., "Real-time soft shadows in dynamic scenes using spherical harmonic
 * exponentiation", SIGGRAPH 2006, whose product is a sum of logarithms as SH; where there is no
 * frame to keep, the product itself is as simple and has no error of its own (man probe-query).
 */
#ifndef OCCLUDERS_H
#define OCCLUDERS_H

#include <stddef.h>

struct error;
struct occluders;

enum { OCCLUDER_DIRECTIONS = 1024 };

/* Reads spheres: lines of X Y Z RADIUS (world, radius above 0), comments behind a #. Errors name
 * the line; a file without any is one. */
struct error *occluders_read(struct occluders **occluders, const char *path);
void occluders_destroy(struct occluders *occluders);

/* Takes the light that they hide at a point away from its radiance, as SH of that order, RGB
 * interleaved. Inside of a sphere nothing is left. Any thread. */
void occluders_shade(const struct occluders *occluders, int order, const double point[3],
                     float *sh);

/* The share of directions that they leave open there. */
double occluders_open(const struct occluders *occluders, const double point[3]);

#endif
