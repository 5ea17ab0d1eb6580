/* SPDX-License-Identifier: Apache-2.0 */
/* sight: what is left of a corner's weight at a point that sees it or does not.
 *
 * At barycentric coordinates u, the depth of the point before what corner i sees is
 *
 *     d_i(u) = 1 - sum over j != i of sight_ij u_j,
 *
 * 1 at the corner and 0 on a plane that cuts the way to corner j at 1 / sight_ij of it: behind that
 * plane the corner is not seen. Numbers belong to pairs of probes, so on the face between two cells
 * both say the same, and what is blended goes on there without a jump.
 */
#ifndef SIGHT_WEIGHTS_H
#define SIGHT_WEIGHTS_H

#include "half.h"

/* Where less than this is left of all weight, a cell's stand-in makes up for it. */
#define SIGHT_ENOUGH 0.05

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

/* Weights of a cell's corners, not yet divided by their sum, which it returns. sight: the cell's
 * halves; u: barycentric. */
static inline double sight_weights(int corners, const uint16_t *sight, const double u[4],
                                   double weight[4])
{
    double sum = 0;
    float value[12];
    for (int i = 0; i < sight_width(corners); i++)
        value[i] = half_value(sight[i]);
    const float *next = value;
    for (int i = 0; i < corners; i++) {
        double depth = 1;
        for (int j = 0; j < corners; j++)
            if (j != i)
                depth -= (double)*next++ * u[j];
        weight[i] = u[i] * sight_left(depth);
        sum += weight[i];
    }
    return sum;
}

#endif
