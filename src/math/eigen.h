/* SPDX-License-Identifier: Apache-2.0 */
/* eigen: the largest eigenvalues of a symmetric matrix and their vectors: the same bits on every
 * machine and for any number of threads.
 *
 * A block of vectors is multiplied by the matrix and made orthonormal again and again, and turned
 * by the eigenvectors of what the matrix does within the block, which Jacobi's rotations give
 * (Golub, Van Loan, "Matrix computations", 8.2.4 and 8.5).
 */
#ifndef EIGEN_H
#define EIGEN_H

#include <stddef.h>

struct error;

/* The sum of count products, in a fixed order. */
double eigen_dot(const double *a, const double *b, size_t count);

/* matrix: size * size numbers, symmetric, without negative eigenvalues. Fills value (count) with
 * the largest eigenvalues, largest first, and vector (count * size) with unit vectors one behind
 * the other, orthogonal to each other; count is at most size. */
struct error *eigen_leading(const double *matrix, size_t size, size_t count, double *value,
                            double *vector, int threads);

#endif
