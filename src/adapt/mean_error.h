/* SPDX-License-Identifier: Apache-2.0 */
/* mean_error: the mean of errors of which squares are known, with noise.
 *
 * A square from which its noise is taken off is right in the mean, but its root is not: the mean of
 * roots is less than the root of the mean, so noise makes errors look small (by a third, where it
 * is as large as they are). So points of about the same error are taken together. Those whose
 * squares are three times as large as their noise have roots of their own. Of the others the mean m
 * and variance say what their errors are in the mean: with V what is left of the variance without
 * the noise's,
 *
 *     m sqrt(m) / sqrt(m^2 + theta V),
 *
 * which is the mean root of gamma distributed squares within 2 % (G. N. Watson, "A note on gamma
 * functions", Proc. Edinburgh Math. Soc. 11, 1959: Gamma(k + 1) / Gamma(k + 1/2) = sqrt(k + theta),
 * 1/4 < theta < 1/pi), and so exact where all are equal. The noise's variance is that of the
 * product of the mean and the difference of two halves, which has the same and is 0 in the mean.
 * Where m is below 0 by more than chance, noise was chosen, and the interval is as much wider.
 */
#ifndef MEAN_ERROR_H
#define MEAN_ERROR_H

#include <stddef.h>
#include <stdint.h>

struct noisy_square {
    double about;    /* what the error may be, from elsewhere: tells who is taken together */
    uint32_t number; /* in which order those are that have the same */
    double square;   /* without its noise, in the mean */
    double noise;    /* as noisy as that, about 0 */
};

/* The mean error of `count` points, which are sorted, and its standard error. 0 points: 0. */
void mean_error(size_t count, struct noisy_square *point, double *mean, double *doubt);

#endif
