/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/octree.h"
#include "base/array.h"
#include "base/error.h"
#include "interpolate/nodes.h"
#include "math/places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- the lattice ----------------------------------------------------------------------------------
 * The least gap between planes of probes along an axis is a unit. All gaps are cells, so powers of
 * two of it. */

static const char axis_name[] = "xyz";

/* Numbers the planes along an axis by their place on the lattice: unit[plane]. */
static struct error *number_planes(struct octree *t, const struct nodes *planes, int axis,
                                   int32_t *unit)
{
    const double *at = planes->at[axis];
    const size_t n = planes->count[axis];
    const double extent = at[n - 1] - at[0];
    double least = INFINITY, sum = 0;
    for (size_t i = 1; i < n; i++)
        least = fmin(least, at[i] - at[i - 1]);
    unit[0] = 0;
    for (size_t i = 1; i < n; i++) {
        double parts = 1;
        for (double gap = (at[i] - at[i - 1]) / least; gap > 1.4142135; gap /= 2)
            parts *= 2;
        sum += parts;
        if (sum > PLACES_MOST)
            return error_new("spacings along %c differ too much: %g of %g", axis_name[axis], least,
                             extent);
        unit[i] = (int32_t)sum;
    }
    const double off = fmin(2e-6 * extent, least / 4);
    for (size_t i = 1; i < n; i++)
        if (fabs(at[i] - (at[0] + unit[i] / sum * extent)) > off)
            return error_new("%c = %.9g is not where halving cells comes to", axis_name[axis],
                             at[i]);
    t->low[axis] = at[0];
    t->high[axis] = at[n - 1];
    t->units[axis] = unit[n - 1];
    return NULL;
}

static double place_of(const struct octree *t, int axis, int32_t unit)
{
    return t->units[axis]
               ? t->low[axis] + (double)unit / t->units[axis] * (t->high[axis] - t->low[axis])
               : t->low[axis];
}

/* The largest cells that make up the box: if any make an octree of the probes, these do. */
static void find_roots(struct octree *t)
{
    t->root = 1 << 20;
    for (int k = 0; k < 3; k++)
        while (t->units[k] % t->root)
            t->root /= 2;
    for (int k = 0; k < 3; k++)
        t->roots[k] = t->units[k] ? (size_t)(t->units[k] / t->root) : 1;
}

static struct error *find_sites(struct octree *t, const double *position)
{
    struct nodes planes;
    int32_t *unit = NULL;
    struct error *err = nodes_planes(&planes, t->probes, position);
    if (!err)
        err = array_create(&t->site, t->probes, sizeof *t->site);
    if (!err)
        err = array_create(&unit, t->probes, sizeof *unit);
    for (int k = 0; k < 3 && !err; k++) {
        err = number_planes(t, &planes, k, unit);
        for (size_t i = 0; i < t->probes && !err; i++)
            t->site[i][k] = unit[nodes_plane(&planes, k, position[3 * i + (size_t)k])];
    }
    free(unit);
    nodes_clear(&planes);
    return err;
}

/* -- cells ------------------------------------------------------------------------------------ */

struct cell {
    int32_t x[3], size; /* units; size 0: not there, in a flat box */
    int32_t corner[8];
    bool thought; /* cut out of a leaf */
};

/* What is made, breadth first: a list of cells, of which the first `done` have been looked at. */
struct build {
    struct octree *tree;
    struct places map;
    struct cell *cell;
    size_t cells, leaves;
    size_t cell_room, child_room, corner_room, made_room;
    bool *used; /* probes that are corners */
};

/* Nodes of a cell are numbered 0 .. 26 by their place, 0, 1 or 2 along each axis, x fastest. */
enum { MIDDLE = 13 };

static int along(int node, int axis)
{
    return axis == 0 ? node % 3 : axis == 1 ? node / 3 % 3 : node / 9;
}

static int beside(int node, int axis, int by)
{
    return node + by * (axis == 0 ? 1 : axis == 1 ? 3 : 9);
}

static int corner_node(int corner)
{
    return 2 * (corner & 1) + 6 * (corner >> 1 & 1) + 18 * (corner >> 2);
}

/* Along how many axes a node is in the middle: 0 of a corner, 1 of an edge, 2 of a face. */
static int middles(int node)
{
    return (along(node, 0) == 1) + (along(node, 1) == 1) + (along(node, 2) == 1);
}

static bool is_flat(const struct octree *t, int axis)
{
    return !t->units[axis];
}

static bool is_probe(const struct build *b, int32_t node)
{
    return node >= 0 && (size_t)node < b->tree->probes;
}

static void node_place(const struct octree *t, const struct cell *c, int node, int32_t x[3])
{
    for (int k = 0; k < 3; k++)
        x[k] = c->x[k] + (is_flat(t, k) ? 0 : along(node, k) * c->size / 2);
}

static struct error *no_probe(const struct octree *t, const int32_t x[3], const char *of,
                              const struct cell *c)
{
    double place[3], low[3], high[3];
    for (int k = 0; k < 3; k++) {
        place[k] = place_of(t, k, x[k]);
        low[k] = place_of(t, k, c->x[k]);
        high[k] = place_of(t, k, c->x[k] + (is_flat(t, k) ? 0 : c->size));
    }
    return error_new(
        "there is no probe at %.9g %.9g %.9g, %s from %.9g %.9g %.9g to %.9g %.9g %.9g", place[0],
        place[1], place[2], of, low[0], low[1], low[2], high[0], high[1], high[2]);
}

static struct error *add_cell(struct build *b, const struct cell *c)
{
    struct octree *t = b->tree;
    if (b->cells >= INT32_MAX - 8)
        return error_new("there are more than %d cells", INT32_MAX - 8);
    struct error *err = array_reserve(&b->cell, &b->cell_room, b->cells + 1, sizeof *b->cell);
    if (!err)
        err = array_reserve(&t->child, &b->child_room, b->cells + 1, sizeof *t->child);
    if (!err) {
        t->child[b->cells] = 0;
        b->cell[b->cells++] = *c;
    }
    return err;
}

static struct error *add_roots(struct build *b)
{
    struct octree *t = b->tree;
    const double needed = ((double)t->roots[0] + !is_flat(t, 0)) *
                          ((double)t->roots[1] + !is_flat(t, 1)) *
                          ((double)t->roots[2] + !is_flat(t, 2));
    if (needed > (double)t->probes)
        return error_new("%zu probes are fewer than the corners of %zu x %zu x %zu cells, the "
                         "largest that make up their box",
                         t->probes, t->roots[0], t->roots[1], t->roots[2]);
    struct error *err = NULL;
    const size_t cells = t->roots[0] * t->roots[1] * t->roots[2];
    for (size_t i = 0; i < cells && !err; i++) {
        const size_t at[3] = {i % t->roots[0], i / t->roots[0] % t->roots[1],
                              i / t->roots[0] / t->roots[1]};
        struct cell c = {.size = t->root};
        for (int k = 0; k < 3; k++)
            c.x[k] = (int32_t)at[k] * t->root;
        for (int j = 0; j < 8 && !err; j++) {
            int32_t x[3];
            node_place(t, &c, corner_node(j), x);
            c.corner[j] = places_find(&b->map, x);
            if (c.corner[j] < 0)
                err = no_probe(t, x, "a corner of the cell", &c);
            else
                b->used[c.corner[j]] = true;
        }
        if (!err)
            err = add_cell(b, &c);
    }
    return err;
}

/* A node that is no probe, between nodes of its cell: along each axis in whose middle it is. */
static struct error *make_node(struct build *b, const struct cell *c, const int32_t x[3], int node,
                               int32_t nodes[27])
{
    struct octree *t = b->tree;
    struct octree_made made = {.apart = c->size};
    if (t->nodes >= INT32_MAX)
        return error_new("there are more than %d nodes", INT32_MAX);
    for (int k = 0; k < 3; k++)
        for (int side = 0; side < 2; side++)
            made.pair[k][side] =
                along(node, k) == 1 && !is_flat(t, k) ? nodes[beside(node, k, 2 * side - 1)] : -1;
    struct error *err =
        array_reserve(&t->made, &b->made_room, t->nodes - t->probes + 1, sizeof *t->made);
    if (!err)
        err = places_add(&b->map, x, (int32_t)t->nodes);
    if (!err) {
        t->made[t->nodes - t->probes] = made;
        nodes[node] = (int32_t)t->nodes++;
    }
    return err;
}

/* Finds the nodes of a cell that is cut; a real one's are probes, one's that is cut in thought are
 * made where there is none. */
static struct error *find_nodes(struct build *b, const struct cell *c, bool thought,
                                int32_t nodes[27])
{
    struct error *err = NULL;
    for (int order = 0; order <= 3; order++)
        for (int node = 0; node < 27 && !err; node++) {
            int32_t x[3];
            if (middles(node) != order)
                continue;
            node_place(b->tree, c, node, x);
            nodes[node] = places_find(&b->map, x);
            if (thought && nodes[node] < 0)
                err = make_node(b, c, x, node, nodes);
            else if (!thought && !is_probe(b, nodes[node]))
                err = no_probe(b->tree, x, "a node of the cell (with a probe in its middle)", c);
            else if (!thought)
                b->used[nodes[node]] = true;
        }
    return err;
}

static struct error *cut(struct build *b, size_t i, bool thought)
{
    const struct cell whole = b->cell[i];
    int32_t nodes[27];
    struct error *err = find_nodes(b, &whole, thought, nodes);
    if (err)
        return err;
    b->tree->child[i] = (int32_t)b->cells;
    for (int part = 0; part < 8 && !err; part++) {
        struct cell c = {.size = whole.size / 2, .thought = thought};
        int first = 0;
        for (int k = 0; k < 3; k++) {
            const int upper = part >> k & 1;
            if (upper && is_flat(b->tree, k))
                c.size = 0;
            c.x[k] = whole.x[k] + upper * (whole.size / 2);
            first = beside(first, k, upper);
        }
        for (int j = 0; j < 8; j++)
            c.corner[j] = nodes[first + corner_node(j) / 2];
        err = add_cell(b, &c);
    }
    return err;
}

/* Whether a probe is in the middle of an edge or face of a cell: then one of them hangs there. */
static bool has_hanging(const struct build *b, const struct cell *c)
{
    for (int node = 0; node < 27; node++) {
        bool flat = node == MIDDLE || middles(node) == 0;
        int32_t x[3];
        for (int k = 0; k < 3; k++)
            flat = flat || (along(node, k) == 1 && is_flat(b->tree, k));
        if (flat)
            continue;
        node_place(b->tree, c, node, x);
        if (is_probe(b, places_find(&b->map, x)))
            return true;
    }
    return false;
}

/* Whether a probe is in the middle of a cell: then it is cut. */
static bool is_cut(const struct build *b, const struct cell *c)
{
    int32_t x[3];
    node_place(b->tree, c, MIDDLE, x);
    return is_probe(b, places_find(&b->map, x));
}

static struct error *add_leaf(struct build *b, size_t i)
{
    struct octree *t = b->tree;
    const struct cell *c = &b->cell[i];
    struct error *err =
        array_reserve(&t->corner, &b->corner_room, b->leaves + 1, sizeof *t->corner);
    if (err)
        return err;
    for (int j = 0; j < 8; j++)
        t->corner[b->leaves][j] = c->corner[j];
    t->child[i] = ~(int32_t)b->leaves++;
    return NULL;
}

static struct error *cut_cells(struct build *b)
{
    struct octree *t = b->tree;
    struct error *err = NULL;
    for (size_t i = 0; i < b->cells && !err; i++) {
        const struct cell c = b->cell[i];
        const bool real = c.size > 1 && !c.thought && is_cut(b, &c);
        for (int j = 0; j < 8 && c.size && !c.thought && !real; j++)
            if (c.size > t->spacing[c.corner[j]])
                t->spacing[c.corner[j]] = c.size;
        if (real || (c.size > 1 && has_hanging(b, &c)))
            err = cut(b, i, !real);
        else if (c.size)
            err = add_leaf(b, i);
    }
    return err;
}

/* All probes are corners. */
static struct error *check_used(const struct build *b)
{
    const struct octree *t = b->tree;
    for (size_t i = 0; i < t->probes; i++)
        if (!b->used[i])
            return error_new("probe %zu at %.9g %.9g %.9g is no corner of a cell: there is no "
                             "probe in the middle of the cell that it would cut",
                             i, place_of(t, 0, t->site[i][0]), place_of(t, 1, t->site[i][1]),
                             place_of(t, 2, t->site[i][2]));
    return NULL;
}

static struct error *build(struct octree *t)
{
    struct build b = {.tree = t};
    struct error *err = array_create(&b.used, t->probes, sizeof *b.used);
    if (!err)
        err = array_create(&t->spacing, t->probes, sizeof *t->spacing);
    for (size_t i = 0; i < t->probes && !err; i++) {
        const int32_t there = places_find(&b.map, t->site[i]);
        err = there >= 0 ? error_new("probes %d and %zu are at one node", there, i)
                         : places_add(&b.map, t->site[i], (int32_t)i);
    }
    if (!err)
        err = add_roots(&b);
    if (!err)
        err = cut_cells(&b);
    if (!err)
        err = check_used(&b);
    places_clear(&b.map);
    free(b.cell);
    free(b.used);
    return err;
}

struct error *octree_find(struct octree *t, size_t probes, const double *position)
{
    *t = (struct octree){.probes = probes, .nodes = probes};
    if (!probes || probes >= INT32_MAX)
        return error_new("there are %s probes", probes ? "too many" : "no");
    struct error *err = find_sites(t, position);
    if (!err) {
        find_roots(t);
        err = build(t);
    }
    if (err) {
        octree_clear(t);
        return error_wrap(err, "the probes are not the corners of an octree's cells");
    }
    return NULL;
}

void octree_clear(struct octree *t)
{
    free(t->child);
    free(t->corner);
    free(t->made);
    free(t->site);
    free(t->spacing);
    *t = (struct octree){0};
}

/* -- values ----------------------------------------------------------------------------------- */

/* The leaf around x (units, within the box): its corners, its size, and x in it, 0 .. 1. */
static const int32_t *leaf_at(const struct octree *t, const double x[3], double in[3], double *size)
{
    size_t cell = 0;
    double from[3], s = t->root;
    for (int k = 2; k >= 0; k--) {
        const size_t root = (size_t)(x[k] / s), last = t->roots[k] - 1;
        from[k] = s * (double)(root < last ? root : last);
        cell = cell * t->roots[k] + (root < last ? root : last);
    }
    while (t->child[cell] >= 0) {
        cell = (size_t)t->child[cell];
        s /= 2;
        for (int k = 0; k < 3; k++)
            if (x[k] >= from[k] + s) {
                from[k] += s;
                cell += (size_t)1 << k;
            }
    }
    for (int k = 0; k < 3; k++)
        in[k] = (x[k] - from[k]) / s;
    *size = s;
    return t->corner[~t->child[cell]];
}

typedef float four __attribute__((vector_size(16)));

/* Rows of data, at most 8 of each corner, and their weights. */
struct blend {
    const float *row[64];
    float weight[64];
    int count;
};

static void blend_add(struct blend *b, const float *row, double weight)
{
    if (weight == 0)
        return;
    b->row[b->count] = row;
    b->weight[b->count++] = (float)weight;
}

static void blend_sum(const struct blend *b, size_t width, float *out)
{
    for (size_t v = 0; v < width && width < 4; v++) {
        out[v] = 0;
        for (int i = 0; i < b->count; i++)
            out[v] += b->weight[i] * b->row[i][v];
    }
    for (size_t next = 0; next < width && width >= 4; next += 4) {
        const size_t v = next + 4 <= width ? next : width - 4; /* the last four once more */
        four sum = {0};
        for (int i = 0; i < b->count; i++) {
            four value;
            memcpy(&value, b->row[i] + v, sizeof value);
            sum += b->weight[i] * value;
        }
        memcpy(out + v, &sum, sizeof sum);
    }
}

static void blend_linear(const struct octree *t, size_t width, const float *data, const double x[3],
                         float *out)
{
    struct blend b = {.count = 0};
    double in[3], size;
    const int32_t *corner = leaf_at(t, x, in, &size);
    for (int j = 0; j < 8; j++)
        blend_add(&b, data + (size_t)corner[j] * width,
                  (j & 1 ? in[0] : 1 - in[0]) * (j & 2 ? in[1] : 1 - in[1]) *
                      (j & 4 ? in[2] : 1 - in[2]));
    blend_sum(&b, width, out);
}

/* Hermite's weights of the value and the slope, at either end of an interval. */
static void hermite(double x, double size, double weight[2][2])
{
    const double y = 1 - x;
    weight[0][0] = (1 + 2 * x) * y * y;
    weight[0][1] = size * x * y * y;
    weight[1][0] = x * x * (1 + 2 * y);
    weight[1][1] = -size * x * x * y;
}

static void blend_cubic(const struct octree *t, size_t width, const float *data, const double x[3],
                        float *out)
{
    struct blend b = {.count = 0};
    double in[3], size, weight[3][2][2];
    const int32_t *corner = leaf_at(t, x, in, &size);
    for (int k = 0; k < 3; k++)
        hermite(in[k], size, weight[k]);
    for (int j = 0; j < 8; j++)
        for (int d = 0; d < 8; d++)
            blend_add(&b, data + (8 * (size_t)corner[j] + (size_t)d) * width,
                      weight[0][j & 1][d & 1] * weight[1][j >> 1 & 1][d >> 1 & 1] *
                          weight[2][j >> 2][d >> 2]);
    blend_sum(&b, width, out);
}

/* p in units, in the box. */
static void to_units(const struct octree *t, const double p[3], double x[3])
{
    for (int k = 0; k < 3; k++)
        x[k] = is_flat(t, k) || p[k] <= t->low[k] ? 0
               : p[k] >= t->high[k]               ? t->units[k]
                                    : (p[k] - t->low[k]) / (t->high[k] - t->low[k]) * t->units[k];
}

void octree_at_inverse(const struct octree *t, size_t width, const float *data, const double p[3],
                       float *out)
{
    struct blend b = {.count = 0};
    double x[3], in[3], size, side[3], weight[8];
    to_units(t, p, x);
    const int32_t *corner = leaf_at(t, x, in, &size);
    for (int k = 0; k < 3; k++)
        side[k] = is_flat(t, k) ? 0 : size * (t->high[k] - t->low[k]) / t->units[k];
    nodes_inverse(in, side, weight);
    for (int j = 0; j < 8; j++)
        blend_add(&b, data + (size_t)corner[j] * width, weight[j]);
    blend_sum(&b, width, out);
}

void octree_at(const struct octree *t, bool cubic, size_t width, const float *data,
               const double p[3], float *out)
{
    double x[3];
    to_units(t, p, x);
    (cubic ? blend_cubic : blend_linear)(t, width, data, x, out);
}

/* -- data at nodes ---------------------------------------------------------------------------- */

static void mean_of_pairs(const struct octree *t, size_t width, float *data)
{
    for (size_t i = t->probes; i < t->nodes; i++) {
        const struct octree_made *m = &t->made[i - t->probes];
        double count = 0;
        for (int k = 0; k < 3; k++)
            count += m->pair[k][0] >= 0 ? 2 : 0;
        for (size_t v = 0; v < width; v++) {
            double sum = 0;
            for (int k = 0; k < 3; k++)
                if (m->pair[k][0] >= 0)
                    sum += (double)data[(size_t)m->pair[k][0] * width + v] +
                           (double)data[(size_t)m->pair[k][1] * width + v];
            data[i * width + v] = (float)(sum / count);
        }
    }
}

/* Three places along an axis, from the probe, and their weights in its value and its slope. */
static void differences(const struct octree *t, size_t probe, int axis, double offset[3],
                        double weight[2][3])
{
    const int32_t x = t->site[probe][axis], units = t->units[axis], h = t->spacing[probe];
    static const double places[5][3] = {{0, 0, 0}, {0, 1, 2}, {-2, -1, 0}, {0, 1, 1}, {-1, -1, 0}},
                        slopes[5][3] = {{-0.5, 0, 0.5},
                                        {-1.5, 2, -0.5},
                                        {0.5, -2, 1.5},
                                        {-1, 1, 0},
                                        {0, -1, 1}};
    const int at_end = x == 0       ? 1
                       : x == units ? 2
                                    : 0,
              kind = at_end && units == h ? at_end + 2 : at_end;
    for (int i = 0; i < 3; i++) {
        offset[i] = at_end ? places[kind][i] * h : (i - 1) * (double)h;
        weight[0][i] = kind == 0 ? i == 1 : kind == 1 || kind == 3 ? i == 0 : i == 2;
        weight[1][i] = slopes[kind][i] / h;
        if (!units) {
            offset[i] = 0;
            weight[1][i] = 0;
        }
    }
}

/* The 8 data of a probe, by differences of the linear function. sum, here: room for 8 * width and
 * width. */
static void derive(const struct octree *t, size_t probe, size_t width, const float *linear,
                   double *sum, float *here, float *data)
{
    double offset[3][3], weight[3][2][3];
    for (int k = 0; k < 3; k++)
        differences(t, probe, k, offset[k], weight[k]);
    for (size_t v = 0; v < 8 * width; v++)
        sum[v] = 0;
    for (int i = 0; i < 27; i++) {
        const int at[3] = {along(i, 0), along(i, 1), along(i, 2)};
        double w[8], x[3];
        bool any = false;
        for (int d = 0; d < 8; d++) {
            w[d] = weight[0][d & 1][at[0]] * weight[1][d >> 1 & 1][at[1]] *
                   weight[2][d >> 2][at[2]];
            any = any || w[d] != 0;
        }
        if (!any)
            continue;
        for (int k = 0; k < 3; k++)
            x[k] = t->site[probe][k] + offset[k][at[k]];
        blend_linear(t, width, linear, x, here);
        for (size_t d = 0; d < 8; d++)
            for (size_t v = 0; v < width && w[d] != 0; v++)
                sum[d * width + v] += w[d] * (double)here[v];
    }
    for (size_t v = 0; v < 8 * width; v++)
        data[v] = (float)sum[v];
}

/* The 8 data in the middle of the cubic between two nodes along an axis, added to sum. */
static void add_middle(int axis, double apart, size_t width, const float *a, const float *b,
                       double *sum)
{
    const size_t slope = (size_t)1 << axis;
    for (size_t d = 0; d < 8; d++) {
        if (d & slope)
            continue;
        for (size_t v = d * width; v < (d + 1) * width; v++) {
            const size_t s = v + slope * width;
            sum[v] += ((double)a[v] + (double)b[v]) / 2 + apart / 8 * ((double)a[s] - (double)b[s]);
            sum[s] += 1.5 / apart * ((double)b[v] - (double)a[v]) -
                      ((double)a[s] + (double)b[s]) / 4;
        }
    }
}

static void derive_made(const struct octree *t, size_t width, double *sum, float *data)
{
    for (size_t i = t->probes; i < t->nodes; i++) {
        const struct octree_made *m = &t->made[i - t->probes];
        double count = 0;
        for (size_t v = 0; v < 8 * width; v++)
            sum[v] = 0;
        for (int k = 0; k < 3; k++)
            if (m->pair[k][0] >= 0) {
                add_middle(k, m->apart, width, data + 8 * width * (size_t)m->pair[k][0],
                           data + 8 * width * (size_t)m->pair[k][1], sum);
                count++;
            }
        for (size_t v = 0; v < 8 * width; v++)
            data[8 * width * i + v] = (float)(sum[v] / count);
    }
}

struct error *octree_fill(const struct octree *t, bool cubic, size_t width, const float *value,
                          float **data)
{
    float *linear = NULL, *here = NULL;
    double *sum = NULL;
    *data = NULL;
    struct error *err = array_create(&linear, t->nodes * width, sizeof *linear);
    if (err)
        return err;
    for (size_t i = 0; i < t->probes * width; i++)
        linear[i] = value[i];
    mean_of_pairs(t, width, linear);
    if (!cubic) {
        *data = linear;
        return NULL;
    }
    err = array_create(data, t->nodes * width, 8 * sizeof **data);
    if (!err)
        err = array_create(&here, width, sizeof *here);
    if (!err)
        err = array_create(&sum, width, 8 * sizeof *sum);
    for (size_t i = 0; i < t->probes && !err; i++)
        derive(t, i, width, linear, sum, here, *data + 8 * width * i);
    if (!err)
        derive_made(t, width, sum, *data);
    free(linear);
    free(here);
    free(sum);
    if (err) {
        free(*data);
        *data = NULL;
    }
    return err;
}
