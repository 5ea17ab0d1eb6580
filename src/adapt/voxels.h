/* SPDX-License-Identifier: Apache-2.0 */
/* voxels: cells of a box that are cut into eight, and the nodes at their corners.
 *
 *     err = voxels_start(&v, low, high, cells, deepest);   the box as root cells, level 0
 *     err = voxels_cut(&v, i);                             eight cells of a level more
 *     voxels_join(&v, i);                                  the eight go
 *     voxels_clear(&v);
 *
 * Nodes that more than one cell has are one. What is made stands behind what there is: cells and
 * nodes that were joined stay, and voxels_used tells which nodes some cell still has. What
 * octree.h reads is the corners of all cells that are left.
 */
#ifndef VOXELS_H
#define VOXELS_H

#include "math/places.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

struct voxel {
    int32_t x[3];    /* of its first corner, on the lattice of the smallest cells */
    int32_t node[8]; /* its corners, x fastest */
    int32_t child;   /* the first of eight; 0: it is a leaf */
    int level;
    bool gone; /* joined */
};

struct voxels {
    double low[3], high[3];
    int32_t cells[3]; /* of level 0 */
    int deepest;      /* the last level */
    struct voxel *voxel;
    size_t count, capacity;
    int32_t (*site)[3]; /* of each node */
    int *level;         /* at which the node came */
    size_t nodes, site_capacity, level_capacity;
    struct places places;
};

/* The lattice must have at most PLACES_MOST places along each axis, cells * 2^deepest. */
struct error *voxels_start(struct voxels *voxels, const double low[3], const double high[3],
                           const int32_t cells[3], int deepest);
void voxels_clear(struct voxels *voxels);

/* Cuts a leaf, above the deepest level. */
struct error *voxels_cut(struct voxels *voxels, size_t voxel);

/* Makes a cell a leaf again, whose eight parts are leaves. */
void voxels_join(struct voxels *voxels, size_t voxel);

/* The 27 nodes of a cell that is cut, x fastest. */
void voxels_nodes(const struct voxels *voxels, size_t voxel, int32_t node[27]);

/* Where a node is, and how long a cell's sides are. */
void voxels_position(const struct voxels *voxels, size_t node, double position[3]);
void voxels_sides(const struct voxels *voxels, int level, double side[3]);

/* Which nodes a cell that is left has: used[nodes]. */
void voxels_used(const struct voxels *voxels, bool *used);

#endif
