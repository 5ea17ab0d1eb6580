/* SPDX-License-Identifier: Apache-2.0 */
/* cache: the indirect light of surfaces, kept for paths that end there.
 *
 * A cache is a set of oriented discs (interpolate/discs.h) with the irradiance of each that comes
 * from light which scattered at least once. A path that has scattered `after` times and is where
 * discs cover the surface ends: light straight from lights and sky is asked there as ever, one ray
 * finds what the way on would have met straight, and the discs say the rest. Where no disc covers
 * the surface, the path goes on. Based on: Bikker and Reijerse, "A precalculated point set for
 * caching shading information", Eurographics short papers, 2009.
 *
 * cache_solve finds the irradiance by gathering: E = direct + F E, where each disc's rays tell its
 * row of F, which is radiosity (Goral et al., "Modeling the interaction of light between diffuse
 * surfaces", SIGGRAPH 1984) without patches.
 */
#ifndef CACHE_H
#define CACHE_H

#include "libprobe-query/sh.h"
#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct discs;
struct error;
struct lit;

struct path_cache {
    struct discs *discs; /* owned */
    float *value;        /* indirect irradiance, 3 a disc; owned. NULL: paths tell the disc that
                              * they would have read (struct path_sample) */
    size_t count;        /* of discs */
    int after;           /* at least 1 */
    bool sky;            /* the values hold the light that comes straight from the sky, too */
    bool opens;          /* receivers ask for an even sky where it is open (path_open) */
    /* Paths go on as if there were no cache, and what they tell is the light that they find less
     * what the cache would have said: where it is read first, and 0 where it never is. */
    bool check;
    struct lit *lit; /* sunlit points; owned; NULL: none */
    /* Root mean square of what it changes in a coefficient of each band, as a share of the length
     * of a receiver's light. */
    double error[SH_ORDER_MAX];
};

#define CACHE_NONE UINT32_MAX /* no disc */

/* What a row of F is made of: a ray of a disc that ended at another, with the share of that one's
 * irradiance that it brings, 3 colours: to be summed and divided by the disc's rays. */
struct cache_link {
    uint32_t disc; /* CACHE_NONE: none */
    float share[3];
};

/* Solves for the irradiance of all discs: `direct` (3 a disc) is what they have of light that
 * scattered once, and of what comes straight, which stands alone in `straight` as well (NULL:
 * nothing), links: `rays` a disc. Up to `scatters` times is light passed on, and no more when
 * nothing changes. value: 3 a disc, written. */
struct error *cache_solve(size_t discs, int rays, const float *straight, const float *direct,
                          const struct cache_link *link, int scatters, int threads, float *value);

void cache_clear(struct path_cache *cache);

#endif
