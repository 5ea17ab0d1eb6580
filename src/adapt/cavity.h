/* SPDX-License-Identifier: Apache-2.0 */
/* cavity: what one probe more would change, without making the cells anew.
 *
 * A Delaunay tetrahedralisation gives way where a point comes in: the cells whose circumsphere
 * holds it go, and the new ones join the point to the faces of the cavity that is left (Bowyer,
 * "Computing Dirichlet tessellations"; Watson, "Computing the n-dimensional Delaunay tessellation",
 * The Computer Journal 24, 1981). So the candidates in the cavity are blended anew of the point and
 * one of these faces each, those of the four that a candidate sees in the scene itself, and what
 * their errors fall by in all is what the probe is worth. The rest of the cells do not change, so
 * probes whose cavities share no cell do not get in each other's way.
 *
 * Of cells that probe-tet has made, which need not be Delaunay to the last, and of light in 32 bits
 * (quick_square.h): it is an estimate, and the cells are made anew before anything is said about
 * errors.
 */
#ifndef CAVITY_H
#define CAVITY_H

#include "adapt/choice.h"

#define CAVITY_NONE UINT32_MAX

struct stars;

enum { CAVITY_CELLS = 192, CAVITY_RING = 256, CAVITY_FACES = 4 * CAVITY_RING };

/* Room for one thread's work. */
struct cavity {
    int32_t cell[CAVITY_CELLS];
    size_t cells;
    /* with those around them, where the point is beyond the hull; else none */
    int32_t ring[CAVITY_RING];
    size_t ringed;
    /* Faces of the cavity, or of the hull, joined to the point: candidates, and the weight of each
     * at x, rows 3 k to 3 k + 2 . (x - point) of the k-th; the point has the rest. */
    uint32_t corner[CAVITY_FACES][3];
    float row[9][CAVITY_FACES];
    size_t faces;
    double point[3];
    uint32_t without; /* a candidate that would be no probe any more; or CAVITY_NONE */
};

/* Finds the cells of a candidate's cavity, and those around it where the point is beyond the hull;
 * false where the cavity is larger than it may be. */
bool cavity_dig(struct cavity *cavity, const struct choice *choice, uint32_t candidate);

/* The same without one of the choice's probes, whose cells are all part of it. */
bool cavity_dig_without(struct cavity *cavity, const struct choice *choice, uint32_t candidate,
                        const struct stars *stars, uint32_t probe);

/* What stands for all that its gain is made of, not 0. cell: gains_cells; refined: whether the
 * candidate is. */
uint64_t cavity_around(const struct cavity *cavity, const uint64_t *cell, bool refined);

/* Returns the sum of what the errors of the other candidates of space would fall by, of a candidate
 * whose cavity was dug; 0 where they would rise. *doubtful: it may well be by chance. */
double cavity_gain(struct cavity *cavity, const struct choice *choice, uint32_t candidate,
                   bool *doubtful);

#endif
