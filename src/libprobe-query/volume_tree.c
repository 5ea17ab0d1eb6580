/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Morton, "A computer oriented geodetic data base and a new technique in file sequencing", IBM,
 * 1966: the curve. Lauterbach et al., "Fast BVH construction on GPUs", Computer Graphics Forum
 * 28(2), 2009: boxes over runs along it.
 */
#include "volume_tree.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

enum { DIGIT = 11, DIGITS = 1 << DIGIT };

size_t volume_block_bytes(size_t bytes)
{
    return (bytes + 63) / 64 * 64;
}

static void ask_for_large_pages(char *block, size_t bytes)
{
#ifdef MADV_HUGEPAGE
    const uintptr_t page = (uintptr_t)1 << 21, from = -(uintptr_t)block & (page - 1);
    if (block && bytes >= from + page) /* refused, it is slower, no more */
        madvise(block + from, (bytes - from) / page * page, MADV_HUGEPAGE);
#else
    (void)block;
    (void)bytes;
#endif
}

void *volume_block(size_t bytes)
{
    char *block = aligned_alloc(64, volume_block_bytes(bytes));
    ask_for_large_pages(block, bytes);
    return block;
}

void *volume_zeros(size_t bytes, void **owned)
{
    char *block = *owned = calloc(volume_block_bytes(bytes) + 64, 1);
    if (block)
        block += -(uintptr_t)block & 63;
    ask_for_large_pages(block, bytes);
    return block;
}

enum probe_status volume_tree_init(struct volume_tree *tree, size_t items)
{
    *tree = (struct volume_tree){.items = items};
    size_t boxes = 0, width = (items + VOLUME_LEAF - 1) / VOLUME_LEAF;
    for (;; width = (width + 1) / 2) {
        tree->level[tree->levels++] = (uint32_t)boxes;
        boxes += width;
        if (width <= 1)
            break;
    }
    tree->level[tree->levels] = (uint32_t)boxes;
    tree->box = volume_block((boxes ? boxes : 1) * sizeof *tree->box);
    if (!tree->box)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < tree->level[tree->levels > 1]; i++) /* the levels above: by finish */
        tree->box[i] =
            (struct volume_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    return PROBE_OK;
}

void volume_tree_clear(struct volume_tree *tree)
{
    free(tree->box);
    *tree = (struct volume_tree){0};
}

/* The next float above one that is below the largest. */
static inline float next_above(float x)
{
    int32_t bits;
    x += 0; /* not -0 */
    memcpy(&bits, &x, sizeof bits);
    bits += x < 0 ? -1 : 1;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The nearest float that is not above x, and not below it. */
static inline float float_below(double x)
{
    const float nearest = (float)x;
    return (double)nearest > x ? -next_above(-nearest) : nearest;
}

static inline float float_above(double x)
{
    const float nearest = (float)x;
    return (double)nearest < x ? next_above(nearest) : nearest;
}

void volume_tree_put(struct volume_tree *tree, size_t leaf, const double low[3],
                     const double high[3])
{
    for (int k = 0; k < 3; k++) {
        tree->box[leaf].low[k] = float_below(low[k]);
        tree->box[leaf].high[k] = float_above(high[k]);
    }
}

void volume_tree_add(struct volume_tree *tree, size_t item, const double p[3])
{
    struct volume_box *box = &tree->box[item / VOLUME_LEAF];
    for (int k = 0; k < 3; k++) {
        const float low = float_below(p[k]), high = float_above(p[k]);
        box->low[k] = low < box->low[k] ? low : box->low[k];
        box->high[k] = high > box->high[k] ? high : box->high[k];
    }
}

static size_t level_width(const struct volume_tree *tree, int level)
{
    return tree->level[level + 1] - tree->level[level];
}

void volume_tree_finish(struct volume_tree *tree)
{
    for (int level = 1; level < tree->levels; level++) {
        const struct volume_box *below = tree->box + tree->level[level - 1];
        for (size_t i = 0; i < level_width(tree, level); i++) {
            struct volume_box *box = tree->box + tree->level[level] + i;
            *box = below[2 * i];
            if (2 * i + 1 == level_width(tree, level - 1))
                continue;
            for (int k = 0; k < 3; k++) {
                const float low = below[2 * i + 1].low[k], high = below[2 * i + 1].high[k];
                box->low[k] = low < box->low[k] ? low : box->low[k];
                box->high[k] = high > box->high[k] ? high : box->high[k];
            }
        }
    }
}

static double centre_square(const struct volume_box *box, const double p[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double d = ((double)box->low[k] + (double)box->high[k]) / 2 - p[k];
        square += d * d;
    }
    return square;
}

void volume_tree_search(const struct volume_tree *tree, const double p[3], double *square,
                        void (*visit)(void *context, size_t item), void *context)
{
    struct {
        int level;
        uint32_t index;
        double square;
    } stack[2 * 34]; /* a level leaves at most one behind */
    int depth = 0;
    if (!tree->items)
        return;
    stack[depth].level = tree->levels - 1;
    stack[depth].index = 0;
    stack[depth++].square = volume_box_square(tree->box + tree->level[tree->levels - 1], p);
    while (depth) { /* each box is on the stack at most once: the search ends */
        const int level = stack[--depth].level;
        const size_t index = stack[depth].index;
        if (!(stack[depth].square <= *square))
            continue;
        if (level == 0) {
            for (size_t i = VOLUME_LEAF * index; i < VOLUME_LEAF * (index + 1) && i < tree->items;
                 i++)
                visit(context, i);
            continue;
        }
        double child[2] = {0, INFINITY};
        const struct volume_box *box = tree->box + tree->level[level - 1] + 2 * index;
        const int children = 2 * index + 1 < level_width(tree, level - 1) ? 2 : 1;
        for (int i = 0; i < children; i++)
            child[i] = volume_box_square(&box[i], p);
        const bool nearer = child[1] < child[0] ||
                            (child[1] == child[0] && children == 2 &&
                             centre_square(&box[1], p) < centre_square(&box[0], p));
        for (int i = 0; i < children; i++) { /* the nearer one on top */
            const int which = children == 1 ? 0 : i ? nearer : !nearer;
            stack[depth].level = level - 1;
            stack[depth].index = (uint32_t)(2 * index) + (uint32_t)which;
            stack[depth++].square = child[which];
        }
    }
}

size_t volume_tree_near(const struct volume_tree *tree, const double p[3])
{
    size_t index = 0;
    for (int level = tree->levels - 1; level > 0; level--) {
        const struct volume_box *box = tree->box + tree->level[level - 1] + 2 * index;
        index *= 2;
        if (index + 1 >= level_width(tree, level - 1))
            continue;
        const double square[2] = {volume_box_square(&box[0], p), volume_box_square(&box[1], p)};
        index += square[1] < square[0] ||
                 (square[1] == square[0] && centre_square(&box[1], p) < centre_square(&box[0], p));
    }
    return VOLUME_LEAF * index;
}

uint64_t volume_morton(const uint32_t x[3], int bits)
{
    uint64_t key = 0;
    for (int k = 0; k < 3; k++) { /* two blanks between every two bits */
        uint64_t s = x[k] & ((1u << bits) - 1);
        s = (s | s << 32) & 0x1f00000000ffff;
        s = (s | s << 16) & 0x1f0000ff0000ff;
        s = (s | s << 8) & 0x100f00f00f00f00f;
        s = (s | s << 4) & 0x10c30c30c30c30c3;
        s = (s | s << 2) & 0x1249249249249249;
        key |= s << k;
    }
    return key;
}

/* One pass of a radix sort, on digits of DIGIT bits: 16 bytes an item, key and number. */
static void sort_digit(size_t count, const uint64_t *from, uint64_t *to, int shift)
{
    size_t begin[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; i++)
        begin[from[i] >> shift & (DIGITS - 1)]++;
    for (size_t d = 0; d < DIGITS; d++) {
        const size_t n = begin[d];
        begin[d] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++)
        to[begin[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

void volume_sort(size_t count, const uint64_t *key, int bits, uint32_t *order, uint64_t *room)
{
    /* The lowest `bits` bits of keys go through as what fits beside an item's number, 32 bits at a
     * time, the low half first. */
    uint64_t *a = room, *b = room + count;
    for (size_t i = 0; i < count; i++)
        order[i] = (uint32_t)i;
    for (int low = 0; low < bits; low += 32) {
        const int width = bits - low < 32 ? bits - low : 32;
        for (size_t i = 0; i < count; i++)
            a[i] = (key[order[i]] >> low & UINT32_MAX) << 32 | order[i];
        for (int shift = 0; shift < width; shift += DIGIT) {
            sort_digit(count, a, b, 32 + shift);
            uint64_t *swap = a;
            a = b;
            b = swap;
        }
        for (size_t i = 0; i < count; i++)
            order[i] = (uint32_t)a[i];
    }
}
