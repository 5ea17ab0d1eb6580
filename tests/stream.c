/* SPDX-License-Identifier: Apache-2.0 */
/* The stream: what is written is read back to the bit in both encodings, and what is not whole or
 * not valid is refused, whichever byte of it is wrong. */
#include "base/error.h"
#include "base/number.h"
#include "math/random.h"
#include "stream/header_number.h"
#include "stream/stream.h"
#include "support/tap.h"

#include <fcntl.h>
#include <float.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[] = "/tmp/probe-stream-XXXXXX";
static char path_a[64], path_b[64];

/* A file in memory that is reopened by name: the tests below read tens of thousands. */
static char memory_path[32];
static int memory_file = -1;

static void write_memory(const void *bytes, size_t count)
{
    if (memory_file < 0) {
        memory_file = memfd_create("stream", 0);
        snprintf(memory_path, sizeof memory_path, "/proc/self/fd/%d", memory_file);
    }
    if (ftruncate(memory_file, 0) || pwrite(memory_file, bytes, count, 0) != (ssize_t)count)
        bail("cannot write in memory");
}

static void write_bytes(const char *path, const void *bytes, size_t count)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, count, f) != count || fclose(f))
        bail("cannot write %s", path);
}

static size_t read_bytes(const char *path, char *bytes, size_t room)
{
    FILE *f = fopen(path, "rb");
    if (!f)
        bail("cannot read %s", path);
    const size_t count = fread(bytes, 1, room, f);
    fclose(f);
    return count;
}

static float any_f32(struct random *r)
{
    for (;;) {
        const uint32_t bits = random_u32(r);
        float value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value))
            return value;
    }
}

static double any_f64(struct random *r)
{
    for (;;) {
        const uint64_t bits = (uint64_t)random_u32(r) << 32 | random_u32(r);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value))
            return value;
    }
}

/* A stream with every type, unknown columns, keys and tables, extreme and missing values. */
static struct stream *example(size_t probes, size_t cells, uint64_t seed)
{
    struct random r = random_start(seed, 1, 2);
    struct stream *s = NULL;
    must(stream_create(&s));
    must(header_add_provenance(&s->header, "probe-place grid --spacing 1.5 'a scene.obj'"));
    must(header_add_provenance(&s->header, "probe-capture --seed 7"));
    must(header_set_key(&s->header, "sh-order", "2"));
    must(header_set_key(&s->header, "somebody-elses-key", "any value: \"yes\" \xc3\xa9"));
    struct table *t = NULL;
    struct column *c = NULL;
    must(stream_add_table(s, "probe", &t));
    must(table_add_column(t, "position", COLUMN_F64, 3, NULL));
    must(table_add_column(t, "sh", COLUMN_F32, 12, NULL));
    must(table_add_column(t, "colour_of_somebody", COLUMN_I32, 2, NULL));
    must(table_resize(t, probes));
    c = table_column(t, "position");
    for (size_t i = 0; i < 3 * probes; i++)
        column_f64(c)[i] = any_f64(&r);
    c = table_column(t, "sh");
    for (size_t i = 0; i < 12 * probes; i++)
        /* every fifth probe is not captured */
        column_f32(c)[i] = i / 12 % 5 == 4 ? NAN : any_f32(&r);
    c = table_column(t, "colour_of_somebody");
    for (size_t i = 0; i < 2 * probes; i++)
        column_i32(c)[i] = (int32_t)random_u32(&r);
    if (probes > 2) {
        static const double extremes[] = {0.0,      -0.0, DBL_MIN, DBL_MAX, 4.9406564584124654e-324,
                                          -DBL_MAX, 0.1,  1e22,    1e23};
        static const float extremes_f32[] = {0.0f,     -0.0f,    FLT_MIN, FLT_MAX,
                                             1.4e-45f, -FLT_MAX, 0.1f,    16777216.0f};
        memcpy(column_f64(table_column(t, "position")), extremes, sizeof extremes);
        memcpy(column_f32(table_column(t, "sh")), extremes_f32, sizeof extremes_f32);
    }
    must(stream_add_table(s, "tet", &t));
    must(table_add_column(t, "vertex", COLUMN_I32, 4, NULL));
    must(table_add_column(t, "neighbour", COLUMN_I32, 4, NULL));
    must(table_resize(t, cells));
    for (size_t i = 0; i < cells; i++) {
        const int32_t first = (int32_t)(random_u32(&r) % (probes - 3));
        for (int k = 0; k < 4; k++) {
            column_i32(table_column(t, "vertex"))[4 * i + (size_t)k] = first + k;
            column_i32(table_column(t, "neighbour"))[4 * i + (size_t)k] =
                (int32_t)(random_u32(&r) % (cells + 1)) - 1;
        }
    }
    must(stream_add_table(s, "unknown", &t));
    must(table_add_column(t, "thing", COLUMN_F64, 1, NULL));
    must(table_resize(t, 1));
    return s;
}

static bool same_table(const struct table *a, const struct table *b)
{
    if (strcmp(a->name, b->name) || a->rows != b->rows || a->column_count != b->column_count)
        return false;
    for (size_t i = 0; i < a->column_count; i++) {
        const struct column *p = &a->columns[i], *q = &b->columns[i];
        if (strcmp(p->name, q->name) || p->type != q->type || p->width != q->width ||
            memcmp(p->data, q->data, a->rows * p->width * column_type_size(p->type)))
            return false;
    }
    return true;
}

static bool same_stream(const struct stream *a, const struct stream *b)
{
    bool same = a->table_count == b->table_count && a->header.key_count == b->header.key_count &&
                a->header.provenance_count == b->header.provenance_count;
    for (size_t i = 0; same && i < a->header.key_count; i++)
        same = !strcmp(a->header.keys[i].name, b->header.keys[i].name) &&
               !strcmp(a->header.keys[i].value, b->header.keys[i].value);
    for (size_t i = 0; same && i < a->header.provenance_count; i++)
        same = !strcmp(a->header.provenance[i], b->header.provenance[i]);
    for (size_t i = 0; same && i < a->table_count; i++)
        same = same_table(&a->tables[i], &b->tables[i]);
    return same;
}

static void test_round_trip(void)
{
    static const size_t sizes[][2] = {{4, 0}, {5, 1}, {1000, 3000}, {30000, 70000}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct stream *s = example(sizes[i][0], sizes[i][1], i), *text = NULL, *binary = NULL;
        must(stream_write(s, path_a, STREAM_TEXT));
        must(stream_write(s, path_b, STREAM_BINARY));
        must(stream_read(&text, path_a));
        must(stream_read(&binary, path_b));
        ok(same_stream(s, text), "%zu probes: text keeps every bit", sizes[i][0]);
        ok(same_stream(s, binary), "%zu probes: binary keeps every bit", sizes[i][0]);
        ok(text->encoding == STREAM_TEXT && binary->encoding == STREAM_BINARY,
           "the encoding is recognised");
        stream_destroy(text);
        stream_destroy(binary);
        stream_destroy(s);
    }
}

/* Rows that come in other portions make the same bytes. */
static void test_portions(void)
{
    enum { ROOM = 1 << 22 };
    struct stream *s = example(9000, 0, 5);
    char *a = malloc(ROOM), *b = malloc(ROOM);
    must(stream_write(s, path_a, STREAM_BINARY));
    struct stream_writer *w = NULL;
    must(stream_writer_open(&w, path_b, STREAM_BINARY, &s->header));
    for (size_t i = 0; i < s->table_count; i++) {
        must(stream_writer_table(w, &s->tables[i]));
        for (size_t row = 0, some = 1; row < s->tables[i].rows;
             row += some, some = some * 3 % 4099) {
            some = row + some > s->tables[i].rows ? s->tables[i].rows - row : some;
            must(stream_writer_rows(w, &s->tables[i], row, some));
        }
    }
    must(stream_writer_finish(w));
    const size_t count = read_bytes(path_a, a, ROOM);
    ok(count == read_bytes(path_b, b, ROOM) && !memcmp(a, b, count),
       "portions do not show in the bytes");

    /* Reading in small portions, with a column of the caller's own. */
    struct stream_reader *r = NULL;
    struct table t;
    bool more, missing = true;
    must(stream_reader_open(&r, path_b));
    must(stream_reader_next_table(r, &t, &more));
    must(table_add_column(&t, "depth", COLUMN_F32, 1, NULL));
    for (size_t got = 1; got;)
        must(stream_reader_rows(r, &t, 7, &got));
    for (size_t i = 0; i < t.rows; i++)
        missing = missing && isnan(column_f32(table_column(&t, "depth"))[i]);
    table_remove_column(&t, "depth");
    ok(same_table(&t, stream_table(s, "probe")) && missing,
       "reading 7 rows at a time gives the same rows, added columns are missing values");
    table_clear(&t);
    must(stream_reader_next_table(r, &t, &more)); /* skip two tables */
    table_clear(&t);
    must(stream_reader_next_table(r, &t, &more));
    ok(more && !strcmp(t.name, "unknown"), "tables can be skipped");
    table_clear(&t);
    must(stream_reader_next_table(r, &t, &more));
    ok(!more && !t.name, "the end is the end");
    table_clear(&t);
    stream_reader_close(r);
    stream_destroy(s);
    free(a);
    free(b);
}

/* Whether reading is refused with a message. */
static bool refused(const char *path)
{
    struct stream *s = NULL;
    struct error *err = stream_read(&s, path);
    const bool bad = err && !s && *error_message(err);
    error_destroy(err);
    stream_destroy(s);
    return bad;
}

static void test_every_byte(void)
{
    char bytes[4096];
    struct stream *s = example(5, 2, 3);
    must(stream_write(s, path_a, STREAM_BINARY));
    const size_t count = read_bytes(path_a, bytes, sizeof bytes);
    size_t accepted = 0;
    for (size_t i = 0; i < count; i++) {
        for (int bit = SANITIZED ? (int)(i % 8) : 0; bit < 8; bit += SANITIZED ? 8 : 1) {
            bytes[i] = (char)(bytes[i] ^ 1 << bit);
            write_memory(bytes, count);
            if (!refused(memory_path)) {
                accepted++;
                printf("# byte %zu bit %d is accepted\n", i, bit);
            }
            bytes[i] = (char)(bytes[i] ^ 1 << bit);
        }
    }
    ok(count > 500 && accepted == 0, "%s of each of %zu bytes flipped: refused",
       SANITIZED ? "a bit" : "each of the 8 bits", count);
    accepted = 0;
    for (size_t length = 0; length < count; length++) {
        write_memory(bytes, length);
        accepted += !refused(memory_path);
    }
    ok(accepted == 0, "cut at any length: refused");
    bytes[count] = 0;
    write_memory(bytes, count + 1);
    ok(refused(memory_path), "a byte behind the end: refused");

    must(stream_write(s, path_a, STREAM_TEXT));
    const size_t text = read_bytes(path_a, bytes, sizeof bytes);
    accepted = 0;
    /* without its last newline it still says end */
    for (size_t length = 0; length + 1 < text; length++) {
        write_memory(bytes, length);
        accepted += !refused(memory_path);
    }
    ok(accepted == 0, "text cut at any length: refused");
    stream_destroy(s);
}

/* Reads bytes and checks that they are refused with this message behind the file's name. */
static void bytes_refused(const char *bytes, size_t count, const char *message)
{
    write_bytes(path_a, bytes, count);
    struct stream *s = NULL;
    struct error *err = stream_read(&s, path_a);
    const size_t prefix = strlen(path_a);
    ok(err && !strncmp(error_message(err), path_a, prefix) &&
           !strcmp(error_message(err) + prefix, message),
       "refused: %s", err ? error_message(err) + prefix : "(accepted)");
    error_destroy(err);
    stream_destroy(s);
}

static void text_refused(const char *text, const char *message)
{
    bytes_refused(text, strlen(text), message);
}

#define HEAD "#?probe 1\ntable probe position:f64:3\n"
#define FOUR "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
#define TET "table tet vertex:i32:4 neighbour:i32:4\n"
#define SEEN "table tet vertex:i32:4 neighbour:i32:4 stand_in:i32:1\n"

static void test_text_refused(void)
{
    text_refused("", ": expected a probe stream, got nothing");
    text_refused("solid cube\n",
                 ":1: expected a probe stream, which begins with '#?probe 1', got 'solid cube'");
    text_refused("#?probe 2\n",
                 ":1: expected a probe stream, which begins with '#?probe 1', got '#?probe 2'");
    text_refused("#?probe 1 bin\n",
                 ":1: expected '#?probe 1' or '#?probe 1 binary', got '#?probe 1 bin'");
    text_refused("#?probe 1\n",
                 ":1: expected a table or the end, got nothing: the stream is not whole");
    text_refused("#?probe 1\nkey a\nkey b\n", ":3: the key key is given twice");
    text_refused("#?probe 1\nKey a\n",
                 ":2: expected a header key, a comment or a table, got 'Key'");
    text_refused("#?probe 1\nsh-order 3\ntable probe position:f64:3 sh:f32:12\nend\n",
                 ":3: table probe: column sh has order 2, but the header's sh-order is '3'");
    text_refused("#?probe 1\ntable probe\nend\n",
                 ":2: table probe: expected at least one column, got none");
    text_refused("#?probe 1\ntable probe x:f32:1\nend\n",
                 ":2: table probe: expected a column position:f64:3, there is none");
    text_refused("#?probe 1\ntable probe position:f32:3\nend\n",
                 ":2: table probe: column position: expected f64:3, got f32:3");
    text_refused(
        "#?probe 1\ntable probe position:f64:3 sh:f32:13\nend\n",
        ":2: table probe: column sh: expected a width of 3 n^2 for an order n of 1 to 6, got 13");
    text_refused("#?probe 1\ntable probe position:f64:3 position:f64:3\nend\n",
                 ":2: table probe: column position is given twice");
    text_refused("#?probe 1\ntable probe position:f64:0\nend\n",
                 ":2: table probe: expected a column as name:type:width, got 'position:f64:0'");
    text_refused("#?probe 1\ntable probe position:f16:3\nend\n",
                 ":2: table probe: column position: expected a type f32, f64 or i32, got 'f16'");
    text_refused("#?probe 1\ntable a x:f64:1\ntable a x:f64:1\nend\n",
                 ":3: table a is given twice");
    text_refused(HEAD "0 0\nend\n", ":3: table probe: expected 3 numbers, got 2");
    text_refused(HEAD "0 0 0 0\nend\n", ":3: table probe: expected 3 numbers, got 4");
    text_refused(HEAD "0 zero 0\nend\n",
                 ":3: table probe: column position: expected a number, got 'zero'");
    text_refused(HEAD "0 1,5 0\nend\n",
                 ":3: table probe: column position: expected a number, got '1,5'");
    text_refused(HEAD "0 1e999 0\nend\n",
                 ":3: table probe: column position: expected a number, got '1e999'");
    text_refused(HEAD "0 nan 0\nend\n",
                 ":3: table probe: row 0: column position: expected finite numbers, got nan");
    text_refused(HEAD "0 0 0\n0 inf 0\nend\n",
                 ":4: table probe: row 1: column position: expected finite numbers, got inf");
    text_refused("#?probe 1\ntable probe position:f64:3 sh:f32:3\n0 0 0 1 nan 1\nend\n",
                 ":3: table probe: row 0: column sh: 1 of 3 numbers are nan; all or none may be");
    text_refused(HEAD FOUR "1 1 1\n",
                 ":7: the stream ends within table probe, after 5 rows: it is not whole");
    text_refused(HEAD FOUR "end\nmore\n", ":7: expected nothing behind the end, got more data");
    text_refused(HEAD FOUR TET "0 1 2 4 -1 -1 -1 -1\nend\n",
                 ":9: table tet: row 0: column vertex: expected an index below the number of "
                 "probes, 4, got 4");
    text_refused(HEAD FOUR TET "0 1 2 -1 -1 -1 -1 -1\nend\n",
                 ":8: table tet: row 0: column vertex: expected an index of 0 or more, got -1");
    text_refused(HEAD FOUR TET "0 1 2 3 -1 -1 1 -1\nend\n",
                 ":9: table tet: row 0: column neighbour: expected an index below the number of "
                 "cells, 1, got 1");
    text_refused(HEAD FOUR TET "0 1 2 3 -1 -1 -2 -1\nend\n",
                 ":8: table tet: row 0: column neighbour: expected an index of -1 or more, got -2");
    text_refused(HEAD FOUR SEEN "0 1 2 3 -1 -1 -1 -1 4\nend\n",
                 ":9: table tet: row 0: column stand_in: expected an index below the number of "
                 "probes, 4, got 4");
    text_refused(HEAD FOUR SEEN "0 1 2 3 -1 -1 -1 -1 -2\nend\n",
                 ":8: table tet: row 0: column stand_in: expected an index of -1 or more, got -2");
    text_refused(HEAD FOUR "table tet vertex:i32:4 neighbour:i32:4 sight:f32:11\nend\n",
                 ":7: table tet: column sight: expected f32:12, got f32:11");
    text_refused(HEAD FOUR "table tet vertex:i32:4 neighbour:i32:4 stand_in:f32:1\nend\n",
                 ":7: table tet: column stand_in: expected i32:1, got f32:1");
    static const char *const probe_columns[][2] = {
        {"irradiance:f32:3", "irradiance:f32:4"},
        {"irradiance_error:f32:3", "irradiance_error:f64:3"},
        {"rays:i32:1", "rays:f32:1"},
        {"inside:i32:1", "inside:i32:2"},
        {"ao:f32:1", "ao:f32:2"},
        {"normal:f32:3", "normal:f64:3"}};
    for (size_t i = 0; i < sizeof probe_columns / sizeof *probe_columns; i++) {
        char text[128], message[128];
        const char *const wrong = strchr(probe_columns[i][1], ':') + 1,
                          *const right = strchr(probe_columns[i][0], ':') + 1;
        const int length = (int)(right - 1 - probe_columns[i][0]);
        snprintf(text, sizeof text, "#?probe 1\ntable probe position:f64:3 %s\nend\n",
                 probe_columns[i][1]);
        snprintf(message, sizeof message, ":2: table probe: column %.*s: expected %s, got %s",
                 length, probe_columns[i][0], right, wrong);
        text_refused(text, message);
    }
    text_refused("#?probe 1\ntable probe position:f64:3 sh:f32:27 visibility:f32:4\nend\n",
                 ":2: table probe: column visibility: expected f32:9, got f32:4");
    text_refused("#?probe 1\ntable probe position:f64:3 visibility:f32:5\nend\n",
                 ":2: table probe: column visibility: expected a width of n^2 for an "
                 "order n of 1 to 6, got 5");
    text_refused(HEAD FOUR TET "0 1 2 2 -1 -1 -1 -1\nend\n",
                 ":8: table tet: row 0: column vertex: expected 4 different probes, got 2 twice");
    text_refused(HEAD FOUR TET "0 1 2 3.5 -1 -1 -1 -1\nend\n",
                 ":8: table tet: column vertex: expected a whole number of 32 bits, got '3.5'");
    text_refused(
        HEAD FOUR TET "0 1 2 99999999999 -1 -1 -1 -1\nend\n",
        ":8: table tet: column vertex: expected a whole number of 32 bits, got '99999999999'");
    text_refused(HEAD TET "0 1 2 3 -1 -1 -1 -1\nend\n",
                 ":5: table tet has 1 rows, but there are no probes");
    text_refused("#?probe 1\ntable\nend\n", ":2: header key table: expected a name of a-z, 0-9 and "
                                            "-, and a value without control characters");
    text_refused("#?probe 1\na_key v\nend\n", ":2: header key a_key: expected a name of a-z, 0-9 "
                                              "and -, and a value without control characters");
    text_refused(HEAD "0\r0 0\nend\n",
                 ":3: table probe: column position: expected a number, got '0\r0'");
    bytes_refused("#?probe 1\n# a\0b\nend\n", 20,
                  ":2: expected a line of text, got control characters");
    bytes_refused(HEAD "# a\0b\nend\n", sizeof HEAD "# a\0b\nend\n" - 1,
                  ":3: table probe: expected text, got a zero byte");
    bytes_refused(HEAD "0 0 0\0\nend\n", sizeof HEAD "0 0 0\0\nend\n" - 1,
                  ":3: table probe: column position: expected a number, got '0'");
}

/* Headers that claim more than they hold are refused for little time and memory. */
static void test_hostile(void)
{
    enum { ROOM = 1 << 18 };
    char *text = malloc(ROOM);
    int n = sprintf(text, "#?probe 1\ntable t");
    for (int i = 0; i <= 4096; i++)
        n += sprintf(text + n, " c%d:f32:1", i);
    strcpy(text + n, "\nend\n");
    text_refused(text, ":2: table t: more than 4096 columns");
    n = sprintf(text, "#?probe 1\n");
    for (int i = 0; i <= 4096; i++)
        n += sprintf(text + n, "k%d\n", i);
    strcpy(text + n, "end\n");
    text_refused(text, ":4098: more than 4096 header keys");
    n = sprintf(text, "#?probe 1\n");
    for (int i = 0; i <= 4096; i++)
        n += sprintf(text + n, "table t%d x:f32:1\n", i);
    strcpy(text + n, "end\n");
    text_refused(text, ":4098: more than 4096 tables");
    text_refused("#?probe 1\ntable t "
                 "a123456789b123456789c123456789d123456789e123456789f123456789g123:f32:1\nend\n",
                 ":2: table t: expected a column as name:type:width, got "
                 "'a123456789b123456789c123456789d123456789'");
    text_refused("#?probe 1\ntable t x:f32:262145\nend\n",
                 ":2: table t: a row takes 1048580 bytes, more than 1048576");
    text_refused("#?probe 1\ntable t x:f32:262144\n",
                 ":2: the stream ends within table t, after 0 rows: it is not whole");
    text_refused(
        "#?probe 1\ntable t x:f32:99999999999999999999\nend\n",
        ":2: table t: expected a column as name:type:width, got 'x:f32:99999999999999999999'");

    static const char head[] = "#?probe 1 binary\ntable t x:f32:1\n";
    static const uint32_t counts[][2] = {
        {4194305, 16777220}, {0xffffffff, 0xfffffffc}, {2, 12}, {0, 4}, {1, 0}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        char message[200];
        n = sprintf(text, "%s", head);
        memcpy(text + n, counts[i], 8);
        memset(text + n + 8, 0, 8);
        sprintf(message,
                ": byte %d: table t: expected a block of rows of 4 bytes, at most 16777216 bytes, "
                "got %u rows in %u bytes",
                n, counts[i][0], counts[i][1]);
        bytes_refused(text, (size_t)n + 16, message);
    }
    memcpy(text + n, (const uint32_t[]){4194304, 16777216}, 8);
    bytes_refused(text, (size_t)n + 16,
                  ": byte 33: the stream ends within table t, after 0 rows: it is not whole");
    free(text);
}

/* The checksum at the end covers every byte before it, so this one pins the format. */
static void test_format(void)
{
    static const char text[] =
        "#?probe 1\n# a command\nsh-order 1\nending here\ntable probe position:f64:3 sh:f32:3\n"
        "0 0 0 .5 .5 .5\n1 -2 3e5 nan nan nan\ntable empty thing:i32:1\nend\n";
    char bytes[1024] = "";
    struct stream *s = NULL;
    write_bytes(path_a, text, sizeof text - 1);
    must(stream_read(&s, path_a));
    ok(!strcmp(header_key(&s->header, "ending"), "here"), "a key may begin like 'end'");
    must(stream_write(s, path_b, STREAM_BINARY));
    const size_t count = read_bytes(path_b, bytes, sizeof bytes - 1);
    ok(count == 253 && !strcmp(bytes + count - 21, "end ba957f20c4df9d86\n"),
       "binary is what it always was: %zu bytes, %.20s", count, bytes + count - 21);
    stream_destroy(s);
}

static void test_text_accepted(void)
{
    const char text[] =
        "#?probe 1\r\n# made by hand\r\nkey value\r\n\r\ntable probe position:f64:3 depth:f32:1\r\n"
        "  +1\t2e0 3 .5\r\n# between rows\n\n4 5 6 nan\n-0 1e-400 7 1e-60\nend";
    write_bytes(path_a, text, sizeof text - 1);
    struct stream *s = NULL;
    must(stream_read(&s, path_a));
    const double *p = column_f64(table_column(stream_table(s, "probe"), "position"));
    const float *d = column_f32(table_column(stream_table(s, "probe"), "depth"));
    ok(stream_table(s, "probe")->rows == 3 && p[0] == 1 && p[1] == 2 && p[5] == 6 && d[0] == 0.5f &&
           isnan(d[1]),
       "CRLF, tabs, +, comments and blank lines are read");
    ok(signbit(p[6]) && p[7] == 0 && d[2] == 0, "-0 stays, what underflows is 0");
    ok(!strcmp(header_key(&s->header, "key"), "value") &&
           !strcmp(s->header.provenance[0], "made by hand"),
       "and the header");
    stream_destroy(s);
}

static void test_numbers(void)
{
    struct random r = random_start(11, 12, 13);
    size_t wrong = 0;
    for (int i = 0; i < 200000; i++) {
        char text[NUMBER_ROOM];
        const double a = any_f64(&r);
        double a_back = 0;
        char *end = number_write_f64(text, a);
        wrong += number_read_f64(text, end, &a_back) != end || memcmp(&a, &a_back, sizeof a);
        const float b = any_f32(&r);
        float b_back = 0;
        end = number_write_f32(text, b);
        wrong += number_read_f32(text, end, &b_back) != end || memcmp(&b, &b_back, sizeof b);
        wrong += end - text > 16; /* shortest: 9 digits, sign, point, e-38 */
    }
    ok(wrong == 0, "200000 random doubles and floats come back to the bit");
}

static void test_writing(void)
{
    struct stream *s = example(10, 3, 1);
    struct stat status;
    write_bytes(path_a, "old", 3);
    chmod(path_a, 0640);
    struct stream_writer *w = NULL;
    must(stream_writer_open(&w, path_a, STREAM_BINARY, &s->header));
    must(stream_writer_table(w, &s->tables[0]));
    must(stream_writer_rows(w, &s->tables[0], 0, 10));
    char bytes[8];
    ok(read_bytes(path_a, bytes, sizeof bytes) == 3, "until the end the old file stays");
    stream_writer_abandon(w);
    ok(read_bytes(path_a, bytes, sizeof bytes) == 3, "an abandoned stream leaves the old file");
    must(stream_write(s, path_a, STREAM_BINARY));
    ok(!stat(path_a, &status) && (status.st_mode & 07777) == 0640 && status.st_size > 100,
       "the new file has the old one's mode");

    struct error *err = stream_write(s, "/dev/full", STREAM_BINARY);
    ok(err && !strcmp(error_message(err), "/dev/full: No space left on device"),
       "a full disk is an error");
    error_destroy(err);
    err = stream_write(s, "/nonexistent/file", STREAM_BINARY);
    ok(err && strstr(error_message(err), "/nonexistent/file: No such file"),
       "so is a directory that is not there");
    error_destroy(err);
    unlink(path_b);
    column_f64(table_column(stream_table(s, "probe"), "position"))[4] = INFINITY;
    err = stream_write(s, path_b, STREAM_TEXT);
    ok(err && access(path_b, F_OK), "an invalid stream is not written: %s",
       err ? error_message(err) : "");
    error_destroy(err);
    stream_destroy(s);

    struct stream_header h = {0};
    err = header_set_key(&h, "a key", "v");
    ok(err != NULL, "a key's name is checked");
    error_destroy(err);
    err = header_set_key(&h, "key", "two\nlines");
    ok(err != NULL, "a key's value is checked");
    error_destroy(err);
    must(header_add_provenance(&h, "two\nlines"));
    ok(!strcmp(h.provenance[0], "two?lines"), "provenance stays one line");
    header_clear(&h);
}

/* Whether the error is this, word for word. */
static bool says(struct error *err, const char *message)
{
    const bool same = err && !strcmp(error_message(err), message);
    if (!same)
        printf("# %s\n", err ? error_message(err) : "no error");
    error_destroy(err);
    return same;
}

/* Numbers in header keys: back to the bit, and what is none or out of range is refused and changes
 * nothing. */
static void test_header_numbers(void)
{
    static const char *const names[] = {"all", "direct", "indirect", NULL};
    const double written[3] = {0.1, -1e300, 4.9406564584124654e-324};
    double read[3] = {7, 7, 7};
    int64_t whole = 7;
    int number = 7, choice = 7;
    struct stream_header h = {0};
    must(header_set_reals(&h, "three", 3, written));
    must(header_get_reals(&h, "three", 3, -DBL_MAX, DBL_MAX, read));
    ok(!memcmp(read, written, sizeof read), "numbers of a key come back to the bit");
    must(header_set_whole(&h, "whole", (int64_t)1 << 53));
    must(header_get_whole(&h, "whole", 0, INT64_MAX, &whole));
    ok(whole == (int64_t)1 << 53, "so does a whole number");
    must(header_set_key(&h, "light", "indirect"));
    must(header_get_choice(&h, "light", names, &choice));
    ok(choice == 2, "and a choice");
    must(header_get_whole(&h, "none", 0, 1, &whole));
    must(header_get_reals(&h, "none", 3, 0, 1, read));
    must(header_get_choice(&h, "none", names, &choice));
    ok(whole == (int64_t)1 << 53 && read[0] == written[0] && choice == 2,
       "a key that is not there changes nothing");
    ok(says(header_require(&h, "none"), "header key none is expected, there is none"),
       "unless it is required");

    static const struct {
        const char *value, *of_int, *of_real;
    } wrong[] = {{"", "expected a whole number from 1 to 9, got ''",
                  "expected a number from 0 to 1, got ''"},
                 {"10", "expected a whole number from 1 to 9, got '10'",
                  "expected a number from 0 to 1, got '10'"},
                 {"-1", "expected a whole number from 1 to 9, got '-1'",
                  "expected a number from 0 to 1, got '-1'"},
                 {"99999999999999999999",
                  "expected a whole number from 1 to 9, got '99999999999999999999'",
                  "expected a number from 0 to 1, got '99999999999999999999'"},
                 {"1x", "expected a whole number from 1 to 9, got '1x'",
                  "expected a number from 0 to 1, got '1x'"},
                 {"1,1", "expected a whole number from 1 to 9, got '1,1'",
                  "expected a number from 0 to 1, got '1,1'"},
                 {"nan", "expected a whole number from 1 to 9, got 'nan'",
                  "expected a number from 0 to 1, got 'nan'"}};
    bool refused = true;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char of_int[100], of_real[100];
        snprintf(of_int, sizeof of_int, "header key wrong: %s", wrong[i].of_int);
        snprintf(of_real, sizeof of_real, "header key wrong: %s", wrong[i].of_real);
        must(header_set_key(&h, "wrong", wrong[i].value));
        refused = says(header_get_int(&h, "wrong", 1, 9, &number), of_int) && refused;
        refused = says(header_get_real(&h, "wrong", 0, 1, &read[0]), of_real) && refused;
    }
    ok(refused && number == 7 && read[0] == written[0], "what is no number, or out of range, is "
                                                        "refused and changes nothing");
    must(header_set_key(&h, "wrong", "1,2"));
    ok(says(header_get_reals(&h, "wrong", 3, -DBL_MAX, DBL_MAX, read),
            "header key wrong: expected 3 numbers separated by commas, got '1,2'") &&
           !memcmp(read, written, sizeof read),
       "so are too few");
    must(header_set_key(&h, "wrong", "-1"));
    ok(says(header_get_real(&h, "wrong", 0, DBL_MAX, read),
            "header key wrong: expected a number from 0, got '-1'"),
       "a limit that there is not is not told");
    ok(says(header_get_choice(&h, "wrong", names, &choice),
            "header key wrong: expected all, direct or indirect, got '-1'"),
       "a choice names what there is");
    header_clear(&h);
}

int main(void)
{
    if (!mkdtemp(directory))
        bail("no temporary directory");
    snprintf(path_a, sizeof path_a, "%s/a", directory);
    snprintf(path_b, sizeof path_b, "%s/b", directory);
    test_numbers();
    test_round_trip();
    test_portions();
    test_every_byte();
    test_text_refused();
    test_hostile();
    test_text_accepted();
    test_format();
    test_writing();
    test_header_numbers();
    unlink(path_a);
    unlink(path_b);
    rmdir(directory);
    return tap_done();
}
