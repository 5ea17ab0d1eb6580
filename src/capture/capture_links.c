/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_links.h"
#include "base/error.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "libprobe-query/discs.h"
#include "stream/stream.h"

#include <stdlib.h>

struct error *capture_links_read(struct capture_links *links, const char *path, int count)
{
    links->on = true;
    return senders_read(&links->senders, path, (size_t)count);
}

struct error *capture_links_take(struct capture_links *links, struct stream_reader *reader,
                                 struct table *schema, const struct stream_header *header)
{
    size_t got;
    struct error *err = stream_reader_rows(reader, schema, SIZE_MAX, &got);
    links->on = true;
    return err ? err : senders_from_table(&links->senders, schema, header);
}

struct error *capture_links_columns(const struct capture_links *links,
                                    const struct capture_settings *settings, struct table *table)
{
    return links->on ? senders_add_columns(&links->senders, settings->order, table) : NULL;
}

struct error *capture_links_start(struct capture_links *links, const struct path_tracer *path,
                                  const struct capture_settings *settings, int threads)
{
    if (!links->on)
        return NULL;
    struct error *err = senders_discs(&links->senders, &links->discs);
    links->capture = (struct capture_senders){.path = path,
                                              .senders = &links->senders,
                                              .discs = links->discs,
                                              .order = settings->order,
                                              .convolved = settings->convolved,
                                              .rays = settings->rays,
                                              .seed = settings->seed,
                                              .threads = threads};
    if (!err && !links->senders.link)
        err = capture_senders_link(&links->capture, &links->senders);
    return err;
}

struct error *capture_links_write(const struct capture_links *links, struct stream_writer *writer)
{
    struct table table = {0};
    if (!links->on)
        return NULL;
    struct error *err = senders_to_table(&links->senders, &table);
    if (!err)
        err = stream_writer_table(writer, &table);
    if (!err)
        err = stream_writer_rows(writer, &table, 0, table.rows);
    table_clear(&table);
    return err;
}

struct error *capture_links_rows(struct capture_links *links, struct table *table, size_t first,
                                 size_t count)
{
    return links->on ? capture_senders_rows(&links->capture, table, first, count) : NULL;
}

size_t capture_links_bytes(const struct capture_links *links)
{
    const size_t sender = 3 * sizeof(double) + 8 * sizeof(float) + sizeof(int32_t),
                 link = sizeof(int32_t) + sizeof(float);
    return links->on ? links->senders.count * (sender + links->senders.links * link) : 0;
}

void capture_links_warn(const struct capture_links *links, struct warnings *warnings)
{
    const struct capture_senders *c = &links->capture;
    const double met = (double)(c->met ? c->met : 1);
    if (!links->on || (double)(c->alone + c->far) <= 0.02 * met)
        return;
    warnings_add(
        warnings, "senders",
        "--transfer surfaces: %.1f %% of what rays met has no sender near, and %.1f %% none "
        "that faces alike, whose light is lost (more senders: probe-place poisson "
        "--count)",
        100 * (double)c->far / met, 100 * (double)c->alone / met);
}

void capture_links_clear(struct capture_links *links)
{
    senders_clear(&links->senders);
    discs_destroy(links->discs);
    *links = (struct capture_links){0};
}
