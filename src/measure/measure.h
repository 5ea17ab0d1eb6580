/* SPDX-License-Identifier: Apache-2.0 */
/* measure: how far the light of a baked stream is from the truth, and how it changes along the way.
 *
 * The error that a player sees is the ruler's (ruler.h), with white of the truth's points. Its
 * square is taken as (s - T1)(s - T2), T1 and T2 the truth's halves (truth.h): without noise.
 *
 * At each of the truth's points the error of irradiance is e(n) = E_stream(n) - E_truth(n),
 * luminance, in the 32 directions of sphere.h. With T1 and T2 the truth's halves, (s - T1)(s - T2)
 * has the expectation e^2 (truth.h): the root of its mean is the rms error, free of the truth's
 * noise. That noise leaves the rms uncertain by `rms_noise`, the standard error of the rms over
 * these very points: the mean square is sum of (x^2 - y^2), x = s - (T1 + T2) / 2, y = (T1 - T2) /
 * 2, whose noise is that of 2 e z + z^2 - y^2 with z distributed as y, so its variance is about sum
 * over points of (mean of 2 x y)^2 + 4/3 (mean of y^2)^2 (for Gaussian noise that is one in all
 * directions; less where it is not). The interval beside each figure is of another kind: what other
 * points might have given (bootstrap.h), noise and all.
 *
 * Of the rms error two parts have causes of their own: what the order of SH cuts off the truth, and
 * the noise of the capture, which its sh_error tells; squares add up, about, and the rest is
 * between the probes: interpolation, extrapolation, leaks.
 *
 * Mean, percentiles and shares are of |e| against the truth's mean, and still hold its noise.
 */
#ifndef MEASURE_H
#define MEASURE_H

#include "measure/report.h"

#include <stdint.h>

struct baked;
struct table;
struct tracer;
struct truth;

struct measure_settings {
    double tolerance; /* of the mean irradiance: what is off by more is too bright, or too dark */
    double dark;      /* share of the mean irradiance below which a point is dark */
    double bad;       /* an error above this is a bad point's */
    uint64_t seed;
    int threads;
};

/* Adds the figures of error, as it is and as it would be if each point took light from the probes
 * that it sees alone (seen.h), for all points and for their parts: inside and outside of the hull,
 * near and far from surfaces (quarters), lit and dark, and those that take light from unseen probes
 * or do not. map: NULL, or an empty table that gets a row for each point: position, error,
 * error_seen, rms (over the directions), bias, truth (mean irradiance), unseen, surface (missing:
 * none), outside. */
struct error *measure_error(struct report *report, const struct truth *truth,
                            const struct baked *baked, const struct tracer *tracer,
                            const struct measure_settings *settings, struct table *map);

/* Adds the figures of change along the truth's paths: over a step of length h, sqrt(mean over
 * directions of (E(p + h) - E(p))^2) / h, for the stream; for the truth the same with the product
 * of its halves' differences in place of the square. Of the stream besides the largest excess over
 * the truth's root mean square in the 8 steps before and behind: a jump that the truth has nearby
 * is none of the stream's making. */
struct error *measure_change(struct report *report, const struct truth *truth,
                             const struct baked *baked);

#endif
