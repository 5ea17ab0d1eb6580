/* SPDX-License-Identifier: Apache-2.0 */
/* octree: probes that are the corners of the cells of an octree along the axes, recognised from
 * their positions, and interpolation between them without jumps.
 *
 *     err = octree_find(&tree, probes, position);
 *     err = octree_fill(&tree, cubic, width, value, &data);     once for each column;
 *                                                               data is the caller's, to be freed
 *     octree_at(&tree, cubic, width, data, p, out);
 *     octree_clear(&tree);
 *
 * A box is a grid of root cells, as long along each axis as may be; a cell that has a probe in its
 * middle is cut into eight, and then all 27 nodes of it are probes. Cells side by side may differ
 * by any number of cuts; there the larger one has hanging nodes, probes on its border that are none
 * of its corners. Where the probes are in a plane or on a line, cells are flat.
 *
 * A leaf with hanging nodes is cut on in thought, and so are the parts that have some on their own
 * border, until none has. The nodes that this makes, where there is no probe, take values from what
 * surrounds them: the middle of an edge from the edge's ends, that of a face from the middles of
 * its edges, that of a cell from those of its faces. So what is on an edge or a face depends on it
 * alone, and cells on both sides agree upon it. Where a face has hanging nodes, those on both sides
 * are cut; where it has none, to cut it changes nothing of the function on it, which goes through
 * its corners alone: so both sides have the same function on every face, however often each is cut,
 * and it is continuous. A part is cut where a cell of its size that is cut shares a face or an edge
 * with it: there are at most 18 such parts for each cell that is cut, so all are made ahead, and
 * memory is linear in the probes.
 *
 * Linear: the made nodes have the mean of what surrounds them, as the trilinear function has there.
 * Each value is a mean of probes', with weights >= 0 that sum to 1; linear fields come out exactly,
 * and each probe's value at its place.
 *
 * Cubic: in each part a tricubic Hermite polynomial from 8 data at each corner: the value and its
 * derivatives by x, y, z, xy, xz, yz and xyz (Lekien and Marsden, "Tricubic interpolation in three
 * dimensions", 2005). A probe's are central differences of the linear function, as far as its
 * largest cell goes (on the border of the box, the slope of the parabola through three), so where
 * spacing is even this is what nodes_cubic makes of a grid. (Over its least cell, noise of the
 * values would be a slope that the largest one carries far: with cells of all sizes side by side
 * and noise of 5 %, cubics overshot three times as far.) A made node's are those of the cubics
 * between opposite neighbours, at their middle, in the mean over the axes. On a face, value and
 * slope across it are bicubic in the data of its corners, of which the same holds as above: the
 * slope is continuous as well. Linear fields come out exactly.
 *
 * Read-only once it is made: threads share it.
 */
#ifndef OCTREE_H
#define OCTREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

/* A node that is no probe: along axis k between two nodes, or -1. */
struct octree_made {
    int32_t pair[3][2];
    int32_t apart; /* how far, in units */
};

struct octree {
    double low[3], high[3];
    /* of the box along each axis; 0: it is flat there. A unit is the least spacing of probes */
    int32_t units[3];
    int32_t root; /* units of a root cell, a power of two */
    size_t roots[3];
    size_t probes, nodes; /* nodes: with the made ones, which come behind the probes */
    /* of each cell, the roots first: the first of its eight parts; or ~ of which leaf it is;
     * owned */
    int32_t *child;
    int32_t (*corner)[8];     /* nodes, of each leaf, x fastest; owned */
    struct octree_made *made; /* each behind those that it is between; owned */
    int32_t (*site)[3];       /* of each probe, in units; owned */
    /* of each probe: the largest cell that it is a corner of, in units; owned */
    int32_t *spacing;
};

/* position: 3 a probe, finite, in any order. Positions may be off by a millionth of the box. The
 * error says what is missing or too much. */
struct error *octree_find(struct octree *tree, size_t probes, const double *position);
void octree_clear(struct octree *tree);

/* The data of a column at all nodes, from the values at the probes, width each: width a node, or 8
 * * width if cubic. */
struct error *octree_fill(const struct octree *tree, bool cubic, size_t width, const float *value,
                          float **data);

/* The values at p, or at the nearest place of the box: out[width]. */
void octree_at(const struct octree *tree, bool cubic, size_t width, const float *data,
               const double p[3], float *out);

/* Of linear data, by the inverse of the distance from each corner of the leaf, or of its part, that
 * p is in (nodes_inverse). */
void octree_at_inverse(const struct octree *tree, size_t width, const float *data,
                       const double p[3], float *out);

#endif
