/* SPDX-License-Identifier: Apache-2.0 */
/* vtk_export: meshes with named arrays as VTK XML files (.vtu, .vtp), through VTK's own writers.
 *
 * Plain C face of a C++ shim: no exception crosses, and what VTK would print becomes an error. A
 * file appears under its name only when it is whole. Every number must be finite: one that is not
 * poisons VTK's bounds.
 */
#ifndef VTK_EXPORT_H
#define VTK_EXPORT_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
extern "C" {
#else
#include <stddef.h>
#include <stdint.h>
#endif

struct error;

enum vtk_type { VTK_EXPORT_F32, VTK_EXPORT_F64, VTK_EXPORT_I32, VTK_EXPORT_U8 };

/* Bytes of one number. */
size_t vtk_type_size(enum vtk_type type);

/* One named array: `width` numbers for each point or cell. */
struct vtk_array {
    const char *name;
    enum vtk_type type;
    size_t width;
    const void *data;
    const char *const *components; /* names of the `width` components, or NULL */
};

/* A named list of lines. */
struct vtk_text {
    const char *name;
    const char *const *lines;
    size_t line_count;
};

/* A mesh. All is borrowed, and neither copied nor changed. */
struct vtk_mesh {
    size_t point_count;
    const double *position; /* 3 * point_count */
    size_t cell_count;
    /* of a cell of a grid: 4 tetrahedra, 3 triangles, 2 lines, 1 vertices; a surface's have 3 */
    int corners;
    /* corners * cell_count; cell_count 0: each point is a cell of its own */
    const int32_t *vertex;
    const struct vtk_array *point_arrays, *cell_arrays;
    size_t point_array_count, cell_array_count;
    const struct vtk_text *texts; /* go into the field data */
    size_t text_count;
};

/* How numbers stand in the file. Not as raw bytes appended to the XML, VTK's other way: ParaView
 * 5.11 of Debian 12 (whose expat defers its parsing since a security update) does not read them. */
enum vtk_encoding {
    VTK_EXPORT_TEXT,
    VTK_EXPORT_BASE64,
    VTK_EXPORT_COMPRESSED, /* zlib, then base64 */
};

/* Writes cells (or points, where there are none) as .vtu. Tetrahedra and triangles get their
 * quality by vtkMeshQuality: aspect_ratio (1 for a regular one, 1e30 for a flat one), and volume or
 * area; cell_arrays of these names go before them. path "-": standard output. What is not a file is
 * written from memory, so it takes that much. */
struct error *vtk_export_grid(const char *path, const struct vtk_mesh *mesh,
                              enum vtk_encoding encoding);

/* Writes triangles as .vtp. */
struct error *vtk_export_surface(const char *path, const struct vtk_mesh *mesh,
                                 enum vtk_encoding encoding);

#ifdef __cplusplus
}
#endif

#endif
