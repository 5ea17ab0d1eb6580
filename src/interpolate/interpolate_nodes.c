/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds that blend the nodes of a grid (nodes.h), or of an octree (octree.h) where the probes
 * are none. Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005: tricubic interpolation.
 */
#include "base/array.h"
#include "base/error.h"
#include "interpolate/bound.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/nodes.h"
#include "interpolate/octree.h"

#include <math.h>
#include <stdlib.h>

/* A grid has no data. */
struct own {
    struct nodes nodes;
    struct octree octree;
    float *data;        /* of the octree's nodes, linear; owned, and so is */
    float *cubic;       /* the same, cubic; NULL: it is not asked for */
    struct bound bound; /* cubic, of light */
};

/* Why the probes are neither what one error says nor the other; takes both. */
static struct error *neither(struct error *grid, struct error *octree)
{
    struct error *err = error_new("%s; nor: %s", error_message(grid), error_message(octree));
    error_destroy(grid);
    error_destroy(octree);
    return err;
}

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
        return NULL;
    err = octree_find(&own->octree, probes, in->position);
    if (err)
        return neither(no_grid, err);
    error_destroy(no_grid);
    for (size_t i = 0; i < probes && !err; i++)
        err = interpolate_has(in, i) ? NULL : interpolate_unknown(in, (int32_t)i);
    if (!err)
        err = octree_fill(&own->octree, false, in->width, in->value, &own->data);
    if (!err && cubic)
        err = octree_fill(&own->octree, true, in->width, in->value, &own->cubic);
    return err;
}

static struct error *open_linear(struct interpolate *in, size_t probes)
{
    return open_nodes(in, probes, false);
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

/* Weights of the nodes of a grid. */
static struct error *blend_nodes(const struct interpolate *in, const double p[3],
                                 void (*weigh)(const struct nodes *nodes, int axis, double x,
                                               size_t node[4], double weight[4]),
                                 float *out)
{
    const struct nodes *nodes = &((const struct own *)in->own)->nodes;
    size_t node[3][4];
    double weight[3][4];
    for (int k = 0; k < 3; k++)
        weigh(nodes, k, p[k], node[k], weight[k]);
    for (size_t k = 0; k < in->width; k++)
        out[k] = 0;
    for (int z = 0; z < 4; z++)
        for (int y = 0; y < 4; y++)
            for (int x = 0; x < 4; x++) {
                const float w = (float)(weight[0][x] * weight[1][y] * weight[2][z]);
                if (w == 0) /* what has no weight has no say, not even as a missing value */
                    continue;
                const int32_t probe =
                    nodes->probe[(node[2][z] * nodes->count[1] + node[1][y]) * nodes->count[0] +
                                 node[0][x]];
                const float *f = in->value + (size_t)probe * in->width;
                if (isnan(f[0]))
                    return interpolate_unknown(in, probe);
                for (size_t k = 0; k < in->width; k++)
                    out[k] += w * f[k];
            }
    return NULL;
}

static struct error *linear(const struct interpolate *in, const double point[3], float *out)
{
    const struct own *own = in->own;
    if (!own->data)
        return blend_nodes(in, point, nodes_linear, out);
    octree_at(&own->octree, false, in->width, own->data, point, out);
    return NULL;
}

static struct error *cubic(const struct interpolate *in, const double point[3], float *out)
{
    const struct own *own = in->own;
    if (!own->data)
        return blend_nodes(in, point, nodes_cubic, out);
    octree_at(&own->octree, true, in->width, own->cubic, point, out);
    return NULL;
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
        err = cubic(in, point, more);
    if (err)
        return err;
    for (size_t k = 0; k < in->width; k++)
        more[k] -= out[k];
    bound_shares(&((const struct own *)in->own)->bound, out, more, share);
    for (size_t k = 0; k < in->width; k++)
        out[k] += share[k % 3] * more[k];
    return NULL;
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
