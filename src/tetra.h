/* tetra: Delaunay tetrahedra of the probes (TetGen), canonical and checked.
 *
 * The same positions give the same tetrahedra in any order: positions are snapped to a
 * power-of-two lattice, put into a canonical order and scaled near 1 before TetGen sees them (design: "Almost-regular grids
 * are the trap"). TetGen runs in a forked child, whose death for any reason becomes one clear error.
 *
 * A cell is four probes with det(p1-p0, p2-p0, p3-p0) > 0; neighbour[i] is the cell across the face
 * opposite vertex i, or -1 on the hull.
 */
#ifndef TETRA_H
#define TETRA_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct warnings;

struct tetra {
    int32_t *vertex;    /* 4 * cell_count, owned */
    int32_t *neighbour; /* 4 * cell_count, owned */
    size_t cell_count;
    float *hull_normal; /* 3 * point_count, owned: unit outward normal (angle-weighted mean of its hull faces) of a hull vertex, 0 inside */
    size_t duplicate_count; /* points that share their lattice site with an earlier one: in no cell */
};

/* Tetrahedralises `count` points (3 * count finite doubles). Errors: fewer than 4 distinct points, all on a line
 * or in a plane (each says which), TetGen's death. Duplicates are a warning. */
struct error *tetra_build(struct tetra *tetra, size_t count, const double *position, struct warnings *warnings);
void tetra_clear(struct tetra *tetra);

/* Checks the invariants: indices, positive volumes, symmetric adjacency, every inner face in two cells, hull closed,
 * volumes sum to the hull's. An error names the first cell that breaks one. */
struct error *tetra_check(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count, const double *position);

/* What --report prints. */
struct tetra_report {
    size_t cells, hull_faces, hull_vertices, unused_points;
    double volume, hull_volume;          /* scene units cubed: sum over cells; by the hull's faces */
    double volume_least, volume_median, volume_most;
    double angle_least, angle_most;      /* dihedral, degrees */
    size_t angle_histogram[18];          /* least dihedral angle of each cell, in bins of 5 degrees (0-5, .. 85-90) */
};
struct error *tetra_measure(size_t cell_count, const int32_t *vertex, const int32_t *neighbour, size_t point_count,
                            const double *position, struct tetra_report *report);

/* Six dihedral angles (degrees) of one cell; p: 4 corners. */
void tetra_dihedral(const double p[4][3], double angle[6]);

/* The shim around TetGen (tetra_tetgen.cc), for tetra.c alone. Runs in this process: it may print, abort or crash. Points are distinct, finite,
 * of rank 3, near 1. Returns the cell count or -1; *vertex and *neighbour are malloc'ed. */
long tetra_tetgen(size_t count, const double *position, int32_t **vertex, int32_t **neighbour);

#endif
