/* SPDX-License-Identifier: Apache-2.0 */
/* sphere: a fixed set of directions over which irradiance is compared.
 *
 * The 12 corners of an icosahedron and the 20 of its dual dodecahedron, nearly evenly spread (each
 * has its nearest 37.4 degrees away), with weights 25/840 and 27/840: the mean over the sphere of
 * any polynomial up to degree 9 is exactly its weighted sum (McLaren, "Optimal numerical
 * integration on a sphere", Mathematics of Computation 17, 1963; Stroud, "Approximate calculation
 * of multiple integrals", 1971, formula U3 9-1). Irradiance from SH of order 6 or less is a
 * polynomial of degree 4, its square one of degree 8: for those the weighted sum is no estimate but
 * the mean square.
 */
#ifndef SPHERE_H
#define SPHERE_H

#include "libprobe-query/sh.h"

#include <stdbool.h>

enum { SPHERE_COUNT = 32, SPHERE_ORDER = 4 };

extern const double sphere_direction[SPHERE_COUNT][3]; /* unit */
extern const double sphere_weight[SPHERE_COUNT];       /* sum to 1 */

/* What turns SH coefficients into irradiance along the set: A_l Y_lm, or Y_lm where they are
 * convolved already. */
struct sphere_basis {
    int order;
    double y[SPHERE_COUNT][SH_COUNT_MAX];
};

struct sphere_basis sphere_basis_make(int order, bool convolved);

/* Irradiance on surfaces with these normals: e[SPHERE_COUNT * channels] from c[order * order *
 * channels]. */
void sphere_irradiance(const struct sphere_basis *basis, const double *c, int channels, double *e);

/* Takes out of SPHERE_COUNT values what SH irradiance of this order can hold: its bands below the
 * order whose A_l is not 0. What is left is what the order cuts off, within a few percent in the
 * mean, for orders up to SPHERE_ORDER: of 16 even dimensions that the set has, bands 0, 2 and 4
 * together take 15. */
void sphere_cut_off(int order, double *value);

/* Weighted mean of SPHERE_COUNT values. */
double sphere_mean(const double *value);

/* Rec. 709 luminance of SPHERE_COUNT RGB values. */
void sphere_luminance(const double *rgb, double *luminance);

#endif
