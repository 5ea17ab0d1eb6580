/* SPDX-License-Identifier: Apache-2.0 */
/* stream_private: what the parts of stream share.
 *
 *     stream_reader.c   reading: what is the same in both encodings
 *     stream_writer.c   writing, likewise
 *     stream_whole.c    whole streams
 *     stream_format.c   what text and binary share
 *     stream_text.c     rows as lines
 *     stream_binary.c   rows as checked blocks
 *     stream_checksum.c what proves a binary stream
 *     stream_valid.c    what every stream must satisfy
 *     table.c           tables and headers in memory
 */
#ifndef STREAM_PRIVATE_H
#define STREAM_PRIVATE_H

#include "base/file.h"
#include "stream/stream.h"
#include "stream/table_private.h"

struct hash;

enum {
    STREAM_ROW_MOST = 1 << 20,   /* bytes of a row */
    STREAM_BLOCK_MOST = 16 << 20 /* bytes of the rows of a block that a reader accepts */
};

/* -- checksums (stream_checksum.c) ------------------------------------------------------------ */

/* XXH3-64 of the bytes since the last checksum, with that checksum as its seed (0 at first): each
 * proves all that came before. */
struct error *checksum_create(struct hash **checksum);
void checksum_destroy(struct hash *checksum); /* NULL is legal */
void checksum_update(struct hash *checksum, const void *bytes, size_t count);
uint64_t checksum_take(struct hash *checksum); /* hands it out; the next one starts */

/* -- validity (stream_valid.c) ----------------------------------------------------------------- */

/* What is known of a stream while its rows pass. */
struct stream_validity {
    size_t probes, cells; /* rows seen */
    int corners;          /* of the table of cells; 0: none yet */
    struct index_most {
        int32_t most; /* largest index seen */
        size_t row;   /* where */
    } vertex, neighbour, stand_in, merged;
};

struct stream_validity validity_start(void);

/* Checks the columns of a table. */
struct error *validity_schema(const struct stream_header *header, const struct table *table);

/* Checks rows first .. first+count-1, which are rows `number` and following of the stream's table.
 * Makes every NaN the same NaN. */
struct error *validity_rows(struct stream_validity *validity, const struct table *table,
                            size_t first, size_t count, size_t number);

/* Checks what only the end can tell: that indices are in range. */
struct error *validity_end(const struct stream_validity *validity);

/* -- readers and writers --------------------------------------------------------------------- */

struct stream_reader {
    struct file_input in;
    struct stream_header header;
    enum stream_encoding encoding;
    struct hash *checksum; /* binary */
    struct stream_validity validity;
    /* of the current table, no rows; its name is NULL before the first and after the last */
    struct table schema;
    size_t row; /* rows of it that were read */
    bool table_ended;
    char **table_names; /* seen so far */
    size_t table_count;
    size_t block_rows; /* binary: rows left in the current block */
};

struct stream_writer {
    struct file_output out;
    struct stream_header header;
    bool binary;
    struct hash *checksum; /* binary */
    struct stream_validity validity;
    struct table schema; /* of the started table */
    size_t row;
    struct table pending; /* rows that do not fill a block yet */
    size_t block_rows;    /* rows of a full block */
};

/* -- what text and binary share (stream_format.c) ---------------------------------------------- */

extern const char stream_magic_text[10], stream_magic_binary[17]; /* the first line */

/* Whether a line starts a table, or ends the stream. */
bool line_is_table(const char *line, size_t length);
bool line_is_end(const char *line, size_t length);

/* Puts file and line, or file and byte, before the message. */
struct error *reader_place(const struct stream_reader *reader, struct error *err);

/* The error of a stream that stops within the current table, `further` rows behind reader->row. */
struct error *ended_within(const struct stream_reader *reader, size_t further);

/* -- rows (stream_text.c, stream_binary.c) ----------------------------------------------------- */

/* Appends up to `most` rows (at least one, or none at the table's end, which sets table_ended) to
 * the table, whose first columns are those of reader->schema and which has room for them, and
 * checks them. */
struct error *text_read_rows(struct stream_reader *reader, struct table *table, size_t most,
                             size_t *got);
struct error *binary_read_rows(struct stream_reader *reader, struct table *table, size_t most,
                               size_t *got);

/* Writes rows as lines. */
struct error *text_write_rows(struct stream_writer *writer, const struct table *table, size_t first,
                              size_t count);

/* Writes one block; count 0 ends the table. */
struct error *binary_write_block(struct stream_writer *writer, const struct table *table,
                                 size_t first, size_t count);

#endif
