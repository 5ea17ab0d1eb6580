/* SPDX-License-Identifier: Apache-2.0 */
/* Which of its cell's probes a point sees (sight.h). */
#include "sight.h"
#include "volume.h"

#include <stdlib.h>

static inline bool sees_all(const uint16_t *sight, size_t width)
{
    uint16_t any = 0;
    if (width == 12) {
        uint64_t four[3];
        memcpy(four, sight, sizeof four);
        return !(four[0] | four[1] | four[2]);
    }
    for (size_t i = 0; i < width; i++)
        any |= sight[i];
    return !any;
}

/* Weights, of that sum, to a place. A stand-in (-1: there is none) has what is missing to enough,
 * in the place of the corner that has least. */
static void give(int corners, double weight[4], double sum, int32_t stand_in,
                 struct probe_place *place)
{
    if (stand_in >= 0) {
        int least = 0;
        for (int i = 1; i < corners; i++)
            least = weight[i] < weight[least] ? i : least;
        place->probe[least] = stand_in;
        weight[least] += SIGHT_ENOUGH - sum;
        sum = SIGHT_ENOUGH;
    }
    for (int i = 0; i < corners; i++)
        place->weight[i] = weight[i] / sum;
}

void volume_see(const struct probe_volume *v, struct probe_place *place)
{
    const int n = v->corners;
    const size_t cell = (size_t)place->cell, width = (size_t)sight_width(n);
    const uint16_t *sight = v->sight + width * cell;
    if (sees_all(sight, width))
        return;
    double weight[4] = {0};
    double sum = n == 4 ? sight_weights(4, sight, place->weight, weight) /* unrolled */
                        : sight_weights(n, sight, place->weight, weight);
    const int32_t stand_in = sum < SIGHT_ENOUGH ? volume_index(v->stand_in, v->stand_in_bytes, cell)
                                                : -1;
    give(n, weight, sum, stand_in, place);
}

const struct volume_beyond *volume_beyond_of(const struct probe_volume *v, int32_t cell)
{
    size_t low = 0, high = v->beyonds;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (v->beyond[middle].cell < cell)
            low = middle + 1;
        else
            high = middle;
    }
    return low < v->beyonds && v->beyond[low].cell == cell ? &v->beyond[low] : NULL;
}

void volume_see_outside(const struct probe_volume *v, const double p[3], struct probe_place *place)
{
    const struct volume_beyond *beyond = volume_beyond_of(v, place->cell);
    double off[3], weight[4];
    if (!beyond) {
        volume_see(v, place);
        return;
    }
    for (int k = 0; k < 3; k++) {
        off[k] = p[k];
        for (int i = 0; i < 4; i++)
            off[k] -= place->weight[i] * volume_site(v, place->probe[i])[k];
        off[k] *= v->lattice.step;
    }
    const double sum =
        sight_weights_outside(v->sight + (size_t)sight_width(4) * (size_t)place->cell,
                              beyond->slope, place->weight, off, weight);
    if (sum > 0) /* or too far away for any */
        give(4, weight, sum, sum < SIGHT_ENOUGH ? beyond->stand_in : -1, place);
}

/* -- making ----------------------------------------------------------------------------------- */

enum probe_status volume_check_sight(const struct probe_volume *v, size_t *row)
{
    const size_t width = (size_t)sight_width(v->corners);
    for (*row = 0; v->sight && *row < v->cells; ++*row) {
        for (size_t i = 0; i < width; i++)
            if (!half_finite(v->sight[width * *row + i]))
                return PROBE_BAD_SIGHT;
        const int32_t stand_in = volume_index(v->stand_in, v->stand_in_bytes, *row);
        if (stand_in < -1 || stand_in >= (int64_t)v->probes)
            return PROBE_BAD_SIGHT;
    }
    for (size_t i = 0; i < v->beyonds; i++) {
        const struct volume_beyond *b = &v->beyond[i];
        *row = b->cell >= 0 && (uint64_t)b->cell < v->cells ? (size_t)b->cell : 0;
        if (b->cell < 0 || (uint64_t)b->cell >= v->cells || b->stand_in < -1 ||
            b->stand_in >= (int64_t)v->probes || (i && b->cell <= v->beyond[i - 1].cell))
            return PROBE_BAD_SIGHT;
        for (int k = 0; k < 12; k++)
            if (!isfinite(b->slope[k]))
                return PROBE_BAD_SIGHT;
    }
    *row = 0;
    return PROBE_OK;
}

static void forget_outside(struct probe_volume *v)
{
    v->bytes -= v->beyond_owned ? v->beyonds * sizeof *v->beyond : 0;
    free(v->beyond_owned);
    v->beyond_owned = NULL;
    v->beyond = NULL;
    v->beyonds = 0;
}

/* The bits that any of an even number of floats has. */
static inline uint64_t bits_of(const float *x, size_t count)
{
    uint64_t any = 0, two;
    for (size_t i = 0; i < count; i += 2) {
        memcpy(&two, x + i, sizeof two);
        any |= two;
    }
    return any;
}

/* In most cells nothing stands. */
static void halve_sight(const float *sight, size_t width, uint16_t *half)
{
    if (!bits_of(sight, width)) {
        memset(half, 0, width * sizeof *half);
        return;
    }
    for (size_t i = 0; i < width; i++)
        half[i] = isfinite(sight[i]) ? half_of(sight[i]) : 0x7c00;
}

enum probe_status probe_volume_set_sight(struct probe_volume *v, const float *sight,
                                         const int32_t *stand_in, size_t *row)
{
    const size_t width = (size_t)sight_width(v->corners);
    const size_t halves = (width * v->cells * sizeof(uint16_t) + 3) / 4 * 4;
    size_t nowhere;
    row = row ? row : &nowhere;
    *row = 0;
    forget_outside(v);
    v->bytes -= v->sight_owned ? halves + v->cells * sizeof(int32_t) : 0;
    free(v->sight_owned);
    v->sight_owned = NULL;
    v->sight = NULL;
    v->stand_in = NULL;
    if (!sight)
        return PROBE_OK;
    char *owned = malloc(halves + v->cells * sizeof(int32_t));
    if (!owned)
        return PROBE_NO_MEMORY;
    uint16_t *half = (uint16_t *)(void *)owned;
    int32_t *other = (int32_t *)(void *)(owned + halves);
    for (size_t i = 0; i < v->cells; i++)
        halve_sight(sight + width * i, width, half + width * i);
    for (size_t i = 0; i < v->cells; i++)
        other[i] = stand_in ? stand_in[i] : -1;
    v->sight = half;
    v->stand_in = other;
    v->stand_in_bytes = 4;
    v->sight_owned = owned;
    v->bytes += halves + v->cells * sizeof(int32_t);
    const enum probe_status status = volume_check_sight(v, row);
    if (status) {
        const size_t where = *row;
        probe_volume_set_sight(v, NULL, NULL, NULL);
        *row = where;
    }
    return status;
}

/* Whether there is anything to know of a cell. */
static bool is_beyond(const float *slope, int32_t stand_in)
{
    return stand_in >= 0 || bits_of(slope, 12) & 0x7fffffff7fffffff; /* -0 is 0 */
}

enum probe_status probe_volume_set_sight_outside(struct probe_volume *v, const float *slope,
                                                 const int32_t *stand_in, size_t *row)
{
    size_t nowhere, count = 0;
    row = row ? row : &nowhere;
    *row = 0;
    forget_outside(v);
    if (!slope)
        return PROBE_OK;
    if (v->corners != 4 || !v->sight)
        return PROBE_BAD_ARGUMENT;
    for (size_t i = 0; i < v->cells; i++)
        count += is_beyond(slope + 12 * i, stand_in ? stand_in[i] : -1);
    struct volume_beyond *beyond = malloc((count + 1) * sizeof *beyond);
    if (!beyond)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < v->cells; i++) {
        const int32_t other = stand_in ? stand_in[i] : -1;
        if (!is_beyond(slope + 12 * i, other))
            continue;
        beyond[v->beyonds] = (struct volume_beyond){.cell = (int32_t)i, .stand_in = other};
        memcpy(beyond[v->beyonds++].slope, slope + 12 * i, sizeof beyond->slope);
    }
    v->beyond = v->beyond_owned = beyond;
    v->bytes += v->beyonds * sizeof *beyond;
    const enum probe_status status = volume_check_sight(v, row);
    if (status)
        forget_outside(v);
    return status;
}

int probe_volume_sees(const struct probe_volume *v)
{
    return v->sight != NULL;
}
