/* SPDX-License-Identifier: Apache-2.0 */
/* capture_cache: a cache of surfaces' indirect light (trace/cache.h) for the probes of a stream.
 *
 *     err = capture_cache_open(&cache, &path, &settings, &options, scene, &probes, threads);
 *     ... capture: paths of `path` end in the cache, where cache.on ...
 *     err = capture_cache_write(&cache, "cache.probe", &header);
 *     path_use_cache(&path, NULL);
 *     capture_cache_clear(&cache);
 *
 * It is read from a stream of surface probes, or made: then its points are where the probes' rays
 * meet surfaces (cache_points.h). Each gathers by rays of its own, from all over its disc
 * (cache_spots.h); those that end at other points are rows of a system which is solved for all
 * light at once (cache_solve). What the cache changes is measured: a few of the probes take their
 * paths on as if there were none, and compare (path_cache.check). Where that is more than it may be
 * the cache is made anew, finer, or left off. Before, a pilot tells what the best of caches would
 * spare; where that is little none is made. A stream of other light (another sun, lamp,
 * sky or albedo) that is to be renewed gives its points alone, which gather in the same way.
 */
#ifndef CAPTURE_CACHE_H
#define CAPTURE_CACHE_H

#include "capture/cache_options.h"
#include "capture/cache_points.h"
#include "capture/capture.h"
#include "trace/cache.h"

struct capture_cache {
    struct path_cache cache;
    struct cache_points points;
    float *half; /* irradiance by the first half of the rays, 3 a point; owned; NULL: it was read */
    bool on;
    int rays;       /* of each point; 0: its light was read: */
    int read_rays;  /* what its stream says of them */
    char told[320]; /* for the user: what was made of the option */
};

/* scene: what `path` traces, for what a stream's header says of its own. Error: the stream is no
 * cache, or one of another scene, light or setting. capture_cache_clear is legal, and needed, on
 * error too. */
struct error *capture_cache_open(struct capture_cache *cache, struct path_tracer *path,
                                 const struct capture_settings *settings,
                                 const struct cache_options *options, const struct scene *scene,
                                 const struct cache_probes *probes, int threads);

/* The same for rows of a table of probes. */
struct error *capture_cache_open_rows(struct capture_cache *cache, struct path_tracer *path,
                                      const struct capture_settings *settings,
                                      const struct cache_options *options,
                                      const struct scene *scene, const struct table *table,
                                      size_t first, size_t count, int threads);

/* Writes the points with their radii and irradiance. header: of the stream that is captured. */
struct error *capture_cache_write(const struct capture_cache *cache, const char *path,
                                  const struct capture_settings *settings,
                                  const struct scene *scene, const struct stream_header *header);
void capture_cache_clear(struct capture_cache *cache);

#endif
