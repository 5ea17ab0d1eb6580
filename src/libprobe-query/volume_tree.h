/* SPDX-License-Identifier: Apache-2.0 */
/* volume_tree: trees of boxes over items in order, and the order: sorting along a Morton curve.
 *
 * Items that follow each other are to lie near each other, as cells, faces of a hull and probes do
 * once they are sorted by volume_morton. Boxes are kept in floats, rounded outward.
 */
#ifndef VOLUME_TREE_H
#define VOLUME_TREE_H

#include "probe-query.h"

#include <stddef.h>
#include <stdint.h>

/* Memory for an array, from the start of a cache line; of a large one in large pages, where the
 * system has such: to get many small ones takes longer than to fill them. NULL: there is none. */
void *volume_block(size_t bytes);
size_t volume_block_bytes(size_t bytes); /* what it takes */

/* The same, all zeros, which cost nothing until they are written over. *owned is what is to be
 * freed. */
void *volume_zeros(size_t bytes, void **owned);

enum { VOLUME_LEAF = 4 }; /* items of a leaf of a tree */

/* A box in lattice units, rounded outward. */
struct volume_box {
    float low[3], high[3];
};

/* A binary tree over runs of VOLUME_LEAF items in their order: level 0 are the leaves' boxes, each
 * level above has half as many, the last one. */
struct volume_tree {
    struct volume_box *box; /* all levels; owned */
    size_t items;
    int levels;
    uint32_t level[34]; /* where each begins in box; [levels]: the count of boxes */
};

enum probe_status volume_tree_init(struct volume_tree *tree, size_t items); /* makes empty boxes */
void volume_tree_clear(struct volume_tree *tree);
/* grows the box of an item's leaf */
void volume_tree_add(struct volume_tree *tree, size_t item, const double p[3]);
/* the box of a leaf all of whose items are known; rounded outward */
void volume_tree_put(struct volume_tree *tree, size_t leaf, const double low[3],
                     const double high[3]);
void volume_tree_finish(struct volume_tree *tree); /* makes the levels above */

/* Squared distance of p from a box; 0 inside. */
static inline double volume_box_square(const struct volume_box *box, const double p[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double below = (double)box->low[k] - p[k], above = p[k] - (double)box->high[k];
        const double d = below > above ? below : above;
        square += d > 0 ? d * d : 0;
    }
    return square;
}

/* Calls visit(context, item) for the items of leaves within sqrt(*square) of p, nearer boxes first;
 * visit may lower *square, and ends the search by making it negative. */
void volume_tree_search(const struct volume_tree *tree, const double p[3], double *square,
                        void (*visit)(void *context, size_t item), void *context);

/* An item of a leaf near p. */
size_t volume_tree_near(const struct volume_tree *tree, const double p[3]);

/* Interleaves the first `bits` bits (at most 21) of three numbers. */
uint64_t volume_morton(const uint32_t x[3], int bits);

/* Sorts by key, of which the lowest `bits` bits count, stably: order[k] is the number of the k-th.
 * room: 3 * count. */
void volume_sort(size_t count, const uint64_t *key, int bits, uint32_t *order, uint64_t *room);

#endif
