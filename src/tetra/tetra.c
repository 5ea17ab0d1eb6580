/* SPDX-License-Identifier: Apache-2.0 */
#include "tetra/tetra.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/angle.h"
#include "math/cell.h"
#include "math/vec.h"
#include "tetra/peel.h"
#include "tetra/sites.h"
#include "tetra/stretch.h"
#include "tetra/thin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

struct tetra_settings tetra_settings_default(void)
{
    return (struct tetra_settings){.merge = 1e-12, .threads = 1};
}

static struct error *make_room(struct tetra *tetra, int corners, size_t cells)
{
    tetra->corners = corners;
    tetra->cell_count = cells;
    tetra->room_bytes = 2 * (size_t)corners * cells * sizeof(int32_t);
    tetra->room =
        mmap(NULL, tetra->room_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (tetra->room == MAP_FAILED) {
        tetra->room = NULL;
        return error_memory();
    }
    tetra->vertex = tetra->room;
    tetra->neighbour = tetra->vertex + (size_t)corners * cells;
    return NULL;
}

static void free_room(struct tetra *tetra)
{
    if (tetra->room)
        munmap(tetra->room, tetra->room_bytes);
    tetra->room = NULL;
}

/* -- tetrahedra ------------------------------------------------------------------------------- */

/* Lattice units to what TetGen sees: near 1, exactly. */
static const double scale = 0x1p-40;

static void stretch_all(const struct stretch *stretch, size_t count, const double *point,
                        double *stretched)
{
    for (size_t i = 0; i < count; i++) {
        const double *p = point + 3 * i;
        for (int k = 0; k < 3; k++)
            stretched[3 * i + (size_t)k] = scale * (stretch->matrix[k][0] * p[0] +
                                                    stretch->matrix[k][1] * p[1] +
                                                    stretch->matrix[k][2] * p[2]);
    }
}

/* sheets: noise on them is peeled off the hull. */
static struct error *make_tetrahedra(struct tetra *tetra, const struct sites *sites,
                                     const struct tetra_settings *settings, bool sheets)
{
    struct stretch stretch;
    double *stretched = NULL, *spacing = NULL;
    struct error *err = array_create(&stretched, 3 * sites->count, sizeof *stretched);
    if (!err) {
        stretch_find(&stretch, sites->count, sites->site);
        stretch_all(&stretch, sites->count, sites->site, stretched);
        err = tetra_run(tetra, sites->count, stretched, sites->extreme, settings);
    }
    if (!err) {
        tetra->corners = 4;
        tetra->stretched = stretch.found;
        err = peel_hull(tetra, sites->count, sites->site, sites->axis, stretched,
                        stretch.found ? PEEL_GRID : PEEL_NOISE);
    }
    if (!err && sheets)
        err = thin_sheets(sites, &spacing);
    if (!err && sheets)
        err = peel_sheets(tetra, sites->count, sites->site, sites->axis, stretched, spacing);
    free(spacing);
    free(stretched);
    return err;
}

/* -- triangles -------------------------------------------------------------------------------- */

/* Of tetrahedra that all hold the apex (the point `apex`), the facets opposite it. */
static struct error *take_bases(struct tetra *tetra, const struct tetra *cones, int32_t apex)
{
    struct error *err = make_room(tetra, 3, cones->cell_count);
    for (size_t cell = 0; cell < cones->cell_count && !err; cell++) {
        const int32_t *v = cones->vertex + 4 * cell, *n = cones->neighbour + 4 * cell;
        int top = 0;
        while (top < 4 && v[top] != apex)
            top++;
        if (top == 4)
            return error_new("TetGen failed on %d probes in a plane", apex);
        for (size_t k = 0; k < 3; k++) {
            tetra->vertex[3 * cell + k] = v[cell_face[top][2 - k]]; /* as seen from the apex */
            tetra->neighbour[3 * cell + k] = n[cell_face[top][2 - k]];
        }
    }
    return err;
}

/* The sphere through a triangle and an apex meets the plane in the triangle's circumcircle: with
 * any apex off the plane, the Delaunay tetrahedra are cones over the Delaunay triangles. */
static struct error *make_triangles(struct tetra *tetra, const struct sites *sites,
                                    const struct tetra_settings *settings)
{
    const size_t count = sites->count;
    double *flat = NULL, *stretched = NULL, m[2][2];
    struct tetra cones = {0};
    struct stretch stretch;
    struct error *err = array_create(&flat, 3 * (count + 1), sizeof *flat);
    if (!err)
        err = array_create(&stretched, 3 * (count + 1), sizeof *stretched);
    if (!err) {
        sites_metric(count, sites->site, sites->axis, m);
        for (size_t i = 0; i < count; i++) {
            const double x = sites->site[3 * i + (size_t)sites->axis[0]],
                         y = sites->site[3 * i + (size_t)sites->axis[1]];
            flat[3 * i] = m[0][0] * x + m[0][1] * y;
            flat[3 * i + 1] = m[1][1] * y;
        }
        stretch_find(&stretch, count, flat);
        /* both maps in one, of multiples of 2^-12: exact on whole numbers */
        double whole[3][3] = {{0}};
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < 2; j++)
                whole[i][j] =
                    rint((stretch.matrix[i][0] * m[0][j] + stretch.matrix[i][1] * m[1][j]) *
                         0x1p12) *
                    0x1p-12;
        for (size_t i = 0; i < count; i++) {
            flat[3 * i] = sites->site[3 * i + (size_t)sites->axis[0]];
            flat[3 * i + 1] = sites->site[3 * i + (size_t)sites->axis[1]];
        }
        whole[2][2] = 1;
        flat[3 * count] = flat[3 * count + 1] = flat[3 * count + 2] = 0x1p38;
        stretch_all(&(struct stretch){.matrix = {{whole[0][0], whole[0][1], whole[0][2]},
                                                 {whole[1][0], whole[1][1], whole[1][2]},
                                                 {whole[2][0], whole[2][1], whole[2][2]}}},
                    count + 1, flat, stretched);
        const size_t first[4] = {sites->extreme[0], sites->extreme[1], sites->extreme[2], count};
        err = tetra_run(&cones, count + 1, stretched, first, settings);
    }
    if (!err)
        err = take_bases(tetra, &cones, (int32_t)count);
    tetra_clear(&cones);
    if (!err) {
        tetra->stretched = true;
        err = peel_hull(tetra, count, sites->site, sites->axis, stretched,
                        stretch.found ? PEEL_GRID : PEEL_NOISE);
    }
    free(flat);
    free(stretched);
    return err;
}

/* -- segments and a point --------------------------------------------------------------------- */

struct stop {
    double along;
    int32_t site;
};

static int compare_stops(const void *a, const void *b)
{
    const double x = ((const struct stop *)a)->along, y = ((const struct stop *)b)->along;
    return x < y ? -1 : x > y;
}

static struct error *make_segments(struct tetra *tetra, const struct sites *sites)
{
    struct stop *stop = NULL;
    struct error *err = array_create(&stop, sites->count, sizeof *stop);
    if (!err)
        err = make_room(tetra, 2, sites->count - 1);
    if (!err) {
        for (size_t i = 0; i < sites->count; i++)
            stop[i] = (struct stop){sites->site[3 * i + (size_t)sites->axis[0]], (int32_t)i};
        qsort(stop, sites->count, sizeof *stop, compare_stops);
        for (size_t cell = 0; cell < tetra->cell_count; cell++)
            for (size_t k = 0; k < 2; k++) {
                /* opposite the first lies the next, opposite the second the one before */
                const size_t next = k ? cell - 1 : cell + 1;
                tetra->vertex[2 * cell + k] = stop[cell + k].site;
                tetra->neighbour[2 * cell + k] = next < tetra->cell_count ? (int32_t)next : -1;
            }
    }
    free(stop);
    return err;
}

static struct error *make_point(struct tetra *tetra)
{
    struct error *err = make_room(tetra, 1, 1);
    if (!err)
        tetra->neighbour[0] = -1; /* the vertex is site 0 */
    return err;
}

/* -- the hull --------------------------------------------------------------------------------- */

/* The outward normal of a cell's facet i, of length 1, in what the cells span. */
static struct vec3 facet_normal(int corners, const struct vec3 *p, int i)
{
    if (corners == 4) {
        const struct vec3 a = p[cell_face[i][0]], b = p[cell_face[i][1]], c = p[cell_face[i][2]];
        return vec3_normalize(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
    }
    if (corners == 2)
        return vec3_normalize(vec3_sub(p[1 - i], p[i]));
    const struct vec3 a = p[(i + 1) % 3], edge = vec3_sub(p[(i + 2) % 3], a),
                      inward = vec3_sub(p[i], a);
    const double along = vec3_dot(edge, inward) / vec3_dot(edge, edge);
    return vec3_normalize(vec3_sub(vec3_scale(along, edge), inward));
}

/* How much a facet counts at its corner k: its angle there; of edges and points all alike. */
static double facet_angle(int corners, const struct vec3 *p, int i, int k)
{
    if (corners != 4)
        return 1;
    int other[2], count = 0;
    for (int j = 0; j < 4; j++)
        if (j != i && j != k)
            other[count++] = j;
    const struct vec3 a = vec3_sub(p[other[0]], p[k]), b = vec3_sub(p[other[1]], p[k]);
    return angle_atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
}

/* Angle-weighted vertex normals (Thuermer and Wuethrich, "Computing vertex normals from polygonal
 * facets", 1998), by probe. */
static struct error *hull_normals(struct tetra *tetra, size_t count, const struct sites *sites)
{
    const int corners = tetra->corners;
    struct vec3 *sum = NULL;
    struct error *err = array_create(&sum, sites->count, sizeof *sum);
    if (!err)
        err = array_create(&tetra->hull_normal, 3 * count, sizeof *tetra->hull_normal);
    for (size_t at = 0; at < (size_t)corners * tetra->cell_count && corners > 1 && !err; at++) {
        if (tetra->neighbour[at] >= 0)
            continue;
        const int i = (int)(at % (size_t)corners);
        const int32_t *v = tetra->vertex + at - i;
        struct vec3 p[4];
        for (int k = 0; k < corners; k++)
            p[k] = vec3_scale(scale, vec3_load(sites->site + 3 * (size_t)v[k]));
        const struct vec3 normal = facet_normal(corners, p, i);
        for (int k = 0; k < corners; k++)
            if (k != i)
                sum[v[k]] = vec3_fma(sum[v[k]], facet_angle(corners, p, i, k), normal);
    }
    for (size_t i = 0; i < sites->count && !err; i++) {
        const struct vec3 n = vec3_normalize(sum[i]);
        float *normal = tetra->hull_normal + 3 * (size_t)sites->row[i];
        normal[0] = (float)n.x;
        normal[1] = (float)n.y;
        normal[2] = (float)n.z;
    }
    free(sum);
    return err;
}

/* -- all together ----------------------------------------------------------------------------- */

enum { CHUNK = 65536 };

struct numbering {
    struct tetra *tetra;
    const int32_t *row;
};

/* Sites become the probes that stand for them. */
static struct error *number_chunk(void *context, size_t index, int thread)
{
    (void)thread;
    const struct numbering *n = context;
    const size_t all = (size_t)n->tetra->corners * n->tetra->cell_count, first = index * CHUNK;
    for (size_t i = first; i < first + CHUNK && i < all; i++)
        n->tetra->vertex[i] = n->row[n->tetra->vertex[i]];
    return NULL;
}

static struct error *make_cells(struct tetra *tetra, const struct sites *sites,
                                const struct tetra_settings *settings)
{
    switch (sites->corners) {
    case 4: return make_tetrahedra(tetra, sites, settings, false);
    case 3: return make_triangles(tetra, sites, settings);
    case 2: return make_segments(tetra, sites);
    default: return make_point(tetra);
    }
}

/* -- thin sets -------------------------------------------------------------------------------- */

static void give_up(struct tetra *tetra)
{
    tetra_await(tetra);
    free_room(tetra);
    *tetra = (struct tetra){0};
}

/* Segments of a walk. Where more than two meet, each has the next for a neighbour, all in a ring;
 * where two do, each other. */
static struct error *string_walk(struct tetra *tetra, size_t sites, const int32_t *walk,
                                 size_t count)
{
    int32_t *last = NULL, *first = NULL; /* of a site's segment ends so far, 2 * segment + end */
    struct error *err = array_create(&last, sites, sizeof *last);
    if (!err)
        err = array_create(&first, sites, sizeof *first);
    if (!err)
        err = make_room(tetra, 2, count);
    for (size_t i = 0; i < sites && !err; i++)
        last[i] = first[i] = -1;
    for (size_t i = 0; i < 2 * count && !err; i++) {
        const int32_t site = walk[i];
        tetra->vertex[i] = site;
        tetra->neighbour[i] = -1;
        if (first[site] < 0)
            first[site] = (int32_t)i;
        else /* an end's neighbour is opposite the segment's other end */
            tetra->neighbour[last[site] ^ 1] = (int32_t)(i / 2);
        last[site] = (int32_t)i;
    }
    for (size_t i = 0; i < sites && !err; i++)
        if (last[i] != first[i])
            tetra->neighbour[last[i] ^ 1] = first[i] / 2;
    free(last);
    free(first);
    return err;
}

static const char *percent(double share, char text[24])
{
    snprintf(text, 24, share < .995 ? "%.2g %%" : "%.0f %%", 100 * share);
    return text;
}

/* Segments, if the sites lie near a line. */
static struct error *try_line(struct tetra *tetra, const struct sites *sites,
                              const struct tetra_settings *settings, struct warnings *warnings)
{
    struct span_frame frame;
    struct sites flat = {0};
    bool apart;
    double share = INFINITY;
    char text[24];
    span_find(&frame, sites->count, sites->site, NULL, 2);
    struct error *err = thin_flatten(sites, 2, &frame, &flat, &apart);
    if (!err && apart)
        err = thin_off_line(&flat, &frame, &share);
    if (!err && share <= settings->thin) {
        err = make_segments(tetra, &flat);
        if (!err)
            err = tetra_check_sites(tetra, flat.count, flat.site, flat.axis, settings->threads);
        tetra->thin = TETRA_LINE;
        warnings_add(
            warnings, "thin",
            "the probes are nearly on a line, off it by at most %s of their spacing: cells "
            "are segments along it (--thin 0: tetrahedra)",
            percent(share, text));
    }
    thin_clear(&flat);
    return err;
}

/* Triangles, if the sites lie in a sheet that is seen in full along the frame's last axis. */
static struct error *try_facing(struct tetra *tetra, const struct sites *sites,
                                const struct span_frame *frame,
                                const struct tetra_settings *settings, struct warnings *warnings)
{
    enum { FEW = 16 };
    const double ledge = 1; /* few may stand off as far as this: at a step's edge */
    struct sites flat = {0};
    struct thin_off off = {.most = INFINITY};
    bool apart;
    char text[24], most[24];
    struct error *err = thin_flatten(sites, 3, frame, &flat, &apart);
    if (!err && apart)
        err = make_triangles(tetra, &flat, settings);
    if (!err && apart)
        err = thin_off_sheet(tetra, sites, &flat, frame, &off);
    double thin = settings->thin;
    if (!err && sites->count < FEW) { /* any few are in a sheet, if it may bend as it likes */
        off.most_of = off.most = fmax(off.most, frame->off / off.spacing);
        thin *= (double)(sites->count * sites->count) / (FEW * FEW);
    }
    if (!err && off.most_of <= thin && off.most <= ledge) {
        err = tetra_check_sites(tetra, flat.count, flat.site, flat.axis, settings->threads);
        tetra->thin = TETRA_SHEET;
        warnings_add(
            warnings, "thin",
            "the probes are nearly in a sheet, 95 %% of them off it by at most %s of their "
            "spacing, all by at most %s: cells are triangles of it (--thin 0: tetrahedra)",
            percent(off.most_of, text), percent(off.most, most));
    } else if (!err && apart) {
        give_up(tetra);
    }
    thin_clear(&flat);
    return err;
}

static struct error *try_sheet(struct tetra *tetra, const struct sites *sites,
                               const struct tetra_settings *settings, struct warnings *warnings)
{
    struct span_frame frame;
    span_find(&frame, sites->count, sites->site, NULL, 3);
    struct error *err = try_facing(tetra, sites, &frame, settings, warnings);
    if (err || tetra->thin)
        return err;
    thin_face(sites, &frame);
    return try_facing(tetra, sites, &frame, settings, warnings);
}

/* Segments in place of other cells, if those are of a walk. */
static struct error *try_walk(struct tetra *tetra, const struct sites *sites,
                              struct warnings *warnings)
{
    int32_t *walk = NULL;
    size_t count;
    struct error *err = thin_walk(tetra, sites, &walk, &count);
    if (!err && walk) {
        give_up(tetra);
        err = string_walk(tetra, sites->count, walk, count);
        tetra->thin = TETRA_WALK;
        warnings_add(warnings, "thin",
                     "the probes are strung along a walk: its %zu steps are the cells (--thin 0: "
                     "triangles or tetrahedra)",
                     count);
    }
    free(walk);
    return err;
}

/* Tetrahedra of storeys and the like, without the noise on their hull; with it, where that would
 * leave no sound hull. */
static struct error *make_storeys(struct tetra *tetra, const struct sites *sites,
                                  const struct tetra_settings *settings)
{
    struct error *err = make_tetrahedra(tetra, sites, settings, true);
    if (err)
        return err;
    err = tetra_check_sites(tetra, sites->count, sites->site, sites->axis, settings->threads);
    if (!err)
        return NULL;
    error_destroy(err);
    give_up(tetra);
    return make_tetrahedra(tetra, sites, settings, false);
}

/* Says so where parts of the probes are thin and their noise makes cells. Of ordinary ones (grids,
 * boxes of up to 1:4, octrees, random ones, rooms with a hole) at most .1 % of the cells are such,
 * of storeys of one layer each hardly more are left. */
static void warn_far(struct warnings *warnings, const struct tetra *tetra,
                     const struct sites *sites)
{
    const struct thin_far far = thin_far(tetra, sites);
    char cells[24], volume[24];
    if (far.cells >= 0.05 || far.volume >= 0.1)
        warnings_add(
            warnings, "far",
            "parts of the probes are one layer or one row, and %s of the cells there, %s of the "
            "volume, are noise that blends probes that are more than %g times as far from each "
            "other "
            "as from their neighbours: place a second layer or row beside them, or make "
            "cells of each part in a stream of its own",
            percent(far.cells, cells), percent(far.volume, volume), THIN_FAR);
}

/* Cells of checked shape of sites that span a plane or space. */
static struct error *make_checked(struct tetra *tetra, const struct sites *sites,
                                  const struct tetra_settings *settings, struct warnings *warnings)
{
    const bool ask = settings->thin > 0 && sites->corners >= 3;
    const struct thin_look look = ask ? thin_look(sites) : (struct thin_look){0};
    const bool line = ask && thin_may_be_line(&look),
               sheet = ask && sites->corners == 4 && thin_may_be_sheet(&look);
    struct error *err = line ? try_line(tetra, sites, settings, warnings) : NULL;
    if (!err && !tetra->thin && line)
        err = make_cells(tetra, sites, settings);
    if (!err && !tetra->thin && line)
        err = try_walk(tetra, sites, warnings);
    if (!err && !tetra->thin && sheet) {
        give_up(tetra);
        err = try_sheet(tetra, sites, settings, warnings);
    }
    if (!err && !tetra->cell_count)
        err = sheet ? make_storeys(tetra, sites, settings) : make_cells(tetra, sites, settings);
    if (err || tetra->thin)
        return err;
    if (ask && sites->corners == 4)
        warn_far(warnings, tetra, sites);
    return tetra_check_sites(tetra, sites->count, sites->site, sites->axis, settings->threads);
}

/* -- and what is said of them ------------------------------------------------------------------ */

static void warn_merged(struct warnings *warnings, const struct tetra *tetra, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (tetra->merged[i] >= 0) {
            warnings_add(warnings, "merged",
                         "%zu of %zu probes are merged with one next to them: they keep their "
                         "light, but are in no cell (probe %zu "
                         "is where probe %d is)",
                         tetra->merged_count, count, i, tetra->merged[i]);
            return;
        }
}

struct error *tetra_make(struct tetra *tetra, size_t count, const double *position,
                         const struct tetra_settings *settings, struct warnings *warnings)
{
    *tetra = (struct tetra){0};
    struct sites sites;
    const struct sites_settings site_settings = {settings->merge, settings->light,
                                                 settings->light_width, settings->threads};
    struct error *err = sites_make(&sites, count, position, &site_settings);
    if (err)
        return err;
    err = make_checked(tetra, &sites, settings, warnings);
    if (!err)
        err = hull_normals(tetra, count, &sites);
    struct numbering numbering = {tetra, sites.row};
    if (!err)
        err = threads_for(settings->threads,
                          ((size_t)tetra->corners * tetra->cell_count + CHUNK - 1) / CHUNK,
                          number_chunk, &numbering);
    if (!err) {
        tetra->merged = sites.merged;
        tetra->merged_count = sites.merged_count;
        sites.merged = NULL;
        if (tetra->merged)
            warn_merged(warnings, tetra, count);
    }
    sites_clear(&sites);
    if (err)
        tetra_clear(tetra);
    return err;
}

struct error *tetra_build(struct tetra *tetra, size_t count, const double *position,
                          struct warnings *warnings)
{
    const struct tetra_settings settings = tetra_settings_default();
    return tetra_make(tetra, count, position, &settings, warnings);
}

void tetra_clear(struct tetra *tetra)
{
    tetra_await(tetra);
    free_room(tetra);
    free(tetra->hull_normal);
    free(tetra->merged);
    *tetra = (struct tetra){0};
}
