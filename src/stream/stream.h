/* SPDX-License-Identifier: Apache-2.0 */
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

#include "stream/table.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

enum stream_encoding { STREAM_AS_READ, STREAM_TEXT, STREAM_BINARY };

struct stream {
    struct stream_header header;
    struct table *tables; /* owned */
    size_t table_count;
    enum stream_encoding encoding; /* as it was read; STREAM_BINARY for a new stream */
};

/* -- streams in memory ----------------------------------------------------------------------- */

struct error *stream_create(struct stream **stream);
void stream_destroy(struct stream *stream);

/* The table of this name, or NULL. */
struct table *stream_table(const struct stream *stream, const char *name);

/* Adds an empty table (replacing one of the same name in place). Table pointers become invalid. */
struct error *stream_add_table(struct stream *stream, const char *name, struct table **table);
void stream_remove_table(struct stream *stream, const char *name);

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
