/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/sight.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "leak/aim.h"
#include "leak/leak.h"
#include "leak/outside.h"
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

/* Of the space about a probe: the inside is as it was where no more of it is off. */
static const double UNCHANGED = 1e-5;

/* Planes outside that are tried for a probe; they are one where they differ by less than SAME. */
enum { PLANES = 24 };
static const double SAME = 1e-4, TINY = 1e-9;

/* Of the space outside: what is told this well is told. */
static const double ENOUGH = 1e-4;

struct job {
    const struct tracer *tracer;
    const struct leak_mesh *mesh;
    struct stars stars;
    double spot[SPOTS_MOST][3]; /* barycentric, of the facet opposite a corner */
    int spots;
    bool *wanted;  /* of each probe; NULL: all are */
    bool *entered; /* by cell: a surface comes into it */
    float *sight;
    struct outside outside;
    double *slope; /* 3 a probe */
};

/* -- cells ------------------------------------------------------------------------------------ */

static struct error *look_for_surfaces(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    const int corners = job->mesh->corners;
    const double *point[4];
    bool wanted = !job->wanted;
    for (int i = 0; i < corners && !wanted; i++)
        wanted = job->wanted[job->mesh->vertex[(size_t)corners * cell + (size_t)i]];
    if (!wanted)
        return interrupt_error();
    for (int i = 0; i < corners; i++)
        point[i] = job->mesh->position +
                   3 * (size_t)job->mesh->vertex[(size_t)corners * cell + (size_t)i];
    job->entered[cell] = trace_enter(job->tracer, corners, point, NULL, NULL);
    return interrupt_error();
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

/* How near to the probe something stands on the way to q, which is 1. */
static double inverse_depth(const struct view *v, struct vec3 q)
{
    double to[3];
    vec3_store(to, q);
    return outside_inverse(v->job->tracer, v->job->mesh->position + 3 * v->probe, to);
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
        err = array_create(&v->sight, most + 3, sizeof *v->sight); /* and the slope */
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
        v->sight[n] = clear ? 0 : inverse_depth(v, leak_mesh_probe(mesh, probe));
        v->ray[v->rays++] = (struct sight_ray){.terms = 3,
                                               .neighbour = {(int)n, (int)n, (int)n},
                                               .u = {1, 0, 0},
                                               .inverse = v->sight[n]};
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
    *ray = (struct sight_ray){.terms = 3, .share = share};
    for (int k = 0; k < 3; k++) {
        ray->neighbour[k] = c->to[k];
        ray->u[k] = u[k];
        spot = vec3_fma(spot, u[k], c->way[k]);
    }
    ray->inverse = clear ? 0 : inverse_depth(v, spot);
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

/* -- what is outside -------------------------------------------------------------------------- */

static int number_of(const struct view *v, int32_t probe)
{
    int n = 0;
    while (v->neighbour[n] != probe)
        n++;
    return n;
}

/* A ray to a point outside: its light's place gives the terms of the neighbours there, its way from
 * that, in `scale`, those of the slope. false: the probe has no weight there. */
static bool ray_to(const struct view *v, const struct outside_look *look, double scale,
                   struct sight_ray *ray)
{
    const int32_t *vertex = v->job->mesh->vertex + 4 * (size_t)look->cell;
    double off[3];
    *ray = (struct sight_ray){0};
    outside_way(&v->job->outside, look, off);
    for (int i = 0; i < 4; i++) {
        if (vertex[i] == (int32_t)v->probe) {
            ray->share = look->weight[i];
            ray->inverse = (double)look->inverse[i];
        } else if (look->weight[i] > 0 && ray->terms < 2) {
            ray->neighbour[ray->terms] = number_of(v, vertex[i]);
            ray->u[ray->terms++] = look->weight[i];
        }
    }
    for (int k = 0; k < 3; k++) {
        ray->neighbour[ray->terms] = (int)v->neighbours + k;
        ray->u[ray->terms++] = off[k] / scale;
    }
    return ray->share > 0;
}

/* How far away the neighbours are, in the mean. */
static double scale_of(const struct view *v)
{
    const struct leak_mesh *mesh = v->job->mesh;
    double sum = 0;
    for (size_t n = 0; n < v->neighbours; n++)
        sum += vec3_length(vec3_sub(leak_mesh_probe(mesh, v->neighbour[n]),
                                    leak_mesh_probe(mesh, (int32_t)v->probe)));
    return sum / (double)v->neighbours;
}

static double share_of(size_t count, const struct sight_ray *ray)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += ray[k].share;
    return sum;
}

/* Appends the rays that go outside, which weigh as much as all before together. */
static struct error *look_outside(struct view *v, double scale)
{
    const struct outside *o = &v->job->outside;
    const size_t first = o->by_probe.first[v->probe], end = o->by_probe.first[v->probe + 1],
                 before = v->rays;
    struct error *err = array_reserve(&v->ray, &v->room, v->rays + (end - first), sizeof *v->ray);
    for (size_t i = first; i < end && !err; i++)
        v->rays += ray_to(v, &o->look[o->by_probe.of[i]], scale, &v->ray[v->rays]);
    const double inside = share_of(before, v->ray),
                 outside = share_of(v->rays - before, v->ray + before);
    for (size_t k = before; k < v->rays && inside > 0; k++)
        v->ray[k].share *= inside / outside;
    return err;
}

/* The slope alone, of rays whose other terms stay as they are. */
static struct error *fit_slope(const struct view *v, size_t rays, const struct sight_ray *ray,
                               double slope[3])
{
    struct sight_ray *alone = NULL;
    struct error *err = array_create(&alone, rays, sizeof *alone);
    for (size_t k = 0; k < rays && !err; k++) {
        alone[k] = (struct sight_ray){
            .terms = 3, .neighbour = {0, 1, 2}, .inverse = ray[k].inverse, .share = ray[k].share};
        for (int i = 0; i < ray[k].terms; i++)
            if ((size_t)ray[k].neighbour[i] < v->neighbours)
                alone[k].base += v->sight[ray[k].neighbour[i]] * ray[k].u[i];
            else
                alone[k].u[ray[k].neighbour[i] - (int)v->neighbours] = ray[k].u[i];
    }
    slope[0] = slope[1] = slope[2] = 0;
    if (!err)
        err = sight_fit(rays, alone, 3, slope);
    free(alone);
    return err;
}

/* All of the probe's numbers as those of a plane, at inverse depth plane . way. */
static void be_plane(const struct view *v, struct vec3 plane, double scale, double *sight)
{
    const struct leak_mesh *mesh = v->job->mesh;
    const struct vec3 p = leak_mesh_probe(mesh, (int32_t)v->probe);
    for (size_t n = 0; n < v->neighbours; n++)
        sight[n] = vec3_dot(plane, vec3_sub(leak_mesh_probe(mesh, v->neighbour[n]), p));
    vec3_store(sight + v->neighbours, vec3_scale(scale, plane));
}

/* Takes a choice that says what is outside with less loss, and the inside as it was. before: rays
 * that go inside, with loss `was`; least: that of those that go outside. */
static bool take(struct view *v, size_t before, double was, const double *trial, double *least)
{
    if (sight_fit_loss(before, v->ray, trial) > was + UNCHANGED * share_of(before, v->ray))
        return false;
    const double loss = sight_fit_loss(v->rays - before, v->ray + before, trial);
    if (!(loss < *least))
        return false;
    *least = loss;
    memcpy(v->sight, trial, (v->neighbours + 3) * sizeof *trial);
    return true;
}

/* Takes that of the planes that stand outside before the cells around which says best what is
 * there. */
static void try_planes(struct view *v, size_t before, double was, double scale, double *trial,
                       double *least)
{
    const struct outside *o = &v->job->outside;
    struct vec3 plane[PLANES];
    int planes = 0;
    for (size_t i = 0; i < v->about; i++) {
        const size_t cell = v->slot[i] / 4, end = o->by_cell.first[cell + 1];
        for (size_t k = o->by_cell.first[cell]; k < end && planes < PLANES; k++) {
            bool known = !outside_plane(&o->look[o->by_cell.of[k]],
                                        v->job->mesh->position + 3 * v->probe, &plane[planes]);
            for (int j = 0; j < planes && !known; j++)
                known = vec3_length(vec3_sub(plane[planes], plane[j])) <
                        SAME * vec3_length(plane[j]);
            if (known)
                continue;
            be_plane(v, plane[planes++], scale, trial);
            take(v, before, was, trial, least);
        }
    }
}

/* Fits the probe's slope, and with it what is free inside: to a plane, as most walls are, of which
 * it need not have met anything itself; then to what is none. */
static struct error *fit_outside(struct view *v)
{
    const size_t n = v->neighbours, before = v->rays;
    const double scale = scale_of(v), was = sight_fit_loss(before, v->ray, v->sight);
    double *trial = NULL, *slope = v->job->slope + 3 * v->probe;
    struct error *err = look_outside(v, scale);
    const struct sight_ray *ray = v->ray + before;
    const size_t rays = v->rays - before;
    bool met = false;
    if (!err)
        err = array_create(&trial, n + 3, sizeof *trial);
    if (!err)
        err = fit_slope(v, rays, ray, v->sight + n);
    for (size_t k = 0; k < rays && !err; k++)
        met = met || ray[k].inverse > 0;
    /* where nothing was met, a plane that goes on is as good as none */
    double least = err ? 0 : sight_fit_loss(rays, ray, v->sight);
    least = met ? least : TINY * share_of(rays, ray);
    if (!err)
        try_planes(v, before, was, scale, trial, &least);
    if (!err && least > ENOUGH * share_of(rays, ray)) { /* no plane */
        memcpy(trial, v->sight, (n + 3) * sizeof *trial);
        err = sight_fit(v->rays, v->ray, n + 3, trial);
        if (!err)
            take(v, before, was, trial, &least);
    }
    for (size_t k = 0; k < 3 && !err; k++)
        slope[k] = v->sight[n + k] / scale;
    free(trial);
    return err;
}

static bool is_beside(const struct view *v)
{
    for (size_t i = 0; i < v->about; i++)
        if (outside_is_blocked(&v->job->outside, v->slot[i] / 4))
            return true;
    return false;
}

/* -- a probe ---------------------------------------------------------------------------------- */

/* Brings the numbers of a probe that all but touches a surface into the range of halves: as if the
 * surface were that much farther. */
static void limit(struct view *v)
{
    const double most = 60000;
    double largest = 0, *slope = v->job->slope + 3 * v->probe;
    for (size_t n = 0; n < v->neighbours; n++)
        largest = fmax(largest, fabs(v->sight[n]));
    if (!(largest > most))
        return;
    for (size_t n = 0; n < v->neighbours; n++)
        v->sight[n] *= most / largest;
    for (int k = 0; k < 3; k++)
        slope[k] *= most / largest;
}

static struct error *look_around(void *context, size_t probe, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct view v;
    bool blocked = false;
    if (job->wanted && !job->wanted[probe])
        return interrupt_error();
    struct error *err = view_init(&v, job, probe);
    const bool beyond = !err && v.job->outside.count && is_beside(&v);
    if (!err && (beyond || has_surfaces(&v))) {
        for (size_t i = 0; i < v.about && !err; i++)
            err = look_through(&v, i);
        for (size_t k = 0; k < v.rays; k++)
            blocked = blocked || v.ray[k].inverse > 0;
    }
    if (blocked && !err)
        err = sight_fit(v.rays, v.ray, v.neighbours, v.sight);
    if (beyond && !err)
        err = fit_outside(&v);
    limit(&v);
    for (size_t i = 0; i < v.about && (blocked || beyond) && !err; i++)
        store(&v, i);
    view_clear(&v);
    return err ? err : interrupt_error();
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

/* Gives each cell of the hull the slopes of its probes, and a stand-in; where there are none of
 * either, nothing. */
static struct error *store_outside(struct sights *sights, const struct job *job, int threads)
{
    const struct leak_mesh *mesh = job->mesh;
    bool any = false;
    if (!job->outside.count)
        return NULL;
    struct error *err =
        array_create(&sights->outside, 12 * mesh->cell_count, sizeof *sights->outside);
    if (!err)
        err = array_create(&sights->stand_in_outside, mesh->cell_count,
                           sizeof *sights->stand_in_outside);
    for (size_t slot = 0; slot < 4 * mesh->cell_count && !err; slot++) {
        const int32_t *neighbour = mesh->neighbour + slot / 4 * 4;
        const bool hull = neighbour[0] < 0 || neighbour[1] < 0 || neighbour[2] < 0 ||
                          neighbour[3] < 0;
        for (size_t k = 0; k < 3 && hull; k++)
            sights->outside[3 * slot + k] = (float)job->slope[3 * (size_t)mesh->vertex[slot] + k];
    }
    if (!err)
        err = stand_in_find_outside(sights->stand_in_outside, sights->sight, sights->outside,
                                    job->tracer, &job->outside, &job->stars, threads);
    for (size_t cell = 0; cell < mesh->cell_count && !err; cell++) {
        any = any || sights->stand_in_outside[cell] >= 0;
        for (size_t k = 0; k < 12; k++)
            any = any || sights->outside[12 * cell + k] != 0;
    }
    if (!any) {
        free(sights->outside);
        free(sights->stand_in_outside);
        sights->outside = NULL;
        sights->stand_in_outside = NULL;
    }
    return err;
}

/* Finds the probes of some cells, and those of the hull, which may lend each other stand-ins. */
static struct error *find_wanted(struct job *job, const bool *cell)
{
    const struct leak_mesh *mesh = job->mesh;
    const size_t corners = (size_t)mesh->corners;
    if (!cell)
        return NULL;
    struct error *err = array_create(&job->wanted, mesh->probe_count, sizeof *job->wanted);
    for (size_t i = 0; i < mesh->cell_count && !err; i++) {
        bool wanted = cell[i];
        for (size_t k = 0; k < corners; k++)
            wanted = wanted || (mesh->neighbour && mesh->neighbour[corners * i + k] < 0);
        for (size_t k = 0; k < corners && wanted; k++)
            job->wanted[mesh->vertex[corners * i + k]] = true;
    }
    return err;
}

struct error *sight_find(struct sights *sights, const struct tracer *tracer,
                         const struct leak_mesh *mesh, int threads)
{
    return sight_find_some(sights, tracer, mesh, NULL, threads);
}

struct error *sight_find_some(struct sights *sights, const struct tracer *tracer,
                              const struct leak_mesh *mesh, const bool *cell, int threads)
{
    struct job job = {.tracer = tracer, .mesh = mesh};
    const size_t width = (size_t)sight_width(mesh->corners);
    *sights = (struct sights){0};
    choose_spots(&job);
    struct error *err = find_wanted(&job, cell);
    if (!err)
        err = stars_init(&job.stars, mesh);
    if (!err)
        err = array_create(&sights->sight, width * mesh->cell_count, sizeof *sights->sight);
    job.sight = sights->sight;
    if (!err)
        err = array_create(&job.entered, mesh->cell_count, sizeof *job.entered);
    if (!err)
        err = threads_for(threads, mesh->cell_count, look_for_surfaces, &job);
    if (!err)
        err = outside_init(&job.outside, tracer, mesh, threads);
    if (!err)
        err = array_create(&job.slope, 3 * mesh->probe_count, sizeof *job.slope);
    if (!err)
        err = threads_for(threads, mesh->probe_count, look_around, &job);
    if (!err)
        err = array_create(&sights->stand_in, mesh->cell_count, sizeof *sights->stand_in);
    if (!err)
        err = stand_in_find(sights->stand_in, sights->sight, tracer, mesh, &job.stars, threads);
    if (!err)
        err = store_outside(sights, &job, threads);
    for (size_t n = 0; n < mesh->cell_count && !err; n++) {
        bool walled = false;
        for (size_t i = 0; i < width; i++)
            walled = walled || sights->sight[width * n + i] > 1;
        sights->walled += walled;
        sights->stood_in += sights->stand_in[n] >= 0;
    }
    free(job.wanted);
    free(job.entered);
    free(job.slope);
    outside_clear(&job.outside);
    stars_clear(&job.stars);
    if (err)
        sights_clear(sights);
    return err;
}

void sights_clear(struct sights *sights)
{
    free(sights->sight);
    free(sights->stand_in);
    free(sights->outside);
    free(sights->stand_in_outside);
    *sights = (struct sights){0};
}
