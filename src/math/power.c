/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: J.-M. Muller, "Elementary Functions: Algorithms and Implementation", 3rd ed., 2016,
 * sec. 5.2 and 11.4: reduction of the argument by powers of two, then a power series. */
#include "math/power.h"

#include <math.h>

/* ln 2 as the sum of a number of few bits, whose products with an exponent are exact, and the
 * rest. */
static const double ln2_high = 0x1.62e42fefa38p-1, ln2_low = 0x1.ef35793c7673p-45;

double power_log(double x)
{
    int exponent;
    double m = frexp(x, &exponent); /* [0.5, 1) */
    if (m < 0.70710678118654752) {
        m *= 2;
        exponent--;
    }
    const double s = (m - 1) / (m + 1), z = s * s; /* ln m = 2 atanh s, |s| < 0.1716 */
    double sum = 0;
    for (int k = 21; k >= 3; k -= 2)
        sum = (sum + 1.0 / k) * z;
    return exponent * ln2_high + (2 * s + (2 * s * sum + exponent * ln2_low));
}

double power_exp(double x)
{
    const double n = floor(x / (ln2_high + ln2_low) + 0.5);
    const double r = (x - n * ln2_high) - n * ln2_low; /* |r| < 0.35 */
    double sum = 1;
    for (int k = 14; k >= 1; k--)
        sum = 1 + sum * r / k;
    return ldexp(sum, (int)n);
}

double power_of(double x, double y)
{
    return x > 0 ? power_exp(y * power_log(x)) : 0;
}
