/* SPDX-License-Identifier: Apache-2.0 */
/* place: where probes go.
 *
 * A method (place_method.h) appends positions: a grid's nodes, given points, steps along a path, or
 * the vertices of the scene. Afterwards, the same way for all, place_inside.h tells which of them
 * are inside solids.
 */
#ifndef PLACE_H
#define PLACE_H

#include "stream/table.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct scene;
struct stream;
struct warnings;

/* Positions, owned: 3 * count doubles; starts as {0}. */
struct place {
    double *position;
    /* of the surfaces that they are at, unit: 3 * count, owned; NULL: they are at none */
    float *normal;
    int *origin; /* numbers of the methods that placed them, owned; NULL: not told */
    /* what else a method tells of them, a row each; owned; see place_add_column */
    struct table columns;
    struct table faces;  /* table face of the stream (faces.h); owned; no name: there is none */
    struct stream *from; /* that they are of, whose header goes on; owned; NULL: of none */
    size_t count, capacity;
    struct stream_header header; /* keys that go with the columns; owned; empty: none */
};
void place_clear(struct place *place);

/* Adds a column (man probe.5) to what is told of the positions, of which all are there; the method
 * fills it. Columns handed out before become invalid. */
struct error *place_add_column(struct place *place, const char *name, enum column_type type,
                               size_t width, struct column **column);

/* What methods are made of: the error when `count` probes, known before they are made, are more
 * than `most`; and one position more. */
struct error *place_check_count(double count, double most);
struct error *place_append(struct place *place, const double position[3]);

/* Appends positions from text, one "x y z" a line (points.h). path "-": standard input. Errors:
 * file:line, no position, more than `most`. */
struct error *place_points(struct place *place, const char *path, double most,
                           struct warnings *warnings);

/* The same where the place is empty; lines "x y z nx ny nz" give their positions normals, made
 * unit. Error: one without a length. */
struct error *place_surface_points(struct place *place, const char *path, double most,
                                   struct warnings *warnings);

/* Which probes a way gets. */
struct place_way {
    double step, interval; /* at most, along the way and in time; 0: does not matter */
    bool spline;           /* smooth; else straight from point to point */
};

/* Makes the positions along the way through those of such a file, which are kept; lines "x y z t"
 * tell when it is there. Column time is that, or else the length of the way so far. Errors: besides
 * those of place_points, times that do not grow. */
struct error *place_path(struct place *place, const char *path, const struct place_way *way,
                         double most, struct warnings *warnings);

/* Whose sides have vertices: those that faces look to, or the backs as well. */
enum place_sides { PLACE_FRONT, PLACE_BOTH };

/* As place_vertices below, of surfaces, with the faces between them: table face and column surface
 * (man probe.5). Backs come behind all fronts, vertices and faces alike, the other way round. */
struct error *place_faces(struct place *place, const struct scene *scene, double offset,
                          double crease, enum place_sides sides, double most);

/* Makes the positions, of which there are none yet, those of the scene's vertices (vertices.h),
 * moved by `offset` along their normals, which they keep unless volume. crease: degrees. Errors:
 * more than `most`. */
struct error *place_vertices(struct place *place, const struct scene *scene, double offset,
                             double crease, bool volume, double most);

#endif
