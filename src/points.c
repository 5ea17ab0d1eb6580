#include "points.h"
#include "array.h"
#include "error.h"
#include "number.h"
#include "stream_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct points {
    struct stream_input in;
    enum points_format format;
    size_t width; /* 0: not known yet */
    size_t first, last; /* number of the first point of the last read, and how many it had */
    size_t *line; /* text: of each point of the last read; owned */
    size_t line_capacity;
};

struct error *points_open(struct points **points, const char *path, enum points_format format, bool normals)
{
    struct points *p = NULL;
    *points = NULL;
    struct error *err = array_create(&p, 1, sizeof *p);
    if (err)
        return err;
    p->format = format;
    p->width = format == POINTS_TEXT ? 0 : normals ? 6 : 3;
    err = input_open(&p->in, path);
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
    input_close(&p->in);
    free(p->line);
    free(p);
}

struct error *points_place(const struct points *p, size_t i, struct error *err)
{
    if (p->format == POINTS_TEXT)
        return error_wrap(err, "%s:%zu", p->in.name, p->line[i]);
    return error_wrap(err, "%s: point %zu", p->in.name, p->first + i);
}

static const char *skip_blanks(const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r'))
        at++;
    return at;
}

/* The numbers of one line; *count is 0 for a blank line or a comment. */
static struct error *read_line(const char *line, const char *end, double value[6], size_t *count)
{
    *count = 0;
    for (const char *at = skip_blanks(line, end); at < end && !(*count == 0 && *at == '#');) {
        double x;
        const char *behind = number_read_f64(at, end, &x);
        size_t length = 0;
        while (at + length < end && !strchr(" \t\r", at[length]))
            length++;
        if (behind != at + length)
            return error_new("expected a number, got '%.*s'", (int)(length < 40 ? length : 40), at);
        if (*count < 6)
            value[*count] = x;
        ++*count;
        at = skip_blanks(behind, end);
    }
    return NULL;
}

static struct error *check_count(struct points *p, size_t count)
{
    if (!p->width && (count == 3 || count == 6))
        p->width = count;
    if (!p->width)
        return error_new("expected x y z or x y z nx ny nz, got %zu number%s", count, count == 1 ? "" : "s");
    if (count != p->width)
        return error_new("expected %zu numbers, as in the lines before, got %zu", p->width, count);
    return NULL;
}

static struct error *check_finite(const double *value, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(value[i]))
            return error_new("expected finite numbers, got %s", isnan(value[i]) ? "nan" : value[i] < 0 ? "-inf" : "inf");
    return NULL;
}

static struct error *read_text(struct points *p, size_t most, double *value, size_t *got)
{
    struct error *err = array_reserve(&p->line, &p->line_capacity, most, sizeof *p->line);
    while (!err && *got < most) {
        const char *line;
        size_t length, bytes, count;
        if (*got && !memchr(p->in.data + p->in.start, '\n', p->in.end - p->in.start))
            break; /* what is here is answered before waiting for more */
        err = input_line(&p->in, &line, &length, &bytes);
        if (err || !line)
            break;
        double number[6];
        err = read_line(line, line + length, number, &count);
        if (!err && count)
            err = check_count(p, count);
        if (!err && count)
            err = check_finite(number, count);
        input_consume(&p->in, bytes);
        p->in.line++;
        if (err || !count) {
            err = error_wrap(err, "%s:%zu", p->in.name, p->in.line);
            continue;
        }
        memcpy(value + *got * p->width, number, count * sizeof *number);
        p->line[(*got)++] = p->in.line;
    }
    return err;
}

static struct error *read_binary(struct points *p, size_t most, double *value, size_t *got)
{
    const size_t bytes = p->width * sizeof *value;
    const unsigned char *data;
    size_t available;
    struct error *err = input_peek(&p->in, bytes, &data, &available);
    if (err || !available)
        return err;
    if (available < bytes)
        return error_new("%s: point %zu: expected %zu bytes, got %zu", p->in.name, p->first, bytes, available);
    *got = (p->in.end - p->in.start) / bytes;
    *got = *got < most ? *got : most;
    memcpy(value, data, *got * bytes);
    input_consume(&p->in, *got * bytes);
    for (size_t i = 0; i < *got && !err; i++)
        err = points_place(p, i, check_finite(value + i * p->width, p->width));
    return err;
}

struct error *points_read(struct points *p, size_t most, double *value, size_t *width, size_t *got)
{
    p->first += p->last;
    *got = 0;
    struct error *err = p->format == POINTS_TEXT ? read_text(p, most, value, got) : read_binary(p, most, value, got);
    p->last = *got;
    *width = p->width;
    return err;
}
