/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "libprobe-query/lattice.h"
#include "libprobe-query/span.h"
#include "math/cell.h"
#include "math/vec.h"
#include "tetra/sites.h"
#include "tetra/stretch.h"
#include "tetra/tetra.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A dent is shallow if the flat cell that would fill it has an altitude of at most this share of
 * its longest edge: twice what is peeled. */
static const double shallow = 0x1p-2;

/* No set of cells without overlaps holds more: six times the lattice's box. */
static const lattice_volume volume_most = (lattice_volume)6 << (3 * LATTICE_BITS);

/* What is known of a chunk of cells. */
struct chunk {
    lattice_volume volume;
    /* neighbours of smaller and of larger numbers than the cell's: as many in all, where each looks
     * back */
    size_t below, above;
};

struct check {
    const struct tetra *tetra;
    size_t count; /* sites */
    const double *site;
    const int *axis;
    /* triangles may all turn the other way, segments go against their axis */
    int sign;
    double metric[2][2]; /* of triangles: sites_metric */
    struct chunk *chunk;
    struct tetra_verdict *verdict;
};

enum { CHUNK = 16384 };

static const double *site_of(const struct check *c, int32_t v)
{
    return c->site + 3 * (size_t)v;
}

/* The corners of a cell opposite its corner i, as they turn outward. */
static int facet_corners(int corners, int i, int facet[3])
{
    for (int k = 0; k < corners - 1; k++)
        facet[k] = corners == 4 ? cell_face[i][k] : (i + 1 + k) % corners;
    return corners - 1;
}

/* Three numbers, whatever their order: their least, their largest and their sum tell them all. */
struct three {
    int32_t least, most;
    int64_t sum;
};

static inline int32_t least_of(int32_t a, int32_t b)
{
    return a < b ? a : b;
}
static inline int32_t most_of(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* The corners of a tetrahedron but one. */
static inline struct three others(const int32_t *v, int but)
{
    const int32_t a = v[(but + 1) & 3], b = v[(but + 2) & 3], c = v[(but + 3) & 3];
    return (struct three){least_of(a, least_of(b, c)), most_of(a, most_of(b, c)),
                          (int64_t)a + b + c};
}

static inline bool are_same(struct three a, struct three b)
{
    return (a.least == b.least) & (a.most == b.most) & (a.sum == b.sum);
}

static inline int facet_back_4(const int32_t *vertex, const int32_t *neighbour, size_t other,
                               size_t cell, int i)
{
    const int32_t *back = neighbour + 4 * other, c = (int32_t)cell;
    /* one, mostly: which, is not guessed */
    unsigned facets = (unsigned)((back[0] == c) | (back[1] == c) << 1 | (back[2] == c) << 2 |
                                 (back[3] == c) << 3);
    for (; facets; facets &= facets - 1) {
        const int j = __builtin_ctz(facets);
        if (are_same(others(vertex + 4 * other, j), others(vertex + 4 * cell, i)))
            return j;
    }
    return -1;
}

static int facet_back(int corners, const int32_t *vertex, const int32_t *neighbour, size_t other,
                      size_t cell, int i)
{
    const int32_t *theirs = vertex + (size_t)corners * other,
                  *ours = vertex + (size_t)corners * cell;
    const int32_t *back = neighbour + (size_t)corners * other;
    for (int j = 0; j < corners; j++) {
        if (back[j] != (int32_t)cell)
            continue;
        int shared = 0;
        for (int k = 0; k < corners; k++)
            for (int m = 0; m < corners; m++)
                shared += (k != j) & (m != i) & (theirs[k] == ours[m]);
        if (shared == corners - 1)
            return j;
    }
    return -1;
}

int tetra_facet_back(const struct tetra *t, size_t other, size_t cell, int i)
{
    return t->corners == 4 ? facet_back_4(t->vertex, t->neighbour, other, cell, i)
                           : facet_back(t->corners, t->vertex, t->neighbour, other, cell, i);
}

/* -- cells ------------------------------------------------------------------------------------ */

static struct error *check_indices(const struct tetra *t, size_t count, size_t first, size_t end)
{
    const size_t corners = (size_t)t->corners;
    for (size_t i = corners * first; i < corners * end; i++) {
        if (t->vertex[i] < 0 || (size_t)t->vertex[i] >= count)
            return error_new("cell %zu: probe %d does not exist", i / corners, t->vertex[i]);
        if (t->neighbour[i] < -1 || t->neighbour[i] >= (int64_t)t->cell_count)
            return error_new("cell %zu: neighbour %d does not exist", i / corners, t->neighbour[i]);
    }
    return NULL;
}

static lattice_volume volume_of(const struct check *c, size_t cell)
{
    const double *p[4] = {NULL};
    const int32_t *v = c->tetra->vertex + (size_t)c->tetra->corners * cell;
    if (c->tetra->corners == 4)
        return lattice_orient(site_of(c, v[0]), site_of(c, v[1]), site_of(c, v[2]),
                              site_of(c, v[3]));
    for (int i = 0; i < c->tetra->corners; i++)
        p[i] = site_of(c, v[i]);
    return c->sign * sites_volume(c->tetra->corners, c->axis, p);
}

static struct error *name_flat(const struct tetra *t, size_t cell)
{
    static const char *const content[] = {"", "", "length", "area", "volume"};
    const int32_t *v = t->vertex + (size_t)t->corners * cell;
    if (t->corners == 4)
        return error_new("cell %zu (probes %d %d %d %d) has no positive volume", cell, v[0], v[1],
                         v[2], v[3]);
    return error_new("cell %zu (probes %d %d ...) has no %s, or turns against the first", cell,
                     v[0], v[1], content[t->corners]);
}

/* Indices, volumes, and that each neighbour of a larger number looks back over the same facet. */
static struct error *check_chunk(void *context, size_t index, int thread)
{
    (void)thread;
    const struct check *c = context;
    const struct tetra *t = c->tetra;
    const int corners = t->corners;
    struct chunk sum = {0}; /* apart from that of other threads until it is whole */
    const size_t first = index * CHUNK,
                 end = first + CHUNK < t->cell_count ? first + CHUNK : t->cell_count;
    struct error *err = check_indices(t, c->count, first, end);
    for (size_t cell = first; cell < end && !err; cell++) {
        const lattice_volume volume = volume_of(c, cell);
        if (volume <= 0)
            return name_flat(t, cell);
        sum.volume += volume;
        if (sum.volume > volume_most)
            return error_new(
                "cell %zu: the cells overlap: together they have more volume than the probes' box",
                cell);
        for (int i = 0; i < corners; i++) {
            const int32_t n = t->neighbour[(size_t)corners * cell + (size_t)i];
            sum.below += n >= 0 && (size_t)n <= cell;
            sum.above += n > (int64_t)cell;
            if (n > (int64_t)cell && tetra_facet_back(t, (size_t)n, cell, i) < 0)
                return error_new(
                    "cell %zu: its neighbour %d does not share the facet opposite probe %d", cell,
                    n, t->vertex[(size_t)corners * cell + (size_t)i]);
        }
    }
    c->chunk[index] = sum;
    return err;
}

/* The first cell whose neighbour does not look back. */
static struct error *name_lopsided(const struct tetra *t)
{
    for (size_t at = 0; at < (size_t)t->corners * t->cell_count; at++) {
        const size_t cell = at / (size_t)t->corners;
        const int32_t n = t->neighbour[at];
        if (n >= 0 && tetra_facet_back(t, (size_t)n, cell, (int)(at % (size_t)t->corners)) < 0)
            return error_new(
                "cell %zu: its neighbour %d does not share the facet opposite probe %d", cell, n,
                t->vertex[at]);
    }
    return error_new("two facets of cells have the same neighbour");
}

/* -- the hull --------------------------------------------------------------------------------- */

/* Calls the block for every facet i of a cell on the hull. */
#define FOR_HULL(cell, i, t)                                                                       \
    for (size_t cell = 0; cell < (t)->cell_count; cell++)                                          \
        for (int i = 0; i < (t)->corners; i++)                                                     \
            if ((t)->neighbour[(size_t)(t)->corners * cell + (size_t)i] < 0)

/* Where two facets of the hull meet: an edge, from its smaller row to its larger; of triangles, a
 * corner (low == high). */
struct seam {
    int32_t low, high;
    bool forward;      /* the facet runs from low to high; of triangles, ends here */
    int32_t corner[3]; /* the facet's */
    int32_t cell;
};

static int compare_seams(const void *a, const void *b)
{
    const struct seam *e = a, *f = b;
    if (e->low != f->low)
        return e->low < f->low ? -1 : 1;
    if (e->high != f->high)
        return e->high < f->high ? -1 : 1;
    return (int)e->forward - (int)f->forward;
}

/* Whether the flat cell in a dent (corners, and twice its area or six times its volume) is no
 * deeper than allowed. */
static bool is_shallow(int corners, const double *const p[4], lattice_volume content)
{
    double longest = 0, base = 0;
    struct vec3 q[4];
    for (int i = 0; i < corners; i++)
        q[i] = vec3_load(p[i]);
    for (int i = 0; i < corners; i++)
        for (int j = i + 1; j < corners; j++)
            longest = fmax(longest, vec3_length(vec3_sub(q[i], q[j])));
    for (int i = 0; i < 4 && corners == 4; i++)
        base =
            fmax(base, vec3_length(vec3_cross(vec3_sub(q[cell_face[i][1]], q[cell_face[i][0]]),
                                              vec3_sub(q[cell_face[i][2]], q[cell_face[i][0]]))));
    return fabs((double)content) <= shallow * longest * (corners == 4 ? base : longest);
}

/* The dent between two facets that meet at a seam, if there is one. */
static struct error *check_dent(const struct check *c, const struct seam *e, const struct seam *f)
{
    const int corners = c->tetra->corners;
    const double *p[4];
    lattice_volume content;
    if (corners == 4) {
        int apex = 0;
        while (f->corner[apex] == e->low || f->corner[apex] == e->high)
            apex++;
        for (int k = 0; k < 3; k++)
            p[k] = site_of(c, e->corner[k]);
        p[3] = site_of(c, f->corner[apex]);
        content = lattice_orient(p[0], p[1], p[2], p[3]);
    } else { /* the facet that begins here, then the one that ends here */
        p[0] = site_of(c, f->corner[0]);
        p[1] = site_of(c, f->corner[1]);
        p[2] = site_of(c, e->corner[1]);
        content = -c->sign * sites_volume(3, c->axis, p);
    }
    if (content <= 0)
        return NULL;
    if (c->verdict)
        c->verdict->dents++;
    if (is_shallow(corners, p, content))
        return NULL;
    if (corners == 4)
        return error_new("the hull is not convex at the edge of probes %d and %d of cell %d",
                         e->low, e->high, e->cell);
    return error_new("the hull is not convex at probe %d of cell %d", e->low, e->cell);
}

static size_t list_seams(const struct check *c, struct seam *seam)
{
    const struct tetra *t = c->tetra;
    size_t count = 0;
    FOR_HULL(cell, i, t)
    {
        int facet[3];
        struct seam s = {.cell = (int32_t)cell};
        const int corners = facet_corners(t->corners, i, facet);
        for (int k = 0; k < corners; k++)
            s.corner[k] = t->vertex[(size_t)t->corners * cell + (size_t)facet[k]];
        for (int k = 0; k < corners; k++) {
            const int32_t from = s.corner[k], to = corners == 3 ? s.corner[(k + 1) % 3] : from;
            s.low = from < to ? from : to;
            s.high = from < to ? to : from;
            s.forward = corners == 3 ? from < to : k == 1;
            seam[count++] = s;
        }
    }
    return count;
}

/* Closed and oriented: at each seam two facets meet, one running each way; and convex but for
 * shallow dents. */
static struct error *check_seams(const struct check *c, size_t facets)
{
    struct seam *seam = NULL;
    struct error *err = array_create(&seam, 3 * facets, sizeof *seam);
    if (err)
        return err;
    const size_t count = list_seams(c, seam);
    qsort(seam, count, sizeof *seam, compare_seams);
    for (size_t i = 0; i < count && !err; i += 2) {
        const struct seam *e = &seam[i], *f = &seam[i + 1];
        if (i + 1 == count || e->low != f->low || e->high != f->high || e->forward || !f->forward ||
            (i + 2 < count && seam[i + 2].low == e->low && seam[i + 2].high == e->high))
            err = error_new("the hull is not closed at probes %d and %d of cell %d", e->low,
                            e->high, e->cell);
        else
            err = check_dent(c, e, f);
    }
    free(seam);
    return err;
}

/* Partial sums over the hull's facets may wrap; the total fits. */
__extension__ typedef unsigned __int128 wrapping_volume;

static struct error *check_hull(const struct check *c, lattice_volume volume)
{
    const struct tetra *t = c->tetra;
    const double *p[4] = {site_of(c, t->vertex[0])}; /* a cone over each facet, from one point */
    size_t facets = 0;
    wrapping_volume hull = 0;
    FOR_HULL(cell, i, t)
    {
        int facet[3];
        const int corners = facet_corners(t->corners, i, facet);
        for (int k = 0; k < corners; k++)
            p[k + 1] = site_of(c, t->vertex[(size_t)t->corners * cell + (size_t)facet[k]]);
        const int turn = t->corners == 2 && i == 1 ? -c->sign : c->sign;
        hull += (wrapping_volume)(turn * sites_volume(t->corners, c->axis, p));
        facets++;
    }
    if (t->corners == 1)
        return t->cell_count == 1 && facets == 1
                   ? NULL
                   : error_new("expected one cell of one probe, got %zu", t->cell_count);
    if (t->corners == 2 && facets != 2)
        return error_new("the segments have %zu ends, not two", facets);
    if ((lattice_volume)hull != volume)
        return error_new("the volumes of the cells do not sum up to the hull's");
    return t->corners > 2 ? check_seams(c, facets) : NULL;
}

static struct error *check_sites(struct check *c, int threads)
{
    const struct tetra *t = c->tetra;
    const size_t chunks = (t->cell_count + CHUNK - 1) / CHUNK;
    if (!t->cell_count)
        return error_new("there are no cells");
    struct error *err = array_create(&c->chunk, chunks, sizeof *c->chunk);
    if (!err)
        err = check_indices(t, c->count, 0, 1);
    c->sign = 1;
    if (!err && t->corners < 4 && volume_of(c, 0) < 0)
        c->sign = -1;
    if (!err)
        err = threads_for(threads, chunks, check_chunk, c);
    lattice_volume volume = 0;
    size_t below = 0, above = 0;
    for (size_t i = 0; i < chunks && !err; i++) {
        below += c->chunk[i].below;
        above += c->chunk[i].above;
        volume += c->chunk[i].volume;
        if (volume > volume_most)
            err =
                error_new("the cells overlap: together they have more volume than the probes' box");
    }
    if (!err && below != above)
        err = name_lopsided(t);
    if (!err)
        err = check_hull(c, volume);
    free(c->chunk);
    return err;
}

struct error *tetra_check_sites(const struct tetra *tetra, size_t count, const double *site,
                                const int axis[2], int threads)
{
    struct check c = {.tetra = tetra, .count = count, .site = site, .axis = axis};
    return check_sites(&c, threads);
}

/* -- Delaunay --------------------------------------------------------------------------------- */

/* Whole numbers of 256 bits, two's complement, least word first. */
struct wide {
    uint64_t word[4];
};

/* sum += a * b. */
static void wide_add_product(struct wide *sum, lattice_volume a, wrapping_volume b)
{
    const bool negative = a < 0;
    const wrapping_volume size = negative ? -(wrapping_volume)a : (wrapping_volume)a;
    const uint64_t x[2] = {(uint64_t)size, (uint64_t)(size >> 64)},
                   y[2] = {(uint64_t)b, (uint64_t)(b >> 64)};
    uint64_t product[4] = {0};
    for (int i = 0; i < 2; i++) {
        wrapping_volume carry = 0;
        for (int j = 0; j < 2; j++) {
            carry += (wrapping_volume)x[i] * y[j] + product[i + j];
            product[i + j] = (uint64_t)carry;
            carry >>= 64;
        }
        product[i + 2] = (uint64_t)carry;
    }
    wrapping_volume carry = negative;
    for (int i = 0; i < 4; i++) {
        carry += (wrapping_volume)sum->word[i] + (negative ? ~product[i] : product[i]);
        sum->word[i] = (uint64_t)carry;
        carry >>= 64;
    }
}

static bool wide_positive(const struct wide *n)
{
    return !(n->word[3] >> 63) && (n->word[0] | n->word[1] | n->word[2] | n->word[3]);
}

/* The square of the distance between two sites: of a triangle's, as their projections lie in the
 * plane. */
static wrapping_volume exact_square(const double *p, const double *q)
{
    wrapping_volume sum = 0;
    for (int k = 0; k < 3; k++) {
        const lattice_volume d = (int64_t)(p[k] - q[k]);
        sum += (wrapping_volume)(d * d);
    }
    return sum;
}

static double square_in_plane(const struct check *c, const double *p, const double *q)
{
    const double a = p[c->axis[0]] - q[c->axis[0]], b = p[c->axis[1]] - q[c->axis[1]];
    const double x = c->metric[0][0] * a + c->metric[0][1] * b, y = c->metric[1][1] * b;
    return x * x + y * y;
}

/* Of a cell and a site e: e is inside the circumsphere where sum_i o_i d_i^2 > 0, o_i being the
 * volume with e in place of corner i and d_i its distance from there (e's power is minus that over
 * the cell's volume). Returns by how much relative to sum_i |o_i| d_i^2, which is the relative
 * error of the squared distances that would explain it; 0 where e is not inside: by exact
 * arithmetic for tetrahedra, to rounding for triangles, whose plane is rounded. */
static double intrusion(const struct check *c, size_t cell, int32_t e)
{
    const int corners = c->tetra->corners;
    const double *p[4] = {NULL}, *const at = site_of(c, e);
    lattice_volume o[4];
    double sum = 0, size = 0;
    for (int i = 0; i < corners; i++)
        p[i] = site_of(c, c->tetra->vertex[(size_t)corners * cell + (size_t)i]);
    for (int i = 0; i < corners; i++) {
        const double *was = p[i];
        p[i] = at;
        o[i] = c->sign * sites_volume(corners, c->axis, p);
        p[i] = was;
        const double square = corners == 4 ? (double)exact_square(was, at)
                                           : square_in_plane(c, was, at);
        sum += (double)o[i] * square;
        size += fabs((double)o[i]) * square;
    }
    if (fabs(sum) > 1e-12 * size || corners < 4) /* far beyond what rounding can do */
        return sum > 1e-12 * size ? sum / size : 0;
    struct wide exact = {{0}};
    for (int i = 0; i < corners; i++)
        wide_add_product(&exact, o[i], exact_square(p[i], at));
    return wide_positive(&exact) ? fmax(sum / size, 1e-300) : 0;
}

static struct error *check_delaunay(const struct check *c)
{
    const struct tetra *t = c->tetra;
    const int corners = t->corners;
    struct error *err = NULL;
    for (size_t at = 0; at < (size_t)corners * t->cell_count && !err && corners > 2; at++) {
        const size_t cell = at / (size_t)corners;
        const int32_t n = t->neighbour[at];
        if (n < (int64_t)cell) /* the hull, or seen from the other side */
            continue;
        const int back = tetra_facet_back(t, (size_t)n, cell, (int)(at % (size_t)corners));
        const int32_t e = t->vertex[(size_t)corners * (size_t)n + (size_t)back];
        const double by = intrusion(c, cell, e);
        c->verdict->inner_facets++;
        c->verdict->not_delaunay += by > 0;
        c->verdict->tolerance = fmax(c->verdict->tolerance, by);
        if (by > STRETCH_TOLERANCE)
            err = error_new("cell %zu is not Delaunay: probe %d of its neighbour %d is inside its "
                            "circumsphere, beyond a tolerance of %g",
                            cell, e, n, STRETCH_TOLERANCE);
    }
    return err;
}

/* -- what only whole streams can be asked ----------------------------------------------------- */

/* All cells are reached from the first. */
static struct error *check_connected(const struct tetra *t)
{
    int32_t *stack = NULL;
    unsigned char *seen = NULL;
    struct error *err = array_create(&stack, t->cell_count, sizeof *stack);
    if (!err)
        err = array_create(&seen, t->cell_count, 1);
    size_t waiting = 0, reached = 0;
    if (!err) {
        stack[waiting++] = 0;
        seen[0] = 1;
    }
    while (waiting) {
        const size_t cell = (size_t)stack[--waiting];
        reached++;
        for (int i = 0; i < t->corners; i++) {
            const int32_t n = t->neighbour[(size_t)t->corners * cell + (size_t)i];
            if (n < 0 || seen[n])
                continue;
            seen[n] = 1;
            stack[waiting++] = n;
        }
    }
    if (!err && reached < t->cell_count)
        err = error_new("the cells do not hang together: from cell 0, %zu of %zu are reached",
                        reached, t->cell_count);
    free(stack);
    free(seen);
    return err;
}

/* Every probe is in a cell, or merged with one that is. */
static struct error *check_used(const struct tetra *t, size_t count)
{
    unsigned char *used = NULL;
    struct error *err = array_create(&used, count, 1);
    for (size_t i = 0; i < (size_t)t->corners * t->cell_count && !err; i++)
        used[t->vertex[i]] = 1;
    for (size_t i = 0; i < count && !err; i++) {
        const int32_t into = t->merged ? t->merged[i] : -1;
        if (into < -1 || into >= (int64_t)count)
            err = error_new("probe %zu is merged with probe %d, which does not exist", i, into);
        else if (into < 0 && !used[i])
            err = error_new("probe %zu is in no cell, and not merged with one that is", i);
        else if (into >= 0 && (used[i] || !used[into]))
            err = error_new("probe %zu is merged with probe %d, but %s", i, into,
                            used[i] ? "in a cell itself" : "that is in no cell");
    }
    free(used);
    return err;
}

/* The sites that cells use: what their plane or line is that of. */
static struct error *find_used(const struct check *c, unsigned char **used)
{
    const struct tetra *t = c->tetra;
    struct error *err = check_indices(t, c->count, 0, t->cell_count);
    if (!err)
        err = array_create(used, c->count, 1);
    for (size_t i = 0; i < (size_t)t->corners * t->cell_count && !err; i++)
        (*used)[t->vertex[i]] = 1;
    return err;
}

static struct error *find_plane(struct check *c, const unsigned char *used, int axis[2])
{
    double *site = NULL;
    size_t count = 0;
    struct error *err = array_create(&site, 3 * c->count, sizeof *site);
    for (size_t i = 0; i < c->count && !err; i++)
        if (used[i])
            memcpy(site + 3 * count++, site_of(c, (int32_t)i), 3 * sizeof *site);
    if (!err && count) {
        sites_axes(count, site, c->tetra->corners, axis);
        sites_metric(count, site, axis, c->metric);
    }
    free(site);
    return err;
}

/* Sound, and if a verdict is asked for, Delaunay. */
static struct error *check_cells(struct check *c)
{
    struct error *err = check_sites(c, threads_available());
    return !err && c->verdict ? check_delaunay(c) : err;
}

/* The same where sites fall in the plane or line that they lie near. */
static struct error *check_flat(const struct check *c, const struct span_frame *frame)
{
    static const int axis[2] = {0, 1};
    struct check flat = *c;
    double *site = NULL;
    struct error *err = array_create(&site, 3 * c->count, sizeof *site);
    for (size_t i = 0; i < c->count && !err; i++) {
        span_flatten(frame, c->tetra->corners, site_of(c, (int32_t)i), site + 3 * i);
        for (size_t k = 0; k < 3; k++)
            site[3 * i + k] = rint(site[3 * i + k]);
    }
    flat.site = site;
    flat.axis = axis;
    flat.metric[0][0] = flat.metric[1][1] = 1;
    flat.metric[0][1] = flat.metric[1][0] = 0;
    if (!err)
        err = check_cells(&flat);
    free(site);
    return err;
}

/* Cells that lie in no plane or line: of some area or length, with neighbours that share the
 * facet. Of segments more than two may meet. */
static struct error *check_bent(const struct check *c)
{
    const struct tetra *t = c->tetra;
    const size_t corners = (size_t)t->corners;
    for (size_t at = 0; at < corners * t->cell_count; at++) {
        const int32_t *v = t->vertex + at / corners * corners, n = t->neighbour[at];
        bool nothing = true;
        for (int k = 0; k < 3; k++) {
            const int across[2] = {k, (k + 1) % 3};
            const double *p[4] = {site_of(c, v[0]), site_of(c, v[1]), site_of(c, v[corners - 1])};
            nothing = nothing && !sites_volume(t->corners, across, p);
        }
        if (nothing)
            return name_flat(t, at / corners);
        int shared = 0;
        for (size_t i = 0; i < corners * corners && n >= 0; i++)
            shared += i / corners != at % corners &&
                      v[i / corners] == t->vertex[corners * (size_t)n + i % corners];
        if (n >= 0 && (shared != t->corners - 1 ||
                       (corners == 3 &&
                        tetra_facet_back(t, (size_t)n, at / corners, (int)(at % corners)) < 0)))
            return error_new(
                "cell %zu: its neighbour %d does not share the facet opposite probe %d",
                at / corners, n, t->vertex[at]);
    }
    return NULL;
}

/* Triangles and segments may lie in a plane or line, near one, or be bent. */
static struct error *check_thin(struct check *c, int axis[2])
{
    enum { ROUNDING = 16 }; /* steps */
    unsigned char *used = NULL;
    struct span_frame frame = {.off = 0};
    struct error *err = find_used(c, &used);
    if (!err)
        span_find(&frame, c->count, c->site, used, c->tetra->corners);
    if (!err)
        err = find_plane(c, used, axis);
    free(used);
    if (!err)
        err = check_cells(c);
    if (!err || frame.off <= ROUNDING)
        return err;
    error_destroy(err);
    if (c->verdict)
        *c->verdict = (struct tetra_verdict){0};
    err = check_flat(c, &frame);
    if (!err)
        return NULL;
    error_destroy(err);
    if (c->verdict)
        *c->verdict = (struct tetra_verdict){0};
    return check_bent(c);
}

static struct error *check_whole(const struct tetra *tetra, size_t count, const double *position,
                                 struct tetra_verdict *verdict)
{
    double *site = NULL;
    int axis[2] = {0, 1};
    struct error *err = array_create(&site, 3 * count, sizeof *site);
    const struct lattice lattice = lattice_fit(count, position);
    for (size_t i = 0; i < count && !err; i++)
        lattice_snap(&lattice, position + 3 * i, site + 3 * i);
    struct check c = {
        .tetra = tetra, .count = count, .site = site, .axis = axis, .verdict = verdict};
    if (!err)
        err = tetra->corners == 3 || tetra->corners == 2 ? check_thin(&c, axis) : check_cells(&c);
    if (!err && verdict)
        err = check_connected(tetra);
    if (!err && verdict)
        err = check_used(tetra, count);
    free(site);
    return err;
}

struct error *tetra_check(const struct tetra *tetra, size_t count, const double *position)
{
    return check_whole(tetra, count, position, NULL);
}

struct error *tetra_verify(const struct tetra *tetra, size_t count, const double *position,
                           struct tetra_verdict *verdict)
{
    *verdict = (struct tetra_verdict){0};
    return check_whole(tetra, count, position, verdict);
}
