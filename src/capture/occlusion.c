/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/occlusion.h"
#include "math/power.h"

#include <math.h>
#include <stddef.h>

const char *const occlusion_falloff_names[] = {[OCCLUSION_STEP] = "step",
                                               [OCCLUSION_LINEAR] = "linear",
                                               [OCCLUSION_SQRT] = "sqrt",
                                               [OCCLUSION_EXP] = "exp",
                                               NULL};

double occlusion_openness(enum occlusion_falloff falloff, double t)
{
    const double bend = 3; /* of EXP: at a tenth of the distance a surface still takes 3/4 */
    if (t > 1)
        return 1;
    switch (falloff) {
    case OCCLUSION_LINEAR: return t;
    case OCCLUSION_SQRT: return sqrt(t);
    case OCCLUSION_EXP: return (1 - power_exp(-bend * t)) / (1 - power_exp(-bend));
    default: return 0;
    }
}

void occlusion_add(struct occlusion *o, struct vec3f direction, double distance)
{
    const double t = isinf(distance) ? 2 : distance / o->distance,
                 rho = occlusion_openness(o->falloff, t);
    o->open += rho;
    o->sum[0] += rho * (double)direction.x;
    o->sum[1] += rho * (double)direction.y;
    o->sum[2] += rho * (double)direction.z;
}
