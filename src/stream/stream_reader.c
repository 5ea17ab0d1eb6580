/* SPDX-License-Identifier: Apache-2.0 */
/* Reading: the header, the order of tables, the end; rows are stream_text.c's and
 * stream_binary.c's. */
#include "base/array.h"
#include "base/error.h"
#include "stream/stream_private.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A line of the header, or one between tables, as a string of its own, to be freed by the caller;
 * NULL when the input has ended. */
static struct error *take_line(struct stream_reader *reader, char **taken)
{
    struct file_input *in = &reader->in;
    const char *line;
    size_t length, bytes;
    struct error *err = file_input_line(in, &line, &length, &bytes);
    *taken = NULL;
    if (err || !line)
        return err;
    if (reader->checksum)
        checksum_update(reader->checksum, line, bytes);
    const size_t text = length -
                        (reader->encoding != STREAM_BINARY && length && line[length - 1] == '\r');
    bool control = false;
    for (size_t i = 0; i < text; i++)
        control = control || ((unsigned char)line[i] < ' ' && line[i] != '\t') || line[i] == 0x7f;
    if (!control) {
        *taken = strndup(line, text);
        err = *taken ? NULL : error_memory();
    }
    file_input_consume(in, bytes);
    in->line++;
    if (!err && control)
        err = reader_place(reader, error_new("expected a line of text, got control characters"));
    if (!err && reader->encoding == STREAM_BINARY && bytes == length)
        err = reader_place(reader, error_new("the stream ends within a line: it is not whole"));
    return err;
}

static struct error *read_magic(struct stream_reader *reader)
{
    struct file_input *in = &reader->in;
    const unsigned char *bytes;
    size_t got;
    struct error *err = file_input_peek(in, sizeof stream_magic_binary, &bytes, &got);
    if (err)
        return err;
    if (!got)
        return error_new("%s: expected a probe stream, got nothing", in->name);
    const size_t common = sizeof stream_magic_text - 1;
    if (got < common || memcmp(bytes, stream_magic_text, common)) {
        char shown[33];
        size_t n = 0;
        for (; n < got && n < sizeof shown - 1 && bytes[n] != '\n'; n++)
            shown[n] = bytes[n] < ' ' || bytes[n] >= 0x7f ? '?' : (char)bytes[n];
        shown[n] = 0;
        return error_new("%s:1: expected a probe stream, which begins with '%s', got '%s'",
                         in->name, stream_magic_text, shown);
    }
    if (got == sizeof stream_magic_binary &&
        !memcmp(bytes, stream_magic_binary, sizeof stream_magic_binary - 1) &&
        bytes[sizeof stream_magic_binary - 1] == '\n') {
        reader->encoding = STREAM_BINARY;
        err = checksum_create(&reader->checksum);
    }
    char *line = NULL;
    if (!err)
        err = take_line(reader, &line);
    if (!err &&
        strcmp(line, reader->encoding == STREAM_BINARY ? stream_magic_binary : stream_magic_text))
        err = error_new("%s:1: expected '%s' or '%s', got '%.40s'", in->name, stream_magic_text,
                        stream_magic_binary, line);
    free(line);
    return err;
}

/* "name value": adds the key. */
static struct error *read_key(struct stream_header *header, char *line)
{
    char *value = line + strcspn(line, " \t");
    const bool separated = *value;
    if (separated)
        *value++ = 0;
    value += strspn(value, " \t");
    if (!stream_name_valid(line))
        return error_new("expected a header key, a comment or a table, got '%.40s'", line);
    if (header_key(header, line))
        return error_new("the key %s is given twice", line);
    return header_set_key(header, line, value);
}

/* Reads header lines up to the first table or the end, which stay to be read. */
static struct error *read_header(struct stream_reader *reader)
{
    struct error *err = read_magic(reader);
    while (!err) {
        const char *ahead;
        size_t length, bytes;
        err = file_input_line(&reader->in, &ahead, &length, &bytes);
        if (err || !ahead || line_is_table(ahead, length) || line_is_end(ahead, length))
            break;
        char *line = NULL;
        err = take_line(reader, &line);
        if (!err && *line == '#')
            err = header_add_provenance(&reader->header, line + 1 + (line[1] == ' '));
        else if (!err && *line)
            err = reader_place(reader, read_key(&reader->header, line));
        free(line);
    }
    return err;
}

struct error *stream_reader_open(struct stream_reader **reader, const char *path)
{
    struct stream_reader *r = NULL;
    *reader = NULL;
    struct error *err = array_create(&r, 1, sizeof *r);
    if (err)
        return err;
    r->encoding = STREAM_TEXT;
    r->validity = validity_start();
    r->table_ended = true;
    err = file_input_open(&r->in, path);
    if (!err)
        err = read_header(r);
    if (err)
        stream_reader_close(r);
    else
        *reader = r;
    return err;
}

void stream_reader_close(struct stream_reader *reader)
{
    if (!reader)
        return;
    file_input_close(&reader->in);
    checksum_destroy(reader->checksum);
    header_clear(&reader->header);
    table_clear(&reader->schema);
    for (size_t i = 0; i < reader->table_count; i++)
        free(reader->table_names[i]);
    free(reader->table_names);
    free(reader);
}

const struct stream_header *stream_reader_header(const struct stream_reader *reader)
{
    return &reader->header;
}

enum stream_encoding stream_reader_encoding(const struct stream_reader *reader)
{
    return reader->encoding;
}

/* "name:type:width" */
static struct error *parse_column(struct table *schema, char *word)
{
    static const enum column_type types[] = {COLUMN_F32, COLUMN_F64, COLUMN_I32};
    char *type = strchr(word, ':'), *width = type ? strchr(type + 1, ':') : NULL;
    char *end = NULL;
    struct error *wrong = error_new("table %s: expected a column as name:type:width, got '%.40s'",
                                    schema->name, word);
    if (!width)
        return wrong;
    *type++ = *width++ = 0;
    const unsigned long count = *width >= '1' && *width <= '9' ? strtoul(width, &end, 10) : 0;
    if (!stream_name_valid(word) || !count || *end || count > STREAM_ROW_MOST)
        return wrong;
    if (schema->column_count == STREAM_NAMES_MOST) {
        error_destroy(wrong);
        return error_new("table %s: more than %d columns", schema->name, STREAM_NAMES_MOST);
    }
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(type, column_type_name(types[i])))
            continue;
        error_destroy(wrong);
        if (table_column(schema, word))
            return error_new("table %s: column %s is given twice", schema->name, word);
        return table_add_column(schema, word, types[i], count, NULL);
    }
    error_destroy(wrong);
    return error_new("table %s: column %s: expected a type f32, f64 or i32, got '%.40s'",
                     schema->name, word, type);
}

static struct error *remember_table(struct stream_reader *reader, const char *name)
{
    for (size_t i = 0; i < reader->table_count; i++)
        if (!strcmp(reader->table_names[i], name))
            return error_new("table %s is given twice", name);
    if (reader->table_count == STREAM_NAMES_MOST)
        return error_new("more than %d tables", STREAM_NAMES_MOST);
    char **grown = realloc(reader->table_names, (reader->table_count + 1) * sizeof *grown);
    if (!grown)
        return error_memory();
    reader->table_names = grown;
    grown[reader->table_count] = strdup(name);
    return grown[reader->table_count++] ? NULL : error_memory();
}

/* "table name column..." */
static struct error *read_table_line(struct stream_reader *reader, char *line)
{
    char *save = NULL;
    strtok_r(line, " \t", &save);
    const char *name = strtok_r(NULL, " \t", &save);
    if (!name || !stream_name_valid(name))
        return error_new("expected a table's name, got '%.40s'", name ? name : "");
    struct error *err = remember_table(reader, name);
    if (!err)
        err = table_init(&reader->schema, name);
    for (char *word; !err && (word = strtok_r(NULL, " \t", &save));)
        err = parse_column(&reader->schema, word);
    return err ? err : validity_schema(&reader->header, &reader->schema);
}

/* "end", in binary with the last checksum, which covers "end " as well; nothing may follow. */
static struct error *read_end(struct stream_reader *reader)
{
    static const char end[] = "end ";
    char expected[32] = "end", *line = NULL;
    if (reader->checksum) {
        checksum_update(reader->checksum, end, sizeof end - 1);
        snprintf(expected, sizeof expected, "%s%016" PRIx64, end, checksum_take(reader->checksum));
    }
    struct error *err = take_line(reader, &line);
    if (!err && strcmp(line, expected))
        err = reader_place(reader, reader->checksum
                                       ? error_new("the checksum at the end does not match")
                                       : error_new("expected 'end', got '%.40s'", line));
    free(line);
    const unsigned char *bytes;
    size_t got = 0;
    if (!err)
        err = file_input_peek(&reader->in, 1, &bytes, &got);
    if (!err && got)
        err = reader_place(reader, error_new("expected nothing behind the end, got more data"));
    return err ? err : reader_place(reader, validity_end(&reader->validity));
}

/* Reads the line that ends the stream or starts the next table. */
static struct error *next_table(struct stream_reader *reader)
{
    const char *ahead;
    size_t length, bytes;
    table_clear(&reader->schema);
    struct error *err = file_input_line(&reader->in, &ahead, &length, &bytes);
    if (err)
        return err;
    if (!ahead)
        return reader_place(
            reader, error_new("expected a table or the end, got nothing: the stream is not whole"));
    if (line_is_end(ahead, length))
        return read_end(reader);
    const bool table = line_is_table(ahead, length);
    char *line = NULL;
    err = take_line(reader, &line);
    if (!err)
        err = reader_place(reader,
                           table ? read_table_line(reader, line)
                                 : error_new("expected a table or the end, got '%.40s'", line));
    free(line);
    reader->row = 0;
    reader->table_ended = false;
    return err;
}

struct error *stream_reader_rows(struct stream_reader *reader, struct table *table, size_t most,
                                 size_t *got)
{
    *got = 0;
    const size_t block = table_block_rows(&reader->schema);
    struct error *err = NULL;
    while (!err && !reader->table_ended && *got < most) {
        const size_t first = table->rows, wanted = most - *got < block ? most - *got : block;
        size_t some = 0;
        err = table_reserve(table, first + wanted);
        /* the stream's columns, and those that the caller added */
        struct table read = *table, added = *table;
        read.column_count = reader->schema.column_count;
        added.columns += read.column_count;
        added.column_count -= read.column_count;
        if (!err)
            err = reader->encoding == STREAM_BINARY ? binary_read_rows(reader, &read, wanted, &some)
                                                    : text_read_rows(reader, &read, wanted, &some);
        if (!err)
            err = table_resize(&added, first + some);
        table->rows = first + some;
        reader->row += some;
        *got += some;
    }
    return err;
}

/* Reads, checks and drops the rest of the current table. */
static struct error *skip_rows(struct stream_reader *reader)
{
    if (reader->table_ended)
        return NULL;
    struct table scratch;
    struct error *err = table_copy_schema(&scratch, &reader->schema);
    for (size_t got = 1; !err && got;) {
        scratch.rows = 0;
        err = stream_reader_rows(reader, &scratch, table_block_rows(&scratch), &got);
    }
    table_clear(&scratch);
    return err;
}

struct error *stream_reader_next_table(struct stream_reader *reader, struct table *schema,
                                       bool *more)
{
    *schema = (struct table){0};
    *more = false;
    struct error *err = skip_rows(reader);
    if (!err)
        err = next_table(reader);
    if (!err && reader->schema.name) {
        err = table_copy_schema(schema, &reader->schema);
        *more = !err;
    }
    return err;
}
