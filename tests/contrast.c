/* SPDX-License-Identifier: Apache-2.0 */
/* Contrast of light: what each kind says of a difference in bands 0 and 1 is what its definition
 * gives by hand; rms is a sum over many directions; shares are of what they should be. */
#include "adapt/contrast.h"
#include "math/direction.h"
#include "math/random.h"
#include "math/vec.h"
#include "support/tap.h"

#include <math.h>
#include <string.h>

enum { ORDER = 3, WIDTH = 3 * ORDER * ORDER };

/* SH whose irradiance is `level` everywhere, and what looks along `slope` on top, in one colour. */
static void make(float *sh, double level, const double slope[3], int channel)
{
    memset(sh, 0, WIDTH * sizeof *sh);
    for (int k = 0; k < 3; k++)
        sh[k] = (float)(level / (sh_cosine(0) * SH_Y00));
    const int axis[3] = {3, 1, 2}; /* of x, y, z in band 1 */
    for (int k = 0; k < 3; k++)
        sh[3 * axis[k] + channel] = (float)(slope[k] / (sh_cosine(1) * 0.48860251190292));
}

static void test_by_hand(void)
{
    static const double none[3], along[3] = {0.3, 0, 0}, skew[3] = {0.3, 0.3, 0.3};
    float a[WIDTH], b[WIDTH], c[WIDTH], black[WIDTH] = {0};
    make(a, 1, none, 0);
    make(b, 1, along, 1);
    make(c, 1, skew, 2);
    struct contrast of = contrast_make(CONTRAST_SIX, CONTRAST_ABSOLUTE, ORDER, 2);
    ok(fabs(contrast(&of, a, b) - 0.15) < 1e-6 && fabs(contrast(&of, a, c) - 0.15) < 1e-6,
       "six: the largest difference along an axis, of the mean: %g, %g", contrast(&of, a, b),
       contrast(&of, a, c));
    of = contrast_make(CONTRAST_TWENTYSIX, CONTRAST_ABSOLUTE, ORDER, 2);
    ok(fabs(contrast(&of, a, c) - 0.15 * sqrt(3)) < 1e-6,
       "twentysix sees what is along a diagonal whole: %g", contrast(&of, a, c));
    of = contrast_make(CONTRAST_TWENTYSIX, CONTRAST_RELATIVE, ORDER, 2);
    ok(fabs(contrast(&of, a, b) - 0.3 / 1.7) < 1e-6, "relative: %g, of the sum on the dark side",
       contrast(&of, a, b));
    of = contrast_make(CONTRAST_RMS, CONTRAST_ABSOLUTE, ORDER, 2);
    ok(fabs(contrast(&of, a, b) - 0.15 / 3) < 1e-6, "rms: %g, over colours and directions",
       contrast(&of, a, b));
    for (int kind = CONTRAST_RMS; kind <= CONTRAST_TWENTYSIX; kind++) {
        of = contrast_make((enum contrast_kind)kind, CONTRAST_RELATIVE, ORDER, 2);
        ok(fabs(contrast(&of, a, black) - 1) < 1e-6 && contrast(&of, black, black) == 0,
           "%s: light against none is 1, none against none 0", contrast_kind_names[kind]);
        ok(contrast(&of, a, b) == contrast(&of, b, a), "%s: either way", contrast_kind_names[kind]);
    }
    of = contrast_make(CONTRAST_MSE, CONTRAST_ABSOLUTE, ORDER, 2);
    const double d = (double)b[10];
    ok(fabs(contrast(&of, a, b) - d * d / WIDTH) < 1e-7, "mse: of coefficients, %g",
       contrast(&of, a, b));
    float two[2 * WIDTH];
    memcpy(two, a, sizeof a);
    make(two + WIDTH, 3, along, 0);
    ok(fabs(contrast_mean(ORDER, 2, two) - 2) < 1e-6 && contrast_mean(ORDER, 0, NULL) == 0,
       "the mean of irradiance 1 and 3 is 2, of nothing 0");
}

/* rms of random SH against a sum over many directions. */
static void test_rms(void)
{
    enum { MANY = 20000 };
    struct random r = random_start(3, 0, 0);
    float a[WIDTH], b[WIDTH];
    double sum = 0;
    for (int i = 0; i < WIDTH; i++) {
        a[i] = random_float(&r);
        b[i] = random_float(&r);
    }
    for (int i = 0; i < MANY; i++) {
        double d[3], ea[3], eb[3];
        vec3_store(d, direction_even(i, MANY));
        sh_irradiance(ORDER, a, 0, d, ea);
        sh_irradiance(ORDER, b, 0, d, eb);
        for (int k = 0; k < 3; k++)
            sum += (ea[k] - eb[k]) * (ea[k] - eb[k]);
    }
    const struct contrast of = contrast_make(CONTRAST_RMS, CONTRAST_ABSOLUTE, ORDER, 1);
    const double many = sqrt(sum / (3 * MANY)), closed = contrast(&of, a, b);
    ok(fabs(closed - many) < 1e-3 * many, "rms is the root mean square over directions: %g, %g",
       closed, many);
}

int main(void)
{
    test_by_hand();
    test_rms();
    return tap_done();
}
