/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/cache_options.h"
#include "base/error.h"
#include "base/options.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <string.h>

enum { AFTER_MOST = 1 << 16 };

struct cache_options cache_options_default(void)
{
    return (struct cache_options){.after = 1, .error = 0.02};
}

const struct option_row *cache_option_rows(struct cache_options *options, struct option_row *rows)
{
    const struct option_row all[CACHE_OPTION_ROWS] = {
        {.name = "cache",
         .argument = "auto|FILE",
         .kind = OPTION_TEXT,
         .value = &options->name,
         .given = &options->name_given,
         .shown = "off",
         .help = "end paths in a cache of the surfaces' indirect light, which\n"
                 "is made, or read from FILE; off: none"},
        {.name = "cache-error",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .value = &options->error,
         .given = &options->error_given,
         .parse = options_share,
         .shown = "2%",
         .help = "share of a probe's light that the cache may change"},
        {.name = "cache-after",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->after,
         .given = &options->after_given,
         .least = 1,
         .most = AFTER_MOST,
         .help = "paths end in it where they have scattered so often"},
        {.name = "cache-renew",
         .kind = OPTION_FLAG,
         .value = &options->renew,
         .help = "where FILE has other light than the scene, gather the scene's\n"
                 "at its points"},
        {0}};
    memcpy(rows, all, sizeof all);
    return rows;
}

struct error *cache_options_check(struct cache_options *options)
{
    if (options->name && !strcmp(options->name, "off"))
        options->name = NULL;
    if (options->name && !*options->name)
        return error_usage("--cache: expected auto, a file's name or off, got ''");
    return options->error > 0
               ? NULL
               : error_usage("--cache-error: expected a share above 0, got %g", options->error);
}

struct error *cache_options_to_header(const struct cache_options *options,
                                      struct stream_header *header)
{
    header_remove_key(header, "capture-cache");
    header_remove_key(header, "capture-cache-after");
    header_remove_key(header, "capture-cache-error");
    header_remove_key(header, CACHE_HOLDS);
    header_remove_key(header, CACHE_SURFACES);
    if (!options->name)
        return NULL;
    struct error *err = header_set_key(header, "capture-cache", options->name);
    if (!err)
        err = header_set_whole(header, "capture-cache-after", options->after);
    return err ? err : header_set_real(header, "capture-cache-error", options->error);
}

struct error *cache_options_from_header(struct cache_options *options,
                                        const struct stream_header *header)
{
    struct cache_options was = *options;
    const char *name = header_key(header, "capture-cache");
    struct error *err = header_get_int(header, "capture-cache-after", 1, AFTER_MOST, &was.after);
    if (!err)
        err = header_get_real(header, "capture-cache-error", 0, 1, &was.error);
    if (err)
        return err;
    relit_key(header, options->relit);
    if (!options->name_given && name)
        options->name = name;
    if (!options->after_given)
        options->after = was.after;
    if (!options->error_given)
        options->error = was.error;
    return NULL;
}

struct error *cache_options_check_renew(const struct cache_options *options)
{
    const bool read = options->name && strcmp(options->name, "auto") != 0;
    return options->renew && !read ? error_usage("--cache-renew needs --cache FILE") : NULL;
}
