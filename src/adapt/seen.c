/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/seen.h"
#include "base/array.h"
#include "base/error.h"
#include "libprobe-query/sight.h"
#include "math/vec.h"
#include "trace/trace.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 64, PROBES = 64 }; /* around, of which a stand-in is one */

/* Weights below this are none where something is in the way: that saves a ray. */
static const double LEAST = 1e-3;

double seen_by(const struct seen_world *world, uint32_t a, uint32_t b)
{
    return (double)trace_visibility(world->tracer, world->position + 3 * (size_t)a,
                                    world->position + 3 * (size_t)b);
}

struct error *seen_reserve(struct seen_known *known, size_t count)
{
    if (count <= known->count)
        return NULL;
    struct error *err =
        array_reserve(&known->of, &known->room, count, SEEN_KNOWN * sizeof *known->of);
    for (size_t i = SEEN_KNOWN * known->count; i < SEEN_KNOWN * count && !err; i++)
        atomic_init(&known->of[i], 0);
    known->count = err ? known->count : count;
    return err;
}

void seen_clear(struct seen_known *known)
{
    free(known->of);
    *known = (struct seen_known){0};
}

double seen_probe(const struct seen_world *world, uint32_t x, uint32_t probe)
{
    const uint32_t place = (probe * 0x9e3779b1U) >> 16 & (SEEN_KNOWN - 1);
    _Atomic uint64_t *known = &world->known->of[SEEN_KNOWN * (size_t)x + place];
    const uint64_t was = atomic_load_explicit(known, memory_order_relaxed);
    float seen;
    uint32_t bits = (uint32_t)was;
    if (was >> 32 != (uint64_t)probe + 1) {
        seen = (float)seen_by(world, x, probe);
        memcpy(&bits, &seen, sizeof bits);
        atomic_store_explicit(known, ((uint64_t)probe + 1) << 32 | bits, memory_order_relaxed);
    }
    memcpy(&seen, &bits, sizeof seen);
    return (double)seen;
}

struct near_probe {
    double square; /* of the distance */
    uint32_t candidate;
};

static int compare(const void *a, const void *b)
{
    const struct near_probe *p = a, *q = b;
    if (p->square != q->square)
        return p->square < q->square ? -1 : 1;
    return p->candidate < q->candidate ? -1 : p->candidate > q->candidate;
}

/* The cell and those around it, nearest by faces first. */
static size_t find_cells(const struct seen_world *world, int32_t first, int32_t cell[CELLS])
{
    size_t count = 1;
    cell[0] = first;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 4 && count < CELLS; k++) {
            const int32_t next = world->neighbour[4 * (size_t)cell[i] + k];
            size_t j = 0;
            while (j < count && cell[j] != next)
                j++;
            if (next >= 0 && j == count)
                cell[count++] = next;
        }
    return count;
}

/* Their probes, the nearest to candidate x first. */
static size_t find_probes(const struct seen_world *world, uint32_t x, int32_t first,
                          struct near_probe probe[PROBES])
{
    const struct vec3 p = vec3_load(world->position + 3 * (size_t)x);
    int32_t cell[CELLS];
    const size_t cells = find_cells(world, first, cell);
    size_t count = 0;
    for (size_t i = 0; i < 4 * cells && count < PROBES; i++) {
        const uint32_t from = world->probe[world->vertex[4 * (size_t)cell[i / 4] + i % 4]];
        size_t j = 0;
        while (j < count && probe[j].candidate != from)
            j++;
        if (j < count)
            continue;
        const struct vec3 way = vec3_sub(vec3_load(world->position + 3 * (size_t)from), p);
        probe[count++] = (struct near_probe){vec3_dot(way, way), from};
    }
    qsort(probe, count, sizeof *probe, compare);
    return count;
}

static void stand_in(const struct seen_world *world, uint32_t x, struct blend *blend)
{
    struct near_probe probe[PROBES];
    const size_t count = find_probes(world, x, blend->cell, probe);
    for (size_t i = 0; i < count; i++)
        if (seen_probe(world, x, probe[i].candidate) > 0.5) {
            for (int k = 0; k < 4; k++)
                blend->weight[k] = k == 0;
            blend->from[0] = probe[i].candidate;
            break;
        }
}

void seen_weigh(const struct seen_world *world, uint32_t x, struct blend *blend)
{
    double weight[4], sum = 0;
    blend->hidden = blend->stood_in = false;
    for (int k = 0; k < 4; k++) {
        const double seen = blend->weight[k] < LEAST ? 0 : seen_probe(world, x, blend->from[k]);
        blend->hidden = blend->hidden || (blend->weight[k] >= LEAST && seen < 1);
        weight[k] = blend->weight[k] * seen;
        sum += weight[k];
    }
    blend->stood_in = sum < SIGHT_ENOUGH;
    if (!blend->hidden)
        return;
    if (blend->stood_in)
        stand_in(world, x, blend);
    else
        for (int k = 0; k < 4; k++)
            blend->weight[k] = weight[k] / sum;
}
