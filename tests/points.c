/* SPDX-License-Identifier: Apache-2.0 */
/* Points from text and from numbers: what is written is what is read, however it is cut into
 * blocks, and what is wrong is named by its line. */
#include "math/random.h"
#include "stream/points.h"
#include "support/files.h"
#include "support/tap.h"

enum { POINTS = 500, ROOM = 1 << 17 };

/* Points, as text among lines that hold none, and the line of each, from 1. */
struct written {
    double value[6 * POINTS];
    size_t width, line[POINTS], lines, bytes;
    char text[ROOM];
};

static void add_text(struct written *w, const char *text)
{
    w->bytes += (size_t)snprintf(w->text + w->bytes, ROOM - w->bytes, "%s", text);
}

static void fill(struct written *w, size_t width)
{
    static const char *const between[] = {"\n", "# 1 2 3\n", " \t\n", "  # 7\n"};
    struct random r = random_start(1, width, 0);
    *w = (struct written){.width = width};
    for (size_t i = 0; i < POINTS; i++) {
        for (; random_u32(&r) % 3 == 0; w->lines++)
            add_text(w, between[random_u32(&r) % 4]);
        w->line[i] = ++w->lines;
        for (size_t k = 0; k < width; k++) {
            char number[64];
            const double scale = pow(10, 600 * random_double(&r) - 300);
            w->value[i * width + k] = scale * (2 * random_double(&r) - 1);
            snprintf(number, sizeof number, "%s%.17g",
                     k       ? i % 2 ? " " : "\t "
                     : i % 3 ? ""
                             : "  ",
                     w->value[i * width + k]);
            add_text(w, number);
        }
        add_text(w, i == POINTS - 1 ? "" : i % 5 ? "\n" : " \r\n"); /* the last has no newline */
    }
    if (w->bytes >= ROOM)
        bail("no room");
}

/* Reads `path`, up to `most` points a time: whether they are those that were written. */
static bool reads_back(const struct written *w, const char *path, enum points_format format,
                       size_t most)
{
    struct points *points;
    double *value = malloc((most + POINTS) * 6 * sizeof *value);
    size_t total = 0, got = 1, width;
    bool same = value;
    must(points_open(&points, path, POINTS_PLACES, format, w->width == 6));
    while (same && got) {
        must(points_read(points, most, value, &width, &got));
        same = got <= most && total + got <= POINTS && (!got || width == w->width) &&
               !memcmp(value, w->value + total * w->width, got * w->width * sizeof *value);
        total += got;
    }
    points_close(points);
    free(value);
    return same && total == POINTS;
}

static void test_round_trip(const struct written *w)
{
    static const size_t most[] = {1, 2, 7, 64, POINTS, 10 * POINTS};
    files_write_bytes("text", w->text, w->bytes);
    files_write_bytes("numbers", w->value, POINTS * w->width * sizeof *w->value);
    int text = 0, binary = 0;
    for (size_t i = 0; i < sizeof most / sizeof *most; i++) {
        text += !reads_back(w, files_path("text"), POINTS_TEXT, most[i]);
        binary += !reads_back(w, files_path("numbers"), POINTS_BINARY, most[i]);
    }
    ok(!text, "%zu numbers a line: read to the bit, in portions of any size", w->width);
    ok(!binary, "%zu numbers a point in binary: as well", w->width);
}

/* Whether the error begins with the path and then `place`. */
static bool is_at(struct error *err, const char *path, const char *place, size_t number)
{
    char expected[PATH_MAX + 64];
    snprintf(expected, sizeof expected, "%s:%s%zu: ", path, place, number);
    const bool at = err && !strncmp(error_message(err), expected, strlen(expected));
    error_destroy(err);
    return at;
}

/* A message about any point names its line, or its number. */
static void test_places(const struct written *w, enum points_format format)
{
    const char *path = files_path(format == POINTS_TEXT ? "text" : "numbers");
    struct points *points;
    struct points_block block = {0};
    size_t total = 0, wrong = 0, blocks = 0;
    must(points_open(&points, path, POINTS_PLACES, format, w->width == 6));
    for (;; blocks++) {
        must(points_take(points, 10, &block));
        if (!block.bytes)
            break;
        must(points_parse(points, &block));
        for (size_t i = 0; i < block.count && total < POINTS; i++, total++) {
            struct error *err = points_block_place(points, &block, i, error_new("it"));
            wrong += format == POINTS_TEXT ? !is_at(err, path, "", w->line[total])
                                           : !is_at(err, path, " point ", total);
        }
    }
    ok(total == POINTS && blocks > 3 && !wrong, "each of %zu points in %zu blocks has its %s",
       total, blocks, format == POINTS_TEXT ? "line" : "number");
    points_block_clear(&block);
    points_close(points);
}

/* The first error, if there is one. */
static struct error *read_all(const char *path, enum points_format format, bool normals)
{
    struct points *points;
    double value[6 * 20];
    size_t width, got = 1;
    must(points_open(&points, path, POINTS_PLACES, format, normals));
    struct error *err = NULL;
    while (!err && got)
        err = points_read(points, 20, value, &width, &got);
    points_close(points);
    return err;
}

/* One line that is wrong, among others, is refused by its number. */
static void test_wrong_lines(void)
{
    static const char *const lines[] = {"1 2",       "1 2 3 4",      "1 2 3 4 5 6", "1 2 x",
                                        "1,2,3",     "1 2 nan",      "1 inf 3",     "1 2 3 no",
                                        "0x1p3 2 3", "1 2 3 4 5 6 7"};
    static char text[ROOM];
    size_t wrong = 0;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        for (size_t at = 2; at < 90; at += 11) {
            size_t bytes = 0;
            for (size_t line = 1; line <= 90; line++)
                bytes += (size_t)snprintf(text + bytes, ROOM - bytes, "%s\n",
                                          line == at      ? lines[i]
                                          : line % 4 == 3 ? "# comment"
                                                          : "1 2 3");
            files_write("wrong", text);
            const bool named = is_at(read_all(files_path("wrong"), POINTS_TEXT, false),
                                     files_path("wrong"), "", at);
            if (!named)
                printf("# '%s' in line %zu\n", lines[i], at);
            wrong += !named;
        }
    }
    ok(!wrong, "lines that are no points are refused, each by its number (%zu are not)", wrong);
}

/* Numbers that end within a point, or are not finite. */
static void test_wrong_numbers(void)
{
    double value[3 * 51] = {0};
    int wrong = 0;
    for (size_t bytes = 0; bytes < 24 * 4; bytes++) {
        files_write_bytes("cut", value, bytes);
        struct error *err = read_all(files_path("cut"), POINTS_BINARY, false);
        if (bytes % 24)
            wrong += !is_at(err, files_path("cut"), " point ", bytes / 24);
        else
            wrong += err != NULL;
    }
    ok(!wrong, "numbers that end within a point are refused, by its number (%d are not)", wrong);
    wrong = 0;
    for (size_t i = 0; i < 3 * 51; i++) {
        value[i] = i % 3 ? i % 3 == 1 ? INFINITY : -INFINITY : NAN;
        files_write_bytes("infinite", value, sizeof value);
        wrong += !is_at(read_all(files_path("infinite"), POINTS_BINARY, false),
                        files_path("infinite"), " point ", i / 3);
        value[i] = 0;
    }
    ok(!wrong, "and so are points that are not finite (%d are not)", wrong);
}

int main(void)
{
    static struct written w;
    files_begin();
    for (size_t width = 3; width <= 6; width += 3) {
        fill(&w, width);
        test_round_trip(&w);
        test_places(&w, POINTS_TEXT);
        test_places(&w, POINTS_BINARY);
    }
    test_wrong_lines();
    test_wrong_numbers();
    files_end();
    return tap_done();
}
