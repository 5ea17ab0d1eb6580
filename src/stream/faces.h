/* SPDX-License-Identifier: Apache-2.0 */
/* faces: the triangles between probes that are the vertices of a surface.
 *
 * `probe-place vertices --faces` writes them: table face, whose column vertex has the three rows of
 * table probe that are its corners, counter-clockwise seen from where it is lit; and column surface
 * of table probe, the places of the surface that probes stand off from.
 */
#ifndef FACES_H
#define FACES_H

#include "math/vec.h"

#include <stddef.h>
#include <stdint.h>

struct error;
struct stream;
struct table;

#define FACES_TABLE "face"

/* Borrowed from the stream. */
struct faces {
    struct table *probes;
    const double *position, *surface; /* 3 * vertices */
    const float *normal;              /* 3 * vertices, unit */
    size_t vertices;
    const int32_t *vertex; /* 3 * count: rows of table probe */
    /* of the scene's: the triangle, and the instance, count each; NULL: not told */
    const int32_t *triangle, *instance;
    size_t count;
};

/* Errors: there are none, a column is missing, or a corner is no row of table probe. */
struct error *faces_of(const struct stream *stream, struct faces *faces);

/* A face's area, in units of the scene, squared, times 2 and its unit normal. */
struct vec3 faces_cross(const struct faces *faces, size_t face);

/* Half of that vector's length. */
double faces_area(const struct faces *faces, size_t face);

#endif
