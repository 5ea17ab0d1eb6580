/* vtk_export: meshes with named arrays as VTK XML files (.vtu, .vtp), through VTK's own writers.
 *
 * Plain C face of a C++ shim: no exception crosses, VTK's own chatter becomes an error. A file appears under its name only when it is whole.
 * Every number must be finite: one that is not poisons VTK's bounds.
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

/* One named array: `width` numbers for each point or cell; borrowed. */
struct vtk_array {
    const char *name;
    enum vtk_type type;
    size_t width;
    const void *data;
    const char *const *components; /* names of the components, or NULL */
};

struct vtk_text {
    const char *name, *value;
};

/* A mesh; all borrowed. */
struct vtk_mesh {
    size_t point_count;
    const double *position; /* 3 * point_count */
    size_t cell_count;
    const int32_t *vertex;  /* 4 (tetrahedra) or 3 (triangles) a cell; none: each point is a cell of its own */
    const struct vtk_array *point_arrays, *cell_arrays;
    size_t point_array_count, cell_array_count;
    const struct vtk_text *texts; /* kept as field data */
    size_t text_count;
};

/* Writes tetrahedra (or points, where cell_count is 0) as .vtu, with cell quality by vtkMeshQuality: min_dihedral (degrees), aspect_ratio,
 * volume. ascii: numbers as text. path "-": standard output. */
struct error *vtk_write_grid(const char *path, const struct vtk_mesh *mesh, int ascii);

/* Writes triangles as .vtp. */
struct error *vtk_write_surface(const char *path, const struct vtk_mesh *mesh, int ascii);

#ifdef __cplusplus
}
#endif

#endif
