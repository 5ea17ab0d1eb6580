/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/sender_tree.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>

enum { FEATURES = 9 };

/* What senders differ in, FEATURES a sender. */
struct making {
    struct sender_tree *tree;
    float *feature; /* owned */
    struct key {
        float value;
        uint32_t sender;
    } * key; /* owned; NULL: the order is given */
};

static struct error *find_features(struct making *m, const struct sender_points *p)
{
    double mean[3] = {0}, variance = 0;
    struct error *err = array_create(&m->feature, FEATURES * p->count, sizeof *m->feature);
    for (size_t i = 0; i < 3 * p->count; i++)
        mean[i % 3] += p->position[i] / (double)p->count;
    for (size_t i = 0; i < 3 * p->count; i++) {
        const double off = p->position[i] - mean[i % 3];
        variance += off * off / (double)p->count;
    }
    const double scale = variance > 0 ? 1 / sqrt(variance) : 0;
    for (size_t i = 0; i < p->count && !err; i++)
        for (size_t k = 0; k < 3; k++) {
            float *f = m->feature + FEATURES * i;
            f[k] = (float)((p->position[3 * i + k] - mean[k]) * scale);
            f[3 + k] = p->normal[3 * i + k];
            f[6 + k] = p->albedo[3 * i + k];
        }
    return err;
}

/* The variance of each feature among a node's senders. */
static void find_variance(const struct making *m, struct sender_node node,
                          double variance[FEATURES])
{
    const uint32_t *sender = m->tree->sender + node.first;
    double sum[FEATURES] = {0}, square[FEATURES] = {0};
    const float *origin = m->feature + FEATURES * (size_t)sender[0];
    for (size_t i = 1; i < node.count; i++)
        for (size_t k = 0; k < FEATURES; k++) {
            const double off = (double)(m->feature[FEATURES * (size_t)sender[i] + k] - origin[k]);
            sum[k] += off;
            square[k] += off * off;
        }
    for (size_t k = 0; k < FEATURES; k++) {
        const double mean = sum[k] / (double)node.count;
        variance[k] = fmax(square[k] / (double)node.count - mean * mean, 0);
    }
}

static int by_value(const void *a, const void *b)
{
    const struct key *x = a, *y = b;
    if (x->value < y->value || x->value > y->value)
        return x->value < y->value ? -1 : 1;
    return x->sender < y->sender ? -1 : 1;
}

/* Puts a node's senders in the order of a feature. */
static void sort_node(const struct making *m, struct sender_node node, size_t feature)
{
    uint32_t *sender = m->tree->sender + node.first;
    for (size_t i = 0; i < node.count; i++)
        m->key[i] = (struct key){m->feature[FEATURES * (size_t)sender[i] + feature], sender[i]};
    qsort(m->key, node.count, sizeof *m->key, by_value);
    for (size_t i = 0; i < node.count; i++)
        sender[i] = m->key[i].sender;
}

static void cut(const struct making *m, struct sender_node node)
{
    double variance[FEATURES], sum = 0;
    size_t most = 0;
    find_variance(m, node, variance);
    for (size_t k = 0; k < FEATURES; k++) {
        sum += variance[k];
        most = variance[k] > variance[most] ? k : most;
    }
    m->tree->spread[node.number] = (float)sqrt(sum);
    if (node.count == 1)
        return;
    if (m->key)
        sort_node(m, node, most);
    cut(m, sender_tree_half(node, 0));
    cut(m, sender_tree_half(node, 1));
}

/* Makes room for an order, of all senders as they come. */
static struct error *start(struct sender_tree *tree, size_t count)
{
    *tree = (struct sender_tree){.count = count, .nodes = 2};
    while (tree->nodes < 2 * count)
        tree->nodes *= 2;
    struct error *err = array_create(&tree->sender, count, sizeof *tree->sender);
    if (!err)
        err = array_create(&tree->spread, tree->nodes, sizeof *tree->spread);
    for (size_t i = 0; i < count && !err; i++)
        tree->sender[i] = (uint32_t)i;
    return err;
}

struct error *sender_tree_create(struct sender_tree *tree, const struct sender_points *points)
{
    struct making m = {.tree = tree};
    struct error *err = start(tree, points->count);
    if (!err)
        err = find_features(&m, points);
    if (!err)
        err = array_create(&m.key, points->count, sizeof *m.key);
    if (!err)
        cut(&m, sender_tree_root(tree));
    free(m.key);
    m.key = NULL;
    if (!err)
        cut(&m, sender_tree_root(tree)); /* spreads, as of an order that is taken over */
    free(m.feature);
    return err;
}

struct error *sender_tree_take(struct sender_tree *tree, const struct sender_points *points,
                               const int32_t *place)
{
    struct making m = {.tree = tree};
    struct error *err = start(tree, points->count);
    if (!err)
        err = find_features(&m, points);
    for (size_t i = 0; i < points->count && !err; i++)
        tree->sender[i] = UINT32_MAX;
    for (size_t i = 0; i < points->count && !err; i++) {
        const size_t at = (size_t)place[i];
        if (place[i] < 0 || at >= points->count || tree->sender[at] != UINT32_MAX)
            err = error_new("row %zu: expected a place of its own from 0 to %zu, got %d", i,
                            points->count - 1, (int)place[i]);
        else
            tree->sender[at] = (uint32_t)i;
    }
    if (!err)
        cut(&m, sender_tree_root(tree));
    free(m.feature);
    return err;
}

void sender_tree_clear(struct sender_tree *tree)
{
    free(tree->sender);
    free(tree->spread);
    *tree = (struct sender_tree){0};
}
