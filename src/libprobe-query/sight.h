/* SPDX-License-Identifier: Apache-2.0 */
/* sight: what is left of a corner's weight at a point that sees it or does not.
 *
 * At barycentric coordinates u, the depth of the point before what corner i sees is
 *
 *     d_i(u) = 1 - sum over j != i of sight_ij u_j,
 *
 * 1 at the corner and 0 on a plane that cuts the way to corner j at 1 / sight_ij of it: behind that
 * plane the corner is not seen. Numbers belong to pairs of probes, so on the face between two cells
 * both say the same, and what is blended goes on there without a jump. Outside of the hull, at
 * `off` from the place at u whose light it has, it is less by slope_i . off; slopes belong to
 * probes.
 */
#ifndef SIGHT_WEIGHTS_H
#define SIGHT_WEIGHTS_H

#include "half.h"

/* Where less than this is left of all weight, a cell's stand-in makes up for it. */
#define SIGHT_ENOUGH 0.01

/* Numbers of sight a cell: of each corner, in order, towards each other one. */
static inline int sight_width(int corners)
{
    return corners * (corners - 1);
}

/* A corner's weight falls from 1 to 0 over the last tenth of its depth. Behind, 2^-30 is left, and
 * less the farther it is: that counts only where no corner is seen, so that the sum is never 0. It
 * is called for less depth than SIGHT_FADE alone: else compilers reckon all of it for each. */
#define SIGHT_FADE 0.1
__attribute__((noinline, unused)) static double sight_left(double depth)
{
    const double least = 0x1p-30, far = 0.001;
    if (depth >= 0)
        return depth / SIGHT_FADE > least ? depth / SIGHT_FADE : least;
    const double behind = far / (far - depth);
    return least * (behind * behind) * (behind * behind);
}

typedef float sight_floats __attribute__((vector_size(16)));
typedef uint16_t sight_halves __attribute__((vector_size(8)));
typedef uint32_t sight_whole __attribute__((vector_size(16)));
typedef double sight_doubles __attribute__((vector_size(16)));

/* half_value of four. */
static inline sight_floats sight_values(const uint16_t half[4])
{
    sight_halves halves;
    memcpy(&halves, half, sizeof halves);
    const sight_whole h = __builtin_convertvector(halves, sight_whole), bits = (h & 0x7fff) << 13,
                      small = (sight_whole)(bits < 1u << 23),
                      moved = bits + (112u << 23) + (small & 1u << 23), least = small & 113u << 23,
                      sign = (h & 0x8000) << 16;
    return (sight_floats)((sight_whole)((sight_floats)moved - (sight_floats)least) | sign);
}

/* The same as sight_depths of a tetrahedron, in the same order, two corners at a time. */
static inline void sight_depths_four(const uint16_t *sight, const double u[4], double depth[4])
{
    const sight_floats a = sight_values(sight), b = sight_values(sight + 4),
                       c = sight_values(sight + 8);
    sight_doubles low = {1, 1}, high = {1, 1};
    low -= (sight_doubles){(double)a[0], (double)a[3]} * (sight_doubles){u[1], u[0]};
    high -= (sight_doubles){(double)b[2], (double)c[1]} * (sight_doubles){u[0], u[0]};
    low -= (sight_doubles){(double)a[1], (double)b[0]} * (sight_doubles){u[2], u[2]};
    high -= (sight_doubles){(double)b[3], (double)c[2]} * (sight_doubles){u[1], u[1]};
    low -= (sight_doubles){(double)a[2], (double)b[1]} * (sight_doubles){u[3], u[3]};
    high -= (sight_doubles){(double)c[0], (double)c[3]} * (sight_doubles){u[3], u[2]};
    memcpy(depth, &low, sizeof low);
    memcpy(depth + 2, &high, sizeof high);
}

/* Depths of a point before what a cell's corners see. sight: the cell's halves; u: barycentric. */
static inline void sight_depths(int corners, const uint16_t *sight, const double u[4],
                                double depth[4])
{
    if (corners == 4) { /* nearly always */
        sight_depths_four(sight, u, depth);
        return;
    }
    for (int i = 0; i < corners; i++) {
        depth[i] = 1;
        for (int j = 0; j < corners; j++)
            if (j != i)
                depth[i] -= (double)half_value(*sight++) * u[j];
    }
}

/* Weights from depths, in the place of these; returns their sum. */
static inline double sight_weigh(int corners, const double u[4], double weight[4])
{
    double sum = 0;
    for (int i = 0; i < corners; i++) {
        weight[i] = weight[i] >= SIGHT_FADE ? u[i] : u[i] * sight_left(weight[i]);
        sum += weight[i];
    }
    return sum;
}

/* Weights of a cell's corners, not yet divided by their sum, which it returns. */
static inline double sight_weights(int corners, const uint16_t *sight, const double u[4],
                                   double weight[4])
{
    sight_depths(corners, sight, u, weight);
    return sight_weigh(corners, u, weight);
}

/* The same of a point that is `off` away from the place at u, outside of the hull, where the depth
 * of each corner falls by three numbers of slope (leak/sight.h). */
static inline double sight_weights_outside(const uint16_t *sight, const float *slope,
                                           const double u[4], const double off[3], double weight[4])
{
    sight_depths(4, sight, u, weight);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            weight[i] -= (double)slope[3 * i + k] * off[k];
    return sight_weigh(4, u, weight);
}

#endif
