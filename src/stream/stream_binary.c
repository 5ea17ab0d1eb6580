/* SPDX-License-Identifier: Apache-2.0 */
/* Rows as blocks (man probe.5, "Blocks"): u32 rows, u32 bytes of the rows, u64 checksum, the rows;
 * a block of no rows ends the table. The checksum covers what stands before it and behind it: the
 * head, then the rows. */
#include "base/error.h"
#include "stream/stream_private.h"

#include <inttypes.h>
#include <string.h>

enum { COUNTS = 8, HEAD = COUNTS + 8 };

/* memcpy of the widths that columns have, as single moves. */
static inline void copy_value(unsigned char *to, const unsigned char *from, size_t bytes)
{
    switch (bytes) {
    case 4: memcpy(to, from, 4); break;
    case 8: memcpy(to, from, 8); break;
    case 12: memcpy(to, from, 12); break;
    case 16: memcpy(to, from, 16); break;
    case 24: memcpy(to, from, 24); break;
    case 48: memcpy(to, from, 48); break;   /* sight */
    case 108: memcpy(to, from, 108); break; /* sh of order 3 */
    default: memcpy(to, from, bytes);
    }
}

/* Copies values of `bytes` bytes between a column, where they lie end to end, and rows. */
static void copy_column(unsigned char *to, size_t to_step, const unsigned char *from,
                        size_t from_step, size_t bytes, size_t count)
{
    for (size_t i = 0; i < count; i++, to += to_step, from += from_step)
        copy_value(to, from, bytes);
}

/* Reads the next block, proves it, and sets reader->block_rows; its rows are next to be consumed. A
 * block of no rows ends the table. */
static struct error *open_block(struct stream_reader *reader, size_t row_bytes)
{
    struct file_input *in = &reader->in;
    const unsigned char *block;
    size_t got;
    uint32_t rows = 0, bytes = 0;
    uint64_t stated = 0;
    struct error *err = file_input_peek(in, HEAD, &block, &got);
    if (!err && got == HEAD) {
        memcpy(&rows, block, 4);
        memcpy(&bytes, block + 4, 4);
        memcpy(&stated, block + COUNTS, sizeof stated);
        if (bytes > STREAM_BLOCK_MOST || rows > STREAM_BLOCK_MOST || rows * row_bytes != bytes)
            return error_new(
                "table %s: expected a block of rows of %zu bytes, at most %d bytes, got %" PRIu32
                " rows in %" PRIu32 " bytes",
                reader->schema.name, row_bytes, STREAM_BLOCK_MOST, rows, bytes);
        err = file_input_peek(in, HEAD + (size_t)bytes, &block, &got);
    }
    if (err)
        return err;
    if (got < HEAD + (size_t)bytes)
        return ended_within(reader, 0);
    checksum_update(reader->checksum, block, COUNTS);
    checksum_update(reader->checksum, block + HEAD, bytes);
    if (checksum_take(reader->checksum) != stated)
        return error_new("table %s: block checksum does not match", reader->schema.name);
    file_input_consume(in, HEAD);
    reader->block_rows = rows;
    reader->table_ended = rows == 0;
    return NULL;
}

struct error *binary_read_rows(struct stream_reader *reader, struct table *table, size_t most,
                               size_t *got)
{
    const size_t row_bytes = table_row_bytes(&reader->schema);
    struct error *err = NULL;
    *got = 0;
    if (!reader->block_rows)
        err = open_block(reader, row_bytes);
    if (err || reader->table_ended)
        return reader_place(reader, err);
    const size_t count = reader->block_rows < most ? reader->block_rows : most;
    /* open_block made the whole block available */
    const unsigned char *rows = reader->in.data + reader->in.start;
    for (size_t i = 0; i < reader->schema.column_count; i++) {
        const struct column *c = &table->columns[i];
        const size_t bytes = c->width * column_type_size(c->type);
        copy_column((unsigned char *)c->data + table->rows * bytes, bytes, rows, row_bytes, bytes,
                    count);
        rows += bytes;
    }
    err = validity_rows(&reader->validity, table, table->rows, count, reader->row);
    if (err)
        return reader_place(reader, err);
    reader->block_rows -= count;
    file_input_consume(&reader->in, count * row_bytes);
    table->rows += count;
    *got = count;
    return NULL;
}

struct error *binary_write_block(struct stream_writer *writer, const struct table *table,
                                 size_t first, size_t count)
{
    struct file_output *out = &writer->out;
    const size_t row_bytes = table_row_bytes(table), bytes = count * row_bytes;
    char *room;
    struct error *err = file_output_room(out, HEAD + bytes, &room);
    if (err)
        return err;
    const uint32_t counts[2] = {(uint32_t)count, (uint32_t)bytes};
    memcpy(room, counts, COUNTS);
    unsigned char *rows = (unsigned char *)room + HEAD;
    for (size_t i = 0; i < table->column_count; i++) {
        const struct column *c = &table->columns[i];
        const size_t width = c->width * column_type_size(c->type);
        copy_column(rows, row_bytes, (const unsigned char *)c->data + first * width, width, width,
                    count);
        rows += width;
    }
    checksum_update(writer->checksum, room, COUNTS);
    checksum_update(writer->checksum, room + HEAD, bytes);
    const uint64_t checksum = checksum_take(writer->checksum);
    memcpy(room + COUNTS, &checksum, sizeof checksum);
    out->count += HEAD + bytes;
    return file_output_flush(out, false);
}
