/* SPDX-License-Identifier: Apache-2.0 */
/* What one stream lacks, taken from others of the same probes: parts in any order and with their
 * rows in any order give the whole to the bit, and what is there stays. */
#include "base/warning.h"
#include "math/random.h"
#include "stream/stream.h"
#include "stream/stream_fill.h"
#include "support/tap.h"

#include <string.h>

enum { ROWS = 200, PARTS = 3, LIGHT = 12 };

/* -- streams ---------------------------------------------------------------------------------- */

static struct column *column(const struct stream *s, const char *name)
{
    return table_column(stream_table(s, "probe"), name);
}

/* Probes with a position, all else missing. */
static struct stream *make_probes(size_t rows)
{
    struct stream *s;
    struct table *t;
    struct column *c;
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &t));
    must(table_add_column(t, "position", COLUMN_F64, 3, &c));
    must(table_add_column(t, "sh", COLUMN_F32, LIGHT, &c));
    must(table_add_column(t, "theirs", COLUMN_F64, 2, &c));
    must(table_add_column(t, "number", COLUMN_I32, 1, &c));
    must(table_resize(t, rows));
    return s;
}

/* All of it by chance; a few positions stand three times. */
static struct stream *make_whole(void)
{
    struct stream *s = make_probes(ROWS);
    struct random r = random_start(1, 0, 0);
    for (size_t i = 0; i < ROWS; i++) {
        for (size_t k = 0; k < 3; k++)
            column_f64(column(s, "position"))[3 * i + k] =
                i % 10 > 7 ? column_f64(column(s, "position"))[3 * (i - i % 10) + k]
                           : random_double(&r) - 0.5;
        for (size_t k = 0; k < LIGHT; k++)
            column_f32(column(s, "sh"))[LIGHT * i + k] = random_float(&r);
        for (size_t k = 0; k < 2; k++)
            column_f64(column(s, "theirs"))[2 * i + k] = random_double(&r);
        column_i32(column(s, "number"))[i] = (int32_t)i;
    }
    return s;
}

static void lose(struct stream *s, size_t row)
{
    for (size_t k = 0; k < LIGHT; k++)
        column_f32(column(s, "sh"))[LIGHT * row + k] = NAN;
    for (size_t k = 0; k < 2; k++)
        column_f64(column(s, "theirs"))[2 * row + k] = NAN;
}

/* The whole, of which every third row has light. */
static struct stream *make_part(const struct stream *whole, size_t part)
{
    struct stream *s = make_probes(ROWS);
    table_copy_rows(stream_table(s, "probe"), 0, stream_table(whole, "probe"), 0, ROWS);
    for (size_t i = 0; i < ROWS; i++)
        if (i % PARTS != part)
            lose(s, i);
    return s;
}

/* The same with its rows in another order; of each ten 0, 8 and 9, at one place, keep theirs. */
static struct stream *make_turned(const struct stream *of)
{
    struct stream *s = make_probes(ROWS);
    size_t to = 0;
    for (size_t first = 10; first-- > 0;)
        for (size_t i = 0; i < ROWS; i += 10)
            if (first != 0 && first != 8 && first != 9)
                table_copy_rows(stream_table(s, "probe"), to++, stream_table(of, "probe"),
                                ROWS - 10 - i + first, 1);
    for (size_t i = ROWS; i > 0; i -= 10)
        for (size_t k = 0; k < 10; k++)
            if (k == 0 || k == 8 || k == 9)
                table_copy_rows(stream_table(s, "probe"), to++, stream_table(of, "probe"),
                                i - 10 + k, 1);
    return s;
}

static bool same_column(const struct stream *a, const struct stream *b, const char *name)
{
    const struct column *x = column(a, name), *y = column(b, name);
    return x && y && x->type == y->type && x->width == y->width &&
           !memcmp(x->data, y->data, ROWS * x->width * column_type_size(x->type));
}

static bool same_probes(const struct stream *a, const struct stream *b)
{
    return stream_table(a, "probe")->rows == ROWS && stream_table(b, "probe")->rows == ROWS &&
           same_column(a, b, "position") && same_column(a, b, "sh") &&
           same_column(a, b, "theirs") && same_column(a, b, "number");
}

/* -- filling ---------------------------------------------------------------------------------- */

static void test_parts(void)
{
    static const size_t order[][PARTS] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                          {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    struct stream *whole = make_whole();
    int wrong = 0, early = 0, told = 0;
    for (size_t i = 0; i < 12; i++) {
        struct warnings warnings = {0};
        struct stream *all = make_part(whole, order[i % 6][0]);
        for (size_t k = 1; k < PARTS; k++) {
            struct stream *part = make_part(whole, order[i % 6][k]),
                          *turned = i < 6 ? NULL : make_turned(part);
            early += same_probes(all, whole);
            must(stream_fill(all, turned ? turned : part, "part", &warnings));
            stream_destroy(part);
            stream_destroy(turned);
        }
        wrong += !same_probes(all, whole);
        told += warnings.count > 0;
        warnings_clear(&warnings);
        stream_destroy(all);
    }
    ok(!wrong && !early, "parts in any order, their rows in any order: the whole to the bit");
    ok(!told, "without a warning");
    stream_destroy(whole);
}

/* Light that is there stays, and of integers, which are never missing, nothing is taken. */
static void test_what_is_there(void)
{
    struct stream *whole = make_whole(), *all = make_part(whole, 0), *other = make_whole();
    for (size_t i = 0; i < ROWS; i++) {
        column_f32(column(other, "sh"))[LIGHT * i] = 9;
        column_i32(column(other, "number"))[i] = 9;
    }
    must(stream_fill(all, other, "other", NULL));
    int wrong = 0;
    for (size_t i = 0; i < ROWS; i++) {
        const float expected = i % PARTS == 0 ? column_f32(column(whole, "sh"))[LIGHT * i] : 9;
        wrong += column_f32(column(all, "sh"))[LIGHT * i] != expected ||
                 column_i32(column(all, "number"))[i] != (int32_t)i;
    }
    ok(!wrong, "what is there stays, what is missing comes (%d are wrong)", wrong);
    stream_destroy(whole);
    stream_destroy(all);
    stream_destroy(other);
}

/* A probe is found by the bits of its place, and by its normal where both have one. */
static void test_places(void)
{
    for (int normals = 0; normals < 2; normals++) {
        struct stream *to = make_probes(3), *from = make_probes(4);
        struct warnings warnings = {0};
        struct column *c;
        const double place[4][3] = {{0, 1, 2}, {-0.0, 1, 2}, {0, 1, 2}, {0, 1, 2 + 0x1p-51}};
        memcpy(column_f64(column(to, "position")), place, 3 * sizeof *place);
        memcpy(column_f64(column(from, "position")), place, sizeof place);
        for (size_t i = 0; i < 4; i++)
            for (size_t k = 0; k < LIGHT; k++)
                column_f32(column(from, "sh"))[LIGHT * i + k] = (float)i;
        for (int k = 0; k < 2 && normals; k++) {
            struct stream *s = k ? from : to;
            must(table_add_column(stream_table(s, "probe"), "normal", COLUMN_F32, 3, &c));
            for (size_t i = 0; i < 3; i++) /* rows 0 and 2 look the other way in the other */
                memcpy(column_f32(c) + 3 * i, (const float[3]){0, (i == 0) == (k == 0) ? 1 : -1, 0},
                       3 * sizeof(float));
            if (k)
                memset(column_f32(c) + 9, 0, 3 * sizeof(float));
            column_f32(c)[4] = 1; /* that of row 1 is the same in both */
        }
        must(stream_fill(to, from, "from", &warnings));
        const float *sh = column_f32(column(to, "sh"));
        if (normals)
            ok(sh[0] == 2 && sh[LIGHT] == 1 && sh[2 * LIGHT] == 0,
               "of probes at one place each is found by its normal");
        else
            ok(sh[0] == 0 && sh[LIGHT] == 1 && sh[2 * LIGHT] == 2,
               "of probes at one place the first is the first; 0 and -0 are two");
        ok(warnings_of_kind(&warnings, "strangers") == 1,
           "a place that differs in its last bit is another, and that is said");
        warnings_clear(&warnings);
        stream_destroy(to);
        stream_destroy(from);
    }
}

/* Of several probes at one place and fewer to fill them from, the first are filled. */
static void test_fewer(void)
{
    struct stream *to = make_probes(3), *from = make_probes(2);
    for (size_t i = 0; i < 9; i++)
        column_f64(column(to, "position"))[i] = 7;
    for (size_t i = 0; i < 6; i++)
        column_f64(column(from, "position"))[i] = 7;
    for (size_t i = 0; i < (size_t)2 * LIGHT; i++)
        column_f32(column(from, "sh"))[i] = (float)(i / LIGHT);
    must(stream_fill(to, from, "from", NULL));
    const float *sh = column_f32(column(to, "sh"));
    ok(sh[0] == 0 && sh[LIGHT] == 1 && isnan(sh[2 * LIGHT]),
       "of three at one place, two others fill the first two");
    stream_destroy(to);
    stream_destroy(from);
}

/* -- columns and keys ------------------------------------------------------------------------- */

static void test_columns(void)
{
    struct stream *whole = make_whole(), *bare = make_whole();
    struct column *c;
    for (int i = 0; i < 3; i++)
        table_remove_column(stream_table(bare, "probe"),
                            (const char *[]){"sh", "theirs", "number"}[i]);
    must(table_add_column(stream_table(whole, "probe"), "hull_normal", COLUMN_F32, 3, &c));
    must(table_add_column(stream_table(whole, "probe"), "merged", COLUMN_I32, 1, &c));
    must(stream_fill(bare, whole, "whole", NULL));
    ok(same_probes(bare, whole), "columns that are missing are added, integers too");
    ok(!column(bare, "hull_normal") && !column(bare, "merged"), "but not what is of cells");
    stream_destroy(bare);

    static const struct {
        enum column_type type;
        size_t width;
    } others[] = {{COLUMN_F64, 1}, {COLUMN_F32, 3}, {COLUMN_I32, 1}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        struct stream *to = make_whole(), *from = make_whole();
        must(table_add_column(stream_table(to, "probe"), "share", COLUMN_F32, 1, &c));
        must(table_add_column(stream_table(from, "probe"), "share", others[i].type, others[i].width,
                              &c));
        struct error *err = stream_fill(to, from, "file", NULL);
        ok(err && !strncmp(error_message(err), "file: column share is ", 22),
           "a column of another type or width is refused: %s", err ? error_message(err) : "no");
        error_destroy(err);
        stream_destroy(to);
        stream_destroy(from);
    }
    struct stream *nothing;
    must(stream_create(&nothing));
    struct error *none = stream_fill(whole, nothing, "file", NULL),
                 *into = stream_fill(nothing, whole, "file", NULL);
    ok(none && into, "without a table probe in both, nothing can be filled");
    error_destroy(none);
    error_destroy(into);
    stream_destroy(nothing);
    stream_destroy(whole);
}

/* Each key of light has to agree; another stays, with a warning. */
static void test_keys(void)
{
    static const struct {
        const char *name;
        bool light;
    } keys[] = {
        {"sh-order", true},     {"sh-content", true},  {"capture-rays", true}, {"sky", true},
        {"sky-key", true},      {"sky-turn", true},    {"sun-1", true},        {"point-2", true},
        {"spot-3", true},       {"emit", true},        {"scene-key", true},    {"max-albedo", true},
        {"albedo-scale", true}, {"light-scale", true}, {"sunny", false},       {"skyline", false},
        {"sky-file", false},    {"scene", false},      {"note", false}};
    int wrong = 0;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        for (int alike = 0; alike < 2; alike++) {
            struct stream *to = make_whole(), *from = make_whole();
            struct warnings warnings = {0};
            must(header_set_key(&to->header, keys[i].name, "1"));
            must(header_set_key(&from->header, keys[i].name, alike ? "1" : "2"));
            struct error *err = stream_fill(to, from, "file", &warnings);
            const bool right = alike           ? !err && !warnings.count
                               : keys[i].light ? err && strstr(error_message(err), keys[i].name)
                                               : !err && warnings.count == 1;
            if (!right)
                printf("# key %s is wrong\n", keys[i].name);
            wrong += !right || strcmp(header_key(&to->header, keys[i].name), "1") != 0;
            error_destroy(err);
            warnings_clear(&warnings);
            stream_destroy(to);
            stream_destroy(from);
        }
    ok(!wrong, "keys of light must agree, others stay with a warning (%d are wrong)", wrong);

    struct stream *to = make_whole(), *from = make_whole();
    must(header_set_key(&from->header, "capture-rays", "64"));
    must(header_add_provenance(&to->header, "probe-place"));
    must(header_add_provenance(&from->header, "probe-place"));
    must(header_add_provenance(&from->header, "probe-capture"));
    must(stream_fill(to, from, "file", NULL));
    const char *rays = header_key(&to->header, "capture-rays");
    ok(rays && !strcmp(rays, "64"), "a key that is missing is taken over");
    ok(to->header.provenance_count == 2 && !strcmp(to->header.provenance[1], "probe-capture"),
       "the history is of both, each line once");
    stream_destroy(to);
    stream_destroy(from);
}

int main(void)
{
    test_parts();
    test_what_is_there();
    test_places();
    test_fewer();
    test_columns();
    test_keys();
    return tap_done();
}
