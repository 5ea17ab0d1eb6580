/* SPDX-License-Identifier: Apache-2.0 */
/* export_mesh: vertices with faces and a colour, as formats of others take them.
 *
 * A stream's probes with faces between them (stream/faces.h) become one part for each instance of a
 * mesh of the scene: vertices that instances share are each one's own. Vertices stand on the
 * surface, not where their probes stood off. A format is a function of its own:
 *
 *     struct export_mesh mesh = {0};
 *     err = export_mesh_make(&mesh, stream, "irradiance", NAN);
 *     if (!err) err = export_glb(&mesh, "-");
 *     export_mesh_clear(&mesh);
 */
#ifndef EXPORT_MESH_H
#define EXPORT_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct stream;

/* Ranges of vertices and of triangles that go together. */
struct export_part {
    int32_t instance; /* of the scene; -1: not told */
    size_t vertex, vertices, triangle, triangles;
};

/* All owned; starts as {0}. */
struct export_mesh {
    float *position, *normal; /* 3 a vertex */
    float *colour;            /* 3 a vertex, linear, 0 to 1 */
    size_t vertices;
    uint32_t *index; /* 3 a triangle, counted within its part */
    size_t triangles;
    struct export_part *part;
    size_t parts;
    bool both;      /* backs have faces of their own */
    double scale;   /* that the column's values were multiplied by */
    size_t clipped; /* vertices that were brighter than 1, or below 0 */
    size_t unknown; /* vertices without a value: black */
};

/* column: of 1 (grey) or 3 values; NULL: irradiance, or else ao. scale: NAN: what brings 99 of 100
 * vertices to 1 at most where it is light, else 1. Errors: no faces, no such column. */
struct error *export_mesh_make(struct export_mesh *mesh, const struct stream *stream,
                               const char *column, double scale);
void export_mesh_clear(struct export_mesh *mesh);

/* The formats; path "-": standard output. GLB: glTF 2.0, a mesh and a node a part, COLOR_0 linear,
 * KHR_materials_unlit. PLY: binary, one mesh, colours as codes of a screen (sRGB). */
struct error *export_glb(const struct export_mesh *mesh, const char *path);
struct error *export_ply(const struct export_mesh *mesh, const char *path);

#endif
