/* SPDX-License-Identifier: Apache-2.0 */
/* De-ringing: windows whose least r is known in closed form; what no window may do; the minimum
 * over the sphere against many samples. */
#include "light/dering.h"
#include "base/error.h"
#include "light/content.h"
#include "math/direction.h"
#include "stream/stream.h"
#include "support/sh_light.h"
#include "support/tap.h"

#include <string.h>

static void add_uniform(float *sh, double radiance)
{
    for (int k = 0; k < 3; k++)
        sh[k] += (float)(radiance * sqrt(4 * PI));
}

/* -- closed forms ----------------------------------------------------------------------------- */

/* A delta's minimum over directions, as a share of the mean, falls as r rises; r_at inverts it. The
 * window's r lies between those of the floor plus the tolerance and plus half of it. */
static void check_delta(enum dering_target target, int order, double floor,
                        double (*r_at)(double least), const char *form)
{
    const struct dering_settings settings = {.target = target, .floor = floor};
    bool right = true, convolved_right = true;
    double r = 0;
    for (int turn = 0; turn < 8; turn++) {
        double d[3];
        float sh[3 * SH_COUNT_MAX] = {0};
        draw_direction(d);
        /* one colour may be dark */
        add_delta(order, sh, d, (const double[3]){1e-3 + draw(), 1e3 * draw(), turn % 2 ? 0 : 1});
        r = dering_window(&settings, order, false, sh);
        right = right && r >= r_at(floor + DERING_TOLERANCE) - 1e-6 &&
                r <= r_at(floor + DERING_TOLERANCE / 2) + 1e-6;
        if (target == DERING_IRRADIANCE || order <= CONTENT_RADIANCE_ORDER_MAX) {
            content_convolve(order, sh, NULL, NULL);
            convolved_right = convolved_right &&
                              fabs(dering_window(&settings, order, true, sh) - r) < 1e-5;
        }
    }
    ok(right, "a delta at order %d, %s of at least %g: %s (r = %.5f, exact %.5f)", order,
       target == DERING_IRRADIANCE ? "irradiance" : "radiance", floor, form, r, r_at(floor));
    ok(convolved_right, "and the same where the coefficients are convolved");
}

/* 1 + 2 r x at x = -1 */
static double irradiance_2(double least)
{
    return (1 - least) / 2;
}
/* 1 + 3 r x at x = -1 */
static double radiance_2(double least)
{
    return (1 - least) / 3;
}
/* 1 + 2 r x + 5/8 r^2 (3 x^2 - 1) at x = -8 / (15 r): 7/15 - 5/8 r^2 */
static double irradiance_3(double least)
{
    return sqrt((7.0 / 15 - least) * 8 / 5);
}
/* the same at x = -1, where that is beyond it: 1 - 2 r + 5/4 r^2 */
static double irradiance_3_back(double least)
{
    return (2 - sqrt(4 - 5 * (1 - least))) / 2.5;
}
/* 1 + 3 r x + 5/2 r^2 (3 x^2 - 1) at x = -1 / (5 r): 7/10 - 5/2 r^2 */
static double radiance_3(double least)
{
    return sqrt((0.7 - least) / 2.5);
}

static void test_closed_forms(void)
{
    check_delta(DERING_IRRADIANCE, 2, 0, irradiance_2, "r = 1/2");
    check_delta(DERING_IRRADIANCE, 2, 0.3, irradiance_2, "r = 0.35");
    check_delta(DERING_RADIANCE, 2, 0, radiance_2, "r = 1/3");
    check_delta(DERING_IRRADIANCE, 3, 0, irradiance_3, "r^2 = 56/75");
    check_delta(DERING_IRRADIANCE, 3, 0.2, irradiance_3, "r^2 = 8/5 (7/15 - floor)");
    check_delta(DERING_IRRADIANCE, 3, 0.5, irradiance_3_back, "1 - 2 r + 5/4 r^2 = floor");
    check_delta(DERING_RADIANCE, 3, 0, radiance_3, "r^2 = 7/25");
}

/* A lamp's irradiance at order 3 under a window w, in the direction of cosine x, over its mean. */
static double lamp(const double w[3], double x)
{
    return 1 + 2 * w[1] * x + 5.0 / 8 * w[2] * (3 * x * x - 1);
}

enum window { ABEL_POISSON, GAUSS, BENDING, HANN, LANCZOS };

static void make_window(enum window window, double t, double w[3])
{
    w[0] = 1;
    for (int l = 1; l < 3; l++) {
        const double a = PI * l * t, k = l * (l + 1);
        w[l] = window == ABEL_POISSON ? pow(1 - t, l)
               : window == GAUSS      ? exp(-k * t)
               : window == BENDING    ? 1 / (1 + t * k * k)
               : l * t >= 1           ? 0
               : window == HANN       ? (1 + cos(a)) / 2
                                      : sin(a) / a;
    }
}

/* What the least window of a kind that leaves nothing below 0 takes of the lamp, in the RMS over
 * directions. */
static double taken(enum window window)
{
    double w[3] = {1, 1, 1};
    bool below = true;
    for (int i = 1; below && i < 2000; i++) {
        make_window(window, i * 5e-4, w);
        below = false;
        for (int k = 0; k <= 1000; k++)
            below = below || lamp(w, k * 2e-3 - 1) < 0;
    }
    const double energy[3] = {1, 4.0 / 3, 5.0 / 16}; /* (2l + 1) A_l^2 / A_0^2 */
    return sqrt((energy[1] * (1 - w[1]) * (1 - w[1]) + energy[2] * (1 - w[2]) * (1 - w[2])) /
                (1 + energy[1] + energy[2]));
}

static void test_windows(void)
{
    static const double stated[] = {
        [ABEL_POISSON] = 0.13, [GAUSS] = 0.19, [BENDING] = 0.42, [HANN] = 0.49, [LANCZOS] = 0.49};
    double worst = 0;
    for (enum window window = ABEL_POISSON; window <= LANCZOS; window++)
        worst = fmax(worst, fabs(taken(window) - stated[window]));
    ok(worst < 0.006,
       "windows that mend a lamp at order 3 take 13, 19, 42, 49 and 49 %% of it, as the manual "
       "says (to %.3f)",
       worst);
}

/* -- the minimum ------------------------------------------------------------------------------ */

enum { SAMPLES = 20000 };

/* The least of many samples: never below the minimum, and not far above it. */
static double sampled_minimum(int order, const double *f)
{
    double least = (double)INFINITY;
    for (int i = 0; i < SAMPLES; i++) {
        double d[3], y[SH_COUNT_MAX], sum = 0;
        vec3_store(d, direction_even(i, SAMPLES));
        sh_basis(order, d, y);
        for (int k = 0; k < order * order; k++)
            sum += y[k] * f[k];
        least = fmin(least, sum);
    }
    return least;
}

static void test_minimum(void)
{
    enum { TURNS = 60 };
    int false_claims = 0, missed = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        const int order = turn % 6 + 1;
        double f[SH_COUNT_MAX], y[SH_COUNT_MAX], d[3];
        draw_direction(d);
        sh_basis(order, d, y);
        for (int i = 0; i < order * order; i++) /* every second is zonal: a ring of minima */
            f[i] = turn / 6 % 2 ? draw() - 0.5 : y[i];
        const double least = sampled_minimum(order, f), span = 1e-3 * (1 + fabs(least));
        false_claims += dering_is_above(order, f, least + 1e-12, span);
        missed += !dering_is_above(order, f, least - 2 * span, span);
    }
    ok(!false_claims, "no level that a sample is below is claimed as a bound (%d of %d)",
       false_claims, TURNS);
    ok(!missed, "a bound is found where it holds with some slack (%d of %d missed)", missed, TURNS);
}

/* -- any probe -------------------------------------------------------------------------------- */

/* Light that is not negative: a sky and a few deltas of any colour. */
static void make_probe(int order, float *sh)
{
    memset(sh, 0, 3 * SH_COUNT_MAX * sizeof *sh);
    const double sky = draw() < 0.5 ? 0 : draw() / 4;
    if (sky > 0)
        add_uniform(sh, sky);
    for (int i = 0, lights = 1 + (int)(3 * draw()); i < lights; i++) {
        double d[3];
        draw_direction(d);
        add_delta(order, sh, d, (const double[3]){draw(), draw(), draw()});
    }
}

/* The least of what must stay above the floor, over its mean, over all colours; NaN-free as all
 * have light. */
static double least_of(enum dering_target target, int order, const float *sh)
{
    double least = (double)INFINITY;
    for (int k = 0; k < 3; k++) {
        double f[SH_COUNT_MAX];
        for (int l = 0, i = 0; l < order; l++)
            for (; i < (l + 1) * (l + 1); i++)
                f[i] = (target == DERING_IRRADIANCE ? sh_cosine(l) : 1) * (double)sh[3 * i + k];
        least = fmin(least, sampled_minimum(order, f) / (f[0] * SH_Y00));
    }
    return least;
}

static void test_properties(void)
{
    enum { TURNS = 48 };
    static const double floors[] = {0, 0.1, 0.4};
    int changed = 0, below = 0, not_least = 0, again = 0, rising = 0, blurred = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        const int order = turn % 6 + 1;
        const enum dering_target target = turn / 6 % 2 ? DERING_RADIANCE : DERING_IRRADIANCE;
        float sh[3 * SH_COUNT_MAX], windowed[3 * SH_COUNT_MAX], less[3 * SH_COUNT_MAX];
        double before = 1;
        make_probe(order, sh);
        const double least = least_of(target, order, sh);
        for (int i = 0; i < 3; i++) {
            const struct dering_settings settings = {.target = target, .floor = floors[i]};
            const double r = dering_window(&settings, order, false, sh);
            memcpy(windowed, sh, sizeof sh);
            dering_apply(order, r, windowed, NULL, NULL);
            changed += r < 1;
            below += least_of(target, order, windowed) < floors[i];
            again += dering_window(&settings, order, false, windowed) != 1;
            blurred += least > floors[i] + DERING_TOLERANCE && r < 1;
            rising += r > before;
            before = r;
            if (r < 0.99) {
                memcpy(less, sh, sizeof sh);
                dering_apply(order, r + 0.01, less, NULL, NULL);
                not_least += least_of(target, order, less) > floors[i] + DERING_TOLERANCE;
            }
        }
    }
    ok(changed > 60, "most of %d probes and floors ring (%d)", 3 * TURNS, changed);
    ok(!below, "none is below its floor afterwards, in any of %d directions (%d)", SAMPLES, below);
    ok(!not_least, "a window that is 0.01 wider does not keep it: the least is found (%d)",
       not_least);
    ok(!again, "a second pass changes nothing (%d)", again);
    ok(!blurred, "what is above the floor keeps its bits (%d)", blurred);
    ok(!rising, "a higher floor never takes less (%d)", rising);
}

static void test_untouched(void)
{
    const struct dering_settings settings = {.target = DERING_RADIANCE},
                                 high = {.target = DERING_RADIANCE, .floor = DERING_FLOOR_MOST};
    float sky[27] = {0}, dark[27] = {0}, negative[27] = {-1, 1, 1}, bare[27] = {[3] = 1};
    add_uniform(sky, 3);
    ok(dering_window(&settings, 3, false, sky) == 1 && dering_window(&high, 3, false, sky) == 1,
       "a uniform sky does not ring, for any floor");
    ok(dering_window(&settings, 3, false, dark) == 1, "nor does darkness");
    ok(dering_window(&settings, 3, false, negative) < 0 &&
           dering_window(&settings, 3, false, bare) < 0,
       "a mean below 0, or of 0 beside light: no window helps, and none is claimed to");
}

/* -- tables ----------------------------------------------------------------------------------- */

static void make_table(struct table *t)
{
    must(table_init(t, "probe"));
    must(table_add_column(t, "sh", COLUMN_F32, 27, NULL));
    must(table_add_column(t, "sh_error", COLUMN_F32, 27, NULL));
    must(table_add_column(t, "sh_gradient", COLUMN_F32, 81, NULL));
    must(table_resize(t, 4)); /* a delta, a sky, not captured, a mean below 0 */
    float *sh = column_f32(table_column(t, "sh")), *error = column_f32(table_column(t, "sh_error"));
    float *gradient = column_f32(table_column(t, "sh_gradient"));
    memset(sh, 0, 2 * 27 * sizeof *sh);
    memset(sh + 81, 0, 27 * sizeof *sh);
    add_delta(3, sh, (const double[3]){0.36, 0.48, 0.8}, (const double[3]){1, 2, 3});
    add_uniform(sh + 27, 1);
    add_uniform(sh + 81, -1);
    for (int i = 0; i < 4 * 27; i++)
        error[i] = i / 27 == 2 ? (float)NAN : 1;
    for (int i = 0; i < 4 * 81; i++)
        gradient[i] = i / 81 == 2 ? (float)NAN : -2;
}

static void test_table(void)
{
    const struct dering_settings settings = {.target = DERING_IRRADIANCE};
    struct dering_count count, counted = {.least = 1};
    struct table t = {0}, was = {0};
    make_table(&t);
    make_table(&was);
    must(dering_table(&t, &settings, false, 2, &count));
    const float *sh = column_f32(table_column(&t, "sh")),
                *error = column_f32(table_column(&t, "sh_error"));
    const float *gradient = column_f32(table_column(&t, "sh_gradient")),
                *window = column_f32(table_column(&t, "sh_window"));
    const float *sh_was = column_f32(table_column(&was, "sh"));
    const float r = window[0];
    ok(count.probes == 3 && count.changed == 1 && count.hopeless == 1 && count.least == (double)r &&
           r > 0.86f && r < 0.865f,
       "of four probes three have light, one rings, one is beyond help (r = %.4f)", (double)r);
    dering_count_add(&counted, &t);
    ok(counted.probes == 3 && counted.changed == 1 && counted.least == (double)r &&
           window[1] == 1 && isnan(window[2]) && window[3] == 1,
       "sh_window says so of each");
    const float square = (float)((double)r * (double)r);
    ok(sh[0] == sh_was[0] && sh[3] == (float)((double)r * (double)sh_was[3]) && error[3] == r &&
           fabsf(error[12] - square) < 1e-6f && gradient[0] == -2 && gradient[3] == -2 * r &&
           gradient[27 + 3] == -2 * r && gradient[54 + 3] == -2 * r,
       "error and gradient go along, band by band");
    ok(!memcmp(sh + 27, sh_was + 27, 27 * sizeof *sh) &&
           !memcmp(sh + 81, sh_was + 81, 27 * sizeof *sh),
       "the others keep every bit");
    must(dering_table(&t, &settings, false, 1, &count));
    ok(!count.changed && window[0] == r, "and so do all in a second pass");
    table_clear(&t);
    table_clear(&was);
}

static void test_header(void)
{
    struct stream_header header = {0};
    struct dering_settings back, some = {.target = DERING_RADIANCE, .floor = 0.125};
    must(dering_to_header(&some, &header));
    must(dering_from_header(&back, &header));
    ok(!strcmp(header_key(&header, "sh-dering"), "radiance 0.125") &&
           back.target == DERING_RADIANCE && back.floor == 0.125,
       "settings come back from the header");
    must(dering_to_header(&(struct dering_settings){0}, &header));
    must(dering_from_header(&back, &header));
    ok(!header_key(&header, "sh-dering") && back.target == DERING_NONE, "and none leaves none");
    static const char *const bad[] = {"irradiance",
                                      "irradiance 1",
                                      "irradiance -1",
                                      "none 0",
                                      "radiance 0.1x",
                                      "radiance nan",
                                      ""};
    int taken = 0;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        must(header_set_key(&header, "sh-dering", bad[i]));
        struct error *err = dering_from_header(&back, &header);
        taken += !err;
        error_destroy(err);
    }
    ok(!taken, "what is no setting is refused (%d)", taken);
    header_clear(&header);
}

int main(void)
{
    test_closed_forms();
    test_windows();
    test_minimum();
    test_properties();
    test_untouched();
    test_table();
    test_header();
    return tap_done();
}
