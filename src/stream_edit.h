/* stream_edit: what probe-cat does to streams: choose tables, columns and rows, merge, describe.
 */
#ifndef STREAM_EDIT_H
#define STREAM_EDIT_H

#include "stream.h"

struct warnings;

/* What to keep. Lists are comma-separated names; NULL: everything. */
struct stream_selection {
    const char *tables;
    const char *columns; /* of whatever table; a table that keeps none goes as well */
    const char *drop;    /* columns not to keep */
    /* Rows of table probe: first, first + step, ... below end, zero-based. Where not all are kept, other tables go, with a warning,
     * and so does hull_normal: they speak of rows that are no more. */
    bool rows_given;
    int64_t first, end, step; /* end -1: all */
    enum { ROWS_ANY, ROWS_CAPTURED, ROWS_UNCAPTURED } captured; /* with light, without */
};

/* Whether a table, and a column of it, is kept. */
bool stream_keeps_table(const struct stream_selection *selection, const char *table);
bool stream_keeps_column(const struct stream_selection *selection, const char *column);

/* Removes from a stream in memory what the selection does not keep. */
struct error *stream_select(struct stream *stream, const struct stream_selection *selection, struct warnings *warnings);

/* Passes a stream on block by block, tables and columns chosen (rows are not). */
struct error *stream_filter(struct stream_reader *reader, struct stream_writer *writer, const struct stream_selection *selection);

/* Appends the probes of `from` to those of `to`, and its provenance. Columns that one of them lacks hold missing values, with a warning. Where
 * keys differ, the first stream's stay, with a warning; sh-order and sh-content must agree. Other tables go, with a warning: merged
 * probes need cells of their own. */
struct error *stream_merge(struct stream *to, const struct stream *from, struct warnings *warnings);

/* Prints what a stream holds to `out` (a FILE *), block by block: encoding, provenance, keys, tables, and for each column its type, missing
 * values, and range. */
struct error *stream_describe(struct stream_reader *reader, void *out);

#endif
