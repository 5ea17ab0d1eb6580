/* SPDX-License-Identifier: Apache-2.0 */
/* direction: directions spread evenly over the sphere, or drawn by the cosine, the same on every
 * machine.
 *
 * Based on: Marques et al., "Spherical Fibonacci point sets for illumination integrals", Computer
 * Graphics Forum 32(8), 2013: heights in even steps, each turned by the golden angle further.
 * Malley's method: cosine-distributed directions from a disc. Duff et al., "Building an orthonormal
 * basis, revisited", JCGT 2017.
 */
#ifndef DIRECTION_H
#define DIRECTION_H

#include "math/angle.h"
#include "math/vec.h"

/* The i-th of `count` unit vectors, from z = 1 down; each stands for 4 pi / count of the sphere. */
static inline struct vec3 direction_even(int i, int count)
{
    const double golden_angle = 2.39996322972865332; /* pi (3 - sqrt 5) */
    const double z = 1 - (2 * i + 1.0) / count, r = sqrt(1 - z * z), turn = i * golden_angle;
    return (struct vec3){r * angle_cos(turn), r * angle_sin(turn), z};
}

/* A cosine-distributed direction about a unit normal, by (u, turn) uniform in the unit square. */
static inline struct vec3f direction_by_cosine(struct vec3f n, float u, float turn)
{
    const float r = sqrtf(u), z = sqrtf(1 - u);
    float x, y;
    angle_turn(turn, &x, &y);
    x *= r;
    y *= r;
    const float sign = n.z < 0 ? -1.0f : 1.0f, a = -1 / (sign + n.z), b = n.x * n.y * a;
    const struct vec3f s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x},
                       t = {b, sign + n.y * n.y * a, -n.y};
    return vec3f_add(vec3f_scale(x, s), vec3f_add(vec3f_scale(y, t), vec3f_scale(z, n)));
}

#endif
