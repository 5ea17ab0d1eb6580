/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/stream_gather.h"
#include "base/error.h"
#include "stream/stream_edit.h"
#include "stream/stream_fill.h"
#include "stream/stream_salvage.h"

static struct error *read_one(struct stream **stream, const char *path, bool salvage,
                              struct warnings *warnings)
{
    return salvage ? stream_salvage(stream, path, warnings) : stream_read(stream, path);
}

static struct error *merge(struct stream *all, const char *path, bool salvage,
                           struct warnings *warnings)
{
    struct stream *one = NULL;
    struct error *err = read_one(&one, path, salvage, warnings);
    if (!err)
        err = error_wrap(stream_merge(all, one, warnings), "%s", path);
    stream_destroy(one);
    return err;
}

static struct error *fill(struct stream *all, const char *path, bool salvage,
                          struct warnings *warnings)
{
    struct stream *one = NULL;
    struct error *err = read_one(&one, path, salvage, warnings);
    if (!err)
        err = stream_fill(all, one, path, warnings);
    stream_destroy(one);
    return err;
}

struct error *stream_gather(struct stream **stream, const struct stream_sources *sources,
                            struct warnings *warnings)
{
    const struct stream_sources *s = sources;
    struct error *err = read_one(stream, s->paths[0], s->salvage, warnings);
    for (size_t i = 1; i < s->count && !err; i++)
        err = merge(*stream, s->paths[i], s->salvage, warnings);
    for (size_t i = 0; i < s->fill_count && !err; i++)
        err = fill(*stream, s->fills[i], s->salvage, warnings);
    return err;
}
