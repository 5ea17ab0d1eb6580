/* SPDX-License-Identifier: Apache-2.0 */
/* What is salvaged of a stream that was cut, at every length: each row that is whole, in order and
 * to the bit, and nothing else. */
#include "base/warning.h"
#include "math/random.h"
#include "stream/stream.h"
#include "stream/stream_salvage.h"
#include "support/files.h"
#include "support/tap.h"

enum {
    ROWS = 9,
    NARROW = 2,
    WIDE = 10000, /* of which a block holds three rows */
    BLOCK_ROWS = 3,
    ROOM = 1 << 20,
    ANY = 30 /* places by chance */
};

/* A stream, its bytes, and where in them each row of table probe is whole. */
struct written {
    struct stream *stream;
    char *bytes;
    size_t size, whole[ROWS];
};

/* One probe has no light; with cells, table tet follows, and one that nobody knows goes before and
 * one behind. */
static struct stream *make_stream(size_t width, bool cells)
{
    struct random r = random_start(2, 0, 0);
    struct stream *s;
    struct table *t;
    struct column *c;
    must(stream_create(&s));
    must(header_add_provenance(&s->header, "probe-place -"));
    if (cells) {
        must(stream_add_table(s, "theirs", &t));
        must(table_add_column(t, "row", COLUMN_I32, 1, &c));
        must(table_resize(t, 1));
        column_i32(table_column(t, "row"))[0] = 7;
    }
    must(stream_add_table(s, "probe", &t));
    must(table_add_column(t, "position", COLUMN_F64, 3, &c));
    must(table_add_column(t, "their_column", COLUMN_F64, width, &c));
    must(table_resize(t, ROWS));
    for (size_t i = 0; i < (size_t)3 * ROWS; i++)
        column_f64(table_column(t, "position"))[i] = 100 * random_double(&r);
    for (size_t i = 0; i < width * ROWS; i++)
        if (i / width != 4)
            column_f64(table_column(t, "their_column"))[i] = random_double(&r);
    if (cells) {
        must(stream_add_table(s, "tet", &t));
        must(table_add_column(t, "vertex", COLUMN_I32, 4, &c));
        must(table_resize(t, 2));
        for (int32_t i = 0; i < 8; i++)
            column_i32(table_column(t, "vertex"))[i] = i % 4 + i / 4;
        must(stream_add_table(s, "behind", &t));
        must(table_add_column(t, "share", COLUMN_F32, 1, &c));
        must(table_resize(t, 1));
        column_f32(table_column(t, "share"))[0] = 0.1f;
    }
    return s;
}

static struct written write_stream(size_t width, bool cells, enum stream_encoding encoding)
{
    struct written w = {.stream = make_stream(width, cells), .bytes = malloc(ROOM)};
    must(stream_write(w.stream, files_path("whole"), encoding));
    FILE *file = fopen(files_path("whole"), "rb");
    w.size = file && w.bytes ? fread(w.bytes, 1, ROOM - 1, file) : 0;
    if (!w.size || fclose(file))
        bail("the stream cannot be read back");
    w.bytes[w.size] = 0;
    const char *at = memmem(w.bytes, w.size, "table probe", 11);
    at = strchr(at, '\n') + 1;
    const size_t row_bytes = (3 + width) * sizeof(double), head = 16;
    for (size_t i = 0; i < ROWS; i++) {
        if (encoding == STREAM_TEXT)
            at = strchr(at, '\n') + 1;
        else if (i % BLOCK_ROWS == 0)
            at += head + BLOCK_ROWS * row_bytes;
        w.whole[i] = (size_t)(at - w.bytes);
    }
    return w;
}

static void clear_written(struct written *w)
{
    stream_destroy(w->stream);
    free(w->bytes);
}

/* Whether rows of all columns are the first ones of the table that was written. */
static bool is_beginning(const struct table *of, const struct table *t)
{
    bool same = t && t->column_count == of->column_count && t->rows <= of->rows;
    for (size_t i = 0; i < of->column_count && same; i++) {
        const struct column *a = &of->columns[i], *b = &t->columns[i];
        same = !strcmp(a->name, b->name) && a->type == b->type && a->width == b->width &&
               !memcmp(a->data, b->data, t->rows * a->width * column_type_size(a->type));
    }
    return same;
}

/* Of every length the rows that are whole up to there. Where there is none, an error may say so. */
static void check_cut(const struct written *w, size_t length, size_t *wrong, size_t *refused)
{
    struct warnings warnings = {0};
    struct stream *s;
    size_t rows = 0;
    while (rows < ROWS && w->whole[rows] <= length)
        rows++;
    files_write_bytes("cut", w->bytes, length);
    struct error *err = stream_salvage(&s, files_path("cut"), &warnings);
    if (err) {
        *wrong += rows > 0 || s;
        ++*refused;
    } else {
        const struct table *probes = stream_table(s, "probe"), *cells = stream_table(s, "tet"),
                           *written = stream_table(w->stream, "tet");
        bool right = is_beginning(stream_table(w->stream, "probe"), probes) && probes->rows == rows;
        if (cells) /* all of them, and of all probes */
            right &= rows == ROWS && written && is_beginning(written, cells) &&
                     cells->rows == written->rows;
        if (length == w->size)
            right &= !warnings.count && s->table_count == w->stream->table_count;
        else if (rows < ROWS)
            right &= s->table_count == 1;
        *wrong += !right;
    }
    error_destroy(err);
    stream_destroy(s);
    warnings_clear(&warnings);
}

static void test_every_length(const char *name, bool cells, enum stream_encoding encoding)
{
    struct written w = write_stream(NARROW, cells, encoding);
    size_t wrong = 0, refused = 0;
    const size_t end = w.whole[0] + (ROWS - BLOCK_ROWS) * (3 + NARROW) * sizeof(double);
    for (size_t i = 0; i < ROWS && encoding == STREAM_BINARY; i++)
        w.whole[i] = end; /* of the one block that holds them */
    for (size_t length = 0; length <= w.size; length++)
        check_cut(&w, length, &wrong, &refused);
    ok(!wrong && refused < w.whole[0],
       "%s: of each of %zu lengths every whole row, and nothing else (%zu are wrong)", name, w.size,
       wrong);
    clear_written(&w);
}

/* Large enough for several blocks: lengths around their ends, and any. */
static void test_blocks(void)
{
    struct written w = write_stream(WIDE, true, STREAM_BINARY);
    struct random r = random_start(6, 0, 0);
    size_t wrong = 0, refused = 0;
    for (size_t i = 0; i < ROWS; i += BLOCK_ROWS)
        for (size_t off = 0; off < 20; off++)
            check_cut(&w, w.whole[i] + off - 10, &wrong, &refused);
    for (int i = 0; i < ANY; i++)
        check_cut(&w, (size_t)(random_double(&r) * (double)(w.size + 1)), &wrong, &refused);
    ok(!wrong && refused < ANY, "several blocks: the rows of those that are whole (%zu are wrong)",
       wrong);
    clear_written(&w);
}

/* A bit that flips in a block costs its rows and those after it. */
static void test_damaged(void)
{
    struct written w = write_stream(WIDE, false, STREAM_BINARY);
    struct random r = random_start(7, 0, 0);
    int wrong = 0;
    for (int i = 0; i < ANY; i++) {
        const size_t at = w.whole[0] +
                          (size_t)(random_double(&r) * (double)(w.whole[ROWS - 1] - w.whole[0]));
        size_t rows = 0;
        struct warnings warnings = {0};
        struct stream *s;
        while (w.whole[rows] <= at)
            rows++;
        w.bytes[at] ^= (char)(1 << i % 8);
        files_write_bytes("damaged", w.bytes, w.size);
        w.bytes[at] ^= (char)(1 << i % 8);
        must(stream_salvage(&s, files_path("damaged"), &warnings));
        const struct table *probes = stream_table(s, "probe");
        wrong += !is_beginning(stream_table(w.stream, "probe"), probes) || probes->rows != rows ||
                 warnings.count != 1;
        stream_destroy(s);
        warnings_clear(&warnings);
    }
    ok(!wrong, "a flipped bit: the rows of the blocks before it (%d are wrong)", wrong);
    clear_written(&w);
}

int main(void)
{
    files_begin();
    test_every_length("text", false, STREAM_TEXT);
    test_every_length("text with cells", true, STREAM_TEXT);
    test_every_length("binary", false, STREAM_BINARY);
    test_every_length("binary with cells", true, STREAM_BINARY);
    test_blocks();
    test_damaged();
    files_end();
    return tap_done();
}
