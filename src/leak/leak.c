/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Sukys, "Light probe cloud generation for games", Chalmers 2014, sec. 3.2.2. */
#include "leak/leak.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "leak/shadow.h"
#include "math/cubes.h"
#include "math/sort.h"
#include "math/vec.h"
#include "trace/trace.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

const int leak_edge[5][6][2] = {[2] = {{0, 1}},
                                [3] = {{0, 1}, {0, 2}, {1, 2}},
                                [4] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

int leak_edges_of(int corners)
{
    return corners * (corners - 1) / 2;
}

/* -- edges ------------------------------------------------------------------------------------ */

struct edge {
    int32_t low, high; /* rows */
    uint32_t slot;     /* 6 * cell + edge of the cell */
};

static int compare_edges(const void *a, const void *b)
{
    const struct edge *e = a, *f = b;
    if (e->high != f->high)
        return e->high < f->high ? -1 : 1;
    return e->slot < f->slot ? -1 : e->slot > f->slot;
}

/* The i-th of all edges, by cells. */
static struct edge edge_of(const struct leak_mesh *mesh, size_t i)
{
    const size_t corners = (size_t)mesh->corners, each = (size_t)leak_edges_of(mesh->corners);
    const int32_t *v = mesh->vertex + i / each * corners;
    const int *edge = leak_edge[corners][i % each];
    const int32_t a = v[edge[0]], b = v[edge[1]];
    return (struct edge){.low = a < b ? a : b, .high = a < b ? b : a, .slot = (uint32_t)i};
}

/* All edges of all cells, sorted: those of several cells stand together. They are put where those
 * of their low end are, which are few, and sorted there: n log n of a million probes' 30 million
 * would take longer than to look along them. */
static struct error *list_edges(const struct leak_mesh *mesh, struct edge **edges, size_t *count)
{
    size_t *end = NULL;
    *count = (size_t)leak_edges_of(mesh->corners) * mesh->cell_count;
    if (mesh->cell_count > UINT32_MAX / 6)
        return error_new("more than %u cells", UINT32_MAX / 6);
    struct error *err = array_create(edges, *count, sizeof **edges);
    if (!err)
        err = array_create(&end, mesh->probe_count + 1, sizeof *end);
    for (size_t i = 0; i < *count && !err; i++)
        end[edge_of(mesh, i).low + 1]++;
    for (size_t p = 0; p < mesh->probe_count && !err; p++)
        end[p + 1] += end[p]; /* where those of p end, and where the next begin */
    for (size_t i = 0; i < *count && !err; i++) {
        const struct edge edge = edge_of(mesh, i);
        (*edges)[end[edge.low]++] = edge; /* now where they begin, until all are there */
    }
    for (size_t p = 0; p < mesh->probe_count && !err; p++) {
        const size_t first = p ? end[p - 1] : 0;
        qsort(*edges + first, end[p] - first, sizeof **edges, compare_edges);
    }
    free(end);
    return err;
}

static bool same_edge(const struct edge *a, const struct edge *b)
{
    return a->low == b->low && a->high == b->high;
}

struct error *leak_settings_for(struct leak_settings *settings, const struct leak_mesh *mesh)
{
    const double *position = mesh->position;
    struct edge *edges = NULL;
    double *length = NULL;
    size_t count = 0, all = 0;
    struct error *err = list_edges(mesh, &edges, &all);
    if (!err)
        err = array_create(&length, all, sizeof *length);
    for (size_t i = 0; i < all && !err; i++) {
        if (i && same_edge(&edges[i - 1], &edges[i]))
            continue;
        length[count++] = vec3_length(vec3_sub(vec3_load(position + 3 * (size_t)edges[i].high),
                                               vec3_load(position + 3 * (size_t)edges[i].low)));
    }
    if (!err)
        sort_doubles(count, length);
    const double median = err || !count ? 0 : length[count / 2];
    *settings = (struct leak_settings){.graze = 0.1,
                                       .margin = 0.1,
                                       .offset = 0.05 * median,
                                       .separation = 0.5 * median,
                                       .threads = 1};
    free(edges);
    free(length);
    return err;
}

/* -- looking along edges ---------------------------------------------------------------------- */

/* What the rays along one edge found. */
struct finding {
    bool crossed, leaking;
    const struct scene_light *lamp; /* whose shadow has its border here; NULL: no border */
    bool lit[2];                    /* it shines on the side of the low, the high end */
    /* a probe can stand before the surface, on the side of the low, the high end */
    bool stands[2];
    bool asks[2]; /* and is asked for: the end is far from the surface */
    /* how far light does, from surfaces, or borders, to ends that are far from them */
    double leaks;
    struct vec3 probe[2]; /* where */
};

struct look {
    const struct tracer *tracer;
    const struct leak_settings *settings;
    const double *position;
    int corners; /* of a cell */
    const struct edge *edges;
    const size_t *first; /* of each distinct edge, in edges */
    struct finding *finding;
};

/* Off the surface on the side of the unit normal n, by the offset, or half way to what is in front
 * of it. */
static struct vec3 stand_off(const struct look *look, struct vec3 on_surface, struct vec3 n)
{
    double from[3], direction[3];
    const double offset = look->settings->offset;
    vec3_store(from, vec3_fma(on_surface, offset * 1e-3, n));
    vec3_store(direction, n);
    const struct trace_hit ahead = trace_nearest(look->tracer, from, direction, 2 * offset);
    return vec3_fma(on_surface, ahead.hit ? ahead.distance / 2 : offset, n);
}

/* On the edge, so that what is added to probes in a plane or on a line stays there: off it by
 * little, it would make space of the plane, and slivers of the cells. Off the surface by the offset
 * all the same, or half way. */
static struct vec3 stand_on_edge(const struct look *look, struct vec3 a, struct vec3 direction,
                                 double distance, double cosine)
{
    return vec3_fma(a, distance - fmin(look->settings->offset / fabs(cosine), distance / 2),
                    direction);
}

/* The ray from `a` towards `b`, whose findings are those of `side`. */
static void look_from(const struct look *look, struct vec3 a, struct vec3 b, int side,
                      struct finding *f)
{
    const struct vec3 way = vec3_sub(b, a);
    const double length = vec3_length(way);
    const struct vec3 direction = vec3_scale(1 / length, way);
    double from[3], along[3];
    vec3_store(from, a);
    vec3_store(along, direction);
    const struct trace_hit hit = trace_nearest(look->tracer, from, along, length);
    if (!hit.hit)
        return;
    f->crossed = true;
    const double cosine = vec3_dot(hit.normal, direction);
    if (fabs(cosine) < look->settings->graze)
        return;
    f->stands[side] = true;
    f->asks[side] = hit.distance >= look->settings->margin * length &&
                    hit.distance * fabs(cosine) >= 2 * look->settings->offset;
    f->leaks += f->asks[side] ? hit.distance : 0;
    /* On the edge itself, not where the hit was rounded to: probes of a plane's grid stay in that
     * plane, else its hull would be all slivers. */
    const struct vec3 on_edge = vec3_fma(a, hit.distance, direction),
                      facing = vec3_scale(cosine < 0 ? 1 : -1, hit.normal);
    f->probe[side] = look->corners < 4 ? stand_on_edge(look, a, direction, hit.distance, cosine)
                                       : stand_off(look, on_edge, facing);
}

/* A pair about the border of a shadow. */
static void look_for_shadow(const struct look *look, struct vec3 low, struct vec3 high,
                            struct finding *f)
{
    const struct leak_settings *s = look->settings;
    const struct vec3 way = vec3_sub(high, low);
    const double length = vec3_length(way), far = fmax(s->margin * length, 2 * s->offset);
    const struct shadow_border border =
        shadow_find(look->tracer, low, high, s->graze, s->offset / 8);
    if (!border.lamp)
        return;
    f->lamp = border.lamp;
    for (int side = 0; side < 2; side++) {
        const double distance = side ? length - border.distance : border.distance,
                     off = fmin(s->offset, distance / 2);
        f->lit[side] = border.lit == !side;
        f->stands[side] = true;
        f->asks[side] = distance >= far;
        f->leaks += f->asks[side] ? distance : 0;
        f->probe[side] = vec3_fma(low, (border.distance + (side ? off : -off)) / length, way);
    }
}

static struct error *look_along(void *context, size_t index, int thread)
{
    (void)thread;
    const struct look *look = context;
    const struct edge *edge = &look->edges[look->first[index]];
    const struct vec3 low = vec3_load(look->position + 3 * (size_t)edge->low),
                      high = vec3_load(look->position + 3 * (size_t)edge->high);
    struct finding *f = &look->finding[index];
    look_from(look, low, high, 0, f);
    look_from(look, high, low, 1, f);
    f->leaking = f->asks[0] || f->asks[1];
    if (look->settings->edges == LEAK_SHADOWS)
        f->asks[0] = f->asks[1] = f->stands[0] = f->stands[1] = false;
    if (look->settings->edges != LEAK_WALLS && !f->crossed)
        look_for_shadow(look, low, high, f);
    return NULL;
}

/* -- choosing probes -------------------------------------------------------------------------- */

struct view {
    const struct tracer *tracer;
    const double *from;
    const struct scene_light *lamp; /* NULL: none asks */
    bool lit;                       /* by it, on this side of its shadow's border */
};

static bool sees(void *context, const double *point)
{
    const struct view *view = context;
    return trace_visibility(view->tracer, view->from, point) > 0 &&
           (!view->lamp || shadow_lit(view->tracer, view->lamp, vec3_load(point)) == view->lit);
}

/* Whether a probe nearer than `reach` (at most a cube's size) is seen from where that of a side
 * would stand: it stands for it, on the same side. */
static bool is_served(const struct cubes *c, const struct tracer *tracer, const struct finding *f,
                      int side, double reach)
{
    double at[3];
    vec3_store(at, f->probe[side]);
    struct view view = {tracer, at, f->lamp, f->lit[side]};
    return cubes_find(c, at, reach, sees, &view, NULL);
}

static int compare_positions(struct vec3 p, struct vec3 q)
{
    if (p.x != q.x)
        return p.x < q.x ? -1 : 1;
    if (p.y != q.y)
        return p.y < q.y ? -1 : 1;
    return p.z < q.z ? -1 : p.z > q.z;
}

/* An edge that asks for probes. */
struct leak_candidate {
    struct vec3 position; /* of the first probe that it asks for, in canonical order */
    struct finding finding;
};

static int compare_candidates(const void *a, const void *b)
{
    return compare_positions(((const struct leak_candidate *)a)->position,
                             ((const struct leak_candidate *)b)->position);
}

/* The worst first. */
static int compare_worst(const void *a, const void *b)
{
    const struct leak_candidate *c = a, *d = b;
    if (c->finding.leaks != d->finding.leaks)
        return c->finding.leaks > d->finding.leaks ? -1 : 1;
    return compare_candidates(a, b);
}

static struct leak_candidate make_candidate(const struct finding *f)
{
    const int first = !f->asks[0] ||
                      (f->asks[1] && compare_positions(f->probe[1], f->probe[0]) < 0);
    return (struct leak_candidate){f->probe[first], *f};
}

/* Counts what the edges ask for, and lists those that do. */
static struct error *list_candidates(const struct finding *finding, struct leaks *leaks)
{
    size_t count = 0;
    for (size_t i = 0; i < leaks->edges; i++) {
        const struct finding *f = &finding[i];
        const bool asks = f->asks[0] || f->asks[1];
        leaks->crossed += f->crossed;
        leaks->leaking += f->leaking;
        leaks->shadowed += asks && f->lamp;
        leaks->asking += asks;
    }
    struct error *err = array_create(&leaks->candidate, leaks->asking, sizeof *leaks->candidate);
    for (size_t i = 0; i < leaks->edges && !err; i++)
        if (finding[i].asks[0] || finding[i].asks[1])
            leaks->candidate[count++] = make_candidate(&finding[i]);
    if (count)
        qsort(leaks->candidate, count, sizeof *leaks->candidate, compare_candidates);
    return err;
}

/* What probes are chosen from, and among. */
struct choosing {
    const struct tracer *tracer;
    const struct leak_settings *settings;
    const struct leak_mesh *mesh;
    const struct leak_room *room;
};

static bool is_wanted(const struct choosing *c, const struct cubes *cubes, const struct finding *f)
{
    for (int side = 0; side < 2; side++)
        if (f->asks[side] && !is_served(cubes, c->tracer, f, side, c->settings->separation))
            return true;
    return false;
}

/* Whether a side still needs its probe. They come in pairs, one on each side of the wall: a probe
 * at a wall without a twin behind it would be joined, through the wall, to probes far away. */
static bool needs(const struct choosing *c, const struct cubes *cubes, const struct finding *f,
                  int side)
{
    const double twin_reach = fmin(2 * c->settings->offset, c->settings->separation);
    return f->stands[side] && !is_served(cubes, c->tracer, f, side, twin_reach);
}

static struct error *may_stand(const struct choosing *c, const double p[3], bool *is_free)
{
    *is_free = true;
    return c->room->is_free ? c->room->is_free(c->room->context, p, is_free) : NULL;
}

/* Takes candidates in their order, each unless what it asks for is near already, as many as there
 * is room for. What may not stand takes no room, and is not asked for again. halves: one of a pair
 * may go in, that at the edge's far end, where there is no room for the other. */
static struct error *take(const struct choosing *c, const struct leak_candidate *candidate,
                          size_t count, size_t most, bool halves, struct leak_choice *choice)
{
    struct cubes cubes = {0};
    const size_t probes = c->mesh->probe_count;
    struct error *err = cubes_init(&cubes, c->settings->separation, probes + 2 * count);
    choice->count = choice->past = 0;
    for (size_t i = 0; i < probes && !err; i++)
        cubes_add(&cubes, c->mesh->position + 3 * i);
    for (size_t i = 0; i < count && choice->count < most && !err; i++) {
        const struct finding *f = &candidate[i].finding;
        if (!is_wanted(c, &cubes, f))
            continue;
        const bool half = most - choice->count < 2 && needs(c, &cubes, f, 0) &&
                          needs(c, &cubes, f, 1);
        if (half && !halves)
            continue; /* there is no room for a pair; another may want one alone */
        /* whichever row has the smaller number */
        const int first = half && f->asks[0] != f->asks[1]
                              ? f->asks[1]
                              : compare_positions(f->probe[0], f->probe[1]) > 0;
        for (int turn = 0; turn < 2 && choice->count < most && !err; turn++) {
            const int side = turn ? !first : first;
            if (!needs(c, &cubes, f, side))
                continue;
            double *added = choice->probe + 3 * choice->count;
            bool is_free;
            vec3_store(added, f->probe[side]);
            cubes_add(&cubes, added);
            err = may_stand(c, added, &is_free);
            choice->count += !err && is_free;
        }
        choice->past = i + 1;
    }
    cubes_clear(&cubes);
    return err;
}

struct error *leak_choose(struct leak_choice *choice, const struct leaks *leaks,
                          const struct tracer *tracer, const struct leak_settings *settings,
                          const struct leak_mesh *mesh, const struct leak_room *room)
{
    const size_t count = leaks->asking;
    const struct choosing c = {tracer, settings, mesh, room};
    const size_t past = room->past < count ? room->past : count;
    struct leak_candidate *worst = NULL;
    *choice = (struct leak_choice){0};
    struct error *err = array_create(&choice->probe, 6 * count, sizeof *choice->probe);
    if (!err)
        err = take(&c, leaks->candidate, count, SIZE_MAX, false, choice);
    choice->asked = choice->count;
    if (!err && choice->asked > room->most) {
        err = array_create(&worst, count, sizeof *worst);
        if (!err) {
            memcpy(worst, leaks->candidate, count * sizeof *worst);
            qsort(worst, count, sizeof *worst, compare_worst);
            err = take(&c, worst + past, count - past, room->most, false, choice);
            if (!err && !choice->count)
                err = take(&c, worst + past, count - past, room->most, true, choice);
            choice->past += past;
        }
        free(worst);
    }
    if (err)
        leak_choice_clear(choice);
    return err;
}

void leak_choice_clear(struct leak_choice *choice)
{
    free(choice->probe);
    *choice = (struct leak_choice){0};
}

/* -- all together ----------------------------------------------------------------------------- */

struct error *leak_find(struct leaks *leaks, const struct tracer *tracer,
                        const struct leak_settings *settings, const struct leak_mesh *mesh)
{
    *leaks = (struct leaks){0};
    struct edge *edges = NULL;
    size_t *first = NULL;
    struct look look = {.tracer = tracer,
                        .settings = settings,
                        .position = mesh->position,
                        .corners = mesh->corners};
    size_t all = 0;
    struct error *err = list_edges(mesh, &edges, &all);
    if (!err)
        err = array_create(&first, all + 1, sizeof *first);
    for (size_t i = 0; i < all && !err; i++)
        if (!i || !same_edge(&edges[i - 1], &edges[i]))
            first[leaks->edges++] = i;
    if (!err) {
        first[leaks->edges] = all;
        err = array_create(&look.finding, leaks->edges, sizeof *look.finding);
    }
    look.edges = edges;
    look.first = first;
    if (!err)
        err = threads_for(settings->threads, leaks->edges, look_along, &look);
    if (!err)
        err = array_create(&leaks->cell_edges, all, sizeof *leaks->cell_edges);
    for (size_t e = 0; e < leaks->edges && !err; e++)
        for (size_t i = first[e]; i < first[e + 1]; i++)
            leaks->cell_edges[edges[i].slot] = look.finding[e].leaking ? 2
                                                                       : look.finding[e].crossed;
    if (!err)
        err = list_candidates(look.finding, leaks);
    free(look.finding);
    free(first);
    free(edges);
    if (err)
        leaks_clear(leaks);
    return err;
}

void leaks_clear(struct leaks *leaks)
{
    free(leaks->cell_edges);
    free(leaks->candidate);
    *leaks = (struct leaks){0};
}
