/* SPDX-License-Identifier: Apache-2.0 */
/* nodes: probes that are the nodes of a grid along the axes, recognised from their positions.
 *
 * Spacings may differ from node to node. Each node must have its probe: of a grid with holes there
 * is no trilinear interpolation.
 */
#ifndef NODES_H
#define NODES_H

#include <stddef.h>
#include <stdint.h>

struct error;

struct nodes {
    size_t count[3];
    double *at[3];  /* where the grid's planes are, ascending; owned */
    int32_t *probe; /* of each node, x fastest; owned */
};

/* position: 3 a probe. The error says why they form no grid. */
struct error *nodes_find(struct nodes *nodes, size_t probes, const double *position);

/* The planes alone, and which one is nearest to x. Of an octree's probes they are not all full
 * (octree.h). */
struct error *nodes_planes(struct nodes *nodes, size_t probes, const double *position);
size_t nodes_plane(const struct nodes *nodes, int axis, double x);

void nodes_clear(struct nodes *nodes);

/* Four nodes along an axis and their weights, sum 1; a place beyond the ends is at the end. Linear:
 * of the two nodes around it. Cubic: a Hermite cubic between these, whose slopes are those of the
 * parabola through each and its neighbours (of one at the end: through the last three): reproduces
 * parabolas, and its slope is continuous. Catmull and Rom, "A class of local interpolating
 * splines", 1974, where nodes are even. */
void nodes_linear(const struct nodes *nodes, int axis, double x, size_t node[4], double weight[4]);
void nodes_cubic(const struct nodes *nodes, int axis, double x, size_t node[4], double weight[4]);

/* Weights of a cell's corners, x fastest, by the inverse of the distance from each, sum 1: at `in`,
 * 0 to 1 along each axis, of a cell with these sides (0: it is flat there). A corner's is 1 at its
 * place; they jump from cell to cell, whose other corners are others. */
void nodes_inverse(const double in[3], const double side[3], double weight[8]);

#endif
