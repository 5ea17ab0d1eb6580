/* SPDX-License-Identifier: Apache-2.0 */
/* interpolate: a column of the probes at any point, in one of several ways.
 *
 *     err = interpolate_open(&in, stream, &settings);
 *     interpolate_find(in, p, &place);   where the point is: cheap to do for a few points ahead
 *     err = interpolate_at(in, p, &place, out);
 *     interpolate_close(in);
 *
 * Read-only once it is open: threads share it.
 */
#ifndef INTERPOLATE_H
#define INTERPOLATE_H

#include "libprobe-query/probe-query.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct interpolate_kind;
struct stream;
struct table;

/* The kinds (interpolate_kind.h): */
extern const struct interpolate_kind
    /* of the four probes of a cell: reproduces linear fields, continuous */
    interpolate_barycentric,
    /* the same of what each probe's gradient foretells for the point (Tatarchuk 2005): exact
     * gradients at probes, continuous */
    interpolate_gradient,
    /* a cubic Bezier polynomial in each cell from values and gradients (Farin 1986): reproduces
     * quadratic fields, continuous, and smooth at probes and along edges */
    interpolate_cubic,
    /* the nearest probe's value; jumps. Without cells */
    interpolate_nearest,
    /* weights that fall to 0 at a radius (Bikker and Reijerse 2009). Without cells */
    interpolate_shepard,
    /* of surface probes, each of which answers for a disc (discs.h): asked with a normal,
     * interpolate_surface. Without cells */
    interpolate_discs,
    /* of the nodes of a grid (nodes.h): reproduces products of linear fields along the axes; or of
     * an octree (octree.h): linear fields, continuous. Without cells */
    interpolate_trilinear,
    /* the same with cubics: reproduces parabolas along a grid's axes, smooth */
    interpolate_tricubic,
    /* the trilinear blend of what each node's gradient foretells for the point, within bounds:
     * reproduces linear fields, exact gradients at nodes, continuous */
    interpolate_trilinear_gradient,
    /* of the nodes of a grid's or octree's cell, by the inverse of their distances; at nodes
     * theirs; jumps. Without cells */
    interpolate_inverse;

enum interpolate_falloff {
    INTERPOLATE_FALL_LINEAR,
    INTERPOLATE_FALL_QUADRATIC,
    INTERPOLATE_FALL_CUBIC
};

struct interpolate_settings {
    const struct interpolate_kind *kind; /* NULL: barycentric; once it is open, the kind it is */
    /* Shepard, discs: weights are (radius - distance)^1, 2 or 3 */
    enum interpolate_falloff falloff;
    /* Shepard; 0: scatter_spacing. Discs; 0: twice the column radius, or scatter_spacing */
    double radius;
    /* an f32 column of table probe; gradients are in the column of that name and _gradient */
    const char *column;
    /* a column by which points are asked for, in place of where they are: their first number is
     * one of it, and kinds are interpolate_barycentric and interpolate_cubic; NULL: none */
    const char *along;
    /* of the hull: PROBE_NEAREST, PROBE_EXTEND, or 0 (probe-query.h) */
    unsigned outside;
};

/* Which of the probes around a point it sees: takes what it does not out of the place's weights,
 * which still sum to 1. */
struct interpolate_sight {
    void (*see)(const void *own, const double point[3], struct probe_place *place);
    const void *own;
};

struct interpolate {
    struct interpolate_settings settings;
    struct interpolate_sight sight; /* see: NULL: light comes from all probes of a cell */
    struct probe_volume *volume;    /* owned; NULL where there are no cells to it */
    void *own;                      /* the kind's; owned */
    const double *position;         /* 3 a probe */
    const float *value;             /* the column */
    const float *gradient;          /* 3 * width a probe: d/dx of all, d/dy, d/dz; NULL: not used */
    size_t width;
    int order; /* of SH, where the column is sh; else 0 */
    bool convolved;
    const struct stream *stream; /* NULL: a packed file */
    float *owned;                /* value of a packed file */
    void *image;                 /* of a packed file; mapped */
    size_t image_bytes;
};

/* The stream must outlive it. Errors: no cells (says to run probe-tet), no such column (says to run
 * probe-capture), no grid and no octree, a probe of an octree whose value is not known. */
struct error *interpolate_open(struct interpolate **interpolate, const struct stream *stream,
                               const struct interpolate_settings *settings);

/* A packed file (man probe-query). */
struct error *interpolate_open_packed(struct interpolate **interpolate, const char *path,
                                      const struct interpolate_settings *settings);

/* What is packed beside all light, of cells: the light of each group of lights; of each block of a
 * transfer, which is a group transfer_sky_J or transfer_suns_N, beside groups, or all light as
 * group rest where there are none. */
enum { INTERPOLATE_GROUPS = 1, INTERPOLATE_TRANSFER = 2 };

/* Packs it (probe_volume_pack_groups, or of discs probe_surface_pack): with *size 0 it tells the
 * size alone. parts: of the above, or 0. Error: some probes have no light; there are no groups or
 * transfers, or these are asked of discs or a packed file; memory. */
struct error *interpolate_pack(const struct interpolate *interpolate, enum probe_packing packing,
                               unsigned parts, size_t *size, void *image);

/* The error that probes without a column sh have no light, or that of surfaces alone. */
struct error *interpolate_no_light(const struct table *probes);

void interpolate_close(struct interpolate *interpolate); /* NULL is legal */

/* Whether a file starts as a packed one does. */
bool interpolate_is_packed(const char *path);

/* From here on places have the weights of what is seen. What `own` points to must outlive it.
 * Error: this way of interpolation does not take its light with a place's weights alone. */
struct error *interpolate_set_sight(struct interpolate *interpolate,
                                    const struct interpolate_sight *sight);

/* The place of a point (finite). place->cell: where to start. */
void interpolate_find(const struct interpolate *interpolate, const double point[3],
                      struct probe_place *place);

/* Where a point of settings.along is: on the straight line between its two probes. */
void interpolate_along_position(const struct interpolate *interpolate,
                                const struct probe_place *place, double position[3]);

/* The places of many points (probe_volume_locate_many). */
void interpolate_find_many(const struct interpolate *interpolate, size_t count, const double *point,
                           size_t stride, const uint32_t *order, struct probe_place *place);

/* Brings what interpolate_at will read nearer. */
void interpolate_fetch(const struct interpolate *interpolate, const struct probe_place *place);

/* Whether it is surfaces alone that are asked for, by interpolate_surface. */
bool interpolate_of_surfaces(const struct interpolate *interpolate);

/* The column's values at a point of a surface with the unit normal n. *covered: false where it is
 * none of those that a disc covers, and one answers for it. Error: nothing faces as n does. Needs
 * interpolate_of_surfaces. */
struct error *interpolate_surface(const struct interpolate *interpolate, const double point[3],
                                  const double n[3], float *out, bool *covered);

/* Brings nearer what interpolate_surface will read at `count` points, 64 at the most; point and n:
 * each begins `stride` doubles behind the last. A normal that is not of length 1 is no error: less
 * is brought, or more. Needs interpolate_of_surfaces. */
void interpolate_fetch_surfaces(const struct interpolate *interpolate, size_t count,
                                const double *point, const double *n, size_t stride);

/* The column's values at a point, whose place was found. Error: a probe's value is not known. */
struct error *interpolate_at(const struct interpolate *interpolate, const double point[3],
                             const struct probe_place *place, float *out);

#endif
