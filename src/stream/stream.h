/* stream: the probe stream, tables of named and typed columns, in text and in binary.
 *
 * man/probe.5 specifies the format to the byte and wins over this comment. A stream is a header
 * (provenance lines and keys) and tables, of which `probe` and those of cells have a meaning;
 * columns and keys that a program does not know pass through unchanged.
 *
 * Two ways to use it. Whole, for programs that need every row at hand:
 *
 *     struct stream *s;
 *     err = stream_read(&s, "-");
 *     const struct column *p = table_column(stream_table(s, "probe"), "position");
 *     ... column_f64(p)[3 * row + axis] ...
 *     err = stream_write(s, "-", STREAM_AS_READ);
 *     stream_destroy(s);
 *
 * And in blocks, for programs that pass rows on before their input ends: stream_reader_* and
 * stream_writer_*, on which the two calls above are built.
 *
 * Every reader checks what it hands out: the encoding, checksums, counts, finiteness, index ranges
 * and the end mark. A stream is whole or it is refused.
 *
 * Missing values: a float column may hold NaN for a value that is not known (a probe that is not
 * yet captured), all components of a row or none; `position` may not. Infinity is refused
 * everywhere.
 */
#ifndef STREAM_H
#define STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

enum stream_encoding { STREAM_AS_READ, STREAM_TEXT, STREAM_BINARY };

enum column_type { COLUMN_F32, COLUMN_F64, COLUMN_I32 };

/* One column: `rows * width` values, row-major, in one array. */
struct column {
    char *name;
    enum column_type type;
    size_t width;
    void *data; /* owned; room for the table's capacity */
};

struct table {
    char *name;
    size_t rows, capacity;
    struct column *columns; /* owned */
    size_t column_count;
};

struct key {
    char *name, *value;
};

struct stream_header {
    char **provenance; /* command lines, oldest first, without "# " */
    size_t provenance_count;
    struct key *keys; /* in order of first appearance */
    size_t key_count;
};

struct stream {
    struct stream_header header;
    struct table *tables; /* owned */
    size_t table_count;
    enum stream_encoding encoding; /* as it was read; STREAM_BINARY for a new stream */
};

/* -- header ---------------------------------------------------------------------------------- */

/* The value of a key, or NULL. Owned by the header. */
const char *header_key(const struct stream_header *header, const char *name);

/* Sets a key; name: [a-z][a-z0-9-]*, value: one line of printable UTF-8. */
struct error *header_set_key(struct stream_header *header, const char *name, const char *value);

/* Removes a key if it is there. */
void header_remove_key(struct stream_header *header, const char *name);

/* Adds a command line as the newest. Control characters are replaced, so it stays one line. */
struct error *header_add_provenance(struct stream_header *header, const char *command_line);

struct error *header_copy(struct stream_header *to, const struct stream_header *from);
void header_clear(struct stream_header *header);

/* -- tables in memory ------------------------------------------------------------------------ */

/* Makes *table empty with this name; clear it with table_clear. */
struct error *table_init(struct table *table, const char *name);
void table_clear(struct table *table);

/* The column of this name, or NULL. */
struct column *table_column(const struct table *table, const char *name);

/* The column of this name, type and width; an error says what came instead. width 0: any. */
struct error *table_require(const struct table *table, const char *name, enum column_type type,
                            size_t width, struct column **column);

/* Adds a column (replacing one of the same name in place, whatever its type) and hands it out;
 * float columns are filled with NaN, integer columns with -1. Column pointers handed out before
 * become invalid. */
struct error *table_add_column(struct table *table, const char *name, enum column_type type,
                               size_t width, struct column **column);

/* Removes the column of this name if it is there. */
void table_remove_column(struct table *table, const char *name);

/* Sets the row count. New rows hold NaN and -1. data pointers taken before become invalid. */
struct error *table_resize(struct table *table, size_t rows);

/* Makes *to a table of the same name and columns with no rows. */
struct error *table_copy_schema(struct table *to, const struct table *from);

/* Copies `count` rows of those columns that both tables have alike (name, type and width); other
 * columns of *to stay as they are. */
void table_copy_rows(struct table *to, size_t to_first, const struct table *from, size_t from_first,
                     size_t count);

static inline float *column_f32(const struct column *c)
{
    return (float *)c->data;
}
static inline double *column_f64(const struct column *c)
{
    return (double *)c->data;
}
static inline int32_t *column_i32(const struct column *c)
{
    return (int32_t *)c->data;
}

/* Bytes of one value. */
size_t column_type_size(enum column_type type);
const char *column_type_name(enum column_type type);

/* -- streams in memory ----------------------------------------------------------------------- */

struct error *stream_create(struct stream **stream);
void stream_destroy(struct stream *stream);

/* The table of this name, or NULL. */
struct table *stream_table(const struct stream *stream, const char *name);

/* Adds an empty table (replacing one of the same name in place). Table pointers become invalid. */
struct error *stream_add_table(struct stream *stream, const char *name, struct table **table);
void stream_remove_table(struct stream *stream, const char *name);

/* The tables of cells, of which a stream has at most one, by corners of a cell less one: point,
 * segment, tri, tet. */
enum { STREAM_CORNERS_MOST = 4 };
extern const char *const stream_cell_table[STREAM_CORNERS_MOST];

/* How many corners a cell of the table of this name has; 0: it holds no cells. */
int stream_cell_corners(const char *table);

/* What every stream must satisfy, whoever made it (man probe.5, "Validity"): known columns have
 * their type and width, positions finite, no infinity, NaN for whole row values only, vertex,
 * neighbour and merged in range. Readers and writers call it themselves. */
struct error *stream_check(const struct stream *stream);

/* Reads a whole stream. path "-": standard input. Errors name file and line or byte. */
struct error *stream_read(struct stream **stream, const char *path);

/* Writes a whole stream. path "-": standard output; else a file that appears, under its name, only
 * when it is whole. */
struct error *stream_write(const struct stream *stream, const char *path,
                           enum stream_encoding encoding);

/* -- in blocks ------------------------------------------------------------------------------- */

struct stream_reader;
struct stream_writer;

/* Opens and reads the header. */
struct error *stream_reader_open(struct stream_reader **reader, const char *path);
/* NULL is legal, and so is stopping early */
void stream_reader_close(struct stream_reader *reader);
const struct stream_header *stream_reader_header(const struct stream_reader *reader);
enum stream_encoding stream_reader_encoding(const struct stream_reader *reader);

/* Advances to the next table (skipping rows that are left, checked all the same) and makes *schema
 * that table with no rows, to be cleared by the caller; *more is false, and *schema empty, when the
 * stream has ended well. */
struct error *stream_reader_next_table(struct stream_reader *reader, struct table *schema,
                                       bool *more);

/* Appends up to `most` further rows of the current table to `table` (made by next_table, perhaps
 * with columns added: those get NaN or -1); fewer only at the table's end. *got says how many: 0
 * when none are left. */
struct error *stream_reader_rows(struct stream_reader *reader, struct table *table, size_t most,
                                 size_t *got);

/* Opens for writing and writes the header. path "-": standard output. encoding: STREAM_TEXT or
 * STREAM_BINARY. */
struct error *stream_writer_open(struct stream_writer **writer, const char *path,
                                 enum stream_encoding encoding, const struct stream_header *header);

/* Starts a table with these columns. */
struct error *stream_writer_table(struct stream_writer *writer, const struct table *schema);

/* Writes rows first .. first+count-1 of `table`, which has the columns of the started table. */
struct error *stream_writer_rows(struct stream_writer *writer, const struct table *table,
                                 size_t first, size_t count);

/* Starts a table like `schema`, which stream_reader_next_table gave, and passes its rows
 * through. */
struct error *stream_copy_table(struct stream_reader *reader, struct stream_writer *writer,
                                const struct table *schema);

/* Writes the end mark and closes; the file takes its name here. Frees the writer, on error too. */
struct error *stream_writer_finish(struct stream_writer *writer);

/* Gives up: no end mark, no file. Frees; NULL is legal. */
void stream_writer_abandon(struct stream_writer *writer);

#endif
