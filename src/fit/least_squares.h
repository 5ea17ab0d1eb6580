/* SPDX-License-Identifier: Apache-2.0 */
/* least_squares: the unknowns x that make a sum of small quadratic forms least, within bounds.
 *
 *     minimise  sum over elements of  x_e' A_e x_e   -   2 b' x,    low <= x <= high
 *
 * An element couples up to four unknowns, as the corners of a face or of a tetrahedron: what
 * samples in it ask for, or a term that keeps x smooth. A sample with weights w, value f and
 * importance a adds a w w' to the A of its element and a f w to b, so that the minimum is the
 * normal equations'. No matrix is put together: it is applied element by element, in their order,
 * which makes the sums the same on any number of threads.
 *
 * Solved by conjugate gradients in unknowns that are scaled to a unit diagonal; at bounds by
 * Dostal and Schoeberl, "Minimizing quadratic functions subject to bound constraints with the rate
 * of convergence and finite termination", Computational Optimization and Applications 30, 2005
 * (MPRGP). With scaled elements of k unknowns the largest eigenvalue is at most k (Wathen,
 * "Realistic eigenvalue bounds for the Galerkin mass matrix", IMA Journal of Numerical Analysis 7,
 * 1987), which is what its fixed steps need. Each step makes the sum less: the result is never
 * worse than where it began, and what no element asks about stays what it was.
 */
#ifndef LEAST_SQUARES_H
#define LEAST_SQUARES_H

#include <stddef.h>
#include <stdint.h>

struct error;

enum { FIT_CORNERS = 4, FIT_FORM = FIT_CORNERS * (FIT_CORNERS + 1) / 2 };

struct fit_element {
    int32_t at[FIT_CORNERS]; /* unknowns; those of fewer: any, with nothing in `form` */
    double form[FIT_FORM];   /* the upper triangle of A_e, row by row */
};

/* Adds scale w w' to an element. */
void fit_element_add(struct fit_element *element, double scale, const double w[FIT_CORNERS]);

struct fit_system {
    const struct fit_element *element; /* borrowed */
    size_t elements, unknowns;
    /* 1 / sqrt(diagonal), and the inverse of that; 0 where there is none; owned, the first */
    double *scale, *inverse;
};

/* Takes the elements as they stand. Error: an unknown that is out of range, short memory. */
struct error *fit_system_init(struct fit_system *system, const struct fit_element *element,
                              size_t elements, size_t unknowns);
void fit_system_clear(struct fit_system *system);

/* What a solution took. */
struct fit_effort {
    int steps;
    double residual; /* of the scaled normal equations, less what bounds hold back: share of |b| */
};

/* Goes from x, within the bounds (-INFINITY, INFINITY: none), to the minimum. right: b. */
struct error *fit_solve(const struct fit_system *system, const double *right, double low,
                        double high, double *x, struct fit_effort *effort);

#endif
