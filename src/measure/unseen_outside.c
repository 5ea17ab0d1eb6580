/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/unseen_outside.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/baked.h"
#include "interpolate/cells_volume.h"
#include "interpolate/interpolate.h"
#include "math/box.h"
#include "math/random.h"
#include "measure/ratio.h"
#include "measure/report.h"
#include "measure/sphere.h"
#include "measure/unseen.h"
#include "place/place_inside.h"
#include "scene/scene.h"
#include "trace/seen.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FOR_BOX = 0x424f5820, BLENDS = 2 }; /* of all probes of a cell, as it is */

enum { SLICE = 1 << 14 }; /* points at a time */

struct point {
    double position[3];
    struct unseen of[BLENDS];
    bool counts, lost;
};

/* Of all points. */
struct sums {
    struct stratum weight, light;
    double blind, worst, worst_point[3];
};

struct job {
    const struct tracer *tracer;
    const struct baked *baked;
    struct probe_volume *all; /* of all probes of a cell; owned */
    struct place_judge **judge;
    struct seen *seen;
    struct sphere_basis basis;
    bool lit;
    struct box box;
    double start[3];
    size_t first, count; /* of the slice */
    struct point *point;
    size_t *asked; /* points that see none of their probes, and may be in matter */
    size_t asked_count;
};

static void keep(const struct job *job, const struct probe_place *at, const struct seen_look *look,
                 struct unseen *unseen)
{
    *unseen = (struct unseen){.weight = look->unseen, .blind = look->blind};
    if (job->lit)
        unseen_of(job->baked, &job->basis, at, look, unseen);
}

static struct error *look_from(void *context, size_t i, int thread)
{
    (void)thread;
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    const struct job *job = context;
    struct point *p = &job->point[i];
    struct probe_place all = {.cell = PROBE_COLD}, now = {.cell = PROBE_COLD};
    struct seen_look seen[BLENDS];
    for (int k = 0; k < 3; k++) {
        const double x = job->start[k] + (double)(job->first + i) * step[k], u = x - floor(x);
        p->position[k] = job->box.low[k] + u * (job->box.high[k] - job->box.low[k]);
    }
    probe_volume_locate(job->all, p->position, &all);
    p->counts = !all.inside;
    if (!p->counts)
        return NULL;
    baked_locate(job->baked, p->position, &now);
    seen_look(job->tracer, job->baked->position, p->position, &all, &seen[0]);
    seen_look_again(job->tracer, job->baked->position, p->position, &all, &seen[0], &now, &seen[1]);
    keep(job, &all, &seen[0], &p->of[0]);
    keep(job, &now, &seen[1], &p->of[1]);
    return NULL;
}

static struct error *judge(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct point *p = &job->point[job->asked[index]];
    p->counts = place_judge_side(*job->judge, p->position) == PLACE_AIR;
    p->lost = p->counts && seen_nearest(job->seen, p->position) < 0;
    p->counts = p->counts && !p->lost;
    return NULL;
}

/* What sees a probe is in free space; the others are asked, and whether they see any at all. */
static struct error *judge_blind(struct job *job, int threads)
{
    const struct baked *b = job->baked;
    struct error *err = NULL;
    job->asked_count = 0;
    for (size_t i = 0; i < job->count; i++)
        if (job->point[i].counts && job->point[i].of[0].blind && job->point[i].of[1].blind)
            job->asked[job->asked_count++] = i;
    if (!job->asked_count)
        return NULL;
    err = place_judge_of(job->judge, job->tracer, b->probe_count, b->position, threads);
    if (!err && !job->seen)
        err = seen_create(&job->seen, job->tracer, b->probe_count, b->position,
                          job->lit ? b->sh : NULL, b->width);
    return err ? err : threads_for(threads, job->asked_count, judge, job);
}

static void add(const struct job *job, int blend, struct sums *sums)
{
    for (size_t i = 0; i < job->count; i++) {
        const struct point *p = &job->point[i];
        const struct unseen *u = &p->of[blend];
        stratum_add(&sums->weight, p->counts ? u->weight : 0, p->counts);
        stratum_add(&sums->light, p->counts ? u->light : 0, p->counts ? u->bright : 0);
        if (!p->counts)
            continue;
        sums->blind += u->blind;
        if (u->weight > sums->worst) {
            sums->worst = u->weight;
            memcpy(sums->worst_point, p->position, sizeof sums->worst_point);
        }
    }
}

static struct unseen_outside_blend sum_up(const struct job *job, const struct sums *sums,
                                          size_t points)
{
    const struct estimate unknown = {(double)NAN, (double)NAN, (double)NAN};
    struct unseen_outside_blend out = {.worst = sums->worst};
    struct ratio weight = {0}, light = {0};
    ratio_add(&weight, &sums->weight, points, 1, true);
    ratio_add(&light, &sums->light, points, 1, true);
    out.weight = ratio_estimate(&weight);
    out.light = job->lit ? ratio_estimate(&light) : unknown;
    out.blind = sums->weight.x > 0 ? sums->blind / sums->weight.x : 0;
    memcpy(out.worst_point, sums->worst_point, sizeof out.worst_point);
    return out;
}

static bool has_light(const struct baked *b)
{
    for (size_t i = 0; i < (size_t)b->mesh.corners * b->mesh.cells && b->sh; i++)
        if (isnan(b->sh[b->width * (size_t)b->mesh.vertex[i]]))
            return false;
    return b->sh != NULL;
}

struct error *unseen_outside(struct unseen_outside *outside, const struct tracer *tracer,
                             const struct baked *baked, const struct unseen_settings *settings,
                             size_t points)
{
    const struct scene *scene = trace_scene(tracer);
    struct place_judge *own = NULL;
    struct job job = {.tracer = tracer,
                      .baked = baked,
                      .judge = settings->judge ? settings->judge : &own,
                      .lit = has_light(baked),
                      .box = {{scene->box_min.x, scene->box_min.y, scene->box_min.z},
                              {scene->box_max.x, scene->box_max.y, scene->box_max.z}}};
    struct random r = random_start(settings->seed, 0, FOR_BOX);
    struct sums sums[BLENDS];
    double volume = 1;
    memset(sums, 0, sizeof sums);
    *outside = (struct unseen_outside){.differ = baked_sees(baked)};
    for (int k = 0; k < 3; k++) {
        volume *= job.box.high[k] - job.box.low[k];
        job.start[k] = random_double(&r);
    }
    if (baked->mesh.corners != 4 || points < 2 || !(volume > 0 && volume < (double)INFINITY))
        return NULL;
    if (job.lit)
        job.basis = sphere_basis_make(baked->order, baked->convolved);
    struct error *err =
        cells_volume_create(&baked->mesh, baked->in ? baked->in->settings.outside : 0, &job.all);
    if (!err)
        err = array_create(&job.point, SLICE, sizeof *job.point);
    if (!err)
        err = array_create(&job.asked, SLICE, sizeof *job.asked);
    for (; job.first < points && !err; job.first += job.count) {
        job.count = points - job.first < SLICE ? points - job.first : SLICE;
        err = threads_for(settings->threads, job.count, look_from, &job);
        if (!err)
            err = judge_blind(&job, settings->threads);
        for (int blend = 0; blend < BLENDS && !err; blend++)
            add(&job, blend, &sums[blend]);
        for (size_t i = 0; i < job.count && !err; i++) {
            outside->points += job.point[i].counts;
            outside->lost += job.point[i].lost;
        }
    }
    outside->lost /= fmax(outside->lost + (double)outside->points, 1);
    outside->all = sum_up(&job, &sums[0], points);
    outside->now = sum_up(&job, &sums[1], points);
    free(job.point);
    free(job.asked);
    seen_destroy(job.seen);
    probe_volume_destroy(job.all);
    place_judge_destroy(own);
    return err;
}

static struct error *report_blend(struct report *report, const struct unseen_outside_blend *blend,
                                  const char *of)
{
    static const char *const axes[3] = {"leak_worst_x", "leak_worst_y", "leak_worst_z"};
    struct error *err = report_add(report, "leak_volume", of, blend->weight);
    if (!err && !isnan(blend->light.value))
        err = report_add(report, "leak_light", of, blend->light);
    if (!err)
        err = report_add_number(report, "blind", of, blend->blind);
    if (!err)
        err = report_add_number(report, "leak_worst", of, blend->worst);
    for (int k = 0; k < 3 && !err && blend->worst > 0; k++)
        err = report_add_number(report, axes[k], of, blend->worst_point[k]);
    return err;
}

struct error *unseen_outside_report(struct report *report, const struct unseen_outside *outside)
{
    if (!outside->points)
        return NULL;
    struct error *err =
        report_add_number(report, "leak_points", "outside", (double)outside->points);
    if (!err)
        err = report_add_number(report, "lost", "outside", outside->lost);
    if (!err)
        err = report_blend(report, &outside->now, "outside");
    return err || !outside->differ ? err
                                   : report_blend(report, &outside->all, "outside-all-probes");
}
