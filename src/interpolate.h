/* interpolate: a column of the probes at any point, in one of several ways.
 *
 *     err = interpolate_open(&in, stream, &settings);
 *     interpolate_find(in, p, &place);          where the point is: cheap to do for a few points ahead
 *     err = interpolate_at(in, p, &place, out);
 *     interpolate_close(in);
 *
 * Read-only once it is open: threads share it.
 */
#ifndef INTERPOLATE_H
#define INTERPOLATE_H

#include "probe-query.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct stream;

enum interpolate_kind {
    INTERPOLATE_BARYCENTRIC, /* of the four probes of a cell: reproduces linear fields */
};

struct interpolate_settings {
    enum interpolate_kind kind;
    const char *column; /* an f32 column of table probe */
    bool nearest;       /* outside of the hull: the light of its nearest point, instead of cells beyond it */
};

struct interpolate {
    struct interpolate_settings settings;
    struct probe_volume *volume; /* owned */
    const float *value;          /* the column */
    size_t width;
    int order; /* of SH, where the column is sh; else 0 */
    bool convolved;
    const struct stream *stream; /* NULL: a packed file */
    float *owned;                /* value of a packed file */
    void *image;                 /* of a packed file; mapped */
    size_t image_bytes;
};

/* The stream must outlive it. Errors: no cells (says to run probe-tet), no such column (says to run probe-capture). */
struct error *interpolate_open(struct interpolate **interpolate, const struct stream *stream, const struct interpolate_settings *settings);

/* A packed file (man probe-query). */
struct error *interpolate_open_packed(struct interpolate **interpolate, const char *path, const struct interpolate_settings *settings);

void interpolate_close(struct interpolate *interpolate); /* NULL is legal */

/* Whether a file starts as a packed one does. */
bool interpolate_is_packed(const char *path);

/* The place of a point (finite). place->cell: where to start. */
void interpolate_find(const struct interpolate *interpolate, const double point[3], struct probe_place *place);

/* The places of many points (probe_volume_locate_many). */
void interpolate_find_many(const struct interpolate *interpolate, size_t count, const double *point, size_t stride, const uint32_t *order, struct probe_place *place);

/* Brings what interpolate_at will read nearer. */
void interpolate_fetch(const struct interpolate *interpolate, const struct probe_place *place);

/* The column's values at a point, whose place was found. Error: a probe's value is not known. */
struct error *interpolate_at(const struct interpolate *interpolate, const double point[3], const struct probe_place *place, float *out);

#endif
