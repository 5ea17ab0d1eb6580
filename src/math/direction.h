/* SPDX-License-Identifier: Apache-2.0 */
/* direction: directions spread evenly over the sphere, the same on every machine.
 *
 * Based on: Marques et al., "Spherical Fibonacci point sets for illumination integrals", Computer
 * Graphics Forum 32(8), 2013: heights in even steps, each turned by the golden angle further.
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

#endif
