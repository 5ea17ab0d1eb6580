/* SPDX-License-Identifier: Apache-2.0 */
/* cell: a tetrahedron of four corners p0 .. p3 with det(p1-p0, p2-p0, p3-p0) > 0, or a triangle.
 *
 * Angles are in degrees and the same on every machine (angle.h).
 */
#ifndef CELL_H
#define CELL_H

/* The corners of the face opposite each corner, counter-clockwise seen from outside. */
extern const int cell_face[4][3];

/* The six dihedral angles between the faces opposite corners 01 02 03 12 13 23: 70.5288 in a
 * regular cell. */
void cell_dihedral(const double p[4][3], double angle[6]);

/* The angle of a triangle at each corner. */
void cell_corner_angles(const double p[3][3], double angle[3]);

#endif
