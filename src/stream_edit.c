#include "stream_edit.h"
#include "array.h"
#include "error.h"
#include "warning.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4096 };

/* -- selecting -------------------------------------------------------------------------------- */

static bool in_list(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; *at; at += strspn(at, ",")) {
        const size_t word = strcspn(at, ",");
        if (word == length && !strncmp(at, name, length))
            return true;
        at += word;
    }
    return false;
}

bool stream_keeps_table(const struct stream_selection *s, const char *table)
{
    return !s->tables || in_list(s->tables, table);
}

bool stream_keeps_column(const struct stream_selection *s, const char *column)
{
    return (!s->columns || in_list(s->columns, column)) && !(s->drop && in_list(s->drop, column));
}

static void drop_columns(struct table *table, const struct stream_selection *s)
{
    for (size_t i = table->column_count; i-- > 0;)
        if (!stream_keeps_column(s, table->columns[i].name))
            table_remove_column(table, table->columns[i].name);
}

/* Moves the rows that are kept to the front; returns how many. */
static size_t keep_rows(struct table *probes, const struct stream_selection *s)
{
    const struct column *sh = table_column(probes, "sh");
    const int64_t rows = (int64_t)probes->rows, end = s->rows_given && s->end >= 0 && s->end < rows ? s->end : rows;
    size_t kept = 0;
    for (int64_t row = s->rows_given ? s->first : 0; row < end; row += s->rows_given ? s->step : 1) {
        const bool captured = sh && !isnan(column_f32(sh)[(size_t)row * sh->width]);
        if ((s->captured == ROWS_CAPTURED && !captured) || (s->captured == ROWS_UNCAPTURED && captured))
            continue;
        table_copy_rows(probes, kept++, probes, (size_t)row, 1); /* never forwards: kept <= row */
    }
    return kept;
}

static struct error *select_rows(struct stream *stream, const struct stream_selection *s, struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there is no table probe to choose rows of");
    const size_t before = probes->rows, kept = keep_rows(probes, s);
    if (kept == before)
        return NULL;
    for (size_t i = stream->table_count; i-- > 0;) {
        const char *name = stream->tables[i].name;
        if (!strcmp(name, "probe"))
            continue;
        warnings_add(warnings, "table dropped", "table %s speaks of rows that are no more: dropped", name);
        stream_remove_table(stream, name);
    }
    probes = stream_table(stream, "probe");
    table_remove_column(probes, "hull_normal");
    return table_resize(probes, kept);
}

struct error *stream_select(struct stream *stream, const struct stream_selection *s, struct warnings *warnings)
{
    struct error *err = NULL;
    for (size_t i = stream->table_count; i-- > 0;)
        if (!stream_keeps_table(s, stream->tables[i].name))
            stream_remove_table(stream, stream->tables[i].name);
    if (s->rows_given || s->captured != ROWS_ANY)
        err = select_rows(stream, s, warnings);
    for (size_t i = stream->table_count; i-- > 0 && !err;) {
        drop_columns(&stream->tables[i], s);
        if (!stream->tables[i].column_count)
            stream_remove_table(stream, stream->tables[i].name);
    }
    return err;
}

static struct error *filter_table(struct stream_reader *reader, struct stream_writer *writer, const struct table *schema,
                                  const struct stream_selection *s)
{
    struct table in = {0}, out = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = table_copy_schema(&out, schema);
    if (!err) {
        drop_columns(&out, s);
        if (!out.column_count)
            goto done;
        err = stream_writer_table(writer, &out);
    }
    for (size_t got = 1; !err && got;) {
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(reader, &in, BLOCK, &got);
        if (!err)
            err = table_resize(&out, got);
        if (err)
            break;
        table_copy_rows(&out, 0, &in, 0, got);
        err = stream_writer_rows(writer, &out, 0, got);
    }
done:
    table_clear(&in);
    table_clear(&out);
    return err;
}

struct error *stream_filter(struct stream_reader *reader, struct stream_writer *writer, const struct stream_selection *s)
{
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(reader, &schema, &more);
        if (!err && more && stream_keeps_table(s, schema.name))
            err = s->columns || s->drop ? filter_table(reader, writer, &schema, s) : stream_copy_table(reader, writer, &schema);
        table_clear(&schema);
    }
    return err;
}

/* -- merging ---------------------------------------------------------------------------------- */

static struct error *merge_header(struct stream_header *to, const struct stream_header *from, struct warnings *warnings)
{
    struct error *err = NULL;
    for (size_t i = 0; i < from->provenance_count && !err; i++)
        err = header_add_provenance(to, from->provenance[i]);
    for (size_t i = 0; i < from->key_count && !err; i++) {
        const char *name = from->keys[i].name, *theirs = from->keys[i].value, *ours = header_key(to, name);
        if (!ours)
            err = header_set_key(to, name, theirs);
        else if (strcmp(ours, theirs) && (!strcmp(name, "sh-order") || !strcmp(name, "sh-content")))
            err = error_new("the streams cannot be merged: %s is %s in the first and %s in another", name, ours, theirs);
        else if (strcmp(ours, theirs))
            warnings_add(warnings, "key differs", "key %s is '%s' in the first stream and '%s' in another: the first stays", name,
                         ours, theirs);
    }
    return err;
}

static struct error *merge_columns(struct table *to, const struct table *from, struct warnings *warnings)
{
    struct error *err = NULL;
    for (size_t i = 0; i < to->column_count; i++)
        if (!table_column(from, to->columns[i].name))
            warnings_add(warnings, "column missing", "a stream has no column %s: its probes get missing values", to->columns[i].name);
    for (size_t i = 0; i < from->column_count && !err; i++) {
        const struct column *theirs = &from->columns[i], *ours = table_column(to, theirs->name);
        if (ours && (ours->type != theirs->type || ours->width != theirs->width)) {
            err = error_new("the streams cannot be merged: column %s is %s:%zu in one and %s:%zu in another", theirs->name,
                            column_type_name(ours->type), ours->width, column_type_name(theirs->type), theirs->width);
        } else if (!ours) {
            warnings_add(warnings, "column missing", "a stream has no column %s: its probes get missing values", theirs->name);
            err = table_add_column(to, theirs->name, theirs->type, theirs->width, NULL);
        }
    }
    return err;
}

struct error *stream_merge(struct stream *to, const struct stream *from, struct warnings *warnings)
{
    struct table *ours = stream_table(to, "probe");
    const struct table *theirs = stream_table(from, "probe");
    if (!ours || !theirs)
        return error_new("the streams cannot be merged: one has no table probe");
    struct error *err = merge_header(&to->header, &from->header, warnings);
    for (size_t i = to->table_count; i-- > 0 && !err;) {
        const char *name = to->tables[i].name;
        if (!strcmp(name, "probe"))
            continue;
        warnings_add(warnings, "table dropped", "table %s speaks of one stream's probes: dropped (run probe-tet again)", name);
        stream_remove_table(to, name);
    }
    if (err)
        return err;
    ours = stream_table(to, "probe");
    table_remove_column(ours, "hull_normal");
    const size_t before = ours->rows;
    err = merge_columns(ours, theirs, warnings);
    table_remove_column(ours, "hull_normal");
    if (!err)
        err = table_resize(ours, before + theirs->rows);
    if (!err)
        table_copy_rows(ours, before, theirs, 0, theirs->rows);
    return err;
}

/* -- describing ------------------------------------------------------------------------------- */

struct range {
    double low, high, sum;
    size_t count, missing;
};

static double value_of(const struct column *c, size_t i)
{
    return c->type == COLUMN_F64 ? column_f64(c)[i] : c->type == COLUMN_F32 ? (double)column_f32(c)[i] : column_i32(c)[i];
}

/* Columns of up to 4 numbers are described number by number, wider ones as a whole. */
static size_t ranges_of(const struct column *c)
{
    return c->width <= 4 ? c->width : 1;
}

static void widen(struct range *range, const struct column *c, size_t rows)
{
    const size_t parts = ranges_of(c);
    for (size_t i = 0; i < rows * c->width; i++) {
        struct range *r = &range[i % c->width % parts];
        const double x = value_of(c, i);
        if (isnan(x)) {
            r->missing++;
            continue;
        }
        r->low = r->count ? fmin(r->low, x) : x;
        r->high = r->count ? fmax(r->high, x) : x;
        r->sum += x;
        r->count++;
    }
}

static void print_column(FILE *out, const struct column *c, const struct range *range)
{
    const size_t parts = ranges_of(c);
    for (size_t k = 0; k < parts; k++) {
        char name[128], type[32];
        snprintf(name, sizeof name, parts > 1 ? "%s[%zu]" : "%s", c->name, k);
        snprintf(type, sizeof type, "%s:%zu", column_type_name(c->type), c->width);
        fprintf(out, "  %-16s %-8s", name, type);
        if (range[k].count)
            fprintf(out, " %14.7g %14.7g %14.7g", range[k].low, range[k].high, range[k].sum / (double)range[k].count);
        else
            fprintf(out, " %14s %14s %14s", "-", "-", "-");
        fprintf(out, " %9zu\n", range[k].missing);
    }
}

static struct error *describe_table(struct stream_reader *reader, struct table *table, FILE *out)
{
    struct range *range = NULL;
    size_t rows = 0;
    struct error *err = array_create(&range, 4 * table->column_count, sizeof *range);
    for (size_t got = 1; !err && got;) {
        err = table_resize(table, 0);
        if (!err)
            err = stream_reader_rows(reader, table, BLOCK, &got);
        for (size_t i = 0; i < table->column_count && !err; i++)
            widen(range + 4 * i, &table->columns[i], got);
        rows += got;
    }
    if (!err) {
        fprintf(out, "table %s: %zu rows\n", table->name, rows);
        fprintf(out, "  %-16s %-8s %14s %14s %14s %9s\n", "column", "type", "least", "most", "mean", "missing");
    }
    for (size_t i = 0; i < table->column_count && !err; i++)
        print_column(out, &table->columns[i], range + 4 * i);
    free(range);
    return err;
}

struct error *stream_describe(struct stream_reader *reader, void *file)
{
    FILE *out = file;
    const struct stream_header *header = stream_reader_header(reader);
    fprintf(out, "encoding %s\n", stream_reader_encoding(reader) == STREAM_BINARY ? "binary" : "text");
    for (size_t i = 0; i < header->provenance_count; i++)
        fprintf(out, "made by %s\n", header->provenance[i]);
    for (size_t i = 0; i < header->key_count; i++)
        fprintf(out, "key %s %s\n", header->keys[i].name, header->keys[i].value);
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table table = {0};
        err = stream_reader_next_table(reader, &table, &more);
        if (!err && more)
            err = describe_table(reader, &table, out);
        table_clear(&table);
    }
    return err;
}
