/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/stream_edit.h"
#include "base/array.h"
#include "base/error.h"
#include "base/number.h"
#include "base/warning.h"
#include "stream/cells.h"
#include "stream/light_columns.h"
#include "stream/sight_key.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4096 };

/* -- selecting -------------------------------------------------------------------------------- */

/* Where a list names it, counted from 0; SIZE_MAX where it does not. */
static size_t place_in_list(const char *list, const char *name)
{
    const size_t length = strlen(name);
    size_t place = 0;
    for (const char *at = list; *at; at += strspn(at, ","), place++) {
        const size_t word = strcspn(at, ",");
        if (word == length && !strncmp(at, name, length))
            return place;
        at += word;
    }
    return SIZE_MAX;
}

static struct error *check_list(const char *option, const char *list)
{
    if (!list)
        return NULL;
    size_t place = 0;
    for (const char *at = list; *at || !place; at += strspn(at, ","), place++) {
        char name[64];
        const int length = (int)strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", length < 63 ? length : 63, at);
        if (!length)
            return error_usage("%s: expected names separated by commas, got '%s'", option, list);
        if (length < 63 && place_in_list(list, name) < place)
            return error_usage("%s: expected each name once, got %s twice", option, name);
        at += length;
    }
    return NULL;
}

struct error *stream_selection_check(const struct stream_selection *selection)
{
    struct error *err = check_list("--columns", selection->columns);
    if (!err)
        err = check_list("--tables", selection->tables);
    return err ? err : check_list("--drop", selection->drop);
}

static bool in_list(const char *list, const char *name)
{
    return place_in_list(list, name) != SIZE_MAX;
}

static bool keeps_table(const struct stream_selection *s, const char *table)
{
    return !s->tables || in_list(s->tables, table);
}

static bool keeps_column(const struct stream_selection *s, const char *column)
{
    return (!s->columns || in_list(s->columns, column)) && !(s->drop && in_list(s->drop, column));
}

/* The names that a stream has, as a list. */
struct seen {
    char *tables, *columns;
};

static struct error *add_name(char **list, const char *name)
{
    char *longer = NULL;
    if (*list && in_list(*list, name))
        return NULL;
    if (asprintf(&longer, "%s,%s", *list ? *list : "", name) < 0)
        return error_memory();
    free(*list);
    *list = longer;
    return NULL;
}

static struct error *see_table(struct seen *seen, const struct table *table)
{
    struct error *err = add_name(&seen->tables, table->name);
    for (size_t i = 0; i < table->column_count && !err; i++)
        err = add_name(&seen->columns, table->columns[i].name);
    return err;
}

/* Every name of `list` must have been seen. */
static struct error *check_seen(const char *what, const char *list, const char *seen)
{
    for (const char *at = list; at && *at; at += strspn(at, ",")) {
        const size_t length = strcspn(at, ",");
        char *name = strndup(at, length);
        if (!name)
            return error_memory();
        const bool there = !length || (seen && in_list(seen, name));
        struct error *err = there ? NULL : error_new("the stream has no %s %s", what, name);
        free(name);
        if (err)
            return err;
        at += length;
    }
    return NULL;
}

/* Clears `seen`; unless there is an error already, checks what the selection names. */
static struct error *check_selection(const struct stream_selection *s, struct seen *seen,
                                     struct error *err)
{
    if (!err)
        err = check_seen("table", s->tables, seen->tables);
    if (!err)
        err = check_seen("column", s->columns, seen->columns);
    free(seen->tables);
    free(seen->columns);
    return err;
}

/* -- conditions ------------------------------------------------------------------------------- */

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t");
}

/* "COLUMN" or "COLUMN[INDEX]"; returns what follows, NULL when it is something else. */
static const char *parse_place(struct stream_condition *c, const char *at)
{
    const size_t length = strcspn(at, " \t[<>=!");
    if (!length || length >= sizeof c->column)
        return NULL;
    memcpy(c->column, at, length);
    at = skip_blanks(at + length);
    if (*at != '[')
        return at;
    int32_t index;
    at = skip_blanks(at + 1);
    const char *end = number_read_i32(at, at + strlen(at), &index);
    if (!end || index < 0)
        return NULL;
    c->indexed = true;
    c->index = (size_t)index;
    end = skip_blanks(end);
    return *end == ']' ? skip_blanks(end + 1) : NULL;
}

static const char *parse_comparison(struct stream_condition *c, const char *at)
{
    static const struct {
        char text[3];
        enum stream_comparison comparison;
    } comparisons[] = {{"<=", COMPARE_LESS_EQUAL}, {">=", COMPARE_GREATER_EQUAL},
                       {"==", COMPARE_EQUAL},      {"!=", COMPARE_UNEQUAL},
                       {"<", COMPARE_LESS},        {">", COMPARE_GREATER},
                       {"=", COMPARE_EQUAL}};
    for (size_t i = 0; i < sizeof comparisons / sizeof *comparisons; i++) {
        if (strncmp(at, comparisons[i].text, strlen(comparisons[i].text)))
            continue;
        c->comparison = comparisons[i].comparison;
        return skip_blanks(at + strlen(comparisons[i].text));
    }
    return NULL;
}

struct error *stream_selection_rows(struct stream_selection *s, const char *text)
{
    int32_t number[3] = {0, -1, 1};
    const char *at = text, *end = text + strlen(text);
    int parts = 0;
    for (bool more = at < end; at && more; parts++) {
        if (at < end && *at >= '0' && *at <= '9' && parts < 3)
            at = number_read_i32(at, end, &number[parts]);
        more = at && at < end && *at == ':';
        if (more)
            at++;
    }
    if (at != end || parts < 1 || parts > 3 || number[2] < 1)
        return error_usage("expected FIRST:END or FIRST:END:STEP, got '%s'", text);
    s->rows_given = true;
    s->first = number[0];
    s->end = parts == 1 ? (int64_t)number[0] + 1 : number[1];
    s->step = number[2];
    return NULL;
}

struct error *stream_selection_add(struct stream_selection *s, const char *text)
{
    struct stream_condition c = {0};
    const char *at = parse_place(&c, skip_blanks(text));
    if (at)
        at = parse_comparison(&c, at);
    if (at)
        at = number_read_f64(at, at + strlen(at), &c.number);
    if (!at || *skip_blanks(at) || !isfinite(c.number))
        return error_usage("expected COLUMN OP NUMBER or COLUMN[INDEX] OP NUMBER, OP one of < <= > "
                           ">= = !=, got '%s'",
                           text);
    struct error *err =
        array_reserve(&s->conditions, &s->condition_capacity, s->condition_count + 1, sizeof c);
    if (!err)
        s->conditions[s->condition_count++] = c;
    return err;
}

void stream_selection_clear(struct stream_selection *s)
{
    free(s->conditions);
    s->conditions = NULL;
    s->condition_count = s->condition_capacity = 0;
}

static bool selects_rows(const struct stream_selection *s)
{
    return s->rows_given || s->captured != ROWS_ANY || s->condition_count;
}

bool stream_selection_is_whole(const struct stream_selection *s)
{
    return selects_rows(s) || (s->tables && strchr(s->tables, ','));
}

static struct error *check_condition(const struct stream_condition *c, const struct table *probes)
{
    const struct column *column = table_column(probes, c->column);
    if (!column)
        return error_new("table probe: there is no column %s to compare", c->column);
    if (!c->indexed && column->width > 1)
        return error_new("column %s has %zu numbers: say which, as in %s[0]", c->column,
                         column->width, c->column);
    if (c->index >= column->width)
        return error_new("column %s has %zu numbers, counted from 0: there is no %s[%zu]",
                         c->column, column->width, c->column, c->index);
    return NULL;
}

struct error *stream_selection_conditions(const struct stream_selection *s,
                                          const struct table *probes)
{
    struct error *err = NULL;
    for (size_t i = 0; i < s->condition_count && !err; i++)
        err = check_condition(&s->conditions[i], probes);
    return err;
}

static double value_of(const struct column *c, size_t i)
{
    return c->type == COLUMN_F64   ? column_f64(c)[i]
           : c->type == COLUMN_F32 ? (double)column_f32(c)[i]
                                   : column_i32(c)[i];
}

static bool condition_holds(const struct stream_condition *c, const struct table *probes,
                            size_t row)
{
    const struct column *column = table_column(probes, c->column);
    const double value = value_of(column, row * column->width + c->index);
    const double number = column->type == COLUMN_F32 ? (double)(float)c->number : c->number;
    switch (c->comparison) {
    case COMPARE_LESS: return value < number;
    case COMPARE_LESS_EQUAL: return value <= number;
    case COMPARE_GREATER: return value > number;
    case COMPARE_GREATER_EQUAL: return value >= number;
    case COMPARE_EQUAL: return value == number;
    case COMPARE_UNEQUAL: return value < number || value > number;
    }
    return false;
}

bool stream_selection_holds(const struct stream_selection *s, const struct table *probes,
                            size_t row)
{
    bool holds = true;
    for (size_t i = 0; i < s->condition_count && holds; i++)
        holds = condition_holds(&s->conditions[i], probes, row);
    return holds;
}

/* -- rows and columns ------------------------------------------------------------------------- */

static bool keeps_row(const struct stream_selection *s, const struct table *probes, size_t row)
{
    const struct column *sh = table_column(probes, "sh");
    const bool captured = sh && !isnan(column_f32(sh)[row * sh->width]);
    return (s->captured == ROWS_ANY || captured == (s->captured == ROWS_CAPTURED)) &&
           stream_selection_holds(s, probes, row);
}

/* Removes the columns that are not kept, and puts the others into the order that is asked for. */
static void choose_columns(struct table *table, const struct stream_selection *s)
{
    for (size_t i = table->column_count; i-- > 0;)
        if (!keeps_column(s, table->columns[i].name))
            table_remove_column(table, table->columns[i].name);
    for (size_t i = 1; i < table->column_count && s->columns; i++) {
        const struct column column = table->columns[i];
        const size_t place = place_in_list(s->columns, column.name);
        size_t to = i;
        for (; to && place_in_list(s->columns, table->columns[to - 1].name) > place; to--)
            table->columns[to] = table->columns[to - 1];
        table->columns[to] = column;
    }
}

/* The same with the tables. */
static void choose_tables(struct stream *stream, const struct stream_selection *s)
{
    for (size_t i = stream->table_count; i-- > 0;)
        if (!keeps_table(s, stream->tables[i].name))
            stream_remove_table(stream, stream->tables[i].name);
    for (size_t i = 1; i < stream->table_count && s->tables; i++) {
        const struct table table = stream->tables[i];
        const size_t place = place_in_list(s->tables, table.name);
        size_t to = i;
        for (; to && place_in_list(s->tables, stream->tables[to - 1].name) > place; to--)
            stream->tables[to] = stream->tables[to - 1];
        stream->tables[to] = table;
    }
}

/* Moves the rows that are kept to the front; returns how many. */
static size_t keep_rows(struct table *probes, const struct stream_selection *s)
{
    const int64_t rows = (int64_t)probes->rows,
                  end = s->rows_given && s->end >= 0 && s->end < rows ? s->end : rows;
    size_t kept = 0;
    for (int64_t row = s->rows_given ? s->first : 0; row < end; row += s->rows_given ? s->step : 1)
        if (keeps_row(s, probes, (size_t)row))
            /* never forwards: kept <= row */
            table_copy_rows(probes, kept++, probes, (size_t)row, 1);
    return kept;
}

/* Removes the tables that speak of probes by their number. */
static void drop_tables(struct stream *stream, const char *why, struct warnings *warnings)
{
    for (size_t i = 0; i < stream->table_count;) {
        const char *name = stream->tables[i].name;
        if (strcmp(name, "probe") && !light_table_is(name)) {
            warnings_add(warnings, "table dropped", "table %s speaks of %s", name, why);
            stream_remove_table(stream, name);
        } else {
            i++;
        }
    }
}

static struct error *select_rows(struct stream *stream, const struct stream_selection *s,
                                 struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there is no table probe to choose rows of");
    struct error *err = stream_selection_conditions(s, probes);
    if (err)
        return err;
    const size_t before = probes->rows, kept = keep_rows(probes, s);
    if (kept == before)
        return NULL;
    drop_tables(stream, "rows that are no more: dropped", warnings);
    cells_remove(stream);
    return table_resize(stream_table(stream, "probe"), kept);
}

struct error *stream_select(struct stream *stream, const struct stream_selection *s,
                            struct warnings *warnings)
{
    struct seen seen = {0};
    struct error *err = NULL;
    for (size_t i = 0; i < stream->table_count && !err; i++)
        err = see_table(&seen, &stream->tables[i]);
    err = check_selection(s, &seen, err);
    if (err)
        return err;
    choose_tables(stream, s);
    if (selects_rows(s))
        err = select_rows(stream, s, warnings);
    for (size_t i = stream->table_count; i-- > 0 && !err;) {
        choose_columns(&stream->tables[i], s);
        if (!stream->tables[i].column_count)
            stream_remove_table(stream, stream->tables[i].name);
    }
    return err;
}

struct error *stream_filter_table(struct stream_reader *reader, struct stream_writer *writer,
                                  const struct table *schema, const struct stream_selection *s)
{
    struct table in = {0}, out = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = table_copy_schema(&out, schema);
    if (!err) {
        choose_columns(&out, s);
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

struct error *stream_filter(struct stream_reader *reader, struct stream_writer *writer,
                            const struct stream_selection *s)
{
    struct seen seen = {0};
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(reader, &schema, &more);
        if (!err && more)
            err = see_table(&seen, &schema);
        if (!err && more && keeps_table(s, schema.name))
            err = s->columns || s->drop ? stream_filter_table(reader, writer, &schema, s)
                                        : stream_copy_table(reader, writer, &schema);
        table_clear(&schema);
    }
    return check_selection(s, &seen, err);
}

/* -- merging ---------------------------------------------------------------------------------- */

/* Says which keys one of two captures lacks, where that means that its light is another. */
static void warn_of_lacking(const struct stream_header *to, const struct stream_header *from,
                            struct warnings *warnings)
{
    const struct stream_header *const both[] = {to, from};
    if (!header_key(to, "capture-rays") || !header_key(from, "capture-rays"))
        return;
    for (int turn = 0; turn < 2; turn++)
        for (size_t i = 0; i < both[turn]->key_count; i++) {
            const char *name = both[turn]->keys[i].name;
            if (light_key_changes(name) && !header_key(both[!turn], name))
                warnings_add(warnings, "key lacks",
                             "key %s is '%s' in one stream, and another has none: it is kept as if "
                             "it were of all probes",
                             name, both[turn]->keys[i].value);
        }
}

static struct error *merge_header(struct stream_header *to, const struct stream_header *from,
                                  struct warnings *warnings)
{
    struct error *err = NULL;
    warn_of_lacking(to, from, warnings);
    for (size_t i = 0; i < from->provenance_count && !err; i++)
        err = header_add_provenance(to, from->provenance[i]);
    for (size_t i = 0; i < from->key_count && !err; i++) {
        const char *name = from->keys[i].name, *theirs = from->keys[i].value,
                   *ours = header_key(to, name);
        if (sight_key_is(name)) /* of cells, which go */
            continue;
        if (!ours)
            err = header_set_key(to, name, theirs);
        else if (strcmp(ours, theirs) && (!strcmp(name, "sh-order") ||
                                          !strcmp(name, "sh-content") || light_key_is_split(name)))
            err = error_new("the streams cannot be merged: %s is %s in the first and %s in another",
                            name, ours, theirs);
        else if (strcmp(ours, theirs) && strcmp(name, "scene-told"))
            warnings_add(warnings, "key differs",
                         "key %s is '%s' in the first stream and '%s' in another: the first stays",
                         name, ours, theirs);
    }
    return err;
}

static struct error *merge_columns(struct table *to, const struct table *from,
                                   struct warnings *warnings)
{
    struct error *err = NULL;
    for (size_t i = 0; i < to->column_count; i++)
        if (!table_column(from, to->columns[i].name))
            warnings_add(warnings, "column missing",
                         "a stream has no column %s: its probes get missing values",
                         to->columns[i].name);
    for (size_t i = 0; i < from->column_count && !err; i++) {
        const struct column *theirs = &from->columns[i], *ours = table_column(to, theirs->name);
        if (ours && (ours->type != theirs->type || ours->width != theirs->width)) {
            err = error_new(
                "the streams cannot be merged: column %s is %s:%zu in one and %s:%zu in another",
                theirs->name, column_type_name(ours->type), ours->width,
                column_type_name(theirs->type), theirs->width);
        } else if (!ours) {
            warnings_add(warnings, "column missing",
                         "a stream has no column %s: its probes get missing values", theirs->name);
            err = table_add_column(to, theirs->name, theirs->type, theirs->width, NULL);
        }
    }
    return err;
}

struct error *stream_merge(struct stream *to, struct stream *from, struct warnings *warnings)
{
    struct table *ours = stream_table(to, "probe"), *theirs = stream_table(from, "probe");
    if (!ours || !theirs)
        return error_new("the streams cannot be merged: one has no table probe");
    for (size_t i = 0; i < from->table_count; i++)
        if (light_table_is(from->tables[i].name) && !stream_table(to, from->tables[i].name))
            return error_new("the streams cannot be merged: one has a table %s, the first has none",
                             from->tables[i].name);
    struct error *err = merge_header(&to->header, &from->header, warnings);
    if (err)
        return err;
    drop_tables(to, "one stream's probes: dropped (run probe-tet again)", warnings);
    drop_tables(from, "one stream's probes: dropped (run probe-tet again)", warnings);
    ours = stream_table(to, "probe");
    theirs = stream_table(from, "probe");
    cells_remove(to);
    ours = stream_table(to, "probe");
    const size_t before = ours->rows;
    err = merge_columns(ours, theirs, warnings);
    cells_remove(to);
    ours = stream_table(to, "probe");
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

/* Columns of up to 4 numbers are described number by number, wider ones as a whole. */
static size_t ranges_of(const struct column *c)
{
    return c->width <= 4 ? c->width : 1;
}

/* Widens a range by `count` values, `step` apart. */
static void widen(struct range *range, const struct column *c, size_t first, size_t step,
                  size_t count)
{
    struct range r = *range;
    for (size_t i = first; count > 0; i += step, count--) {
        const double x = value_of(c, i);
        if (isnan(x)) {
            r.missing++;
            continue;
        }
        r.low = x < r.low || !r.count ? x : r.low;
        r.high = x > r.high || !r.count ? x : r.high;
        r.sum += x;
        r.count++;
    }
    *range = r;
}

static void widen_column(struct range *range, const struct column *c, size_t rows)
{
    const size_t parts = ranges_of(c);
    for (size_t k = 0; k < parts; k++)
        widen(&range[k], c, k, parts, rows * c->width / parts);
}

static void print_column(FILE *out, const struct column *c, const struct range *range)
{
    const size_t parts = ranges_of(c);
    const int digits = c->type == COLUMN_I32 ? 10 : 7;
    for (size_t k = 0; k < parts; k++) {
        char name[128], type[32];
        snprintf(name, sizeof name, parts > 1 ? "%s[%zu]" : "%s", c->name, k);
        snprintf(type, sizeof type, "%s:%zu", column_type_name(c->type), c->width);
        fprintf(out, "  %-16s %-8s", name, type);
        if (range[k].count)
            fprintf(out, " %14.*g %14.*g %14.7g", digits, range[k].low, digits, range[k].high,
                    range[k].sum / (double)range[k].count);
        else
            fprintf(out, " %14s %14s %14s", "-", "-", "-");
        fprintf(out, " %9zu\n", range[k].missing);
    }
}

/* reader: where the rows come from; NULL: they are there. */
static struct error *describe_table(struct stream_reader *reader, struct table *table, FILE *out)
{
    struct range *range = NULL;
    size_t rows = 0;
    struct error *err = array_create(&range, 4 * table->column_count, sizeof *range);
    for (size_t got = 1; !err && got;) {
        if (reader) {
            err = table_resize(table, 0);
            if (!err)
                err = stream_reader_rows(reader, table, BLOCK, &got);
        } else {
            got = rows ? 0 : table->rows;
        }
        for (size_t i = 0; i < table->column_count && !err; i++)
            widen_column(range + 4 * i, &table->columns[i], got);
        rows += got;
    }
    if (!err) {
        fprintf(out, "table %s: %zu rows\n", table->name, rows);
        fprintf(out, "  %-16s %-8s %14s %14s %14s %9s\n", "column", "type", "least", "most", "mean",
                "missing");
    }
    for (size_t i = 0; i < table->column_count && !err; i++)
        print_column(out, &table->columns[i], range + 4 * i);
    free(range);
    return err;
}

static void describe_header(const struct stream_header *header, enum stream_encoding encoding,
                            FILE *out)
{
    fprintf(out, "encoding %s\n", encoding == STREAM_BINARY ? "binary" : "text");
    for (size_t i = 0; i < header->provenance_count; i++)
        fprintf(out, "made by %s\n", header->provenance[i]);
    for (size_t i = 0; i < header->key_count; i++)
        fprintf(out, "key %s %s\n", header->keys[i].name, header->keys[i].value);
}

struct error *stream_describe(struct stream_reader *reader, FILE *out)
{
    describe_header(stream_reader_header(reader), stream_reader_encoding(reader), out);
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

struct error *stream_describe_whole(const struct stream *stream, FILE *out)
{
    struct error *err = NULL;
    describe_header(&stream->header, stream->encoding, out);
    for (size_t i = 0; i < stream->table_count && !err; i++)
        err = describe_table(NULL, &stream->tables[i], out);
    return err;
}
