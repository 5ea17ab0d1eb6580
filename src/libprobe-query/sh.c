/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH
 * 2001. Sloan, "Efficient spherical harmonic evaluation", Journal of Computer Graphics Techniques
 * 2(2), 2013: the recurrences.
 */
#include "sh.h"

#include <math.h>

#define PI 3.14159265358979323846

/* Y_lm(x, y, z) = K_lm P_lm(z) {sqrt2 cos m phi, 1, sqrt2 sin |m| phi} as polynomials: with sin^m
 * theta taken into C_m + i S_m = (x + i y)^m, what is left is a polynomial in z. With its constant
 * K_lm sqrt2 taken in, it starts as first[m] and goes on as p_l = rise[m][l] z p_(l-1) - fall[m][l]
 * p_(l-2), where rise = sqrt((4 l^2 - 1) / (l^2 - m^2)) and fall = rise sqrt(((l - 1)^2
 * - m^2) / (4 (l - 1)^2 - 1)). */
static const double first[SH_ORDER_MAX] = {SH_Y00,
                                           0.48860251190292,
                                           0.5462742152960396,
                                           0.5900435899266436,
                                           0.6258357354491763,
                                           0.6563820568401701};
static const double rise[SH_ORDER_MAX][SH_ORDER_MAX] = {
    {0, 1.7320508075688772, 1.9364916731037085, 1.9720265943665387, 1.984313483298443,
     1.98997487421324},
    {0, 0, 2.23606797749979, 2.091650066335189, 2.04939015319192, 2.03100960115899},
    {0, 0, 0, 2.6457513110645907, 2.29128784747792, 2.1712405933672376},
    {0, 0, 0, 0, 3.0, 2.48746859276655},
    {0, 0, 0, 0, 0, 3.3166247903554}};
static const double fall[SH_ORDER_MAX][SH_ORDER_MAX] = {
    {0, 0, 1.118033988749895, 1.018350154434631, 1.0062305898749055, 1.002853072844814},
    {0, 0, 0, 0.9354143466934853, 0.9797958971132713, 0.991031208965115},
    {0, 0, 0, 0, 0.8660254037844386, 0.9476070829586856},
    {0, 0, 0, 0, 0, 0.82915619758885}};

void sh_basis(int order, const double d[3], double *y)
{
    double c = 1, s = 0; /* C_m, S_m */
    for (int m = 0; m < order; m++) {
        double before = 0, p = first[m]; /* of l - 1, of l */
        for (int l = m; l < order; l++) {
            if (l > m) {
                const double next = rise[m][l] * d[2] * p - fall[m][l] * before;
                before = p;
                p = next;
            }
            y[l * (l + 1) + m] = c * p;
            if (m)
                y[l * (l + 1) - m] = s * p;
        }
        const double c_next = d[0] * c - d[1] * s;
        s = d[0] * s + d[1] * c;
        c = c_next;
    }
}

/* The same with the innermost loop over directions, so that several are done by each
 * instruction. */
void sh_basis_wave(int order, const float (*direction)[3], double (*y)[SH_WAVE])
{
    double dx[SH_WAVE], dy[SH_WAVE], dz[SH_WAVE], c[SH_WAVE], s[SH_WAVE];
    for (int k = 0; k < SH_WAVE; k++) {
        dx[k] = (double)direction[k][0], dy[k] = (double)direction[k][1];
        dz[k] = (double)direction[k][2];
        c[k] = 1, s[k] = 0;
    }
    for (int m = 0; m < order; m++) {
        double before[SH_WAVE], p[SH_WAVE]; /* of l - 1, of l */
        for (int k = 0; k < SH_WAVE; k++)
            before[k] = 0, p[k] = first[m];
        for (int l = m; l < order; l++) {
            for (int k = 0; k < SH_WAVE && l > m; k++) {
                const double next = rise[m][l] * dz[k] * p[k] - fall[m][l] * before[k];
                before[k] = p[k];
                p[k] = next;
            }
            double *plus = y[l * (l + 1) + m], *minus = y[l * (l + 1) - m];
            for (int k = 0; k < SH_WAVE; k++) {
                minus[k] = s[k] * p[k];
                plus[k] = c[k] * p[k]; /* after the other: m may be 0 */
            }
        }
        for (int k = 0; k < SH_WAVE; k++) {
            const double c_next = dx[k] * c[k] - dy[k] * s[k];
            s[k] = dx[k] * s[k] + dy[k] * c[k];
            c[k] = c_next;
        }
    }
}

double sh_cosine(int l)
{
    static const double a[SH_ORDER_MAX] = {PI, 2 * PI / 3, PI / 4, 0, -PI / 24, 0};
    return a[l];
}

void sh_project(int order, const double *y, const double rgb[3], double weight, double *c)
{
    for (int i = 0; i < order * order; i++)
        for (int k = 0; k < 3; k++)
            c[3 * i + k] += weight * rgb[k] * y[i];
}

/* Sum of c_lm y_lm, times A_l where cosine is set. */
static void evaluate(int order, const float *c, const double *y, int cosine, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int l = 0, i = 0; l < order; l++) {
        const double factor = cosine ? sh_cosine(l) : 1;
        for (; i < (l + 1) * (l + 1); i++)
            for (int k = 0; k < 3; k++)
                rgb[k] += factor * y[i] * (double)c[3 * i + k];
    }
}

void sh_radiance(int order, const float *c, const double d[3], double rgb[3])
{
    double y[SH_COUNT_MAX];
    sh_basis(order, d, y);
    evaluate(order, c, y, 0, rgb);
}

void sh_irradiance(int order, const float *c, int convolved, const double n[3], double rgb[3])
{
    double y[SH_COUNT_MAX];
    sh_basis(order, n, y);
    evaluate(order, c, y, !convolved, rgb);
}

void sh_scale_bands(int order, const double *factor, float *c)
{
    for (int l = 0, i = 0; l < order; l++)
        for (; i < 3 * (l + 1) * (l + 1); i++)
            c[i] = (float)(factor[l] * (double)c[i]);
}

void sh_dominant(int order, const float *c, double direction[3])
{
    static const int index[3] = {3, 1, 2}; /* x, y, z of band 1 */
    for (int k = 0; k < 3; k++) {
        const float *rgb = c + 3 * index[k];
        direction[k] = order < 2 ? 0
                                 : 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] +
                                       0.0722 * (double)rgb[2];
    }
}

int sh_order_of(unsigned long width)
{
    for (int n = 1; n <= SH_ORDER_MAX; n++)
        if (width == (unsigned long)(3 * n * n))
            return n;
    return 0;
}
