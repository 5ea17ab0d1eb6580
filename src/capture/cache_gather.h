/* SPDX-License-Identifier: Apache-2.0 */
/* cache_gather: the irradiance of a cache's discs.
 *
 * Each point gathers by rays of its own, from all over its disc (cache_spots.h): what they meet
 * that has no disc is added at once; those that end on other discs are rows of a system that is
 * solved for all light (cache_solve): radiosity by gathering.
 */
#ifndef CACHE_GATHER_H
#define CACHE_GATHER_H

struct capture_cache;
struct capture_settings;
struct error;
struct path_tracer;

/* Sets cache->cache.value and cache->half of cache->points, of which each has cache->rays rays, and
 * says whether they hold the sky. Discs are there. */
struct error *cache_gather(struct capture_cache *cache, struct path_tracer *path,
                           const struct capture_settings *settings, int threads);

#endif
