/* SPDX-License-Identifier: Apache-2.0 */
/* tetra: Delaunay cells of the probes (TetGen), canonical and checked.
 *
 * The same positions give the same cells in any order: they are snapped to a power-of-two lattice
 * (lattice.h), merged and put into a canonical order (sites.h), stretched a little where they form
 * a grid (stretch.h), before TetGen sees them. TetGen runs in a child process, whose death for any
 * reason becomes one clear error. Flat cells that noise leaves on the hull are peeled off (peel.h).
 *
 * Probes that span space by noise alone are put into the line or sheet that they lie near, or
 * strung along the walk that they make, where settings.thin asks for it (thin.h).
 */
#ifndef TETRA_H
#define TETRA_H

#include "tetra/tetra_cells.h"

#ifdef __cplusplus
#include <cstdio>
extern "C" {
#else
#include <stdio.h>
#endif

struct error;
struct warnings;

struct tetra_settings {
    double merge; /* probes nearer than this share of the box's largest side are merged */
    /* light_width * count, or NULL: of merged probes, one with light represents the others */
    const float *light;
    size_t light_width;
    /* probes that stand off a line or sheet by at most this share of their spacing are put into it,
     * and walks are strung; 0: neither */
    double thin;
    int threads;
    /* TetGen without a child: where its death is no loss, as in a fuzzer's own child */
    bool in_process;
};

/* merge 1e-12: about one step of the lattice; no light; thin 0; one thread. */
struct tetra_settings tetra_settings_default(void);

/* Makes the cells of `count` points (3 * count finite doubles). Errors: no point, one that is not
 * finite, TetGen's death. Merged points are a warning. */
struct error *tetra_make(struct tetra *tetra, size_t count, const double *position,
                         const struct tetra_settings *settings, struct warnings *warnings);

/* The same with the default settings. */
struct error *tetra_build(struct tetra *tetra, size_t count, const double *position,
                          struct warnings *warnings);
void tetra_clear(struct tetra *tetra);

/* What tetra_verify found of how far cells are from Delaunay, and of the hull from convex. */
struct tetra_verdict {
    size_t inner_facets, not_delaunay; /* of them, by exact predicates */
    /* the largest relative error of squared distances that explains the worst of those */
    double tolerance;
    /* edges (of triangles: corners) at which the hull is not convex */
    size_t dents;
};

/* Checks that cells (corners, cell_count, vertex, neighbour, merged) are what tetra_make promises,
 * in exact arithmetic: indices, positive volumes, symmetric adjacency across the same facet, the
 * hull closed and oriented, convex but for dents that are shallower than 1/4 of what they span,
 * and holding the cells' volume. tetra_make does so itself. An error names the first cell that
 * breaks one. */
struct error *tetra_check(const struct tetra *tetra, size_t count, const double *position);

/* The same, and that the cells hang together, are Delaunay up to STRETCH_TOLERANCE across each
 * inner facet, and use every probe that is not merged with one that they use. */
struct error *tetra_verify(const struct tetra *tetra, size_t count, const double *position,
                           struct tetra_verdict *verdict);

/* What --report prints. */
struct tetra_report {
    size_t cells, hull_facets, hull_vertices, unused_points, merged_points;
    /* scene units cubed, squared (areas), or units: sum over cells; by the hull's facets */
    double volume, hull_volume;
    double volume_least, volume_median, volume_most;
    double angle_least, angle_most; /* dihedral, or of a triangle, degrees */
    /* least angle of each cell, in bins of 5 degrees (0-5, .. 70-75) */
    size_t angle_histogram[15];
};
struct error *tetra_measure(const struct tetra *tetra, size_t count, const double *position,
                            struct tetra_report *report);

/* Prints it, of so many probes, in a few lines. */
void tetra_report_print(const struct tetra_report *report, int corners, size_t probes, FILE *out);

/* What cells of so many corners (1 to 4) are called: "tetrahedra". */
const char *tetra_cells_name(int corners);

/* -- for the module's own files --------------------------------------------------------------- */

/* Runs TetGen on distinct points, finite and near 1, in canonical order; those numbered first[0..3]
 * span a tetrahedron, as wide as they can. vertex and neighbour come in a mapping of their own,
 * cells in order of their first vertex, which is the least. */
struct error *tetra_run(struct tetra *tetra, size_t count, const double *position,
                        const size_t first[4], const struct tetra_settings *settings);

/* Waits for the end of the process that made the cells. */
void tetra_await(struct tetra *tetra);

/* Where TetGen's result goes. */
struct tetra_sink {
    /* gives 8 * cells indices, for the vertices and then for the neighbours, or NULL */
    int32_t *(*room)(void *context, size_t cells);
    /* called when all is in there, before TetGen's memory is freed */
    void (*whole)(void *context);
    void *context;
};

/* The shim around TetGen (tetra_tetgen.cc). Runs in this process: it may print, abort or crash.
 * order: which point is inserted when. Returns the cell count or -1. */
long tetra_tetgen(size_t count, const double *position, const int32_t *order, int threads,
                  const struct tetra_sink *sink);

/* The checks of tetra_check on sites (3 * count whole numbers): what tetra_make does before it
 * numbers by probe. */
struct error *tetra_check_sites(const struct tetra *tetra, size_t count, const double *site,
                                const int axis[2], int threads);

#ifdef __cplusplus
}
#endif

#endif
