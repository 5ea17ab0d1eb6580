/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/discs.h"
#include "base/array.h"
#include "base/error.h"
#include "math/box.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    CELLS_EACH = 64, /* cells a point, at the most */
    SHELLS = 3       /* of cells, in which a disc is looked for where none covers a place */
};

/* A cell is this share of the discs' mean radius: smaller ones have shorter lists, but more. */
#define CELL_SHARE 0.5

/* Cosine of the angle up to which two sides face alike. */
#define ALIKE 0.5f

/* 32 bytes. Positions are less the origin of the grid, so that floats hold them well. */
struct disc {
    float position[3], normal[3];
    float radius;
    uint32_t point; /* whose value it has */
};

struct discs {
    struct disc *disc; /* owned, in order of the cells that they are in; and so is: */
    uint32_t *list;    /* discs by cell */
    uint32_t *start;   /* of each cell's, and the end of the last */
    size_t count;
    double origin[3], scale; /* cells a unit */
    int32_t cells[3];
    float most; /* radius of the largest disc, in cells */
};

static size_t cell_number(const struct discs *d, const int32_t cell[3])
{
    return ((size_t)cell[2] * (size_t)d->cells[1] + (size_t)cell[1]) * (size_t)d->cells[0] +
           (size_t)cell[0];
}

/* -- making ------------------------------------------------------------------------------------ */

/* Sets the grid: cells by the mean radius, unless that makes too many. */
static struct error *set_grid(struct discs *d, const struct disc_points *points)
{
    struct box box = box_empty();
    double sum = 0, side[3];
    for (size_t i = 0; i < points->count; i++) {
        const double r = (double)points->radius[i], *p = points->position + 3 * i;
        if (!(r > 0))
            continue;
        const double low[3] = {p[0] - r, p[1] - r, p[2] - r},
                     high[3] = {p[0] + r, p[1] + r, p[2] + r};
        box_add(&box, low);
        box_add(&box, high);
        sum += r;
        d->count++;
    }
    if (!d->count)
        return error_new("no surface probe has irradiance: run probe-capture");
    for (int k = 0; k < 3; k++)
        if (!(box.high[k] - box.low[k] < (double)INFINITY))
            return error_new("surface probes are too far from one another for discs");
    double cell = CELL_SHARE * sum / (double)d->count, cells = INFINITY;
    for (;; cell *= 1.1) {
        cells = 1;
        for (int k = 0; k < 3; k++) {
            side[k] = floor((box.high[k] - box.low[k]) / cell) + 1;
            cells *= side[k];
        }
        if (cells <= 4096 + CELLS_EACH * (double)d->count)
            break;
    }
    for (int k = 0; k < 3; k++) {
        d->cells[k] = (int32_t)side[k];
        d->origin[k] = box.low[k];
    }
    d->scale = 1 / cell;
    return array_create(&d->start, (size_t)cells + 1, sizeof *d->start);
}

struct sorting {
    size_t cell;
    uint32_t point;
};

static int compare(const void *a, const void *b)
{
    const struct sorting *x = a, *y = b;
    return x->cell != y->cell ? (x->cell > y->cell ? 1 : -1)
                              : (x->point > y->point) - (x->point < y->point);
}

/* The cell of a place in cells from the origin, within the grid. */
static void cell_of(const struct discs *d, const float p[3], int32_t cell[3])
{
    for (int k = 0; k < 3; k++) {
        const int32_t most = d->cells[k] - 1;
        cell[k] = p[k] > 0 ? p[k] < (float)most ? (int32_t)p[k] : most : 0;
    }
}

static void to_cells(const struct discs *d, const double p[3], float in_cells[3])
{
    for (int k = 0; k < 3; k++)
        in_cells[k] = (float)((p[k] - d->origin[k]) * d->scale);
}

/* Streams of other programs may have normals of any length. One without faces nowhere. */
static void set_normal(struct disc *disc, const float normal[3])
{
    const double x = (double)normal[0], y = (double)normal[1], z = (double)normal[2],
                 length = sqrt(x * x + y * y + z * z);
    for (int k = 0; k < 3; k++)
        disc->normal[k] = length > 0 ? (float)((double)normal[k] / length) : 0;
}

/* Lengths of discs are in cells. */
static struct error *sort_discs(struct discs *d, const struct disc_points *points)
{
    struct sorting *order = NULL;
    size_t count = 0;
    struct error *err = array_create(&order, d->count, sizeof *order);
    if (!err)
        err = array_create(&d->disc, d->count, sizeof *d->disc);
    for (size_t i = 0; i < points->count && !err; i++) {
        float p[3];
        int32_t cell[3];
        if (!(points->radius[i] > 0))
            continue;
        to_cells(d, points->position + 3 * i, p);
        cell_of(d, p, cell);
        order[count++] = (struct sorting){cell_number(d, cell), (uint32_t)i};
    }
    if (!err)
        qsort(order, count, sizeof *order, compare);
    for (size_t i = 0; i < count && !err; i++) {
        const uint32_t point = order[i].point;
        struct disc *disc = &d->disc[i];
        to_cells(d, points->position + 3 * (size_t)point, disc->position);
        set_normal(disc, points->normal + 3 * (size_t)point);
        disc->radius = (float)((double)points->radius[point] * d->scale);
        disc->point = point;
        d->most = disc->radius > d->most ? disc->radius : d->most;
    }
    free(order);
    return err;
}

/* Whether any of a cell may be nearer than the radius. */
static bool touches(const struct disc *disc, const int32_t cell[3])
{
    float square = 0;
    for (int k = 0; k < 3; k++) {
        const float low = (float)cell[k] - disc->position[k], high = -low - 1,
                    off = low > high ? low : high;
        square += off > 0 ? off * off : 0;
    }
    return square <= disc->radius * disc->radius;
}

/* The cells of a column along an axis that come as near to the disc's plane as what it covers: from
 * low to high at the most. cell: the column's, but for the axis. */
static void near_plane(const struct disc *disc, int axis, const int32_t cell[3], int32_t *low,
                       int32_t *high)
{
    const float *n = disc->normal, *p = disc->position;
    float height = 0, room = 1e-3f + disc->radius / 4;
    for (int k = 0; k < 3; k++) {
        height += k == axis ? 0 : ((float)cell[k] + 0.5f - p[k]) * n[k];
        room += 0.5f * fabsf(n[k]);
    }
    /* |height + (c + 1/2 - p) n| <= room */
    const float middle = p[axis] - 0.5f - height / n[axis], reach = room / fabsf(n[axis]);
    const float first = ceilf(middle - reach), last = floorf(middle + reach);
    *low = first > (float)*low ? (int32_t)first : *low;
    *high = last < (float)*high ? (int32_t)last : *high;
}

/* Counts the cells of each disc, or lists it in them. */
static void enter(struct discs *d, uint32_t number, bool list)
{
    const struct disc *disc = &d->disc[number];
    const float *p = disc->position, *n = disc->normal;
    int32_t low[3], high[3], cell[3];
    int axis = fabsf(n[1]) > fabsf(n[0]) ? 1 : 0;
    if (fabsf(n[2]) > fabsf(n[axis]))
        axis = 2;
    const int second = (axis + 1) % 3, third = (axis + 2) % 3;
    /* as much wider as rounding could be */
    const float wide = disc->radius + 1e-3f;
    cell_of(d, (const float[3]){p[0] - wide, p[1] - wide, p[2] - wide}, low);
    cell_of(d, (const float[3]){p[0] + wide, p[1] + wide, p[2] + wide}, high);
    for (cell[third] = low[third]; cell[third] <= high[third]; cell[third]++)
        for (cell[second] = low[second]; cell[second] <= high[second]; cell[second]++) {
            int32_t from = low[axis], to = high[axis];
            near_plane(disc, axis, cell, &from, &to);
            for (cell[axis] = from; cell[axis] <= to; cell[axis]++) {
                if (!touches(disc, cell))
                    continue;
                uint32_t *start = &d->start[cell_number(d, cell)];
                if (list)
                    d->list[--*start] = number;
                else
                    ++*start;
            }
        }
}

static struct error *list_discs(struct discs *d)
{
    const size_t cells = (size_t)d->cells[0] * (size_t)d->cells[1] * (size_t)d->cells[2];
    uint64_t sum = 0;
    for (uint32_t i = 0; i < d->count; i++)
        enter(d, i, false);
    for (size_t i = 0; i <= cells; i++) {
        sum += d->start[i];
        if (sum > UINT32_MAX)
            return error_new("discs are so large beside the distance of their points that they "
                             "touch more than %u cells: expected a smaller --radius",
                             UINT32_MAX);
        d->start[i] = (uint32_t)sum; /* the end; entering makes it the start */
    }
    struct error *err = array_create(&d->list, (size_t)sum, sizeof *d->list);
    for (uint32_t i = (uint32_t)d->count; i-- > 0 && !err;)
        enter(d, i, true);
    return err;
}

struct error *discs_create(struct discs **discs, const struct disc_points *points)
{
    struct discs *d = NULL;
    *discs = NULL;
    struct error *err = array_create(&d, 1, sizeof *d);
    if (!err)
        err = set_grid(d, points);
    if (!err)
        err = sort_discs(d, points);
    if (!err)
        err = list_discs(d);
    if (err)
        discs_destroy(d);
    else
        *discs = d;
    return err;
}

void discs_destroy(struct discs *d)
{
    if (!d)
        return;
    free(d->disc);
    free(d->list);
    free(d->start);
    free(d);
}

/* -- asking ------------------------------------------------------------------------------------ */

struct place {
    float p[3], n[3];
};

/* How much larger a disc would have to be to cover the place with its rim: below 1, it does.
 * Infinity: it faces elsewhere. */
static float rim(const struct disc *disc, const struct place *at)
{
    const float x = at->p[0] - disc->position[0], y = at->p[1] - disc->position[1],
                z = at->p[2] - disc->position[2];
    const float facing = at->n[0] * disc->normal[0] + at->n[1] * disc->normal[1] +
                         at->n[2] * disc->normal[2];
    if (!(facing > ALIKE))
        return INFINITY;
    const float height = fabsf(x * disc->normal[0] + y * disc->normal[1] + z * disc->normal[2]),
                distance = sqrtf(x * x + y * y + z * z);
    return (distance > 4 * height ? distance : 4 * height) / disc->radius;
}

static float weight_of(const struct disc *disc, const struct place *at, int falloff)
{
    const float x = at->p[0] - disc->position[0], y = at->p[1] - disc->position[1],
                z = at->p[2] - disc->position[2];
    const float facing = at->n[0] * disc->normal[0] + at->n[1] * disc->normal[1] +
                         at->n[2] * disc->normal[2],
                square = x * x + y * y + z * z, radius = disc->radius;
    if (!(facing > ALIKE) || !(square < radius * radius))
        return 0;
    const float height = fabsf(x * disc->normal[0] + y * disc->normal[1] + z * disc->normal[2]);
    if (!(4 * height < radius))
        return 0;
    const float c = 1 - sqrtf(square) / radius, fall = falloff == 1   ? c
                                                       : falloff == 2 ? c * c
                                                                      : c * c * c;
    return fall * (1 - 4 * height / radius) * (2 * facing - 1);
}

/* The best of those that do not cover the place. */
struct best {
    float rim;
    uint32_t disc; /* UINT32_MAX: none */
};

static void try_disc(const struct discs *d, uint32_t i, const struct place *at, struct best *best)
{
    const float r = rim(&d->disc[i], at);
    if (r < best->rim || (r <= best->rim && i < best->disc && r < INFINITY))
        *best = (struct best){r, i};
}

static void try_cell(const struct discs *d, const int32_t cell[3], const struct place *at,
                     struct best *best)
{
    for (int k = 0; k < 3; k++)
        if (cell[k] < 0 || cell[k] >= d->cells[k])
            return;
    const size_t number = cell_number(d, cell);
    for (uint32_t i = d->start[number]; i < d->start[number + 1]; i++)
        try_disc(d, d->list[i], at, best);
}

/* A disc of radius R that touches none of the cells up to a distance would have to be larger by
 * more than distance / R. Who is not found near by is looked for among all. */
static struct best find_best(const struct discs *d, const struct place *at)
{
    struct best best = {INFINITY, UINT32_MAX};
    int32_t middle[3], cell[3];
    float outside = 0;
    cell_of(d, at->p, middle);
    for (int k = 0; k < 3; k++) {
        outside = fmaxf(outside, -at->p[k]);
        outside = fmaxf(outside, at->p[k] - (float)d->cells[k]);
    }
    for (int32_t s = 0; s <= SHELLS && outside <= 0; s++) {
        for (cell[2] = middle[2] - s; cell[2] <= middle[2] + s; cell[2]++)
            for (cell[1] = middle[1] - s; cell[1] <= middle[1] + s; cell[1]++)
                for (cell[0] = middle[0] - s; cell[0] <= middle[0] + s; cell[0]++)
                    if (abs(cell[0] - middle[0]) == s || abs(cell[1] - middle[1]) == s ||
                        abs(cell[2] - middle[2]) == s)
                        try_cell(d, cell, at, &best);
        if (best.rim <= 1 + (float)s / d->most)
            return best;
    }
    for (uint32_t i = 0; i < d->count; i++)
        try_disc(d, i, at, &best);
    return best;
}

enum discs_answer discs_blend(const struct discs *d, const double p[3], const double n[3],
                              int falloff, const float *value, size_t width, float *out)
{
    struct place at;
    int32_t cell[3];
    float sum = 0;
    to_cells(d, p, at.p);
    for (int k = 0; k < 3; k++)
        at.n[k] = (float)n[k];
    cell_of(d, at.p, cell);
    for (size_t k = 0; k < width; k++)
        out[k] = 0;
    const size_t number = cell_number(d, cell);
    for (uint32_t i = d->start[number]; i < d->start[number + 1]; i++) {
        const struct disc *disc = &d->disc[d->list[i]];
        const float weight = weight_of(disc, &at, falloff), *v = value + width * disc->point;
        sum += weight;
        for (size_t k = 0; k < width && weight > 0; k++)
            out[k] += weight * v[k];
    }
    if (sum > 0) {
        for (size_t k = 0; k < width; k++)
            out[k] /= sum;
        return DISCS_COVERED;
    }
    const struct best best = find_best(d, &at);
    if (best.disc == UINT32_MAX)
        return DISCS_NONE;
    memcpy(out, value + width * d->disc[best.disc].point, width * sizeof *out);
    return DISCS_NEAREST;
}

/* The discs of the cell that a place is in, and the place as they have it. */
static const uint32_t *cell_at(const struct discs *d, const double p[3], const double n[3],
                               struct place *at, size_t *count)
{
    int32_t cell[3];
    to_cells(d, p, at->p);
    for (int k = 0; k < 3; k++)
        at->n[k] = (float)n[k];
    cell_of(d, at->p, cell);
    const size_t number = cell_number(d, cell);
    *count = d->start[number + 1] - d->start[number];
    return d->list + d->start[number];
}

static float fine_weight(const struct disc *disc, const struct place *at)
{
    return weight_of(disc, at, 1) / (disc->radius * disc->radius);
}

bool discs_cover(const struct discs *d, const double p[3], const double n[3], const float *value,
                 float out[3])
{
    struct place at;
    size_t count;
    float sum = 0;
    const uint32_t *list = cell_at(d, p, n, &at, &count);
    out[0] = out[1] = out[2] = 0;
    for (size_t i = 0; i < count; i++) {
        const struct disc *disc = &d->disc[list[i]];
        const float weight = fine_weight(disc, &at), *v = value + 3 * (size_t)disc->point;
        if (!(weight > 0))
            continue;
        sum += weight;
        for (int k = 0; k < 3; k++)
            out[k] += weight * v[k];
    }
    for (int k = 0; k < 3 && sum > 0; k++)
        out[k] /= sum;
    return sum > 0;
}

bool discs_covers(const struct discs *d, const double p[3], const double n[3])
{
    struct place at;
    size_t count;
    const uint32_t *list = cell_at(d, p, n, &at, &count);
    for (size_t i = 0; i < count; i++)
        if (weight_of(&d->disc[list[i]], &at, 1) > 0)
            return true;
    return false;
}

uint32_t discs_draw(const struct discs *d, const double p[3], const double n[3], float u)
{
    struct place at;
    size_t count;
    float sum = 0;
    uint32_t drawn = UINT32_MAX;
    const uint32_t *list = cell_at(d, p, n, &at, &count);
    for (size_t i = 0; i < count; i++) { /* from those so far, and what is left of u */
        const struct disc *disc = &d->disc[list[i]];
        const float weight = fine_weight(disc, &at);
        if (!(weight > 0))
            continue;
        sum += weight;
        const float share = weight / sum;
        if (u < share) {
            u /= share;
            drawn = disc->point;
        } else {
            u = (u - share) / (1 - share);
        }
    }
    return drawn;
}
