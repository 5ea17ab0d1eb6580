/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/dilate.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/scatter.h"
#include "math/vec.h"
#include "stream/light_columns.h"
#include "stream/stream_edit.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far valid probes are looked for, in scatter_spacing; how many backs a ray goes through. */
enum { RADIUS_MOST = 4, BACKS_MOST = 8 };

/* What comes of the light that reaches a probe, beside the light itself. */
static const char *const of_light[] = {
    "sh_window", "visibility",   "ao",           "bent_normal",        "bent_length",
    "cone",      "ambient_cube", "ambient_dice", "ambient_dice_cubic", "ahd"};

struct job {
    const struct tracer *tracer;
    const double *position;
    const struct scatter *valid;
    double spacing;
    const int32_t *asking; /* probes that look for light */
    int32_t *donor;        /* of each of these; owned, and so is: */
    unsigned char *seen;
};

/* -- what is invalid -------------------------------------------------------------------------- */

struct invalid {
    const struct table *probes;
    const struct stream_selection *conditions;
    const struct column *sh;
};

static bool is_dark(const struct invalid *invalid, size_t probe)
{
    return isnan(column_f32(invalid->sh)[probe * invalid->sh->width]);
}

static bool is_no_donor(const void *context, size_t probe)
{
    const struct invalid *invalid = context;
    return is_dark(invalid, probe) ||
           stream_selection_holds(invalid->conditions, invalid->probes, probe);
}

/* -- looking ---------------------------------------------------------------------------------- */

enum sight { HIDDEN, THROUGH_BACKS, FREE };

static enum sight look(const struct tracer *tracer, struct vec3 p, struct vec3 q)
{
    double from[3], along[3];
    const struct vec3 way = vec3_sub(q, p);
    const double length = vec3_length(way), step = length * 1e-6;
    if (!(length > 0))
        return FREE;
    const struct vec3 direction = vec3_scale(1 / length, way);
    vec3_store(along, direction);
    double gone = 0;
    for (int backs = 0; backs <= BACKS_MOST; backs++) {
        vec3_store(from, vec3_fma(p, gone, direction));
        const struct trace_hit hit = trace_nearest(tracer, from, along, length - gone);
        if (!hit.hit)
            return backs ? THROUGH_BACKS : FREE;
        if (hit.front)
            return HIDDEN;
        gone += hit.distance + step;
        if (gone >= length)
            return THROUGH_BACKS;
    }
    return HIDDEN;
}

/* The nearest valid probe that is seen freely, and the nearest through backs. */
struct search {
    const struct job *job;
    struct vec3 p;
    double from; /* nearer ones than this were asked before */
    double nearest[3];
    int32_t probe[3]; /* by enum sight; -1: none yet */
};

static void ask(void *context, int32_t probe, double distance)
{
    struct search *s = context;
    if (distance < s->from || distance > s->nearest[FREE])
        return;
    const enum sight sight =
        look(s->job->tracer, s->p, vec3_load(s->job->position + 3 * (size_t)probe));
    if (distance < s->nearest[sight] ||
        (distance == s->nearest[sight] && probe < s->probe[sight])) {
        s->nearest[sight] = distance;
        s->probe[sight] = probe;
    }
}

static struct error *look_for(void *context, size_t i, int thread)
{
    (void)thread;
    const struct job *job = context;
    const double *p = job->position + 3 * (size_t)job->asking[i], all = (double)INFINITY;
    struct search s = {
        .job = job, .p = vec3_load(p), .nearest = {all, all, all}, .probe = {-1, -1, -1}};
    double distance;
    for (int turn = 1; turn <= RADIUS_MOST && s.probe[FREE] < 0 && s.probe[THROUGH_BACKS] < 0;
         turn *= 2) {
        scatter_within(job->valid, p, turn * job->spacing, ask, &s);
        s.from = turn * job->spacing;
    }
    const int32_t seen = s.probe[FREE] >= 0 ? s.probe[FREE] : s.probe[THROUGH_BACKS];
    job->seen[i] = seen >= 0;
    job->donor[i] = seen >= 0 ? seen : scatter_nearest(job->valid, p, &distance);
    return NULL;
}

/* -- all together ----------------------------------------------------------------------------- */

static bool is_given(const struct column *column, size_t sh_width)
{
    struct light_column what;
    bool given = light_column_of(column, sh_width, &what) || light_column_is_split(column->name);
    for (size_t k = 0; k < sizeof of_light / sizeof *of_light; k++)
        given = given || !strcmp(column->name, of_light[k]);
    return given;
}

/* Gives the light of the donors, which are none of those that get any. */
static void give(struct table *probes, const struct job *job, size_t count)
{
    const size_t sh_width = table_column(probes, "sh")->width;
    for (size_t k = 0; k < probes->column_count; k++) {
        const struct column *c = &probes->columns[k];
        const size_t bytes = c->width * column_type_size(c->type);
        for (size_t i = 0; i < count && is_given(c, sh_width); i++)
            memcpy((char *)c->data + (size_t)job->asking[i] * bytes,
                   (const char *)c->data + (size_t)job->donor[i] * bytes, bytes);
    }
}

static struct error *mark(struct table *probes, const struct job *job, size_t count)
{
    struct column *filled = NULL;
    struct error *err = table_add_column(probes, "filled", COLUMN_I32, 1, &filled);
    if (err)
        return err;
    memset(filled->data, 0, probes->rows * sizeof(int32_t));
    for (size_t i = 0; i < count; i++)
        column_i32(filled)[job->asking[i]] = 1;
    return NULL;
}

struct error *dilate(struct table *probes, const struct stream_selection *conditions,
                     const struct tracer *tracer, int threads, struct dilate_count *count)
{
    struct job job = {.tracer = tracer, .position = column_f64(table_column(probes, "position"))};
    struct invalid invalid = {probes, conditions, table_column(probes, "sh")};
    struct scatter *valid = NULL;
    int32_t *asking = NULL;
    *count = (struct dilate_count){0};
    if (!invalid.sh)
        return error_new("the probes have no light from all sides (no column sh) to give others");
    struct error *err = stream_selection_conditions(conditions, probes);
    if (!err)
        err = array_create(&asking, probes->rows, sizeof *asking);
    size_t lit = 0;
    for (size_t i = 0; i < probes->rows && !err; i++) {
        lit += !is_dark(&invalid, i);
        if (!is_dark(&invalid, i) && is_no_donor(&invalid, i))
            asking[count->filled++] = (int32_t)i;
    }
    job.asking = asking;
    if (!err && count->filled == lit && lit)
        err = error_new("all %zu probes with light are invalid: none has light to give", lit);
    if (!err && count->filled)
        err = scatter_create(&valid, probes->rows, job.position, is_no_donor, &invalid);
    if (!err && count->filled) {
        job.valid = valid;
        job.spacing = scatter_spacing(valid);
        err = array_create(&job.donor, count->filled, sizeof *job.donor);
    }
    if (!err)
        err = array_create(&job.seen, count->filled, sizeof *job.seen);
    if (!err)
        err = threads_for(threads, count->filled, look_for, &job);
    for (size_t i = 0; i < count->filled && !err; i++)
        count->unseen += !job.seen[i];
    if (!err) {
        give(probes, &job, count->filled);
        err = mark(probes, &job, count->filled);
    }
    scatter_destroy(valid);
    free(asking);
    free(job.donor);
    free(job.seen);
    return err;
}
