/* SPDX-License-Identifier: Apache-2.0 */
/* sh_light: SH of light that is drawn at random, for tests of what is made of SH. */
#ifndef SH_LIGHT_H
#define SH_LIGHT_H

#include "base/error.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "support/tap.h"

#include <math.h>
#include <stdint.h>

#define PI ANGLE_PI

static uint64_t state = 1;

static inline double draw(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) * 0x1p-53;
}

static inline void draw_direction(double d[3])
{
    const double z = 2 * draw() - 1, s = sqrt(1 - z * z), phi = 2 * PI * draw();
    d[0] = s * cos(phi), d[1] = s * sin(phi), d[2] = z;
}

/* Adds a delta of irradiance rgb from d. */
static inline void add_delta(int order, float *sh, const double d[3], const double rgb[3])
{
    double y[SH_COUNT_MAX];
    sh_basis(order, d, y);
    for (int i = 0; i < order * order; i++)
        for (int k = 0; k < 3; k++)
            sh[3 * i + k] += (float)(y[i] * rgb[k]);
}

#endif
