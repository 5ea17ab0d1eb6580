/* SPDX-License-Identifier: Apache-2.0 */
#include "math/sphere_rule.h"
#include "math/angle.h"

#include <math.h>

enum { AROUND = 16 };

double sphere_rule(int i, double direction[3])
{
    static const double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                   0.9602898564975363},
                        weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                     0.1012285362903763};
    const int height = i / AROUND;
    const double z = height % 2 ? -node[height / 2] : node[height / 2], r = sqrt(1 - z * z),
                 turn = 2 * ANGLE_PI * (i % AROUND + 0.5) / AROUND;
    direction[0] = r * angle_cos(turn);
    direction[1] = r * angle_sin(turn);
    direction[2] = z;
    return weight[height / 2] * 2 * ANGLE_PI / AROUND;
}
