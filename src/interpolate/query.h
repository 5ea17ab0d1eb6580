/* SPDX-License-Identifier: Apache-2.0 */
/* query: the light at points, interpolated from a baked stream or a packed file.
 *
 *     err = query_open(&q, interpolate, &settings);
 *     if (!err) err = query_run(q, points);
 *     if (!err) err = query_finish(q);
 *
 * A point alone gets the interpolated column; a point with a normal gets the irradiance (RGB) of a
 * surface there, of SH or of the surface probes that face as it does. Blocks of points are answered
 * by many threads and written in order. Points of a block that are far from one another are looked
 * up along a Morton curve. Where interpolation goes along a column (interpolate.h), a point is one
 * number of it, or that and a normal.
 */
#ifndef QUERY_H
#define QUERY_H

#include <stdbool.h>
#include <stddef.h>

struct interpolate;
struct error;
struct occluders;
struct points;
struct query;

enum query_format {
    QUERY_TEXT,   /* a line of numbers a point */
    QUERY_BINARY, /* little-endian floats */
    QUERY_STREAM, /* a probe stream of the points with the interpolated column */
};

enum query_outside {
    QUERY_AUTO,    /* one of the next two, as the hull is (probe-query.h) */
    QUERY_EXTEND,  /* cells beyond the hull */
    QUERY_NEAREST, /* the light of the hull's nearest point */
    QUERY_ZERO,    /* no light */
    QUERY_ERROR,   /* refused */
};

struct query_settings {
    enum query_format format;
    enum query_outside outside;
    /* text: add cell, probes, weights, inside or outside, distance from the hull */
    bool explain;
    int threads;
    const struct occluders *occluders; /* of radiance as SH alone; borrowed; NULL: none */
    const char *output;                /* a path, or "-" */
    const char *recorded;              /* QUERY_STREAM: the command line for the provenance */
};

/* What is interpolated (interpolate.h) must outlive the query. */
struct error *query_open(struct query **query, const struct interpolate *interpolate,
                         const struct query_settings *settings);

/* Answers all points. Errors name where. */
struct error *query_run(struct query *query, struct points *points);

/* How many points were outside the hull. */
size_t query_outside(const struct query *query);

/* Ends the output. Frees, on error too. */
struct error *query_finish(struct query *query);
void query_abandon(struct query *query); /* NULL is legal */

#endif
