/* SPDX-License-Identifier: Apache-2.0 */
/* Which of its cell's probes a point sees (sight.h). */
#include "sight.h"
#include "volume.h"

#include <stdlib.h>

static bool sees_all(const uint16_t *sight, size_t width)
{
    uint16_t any = 0;
    for (size_t i = 0; i < width; i++)
        any |= sight[i];
    return !any;
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
    if (stand_in >= 0) { /* in the place of the corner that has least */
        int least = 0;
        for (int i = 1; i < n; i++)
            least = weight[i] < weight[least] ? i : least;
        place->probe[least] = stand_in;
        weight[least] += SIGHT_ENOUGH - sum;
        sum = SIGHT_ENOUGH;
    }
    for (int i = 0; i < n; i++)
        place->weight[i] = weight[i] / sum;
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
    *row = 0;
    return PROBE_OK;
}

enum probe_status probe_volume_set_sight(struct probe_volume *v, const float *sight,
                                         const int32_t *stand_in, size_t *row)
{
    const size_t width = (size_t)sight_width(v->corners);
    const size_t halves = (width * v->cells * sizeof(uint16_t) + 3) / 4 * 4;
    size_t nowhere;
    row = row ? row : &nowhere;
    *row = 0;
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
    for (size_t i = 0; i < width * v->cells; i++)
        half[i] = isfinite(sight[i]) ? half_of(sight[i]) : 0x7c00;
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

int probe_volume_sees(const struct probe_volume *v)
{
    return v->sight != NULL;
}
