/* SPDX-License-Identifier: Apache-2.0 */
#include "discs.h"
#include "volume_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    CELLS_EACH = 64,     /* cells a point, at the most */
    SIDE_MOST = 1 << 16, /* cells along an axis, so that floats tell places in them */
    PATCHES = 5, /* classes of normals: those of a face of a cube, along each of its sides, */
    CLASSES = 6 * PATCHES * PATCHES, /* and all */
    RUN_MOST = 16,                   /* discs of a run */
    GROUP = 8,                       /* discs of a group */
    LEVELS = 32,                     /* of groups, at the most */
    SOME = 64,                       /* discs that are asked at a time */
    LINE = 16                        /* words of a cache line */
};

/* A cell is this share of the discs' mean radius: smaller ones have shorter lists, but more. */
#define CELL_SHARE 0.7

/* Cosine of the angle up to which two sides face alike. */
#define ALIKE 0.5f

/* Places farther out than this, in cells, count as that far. */
#define FAR_OUT 1e15

_Static_assert(sizeof(struct disc) == 32, "a disc is packed");

/* Normals that are near to one another. */
struct normals {
    float middle[3]; /* unit */
    float least;     /* cosine with it of what faces as any of them does */
};

/* Discs near to one another: a box about their middles, and the largest radius. */
struct group {
    float low[3], high[3], most;
};

/* The discs of a cell stand in `word` in runs of normals of one class, each behind a word that says
 * how many there are (times 256) and of which class. */
struct discs {
    const struct disc *disc; /* along a Morton curve */
    struct disc *own;        /* the same, where they are its own; owned, and so is: */
    uint32_t *word;          /* discs by cell, in runs */
    uint32_t *start;         /* where those of each cell begin, and the end of the last */
    size_t count, cell_count, words;
    struct discs_grid grid;
    struct normals normals[CLASSES];
    struct group *group;      /* owned */
    size_t level[LEVELS + 1]; /* where the groups of each begin, and the end of the last */
    int levels;
};

static size_t cell_number(const struct discs *d, const int32_t cell[3])
{
    return ((size_t)cell[2] * (size_t)d->grid.cells[1] + (size_t)cell[1]) *
               (size_t)d->grid.cells[0] +
           (size_t)cell[0];
}

/* -- normals ----------------------------------------------------------------------------------- */

/* The patch of the cube about it that a normal goes through. */
static uint32_t class_of(const float n[3])
{
    int axis = fabsf(n[1]) > fabsf(n[0]) ? 1 : 0;
    if (fabsf(n[2]) > fabsf(n[axis]))
        axis = 2;
    uint32_t number = 2 * (uint32_t)axis + (n[axis] < 0);
    for (int k = 1; k < 3; k++) {
        const float share = n[(axis + k) % 3] / fabsf(n[axis]),
                    at = (share + 1) / 2 * (float)PATCHES;
        number = number * PATCHES + (at > 0 ? at < PATCHES - 1 ? (uint32_t)at : PATCHES - 1 : 0);
    }
    return number;
}

static void patch_point(uint32_t number, double x, double y, double n[3])
{
    const uint32_t face = number / (PATCHES * PATCHES), axis = face / 2;
    const double u = 2 * (number / PATCHES % PATCHES + x) / PATCHES - 1,
                 v = 2 * (number % PATCHES + y) / PATCHES - 1, length = sqrt(1 + u * u + v * v);
    n[axis] = (face % 2 ? -1 : 1) / length;
    n[(axis + 1) % 3] = u / length;
    n[(axis + 2) % 3] = v / length;
}

/* The middle of a patch, and the widest angle with it of what is within 60 degrees of any of its
 * points, of which the farthest is a corner. */
static void set_classes(struct discs *d)
{
    for (uint32_t i = 0; i < CLASSES; i++) {
        double middle[3], corner[3], least = 1;
        patch_point(i, 0.5, 0.5, middle);
        for (int c = 0; c < 4; c++) {
            patch_point(i, c & 1, c >> 1, corner);
            least =
                fmin(least, middle[0] * corner[0] + middle[1] * corner[1] + middle[2] * corner[2]);
        }
        for (int k = 0; k < 3; k++)
            d->normals[i].middle[k] = (float)middle[k];
        d->normals[i].least = (float)(0.5 * least - sqrt(0.75) * sqrt(1 - least * least) - 1e-4);
    }
}

static float facing(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* -- making ------------------------------------------------------------------------------------ */

struct making {
    struct discs *d;
    const struct disc_points *points; /* NULL: discs are there */
    uint32_t *start, *list;           /* discs by cell; owned, and so is: */
    uint64_t *class;                  /* of each disc's normal */
    uint32_t *order;                  /* of discs by class */
};

static void *zeros(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

/* Room for cells, of which there are so many. */
static enum probe_status start_cells(struct making *m, double cells)
{
    m->d->cell_count = (size_t)cells;
    m->d->start = zeros(m->d->cell_count + 1, sizeof *m->d->start);
    m->start = zeros(m->d->cell_count + 1, sizeof *m->start);
    return m->d->start && m->start ? PROBE_OK : PROBE_NO_MEMORY;
}

/* Whether there are not too many for so many discs. */
static bool few_cells(double cells, double longest, size_t discs)
{
    return cells <= 4096 + CELLS_EACH * (double)discs && longest <= SIDE_MOST;
}

/* Sets the grid: cells by the mean radius, unless that makes too many. */
static enum probe_status set_grid(struct making *m)
{
    struct discs *d = m->d;
    const struct disc_points *points = m->points;
    double low[3], high[3], sum = 0, side[3];
    for (int k = 0; k < 3; k++) {
        low[k] = (double)INFINITY;
        high[k] = -(double)INFINITY;
    }
    for (size_t i = 0; i < points->count; i++) {
        const double r = (double)points->radius[i], *p = points->position + 3 * i;
        if (!(r > 0))
            continue;
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], p[k] - r);
            high[k] = fmax(high[k], p[k] + r);
        }
        sum += r;
        d->count++;
    }
    if (!d->count)
        return PROBE_NO_DISCS;
    for (int k = 0; k < 3; k++)
        if (!(high[k] - low[k] < (double)INFINITY))
            return PROBE_DISCS_APART;
    double cell = CELL_SHARE * sum / (double)d->count, cells, longest;
    for (;; cell *= 1.1) {
        cells = 1;
        longest = 0;
        for (int k = 0; k < 3; k++) {
            side[k] = floor((high[k] - low[k]) / cell) + 1;
            cells *= side[k];
            longest = fmax(longest, side[k]);
        }
        if (few_cells(cells, longest, d->count))
            break;
    }
    for (int k = 0; k < 3; k++) {
        d->grid.cells[k] = (int32_t)side[k];
        d->grid.origin[k] = low[k];
    }
    d->grid.scale = 1 / cell;
    return start_cells(m, cells);
}

/* The cell of a place in cells from the origin, within the grid. */
static void cell_of(const struct discs *d, const float p[3], int32_t cell[3])
{
    for (int k = 0; k < 3; k++) {
        const int32_t most = d->grid.cells[k] - 1;
        cell[k] = p[k] > 0 ? p[k] < (float)most ? (int32_t)p[k] : most : 0;
    }
}

static void to_cells(const struct discs *d, const double p[3], float in_cells[3])
{
    for (int k = 0; k < 3; k++) {
        const double x = (p[k] - d->grid.origin[k]) * d->grid.scale;
        in_cells[k] = (float)(x < FAR_OUT ? x > -FAR_OUT ? x : -FAR_OUT : FAR_OUT);
    }
}

/* Streams of other programs may have normals of any length. One without faces nowhere. */
static void set_normal(struct disc *disc, const float normal[3])
{
    const double x = (double)normal[0], y = (double)normal[1], z = (double)normal[2],
                 length = sqrt(x * x + y * y + z * z);
    for (int k = 0; k < 3; k++)
        disc->normal[k] = length > 0 ? (float)((double)normal[k] / length) : 0;
}

/* Makes discs of points, along a Morton curve. */
static enum probe_status sort_discs(struct making *m)
{
    enum { BITS = 17 };
    struct discs *d = m->d;
    const struct disc_points *points = m->points;
    uint64_t *key = zeros(4 * d->count, sizeof *key), *room = key ? key + d->count : NULL;
    uint32_t *order = zeros(2 * d->count, sizeof *order), *point = order ? order + d->count : NULL;
    d->own = volume_block(d->count * sizeof *d->own);
    const bool enough = key && order && d->own;
    size_t count = 0;
    for (size_t i = 0; i < points->count && enough; i++) {
        float p[3];
        int32_t cell[3];
        uint32_t x[3];
        if (!(points->radius[i] > 0))
            continue;
        to_cells(d, points->position + 3 * i, p);
        cell_of(d, p, cell);
        for (int k = 0; k < 3; k++)
            x[k] = (uint32_t)cell[k];
        point[count] = (uint32_t)i;
        key[count++] = volume_morton(x, BITS);
    }
    if (enough)
        volume_sort(count, key, 3 * BITS, order, room);
    for (size_t i = 0; i < count; i++) {
        const uint32_t from = point[order[i]];
        const double radius = (double)points->radius[from] * d->grid.scale;
        struct disc *disc = &d->own[i];
        to_cells(d, points->position + 3 * (size_t)from, disc->position);
        set_normal(disc, points->normal + 3 * (size_t)from);
        disc->inverse = (float)(1 / radius);
        disc->point = from;
    }
    d->disc = d->own;
    free(key);
    free(order);
    return enough ? PROBE_OK : PROBE_NO_MEMORY;
}

static enum probe_status sort_by_class(struct making *m)
{
    const size_t count = m->d->count;
    uint64_t *room = zeros(3 * count, sizeof *room);
    m->class = zeros(count, sizeof *m->class);
    m->order = zeros(count, sizeof *m->order);
    const bool enough = room && m->class && m->order;
    for (size_t i = 0; i < count && enough; i++)
        m->class[i] = class_of(m->d->disc[i].normal);
    if (enough)
        volume_sort(count, m->class, 8, m->order, room);
    free(room);
    return enough ? PROBE_OK : PROBE_NO_MEMORY;
}

/* As much wider as rounding could be. */
static float wide_radius(const struct disc *disc)
{
    return 1 / disc->inverse + 1e-3f;
}

/* Whether what the disc covers may come into a cell. */
static bool touches(const struct disc *disc, const int32_t cell[3])
{
    const float radius = wide_radius(disc);
    float square = 0;
    for (int k = 0; k < 3; k++) {
        const float below = (float)cell[k] - disc->position[k], above = -below - 1,
                    off = below > above ? below : above;
        square += off > 0 ? off * off : 0;
    }
    return square <= radius * radius;
}

/* The cells of a column along an axis that come as near to the disc's plane as what it covers: from
 * low to high at the most. cell: the column's, but for the axis. */
static void near_plane(const struct disc *disc, int axis, const int32_t cell[3], int32_t *low,
                       int32_t *high)
{
    const float *n = disc->normal, *p = disc->position;
    float height = 0, room = 1e-3f + wide_radius(disc) / 4;
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
static void enter(struct making *m, uint32_t number, bool list)
{
    const struct discs *d = m->d;
    const struct disc *disc = &d->disc[number];
    const float *p = disc->position, *n = disc->normal, wide = wide_radius(disc);
    int32_t low[3], high[3], cell[3];
    int axis = fabsf(n[1]) > fabsf(n[0]) ? 1 : 0;
    if (fabsf(n[2]) > fabsf(n[axis]))
        axis = 2;
    const int second = (axis + 1) % 3, third = (axis + 2) % 3;
    cell_of(d, (const float[3]){p[0] - wide, p[1] - wide, p[2] - wide}, low);
    cell_of(d, (const float[3]){p[0] + wide, p[1] + wide, p[2] + wide}, high);
    for (cell[third] = low[third]; cell[third] <= high[third]; cell[third]++)
        for (cell[second] = low[second]; cell[second] <= high[second]; cell[second]++) {
            int32_t from = low[axis], to = high[axis];
            near_plane(disc, axis, cell, &from, &to);
            for (cell[axis] = from; cell[axis] <= to; cell[axis]++) {
                if (!touches(disc, cell))
                    continue;
                uint32_t *start = &m->start[cell_number(d, cell)];
                if (list)
                    m->list[--*start] = number;
                else
                    ++*start;
            }
        }
}

/* Lists discs by cell; those of a cell by class, and then in their order. */
static enum probe_status list_discs(struct making *m)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < m->d->count; i++)
        enter(m, i, false);
    for (size_t i = 0; i <= m->d->cell_count; i++) {
        sum += m->start[i];
        if (sum > UINT32_MAX)
            return PROBE_DISCS_LARGE;
        m->start[i] = (uint32_t)sum; /* the end; entering makes it the start */
    }
    m->list = zeros((size_t)sum, sizeof *m->list);
    for (size_t i = m->d->count; i-- > 0 && m->list;)
        enter(m, m->order[i], true);
    return m->list ? PROBE_OK : PROBE_NO_MEMORY;
}

/* Writes what touches a cell in runs, to where `word` points, or nowhere. Returns how many words
 * that takes. */
static size_t write_runs(const struct making *m, size_t cell, uint32_t *word)
{
    size_t words = 0, run = 0;
    uint64_t class = 0;
    uint32_t count = 0; /* of the run */
    for (size_t i = m->start[cell]; i < m->start[cell + 1]; i++) {
        const uint32_t disc = m->list[i];
        if (!count || class != m->class[disc] || count == RUN_MOST) {
            class = m->class[disc];
            count = 0;
            run = words++;
        }
        count++;
        if (word) {
            word[run] = count << 8 | (uint32_t) class;
            word[words] = disc;
        }
        words++;
    }
    return words;
}

static enum probe_status write_cells(struct making *m)
{
    struct discs *d = m->d;
    uint64_t sum = 0;
    for (size_t i = 0; i < d->cell_count; i++) {
        d->start[i] = (uint32_t)sum;
        sum += write_runs(m, i, NULL);
        if (sum > UINT32_MAX)
            return PROBE_DISCS_LARGE;
    }
    d->start[d->cell_count] = (uint32_t)sum;
    d->words = (size_t)sum;
    d->word = volume_block(d->words * sizeof *d->word);
    for (size_t i = 0; i < d->cell_count && d->word; i++)
        write_runs(m, i, d->word + d->start[i]);
    return d->word ? PROBE_OK : PROBE_NO_MEMORY;
}

static void add_to_group(struct group *group, const float low[3], const float high[3], float most)
{
    for (int k = 0; k < 3; k++) {
        group->low[k] = fminf(group->low[k], low[k]);
        group->high[k] = fmaxf(group->high[k], high[k]);
    }
    group->most = fmaxf(group->most, most);
}

/* Level 0: GROUP discs each, which follow one another; each level above: two of the one below. */
static enum probe_status make_groups(struct discs *d)
{
    size_t count = (d->count + GROUP - 1) / GROUP;
    d->levels = 1;
    d->level[1] = count;
    while (count > 1) {
        count = (count + 1) / 2;
        d->levels++;
        d->level[d->levels] = d->level[d->levels - 1] + count;
    }
    d->group = zeros(d->level[d->levels], sizeof *d->group);
    if (!d->group)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < d->level[d->levels]; i++)
        d->group[i] =
            (struct group){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0};
    for (size_t i = 0; i < d->count; i++) {
        const struct disc *disc = &d->disc[i];
        add_to_group(&d->group[i / GROUP], disc->position, disc->position, 1 / disc->inverse);
    }
    for (int level = 1; level < d->levels; level++)
        for (size_t i = d->level[level - 1]; i < d->level[level]; i++) {
            const struct group *part = &d->group[i];
            add_to_group(&d->group[d->level[level] + (i - d->level[level - 1]) / 2], part->low,
                         part->high, part->most);
        }
    return PROBE_OK;
}

/* The rest, once there are discs and a grid; ends what was begun. */
static enum probe_status finish(struct making *m, enum probe_status status, struct discs **discs)
{
    if (!status) {
        set_classes(m->d);
        status = sort_by_class(m);
    }
    if (!status)
        status = list_discs(m);
    if (!status)
        status = write_cells(m);
    if (!status)
        status = make_groups(m->d);
    free(m->start);
    free(m->list);
    free(m->class);
    free(m->order);
    if (status)
        discs_destroy(m->d);
    else
        *discs = m->d;
    return status;
}

enum probe_status discs_make(struct discs **discs, const struct disc_points *points)
{
    struct making m = {.d = zeros(1, sizeof *m.d), .points = points};
    *discs = NULL;
    enum probe_status status = m.d ? set_grid(&m) : PROBE_NO_MEMORY;
    if (!status)
        status = sort_discs(&m);
    return finish(&m, status, discs);
}

/* Whether it is one in the grid, and the i-th of its list. *sum: of radii so far. */
static bool sane_disc(const struct discs_grid *grid, const struct disc *disc, size_t i, double *sum)
{
    const float length = facing(disc->normal, disc->normal);
    const double radius = 1 / (double)disc->inverse;
    bool sane = disc->point == i && (fabsf(length - 1) < 1e-3f || length == 0) && radius > 0 &&
                radius < (double)INFINITY;
    for (int k = 0; k < 3; k++)
        sane = sane && (double)disc->position[k] - radius > -0.1 &&
               (double)disc->position[k] + radius < grid->cells[k] + 0.1;
    *sum += radius;
    return sane;
}

enum probe_status discs_make_again(struct discs **discs, const struct disc *list, size_t count,
                                   const struct discs_grid *grid, size_t *row)
{
    double cells = 1, longest = 0, sum = 0;
    bool sane = count > 0 && count <= INT32_MAX && grid->scale > 0 &&
                grid->scale < (double)INFINITY;
    *discs = NULL;
    for (int k = 0; k < 3; k++) {
        cells *= grid->cells[k];
        longest = fmax(longest, grid->cells[k]);
        sane = sane && grid->cells[k] > 0 && fabs(grid->origin[k]) < (double)INFINITY;
    }
    if (!sane || !few_cells(cells, longest, count))
        return PROBE_BAD_IMAGE;
    for (*row = 0; *row < count; ++*row)
        if (!sane_disc(grid, &list[*row], *row, &sum))
            return PROBE_BAD_DISC;
    *row = 0;
    if (!(sum * CELL_SHARE <= 1.01 * (double)count))
        return PROBE_BAD_IMAGE; /* cells are no smaller, so no disc is in too many */
    struct making m = {.d = zeros(1, sizeof *m.d)};
    if (!m.d)
        return PROBE_NO_MEMORY;
    m.d->disc = list;
    m.d->count = count;
    m.d->grid = *grid;
    return finish(&m, start_cells(&m, cells), discs);
}

const struct discs_grid *discs_grid_of(const struct discs *d)
{
    return &d->grid;
}

const struct disc *discs_list(const struct discs *d, size_t *count)
{
    *count = d->count;
    return d->disc;
}

size_t discs_bytes(const struct discs *d)
{
    return sizeof *d + (d->own ? volume_block_bytes(d->count * sizeof *d->own) : 0) +
           volume_block_bytes(d->words * sizeof *d->word) + (d->cell_count + 1) * sizeof *d->start +
           d->level[d->levels] * sizeof *d->group;
}

void discs_destroy(struct discs *d)
{
    if (!d)
        return;
    free(d->own);
    free(d->word);
    free(d->start);
    free(d->group);
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
    const float way[3] = {at->p[0] - disc->position[0], at->p[1] - disc->position[1],
                          at->p[2] - disc->position[2]};
    if (!(facing(at->n, disc->normal) > ALIKE))
        return INFINITY;
    const float height = fabsf(facing(way, disc->normal)), distance = sqrtf(facing(way, way));
    return (distance > 4 * height ? distance : 4 * height) * disc->inverse;
}

/* How far a place is from a disc's middle along its surface, in radii: what is off its plane, or
 * turned away, counts as farther, a sheet close behind by two radii. Infinity: it faces
 * elsewhere. */
static float off_surface(const struct disc *disc, const struct place *at)
{
    const float way[3] = {at->p[0] - disc->position[0], at->p[1] - disc->position[1],
                          at->p[2] - disc->position[2]},
                alike = facing(at->n, disc->normal);
    if (!(alike > ALIKE))
        return INFINITY;
    const float off = 64 * fabsf(facing(way, disc->normal)) * disc->inverse;
    return sqrtf(facing(way, way)) * disc->inverse + (off < 2 ? off : 2) + 2 * (1 - alike);
}

enum { FINE = 0 }; /* as a falloff: linear, and by 1 / R^2; nearer to the plane */

/* Discs that cover a place, some at a time. */
struct covering {
    const uint32_t *word, *end; /* of those that were not asked */
    uint32_t asked[SOME];
    size_t count;
    uint32_t point[SOME];
    float weight[SOME]; /* above 0 */
};

/* Adds a disc, if it covers the place. Without a branch: which of a cell's do, nobody foretells. */
static void add_covering(const struct discs *d, uint32_t number, const struct place *at,
                         int falloff, struct covering *c)
{
    const struct disc *disc = &d->disc[number];
    const float way[3] = {at->p[0] - disc->position[0], at->p[1] - disc->position[1],
                          at->p[2] - disc->position[2]},
                thin = falloff == FINE ? DISCS_FLAT : 4;
    const float near = 1 - sqrtf(facing(way, way)) * disc->inverse,
                flat = 1 - thin * fabsf(facing(way, disc->normal)) * disc->inverse,
                alike = 2 * facing(at->n, disc->normal) - 1,
                fall = falloff == 1   ? near
                       : falloff == 2 ? near * near
                       : falloff == 3 ? near * near * near
                                      : near * disc->inverse * disc->inverse;
    const float weight = fall * flat * alike;
    c->point[c->count] = disc->point;
    c->weight[c->count] = weight;
    c->count += (size_t)((near > 0) & (flat > 0) & (alike > 0) & (weight > 0));
}

static size_t cell_at(const struct discs *d, const struct place *at)
{
    int32_t cell[3];
    cell_of(d, at->p, cell);
    return cell_number(d, cell);
}

static struct covering covering_start(const struct discs *d, const struct place *at)
{
    const size_t cell = cell_at(d, at);
    struct covering c;
    c.word = d->word + d->start[cell];
    c.end = d->word + d->start[cell + 1];
    c.count = 0;
    for (const uint32_t *word = c.word; word < c.end; word += LINE)
        __builtin_prefetch(word); /* all at once: walking the runs, one would wait for each */
    return c;
}

/* The next ones; false: there are no more. */
static bool cover(const struct discs *d, const struct place *at, int falloff, struct covering *c)
{
    const bool any = c->word < c->end;
    size_t asked = 0;
    while (c->word < c->end && asked + RUN_MOST <= SOME) {
        const uint32_t run = *c->word++, count = run >> 8;
        const struct normals *normals = &d->normals[run & 255];
        if (facing(at->n, normals->middle) > normals->least)
            for (uint32_t i = 0; i < count; i++) {
                c->asked[asked++] = c->word[i];
                __builtin_prefetch(&d->disc[c->word[i]]); /* as the words */
            }
        c->word += count;
    }
    c->count = 0;
    for (size_t i = 0; i < asked; i++)
        add_covering(d, c->asked[i], at, falloff, c);
    return any;
}

/* The best of those that do not cover the place. */
struct best {
    float rim;
    uint32_t disc; /* UINT32_MAX: none */
};

/* A search for it. */
struct search {
    const struct discs *d;
    const struct place *at;
    float (*rim)(const struct disc *disc, const struct place *at); /* at least the distance / R */
    struct best best;
};

/* None of a group's discs has a smaller rim. */
static float least_rim(const struct group *group, const struct place *at)
{
    float square = 0;
    for (int k = 0; k < 3; k++) {
        const float below = group->low[k] - at->p[k], above = at->p[k] - group->high[k],
                    off = below > above ? below : above;
        square += off > 0 ? off * off : 0;
    }
    return 0.9999f * sqrtf(square) / group->most;
}

static void try_disc(struct search *s, uint32_t i)
{
    const float r = s->rim(&s->d->disc[i], s->at);
    if (r < s->best.rim || (r <= s->best.rim && i < s->best.disc && r < INFINITY))
        s->best = (struct best){r, i};
}

/* Looks in the i-th group of a level, the nearer half first. */
static void try_group(struct search *s, int level, size_t i)
{
    const struct discs *d = s->d;
    if (least_rim(&d->group[d->level[level] + i], s->at) > s->best.rim)
        return;
    if (level) {
        const struct group *half = &d->group[d->level[level - 1] + 2 * i];
        const bool two = d->level[level - 1] + 2 * i + 1 < d->level[level];
        const size_t first = two && least_rim(half + 1, s->at) < least_rim(half, s->at);
        try_group(s, level - 1, 2 * i + first);
        if (two)
            try_group(s, level - 1, 2 * i + 1 - first);
        return;
    }
    for (size_t k = GROUP * i; k < GROUP * (i + 1) && k < d->count; k++)
        try_disc(s, (uint32_t)k);
}

static struct best find_best(const struct discs *d, const struct place *at,
                             float (*of)(const struct disc *disc, const struct place *at))
{
    struct search s = {d, at, of, {INFINITY, UINT32_MAX}};
    try_group(&s, d->levels - 1, 0);
    return s.best;
}

static struct place place_at(const struct discs *d, const double p[3], const double n[3])
{
    struct place at;
    to_cells(d, p, at.p);
    for (int k = 0; k < 3; k++)
        at.n[k] = (float)n[k];
    return at;
}

enum discs_answer discs_blend(const struct discs *d, const double p[3], const double n[3],
                              int falloff, const float *value, size_t width, float *out)
{
    const struct place at = place_at(d, p, n);
    struct covering c = covering_start(d, &at);
    float sum = 0;
    for (size_t k = 0; k < width; k++)
        out[k] = 0;
    while (cover(d, &at, falloff, &c))
        for (size_t i = 0; i < c.count; i++) {
            const float *v = value + width * c.point[i];
            sum += c.weight[i];
            for (size_t k = 0; k < width; k++)
                out[k] += c.weight[i] * v[k];
        }
    if (sum > 0) {
        for (size_t k = 0; k < width; k++)
            out[k] /= sum;
        return DISCS_COVERED;
    }
    const struct best best = find_best(d, &at, rim);
    if (best.disc == UINT32_MAX)
        return DISCS_NONE;
    memcpy(out, value + width * d->disc[best.disc].point, width * sizeof *out);
    return DISCS_NEAREST;
}

bool discs_cover(const struct discs *d, const double p[3], const double n[3], const float *value,
                 float out[3])
{
    const struct place at = place_at(d, p, n);
    struct covering c = covering_start(d, &at);
    float sum = 0;
    out[0] = out[1] = out[2] = 0;
    while (cover(d, &at, FINE, &c))
        for (size_t i = 0; i < c.count; i++) {
            const float *v = value + 3 * (size_t)c.point[i];
            sum += c.weight[i];
            for (int k = 0; k < 3; k++)
                out[k] += c.weight[i] * v[k];
        }
    for (int k = 0; k < 3 && sum > 0; k++)
        out[k] /= sum;
    return sum > 0;
}

bool discs_covers(const struct discs *d, const double p[3], const double n[3])
{
    const struct place at = place_at(d, p, n);
    struct covering c = covering_start(d, &at);
    while (cover(d, &at, FINE, &c))
        if (c.count > 0)
            return true;
    return false;
}

uint32_t discs_draw(const struct discs *d, const double p[3], const double n[3], float u)
{
    const struct place at = place_at(d, p, n);
    struct covering c = covering_start(d, &at);
    float sum = 0;
    uint32_t drawn = UINT32_MAX;
    while (cover(d, &at, FINE, &c))
        for (size_t i = 0; i < c.count; i++) { /* from those so far, and what is left of u */
            sum += c.weight[i];
            const float share = c.weight[i] / sum;
            if (u < share) {
                u /= share;
                drawn = c.point[i];
            } else {
                u = (u - share) / (1 - share);
            }
        }
    return drawn;
}

uint32_t discs_nearest(const struct discs *d, const double p[3], const double n[3], float *distance)
{
    const struct place at = place_at(d, p, n);
    const struct best best = find_best(d, &at, off_surface);
    *distance = best.rim;
    return best.disc == UINT32_MAX ? UINT32_MAX : d->disc[best.disc].point;
}

enum { FETCHED = 64 };

/* Discs of a cell that may face as the place does. */
static void fetch_discs(const struct discs *d, const struct place *at)
{
    struct covering c = covering_start(d, at);
    while (c.word < c.end) {
        const uint32_t run = *c.word++, count = run >> 8;
        const struct normals *normals = &d->normals[run & 255];
        if (facing(at->n, normals->middle) > normals->least)
            for (uint32_t i = 0; i < count; i++)
                __builtin_prefetch(&d->disc[c.word[i]]);
        c.word += count;
    }
}

/* Whether most places are far from the ones before them: what the others read is near already. */
static bool are_scattered(size_t count, const struct place *at)
{
    enum { FAR = 16 /* cells */ };
    size_t jumps = 0;
    for (size_t i = 1; i < count; i++) {
        float far = 0;
        for (int k = 0; k < 3; k++)
            far = fmaxf(far, fabsf(at[i].p[k] - at[i - 1].p[k]));
        jumps += far > FAR;
    }
    return 2 * jumps > count;
}

void discs_fetch(const struct discs *d, size_t count, const double *p, const double *n,
                 size_t stride)
{
    struct place at[FETCHED];
    count = count < FETCHED ? count : FETCHED;
    for (size_t i = 0; i < count; i++)
        at[i] = place_at(d, p + i * stride, n + i * stride);
    if (!are_scattered(count, at))
        return;
    for (size_t i = 0; i < count; i++)
        __builtin_prefetch(&d->start[cell_at(d, &at[i])]);
    for (size_t i = 0; i < count; i++) {
        covering_start(d, &at[i]);
    }
    for (size_t i = 0; i < count; i++)
        fetch_discs(d, &at[i]);
}
