/* SPDX-License-Identifier: Apache-2.0 */
/* stream_edit: what probe-cat does to streams: choose tables, columns and rows, merge, describe.
 */
#ifndef STREAM_EDIT_H
#define STREAM_EDIT_H

#include "stream/stream.h"

#include <stdio.h>

struct warnings;

/* "COLUMN[INDEX] OP NUMBER": a comparison that the probes to keep must pass. A missing value passes
 * none. */
struct stream_condition {
    char column[64];
    bool indexed;
    size_t index;
    enum stream_comparison {
        COMPARE_LESS,
        COMPARE_LESS_EQUAL,
        COMPARE_GREATER,
        COMPARE_GREATER_EQUAL,
        COMPARE_EQUAL,
        COMPARE_UNEQUAL
    } comparison;
    double number; /* compared as a value of the column's type */
};

/* What to keep. Lists are comma-separated names; NULL: everything. What tables and columns name is
 * kept in their order. */
struct stream_selection {
    const char *tables; /* each must be there */
    /* of whatever table, each must be there; a table that keeps none goes as well */
    const char *columns;
    const char *drop; /* columns not to keep; need not be there */
    /* Rows of table probe: first, first + step, ... below end, zero-based. Where not all are kept,
     * other tables go, with a warning, and so do hull_normal and merged: they speak of rows that
     * are no more. */
    bool rows_given;
    int64_t first, end, step;            /* end -1: all */
    int captured;                        /* ROWS_ANY; with light, without */
    struct stream_condition *conditions; /* all must hold; owned */
    size_t condition_count, condition_capacity;
};

enum { ROWS_ANY, ROWS_CAPTURED, ROWS_UNCAPTURED };

/* Takes rows from "FIRST:END" or "FIRST:END:STEP", each of which may be left out, or from the
 * number of one; the error says what was expected. */
struct error *stream_selection_rows(struct stream_selection *selection, const char *text);

/* Adds a condition; the error says what was expected. */
struct error *stream_selection_add(struct stream_selection *selection, const char *text);

/* Whether the columns of all conditions are there; whether all hold of a row. */
struct error *stream_selection_conditions(const struct stream_selection *selection,
                                          const struct table *probes);
bool stream_selection_holds(const struct stream_selection *selection, const struct table *probes,
                            size_t row);

/* Whether the selection needs the whole stream in memory: it chooses among rows, or puts tables in
 * order. */
bool stream_selection_is_whole(const struct stream_selection *selection);

/* A usage error where a list of names is empty or has one twice, which a stream cannot. */
struct error *stream_selection_check(const struct stream_selection *selection);

void stream_selection_clear(struct stream_selection *selection);

/* Removes from a stream in memory what the selection does not keep. */
struct error *stream_select(struct stream *stream, const struct stream_selection *selection,
                            struct warnings *warnings);

/* Passes a stream on block by block, tables and columns chosen (rows are not). */
struct error *stream_filter(struct stream_reader *reader, struct stream_writer *writer,
                            const struct stream_selection *selection);

/* The same of one table, whose schema stream_reader_next_table gave: columns are chosen. */
struct error *stream_filter_table(struct stream_reader *reader, struct stream_writer *writer,
                                  const struct table *schema,
                                  const struct stream_selection *selection);

/* Appends the probes of `from` to those of `to`, and its provenance. Columns that one of them lacks
 * hold missing values, with a warning. Where keys differ, the first stream's stay, with a warning;
 * sh-order and sh-content must agree. Other tables go, from both, with a warning: merged probes
 * need cells of their own. */
struct error *stream_merge(struct stream *to, struct stream *from, struct warnings *warnings);

/* Prints what a stream holds to `out`, block by block: encoding, provenance, keys, tables, and for
 * each column its type, missing values, and range. */
struct error *stream_describe(struct stream_reader *reader, FILE *out);
struct error *stream_describe_whole(const struct stream *stream, FILE *out);

#endif
