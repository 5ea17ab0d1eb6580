/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/bound.h"
#include "math/angle.h"

#include <math.h>

/* What a side may be darker than dark, as a share of the mean of all: the light of few bands is so
 * itself, and what is 0 on one side must not forbid all others to change. */
#define DARKER 0.005f

/* Where no side is darker than this share of the mean, what is between them is not dark either. */
#define DIM 0.25f

static void set_side(float side[SH_COUNT_MAX], int order, bool convolved, double x, double y,
                     double z)
{
    const double length = sqrt(x * x + y * y + z * z);
    double basis[SH_COUNT_MAX];
    sh_basis(order, (double[3]){x / length, y / length, z / length}, basis);
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++)
            side[i] = (float)((convolved ? 1 : sh_cosine(l)) * basis[i]);
}

void bound_start(struct bound *bound, int order, bool convolved)
{
    *bound = (struct bound){.functions = order * order};
    int side = 0;
    for (int z = -1; z <= 1; z++)
        for (int y = -1; y <= 1; y++)
            for (int x = -1; x <= 1; x++)
                if (x || y || z)
                    set_side(bound->side[side++], order, convolved, x, y, z);
    for (int i = 0; i < BOUND_FINE; i++) { /* the squares of a cube's faces */
        const int face = i / (BOUND_ACROSS * BOUND_ACROSS), axis = face / 2;
        double d[3];
        d[axis] = face % 2 ? BOUND_ACROSS : -BOUND_ACROSS;
        d[(axis + 1) % 3] = 2 * (i / BOUND_ACROSS % BOUND_ACROSS) + 1 - BOUND_ACROSS;
        d[(axis + 2) % 3] = 2 * (i % BOUND_ACROSS) + 1 - BOUND_ACROSS;
        set_side(bound->fine[i], order, convolved, d[0], d[1], d[2]);
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

/* Lowers the shares so that no side gets darker than dark. Returns whether one of them is dim. */
static bool lower_shares(const struct bound *bound, int sides, const float side[][SH_COUNT_MAX],
                         const float *sh, const float *more, float share[3])
{
    float mean[3], least[3] = {INFINITY, INFINITY, INFINITY};
    for (int k = 0; k < 3; k++)
        mean[k] = fmaxf(bound->side[0][0] * sh[k], 0); /* alike on all sides */
    for (int s = 0; s < sides; s++) {
        float there[3] = {0}, added[3] = {0};
        for (int i = 0; i < bound->functions; i++)
            for (int k = 0; k < 3; k++) {
                there[k] += side[s][i] * sh[3 * i + k];
                added[k] += side[s][i] * more[3 * i + k];
            }
        for (int k = 0; k < 3; k++) {
            const float most = fmaxf(there[k], 0) + DARKER * mean[k];
            if (-added[k] * share[k] > most)
                share[k] = most / -added[k];
            least[k] = fminf(least[k], there[k] + fminf(added[k], 0));
        }
    }
    return least[0] < DIM * mean[0] || least[1] < DIM * mean[1] || least[2] < DIM * mean[2];
}

void bound_shares(const struct bound *bound, const float *sh, const float *more, float share[3])
{
    share[0] = share[1] = share[2] = 1;
    if (lower_shares(bound, BOUND_SIDES, bound->side, sh, more, share) && bound->functions > 1)
        lower_shares(bound, BOUND_FINE, bound->fine, sh, more, share);
}
