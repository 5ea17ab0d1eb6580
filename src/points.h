/* points: positions, with or without a normal, from text lines or raw numbers.
 *
 * Text: one point a line, `x y z` or `x y z nx ny nz`, all lines alike; blank lines and # comments are skipped.
 * Binary: little-endian doubles, 3 or 6 a point. Read in blocks, so that a pipe is answered while it runs.
 */
#ifndef POINTS_H
#define POINTS_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct points;

enum points_format { POINTS_TEXT, POINTS_BINARY };

/* path "-": standard input. normals: binary points have one (text tells by itself). */
struct error *points_open(struct points **points, const char *path, enum points_format format, bool normals);
void points_close(struct points *points);

/* Reads up to `most` points into value (room for 6 * most). *width: 3 or 6 numbers a point, value is packed accordingly. *got: fewer than most when a
 * pipe has no more for now or the input ends; 0 only at its end. All are finite. Errors name file and line, or point. */
struct error *points_read(struct points *points, size_t most, double *value, size_t *width, size_t *got);

/* Where the i-th point of the last points_read came from, in front of a message about it: "stdin:12", "stdin: point 11". */
struct error *points_place(const struct points *points, size_t i, struct error *err);

#endif
