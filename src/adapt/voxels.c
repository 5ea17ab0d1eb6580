/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/voxels.h"
#include "base/array.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

/* The node at a place, made where there is none. */
static struct error *node_at(struct voxels *v, const int32_t x[3], int level, int32_t *node)
{
    *node = places_find(&v->places, x);
    if (*node >= 0)
        return NULL;
    if (v->nodes >= INT32_MAX)
        return error_new("there are more than %d nodes", INT32_MAX);
    struct error *err = array_reserve(&v->site, &v->site_capacity, v->nodes + 1, sizeof *v->site);
    if (!err)
        err = array_reserve(&v->level, &v->level_capacity, v->nodes + 1, sizeof *v->level);
    if (!err)
        err = places_add(&v->places, x, (int32_t)v->nodes);
    if (err)
        return err;
    memcpy(v->site[v->nodes], x, sizeof *v->site);
    v->level[v->nodes] = level;
    *node = (int32_t)v->nodes++;
    return NULL;
}

static int32_t units_of(const struct voxels *v, int level)
{
    return (int32_t)1 << (v->deepest - level);
}

static struct error *add_voxel(struct voxels *v, const int32_t x[3], int level)
{
    struct voxel new = {.x = {x[0], x[1], x[2]}, .level = level};
    struct error *err = array_reserve(&v->voxel, &v->capacity, v->count + 1, sizeof *v->voxel);
    for (int j = 0; j < 8 && !err; j++) {
        int32_t corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = x[k] + (j >> k & 1) * units_of(v, level);
        err = node_at(v, corner, level, &new.node[j]);
    }
    if (!err)
        v->voxel[v->count++] = new;
    return err;
}

struct error *voxels_start(struct voxels *v, const double low[3], const double high[3],
                           const int32_t cells[3], int deepest)
{
    struct error *err = NULL;
    *v = (struct voxels){.deepest = deepest};
    memcpy(v->low, low, sizeof v->low);
    memcpy(v->high, high, sizeof v->high);
    memcpy(v->cells, cells, sizeof v->cells);
    const int32_t units = units_of(v, 0);
    for (int32_t z = 0; z < cells[2] && !err; z++)
        for (int32_t y = 0; y < cells[1] && !err; y++)
            for (int32_t x = 0; x < cells[0] && !err; x++)
                err = add_voxel(v, (const int32_t[3]){x * units, y * units, z * units}, 0);
    return err;
}

void voxels_clear(struct voxels *v)
{
    free(v->voxel);
    free(v->site);
    free(v->level);
    places_clear(&v->places);
    *v = (struct voxels){0};
}

struct error *voxels_cut(struct voxels *v, size_t i)
{
    const struct voxel whole = v->voxel[i];
    struct error *err =
        v->count >= INT32_MAX - 8 ? error_new("there are more than %d cells", INT32_MAX - 8) : NULL;
    v->voxel[i].child = (int32_t)v->count;
    for (int part = 0; part < 8 && !err; part++) {
        int32_t x[3];
        for (int k = 0; k < 3; k++)
            x[k] = whole.x[k] + (part >> k & 1) * units_of(v, whole.level + 1);
        err = add_voxel(v, x, whole.level + 1);
    }
    return err;
}

void voxels_join(struct voxels *v, size_t i)
{
    for (int part = 0; part < 8; part++)
        v->voxel[v->voxel[i].child + part].gone = true;
    v->voxel[i].child = 0;
}

void voxels_nodes(const struct voxels *v, size_t i, int32_t node[27])
{
    for (int n = 0; n < 27; n++) {
        const int at[3] = {n % 3, n / 3 % 3, n / 9};
        int part = 0, corner = 0;
        for (int k = 0; k < 3; k++) {
            part |= (at[k] == 2) << k;
            corner |= (at[k] >= 1) << k;
        }
        node[n] = v->voxel[v->voxel[i].child + part].node[corner];
    }
}

void voxels_position(const struct voxels *v, size_t node, double position[3])
{
    for (int k = 0; k < 3; k++) {
        const double share = (double)v->site[node][k] / ((double)v->cells[k] * units_of(v, 0));
        position[k] = v->low[k] + share * (v->high[k] - v->low[k]);
    }
}

void voxels_sides(const struct voxels *v, int level, double side[3])
{
    for (int k = 0; k < 3; k++)
        side[k] = (v->high[k] - v->low[k]) / v->cells[k] / ((int32_t)1 << level);
}

void voxels_used(const struct voxels *v, bool *used)
{
    memset(used, 0, v->nodes * sizeof *used);
    for (size_t i = 0; i < v->count; i++)
        for (int j = 0; j < 8 && !v->voxel[i].gone; j++)
            used[v->voxel[i].node[j]] = true;
}
