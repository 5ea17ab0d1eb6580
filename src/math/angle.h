/* SPDX-License-Identifier: Apache-2.0 */
/* angle: sine, cosine and arc tangent that come out the same on every machine.
 *
 * libm picks its instructions by the processor, so its last bit differs between machines; these use
 * + - * / alone. Based on: S. L. Moshier, Cephes Mathematical Library, sin.c and atan.c. Within
 * 5e-16 of the true value for |x| up to 1e4. Arguments must be finite.
 */
#ifndef ANGLE_H
#define ANGLE_H

#define ANGLE_PI 3.14159265358979323846

/* Radians. */
double angle_sin(double x);
double angle_cos(double x);

/* The angle of (x, y) from the x axis, in [-pi, pi]; 0 for (0, 0). */
double angle_atan2(double y, double x);

/* x and y, the cosine and sine of 2 pi `turn`, for turn in [0, 1], in single precision (within
 * 2e-7): for directions drawn at random. Inline, so that a loop over it is done by vector
 * instructions. */
static inline void angle_turn(float turn, float *x, float *y)
{
    const int quarters = (int)(4 * turn + 0.5f);
    const float z = (4 * turn - (float)quarters) * (float)(ANGLE_PI / 2), zz = z * z;
    /* Moshier's sinf.c and cosf.c, |z| <= pi/4 */
    const float s = z +
                    z * zz * ((-1.9515295891e-4f * zz + 8.3321608736e-3f) * zz - 1.6666654611e-1f);
    const float c =
        1 - 0.5f * zz +
        zz * zz *
            ((2.443315711809948e-5f * zz - 1.388731625493765e-3f) * zz + 4.166664568298827e-2f);
    const float along = quarters & 1 ? s : c, across = quarters & 1 ? c : s;
    *x = (quarters + 1) & 2 ? -along : along;
    *y = quarters & 2 ? -across : across;
}

#endif
