/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "math/vec.h"
#include "place/place_method.h"
#include "stream/points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A given point. */
struct knot {
    struct vec3 p;
    double t;          /* its time, or how far along the given points it is */
    struct vec3 slope; /* by t; where there is a spline */
};

struct path {
    struct knot *knot; /* owned; and so is: */
    size_t count, capacity;
    bool timed;
    double *time; /* of each probe */
    size_t times, time_capacity;
};

static struct error *take(void *context, const struct points *points, const double *value,
                          size_t width, size_t count)
{
    struct path *path = context;
    struct error *err = NULL;
    path->timed = width == 4;
    for (size_t i = 0; i < count && !err; i++) {
        const double *v = value + width * i;
        const struct knot *last = path->count ? &path->knot[path->count - 1] : NULL;
        struct knot knot = {.p = vec3_load(v)};
        if (path->timed)
            knot.t = v[3];
        else if (last)
            knot.t = last->t + vec3_length(vec3_sub(knot.p, last->p));
        if (path->timed && last && !(knot.t > last->t))
            err = points_place(
                points, i,
                error_new("expected times that grow, got %.15g after %.15g", knot.t, last->t));
        if (!err)
            err = array_reserve(&path->knot, &path->capacity, path->count + 1, sizeof *path->knot);
        if (!err)
            path->knot[path->count++] = knot;
    }
    return err;
}

/* Slopes of the parabolas through each point and its neighbours, at the ends through the last
 * three: Catmull and Rom's where times are even. A point that is given twice is a corner. */
static void find_slopes(struct path *path)
{
    struct knot *k = path->knot;
    const size_t n = path->count;
    for (size_t i = 0; i < n; i++) {
        const double before = i ? k[i].t - k[i - 1].t : 0,
                     behind = i + 1 < n ? k[i + 1].t - k[i].t : 0;
        struct vec3 slope = {0, 0, 0};
        if (before > 0)
            slope = vec3_fma(slope, behind > 0 ? behind / (before + behind) / before : 1 / before,
                             vec3_sub(k[i].p, k[i - 1].p));
        if (behind > 0)
            slope = vec3_fma(slope, before > 0 ? before / (before + behind) / behind : 1 / behind,
                             vec3_sub(k[i + 1].p, k[i].p));
        k[i].slope = slope;
    }
    for (size_t i = 0; i + 1 < n; i++) { /* ends of smooth parts: the mean slope is the secant's */
        const double h = k[i + 1].t - k[i].t;
        const bool first = !i || !(k[i].t > k[i - 1].t),
                   last = i + 2 == n || !(k[i + 2].t > k[i + 1].t);
        if (!(h > 0) || first == last)
            continue;
        const struct vec3 twice = vec3_scale(2 / h, vec3_sub(k[i + 1].p, k[i].p));
        if (first)
            k[i].slope = vec3_sub(twice, k[i + 1].slope);
        else
            k[i + 1].slope = vec3_sub(twice, k[i].slope);
    }
}

/* Hermite's cubic, at x of 0 .. 1 between two knots; without a spline the straight line. */
static struct vec3 between(const struct knot *k, bool spline, double x)
{
    const double h = k[1].t - k[0].t, y = 1 - x;
    if (!spline)
        return vec3_fma(k[0].p, x, vec3_sub(k[1].p, k[0].p));
    struct vec3 p = vec3_scale((1 + 2 * x) * y * y, k[0].p);
    p = vec3_fma(p, x * x * (1 + 2 * y), k[1].p);
    p = vec3_fma(p, h * x * y * y, k[0].slope);
    return vec3_fma(p, -h * x * x * y, k[1].slope);
}

/* Pieces of a spline between two knots, by which its length is told. */
enum { PIECES = 256 };

static struct error *append(struct place *place, struct path *path, struct vec3 p, double time)
{
    double position[3];
    vec3_store(position, p);
    struct error *err =
        array_reserve(&path->time, &path->time_capacity, path->times + 1, sizeof *path->time);
    if (!err)
        err = place_append(place, position);
    if (!err)
        path->time[path->times++] = time;
    return err;
}

/* Puts probes from knot i to before the next, at even distances along the way, or at even times
 * where these need more. *length: of the way so far. */
static struct error *place_between(struct place *place, struct path *path, size_t i,
                                   const struct place_way *way, double most, double *length)
{
    const struct knot *k = &path->knot[i];
    const double start = *length, h = k[1].t - k[0].t;
    double to[PIECES + 1] = {0}; /* length to each piece's start */
    const int pieces = way->spline ? PIECES : 1;
    for (int j = 0; j < pieces; j++)
        to[j + 1] = to[j] + vec3_length(vec3_sub(between(k, way->spline, (j + 1.0) / pieces),
                                                 between(k, way->spline, (double)j / pieces)));
    const double whole = to[pieces];
    /* none longer than the step */
    const double steps = way->step > 0 ? ceil(whole / way->step * (1 - 1e-12)) : 1,
                 times = way->interval > 0
                             ? ceil((path->timed ? h : whole) / way->interval * (1 - 1e-12))
                             : 1,
                 parts = fmax(steps, times);
    struct error *err = place_check_count((double)place->count + fmax(parts, 1), most);
    if (!err)
        err = append(place, path, k->p, path->timed ? k->t : start);
    int piece = 0;
    for (double n = 1; n < parts && !err; n++) {
        double x = n / parts;
        const double at = x * whole;
        if (steps >= times && pieces > 1 && whole > 0) {
            while (piece + 1 < pieces && to[piece + 1] < at)
                piece++;
            x = (piece + (at - to[piece]) / (to[piece + 1] - to[piece])) / pieces;
        }
        err = append(place, path, between(k, way->spline, x),
                     path->timed ? k->t + x * h : start + at);
    }
    *length += whole;
    return err;
}

struct error *place_path(struct place *place, const char *file, const struct place_way *way,
                         double most, struct warnings *warnings)
{
    struct path path = {0};
    struct column *time = NULL;
    double length = 0;
    struct error *err = points_read_all(file, POINTS_TIMED, take, &path, warnings);
    if (!err && way->spline)
        find_slopes(&path);
    for (size_t i = 0; i + 1 < path.count && !err; i++)
        err = place_between(place, &path, i, way, most, &length);
    const struct knot *last = err ? NULL : &path.knot[path.count - 1];
    if (!err)
        err = place_check_count((double)place->count + 1, most);
    if (!err)
        err = append(place, &path, last->p, path.timed ? last->t : length);
    if (!err)
        err = place_add_column(place, "time", COLUMN_F64, 1, &time);
    if (!err)
        memcpy(column_f64(time), path.time, path.times * sizeof *path.time);
    free(path.knot);
    free(path.time);
    return err;
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "step",
         .argument = "S",
         .kind = OPTION_REAL,
         .value = &o->way.step,
         .least_open = true,
         .most = INFINITY,
         .given = &o->step_given,
         .shown = "none",
         .help = "path: the greatest distance between probes along the path"},
        {.name = "interval",
         .argument = "DT",
         .kind = OPTION_REAL,
         .value = &o->way.interval,
         .least_open = true,
         .most = INFINITY,
         .given = &o->interval_given,
         .shown = "none",
         .help = "path: the greatest time between them"},
        {.name = "spline",
         .kind = OPTION_FLAG,
         .value = &o->way.spline,
         .given = &o->spline_given,
         .help = "path: a smooth way through the positions, not straight ones"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    return o->step_given || o->interval_given ? NULL
                                              : error_usage("path: expected --step or --interval");
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct error *err = place_path(place, world->file, &o->way, world->most, world->warnings);
    return err ? err : place_reach_keep(place, o, world);
}

const struct place_method place_method_path = {.name = "path",
                                               .origin = 3,
                                               .file_of = "positions",
                                               .reaches = true,
                                               .rows = rows,
                                               .check = check,
                                               .place = place_by_options};
