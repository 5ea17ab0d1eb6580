/* SPDX-License-Identifier: Apache-2.0 */
/* Made and checked: the cells (tetrahedra: volume_tetra.c), the hull. */
#include "volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- checking what is given ------------------------------------------------------------------- */

/* Whether `other` has a neighbour `cell` across a facet with the corners of cell's facet opposite
 * `corner`; of bent ones, more than two of which may meet, whether it has these corners at all. */
static bool shares_facet(const struct probe_volume *v, size_t cell, int corner, size_t other)
{
    for (int j = 0; j < v->corners; j++) {
        if (!v->bent && volume_neighbour(v, other, j) != (int32_t)cell)
            continue;
        int shared = 0;
        for (int a = 0; a < v->corners; a++)
            for (int b = 0; b < v->corners; b++)
                shared += a != corner && b != j &&
                          volume_vertex(v, cell, a) == volume_vertex(v, other, b);
        if (shared == v->corners - 1)
            return true;
    }
    return false;
}

/* Whether each of `count` indices as given is below `end`, or -1 where that is legal. */
static bool are_below(const void *index, int bytes, size_t count, size_t end, bool or_none)
{
    const uint32_t none = or_none; /* -1 counts as 0, all others as one more */
    bool below = true;
    for (size_t i = 0; i < count && bytes == 4; i++)
        below &= ((const uint32_t *)index)[i] + none < end + none;
    for (size_t i = 0; i < count && bytes == 2; i++)
        below &= (uint32_t)volume_index(index, 2, i) + none < end + none;
    return below;
}

static enum probe_status check_indices(const struct probe_volume *v, size_t *row)
{
    const size_t corners = (size_t)v->corners * v->cells;
    if (are_below(v->vertex, v->vertex_bytes, corners, v->probes, false) &&
        are_below(v->neighbour, v->neighbour_bytes, corners, v->cells, true))
        return PROBE_OK;
    for (size_t cell = 0; cell < v->cells; cell++) { /* where? */
        *row = cell;
        for (int i = 0; i < v->corners; i++) {
            const int32_t p = volume_vertex(v, cell, i), n = volume_neighbour(v, cell, i);
            if (p < 0 || (size_t)p >= v->probes)
                return PROBE_BAD_VERTEX;
            if (n < -1 || n >= (int32_t)v->cells)
                return PROBE_BAD_NEIGHBOUR;
        }
    }
    return PROBE_OK;
}

/* -- planes and lines ------------------------------------------------------------------------- */

static void normalise(double a[3])
{
    const double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int k = 0; k < 3 && length > 0; k++)
        a[k] /= length;
}

/* A triangle's area as seen along an axis, twice; a segment's extent along it. Signed, exact. */
static lattice_volume along_axis(const struct probe_volume *v, size_t cell, int axis)
{
    const double *s[3];
    int64_t d[2][3];
    for (int i = 0; i < v->corners; i++)
        s[i] = volume_site(v, volume_vertex(v, cell, i));
    for (int i = 0; i + 1 < v->corners; i++)
        for (int k = 0; k < 3; k++)
            d[i][k] = lattice_whole(s[i + 1][k] - s[0][k]);
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    return v->corners == 2 ? d[0][axis]
                           : (lattice_volume)d[0][x] * d[1][y] - (lattice_volume)d[0][y] * d[1][x];
}

/* The axis along which cells are seen side by side: all turn (run) the same way, and if they do
 * along several, where they are seen largest. Probes that were merged into a plane may stand off it
 * by a good part of a cell, so its normal alone does not tell. */
static int facing_axis(const struct probe_volume *v)
{
    int best = 0;
    bool best_alike = false;
    double most = -1;
    for (int axis = 0; axis < 3; axis++) {
        size_t forth = 0, back = 0;
        double total = 0;
        for (size_t cell = 0; cell < v->cells; cell++) {
            const lattice_volume a = along_axis(v, cell, axis);
            forth += a > 0;
            back += a < 0;
            total += fabs((double)a);
        }
        const bool alike = forth == v->cells || back == v->cells;
        if (alike > best_alike || (alike == best_alike && total > most)) {
            best = axis;
            best_alike = alike;
            most = total;
        }
    }
    return best;
}

/* Triangles: the plane's normal is the mean of theirs. Segments: the line runs between the two ends
 * that are farthest apart along its axis. */
static void find_span(struct probe_volume *v)
{
    const int facing = v->corners > 1 ? facing_axis(v) : 0;
    v->axis[0] = v->corners == 3 ? (facing + 1) % 3 : facing;
    v->axis[1] = (v->axis[0] + 1) % 3;
    v->axis[2] = (v->axis[0] + 2) % 3;
    for (size_t cell = 0; cell < v->cells && v->corners == 3; cell++) {
        const bool back = along_axis(v, cell, facing) < 0;
        for (int k = 0; k < 3; k++) {
            const double area = (double)along_axis(v, cell, k);
            v->normal[k] += back ? -area : area;
        }
    }
    if (v->corners == 3)
        memcpy(v->origin, volume_site(v, volume_vertex(v, 0, 0)), sizeof v->origin);
    int32_t ends[2] = {volume_vertex(v, 0, 0), volume_vertex(v, 0, 0)};
    for (size_t i = 0; i < v->cells && v->corners == 2; i++)
        for (int k = 0; k < 2; k++) {
            const int32_t p = volume_vertex(v, i, k);
            if (volume_site(v, p)[v->axis[0]] < volume_site(v, ends[0])[v->axis[0]])
                ends[0] = p;
            if (volume_site(v, p)[v->axis[0]] > volume_site(v, ends[1])[v->axis[0]])
                ends[1] = p;
        }
    for (int k = 0; k < 3 && v->corners <= 2; k++) {
        v->origin[k] = volume_site(v, ends[0])[k];
        v->normal[k] = volume_site(v, ends[1])[k] - v->origin[k];
    }
    normalise(v->normal);
}

/* -- what they span --------------------------------------------------------------------------- */

/* Whether a triangle has no area, a segment no length. */
static bool is_nothing(const struct probe_volume *v, size_t cell)
{
    return !along_axis(v, cell, 0) && !along_axis(v, cell, 1) && !along_axis(v, cell, 2);
}

/* A length as long as cells are wide: the root of twice their mean area, or their mean length. */
static double width_of_cells(const struct probe_volume *v)
{
    double sum = 0;
    for (size_t cell = 0; cell < v->cells; cell++) {
        double square = 0;
        for (int k = 0; k < 3; k++)
            square += (double)along_axis(v, cell, k) * (double)along_axis(v, cell, k);
        sum += sqrt(square);
    }
    sum /= (double)v->cells;
    return v->corners == 3 ? sqrt(sum) : sum;
}

/* Whether cells lie side by side where they fall in the plane or on the line. */
static bool are_alike(const struct probe_volume *v)
{
    const int sides = v->corners;
    size_t forth = 0, back = 0;
    for (size_t cell = 0; cell < v->cells; cell++) {
        const double *s[3];
        for (int i = 0; i < sides; i++)
            s[i] = volume_span_site(v, volume_vertex(v, cell, i));
        int64_t d[2][2];
        for (int i = 0; i + 1 < sides; i++)
            for (int k = 0; k < 2; k++)
                d[i][k] = lattice_whole(s[i + 1][k] - s[0][k]);
        const lattice_volume area = sides == 2 ? d[0][0]
                                               : (lattice_volume)d[0][0] * d[1][1] -
                                                     (lattice_volume)d[0][1] * d[1][0];
        forth += area > 0;
        back += area < 0;
    }
    return forth == v->cells || back == v->cells;
}

static enum probe_status flatten(struct probe_volume *v)
{
    v->flat = malloc(3 * v->probes * sizeof *v->flat);
    if (!v->flat)
        return PROBE_NO_MEMORY;
    for (int k = 0; k < 3; k++) {
        v->flat_low[k] = INFINITY;
        v->flat_high[k] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * v->probes; i++) {
        if (i % 3 == 0)
            span_flatten(&v->frame, v->corners, volume_site(v, (int32_t)(i / 3)), v->flat + i);
        v->flat[i] = rint(v->flat[i]);
        v->flat_low[i % 3] = fmin(v->flat_low[i % 3], v->flat[i]);
        v->flat_high[i % 3] = fmax(v->flat_high[i % 3], v->flat[i]);
    }
    return PROBE_OK;
}

/* Triangles and segments: within rounding of a plane or line, near one, or bent. */
static enum probe_status judge_span(struct probe_volume *v)
{
    enum { ROUNDING = 16 }; /* steps */
    unsigned char *used = calloc(v->probes ? v->probes : 1, 1);
    if (!used)
        return PROBE_NO_MEMORY;
    for (size_t cell = 0; cell < v->cells; cell++)
        for (int i = 0; i < v->corners; i++)
            used[volume_vertex(v, cell, i)] = 1;
    span_find(&v->frame, v->probes, v->site, used, v->corners);
    free(used);
    if (v->frame.off <= ROUNDING)
        return PROBE_OK;
    const bool near = v->frame.off <= width_of_cells(v);
    enum probe_status status = near ? flatten(v) : PROBE_OK;
    if (status || (near && are_alike(v))) {
        for (int k = 0; k < 3; k++)
            v->axis[k] = k;
        return status;
    }
    free(v->flat);
    v->flat = NULL;
    v->bent = true;
    return status;
}

static enum probe_status check_cells(const struct probe_volume *v, size_t *row)
{
    for (size_t cell = 0; cell < v->cells; cell++) {
        *row = cell;
        lattice_volume volume[4];
        /* that of corner 0 is the whole cell's */
        volume_measure(v, cell, volume_span_site(v, volume_vertex(v, cell, 0)), volume);
        if (v->bent ? is_nothing(v, cell) : volume[0] <= 0)
            return PROBE_BAD_SHAPE;
        for (int i = 0; i < v->corners; i++) {
            const int32_t n = volume_neighbour(v, cell, i);
            if (n >= 0 && ((size_t)n == cell || !shares_facet(v, cell, i, (size_t)n)))
                return PROBE_BAD_NEIGHBOUR;
        }
    }
    return PROBE_OK;
}

/* -- the tree of cells ---------------------------------------------------------------------- */

static enum probe_status make_tetrahedra(struct probe_volume *v, size_t *row)
{
    bool sure = true;
    const enum probe_status status = volume_tetra_make(v, &sure);
    if (status || sure)
        return status;
    struct probe_volume as_given = *v;
    as_given.cell = NULL;
    return check_cells(&as_given, row);
}

static enum probe_status make_cell_tree(struct probe_volume *v)
{
    const enum probe_status status = volume_tree_init(&v->cell_tree, v->cells);
    for (size_t i = 0; !status && i < v->cells; i++)
        for (int k = 0; k < v->corners; k++) {
            const double *s = volume_span_site(v, volume_vertex(v, i, k));
            double p[3] = {s[0], s[1], s[2]};
            for (int j = v->corners - 1; j < 3; j++)
                p[v->axis[j]] = 0;
            volume_tree_add(&v->cell_tree, i, p);
        }
    if (!status)
        volume_tree_finish(&v->cell_tree);
    return status;
}

/* -- the hull --------------------------------------------------------------------------------- */

/* Adds the facets of a cell to those there are. */
static void add_facets(struct probe_volume *v, size_t cell)
{
    for (int k = 0; k < v->corners; k++)
        if (volume_neighbour(v, cell, k) < 0)
            v->facet[v->facets++] =
                (struct volume_facet){.cell = (int32_t)cell, .corner = k, .across = {-1, -1, -1}};
}

static enum probe_status make_facets(struct probe_volume *v, size_t *row)
{
    for (size_t i = 0; i < v->cells && v->corners < 4 && !v->bent; i++)
        for (int k = 0; k < v->corners; k++)
            v->facets += volume_neighbour(v, i, k) < 0;
    if (v->bent)
        v->facets = v->cells;
    if (!v->facets) { /* cells without an end: there is no such mesh in flat space */
        *row = 0;
        return PROBE_BAD_NEIGHBOUR;
    }
    if (v->facets > INT32_MAX)
        return PROBE_BAD_ARGUMENT;
    v->facet = malloc(v->facets * sizeof *v->facet);
    enum probe_status status = v->facet ? volume_tree_init(&v->facet_tree, v->facets)
                                        : PROBE_NO_MEMORY;
    if (status)
        return status;
    v->facets = 0;
    for (size_t i = 0; i < v->cells && v->bent; i++)
        v->facet[v->facets++] =
            (struct volume_facet){.cell = (int32_t)i, .corner = -1, .across = {-1, -1, -1}};
    for (size_t i = 0; i < v->cells && !v->bent; i++) /* in Morton order: so are these */
        if (v->corners < 4 || v->on_hull[i / VOLUME_LEAF])
            add_facets(v, i);
    for (size_t i = 0; i < v->facets; i++) {
        int32_t vertex[3];
        volume_facet_vertex(v, &v->facet[i], vertex);
        for (int k = 0; k < 3; k++)
            volume_tree_add(&v->facet_tree, i, volume_span_site(v, vertex[k]));
    }
    volume_tree_finish(&v->facet_tree);
    return PROBE_OK;
}

struct edge {
    int32_t low, high; /* its probes */
    int32_t facet, corner;
};

static int compare_edges(const void *a, const void *b)
{
    const struct edge *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return x->facet < y->facet ? -1 : x->facet > y->facet;
}

/* Which facets share edges; the hull is closed where two do, and convex where none sees the far
 * corner of another. */
static enum probe_status join_facets(struct probe_volume *v)
{
    const size_t n = 3 * v->facets;
    struct edge *edge = malloc(n * sizeof *edge);
    if (!edge)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < n; i++) {
        int32_t p[3];
        volume_facet_vertex(v, &v->facet[i / 3], p);
        const int32_t a = p[(i + 1) % 3], b = p[(i + 2) % 3];
        edge[i] = (struct edge){a < b ? a : b, a < b ? b : a, (int32_t)(i / 3), (int32_t)(i % 3)};
    }
    qsort(edge, n, sizeof *edge, compare_edges);
    v->convex = v->closed = true;
    for (size_t i = 0; i < n;) {
        size_t same = 1;
        while (i + same < n && edge[i + same].low == edge[i].low &&
               edge[i + same].high == edge[i].high)
            same++;
        if (same == 2) {
            int32_t p[3], q[3];
            v->facet[edge[i].facet].across[edge[i].corner] = edge[i + 1].facet;
            v->facet[edge[i + 1].facet].across[edge[i + 1].corner] = edge[i].facet;
            volume_facet_vertex(v, &v->facet[edge[i].facet], p);
            volume_facet_vertex(v, &v->facet[edge[i + 1].facet], q);
            v->convex = v->convex && lattice_orient(volume_site(v, p[0]), volume_site(v, p[2]),
                                                    volume_site(v, p[1]),
                                                    volume_site(v, q[edge[i + 1].corner])) >= 0;
        } else {
            v->convex = v->closed = false;
        }
        i += same;
    }
    free(edge);
    return PROBE_OK;
}

/* -- making ----------------------------------------------------------------------------------- */

static enum probe_status make_sites(struct probe_volume *v, const double *position, size_t *row)
{
    for (size_t i = 0; i < 3 * v->probes; i++)
        if (!isfinite(position[i])) {
            *row = i / 3;
            return PROBE_BAD_POSITION;
        }
    v->lattice = lattice_fit(v->probes, position);
    v->site = v->site_owned = malloc((3 * v->probes + 1) * sizeof *v->site_owned);
    if (!v->site_owned)
        return PROBE_NO_MEMORY;
    v->bytes += (3 * v->probes + 1) * sizeof *v->site_owned;
    for (size_t i = 0; i < v->probes; i++)
        lattice_snap(&v->lattice, position + 3 * i, v->site_owned + 3 * i);
    return PROBE_OK;
}

static size_t tree_bytes(const struct volume_tree *tree)
{
    return volume_block_bytes(tree->level[tree->levels] * sizeof *tree->box);
}

static enum probe_status make_rest(struct probe_volume *v, size_t *row)
{
    if (v->corners < 1 || v->corners > 4 || v->probes > INT32_MAX || v->cells > INT32_MAX)
        return PROBE_BAD_ARGUMENT;
    if (!v->cells)
        return PROBE_NO_CELLS;
    v->steps_most = 64 + (int)(8 * cbrt((double)v->cells));
    v->scale = 1 / v->lattice.step;
    v->scale = v->lattice.step > 0x1p-1000 && v->lattice.step < 0x1p1000 ? v->scale : 0;
    v->near = v->scale > 0;
    for (int k = 0; k < 3; k++) {
        v->low[k] = INFINITY;
        v->high[k] = -INFINITY;
    }
    for (size_t i = 0; i < v->probes; i++)
        for (size_t k = 0; k < 3; k++) {
            const double x = v->site[3 * i + k];
            v->low[k] = x < v->low[k] ? x : v->low[k];
            v->high[k] = x > v->high[k] ? x : v->high[k];
        }
    for (int k = 0; k < 3; k++) {
        v->shift[k] = v->lattice.step > 0 ? v->lattice.origin[k] / v->lattice.step : 0;
        v->near = v->near &&
                  fmax(fabs(v->low[k] + v->shift[k]), fabs(v->high[k] + v->shift[k])) < 0x1p50;
        v->middle[k] = (v->low[k] + v->high[k]) / 2;
        v->half[k] = (v->high[k] - v->low[k]) / 2;
    }
    enum probe_status status = check_indices(v, row);
    if (!status && v->corners < 4)
        find_span(v);
    if (!status && (v->corners == 3 || v->corners == 2))
        status = judge_span(v);
    if (!status && v->corners == 4)
        status = make_tetrahedra(v, row);
    else if (!status)
        status = check_cells(v, row);
    if (!status && v->corners < 4 && !v->bent)
        status = make_cell_tree(v);
    if (!status)
        status = make_facets(v, row);
    free(v->on_hull);
    v->on_hull = NULL;
    if (!status && v->corners == 4)
        status = join_facets(v);
    if (!status && v->corners == 4 && !(v->flags & PROBE_NEAREST) &&
        (!v->convex || v->flags & PROBE_EXTEND))
        status = volume_outer_init(v);
    if (!status && v->corners == 4)
        status = volume_tetra_end(v);
    v->bytes += v->flat ? 3 * v->probes * sizeof *v->flat : 0;
    v->bytes += sizeof *v + tree_bytes(&v->cell_tree) + tree_bytes(&v->facet_tree) +
                tree_bytes(&v->image_tree) + v->facets * sizeof *v->facet;
    return status;
}

enum probe_status volume_finish(struct probe_volume *v, enum probe_status status, size_t *row,
                                struct probe_volume **volume)
{
    if (!status)
        status = make_rest(v, row);
    if (status)
        probe_volume_destroy(v);
    else
        *volume = v;
    return status;
}

enum probe_status probe_volume_create(struct probe_volume **volume, const struct probe_mesh *mesh,
                                      unsigned flags, size_t *row)
{
    size_t nowhere;
    struct probe_volume *v = calloc(1, sizeof *v);
    *volume = NULL;
    if (!v)
        return PROBE_NO_MEMORY;
    *v = (struct probe_volume){.flags = flags,
                               .corners = mesh->corners,
                               .probes = mesh->probes,
                               .cells = mesh->cells,
                               .vertex = mesh->vertex,
                               .neighbour = mesh->neighbour,
                               .vertex_bytes = 4,
                               .neighbour_bytes = 4};
    row = row ? row : &nowhere;
    *row = 0;
    enum probe_status status = v->probes > INT32_MAX ? PROBE_BAD_ARGUMENT
                                                     : make_sites(v, mesh->position, row);
    return volume_finish(v, status, row, volume);
}

void probe_volume_destroy(struct probe_volume *v)
{
    if (!v)
        return;
    free(v->site_owned);
    free(v->sight_owned);
    free(v->beyond_owned);
    free(v->flat);
    free(v->cell_owned);
    free(v->number);
    free(v->inner);
    free(v->start);
    volume_tree_clear(&v->cell_tree);
    free(v->facet);
    volume_tree_clear(&v->facet_tree);
    volume_tree_clear(&v->image_tree);
    free(v);
}
