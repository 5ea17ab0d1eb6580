/* SPDX-License-Identifier: Apache-2.0 */
/* ratio: a ratio of two means over space that is cut into strata, with its interval.
 *
 * Points are spread over each stratum, and each has a y and an x; the ratio is that of the means of
 * y and x over all space (Cochran, "Sampling techniques", 1977, sec. 6.11). Its interval is
 * Wilson's (1927) with that variance, and with as many points as weigh as much as those have where
 * surfaces are: where y is 0 at all of n points, the ratio may still be 3.84 / n; where there are
 * no surfaces, it is 0.
 */
#ifndef RATIO_H
#define RATIO_H

#include "measure/bootstrap.h"

#include <stdbool.h>
#include <stddef.h>

/* For the ratio of two means. */
struct ratio {
    double above, below; /* sums of y and x, by volume */
    double near;         /* of x, where surfaces are */
    double yy, xy, xx;   /* of the variances and covariance of the sums, by stratum */
    double square;       /* of x times its volume, where surfaces are */
};

/* A stratum's own sums, of its points' y and x. */
struct stratum {
    double y, x, yy, xy, xx;
};

void stratum_add(struct stratum *stratum, double y, double x);

/* Adds a stratum of `count` points, 2 or more. near: surfaces may be in it. */
void ratio_add(struct ratio *ratio, const struct stratum *stratum, size_t count, double volume,
               bool near);

/* Values of 0 to 1 where 0 <= y <= x. All 0 where there is no x. */
struct estimate ratio_estimate(const struct ratio *ratio);

#endif
