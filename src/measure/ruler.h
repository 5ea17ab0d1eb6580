/* SPDX-License-Identifier: Apache-2.0 */
/* ruler: the error of light at a point that a player sees.
 *
 * It is relative, because eyes are, and no point counts more than 1: the root of the mean over
 * directions (sphere.h) of
 *
 *     min(((s - T) / max(T, floor))^2, 1),    s the irradiance that is shown, not below 0, T the
 *                                             truth
 *
 * with a floor of RULER_FLOOR times white, the light that the exposure of pictures (display.h)
 * shows as white where it is found from the mean irradiances of the scene's points. Both may be
 * noisy: the variance of s - T that is noise is taken off each square, down to -1, and a mean below
 * 0 has the root of its size with the sign -. Where the light is right that is as often above 0 as
 * below, and where it is far off the noise is small beside it, so that the mean over points holds
 * little of it. The floor was chosen so that bakes are ranked as by the lightness of a lit sphere
 * (scripts/ruler; man probe-trades).
 */
#ifndef RULER_H
#define RULER_H

#include <stddef.h>

struct error;

#define RULER_FLOOR 0.1 /* of white: light below counts as if it were this */

/* Of SPHERE_COUNT irradiances each, luminance; variance: of light - truth, by noise. floor: 0
 * where there is no light at all. */
double ruler_error(const double *light, const double *truth, const double *variance, double floor);

/* The light that the scene's exposure shows as white, by the mean irradiances of points: as
 * pictures are exposed. 0: there is no light. */
struct error *ruler_white(size_t count, const float *mean, double *white);

#endif
