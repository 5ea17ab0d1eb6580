/* SPDX-License-Identifier: Apache-2.0 */
/* span: the plane or the line that sites lie near, and their places in it.
 *
 * Sites that stand a little off their plane or line are triangulated (strung) and looked up where
 * they fall in it. Both sides, whoever makes the cells and whoever looks places up, find the same
 * plane: its moments are sums of whole numbers, exact whatever the order.
 */
#ifndef SPAN_H
#define SPAN_H

#include <stddef.h>

struct span_frame {
    double middle[3];  /* whole numbers */
    double axis[3][3]; /* unit, right-handed: along which sites reach the farthest first */
    double off;        /* the largest distance of a site from the plane (line), steps */
};

/* Of the sites (3 * count, whole numbers up to 2^LATTICE_BITS) that are used (NULL: all).
 * corners: 3 a plane, 2 a line; says what `off` is from. */
void span_find(struct span_frame *frame, size_t count, const double *site,
               const unsigned char *used, int corners);

/* Where a place falls: its coordinates along the plane (line), in units of 4 steps, counted such
 * that those of sites are 0 .. 2^LATTICE_BITS, not rounded; the others are 0. */
void span_flatten(const struct span_frame *frame, int corners, const double p[3], double flat[3]);

/* The directions in which a symmetric matrix only stretches, by Jacobi's rotations; m becomes
 * diagonal. */
void span_axes(double m[3][3], double axis[3][3]);

#endif
