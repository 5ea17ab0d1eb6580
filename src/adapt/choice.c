/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/choice.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/cells_volume.h"
#include "leak/cells_make.h"
#include "leak/leak_mend.h"
#include "libprobe-query/sh.h"
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

double choice_error_of(const struct candidates *c, size_t candidate, double light[2][SPHERE_COUNT])
{
    const struct candidate_light *of = &c->light[candidate];
    double mean[SPHERE_COUNT], truth[SPHERE_COUNT], noise[SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double t[2] = {(double)of->truth[0][d], (double)of->truth[1][d]},
                     y = (light[0][d] - t[0] - light[1][d] + t[1]) / 2;
        mean[d] = (light[0][d] + light[1][d]) / 2;
        truth[d] = (t[0] + t[1]) / 2;
        noise[d] = y * y;
    }
    return ruler_error(mean, truth, noise, c->floor);
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
    size_t row = 0;
    struct error *err = make_stream(choice);
    if (!err)
        err = cells_volume_mesh(choice->stream, &choice->cells);
    if (!err && choice->cells.corners != 4)
        err = error_new("the free space is flat: probes that light is blended of need one that is "
                        "not");
    if (!err)
        err = leak_mesh_of(choice->stream, &choice->mesh);
    if (!err)
        err = sight_find(&choice->sights, choice->world.job->path->tracer, &choice->mesh,
                         choice->world.job->threads);
    if (!err)
        err = stars_init(&choice->stars, &choice->mesh);
    if (!err)
        err = cells_volume_create(&choice->cells, 0, &choice->volume);
    if (!err) {
        enum probe_status status = probe_volume_set_sight(choice->volume, choice->sights.sight,
                                                          choice->sights.stand_in, &row);
        if (!status)
            status = probe_volume_set_sight_outside(choice->volume, choice->sights.outside,
                                                    choice->sights.stand_in_outside, &row);
        err = cells_volume_error(status, row);
    }
    return err;
}

/* -- candidates in it ------------------------------------------------------------------------- */

static struct error *judge_block(void *context, size_t block, int thread)
{
    (void)thread;
    struct choice *choice = context;
    const struct candidates *c = choice->world.candidates;
    const size_t end = (block + 1) * BLOCK < c->count ? (block + 1) * BLOCK : c->count;
    for (size_t i = block * BLOCK; i < end; i++) {
        struct probe_place *place = &choice->place[i];
        double light[2][SPHERE_COUNT];
        uint32_t from[4];
        *place = (struct probe_place){.cell = PROBE_COLD};
        probe_volume_locate(choice->volume, c->position + 3 * i, place);
        for (int k = 0; k < 4; k++)
            from[k] = choice->probe[place->probe[k]];
        choice_blend(c, 4, from, place->weight, light);
        choice->error[i] = (float)choice_error_of(c, i, light);
    }
    return NULL;
}

static struct error *sort_by_cell(struct choice *choice)
{
    const size_t count = choice->world.candidates->count, cells = choice->mesh.cell_count;
    struct error *err = array_create(&choice->first, cells + 2, sizeof *choice->first);
    if (!err)
        err = array_create(&choice->at, count, sizeof *choice->at);
    if (err)
        return err;
    for (size_t i = 0; i < count; i++)
        choice->first[choice->place[i].cell + 2]++;
    for (size_t i = 0; i < cells; i++)
        choice->first[i + 2] += choice->first[i + 1];
    for (size_t i = 0; i < count; i++)
        choice->at[choice->first[choice->place[i].cell + 1]++] = (uint32_t)i;
    return NULL;
}

/* Adds the squares in a cell to a sum, `times` each. */
static void add_cell(const struct choice *choice, int32_t cell, double times, double *sum,
                     double *count)
{
    for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++)
        if (choice_counts(choice, choice->at[k])) {
            *sum += times * choice_square((double)choice->error[choice->at[k]]);
            *count += times;
        }
}

/* The root of the mean square in a cell and, with less weight, in those beside it: what errors are
 * there without their noise, about. */
static double smooth_error(const struct choice *choice, int32_t cell)
{
    double sum = 0, count = 0;
    add_cell(choice, cell, 2, &sum, &count);
    for (size_t k = 0; k < 4; k++) {
        const int32_t next = choice->cells.neighbour[4 * (size_t)cell + k];
        if (next >= 0)
            add_cell(choice, next, 1, &sum, &count);
    }
    return count > 0 ? sqrt(fmax(sum / count, 0)) : 0;
}

/* The weights 1 / (2 e) that make changes of squares those of errors. */
static void find_weights(struct choice *choice)
{
    double sum = 0, count = 0;
    for (size_t cell = 0; cell < choice->mesh.cell_count; cell++) {
        const double e = smooth_error(choice, (int32_t)cell);
        for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++) {
            const uint32_t x = choice->at[k];
            choice->weight[x] = (float)(0.5 / fmax(e, LEAST));
            sum += choice_counts(choice, x) ? e : 0;
            count += choice_counts(choice, x);
        }
    }
    choice->error_of_space = count > 0 ? sum / count : 0;
}

static void find_means(struct choice *choice)
{
    const struct candidates *c = choice->world.candidates;
    double sum = 0, square = 0, n = 0;
    for (size_t i = 0; i < c->count; i++) {
        const double e = (double)choice->error[i];
        if (c->kind[i] != CANDIDATE_JUDGE)
            continue;
        n++;
        sum += e;
        square += e * e;
    }
    choice->error_of_judges = n > 0 ? sum / n : 0;
    choice->judges_doubt = n > 1 ? sqrt(fmax(square / n - sum / n * (sum / n), 0) / (n - 1)) : 0;
}

struct error *choice_init(struct choice *choice, const struct choice_world *world, size_t count,
                          const uint32_t *probe)
{
    const size_t all = world->candidates->count;
    *choice = (struct choice){.world = *world, .count = count};
    struct error *err = array_create(&choice->probe, count, sizeof *choice->probe);
    if (!err)
        err = array_create(&choice->chosen, all, sizeof *choice->chosen);
    if (!err)
        err = array_create(&choice->place, all, sizeof *choice->place);
    if (!err)
        err = array_create(&choice->error, all, sizeof *choice->error);
    if (!err)
        err = array_create(&choice->weight, all, sizeof *choice->weight);
    if (!err)
        err = candidates_refine(world->candidates, world->job, count, probe);
    for (size_t i = 0; i < count && !err; i++) {
        choice->probe[i] = probe[i];
        choice->chosen[probe[i]] = true;
    }
    if (!err)
        err = make_volume(choice);
    if (!err)
        err = threads_for(world->job->threads, (all + BLOCK - 1) / BLOCK, judge_block, choice);
    if (!err)
        err = sort_by_cell(choice);
    if (err) {
        choice_clear(choice);
        return err;
    }
    find_weights(choice);
    find_means(choice);
    return NULL;
}

void choice_clear(struct choice *choice)
{
    probe_volume_destroy(choice->volume);
    stars_clear(&choice->stars);
    sights_clear(&choice->sights);
    stream_destroy(choice->stream);
    free(choice->probe);
    free(choice->chosen);
    free(choice->place);
    free(choice->error);
    free(choice->weight);
    free(choice->first);
    free(choice->at);
    *choice = (struct choice){0};
}

size_t choice_bytes(const struct choice *choice, int order)
{
    float *sh = NULL;
    if (order > SH_ORDER_MAX)
        return 0;
    struct error *err = array_create(&sh, 3 * choice->count * (size_t)(order * order), sizeof *sh);
    const size_t bytes =
        err ? 0 : probe_volume_pack(choice->volume, order, sh, 0, PROBE_PACK_FLOAT, NULL, 0);
    error_destroy(err);
    free(sh);
    return bytes;
}
