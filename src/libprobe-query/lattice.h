/* SPDX-License-Identifier: Apache-2.0 */
/* lattice: positions on a power-of-two lattice, which tetrahedra are made of and located in.
 *
 * The lattice has a power of two for its step, at most 2^-LATTICE_BITS of the box that holds the
 * probes, and steps of the world's own axes, so a position that it can hold exactly stays where it
 * is. Coordinates are whole numbers 0 .. 2^LATTICE_BITS held in doubles, so determinants of them
 * are exact in 128 bits: which cells have a positive volume, and whether volumes sum up, is
 * arithmetic and not luck. Noise below 1e-12 of the box, as of a grid that was computed,
 * disappears. The probes' own positions stay in the stream as they are.
 */
#ifndef LATTICE_H
#define LATTICE_H

#include <stddef.h>
#include <stdint.h>

enum { LATTICE_BITS = 40 };

struct lattice {
    double step; /* scene units; 0 when all positions are one */
    double origin[3];
};

/* The lattice of `count` positions (3 * count finite doubles). */
struct lattice lattice_fit(size_t count, const double *position);

/* The lattice's coordinates of a position: whole numbers for the probes themselves. */
void lattice_snap(const struct lattice *lattice, const double position[3], double site[3]);

/* A difference of sites as the whole number that it is. */
static inline int64_t lattice_whole(double x)
{
    return (int64_t)x;
}

/* Six times the signed volume of a cell of sites, exactly; positive where p1-p0, p2-p0, p3-p0 are
 * right-handed. */
__extension__ typedef __int128 lattice_volume;
lattice_volume lattice_orient(const double p0[3], const double p1[3], const double p2[3],
                              const double p3[3]);

#endif
