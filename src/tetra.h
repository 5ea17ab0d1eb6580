/* tetra: Delaunay tetrahedra of the probes (TetGen), canonical and checked.
 *
 * The same positions give the same tetrahedra in any order: they are snapped to a power-of-two lattice (lattice.h),
 * put into a canonical order, and brought near 1, before TetGen sees them. TetGen runs in a child process,
 * whose death for any reason becomes one clear error.
 *
 * A cell is four probes with det(p1-p0, p2-p0, p3-p0) > 0 on the lattice (cell.h); neighbour[i] is the cell across the
 * face opposite vertex i, or -1 on the hull.
 */
#ifndef TETRA_H
#define TETRA_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
extern "C" {
#else
#include <stddef.h>
#include <stdint.h>
#endif

struct error;
struct warnings;

struct tetra {
    int32_t *vertex;    /* 4 * cell_count, owned */
    int32_t *neighbour; /* 4 * cell_count, owned */
    size_t cell_count;
    float *hull_normal; /* 3 * point_count, owned: unit outward normal (angle-weighted mean of its hull faces) of a hull vertex, 0 inside */
};

/* Tetrahedralises `count` points (3 * count finite doubles). Errors: fewer than 4 distinct points, all on a line
 * or in a plane (each says which), TetGen's death. Duplicates are a warning. */
struct error *tetra_build(struct tetra *tetra, size_t count, const double *position, struct warnings *warnings);
void tetra_clear(struct tetra *tetra);

/* Checks the invariants, in exact arithmetic: indices, positive volumes, symmetric adjacency across the same face, every edge
 * of the hull in two of its faces, volumes sum to the hull's. An error names the first cell that breaks one. */
struct error *tetra_check(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count, const double *position);

/* What --report prints. */
struct tetra_report {
    size_t cells, hull_faces, hull_vertices, unused_points;
    double volume, hull_volume;          /* scene units cubed: sum over cells; by the hull's faces */
    double volume_least, volume_median, volume_most;
    double angle_least, angle_most;      /* dihedral, degrees */
    size_t angle_histogram[15];          /* least dihedral angle of each cell, in bins of 5 degrees (0-5, .. 70-75) */
};
struct error *tetra_measure(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count,
                            const double *position, struct tetra_report *report);

/* The shim around TetGen (tetra_tetgen.cc), for tetra.c alone. Runs in this process: it may print, abort or crash. Points are distinct,
 * finite, of rank 3, near 1. Returns the cell count or -1; *vertex and *neighbour are never freed: the process is to end. */
long tetra_tetgen(size_t count, const double *position, int32_t **vertex, int32_t **neighbour);

#ifdef __cplusplus
}
#endif

#endif
