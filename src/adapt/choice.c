/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/choice.h"
#include "adapt/mean_error.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "interpolate/cells_volume.h"
#include "leak/cells_make.h"
#include "leak/leak_mend.h"
#include "leak/sight.h"
#include "libprobe-query/sh.h"
#include "libprobe-query/sight.h"
#include "measure/ruler.h"
#include "stream/stream.h"
#include "trace/path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Errors below are as good as this: nobody sees them, and it is about their noise. */
static const double LEAST = 0.02;

enum { BLOCK = 256 }; /* candidates that are looked up one after the other */

void choice_blend(const struct candidates *c, int count, const uint32_t *from, const double *weight,
                  double light[2][SPHERE_COUNT])
{
    memset(light, 0, 2 * sizeof *light);
    for (int k = 0; k < count; k++) {
        const struct candidate_light *of = &c->light[from[k]];
        for (int half = 0; half < 2 && weight[k] != 0; half++)
            for (int d = 0; d < SPHERE_COUNT; d++)
                light[half][d] += weight[k] * (double)of->probe[half][d];
    }
}

double choice_error_of(const struct candidates *c, size_t candidate, double light[2][SPHERE_COUNT],
                       float *noise)
{
    const struct candidate_light *of = &c->light[candidate];
    double mean[SPHERE_COUNT], truth[SPHERE_COUNT], variance[SPHERE_COUNT], product[SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double t[2] = {(double)of->truth[0][d], (double)of->truth[1][d]},
                     y = (light[0][d] - t[0] - light[1][d] + t[1]) / 2;
        mean[d] = (light[0][d] + light[1][d]) / 2;
        truth[d] = (t[0] + t[1]) / 2;
        variance[d] = y * y;
        product[d] = 2 * (mean[d] - truth[d]) * y;
    }
    for (int d = 0; d < SPHERE_COUNT && noise; d++) {
        const double below = fmax(truth[d], c->floor);
        product[d] = fmin(fmax(product[d] / (below * below), -1), 1);
    }
    if (noise)
        *noise = (float)sphere_mean(product);
    return ruler_error(mean, truth, variance, c->floor);
}

/* -- cells ------------------------------------------------------------------------------------ */

static struct error *make_stream(struct choice *choice)
{
    struct table *table = NULL;
    struct column *position = NULL;
    struct error *err = stream_create(&choice->stream);
    if (!err)
        err = stream_add_table(choice->stream, "probe", &table);
    if (!err)
        err = table_resize(table, choice->count);
    if (!err)
        err = table_add_column(table, "position", COLUMN_F64, 3, &position);
    for (size_t i = 0; i < choice->count && !err; i++)
        memcpy(column_f64(position) + 3 * i,
               choice->world.candidates->position + 3 * (size_t)choice->probe[i],
               3 * sizeof(double));
    return err ? err : cells_make(choice->stream, true);
}

static struct error *make_volume(struct choice *choice)
{
    struct error *err = make_stream(choice);
    if (!err)
        err = cells_volume_mesh(choice->stream, &choice->cells);
    if (!err && choice->cells.corners != 4)
        err = error_new("the free space is flat: probes that light is blended of need one that is "
                        "not");
    if (!err)
        err = leak_mesh_of(choice->stream, &choice->mesh);
    if (!err)
        err = cells_volume_create(&choice->cells, 0, &choice->volume);
    return err;
}

/* -- candidates in it ------------------------------------------------------------------------- */

struct judging {
    struct choice *choice;
    const struct choice *before; /* or NULL */
};

/* Where a candidate is, of the four around or with what stands in for one. */
static struct blend locate(const struct choice *choice, size_t x)
{
    struct probe_place place = {.cell = PROBE_COLD};
    probe_volume_locate(choice->volume, choice->world.candidates->position + 3 * x, &place);
    struct blend blend = {.cell = place.cell, .inside = place.inside};
    for (int k = 0; k < 4; k++) {
        blend.from[k] = choice->probe[place.probe[k]];
        blend.weight[k] = place.weight[k];
    }
    return blend;
}

/* Whether a candidate is in the cell where it was, and that is blended as it was. */
static bool is_same(const struct blend *now, const struct blend *before)
{
    bool same = now->inside && before->inside && !before->stood_in;
    for (int i = 0; i < 4 && same; i++) {
        int k = 0;
        while (k < 4 && before->from[k] != now->from[i])
            k++;
        same = k < 4;
    }
    return same;
}

static void judge(struct choice *choice, const struct choice *before, size_t x)
{
    const struct candidates *c = choice->world.candidates;
    struct blend *blend = &choice->blend[x];
    double light[2][SPHERE_COUNT];
    *blend = locate(choice, x);
    if (before && x < before->candidates && is_same(blend, &before->blend[x])) {
        const int32_t cell = blend->cell;
        *blend = before->blend[x];
        blend->cell = cell;
        choice->error[x] = before->error[x];
        choice->noise[x] = before->noise[x];
        return;
    }
    const struct seen_world seen = choice_seen(choice);
    seen_weigh(&seen, (uint32_t)x, blend);
    choice_blend(c, 4, blend->from, blend->weight, light);
    choice->error[x] = (float)choice_error_of(c, x, light, &choice->noise[x]);
}

static struct error *judge_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct judging *j = context;
    const size_t count = j->choice->candidates,
                 end = (block + 1) * BLOCK < count ? (block + 1) * BLOCK : count;
    for (size_t x = block * BLOCK; x < end; x++)
        judge(j->choice, j->before, x);
    return interrupt_error();
}

static struct error *for_blocks(const struct choice *choice, threads_body *body, void *context)
{
    return threads_for(choice->world.job->threads, (choice->candidates + BLOCK - 1) / BLOCK, body,
                       context);
}

static struct error *sort_by_cell(struct choice *choice)
{
    const size_t count = choice->candidates, cells = choice->mesh.cell_count;
    struct error *err = array_create(&choice->first, cells + 2, sizeof *choice->first);
    if (!err)
        err = array_create(&choice->at, count, sizeof *choice->at);
    if (err)
        return err;
    for (size_t i = 0; i < count; i++)
        choice->first[choice->blend[i].cell + 2]++;
    for (size_t i = 0; i < cells; i++)
        choice->first[i + 2] += choice->first[i + 1];
    for (size_t i = 0; i < count; i++)
        choice->at[choice->first[choice->blend[i].cell + 1]++] = (uint32_t)i;
    return NULL;
}

/* Adds the squares in a cell to a sum, `times` each. */
static void add_cell(const struct choice *choice, const float *square, int32_t cell, double times,
                     double *sum, double *count)
{
    for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++)
        if (choice_counts(choice, choice->at[k])) {
            *sum += times * (double)square[choice->at[k]];
            *count += times;
        }
}

/* The root of the mean square in a cell and, with less weight, in those beside it: what errors are
 * there without their noise, about. */
static double smooth_error(const struct choice *choice, const float *square, int32_t cell)
{
    double sum = 0, count = 0;
    add_cell(choice, square, cell, 2, &sum, &count);
    for (size_t k = 0; k < 4; k++) {
        const int32_t next = choice->cells.neighbour[4 * (size_t)cell + k];
        if (next >= 0)
            add_cell(choice, square, next, 1, &sum, &count);
    }
    return count > 0 ? sqrt(fmax(sum / count, 0)) : 0;
}

/* The mean error of the judges, by their squares and what is as noisy as those. */
static struct error *find_mean_of_judges(const struct choice *choice, const float *square,
                                         const float *noise, const float *smooth,
                                         struct choice_errors *errors)
{
    const struct candidates *c = choice->world.candidates;
    struct noisy_square *judge = NULL;
    size_t judges = 0;
    struct error *err = array_create(&judge, c->judges, sizeof *judge);
    for (size_t x = 0; x < choice->candidates && !err; x++)
        if (c->kind[x] == CANDIDATE_JUDGE)
            judge[judges++] = (struct noisy_square){.about = (double)smooth[choice->blend[x].cell],
                                                    .number = (uint32_t)x,
                                                    .square = (double)square[x],
                                                    .noise = (double)noise[x]};
    if (!err)
        mean_error(judges, judge, &errors->judges, &errors->doubt);
    free(judge);
    return err;
}

struct error *choice_least_error(const struct choice *choice, double *error)
{
    const struct candidates *c = choice->world.candidates;
    struct noisy_square *judge = NULL;
    size_t judges = 0;
    double doubt;
    struct error *err = array_create(&judge, c->judges, sizeof *judge);
    for (size_t x = 0; x < choice->candidates && !err; x++) {
        const uint32_t from = (uint32_t)x;
        double light[2][SPHERE_COUNT];
        float noise = 0;
        if (c->kind[x] != CANDIDATE_JUDGE)
            continue;
        choice_blend(c, 1, &from, (const double[]){1}, light);
        const double square = choice_square(choice_error_of(c, x, light, &noise));
        judge[judges++] = (struct noisy_square){0, from, square, (double)noise};
    }
    if (!err)
        mean_error(judges, judge, error, &doubt);
    free(judge);
    return err;
}

/* The mean errors by the squares of all candidates, and what is as noisy as those. smooth: of each
 * cell, out. */
static struct error *find_means(const struct choice *choice, const float *square,
                                const float *noise, float *smooth, struct choice_errors *errors)
{
    double sum = 0, count = 0;
    for (size_t cell = 0; cell < choice->mesh.cell_count; cell++) {
        const double e = smooth_error(choice, square, (int32_t)cell);
        smooth[cell] = (float)e;
        for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++) {
            const bool counts = choice_counts(choice, choice->at[k]);
            sum += counts ? e : 0;
            count += counts;
        }
    }
    errors->space = count > 0 ? sum / count : 0;
    return find_mean_of_judges(choice, square, noise, smooth, errors);
}

/* And the weights 1 / (2 e) that make changes of squares those of errors. */
static struct error *find_weights(struct choice *choice)
{
    float *square = NULL, *smooth = NULL;
    struct error *err = array_create(&square, choice->candidates, sizeof *square);
    if (!err)
        err = array_create(&smooth, choice->mesh.cell_count, sizeof *smooth);
    for (size_t x = 0; x < choice->candidates && !err; x++)
        square[x] = (float)choice_square((double)choice->error[x]);
    if (!err)
        err = find_means(choice, square, choice->noise, smooth, &choice->errors);
    for (size_t x = 0; x < choice->candidates && !err; x++)
        choice->weight[x] = (float)(0.5 / fmax((double)smooth[choice->blend[x].cell], LEAST));
    free(square);
    free(smooth);
    return err;
}

static struct error *make_room(struct choice *choice)
{
    const size_t all = choice->candidates;
    struct error *err = array_create(&choice->probe, choice->count, sizeof *choice->probe);
    if (!err)
        err = array_create(&choice->chosen, all, sizeof *choice->chosen);
    if (!err)
        err = array_create(&choice->blend, all, sizeof *choice->blend);
    if (!err)
        err = array_create(&choice->error, all, sizeof *choice->error);
    if (!err)
        err = array_create(&choice->noise, all, sizeof *choice->noise);
    if (!err)
        err = array_create(&choice->weight, all, sizeof *choice->weight);
    return error_wrap(err, "%zu points to choose probes from", all);
}

struct error *choice_init(struct choice *choice, const struct choice_world *world, size_t count,
                          const uint32_t *probe, const struct choice *before)
{
    *choice = (struct choice){.world = *world,
                              .tracer = world->job->path->tracer,
                              .count = count,
                              .candidates = world->candidates->count};
    struct error *err = make_room(choice);
    if (!err)
        err = seen_reserve(world->seen, choice->candidates);
    if (!err)
        err = candidates_refine(world->candidates, world->job, count, probe);
    for (size_t i = 0; i < count && !err; i++) {
        choice->probe[i] = probe[i];
        choice->chosen[probe[i]] = true;
    }
    if (!err)
        err = interrupt_error();
    if (!err)
        err = make_volume(choice);
    if (!err)
        err = for_blocks(choice, judge_block, &(struct judging){choice, before});
    if (!err)
        err = sort_by_cell(choice);
    if (!err)
        err = find_weights(choice);
    if (err)
        choice_clear(choice);
    return err;
}

void choice_clear(struct choice *choice)
{
    probe_volume_destroy(choice->volume);
    stream_destroy(choice->stream);
    free(choice->probe);
    free(choice->chosen);
    free(choice->blend);
    free(choice->error);
    free(choice->noise);
    free(choice->weight);
    free(choice->first);
    free(choice->at);
    *choice = (struct choice){0};
}

/* -- what will be seen ------------------------------------------------------------------------ */

struct looking {
    const struct choice *choice;
    bool *cell;            /* judges are in it: its sight is known */
    float *square, *noise; /* of each candidate */
};

static struct error *look_at_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct looking *l = context;
    const struct candidates *c = l->choice->world.candidates;
    const size_t count = l->choice->candidates,
                 end = (block + 1) * BLOCK < count ? (block + 1) * BLOCK : count;
    for (size_t x = block * BLOCK; x < end; x++) {
        double light[2][SPHERE_COUNT];
        if (!l->cell[l->choice->blend[x].cell]) {
            l->square[x] = (float)choice_square((double)l->choice->error[x]);
            l->noise[x] = l->choice->noise[x];
            continue;
        }
        const struct blend blend = locate(l->choice, x);
        choice_blend(c, 4, blend.from, blend.weight, light);
        l->square[x] = (float)choice_square(choice_error_of(c, x, light, &l->noise[x]));
    }
    return interrupt_error();
}

struct error *choice_look(const struct choice *choice, struct choice_errors *errors, float *square)
{
    struct sights sights = {0};
    struct looking l = {.choice = choice, .square = square};
    float *smooth = NULL;
    size_t row = 0;
    struct error *err = array_create(&l.noise, choice->candidates, sizeof *l.noise);
    if (!err)
        err = array_create(&l.cell, choice->mesh.cell_count, sizeof *l.cell);
    for (size_t x = 0; x < choice->candidates && !err; x++)
        if (choice->world.candidates->kind[x] == CANDIDATE_JUDGE)
            l.cell[choice->blend[x].cell] = true;
    if (!err)
        err = sight_find_some(&sights, choice->tracer, &choice->mesh, l.cell,
                              choice->world.job->threads);
    if (!err) {
        enum probe_status status =
            probe_volume_set_sight(choice->volume, sights.sight, sights.stand_in, &row);
        if (!status)
            status = probe_volume_set_sight_outside(choice->volume, sights.outside,
                                                    sights.stand_in_outside, &row);
        err = cells_volume_error(status, row);
    }
    if (!err)
        err = for_blocks(choice, look_at_block, &l);
    probe_volume_set_sight(choice->volume, NULL, NULL, &row);
    if (!err)
        err = array_create(&smooth, choice->mesh.cell_count, sizeof *smooth);
    if (!err)
        err = find_means(choice, square, l.noise, smooth, errors);
    sights_clear(&sights);
    free(l.cell);
    free(l.noise);
    free(smooth);
    return err;
}

enum { OUTSIDE_BYTES = 56 }; /* man libprobe-query */

/* Packed files hold as many numbers of sight, whatever they are. */
static struct error *set_open_sight(const struct choice *choice)
{
    const size_t cells = choice->mesh.cell_count;
    float *sight = NULL;
    int32_t *stand_in = NULL;
    size_t row = 0;
    struct error *err = array_create(&sight, (size_t)sight_width(4) * cells, sizeof *sight);
    if (!err)
        err = array_create(&stand_in, cells, sizeof *stand_in);
    for (size_t i = 0; i < cells && !err; i++)
        stand_in[i] = -1;
    if (!err)
        err =
            cells_volume_error(probe_volume_set_sight(choice->volume, sight, stand_in, &row), row);
    free(sight);
    free(stand_in);
    return err;
}

size_t choice_bytes(const struct choice *choice, int order)
{
    float *sh = NULL;
    if (order > SH_ORDER_MAX)
        return 0;
    struct error *err = array_create(&sh, 3 * choice->count * (size_t)(order * order), sizeof *sh);
    if (!err)
        err = set_open_sight(choice);
    size_t bytes = err ? 0
                       : probe_volume_pack(choice->volume, order, sh, 0, PROBE_PACK_FLOAT, NULL, 0);
    for (size_t i = 0; bytes && i < choice->mesh.cell_count; i++)
        for (int k = 0; k < 4; k++) /* something may stand beyond each cell of the hull */
            if (choice->mesh.neighbour[4 * i + (size_t)k] < 0) {
                bytes += OUTSIDE_BYTES;
                break;
            }
    probe_volume_set_sight(choice->volume, NULL, NULL, NULL);
    error_destroy(err);
    free(sh);
    return bytes;
}
