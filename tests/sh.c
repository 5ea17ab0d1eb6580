/* SPDX-License-Identifier: Apache-2.0 */
/* Spherical harmonics: the functions are orthonormal and have the signs and constants that the
 * manual states; irradiance is the cosine convolution. */
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "support/tap.h"

#define PI ANGLE_PI

/* Integrates by Gauss-Legendre in z (exact for the polynomials here) and equal steps in phi. */
enum { NZ = 12, NPHI = 32 };
static const double node[NZ] = {-0.9815606342467192, -0.9041172563704749, -0.7699026741943047,
                                -0.5873179542866175, -0.3678314989981802, -0.1252334085114689,
                                0.1252334085114689,  0.3678314989981802,  0.5873179542866175,
                                0.7699026741943047,  0.9041172563704749,  0.9815606342467192};
static const double weight[NZ] = {0.0471753363865118, 0.1069393259953184, 0.1600783285433462,
                                  0.2031674267230659, 0.2334925365383548, 0.2491470458134028,
                                  0.2491470458134028, 0.2334925365383548, 0.2031674267230659,
                                  0.1600783285433462, 0.1069393259953184, 0.0471753363865118};

static double direction(int i, int j, double d[3])
{
    const double s = sqrt(1 - node[i] * node[i]), phi = 2 * PI * (j + 0.5) / NPHI;
    d[0] = s * cos(phi);
    d[1] = s * sin(phi);
    d[2] = node[i];
    return weight[i] * 2 * PI / NPHI;
}

static void test_basis(void)
{
    double gram[SH_COUNT_MAX][SH_COUNT_MAX] = {{0}};
    for (int i = 0; i < NZ; i++) {
        for (int j = 0; j < NPHI; j++) {
            double d[3], y[SH_COUNT_MAX];
            const double w = direction(i, j, d);
            sh_basis(SH_ORDER_MAX, d, y);
            for (int a = 0; a < SH_COUNT_MAX; a++)
                for (int b = 0; b < SH_COUNT_MAX; b++)
                    gram[a][b] += w * y[a] * y[b];
        }
    }
    double worst = 0;
    for (int a = 0; a < SH_COUNT_MAX; a++)
        for (int b = 0; b < SH_COUNT_MAX; b++)
            worst = fmax(worst, fabs(gram[a][b] - (a == b)));
    ok(worst < 1e-12, "the %d functions are orthonormal to %.1e", SH_COUNT_MAX, worst);

    const double x = 0.36, y = 0.48, z = 0.8, d[3] = {x, y, z};
    double got[SH_COUNT_MAX];
    sh_basis(6, d, got);
    const double expected[] = {0.282095,
                               0.488603 * y,
                               0.488603 * z,
                               0.488603 * x,
                               1.092548 * x * y,
                               1.092548 * y * z,
                               0.315392 * (3 * z * z - 1),
                               1.092548 * x * z,
                               0.546274 * (x * x - y * y),
                               0.590044 * y * (3 * x * x - y * y)};
    worst = 0;
    for (int i = 0; i < 10; i++)
        worst = fmax(worst, fabs(got[i] - expected[i]));
    ok(worst < 1e-6, "constants and signs are those of Ramamoorthi and Hanrahan: %.1e", worst);
    for (int order = 1; order < SH_ORDER_MAX; order++) {
        double few[SH_COUNT_MAX];
        sh_basis(order, d, few);
        bool same = true;
        for (int i = 0; i < order * order; i++)
            same = same && few[i] == got[i];
        ok(same, "order %d is the beginning of order %d", order, SH_ORDER_MAX);
    }
}

/* Radiance that is a polynomial of degree 5, so that order 6 holds it exactly. */
static double polynomial(const double d[3])
{
    return 2 + d[0] - 3 * d[1] * d[2] + d[2] * d[2] * d[2] * d[0] * d[1];
}

static void test_projection(void)
{
    double c[3 * SH_COUNT_MAX] = {0};
    float f[3 * SH_COUNT_MAX];
    for (int i = 0; i < NZ; i++) {
        for (int j = 0; j < NPHI; j++) {
            double d[3], y[SH_COUNT_MAX];
            const double w = direction(i, j, d), l = polynomial(d), rgb[3] = {l, 2 * l, -l};
            sh_basis(6, d, y);
            sh_project(6, y, rgb, w, c);
        }
    }
    for (int i = 0; i < 3 * SH_COUNT_MAX; i++)
        f[i] = (float)c[i];
    double worst = 0;
    for (int j = 0; j < NPHI; j++) {
        double d[3], rgb[3];
        direction(j % NZ, j, d);
        sh_radiance(6, f, d, rgb);
        const double l = polynomial(d);
        worst = fmax(worst, fmax(fabs(rgb[0] - l), fmax(fabs(rgb[1] - 2 * l), fabs(rgb[2] + l))));
    }
    ok(worst < 1e-5, "a polynomial comes back from its projection: %.1e", worst);

    /* Its irradiance, by cubature of max(0, cos) about an axis: a cap in coordinates of the
     * normal. */
    const double n[3] = {0.36, -0.48, 0.8}, t[3] = {0.8, 0.6, 0}, b[3] = {-0.48, 0.64, 0.6};
    double expected = 0;
    for (int i = 0; i < NZ; i++) {
        const double z = 0.5 * (node[i] + 1), s = sqrt(1 - z * z);
        for (int j = 0; j < NPHI; j++) {
            const double phi = 2 * PI * (j + 0.5) / NPHI;
            double d[3];
            for (int k = 0; k < 3; k++)
                d[k] = s * cos(phi) * t[k] + s * sin(phi) * b[k] + z * n[k];
            expected += 0.5 * weight[i] * 2 * PI / NPHI * z * polynomial(d);
        }
    }
    double rgb[3];
    sh_irradiance(6, f, 0, n, rgb);
    ok(fabs(rgb[0] - expected) < 1e-5,
       "irradiance is the cosine-weighted integral: %.6f, cubature %.6f", rgb[0], expected);
    for (int l = 0, i = 0; l < 6; l++)
        for (; i < (l + 1) * (l + 1); i++)
            for (int k = 0; k < 3; k++)
                f[3 * i + k] *= (float)sh_cosine(l);
    double convolved[3];
    sh_irradiance(6, f, 1, n, convolved);
    ok(fabs(convolved[0] - rgb[0]) < 1e-5, "convolved coefficients give it directly");
}

int main(void)
{
    test_basis();
    test_projection();
    const float c[12] = {9, 9, 9, 0, 1, 0, 0, 2, 0, 0, 3, 0};
    double d[3];
    sh_dominant(2, c, d);
    ok(fabs(d[0] - 3 * 0.7152) < 1e-12 && fabs(d[1] - 0.7152) < 1e-12 &&
           fabs(d[2] - 2 * 0.7152) < 1e-12,
       "the dominant direction is band 1 as (x, y, z)");
    ok(sh_order_of(27) == 3 && sh_order_of(108) == 6 && !sh_order_of(28) && !sh_order_of(0),
       "an order from a column's width");
    return tap_done();
}
