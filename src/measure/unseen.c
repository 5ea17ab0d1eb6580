/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/unseen.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/baked.h"
#include "math/luminance.h"
#include "math/random.h"
#include "math/sort.h"
#include "math/vec.h"
#include "measure/narrow.h"
#include "measure/ratio.h"
#include "measure/report.h"
#include "place/place_inside.h"
#include "trace/seen.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FOR_CELL = 0x43454c4c }; /* what random numbers are for: part of their name */

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

/* -- points of cells -------------------------------------------------------------------------- */

/* Of all of a cell's probes, as it is; cells and, if they have fewer, points at a time. */
enum { BLENDS = 2, BLOCK = 4096, SAMPLES = 1 << 20 };

/* What is kept of a point. */
struct sample {
    double position[3];
    struct {
        float weight, light, bright, leak_square, leak_mean;
        bool blind;
    } of[BLENDS];
    bool free, lost;
};

struct job {
    const struct tracer *tracer;
    const struct baked *baked;
    const struct unseen_settings *settings;
    struct sphere_basis basis;
    bool lit, sees;
    double *size;                     /* by cell: volume, area or length */
    bool *near;                       /* a surface may be in it */
    double density;                   /* points a size where it is near */
    struct seen *seen;                /* owned; NULL: not needed yet */
    struct place_judge **judge, *own; /* own: owned; where there is no other */
    /* of the block: */
    size_t begin, end;
    size_t *first; /* of each cell's samples; one more than there are cells */
    struct sample *sample;
    size_t room;
    size_t *asked; /* samples that see nothing of their cell */
    size_t asked_count, asked_room;
};

static struct vec3 corner(const struct baked *b, size_t cell, size_t i)
{
    return vec3_load(b->position + 3 * (size_t)b->mesh.vertex[(size_t)b->mesh.corners * cell + i]);
}

static double size_of(const struct baked *b, size_t cell)
{
    const struct vec3 p = corner(b, cell, 0), x = vec3_sub(corner(b, cell, 1), p);
    if (b->mesh.corners == 2)
        return vec3_length(x);
    const struct vec3 area = vec3_cross(x, vec3_sub(corner(b, cell, 2), p));
    if (b->mesh.corners == 3)
        return vec3_length(area) / 2;
    return fabs(vec3_dot(area, vec3_sub(corner(b, cell, 3), p))) / 6;
}

static struct error *measure_distance(void *context, size_t probe, int thread)
{
    (void)thread;
    const struct job *job = context;
    job->size[probe] = trace_distance(job->tracer, job->baked->position + 3 * probe);
    return NULL;
}

/* A surface may be in the cells that no corner sees past. */
static bool is_near(const struct baked *b, size_t cell, const double *distance)
{
    const size_t n = (size_t)b->mesh.corners;
    for (size_t i = 0; i < n; i++) {
        double far = 0;
        for (size_t j = 0; j < n; j++)
            far = fmax(far, vec3_length(vec3_sub(corner(b, cell, j), corner(b, cell, i))));
        if (distance[b->mesh.vertex[n * cell + i]] > (1 + 1e-3) * far)
            return false;
    }
    return true;
}

static struct error *find_near(struct job *job, struct unseen_cells *cells)
{
    const struct baked *b = job->baked;
    double *distance = NULL, sum = 0;
    struct error *err = array_create(&distance, b->probe_count, sizeof *distance);
    job->size = distance;
    if (!err)
        err = threads_for(job->settings->threads, b->probe_count, measure_distance, job);
    job->size = NULL;
    if (!err)
        err = array_create(&job->near, b->mesh.cells, sizeof *job->near);
    if (!err)
        err = array_create(&job->size, b->mesh.cells, sizeof *job->size);
    for (size_t i = 0; i < b->mesh.cells && !err; i++) {
        job->size[i] = size_of(b, i);
        job->near[i] = is_near(b, i, distance);
        cells->near += job->near[i];
        sum += job->near[i] ? job->size[i] : 0;
    }
    job->density = sum > 0 ? job->settings->points / sum : 0;
    free(distance);
    return err;
}

static size_t count_of(const struct job *job, size_t cell)
{
    const double share = job->near[cell] ? ceil(job->density * job->size[cell]) : 0;
    return (size_t)fmax(share, job->settings->least);
}

/* Where a cell's points start: random by where its corners are, so that a cell that stays among
 * others that are made anew keeps its points. */
static void start_of(const struct job *job, size_t cell, double start[3])
{
    const struct baked *b = job->baked;
    const size_t n = (size_t)b->mesh.corners;
    uint64_t name = 0;
    for (size_t k = 0; k < n; k++)
        name += random_hash_position(b->position + 3 * (size_t)b->mesh.vertex[n * cell + k]);
    struct random r = random_start(job->settings->seed, name, FOR_CELL);
    for (int k = 0; k < 3; k++)
        start[k] = random_double(&r);
}

/* The i-th point of a cell: evenly spread, by the gaps between sorted numbers (Devroye,
 * "Non-uniform random variate generation", 1986, ch. V, theorem 2.1). */
static struct vec3 point_in_cell(const struct job *job, size_t cell, const double start[3],
                                 size_t i, double u[4])
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    const size_t n = (size_t)job->baked->mesh.corners;
    double x[5] = {0};
    for (size_t k = 1; k < n; k++) {
        const double y = start[k - 1] + (double)i * step[k - 1];
        x[k] = y - floor(y);
    }
    x[n] = 1;
    sort_doubles(n - 1, x + 1);
    struct vec3 p = {0};
    for (size_t k = 0; k < 4; k++) {
        u[k] = k < n ? x[k + 1] - x[k] : 0;
        if (k < n)
            p = vec3_fma(p, u[k], corner(job->baked, cell, k));
    }
    return p;
}

static void keep_blend(const struct job *job, const struct probe_place *at,
                       const struct seen_look *look, struct sample *s, int blend)
{
    struct unseen u = {.weight = look->unseen, .blind = look->blind};
    double square[SPHERE_COUNT];
    if (job->lit)
        unseen_of(job->baked, &job->basis, at, look, &u);
    for (int d = 0; d < SPHERE_COUNT; d++)
        square[d] = u.leak[d] * u.leak[d];
    s->of[blend].weight = (float)u.weight;
    s->of[blend].light = (float)u.light;
    s->of[blend].bright = (float)u.bright;
    s->of[blend].leak_square = u.weight > 0 ? (float)sphere_mean(square) : 0;
    s->of[blend].leak_mean = u.weight > 0 ? (float)sphere_mean(u.leak) : 0;
    s->of[blend].blind = u.blind;
}

/* Where no surface is near, what is blended is seen, if it is the cell's. */
static void take_for_seen(const struct probe_place *at, struct seen_look *look)
{
    *look = (struct seen_look){.share = 1};
    for (int k = 0; k < 4; k++)
        look->visible[k] = at->weight[k] > 0;
}

static struct error *look_from_cell(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    const struct baked *b = job->baked;
    const size_t cell = job->begin + index;
    double start[3];
    start_of(job, cell, start);
    for (size_t i = job->first[index]; i < job->first[index + 1]; i++) {
        struct sample *s = &job->sample[i];
        struct probe_place at = {.cell = (int32_t)cell};
        struct seen_look all, now;
        *s = (struct sample){0};
        vec3_store(s->position, point_in_cell(job, cell, start, i - job->first[index], at.weight));
        for (int k = 0; k < b->mesh.corners; k++)
            at.probe[k] = b->mesh.vertex[(size_t)b->mesh.corners * cell + (size_t)k];
        if (job->near[cell])
            seen_look(job->tracer, b->position, s->position, &at, &all);
        else
            take_for_seen(&at, &all);
        keep_blend(job, &at, &all, s, 0);
        s->of[1] = s->of[0];
        if (job->sees) {
            struct probe_place blend = {.cell = (int32_t)cell};
            baked_locate(b, s->position, &blend);
            seen_look_again(job->tracer, b->position, s->position, &at, &all, &blend, &now);
            keep_blend(job, &blend, &now, s, 1);
        }
        s->free = !s->of[0].blind || !s->of[1].blind;
    }
    return NULL;
}

/* A point that sees none of its cell: whether it is free, and sees any probe at all. A gap that no
 * probe sees is no free space. */
static struct error *judge_blind(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct sample *s = &job->sample[job->asked[index]];
    s->free = place_judge_side(*job->judge, s->position) == PLACE_AIR;
    s->lost = s->free && seen_nearest(job->seen, s->position) < 0;
    if (s->lost && is_narrow(job->tracer, s->position, UNSEEN_NARROW * seen_spacing(job->seen)))
        s->free = s->lost = false;
    return NULL;
}

/* What is needed where points see none of their cell. */
static struct error *make_judge(struct job *job)
{
    const struct baked *b = job->baked;
    struct error *err = NULL;
    if (!job->seen)
        err = seen_create(&job->seen, job->tracer, b->probe_count, b->position,
                          job->lit ? b->sh : NULL, b->width);
    return err ? err
               : place_judge_of(job->judge, job->tracer, b->probe_count, b->position,
                                job->settings->threads);
}

/* Looks from the points of the next cells. */
static struct error *look_from_block(struct job *job)
{
    const size_t count = job->end - job->begin;
    for (size_t i = 0; i < count; i++)
        job->first[i + 1] = job->first[i] + count_of(job, job->begin + i);
    struct error *err =
        array_reserve(&job->sample, &job->room, job->first[count], sizeof *job->sample);
    err = error_memory_for(err, "%.3g GB for %zu points of %zu cells (--points, --leak-samples)",
                           (double)(job->first[count] * sizeof *job->sample) / 1e9,
                           job->first[count], count);
    if (!err)
        err = threads_for(job->settings->threads, count, look_from_cell, job);
    job->asked_count = 0;
    for (size_t i = 0; i < job->first[count] && !err; i++) {
        if (job->sample[i].free)
            continue;
        err =
            array_reserve(&job->asked, &job->asked_room, job->asked_count + 1, sizeof *job->asked);
        if (!err)
            job->asked[job->asked_count++] = i;
    }
    if (!err && job->asked_count)
        err = make_judge(job);
    if (!err && job->asked_count)
        err = threads_for(job->settings->threads, job->asked_count, judge_blind, job);
    return err;
}

/* -- sums ------------------------------------------------------------------------------------- */

struct sums {
    struct ratio weight, light;
    double blind, open, square, mean, worst;
};

struct totals {
    double free, lost;
    struct sums of[BLENDS];
};

/* Adds a cell's points. */
static void add_cell(const struct job *job, size_t index, struct totals *totals,
                     struct unseen_cells *cells)
{
    const size_t cell = job->begin + index, first = job->first[index],
                 count = job->first[index + 1] - first;
    const double part = job->size[cell] / (double)count;
    size_t free = 0;
    for (size_t i = first; i < first + count; i++) {
        free += job->sample[i].free;
        totals->lost += job->sample[i].lost ? part : 0;
    }
    totals->free += part * (double)free;
    cells->cell_free[cell] = (float)free / (float)count;
    for (int k = 0; k < BLENDS; k++) {
        struct sums *sums = &totals->of[k];
        struct unseen_blend *blend = k ? &cells->now : &cells->all;
        struct stratum weight = {0}, light = {0};
        double leak = 0, open = 0;
        const struct sample *dark = NULL; /* that sees least */
        for (size_t i = first; i < first + count; i++) {
            const struct sample *s = &job->sample[i];
            stratum_add(&weight, s->free ? (double)s->of[k].weight : 0, s->free);
            stratum_add(&light, s->free ? (double)s->of[k].light : 0,
                        s->free ? (double)s->of[k].bright : 0);
            if (!s->free)
                continue;
            if (!dark || s->of[k].weight > dark->of[k].weight)
                dark = s;
            sums->blind += s->of[k].blind ? part : 0;
            open += s->of[k].blind ? 0 : 1;
            leak += (double)s->of[k].leak_square;
            sums->mean += part * (double)s->of[k].leak_mean;
        }
        sums->open += part * open;
        sums->square += part * leak;
        ratio_add(&sums->weight, &weight, count, job->size[cell], job->near[cell]);
        ratio_add(&sums->light, &light, count, job->size[cell], job->near[cell]);
        const double leaks = part * (job->lit ? light.y : weight.y);
        if (leaks > sums->worst) {
            sums->worst = leaks;
            blend->worst_cell = cell;
            blend->worst_share = weight.y / (double)free;
            memcpy(blend->worst_point, dark->position, sizeof blend->worst_point);
        }
        if (k) {
            cells->cell_weight[cell] = free ? (float)(weight.y / (double)free) : 0;
            cells->cell_leak[cell] = open > 0 ? (float)sqrt(leak / open) : 0;
        }
    }
}

/* Hands on the points of a cell that do not see all. */
static struct error *keep_cell(const struct job *job, size_t index)
{
    const size_t cell = job->begin + index, count = job->first[index + 1] - job->first[index];
    struct error *err = NULL;
    for (size_t i = job->first[index]; i < job->first[index + 1] && !err; i++) {
        const struct sample *s = &job->sample[i];
        if (!s->free || !(s->of[1].weight > 0))
            continue;
        struct unseen_point point = {.cell = cell,
                                     .volume = job->size[cell] / (double)count,
                                     .weight = (double)s->of[1].weight};
        memcpy(point.position, s->position, sizeof point.position);
        err = job->settings->keep(job->settings->context, &point);
    }
    return err;
}

static void sum_up(const struct job *job, const struct totals *totals, struct unseen_cells *cells)
{
    const struct estimate unknown = {(double)NAN, (double)NAN, (double)NAN};
    cells->free_volume = totals->free;
    cells->lost = totals->free > 0 ? totals->lost / totals->free : 0;
    cells->differ = job->sees;
    for (int k = 0; k < BLENDS; k++) {
        const struct sums *sums = &totals->of[k];
        struct unseen_blend *blend = k ? &cells->now : &cells->all;
        const double all = job->lit ? sums->light.above : sums->weight.above;
        blend->weight = ratio_estimate(&sums->weight);
        blend->light = job->lit ? ratio_estimate(&sums->light) : unknown;
        blend->blind = totals->free > 0 ? sums->blind / totals->free : 0;
        blend->leaked_rms = sums->open > 0 ? sqrt(sums->square / sums->open) : 0;
        blend->leaked_bias = sums->open > 0 ? sums->mean / sums->open : 0;
        if (!job->lit)
            blend->leaked_rms = blend->leaked_bias = (double)NAN;
        blend->worst_part = all > 0 ? sums->worst / all : 0;
    }
}

/* -- all together ----------------------------------------------------------------------------- */

/* Whether every probe of a cell has light. */
static bool is_lit(const struct baked *b)
{
    for (size_t i = 0; i < (size_t)b->mesh.corners * b->mesh.cells && b->sh; i++)
        if (isnan(b->sh[b->width * (size_t)b->mesh.vertex[i]]))
            return false;
    return b->sh != NULL;
}

static struct error *start(struct job *job, struct unseen_cells *cells)
{
    const size_t count = job->baked->mesh.cells;
    job->lit = is_lit(job->baked);
    job->sees = baked_sees(job->baked);
    job->judge = job->settings->judge ? job->settings->judge : &job->own;
    if (job->lit)
        job->basis = sphere_basis_make(job->baked->order, job->baked->convolved);
    struct error *err = find_near(job, cells);
    if (!err)
        err = array_create(&job->first, BLOCK + 1, sizeof *job->first);
    if (!err)
        err = array_create(&cells->cell_weight, count, sizeof *cells->cell_weight);
    if (!err)
        err = array_create(&cells->cell_leak, count, sizeof *cells->cell_leak);
    return err ? err : array_create(&cells->cell_free, count, sizeof *cells->cell_free);
}

/* The cells of the next block end here: one of them at least. */
static size_t end_of_block(const struct job *job)
{
    size_t end = job->begin, points = 0;
    while (end < job->baked->mesh.cells && end < job->begin + BLOCK && points < SAMPLES)
        points += count_of(job, end++);
    return end;
}

struct error *unseen_cells(struct unseen_cells *cells, const struct tracer *tracer,
                           const struct baked *baked, const struct unseen_settings *settings)
{
    struct job job = {.tracer = tracer, .baked = baked, .settings = settings};
    struct totals totals = {0};
    *cells = (struct unseen_cells){0};
    if (baked->mesh.corners < 2)
        return error_new("leaks are measured of cells, and %s",
                         baked->mesh.corners ? "the cell is a point" : "there are no cells");
    struct error *err = start(&job, cells);
    for (; job.begin < baked->mesh.cells && !err; job.begin = job.end) {
        job.end = end_of_block(&job);
        err = look_from_block(&job);
        for (size_t i = 0; i < job.end - job.begin && !err; i++) {
            add_cell(&job, i, &totals, cells);
            if (settings->keep)
                err = keep_cell(&job, i);
        }
        cells->points += err ? 0 : job.first[job.end - job.begin];
    }
    if (!err)
        sum_up(&job, &totals, cells);
    free(job.size);
    free(job.near);
    free(job.first);
    free(job.sample);
    free(job.asked);
    seen_destroy(job.seen);
    place_judge_destroy(job.own);
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

static struct error *report_blend(struct report *report, const struct unseen_blend *blend,
                                  const char *of)
{
    const double mean = report_get(report, "irradiance", "all").value;
    const struct {
        const char *name;
        double value;
        bool there;
    } figures[] = {
        {"leaked_rms", blend->leaked_rms, !isnan(blend->leaked_rms)},
        {"leaked_bias", blend->leaked_bias, !isnan(blend->leaked_rms)},
        {"leaked_rms_relative", blend->leaked_rms / mean, mean > 0 && !isnan(blend->leaked_rms)},
        {"leaked_bias_relative", blend->leaked_bias / mean, mean > 0 && !isnan(blend->leaked_rms)},
        {"blind", blend->blind, true},
        {"leak_worst_cell", (double)blend->worst_cell, blend->worst_share > 0},
        {"leak_worst", blend->worst_share, true},
        {"leak_worst_part", blend->worst_part, blend->worst_share > 0},
        {"leak_worst_x", blend->worst_point[0], blend->worst_share > 0},
        {"leak_worst_y", blend->worst_point[1], blend->worst_share > 0},
        {"leak_worst_z", blend->worst_point[2], blend->worst_share > 0}};
    struct error *err = report_add(report, "leak_volume", of, blend->weight);
    if (!err && !isnan(blend->light.value))
        err = report_add(report, "leak_light", of, blend->light);
    for (size_t i = 0; i < sizeof figures / sizeof *figures && !err; i++)
        if (figures[i].there)
            err = report_add_number(report, figures[i].name, of, figures[i].value);
    return err;
}

struct error *unseen_report(struct report *report, const struct unseen_cells *cells, size_t count)
{
    struct error *err = report_add_number(report, "cells", "all", (double)count);
    if (!err)
        err = report_add_number(report, "leak_points", "all", (double)cells->points);
    if (!err)
        err = report_add_number(report, "free_volume", "all", cells->free_volume);
    if (!err)
        err = report_add_number(report, "lost", "all", cells->lost);
    if (!err)
        err = report_blend(report, &cells->now, "all");
    return err || !cells->differ ? err : report_blend(report, &cells->all, "all-probes");
}

struct error *unseen_gate(const struct report *report, double most)
{
    const struct estimate light = report_get(report, "leak_light", "all"),
                          weight = report_get(report, "leak_volume", "all");
    const bool lit = !isnan(light.value);
    const struct estimate *e = lit ? &light : &weight;
    if (!(e->high > most))
        return NULL;
    char worst[160] = "";
    if (report_get(report, "leak_worst", "all").value > 0)
        snprintf(worst, sizeof worst, "; worst cell %.0f, at %.6g %.6g %.6g",
                 report_get(report, "leak_worst_cell", "all").value,
                 report_get(report, "leak_worst_x", "all").value,
                 report_get(report, "leak_worst_y", "all").value,
                 report_get(report, "leak_worst_z", "all").value);
    return error_above("%s %.3g %% (%.3g .. %.3g), above --max-leak %.6g%s",
                       lit ? "light that leaks" : "unseen weight", 100 * e->value, 100 * e->low,
                       100 * e->high, most, worst);
}
