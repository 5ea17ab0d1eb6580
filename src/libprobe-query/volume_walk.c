/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012: walk from the last
 * cell, to the neighbour beyond the most negative weight. Edelsbrunner, "An acyclicity theorem for
 * cell complexes in d dimensions", Combinatorica 10, 1990. Shewchuk, "Adaptive precision
 * floating-point arithmetic and fast robust geometric predicates", DCG 18, 1997: signs with an
 * error bound.
 *
 * Why it ends. The walk crosses a face only when the point is strictly beyond it, which is decided
 * exactly. Among Delaunay cells such a walk visits none twice (Edelsbrunner 1990: from any
 * viewpoint, Delaunay cells are partially ordered by which hides which), so it ends after as many
 * steps as there are cells at most, and in practice after a few times their cube root. A mesh whose
 * slivers were mended, or that someone else made, may not be Delaunay. So the walk is only a head
 * start: where it has not arrived after steps_most steps, or leaves a hull with dents, through
 * which it may come in again, the tree of boxes over all cells is descended instead. That visits
 * each of its finitely many nodes at most once, and finds a cell that holds the point if there is
 * one.
 *
 * Why the answer does not depend on where the walk began. Cells of a mesh do not overlap, so a
 * point strictly within one has one answer. A point on a face, an edge or a probe (an exact weight
 * of 0) is in several: its answer is the first of them in the tree's order.
 *
 * Where there are rays, a walk that has left a hull with dents needs no tree but near the hull:
 * each point is in one cell, inner or outer, so one that an outer cell holds, farther from the hull
 * than rounding goes, is outside.
 */
#include "volume.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* -- a point ---------------------------------------------------------------------------------- */

static double round_whole(double x) /* to even, as rint, which is a call: |x| < 2^51 */
{
    return x + 0x1.8p52 - 0x1.8p52;
}

static double far_coordinates(const struct probe_volume *v, const double point[3],
                              double coordinates[3]);

static const double reach = 0x1p60;

static inline double coordinates_of(const struct probe_volume *v, const double point[3],
                                    double coordinates[3])
{
    if (v->scale > 0) {
        for (int k = 0; k < 3; k++)
            coordinates[k] = point[k] * v->scale - v->shift[k];
        /* however far the middle of the probes is from the lattice's origin */
        const double sure = reach - 0x1p42;
        if (fabs(coordinates[0]) <= sure && fabs(coordinates[1]) <= sure &&
            fabs(coordinates[2]) <= sure)
            return 0;
    }
    return far_coordinates(v, point, coordinates);
}

double volume_coordinates(const struct probe_volume *v, const double point[3],
                          double coordinates[3])
{
    return coordinates_of(v, point, coordinates);
}

static double far_coordinates(const struct probe_volume *v, const double point[3],
                              double coordinates[3])
{
    double middle[3], most = 0, size = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = (v->low[k] + v->high[k]) / 2;
        coordinates[k] = v->scale > 0          ? point[k] * v->scale - v->shift[k]
                         : v->lattice.step > 0 ? point[k] / v->lattice.step - v->shift[k]
                                               : 0;
        const double here = fabs(coordinates[k] - middle[k]), there = fabs(point[k]);
        most = here > most || here != here ? here : most;
        size = there > size ? there : size;
    }
    if (most <= reach)
        return 0;
    /* else the point is so far out that its coordinates overflow */
    const bool counted = most < INFINITY;
    double square = 0;
    /* towards the middle, but what lies before a side of the probes' box stays where it is before
     * it */
    for (int k = 0; k < 3; k++) {
        const double off = coordinates[k] - middle[k],
                     along = counted ? off / most : point[k] / size;
        const double within = fmin(fabs(off), v->high[k] - middle[k]);
        coordinates[k] = middle[k] + copysign(fmax(within, fabs(along) * reach), off);
        square += along * along;
    }
    return fmin((counted ? most * v->lattice.step : size) * sqrt(square), DBL_MAX);
}

/* As lattice_snap does, to the bit, of a point of the probes' box; others stay outside of it. So a
 * probe is found at its site, which in a cell that is a few steps flat is all the difference. */
static inline void round_to_lattice(const struct probe_volume *v, const double point[3],
                                    double p[3])
{
    if (!v->near) {
        lattice_snap(&v->lattice, point, p);
        return;
    }
    for (int k = 0; k < 3; k++)
        p[k] = round_whole(point[k] * v->scale) - v->shift[k];
}

/* The place of the mesh's plane or line that a point is above, rounded to the lattice along the
 * axes that matter. */
static void project(const struct probe_volume *v, const double p[3], double q[3])
{
    double along = 0;
    if (v->flat) {
        span_flatten(&v->frame, v->corners, p, q);
        for (int k = 0; k < v->corners - 1; k++)
            q[k] = rint(q[k]);
        return;
    }
    for (int k = 0; k < 3; k++)
        along += (p[k] - v->origin[k]) * v->normal[k];
    for (int k = 0; k < 3; k++)
        q[k] = v->corners == 3 ? p[k] - along * v->normal[k] : v->origin[k] + along * v->normal[k];
    for (int j = 0; j < 3; j++)
        q[v->axis[j]] = j < v->corners - 1 ? rint(q[v->axis[j]]) : 0;
}

/* -- weights ---------------------------------------------------------------------------------- */

struct weights {
    double weight[4]; /* sum 1 */
    int lowest;       /* the corner with the least weight */
    bool touches;     /* exactly: none is below 0, and one is 0 */
};

static inline int lowest_of(const double w[4])
{
    const int a = w[1] < w[0], b = 2 + (w[3] < w[2]);
    return w[b] < w[a] ? b : a;
}

__attribute__((noinline)) static bool weigh_exactly(const struct probe_volume *v, size_t cell,
                                                    const double p[3], struct weights *w)
{
    lattice_volume volume[4], sum = 0;
    volume_measure(v, cell, p, volume);
    for (int i = 0; i < 4; i++)
        sum += volume[i];
    int zeros = 0;
    w->lowest = 0;
    for (int i = 0; i < v->corners; i++) {
        w->weight[i] = (double)volume[i] / (double)sum;
        zeros += volume[i] == 0;
        w->lowest = volume[i] < volume[w->lowest] ? i : w->lowest;
    }
    for (int i = v->corners; i < 4; i++)
        w->weight[i] = 0;
    w->touches = zeros > 0;
    return volume[w->lowest] >= 0;
}

/* Lean: from the sites, in doubles. False: not certain. */
__attribute__((noinline)) static bool weigh_sites(const struct probe_volume *v, size_t cell,
                                                  const double p[3], struct weights *w)
{
    double d[4][3], size = 0;
    for (int i = 0; i < 4; i++) {
        const double *s = volume_site(v, volume_vertex(v, cell, i));
        double most = 0;
        for (int k = 0; k < 3; k++) {
            d[i][k] = s[k] - p[k];
            most = fmax(most, fabs(d[i][k]));
        }
        size += most;
    }
    double ab[3], cd[3], volume[4] = {0};
    for (int k = 0; k < 3; k++) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        ab[k] = d[0][x] * d[1][y] - d[0][y] * d[1][x];
        cd[k] = d[2][x] * d[3][y] - d[2][y] * d[3][x];
    }
    for (int k = 0; k < 3; k++) {
        volume[0] += d[1][k] * cd[k];
        volume[1] -= d[0][k] * cd[k];
        volume[2] += d[3][k] * ab[k];
        volume[3] -= d[2][k] * ab[k];
    }
    /* Differences of whole numbers are exact; a sum of six products of three is off by less than 8
     * roundings of their sizes. */
    const double sum = volume[0] + volume[1] + volume[2] + volume[3],
                 error = 0x1p-49 * size * size * size;
    w->lowest = lowest_of(volume);
    w->touches = false;
    if (!(fabs(volume[w->lowest]) > error) || !(error < 0x1p-27 * sum))
        return false;
    for (int i = 0; i < 4; i++)
        w->weight[i] = volume[i] / sum;
    return true;
}

typedef double two __attribute__((vector_size(16)));

static inline two load_two(const double *from)
{
    two v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline two size_of(two v)
{
    typedef int64_t bits __attribute__((vector_size(16)));
    return (two)((bits)v & (bits){INT64_MAX, INT64_MAX});
}

static inline double least_of(double a, double b)
{
    return a < b ? a : b;
}

enum side { WITHIN, BEYOND, UNSURE };

/* From the planes, of corners 1 and 2 side by side. A plane's numbers are off by three roundings at
 * most, products by one more, sums of four by two; the weight of corner 0 by all of them. 16
 * roundings of the sum of all sizes bound that. */
static inline enum side weigh_planes(const struct volume_cell *cell, const double p[3],
                                     struct weights *w)
{
    const two x = load_two(cell->plane[0]) * p[0], y = load_two(cell->plane[1]) * p[1],
              z = load_two(cell->plane[2]) * p[2], c = load_two(cell->plane[3]);
    const double x3 = cell->plane[0][2] * p[0], y3 = cell->plane[1][2] * p[1],
                 z3 = cell->plane[2][2] * p[2], c3 = cell->plane[3][2];
    const two weight = (x + y) + (z + c),
              size = (size_of(x) + size_of(y)) + (size_of(z) + size_of(c));
    const double w3 = (x3 + y3) + (z3 + c3), size3 = (fabs(x3) + fabs(y3)) + (fabs(z3) + fabs(c3));
    const double w0 = 1 - (weight[0] + weight[1] + w3),
                 error = 0x1p-49 * (1 + size[0] + size[1] + size3);
    const double least = least_of(least_of(w0, weight[0]), least_of(weight[1], w3));
    const two low = {w0, weight[0]}, high = {weight[1], w3};
    memcpy(w->weight, &low, sizeof low); /* two at a time, as they are read again */
    memcpy(w->weight + 2, &high, sizeof high);
    w->touches = false;
    /* certain, and as right as light in floats can show */
    if (!(fabs(least) > error && error < 0x1p-27))
        return UNSURE;
    if (least > 0)
        return WITHIN;
    w->lowest = lowest_of(w->weight);
    return BEYOND;
}

/* Whether the cell holds p; if not, p is strictly beyond the facet opposite the lowest corner.
 * ready: the cell, or NULL where there are no such. */
static inline __attribute__((always_inline)) bool weigh(const struct probe_volume *v,
                                                        const struct volume_cell *ready,
                                                        size_t cell, const double p[3],
                                                        struct weights *w)
{
    const enum side side = ready ? weigh_planes(ready, p, w) : UNSURE;
    if (side != UNSURE)
        return side == WITHIN;
    if (!ready && v->corners == 4 && weigh_sites(v, cell, p, w))
        return w->weight[w->lowest] > 0;
    return weigh_exactly(v, cell, p, w);
}

/* -- searching -------------------------------------------------------------------------------- */

struct search {
    const struct probe_volume *volume;
    const double *p;
    double square; /* of the distance within which boxes are opened: 0, then below it */
    size_t cell;
    struct weights weights;
};

static void try_cell(void *context, size_t cell)
{
    struct search *s = context;
    struct weights w;
    struct volume_cell own;
    const struct volume_cell *ready = s->volume->cell ? volume_ready(s->volume, cell, &own) : NULL;
    if (s->square < 0 || !weigh(s->volume, ready, cell, s->p, &w))
        return;
    s->cell = cell;
    s->weights = w;
    s->square = -1;
}

/* The first cell that holds p, in the tree's order. */
static bool search_tree(const struct probe_volume *v, const double p[3], size_t *cell,
                        struct weights *w)
{
    struct search s = {.volume = v, .p = p};
    volume_tree_search(&v->cell_tree, p, &s.square, try_cell, &s);
    if (s.square >= 0)
        return false;
    *cell = s.cell;
    *w = s.weights;
    return true;
}

/* One point on its way. */
struct walker {
    double exactly[3], p[3]; /* lattice coordinates, and rounded or projected */
    double far;              /* beyond reach: how far, scene units; else 0 */
    size_t cell;
    int steps;
    struct weights weights;
};

enum walker_state {
    WALKING,
    INSIDE,
    OUTSIDE,
    LEFT /* through the hull, but it may go on elsewhere */
};

/* The coordinates of any point; false: outside the box of all sites. */
__attribute__((noinline)) static bool begin_anywhere(const struct probe_volume *v,
                                                     const double point[3], struct walker *w)
{
    bool within = !v->bent;
    w->far = coordinates_of(v, point, w->exactly);
    if (v->corners < 4 && within) {
        const double *low = v->flat ? v->flat_low : v->low,
                     *high = v->flat ? v->flat_high : v->high;
        project(v, w->exactly, w->p);
        for (int j = 0; j < v->corners - 1; j++)
            within = within && w->p[v->axis[j]] >= low[v->axis[j]] &&
                     w->p[v->axis[j]] <= high[v->axis[j]];
    } else if (within) {
        round_to_lattice(v, point, w->p);
        for (int k = 0; k < 3; k++)
            within = within && w->p[k] >= v->low[k] && w->p[k] <= v->high[k];
    }
    return within;
}

/* A cell near a place, without a walk. */
static size_t near_cell(const struct probe_volume *v, const double p[3])
{
    const int32_t start = v->start ? v->start[volume_start_box(v, p)] : -1;
    return start >= 0 ? (size_t)start : volume_tree_near(&v->cell_tree, p);
}

/* false: outside, without a walk. cell: where the walk begins; v->cells: anywhere. */
static inline bool begin(const struct probe_volume *v, const double point[3], size_t cell,
                         struct walker *w)
{
    const double x = point[0] * v->scale - v->shift[0], y = point[1] * v->scale - v->shift[1],
                 z = point[2] * v->scale - v->shift[2];
    bool within = fabs(x - v->middle[0]) <= v->half[0] && fabs(y - v->middle[1]) <= v->half[1] &&
                  fabs(z - v->middle[2]) <= v->half[2];
    if (within && v->corners == 4 && v->near) { /* nearly always */
        w->exactly[0] = x;
        w->exactly[1] = y;
        w->exactly[2] = z;
        w->far = 0;
        round_to_lattice(v, point, w->p);
    } else {
        within = begin_anywhere(v, point, w);
    }
    w->steps = 0;
    w->cell = cell < v->cells || !within ? cell : near_cell(v, w->p);
    return within;
}

/* after so many, the last point was not near, and the walk begins anew from nearer by */
enum { STEPS_NEAR = 4 };

/* Looks at the cell that the walker is in, and moves it on. */
static inline enum walker_state step(const struct probe_volume *v, struct walker *w)
{
    struct volume_cell own;
    const struct volume_cell *ready = v->cell ? volume_ready(v, w->cell, &own) : NULL;
    if (weigh(v, ready, w->cell, w->p, &w->weights)) {
        if (w->weights.touches)
            search_tree(v, w->p, &w->cell, &w->weights);
        return INSIDE;
    }
    const int32_t next = ready ? ready->neighbour[w->weights.lowest]
                               : volume_neighbour(v, w->cell, w->weights.lowest);
    if (next >= 0 && w->steps++ < v->steps_most) {
        w->cell = w->steps == STEPS_NEAR ? near_cell(v, w->p) : (size_t)next;
        return WALKING;
    }
    if (next < 0 && (v->convex || v->rays))
        return v->convex ? OUTSIDE : LEFT;
    return search_tree(v, w->p, &w->cell, &w->weights) ? INSIDE : OUTSIDE;
}

static inline void arrive(const struct probe_volume *v, struct walker *w, enum walker_state state,
                          struct probe_place *place)
{
    if (v->bent)
        place->inside = !volume_outer(v, w->exactly, place);
    else
        place->inside = state == INSIDE ||
                        (state != INSIDE && !volume_outer(v, w->exactly, place) && state == LEFT &&
                         search_tree(v, w->p, &w->cell, &w->weights));
    if (place->inside) {
        place->distance = 0;
        if (!v->bent)
            volume_place(v, w->cell, w->weights.weight, place);
    } else if (w->far > 0) {
        place->distance = w->far;
    }
    if (v->sight && place->inside)
        volume_see(v, place);
    else if (v->sight)
        volume_see_outside(v, w->exactly, place);
}

/* Finds a point that is certainly within a cell: nearly every one of a path, in that of the last.
 * Whatever is not finite is nowhere. */
static inline bool still_within(const struct probe_volume *v, const double point[3], size_t cell,
                                struct probe_place *place)
{
    struct weights w;
    struct volume_cell own;
    double p[3];
    if (!v->cell || !v->near || cell >= v->cells)
        return false;
    round_to_lattice(v, point, p);
    if (weigh_planes(volume_ready(v, cell, &own), p, &w) != WITHIN)
        return false;
    place->inside = 1;
    place->distance = 0;
    volume_place(v, cell, w.weight, place);
    if (v->sight)
        volume_see(v, place);
    return true;
}

static inline bool finite_point(const double p[3])
{
    return fabs(p[0]) < INFINITY && fabs(p[1]) < INFINITY && fabs(p[2]) < INFINITY;
}

/* The internal number of the cell of a place; v->cells: none. */
static inline size_t cell_of(const struct probe_volume *v, const struct probe_place *place)
{
    if (place->cell < 0 || (size_t)place->cell >= v->cells)
        return v->cells;
    return v->inner ? (size_t)v->inner[place->cell] : (size_t)place->cell;
}

/* Walks to a point from a cell, or from anywhere (v->cells). *cell becomes the last one. Returns
 * how many steps it took. */
static int walk_from(const struct probe_volume *v, const double point[3], size_t *cell,
                     struct probe_place *place)
{
    struct walker w;
    enum walker_state state = begin(v, point, *cell, &w) ? WALKING : OUTSIDE;
    while (state == WALKING)
        state = step(v, &w);
    arrive(v, &w, state, place);
    *cell = w.cell;
    return w.steps;
}

enum probe_status probe_volume_locate(const struct probe_volume *v, const double point[3],
                                      struct probe_place *place)
{
    size_t cell = cell_of(v, place);
    if (still_within(v, point, cell, place))
        return PROBE_OK;
    if (!finite_point(point))
        return PROBE_BAD_POINT;
    walk_from(v, point, &cell, place);
    return PROBE_OK;
}

/* -- many points ------------------------------------------------------------------------------ */

/* One point after the other, as long as each is near the one before. Returns how many that were;
 * *cell is the last one's. */
static size_t locate_along(const struct probe_volume *v, size_t count, const double *point,
                           size_t stride, size_t *cell, struct probe_place *place)
{
    for (size_t i = 0; i < count; i++) {
        if (still_within(v, point + stride * i, *cell, &place[i]))
            continue;
        if (walk_from(v, point + stride * i, cell, &place[i]) >= STEPS_NEAR && i)
            return i + 1;
        const struct volume_cell *last = *cell < v->cells ? volume_made(v, *cell) : NULL;
        for (int k = 0; k < 4 && last; k++) { /* one of these is the next */
            const int32_t next = last->neighbour[k];
            if (next >= 0) {
                __builtin_prefetch(&v->cell[next]);
                __builtin_prefetch(v->cell[next].vertex);
            }
        }
    }
    return count;
}

/* Walks of several points take turns: one goes on until it needs a cell that it has not seen, asks
 * memory for it, and the others go on meanwhile. */
static void locate_in_turns(const struct probe_volume *v, size_t count, const double *point,
                            size_t stride, const uint32_t *order, size_t start,
                            struct probe_place *place)
{
    enum { LANES = 8 };
    struct walker walker[LANES];
    size_t at[LANES], end[LANES], open = 0;
    bool begun[LANES] = {false};
    for (size_t lane = 0; lane < LANES; lane++) {
        at[lane] = count * lane / LANES;
        end[lane] = count * (lane + 1) / LANES;
        walker[lane].cell = start;
        open += at[lane] < end[lane];
    }
    while (open)
        for (size_t lane = 0; lane < LANES; lane++) {
            struct walker *w = &walker[lane];
            while (at[lane] < end[lane]) {
                const double *const p = point + stride * (order ? order[at[lane]] : at[lane]);
                enum walker_state state = WALKING;
                if (!begun[lane])
                    state = begin(v, p, w->cell, w) ? WALKING : OUTSIDE;
                begun[lane] = true;
                if (state == WALKING)
                    state = step(v, w);
                if (state == WALKING) {
                    if (v->cell) {
                        __builtin_prefetch(&v->cell[w->cell]);
                        __builtin_prefetch(v->cell[w->cell].vertex);
                    }
                    break;
                }
                arrive(v, w, state, &place[at[lane]]);
                begun[lane] = false;
                open -= ++at[lane] == end[lane];
            }
        }
}

enum probe_status probe_volume_locate_many(const struct probe_volume *v, size_t count,
                                           const double *point, size_t stride,
                                           const uint32_t *order, struct probe_place *place)
{
    for (size_t i = 0; i < count; i++)
        if (!finite_point(point + stride * (order ? order[i] : i)))
            return PROBE_BAD_POINT;
    size_t cell = count ? cell_of(v, &place[0]) : v->cells;
    const size_t along = order ? 0 : locate_along(v, count, point, stride, &cell, place);
    locate_in_turns(v, count - along, point + stride * along, stride, order, cell, place + along);
    return PROBE_OK;
}

void probe_volume_order(const struct probe_volume *v, size_t count, const double *point,
                        size_t stride, uint32_t *order, uint64_t *room)
{
    /* 33 bits are three passes; a cell of 1/2048 of the box is fine enough to keep cells in the
     * cache */
    enum { BITS = 11 };
    const double top = (1 << BITS) - 1;
    double extent = 1;
    for (int k = 0; k < 3; k++)
        extent = fmax(extent, v->high[k] - v->low[k]);
    uint64_t *key = room;
    for (size_t i = 0; i < count; i++) {
        double p[3];
        uint32_t x[3];
        volume_coordinates(v, point + stride * i, p);
        for (int k = 0; k < 3; k++) {
            const double at = (p[k] - v->low[k]) * (top / extent);
            x[k] = at >= 0 ? at < top ? (uint32_t)at : (uint32_t)top : 0; /* NaN is somewhere */
        }
        key[i] = volume_morton(x, BITS);
    }
    volume_sort(count, key, 3 * BITS, order, room + count);
}

int probe_volume_scattered(const struct probe_volume *v, size_t count, const double *point,
                           size_t stride)
{
    enum { SAMPLES = 64, CELLS = 8 }; /* steps of more than 8 cells */
    double extent[3], volume = 1, cell;
    for (int k = 0; k < 3; k++) {
        extent[k] = v->high[k] - v->low[k];
        volume *= extent[k] > 1 ? extent[k] : 1;
    }
    cell = cbrt(volume / (double)v->cells) * CELLS;
    size_t far = 0, steps = 0;
    for (size_t i = 0; i + 1 < count; i += 1 + count / SAMPLES) {
        double a[3], b[3], square = 0;
        volume_coordinates(v, point + stride * i, a);
        volume_coordinates(v, point + stride * (i + 1), b);
        for (int k = 0; k < 3; k++)
            square += (a[k] - b[k]) * (a[k] - b[k]);
        far += square > cell * cell;
        steps++;
    }
    return 2 * far > steps;
}
