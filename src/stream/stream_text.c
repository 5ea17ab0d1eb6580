/* SPDX-License-Identifier: Apache-2.0 */
/* Rows as lines of numbers. */
#include "base/error.h"
#include "base/number.h"
#include "stream/stream_private.h"

#include <string.h>

static const char *skip_blanks(const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\t'))
        at++;
    return at;
}

static const char *skip_word(const char *at, const char *end)
{
    while (at < end && *at != ' ' && *at != '\t')
        at++;
    return at;
}

static const char *read_number(const struct column *c, size_t index, const char *at,
                               const char *end)
{
    switch (c->type) {
    case COLUMN_F32: return number_read_f32(at, end, &column_f32(c)[index]);
    case COLUMN_F64: return number_read_f64(at, end, &column_f64(c)[index]);
    case COLUMN_I32: return number_read_i32(at, end, &column_i32(c)[index]);
    }
    return NULL;
}

static struct error *wrong_count(const struct table *schema, const char *line, const char *end)
{
    size_t expected = 0, got = 0;
    for (size_t i = 0; i < schema->column_count; i++)
        expected += schema->columns[i].width;
    for (const char *at = skip_blanks(line, end); at < end;
         at = skip_blanks(skip_word(at, end), end))
        got++;
    return error_new("table %s: expected %zu numbers, got %zu", schema->name, expected, got);
}

static struct error *wrong_number(const struct table *schema, const struct column *c,
                                  const char *at, const char *end)
{
    const int length = (int)(skip_word(at, end) - at);
    const int shown = length < 40 ? length : 40;
    return error_new("table %s: column %s: expected %s, got '%.*s'", schema->name, c->name,
                     c->type == COLUMN_I32   ? "a whole number of 32 bits"
                     : c->type == COLUMN_F32 ? "a number that fits 32 bits"
                                             : "a number",
                     shown, at);
}

/* One line into row `row` of the table's first columns. */
static struct error *read_row(const struct table *schema, struct table *table, size_t row,
                              const char *line, const char *end)
{
    const char *at = skip_blanks(line, end);
    for (size_t i = 0; i < schema->column_count; i++) {
        const struct column *c = &table->columns[i];
        for (size_t k = 0; k < c->width; k++) {
            if (at == end)
                return wrong_count(schema, line, end);
            const char *behind = read_number(c, row * c->width + k, at, end);
            if (!behind || (behind < end && *behind != ' ' && *behind != '\t'))
                return wrong_number(schema, c, at, end);
            at = skip_blanks(behind, end);
        }
    }
    return at == end ? NULL : wrong_count(schema, line, end);
}

/* A line between two lines of the table's own: a row, or nothing (a comment, a blank line: *is_row
 * is false). */
static struct error *read_line(struct stream_reader *reader, struct table *table, size_t number,
                               const char *line, size_t length, bool *is_row)
{
    const char *end = line + length - (length && line[length - 1] == '\r'),
               *first = skip_blanks(line, end);
    *is_row = first < end && *first != '#';
    if (!*is_row)
        return memchr(line, 0, length)
                   ? error_new("table %s: expected text, got a zero byte", reader->schema.name)
                   : NULL;
    struct error *err = read_row(&reader->schema, table, table->rows, first, end);
    return err ? err : validity_rows(&reader->validity, table, table->rows, 1, number);
}

struct error *text_read_rows(struct stream_reader *reader, struct table *table, size_t most,
                             size_t *got)
{
    struct file_input *in = &reader->in;
    *got = 0;
    while (*got < most) {
        const char *line;
        size_t length, bytes;
        bool is_row;
        struct error *err = file_input_line(in, &line, &length, &bytes);
        if (err)
            return err;
        if (!line)
            return reader_place(reader, ended_within(reader, *got));
        if (line_is_table(line, length) || line_is_end(line, length)) {
            reader->table_ended = true;
            return NULL;
        }
        err = read_line(reader, table, reader->row + *got, line, length, &is_row);
        in->line++;
        if (err)
            return reader_place(reader, err);
        table->rows += is_row;
        *got += is_row;
        file_input_consume(in, bytes);
    }
    return NULL;
}

struct error *text_write_rows(struct stream_writer *writer, const struct table *table, size_t first,
                              size_t count)
{
    struct file_output *out = &writer->out;
    size_t values = 0;
    for (size_t i = 0; i < table->column_count; i++)
        values += table->columns[i].width;
    struct error *err = NULL;
    for (size_t row = first; row < first + count && !err; row++) {
        char *room;
        err = file_output_room(out, values * (NUMBER_ROOM + 1) + 1, &room);
        if (err)
            break;
        char *at = room;
        for (size_t i = 0; i < table->column_count; i++) {
            const struct column *c = &table->columns[i];
            for (size_t k = row * c->width; k < (row + 1) * c->width; k++) {
                at = c->type == COLUMN_F32   ? number_write_f32(at, column_f32(c)[k])
                     : c->type == COLUMN_F64 ? number_write_f64(at, column_f64(c)[k])
                                             : number_write_i32(at, column_i32(c)[k]);
                *at++ = ' ';
            }
        }
        at[-1] = '\n';
        out->count += (size_t)(at - room);
        err = file_output_flush(out, false);
    }
    return err;
}
