/* SPDX-License-Identifier: Apache-2.0 */
#include "math/cubes.h"
#include "base/array.h"
#include "base/error.h"
#include "math/vec.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int64_t cube_of(double x, double size)
{
    const double cube = floor(x / size);
    return fabs(cube) < 0x1p62 ? (int64_t)cube : 0;
}

static size_t cube_hash(const struct cubes *c, int64_t x, int64_t y, int64_t z)
{
    const uint64_t h = (uint64_t)x * 0x9e3779b97f4a7c15u ^ (uint64_t)y * 0xc2b2ae3d27d4eb4fu ^
                       (uint64_t)z * 0x165667b19e3779f9u;
    return (size_t)((h ^ h >> 29) * 0xbf58476d1ce4e5b9u >> 32) & c->mask;
}

struct error *cubes_init(struct cubes *c, double size, size_t room)
{
    *c = (struct cubes){.size = size, .mask = 1024};
    while (c->mask < 2 * room)
        c->mask *= 2;
    struct error *err = array_create(&c->head, c->mask, sizeof *c->head);
    if (!err)
        err = array_create(&c->next, room, sizeof *c->next);
    if (!err)
        err = array_create(&c->point, 3 * room, sizeof *c->point);
    for (size_t i = 0; i < c->mask && !err; i++)
        c->head[i] = -1;
    c->mask--;
    return err;
}

void cubes_clear(struct cubes *c)
{
    free(c->head);
    free(c->next);
    free(c->point);
    *c = (struct cubes){0};
}

void cubes_add(struct cubes *c, const double p[3])
{
    const size_t h =
        cube_hash(c, cube_of(p[0], c->size), cube_of(p[1], c->size), cube_of(p[2], c->size));
    memcpy(c->point + 3 * c->count, p, 3 * sizeof *p);
    c->next[c->count] = c->head[h];
    c->head[h] = (int32_t)c->count++;
}

bool cubes_find(const struct cubes *c, const double p[3], double reach,
                bool (*accepts)(void *context, const double *point), void *context, int32_t *found)
{
    const int64_t at[3] = {cube_of(p[0], c->size), cube_of(p[1], c->size), cube_of(p[2], c->size)};
    for (int64_t x = at[0] - 1; x <= at[0] + 1; x++)
        for (int64_t y = at[1] - 1; y <= at[1] + 1; y++)
            for (int64_t z = at[2] - 1; z <= at[2] + 1; z++)
                for (int32_t i = c->head[cube_hash(c, x, y, z)]; i >= 0; i = c->next[i]) {
                    const double *q = c->point + 3 * (size_t)i;
                    if (vec3_length(vec3_sub(vec3_load(q), vec3_load(p))) >= reach ||
                        (accepts && !accepts(context, q)))
                        continue;
                    if (found)
                        *found = i;
                    return true;
                }
    return false;
}
