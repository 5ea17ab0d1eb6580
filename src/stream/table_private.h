/* SPDX-License-Identifier: Apache-2.0 */
/* table_private: what the parts of stream know of tables, beside table.h. */
#ifndef TABLE_PRIVATE_H
#define TABLE_PRIVATE_H

#include "stream/table.h"

enum {
    /* bytes of rows that a writer puts into a block: they stay in the second-level cache */
    STREAM_BLOCK_BYTES = 256 << 10,
    STREAM_NAMES_MOST = 4096, /* columns of a table, tables of a stream, keys of a header */
    STREAM_NAME_MOST = 63     /* bytes of a name */
};

/* Bytes of one row in binary. */
size_t table_row_bytes(const struct table *table);

/* Makes room for `rows` rows. */
struct error *table_reserve(struct table *table, size_t rows);

/* How many rows of a table make a block, at least one. */
size_t table_block_rows(const struct table *table);

/* Whether `name` may name a table or column: [a-z][a-z0-9_-]*, of at most STREAM_NAME_MOST
 * bytes. */
bool stream_name_valid(const char *name);

#endif
