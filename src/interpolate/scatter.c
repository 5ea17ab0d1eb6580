/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/scatter.h"
#include "base/array.h"
#include "base/error.h"
#include "libprobe-query/volume_tree.h"
#include "math/box.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct scatter {
    const double *position;
    int32_t *probe; /* along the curve */
    size_t count;
    double origin[3]; /* boxes are of positions less this, so that floats hold them well */
    struct volume_tree tree;
};

static double square_between(const struct scatter *s, int32_t probe, const double p[3])
{
    double square = 0;
    for (size_t k = 0; k < 3; k++) {
        const double d = s->position[3 * (size_t)probe + k] - p[k];
        square += d * d;
    }
    return square;
}

static struct error *sort_probes(struct scatter *s)
{
    const size_t n = s->count;
    uint64_t *key = NULL, *room = NULL;
    uint32_t *order = NULL;
    int32_t *sorted = NULL;
    struct box box = box_empty();
    for (size_t i = 0; i < n; i++)
        box_add(&box, s->position + 3 * (size_t)s->probe[i]);
    const double extent = box_side(&box);
    memcpy(s->origin, box.low, sizeof s->origin);
    struct error *err = array_create(&key, n, sizeof *key);
    if (!err)
        err = array_create(&room, 3 * n, sizeof *room);
    if (!err)
        err = array_create(&order, n, sizeof *order);
    if (!err)
        err = array_create(&sorted, n, sizeof *sorted);
    for (size_t i = 0; i < n && !err; i++) {
        uint32_t x[3];
        for (size_t k = 0; k < 3; k++)
            x[k] = extent > 0 ? (uint32_t)((s->position[3 * (size_t)s->probe[i] + k] - box.low[k]) /
                                           extent * 2097151)
                              : 0;
        key[i] = volume_morton(x, 21);
    }
    if (!err) {
        volume_sort(n, key, 63, order, room);
        for (size_t i = 0; i < n; i++)
            sorted[i] = s->probe[order[i]];
        free(s->probe);
        s->probe = sorted;
    }
    free(key);
    free(room);
    free(order);
    return err;
}

struct error *scatter_create(struct scatter **scatter, size_t probes, const double *position,
                             bool (*skip)(const void *context, size_t probe), const void *context)
{
    struct scatter *s = NULL;
    *scatter = NULL;
    struct error *err = array_create(&s, 1, sizeof *s);
    if (err)
        return err;
    s->position = position;
    err = array_create(&s->probe, probes, sizeof *s->probe);
    for (size_t i = 0; i < probes && !err; i++)
        if (!skip(context, i))
            s->probe[s->count++] = (int32_t)i;
    if (!err && !s->count)
        err = error_new("no probe has light: run probe-capture");
    if (!err)
        err = sort_probes(s);
    if (!err && volume_tree_init(&s->tree, s->count))
        err = error_memory();
    for (size_t i = 0; i < s->count && !err; i++) {
        double p[3];
        for (size_t k = 0; k < 3; k++)
            p[k] = position[3 * (size_t)s->probe[i] + k] - s->origin[k];
        volume_tree_add(&s->tree, i, p);
    }
    if (!err) {
        volume_tree_finish(&s->tree);
        *scatter = s;
    } else {
        scatter_destroy(s);
    }
    return err;
}

void scatter_destroy(struct scatter *s)
{
    if (!s)
        return;
    volume_tree_clear(&s->tree);
    free(s->probe);
    free(s);
}

/* -- asking ---------------------------------------------------------------------------------- */

struct ask {
    const struct scatter *scatter;
    const double *p;
    double square;
    int32_t best, not ; /* not: is not looked at */
    void (*visit)(void *context, int32_t probe, double distance);
    void *context;
};

static void try_nearest(void *context, size_t item)
{
    struct ask *a = context;
    const int32_t probe = a->scatter->probe[item];
    const double square = square_between(a->scatter, probe, a->p);
    if (probe != a->not &&(square < a->square ||
                           (square == a->square && (a->best < 0 || probe < a->best)))) {
        a->square = square;
        a->best = probe;
    }
}

static void try_within(void *context, size_t item)
{
    struct ask *a = context;
    const double square = square_between(a->scatter, a->scatter->probe[item], a->p);
    if (square < a->square)
        a->visit(a->context, a->scatter->probe[item], sqrt(square));
}

static void search(const struct scatter *s, struct ask *a,
                   void (*visit)(void *context, size_t item))
{
    double p[3];
    for (int k = 0; k < 3; k++)
        p[k] = a->p[k] - s->origin[k];
    volume_tree_search(&s->tree, p, &a->square, visit, a);
}

int32_t scatter_nearest(const struct scatter *s, const double p[3], double *distance)
{
    struct ask a = {.scatter = s, .p = p, .square = INFINITY, .best = -1, .not = -1};
    search(s, &a, try_nearest);
    *distance = sqrt(a.square);
    return a.best >= 0 ? a.best : s->probe[0];
}

double scatter_spacing(const struct scatter *s)
{
    double sum = 0;
    for (size_t i = 0; i < s->count; i++) {
        struct ask a = {.scatter = s,
                        .p = s->position + 3 * (size_t)s->probe[i],
                        .square = INFINITY,
                        .best = -1,
                        .not = s->probe[i]};
        search(s, &a, try_nearest);
        sum += a.square < INFINITY ? sqrt(a.square) : 0;
    }
    return 2 * sum / (double)s->count;
}

/* The order of boxes depends on how near they are to p; that of sums must not, at least not for one
 * p: it does not. */
void scatter_within(const struct scatter *s, const double p[3], double radius,
                    void (*visit)(void *context, int32_t probe, double distance), void *context)
{
    struct ask a = {
        .scatter = s, .p = p, .square = radius * radius, .visit = visit, .context = context};
    search(s, &a, try_within);
}
