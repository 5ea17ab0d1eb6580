/* SPDX-License-Identifier: Apache-2.0 */
/* place_grid: the nodes of grids that fill boxes. */
#ifndef PLACE_GRID_H
#define PLACE_GRID_H

#include "place/space.h"

#include <stdbool.h>

struct error;
struct place;
struct reach;

/* A grid that fills a box. Along each axis its nodes are even, as far from each other as the
 * spacing or less, and the outermost ones have the clearance from the box's faces. Where that
 * leaves less than half a spacing, there is one node in the middle. */
struct place_grid {
    struct place_box box; /* low <= high */
    int up;               /* the axis that the box is turned about */
    double spacing[3];    /* greater than 0 */
    double clearance;     /* a length, or a share of the nodes' distance, at most 0.5 */
    bool share;
};

/* How many nodes the grid has along each axis. Doubles, since they may exceed any integer. */
void place_grid_nodes(const struct place_grid *grid, double nodes[3]);

/* Gives the grids the smallest spacing, one for all and equal along the axes, with which they have
 * at most `most` nodes (as many as there are grids, or more), and returns it. Not all of the boxes
 * are points. */
double place_grid_spacing(struct place_grid *grid, int count, double most);

/* Appends the nodes of each, x fastest. Nodes in an earlier box, or nearer to a node of it than
 * half a spacing of either, are left out; and, with a region (NULL: none), those that are no corner
 * of a cell that it comes into. Errors: more than `most` of them, naming the number. */
struct error *place_grids(struct place *place, const struct place_grid *grid, int count,
                          const struct reach *reach, double most);

#endif
