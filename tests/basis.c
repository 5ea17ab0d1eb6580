/* SPDX-License-Identifier: Apache-2.0 */
/* Other bases: what their functions must be, and that fits are the best there are. */
#include "light/basis.h"
#include "base/error.h"
#include "light/content.h"
#include "math/direction.h"
#include "math/luminance.h"
#include "stream/stream.h"
#include "support/sh_light.h"
#include "support/tap.h"

#include <string.h>

/* A sky and three deltas. */
static void make_probe(int order, float *sh)
{
    memset(sh, 0, (size_t)(3 * order * order) * sizeof *sh);
    for (int k = 0; k < 3; k++)
        sh[k] = (float)(draw() * sqrt(4 * PI));
    for (int i = 0; i < 3; i++) {
        double d[3];
        draw_direction(d);
        add_delta(order, sh, d, (const double[3]){draw(), draw(), draw()});
    }
}

static void fit(enum basis basis, int order, const float *sh, float *c)
{
    struct basis_fit *f;
    must(basis_fit_create(&f, basis, order));
    basis_fit_probe(f, false, sh, c);
    basis_fit_destroy(f);
}

/* -- functions -------------------------------------------------------------------------------- */

static void test_functions(void)
{
    float ones[BASIS_WIDTH_MOST];
    for (int i = 0; i < BASIS_WIDTH_MOST; i++)
        ones[i] = 1;
    for (enum basis basis = BASIS_CUBE; basis <= BASIS_DICE; basis++) {
        double worst = 0;
        for (int i = 0; i < 1000; i++) {
            double n[3], rgb[3];
            draw_direction(n);
            basis_irradiance(basis, ones, n, rgb);
            worst = fmax(worst, fabs(rgb[i % 3] - 1));
        }
        ok(worst < 1e-14, "%s: the functions sum to 1 in every direction (%.1e)", basis_name(basis),
           worst);
    }
    /* McTaggart's by hand: (0.36, -0.48, 0.8) meets +X, -Y, +Z. */
    float cube[18];
    for (int i = 0; i < 18; i++)
        cube[i] = (float)(i + 1);
    double rgb[3];
    basis_irradiance(BASIS_CUBE, cube, (const double[3]){0.36, -0.48, 0.8}, rgb);
    ok(fabs(rgb[1] - (0.1296 * 2 + 0.2304 * 11 + 0.64 * 14)) < 1e-12,
       "cube: the three sides that a normal meets, by its squares");
    /* At a corner v: 0.35 + 0.25 of its own, and of its five neighbours, v . w = 1 / sqrt(5), 0.35
     * / 5 + 0.25 / 25. */
    float dice[36] = {0};
    /* 4 g + 2 a + b = 4 + 2 + 0 */
    const double corner[3] = {0, -0.8506508083520399, 0.5257311121191336};
    dice[3 * 6] = 1;
    basis_irradiance(BASIS_DICE, dice, corner, rgb);
    const double own = rgb[0];
    dice[3 * 6] = 0;
    int neighbours = 0;
    for (int i = 0; i < 12; i++) {
        dice[3 * i] = 1;
        basis_irradiance(BASIS_DICE, dice, corner, rgb);
        dice[3 * i] = 0;
        neighbours += fabs(rgb[0] - 0.08) < 1e-12;
    }
    ok(fabs(own - 0.6) < 1e-12 && neighbours == 5,
       "dice: corner 6 is where it is said to be, with five neighbours");
    float ahd[9] = {1, 2, 3, 4, 5, 6, 0, 0.6f, 0.8f};
    basis_irradiance(BASIS_AHD, ahd, (const double[3]){0, 0, 1}, rgb);
    double back[3];
    basis_irradiance(BASIS_AHD, ahd, (const double[3]){0, 0, -1}, back);
    ok(fabs(rgb[2] - (3 + 0.8 * 6)) < 1e-6 && back[2] == 3,
       "ahd: ambient, and highlight by the cosine");
}

/* The derivative along a unit tangent t at n, by differences on the sphere's great circle. */
static double slope(const float *c, const double n[3], const double t[3], double step)
{
    double side[2][3], rgb[3], value[2];
    for (int i = 0; i < 2; i++) {
        const double angle = i ? step : 0;
        for (int k = 0; k < 3; k++)
            side[i][k] = cos(angle) * n[k] + sin(angle) * t[k];
        basis_irradiance(BASIS_DICE_CUBIC, c, side[i], rgb);
        value[i] = rgb[0];
    }
    return (value[1] - value[0]) / step;
}

static void test_cubic(void)
{
    static const double a = 0.8506508083520399, b = 0.5257311121191336;
    float c[108];
    for (int i = 0; i < 108; i++)
        c[i] = (float)(draw() - 0.5);
    double value = 0, derivative = 0;
    for (int i = 0; i < 12; i++) {
        double n[3] = {0}, u[3] = {0}, v[3], rgb[3];
        n[i / 4] = i & 2 ? -a : a;
        n[(i / 4 + 1) % 3] = i & 1 ? -b : b;
        u[(i / 4 + 2) % 3] = 1;
        for (int k = 0; k < 3; k++)
            v[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
        basis_irradiance(BASIS_DICE_CUBIC, c, n, rgb);
        value = fmax(value, fabs(rgb[0] - (double)c[9 * i]));
        derivative = fmax(derivative, fabs(slope(c, n, u, 1e-6) - (double)c[9 * i + 3]));
        derivative = fmax(derivative, fabs(slope(c, n, v, 1e-6) - (double)c[9 * i + 6]));
    }
    ok(value < 1e-12 && derivative < 1e-4,
       "dice-cubic: the corners' values and derivatives are kept (%.1e, %.1e)", value, derivative);

    /* Along circles: no jump of value or slope, over all edges. */
    double jump = 0, kink = 0;
    for (int turn = 0; turn < 20; turn++) {
        double p[3], q[3], before = 0, value_before = 0;
        draw_direction(p);
        draw_direction(q);
        const double dot = p[0] * q[0] + p[1] * q[1] + p[2] * q[2], length = sqrt(1 - dot * dot);
        for (int k = 0; k < 3; k++)
            q[k] = (q[k] - dot * p[k]) / length;
        enum { STEPS = 20000 };
        for (int i = 0; i < STEPS; i++) {
            const double angle = 2 * PI * i / STEPS;
            double n[3], t[3], rgb[3];
            for (int k = 0; k < 3; k++) {
                n[k] = cos(angle) * p[k] + sin(angle) * q[k];
                t[k] = cos(angle) * q[k] - sin(angle) * p[k];
            }
            basis_irradiance(BASIS_DICE_CUBIC, c, n, rgb);
            const double s = slope(c, n, t, 1e-7);
            jump = fmax(jump, i ? fabs(rgb[0] - value_before) : 0);
            kink = fmax(kink, i ? fabs(s - before) : 0);
            value_before = rgb[0];
            before = s;
        }
    }
    ok(jump < 2e-3 && kink < 2e-2,
       "dice-cubic: smooth across edges: steps of 3e-4 change value by %.1e, slope by %.1e", jump,
       kink);

    float sh[12] = {0}, linear[BASIS_WIDTH_MOST]; /* E = A_1 L_1m Y_1m alone */
    sh[3] = 1, sh[6] = -2, sh[9] = 0.5f;
    fit(BASIS_DICE_CUBIC, 2, sh, linear);
    double worst = 0;
    for (int i = 0; i < 200; i++) {
        double n[3], is[3], was[3];
        draw_direction(n);
        basis_irradiance(BASIS_DICE_CUBIC, linear, n, is);
        sh_irradiance(2, sh, 0, n, was);
        worst = fmax(worst, fabs(is[0] - was[0]));
    }
    ok(worst < 1e-6, "dice-cubic: holds linear light exactly (%.1e)", worst);
}

/* -- fits ------------------------------------------------------------------------------------- */

enum { SAMPLES = 40000 };

/* Integral of the square of what a fit leaves out, colour k; and of what it leaves out times other
 * functions. */
static double left_out(enum basis basis, int order, const float *sh, const float *c,
                       const float *other, int k)
{
    double sum = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double n[3];
        vec3_store(n, direction_even(i, SAMPLES));
        double is[3], was[3], by[3];
        basis_irradiance(basis, c, n, is);
        sh_irradiance(order, sh, 0, n, was);
        if (other)
            basis_irradiance(basis, other, n, by);
        sum += (was[k] - is[k]) * (other ? by[k] : was[k] - is[k]);
    }
    return sum * 4 * PI / SAMPLES;
}

static void test_fits(void)
{
    for (enum basis basis = BASIS_CUBE; basis < BASIS_AHD; basis++) {
        double worst = 0;
        for (int order = 1; order <= SH_ORDER_MAX; order++) {
            float sh[3 * SH_COUNT_MAX], c[BASIS_WIDTH_MOST], other[BASIS_WIDTH_MOST];
            make_probe(order, sh);
            fit(basis, order, sh, c);
            for (size_t i = 0; i < basis_width(basis); i++)
                other[i] = (float)(draw() - 0.5);
            worst = fmax(worst, fabs(left_out(basis, order, sh, c, other, order % 3)));
        }
        ok(worst < 3e-4,
           "%s: what is left out is orthogonal to whatever the basis can hold: least squares "
           "(%.1e)",
           basis_name(basis), worst);
    }
    /* Y20 and Y22 are combinations of squares, which the cube holds. */
    float even[27] = {[0] = 2, [18] = 0.3f, [24] = -0.2f}, cube[18];
    fit(BASIS_CUBE, 3, even, cube);
    ok(left_out(BASIS_CUBE, 3, even, cube, NULL, 0) < 1e-11,
       "cube: holds squares of the axes exactly");
    /* x alone: 1.25 x |x| is the best. */
    float x[12] = {[9] = (float)(1 / (2 * PI / 3 * 0.48860251190292))};
    fit(BASIS_CUBE, 2, x, cube);
    ok(fabsf(cube[0] - 1.25f) < 1e-5f && fabsf(cube[3] + 1.25f) < 1e-5f && fabsf(cube[6]) < 1e-5f,
       "cube: E = x becomes 5/4 x |x|");
    for (enum basis basis = BASIS_CUBE; basis < BASIS_COUNT; basis++) {
        float sky[3 * SH_COUNT_MAX] = {0}, c[BASIS_WIDTH_MOST];
        double worst = 0;
        for (int k = 0; k < 3; k++)
            sky[k] = (float)((k + 1) * sqrt(4 * PI));
        fit(basis, 4, sky, c);
        for (int i = 0; i < 2000; i++) {
            double n[3], rgb[3];
            draw_direction(n);
            basis_irradiance(basis, c, n, rgb);
            for (int k = 0; k < 3; k++)
                worst = fmax(worst, fabs(rgb[k] / (PI * (k + 1)) - 1));
        }
        ok(worst < (basis == BASIS_DICE_CUBIC ? 0.042 : 1e-5), "%s: a uniform sky is pi L, to %.1e",
           basis_name(basis), worst);
    }
}

/* -- ahd -------------------------------------------------------------------------------------- */

/* A sky and one delta: the direction is the delta's, and the two colours follow from <E, c> = pi A
 * + H sum of A_l^2 (2l + 1) / 4 pi. */
static void test_highlight(void)
{
    double turned = 0, worst = 0;
    for (int turn = 0; turn < 10; turn++) {
        const int order = 2 + turn % 5;
        const double sky[3] = {0.1, 0.2, 0.3}, light[3] = {1 + draw(), 2 + draw(), 1.5 + draw()};
        float sh[3 * SH_COUNT_MAX] = {0}, c[9];
        double d[3], norm = 0;
        draw_direction(d);
        add_delta(order, sh, d, light);
        for (int k = 0; k < 3; k++)
            sh[k] += (float)(sky[k] * sqrt(4 * PI));
        fit(BASIS_AHD, order, sh, c);
        for (int l = 0; l < order; l++)
            norm += sh_cosine(l) * sh_cosine(l) * (2 * l + 1) / (4 * PI);
        for (int k = 0; k < 3; k++) {
            const double whole = 4 * PI * PI * sky[k] + PI * light[k],
                         part = PI * PI * sky[k] + norm * light[k];
            const double h = (part - whole / 4) * 12 / (5 * PI), a = (whole - PI * h) / (4 * PI);
            worst = fmax(worst, fmax(fabs((double)c[3 + k] / h - 1), fabs((double)c[k] / a - 1)));
            turned = fmax(turned, fabs((double)c[6 + k] - d[k]));
        }
    }
    ok(turned < 1e-5 && worst < 1e-5,
       "ahd: a lamp and a sky are its closed form (direction off by %.1e, colours by %.1e)", turned,
       worst);

    int better = 0, negative = 0;
    /* no other direction, with colours of its own or changed ones, does better */
    for (int turn = 0; turn < 6; turn++) {
        float sh[3 * SH_COUNT_MAX], c[9], other[9];
        make_probe(3, sh);
        fit(BASIS_AHD, 3, sh, c);
        double best = 0;
        for (int k = 0; k < 3; k++) {
            best += left_out(BASIS_AHD, 3, sh, c, NULL, k);
            negative += c[k] < 0 || c[3 + k] < 0;
        }
        for (int change = 0; change < 8; change++) {
            double d[3], sum = 0;
            memcpy(other, c, sizeof c);
            draw_direction(d);
            for (int k = 0; k < 3 && change < 4; k++) /* nudged */
                d[k] = (double)c[6 + k] + 0.05 * d[k];
            const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (int k = 0; k < 3; k++) {
                other[6 + k] = (float)(d[k] / length);
                other[k] *= change % 2 ? (float)(0.9 + 0.2 * draw()) : 1;
                other[3 + k] *= change % 2 ? (float)(0.9 + 0.2 * draw()) : 1;
            }
            for (int k = 0; k < 3; k++)
                sum += left_out(BASIS_AHD, 3, sh, other, NULL, k);
            better += sum < best - 1e-6;
        }
    }
    ok(!better && !negative, "ahd: nothing near or far is closer, no colour below 0 (%d, %d)",
       better, negative);
    float dark[27] = {0}, c[9];
    fit(BASIS_AHD, 3, dark, c);
    ok(c[0] == 0 && c[3] == 0 && fabsf(c[6] * c[6] + c[7] * c[7] + c[8] * c[8] - 1) < 1e-6f,
       "ahd: darkness is dark, with a unit direction");
}

/* -- tables ----------------------------------------------------------------------------------- */

static void test_table(void)
{
    enum { ROWS = 5 };
    struct table t = {0};
    must(table_init(&t, "probe"));
    must(table_add_column(&t, "sh", COLUMN_F32, 27, NULL));
    must(table_resize(&t, ROWS)); /* the last stays uncaptured */
    for (int i = 0; i < ROWS - 1; i++)
        make_probe(3, column_f32(table_column(&t, "sh")) + 27 * i);
    for (enum basis basis = BASIS_CUBE; basis < BASIS_COUNT; basis++) {
        struct basis_error error, again;
        must(basis_convert(&t, basis, false, 2, &error));
        const size_t width = basis_width(basis);
        const float *sh = column_f32(table_column(&t, "sh")),
                    *c = column_f32(table_column(&t, basis_column(basis)));
        double square = 0, worst = 0;
        for (size_t i = 0; i < ROWS - 1; i++) {
            double mean = 0, one = 0;
            for (int s = 0; s < SAMPLES; s++) {
                double n[3], is[3], was[3];
                vec3_store(n, direction_even(s, SAMPLES));
                basis_irradiance(basis, c + i * width, n, is);
                sh_irradiance(3, sh + 27 * i, 0, n, was);
                const double off = luminance_f64(is) - luminance_f64(was);
                mean += luminance_f64(was) / SAMPLES;
                one += off * off / SAMPLES;
                worst = fmax(worst, fabs(off));
            }
            square += one / (mean * mean) / (ROWS - 1);
        }
        ok(error.probes == ROWS - 1 && fabs(error.rms / sqrt(square) - 1) < 0.02 &&
               isnan(c[(ROWS - 1) * width]) && error.worst >= error.rms,
           "%s: the stated error is that over 40000 directions (%.4f, %.4f); a probe without light "
           "has none",
           basis_name(basis), error.rms, sqrt(square));
        /* Convolved coefficients give the same, but for their rounding. */
        float sample[BASIS_WIDTH_MOST];
        memcpy(sample, c, width * sizeof *sample);
        must(content_convert(&t, false, true));
        must(basis_convert(&t, basis, true, 1, &again));
        c = column_f32(table_column(&t, basis_column(basis)));
        double off = 0;
        for (size_t k = 0; k < width; k++)
            off = fmax(off, fabs((double)c[k] - (double)sample[k]));
        ok(off < 1e-4 && fabs(again.rms - error.rms) < 1e-5,
           "%s: and the same of irradiance (%.1e)", basis_name(basis), off);
        must(content_convert(&t, true, false));
    }
    basis_drop(&t);
    ok(t.column_count == 1, "all go together");
    table_clear(&t);
}

int main(void)
{
    test_functions();
    test_cubic();
    test_fits();
    test_highlight();
    test_table();
    return tap_done();
}
