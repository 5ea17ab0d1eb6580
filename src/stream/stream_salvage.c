/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/stream_salvage.h"
#include "base/error.h"
#include "base/warning.h"
#include "stream/cells.h"
#include "stream/stream_private.h"

#include <string.h>

/* Shortage of memory is no damage of the stream. */
static struct error *sort_error(struct error *err, struct error **damage)
{
    if (err == error_memory())
        return err;
    *damage = err;
    return NULL;
}

/* Reads one table as far as it goes. *within: the damage is in its rows. */
static struct error *read_table(struct stream_reader *reader, struct stream *stream, bool *more,
                                bool *within, struct error **damage)
{
    struct table schema, *table = NULL;
    struct error *err = sort_error(stream_reader_next_table(reader, &schema, more), damage);
    if (err || *damage || !*more)
        return err;
    err = stream_add_table(stream, schema.name, &table);
    if (err) {
        table_clear(&schema);
        return err;
    }
    table_clear(table);
    *table = schema;
    size_t got;
    err = sort_error(stream_reader_rows(reader, table, SIZE_MAX, &got), damage);
    *within = *damage;
    return err;
}

/* Whether the last line that was taken is the text's last and lacks its newline. */
static bool took_cut_line(const struct stream_reader *reader)
{
    const struct file_input *in = &reader->in;
    return reader->encoding == STREAM_TEXT && in->ended && in->start > 0 &&
           in->data[in->start - 1] != '\n';
}

/* Drops what is not whole of the table that the damage is in, and what that makes untrue. */
static struct error *drop_damaged(const struct stream_reader *reader, struct stream *stream)
{
    const char *name = reader->schema.name;
    struct table *table = stream_table(stream, name);
    /* else the cut line is the table's own */
    const bool cut = took_cut_line(reader), known = table->rows > 0 || !cut;
    if (strcmp(name, "probe") || !known) {
        stream_remove_table(stream, name);
        return NULL;
    }
    for (size_t i = stream->table_count; i-- > 0;)
        if (strcmp(stream->tables[i].name, "probe"))
            stream_remove_table(stream, stream->tables[i].name);
    table = stream_table(stream, "probe");
    return table_resize(table, table->rows - cut);
}

static struct error *keep_whole(const struct stream_reader *reader, struct stream *stream,
                                bool within, const char *path, const struct error *damage,
                                struct warnings *warnings)
{
    struct error *err = within ? drop_damaged(reader, stream) : NULL;
    struct table *probes = stream_table(stream, "probe");
    if (err)
        return err;
    if (!probes)
        return error_new("%s: no probes can be salvaged", error_message(damage));
    if (!cells_exist(stream))
        cells_remove(stream);
    const bool dropped = within && strcmp(reader->schema.name, "probe");
    warnings_add(warnings, path, "%s: %zu rows of table probe are kept%s%s%s",
                 error_message(damage), probes->rows, dropped ? ", table " : "",
                 dropped ? reader->schema.name : "", dropped ? " is dropped" : "");
    return NULL;
}

struct error *stream_salvage(struct stream **stream, const char *path, struct warnings *warnings)
{
    struct stream_reader *reader = NULL;
    struct stream *s = NULL;
    struct error *damage = NULL;
    bool within = false;
    *stream = NULL;
    struct error *err = stream_reader_open(&reader, path);
    if (!err)
        err = stream_create(&s);
    if (!err)
        err = header_copy(&s->header, stream_reader_header(reader));
    for (bool more = true; !err && !damage && more;)
        err = read_table(reader, s, &more, &within, &damage);
    if (!err && damage)
        err = keep_whole(reader, s, within, path, damage, warnings);
    if (!err) {
        s->encoding = stream_reader_encoding(reader);
        *stream = s;
        s = NULL;
    }
    error_destroy(damage);
    stream_destroy(s);
    stream_reader_close(reader);
    return err;
}
