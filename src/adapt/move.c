/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/move.h"
#include "adapt/cavity.h"
#include "adapt/gains.h"
#include "adapt/rank.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/progress.h"
#include "base/threads.h"
#include "leak/stars.h"
#include "math/vec.h"

#include <stdlib.h>
#include <string.h>

enum { TRIED = 16 };   /* candidates around a probe, the nearest */
enum { AROUND = 512 }; /* of which they are the nearest, at the most */

void moves_clear(struct moves *moves)
{
    free(moves->of);
    *moves = (struct moves){0};
}

static struct error *reserve(struct moves *moves, size_t count)
{
    struct error *err = array_reserve(&moves->of, &moves->room, count, sizeof *moves->of);
    if (!err && count > moves->count) {
        memset(moves->of + moves->count, 0, (count - moves->count) * sizeof *moves->of);
        moves->count = count;
    }
    return err;
}

/* -- what moves gain -------------------------------------------------------------------------- */

struct moving {
    const struct choice *choice;
    struct moves *known;
    struct stars stars;
    uint64_t *number; /* gains_cells */
    struct rank *probe;
    struct cavity *cavity; /* of each thread */
};

/* The candidates in the cells around a probe, the nearest first; returns how many. */
static size_t find_near(const struct moving *m, size_t probe, struct rank near[AROUND])
{
    const struct choice *choice = m->choice;
    const struct candidates *c = choice->world.candidates;
    const struct vec3 p = vec3_load(c->position + 3 * (size_t)choice->probe[probe]);
    size_t count = 0;
    for (size_t s = m->stars.first[probe]; s < m->stars.first[probe + 1]; s++) {
        const size_t cell = m->stars.slot[s] / 4;
        for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1] && count < AROUND; k++) {
            const uint32_t x = choice->at[k];
            const struct vec3 d = vec3_sub(vec3_load(c->position + 3 * (size_t)x), p);
            if (choice_can_add(choice, x))
                near[count++] = (struct rank){-vec3_dot(d, d), x};
        }
    }
    qsort(near, count, sizeof *near, rank_compare);
    return count < TRIED ? count : TRIED;
}

static uint64_t number_around(const struct moving *m, size_t probe)
{
    uint64_t sum = 0;
    for (size_t s = m->stars.first[probe]; s < m->stars.first[probe + 1]; s++)
        sum += m->number[m->stars.slot[s] / 4];
    return sum ? sum : 1;
}

static struct error *find_move(void *context, size_t i, int thread)
{
    struct moving *m = context;
    struct cavity *cavity = &m->cavity[thread];
    const uint32_t own = m->choice->probe[i];
    struct move_known *known = &m->known->of[own];
    const uint64_t around = number_around(m, i);
    m->probe[i] = (struct rank){0, (uint32_t)i};
    if (m->choice->world.candidates->kind[own] == CANDIDATE_GIVEN)
        return NULL;
    if (known->around != around) {
        struct rank near[AROUND];
        const size_t count = find_near(m, i, near);
        *known = (struct move_known){.around = around};
        for (size_t k = 0; k < count; k++) {
            if (!cavity_dig_without(cavity, m->choice, near[k].number, &m->stars, (uint32_t)i))
                continue;
            bool by_chance; /* what was moved is looked at again, and taken back if so */
            const double gain = cavity_gain(cavity, m->choice, near[k].number, &by_chance);
            if (gain > known->gain) {
                known->gain = gain;
                known->candidate = near[k].number;
            }
        }
    }
    m->probe[i].value = known->gain;
    progress_add(m->choice->world.job->progress, 1);
    return interrupt_error();
}

/* Takes those whose cavities are apart. */
static struct error *take(struct moving *m, size_t most, struct move *move, size_t *found)
{
    const struct choice *choice = m->choice;
    struct cavity *cavity = m->cavity;
    bool *taken = NULL;
    struct error *err = array_create(&taken, choice->mesh.cell_count, sizeof *taken);
    for (size_t i = 0; i < choice->count && *found < most && !err; i++) {
        const uint32_t probe = m->probe[i].number;
        const uint32_t candidate = m->known->of[choice->probe[probe]].candidate;
        bool alone = m->probe[i].value > 0 &&
                     cavity_dig_without(cavity, choice, candidate, &m->stars, probe);
        for (size_t k = 0; k < cavity->cells && alone; k++)
            alone = !taken[cavity->cell[k]];
        for (size_t k = 0; k < cavity->cells && alone; k++)
            taken[cavity->cell[k]] = true;
        if (alone)
            move[(*found)++] = (struct move){probe, candidate};
    }
    free(taken);
    return err;
}

struct error *move_find(const struct choice *choice, struct moves *known, size_t most,
                        struct move *move, size_t *found)
{
    const int threads = choice->world.job->threads;
    struct moving m = {.choice = choice, .known = known};
    *found = 0;
    struct error *err = array_create(&m.cavity, (size_t)threads, sizeof *m.cavity);
    if (!err)
        err = array_create(&m.probe, choice->count, sizeof *m.probe);
    if (!err)
        err = reserve(known, choice->candidates);
    if (!err)
        err = gains_cells(choice, &m.number);
    if (!err)
        err = stars_init(&m.stars, &choice->mesh);
    if (!err)
        err = threads_for(threads, choice->count, find_move, &m);
    if (!err) {
        qsort(m.probe, choice->count, sizeof *m.probe, rank_compare);
        err = take(&m, most, move, found);
    }
    stars_clear(&m.stars);
    free(m.cavity);
    free(m.probe);
    free(m.number);
    return err;
}

/* -- what came of them ------------------------------------------------------------------------ */

/* Adds to the gains of the moves whose probes light is blended of. */
static void add_gain(const struct blend *blend, const uint32_t *move_of, double gain, double *gains,
                     uint32_t *last)
{
    for (int k = 0; k < 4; k++) {
        const uint32_t i = move_of[blend->from[k]];
        if (i && *last != i)
            gains[i - 1] += gain;
        *last = i ? i : *last;
    }
}

struct error *move_judge(const struct choice *before, const struct choice *after,
                         struct moves *known, size_t count, const struct move *move, bool *good)
{
    uint32_t *move_of = NULL; /* each candidate that is in one, from 1 */
    double *gain = NULL;
    struct error *err = array_create(&move_of, before->candidates, sizeof *move_of);
    if (!err)
        err = array_create(&gain, count, sizeof *gain);
    for (uint32_t i = 0; i < count && !err; i++)
        move_of[before->probe[move[i].probe]] = move_of[move[i].candidate] = i + 1;
    for (uint32_t x = 0; x < before->candidates && !err; x++) {
        uint32_t last = 0;
        if (!choice_counts(before, x) || !choice_counts(after, x))
            continue;
        const double fall = (double)before->weight[x] * (choice_square((double)before->error[x]) -
                                                         choice_square((double)after->error[x]));
        if (fall != 0) {
            add_gain(&after->blend[x], move_of, fall, gain, &last);
            add_gain(&before->blend[x], move_of, fall, gain, &last);
        }
    }
    for (size_t i = 0; i < count && !err; i++) {
        good[i] = gain[i] > 0;
        if (!good[i])
            known->of[before->probe[move[i].probe]].gain = 0;
    }
    free(move_of);
    free(gain);
    return err;
}
