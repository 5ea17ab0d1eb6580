/* SPDX-License-Identifier: Apache-2.0 */
/* The method `octree` of probe-place: probes at the corners of the cells of an octree, which are
 * cut where tests of light or of surfaces say so, and joined again where that made no difference.
 * Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005. Greger et al., "The irradiance
 * volume", IEEE Computer Graphics and Applications 18(2), 1998: cells that hold a surface. Pharr
 * and Humphreys, "Physically based rendering", 2004: the harmonic mean of distances. What they
 * leave open is in man probe-place.
 */
#include "adapt/contrast.h"
#include "adapt/place_light.h"
#include "adapt/voxels.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/vec.h"
#include "place/place_inside.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "trace/enter.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How far inside of the scene's box the tree is, in sides of its smallest cells, unless told
 * otherwise. */
static const double INSET_SHARE = 0.25;

/* A node nearer to a surface than this share of the smallest cell's side is on it. */
static const double ON_SHARE = 1e-3;

/* -- options ---------------------------------------------------------------------------------- */

/* What cuts a cell, and the threshold unless told otherwise; 0: there is none. */
static const struct test {
    const char *name;
    double threshold;
} tests[PLACE_CUTS] = {[PLACE_CUT_GEOMETRY] = {"geometry", 0},
                       [PLACE_CUT_DISTANCE] = {"distance", 1},
                       [PLACE_CUT_GRADIENT] = {"gradient", 1},
                       [PLACE_CUT_CONTRAST] = {"contrast", 0.6},
                       [PLACE_CUT_ALL] = {"all", 0}};

/* "geometry,gradient=0.3": which tests there are, NaN for those there are not. */
static struct error *parse_cut(void *value, const char *text)
{
    double *cut = value;
    for (int i = 0; i < PLACE_CUTS; i++)
        cut[i] = NAN;
    for (const char *at = text;; at++) {
        const size_t length = strcspn(at, ",");
        char word[64];
        int i = 0;
        snprintf(word, sizeof word, "%.*s", (int)length, at);
        char *number = strchr(word, '=');
        if (number)
            *number++ = 0;
        while (i < PLACE_CUTS && strcmp(tests[i].name, word))
            i++;
        if (i == PLACE_CUTS)
            return error_usage("--cut: expected geometry, distance, gradient, contrast or all, "
                               "with commas between, got '%s'",
                               word);
        if (number && !(tests[i].threshold > 0))
            return error_usage("--cut: %s has no threshold", word);
        cut[i] = tests[i].threshold;
        struct error *err = number ? options_real("--cut", number, &cut[i]) : NULL;
        if (err)
            return err;
        if (number && !(cut[i] > 0))
            return error_usage("--cut: expected a threshold greater than 0, got %s", number);
        at += length;
        if (!*at)
            return NULL;
    }
}

static struct error *parse_levels(void *value, const char *text)
{
    struct place_options *o = value;
    int least = 0, most = 0, used = 0;
    o->least_level_given = sscanf(text, "%d:%d%n", &least, &most, &used) == 2;
    if ((!o->least_level_given && sscanf(text, "%d%n", &most, &used) != 1) || text[used] ||
        least < 0 || least > most || most > PLACE_LEVELS_MOST)
        return error_usage("--levels: expected MAX or MIN:MAX, from 0 to %d, got '%s'",
                           PLACE_LEVELS_MOST, text);
    o->levels[0] = o->least_level_given ? least : (most < o->levels[0] ? most : o->levels[0]);
    o->levels[1] = most;
    return NULL;
}

static struct error *parse_cells(void *value, const char *text)
{
    int32_t *cells = value;
    double number[3];
    struct error *err = options_reals("--cells", text, 3, number);
    for (int k = 0; k < 3 && !err; k++) {
        if (!(number[k] >= 1 && number[k] <= 1e6 && number[k] == floor(number[k])))
            err = error_usage("--cells: expected whole numbers from 1, got '%s'", text);
        else
            cells[k] = (int32_t)number[k];
    }
    return err;
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "cells",
         .argument = "NX,NY,NZ",
         .kind = OPTION_CALL,
         .parse = parse_cells,
         .value = o->octree.cells,
         .given = &o->octree.cells_given,
         .shown = "as cubic as the box allows",
         .help = "octree: cells of level 0 along each axis"},
        {.name = "levels",
         .argument = "[MIN:]MAX",
         .kind = OPTION_CALL,
         .parse = parse_levels,
         .value = o,
         .given = &o->levels_given,
         .shown = "1:2",
         .help = "octree: cells are cut to MIN, and no further than MAX; spawn-merge:\n"
                 "none comes nearer to another than spacing / 2^MAX, but where two merge"},
        {.name = "cut",
         .argument = "TEST[=X],...",
         .kind = OPTION_CALL,
         .parse = parse_cut,
         .value = o->octree.cut,
         .given = &o->octree.cut_given,
         .shown = "distance=1",
         .help = "octree: a cell is cut where one of these says so: geometry (a surface\n"
                 "comes in), distance=K (its edge is longer than K times the harmonic mean\n"
                 "of what a corner sees), gradient=G (light changes by G over its edge),\n"
                 "contrast=C (between two corners), all"},
        {.name = "cull",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &o->octree.cull,
         .given = &o->octree.cull_given,
         .least_open = true,
         .most = INFINITY,
         .shown = "none",
         .help = "octree: cut cells are joined again where all light within is what\n"
                 "their corners foretell, but for a contrast of X"},
        {.name = "inset",
         .argument = "D",
         .kind = OPTION_REAL,
         .value = &o->octree.inset,
         .given = &o->octree.inset_given,
         .most = INFINITY,
         .shown = "0.25 of the smallest cells",
         .help = "octree: how far inside of the scene's box it begins; with --bounds 0"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

/* -- the tree that is made -------------------------------------------------------------------- */

struct making {
    struct place_light light;
    const struct place_options *options;
    struct reach *reach; /* NULL: anywhere */
    struct voxels voxels;
    bool need_light, need_gradient;
    size_t measured; /* nodes that are known: */
    double *position;
    bool *air;
    float *sh;     /* what is in no air has none; and so is: */
    double *steep; /* root mean square change of irradiance by length */
    double *depth; /* harmonic mean distance of surfaces; INFINITY: none */
    size_t room[5];
    struct contrast contrast; /* by the mean of all light until then */
    /* of each level: cells that each test would cut, and that were cut and culled */
    size_t by_test[PLACE_LEVELS_MOST + 1][PLACE_CUTS], cut[PLACE_LEVELS_MOST + 1],
        culled[PLACE_LEVELS_MOST + 1];
};

static void clear(struct making *m)
{
    voxels_clear(&m->voxels);
    reach_destroy(m->reach);
    place_light_close(&m->light);
    free(m->position);
    free(m->air);
    free(m->sh);
    free(m->steep);
    free(m->depth);
}

static bool tests_by(const struct making *m, enum place_cut test)
{
    return !isnan(m->options->octree.cut[test]);
}

/* -- nodes ------------------------------------------------------------------------------------ */

static double steepness(const struct making *m, const struct capture_probe *probe)
{
    const int order = m->light.settings.order;
    const size_t width = place_light_width(&m->light);
    double sum = 0;
    for (int l = 0; l < order; l++)
        for (size_t i = 3 * (size_t)(l * l); i < 3 * (size_t)((l + 1) * (l + 1)); i++)
            for (size_t k = 0; k < 3; k++) {
                const double slope = sh_cosine(l) * (double)probe->sh_gradient[k * width + i];
                sum += slope * slope;
            }
    return sqrt(sum / (3 * 4 * 3.14159265358979323846));
}

struct measuring {
    struct making *making;
    struct capture_settings settings;
    struct progress *progress;
};

static struct error *measure_one(void *context, size_t index, int thread)
{
    (void)thread;
    struct measuring *work = context;
    struct making *m = work->making;
    const size_t i = m->measured + index, width = place_light_width(&m->light);
    struct capture_probe probe;
    progress_add(work->progress, 1);
    if (!m->air[i] || interrupt_came())
        return NULL;
    struct error *err =
        capture_probe(&m->light.path, &work->settings, m->position + 3 * i, NULL, &probe);
    for (size_t k = 0; k < width && m->need_light && !err; k++) {
        m->sh[width * i + k] = probe.sh[k];
        if (!isfinite(probe.sh[k]))
            err = error_new("light is beyond what 32 bits can hold: --light-scale brings it down");
    }
    if (err)
        return err;
    m->depth[i] = probe.depth > 0 ? (double)probe.depth : (double)INFINITY;
    m->steep[i] = m->need_gradient ? steepness(m, &probe) : 0;
    return NULL;
}

static struct error *make_room(struct making *m)
{
    const size_t n = m->voxels.nodes;
    struct error *err = array_reserve(&m->position, &m->room[0], n, 3 * sizeof *m->position);
    if (!err)
        err = array_reserve(&m->air, &m->room[1], n, sizeof *m->air);
    if (!err && m->need_light)
        err = array_reserve(&m->sh, &m->room[2], n, place_light_width(&m->light) * sizeof *m->sh);
    if (!err)
        err = array_reserve(&m->steep, &m->room[3], n, sizeof *m->steep);
    if (!err)
        err = array_reserve(&m->depth, &m->room[4], n, sizeof *m->depth);
    return err;
}

/* Finds out all about the nodes that are new. */
static struct error *measure(struct making *m)
{
    const size_t first = m->measured, count = m->voxels.nodes - first,
                 width = place_light_width(&m->light);
    const struct place_world *world = m->light.world;
    struct error *err = place_check_count((double)m->voxels.nodes, world->most);
    struct measuring work = {.making = m, .settings = m->light.settings};
    double side[3];
    if (!err)
        err = make_room(m);
    for (size_t i = first; i < m->voxels.nodes && !err; i++)
        voxels_position(&m->voxels, i, m->position + 3 * i);
    if (!err)
        err = place_light_air(&m->light, count, m->position + 3 * first, m->air + first);
    if (err)
        return err;
    voxels_sides(&m->voxels, m->voxels.deepest, side);
    const double on = ON_SHARE * fmin(side[0], fmin(side[1], side[2]));
    for (size_t i = first; i < m->voxels.nodes; i++) {
        m->air[i] = m->air[i] && trace_distance(m->light.tracer, m->position + 3 * i) > on;
        m->steep[i] = 0;
        m->depth[i] = (double)NAN;
        for (size_t k = 0; k < width && m->need_light; k++)
            m->sh[width * i + k] = 0;
    }
    work.settings.columns = CAPTURE_DEPTH | (m->need_gradient ? CAPTURE_GRADIENT : 0);
    if (!m->need_light) {
        work.settings.light = CAPTURE_DIRECT;
        work.settings.bounces = 0;
    }
    work.progress = progress_start(world->progress, world->program, "nodes", count);
    err = threads_for(world->inside.threads, count, measure_one, &work);
    progress_end(work.progress);
    m->measured = m->voxels.nodes;
    return err;
}

/* Tells the judge of air what the scene is, by points all over the box. */
static struct error *look_around(struct making *m)
{
    enum { SIDE = 10 };
    double p[3 * SIDE * SIDE * SIDE];
    bool air[SIDE * SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = m->voxels.low[k] +
                           (at[k] + .5) / SIDE * (m->voxels.high[k] - m->voxels.low[k]);
    }
    return place_light_air(&m->light, SIDE * SIDE * SIDE, p, air);
}

static void weigh_light(struct making *m)
{
    const size_t width = place_light_width(&m->light);
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < m->measured && m->need_light; i++)
        if (m->air[i]) {
            sum += contrast_mean(m->light.settings.order, 1, m->sh + width * i);
            count++;
        }
    m->contrast = contrast_make(CONTRAST_RMS, CONTRAST_RELATIVE, m->light.settings.order,
                                count ? sum / (double)count : 0);
}

/* -- tests ------------------------------------------------------------------------------------ */

/* Whether a surface comes into a cell: into one of the five tetrahedra that make it up. */
static bool holds_surface(const struct making *m, const struct voxel *v)
{
    static const int part[5][4] = {
        {0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};
    for (int i = 0; i < 5; i++) {
        const double *corner[4];
        for (int j = 0; j < 4; j++)
            corner[j] = m->position + 3 * (size_t)v->node[part[i][j]];
        if (trace_enter(m->light.tracer, 4, corner, NULL, NULL))
            return true;
    }
    return false;
}

static double least_depth(const struct making *m, const struct voxel *v)
{
    double least = (double)INFINITY;
    for (int j = 0; j < 8; j++)
        if (m->air[v->node[j]])
            least = fmin(least, m->depth[v->node[j]]);
    return least;
}

static int corners_in_air(const struct making *m, const struct voxel *v)
{
    int count = 0;
    for (int j = 0; j < 8; j++)
        count += m->air[v->node[j]];
    return count;
}

static bool differs(const struct making *m, const struct voxel *v, double threshold)
{
    const size_t width = place_light_width(&m->light);
    for (int j = 0; j < 8; j++)
        for (int i = 0; i < j; i++)
            if (m->air[v->node[i]] && m->air[v->node[j]] &&
                contrast(&m->contrast, m->sh + width * (size_t)v->node[i],
                         m->sh + width * (size_t)v->node[j]) > threshold)
                return true;
    return false;
}

static bool is_steep(const struct making *m, const struct voxel *v, double edge, double threshold)
{
    for (int j = 0; j < 8; j++)
        if (m->air[v->node[j]] && edge * m->steep[v->node[j]] > threshold * m->contrast.mean)
            return true;
    return false;
}

/* Whether the region comes into a cell. */
static bool is_reached(const struct making *m, const struct voxel *v)
{
    double middle[3], half[3];
    if (!m->reach)
        return true;
    voxels_sides(&m->voxels, v->level, half);
    for (int k = 0; k < 3; k++) {
        half[k] /= 2;
        middle[k] = m->position[3 * (size_t)v->node[0] + (size_t)k] + half[k];
    }
    return reach_near(m->reach, middle, half);
}

/* Whether a cell is to be cut; counts who says so. Where fewer than half of its corners are in the
 * air there is nothing to go by, and whoever asks them cuts it where a surface comes in. */
static bool is_to_cut(struct making *m, const struct voxel *v)
{
    const double *cut = m->options->octree.cut;
    bool says[PLACE_CUTS] = {false}, any = v->level < m->options->levels[0];
    double side[3];
    voxels_sides(&m->voxels, v->level, side);
    const double edge = fmax(side[0], fmax(side[1], side[2]));
    const bool blind = corners_in_air(m, v) < 4 && holds_surface(m, v);
    if (tests_by(m, PLACE_CUT_GEOMETRY))
        says[PLACE_CUT_GEOMETRY] = holds_surface(m, v);
    if (tests_by(m, PLACE_CUT_DISTANCE))
        says[PLACE_CUT_DISTANCE] = blind || edge > cut[PLACE_CUT_DISTANCE] * least_depth(m, v);
    if (tests_by(m, PLACE_CUT_GRADIENT))
        says[PLACE_CUT_GRADIENT] = blind || is_steep(m, v, edge, cut[PLACE_CUT_GRADIENT]);
    if (tests_by(m, PLACE_CUT_CONTRAST))
        says[PLACE_CUT_CONTRAST] = blind || differs(m, v, cut[PLACE_CUT_CONTRAST]);
    says[PLACE_CUT_ALL] = tests_by(m, PLACE_CUT_ALL);
    for (int i = 0; i < PLACE_CUTS; i++) {
        m->by_test[v->level][i] += says[i];
        any = any || says[i];
    }
    return any;
}

/* Cuts level by level. */
static struct error *refine(struct making *m)
{
    size_t from = 0;
    struct error *err = measure(m);
    for (int level = 0; level < m->voxels.deepest && !err && !interrupt_came(); level++) {
        const size_t end = m->voxels.count;
        weigh_light(m);
        for (size_t i = from; i < end && !err; i++) {
            const struct voxel v = m->voxels.voxel[i];
            if (!is_reached(m, &v) || !is_to_cut(m, &v))
                continue;
            m->cut[level]++;
            err = voxels_cut(&m->voxels, i);
            if (!err)
                err = place_check_count((double)m->voxels.nodes, m->light.world->most);
        }
        from = end;
        if (!err)
            err = measure(m);
    }
    return err;
}

/* -- joining ---------------------------------------------------------------------------------- */

/* What the cell's corners foretell for one of its 27 nodes; false: none is in the air. */
static bool foretell(const struct making *m, const struct voxel *v, int node, float *sh)
{
    const size_t width = place_light_width(&m->light);
    double all = 0, sum[3 * SH_COUNT_MAX] = {0};
    for (int j = 0; j < 8; j++) {
        const double x[3] = {node % 3 / 2.0, node / 3 % 3 / 2.0, node / 9 / 2.0};
        double weight = 1;
        for (int k = 0; k < 3; k++)
            weight *= j >> k & 1 ? x[k] : 1 - x[k];
        if (!m->air[v->node[j]])
            continue;
        all += weight;
        for (size_t k = 0; k < width; k++)
            sum[k] += weight * (double)m->sh[width * (size_t)v->node[j] + k];
    }
    for (size_t k = 0; k < width && all > 0; k++)
        sh[k] = (float)(sum[k] / all);
    return all > 0;
}

/* Whether what a cut added tells nothing new. */
static bool is_idle(const struct making *m, size_t i)
{
    const struct voxel *v = &m->voxels.voxel[i];
    const size_t width = place_light_width(&m->light);
    int32_t node[27];
    float sh[3 * SH_COUNT_MAX];
    for (int part = 0; part < 8; part++)
        if (m->voxels.voxel[v->child + part].child)
            return false;
    voxels_nodes(&m->voxels, i, node);
    for (int n = 0; n < 27; n++)
        if (m->air[node[n]] && (!foretell(m, v, n, sh) ||
                                contrast(&m->contrast, sh, m->sh + width * (size_t)node[n]) >=
                                    m->options->octree.cull))
            return false;
    return true;
}

/* Children stand behind their parents, so those come to be leaves before they are asked. */
static void cull(struct making *m)
{
    weigh_light(m);
    for (size_t i = m->voxels.count; i-- > 0;) {
        const struct voxel *v = &m->voxels.voxel[i];
        if (v->gone || !v->child || v->level < m->options->levels[0] || !is_idle(m, i))
            continue;
        m->culled[v->level]++;
        voxels_join(&m->voxels, i);
    }
}

/* -- what is told ----------------------------------------------------------------------------- */

static void tell(const struct making *m, const bool *used, size_t kept)
{
    const struct place_world *world = m->light.world;
    const struct voxels *v = &m->voxels;
    size_t nodes[PLACE_LEVELS_MOST + 1] = {0}, leaves[PLACE_LEVELS_MOST + 1] = {0}, no_air = 0;
    if (!world->program)
        return;
    for (size_t i = 0; i < v->nodes; i++) {
        nodes[v->level[i]] += used[i];
        no_air += used[i] && !m->air[i];
    }
    for (size_t i = 0; i < v->count; i++)
        leaves[v->voxel[i].level] += !v->voxel[i].gone && !v->voxel[i].child;
    fprintf(stderr, "%s: level %9s %9s %9s %9s", world->program, "nodes", "leaves", "cut",
            "joined");
    for (int t = 0; t < PLACE_CUTS; t++)
        if (tests_by(m, (enum place_cut)t))
            fprintf(stderr, " %9s", tests[t].name);
    for (int level = 0; level <= v->deepest; level++) {
        fprintf(stderr, "\n%s: %5d %9zu %9zu %9zu %9zu", world->program, level, nodes[level],
                leaves[level], m->cut[level], m->culled[level]);
        for (int t = 0; t < PLACE_CUTS; t++)
            if (tests_by(m, (enum place_cut)t))
                fprintf(stderr, " %9zu", m->by_test[level][t]);
    }
    fprintf(stderr, "\n%s: %zu nodes of %zu that were looked at, %zu of them in no air\n",
            world->program, kept, v->nodes, no_air);
}

/* Writes the nodes that are used, and what is known of them. */
static struct error *give(struct making *m, struct place *place)
{
    struct column *level = NULL, *inside = NULL, *depth = NULL;
    bool *used = NULL;
    double *position = NULL;
    size_t count = 0;
    struct error *err = array_create(&used, m->voxels.nodes, sizeof *used);
    if (!err)
        err = array_create(&position, m->voxels.nodes, 3 * sizeof *position);
    if (!err)
        voxels_used(&m->voxels, used);
    for (size_t i = 0; i < m->voxels.nodes && !err; i++)
        if (used[i])
            memcpy(position + 3 * count++, m->position + 3 * i, 3 * sizeof *position);
    if (!err)
        err = place_light_give(&m->light, place, count, position, place_method_octree.origin);
    if (!err)
        err = place_add_column(place, "level", COLUMN_I32, 1, &level);
    if (!err)
        err = place_add_column(place, "inside", COLUMN_I32, 1, &inside);
    if (!err)
        err = place_add_column(place, "depth", COLUMN_F32, 1, &depth);
    if (!err) {
        level = table_column(&place->columns, "level");
        inside = table_column(&place->columns, "inside");
        depth = table_column(&place->columns, "depth");
    }
    count = 0;
    for (size_t i = 0; i < m->voxels.nodes && !err; i++) {
        if (!used[i])
            continue;
        const double *p = m->position + 3 * i;
        const enum place_side side = m->air[i] ? PLACE_AIR : place_judge_side(m->light.judge, p);
        column_i32(level)[count] = m->voxels.level[i];
        /* what is in the air and on a surface counts as in it */
        column_i32(inside)[count] = m->air[i] ? 0 : side == PLACE_AIR ? PLACE_SOLID : (int)side;
        column_f32(depth)[count] = !m->air[i] ? NAN : isinf(m->depth[i]) ? 0 : (float)m->depth[i];
        count++;
    }
    if (!err)
        tell(m, used, count);
    free(used);
    free(position);
    return err;
}

/* -- the method ------------------------------------------------------------------------------- */

/* Cells of level 0: as cubic as they can be, about two along the shortest side, and no more than
 * sixteen along the longest. */
static void choose_cells(const double low[3], const double high[3], int32_t cells[3])
{
    double shortest = (double)INFINITY, longest = 0;
    for (int k = 0; k < 3; k++) {
        shortest = fmin(shortest, high[k] - low[k]);
        longest = fmax(longest, high[k] - low[k]);
    }
    const double edge = fmax(shortest / 2, longest / 16);
    for (int k = 0; k < 3; k++)
        cells[k] = (int32_t)fmax(floor((high[k] - low[k]) / edge + 0.5), 1);
}

static struct error *start(struct making *m)
{
    const struct place_options *o = m->options;
    int32_t cells[3];
    double low[3], high[3];
    double inset = o->octree.inset;
    struct place_space space;
    place_options_space(o, m->light.world, m->reach, &space);
    memcpy(low, space.low, sizeof low);
    memcpy(high, space.high, sizeof high);
    for (int k = 0; k < 3; k++)
        if (!(high[k] > low[k]))
            return error_new("an octree needs a box with a volume: --bounds gives one");
    if (o->octree.cells_given)
        memcpy(cells, o->octree.cells, sizeof cells);
    else
        choose_cells(low, high, cells);
    if (!o->octree.inset_given && !o->bounds_given) {
        inset = (double)INFINITY;
        for (int k = 0; k < 3; k++)
            inset = fmin(inset, INSET_SHARE * (high[k] - low[k]) /
                                    (cells[k] * ((int32_t)1 << o->levels[1]) + 2 * INSET_SHARE));
    }
    double roots = 1;
    for (int k = 0; k < 3; k++) {
        low[k] += inset;
        high[k] -= inset;
        roots *= cells[k] + 1.0;
        if (!(high[k] > low[k]))
            return error_new("--inset %g leaves nothing of the box", inset);
        if ((double)cells[k] * (1 << o->levels[1]) > PLACES_MOST)
            return error_new("--cells and --levels make more than %d cells along an axis",
                             PLACES_MOST);
    }
    struct error *err = place_check_count(roots, m->light.world->most);
    return err ? err : voxels_start(&m->voxels, low, high, cells, o->levels[1]);
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct making m = {.options = o};
    struct error *err = place_light_open(&m.light, o, world, 256, CAPTURE_ALL);
    m.need_gradient = tests_by(&m, PLACE_CUT_GRADIENT);
    m.need_light = m.need_gradient || tests_by(&m, PLACE_CUT_CONTRAST) || o->octree.cull_given;
    if (!err)
        err = place_reach_open(&m.reach, o, m.light.tracer, world);
    if (!err)
        err = start(&m);
    if (!err)
        err = look_around(&m);
    if (!err)
        err = refine(&m);
    world->interrupted = !err && interrupt_came();
    if (!err && o->octree.cull_given && !world->interrupted)
        cull(&m);
    if (!err)
        err = give(&m, place);
    clear(&m);
    return err;
}

static const char *const shared[] = {"bounds", "rays", "bounces", "light", "order", NULL};

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    return o->boxes > 1 ? error_usage("octree: expected one --bounds, got %d", o->boxes) : NULL;
}

const struct place_method place_method_octree = {.name = "octree",
                                                 .origin = 9,
                                                 .needs_scene = true,
                                                 .sees_light = true,
                                                 .shares = shared,
                                                 .reaches = true,
                                                 .rows = rows,
                                                 .check = check,
                                                 .place = place_by_options};
