/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/sphere.h"
#include "math/angle.h"
#include "math/luminance.h"

/* Corners of the icosahedron: (0, +-1, +-p) / sqrt(1 + p^2), p the golden ratio, and what turns
 * into them; of the dodecahedron: (+-1, +-1, +-1) / sqrt 3, (0, +-p, +-1/p) / sqrt 3. */
#define A 0.5257311121191336
#define B 0.85065080835204
#define C 0.5773502691896258
#define D 0.9341723589627157
#define E 0.35682208977308993

const double sphere_direction[SPHERE_COUNT][3] = {
    {0, A, B},   {0, A, -B},  {0, -A, B},  {0, -A, -B}, {B, 0, A},   {-B, 0, A},   {B, 0, -A},
    {-B, 0, -A}, {A, B, 0},   {A, -B, 0},  {-A, B, 0},  {-A, -B, 0}, {C, C, C},    {C, C, -C},
    {C, -C, C},  {C, -C, -C}, {-C, C, C},  {-C, C, -C}, {-C, -C, C}, {-C, -C, -C}, {0, D, E},
    {0, D, -E},  {0, -D, E},  {0, -D, -E}, {E, 0, D},   {-E, 0, D},  {E, 0, -D},   {-E, 0, -D},
    {D, E, 0},   {D, -E, 0},  {-D, E, 0},  {-D, -E, 0}};

#define I (25.0 / 840)
#define O (27.0 / 840)

const double sphere_weight[SPHERE_COUNT] = {I, I, I, I, I, I, I, I, I, I, I, I, O, O, O, O,
                                            O, O, O, O, O, O, O, O, O, O, O, O, O, O, O, O};

struct sphere_basis sphere_basis_make(int order, bool convolved)
{
    struct sphere_basis basis = {.order = order};
    for (int d = 0; d < SPHERE_COUNT; d++) {
        sh_basis(order, sphere_direction[d], basis.y[d]);
        for (int l = 0; l < order; l++)
            for (int i = l * l; i < (l + 1) * (l + 1); i++)
                basis.y[d][i] *= convolved ? 1 : sh_cosine(l);
    }
    return basis;
}

void sphere_irradiance(const struct sphere_basis *basis, const double *c, int channels, double *e)
{
    for (int d = 0; d < SPHERE_COUNT; d++) {
        for (int k = 0; k < channels; k++) {
            double sum = 0;
            for (int i = 0; i < basis->order * basis->order; i++)
                sum += basis->y[d][i] * c[channels * i + k];
            e[channels * d + k] = sum;
        }
    }
}

void sphere_cut_off(int order, double *value)
{
    double y[SPHERE_COUNT][SH_COUNT_MAX], c[SH_COUNT_MAX] = {0};
    for (int d = 0; d < SPHERE_COUNT; d++)
        sh_basis(order, sphere_direction[d], y[d]);
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1) && sh_cosine(l) != 0; i++)
            for (int d = 0; d < SPHERE_COUNT; d++)
                c[i] += 4 * ANGLE_PI * sphere_weight[d] * value[d] * y[d][i];
    for (int d = 0; d < SPHERE_COUNT; d++)
        for (int i = 0; i < order * order; i++)
            value[d] -= c[i] * y[d][i];
}

double sphere_mean(const double *value)
{
    double sum = 0;
    for (int d = 0; d < SPHERE_COUNT; d++)
        sum += sphere_weight[d] * value[d];
    return sum;
}

void sphere_luminance(const double *rgb, double *luminance)
{
    for (int d = 0; d < SPHERE_COUNT; d++)
        luminance[d] = luminance_f64(rgb + 3 * d);
}
