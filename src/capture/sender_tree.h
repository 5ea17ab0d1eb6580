/* SPDX-License-Identifier: Apache-2.0 */
/* sender_tree: senders in an order in which every cluster of them is a row of neighbours.
 *
 * A cluster is a node of a balanced binary tree over that order, so the order is all that needs to
 * be kept: node 1 is all senders; node i is cut into node 2 i, the first half of its row, rounded
 * up, and node 2 i + 1, until one sender is left. Each node is cut at the median along what its
 * senders differ in most (a k-d tree, Bentley, CACM 1975): the place, in units in which all senders
 * together have a variance of 1, the normal, or the albedo. So clusters are of one surface and one
 * colour as far as they go. Based on: Walter et al., "Lightcuts", SIGGRAPH 2005, whose tree has
 * such clusters of lights.
 */
#ifndef SENDER_TREE_H
#define SENDER_TREE_H

#include <stddef.h>
#include <stdint.h>

struct error;

enum { SENDERS_MOST = 1 << 20 };

/* What is known of senders; borrowed; count from 1 to SENDERS_MOST. */
struct sender_points {
    size_t count;
    const double *position; /* 3 a sender, scene units */
    const float *normal;    /* 3, unit */
    const float *albedo;    /* 3 */
};

struct sender_tree {
    size_t count, nodes; /* nodes: numbers are below this, some of them of none */
    uint32_t *sender;    /* at each place of the order; owned, and so is: */
    float *spread;       /* a node: root of the sum of its senders' variances; 0: they are alike */
};

/* Finds the order. */
struct error *sender_tree_create(struct sender_tree *tree, const struct sender_points *points);

/* Takes over an order: place[i] is sender i's. Error: these are not the places of all. */
struct error *sender_tree_take(struct sender_tree *tree, const struct sender_points *points,
                               const int32_t *place);
void sender_tree_clear(struct sender_tree *tree); /* {0} is legal */

/* A node: places first .. first + count - 1. */
struct sender_node {
    uint32_t number;
    size_t first, count;
};

static inline struct sender_node sender_tree_root(const struct sender_tree *tree)
{
    return (struct sender_node){1, 0, tree->count};
}

/* One half of a node of two senders or more: 0 or 1. */
static inline struct sender_node sender_tree_half(struct sender_node node, unsigned half)
{
    const size_t first = (node.count + 1) / 2;
    return half ? (struct sender_node){2 * node.number + 1, node.first + first, node.count - first}
                : (struct sender_node){2 * node.number, node.first, first};
}

#endif
