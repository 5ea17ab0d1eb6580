/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/quick_square.h"

struct quick_light quick_blend(const float *const from[4], const float weight[4])
{
    struct quick_light light;
    const float a = weight[0], b = weight[1], c = weight[2], d = weight[3];
    for (int half = 0; half < 2; half++) {
        const int first = half * SPHERE_COUNT;
        const float *p = from[0] + first, *q = from[1] + first, *r = from[2] + first,
                    *s = from[3] + first;
        float *to = light.half[half];
        for (int i = 0; i < SPHERE_COUNT; i++)
            to[i] = a * p[i] + b * q[i] + (c * r[i] + d * s[i]);
    }
    return light;
}

static inline float most(float a, float b)
{
    return a > b ? a : b;
}

static inline float least(float a, float b)
{
    return a < b ? a : b;
}

double quick_square(const struct candidate_light *at, const struct quick_light *light, double floor)
{
    const float lowest = (float)floor;
    const float *l = light->half[0], *m = light->half[1], *t = at->truth[0], *u = at->truth[1];
    float square[SPHERE_COUNT], sum[4] = {0};
    for (int i = 0; i < SPHERE_COUNT; i++) {
        const float truth = (t[i] + u[i]) / 2, one = 1 / most(truth, lowest),
                    x = (most((l[i] + m[i]) / 2, 0) - truth) * one,
                    y = (l[i] - t[i] - m[i] + u[i]) / 2 * one;
        square[i] = (float)sphere_weight[i] * most(least(x * x - y * y, 1), -1);
    }
    for (int i = 0; i < SPHERE_COUNT; i += 4)
        for (int k = 0; k < 4; k++)
            sum[k] += square[i + k];
    return (double)((sum[0] + sum[1]) + (sum[2] + sum[3]));
}
