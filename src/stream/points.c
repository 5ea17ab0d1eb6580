/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/points.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "base/warning.h"

#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_BYTES = 32 }; /* about what a point of a text takes */

/* Numbers of a point without more and with, and what they are. */
static const struct shape {
    size_t least, most;
    const char *text;
} shapes[] = {[POINTS_PLACES] = {3, 6, "x y z or x y z nx ny nz"},
              [POINTS_TIMED] = {3, 4, "x y z or x y z t"},
              [POINTS_TIMES] = {1, 4, "t or t nx ny nz"}};

struct points {
    struct file_input in; /* its descriptor and name */
    const struct shape *shape;
    enum points_format format;
    size_t width; /* 0: not known yet */
    size_t next;  /* number of the next point or line */
    bool cut;     /* text: it has ended, in a number and without a line end */
    char *rest;   /* what came behind the last whole point or line; owned */
    size_t rest_bytes, rest_capacity;
    /* points_read: the block that is being handed out, and what of it is next and was last */
    struct points_block last;
    size_t at, was;
};

struct error *points_open(struct points **points, const char *path, enum points_shape shape,
                          enum points_format format, bool more)
{
    struct points *p = NULL;
    *points = NULL;
    struct error *err = array_create(&p, 1, sizeof *p);
    if (err)
        return err;
    p->format = format;
    p->shape = &shapes[shape];
    p->width = format == POINTS_TEXT ? 0 : more ? p->shape->most : p->shape->least;
    p->next = format == POINTS_TEXT;
    err = file_input_open(&p->in, path);
    if (err)
        free(p);
    else
        *points = p;
    return err;
}

void points_close(struct points *p)
{
    if (!p)
        return;
    file_input_close(&p->in);
    points_block_clear(&p->last);
    free(p->rest);
    free(p);
}

bool points_ready(const struct points *p, int milliseconds)
{
    struct pollfd fd = {.fd = p->in.fd, .events = POLLIN};
    return p->in.ended || poll(&fd, 1, milliseconds) != 0;
}

void points_block_clear(struct points_block *block)
{
    free(block->data);
    free(block->number);
    *block = (struct points_block){0};
}

/* -- lines ----------------------------------------------------------------------------------- */

static const char *line_end(const char *at, const char *end)
{
    const char *newline = memchr(at, '\n', (size_t)(end - at));
    return newline ? newline : end;
}

static const char *skip_blanks(const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r'))
        at++;
    return at;
}

static bool holds_point(const char *line, const char *end)
{
    line = skip_blanks(line, end);
    return line < end && *line != '#';
}

static bool ends_word(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '#';
}

/* The numbers of a line that holds some; no more than 6 are kept. */
static struct error *read_line(const char *line, const char *end, double value[6], size_t *count)
{
    *count = 0;
    for (const char *at = skip_blanks(line, end); at < end && *at != '#';) {
        double x;
        const char *behind = number_read_f64(at, end, &x);
        if (!behind || (behind < end && !ends_word(*behind))) {
            size_t length = 0;
            while (at + length < end && !ends_word(at[length]))
                length++;
            return error_new("expected a number, got '%.*s'", (int)(length < 40 ? length : 40), at);
        }
        if (*count < 6)
            value[*count] = x;
        ++*count;
        at = skip_blanks(behind, end);
    }
    return NULL;
}

static struct error *check_count(const struct shape *shape, size_t width, size_t count)
{
    if (!width)
        return error_new("expected %s, got %zu number%s", shape->text, count,
                         count == 1 ? "" : "s");
    if (count != width)
        return error_new("expected %zu numbers, as in the lines before, got %zu", width, count);
    return NULL;
}

static struct error *check_finite(const double *value, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(value[i]))
            return error_new("expected finite numbers, got %s", isnan(value[i]) ? "nan"
                                                                : value[i] < 0  ? "-inf"
                                                                                : "inf");
    return NULL;
}

/* The first line that holds a point says how many numbers all have. */
static void find_width(struct points *p, const char *at, const char *end)
{
    for (const char *stop; !p->width && at < end; at = stop + 1) {
        double value[6];
        size_t count = 0;
        stop = line_end(at, end);
        if (!holds_point(at, stop))
            continue;
        error_destroy(read_line(at, stop, value, &count));
        p->width = count == p->shape->least || count == p->shape->most ? count : 0;
        return; /* a line that is wrong is refused when it is parsed */
    }
}

static size_t count_lines(const char *at, const char *end)
{
    size_t lines = 0;
    for (; at < end; at++)
        lines += *at == '\n';
    return lines;
}

/* -- blocks ---------------------------------------------------------------------------------- */

/* Bytes of the whole points or lines at the front of a block. */
static size_t whole_bytes(const struct points *p, const struct points_block *block)
{
    if (p->format == POINTS_BINARY)
        return block->bytes - block->bytes % (p->width * sizeof(double));
    if (p->in.ended)
        return block->bytes;
    const char *newline = memrchr(block->data, '\n', block->bytes);
    return newline ? (size_t)(newline + 1 - block->data) : 0;
}

static struct error *read_more(struct points *p, size_t most, struct points_block *block)
{
    struct error *err = array_reserve(&block->data, &block->capacity, block->bytes + most, 1);
    if (err)
        return err;
    size_t got;
    err = file_input_read(&p->in, block->data + block->bytes, most, &got);
    block->bytes += got;
    return err;
}

/* Keeps what stands behind the first `bytes` bytes for the next block. */
static struct error *keep_rest(struct points *p, struct points_block *block, size_t bytes)
{
    p->rest_bytes = block->bytes - bytes;
    struct error *err = array_reserve(&p->rest, &p->rest_capacity, p->rest_bytes, 1);
    if (!err && p->rest_bytes)
        memcpy(p->rest, block->data + bytes, p->rest_bytes);
    block->bytes = bytes;
    return err;
}

/* Whether the text of a block ends in a number. */
static bool ends_in_number(const struct points_block *block)
{
    const char *const end = block->data + block->bytes;
    if (!block->bytes || !memchr("0123456789.", end[-1], 11))
        return false;
    const char *newline = memrchr(block->data, '\n', block->bytes);
    const char *line = newline ? newline + 1 : block->data;
    return !memchr(line, '#', (size_t)(end - line));
}

void points_warn_end(const struct points *p, struct warnings *warnings)
{
    if (p->cut && p->next > 1)
        warnings_add(warnings, "last line without an end",
                     "%s:%zu: nothing ends the last line: if the file is cut off there, its last "
                     "number is another",
                     p->in.name, p->next);
}

struct error *points_take(struct points *p, size_t most, struct points_block *block)
{
    const size_t bytes = most *
                         (p->format == POINTS_BINARY ? p->width * sizeof(double) : LINE_BYTES);
    struct error *err = array_reserve(&block->data, &block->capacity, p->rest_bytes + bytes, 1);
    block->bytes = block->count = 0;
    if (err)
        return err;
    if (p->rest_bytes)
        memcpy(block->data, p->rest, p->rest_bytes);
    block->bytes = p->rest_bytes;
    p->rest_bytes = 0;
    size_t whole = 0;
    while (!err && !p->in.ended && !whole) {
        err = read_more(p, bytes, block);
        whole = err ? 0 : whole_bytes(p, block);
        if (!err && !whole && block->bytes > FILE_LINE_MOST)
            err = error_new("%s:%zu: the line is longer than %d bytes", p->in.name, p->next,
                            FILE_LINE_MOST);
    }
    if (!err && p->in.ended && p->format == POINTS_BINARY && block->bytes > whole)
        err = error_new("%s: point %zu: expected %zu bytes, got %zu", p->in.name, p->next,
                        p->width * sizeof(double), block->bytes - whole);
    if (!err)
        err = keep_rest(p, block, whole);
    if (err)
        return err;
    if (p->format == POINTS_TEXT && p->next == 1 && block->bytes >= 3 &&
        !memcmp(block->data, "\xef\xbb\xbf", 3)) /* a byte order mark */
        memset(block->data, ' ', 3);
    if (p->format == POINTS_TEXT && !p->width)
        find_width(p, block->data, block->data + block->bytes);
    p->cut = p->format == POINTS_TEXT && p->in.ended &&
             (block->bytes ? ends_in_number(block) : p->cut);
    block->first = p->next;
    block->width = p->width;
    p->next += p->format == POINTS_TEXT ? count_lines(block->data, block->data + block->bytes)
                                        : block->bytes / (p->width * sizeof(double));
    return NULL;
}

static struct error *parse_text(const struct points *p, struct points_block *block)
{
    const char *end = block->data + block->bytes, *stop;
    struct error *err = NULL;
    size_t line = block->first;
    for (const char *at = block->data; !err && at < end; at = stop + 1, line++) {
        double value[6];
        size_t count = 0;
        stop = line_end(at, end);
        if (!holds_point(at, stop))
            continue;
        err = read_line(at, stop, value, &count);
        if (!err)
            err = check_count(p->shape, block->width, count);
        if (!err)
            err = check_finite(value, count);
        if (err)
            return error_wrap(err, "%s:%zu", p->in.name, line);
        err = array_reserve(&block->number, &block->number_capacity, (block->count + 1) * count,
                            sizeof *block->number);
        if (!err)
            memcpy(block->number + block->count++ * count, value, count * sizeof *value);
    }
    block->value = block->number;
    return err;
}

struct error *points_parse(const struct points *p, struct points_block *block)
{
    if (p->format == POINTS_TEXT)
        return parse_text(p, block);
    struct error *err = NULL;
    block->value = (const double *)(const void *)block->data;
    block->count = block->bytes / (block->width * sizeof(double));
    /* x - x is 0, or NaN where x is not finite; two points or one at a time */
    double rest[6] = {0};
    size_t at = 0;
    for (; at + 6 <= block->count * block->width; at += 6)
        for (size_t k = 0; k < 6; k++)
            rest[k] += block->value[at + k] - block->value[at + k];
    for (; at < block->count * block->width; at++)
        rest[0] += block->value[at] - block->value[at];
    const bool finite = rest[0] + rest[1] + rest[2] + rest[3] + rest[4] + rest[5] == 0;
    for (size_t i = 0; i < block->count && !finite && !err; i++)
        err = points_block_place(p, block, i,
                                 check_finite(block->value + i * block->width, block->width));
    return err;
}

struct error *points_block_place(const struct points *p, const struct points_block *block, size_t i,
                                 struct error *err)
{
    if (!err)
        return NULL;
    if (p->format == POINTS_BINARY)
        return error_wrap(err, "%s: point %zu", p->in.name, block->first + i);
    size_t line = block->first;
    const char *end = block->data + block->bytes, *stop;
    for (const char *at = block->data; at < end; at = stop + 1, line++) {
        stop = line_end(at, end);
        if (holds_point(at, stop) && i-- == 0)
            break;
    }
    return error_wrap(err, "%s:%zu", p->in.name, line);
}

struct error *points_read(struct points *p, size_t most, double *value, size_t *width, size_t *got)
{
    struct points_block *b = &p->last;
    p->was = p->at;
    *got = 0;
    if (p->at == b->count) {
        p->at = p->was = 0;
        do {
            struct error *err = points_take(p, most, b);
            if (!err)
                err = points_parse(p, b);
            if (err)
                return err;
        } while (!b->count && b->bytes);
    }
    *width = b->width;
    *got = b->count - p->at < most ? b->count - p->at : most;
    if (*got)
        memcpy(value, b->value + p->at * b->width, *got * b->width * sizeof *value);
    p->at += *got;
    return NULL;
}

struct error *points_read_all(const char *path, enum points_shape shape, points_taker *take,
                              void *context, struct warnings *warnings)
{
    enum { BLOCK = 1024 };
    struct points *points = NULL;
    double *value = NULL;
    size_t width = 0, count = 0;
    struct error *err = points_open(&points, path, shape, POINTS_TEXT, false);
    if (!err)
        err = array_create(&value, 6 * BLOCK, sizeof *value);
    for (size_t got = 1; !err && got; count += got) {
        err = points_read(points, BLOCK, value, &width, &got);
        if (!err && got)
            err = take(context, points, value, width, got);
    }
    if (!err && !count)
        err = error_new("%s: expected at least one position, got none", path);
    if (!err)
        points_warn_end(points, warnings);
    free(value);
    points_close(points);
    return err;
}

struct error *points_place(const struct points *p, size_t i, struct error *err)
{
    return points_block_place(p, &p->last, p->was + i, err);
}
