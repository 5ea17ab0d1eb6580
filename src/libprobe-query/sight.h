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
 * less the farther it is: that counts only where no corner is seen, so that the sum is never 0. */
static inline double sight_left(double depth)
{
    const double fade = 0.1, least = 0x1p-30, far = 0.001;
    if (depth >= fade)
        return 1;
    if (depth >= 0)
        return depth / fade > least ? depth / fade : least;
    const double behind = far / (far - depth);
    return least * (behind * behind) * (behind * behind);
}

/* Depths of a point before what a cell's corners see. sight: the cell's halves; u: barycentric. */
static inline void sight_depths(int corners, const uint16_t *sight, const double u[4],
                                double depth[4])
{
    float value[12];
    for (int i = 0; i < sight_width(corners); i++)
        value[i] = half_value(sight[i]);
    const float *next = value;
    for (int i = 0; i < corners; i++) {
        depth[i] = 1;
        for (int j = 0; j < corners; j++)
            if (j != i)
                depth[i] -= (double)*next++ * u[j];
    }
}

/* Weights of a cell's corners, not yet divided by their sum, which it returns. */
static inline double sight_weights(int corners, const uint16_t *sight, const double u[4],
                                   double weight[4])
{
    double sum = 0;
    sight_depths(corners, sight, u, weight);
    for (int i = 0; i < corners; i++) {
        weight[i] = u[i] * sight_left(weight[i]);
        sum += weight[i];
    }
    return sum;
}

/* The same of a point that is `off` away from the place at u, outside of the hull, where the depth
 * of each corner falls by three numbers of slope (leak/sight.h). */
static inline double sight_weights_outside(const uint16_t *sight, const float *slope,
                                           const double u[4], const double off[3], double weight[4])
{
    double sum = 0;
    sight_depths(4, sight, u, weight);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++)
            weight[i] -= (double)slope[3 * i + k] * off[k];
        weight[i] = u[i] * sight_left(weight[i]);
        sum += weight[i];
    }
    return sum;
}

#endif
