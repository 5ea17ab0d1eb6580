/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/insert.h"
#include "adapt/cavity.h"
#include "adapt/gains.h"
#include "adapt/rank.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/progress.h"
#include "base/threads.h"

#include <stdlib.h>

enum { OF_A_CELL = 12 };         /* candidates of one that are looked at */
enum { SHARED = 25 };            /* % of a cavity's cells that others may change as well */
enum { FOR_EACH = 8, AND = 64 }; /* candidates that are looked at for each one wanted, and more */

static bool can_be_chosen(const struct choice *choice, uint32_t x)
{
    const enum candidate_kind kind = choice->world.candidates->kind[x];
    return (kind == CANDIDATE_SPACE || kind == CANDIDATE_SURFACE) && !choice->chosen[x];
}

/* The cells by their errors. */
static struct error *rank_cells(const struct choice *choice, struct rank **cell)
{
    const size_t cells = choice->mesh.cell_count;
    struct error *err = array_create(cell, cells, sizeof **cell);
    for (size_t i = 0; i < cells && !err; i++) {
        struct rank *rank = &(*cell)[i];
        rank->number = (uint32_t)i;
        for (uint32_t k = choice->first[i]; k < choice->first[i + 1]; k++) {
            const uint32_t x = choice->at[k];
            if (choice_counts(choice, x))
                rank->value += (double)choice->weight[x] * choice_square((double)choice->error[x]);
        }
    }
    if (!err)
        qsort(*cell, cells, sizeof **cell, rank_compare);
    return err;
}

/* Candidates of a cell, spread over those of large and small errors. */
static size_t pick(const struct choice *choice, uint32_t cell, struct rank *all,
                   struct rank *picked)
{
    size_t count = 0;
    for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++)
        if (can_be_chosen(choice, choice->at[k]))
            all[count++] = (struct rank){(double)choice->error[choice->at[k]], choice->at[k]};
    qsort(all, count, sizeof *all, rank_compare);
    const size_t take = count < OF_A_CELL ? count : OF_A_CELL;
    for (size_t i = 0; i < take; i++)
        picked[i] = all[i * count / take];
    return take;
}

static struct error *pick_all(const struct choice *choice, size_t most, struct rank *picked,
                              size_t *count)
{
    struct rank *cell = NULL, *all = NULL;
    struct error *err = rank_cells(choice, &cell);
    if (!err)
        err = array_create(&all, choice->world.candidates->count, sizeof *all);
    *count = 0;
    for (size_t i = 0; i < choice->mesh.cell_count && *count + OF_A_CELL <= most && !err; i++)
        *count += pick(choice, cell[i].number, all, picked + *count);
    free(cell);
    free(all);
    return err;
}

struct gaining {
    const struct choice *choice;
    uint64_t *cell; /* gains_cells */
    struct rank *picked;
    struct cavity *cavity; /* of each thread */
};

static struct error *find_gain(void *context, size_t i, int thread)
{
    struct gaining *g = context;
    struct cavity *cavity = &g->cavity[thread];
    const uint32_t x = g->picked[i].number;
    struct gain *known = &g->choice->world.gains->of[x];
    g->picked[i].value = 0;
    if (cavity_dig(cavity, g->choice, x)) {
        const uint64_t around =
            cavity_around(cavity, g->cell, g->choice->world.candidates->refined[x]);
        if (known->around != around)
            *known = (struct gain){around, cavity_gain(cavity, g->choice, x)};
        g->picked[i].value = known->value;
    }
    progress_add(g->choice->world.job->progress, 1);
    return interrupt_error();
}

/* Whether as good as none of a cavity's cells are taken. */
static bool is_free(const struct cavity *cavity, const bool *taken)
{
    size_t shared = 0;
    for (size_t k = 0; k < cavity->cells; k++)
        shared += taken[cavity->cell[k]];
    return shared <= SHARED * cavity->cells / 100;
}

/* Takes the candidates whose cavities are apart. */
static struct error *take(const struct choice *choice, const struct rank *picked, size_t count,
                          double least, struct cavity *cavity, size_t most, uint32_t *candidate,
                          size_t *found, double *gain)
{
    bool *taken = NULL;
    struct error *err = array_create(&taken, choice->mesh.cell_count, sizeof *taken);
    *found = 0;
    *gain = 0;
    for (size_t i = 0; i < count && *found < most && !err; i++) {
        if (!(picked[i].value > 0) || !(picked[i].value >= least) ||
            !cavity_dig(cavity, choice, picked[i].number) || !is_free(cavity, taken))
            continue;
        for (size_t k = 0; k < cavity->cells; k++)
            taken[cavity->cell[k]] = true;
        candidate[(*found)++] = picked[i].number;
        *gain += picked[i].value;
    }
    free(taken);
    return err;
}

static struct error *find(struct gaining *g, size_t room, size_t most, double share,
                          uint32_t *candidate, size_t *found, double *gain, bool *all)
{
    const struct choice *choice = g->choice;
    size_t count = 0;
    struct error *err = array_create(&g->picked, room, sizeof *g->picked);
    if (!err)
        err = pick_all(choice, room, g->picked, &count);
    *all = count + OF_A_CELL <= room;
    if (!err)
        err = threads_for(choice->world.job->threads, count, find_gain, g);
    if (!err && count) {
        qsort(g->picked, count, sizeof *g->picked, rank_compare);
        const size_t large = most / 8 < count ? most / 8 : count - 1;
        err = take(choice, g->picked, count, share * g->picked[large].value, g->cavity, most,
                   candidate, found, gain);
    }
    free(g->picked);
    return err;
}

struct error *insert_find(const struct choice *choice, size_t most, double share,
                          uint32_t *candidate, size_t *found, double *gain)
{
    const int threads = choice->world.job->threads;
    struct gaining g = {.choice = choice};
    bool all = false;
    *found = 0;
    struct error *err = array_create(&g.cavity, (size_t)threads, sizeof *g.cavity);
    if (!err)
        err = gains_reserve(choice->world.gains, choice->candidates);
    if (!err)
        err = gains_cells(choice, &g.cell);
    /* where none gains among those, more are looked at */
    for (size_t room = FOR_EACH * most + AND + choice->count; !err && !*found && !all; room *= 4)
        err = find(&g, room, most, share, candidate, found, gain, &all);
    free(g.cavity);
    free(g.cell);
    return err;
}
