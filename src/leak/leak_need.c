/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/leak_need.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/scatter.h"
#include "leak/leak.h"
#include "math/vec.h"
#include "trace/trace.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The ball of a sliver is huge: no larger than this many of its longest edge. */
#define BALL_MOST 1.0

/* A place and a point that it would serve. */
struct pair {
    uint32_t place, point;
};

/* The points of one cell, and the pairs of them. */
struct group {
    size_t first, count;
    struct pair *pair; /* owned */
    size_t pairs, capacity;
};

struct job {
    const struct tracer *tracer;
    const struct leak_mesh *mesh;
    const struct need_point *point;
    size_t points;
    struct scatter *places;
    struct group *group;
    size_t groups;
};

static bool sees(const struct job *job, const double a[3], const double b[3])
{
    return trace_visibility(job->tracer, a, b) > 0.5f;
}

/* -- balls ------------------------------------------------------------------------------------ */

struct ball {
    struct vec3 centre;
    double radius;
};

/* Solves a x = b, n x n with n of 1 to 3, by Cramer's rule. false: it has no solution to speak of.
 */
static bool solve(int n, double a[3][3], const double b[3], double x[3])
{
    for (int k = n; k < 3; k++)
        for (int i = 0; i < 3; i++)
            a[k][i] = a[i][k] = i == k;
    const struct vec3 c0 = {a[0][0], a[1][0], a[2][0]}, c1 = {a[0][1], a[1][1], a[2][1]},
                      c2 = {a[0][2], a[1][2], a[2][2]},
                      r = {b[0], n > 1 ? b[1] : 0, n > 2 ? b[2] : 0};
    const double det = vec3_dot(c0, vec3_cross(c1, c2)),
                 size = vec3_length(c0) * vec3_length(c1) * vec3_length(c2);
    if (!(fabs(det) > 1e-9 * size))
        return false;
    x[0] = vec3_dot(r, vec3_cross(c1, c2)) / det;
    x[1] = vec3_dot(c0, vec3_cross(r, c2)) / det;
    x[2] = vec3_dot(c0, vec3_cross(c1, r)) / det;
    return true;
}

/* Through the corners of a cell, its centre in the span of these; of a flat one, about its
 * middle. */
static struct ball ball_of(const struct leak_mesh *mesh, size_t cell)
{
    const int n = mesh->corners - 1;
    const int32_t *vertex = mesh->vertex + (size_t)mesh->corners * cell;
    const struct vec3 p = leak_mesh_probe(mesh, vertex[0]);
    struct vec3 way[3] = {{0}}, middle = p;
    double gram[3][3] = {{0}}, half[3] = {0}, x[3] = {0}, longest = 0;
    for (int i = 0; i < n; i++) {
        way[i] = vec3_sub(leak_mesh_probe(mesh, vertex[i + 1]), p);
        half[i] = vec3_dot(way[i], way[i]) / 2;
        middle = vec3_fma(middle, 1.0 / (n + 1), way[i]);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            gram[i][j] = vec3_dot(way[i], way[j]);
            longest = fmax(longest, vec3_length(vec3_sub(way[i], way[j])));
        }
    for (int i = 0; i < n; i++)
        longest = fmax(longest, sqrt(2 * half[i]));
    struct ball ball = {p, 0};
    if (solve(n, gram, half, x))
        for (int i = 0; i < n; i++)
            ball.centre = vec3_fma(ball.centre, x[i], way[i]);
    ball.radius = vec3_length(vec3_sub(ball.centre, p));
    if (!(ball.radius > 0 && ball.radius <= BALL_MOST * longest))
        ball = (struct ball){middle, BALL_MOST * longest};
    return ball;
}

/* -- what serves what ------------------------------------------------------------------------- */

struct found {
    int32_t *place;
    size_t count, capacity;
    struct error *err;
};

static void find(void *context, int32_t place, double distance)
{
    (void)distance;
    struct found *f = context;
    if (!f->err)
        f->err = array_reserve(&f->place, &f->capacity, f->count + 1, sizeof *f->place);
    if (!f->err)
        f->place[f->count++] = place;
}

static struct error *pair_group(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct group *g = &job->group[index];
    struct found found = {0};
    double centre[3];
    const struct ball ball = ball_of(job->mesh, job->point[g->first].cell);
    vec3_store(centre, ball.centre);
    scatter_within(job->places, centre, ball.radius, find, &found);
    struct error *err = found.err;
    for (size_t i = 0; i < found.count && !err; i++)
        for (size_t k = g->first; k < g->first + g->count && !err; k++) {
            const size_t place = (size_t)found.place[i];
            if (place != k && !sees(job, job->point[place].position, job->point[k].position))
                continue;
            err = array_reserve(&g->pair, &g->capacity, g->pairs + 1, sizeof *g->pair);
            if (!err)
                g->pair[g->pairs++] = (struct pair){(uint32_t)place, (uint32_t)k};
        }
    free(found.place);
    return err;
}

static struct error *make_groups(struct job *job)
{
    struct error *err = array_create(&job->group, job->points, sizeof *job->group);
    for (size_t i = 0; i < job->points && !err; i++) {
        if (!i || job->point[i].cell != job->point[i - 1].cell)
            job->group[job->groups++].first = i;
        job->group[job->groups - 1].count++;
    }
    return err;
}

/* -- choosing --------------------------------------------------------------------------------- */

/* Points by place: those of place i are point[first[i]] on. Places by point likewise. */
struct table_of {
    size_t *first;
    uint32_t *of;
};

static struct error *table_make(struct table_of *t, const struct job *job, bool by_place)
{
    size_t pairs = 0;
    for (size_t g = 0; g < job->groups; g++)
        pairs += job->group[g].pairs;
    struct error *err = array_create(&t->first, job->points + 2, sizeof *t->first);
    if (!err)
        err = array_create(&t->of, pairs, sizeof *t->of);
    /* counted two places on, so that they stand one on when they are filled */
    for (size_t g = 0; g < job->groups && !err; g++)
        for (size_t i = 0; i < job->group[g].pairs; i++) {
            const struct pair p = job->group[g].pair[i];
            t->first[(by_place ? p.place : p.point) + 2]++;
        }
    for (size_t i = 2; i < job->points + 2 && !err; i++)
        t->first[i] += t->first[i - 1];
    for (size_t g = 0; g < job->groups && !err; g++)
        for (size_t i = 0; i < job->group[g].pairs; i++) {
            const struct pair p = job->group[g].pair[i];
            t->of[t->first[(by_place ? p.place : p.point) + 1]++] = by_place ? p.point : p.place;
        }
    return err;
}

static void table_clear_of(struct table_of *t)
{
    free(t->first);
    free(t->of);
}

/* The middle of what a place serves and is not served yet, where it sees all that the place does;
 * else the place. */
static void stand(const struct job *job, const struct table_of *points, const bool *served,
                  size_t place, double out[3])
{
    struct vec3 sum = {0};
    double all = 0, middle[3];
    const double *p = job->point[place].position;
    for (size_t i = points->first[place]; i < points->first[place + 1]; i++) {
        const struct need_point *q = &job->point[points->of[i]];
        if (served[points->of[i]])
            continue;
        sum = vec3_fma(sum, q->leaks, vec3_load(q->position));
        all += q->leaks;
    }
    vec3_store(middle, vec3_scale(1 / all, sum));
    bool better = sees(job, middle, p);
    for (size_t i = points->first[place]; i < points->first[place + 1] && better; i++)
        better = served[points->of[i]] || sees(job, middle, job->point[points->of[i]].position);
    memcpy(out, better ? middle : p, 3 * sizeof *out);
}

static struct error *choose(const struct job *job, size_t most, double *probe, size_t *count)
{
    struct table_of points = {0}, places = {0};
    double *gain = NULL;
    bool *served = NULL;
    struct error *err = table_make(&points, job, true);
    if (!err)
        err = table_make(&places, job, false);
    if (!err)
        err = array_create(&gain, job->points, sizeof *gain);
    if (!err)
        err = array_create(&served, job->points, sizeof *served);
    for (size_t i = 0; i < job->points && !err; i++)
        for (size_t k = points.first[i]; k < points.first[i + 1]; k++)
            gain[i] += job->point[points.of[k]].leaks;
    const double enough = 1e-9;
    double first = 0;
    while (!err && *count < most) {
        size_t best = 0;
        for (size_t i = 1; i < job->points; i++)
            best = gain[i] > gain[best] ? i : best;
        if (!*count)
            first = gain[best];
        if (!(gain[best] > enough * first))
            break;
        stand(job, &points, served, best, probe + 3 * (*count)++);
        for (size_t k = points.first[best]; k < points.first[best + 1]; k++) {
            const size_t point = points.of[k];
            if (served[point])
                continue;
            served[point] = true;
            for (size_t i = places.first[point]; i < places.first[point + 1]; i++)
                gain[places.of[i]] -= job->point[point].leaks;
        }
    }
    free(gain);
    free(served);
    table_clear_of(&points);
    table_clear_of(&places);
    return err;
}

static bool none(const void *context, size_t place)
{
    (void)context;
    (void)place;
    return false;
}

struct error *leak_need(const struct tracer *tracer, const struct leak_mesh *mesh,
                        const struct need_point *point, size_t points, size_t most, int threads,
                        double *probe, size_t *count)
{
    struct job job = {.tracer = tracer, .mesh = mesh, .point = point, .points = points};
    double *position = NULL;
    *count = 0;
    if (!points || !most)
        return NULL;
    struct error *err = array_create(&position, 3 * points, sizeof *position);
    for (size_t i = 0; i < points && !err; i++)
        memcpy(position + 3 * i, point[i].position, 3 * sizeof *position);
    if (!err)
        err = scatter_create(&job.places, points, position, none, NULL);
    if (!err)
        err = make_groups(&job);
    if (!err)
        err = threads_for(threads, job.groups, pair_group, &job);
    if (!err)
        err = choose(&job, most, probe, count);
    for (size_t g = 0; g < job.groups; g++)
        free(job.group[g].pair);
    free(job.group);
    scatter_destroy(job.places);
    free(position);
    return err;
}
