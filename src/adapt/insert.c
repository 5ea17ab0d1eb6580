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

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OF_A_CELL = 4 }; /* candidates of one that are looked at: more would share its cavity */
enum { SHARED = 25 };   /* % of a cavity's cells that others may change as well */
enum { FEW = 3 };       /* of those wanted: so many come if they gain anything */
enum { DOUBTED = 50 };  /* of all that there are: so many more, if they may gain something */
enum { FOR_EACH = 4, AND = 512 }; /* gains that are estimated for each one wanted, and more */
enum { WIDER = 3 };               /* times, each twice as many, to find half of those few */

/* Standard errors of the noise of a cell's errors that are not counted. */
static const double NOISE = 2;

/* What gains count that may be by chance. */
static const double DOUBTFUL = 1e-3;

/* The cells by their errors, less what may well be noise: else those would come first that are
 * large, without any error to speak of. */
static struct error *rank_cells(const struct choice *choice, struct rank **cell)
{
    const size_t cells = choice->mesh.cell_count;
    struct error *err = array_create(cell, cells, sizeof **cell);
    for (size_t i = 0; i < cells && !err; i++) {
        struct rank *rank = &(*cell)[i];
        rank->number = (uint32_t)i;
        double squares = 0;
        for (uint32_t k = choice->first[i]; k < choice->first[i + 1]; k++) {
            const uint32_t x = choice->at[k];
            const double weight = (double)choice->weight[x],
                         noise = weight * (double)choice->noise[x];
            if (!choice_counts(choice, x))
                continue;
            rank->value += weight * choice_square((double)choice->error[x]);
            squares += noise * noise;
        }
        rank->value -= NOISE * sqrt(squares);
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
        if (choice_can_add(choice, choice->at[k]))
            all[count++] = (struct rank){(double)choice->error[choice->at[k]], choice->at[k]};
    qsort(all, count, sizeof *all, rank_compare);
    const size_t take = count < OF_A_CELL ? count : OF_A_CELL;
    for (size_t i = 0; i < take; i++)
        picked[i] = all[i * count / take];
    return take;
}

/* Candidates whose gains are estimated, of more and more cells. */
struct gaining {
    const struct choice *choice;
    uint64_t *number;  /* of each cell: gains_cells; this and what follows is owned */
    struct rank *cell; /* those with the largest errors first; */
    size_t cells;      /* so many of them were looked into */
    struct rank *of_cell;
    struct rank *picked; /* by their gains, if they are known */
    size_t count;
    bool *fresh;           /* the gain was not known before */
    struct cavity *cavity; /* of each thread */
};

static void gaining_clear(struct gaining *g)
{
    free(g->number);
    free(g->cell);
    free(g->of_cell);
    free(g->picked);
    free(g->fresh);
    free(g->cavity);
}

static struct error *gaining_init(struct gaining *g, const struct choice *choice)
{
    const size_t all = choice->candidates;
    *g = (struct gaining){.choice = choice};
    struct error *err =
        array_create(&g->cavity, (size_t)choice->world.job->threads, sizeof *g->cavity);
    if (!err)
        err = array_create(&g->of_cell, all, sizeof *g->of_cell);
    if (!err)
        err = array_create(&g->picked, all, sizeof *g->picked);
    if (!err)
        err = array_create(&g->fresh, all, sizeof *g->fresh);
    if (!err)
        err = gains_reserve(choice->world.gains, all);
    if (!err)
        err = gains_cells(choice, &g->number);
    if (!err)
        err = rank_cells(choice, &g->cell);
    return err;
}

static struct error *find_gain(void *context, size_t i, int thread)
{
    struct gaining *g = context;
    struct cavity *cavity = &g->cavity[thread];
    i += g->count;
    const uint32_t x = g->picked[i].number;
    struct gain *known = &g->choice->world.gains->of[x];
    g->picked[i].value = 0;
    if (cavity_dig(cavity, g->choice, x)) {
        const uint64_t around =
            cavity_around(cavity, g->number, g->choice->world.candidates->refined[x]);
        g->fresh[i] = known->around != around;
        if (g->fresh[i]) {
            known->around = around;
            known->value = cavity_gain(cavity, g->choice, x, &known->doubtful);
        }
        g->picked[i].value = known->doubtful ? known->value * DOUBTFUL : known->value;
    }
    progress_add(g->choice->world.job->progress, 1);
    return interrupt_error();
}

/* Looks into more cells, until so many gains were estimated, or there are no more. */
static struct error *find_gains(struct gaining *g, size_t room)
{
    const struct choice *choice = g->choice;
    struct error *err = NULL;
    for (size_t fresh = 0; fresh < room && g->cells < choice->mesh.cell_count && !err;) {
        size_t more = 0;
        while (fresh + more < room && g->cells < choice->mesh.cell_count)
            more +=
                pick(choice, g->cell[g->cells++].number, g->of_cell, g->picked + g->count + more);
        err = threads_for(choice->world.job->threads, more, find_gain, g);
        for (; more; more--)
            fresh += g->fresh[g->count++];
    }
    return err;
}

/* Whether as good as none of a cavity's cells are taken. */
static bool is_free(const struct cavity *cavity, const bool *taken)
{
    size_t shared = 0;
    for (size_t k = 0; k < cavity->cells; k++)
        shared += taken[cavity->cell[k]];
    return shared <= SHARED * cavity->cells / 100;
}

/* Those that gain most, in order; the caller's to free. */
static struct error *rank_gains(const struct gaining *g, struct rank **best)
{
    struct error *err = array_create(best, g->count, sizeof **best);
    if (!err && g->count) {
        memcpy(*best, g->picked, g->count * sizeof **best);
        qsort(*best, g->count, sizeof **best, rank_compare);
    }
    return err;
}

/* How many are taken at the least, and at the most of those whose gain is doubtful. */
struct numbers {
    size_t few, doubted, most;
};

static struct numbers numbers_of(const struct choice *choice, size_t most)
{
    const size_t doubted = choice->count / DOUBTED, few = most / FEW + 1;
    struct numbers n = {.few = few > doubted ? few : doubted, .doubted = doubted, .most = most};
    n.few = n.few < most ? n.few : most;
    return n;
}

/* Takes the candidates whose cavities are apart: few whatever they gain, and those whose gain is a
 * share of a large one. */
static struct error *take(const struct gaining *g, struct numbers n, double share,
                          uint32_t *candidate, size_t *found, double *gain)
{
    struct rank *best = NULL;
    bool *taken = NULL;
    struct error *err = rank_gains(g, &best);
    if (!err)
        err = array_create(&taken, g->choice->mesh.cell_count, sizeof *taken);
    const size_t large = n.most / 8 < g->count ? n.most / 8 : g->count - 1;
    *found = 0;
    *gain = 0;
    for (size_t i = 0; i < g->count && *found < n.most && !err; i++) {
        const uint32_t x = best[i].number;
        const size_t least = g->choice->world.gains->of[x].doubtful ? n.doubted : n.few;
        if (!(best[i].value > 0) || (*found >= least && best[i].value < share * best[large].value))
            break;
        if (!cavity_dig(g->cavity, g->choice, x) || !is_free(g->cavity, taken))
            continue;
        for (size_t k = 0; k < g->cavity->cells; k++)
            taken[g->cavity->cell[k]] = true;
        candidate[(*found)++] = x;
        *gain += g->choice->world.gains->of[x].value;
    }
    free(taken);
    free(best);
    return err;
}

struct error *insert_find(const struct choice *choice, size_t most, double share,
                          uint32_t *candidate, size_t *found, double *gain)
{
    const struct numbers n = numbers_of(choice, most);
    size_t room = FOR_EACH * most + AND;
    struct gaining g;
    *found = 0;
    struct error *err = gaining_init(&g, choice);
    for (int i = 0; !err && g.cells < choice->mesh.cell_count &&
                    (!*found || (i <= WIDER && 2 * *found < n.few));
         i++, room *= 2) {
        err = find_gains(&g, room);
        if (!err)
            err = take(&g, n, share, candidate, found, gain);
    }
    gaining_clear(&g);
    return err;
}
