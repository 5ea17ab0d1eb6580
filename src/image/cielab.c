/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: IEC 61966-2-1 (primaries and white of Rec. 709), as whole fractions; CIE 15:2004,
 * 8.2.1. */
#include "image/cielab.h"
#include "math/power.h"

/* Rows sum to 1: each is divided by its white. */
static const double to_xyz[3][3] = {
    {10135552.0 / 23359437, 8788810.0 / 23359437, 4435075.0 / 23359437},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 80288307, 8788810.0 / 80288307, 70074185.0 / 80288307}};

static double determinant(const double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

void cielab_xyz(const double rgb[3], double xyz[3])
{
    for (int i = 0; i < 3; i++)
        xyz[i] = to_xyz[i][0] * rgb[0] + to_xyz[i][1] * rgb[1] + to_xyz[i][2] * rgb[2];
}

/* By Cramer's rule. */
void cielab_rgb(const double xyz[3], double rgb[3])
{
    const double whole = determinant(to_xyz);
    for (int k = 0; k < 3; k++) {
        double m[3][3];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                m[i][j] = j == k ? xyz[i] : to_xyz[i][j];
        rgb[k] = determinant((const double(*)[3])m) / whole;
    }
}

/* delta = 6/29 */
static double forward(double t)
{
    return t > 216.0 / 24389 ? power_of(t, 1.0 / 3) : t * 841 / 108 + 4.0 / 29;
}

static double backward(double f)
{
    return f > 6.0 / 29 ? f * f * f : (f - 4.0 / 29) * 108 / 841;
}

void cielab_of(const double rgb[3], double lab[3])
{
    double xyz[3];
    cielab_xyz(rgb, xyz);
    const double x = forward(xyz[0]), y = forward(xyz[1]), z = forward(xyz[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 500 * (x - y);
    lab[2] = 200 * (y - z);
}

void cielab_to(const double lab[3], double rgb[3])
{
    const double y = (lab[0] + 16) / 116,
                 xyz[3] = {backward(y + lab[1] / 500), backward(y), backward(y - lab[2] / 200)};
    cielab_rgb(xyz, rgb);
}
