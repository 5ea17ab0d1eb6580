/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/sight.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "leak/aim.h"
#include "leak/leak.h"
#include "leak/sight_fit.h"
#include "leak/stand_in.h"
#include "leak/stars.h"
#include "libprobe-query/sight.h"
#include "trace/enter.h"
#include "trace/trace.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Of a triangle's side, in parts: a ray goes through the middle of each of its SIDE^2 parts. */
enum { SIDE = 4, SPOTS_MOST = SIDE * SIDE };

/* An edge has no space about it; it counts as a ray through a facet does, times this. */
static const double EDGE_SHARE = 1.0 / 6;

struct job {
    const struct tracer *tracer;
    const struct leak_mesh *mesh;
    struct stars stars;
    double spot[SPOTS_MOST][3]; /* barycentric, of the facet opposite a corner */
    int spots;
    bool *entered; /* by cell: a surface comes into it */
    float *sight;
};

/* -- cells ------------------------------------------------------------------------------------ */

static struct error *look_for_surfaces(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    const int corners = job->mesh->corners;
    const double *point[4];
    for (int i = 0; i < corners; i++)
        point[i] = job->mesh->position +
                   3 * (size_t)job->mesh->vertex[(size_t)corners * cell + (size_t)i];
    job->entered[cell] = trace_enter(job->tracer, corners, point, NULL, NULL);
    return NULL;
}

/* -- around one probe ------------------------------------------------------------------------- */

/* A probe's neighbours and the rays to them and between them. */
struct view {
    const struct job *job;
    size_t probe;
    size_t about; /* cells around it */
    const uint32_t *slot;
    int32_t *neighbour;
    double *sight; /* towards each neighbour */
    size_t neighbours;
    struct sight_ray *ray;
    size_t rays, room;
};

static const int32_t *cell_of(const struct view *v, size_t i)
{
    const size_t corners = (size_t)v->job->mesh->corners;
    return v->job->mesh->vertex + v->slot[i] / corners * corners;
}

/* How near to p something stands on the way to q, which is 1. */
static double inverse_depth(const struct job *job, struct vec3 p, struct vec3 q)
{
    double from[3], direction[3];
    const struct vec3 way = vec3_sub(q, p);
    const double length = vec3_length(way), least = length / 0x1p14;
    vec3_store(from, p);
    vec3_store(direction, vec3_scale(1 / length, way));
    const struct trace_hit hit = trace_nearest(job->tracer, from, direction, length);
    return hit.hit ? length / fmax(hit.distance, least) : 0;
}

static struct error *view_init(struct view *v, const struct job *job, size_t probe)
{
    *v = (struct view){.job = job,
                       .probe = probe,
                       .about = job->stars.first[probe + 1] - job->stars.first[probe],
                       .slot = job->stars.slot + job->stars.first[probe]};
    const size_t most = v->about * (size_t)(job->mesh->corners - 1);
    struct error *err = array_create(&v->neighbour, most, sizeof *v->neighbour);
    if (!err)
        err = array_create(&v->sight, most, sizeof *v->sight);
    return err;
}

static void view_clear(struct view *v)
{
    free(v->neighbour);
    free(v->sight);
    free(v->ray);
}

/* Whether a surface comes into the i-th cell around; into any. */
static bool is_entered(const struct view *v, size_t i)
{
    return v->job->entered[v->slot[i] / (size_t)v->job->mesh->corners];
}

static bool has_surfaces(const struct view *v)
{
    for (size_t i = 0; i < v->about; i++)
        if (is_entered(v, i))
            return true;
    return false;
}

/* The number of a neighbour; looks towards one that is new, unless nothing is in the way. */
static int find_neighbour(struct view *v, int32_t probe, bool clear)
{
    size_t n = 0;
    while (n < v->neighbours && v->neighbour[n] != probe)
        n++;
    if (n == v->neighbours) {
        const struct leak_mesh *mesh = v->job->mesh;
        v->neighbour[v->neighbours++] = probe;
        v->sight[n] = clear ? 0
                            : inverse_depth(v->job, leak_mesh_probe(mesh, (int32_t)v->probe),
                                            leak_mesh_probe(mesh, probe));
        v->ray[v->rays++] = (struct sight_ray){
            .neighbour = {(int)n, (int)n, (int)n}, .u = {1, 0, 0}, .inverse = v->sight[n]};
    }
    return (int)n;
}

/* A cell as the probe sees it. */
struct ahead {
    int others;               /* corners, without the probe */
    struct vec3 from, way[3]; /* the probe, and to each */
    int to[3];                /* their numbers; the first for what there is not */
    const double *corner[4];  /* the probe first */
    double space;
};

static struct ahead look_ahead(struct view *v, size_t i, bool clear)
{
    const struct leak_mesh *mesh = v->job->mesh;
    const int32_t *vertex = cell_of(v, i);
    struct ahead c = {.from = leak_mesh_probe(mesh, (int32_t)v->probe),
                      .corner = {mesh->position + 3 * v->probe}};
    for (int k = 0; k < mesh->corners; k++)
        if (vertex[k] != (int32_t)v->probe) {
            c.way[c.others] = vec3_sub(leak_mesh_probe(mesh, vertex[k]), c.from);
            c.to[c.others++] = find_neighbour(v, vertex[k], clear);
            c.corner[c.others] = mesh->position + 3 * (size_t)vertex[k];
        }
    for (int k = c.others; k < 3; k++)
        c.to[k] = c.to[0];
    c.space = c.others == 3   ? fabs(vec3_dot(c.way[0], vec3_cross(c.way[1], c.way[2])))
              : c.others == 2 ? vec3_length(vec3_cross(c.way[0], c.way[1]))
                              : vec3_length(c.way[0]);
    return c;
}

/* A ray through a spot of the facet. Returns whether it met anything. */
static bool look_at(struct view *v, const struct ahead *c, const double u[3], double share,
                    bool clear)
{
    struct sight_ray *ray = &v->ray[v->rays++];
    struct vec3 spot = c->from;
    *ray = (struct sight_ray){.share = share};
    for (int k = 0; k < 3; k++) {
        ray->neighbour[k] = c->to[k];
        ray->u[k] = u[k];
        spot = vec3_fma(spot, u[k], c->way[k]);
    }
    ray->inverse = clear ? 0 : inverse_depth(v->job, c->from, spot);
    return ray->inverse > 0;
}

/* Looks through a cell, and where that meets nothing of what comes into it, at that. */
static struct error *look_through(struct view *v, size_t i)
{
    const struct job *job = v->job;
    const bool clear = !is_entered(v, i);
    struct error *err = array_reserve(&v->ray, &v->room,
                                      v->rays + 3 + (size_t)job->spots + AIM_MOST, sizeof *v->ray);
    if (err)
        return err;
    const struct ahead c = look_ahead(v, i, clear);
    const double share = c.space / SPOTS_MOST;
    bool met = clear;
    for (int s = 0; s < job->spots; s++)
        met = look_at(v, &c, job->spot[s], share, clear) || met;
    for (size_t k = 0; k < v->rays; k++)
        for (int n = 0; n < c.others && v->ray[k].u[0] == 1; n++)
            v->ray[k].share += v->ray[k].neighbour[0] == c.to[n] ? EDGE_SHARE * share : 0;
    if (met || c.others < 3)
        return NULL;
    struct aim aim[AIM_MOST];
    const int aims = aim_find(aim, job->tracer, c.corner);
    for (int k = 0; k < aims; k++)
        look_at(v, &c, aim[k].u, aim[k].share * c.space, false);
    return NULL;
}

static void store(const struct view *v, size_t i)
{
    const size_t others = (size_t)v->job->mesh->corners - 1;
    const int32_t *vertex = cell_of(v, i);
    float *out = v->job->sight + others * v->slot[i];
    for (size_t k = 0; k <= others; k++) {
        size_t n = 0;
        if (vertex[k] == (int32_t)v->probe)
            continue;
        while (v->neighbour[n] != vertex[k])
            n++;
        *out++ = half_value(half_of((float)v->sight[n]));
    }
}

/* Brings the numbers of a probe that all but touches a surface into the range of halves: as if the
 * surface were that much farther. */
static void limit(struct view *v)
{
    const double most = 60000;
    double largest = 0;
    for (size_t n = 0; n < v->neighbours; n++)
        largest = fmax(largest, fabs(v->sight[n]));
    for (size_t n = 0; n < v->neighbours && largest > most; n++)
        v->sight[n] *= most / largest;
}

static struct error *look_around(void *context, size_t probe, int thread)
{
    (void)thread;
    struct view v;
    bool blocked = false;
    struct error *err = view_init(&v, context, probe);
    if (!err && has_surfaces(&v)) {
        for (size_t i = 0; i < v.about && !err; i++)
            err = look_through(&v, i);
        for (size_t k = 0; k < v.rays; k++)
            blocked = blocked || v.ray[k].inverse > 0;
    }
    if (blocked && !err)
        err = sight_fit(v.rays, v.ray, v.neighbours, v.sight);
    limit(&v);
    for (size_t i = 0; i < v.about && blocked && !err; i++)
        store(&v, i);
    view_clear(&v);
    return err;
}

/* -- all together ----------------------------------------------------------------------------- */

/* Middles of the parts of a facet that is cut evenly: a triangle, or an edge of triangles; a
 * segment's facet is the neighbour, to which a ray goes anyway. */
static void choose_spots(struct job *job)
{
    for (int k = 0; job->mesh->corners == 3 && k < SIDE; k++) {
        const double x = (k + 0.5) / SIDE;
        double *spot = job->spot[job->spots++];
        spot[0] = x;
        spot[1] = 1 - x;
    }
    for (int a = 0; job->mesh->corners == 4 && a < SIDE; a++)
        for (int b = 0; a + b < SIDE; b++)
            for (int up = 0; up < 2 && a + b + up < SIDE; up++) {
                double *spot = job->spot[job->spots++];
                spot[0] = (a + (1 + up) / 3.0) / SIDE;
                spot[1] = (b + (1 + up) / 3.0) / SIDE;
                spot[2] = 1 - spot[0] - spot[1];
            }
}

struct error *sight_find(struct sights *sights, const struct tracer *tracer,
                         const struct leak_mesh *mesh, int threads)
{
    struct job job = {.tracer = tracer, .mesh = mesh};
    const size_t width = (size_t)sight_width(mesh->corners);
    *sights = (struct sights){0};
    choose_spots(&job);
    struct error *err = stars_init(&job.stars, mesh);
    if (!err)
        err = array_create(&sights->sight, width * mesh->cell_count, sizeof *sights->sight);
    job.sight = sights->sight;
    if (!err)
        err = array_create(&job.entered, mesh->cell_count, sizeof *job.entered);
    if (!err)
        err = threads_for(threads, mesh->cell_count, look_for_surfaces, &job);
    if (!err)
        err = threads_for(threads, mesh->probe_count, look_around, &job);
    if (!err)
        err = array_create(&sights->stand_in, mesh->cell_count, sizeof *sights->stand_in);
    if (!err)
        err = stand_in_find(sights->stand_in, sights->sight, tracer, mesh, &job.stars, threads);
    for (size_t cell = 0; cell < mesh->cell_count && !err; cell++) {
        bool walled = false;
        for (size_t i = 0; i < width; i++)
            walled = walled || sights->sight[width * cell + i] > 1;
        sights->walled += walled;
        sights->stood_in += sights->stand_in[cell] >= 0;
    }
    free(job.entered);
    stars_clear(&job.stars);
    if (err)
        sights_clear(sights);
    return err;
}

void sights_clear(struct sights *sights)
{
    free(sights->sight);
    free(sights->stand_in);
    *sights = (struct sights){0};
}
