/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Edelsbrunner, "An acyclicity theorem for cell complexes in d dimensions", Combinatorica
 * 10, 1990. */
#include "tetra/peel.h"
#include "base/array.h"
#include "base/error.h"
#include "math/vec.h"
#include "tetra/sites.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A cell that may be peeled. */
struct candidate {
    double power; /* of the middle to its circumsphere: the highest goes first */
    int32_t cell;
};

struct peel {
    struct tetra *tetra;
    const double *site, *stretched;
    const int *axis;
    double flat;
    const double *spacing; /* of each site in a sheet, or 0; NULL: peel what is flat */
    double middle[3];      /* of all sites, whole numbers */
    struct vec3 stretched_middle;
    int32_t *facets; /* of each site: how many facets of the hull it is in */
    double *depth;   /* of each cell: how much has been peeled off above it */
    unsigned char *gone;
    struct candidate *heap;
    size_t waiting, room;
    int32_t *order; /* cells in the order they went */
    size_t peeled, order_room;
};

static struct vec3 at(const double *site, int32_t i)
{
    return vec3_load(site + 3 * (size_t)i);
}

/* -- shape ------------------------------------------------------------------------------------ */

/* The least altitude of a cell, and its content (six volumes, two areas). */
static double altitude(const struct peel *p, size_t cell, double *content)
{
    const int corners = p->tetra->corners;
    const int32_t *v = p->tetra->vertex + (size_t)corners * cell;
    const struct vec3 o = at(p->site, v[0]), a = vec3_sub(at(p->site, v[1]), o),
                      b = vec3_sub(at(p->site, v[2]), o);
    double base = 0;
    if (corners == 3) {
        *content = vec3_length(vec3_cross(a, b));
        base = fmax(fmax(vec3_length(a), vec3_length(b)), vec3_length(vec3_sub(a, b)));
    } else {
        const struct vec3 c = vec3_sub(at(p->site, v[3]), o);
        *content = fabs(vec3_dot(a, vec3_cross(b, c)));
        base = fmax(fmax(vec3_length(vec3_cross(a, b)), vec3_length(vec3_cross(b, c))),
                    fmax(vec3_length(vec3_cross(c, a)),
                         vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)))));
    }
    return base > 0 ? *content / base : 0;
}

static double shortest_edge(const struct peel *p, size_t cell)
{
    const int corners = p->tetra->corners;
    const int32_t *v = p->tetra->vertex + (size_t)corners * cell;
    double least = INFINITY;
    for (int i = 0; i < corners; i++)
        for (int j = i + 1; j < corners; j++)
            least = fmin(least, vec3_length(vec3_sub(at(p->site, v[i]), at(p->site, v[j]))));
    return least;
}

/* Whether the middle of all sites is strictly beyond a facet of a cell, seen from the cell. */
static bool middle_beyond(const struct peel *p, size_t cell, int facet)
{
    const int corners = p->tetra->corners;
    const double *corner[4] = {NULL};
    for (int i = 0; i < corners; i++)
        corner[i] = p->site + 3 * (size_t)p->tetra->vertex[(size_t)corners * cell + (size_t)i];
    const lattice_volume whole = sites_volume(corners, p->axis, corner);
    corner[facet] = p->middle;
    const lattice_volume there = sites_volume(corners, p->axis, corner);
    return whole > 0 ? there < 0 : there > 0;
}

/* The power of the middle of all sites to a cell's circumsphere (circle): minus the sum of its
 * barycentric coordinates times the squares of its distances from the corners. Coordinates are
 * exact and the same in both spaces, distances those of the stretched one. */
static double power_of_middle(const struct peel *p, size_t cell)
{
    const int corners = p->tetra->corners;
    const int32_t *v = p->tetra->vertex + (size_t)corners * cell;
    const double *corner[4] = {NULL};
    for (int i = 0; i < corners; i++)
        corner[i] = p->site + 3 * (size_t)v[i];
    const double volume = (double)sites_volume(corners, p->axis, corner);
    double sum = 0;
    for (int i = 0; i < corners; i++) {
        const double *const was = corner[i];
        corner[i] = p->middle;
        const struct vec3 way = vec3_sub(at(p->stretched, v[i]), p->stretched_middle);
        sum += (double)sites_volume(corners, p->axis, corner) * vec3_dot(way, way);
        corner[i] = was;
    }
    return -sum / volume;
}

static void find_middle(struct peel *p, size_t count)
{
    struct vec3 site = {0}, stretched = {0};
    for (size_t i = 0; i < count; i++) {
        site = vec3_fma(site, 1.0 / (double)count, at(p->site, (int32_t)i));
        stretched = vec3_fma(stretched, 1.0 / (double)count, at(p->stretched, (int32_t)i));
    }
    vec3_store(p->middle, site);
    for (int k = 0; k < 3; k++)
        p->middle[k] = rint(p->middle[k]);
    p->stretched_middle = stretched;
}

/* -- a heap of candidates ---------------------------------------------------------------------- */

/* The highest first; of equals, the first cell. */
static bool goes_before(struct candidate a, struct candidate b)
{
    return a.power != b.power ? a.power > b.power : a.cell < b.cell;
}

static struct error *push(struct peel *p, struct candidate c)
{
    struct error *err = array_reserve(&p->heap, &p->room, p->waiting + 1, sizeof *p->heap);
    if (err)
        return err;
    size_t i = p->waiting++;
    for (; i && goes_before(c, p->heap[(i - 1) / 2]); i = (i - 1) / 2)
        p->heap[i] = p->heap[(i - 1) / 2];
    p->heap[i] = c;
    return NULL;
}

static struct candidate pop(struct peel *p)
{
    const struct candidate top = p->heap[0], last = p->heap[--p->waiting];
    size_t i = 0;
    for (size_t child = 1; child < p->waiting; child = 2 * i + 1) {
        if (child + 1 < p->waiting && goes_before(p->heap[child + 1], p->heap[child]))
            child++;
        if (!goes_before(p->heap[child], last))
            break;
        p->heap[i] = p->heap[child];
        i = child;
    }
    p->heap[i] = last;
    return top;
}

/* Whether a cell of so small an altitude is noise on a sheet. */
static bool is_noise(const struct peel *p, size_t cell, double thin)
{
    const int32_t *v = p->tetra->vertex + 4 * cell;
    double longest = 0, spacing = 0;
    int of_sheet = 0;
    for (int i = 0; i < 4; i++) {
        spacing = fmax(spacing, p->spacing[v[i]]);
        of_sheet += p->spacing[v[i]] > 0;
        for (int j = 0; j < i; j++)
            longest = fmax(longest, vec3_length(vec3_sub(at(p->site, v[i]), at(p->site, v[j]))));
    }
    return of_sheet >= 3 && longest > PEEL_LONG * spacing && thin <= PEEL_SHALLOW * longest &&
           thin + p->depth[cell] <= spacing;
}

/* Puts a cell with a facet on the hull into the heap if it is flat, or noise. */
static struct error *consider(struct peel *p, size_t cell)
{
    double content;
    if (p->spacing)
        return is_noise(p, cell, altitude(p, cell, &content))
                   ? push(p, (struct candidate){power_of_middle(p, cell), (int32_t)cell})
                   : NULL;
    const double limit = p->flat * shortest_edge(p, cell), thin = altitude(p, cell, &content);
    if (thin > limit || thin + p->depth[cell] > PEEL_DEPTH * limit)
        return NULL;
    return push(p, (struct candidate){power_of_middle(p, cell), (int32_t)cell});
}

/* -- peeling ---------------------------------------------------------------------------------- */

/* Whether the edge of a tetrahedron between the corners i and j, which are opposite facets on the
 * hull, is on the hull elsewhere: goes around it, from cell to cell. */
static bool edge_on_hull(const struct tetra *t, size_t cell, int i, int j)
{
    const int32_t from = t->vertex[4 * cell + (size_t)i], to = t->vertex[4 * cell + (size_t)j];
    int leave = 0;
    while (leave == i || leave == j)
        leave++;
    size_t here = cell;
    for (size_t steps = 0; steps < t->cell_count; steps++) {
        const int32_t next = t->neighbour[4 * here + (size_t)leave];
        if (next < 0)
            return true;
        if ((size_t)next == cell)
            return false;
        const int back = tetra_facet_back(t, (size_t)next, here, leave);
        if (back < 0)
            return true;
        for (leave = 0; leave < 4; leave++) { /* the other facet that holds the edge */
            const int32_t v = t->vertex[4 * (size_t)next + (size_t)leave];
            if (leave != back && v != from && v != to)
                break;
        }
        here = (size_t)next;
    }
    return true;
}

static bool may_go(const struct peel *p, size_t cell)
{
    const struct tetra *t = p->tetra;
    const size_t first = (size_t)t->corners * cell;
    int open[4], count = 0;
    for (int i = 0; i < t->corners; i++)
        if (t->neighbour[first + (size_t)i] < 0)
            open[count++] = i;
        else if (!middle_beyond(p, cell, i))
            return false; /* the cell there lies behind this one, and is to go first */
    if (count == 1)
        return p->facets[t->vertex[first + (size_t)open[0]]] == 0;
    return count == 2 && t->corners == 4 && !edge_on_hull(t, cell, open[0], open[1]);
}

/* Counts facet i of a cell among those of the hull, or no more. */
static void count_facet(struct peel *p, size_t cell, int i, int change)
{
    const int corners = p->tetra->corners;
    for (int k = 0; k < corners; k++)
        if (k != i)
            p->facets[p->tetra->vertex[(size_t)corners * cell + (size_t)k]] += change;
}

static struct error *remove_cell(struct peel *p, size_t cell)
{
    struct tetra *t = p->tetra;
    const size_t first = (size_t)t->corners * cell;
    double content;
    const double depth = p->depth[cell] + altitude(p, cell, &content);
    struct error *err = array_reserve(&p->order, &p->order_room, p->peeled + 1, sizeof *p->order);
    if (err)
        return err;
    p->order[p->peeled++] = (int32_t)cell;
    p->gone[cell] = 1;
    for (int i = 0; i < t->corners; i++) {
        const int32_t other = t->neighbour[first + (size_t)i];
        if (other < 0)
            count_facet(p, cell, i, -1);
    }
    for (int i = 0; i < t->corners && !err; i++) {
        const int32_t other = t->neighbour[first + (size_t)i];
        const int back = other < 0 ? -1 : tetra_facet_back(t, (size_t)other, cell, i);
        if (back < 0)
            continue;
        t->neighbour[(size_t)t->corners * (size_t)other + (size_t)back] = -1;
        count_facet(p, (size_t)other, back, 1);
        p->depth[other] = fmax(p->depth[other], depth);
        err = consider(p, (size_t)other);
    }
    return err;
}

/* Puts back what was peeled, last first. */
static void put_back(struct peel *p)
{
    struct tetra *t = p->tetra;
    while (p->peeled) {
        const int32_t cell = p->order[--p->peeled];
        p->gone[cell] = 0;
        for (int i = 0; i < t->corners; i++) {
            const int32_t other = t->neighbour[(size_t)t->corners * (size_t)cell + (size_t)i];
            /* whose facet was opened: it is without a neighbour, and is this one */
            for (int j = 0; j < t->corners && other >= 0; j++) {
                int32_t *n = &t->neighbour[(size_t)t->corners * (size_t)other + (size_t)j];
                const int32_t was = *n;
                if (was >= 0)
                    continue;
                *n = cell;
                if (tetra_facet_back(t, (size_t)other, (size_t)cell, i) == j)
                    break;
                *n = was;
            }
        }
    }
}

/* Closes the gaps: the cells that stay keep their order. */
static struct error *close_ranks(struct peel *p)
{
    struct tetra *t = p->tetra;
    const size_t corners = (size_t)t->corners;
    int32_t *number = NULL; /* of each cell, what it becomes */
    struct error *err = array_create(&number, t->cell_count, sizeof *number);
    if (err)
        return err;
    size_t kept = 0;
    for (size_t cell = 0; cell < t->cell_count; cell++) {
        number[cell] = (int32_t)kept;
        if (p->gone[cell])
            continue;
        for (size_t i = 0; i < corners && kept < cell; i++) {
            t->vertex[corners * kept + i] = t->vertex[corners * cell + i];
            t->neighbour[corners * kept + i] = t->neighbour[corners * cell + i];
        }
        kept++;
    }
    for (size_t i = 0; i < corners * kept; i++)
        if (t->neighbour[i] >= 0)
            t->neighbour[i] = number[t->neighbour[i]];
    t->cell_count = kept;
    t->peeled += p->peeled;
    free(number);
    return NULL;
}

static double content_of(const struct peel *p, const int32_t *cells, size_t count)
{
    double sum = 0, content;
    for (size_t i = 0; i < count; i++) {
        altitude(p, cells ? (size_t)cells[i] : i, &content);
        sum += content;
    }
    return sum;
}

static struct error *run(struct peel *p)
{
    struct tetra *t = p->tetra;
    struct error *err = NULL;
    for (size_t cell = 0; cell < t->cell_count && !err; cell++) {
        bool open = false;
        for (int i = 0; i < t->corners; i++)
            if (t->neighbour[(size_t)t->corners * cell + (size_t)i] < 0) {
                count_facet(p, cell, i, 1);
                open = true;
            }
        err = open ? consider(p, cell) : NULL;
    }
    while (p->waiting && !err) {
        const struct candidate c = pop(p);
        if (!p->gone[c.cell] && may_go(p, (size_t)c.cell))
            err = remove_cell(p, (size_t)c.cell);
    }
    if (err || !p->peeled)
        return err;
    if (content_of(p, p->order, p->peeled) >
        content_of(p, NULL, t->cell_count) * (p->spacing ? PEEL_SHEETS : PEEL_HULL))
        put_back(p);
    else
        err = close_ranks(p);
    return err;
}

static struct error *peel(struct peel *p, size_t count)
{
    find_middle(p, count);
    struct error *err = array_create(&p->facets, count, sizeof *p->facets);
    if (!err)
        err = array_create(&p->depth, p->tetra->cell_count, sizeof *p->depth);
    if (!err)
        err = array_create(&p->gone, p->tetra->cell_count, 1);
    if (!err)
        err = run(p);
    free(p->facets);
    free(p->depth);
    free(p->gone);
    free(p->heap);
    free(p->order);
    return err;
}

struct error *peel_hull(struct tetra *tetra, size_t count, const double *site, const int axis[2],
                        const double *stretched, double flat)
{
    struct peel p = {
        .tetra = tetra, .site = site, .axis = axis, .stretched = stretched, .flat = flat};
    return peel(&p, count);
}

struct error *peel_sheets(struct tetra *tetra, size_t count, const double *site, const int axis[2],
                          const double *stretched, const double *spacing)
{
    struct peel p = {
        .tetra = tetra, .site = site, .axis = axis, .stretched = stretched, .spacing = spacing};
    return peel(&p, count);
}
