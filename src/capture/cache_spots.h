/* SPDX-License-Identifier: Apache-2.0 */
/* cache_spots: where on its disc a point of a cache gathers.
 *
 * The irradiance at the middle of a disc is not what paths that end on the disc would find in the
 * mean: it is too bright where the middle is, and so are all probes. So each hit that the points
 * were chosen from is a spot of one of the discs that cover it, drawn by what they count there; a
 * disc that gathers from its spots holds the mean over what probes see of it.
 */
#ifndef CACHE_SPOTS_H
#define CACHE_SPOTS_H

#include <stddef.h>
#include <stdint.h>

struct cache_points;
struct discs;
struct error;

struct cache_spots {
    uint32_t *hit;   /* of the points' hits, disc by disc; owned */
    uint32_t *first; /* of each disc, and one more; owned */
};

struct error *cache_spots_find(struct cache_spots *spots, const struct cache_points *points,
                               const struct discs *discs);
void cache_spots_clear(struct cache_spots *spots);

#endif
