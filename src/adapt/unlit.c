/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/unlit.h"
#include "base/array.h"
#include "base/error.h"
#include "math/box.h"
#include "math/cubes.h"
#include "math/direction.h"
#include "math/random.h"
#include "math/sort.h"
#include "math/vec.h"
#include "trace/trace.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FOR_CENTRES = 0x71 }; /* what random numbers are for: part of their name */
enum { LLOYD_MOST = 100 };

static double square_between(const double *a, const double *b)
{
    const struct vec3 d = vec3_sub(vec3_load(a), vec3_load(b));
    return vec3_dot(d, d);
}

bool unlit_sees_surface(const struct tracer *tracer, const double p[3])
{
    enum { RAYS = 32 };
    for (int i = 0; i < RAYS; i++) {
        double d[3];
        vec3_store(d, direction_even(i, RAYS));
        if (trace_nearest(tracer, p, d, (double)INFINITY).hit)
            return true;
    }
    return false;
}

void unlit_tell(const char *program, size_t count, size_t areas, size_t clusters)
{
    fprintf(stderr, "%s: %zu black probes in %zu areas: %zu stand for them\n", program, count,
            areas, clusters);
}

/* -- reach ------------------------------------------------------------------------------------ */

/* The nearest of the points that were looked at. */
struct nearest {
    const double *from;
    double square;
};

static bool is_nearer(void *context, const double *point)
{
    struct nearest *n = context;
    const double square = square_between(point, n->from);
    if (square > 0 && square < n->square)
        n->square = square;
    return false;
}

/* Distance from each to its nearest, by cubes that grow until something is in reach. */
static double nearest_of(const struct cubes *cubes, int sizes, const double *p)
{
    struct nearest n = {p, (double)INFINITY};
    for (int i = 0; i < sizes && !(n.square < (double)INFINITY); i++)
        cubes_find(&cubes[i], p, cubes[i].size, is_nearer, &n, NULL);
    return sqrt(n.square);
}

struct error *unlit_reach(size_t count, const double *position, size_t some, const double *of,
                          double *reach)
{
    enum { SIZES = 12 };
    struct cubes cubes[SIZES] = {0};
    const struct box box = box_of(count, position);
    double *distance = NULL;
    struct error *err = array_create(&distance, some, sizeof *distance);
    *reach = 0;
    const double side = count > 1 ? box_side(&box) : 0;
    for (int s = 0; s < SIZES && !err; s++) {
        err = cubes_init(&cubes[s], fmax(side * exp2(s + 2 - SIZES), 1e-300), count);
        for (size_t i = 0; i < count && !err; i++)
            cubes_add(&cubes[s], position + 3 * i);
    }
    for (size_t i = 0; i < some && !err; i++)
        distance[i] = nearest_of(cubes, SIZES, of + 3 * i);
    if (!err && side > 0 && some) {
        sort_doubles(some, distance);
        *reach = 2 * distance[some / 2];
    }
    for (int s = 0; s < SIZES; s++)
        cubes_clear(&cubes[s]);
    free(distance);
    return err;
}

/* -- areas ------------------------------------------------------------------------------------ */

struct areas {
    const struct unlit_job *job;
    struct cubes cubes;
    uint32_t *parent; /* of each probe, up to the least of its area */
    uint32_t probe;   /* that is being joined to others */
};

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

static bool are_in_sight(const struct tracer *tracer, const double *a, const double *b)
{
    const struct vec3 way = vec3_sub(vec3_load(b), vec3_load(a));
    const double length = vec3_length(way);
    double d[3];
    vec3_store(d, vec3_scale(1 / length, way));
    return !tracer || !(length > 0) || !trace_nearest(tracer, a, d, length).hit;
}

static bool join(void *context, const double *point)
{
    struct areas *areas = context;
    const uint32_t other = (uint32_t)((point - areas->cubes.point) / 3);
    const uint32_t a = root_of(areas->parent, areas->probe), b = root_of(areas->parent, other);
    if (a != b &&
        are_in_sight(areas->job->tracer, areas->job->position + 3 * (size_t)areas->probe, point))
        areas->parent[a > b ? a : b] = a > b ? b : a;
    return false;
}

/* area[i]: the number of the probe's area, from 0 in order of their first probes. */
static struct error *find_areas(const struct unlit_job *job, uint32_t *area, size_t *count)
{
    struct areas areas = {.job = job, .parent = area};
    const double reach = fmax(job->reach, 1e-300);
    struct error *err = cubes_init(&areas.cubes, reach, job->count);
    for (size_t i = 0; i < job->count && !err; i++)
        cubes_add(&areas.cubes, job->position + 3 * i);
    for (uint32_t i = 0; i < job->count; i++)
        area[i] = i;
    for (areas.probe = 0; areas.probe < job->count && !err; areas.probe++)
        cubes_find(&areas.cubes, job->position + 3 * (size_t)areas.probe, reach, join, &areas,
                   NULL);
    cubes_clear(&areas.cubes);
    for (uint32_t i = 0; i < job->count; i++)
        area[i] = root_of(area, i);
    *count = 0; /* roots come before what they are the roots of */
    for (uint32_t i = 0; i < job->count; i++)
        area[i] = area[i] == i ? (uint32_t)(*count)++ : area[area[i]];
    return err;
}

/* -- clusters --------------------------------------------------------------------------------- */

/* Probes, their areas, and the centres. */
struct clusters {
    const struct unlit_job *job;
    const uint32_t *area;
    double *centre; /* 3 each; owned, as the next ones are */
    uint32_t *of;   /* area of each centre */
    size_t count, most;
    uint32_t *mine; /* centre of each probe; most: none */
    double *square; /* of the distance to it */
};

/* Gives each probe to the nearest centre of its area from number `first` on, where that is nearer
 * than what it has; whether any changed. */
static bool assign(struct clusters *c, size_t first)
{
    bool changed = false;
    for (size_t i = 0; i < c->job->count; i++) {
        const double *p = c->job->position + 3 * i;
        uint32_t best = first ? c->mine[i] : (uint32_t)c->most;
        double least = first ? c->square[i] : (double)INFINITY;
        for (size_t k = first; k < c->count; k++) {
            const double square = c->of[k] == c->area[i] ? square_between(p, c->centre + 3 * k)
                                                         : (double)INFINITY;
            if (square < least) {
                least = square;
                best = (uint32_t)k;
            }
        }
        changed = changed || best != c->mine[i];
        c->mine[i] = best;
        c->square[i] = least;
    }
    return changed;
}

static void add_centre(struct clusters *c, size_t probe)
{
    memcpy(c->centre + 3 * c->count, c->job->position + 3 * probe, 3 * sizeof *c->centre);
    c->of[c->count++] = c->area[probe];
    assign(c, c->count - 1);
}

/* Draws a probe with probability by squared distance; returns job->count where all are at
 * centres. */
static size_t draw(const struct clusters *c, struct random *r)
{
    double sum = 0;
    for (size_t i = 0; i < c->job->count; i++)
        sum += isfinite(c->square[i]) ? c->square[i] : 0;
    double left = sum * random_double(r);
    for (size_t i = 0; i < c->job->count && sum > 0; i++) {
        left -= isfinite(c->square[i]) ? c->square[i] : 0;
        if (left < 0)
            return i;
    }
    return c->job->count;
}

/* Moves centres to the means of what is theirs. */
static void move_centres(struct clusters *c)
{
    for (size_t k = 0; k < c->count; k++) {
        struct vec3 sum = {0};
        size_t count = 0;
        for (size_t i = 0; i < c->job->count; i++)
            if (c->mine[i] == k) {
                sum = vec3_add(sum, vec3_load(c->job->position + 3 * i));
                count++;
            }
        if (count)
            vec3_store(c->centre + 3 * k, vec3_scale(1 / (double)count, sum));
    }
}

static int compare_clusters(const void *left, const void *right)
{
    const struct unlit_cluster *a = left, *b = right;
    if (a->size != b->size)
        return a->size > b->size ? -1 : 1;
    return (a->probe > b->probe) - (a->probe < b->probe);
}

/* The probe nearest to each centre stands for what is its. */
static size_t stand_for(const struct clusters *c, struct unlit_cluster *cluster)
{
    size_t found = 0;
    for (size_t k = 0; k < c->count; k++) {
        struct unlit_cluster *now = &cluster[found];
        double least = (double)INFINITY;
        *now = (struct unlit_cluster){0};
        for (size_t i = 0; i < c->job->count; i++) {
            if (c->mine[i] != k)
                continue;
            const double square = square_between(c->job->position + 3 * i, c->centre + 3 * k);
            now->size++;
            if (square < least) {
                least = square;
                now->probe = (uint32_t)i;
            }
        }
        found += now->size > 0;
    }
    qsort(cluster, found, sizeof *cluster, compare_clusters);
    return found;
}

/* A centre for each of the largest areas, and then as many as are wanted. */
static void find_centres(struct clusters *c, const struct unlit_cluster *area, size_t areas)
{
    struct random r = random_start(c->job->seed, FOR_CENTRES, 0);
    for (size_t i = 0; i < c->job->count; i++) {
        c->mine[i] = (uint32_t)c->most;
        c->square[i] = (double)INFINITY;
    }
    for (size_t a = 0; a < areas && c->count < c->most; a++)
        add_centre(c, area[a].probe);
    for (size_t next = 0; c->count < c->most && (next = draw(c, &r)) < c->job->count;)
        add_centre(c, next);
    for (int round = 0; round < LLOYD_MOST; round++) {
        move_centres(c);
        if (!assign(c, 0))
            break;
    }
}

/* The areas by size, with the first probe of each. */
static struct error *list_areas(const struct unlit_job *job, const uint32_t *area, size_t count,
                                struct unlit_cluster **list)
{
    struct error *err = array_create(list, count, sizeof **list);
    for (size_t i = 0; i < job->count && !err; i++) {
        struct unlit_cluster *a = &(*list)[area[i]];
        if (!a->size++)
            a->probe = (uint32_t)i;
    }
    if (!err)
        qsort(*list, count, sizeof **list, compare_clusters);
    return err;
}

struct error *unlit_find(const struct unlit_job *job, struct unlit_cluster **cluster,
                         size_t *clusters, size_t *areas)
{
    struct clusters c = {.job = job};
    struct unlit_cluster *list = NULL;
    uint32_t *area = NULL;
    *cluster = NULL;
    *clusters = *areas = 0;
    if (!job->count)
        return NULL;
    struct error *err = array_create(&area, job->count, sizeof *area);
    if (!err)
        err = find_areas(job, area, areas);
    if (!err)
        err = list_areas(job, area, *areas, &list);
    c.area = area;
    c.most = job->wanted ? (size_t)job->wanted : *areas < UNLIT_MOST ? *areas : UNLIT_MOST;
    c.most = c.most < job->count ? c.most : job->count;
    if (!err)
        err = array_create(&c.centre, 3 * c.most, sizeof *c.centre);
    if (!err)
        err = array_create(&c.of, c.most, sizeof *c.of);
    if (!err)
        err = array_create(&c.mine, job->count, sizeof *c.mine);
    if (!err)
        err = array_create(&c.square, job->count, sizeof *c.square);
    if (!err)
        err = array_create(cluster, c.most, sizeof **cluster);
    if (!err) {
        find_centres(&c, list, *areas);
        *clusters = stand_for(&c, *cluster);
    }
    free(area);
    free(list);
    free(c.centre);
    free(c.of);
    free(c.mine);
    free(c.square);
    return err;
}
