/* SPDX-License-Identifier: Apache-2.0 */
/* quick_square: what choice_error_of says of light at a candidate, squared, in 32 bits.
 *
 * Before a probe is chosen errors are estimated many hundred times for each that will come; what is
 * told of errors in the end is not of these. Four directions at a time, a tenth of the time.
 */
#ifndef QUICK_SQUARE_H
#define QUICK_SQUARE_H

#include "adapt/candidates.h"

/* Light along the directions, its halves one after the other. */
struct quick_light {
    float half[2][SPHERE_COUNT];
};

/* Blends what four probes give. from: of each the first number of a candidate_light's `probe`, or
 * of a quick_light's `half`. */
struct quick_light quick_blend(const float *const from[4], const float weight[4]);

/* The square of the ruler's error, with its sign and without noise in the mean. floor: of the
 * ruler, above 0. */
double quick_square(const struct candidate_light *at, const struct quick_light *light,
                    double floor);

#endif
