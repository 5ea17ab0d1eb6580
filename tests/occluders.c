/* SPDX-License-Identifier: Apache-2.0 */
/* The light that moving spheres leave: closed forms, and what the sum of logarithms that Ren et al.
 * ("Real-time soft shadows in dynamic scenes using spherical harmonic exponentiation", SIGGRAPH
 * 2006) take for a product is off by. */
#include "base/error.h"
#include "interpolate/occluders.h"
#include "libprobe-query/probe-query.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "math/direction.h"
#include "math/random.h"
#include "support/tap.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI ANGLE_PI

enum { ORDER = 4, COUNT = ORDER * ORDER, FINE = 20000, SETS = 40 };

static const char *const file = "occluders.txt";

static struct occluders *make(const double *sphere, int count)
{
    struct occluders *o;
    FILE *f = fopen(file, "w");
    fputs("# moving\n\n", f);
    for (int i = 0; i < count; i++, sphere += 4)
        fprintf(f, "%.17g %.17g, %.17g %.17g # one\n", sphere[0], sphere[1], sphere[2], sphere[3]);
    fclose(f);
    must(occluders_read(&o, file));
    remove(file);
    return o;
}

static const double origin[3] = {0};

/* A sphere hides (1 - cos) / 2 of all directions, sin t = r / d; two apart both, one behind another
 * no more than that. */
static void test_share(void)
{
    double worst = 0;
    for (int i = 1; i < 10; i++) {
        const double s = i / 10.0, sphere[4] = {2, -1, 0.5, s * sqrt(5.25)};
        struct occluders *o = make(sphere, 1);
        worst = fmax(worst, fabs(occluders_open(o, origin) - (1 + sqrt(1 - s * s)) / 2));
        occluders_destroy(o);
    }
    ok(worst < 2e-3, "one sphere leaves (1 + cos) / 2 open (off by %.1e)", worst);
    const double apart[8] = {2, 0, 0, 1, 0, 0, -2, 1}, behind[8] = {2, 0, 0, 1, 6, 0, 0, 2};
    struct occluders *two = make(apart, 2), *one = make(behind, 2);
    const double each = (1 - sqrt(0.75)) / 2;
    ok(fabs(occluders_open(two, origin) - (1 - 2 * each)) < 2e-3 &&
           fabs(occluders_open(one, origin) - (1 - each)) < 2e-3,
       "two apart hide the sum, one behind the other no more");
    float sh[3] = {1, 2, 3};
    occluders_shade(two, 1, (const double[3]){1.5, 0.1, 0}, sh);
    ok(sh[0] == 0 && sh[2] == 0 && occluders_open(two, (const double[3]){1.5, 0.1, 0}) == 0,
       "inside of a sphere no light is left");
    occluders_destroy(one);
    occluders_destroy(two);
}

/* Irradiance under a uniform sky with a sphere straight above: pi (1 - sin^2 t); SH of order 6 keep
 * it to a hundredth. */
static void test_irradiance(void)
{
    const double sphere[4] = {0, 2, 0, 1};
    struct occluders *o = make(sphere, 1);
    float sh[3 * SH_COUNT_MAX] = {0}, rgb[3];
    for (int k = 0; k < 3; k++)
        sh[k] = (float)sqrt(4 * PI);
    occluders_shade(o, SH_ORDER_MAX, origin, sh);
    probe_irradiance(SH_ORDER_MAX, sh, (const float[3]){0, 1, 0}, rgb);
    ok(fabs((double)rgb[1] / PI - 0.75) < 0.01,
       "a sphere above takes sin^2 of the irradiance (%.4f)", (double)rgb[1] / PI);
    float before[3 * SH_COUNT_MAX];
    memcpy(before, sh, sizeof sh);
    occluders_destroy(o);
    const double away[4] = {0, 2e9, 0, 1e-9};
    o = make(away, 1);
    occluders_shade(o, SH_ORDER_MAX, origin, sh);
    double worst = 0;
    for (int k = 0; k < 3 * SH_COUNT_MAX; k++)
        worst = fmax(worst, fabs((double)sh[k] - (double)before[k]));
    ok(worst < 1e-6, "one as small as nothing takes next to nothing (%.1e)", worst);
    occluders_destroy(o);
}

/* -- logarithms -------------------------------------------------------------------------------- */

/* Adds the SH of log V of a sphere: log(dark) within its cone. */
static void add_log(const double sphere[4], double dark, double *sum)
{
    const double d = sqrt(sphere[0] * sphere[0] + sphere[1] * sphere[1] + sphere[2] * sphere[2]),
                 c = sqrt(1 - sphere[3] * sphere[3] / d / d),
                 n[3] = {sphere[0] / d, sphere[1] / d, sphere[2] / d};
    /* integral of P_l over [c, 1] (Abramowitz and Stegun 8.14.1) */
    const double p[6] = {1,
                         c,
                         (3 * c * c - 1) / 2,
                         (5 * c * c * c - 3 * c) / 2,
                         (35 * c * c * c * c - 30 * c * c + 3) / 8,
                         0};
    double y[SH_COUNT_MAX];
    sh_basis(ORDER, n, y);
    for (int l = 0, i = 0; l < ORDER; l++)
        for (; i < (l + 1) * (l + 1); i++)
            sum[i] += 2 * PI * log(dark) * y[i] * (l ? (p[l - 1] - p[l + 1]) / (2 * l + 1) : 1 - c);
}

/* V as SH by exponentiating the sum of logarithms in 1024 directions. */
static void by_logarithms(const double *sphere, int count, double dark, double *v)
{
    double sum[COUNT] = {0};
    memset(v, 0, COUNT * sizeof *v);
    for (int s = 0; s < count; s++)
        add_log(sphere + 4 * s, dark, sum);
    for (int i = 0; i < OCCLUDER_DIRECTIONS; i++) {
        double d[3], y[SH_COUNT_MAX], log_v = 0;
        vec3_store(d, direction_even(i, OCCLUDER_DIRECTIONS));
        sh_basis(ORDER, d, y);
        for (int k = 0; k < COUNT; k++)
            log_v += sum[k] * y[k];
        for (int k = 0; k < COUNT; k++)
            v[k] += 4 * PI / OCCLUDER_DIRECTIONS * exp(log_v) * y[k];
    }
}

static void by_product(const double *sphere, int count, double *v)
{
    struct occluders *o = make(sphere, count);
    float sh[3 * COUNT] = {0};
    sh[0] = (float)sqrt(4 * PI);
    occluders_shade(o, ORDER, origin, sh);
    for (int k = 0; k < COUNT; k++)
        v[k] = (double)sh[3 * k];
    occluders_destroy(o);
}

static void truth_of(const double *sphere, int count, double *v)
{
    memset(v, 0, COUNT * sizeof *v);
    for (int i = 0; i < FINE; i++) {
        double d[3], y[SH_COUNT_MAX];
        const struct vec3 w = direction_even(i, FINE);
        bool open = true;
        for (int s = 0; s < count; s++) {
            const struct vec3 c = vec3_load(sphere + 4 * s);
            const double along = vec3_dot(w, c), r = sphere[4 * s + 3];
            open = open && !(along > 0 && vec3_dot(c, c) - along * along < r * r);
        }
        vec3_store(d, w);
        sh_basis(ORDER, d, y);
        for (int k = 0; k < COUNT && open; k++)
            v[k] += 4 * PI / FINE * y[k];
    }
}

/* Error of V over all directions, RMS, of sets of five spheres, which may overlap. */
static void test_logarithms(void)
{
    struct random r = random_start(5, 0, 0);
    static const double dark[5] = {0.01, 0.05, 0.1, 0.2, 0.4};
    double product = 0, logarithm[5] = {0}, least;
    for (int i = 0; i < SETS; i++) {
        double sphere[20], truth[COUNT], v[COUNT];
        for (int s = 0; s < 5; s++) {
            vec3_store(sphere + 4 * s,
                       vec3_scale(1 + 2 * random_double(&r),
                                  direction_even((int)(1000 * random_double(&r)), 1000)));
            sphere[4 * s + 3] = 0.2 + 0.7 * random_double(&r);
        }
        truth_of(sphere, 5, truth);
        by_product(sphere, 5, v);
        for (int k = 0; k < COUNT; k++)
            product += (v[k] - truth[k]) * (v[k] - truth[k]) / (4 * PI * SETS);
        for (int e = 0; e < 5; e++) {
            by_logarithms(sphere, 5, dark[e], v);
            for (int k = 0; k < COUNT; k++)
                logarithm[e] += (v[k] - truth[k]) * (v[k] - truth[k]) / (4 * PI * SETS);
        }
    }
    least = logarithm[0];
    for (int e = 0; e < 5; e++) {
        printf("# darkness %g: off by %.4f\n", dark[e], sqrt(logarithm[e]));
        least = fmin(least, logarithm[e]);
    }
    ok(sqrt(product) < 0.004 && product < least,
       "of five spheres, order %d, V is off by %.4f RMS as a product, by %.4f by logarithms at "
       "best",
       ORDER, sqrt(product), sqrt(least));
}

int main(void)
{
    test_share();
    test_irradiance();
    test_logarithms();
    return tap_done();
}
