/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/stand_in.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "leak/leak.h"
#include "leak/outside.h"
#include "leak/stars.h"
#include "libprobe-query/sight.h"
#include "math/sort.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* POINTS of a cell, the first of LOOKED evenly spread ones that lack a probe, so that few are not
 * judged by fewer; candidates stand within RINGS cells of it, LISTED at most, and the ASKED nearest
 * are looked for from TRIED of the points, the best BEST of them from all. */
enum {
    POINTS = 64,
    LOOKED = 8 * POINTS,
    PRIME = 7919,
    RINGS = 3,
    LISTED = 1024,
    ASKED = 48,
    TRIED = 12,
    BEST = 6
};

/* A stand-in is seen from more points than what is left of the corners, by more than one: from
 * both sides of a wall a few points see little, and one may be on either. */
static const double GAIN = 1;

/* Of a cell that no point was met beyond at which one is needed: that of a cell around. */
enum { ASK = -2 };

struct job {
    const struct tracer *tracer;
    const struct leak_mesh *mesh;
    const struct stars *stars;
    const float *sight;
    const float *slope; /* outside: 12 a cell */
    const struct outside *outside;
    int32_t *stand_in;
};

/* -- points ----------------------------------------------------------------------------------- */

/* The k-th point of a cell, barycentric: evenly spread, by the gaps between sorted numbers
 * (Devroye, "Non-uniform random variate generation", 1986, ch. V, theorem 2.1) of the additive
 * sequence of three dimensions' golden ratio (Roberts, "The unreasonable effectiveness of
 * quasirandom sequences", 2018). */
static void point_of_cell(int corners, int k, double u[4])
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    double x[5] = {0};
    for (int i = 1; i < corners; i++) {
        const double y = 0.5 + (k + 1) * step[i - 1];
        x[i] = y - floor(y);
    }
    x[corners] = 1;
    sort_doubles((size_t)corners - 1, x + 1);
    for (int i = 0; i < 4; i++)
        u[i] = i < corners ? x[i + 1] - x[i] : 0;
}

static bool sees(const struct job *job, struct vec3 p, int32_t probe)
{
    double from[3];
    vec3_store(from, p);
    return trace_visibility(job->tracer, from, job->mesh->position + 3 * (size_t)probe) > 0.5f;
}

/* Points of the cell where little is left of its corners' weights. Returns how many; *served: of
 * how many of them what is left comes from corners that they see. */
static int find_points(const struct job *job, size_t cell, struct vec3 point[POINTS],
                       double *served)
{
    const int corners = job->mesh->corners;
    const size_t width = (size_t)sight_width(corners);
    const int32_t *vertex = job->mesh->vertex + (size_t)corners * cell;
    uint16_t sight[12];
    bool walled = false;
    int count = 0;
    *served = 0;
    for (size_t i = 0; i < width; i++) {
        sight[i] = half_of(job->sight[width * cell + i]);
        walled = walled || job->sight[width * cell + i] > 1;
    }
    for (int k = 0; k < LOOKED && count < POINTS && walled; k++) {
        double u[4], weight[4];
        struct vec3 p = {0};
        point_of_cell(corners, k, u);
        const double sum = sight_weights(corners, sight, u, weight);
        if (sum >= SIGHT_ENOUGH)
            continue;
        for (int i = 0; i < corners; i++)
            p = vec3_fma(p, u[i], leak_mesh_probe(job->mesh, vertex[i]));
        for (int i = 0; i < corners; i++)
            *served += weight[i] > 1e-3 * sum && sees(job, p, vertex[i]) ? weight[i] / sum : 0;
        point[count++] = p;
    }
    return count;
}

/* -- candidates ------------------------------------------------------------------------------- */

struct candidate {
    double square; /* of the distance */
    int32_t probe;
};

static int compare_candidates(const void *a, const void *b)
{
    const struct candidate *p = a, *q = b;
    if (p->square != q->square)
        return p->square < q->square ? -1 : 1;
    return p->probe < q->probe ? -1 : p->probe > q->probe;
}

/* Probes, each once: a table of their numbers + 1, by multiplicative hashing (Knuth, "The art of
 * computer programming", vol. 3, sec. 6.4). */
struct list {
    struct candidate candidate[LISTED];
    size_t count;
    int32_t table[2 * LISTED];
};

static void list(struct list *list, int32_t probe)
{
    size_t at = ((uint32_t)probe * 2654435769u) % (2 * LISTED);
    while (list->table[at] && list->table[at] != probe + 1)
        at = (at + 1) % (2 * LISTED);
    if (list->table[at] || list->count == LISTED)
        return;
    list->table[at] = probe + 1;
    list->candidate[list->count++].probe = probe;
}

/* The probes of the cell and of those around it, ring by ring, then by their distance from p. */
static void find_candidates(const struct job *job, size_t cell, struct vec3 p, struct list *found)
{
    const size_t corners = (size_t)job->mesh->corners;
    size_t begin = 0;
    found->count = 0;
    memset(found->table, 0, sizeof found->table);
    for (size_t i = 0; i < corners; i++)
        list(found, job->mesh->vertex[corners * cell + i]);
    for (int ring = 0; ring < RINGS; ring++) {
        const size_t end = found->count;
        for (; begin < end; begin++) {
            const size_t *first = job->stars->first + found->candidate[begin].probe;
            for (size_t s = first[0]; s < first[1]; s++)
                for (size_t i = 0; i < corners; i++)
                    list(found, job->mesh->vertex[job->stars->slot[s] / corners * corners + i]);
        }
    }
    for (size_t i = 0; i < found->count; i++) {
        const struct vec3 way = vec3_sub(leak_mesh_probe(job->mesh, found->candidate[i].probe), p);
        found->candidate[i].square = vec3_dot(way, way);
    }
    qsort(found->candidate, found->count, sizeof *found->candidate, compare_candidates);
}

/* From how many of the points first .. end - 1 the probe is seen. */
static int count_seen(const struct job *job, const struct vec3 *point, int first, int end,
                      int32_t probe)
{
    int seen = 0;
    for (int k = first; k < end; k++)
        seen += sees(job, point[k], probe);
    return seen;
}

/* The candidate that most of the points see, and more than `least`, of several the nearest; -1:
 * none. The first points are as evenly spread as all are. */
static int32_t choose(const struct job *job, const struct list *found, int points,
                      const struct vec3 *point, double least)
{
    const int tried = points < TRIED ? points : TRIED;
    size_t asked = found->count < ASKED ? found->count : ASKED;
    int seen[ASKED];
    int32_t chosen = -1;
    for (size_t i = 0; i < asked; i++) {
        seen[i] = count_seen(job, point, 0, tried, found->candidate[i].probe);
        if (seen[i] == tried)
            asked = i + 1;
    }
    for (int turn = 0; turn < BEST && least < points; turn++) {
        size_t best = 0;
        for (size_t i = 1; i < asked; i++)
            best = seen[i] > seen[best] ? i : best;
        if (seen[best] <= 0)
            break;
        const int32_t probe = found->candidate[best].probe;
        const int all = seen[best] + count_seen(job, point, tried, points, probe);
        if (all > least) {
            least = all;
            chosen = probe;
        }
        seen[best] = 0;
    }
    return chosen;
}

/* The one for these points, of how many of which what is left of corners is seen. */
static void find_one(const struct job *job, size_t cell, int points, const struct vec3 *point,
                     double served, double gain)
{
    struct vec3 middle = {0};
    struct list found;
    job->stand_in[cell] = -1;
    if (!points || served + gain >= points)
        return;
    for (int k = 0; k < points; k++)
        middle = vec3_fma(middle, 1.0 / points, point[k]);
    find_candidates(job, cell, middle, &found);
    job->stand_in[cell] = choose(job, &found, points, point, served + gain);
}

static struct error *look_for(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct vec3 point[POINTS];
    double served;
    const int points = find_points(job, cell, point, &served);
    find_one(job, cell, points, point, served, GAIN);
    return interrupt_error();
}

/* As find_points, of a cell of the hull, outside. */
static int find_points_outside(const struct job *job, size_t cell, struct vec3 point[POINTS],
                               double *served)
{
    const struct outside_list *list = &job->outside->by_cell;
    uint16_t sight[12];
    const float *slope = job->slope + 12 * cell;
    int count = 0;
    *served = 0;
    if (!outside_is_blocked(job->outside, cell))
        return 0;
    for (size_t i = 0; i < 12; i++)
        sight[i] = half_of(job->sight[12 * cell + i]);
    const size_t first = list->first[cell], all = list->first[cell + 1] - first,
                 stride = all % PRIME ? PRIME : 1;
    for (size_t k = 0; k < all && count < POINTS; k++) {
        /* in an order in which the first are spread over all */
        const struct outside_look *look = &job->outside->look[list->of[first + k * stride % all]];
        double off[3], weight[4];
        outside_way(job->outside, look, off);
        const double sum = sight_weights_outside(sight, slope, look->weight, off, weight);
        if (sum >= SIGHT_ENOUGH)
            continue;
        for (int i = 0; i < 4; i++)
            *served += weight[i] > 1e-3 * sum && !(look->inverse[i] > 0) ? weight[i] / sum : 0;
        point[count++] = vec3_load(look->point);
    }
    return count;
}

/* Whether something stands outside before one of the cell's corners. */
static bool has_slope(const struct job *job, size_t cell)
{
    bool any = false;
    for (size_t k = 0; k < 12; k++)
        any = any || job->slope[12 * cell + k] != 0;
    return any;
}

static struct error *look_for_outside(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct vec3 point[POINTS];
    double served;
    const int points = find_points_outside(job, cell, point, &served);
    if (points)
        find_one(job, cell, points, point, served, 0);
    else
        job->stand_in[cell] = has_slope(job, cell) ? ASK : -1;
    return interrupt_error();
}

/* The stand-in of the cell around that shares most corners and has one; -1: none has. */
static int32_t ask_around(const struct job *job, size_t cell)
{
    const int32_t *vertex = job->mesh->vertex + 4 * cell;
    int32_t found = -1;
    int most = 0;
    for (int c = 0; c < 4; c++)
        for (size_t s = job->stars->first[vertex[c]]; s < job->stars->first[vertex[c] + 1]; s++) {
            const size_t other = job->stars->slot[s] / 4;
            int shared = 0;
            for (int i = 0; i < 16 && job->stand_in[other] >= 0; i++)
                shared += vertex[i % 4] == job->mesh->vertex[4 * other + (size_t)i / 4];
            if (shared > most) {
                most = shared;
                found = job->stand_in[other];
            }
        }
    return found;
}

struct error *stand_in_find(int32_t *stand_in, const float *sight, const struct tracer *tracer,
                            const struct leak_mesh *mesh, const struct stars *stars, int threads)
{
    struct job job = {
        .tracer = tracer, .mesh = mesh, .stars = stars, .sight = sight, .stand_in = stand_in};
    return threads_for(threads, mesh->cell_count, look_for, &job);
}

struct error *stand_in_find_outside(int32_t *stand_in, const float *sight, const float *slope,
                                    const struct tracer *tracer, const struct outside *outside,
                                    const struct stars *stars, int threads)
{
    struct job job = {.tracer = tracer,
                      .mesh = outside->mesh,
                      .stars = stars,
                      .sight = sight,
                      .slope = slope,
                      .outside = outside,
                      .stand_in = stand_in};
    int32_t *asked = NULL;
    const size_t count = outside->mesh->cell_count;
    struct error *err = threads_for(threads, count, look_for_outside, &job);
    if (!err)
        err = array_create(&asked, count, sizeof *asked);
    for (size_t cell = 0; cell < count && !err; cell++)
        asked[cell] = stand_in[cell] == ASK ? ask_around(&job, cell) : stand_in[cell];
    if (!err)
        memcpy(stand_in, asked, count * sizeof *asked);
    free(asked);
    return err;
}
