/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/thin_out.h"
#include "adapt/quick_square.h"
#include "adapt/rank.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "leak/stars.h"
#include "math/vec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NEIGHBOURS = 64 };

/* The probes in the cells around one, as candidates. */
static int find_neighbours(const struct choice *choice, const struct stars *stars, size_t probe,
                           uint32_t *neighbour)
{
    int count = 0;
    for (size_t s = stars->first[probe]; s < stars->first[probe + 1]; s++)
        for (size_t k = 0; k < 4; k++) {
            const int32_t vertex = choice->mesh.vertex[stars->slot[s] / 4 * 4 + k];
            const uint32_t candidate = choice->probe[vertex];
            int i = 0;
            while (i < count && neighbour[i] != candidate)
                i++;
            if (i == count && count < NEIGHBOURS && (size_t)vertex != probe)
                neighbour[count++] = candidate;
        }
    return count;
}

/* Solves a x = b for a symmetric positive matrix, in place; returns whether it could. */
static bool solve(double a[4][4], double b[4])
{
    for (int i = 0; i < 4; i++) {
        if (!(a[i][i] > 1e-12))
            return false;
        for (int k = i + 1; k < 4; k++) {
            const double f = a[k][i] / a[i][i];
            for (int j = i; j < 4; j++)
                a[k][j] -= f * a[i][j];
            b[k] -= f * b[i];
        }
    }
    for (int i = 3; i >= 0; i--) {
        for (int k = i + 1; k < 4; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    return true;
}

/* Weights of neighbours for the light at p: of the linear function that fits it best there; or,
 * where they do not tell one, of its mean. */
static void fit(const struct candidates *c, const double p[3], int count, const uint32_t *neighbour,
                double *weight)
{
    double a[4][4] = {{0}}, b[4] = {1, 0, 0, 0}, row[NEIGHBOURS][4], near = (double)INFINITY,
           sum = 0;
    for (int i = 0; i < count; i++) {
        const struct vec3 d =
            vec3_sub(vec3_load(c->position + 3 * (size_t)neighbour[i]), vec3_load(p));
        row[i][0] = 1;
        vec3_store(row[i] + 1, d);
        near = fmin(near, vec3_length(d));
    }
    for (int i = 0; i < count; i++) {
        for (int k = 1; k < 4; k++)
            row[i][k] /= near;
        const double square = row[i][1] * row[i][1] + row[i][2] * row[i][2] + row[i][3] * row[i][3];
        weight[i] = 1 / square;
        sum += weight[i];
        for (int k = 0; k < 4; k++)
            for (int j = 0; j < 4; j++)
                a[k][j] += row[i][k] * row[i][j] / square;
    }
    const bool linear = count > 4 && solve(a, b);
    for (int i = 0; i < count; i++)
        weight[i] *= linear
                         ? b[0] * row[i][0] + b[1] * row[i][1] + b[2] * row[i][2] + b[3] * row[i][3]
                         : 1 / sum;
}

/* What neighbours give with such weights. */
static struct quick_light fitted_light(const struct candidates *c, int count,
                                       const uint32_t *neighbour, const double *weight)
{
    double light[2][SPHERE_COUNT];
    struct quick_light fitted;
    choice_blend(c, count, neighbour, weight, light);
    for (int half = 0; half < 2; half++)
        for (int d = 0; d < SPHERE_COUNT; d++)
            fitted.half[half][d] = (float)light[half][d];
    return fitted;
}

/* By how much the errors around a probe grow without it. */
static double loss_of(const struct choice *choice, const struct stars *stars, size_t probe)
{
    const struct candidates *c = choice->world.candidates;
    const struct seen_world world = choice_seen(choice);
    const double *p = c->position + 3 * (size_t)choice->probe[probe];
    uint32_t neighbour[NEIGHBOURS];
    double weight[NEIGHBOURS], before = 0, after = 0;
    int count = find_neighbours(choice, stars, probe, neighbour), seen = 0;
    for (int i = 0; i < count; i++)
        if (seen_probe(&world, choice->probe[probe], neighbour[i]) > 0.5)
            neighbour[seen++] = neighbour[i];
    count = seen;
    if (!count)
        return (double)INFINITY;
    fit(c, p, count, neighbour, weight);
    const struct quick_light instead = fitted_light(c, count, neighbour, weight);
    for (size_t s = stars->first[probe]; s < stars->first[probe + 1]; s++) {
        const size_t cell = stars->slot[s] / 4;
        for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++) {
            const uint32_t x = choice->at[k];
            const struct blend *blend = &choice->blend[x];
            const float *light[4];
            float share[4], mine = 0;
            for (int i = 0; i < 4; i++) {
                const bool own = blend->from[i] == choice->probe[probe];
                share[i] = (float)blend->weight[i];
                light[i] = own ? instead.half[0] : c->light[blend->from[i]].probe[0];
                mine += own ? share[i] : 0;
            }
            if (!(mine > 0) || !choice_counts(choice, x))
                continue;
            const struct quick_light now = quick_blend(light, share);
            before += (double)choice->weight[x] * choice_square((double)choice->error[x]);
            after += (double)choice->weight[x] * quick_square(&c->light[x], &now, c->floor);
        }
    }
    return fmax(after, 0) - fmax(before, 0); /* less than none is noise */
}

struct losing {
    const struct choice *choice;
    struct stars stars;
    struct rank *rank; /* of each probe, less its loss: those that are missed least come first */
};

static struct error *find_loss(void *context, size_t i, int thread)
{
    (void)thread;
    struct losing *l = context;
    const bool given = l->choice->world.candidates->kind[l->choice->probe[i]] == CANDIDATE_GIVEN;
    l->rank[i] =
        (struct rank){given ? -(double)INFINITY : -loss_of(l->choice, &l->stars, i), (uint32_t)i};
    return interrupt_error();
}

struct error *thin_out_find(const struct choice *choice, size_t most, uint32_t *probe,
                            size_t *found)
{
    struct losing l = {.choice = choice};
    bool *taken = NULL;
    *found = 0;
    struct error *err = array_create(&l.rank, choice->count, sizeof *l.rank);
    if (!err)
        err = array_create(&taken, choice->mesh.cell_count, sizeof *taken);
    if (!err)
        err = stars_init(&l.stars, &choice->mesh);
    if (!err)
        err = threads_for(choice->world.job->threads, choice->count, find_loss, &l);
    if (!err)
        qsort(l.rank, choice->count, sizeof *l.rank, rank_compare);
    for (size_t i = 0; i < choice->count && *found < most && !err; i++) {
        const uint32_t number = l.rank[i].number;
        const size_t first = l.stars.first[number], end = l.stars.first[number + 1];
        bool alone = l.rank[i].value > -(double)INFINITY;
        for (size_t s = first; s < end; s++)
            alone = alone && !taken[l.stars.slot[s] / 4];
        for (size_t s = first; s < end && alone; s++)
            taken[l.stars.slot[s] / 4] = true;
        if (alone)
            probe[(*found)++] = number;
    }
    stars_clear(&l.stars);
    free(taken);
    free(l.rank);
    return err;
}
