/* SPDX-License-Identifier: Apache-2.0 */
/* Writing: the header, tables, the end; rows are stream_text.c's and stream_binary.c's. */
#include "base/array.h"
#include "base/error.h"
#include "stream/stream_private.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

__attribute__((format(printf, 2, 3))) static struct error *write_text(struct stream_writer *writer,
                                                                      const char *format, ...)
{
    struct file_output *out = &writer->out;
    va_list args;
    va_start(args, format);
    char *text = NULL;
    const int length = vasprintf(&text, format, args);
    va_end(args);
    if (length < 0)
        return error_memory();
    char *room;
    struct error *err = file_output_room(out, (size_t)length, &room);
    if (!err) {
        memcpy(room, text, (size_t)length);
        out->count += (size_t)length;
        if (writer->checksum)
            checksum_update(writer->checksum, text, (size_t)length);
        err = file_output_flush(out, false);
    }
    free(text);
    return err;
}

static struct error *write_header(struct stream_writer *writer)
{
    const struct stream_header *header = &writer->header;
    struct error *err =
        write_text(writer, "%s\n", writer->binary ? stream_magic_binary : stream_magic_text);
    for (size_t i = 0; i < header->provenance_count && !err; i++)
        err = write_text(writer, "# %s\n", header->provenance[i]);
    for (size_t i = 0; i < header->key_count && !err; i++)
        err = write_text(writer, "%s %s\n", header->keys[i].name, header->keys[i].value);
    return err;
}

struct error *stream_writer_open(struct stream_writer **writer, const char *path,
                                 enum stream_encoding encoding, const struct stream_header *header)
{
    struct stream_writer *w = NULL;
    *writer = NULL;
    struct error *err = array_create(&w, 1, sizeof *w);
    if (err)
        return err;
    w->binary = encoding == STREAM_BINARY;
    w->validity = validity_start();
    w->out.fd = -1;
    err = header_copy(&w->header, header);
    if (!err)
        err = file_output_open(&w->out, path, w->binary);
    if (!err && w->binary)
        err = checksum_create(&w->checksum);
    if (!err)
        err = write_header(w);
    if (err)
        stream_writer_abandon(w);
    else
        *writer = w;
    return err;
}

/* Ends the started table, if there is one. */
static struct error *end_table(struct stream_writer *writer)
{
    struct error *err = NULL;
    if (writer->binary && writer->schema.name) {
        if (writer->pending.rows)
            err = binary_write_block(writer, &writer->pending, 0, writer->pending.rows);
        if (!err)
            err = binary_write_block(writer, &writer->pending, 0, 0);
    }
    table_clear(&writer->schema);
    table_clear(&writer->pending);
    return err;
}

struct error *stream_writer_table(struct stream_writer *writer, const struct table *schema)
{
    struct error *err = end_table(writer);
    if (!err)
        err = validity_schema(&writer->header, schema);
    if (!err)
        err = table_copy_schema(&writer->schema, schema);
    if (!err)
        err = table_copy_schema(&writer->pending, schema);
    if (!err)
        err = write_text(writer, "table %s", schema->name);
    for (size_t i = 0; i < schema->column_count && !err; i++)
        err = write_text(writer, " %s:%s:%zu", schema->columns[i].name,
                         column_type_name(schema->columns[i].type), schema->columns[i].width);
    if (!err)
        err = write_text(writer, "\n");
    writer->row = 0;
    writer->block_rows = table_block_rows(schema);
    return err;
}

static struct error *check_columns(const struct table *expected, const struct table *got)
{
    bool same = expected->column_count == got->column_count;
    for (size_t i = 0; same && i < got->column_count; i++)
        same = !strcmp(expected->columns[i].name, got->columns[i].name) &&
               expected->columns[i].type == got->columns[i].type &&
               expected->columns[i].width == got->columns[i].width;
    return same ? NULL
                : error_new("table %s: rows have other columns than the table was started with",
                            expected->name);
}

/* Keeps rows until they fill a block, so that the bytes do not depend on how many came at a
 * time. */
static struct error *keep_pending(struct stream_writer *writer, const struct table *table,
                                  size_t first, size_t count)
{
    struct table *pending = &writer->pending;
    struct error *err = table_reserve(pending, pending->rows + count);
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const size_t bytes = table->columns[i].width * column_type_size(table->columns[i].type);
        memcpy((char *)pending->columns[i].data + pending->rows * bytes,
               (const char *)table->columns[i].data + first * bytes, count * bytes);
    }
    if (!err)
        pending->rows += count;
    return err;
}

static struct error *write_blocks(struct stream_writer *writer, const struct table *table,
                                  size_t first, size_t count)
{
    struct error *err = NULL;
    while (count && !err) {
        size_t some = writer->block_rows;
        if (!writer->pending.rows && count >= some) {
            err = binary_write_block(writer, table, first, some);
        } else {
            some = writer->block_rows - writer->pending.rows;
            some = count < some ? count : some;
            err = keep_pending(writer, table, first, some);
            if (!err && writer->pending.rows == writer->block_rows) {
                err = binary_write_block(writer, &writer->pending, 0, writer->pending.rows);
                writer->pending.rows = 0;
            }
        }
        first += some;
        count -= some;
    }
    return err;
}

struct error *stream_writer_rows(struct stream_writer *writer, const struct table *table,
                                 size_t first, size_t count)
{
    struct error *err = check_columns(&writer->schema, table);
    /* a block's worth at a time: checked and written while it is in the cache */
    while (count && !err) {
        const size_t some = count < writer->block_rows ? count : writer->block_rows;
        err = validity_rows(&writer->validity, table, first, some, writer->row);
        if (!err)
            err = writer->binary ? write_blocks(writer, table, first, some)
                                 : text_write_rows(writer, table, first, some);
        writer->row += some;
        first += some;
        count -= some;
    }
    return err;
}

struct error *stream_writer_finish(struct stream_writer *writer)
{
    struct error *err = end_table(writer);
    if (!err)
        err = validity_end(&writer->validity);
    if (!err)
        err = write_text(writer, writer->binary ? "end " : "end\n");
    if (!err && writer->binary)
        err = write_text(writer, "%016" PRIx64 "\n", checksum_take(writer->checksum));
    if (!err)
        err = file_output_finish(&writer->out);
    stream_writer_abandon(writer);
    return err;
}

void stream_writer_abandon(struct stream_writer *writer)
{
    if (!writer)
        return;
    file_output_abandon(&writer->out);
    checksum_destroy(writer->checksum);
    header_clear(&writer->header);
    table_clear(&writer->schema);
    table_clear(&writer->pending);
    free(writer);
}
