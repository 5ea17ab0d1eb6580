/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/nodes.h"
#include "base/array.h"
#include "base/error.h"
#include "math/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The planes along an axis: positions that differ by less than a millionth of the grid's extent are
 * of one. */
static struct error *find_planes(struct nodes *g, int axis, size_t probes, const double *position)
{
    double *at = NULL;
    struct error *err = array_create(&at, probes, sizeof *at);
    if (err)
        return err;
    for (size_t i = 0; i < probes; i++)
        at[i] = position[3 * i + (size_t)axis];
    sort_doubles(probes, at);
    const double apart = 1e-6 * (at[probes - 1] - at[0]);
    size_t n = 0;
    for (size_t i = 0; i < probes; i++)
        if (!n || at[i] - at[n - 1] > apart)
            at[n++] = at[i];
    g->at[axis] = at;
    g->count[axis] = n;
    return NULL;
}

size_t nodes_plane(const struct nodes *g, int axis, double x)
{
    size_t low = 0, high = g->count[axis] - 1;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (g->at[axis][middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return fabs(g->at[axis][high] - x) < fabs(g->at[axis][low] - x) ? high : low;
}

static struct error *place_probes(struct nodes *g, size_t probes, const double *position)
{
    struct error *err = array_create(&g->probe, probes, sizeof *g->probe);
    for (size_t i = 0; i < probes && !err; i++)
        g->probe[i] = -1;
    for (size_t i = 0; i < probes && !err; i++) {
        size_t node = 0;
        for (int k = 2; k >= 0; k--)
            node = node * g->count[k] + nodes_plane(g, k, position[3 * i + (size_t)k]);
        if (g->probe[node] >= 0)
            err = error_new(
                "the probes are not the nodes of a grid: probes %d and %zu are at one node",
                g->probe[node], i);
        else
            g->probe[node] = (int32_t)i;
    }
    return err;
}

struct error *nodes_planes(struct nodes *g, size_t probes, const double *position)
{
    *g = (struct nodes){0};
    struct error *err = probes ? NULL : error_new("there are no probes");
    for (int k = 0; k < 3 && !err; k++)
        err = find_planes(g, k, probes, position);
    if (err)
        nodes_clear(g);
    return err;
}

struct error *nodes_find(struct nodes *g, size_t probes, const double *position)
{
    struct error *err = nodes_planes(g, probes, position);
    if (err)
        return err;
    if ((double)g->count[0] * (double)g->count[1] * (double)g->count[2] != (double)probes)
        err = error_new("the probes are not the nodes of a grid: %zu probes have %zu, %zu and %zu "
                        "different coordinates x, y and z",
                        probes, g->count[0], g->count[1], g->count[2]);
    else
        err = place_probes(g, probes, position);
    if (err)
        nodes_clear(g);
    return err;
}

void nodes_clear(struct nodes *g)
{
    for (int k = 0; k < 3; k++)
        free(g->at[k]);
    free(g->probe);
    *g = (struct nodes){0};
}

/* The interval that holds x, brought within the ends: its first node; *x becomes 0 .. 1 within
 * it. */
static size_t interval(const struct nodes *g, int axis, double *x)
{
    const double *at = g->at[axis];
    const size_t n = g->count[axis];
    size_t low = 0, high = n - 1;
    if (n < 2 || *x <= at[0]) {
        *x = 0;
        return 0;
    }
    if (*x >= at[n - 1]) {
        *x = 1;
        return n - 2;
    }
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (at[middle] <= *x)
            low = middle;
        else
            high = middle;
    }
    *x = (*x - at[low]) / (at[low + 1] - at[low]);
    return low;
}

void nodes_linear(const struct nodes *g, int axis, double x, size_t node[4], double weight[4])
{
    const size_t low = interval(g, axis, &x);
    for (size_t i = 0; i < 4; i++) {
        node[i] = low + (i == 1 && g->count[axis] > 1);
        weight[i] = 0;
    }
    weight[0] = 1 - x;
    weight[1] = x;
}

/* Adds `factor` times the slope at node i, as weights of nodes first .. first + 3. */
static void add_slope(const struct nodes *g, int axis, size_t i, double factor, size_t first,
                      double weight[4])
{
    const double *at = g->at[axis];
    /* of the parabola's three nodes */
    const size_t n = g->count[axis], a = i == 0 ? 0 : i == n - 1 ? n - 3 : i - 1;
    /* the slope of Lagrange's polynomial of node j at node i */
    for (size_t j = a; j < a + 3; j++) {
        double slope = 0;
        for (size_t skip = a; skip < a + 3; skip++) {
            if (skip == j)
                continue;
            double term = 1 / (at[j] - at[skip]);
            for (size_t other = a; other < a + 3; other++)
                if (other != j && other != skip)
                    term *= (at[i] - at[other]) / (at[j] - at[other]);
            slope += term;
        }
        weight[j - first] += factor * slope;
    }
}

void nodes_cubic(const struct nodes *g, int axis, double x, size_t node[4], double weight[4])
{
    const size_t n = g->count[axis];
    if (n < 3) {
        nodes_linear(g, axis, x, node, weight);
        return;
    }
    const size_t low = interval(g, axis, &x), first = n < 4 || low == 0 ? 0
                                                      : low + 2 < n     ? low - 1
                                                                        : n - 4;
    const double h = g->at[axis][low + 1] - g->at[axis][low];
    for (size_t i = 0; i < 4; i++) {
        node[i] = first + i < n ? first + i : n - 1;
        weight[i] = 0;
    }
    weight[low - first] += (1 + 2 * x) * (1 - x) * (1 - x);
    weight[low + 1 - first] += x * x * (3 - 2 * x);
    add_slope(g, axis, low, h * x * (1 - x) * (1 - x), first, weight);
    add_slope(g, axis, low + 1, -h * x * x * (1 - x), first, weight);
}

void nodes_inverse(const double in[3], const double side[3], double weight[8])
{
    double distance[8], least = (double)INFINITY, sum = 0;
    for (int j = 0; j < 8; j++) {
        double square = 0;
        for (int k = 0; k < 3; k++) {
            const double off = (in[k] - (j >> k & 1)) * side[k];
            square += off * off;
        }
        distance[j] = sqrt(square);
        least = fmin(least, distance[j]);
    }
    for (int j = 0; j < 8; j++) /* in shares of the least: where that is 0, only it counts */
        sum += weight[j] = distance[j] > 0 ? least / distance[j] : 1;
    for (int j = 0; j < 8; j++)
        weight[j] /= sum;
}
