/* SPDX-License-Identifier: Apache-2.0 */
/* cache_points: where the rays of probes meet surfaces, thinned to points of a cache.
 *
 * A hit at distance d from its probe stands for a disc of radius 2 s d, so that all discs fill
 * about the same share of what a probe sees; s is as small as the number of points allows. The
 * coarsest come first, and a hit is kept where no point that is kept and faces alike is nearer than
 * s d. The points depend on the set of probes, not on their order.
 */
#ifndef CACHE_POINTS_H
#define CACHE_POINTS_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct discs;
struct error;
struct path_tracer;

struct cache_points {
    double *position; /* 3 a point; owned, and so are: */
    float *normal;    /* 3 a point, unit, of the side that was met */
    float *radius;    /* half that of the disc: s d, or less where surfaces are near */
    float *reach;     /* s d; NULL in points that were not found */
    size_t count;
    double size; /* s */
    /* all hits that the points were chosen from: 3 a hit; owned */
    double *hit_position;
    float *hit_normal;
    size_t hits;
    bool full; /* there are as many as there may be, and room for more of that size */
};

/* The probes whose rays are traced. */
struct cache_probes {
    const double *position; /* 3 a probe */
    const float *normal;    /* 3 a probe; NULL: points */
    size_t count;
};

/* size: s at the least. No hits: no points. */
struct error *cache_points_find(struct cache_points *points, const struct path_tracer *path,
                                const struct cache_probes *probes, size_t most, double size,
                                uint64_t seed, int threads);

/* The hits alone, for points that were not found here: so that what gathers from hits does (see
 * cache_spots.h) as if they had been. */
struct error *cache_points_hits(struct cache_points *points, const struct path_tracer *path,
                                const struct cache_probes *probes, uint64_t seed, int threads);

/* The discs of points: twice these radii. */
struct error *cache_points_discs(const struct cache_points *points, const float *radius,
                                 struct discs **discs);
void cache_points_clear(struct cache_points *points);

#endif
