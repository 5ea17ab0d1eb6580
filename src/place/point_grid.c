/* SPDX-License-Identifier: Apache-2.0 */
#include "place/point_grid.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_BITS = 10 };

static size_t bucket(const struct point_grid *grid, int level, const int64_t cell[3])
{
    uint64_t h = (uint64_t)level;
    for (int k = 0; k < 3; k++) {
        h = (h ^ (uint64_t)cell[k]) * 0x9e3779b97f4a7c15;
        h ^= h >> 29;
    }
    return (size_t)((h * 0xbf58476d1ce4e5b9) >> (64 - grid->bits));
}

/* No point's twice the radius is more than a cell. */
static int level_of(const struct point_grid *grid, double radius)
{
    int level = 0;
    for (double cell = grid->cell; level + 1 < grid->levels && cell < 2 * radius; cell *= 2)
        level++;
    return level;
}

static void link_point(struct point_grid *grid, size_t i)
{
    struct grid_point *p = &grid->point[i];
    const int level = level_of(grid, (double)p->radius);
    const double scale = 1 / ldexp(grid->cell, level);
    const int64_t cell[3] = {(int64_t)floor(p->position.x * scale),
                             (int64_t)floor(p->position.y * scale),
                             (int64_t)floor(p->position.z * scale)};
    int32_t *first = &grid->first[bucket(grid, level, cell)];
    p->next = *first;
    *first = (int32_t)i;
}

static struct error *make_table(struct point_grid *grid, int bits)
{
    int32_t *first;
    struct error *err = array_create(&first, (size_t)1 << bits, sizeof *first);
    if (err)
        return err;
    memset(first, -1, ((size_t)1 << bits) * sizeof *first);
    free(grid->first);
    grid->first = first;
    grid->bits = bits;
    for (size_t i = 0; i < grid->count; i++)
        link_point(grid, i);
    return NULL;
}

struct error *point_grid_init(struct point_grid *grid, double least, double most)
{
    *grid = (struct point_grid){.cell = 2 * least, .levels = 1};
    for (double cell = grid->cell; cell < 2 * most; cell *= 2)
        grid->levels++;
    return make_table(grid, FIRST_BITS);
}

void point_grid_clear(struct point_grid *grid)
{
    free(grid->point);
    free(grid->first);
    *grid = (struct point_grid){0};
}

struct error *point_grid_add(struct point_grid *grid, struct vec3 position, struct vec3f normal,
                             float radius)
{
    struct error *err =
        array_reserve(&grid->point, &grid->capacity, grid->count + 1, sizeof *grid->point);
    if (err)
        return err;
    grid->point[grid->count] = (struct grid_point){position, normal, radius, -1};
    if (grid->count >= (size_t)1 << grid->bits)
        err = make_table(grid, grid->bits + 2);
    if (!err)
        link_point(grid, grid->count++);
    return err;
}

/* A search in one of the grids. */
struct search {
    const struct point_grid *grid;
    int level;
    double cell, within;
    const double *square; /* the visitor's */
    double p[3];
    int64_t middle[3]; /* the cell of p */
    void (*visit)(void *context, size_t i);
    void *context;
};

static double limit_of(const struct search *s)
{
    return fmin(*s->square, s->within * s->within);
}

static void visit_cell(const struct search *s, const int64_t cell[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double low = (double)cell[k] * s->cell - s->p[k], high = -low - s->cell,
                     off = low > high ? low : high;
        square += off > 0 ? off * off : 0;
    }
    if (square > limit_of(s))
        return;
    for (int32_t i = s->grid->first[bucket(s->grid, s->level, cell)]; i >= 0;
         i = s->grid->point[i].next)
        s->visit(s->context, (size_t)i);
}

/* The cells that are so many away from the middle one. */
static void visit_shell(const struct search *s, int64_t away)
{
    int64_t cell[3];
    for (int64_t z = -away; z <= away; z++)
        for (int64_t y = -away; y <= away; y++) {
            const bool inner = z > -away && z < away && y > -away && y < away;
            for (int64_t x = -away; x <= away; x += inner ? 2 * away : 1) {
                cell[0] = s->middle[0] + x;
                cell[1] = s->middle[1] + y;
                cell[2] = s->middle[2] + z;
                visit_cell(s, cell);
            }
        }
}

void point_grid_near(const struct point_grid *grid, struct vec3 p, const double *square,
                     bool by_reach, void (*visit)(void *context, size_t i), void *context)
{
    struct search s = {
        .grid = grid, .cell = grid->cell, .square = square, .visit = visit, .context = context};
    vec3_store(s.p, p);
    for (s.level = 0; s.level < grid->levels; s.level++, s.cell *= 2) {
        double inside = (double)INFINITY; /* how far p is from the faces of its cell */
        s.within = by_reach ? s.cell : (double)INFINITY;
        for (int k = 0; k < 3; k++) {
            s.middle[k] = (int64_t)floor(s.p[k] / s.cell);
            const double off = s.p[k] - (double)s.middle[k] * s.cell;
            inside = fmin(inside, fmin(off, s.cell - off));
        }
        visit_shell(&s, 0);
        for (int64_t away = 1;; away++) {
            const double least = fmax(inside + (double)(away - 1) * s.cell, 0);
            if (least * least > limit_of(&s))
                break;
            visit_shell(&s, away);
        }
    }
}
