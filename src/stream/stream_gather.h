/* SPDX-License-Identifier: Apache-2.0 */
/* stream_gather: one stream in memory from several: merged, then filled from others.
 *
 * Where streams were cut short or damaged, what is whole of them can be taken (stream_salvage).
 */
#ifndef STREAM_GATHER_H
#define STREAM_GATHER_H

#include "stream/stream.h"

struct warnings;

/* Which streams; paths are borrowed, and outlive the warnings. */
struct stream_sources {
    const char **paths; /* are merged in this order; at least one */
    size_t count;
    const char **fills; /* what is missing is taken from these, in this order */
    size_t fill_count;
    bool salvage; /* all may be damaged */
};

struct error *stream_gather(struct stream **stream, const struct stream_sources *sources,
                            struct warnings *warnings);

#endif
