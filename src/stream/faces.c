/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/faces.h"
#include "base/error.h"
#include "stream/stream.h"

static struct error *check_corners(const struct faces *faces)
{
    for (size_t i = 0; i < 3 * faces->count; i++)
        if (faces->vertex[i] < 0 || (size_t)faces->vertex[i] >= faces->vertices)
            return error_new("row %zu: column vertex: expected the number of one of %zu probes, "
                             "got %d",
                             i / 3, faces->vertices, faces->vertex[i]);
    return NULL;
}

/* A whole number a face that may be missing. */
static const int32_t *optional(const struct table *table, const char *name)
{
    const struct column *column = table_column(table, name);
    return column && column->type == COLUMN_I32 && column->width == 1 ? column_i32(column) : NULL;
}

struct error *faces_of(const struct stream *stream, struct faces *faces)
{
    struct table *probes = stream_table(stream, "probe"),
                 *table = stream_table(stream, FACES_TABLE);
    struct column *position = NULL, *surface = NULL, *normal = NULL, *vertex = NULL;
    if (!probes || !table)
        return error_new("expected a table face, there is none (probe-place vertices --faces "
                         "writes one)");
    struct error *err = table_require(probes, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(probes, "surface", COLUMN_F64, 3, &surface);
    if (!err)
        err = table_require(probes, "normal", COLUMN_F32, 3, &normal);
    err = error_wrap(err, "table probe");
    if (!err)
        err = error_wrap(table_require(table, "vertex", COLUMN_I32, 3, &vertex), "table face");
    if (err)
        return err;
    *faces = (struct faces){.probes = probes,
                            .position = column_f64(position),
                            .surface = column_f64(surface),
                            .normal = column_f32(normal),
                            .vertices = probes->rows,
                            .vertex = column_i32(vertex),
                            .triangle = optional(table, "triangle"),
                            .instance = optional(table, "instance"),
                            .count = table->rows};
    return error_wrap(check_corners(faces), "table face");
}

struct vec3 faces_cross(const struct faces *faces, size_t face)
{
    struct vec3 p[3];
    for (size_t c = 0; c < 3; c++)
        p[c] = vec3_load(faces->surface + 3 * (size_t)faces->vertex[3 * face + c]);
    return vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
}

double faces_area(const struct faces *faces, size_t face)
{
    return vec3_length(faces_cross(faces, face)) / 2;
}
