/* SPDX-License-Identifier: Apache-2.0 */
#include "place/reach.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "math/box.h"
#include "math/hash.h"
#include "math/vec.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "place/up.h"
#include "scene/scene.h"
#include "stream/points.h"
#include "trace/trace.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a floor that a body stands on: the least cosine between its normal and up. */
#define FLOOR_LEAST .5
/* Cells from the first start that a lattice can count. */
enum { FAR = 1 << 20 };
enum { NONE = -1 };

/* Coordinates: u and v follow the up axis, as in space.h; elevation is along it. */
struct state {
    int32_t i, j;
    double low, high; /* elevations of the body's ends; high: from where it fell */
    int32_t part;     /* the start that it was first reached from; NONE: not yet */
    bool blocked;     /* no body fits */
};

struct span {
    double low, high;
};

struct reach_column {
    int32_t i, j;
    size_t first, count; /* spans */
};

struct reach {
    struct reach_settings settings;
    const struct tracer *tracer; /* borrowed, while the flood goes */
    int up, u, v;
    double way, cell, wide;            /* of up; wide: half of a column's region */
    double origin_u, origin_v, origin; /* the first start; origin: elevation */
    struct box scene;
    struct state *state; /* owned, as all that follows */
    size_t count, room;
    uint32_t *slot; /* numbers of states and 1, by hash; 0: none */
    size_t slots;
    uint32_t *order; /* of the states that were entered; the first ones were left as well */
    size_t entered, left, order_room;
    size_t comings; /* to states, again too */
    int32_t *root;  /* of each start's part: another of the same, or itself */
    size_t parts, parts_room;
    struct progress *progress; /* of the flood */
    struct span *span;
    struct reach_column *column;
    size_t columns, spans;
    uint32_t *column_slot;
    size_t column_slots;
};

/* -- hashing ---------------------------------------------------------------------------------- */

static size_t mix(int32_t i, int32_t j, int32_t k)
{
    uint64_t x = (uint64_t)(uint32_t)i << 42 ^ (uint64_t)(uint32_t)j << 21 ^ (uint32_t)k;
    x = (x ^ x >> 31) * 0x9e3779b97f4a7c15;
    x = (x ^ x >> 29) * 0xbf58476d1ce4e5b9;
    return (size_t)(x ^ x >> 32);
}

/* States of a column are told apart by elevation, in layers that no two floors share. */
static int32_t layer_of(const struct reach *r, double low)
{
    const double layer = r->settings.fly ? r->cell : r->settings.height / 4,
                 from = r->settings.fly ? low + r->settings.radius : low;
    return (int32_t)fmin(fmax(floor((from - r->origin) / layer + .5), -2e9), 2e9);
}

static void put(struct reach *r, uint32_t number)
{
    const struct state *s = &r->state[number];
    size_t at = mix(s->i, s->j, layer_of(r, s->low)) & (r->slots - 1);
    while (r->slot[at])
        at = (at + 1) & (r->slots - 1);
    r->slot[at] = number + 1;
}

/* The state of a column at that elevation; NONE: there is none. */
static int64_t find(const struct reach *r, int32_t i, int32_t j, double low)
{
    const double same = r->settings.fly ? r->cell / 2 : 1e-2 * r->settings.height;
    const int32_t middle = layer_of(r, low), around = r->settings.fly ? 0 : 1;
    for (int32_t k = middle - around; k <= middle + around && r->slots; k++)
        for (size_t at = mix(i, j, k) & (r->slots - 1); r->slot[at];
             at = (at + 1) & (r->slots - 1)) {
            const struct state *s = &r->state[r->slot[at] - 1];
            if (s->i == i && s->j == j && fabs(s->low - low) < same)
                return (int64_t)r->slot[at] - 1;
        }
    return NONE;
}

static struct error *refuse_size(const struct reach *r)
{
    return error_new("the region has more than %d cells of %g: --cell makes them larger, "
                     "--max-cells allows more (lengths are in units of the scene)",
                     r->settings.most, r->cell);
}

static struct error *add(struct reach *r, struct state state, int64_t *number)
{
    if (r->count >= (size_t)r->settings.most || abs(state.i) >= FAR || abs(state.j) >= FAR)
        return refuse_size(r);
    struct error *err = array_reserve(&r->state, &r->room, r->count + 1, sizeof *r->state);
    if (!err && 2 * (r->count + 1) > r->slots) {
        const size_t slots = r->slots ? 2 * r->slots : 1024;
        uint32_t *grown = NULL;
        err = array_create(&grown, slots, sizeof *grown);
        if (!err) {
            free(r->slot);
            r->slot = grown;
            r->slots = slots;
            for (uint32_t i = 0; i < r->count; i++)
                put(r, i);
        }
    }
    if (err)
        return err;
    *number = (int64_t)r->count;
    r->state[r->count] = state;
    put(r, (uint32_t)r->count++);
    progress_add(r->progress, 1);
    return NULL;
}

/* -- bodies ----------------------------------------------------------------------------------- */

static void point_at(const struct reach *r, double i, double j, double elevation, double p[3])
{
    p[r->u] = r->origin_u + i * r->cell;
    p[r->v] = r->origin_v + j * r->cell;
    p[r->up] = r->way * elevation;
}

/* Whether a body whose axis goes through p fits between two elevations: a pile of balls. */
static bool fits(const struct reach *r, const double p[3], double low, double high)
{
    const double radius = fmin(r->settings.radius, (high - low) / 2) * (1 - 1e-4),
                 last = high - radius, wide = 1.5 * radius;
    double q[3], at = low + radius;
    memcpy(q, p, sizeof q);
    if (!(radius > 0))
        return true;
    for (;;) {
        q[r->up] = r->way * at;
        const bool free = !trace_is_near(r->tracer, q, wide);
        if (!free && trace_is_near(r->tracer, q, radius))
            return false;
        if (at >= last)
            return true;
        /* a wide ball holds the narrower ones up to sqrt(1.5^2 - 1) of their radius off */
        at = fmin(at + (free ? 1.1 : .25) * radius, last);
    }
}

static bool ray_is_free(const struct reach *r, const double a[3], const double b[3])
{
    const struct vec3 way = vec3_sub(vec3_load(b), vec3_load(a));
    const double length = vec3_length(way);
    double d[3];
    if (!(length > 0))
        return true;
    vec3_store(d, vec3_scale(1 / length, way));
    return !trace_nearest(r->tracer, a, d, length).hit;
}

/* The floor below p, no farther down than that. */
static bool find_floor(const struct reach *r, const double p[3], double most, double *elevation)
{
    double down[3] = {0}, normal[3];
    down[r->up] = -r->way;
    const struct trace_hit hit = trace_nearest(r->tracer, p, down, most);
    if (!hit.hit)
        return false;
    vec3_store(normal, hit.normal);
    *elevation = r->way * p[r->up] - hit.distance;
    return fabs(normal[r->up]) >= FLOOR_LEAST;
}

/* -- steps ------------------------------------------------------------------------------------ */

static int32_t root_of(const struct reach *r, int32_t part)
{
    while (r->root[part] != part)
        part = r->root[part];
    return part;
}

/* A body of this part comes to a state: parts that meet become one. */
static struct error *enter(struct reach *r, uint32_t number, int32_t part)
{
    struct state *s = &r->state[number];
    r->comings++;
    if (s->part == NONE) {
        struct error *err =
            array_reserve(&r->order, &r->order_room, r->entered + 1, sizeof *r->order);
        if (err)
            return err;
        r->order[r->entered++] = number;
        s->part = part;
    }
    const int32_t a = root_of(r, s->part), b = root_of(r, part);
    r->root[a > b ? a : b] = a > b ? b : a;
    return NULL;
}

/* Goes from a point above a floor to a column that is near. *falls: the floor there is lower than a
 * step, and a body that went on at the old height would fit. */
static struct error *step(struct reach *r, double from_i, double from_j, double from, int32_t i,
                          int32_t j, int32_t part, bool *falls)
{
    const struct reach_settings *s = &r->settings;
    const double lift = s->climb + 1e-3 * s->radius, level = 1e-2 * s->height;
    double a[3], b[3], to = 0;
    *falls = false;
    point_at(r, from_i, from_j, from + lift, a);
    point_at(r, i, j, from + lift, b);
    if (!ray_is_free(r, a, b) || !find_floor(r, b, lift + s->drop, &to))
        return NULL;
    int64_t number = find(r, i, j, to);
    if (number == NONE) {
        const struct state new = {.i = i,
                                  .j = j,
                                  .low = to,
                                  .high = to + s->height,
                                  .part = NONE,
                                  .blocked = !fits(r, b, to + s->climb, to + s->height)};
        struct error *err = add(r, new, &number);
        if (err)
            return err;
    }
    struct state *state = &r->state[number];
    if (to > from + level) { /* up: its head first */
        a[r->up] = b[r->up] = r->way * (to + lift);
        if (!ray_is_free(r, a, b) || !fits(r, a, from + s->climb, to + s->height))
            return NULL;
    }
    *falls = to < from - s->climb && fits(r, b, from + s->climb, from + s->height);
    if (state->blocked)
        return NULL;
    if (to < from - level) {
        if (!fits(r, b, to + s->climb, from + s->height))
            return NULL;
        state->high = fmax(state->high, from + s->height);
    }
    return enter(r, (uint32_t)number, part);
}

/* Walks to the column beside; and where it falls, as far on as it takes to be clear of the edge. */
static struct error *walk(struct reach *r, const struct state *from, int di, int dj, int32_t part)
{
    const double far = r->settings.radius / r->cell + 1;
    bool falls = true;
    struct error *err = NULL;
    for (int n = 1; n <= far && falls && !err; n++) {
        const int32_t i = from->i + n * di, j = from->j + n * dj;
        err = step(r, from->i, from->j, from->low, i, j, part, &falls);
    }
    return err;
}

static bool in_scene(const struct reach *r, const double p[3])
{
    for (int k = 0; k < 3; k++)
        if (!(p[k] >= r->scene.low[k] && p[k] <= r->scene.high[k]))
            return false;
    return true;
}

/* Flies to a node beside where it is. */
static struct error *fly(struct reach *r, int32_t i, int32_t j, double elevation, int32_t part)
{
    const double radius = r->settings.radius;
    double p[3];
    int64_t number = find(r, i, j, elevation - radius);
    if (number == NONE) {
        point_at(r, i, j, elevation, p);
        const struct state new = {.i = i,
                                  .j = j,
                                  .low = elevation - radius,
                                  .high = elevation + radius,
                                  .part = NONE,
                                  .blocked = !in_scene(r, p) ||
                                             trace_is_near(r->tracer, p, radius * (1 - 1e-4))};
        struct error *err = add(r, new, &number);
        if (err)
            return err;
    }
    return r->state[number].blocked ? NULL : enter(r, (uint32_t)number, part);
}

/* -- the flood -------------------------------------------------------------------------------- */

/* Leaves what was entered and not yet left, by all ways: the eight or 26 nodes around it, so that a
 * gap which is wider than the body by a cell is found however it is turned. */
static struct error *flood(struct reach *r, int32_t part)
{
    const bool flies = r->settings.fly;
    const int up = flies ? 1 : 0;
    struct error *err = NULL;
    for (; r->left < r->entered && !err; r->left++) {
        const struct state from = r->state[r->order[r->left]];
        const double middle = from.low + r->settings.radius;
        for (int i = -1; i <= 1; i++)
            for (int j = -1; j <= 1; j++)
                for (int k = -up; k <= up && !err; k++) {
                    if (flies)
                        err = fly(r, from.i + i, from.j + j, middle + k * r->cell, part);
                    else if (i || j)
                        err = walk(r, &from, i, j, part);
                }
    }
    return err;
}

/* -- starts ----------------------------------------------------------------------------------- */

struct starting {
    struct reach *reach;
    const struct place_judge *judge;
};

/* How far the nearest surface is from a body's axis through p, above what it climbs. */
static double room_around(const struct reach *r, const double p[3], double floor_at)
{
    const struct reach_settings *s = &r->settings;
    const double last = floor_at + s->height - s->radius;
    double q[3], least = (double)INFINITY;
    memcpy(q, p, sizeof q);
    for (double at = fmin(floor_at + s->climb + s->radius, last);; at += s->radius / 4) {
        q[r->up] = r->way * fmin(at, last);
        least = fmin(least, trace_distance(r->tracer, q));
        if (at >= last)
            return least;
    }
}

/* Says which room a body lacks at a start, above a floor. */
static struct error *refuse_body(const struct reach *r, const double p[3], double floor_at)
{
    const struct reach_settings *s = &r->settings;
    double from[3], up[3] = {0};
    memcpy(from, p, sizeof from);
    from[r->up] = r->way * (floor_at + s->climb);
    up[r->up] = r->way;
    if (!s->fly) {
        const struct trace_hit hit = trace_nearest(r->tracer, from, up, s->height - s->climb);
        const double around = hit.hit ? 0 : room_around(r, p, floor_at);
        if (hit.hit)
            return error_new(
                "no body of height %g fits at %g %g %g: what is above the floor leaves "
                "%g (--height is in units of the scene)",
                s->height, p[0], p[1], p[2], s->climb + hit.distance);
        if (around < s->radius)
            return error_new("no body of radius %g fits at %g %g %g: a surface, higher than it "
                             "climbs, is %g from its middle (--radius and --climb are in units of "
                             "the scene)",
                             s->radius, p[0], p[1], p[2], around);
    }
    if (s->fly)
        return error_new("a ball of radius %g does not fit at %g %g %g: a surface is %g away "
                         "(--radius is in units of the scene)",
                         s->radius, p[0], p[1], p[2], trace_distance(r->tracer, p));
    return error_new("no body of radius %g and height %g fits at %g %g %g, with what is lower than "
                     "%g in its way (--radius, --height and --climb are in units of the scene)",
                     s->radius, s->height, p[0], p[1], p[2], s->climb);
}

/* Comes to one of the nodes around a start, the nearest that a body gets to. lifted: as of
 * lift_start. */
static struct error *start_at(struct reach *r, const double p[3], const double lifted[3],
                              int32_t part)
{
    const struct reach_settings *s = &r->settings;
    const double e = r->way * p[r->up], i = (p[r->u] - r->origin_u) / r->cell,
                 j = (p[r->v] - r->origin_v) / r->cell,
                 middle = floor((e - r->origin) / r->cell + .5);
    const size_t before = r->comings;
    double floor_at = 0, q[3];
    bool falls;
    struct error *err = NULL;
    const double most = s->height + s->drop;
    if (!(fmax(fabs(i), fabs(j)) < FAR && fabs(middle) < 1e9))
        return refuse_size(r);
    if (!s->fly && !find_floor(r, lifted, most + fabs(lifted[r->up] - p[r->up]), &floor_at))
        return error_new("there is no floor below %g %g %g, no farther than %g down (--height and "
                         "--drop) and not steeper than 60 degrees",
                         p[0], p[1], p[2], most);
    for (int ring = 0; ring < 9 && r->comings == before && !err; ring++) {
        static const int off[9][2] = {{0, 0}, {1, 0},  {-1, 0}, {0, 1},  {0, -1},
                                      {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
        const int32_t a = (int32_t)floor(i + .5) + off[ring][0],
                      b = (int32_t)floor(j + .5) + off[ring][1];
        const double to = r->origin + middle * r->cell;
        point_at(r, a, b, to, q);
        if (!s->fly)
            err = step(r, i, j, floor_at, a, b, part, &falls);
        else if (ray_is_free(r, p, q))
            err = fly(r, a, b, to, part);
    }
    return err || r->comings > before ? err : refuse_body(r, p, floor_at);
}

/* A start that was given at its feet, on the floor or a hair below it, is lifted into the body; one
 * right below a ceiling is not lifted through it. */
static void lift_start(const struct starting *starting, const double p[3], double lifted[3])
{
    static const double HAIR = 1e-2; /* of what it is lifted by */
    const struct reach *r = starting->reach;
    const struct reach_settings *s = &r->settings;
    const double most = fmin(s->climb > 0 ? s->climb : s->radius, s->height / 4);
    double up[3] = {0};
    memcpy(lifted, p, 3 * sizeof *p);
    up[r->up] = r->way;
    if (s->fly)
        return;
    const struct trace_hit hit = trace_nearest(r->tracer, p, up, most);
    if (hit.hit && hit.distance > HAIR * most) {
        lifted[r->up] += r->way * hit.distance / 2;
        if (hit.distance >= most / 8 || place_judge_side(starting->judge, lifted) == PLACE_AIR)
            return;
    }
    lifted[r->up] = p[r->up] + r->way * most;
}

static struct error *take_start(struct starting *starting, const double p[3])
{
    static const char *const where[] = {[PLACE_SOLID] = "inside a solid",
                                        [PLACE_BEHIND] = "under or behind an open surface",
                                        [PLACE_VOID] = "outside of a closed room"};
    struct reach *r = starting->reach;
    const double most = box_side(&r->scene);
    for (int k = 0; k < 3; k++) /* a walker may stand on its roof */
        if (!(p[k] >= r->scene.low[k] - (k == r->up ? r->settings.height : 0) - 1e-6 * most &&
              p[k] <= r->scene.high[k] + (k == r->up ? r->settings.height : 0) + 1e-6 * most))
            return error_new(
                "the start %g %g %g is outside of the scene, which is from %g %g %g to "
                "%g %g %g",
                p[0], p[1], p[2], r->scene.low[0], r->scene.low[1], r->scene.low[2],
                r->scene.high[0], r->scene.high[1], r->scene.high[2]);
    double q[3];
    lift_start(starting, p, q);
    const enum place_side side = place_judge_side(starting->judge, q);
    if (side != PLACE_AIR)
        return error_new("the start %g %g %g is %s", p[0], p[1], p[2], where[side]);
    if (!r->parts) {
        r->origin_u = p[r->u];
        r->origin_v = p[r->v];
        r->origin = r->way * p[r->up];
    }
    struct error *err = array_reserve(&r->root, &r->parts_room, r->parts + 1, sizeof *r->root);
    if (err)
        return err;
    const int32_t part = (int32_t)r->parts++;
    r->root[part] = part;
    err = start_at(r, p, q, part);
    return err ? err : flood(r, part);
}

static struct error *take(void *context, const struct points *points, const double *value,
                          size_t width, size_t count)
{
    struct error *err = NULL;
    for (size_t i = 0; i < count && !err; i++)
        err = points_place(points, i, take_start(context, value + width * i));
    return err;
}

/* Judges by even points of the scene's box, with the air that bodies need above it: an open ground
 * may be flat. */
static struct error *judge_scene(struct place_judge **judge, const struct reach *r,
                                 struct warnings *warnings)
{
    enum { ASKED = 512 };
    static const double even[3] = {0.8191725133961644, 0.6710436067037892, 0.5497004779019702};
    struct place_inside_settings settings = place_inside_default();
    struct place place = {.count = ASKED};
    struct box box = r->scene;
    double *side = r->way > 0 ? &box.high[r->up] : &box.low[r->up];
    *side += 2 * r->way * r->settings.height;
    settings.threads = r->settings.threads;
    struct error *err = array_create(&place.position, 3 * place.count, sizeof *place.position);
    for (size_t i = 0; i < place.count && !err; i++)
        for (int k = 0; k < 3; k++) {
            const double x = (double)(i + 1) * even[k];
            place.position[3 * i + (size_t)k] = box.low[k] +
                                                (box.high[k] - box.low[k]) * (x - floor(x));
        }
    if (!err)
        err = place_judge_create(judge, &place, r->tracer, &settings, NULL, warnings);
    place_clear(&place);
    return err;
}

/* -- what is left of it ----------------------------------------------------------------------- */

/* Adds what is free above the head. */
static void add_headroom(const struct reach *r, struct state *s)
{
    double p[3], up[3] = {0};
    const double from = s->high - r->settings.radius;
    point_at(r, s->i, s->j, from, p);
    up[r->up] = r->way;
    const struct trace_hit hit =
        trace_nearest(r->tracer, p, up, r->settings.radius + r->settings.headroom);
    s->high = hit.hit ? from + hit.distance : s->high + r->settings.headroom;
}

static int compare_states(const void *a, const void *b)
{
    const struct state *x = a, *y = b;
    if (x->i != y->i)
        return x->i < y->i ? -1 : 1;
    if (x->j != y->j)
        return x->j < y->j ? -1 : 1;
    return x->low < y->low ? -1 : x->low > y->low;
}

static size_t column_slot(const struct reach *r, int32_t i, int32_t j)
{
    size_t at = mix(i, j, 0) & (r->column_slots - 1);
    while (r->column_slot[at]) {
        const struct reach_column *c = &r->column[r->column_slot[at] - 1];
        if (c->i == i && c->j == j)
            break;
        at = (at + 1) & (r->column_slots - 1);
    }
    return at;
}

/* Makes columns of the states that were entered, in canonical order. */
static struct error *make_columns(struct reach *r)
{
    struct state *sorted = NULL;
    struct error *err = array_create(&sorted, r->entered, sizeof *sorted);
    if (!err)
        err = array_create(&r->span, r->entered, sizeof *r->span);
    if (!err)
        err = array_create(&r->column, r->entered, sizeof *r->column);
    for (size_t n = 0; n < r->entered && !err; n++) {
        sorted[n] = r->state[r->order[n]];
        if (!r->settings.fly)
            add_headroom(r, &sorted[n]);
    }
    if (!err)
        qsort(sorted, r->entered, sizeof *sorted, compare_states);
    for (size_t n = 0; n < r->entered && !err; n++) {
        const struct state *s = &sorted[n];
        struct reach_column *c = r->columns ? &r->column[r->columns - 1] : NULL;
        struct span *last = r->spans ? &r->span[r->spans - 1] : NULL;
        if (!c || c->i != s->i || c->j != s->j) {
            c = &r->column[r->columns++];
            *c = (struct reach_column){.i = s->i, .j = s->j, .first = r->spans};
        }
        if (c->count && s->low <= last->high) {
            last->high = fmax(last->high, s->high);
        } else {
            r->span[r->spans++] = (struct span){s->low, s->high};
            c->count++;
        }
    }
    for (r->column_slots = 16; r->column_slots < 2 * r->columns;)
        r->column_slots *= 2;
    if (!err)
        err = array_create(&r->column_slot, r->column_slots, sizeof *r->column_slot);
    for (size_t n = 0; n < r->columns && !err; n++)
        r->column_slot[column_slot(r, r->column[n].i, r->column[n].j)] = (uint32_t)n + 1;
    free(sorted);
    return err;
}

/* What a body climbs must be below its waist, or walls that it fits beside are steps to it; its
 * axis is free along the radius at both ends; and a thread is looked at for long at each place. */
static struct error *check_body(const struct reach_settings *s)
{
    enum { SLIMMEST = 1000 };
    if (s->fly)
        return NULL;
    if (!(s->climb <= s->height / 2))
        return error_new(
            "expected a step of at most half the height, %g, that the body climbs, got "
            "%g (--climb)",
            s->height / 2, s->climb);
    if (!(s->radius <= s->height / 2))
        return error_new("expected a radius of at most half the height, %g, got %g (--radius, "
                         "--height; a body that walks is no wider than high)",
                         s->height / 2, s->radius);
    return s->height <= SLIMMEST * s->radius
               ? NULL
               : error_new("expected a body at most %d times as high as its radius, got %g and %g "
                           "(--height, --radius)",
                           SLIMMEST, s->height, s->radius);
}

struct error *reach_create(struct reach **reach, const char *file, const struct tracer *tracer,
                           const struct reach_settings *settings, struct warnings *warnings)
{
    const struct scene *scene = trace_scene(tracer);
    struct reach *r = NULL;
    struct place_judge *judge = NULL;
    *reach = NULL;
    struct error *err = array_create(&r, 1, sizeof *r);
    if (err)
        return err;
    r->settings = *settings;
    r->tracer = tracer;
    r->cell = settings->cell > 0 ? settings->cell : settings->radius / 2;
    r->wide = settings->radius + r->cell / 2;
    r->up = up_axis(scene);
    r->u = (r->up + 1) % 3;
    r->v = (r->up + 2) % 3;
    r->way = up_way(scene, r->up);
    vec3_store(r->scene.low, scene->box_min);
    vec3_store(r->scene.high, scene->box_max);
    err = check_body(settings);
    if (!err)
        err = judge_scene(&judge, r, warnings);
    struct starting starting = {.reach = r, .judge = judge};
    r->progress = progress_start(!err && settings->program, settings->program, "places", 0);
    if (!err)
        err = points_read_all(file, POINTS_PLACES, take, &starting, warnings);
    progress_end(r->progress);
    if (!err)
        err = make_columns(r);
    size_t parts = 0;
    for (size_t i = 0; i < r->parts && !err; i++)
        parts += r->root[i] == (int32_t)i;
    if (parts > 1)
        warnings_add(warnings, "reach",
                     "%s: the region is cut in %zu, nobody gets from one to another: all are kept",
                     file, parts);
    place_judge_destroy(judge);
    r->tracer = NULL;
    if (err)
        reach_destroy(r);
    else
        *reach = r;
    return err;
}

void reach_destroy(struct reach *reach)
{
    if (!reach)
        return;
    free(reach->state);
    free(reach->slot);
    free(reach->order);
    free(reach->root);
    free(reach->span);
    free(reach->column);
    free(reach->column_slot);
    free(reach);
}

/* -- asking ----------------------------------------------------------------------------------- */

/* Whether a column has any of the box. */
static bool column_meets(const struct reach *r, const struct reach_column *c, const double p[3],
                         const double margin[3])
{
    const double du = fmax(fabs(p[r->u] - (r->origin_u + c->i * r->cell)) - margin[r->u], 0),
                 dv = fmax(fabs(p[r->v] - (r->origin_v + c->j * r->cell)) - margin[r->v], 0),
                 e = r->way * p[r->up];
    if (du * du + dv * dv > r->wide * r->wide)
        return false;
    for (size_t n = 0; n < c->count; n++) {
        const struct span *span = &r->span[c->first + n];
        if (span->low <= e + margin[r->up] && span->high >= e - margin[r->up])
            return true;
    }
    return false;
}

bool reach_near(const struct reach *r, const double p[3], const double margin[3])
{
    const double u = (p[r->u] - r->origin_u) / r->cell, v = (p[r->v] - r->origin_v) / r->cell,
                 wide_u = (r->wide + margin[r->u]) / r->cell,
                 wide_v = (r->wide + margin[r->v]) / r->cell;
    if (!(4 * wide_u * wide_v < (double)r->columns)) {
        for (size_t n = 0; n < r->columns; n++)
            if (column_meets(r, &r->column[n], p, margin))
                return true;
        return false;
    }
    if (!(fabs(u) < 2.0 * FAR && fabs(v) < 2.0 * FAR))
        return false;
    for (double i = ceil(u - wide_u); i <= u + wide_u; i++)
        for (double j = ceil(v - wide_v); j <= v + wide_v; j++) {
            const uint32_t number = r->column_slot[column_slot(r, (int32_t)i, (int32_t)j)];
            if (number && column_meets(r, &r->column[number - 1], p, margin))
                return true;
        }
    return false;
}

bool reach_holds(const struct reach *reach, const double p[3])
{
    static const double none[3] = {0};
    return reach_near(reach, p, none);
}

void reach_box(const struct reach *r, double low[3], double high[3])
{
    struct box box = box_empty();
    for (size_t n = 0; n < r->columns; n++) {
        const struct reach_column *c = &r->column[n];
        const struct span *first = &r->span[c->first], *last = &r->span[c->first + c->count - 1];
        double p[3];
        for (int side = -1; side <= 1; side += 2) {
            p[r->u] = r->origin_u + c->i * r->cell + side * r->wide;
            p[r->v] = r->origin_v + c->j * r->cell + side * r->wide;
            p[r->up] = r->way * (side < 0 ? first->low : last->high);
            box_add(&box, p);
        }
    }
    memcpy(low, box.low, sizeof box.low);
    memcpy(high, box.high, sizeof box.high);
}

size_t reach_count(const struct reach *reach)
{
    return reach->entered;
}

void reach_place(const struct reach *r, size_t i, double p[3])
{
    const struct state *s = &r->state[r->order[i]];
    const double half = r->settings.fly ? r->settings.radius : r->settings.height / 2;
    point_at(r, s->i, s->j, s->low + half, p);
}

struct error *reach_key(const char *file, const struct reach_settings *s, char key[REACH_KEY])
{
    const double body[] = {s->radius, s->height, s->climb, s->drop, s->headroom, s->cell, s->fly};
    struct place starts = {0};
    struct hash hash;
    struct error *err = strcmp(file, "-") ? place_points(&starts, file, (double)INFINITY, NULL)
                                          : error_usage("--reach: expected a file, which is read "
                                                        "twice, got standard input");
    hash_start(&hash, 0);
    hash_add(&hash, body, sizeof body);
    if (!err)
        hash_add(&hash, starts.position, 3 * starts.count * sizeof *starts.position);
    snprintf(key, REACH_KEY, "%016llx", (unsigned long long)hash_value(&hash));
    place_clear(&starts);
    return err;
}

/* -- options ---------------------------------------------------------------------------------- */

struct reach_settings reach_default(void)
{
    return (struct reach_settings){.radius = .3,
                                   .height = 1.8,
                                   .climb = .4,
                                   .drop = 3,
                                   .headroom = .3,
                                   .most = 4000000,
                                   .threads = 1};
}

struct option_row *reach_option_rows(struct reach_settings *s, struct option_row *row)
{
    const struct {
        const char *name;
        double *value;
        bool open; /* not 0 */
        bool *given;
        const char *shown, *help;
    } lengths[] = {
        {"radius", &s->radius, true, &s->radius_given, NULL, "reach: half the width of the body"},
        {"height", &s->height, true, &s->height_given, NULL, "reach: of the body that walks"},
        {"climb", &s->climb, false, &s->climb_given, NULL,
         "reach: the highest step that it climbs"},
        {"drop", &s->drop, false, &s->drop_given, NULL, "reach: how far it may fall"},
        {"headroom", &s->headroom, false, &s->headroom_given, NULL,
         "reach: air above its head that counts as well, where it is free"},
        {"cell", &s->cell, true, &s->cell_given, "half the radius",
         "reach: from one place where it is tried to the next"}};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
        *row++ = (struct option_row){.name = lengths[i].name,
                                     .argument = "LENGTH",
                                     .kind = OPTION_REAL,
                                     .value = lengths[i].value,
                                     .least_open = lengths[i].open,
                                     .most = 1e15,
                                     .given = lengths[i].given,
                                     .shown = lengths[i].shown,
                                     .help = lengths[i].help};
    *row++ = (struct option_row){.name = "fly",
                                 .kind = OPTION_FLAG,
                                 .value = &s->fly,
                                 .given = &s->fly_given,
                                 .help = "reach: the body is a ball that flies"};
    *row++ = (struct option_row){.name = "max-cells",
                                 .argument = "N",
                                 .kind = OPTION_INT,
                                 .value = &s->most,
                                 .least = 1,
                                 .most = INT32_MAX,
                                 .given = &s->most_given,
                                 .help = "reach: refuse to try more places"};
    return row;
}

const char *reach_option_given(const struct reach_settings *s)
{
    return s->radius_given     ? "--radius"
           : s->height_given   ? "--height"
           : s->climb_given    ? "--climb"
           : s->drop_given     ? "--drop"
           : s->headroom_given ? "--headroom"
           : s->cell_given     ? "--cell"
           : s->fly_given      ? "--fly"
           : s->most_given     ? "--max-cells"
                               : NULL;
}

struct error *reach_check_given(const struct reach_settings *s)
{
    const char *const walks = s->height_given     ? "--height"
                              : s->climb_given    ? "--climb"
                              : s->drop_given     ? "--drop"
                              : s->headroom_given ? "--headroom"
                                                  : NULL;
    return s->fly && walks ? error_usage("%s is of a body that walks: --fly is a ball, which has a "
                                         "--radius alone",
                                         walks)
                           : NULL;
}
