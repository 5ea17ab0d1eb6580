/* SPDX-License-Identifier: Apache-2.0 */
/* Tables, columns and rows of a stream chosen, streams merged and described: against loops that say
 * the same more simply, for every selection of a few parts. */
#include "base/warning.h"
#include "math/random.h"
#include "stream/stream.h"
#include "stream/stream_edit.h"
#include "support/files.h"
#include "support/tap.h"

enum { ROWS = 9, MANY = 9000 /* some blocks */ };

/* -- a stream --------------------------------------------------------------------------------- */

static struct table *probes(const struct stream *s)
{
    return stream_table(s, "probe");
}

static struct column *column(const struct stream *s, const char *name)
{
    return table_column(probes(s), name);
}

/* share: each of a few values, one of them missing, in turn. */
static const float shares[] = {-1, 0.1f, NAN, 0.25f, 3};
enum { SHARES = sizeof shares / sizeof *shares };

/* Probes with cells and a table of somebody's; number is the row's; every fourth has no light. */
static struct stream *make_stream(size_t rows)
{
    struct stream *s;
    struct table *t;
    struct random r = random_start(1, 0, 0);
    must(stream_create(&s));
    must(header_add_provenance(&s->header, "probe-place"));
    must(header_set_key(&s->header, "sh-order", "1"));
    must(header_set_key(&s->header, "sh-content", "radiance"));
    must(stream_add_table(s, "probe", &t));
    must(table_add_column(t, "position", COLUMN_F64, 3, NULL));
    must(table_add_column(t, "sh", COLUMN_F32, 3, NULL));
    must(table_add_column(t, "share", COLUMN_F32, 1, NULL));
    must(table_add_column(t, "number", COLUMN_I32, 2, NULL));
    must(table_add_column(t, "hull_normal", COLUMN_F32, 3, NULL));
    must(table_add_column(t, "merged", COLUMN_I32, 1, NULL));
    must(table_resize(t, rows));
    for (size_t i = 0; i < rows; i++) {
        for (size_t k = 0; k < 3; k++)
            column_f64(column(s, "position"))[3 * i + k] = random_double(&r);
        for (size_t k = 0; k < 3; k++)
            column_f32(column(s, "sh"))[3 * i + k] = i % 4 == 3 ? NAN : random_float(&r);
        column_f32(column(s, "share"))[i] = shares[i % SHARES];
        column_i32(column(s, "number"))[2 * i] = (int32_t)i;
        column_i32(column(s, "number"))[2 * i + 1] = -(int32_t)i;
        column_i32(column(s, "merged"))[i] = -1;
    }
    must(stream_add_table(s, "tet", &t));
    must(table_add_column(t, "vertex", COLUMN_I32, 4, NULL));
    must(table_resize(t, 1));
    for (int32_t k = 0; k < 4; k++)
        column_i32(table_column(t, "vertex"))[k] = k;
    must(stream_add_table(s, "theirs", &t));
    must(table_add_column(t, "thing", COLUMN_F64, 1, NULL));
    must(table_resize(t, 1));
    return s;
}

static struct stream_selection all(void)
{
    return (struct stream_selection){.step = 1, .end = -1};
}

/* Whether the rows that are left are those that are wanted. */
static bool has_rows(const struct stream *s, const bool *wanted, size_t rows)
{
    size_t at = 0;
    for (size_t i = 0; i < rows; i++)
        if (wanted[i]) {
            if (at >= probes(s)->rows || column_i32(column(s, "number"))[2 * at] != (int32_t)i ||
                column_i32(column(s, "number"))[2 * at + 1] != -(int32_t)i)
                return false;
            at++;
        }
    return at == probes(s)->rows;
}

/* Selects of a new stream; whether what is left is what is wanted, and what speaks of rows that
 * are no more went with them. */
static bool selects(const struct stream_selection *selection, const bool *wanted)
{
    struct stream *s = make_stream(ROWS);
    struct warnings warnings = {0};
    bool every = true;
    for (size_t i = 0; i < ROWS; i++)
        every &= wanted[i];
    must(stream_select(s, selection, &warnings));
    const bool right = has_rows(s, wanted, ROWS) && !stream_table(s, "tet") == !every &&
                       !stream_table(s, "theirs") == !every &&
                       !column(s, "hull_normal") == !every && !column(s, "merged") == !every &&
                       warnings_of_kind(&warnings, "table dropped") == (every ? 0 : 2);
    warnings_clear(&warnings);
    stream_destroy(s);
    return right;
}

/* -- rows ------------------------------------------------------------------------------------- */

static void test_rows(void)
{
    int wrong = 0, tried = 0;
    for (int first = -1; first < 5; first++)
        for (int end = -1; end < ROWS + 2; end++)
            for (int step = 0; step < 4; step++) {
                char text[40] = "";
                bool wanted[ROWS] = {false};
                struct stream_selection s = all();
                if (first >= 0)
                    sprintf(text, "%d", first);
                strcat(text, ":");
                if (end >= 0)
                    sprintf(text + strlen(text), "%d", end);
                if (step)
                    sprintf(text + strlen(text), ":%d", step);
                for (int i = first < 0 ? 0 : first; i < (end < 0 || end > ROWS ? ROWS : end);
                     i += step ? step : 1)
                    wanted[i] = true;
                must(stream_selection_rows(&s, text));
                wrong += !selects(&s, wanted);
                tried++;
            }
    for (int row = 0; row < ROWS + 2; row++) {
        char text[12];
        bool wanted[ROWS + 2] = {false};
        struct stream_selection s = all();
        sprintf(text, "%d", row);
        wanted[row] = true;
        must(stream_selection_rows(&s, text));
        wrong += !selects(&s, wanted);
        tried++;
    }
    ok(!wrong, "FIRST:END:STEP, FIRST:END and one row: of %d texts %d keep the wrong rows", tried,
       wrong);
    static const char *const bad[] = {"",   "x",    "-1",  "1:2:0", "1:2:-1",      "1:2:3:4",
                                      "1 ", "1::x", "0x1", "1,2",   "3000000000:", ": 2"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct stream_selection s = all();
        struct error *err = stream_selection_rows(&s, bad[i]);
        ok(err && !s.rows_given, "rows '%s' are refused, and nothing is set", bad[i]);
        error_destroy(err);
    }
}

static bool compares(const char *op, double a, double b)
{
    return !strcmp(op, "<")                        ? a < b
           : !strcmp(op, "<=")                     ? a <= b
           : !strcmp(op, ">")                      ? a > b
           : !strcmp(op, ">=")                     ? a >= b
           : !strcmp(op, "=") || !strcmp(op, "==") ? a == b
                                                   : a < b || a > b;
}

/* A missing value passes none, 0.1 is the float that 0.1 is, and several must all hold. */
static void test_conditions(void)
{
    static const char *const ops[] = {"<", "<=", ">", ">=", "=", "==", "!="};
    static const char *const numbers[] = {"-1", "0.1", "0.25", "7", "-7"};
    int wrong = 0, tried = 0;
    for (size_t o = 0; o < sizeof ops / sizeof *ops; o++)
        for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++)
            for (int both = 0; both < 2; both++) {
                struct stream_selection s = all();
                char text[40];
                bool wanted[ROWS];
                for (size_t i = 0; i < ROWS; i++)
                    wanted[i] = compares(ops[o], (double)shares[i % SHARES],
                                         (double)strtof(numbers[n], NULL)) &&
                                (!both || -(double)i > -5);
                sprintf(text, both ? " share%s%s " : "share %s %s", ops[o], numbers[n]);
                must(stream_selection_add(&s, text));
                if (both)
                    must(stream_selection_add(&s, "number[1] > -5"));
                wrong += !selects(&s, wanted);
                tried++;
                stream_selection_clear(&s);
            }
    ok(!wrong, "of %d comparisons %d keep the wrong probes", tried, wrong);
    for (int lit = 0; lit < 2; lit++) {
        struct stream_selection s = all();
        bool wanted[ROWS];
        s.captured = lit ? ROWS_CAPTURED : ROWS_UNCAPTURED;
        for (size_t i = 0; i < ROWS; i++)
            wanted[i] = (i % 4 != 3) == lit;
        ok(selects(&s, wanted), "probes %s light", lit ? "with" : "without");
    }
}

/* -- tables and columns ----------------------------------------------------------------------- */

static bool is_order(const struct table *t, const char *names)
{
    char list[200] = "";
    for (size_t i = 0; i < t->column_count; i++)
        sprintf(list + strlen(list), "%s%s", i ? "," : "", t->columns[i].name);
    return !strcmp(list, names);
}

static void test_columns(void)
{
    static const char *const lists[] = {"position,sh,share", "share,sh,position",
                                        "sh,position,share", "number,position",
                                        "merged,hull_normal,number,share,sh,position"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        struct stream *s = make_stream(ROWS), *whole = make_stream(ROWS);
        struct stream_selection selection = all();
        selection.columns = lists[i];
        must(stream_select(s, &selection, NULL));
        bool same = is_order(probes(s), lists[i]) && !stream_table(s, "tet");
        for (size_t k = 0; k < probes(s)->column_count && same; k++) {
            const struct column *c = &probes(s)->columns[k], *of = column(whole, c->name);
            same = c->width == of->width &&
                   !memcmp(c->data, of->data, ROWS * c->width * column_type_size(c->type));
        }
        ok(same, "columns %s, in this order, with their values", lists[i]);
        stream_destroy(s);
        stream_destroy(whole);
    }
    struct stream *s = make_stream(ROWS);
    struct stream_selection selection = all();
    selection.drop = "sh,nothing,thing,merged";
    must(stream_select(s, &selection, NULL));
    ok(is_order(probes(s), "position,share,number,hull_normal") && stream_table(s, "tet") &&
           !stream_table(s, "theirs"),
       "all columns but these, which need not be there; a table that keeps none goes");
    selection = all();
    selection.tables = "tet,probe";
    must(stream_select(s, &selection, NULL));
    ok(s->table_count == 2 && !strcmp(s->tables[0].name, "tet") && probes(s)->rows == ROWS,
       "tables in the order asked for");
    for (int k = 0; k < 2; k++) {
        selection = all();
        *(k ? &selection.tables : &selection.columns) = "position,probe,nothing";
        struct error *err = stream_select(s, &selection, NULL);
        ok(err, "a name that is not there is refused: %s", err ? error_message(err) : "no");
        error_destroy(err);
    }
    stream_destroy(s);
}

/* Block by block, on the way from file to file, it is what it is in memory. */
static void test_filter(void)
{
    static const struct {
        const char *tables, *columns, *drop;
    } chosen[] = {{NULL, NULL, NULL},
                  {"probe", NULL, NULL},
                  {"tet", NULL, NULL},
                  {NULL, "share,position", NULL},
                  {NULL, "thing,number,vertex,position", "number"},
                  {"probe", NULL, "sh,hull_normal"}};
    struct stream *whole = make_stream(MANY);
    must(stream_write(whole, files_path("whole"), STREAM_BINARY));
    for (size_t i = 0; i < sizeof chosen / sizeof *chosen; i++) {
        struct stream_selection s = all();
        struct stream *memory = make_stream(MANY), *passed = NULL;
        struct stream_reader *reader;
        struct stream_writer *writer;
        s.tables = chosen[i].tables, s.columns = chosen[i].columns, s.drop = chosen[i].drop;
        must(stream_select(memory, &s, NULL));
        must(stream_reader_open(&reader, files_path("whole")));
        must(stream_writer_open(&writer, files_path("passed"), STREAM_BINARY,
                                stream_reader_header(reader)));
        must(stream_filter(reader, writer, &s));
        if (i == 2) { /* cells without their probes are no stream */
            struct error *err = stream_writer_finish(writer);
            ok(err, "cells alone are refused on either way");
            error_destroy(err);
        } else {
            must(stream_writer_finish(writer));
            must(stream_read(&passed, files_path("passed")));
            bool same = passed->table_count == memory->table_count;
            for (size_t t = 0; t < passed->table_count && same; t++) {
                const struct table *a = &passed->tables[t], *b = &memory->tables[t];
                same = !strcmp(a->name, b->name) && a->rows == b->rows &&
                       a->column_count == b->column_count;
                for (size_t k = 0; k < a->column_count && same; k++) {
                    const struct column *c = &a->columns[k], *d = &b->columns[k];
                    same =
                        !strcmp(c->name, d->name) && c->width == d->width &&
                        !memcmp(c->data, d->data, a->rows * c->width * column_type_size(c->type));
                }
            }
            ok(same, "filter %zu: passed on is what is selected in memory", i);
        }
        stream_reader_close(reader);
        stream_destroy(passed);
        stream_destroy(memory);
    }
    stream_destroy(whole);
}

/* -- merging and describing ------------------------------------------------------------------- */

static struct stream *make_half(const char *rows)
{
    struct stream *s = make_stream(ROWS);
    struct stream_selection half = all();
    must(stream_selection_rows(&half, rows));
    must(stream_select(s, &half, NULL));
    return s;
}

static void test_merge(void)
{
    struct stream *first = make_half(":4"), *second = make_half("4:"), *whole = make_stream(ROWS);
    struct warnings warnings = {0};
    must(stream_merge(first, second, &warnings));
    bool every[ROWS];
    memset(every, true, sizeof every);
    ok(has_rows(first, every, ROWS) && !warnings.count &&
           !memcmp(column(first, "sh")->data, column(whole, "sh")->data, 12 * (size_t)ROWS),
       "halves merged are the whole");
    ok(first->header.provenance_count == 2, "with the history of both");
    table_remove_column(probes(second), "share");
    must(header_set_key(&second->header, "note", "new"));
    must(header_set_key(&first->header, "note", "old"));
    must(stream_merge(whole, first, &warnings));
    ok(probes(whole)->rows == 2 * (size_t)ROWS && whole->table_count == 1 &&
           !column(whole, "merged") && !column(whole, "hull_normal") && warnings.count == 1,
       "merged probes lose what is of cells, and that is said");
    must(stream_merge(whole, second, &warnings));
    bool missing = true;
    for (size_t i = 2 * (size_t)ROWS; i < probes(whole)->rows; i++)
        missing &= isnan(column_f32(column(whole, "share"))[i]);
    ok(missing && warnings_of_kind(&warnings, "column missing") == 1,
       "a column that one lacks holds missing values, and that is said");
    ok(!strcmp(header_key(&whole->header, "note"), "old") &&
           warnings_of_kind(&warnings, "key differs") == 1,
       "the first stream's key stays, and that is said");
    warnings_clear(&warnings);
    for (int k = 0; k < 3; k++) {
        struct stream *other = make_stream(ROWS);
        if (k == 2)
            must(table_add_column(probes(other), "share", COLUMN_F32, 2, NULL));
        else
            must(header_set_key(&other->header, k ? "sh-order" : "sh-content",
                                k ? "0" : "irradiance"));
        struct error *err = stream_merge(whole, other, NULL);
        ok(err, "what does not go together is refused: %s", err ? error_message(err) : "no");
        error_destroy(err);
        stream_destroy(other);
    }
    stream_destroy(first);
    stream_destroy(second);
    stream_destroy(whole);
}

static void test_describe(void)
{
    struct stream *s = make_stream(MANY);
    struct stream_reader *reader;
    char *by_blocks = NULL, *whole = NULL;
    size_t size;
    must(stream_write(s, files_path("described"), STREAM_BINARY));
    must(stream_reader_open(&reader, files_path("described")));
    FILE *out = open_memstream(&by_blocks, &size);
    must(stream_describe(reader, out));
    fclose(out);
    out = open_memstream(&whole, &size);
    must(stream_describe_whole(s, out));
    fclose(out);
    ok(!strcmp(by_blocks, whole), "described by blocks as in memory");
    ok(strstr(whole, "table probe: 9000 rows"), "with the rows of each table");
    char name[20], type[20];
    double low = 0, high = 0, mean = 0;
    unsigned missing = 0;
    const char *line = strstr(whole, "\n  share ");
    const int got =
        line ? sscanf(line, "%19s %19s %lf %lf %lf %u", name, type, &low, &high, &mean, &missing)
             : 0;
    /* the mean of -1, 0.1, 0.25 and 3 */
    ok(got == 6 && low == -1 && high == 3 && fabs(mean - 0.5875) < 1e-6 && missing == MANY / SHARES,
       "and least, most, mean and missing values of a column");
    free(by_blocks);
    free(whole);
    stream_reader_close(reader);
    stream_destroy(s);
}

int main(void)
{
    files_begin();
    test_rows();
    test_conditions();
    test_columns();
    test_filter();
    test_merge();
    test_describe();
    files_end();
    return tap_done();
}
