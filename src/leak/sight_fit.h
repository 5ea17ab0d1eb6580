/* SPDX-License-Identifier: Apache-2.0 */
/* sight_fit: the inverse depths of a probe's neighbours that say best what rays from it met.
 *
 * A ray through a cell leaves it through the facet opposite the probe, at barycentric coordinates
 * u; inverse depth there is sum of sight_j u_j (leak/sight.h). Where that is s, the ray counts as
 * seen as far as r = min(1, 1/s) of its way to the facet. A probe's barycentric weight is 1 - r at
 * r, and space about the ray grows as r^2, so that what is seen of the probe's weight is
 * F(r) = r^3 (4 - 3 r), of 1. The fit makes the sum over rays of |F(r) - F(true r)| small, weight
 * that leaks counted LEAK times: by least squares, each ray weighted anew in every step such that
 * its square is its loss (iteratively reweighted least squares; Holland and Welsch, "Robust
 * regression using iteratively reweighted least-squares", 1977). It begins with the plane, or what
 * is nearest to one, that all rays that met anything met, where that is better than where it was to
 * begin.
 */
#ifndef SIGHT_FIT_H
#define SIGHT_FIT_H

#include <stddef.h>

struct error;

enum { SIGHT_TERMS = 5 };

/* Terms: neighbours with their barycentric coordinates, of sum 1 at a facet; or, of a ray to a
 * point outside of the hull, at which inverse depth is linear too (leak/sight.h), any factors. */
struct sight_ray {
    int terms;
    int neighbour[SIGHT_TERMS]; /* corners of the facet: numbers of the probe's neighbours */
    double u[SIGHT_TERMS];      /* where the ray meets it */
    double base;                /* of inverse depth, whatever the neighbours have */
    double inverse; /* depth of what it meets, 1 at the facet; 0: it meets nothing before */
    double share;   /* of the space about the probe, any unit */
};

/* sight: one number a neighbour; in: where to begin. Never makes the loss larger. The same rays in
 * the same order give the same bytes. */
struct error *sight_fit(size_t count, const struct sight_ray *ray, size_t neighbours,
                        double *sight);

/* The loss of one choice. */
double sight_fit_loss(size_t count, const struct sight_ray *ray, const double *sight);

#endif
