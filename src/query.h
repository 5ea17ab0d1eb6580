/* query: the light at points, interpolated from a baked stream.
 *
 *     err = query_open(&q, stream, "sh", QUERY_TEXT, explain, "-");
 *     for each block of points: err = query_points(q, points, count, width, value);
 *     err = query_finish(q);
 *
 * A point alone gets the interpolated column; a point with a normal gets the irradiance (RGB) of a surface there. Points are
 * answered in order, each walk starting from the last cell.
 */
#ifndef QUERY_H
#define QUERY_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct points;
struct query;
struct stream;

enum query_format {
    QUERY_TEXT,  /* a line of numbers a point */
    QUERY_BINARY, /* little-endian floats */
    QUERY_STREAM, /* a probe stream of the points with the interpolated column */
};

struct query_settings {
    const char *column;       /* what is interpolated: an f32 column of table probe */
    enum query_format format;
    bool explain;             /* text: add cell, probes, weights, inside or outside, distance from the hull */
    const char *output;       /* a path, or "-" */
    const char *recorded;     /* QUERY_STREAM: the command line for the provenance */
};

/* The stream must outlive the query. Errors: no cells (says to run probe-tet), no such column (says to run probe-capture). */
struct error *query_open(struct query **query, const struct stream *stream, const struct query_settings *settings);

/* Answers count points of width 3 or 6 (points.h), which were read from `points` last: errors name where. */
struct error *query_points(struct query *query, const struct points *points, size_t count, size_t width, const double *value);

/* Ends the output. Frees, on error too. */
struct error *query_finish(struct query *query);
void query_abandon(struct query *query); /* NULL is legal */

/* How many points were outside the hull. */
size_t query_outside(const struct query *query);

#endif
