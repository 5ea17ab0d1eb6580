/* SPDX-License-Identifier: Apache-2.0 */
/* Whole streams: in memory, read and written by way of stream_reader.c and stream_writer.c. */
#include "base/array.h"
#include "base/error.h"
#include "stream/stream_private.h"

#include <stdlib.h>
#include <string.h>

struct error *stream_create(struct stream **stream)
{
    struct error *err = array_create(stream, 1, sizeof **stream);
    if (!err)
        (*stream)->encoding = STREAM_BINARY;
    return err;
}

void stream_destroy(struct stream *stream)
{
    if (!stream)
        return;
    for (size_t i = 0; i < stream->table_count; i++)
        table_clear(&stream->tables[i]);
    free(stream->tables);
    header_clear(&stream->header);
    free(stream);
}

struct table *stream_table(const struct stream *stream, const char *name)
{
    for (size_t i = 0; i < stream->table_count; i++)
        if (!strcmp(stream->tables[i].name, name))
            return &stream->tables[i];
    return NULL;
}

struct error *stream_add_table(struct stream *stream, const char *name, struct table **table)
{
    struct table fresh;
    struct error *err = table_init(&fresh, name);
    if (err)
        return err;
    struct table *place = stream_table(stream, name);
    if (place) {
        table_clear(place);
    } else {
        struct table *grown = realloc(stream->tables, (stream->table_count + 1) * sizeof *grown);
        if (!grown) {
            table_clear(&fresh);
            return error_memory();
        }
        stream->tables = grown;
        place = &stream->tables[stream->table_count++];
    }
    *place = fresh;
    *table = place;
    return NULL;
}

void stream_remove_table(struct stream *stream, const char *name)
{
    struct table *table = stream_table(stream, name);
    if (!table)
        return;
    table_clear(table);
    const size_t index = (size_t)(table - stream->tables);
    memmove(table, table + 1, (--stream->table_count - index) * sizeof *table);
}

struct error *stream_read(struct stream **stream, const char *path)
{
    struct stream_reader *reader = NULL;
    struct stream *s = NULL;
    *stream = NULL;
    struct error *err = stream_reader_open(&reader, path);
    if (!err)
        err = stream_create(&s);
    if (!err)
        err = header_copy(&s->header, &reader->header);
    for (bool more = true; !err && more;) {
        struct table schema, *table = NULL;
        err = stream_reader_next_table(reader, &schema, &more);
        if (err || !more)
            break;
        err = stream_add_table(s, schema.name, &table);
        if (err) {
            table_clear(&schema);
            break;
        }
        table_clear(table);
        *table = schema;
        size_t got;
        err = stream_reader_rows(reader, table, SIZE_MAX, &got);
    }
    if (!err) {
        s->encoding = reader->encoding;
        *stream = s;
        s = NULL;
    }
    stream_destroy(s);
    stream_reader_close(reader);
    return err;
}

struct error *stream_write(const struct stream *stream, const char *path,
                           enum stream_encoding encoding)
{
    struct stream_writer *writer = NULL;
    struct error *err = stream_check(stream); /* before a byte is written */
    if (err)
        return err;
    err = stream_writer_open(
        &writer, path, encoding == STREAM_AS_READ ? stream->encoding : encoding, &stream->header);
    for (size_t i = 0; i < stream->table_count && !err; i++) {
        err = stream_writer_table(writer, &stream->tables[i]);
        if (!err)
            err = stream_writer_rows(writer, &stream->tables[i], 0, stream->tables[i].rows);
    }
    if (!err)
        return stream_writer_finish(writer);
    stream_writer_abandon(writer);
    return err;
}

struct error *stream_copy_table(struct stream_reader *reader, struct stream_writer *writer,
                                const struct table *schema)
{
    struct table rows = {0};
    struct error *err = table_copy_schema(&rows, schema);
    if (!err)
        err = stream_writer_table(writer, schema);
    for (size_t got = 1; !err && got;) {
        rows.rows = 0;
        err = stream_reader_rows(reader, &rows, table_block_rows(&rows), &got);
        if (!err)
            err = stream_writer_rows(writer, &rows, 0, got);
    }
    table_clear(&rows);
    return err;
}
