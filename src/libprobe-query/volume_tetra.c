/* SPDX-License-Identifier: Apache-2.0 */
/* Tetrahedra, all that is made of each in one pass. Based on:
 * Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012: a matrix for each
 * cell.
 *
 * Opening a large file is waiting for memory: each cell is read once and written once, in the order
 * in which it lies (packed files are in it already). Lazy, none is written: half of the time goes
 * into memory for matrices that few look-ups ask for. All is checked, and a cell is made when the
 * first look-up comes to it.
 *
 * Neighbours. A face is checked from the later one of the two cells that share it. That is enough:
 * cells of positive volume have four different corners, so a face that was found is no other's, and
 * where as many faces name an earlier cell as name a later one, all of those were found.
 *
 * What is not certain here (a volume that is not positive, a face that was not found) is looked at
 * again by volume_make.c, which says what is wrong and where.
 */
#include "volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- planes ----------------------------------------------------------------------------------- */

/* The nearest double of a whole number below 2^84: both parts are exact, so their sum is rounded
 * once. */
static inline double nearest_of_84(lattice_volume x)
{
    return (double)(int64_t)(x >> 32) * 0x1p32 + (double)(int64_t)(uint32_t)x;
}

/* Of one below 2^126: of its first 63 bits, the last of which stands for all that follow, the
 * machine rounds right. */
static inline double nearest_of_126(lattice_volume x)
{
    const int64_t high = (int64_t)(x >> 64);
    const uint64_t low = (uint64_t)x,
                   size = ((uint64_t)high << 1 | low >> 63) ^ (uint64_t)(high >> 63);
    if (!size)
        return (double)(int64_t)low;
    const int bits = 64 - __builtin_clzll(size);
    const uint64_t cut = low & (((uint64_t)1 << bits) - 1);
    const int64_t first = (int64_t)((uint64_t)(x >> bits) | (cut != 0));
    const uint64_t exponent = (uint64_t)(1023 + bits) << 52;
    double scale;
    memcpy(&scale, &exponent, sizeof scale);
    return (double)first * scale;
}

/* A cell's planes: those of weight i are its facet's cofactors over the cell's volume. All whole
 * numbers below 2^126, so each number of a plane is right to three roundings; volume_walk.c builds
 * on that. Returns whether the volume is positive. */
static inline bool make_planes(const double *const s[4], double plane[4][3])
{
    int64_t d[4][3]; /* the first corner, the others as seen from it */
    double n[3][3];
    lattice_volume volume = 0, constant[3] = {0};
    for (int k = 0; k < 3; k++) {
        d[0][k] = lattice_whole(s[0][k]);
        for (int i = 1; i < 4; i++)
            d[i][k] = lattice_whole(s[i][k]) - d[0][k];
    }
    for (int k = 0; k < 3; k++) {
        const int x = k == 2 ? 0 : k + 1, y = k == 0 ? 2 : k - 1;
        for (int i = 0; i < 3; i++) { /* inward, of the facet of corners 0 and these */
            const int64_t *b = d[i == 0 ? 2 : i == 1 ? 3 : 1], *c = d[i == 0 ? 3 : i == 1 ? 1 : 2];
            const lattice_volume area = (lattice_volume)b[x] * c[y] - (lattice_volume)b[y] * c[x];
            n[k][i] = nearest_of_84(area);
            constant[i] -= area * d[0][k];
            if (i == 0)
                volume += area * d[1][k];
        }
    }
    const double whole_cell = nearest_of_126(volume);
    if (!(whole_cell > 0))
        return false;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            plane[k][i] = n[k][i] / whole_cell;
        plane[3][i] = nearest_of_126(constant[i]) / whole_cell;
    }
    return true;
}

/* -- cells ------------------------------------------------------------------------------------ */

struct corners {
    int32_t vertex[4], neighbour[4];
};

static inline void read_four(const void *index, int bytes, size_t cell, int32_t four[4])
{
    if (bytes == 4)
        memcpy(four, (const int32_t *)index + 4 * cell, 4 * sizeof *four);
    else
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++)
            four[k] = volume_index(index, 2, 4 * cell + k);
}

static inline struct corners read_corners(const struct probe_volume *v, size_t cell)
{
    struct corners c;
    read_four(v->vertex, v->vertex_bytes, cell, c.vertex);
    read_four(v->neighbour, v->neighbour_bytes, cell, c.neighbour);
    return c;
}

typedef int32_t four __attribute__((vector_size(16)));

/* Whether b names `cell` as its neighbour across the face that it shares with a, opposite a corner
 * of a. All corners of a cell differ. */
static inline bool shares_face(const struct corners *a, int corner, const struct corners *b,
                               int32_t cell)
{
    four vertex, neighbour;
    memcpy(&vertex, b->vertex, sizeof vertex);
    memcpy(&neighbour, b->neighbour, sizeof neighbour);
    const int *other = volume_facet_corner[corner];
    const four shared = (vertex == a->vertex[other[0]]) | (vertex == a->vertex[other[1]]) |
                        (vertex == a->vertex[other[2]]), /* -1 or 0 */
        found = shared + (~shared & (neighbour == cell) & 16);
    return found[0] + found[1] + found[2] + found[3] == 16 - 3;
}

/* The middle of a cell, exactly. */
static inline void middle_of(const double *const s[4], double middle[3])
{
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++)
        middle[k] = (s[0][k] + s[1][k] + s[2][k] + s[3][k]) / 4;
}

static inline uint64_t key_of(const double middle[3])
{
    uint32_t x[3];
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++)
        x[k] = (uint32_t)(int64_t)(middle[k] * (1.0 / ((uint64_t)1 << (LATTICE_BITS - 21 + 1))));
    return volume_morton(x, 21);
}

static uint64_t key_of_cell(const struct probe_volume *v, size_t cell)
{
    int32_t vertex[4];
    double middle[3];
    read_four(v->vertex, v->vertex_bytes, cell, vertex);
    const double *const s[4] = {volume_site(v, vertex[0]), volume_site(v, vertex[1]),
                                volume_site(v, vertex[2]), volume_site(v, vertex[3])};
    middle_of(s, middle);
    return key_of(middle);
}

/* Whether cells lie along a Morton curve by their middles, leaf by leaf of the tree. */
static bool are_in_order(const struct probe_volume *v)
{
    uint64_t last = 0;
    for (size_t i = 0; i < v->cells; i += VOLUME_LEAF) {
        const uint64_t key = key_of_cell(v, i);
        if (key < last)
            return false;
        last = key;
    }
    return true;
}

/* Cells in the order of their middles along a Morton curve. None is kept where they lie in it. */
static enum probe_status make_order(struct probe_volume *v)
{
    const size_t n = v->cells;
    if (are_in_order(v))
        return PROBE_OK;
    uint64_t *key = volume_block(4 * n * sizeof *key), *room = key + n;
    v->number = malloc(n * sizeof *v->number);
    v->inner = malloc(n * sizeof *v->inner);
    v->bytes += 2 * n * sizeof *v->number;
    const bool made = key && v->number && v->inner;
    for (size_t i = 0; made && i < n; i++)
        key[i] = key_of_cell(v, i);
    if (made)
        volume_sort(n, key, 63, (uint32_t *)v->number, room);
    for (size_t i = 0; made && i < n; i++)
        v->inner[v->number[i]] = (int32_t)i;
    free(key);
    return made ? PROBE_OK : PROBE_NO_MEMORY;
}

/* -- all -------------------------------------------------------------------------------------- */

/* About a box of the grid for two cells: walks from there are a few steps. */
static enum probe_status begin_start(struct probe_volume *v)
{
    v->start_side = (size_t)cbrt((double)v->cells / 2) + 1;
    const size_t boxes = v->start_side * v->start_side * v->start_side;
    v->start = malloc(boxes * sizeof *v->start);
    if (!v->start)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < boxes; i++)
        v->start[i] = -1;
    v->bytes += boxes * sizeof *v->start;
    return PROBE_OK;
}

static void end_start(struct probe_volume *v)
{
    const size_t boxes = v->start_side * v->start_side * v->start_side;
    for (size_t i = 1; i < boxes; i++) /* an empty one has its neighbour's */
        v->start[i] = v->start[i] < 0 ? v->start[i - 1] : v->start[i];
}

/* What is gathered of all cells. */
struct pass {
    double low[3], high[3]; /* of a leaf of the tree */
    size_t earlier, later;  /* faces whose neighbour is so */
    bool sure;
};

static inline void check_faces(struct probe_volume *v, const struct volume_cell *cell, size_t i,
                               const struct corners *c, struct pass *pass)
{
    int earlier[5]; /* corners; the last for what none are */
    size_t count = 0, outer = 0;
#pragma GCC unroll 4
    for (int k = 0; k < 4; k++) {
        const int32_t n = c->neighbour[k], here = (int32_t)i;
        earlier[count] = k;
        count += (uint32_t)n < (uint32_t)here;
        pass->later += n > here;
        pass->sure &= n != here;
        outer += n < 0;
    }
    pass->earlier += count;
    v->facets += outer;
    if (outer)
        v->on_hull[i / VOLUME_LEAF] = 1;
    for (size_t j = 0; j < count; j++) {
        const size_t n = (size_t)c->neighbour[earlier[j]];
        struct corners other;
        if (cell)
            memcpy(&other, cell[n].vertex, sizeof other);
        else
            other = read_corners(v, n);
        pass->sure &= shares_face(c, earlier[j], &other, (int32_t)i);
    }
}

/* Lean: by a bound of rounding (eight of all products' sizes), or exactly. */
static inline bool has_volume(const double *const s[4])
{
    double d[3][3], volume = 0, size = 0;
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++)
#pragma GCC unroll 3
        for (int k = 0; k < 3; k++)
            d[i][k] = s[i + 1][k] - s[0][k];
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
        const int x = k == 2 ? 0 : k + 1, y = k == 0 ? 2 : k - 1;
        const double a = d[1][x] * d[2][y], b = d[1][y] * d[2][x];
        volume += d[0][k] * (a - b);
        size += fabs(d[0][k]) * (fabs(a) + fabs(b));
    }
    return volume > 0x1p-50 * size || lattice_orient(s[0], s[1], s[2], s[3]) > 0;
}

static inline void grow_leaf(struct probe_volume *v, const double *const s[4], size_t i,
                             struct pass *pass)
{
    const bool first = i % VOLUME_LEAF == 0;
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
        double low = first ? s[0][k] : pass->low[k], high = first ? s[0][k] : pass->high[k];
#pragma GCC unroll 4
        for (int c = 0; c < 4; c++) {
            low = s[c][k] < low ? s[c][k] : low;
            high = s[c][k] > high ? s[c][k] : high;
        }
        pass->low[k] = low;
        pass->high[k] = high;
    }
    if (i % VOLUME_LEAF == VOLUME_LEAF - 1 || i == v->cells - 1)
        volume_tree_put(&v->cell_tree, i / VOLUME_LEAF, pass->low, pass->high);
}

/* Makes the i-th cell; cell NULL: lean, or later. */
static inline void make_cell(struct probe_volume *v, struct volume_cell *cell, size_t i,
                             struct pass *pass)
{
    struct corners c = read_corners(v, (size_t)volume_number(v, i));
    for (int k = 0; k < 4 && v->inner; k++)
        c.neighbour[k] = c.neighbour[k] < 0 ? -1 : v->inner[c.neighbour[k]];
    const double *const s[4] = {volume_site(v, c.vertex[0]), volume_site(v, c.vertex[1]),
                                volume_site(v, c.vertex[2]), volume_site(v, c.vertex[3])};
    double middle[3];
    if (cell)
        memcpy(cell[i].vertex, &c, sizeof c);
    pass->sure &= cell ? make_planes(s, cell[i].plane) : has_volume(s);
    check_faces(v, cell, i, &c, pass);
    grow_leaf(v, s, i, pass);
    middle_of(s, middle);
    v->start[volume_start_box(v, middle)] = (int32_t)i;
}

const struct volume_cell *volume_make_ready(const struct probe_volume *v, size_t cell,
                                            struct volume_cell *own)
{
    const struct corners c = read_corners(v, cell);
    const double *const s[4] = {volume_site(v, c.vertex[0]), volume_site(v, c.vertex[1]),
                                volume_site(v, c.vertex[2]), volume_site(v, c.vertex[3])};
    struct volume_cell *to = &v->cell[cell];
    uint64_t none = 0;
    make_planes(s, own->plane);
    memcpy(own->vertex, c.vertex, sizeof c.vertex);
    memcpy(own->neighbour, c.neighbour, sizeof c.neighbour);
    /* begun: not ready, and not to be begun by another */
    if (!__atomic_compare_exchange_n(&to->pair[0], &none, UINT64_MAX, false, __ATOMIC_RELAXED,
                                     __ATOMIC_RELAXED))
        return own;
    memcpy(to->plane, own->plane, sizeof to->plane);
    memcpy(to->neighbour, own->neighbour, sizeof to->neighbour);
    to->pair[1] = own->pair[1];
    __atomic_store_n(&to->pair[0], own->pair[0], __ATOMIC_RELEASE);
    return to;
}

static enum probe_status begin_cells(struct probe_volume *v, struct volume_cell **cell)
{
    const size_t bytes = v->cells * sizeof **cell;
    *cell = volume_zeros(bytes, &v->cell_owned);
    v->bytes += *cell ? volume_block_bytes(bytes) + 64 : 0;
    return *cell ? PROBE_OK : PROBE_NO_MEMORY;
}

enum probe_status volume_tetra_end(struct probe_volume *v)
{
    return v->lazy ? begin_cells(v, &v->cell) : PROBE_OK;
}

enum probe_status volume_tetra_make(struct probe_volume *v, bool *sure)
{
    const bool lean = v->flags & PROBE_LEAN;
    struct pass pass = {.sure = true};
    struct volume_cell *cell = NULL;
    enum probe_status status = lean ? PROBE_OK : make_order(v);
    v->lazy = v->lazy && !v->number; /* in the order in which they were given */
    if (!status && !lean && !v->lazy)
        status = begin_cells(v, &cell);
    if (!status)
        status = volume_tree_init(&v->cell_tree, v->cells);
    if (!status)
        status = begin_start(v);
    if (!status && !(v->on_hull = calloc(v->cells / VOLUME_LEAF + 1, 1)))
        status = PROBE_NO_MEMORY;
    if (status)
        return status;
    for (size_t i = 0; i < v->cells; i++)
        make_cell(v, cell, i, &pass);
    volume_tree_finish(&v->cell_tree);
    end_start(v);
    *sure = pass.sure && pass.earlier == pass.later;
    v->cell = cell;
    return PROBE_OK;
}
