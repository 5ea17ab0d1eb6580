/* SPDX-License-Identifier: Apache-2.0 */
/* points: positions, with or without a normal or a time, or times, from text lines or raw numbers.
 *
 * Text: one point a line, `x y z` or `x y z nx ny nz` (or as the shape says), all lines alike;
 * blank lines and # comments, behind a point too, are skipped. Binary: little-endian doubles, as
 * many a point.
 *
 * They come in blocks. Taking a block is quick and done by one thread at a time; parsing it can be
 * done by many:
 *
 *     struct points_block block = {0};
 *     locked:   err = points_take(points, most, &block);       block.bytes 0: the input has ended
 *     free:     err = points_parse(points, &block);            block.value, count, width
 *     points_block_clear(&block);
 *
 * A block holds what has come so far, so that a pipe is answered while it runs.
 */
#ifndef POINTS_H
#define POINTS_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct points;
struct warnings;

enum points_format { POINTS_TEXT, POINTS_BINARY };

/* What a point is, without more and with. */
enum points_shape {
    POINTS_PLACES, /* x y z, or x y z nx ny nz */
    POINTS_TIMED,  /* x y z, or x y z t */
    POINTS_TIMES,  /* t, or t nx ny nz */
};

struct points_block {
    const double *value; /* count * width numbers, all finite */
    size_t count, width; /* width: as the shape has it */
    char *data;          /* as it came; owned */
    size_t bytes, capacity;
    double *number; /* parsed from text; owned */
    size_t number_capacity;
    size_t first; /* number of the first point (binary, from 0) or line (text, from 1) */
};

/* path "-": standard input. more: binary points have what the shape may have (text tells by
 * itself). */
struct error *points_open(struct points **points, const char *path, enum points_shape shape,
                          enum points_format format, bool more);
void points_close(struct points *points);

/* Whether a take would not wait, after waiting for it no longer than so many milliseconds. */
bool points_ready(const struct points *points, int milliseconds);

/* Takes what has come, about `most` points at most; block->bytes is 0 only at the end of the
 * input. */
struct error *points_take(struct points *points, size_t most, struct points_block *block);

/* Finds the block's points. Errors name file and line, or point. */
struct error *points_parse(const struct points *points, struct points_block *block);

/* Where the i-th point of a block came from, in front of a message about it: "stdin:12", "stdin:
 * point 11". NULL stays NULL. */
struct error *points_block_place(const struct points *points, const struct points_block *block,
                                 size_t i, struct error *err);

void points_block_clear(struct points_block *block);

/* For one thread: takes, parses and copies up to `most` points into value (room for 6 * most),
 * *width numbers each; *got is 0 only at the end of the input. */
struct error *points_read(struct points *points, size_t most, double *value, size_t *width,
                          size_t *got);

/* Is handed points that were read (value[count * width]), for points_place to say of one of them
 * where it came from. */
typedef struct error *points_taker(void *context, const struct points *points, const double *value,
                                   size_t width, size_t count);

/* Hands on all points of a text file, some at a time and in order. Errors: besides the taker's,
 * there is no point in it. */
struct error *points_read_all(const char *path, enum points_shape shape, points_taker *take,
                              void *context, struct warnings *warnings);

/* Warns, when all was taken, where a text of several lines ends in a number without a line end:
 * what is left of a number that was cut off is a number too. */
void points_warn_end(const struct points *points, struct warnings *warnings);

/* Where the i-th point of the last points_read came from. */
struct error *points_place(const struct points *points, size_t i, struct error *err);

#endif
