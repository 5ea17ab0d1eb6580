/* SPDX-License-Identifier: Apache-2.0 */
/* cache_gather: the irradiance of a cache's discs.
 *
 * Each point gathers by rays of its own, from all over its disc (cache_spots.h): what they meet
 * that has no disc is added at once; those that end on other discs are rows of a system that is
 * solved for all light (cache_solve): radiosity by gathering.
 */
#ifndef CACHE_GATHER_H
#define CACHE_GATHER_H

struct cache_points;
struct capture_settings;
struct error;
struct path_cache;
struct path_tracer;

/* Sets the value of a cache whose discs are those of `points`, by so many rays a point, and says
 * whether it holds the sky. *half: 3 a point, the irradiance by the first half of the rays; the
 * caller frees it, after an error too. */
struct error *cache_gather(struct path_cache *cache, const struct cache_points *points, int rays,
                           struct path_tracer *path, const struct capture_settings *settings,
                           int threads, float **half);

#endif
