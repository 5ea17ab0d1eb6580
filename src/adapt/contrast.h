/* SPDX-License-Identifier: Apache-2.0 */
/* contrast: how different the light of two positions is (after P. Sukys, "Light probe cloud
 * generation for games", Chalmers University, 2014, sec. 3.1.3).
 *
 * E_a(n), E_b(n) are irradiance by two SH of one order, channel by channel.
 *
 *     six, twentysix  the largest |E_a - E_b| of R, G, B along 6 axes, or along these, the 12 unit
 *                     sums of two of them and the 8 of three;
 *     rms             its root mean square over all directions and colours, in closed form:
 *                     sqrt(mean over colours of sum A_l^2 |dL_lm|^2 / 4 pi) (Parseval);
 *     mse             mean over coefficients of (c_a - c_b)^2, of radiance: it has no bound.
 *
 * All but mse are shares: of a mean that is given, that of all light (absolute), or of E_a + E_b,
 * for rms the root mean squares of both (relative, then 1 at the most), of which a thousandth of
 * that mean is the least.
 */
#ifndef CONTRAST_H
#define CONTRAST_H

#include "libprobe-query/sh.h"

#include <stddef.h>

enum contrast_kind { CONTRAST_RMS, CONTRAST_SIX, CONTRAST_TWENTYSIX, CONTRAST_MSE };
enum contrast_form { CONTRAST_ABSOLUTE, CONTRAST_RELATIVE };
extern const char *const contrast_kind_names[]; /* NULL behind the last; and of the form: */
extern const char *const contrast_form_names[];

enum { CONTRAST_DIRECTIONS = 26 };

struct contrast {
    enum contrast_kind kind;
    enum contrast_form form;
    int order;
    double mean;                                     /* irradiance that shares are of */
    double basis[CONTRAST_DIRECTIONS][SH_COUNT_MAX]; /* A_l Y_lm along them, those of six first */
};

/* mean: usually contrast_mean of all light that there is. */
struct contrast contrast_make(enum contrast_kind kind, enum contrast_form form, int order,
                              double mean);

/* Mean irradiance over directions, colours and `count` SH (3 order^2 floats each); 0 of none. */
double contrast_mean(int order, size_t count, const float *sh);

/* Of two SH, 3 order^2 floats each; 0 where both are black. */
double contrast(const struct contrast *contrast, const float *a, const float *b);

/* The same; rms without what noise adds to it: the sum of the variances of both in irradiance, in
 * the mean over directions and colours (place_light_capture_noise). */
double contrast_clean(const struct contrast *contrast, const float *a, const float *b,
                      double noise);

#endif
