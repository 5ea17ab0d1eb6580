/* SPDX-License-Identifier: Apache-2.0 */
#include "math/angle.h"

#include <math.h>
#include <stdbool.h>

/* pi/4 in three parts, the first two short enough that their products with small integers are
 * exact. */
static const double quarter[3] = {7.85398125648498535156e-1, 3.77489470793079817668e-8,
                                  2.69515142907905952645e-15};

static const double sine[6] = {1.58962301576546568060e-10, -2.50507477628578072866e-8,
                               2.75573136213857245213e-6,  -1.98412698295895385996e-4,
                               8.33333333332211858878e-3,  -1.66666666666666307295e-1};
static const double cosine[6] = {-1.13585365213876817300e-11, 2.08757008419747316778e-9,
                                 -2.75573141792967388112e-7,  2.48015872888517045348e-5,
                                 -1.38888888888730564116e-3,  4.16666666666665929218e-2};

/* Horner's rule: c[0] x^(n-1) + ... + c[n-1]. */
static double polynomial(const double *c, int n, double x)
{
    double y = c[0];
    for (int i = 1; i < n; i++)
        y = y * x + c[i];
    return y;
}

/* Splits x >= 0: x = octant pi/4 + z with octant even and z in [-pi/4, pi/4]. */
static int reduce(double x, double *z)
{
    if (x > 1e6) /* octants beyond are not exact */
        x = fmod(x, 2 * ANGLE_PI);
    double octant = floor(x / quarter[0]);
    octant += fmod(octant, 2);
    *z = ((x - octant * quarter[0]) - octant * quarter[1]) - octant * quarter[2];
    return (int)fmod(octant, 8);
}

static double kernel_sin(double z)
{
    const double zz = z * z;
    return z + z * (zz * polynomial(sine, 6, zz));
}

static double kernel_cos(double z)
{
    const double zz = z * z;
    return 1.0 - 0.5 * zz + zz * zz * polynomial(cosine, 6, zz);
}

double angle_sin(double x)
{
    double z;
    const int octant = reduce(fabs(x), &z);
    const double y = octant == 2 || octant == 6 ? kernel_cos(z) : kernel_sin(z);
    return (octant >= 4) != signbit(x) ? -y : y;
}

double angle_cos(double x)
{
    double z;
    const int octant = reduce(fabs(x), &z);
    const double y = octant == 2 || octant == 6 ? kernel_sin(z) : kernel_cos(z);
    return octant == 2 || octant == 4 ? -y : y;
}

/* Arc tangent of x >= 0. */
static double arc_tangent(double x)
{
    static const double p[5] = {-8.750608600031904122785e-1, -1.615753718733365076637e1,
                                -7.500855792314704667340e1, -1.228866684490136173410e2,
                                -6.485021904942025371773e1};
    static const double q[6] = {1,
                                2.485846490142306297962e1,
                                1.650270098316988542046e2,
                                4.328810604912902668951e2,
                                4.853903996359136964868e2,
                                1.945506571482613964425e2};
    static const double tangent_3_pi_8 = 2.41421356237309504880,
                        rest_of_half_pi = 6.123233995736765886130e-17;
    double start = 0, rest = 0;
    if (x > tangent_3_pi_8) {
        start = ANGLE_PI / 2;
        rest = rest_of_half_pi;
        x = -1 / x;
    } else if (x > 0.66) {
        start = ANGLE_PI / 4;
        rest = 0.5 * rest_of_half_pi;
        x = (x - 1) / (x + 1);
    }
    const double xx = x * x;
    return start + (x * (xx * polynomial(p, 5, xx) / polynomial(q, 6, xx)) + x + rest);
}

double angle_atan2(double y, double x)
{
    if (y == 0 && x == 0)
        return 0;
    const bool steep = fabs(y) > fabs(x);
    double a = arc_tangent(steep ? fabs(x / y) : fabs(y / x));
    if (steep)
        a = ANGLE_PI / 2 - a;
    if (x < 0)
        a = ANGLE_PI - a;
    return y < 0 ? -a : a;
}
