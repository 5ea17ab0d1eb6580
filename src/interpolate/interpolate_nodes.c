/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds that blend the nodes of a grid (nodes.h), or of an octree (octree.h) where the probes
 * are none.
 *
 * Nodes in no air (column inside), but for those that hold the light of another probe (column
 * filled), are left out of linear blends, and the weights of the others grow to sum to 1. They keep
 * one of a thousandth, at which they have the value of the nearest node in the air: so a blend is
 * continuous where all nodes of a cell are in no air, too. A cubic of light is then this blend and
 * what the cubic of these values has beyond their linear blend. Scenes without such nodes pay
 * nothing.
 *
 * Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005: tricubic interpolation, inverse
 * distances, and gradients.
 */
#include "base/array.h"
#include "base/error.h"
#include "interpolate/bound.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/nodes.h"
#include "interpolate/octree.h"
#include "interpolate/scatter.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A grid has no data. */
struct own {
    struct nodes nodes;
    struct octree octree;
    float *data;        /* of the octree's nodes, linear; owned, and so is */
    float *cubic;       /* the same, cubic; NULL: it is not asked for */
    struct bound bound; /* cubic, of light */
    /* Where nodes are in no air: values of all nodes, what they weigh, and of the octree these
     * values, linear, and weights; its data are values times weights then. Else NULL; owned */
    float *value, *weight, *plain, *weight_data;
    /* Of gradients: what they add at a place p is, with `from` in the middle, a blend of slope[0],
     * and of slope[1 + k] times (p - from)[k]; as value or data; owned; NULL: not asked for */
    float *slope[4];
    double low[3], high[3], from[3];
    bool inverse; /* linear blends are by distance (nodes_inverse) */
};

/* How much of what gradients foretell counts: with half of it parabolas come out exactly, where the
 * whole, as Tatarchuk has it, is off as far as none is, to the other side. */
static const float GRADIENT_SHARE = 0.5f;

/* What a node in no air weighs. */
static const float NO_AIR = 1e-3f;

/* Why the probes are neither what one error says nor the other; takes both. */
static struct error *neither(struct error *grid, struct error *octree)
{
    struct error *err = error_new("%s; nor: %s", error_message(grid), error_message(octree));
    error_destroy(grid);
    error_destroy(octree);
    return err;
}

/* -- nodes in no air ----------------------------------------------------------------------- */

static const int32_t *numbers_of(const struct interpolate *in, const char *name)
{
    const struct table *probes = in->stream ? stream_table(in->stream, "probe") : NULL;
    const struct column *c = probes ? table_column(probes, name) : NULL;
    return c && c->type == COLUMN_I32 && c->width == 1 ? column_i32(c) : NULL;
}

static bool is_left_out(const void *weight, size_t probe)
{
    return ((const float *)weight)[probe] < 1;
}

/* Gives all nodes weights and values, where some are in no air and some in it. */
static struct error *leave_out(const struct interpolate *in, struct own *own, size_t probes)
{
    const int32_t *inside = numbers_of(in, "inside"), *filled = numbers_of(in, "filled");
    struct scatter *scatter = NULL;
    size_t count = 0;
    for (size_t i = 0; i < probes && inside; i++)
        count += inside[i] && !(filled && filled[i]);
    if (!count || count == probes)
        return NULL;
    struct error *err = array_create(&own->weight, probes, sizeof *own->weight);
    if (!err)
        err = array_create(&own->value, probes * in->width, sizeof *own->value);
    for (size_t i = 0; i < probes && !err; i++)
        own->weight[i] = inside[i] && !(filled && filled[i]) ? NO_AIR : 1;
    if (!err)
        err = scatter_create(&scatter, probes, in->position, is_left_out, own->weight);
    for (size_t i = 0; i < probes && !err; i++) {
        double distance;
        const size_t from = own->weight[i] < 1
                                ? (size_t)scatter_nearest(scatter, in->position + 3 * i, &distance)
                                : i;
        memcpy(own->value + in->width * i, in->value + in->width * from,
               in->width * sizeof *own->value);
    }
    scatter_destroy(scatter);
    return err;
}

static struct error *fill_left_out(const struct interpolate *in, struct own *own, bool cubic)
{
    const size_t width = in->width, probes = own->octree.probes;
    float *weighed = NULL;
    struct error *err = array_create(&weighed, probes * width, sizeof *weighed);
    for (size_t i = 0; i < probes * width && !err; i++)
        weighed[i] = own->weight[i / width] * own->value[i];
    if (!err)
        err = octree_fill(&own->octree, false, width, weighed, &own->data);
    if (!err)
        err = octree_fill(&own->octree, false, 1, own->weight, &own->weight_data);
    if (!err && cubic)
        err = octree_fill(&own->octree, false, width, own->value, &own->plain);
    free(weighed);
    return err;
}

/* -- opening ------------------------------------------------------------------------------- */

/* Probes are a grid, or else an octree, whose made nodes need the values of all. */
static struct error *open_nodes(struct interpolate *in, size_t probes, bool cubic)
{
    struct own *own = NULL;
    struct error *err = array_create(&own, 1, sizeof *own);
    if (err)
        return err;
    in->own = own;
    struct error *no_grid = nodes_find(&own->nodes, probes, in->position);
    if (!no_grid)
        return leave_out(in, own, probes);
    err = octree_find(&own->octree, probes, in->position);
    if (err)
        return neither(no_grid, err);
    error_destroy(no_grid);
    err = leave_out(in, own, probes);
    for (size_t i = 0; i < probes && !err; i++)
        err = interpolate_has(in, i) || (own->weight && own->weight[i] < 1)
                  ? NULL
                  : interpolate_unknown(in, (int32_t)i);
    if (!err && own->weight)
        err = fill_left_out(in, own, cubic);
    else if (!err)
        err = octree_fill(&own->octree, false, in->width, in->value, &own->data);
    if (!err && cubic)
        err = octree_fill(&own->octree, true, in->width, own->weight ? own->value : in->value,
                          &own->cubic);
    return err;
}

static struct error *open_linear(struct interpolate *in, size_t probes)
{
    return open_nodes(in, probes, false);
}

static struct error *open_inverse(struct interpolate *in, size_t probes)
{
    struct error *err = open_nodes(in, probes, false);
    if (!err)
        ((struct own *)in->own)->inverse = true;
    return err;
}

static struct error *open_cubic(struct interpolate *in, size_t probes)
{
    struct error *err = open_nodes(in, probes, true);
    if (!err && in->order)
        bound_start(&((struct own *)in->own)->bound, in->order, in->convolved);
    return err;
}

static void close_nodes(void *context)
{
    struct own *own = context;
    nodes_clear(&own->nodes);
    octree_clear(&own->octree);
    free(own->data);
    free(own->cubic);
    free(own->value);
    free(own->weight);
    free(own->plain);
    free(own->weight_data);
    for (int k = 0; k < 4; k++)
        free(own->slope[k]);
    free(own);
}

/* Whether p is within the box of a grid or octree, and how far outside. */
static void find_in_box(const struct interpolate *in, const double p[3], struct probe_place *place)
{
    const struct own *own = in->own;
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double low = own->data ? own->octree.low[k] : own->nodes.at[k][0],
                     high = own->data ? own->octree.high[k]
                                      : own->nodes.at[k][own->nodes.count[k] - 1],
                     off = fmax(fmax(low - p[k], p[k] - high), 0);
        square += off * off;
    }
    *place =
        (struct probe_place){.cell = PROBE_COLD, .inside = square == 0, .distance = sqrt(square)};
}

/* -- values -------------------------------------------------------------------------------- */

typedef void weigh_nodes(const struct nodes *nodes, int axis, double x, size_t node[4],
                         double weight[4]);

/* Of the cell around a place, by the weights that are linear. */
static void weigh_inverse(const struct nodes *nodes, size_t node[3][4], double weight[3][4],
                          double corner[8])
{
    double in[3], side[3];
    for (int k = 0; k < 3; k++) {
        in[k] = weight[k][1];
        side[k] = nodes->at[k][node[k][1]] - nodes->at[k][node[k][0]];
    }
    nodes_inverse(in, side, corner);
}

/* Blends the nodes of a grid. weight: NULL, or what each weighs. */
static struct error *blend_nodes(const struct interpolate *in, const double p[3],
                                 weigh_nodes *weigh, const float *value, const float *weight_of,
                                 float *out)
{
    const struct nodes *nodes = &((const struct own *)in->own)->nodes;
    size_t node[3][4];
    double weight[3][4], corner[8];
    const bool inverse = ((const struct own *)in->own)->inverse;
    const int most = inverse ? 2 : 4;
    float all = 0;
    for (int k = 0; k < 3; k++)
        weigh(nodes, k, p[k], node[k], weight[k]);
    if (inverse)
        weigh_inverse(nodes, node, weight, corner);
    for (size_t k = 0; k < in->width; k++)
        out[k] = 0;
    for (int z = 0; z < most; z++)
        for (int y = 0; y < most; y++)
            for (int x = 0; x < most; x++) {
                float w = (float)(inverse ? corner[x | y << 1 | z << 2]
                                          : weight[0][x] * weight[1][y] * weight[2][z]);
                if (w == 0) /* what has no weight has no say, not even as a missing value */
                    continue;
                const int32_t probe =
                    nodes->probe[(node[2][z] * nodes->count[1] + node[1][y]) * nodes->count[0] +
                                 node[0][x]];
                const float *f = value + (size_t)probe * in->width;
                if (isnan(f[0]))
                    return interpolate_unknown(in, probe);
                if (weight_of)
                    all += w *= weight_of[probe];
                for (size_t k = 0; k < in->width; k++)
                    out[k] += w * f[k];
            }
    for (size_t k = 0; k < in->width && weight_of; k++)
        out[k] /= all;
    return NULL;
}

static void octree_blend(const struct own *own, size_t width, const float *data,
                         const double point[3], float *out)
{
    if (own->inverse)
        octree_at_inverse(&own->octree, width, data, point, out);
    else
        octree_at(&own->octree, false, width, data, point, out);
}

/* A linear blend of values of a grid's nodes, or data of an octree's. */
static struct error *blend(const struct interpolate *in, const double point[3], const float *value,
                           float *out)
{
    const struct own *own = in->own;
    if (!own->data)
        return blend_nodes(in, point, nodes_linear, value, own->weight, out);
    octree_blend(own, in->width, value, point, out);
    if (own->weight) {
        float all;
        octree_blend(own, 1, own->weight_data, point, &all);
        for (size_t k = 0; k < in->width; k++)
            out[k] /= all;
    }
    return NULL;
}

static struct error *linear(const struct interpolate *in, const double point[3], float *out)
{
    const struct own *own = in->own;
    return blend(in, point, own->data ? own->data : own->value ? own->value : in->value, out);
}

/* The linear blend that a cubic goes beyond: of all nodes alike. */
static struct error *plain(const struct interpolate *in, const double point[3], float *out)
{
    const struct own *own = in->own;
    if (!own->data)
        return blend_nodes(in, point, nodes_linear, own->value, NULL, out);
    octree_at(&own->octree, false, in->width, own->plain, point, out);
    return NULL;
}

static struct error *cubic(const struct interpolate *in, const double point[3], float *out)
{
    const struct own *own = in->own;
    if (!own->data)
        return blend_nodes(in, point, nodes_cubic, own->value ? own->value : in->value, NULL, out);
    octree_at(&own->octree, true, in->width, own->cubic, point, out);
    return NULL;
}

/* What the cubic has, of light, beyond the linear blend, which is in `out`. */
static struct error *go_beyond(const struct interpolate *in, const double point[3],
                               const float *out, float *more)
{
    const struct own *own = in->own;
    float all[3 * SH_COUNT_MAX];
    struct error *err = cubic(in, point, more);
    if (!err && own->weight)
        err = plain(in, point, all);
    for (size_t k = 0; k < in->width && !err; k++)
        more[k] -= own->weight ? all[k] : out[k];
    return err;
}

static struct error *linear_at(const struct interpolate *in, const double point[3],
                               const struct probe_place *place, float *out)
{
    (void)place;
    return linear(in, point, out);
}

/* A cubic swings below what it goes through: where it takes more light from the linear blend, on
 * any side, than that has, it counts in part (bound.h). */
static struct error *cubic_at(const struct interpolate *in, const double point[3],
                              const struct probe_place *place, float *out)
{
    (void)place;
    if (!in->order)
        return cubic(in, point, out);
    float more[3 * SH_COUNT_MAX], share[3];
    struct error *err = linear(in, point, out);
    if (!err)
        err = go_beyond(in, point, out, more);
    if (err)
        return err;
    bound_shares(&((const struct own *)in->own)->bound, out, more, share);
    for (size_t k = 0; k < in->width; k++)
        out[k] += share[k % 3] * more[k];
    return NULL;
}

/* Adds what gradients foretell, as far as it takes no more light than there is. */
static struct error *slopes_at(const struct interpolate *in, const double point[3],
                               const struct probe_place *place, float *out)
{
    (void)place;
    const struct own *own = in->own;
    float more[3 * SH_COUNT_MAX], term[3 * SH_COUNT_MAX], share[3] = {1, 1, 1};
    struct error *err = linear(in, point, out);
    if (!err)
        err = blend(in, point, own->slope[0], more);
    for (int k = 0; k < 3 && !err; k++) {
        const double x = fmin(fmax(point[k], own->low[k]), own->high[k]) - own->from[k];
        err = blend(in, point, own->slope[1 + k], term);
        for (size_t v = 0; v < in->width && !err; v++)
            more[v] += (float)x * term[v];
    }
    for (size_t v = 0; v < in->width && !err; v++)
        more[v] *= GRADIENT_SHARE;
    if (!err && in->order)
        bound_shares(&own->bound, out, more, share);
    for (size_t v = 0; v < in->width && !err; v++)
        out[v] += in->order ? share[v % 3] * more[v] : fmaxf(more[v], -fabsf(out[v]));
    return err;
}

/* -- gradients ----------------------------------------------------------------------------- */

/* The nearest place where the largest cell beside a node ends, along an axis, on a side; false: the
 * node is on the border of the box. */
static bool place_beside(const struct interpolate *in, size_t i, int axis, int side, double q[3])
{
    const struct own *own = in->own;
    memcpy(q, in->position + 3 * i, 3 * sizeof *q);
    if (!own->data) {
        const size_t at = nodes_plane(&own->nodes, axis, q[axis]);
        if (side < 0 ? at == 0 : at + 1 == own->nodes.count[axis])
            return false;
        q[axis] = own->nodes.at[axis][side < 0 ? at - 1 : at + 1];
        return true;
    }
    const struct octree *t = &own->octree;
    const int32_t to = t->site[i][axis] + side * t->spacing[i];
    if (to < 0 || to > t->units[axis] || !t->units[axis])
        return false;
    q[axis] += side * (t->high[axis] - t->low[axis]) * t->spacing[i] / t->units[axis];
    return true;
}

/* What counts of what a slope foretells beyond what is there: no more than what both have together,
 * of light as a whole (order), else one by one. Half of it, as in cells, holds parabolas that touch
 * 0, and gains nothing. */
static void limit_one(const struct interpolate *in, const struct bound *bound, const float *here,
                      const float *there, const float *more, float *share)
{
    const float light = in->order ? bound_part(bound_size(bound, more),
                                               bound_size(bound, here) + bound_size(bound, there))
                                  : 1;
    for (size_t v = 0; v < in->width; v++)
        share[v] =
            fminf(share[v],
                  in->order ? light : bound_part(fabsf(more[v]), fabsf(here[v]) + fabsf(there[v])));
}

/* A node's gradient along an axis, held by the light on both sides: towards the slope between
 * them (bound.h; Barth and Jespersen 1989). */
static struct error *limit_slope(const struct interpolate *in, size_t i, int axis, float *slope)
{
    const struct own *own = in->own;
    const size_t width = in->width;
    const double x = in->position[3 * i + (size_t)axis];
    float value[2][3 * SH_COUNT_MAX], share[3 * SH_COUNT_MAX], more[3 * SH_COUNT_MAX];
    double end[2] = {x, x}, q[3];
    const float *here = (own->value ? own->value : in->value) + width * i;
    struct error *err = NULL;
    for (size_t v = 0; v < width; v++) {
        value[0][v] = value[1][v] = here[v];
        share[v] = 1;
    }
    for (int side = 0; side < 2 && !err; side++) {
        if (!place_beside(in, i, axis, 2 * side - 1, q))
            continue;
        err = linear(in, q, value[side]);
        end[side] = q[axis];
        for (size_t v = 0; v < width && !err; v++)
            more[v] = (float)(end[side] - x) * slope[v] - (value[side][v] - here[v]);
        if (!err)
            limit_one(in, &own->bound, here, value[side], more, share);
    }
    for (size_t v = 0; v < width && !err; v++)
        if (share[v] < 1) {
            const float between = (value[1][v] - value[0][v]) / (float)(end[1] - end[0]);
            slope[v] = between + share[v] * (slope[v] - between);
        }
    return err;
}

/* What all nodes' gradients are, but for those in no air, which have what is not their own. */
static struct error *limit_slopes(const struct interpolate *in, size_t probes, float *gradient)
{
    const struct own *own = in->own;
    struct error *err = NULL;
    for (size_t i = 0; i < probes && !err; i++) {
        float *g = gradient + 3 * in->width * i;
        if (own->weight && own->weight[i] < 1) {
            memset(g, 0, 3 * in->width * sizeof *g);
            continue;
        }
        memcpy(g, in->gradient + 3 * in->width * i, 3 * in->width * sizeof *g);
        if (isnan(g[0]))
            err = error_new("probe %zu has no gradient: run probe-capture", i);
        for (int k = 0; k < 3 && !err; k++)
            err = limit_slope(in, i, k, g + (size_t)k * in->width);
    }
    return err;
}

/* Of each node c + g (p - x) is foretold for p, so what g adds is -g (x - from) + g (p - from). */
static struct error *spread_slopes(const struct interpolate *in, size_t probes,
                                   const float *gradient)
{
    const size_t width = in->width;
    struct own *own = in->own;
    struct error *err = NULL;
    for (size_t t = 0; t < 4 && !err; t++) {
        float *slope = NULL;
        err = array_create(&slope, probes * width, sizeof *slope);
        for (size_t i = 0; i < probes && !err; i++) {
            const float *g = gradient + 3 * width * i;
            for (size_t v = 0; v < width; v++) {
                double sum = t ? (double)g[(t - 1) * width + v] : 0;
                for (size_t k = 0; k < 3 && !t; k++)
                    sum -= (double)g[k * width + v] * (in->position[3 * i + k] - own->from[k]);
                slope[width * i + v] = (float)sum;
            }
        }
        own->slope[t] = slope;
        if (!err && own->data) {
            err = octree_fill(&own->octree, false, width, slope, &own->slope[t]);
            free(slope);
        }
    }
    return err;
}

static struct error *open_slopes(struct interpolate *in, size_t probes)
{
    float *gradient = NULL;
    struct error *err = open_nodes(in, probes, false);
    struct own *own = in->own;
    if (!err && in->width > 3 * SH_COUNT_MAX)
        err = error_new("column %s is too wide to be blended by gradients: %zu numbers",
                        in->settings.column, in->width);
    for (int k = 0; k < 3 && !err; k++) {
        own->low[k] = own->data ? own->octree.low[k] : own->nodes.at[k][0];
        own->high[k] = own->data ? own->octree.high[k] : own->nodes.at[k][own->nodes.count[k] - 1];
        own->from[k] = (own->low[k] + own->high[k]) / 2;
    }
    if (!err && in->order)
        bound_start(&own->bound, in->order, in->convolved);
    if (!err)
        err = array_create(&gradient, probes * in->width, 3 * sizeof *gradient);
    if (!err)
        err = limit_slopes(in, probes, gradient);
    if (!err)
        err = spread_slopes(in, probes, gradient);
    free(gradient);
    return err;
}

const struct interpolate_kind interpolate_trilinear = {.name = "trilinear",
                                                       .open = open_linear,
                                                       .close = close_nodes,
                                                       .find = find_in_box,
                                                       .at = linear_at};
const struct interpolate_kind interpolate_tricubic = {.name = "tricubic",
                                                      .open = open_cubic,
                                                      .close = close_nodes,
                                                      .find = find_in_box,
                                                      .at = cubic_at};
const struct interpolate_kind interpolate_trilinear_gradient = {.name = "trilinear-gradient",
                                                                .needs_gradients = true,
                                                                .open = open_slopes,
                                                                .close = close_nodes,
                                                                .find = find_in_box,
                                                                .at = slopes_at};
const struct interpolate_kind interpolate_inverse = {.name = "inverse",
                                                     .open = open_inverse,
                                                     .close = close_nodes,
                                                     .find = find_in_box,
                                                     .at = linear_at};
