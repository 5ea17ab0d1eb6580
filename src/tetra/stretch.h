/* SPDX-License-Identifier: Apache-2.0 */
/* stretch: a metric in which grids have no ties.
 *
 * The corners of a grid's cube lie on one sphere. Which of the ways to cut the cube is Delaunay, is
 * decided by noise: that of a rotation, of numbers, of an artist's hand. Flat cells come of it, of
 * four corners of a square, since their sphere is empty as well. So the points are stretched a
 * little before they are tetrahedralised, along directions that are askew to the grid: a square
 * becomes a rhomboid, whose short diagonal is Delaunay by a margin that outdoes the noise, and
 * every cube is cut in the same way. Cells that are Delaunay in the stretched space are valid in
 * the true one, whatever the points: affine maps keep sides and hulls. They are Delaunay in it but
 * for a tolerance: no squared distance changes by more than STRETCH_TOLERANCE of itself, against a
 * common scale.
 *
 * Which directions are askew to the grid, and whether there is one at all, is read off the
 * neighbours of a sample of points: rectangles of four. Points without rectangles are not
 * stretched.
 */
#ifndef STRETCH_H
#define STRETCH_H

#include <stdbool.h>
#include <stddef.h>

#define STRETCH_TOLERANCE (1.0 / 64)

struct stretch {
    bool found; /* there is a grid */
    /* of multiples of 2^-12, so that stretched sites of a lattice are exact; the unit matrix
     * without a grid */
    double matrix[3][3];
};

/* Of points in canonical order (3 * count). */
void stretch_find(struct stretch *stretch, size_t count, const double *point);

#endif
