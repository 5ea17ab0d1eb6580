/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/bound.h"
#include "math/angle.h"

#include <math.h>

/* What a side may be darker than dark, as a share of the mean of all: the light of few bands is so
 * itself, and what is 0 on one side must not forbid all others to change. */
#define DARKER 0.01f

void bound_start(struct bound *bound, int order, bool convolved)
{
    *bound = (struct bound){.functions = order * order};
    int side = 0;
    for (int z = -1; z <= 1; z++)
        for (int y = -1; y <= 1; y++)
            for (int x = -1; x <= 1; x++) {
                const double length = sqrt(x * x + y * y + z * z);
                double basis[SH_COUNT_MAX];
                if (!(length > 0))
                    continue;
                sh_basis(order, (double[3]){x / length, y / length, z / length}, basis);
                for (int l = 0; l < order; l++)
                    for (int i = l * l; i < (l + 1) * (l + 1); i++)
                        bound->side[side][i] = (float)((convolved ? 1 : sh_cosine(l)) * basis[i]);
                side++;
            }
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++) {
            const double factor = convolved ? 1 : sh_cosine(l);
            bound->square[i] = (float)(factor * factor / (4 * ANGLE_PI));
        }
}

float bound_size(const struct bound *bound, const float *sh)
{
    float sum[3] = {0};
    for (int i = 0; i < bound->functions; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += bound->square[i] * sh[3 * i + k] * sh[3 * i + k];
    return sqrtf(sum[0] + sum[1] + sum[2]);
}

void bound_shares(const struct bound *bound, const float *sh, const float *more, float share[3])
{
    float dark[3];
    for (int k = 0; k < 3; k++) {
        dark[k] = DARKER * fmaxf(bound->side[0][0] * sh[k], 0); /* alike on all sides */
        share[k] = 1;
    }
    for (int side = 0; side < BOUND_SIDES; side++) {
        float there[3] = {0}, added[3] = {0};
        for (int i = 0; i < bound->functions; i++)
            for (int k = 0; k < 3; k++) {
                there[k] += bound->side[side][i] * sh[3 * i + k];
                added[k] += bound->side[side][i] * more[3 * i + k];
            }
        for (int k = 0; k < 3; k++) {
            const float most = fmaxf(there[k], 0) + dark[k];
            if (-added[k] * share[k] > most)
                share[k] = most / -added[k];
        }
    }
}
