/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/occlusion.h"
#include "math/angle.h"
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
    o->rays++;
    o->open += rho;
    o->sum[0] += rho * (double)direction.x;
    o->sum[1] += rho * (double)direction.y;
    o->sum[2] += rho * (double)direction.z;
}

void occlusion_sort(struct occlusion *o, struct vec3f normal, int azimuths, struct vec3f direction,
                    bool met)
{
    const struct vec3f from = fabsf(normal.x) < 0.99f ? (struct vec3f){1, 0, 0}
                                                      : (struct vec3f){0, 0, 1},
                       t = vec3f_fma(from, -vec3f_dot(from, normal), normal),
                       b = vec3f_cross(vec3f_normalize(t), normal);
    const double turn = angle_atan2((double)vec3f_dot(direction, b),
                                    (double)vec3f_dot(direction, vec3f_normalize(t))) /
                        (2 * ANGLE_PI);
    const int sector = (int)floor(turn * azimuths + 0.5) + azimuths;
    o->all[sector % azimuths]++;
    o->met[sector % azimuths] += met;
}

void occlusion_horizon(const struct occlusion *o, int azimuths, float *altitude)
{
    for (int i = 0; i < azimuths; i++) {
        const int open = o->all[i] - o->met[i];
        altitude[i] = (float)angle_atan2(sqrt(o->met[i]), sqrt(open));
    }
}

void occlusion_bent(const struct occlusion *o, float normal[3], float *length)
{
    const struct vec3 sum = vec3_load(o->sum), unit = vec3_normalize(sum);
    normal[0] = (float)unit.x, normal[1] = (float)unit.y, normal[2] = (float)unit.z;
    *length = o->open > 0 ? (float)fmin(vec3_length(sum) / o->open, 1) : 0;
}

void occlusion_cone(const struct occlusion *o, const struct vec3f *normal, float cone[4])
{
    float length;
    occlusion_bent(o, cone, &length);
    double cosine = 2 * (double)length - 1;
    if (normal) {
        const double k = o->open / (double)o->rays,
                     aslant = (double)vec3f_dot((struct vec3f){cone[0], cone[1], cone[2]}, *normal);
        cosine = sqrt(fmax(1 - k / fmax(aslant, k), 0));
    }
    cone[3] = o->open > 0 ? (float)cosine : 1;
}

void occlusion_bounced(float ao, const float albedo[3], float bounced[3])
{
    const double k = (double)ao;
    for (int c = 0; c < 3; c++) {
        const double left = 1 - (double)albedo[c] * (1 - k);
        bounced[c] = left > 0 ? (float)(k / left) : 0; /* all reflect all, and no light comes in */
    }
}
