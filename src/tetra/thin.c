/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Toussaint, "The relative neighbourhood graph of a finite planar set", Pattern
 * Recognition 12, 1980. Kruskal, "On the shortest spanning subtree of a graph", Proc. AMS 7, 1956.
 */
#include "tetra/thin.h"
#include "base/array.h"
#include "base/error.h"
#include "math/sort.h"
#include "math/vec.h"
#include "tetra/sites.h"
#include "tetra/tetra_cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static struct vec3 at(const struct sites *sites, size_t i)
{
    return vec3_load(sites->site + 3 * i);
}

static double apart(const struct sites *sites, size_t i, size_t j)
{
    return vec3_length(vec3_sub(at(sites, i), at(sites, j)));
}

/* -- how it looks around a site --------------------------------------------------------------- */

/* NEAREST: of whom a neighbourhood is made; of a line fewer, as it may bend. */
enum { WINDOW = 256, NEAREST = 8, NEAREST_OF_LINE = 4, SAMPLES = 256 };

/* The nearest of the sites that are no farther than WINDOW away in canonical order, nearest first.
 * Returns how many. */
static size_t nearest_of(const struct sites *sites, size_t i, size_t near[NEAREST],
                         double distance[NEAREST])
{
    size_t count = 0;
    const size_t first = i < WINDOW ? 0 : i - WINDOW,
                 end = i + WINDOW < sites->count ? i + WINDOW + 1 : sites->count;
    for (size_t k = first; k < end; k++) {
        if (k == i)
            continue;
        const struct vec3 off = vec3_sub(at(sites, k), at(sites, i));
        const double square = vec3_dot(off, off);
        if (count == NEAREST && square >= distance[NEAREST - 1])
            continue;
        size_t to = count < NEAREST ? count++ : NEAREST - 1;
        for (; to && distance[to - 1] > square; to--) {
            distance[to] = distance[to - 1];
            near[to] = near[to - 1];
        }
        distance[to] = square;
        near[to] = k;
    }
    for (size_t k = 0; k < count; k++)
        distance[k] = sqrt(distance[k]);
    return count;
}

/* How far a site and its nearest reach along their own axes: root mean squares, the largest
 * first. */
static void reach_of(const struct sites *sites, size_t i, const size_t *near, size_t count,
                     double reach[3], double axis[3][3])
{
    struct vec3 mean = at(sites, i);
    double moment[3][3] = {{0}};
    for (size_t k = 0; k < count; k++)
        mean = vec3_add(mean, at(sites, near[k]));
    mean = vec3_scale(1 / (double)(count + 1), mean);
    for (size_t k = 0; k <= count; k++) {
        double d[3];
        vec3_store(d, vec3_sub(at(sites, k < count ? near[k] : i), mean));
        for (int j = 0; j < 9; j++)
            moment[j / 3][j % 3] += d[j / 3] * d[j % 3] / (double)(count + 1);
    }
    span_axes(moment, axis);
    for (int k = 0; k < 3; k++)
        reach[k] = sqrt(fmax(moment[k][k], 0));
    for (int k = 0; k < 3; k++) /* three numbers: bubbles */
        if (reach[k % 2] < reach[k % 2 + 1]) {
            double swap[3], most = reach[k % 2];
            reach[k % 2] = reach[k % 2 + 1];
            reach[k % 2 + 1] = most;
            memcpy(swap, axis[k % 2], sizeof swap);
            memcpy(axis[k % 2], axis[k % 2 + 1], sizeof swap);
            memcpy(axis[k % 2 + 1], swap, sizeof swap);
        }
}

/* Noise of .3 of the spacing to either side leaves these below .3; of a grid in space they are
 * near 1. */
static const double thinner = 0.35;

static bool is_line(const struct sites *sites, size_t i, const size_t *near, size_t count)
{
    double reach[3], axis[3][3];
    reach_of(sites, i, near, count < NEAREST_OF_LINE ? count : NEAREST_OF_LINE, reach, axis);
    return hypot(reach[1], reach[2]) <= thinner * reach[0];
}

static bool is_sheet(const struct sites *sites, size_t i, const size_t *near, size_t count)
{
    double reach[3], axis[3][3];
    reach_of(sites, i, near, count, reach, axis);
    return reach[2] <= thinner * hypot(reach[0], reach[1]) / sqrt(2);
}

struct thin_look thin_look(const struct sites *sites)
{
    const size_t samples = sites->count < SAMPLES ? sites->count : SAMPLES;
    struct thin_look look = {0};
    for (size_t s = 0; s < samples; s++) {
        size_t near[NEAREST];
        double distance[NEAREST];
        const size_t i = s * sites->count / samples, count = nearest_of(sites, i, near, distance);
        look.line += is_line(sites, i, near, count) / (double)samples;
        look.sheet += is_sheet(sites, i, near, count) / (double)samples;
    }
    return look;
}

bool thin_may_be_line(const struct thin_look *look)
{
    return look->line >= 0.5;
}

bool thin_may_be_sheet(const struct thin_look *look)
{
    return look->sheet >= 0.7;
}

/* -- a line or a plane ------------------------------------------------------------------------ */

static int compare_places(const void *a, const void *b)
{
    const double *p = a, *q = b;
    for (int k = 0; k < 2; k++)
        if (p[k] != q[k])
            return p[k] < q[k] ? -1 : 1;
    return 0;
}

void thin_face(const struct sites *sites, struct span_frame *frame)
{
    const size_t samples = sites->count < SAMPLES ? sites->count : SAMPLES;
    double facing[3][3] = {{0}}, axis[3][3], along = 0;
    int up = 0;
    for (size_t s = 0; s < samples; s++) {
        size_t near[NEAREST];
        double distance[NEAREST], reach[3];
        const size_t i = s * sites->count / samples, count = nearest_of(sites, i, near, distance);
        reach_of(sites, i, near, count, reach, axis);
        const double sure = reach[1] > 0 ? (reach[1] - reach[2]) / reach[1] : 0;
        for (int j = 0; j < 9; j++)
            facing[j / 3][j % 3] += sure * axis[2][j / 3] * axis[2][j % 3];
    }
    span_axes(facing, axis);
    for (int k = 1; k < 3; k++)
        up = facing[k][k] > facing[up][up] ? k : up;
    /* of the plane's directions, the one that is nearest to where the sites reach the farthest */
    const struct vec3 normal = vec3_load(axis[up]);
    struct vec3 first = vec3_load(frame->axis[0]);
    along = vec3_dot(first, normal);
    if (fabs(along) > 0.9) {
        first = vec3_load(frame->axis[1]);
        along = vec3_dot(first, normal);
    }
    first = vec3_normalize(vec3_fma(first, -along, normal));
    vec3_store(frame->axis[0], first);
    vec3_store(frame->axis[1], vec3_cross(normal, first));
    vec3_store(frame->axis[2], normal);
}

struct error *thin_flatten(const struct sites *sites, int corners, const struct span_frame *frame,
                           struct sites *flat, bool *are_apart)
{
    double *place = NULL;
    *flat = (struct sites){.lattice = sites->lattice,
                           .row = sites->row,
                           .count = sites->count,
                           .corners = corners,
                           .axis = {0, 1}};
    *are_apart = true;
    struct error *err = array_create(&flat->site, 3 * sites->count, sizeof *flat->site);
    if (!err)
        err = array_create(&place, 3 * sites->count, sizeof *place);
    if (!err) {
        for (size_t i = 0; i < sites->count; i++) {
            double *p = flat->site + 3 * i;
            span_flatten(frame, corners, sites->site + 3 * i, p);
            for (int k = 0; k < corners - 1; k++)
                p[k] = rint(p[k]);
        }
        memcpy(place, flat->site, 3 * sites->count * sizeof *place);
        qsort(place, sites->count, 3 * sizeof *place, compare_places);
        for (size_t i = 0; i + 1 < sites->count; i++)
            *are_apart = *are_apart && compare_places(place + 3 * i, place + 3 * (i + 1));
        sites_extremes(flat->count, flat->site, flat->extreme);
    }
    free(place);
    return err;
}

void thin_clear(struct sites *flat)
{
    free(flat->site);
    flat->site = NULL;
}

struct error *thin_off_line(const struct sites *flat, const struct span_frame *frame, double *share)
{
    double *along = NULL;
    const size_t gaps = flat->count - 1;
    struct error *err = array_create(&along, flat->count, sizeof *along);
    if (err)
        return err;
    for (size_t i = 0; i < flat->count; i++)
        along[i] = flat->site[3 * i];
    sort_doubles(flat->count, along);
    for (size_t i = 0; i < gaps; i++)
        along[i] = 4 * (along[i + 1] - along[i]); /* steps */
    sort_doubles(gaps, along);
    *share = frame->off / along[gaps / 2];
    free(along);
    return NULL;
}

/* -- edges ------------------------------------------------------------------------------------ */

struct edge {
    double length;
    int32_t low, high;
};

static int compare_ends(const void *a, const void *b)
{
    const struct edge *e = a, *f = b;
    if (e->low != f->low)
        return e->low < f->low ? -1 : 1;
    return e->high < f->high ? -1 : e->high > f->high;
}

static int compare_lengths(const void *a, const void *b)
{
    const struct edge *e = a, *f = b;
    if (e->length != f->length)
        return e->length < f->length ? -1 : 1;
    return compare_ends(a, b);
}

/* The edges of cells, each once, by their ends. */
static struct error *list_edges(const struct tetra *cells, const struct sites *sites,
                                struct edge **edge, size_t *count)
{
    const size_t corners = (size_t)cells->corners;
    size_t n = 0;
    struct error *err =
        array_create(edge, cells->cell_count * corners * (corners - 1) / 2, sizeof **edge);
    *count = 0;
    if (err)
        return err;
    for (size_t cell = 0; cell < cells->cell_count; cell++)
        for (size_t i = 0; i < corners; i++)
            for (size_t j = i + 1; j < corners; j++) {
                const int32_t a = cells->vertex[corners * cell + i],
                              b = cells->vertex[corners * cell + j];
                (*edge)[n++] = (struct edge){0, a < b ? a : b, a < b ? b : a};
            }
    qsort(*edge, n, sizeof **edge, compare_ends);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || compare_ends(&(*edge)[i], &(*edge)[i - 1])) {
            struct edge *e = &(*edge)[(*count)++];
            *e = (*edge)[i];
            e->length = apart(sites, (size_t)e->low, (size_t)e->high);
        }
    return NULL;
}

/* The edges at each site, from first[site] to first[site + 1] in `end`: the other ends, nearest
 * first where edges come by length. */
struct star {
    size_t *first;
    int32_t *end;
};

static struct error *make_stars(struct star *star, size_t sites, const struct edge *edge,
                                size_t count)
{
    *star = (struct star){0};
    struct error *err = array_create(&star->first, sites + 2, sizeof *star->first);
    if (!err)
        err = array_create(&star->end, 2 * count, sizeof *star->end);
    for (size_t i = 0; i < count && !err; i++) {
        star->first[edge[i].low + 2]++;
        star->first[edge[i].high + 2]++;
    }
    for (size_t i = 2; i < sites + 2 && !err; i++)
        star->first[i] += star->first[i - 1];
    for (size_t i = 0; i < count && !err; i++) {
        star->end[star->first[edge[i].low + 1]++] = edge[i].high;
        star->end[star->first[edge[i].high + 1]++] = edge[i].low;
    }
    return err;
}

static void clear_stars(struct star *star)
{
    free(star->first);
    free(star->end);
}

/* -- a sheet ---------------------------------------------------------------------------------- */

/* How far a site is off the plane through it and its neighbours, who count by the inverse of their
 * squared distances; its height above where that is steeper than 70 degrees. (u, v) lie in the
 * plane of all, w is the height above. */
static double off_plane(const struct vec3 *p, size_t count)
{
    const double steep = 2.75; /* tan 70 */
    double total = 0, gram[2][2] = {{0}}, across[2] = {0}, mean[3] = {0}, least = INFINITY;
    for (size_t k = 1; k < count; k++)
        least = fmin(least, vec3_length(vec3_sub(p[k], p[0])));
    for (int pass = 0; pass < 2; pass++) {
        for (size_t k = 0; k < count; k++) {
            const double length = k ? vec3_length(vec3_sub(p[k], p[0])) : least,
                         weight = least * least / (length * length);
            const double d[3] = {p[k].x - mean[0], p[k].y - mean[1], p[k].z - mean[2]};
            total += pass ? 0 : weight;
            for (int i = 0; i < 2 && pass; i++) {
                across[i] += weight * d[i] * d[2];
                for (int j = 0; j < 2; j++)
                    gram[i][j] += weight * d[i] * d[j];
            }
            if (!pass) {
                mean[0] += weight * p[k].x;
                mean[1] += weight * p[k].y;
                mean[2] += weight * p[k].z;
            }
        }
        for (int k = 0; k < 3 && !pass; k++)
            mean[k] /= total;
        if (pass)
            break;
    }
    const double det = gram[0][0] * gram[1][1] - gram[0][1] * gram[0][1],
                 trace = gram[0][0] + gram[1][1];
    double slope[2] = {0};
    if (det > 1e-6 * trace * trace) { /* neighbours in a row tell no slope */
        slope[0] = (across[0] * gram[1][1] - across[1] * gram[0][1]) / det;
        slope[1] = (across[1] * gram[0][0] - across[0] * gram[0][1]) / det;
    }
    const double rise = hypot(slope[0], slope[1]);
    const double off = p[0].z - mean[2] - slope[0] * (p[0].x - mean[0]) -
                       slope[1] * (p[0].y - mean[1]);
    return rise > steep ? fabs(off) : fabs(off) / sqrt(1 + rise * rise);
}

/* By how much the neighbours that a site stands upon, or that stand upon it, are above or below it:
 * those less than 15 degrees from upright. */
static double off_stack(const struct vec3 *p, size_t count)
{
    double off = 0;
    for (size_t k = 1; k < count; k++) {
        const struct vec3 d = vec3_sub(p[k], p[0]);
        off = hypot(d.x, d.y) < 0.27 * fabs(d.z) ? fmax(off, fabs(d.z)) : off;
    }
    return off;
}

struct error *thin_off_sheet(const struct tetra *triangles, const struct sites *sites,
                             const struct sites *flat, const struct span_frame *frame,
                             struct thin_off *off)
{
    enum { NEIGHBOURS = 32 };
    struct edge *edge = NULL;
    struct star star = {0};
    double *spacing = NULL, *share = NULL;
    size_t count;
    *off = (struct thin_off){INFINITY, INFINITY, 0};
    struct error *err = list_edges(triangles, sites, &edge, &count);
    if (!err)
        qsort(edge, count, sizeof *edge, compare_lengths);
    if (!err)
        err = make_stars(&star, sites->count, edge, count);
    if (!err)
        err = array_create(&spacing, sites->count, sizeof *spacing);
    if (!err)
        err = array_create(&share, sites->count, sizeof *share);
    for (size_t i = 0; i < sites->count && !err; i++) {
        struct vec3 p[NEIGHBOURS + 1];
        size_t n = 0;
        for (size_t k = star.first[i]; k <= star.first[i + 1] && n <= NEIGHBOURS; k++) {
            const size_t j = n ? (size_t)star.end[k - 1] : i;
            const struct vec3 up = vec3_load(frame->axis[2]),
                              from = vec3_sub(at(sites, j), vec3_load(frame->middle));
            p[n++] =
                (struct vec3){4 * flat->site[3 * j], 4 * flat->site[3 * j + 1], vec3_dot(up, from)};
        }
        spacing[i] = n > 1 ? apart(sites, i, (size_t)star.end[star.first[i]]) : 0;
        share[i] = fmax(off_plane(p, n), off_stack(p, n));
    }
    if (!err) {
        sort_doubles(sites->count, spacing);
        sort_doubles(sites->count, share);
        off->spacing = spacing[sites->count / 2];
        off->most_of = share[(sites->count - 1) * 19 / 20] / off->spacing;
        off->most = share[sites->count - 1] / off->spacing;
    }
    free(edge);
    clear_stars(&star);
    free(spacing);
    free(share);
    return err;
}

/* -- a walk ----------------------------------------------------------------------------------- */

static int32_t root_of(int32_t *up, int32_t i)
{
    while (up[i] != i)
        i = up[i] = up[up[i]];
    return i;
}

/* Whether a site next to either end is nearer to both than they are to each other. */
static bool is_between(const struct sites *sites, const struct star *star, const struct edge *e)
{
    const int32_t ends[2] = {e->low, e->high};
    for (int s = 0; s < 2; s++)
        for (size_t k = star->first[ends[s]]; k < star->first[ends[s] + 1]; k++) {
            const int32_t other = star->end[k];
            if (other != ends[1 - s] && apart(sites, (size_t)other, (size_t)ends[0]) < e->length &&
                apart(sites, (size_t)other, (size_t)ends[1]) < e->length)
                return true;
        }
    return false;
}

/* How far a site's second neighbour is. */
static double spacing_of(const struct sites *sites, const struct star *star, int32_t i)
{
    const size_t first = star->first[i], degree = star->first[i + 1] - first;
    return degree ? apart(sites, (size_t)i, (size_t)star->end[first + (degree > 1)]) : 0;
}

/* Keeps the edges (by length) of the minimum spanning tree, and those that close rings. */
static size_t keep_walk(const struct sites *sites, const struct star *star, struct edge *edge,
                        size_t count, int32_t *up)
{
    const double near = 1.5; /* what closes a ring is hardly longer than the spacing there */
    size_t kept = 0;
    for (size_t i = 0; i < sites->count; i++)
        up[i] = (int32_t)i;
    for (size_t i = 0; i < count; i++) {
        const struct edge e = edge[i];
        const int32_t a = root_of(up, e.low), b = root_of(up, e.high);
        const bool closes = a == b &&
                            e.length <= near * fmin(spacing_of(sites, star, e.low),
                                                    spacing_of(sites, star, e.high)) &&
                            !is_between(sites, star, &e);
        up[a] = b;
        if (a != b || closes)
            edge[kept++] = e;
    }
    return kept;
}

static bool is_walk(const struct sites *sites, const struct star *star)
{
    size_t plain = 0, passed = 0, straight = 0;
    for (size_t i = 0; i < sites->count; i++) {
        const size_t first = star->first[i], degree = star->first[i + 1] - first;
        plain += degree <= 2;
        if (degree != 2)
            continue;
        const struct vec3 a = vec3_sub(at(sites, (size_t)star->end[first]), at(sites, i)),
                          b = vec3_sub(at(sites, (size_t)star->end[first + 1]), at(sites, i));
        passed++;
        straight += vec3_dot(a, b) <= -0.5 * vec3_length(a) * vec3_length(b);
    }
    if (sites->count < 16) /* any few probes are a walk, if it may bend as it likes */
        return sites->count >= 8 && plain == sites->count && straight == passed;
    return 7 * plain >= 6 * sites->count && 5 * straight >= 4 * passed;
}

struct error *thin_walk(const struct tetra *cells, const struct sites *sites, int32_t **walk,
                        size_t *count)
{
    struct edge *edge = NULL;
    struct star all = {0}, kept = {0};
    int32_t *up = NULL;
    size_t edges;
    *walk = NULL;
    *count = 0;
    struct error *err = list_edges(cells, sites, &edge, &edges);
    if (!err)
        qsort(edge, edges, sizeof *edge, compare_lengths);
    if (!err)
        err = make_stars(&all, sites->count, edge, edges);
    if (!err)
        err = array_create(&up, sites->count, sizeof *up);
    if (!err) {
        edges = keep_walk(sites, &all, edge, edges, up);
        err = make_stars(&kept, sites->count, edge, edges);
    }
    if (!err && is_walk(sites, &kept))
        err = array_create(walk, 2 * edges, sizeof **walk);
    if (!err && *walk) {
        qsort(edge, edges, sizeof *edge, compare_ends);
        for (*count = 0; *count < edges; ++*count) {
            (*walk)[2 * *count] = edge[*count].low;
            (*walk)[2 * *count + 1] = edge[*count].high;
        }
    }
    free(edge);
    free(up);
    clear_stars(&all);
    clear_stars(&kept);
    return err;
}

/* -- what is left ----------------------------------------------------------------------------- */

struct thin_far thin_far(const struct tetra *tetra, const struct sites *sites)
{
    enum { CELLS = 2000 };
    struct thin_far far = {0};
    double all = 0, of_thin = 0;
    const size_t samples = tetra->cell_count < CELLS ? tetra->cell_count : CELLS;
    for (size_t s = 0; s < samples; s++) {
        const int32_t *v = tetra->vertex + 4 * (s * tetra->cell_count / samples);
        double longest = 0, spacing = 0;
        int thin = 0;
        for (int i = 0; i < 4; i++) {
            size_t near[NEAREST];
            double distance[NEAREST];
            const size_t count = nearest_of(sites, (size_t)v[i], near, distance);
            spacing = fmax(spacing, distance[count > 1]);
            thin += is_line(sites, (size_t)v[i], near, count) ||
                    is_sheet(sites, (size_t)v[i], near, count);
            for (int j = 0; j < i; j++)
                longest = fmax(longest, apart(sites, (size_t)v[i], (size_t)v[j]));
        }
        const struct vec3 p = at(sites, (size_t)v[0]), a = vec3_sub(at(sites, (size_t)v[1]), p),
                          b = vec3_sub(at(sites, (size_t)v[2]), p),
                          c = vec3_sub(at(sites, (size_t)v[3]), p);
        const double volume = fabs(vec3_dot(a, vec3_cross(b, c))),
                     base = fmax(fmax(vec3_length(vec3_cross(a, b)), vec3_length(vec3_cross(b, c))),
                                 fmax(vec3_length(vec3_cross(c, a)),
                                      vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)))));
        all += volume;
        of_thin += thin >= 3;
        if (longest > THIN_FAR * spacing && thin >= 3 && volume < thinner * spacing * base) {
            far.cells++;
            far.volume += volume;
        }
    }
    /* of cells of thin parts, where there are such parts */
    far.cells /= of_thin > 0.1 * (double)samples ? of_thin : (double)samples;
    far.volume /= all > 0 ? all : 1;
    return far;
}

struct error *thin_sheets(const struct sites *sites, double **spacing)
{
    struct error *err = array_create(spacing, sites->count, sizeof **spacing);
    for (size_t i = 0; i < sites->count && !err; i++) {
        size_t near[NEAREST];
        double distance[NEAREST];
        const size_t count = nearest_of(sites, i, near, distance);
        (*spacing)[i] = count > 1 && is_sheet(sites, i, near, count) ? distance[1] : 0;
    }
    return err;
}
