/* SPDX-License-Identifier: Apache-2.0 */
/* capture_links: the senders of a stream that is captured (senders.h), from where they come from to
 * where they are written.
 *
 *     capture_links_read(&links, "senders.probe", 256)       what --transfer surfaces asks for, or
 *     capture_links_take(&links, reader, &schema, header)      table sender of the stream
 *     capture_links_start(&links, path, settings, threads)     theirs are captured
 *     capture_links_write(&links, writer)                      before table probe
 *     capture_links_rows(&links, table, first, count)          those of probes
 *     capture_links_clear(&links)
 */
#ifndef CAPTURE_LINKS_H
#define CAPTURE_LINKS_H

#include "capture/capture_senders.h"

struct capture_settings;
struct stream_reader;
struct stream_writer;
struct warnings;

/* Starts as {0}. */
struct capture_links {
    bool on;
    struct senders senders;
    struct discs *discs; /* owned */
    struct capture_senders capture;
};

struct error *capture_links_read(struct capture_links *links, const char *path, int count);
struct error *capture_links_take(struct capture_links *links, struct stream_reader *reader,
                                 struct table *schema, const struct stream_header *header);

/* The rest does nothing where there are none. */
struct error *capture_links_columns(const struct capture_links *links,
                                    const struct capture_settings *settings, struct table *table);
struct error *capture_links_start(struct capture_links *links, const struct path_tracer *path,
                                  const struct capture_settings *settings, int threads);
struct error *capture_links_write(const struct capture_links *links, struct stream_writer *writer);
struct error *capture_links_rows(struct capture_links *links, struct table *table, size_t first,
                                 size_t count);

/* Bytes of table sender. */
size_t capture_links_bytes(const struct capture_links *links);

/* That surfaces have no senders. */
void capture_links_warn(const struct capture_links *links, struct warnings *warnings);
void capture_links_clear(struct capture_links *links);

#endif
