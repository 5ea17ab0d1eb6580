/* SPDX-License-Identifier: Apache-2.0 */
/* cache_options: which cache of surfaces' light a capture uses (capture_cache.h), and its keys in a
 * stream's header. */
#ifndef CACHE_OPTIONS_H
#define CACHE_OPTIONS_H

struct error;
struct stream_header;

struct cache_options {
    const char *name; /* NULL: no cache; "auto": one is made; else of a stream. Borrowed */
    int after;        /* paths end where they have scattered so often: at least 1 */
    double error;     /* the share of a probe's light that the cache may change */
};

/* The key of a stream that is a cache whose light is not only what surfaces scatter: "sky", that
 * which comes straight from the sky, too. */
#define CACHE_HOLDS "capture-cache-holds"

/* No cache; after 1; 2 %. */
struct cache_options cache_options_default(void);

/* As header keys capture-cache, capture-cache-after and capture-cache-error, where there is a cache
 * at all, and back: the name is the header's, and missing keys leave what there is. A header that
 * is written loses CACHE_HOLDS. */
struct error *cache_options_to_header(const struct cache_options *options,
                                      struct stream_header *header);
struct error *cache_options_from_header(struct cache_options *options,
                                        const struct stream_header *header);

#endif
