/* Based on:
 * Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH 2001.
 * Sloan, "Efficient spherical harmonic evaluation", Journal of Computer Graphics Techniques 2(2), 2013: the recurrences.
 */
#include "sh.h"

#include <math.h>

#define PI 3.14159265358979323846

/* Y_lm(x, y, z) = K_lm P_lm(z) {sqrt2 cos m phi, 1, sqrt2 sin |m| phi} as polynomials: with sin^m theta taken into
 * C_m + i S_m = (x + i y)^m, what is left of P_lm is a polynomial in z with P_mm = (2m-1)!! and
 * (l-m) P_lm = (2l-1) z P_(l-1)m - (l+m-1) P_(l-2)m. */
void sh_basis(int order, const double d[3], double *y)
{
    double c = 1, s = 0, diagonal = 1; /* C_m, S_m, P_mm */
    double factorial_ratio = 1;        /* (2m)! */
    for (int m = 0; m < order; m++) {
        double before = 0, p = diagonal, ratio = factorial_ratio; /* P_(l-1)m, P_lm, (l+m)! / (l-m)! */
        for (int l = m; l < order; l++) {
            const double k = sqrt((2 * l + 1) / (4 * PI * ratio)) * p;
            const int at = l * (l + 1);
            if (m == 0) {
                y[at] = k;
            } else {
                y[at + m] = sqrt(2.0) * k * c;
                y[at - m] = sqrt(2.0) * k * s;
            }
            const double next = ((2 * l + 1) * d[2] * p - (l + m) * before) / (l + 1 - m);
            before = p;
            p = next;
            ratio *= (double)(l + 1 + m) / (l + 1 - m);
        }
        const double c_next = d[0] * c - d[1] * s;
        s = d[0] * s + d[1] * c;
        c = c_next;
        diagonal *= 2 * m + 1;
        factorial_ratio *= (2.0 * m + 1) * (2.0 * m + 2);
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

void sh_dominant(int order, const float *c, double direction[3])
{
    static const int index[3] = {3, 1, 2}; /* x, y, z of band 1 */
    for (int k = 0; k < 3; k++) {
        const float *rgb = c + 3 * index[k];
        direction[k] = order < 2 ? 0 : 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
    }
}

int sh_order_of(unsigned long width)
{
    for (int n = 1; n <= SH_ORDER_MAX; n++)
        if (width == (unsigned long)(3 * n * n))
            return n;
    return 0;
}
