/* SPDX-License-Identifier: Apache-2.0 */
/* cache_options: which cache of surfaces' light a capture uses (capture_cache.h): the options that
 * say so, the same in every program that captures, and the keys in a stream's header.
 *
 *     struct option_row rows[CACHE_OPTION_ROWS];
 *     ... groups[] = {cache_option_rows(&cache, rows), ...} ... options_parse ...
 *     err = cache_options_check(&cache);
 *     err = cache_options_from_header(&cache, header);
 */
#ifndef CACHE_OPTIONS_H
#define CACHE_OPTIONS_H

#include "scene/relit.h"

#include <stdbool.h>

struct error;
struct option_row;
struct stream_header;

struct cache_options {
    const char *name; /* NULL: no cache; "auto": one is made; else of a stream. Borrowed */
    int after;        /* paths end where they have scattered so often: at least 1 */
    double error;     /* the share of a probe's light that the cache may change */
    bool renew;       /* light of a stream that is not that of the scene is gathered anew */
    bool name_given, after_given, error_given; /* on the command line */
    char relit[RELIT_KEY_ROOM];                /* what became of the probes' light (relit_key) */
};

/* The key of a stream that is a cache whose light is not only what surfaces scatter: "sky", that
 * which comes straight from the sky, too. */
#define CACHE_HOLDS "capture-cache-holds"

/* The key of a stream that is a cache for the surfaces that its points are on (scene_surface_key),
 * in hexadecimal. */
#define CACHE_SURFACES "capture-cache-surfaces"

/* No cache; after 1; 2 %. */
struct cache_options cache_options_default(void);

enum { CACHE_OPTION_ROWS = 5 };

/* Fills rows with --cache, --cache-error, --cache-after and --cache-renew, which write into
 * options, and returns them. */
const struct option_row *cache_option_rows(struct cache_options *options, struct option_row *rows);

/* What was parsed: "off" becomes NULL. */
struct error *cache_options_check(struct cache_options *options);

/* As header keys capture-cache, capture-cache-after and capture-cache-error, where there is a cache
 * at all, and back: the name is the header's, missing keys leave what there is, and what the
 * command line gave stays. A header that is written loses CACHE_HOLDS and CACHE_SURFACES. */
struct error *cache_options_to_header(const struct cache_options *options,
                                      struct stream_header *header);
struct error *cache_options_from_header(struct cache_options *options,
                                        const struct stream_header *header);

/* That there is a file to renew, by the command line or the header. */
struct error *cache_options_check_renew(const struct cache_options *options);

#endif
