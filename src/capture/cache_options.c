/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/cache_options.h"
#include "base/error.h"
#include "stream/header_number.h"
#include "stream/stream.h"

enum { AFTER_MOST = 1 << 16 };

struct cache_options cache_options_default(void)
{
    return (struct cache_options){.after = 1, .error = 0.02};
}

struct error *cache_options_to_header(const struct cache_options *options,
                                      struct stream_header *header)
{
    header_remove_key(header, "capture-cache");
    header_remove_key(header, "capture-cache-after");
    header_remove_key(header, "capture-cache-error");
    header_remove_key(header, CACHE_HOLDS);
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
    const char *name = header_key(header, "capture-cache");
    options->name = name ? name : options->name;
    struct error *err =
        header_get_int(header, "capture-cache-after", 1, AFTER_MOST, &options->after);
    return err ? err : header_get_real(header, "capture-cache-error", 0, 1, &options->error);
}
