/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/cache_spots.h"
#include "base/array.h"
#include "base/error.h"
#include "capture/cache_points.h"
#include "interpolate/discs.h"
#include "math/random.h"
#include "trace/cache.h"

#include <stdlib.h>
#include <string.h>

/* The disc that a hit is a spot of. */
static uint32_t disc_of(const struct cache_points *points, const struct discs *discs, size_t hit)
{
    const double *p = points->hit_position + 3 * hit;
    const float *n = points->hit_normal + 3 * hit;
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
    return discs_draw(discs, p, normal, (float)(random_hash_position(p) >> 40) * 0x1p-24f);
}

struct error *cache_spots_find(struct cache_spots *spots, const struct cache_points *points,
                               const struct discs *discs)
{
    uint32_t *disc = NULL, *next = NULL;
    struct error *err = array_create(&disc, points->hits, sizeof *disc);
    if (!err)
        err = array_create(&next, points->count + 1, sizeof *next);
    if (!err)
        err = array_create(&spots->first, points->count + 2, sizeof *spots->first);
    if (!err)
        err = array_create(&spots->hit, points->hits, sizeof *spots->hit);
    for (size_t i = 0; i < points->hits && !err; i++) {
        disc[i] = disc_of(points, discs, i);
        if (disc[i] != CACHE_NONE)
            spots->first[disc[i] + 1]++;
    }
    for (size_t d = 0; d < points->count && !err; d++)
        next[d + 1] = spots->first[d + 1] += spots->first[d];
    for (size_t i = 0; i < points->hits && !err; i++)
        if (disc[i] != CACHE_NONE)
            spots->hit[next[disc[i]]++] = (uint32_t)i;
    free(disc);
    free(next);
    return err;
}

void cache_spots_clear(struct cache_spots *spots)
{
    free(spots->hit);
    free(spots->first);
    *spots = (struct cache_spots){0};
}
