/* SPDX-License-Identifier: Apache-2.0 */
/* fit_surface: what least squares ask of values at a surface's vertices (Kavan, Bargteil and
 * Sloan, "Least squares vertex baking", Computer Graphics Forum 30(4), 2011, EGSR).
 *
 *     1/A sum over samples  a_s (w_s . x - f_s)^2  +  smooth/A sum over edges  A_e (h_e J_e)^2
 *
 * A: the area of all samples, a_s that of one, w_s its weights of the corners of its face, f_s its
 * value. The second term is against bends, which the eye sees as Mach's bands: J_e is the jump of
 * the slope across an edge between two faces, unfolded into a plane, A_e a third of their areas,
 * and h_e the geometric mean of their heights over the edge, which makes `smooth` a number without
 * a unit that means the same for any size of faces. The paper asks that gradients of neighbours
 * agree; the scale by h_e is ours. Faces meet where they share two vertices, so no term goes over
 * a crease.
 */
#ifndef FIT_SURFACE_H
#define FIT_SURFACE_H

#include "fit/least_squares.h"

#include <stdbool.h>

struct faces;

/* Samples of faces, a row each; borrowed. */
struct fit_samples {
    const int32_t *face;
    const float *weight; /* 3 each */
    const float *area;
    const bool *used; /* those that are asked */
    size_t count;
};

struct fit_surface {
    struct fit_element *element; /* owned; NULL where there are none */
    size_t count;
    double area; /* of the samples */
};

/* The elements of both terms; smooth 0: of the first alone. Error: no sample has an area. */
struct error *fit_surface_make(struct fit_surface *surface, const struct faces *faces,
                               const struct fit_samples *samples, double smooth);
void fit_surface_clear(struct fit_surface *surface);

/* The right side: right[vertex] = (1/A) sum a_s w_s f_s, of value[stride * sample]. */
void fit_surface_right(const struct fit_surface *surface, const struct faces *faces,
                       const struct fit_samples *samples, const float *value, size_t stride,
                       double *right);

/* The mean square of w . x - f over the surface, and that of f. */
void fit_surface_error(const struct fit_surface *surface, const struct faces *faces,
                       const struct fit_samples *samples, const float *value, size_t stride,
                       const double *x, double *error, double *all);

#endif
