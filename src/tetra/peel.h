/* SPDX-License-Identifier: Apache-2.0 */
/* peel: takes flat cells off the hull.
 *
 * The outside of a grid is a plane but for noise, and a convex hull over noise is long thin facets
 * from bump to bump, with flat cells below. They hold no volume to speak of, light blended in them
 * comes from far away, and so does what is continued beyond them. Peeled off, they leave the facets
 * of the grid's own cells.
 *
 * A cell goes when it has a facet on the hull, is flat, and leaves the hull a closed surface
 * through the same probes: with one facet on the hull if the corner opposite is not yet on it, with
 * two if the edge between the others is not. Cells go in the order in which they lie behind each
 * other as seen from the middle of all probes, the last ones first: by the power of the middle to
 * their circumspheres, which orders Delaunay cells so (Edelsbrunner, "An acyclicity theorem for
 * cell complexes in d dimensions", 1990). No flat cell is stuck between others that went too early;
 * and where the one behind may not go, the one before it stays too, so that the middle sees all of
 * the hull: what is left is star-shaped, as rays to the outside need it (volume_outer.c).
 */
#ifndef PEEL_H
#define PEEL_H

#include "tetra/tetra_cells.h"

struct error;

/* Flat: the least altitude is at most this share of the shortest edge; what is peeled off at one
 * place adds up to at most PEEL_DEPTH times as much. Of grids, whose own cells are known not to be
 * flat, and of anything else, where just the noise of numbers is peeled. */
#define PEEL_GRID 0x1p-7
#define PEEL_NOISE 0x1p-20
#define PEEL_DEPTH 4

/* Peels tetrahedra or triangles of sites (3 * count). `stretched` (3 * count): where they are
 * Delaunay. Puts all back, and says that none were peeled, if they are more than PEEL_HULL of the
 * volume: the probes are nothing but a flat sheet. */
#define PEEL_HULL 0x1p-4
struct error *peel_hull(struct tetra *tetra, size_t count, const double *site, const int axis[2],
                        const double *stretched, double flat);

/* Peels tetrahedra that are nothing but the noise of a sheet on the hull, as of the lowest and the
 * highest of several storeys: three corners or more are of sheets, the longest edge is more than
 * PEEL_LONG times the spacing there, and the least altitude at most PEEL_SHALLOW of it, which the
 * hull's dents may be deep. spacing: of each site, 0 of those in no sheet (thin.h). Flatter ones
 * were peeled before. All are put back if they are more than PEEL_SHEETS of the volume. */
#define PEEL_SHEETS 0x1p-2
#define PEEL_LONG 2.2
#define PEEL_SHALLOW 0x1p-3
struct error *peel_sheets(struct tetra *tetra, size_t count, const double *site, const int axis[2],
                          const double *stretched, const double *spacing);

#endif
