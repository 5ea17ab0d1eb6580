/* Readers and writers: the header, the order of tables, the end; rows are stream_text.c's and
 * stream_binary.c's. */
#include "stream/stream.h"
#include "base/array.h"
#include "base/error.h"
#include "stream/stream_private.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char magic_text[] = "#?probe 1", magic_binary[] = "#?probe 1 binary";

/* -- reading --------------------------------------------------------------------------------- */

struct error *reader_place(const struct stream_reader *reader, struct error *err)
{
    if (reader->encoding == STREAM_BINARY)
        return error_wrap(err, "%s: byte %" PRIu64, reader->in.name, reader->in.offset);
    return error_wrap(err, "%s:%zu", reader->in.name, reader->in.line);
}

struct error *ended_within(const struct stream_reader *reader, size_t further)
{
    return error_new("the stream ends within table %s, after %zu rows: it is not whole",
                     reader->schema.name, reader->row + further);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

bool line_is_table(const char *line, size_t length)
{
    return length > 5 && !memcmp(line, "table", 5) && is_blank(line[5]);
}

bool line_is_end(const char *line, size_t length)
{
    return length >= 3 && !memcmp(line, "end", 3) && (length == 3 || is_blank(line[3]));
}

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
    struct error *err = file_input_peek(in, sizeof magic_binary, &bytes, &got);
    if (err)
        return err;
    if (!got)
        return error_new("%s: expected a probe stream, got nothing", in->name);
    const size_t common = sizeof magic_text - 1;
    if (got < common || memcmp(bytes, magic_text, common)) {
        char shown[33];
        size_t n = 0;
        for (; n < got && n < sizeof shown - 1 && bytes[n] != '\n'; n++)
            shown[n] = bytes[n] < ' ' || bytes[n] >= 0x7f ? '?' : (char)bytes[n];
        shown[n] = 0;
        return error_new("%s:1: expected a probe stream, which begins with '%s', got '%s'",
                         in->name, magic_text, shown);
    }
    if (got == sizeof magic_binary && !memcmp(bytes, magic_binary, sizeof magic_binary - 1) &&
        bytes[sizeof magic_binary - 1] == '\n') {
        reader->encoding = STREAM_BINARY;
        err = checksum_create(&reader->checksum);
    }
    char *line = NULL;
    if (!err)
        err = take_line(reader, &line);
    if (!err && strcmp(line, reader->encoding == STREAM_BINARY ? magic_binary : magic_text))
        err = error_new("%s:1: expected '%s' or '%s', got '%.40s'", in->name, magic_text,
                        magic_binary, line);
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

/* -- writing --------------------------------------------------------------------------------- */

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
    struct error *err = write_text(writer, "%s\n", writer->binary ? magic_binary : magic_text);
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
