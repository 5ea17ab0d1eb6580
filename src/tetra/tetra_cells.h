/* SPDX-License-Identifier: Apache-2.0 */
/* tetra_cells: the cells that tetra makes and peel takes from.
 *
 * A cell is a simplex of `corners` probes: four that span space, with det(p1-p0, p2-p0, p3-p0) > 0
 * on the lattice (cell.h); three of probes in a plane, all turning the same way; two on a line, in
 * order; or one. neighbour[i] is the cell across the facet opposite vertex i, or -1 on the hull.
 * Segments of a walk run anyhow, and where more than two meet, each has the next of them for a
 * neighbour, all in a ring; triangles may bend.
 * Tetrahedra and triangles stand in the canonical order of the first of their probes, which is a
 * tetrahedron's vertex[0]; segments stand along their line.
 */
#ifndef TETRA_CELLS_H
#define TETRA_CELLS_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
extern "C" {
#else
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#endif

enum { TETRA_CORNERS_MOST = 4 };

/* What cells are made of that span space by noise alone (thin.h). */
enum tetra_thin { TETRA_NOT_THIN, TETRA_LINE, TETRA_WALK, TETRA_SHEET };

/* Cells; starts as {0}. */
struct tetra {
    int corners; /* 4, 3, 2 or 1 a cell */
    size_t cell_count;
    int32_t *vertex;    /* corners * cell_count */
    int32_t *neighbour; /* corners * cell_count */
    /* 3 * point_count, owned: unit outward normal (angle-weighted mean of its facets) of a probe on
     * the hull, in what the cells span; 0 inside */
    float *hull_normal;
    /* of each point the one that represents it in the cells, or -1; NULL where none is merged;
     * owned */
    int32_t *merged;
    size_t merged_count;
    bool stretched; /* Delaunay up to STRETCH_TOLERANCE */
    size_t peeled;  /* flat cells that were taken off the hull */
    enum tetra_thin thin;
    void *room; /* vertex and neighbour, mapped; owned */
    size_t room_bytes;
    /* the process that made them and is freeing its memory; 0: none; ours to wait for */
    int child;
};

/* The facet of cell `other` that it shares with facet i of `cell`, or -1. */
int tetra_facet_back(const struct tetra *tetra, size_t other, size_t cell, int i);

#ifdef __cplusplus
}
#endif

#endif
