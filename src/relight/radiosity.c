/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/radiosity.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "capture/senders.h"
#include "math/angle.h"

#include <math.h>
#include <stdlib.h>

enum { CHUNK = 64 };

struct solving {
    const struct senders *senders;
    const float *direct;
    double *node;    /* of the bounce before */
    double *scatter; /* 3 a sender: of this one; owned */
};

/* Sets a node and those below it to the mean of their senders. Returns their area. */
static double set_node(const struct solving *s, struct sender_node node)
{
    double *mean = s->node + 3 * (size_t)node.number;
    if (node.count == 1) {
        const size_t sender = s->senders->tree.sender[node.first];
        for (int c = 0; c < 3; c++)
            mean[c] = s->scatter[3 * sender + (size_t)c];
        return (double)s->senders->area[sender];
    }
    const struct sender_node half[2] = {sender_tree_half(node, 0), sender_tree_half(node, 1)};
    const double area[2] = {set_node(s, half[0]), set_node(s, half[1])}, sum = area[0] + area[1],
                 share = sum > 0 ? area[0] / sum : (double)half[0].count / (double)node.count;
    for (int c = 0; c < 3; c++)
        mean[c] = share * s->node[3 * (size_t)half[0].number + (size_t)c] +
                  (1 - share) * s->node[3 * (size_t)half[1].number + (size_t)c];
    return sum;
}

/* What some senders scatter of the light straight from lights, and of the bounce before. */
static struct error *gather(void *context, size_t index, int thread)
{
    const struct solving *s = context;
    const size_t links = s->senders->links, first = index * CHUNK,
                 end = first + CHUNK < s->senders->count ? first + CHUNK : s->senders->count;
    (void)thread;
    for (size_t i = first; i < end; i++) {
        double sum[3] = {0};
        for (size_t k = i * links; k < (i + 1) * links && s->senders->link[k]; k++)
            for (size_t c = 0; c < 3; c++)
                sum[c] += (double)s->senders->share[k] *
                          s->node[3 * (size_t)s->senders->link[k] + c];
        for (size_t c = 0; c < 3; c++)
            s->scatter[3 * i + c] = (double)s->senders->albedo[3 * i + c] *
                                    ((double)s->direct[3 * i + c] / ANGLE_PI + sum[c]);
    }
    return NULL;
}

struct error *radiosity_solve(const struct senders *senders, const float *direct, int bounces,
                              int threads, double *node)
{
    struct solving s = {.senders = senders, .direct = direct, .node = node};
    const double nothing = 1e-9;
    struct error *err = array_create(&s.scatter, 3 * senders->count, sizeof *s.scatter);
    for (size_t i = 0; i < 3 * senders->tree.nodes; i++)
        node[i] = 0;
    for (int b = 0; b < bounces && !err; b++) {
        double was[3] = {node[3], node[4], node[5]}, change = 0, all = 0;
        err = threads_for(threads, (senders->count + CHUNK - 1) / CHUNK, gather, &s);
        if (err)
            break;
        set_node(&s, sender_tree_root(&senders->tree));
        for (int c = 0; c < 3; c++) { /* light only grows, so the mean tells */
            change += fabs(node[3 + c] - was[c]);
            all += fabs(node[3 + c]);
        }
        if (change <= nothing * all)
            break;
    }
    free(s.scatter);
    return err;
}
