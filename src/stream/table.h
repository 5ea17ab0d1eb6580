/* SPDX-License-Identifier: Apache-2.0 */
/* table: what a stream is made of, in memory: the header's keys, and tables of named and typed
 * columns. stream.h tells what they mean.
 */
#ifndef TABLE_H
#define TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

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

/* -- names ----------------------------------------------------------------------------------- */

/* The tables of cells, of which a stream has at most one, by corners of a cell less one: point,
 * segment, tri, tet. */
enum { STREAM_CORNERS_MOST = 4 };
extern const char *const stream_cell_table[STREAM_CORNERS_MOST];

/* How many corners a cell of the table of this name has; 0: it holds no cells. */
int stream_cell_corners(const char *table);

#endif
