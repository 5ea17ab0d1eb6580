/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/unseen.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/baked.h"
#include "math/luminance.h"
#include "math/random.h"
#include "math/vec.h"
#include "measure/report.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "trace/seen.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FOR_CELL ((uint64_t)1 << 48) /* what random numbers are for: part of their name */

/* -- one point -------------------------------------------------------------------------------- */

/* Adds the luminance of a probe's coefficients times a factor. */
static void add_probe(const struct baked *baked, int32_t probe, double factor, double *luminance)
{
    const float *c = baked->sh + baked->width * (size_t)probe;
    for (int i = 0; i < baked->order * baked->order; i++)
        luminance[i] += factor * luminance_f32(c + 3 * i);
}

void unseen_of(const struct baked *baked, const struct sphere_basis *basis,
               const struct probe_place *at, const struct seen_look *look, struct unseen *unseen)
{
    double leak[SH_COUNT_MAX] = {0};
    *unseen = (struct unseen){.weight = look->unseen, .blind = look->blind};
    for (int i = 0; i < 4; i++) {
        if (!(at->weight[i] > 0))
            continue;
        const double bright = at->weight[i] * baked_brightness(baked, at->probe[i]);
        unseen->light += (1 - look->visible[i]) * bright;
        unseen->bright += bright;
    }
    if (unseen->blind || !(unseen->weight > 0))
        return;
    for (int i = 0; i < 4; i++)
        if (at->weight[i] > 0)
            add_probe(baked, at->probe[i], at->weight[i] * (1 - look->visible[i] / look->share),
                      leak);
    sphere_irradiance(basis, leak, 1, unseen->leak);
}

/* -- cells ------------------------------------------------------------------------------------ */

/* What is kept of a sample. */
struct sample {
    float weight, light, bright, leak_square, leak_mean;
    bool blind, free;
};

struct job {
    const struct tracer *tracer;
    const struct baked *baked;
    struct sphere_basis basis;
    int samples;
    uint64_t seed;
    struct sample *sample; /* samples of each cell */
};

static struct vec3 corner(const struct baked *b, size_t cell, size_t i)
{
    return vec3_load(b->position + 3 * (size_t)b->mesh.vertex[4 * cell + i]);
}

/* The i-th point of a cell: evenly spread, by the gaps between three sorted numbers (Devroye,
 * "Non-uniform random variate generation", 1986, ch. V, theorem 2.1). */
static void point_in_cell(const struct job *job, size_t cell, int i, double p[3])
{
    struct random r = random_start(job->seed, FOR_CELL | cell, (uint32_t)i);
    double x[5] = {0, random_double(&r), random_double(&r), random_double(&r), 1};
    for (int a = 1; a < 3; a++) {
        for (int b = a + 1; b < 4; b++) {
            if (x[b] < x[a]) {
                const double swap = x[a];
                x[a] = x[b];
                x[b] = swap;
            }
        }
    }
    struct vec3 sum = {0};
    for (size_t k = 0; k < 4; k++)
        sum = vec3_fma(sum, x[k + 1] - x[k], corner(job->baked, cell, k));
    vec3_store(p, sum);
}

static struct error *look_from_cell(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    for (int i = 0; i < job->samples; i++) {
        struct sample *s = &job->sample[cell * (size_t)job->samples + (size_t)i];
        double p[3];
        struct probe_place at = {.cell = (int32_t)cell};
        struct seen_look look;
        struct unseen u;
        point_in_cell(job, cell, i, p);
        baked_locate(job->baked, p, &at);
        seen_look(job->tracer, job->baked->position, p, &at, &look);
        unseen_of(job->baked, &job->basis, &at, &look, &u);
        double square[SPHERE_COUNT];
        for (int d = 0; d < SPHERE_COUNT; d++)
            square[d] = u.leak[d] * u.leak[d];
        *s = (struct sample){.weight = (float)u.weight,
                             .light = (float)u.light,
                             .bright = (float)u.bright,
                             .leak_square = (float)sphere_mean(square),
                             .leak_mean = (float)sphere_mean(u.leak),
                             .blind = u.blind,
                             .free = !u.blind};
    }
    return NULL;
}

/* Finds out which of the blind points are free. As many that see are asked with them: place_inside
 * judges the scene's faces by what all see. */
static struct error *judge_blind(const struct job *job, size_t count, int threads)
{
    struct place place = {0};
    size_t *index = NULL, blind = 0, asked = 0;
    enum place_side *side = NULL;
    struct place_inside_settings settings = place_inside_default();
    settings.threads = threads;
    for (size_t i = 0; i < count; i++)
        blind += job->sample[i].blind;
    if (!blind)
        return NULL;
    const size_t room = 2 * blind < count ? 2 * blind : count;
    struct error *err = array_create(&index, room, sizeof *index);
    if (!err)
        err = array_create(&place.position, 3 * room, sizeof *place.position);
    if (!err)
        err = array_create(&side, room, sizeof *side);
    for (int turn = 0; turn < 2 && !err; turn++)
        for (size_t i = 0; i < count && asked < room; i++)
            if (job->sample[i].blind == (turn == 0))
                index[asked++] = i;
    for (size_t k = 0; k < asked && !err; k++)
        point_in_cell(job, index[k] / (size_t)job->samples, (int)(index[k] % (size_t)job->samples),
                      place.position + 3 * k);
    place.count = asked;
    if (!err)
        err = place_inside(&place, job->tracer, &settings, side, NULL);
    for (size_t k = 0; k < blind && !err; k++)
        job->sample[index[k]].free = side[k] == PLACE_AIR;
    free(index);
    free(side);
    place_clear(&place);
    return err;
}

static double volume_of(const struct baked *b, size_t cell)
{
    const struct vec3 p = corner(b, cell, 0);
    return fabs(vec3_dot(
               vec3_sub(corner(b, cell, 1), p),
               vec3_cross(vec3_sub(corner(b, cell, 2), p), vec3_sub(corner(b, cell, 3), p)))) /
           6;
}

/* The ratio of two means over free space, by volume, with its interval. which: 0 weight over 1, 1
 * light over bright. */
static struct estimate ratio(const struct job *job, int which)
{
    const size_t n = (size_t)job->samples;
    double above = 0, below = 0, variance = 0;
    for (int turn = 0; turn < 2; turn++) { /* the ratio, then the spread about it */
        const double r = turn && below > 0 ? above / below : 0;
        for (size_t cell = 0; cell < job->baked->mesh.cells; cell++) {
            const double volume = volume_of(job->baked, cell);
            double sum = 0, square = 0;
            for (size_t i = 0; i < n; i++) {
                const struct sample *s = &job->sample[cell * n + i];
                const double y = !s->free ? 0 : which ? (double)s->light : (double)s->weight;
                const double x = !s->free ? 0 : which ? (double)s->bright : 1;
                sum += y - r * x;
                square += (y - r * x) * (y - r * x);
                above += turn ? 0 : volume * y / (double)n;
                below += turn ? 0 : volume * x / (double)n;
            }
            if (turn)
                variance += volume * volume * fmax(square - sum * sum / (double)n, 0) /
                            (double)(n - 1) / (double)n;
        }
    }
    const double value = below > 0 ? above / below : 0,
                 error = below > 0 ? sqrt(variance) / below : 0;
    return (struct estimate){.value = value,
                             .low = fmax(value - 1.96 * error, 0),
                             .high = fmin(value + 1.96 * error, 1)};
}

static void sum_up(const struct job *job, struct unseen_cells *cells)
{
    double all = 0, blind = 0, open = 0, square = 0, mean = 0;
    cells->weight = ratio(job, 0);
    cells->light = ratio(job, 1);
    for (size_t cell = 0; cell < job->baked->mesh.cells; cell++) {
        const double part = volume_of(job->baked, cell) / job->samples;
        double weight = 0, leak = 0;
        int free = 0, seeing = 0;
        for (int i = 0; i < job->samples; i++) {
            const struct sample *s = &job->sample[cell * (size_t)job->samples + (size_t)i];
            if (!s->free)
                continue;
            free++;
            seeing += !s->blind;
            weight += (double)s->weight;
            leak += (double)s->leak_square;
            *(s->blind ? &blind : &open) += part;
            square += part * (double)s->leak_square;
            mean += part * (double)s->leak_mean;
        }
        all += free * part;
        cells->cell_weight[cell] = free ? (float)(weight / free) : 0;
        cells->cell_leak[cell] = seeing ? (float)sqrt(leak / seeing) : 0;
        cells->cell_free[cell] = (float)free / (float)job->samples;
        if (cells->cell_weight[cell] > cells->cell_weight[cells->worst_cell])
            cells->worst_cell = cell;
    }
    cells->free_volume = all;
    cells->blind = all > 0 ? blind / all : 0;
    cells->leaked_rms = open > 0 ? sqrt(square / open) : 0;
    cells->leaked_bias = open > 0 ? mean / open : 0;
}

/* unseen_of reads every probe of a cell. */
static struct error *check_light(const struct baked *b)
{
    for (size_t i = 0; i < 4 * b->mesh.cells; i++)
        if (isnan(b->sh[b->width * (size_t)b->mesh.vertex[i]]))
            return error_new("probe %d has no light: run probe-capture", b->mesh.vertex[i]);
    return NULL;
}

struct error *unseen_cells(struct unseen_cells *cells, const struct tracer *tracer,
                           const struct baked *baked, int samples, uint64_t seed, int threads)
{
    struct job job = {.tracer = tracer,
                      .baked = baked,
                      .samples = samples,
                      .seed = seed,
                      .basis = sphere_basis_make(baked->order, baked->convolved)};
    *cells = (struct unseen_cells){0};
    struct error *err = baked->mesh.corners == 4
                            ? check_light(baked)
                            : error_new("leaks are measured of tetrahedra alone");
    if (!err)
        err = array_create(&job.sample, baked->mesh.cells * (size_t)samples, sizeof *job.sample);
    if (!err)
        err = array_create(&cells->cell_weight, baked->mesh.cells, sizeof *cells->cell_weight);
    if (!err)
        err = array_create(&cells->cell_leak, baked->mesh.cells, sizeof *cells->cell_leak);
    if (!err)
        err = array_create(&cells->cell_free, baked->mesh.cells, sizeof *cells->cell_free);
    if (!err)
        err = threads_for(threads, baked->mesh.cells, look_from_cell, &job);
    if (!err)
        err = judge_blind(&job, baked->mesh.cells * (size_t)samples, threads);
    if (!err)
        sum_up(&job, cells);
    free(job.sample);
    if (err)
        unseen_cells_clear(cells);
    return err;
}

void unseen_cells_clear(struct unseen_cells *cells)
{
    free(cells->cell_weight);
    free(cells->cell_leak);
    free(cells->cell_free);
    *cells = (struct unseen_cells){0};
}

/* -- report ----------------------------------------------------------------------------------- */

struct error *unseen_report(struct report *report, const struct unseen_cells *cells, size_t count)
{
    const double mean = report_get(report, "irradiance", "all").value;
    struct error *err = report_add_number(report, "cells", "all", (double)count);
    if (!err)
        err = report_add_number(report, "free_volume", "all", cells->free_volume);
    if (!err)
        err = report_add(report, "leak_volume", "all", cells->weight);
    if (!err)
        err = report_add(report, "leak_light", "all", cells->light);
    if (!err)
        err = report_add_number(report, "leaked_rms", "all", cells->leaked_rms);
    if (!err)
        err = report_add_number(report, "leaked_bias", "all", cells->leaked_bias);
    if (!err && mean > 0)
        err = report_add_number(report, "leaked_rms_relative", "all", cells->leaked_rms / mean);
    if (!err && mean > 0)
        err = report_add_number(report, "leaked_bias_relative", "all", cells->leaked_bias / mean);
    if (!err)
        err = report_add_number(report, "blind", "all", cells->blind);
    if (!err)
        err = report_add_number(report, "leak_worst_cell", "all", (double)cells->worst_cell);
    if (!err)
        err = report_add_number(report, "leak_worst", "all",
                                (double)cells->cell_weight[cells->worst_cell]);
    return err;
}
