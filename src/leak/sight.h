/* SPDX-License-Identifier: Apache-2.0 */
/* sight: how far each probe sees into the cells around it.
 *
 * At barycentric coordinates u of a cell, the depth of a point before what corner i sees is
 *
 *     d_i(u) = 1 - sum over j != i of sight_ij u_j:
 *
 * 1 at the probe, and 0 on a plane that cuts the way to corner j at 1 / sight_ij of it. Sight_ij is
 * the inverse depth of what the probe sees towards its neighbour j, and between neighbours inverse
 * depth is linear, as that of any plane is: before a flat wall this is exact, and it bends from
 * cell to cell as the wall does. A number belongs to two probes, not to a cell, so on the face
 * between two cells both say the same of its corners, and what is blended by it has no jump there.
 * It is fitted to rays from the probe through each cell (sight_fit.h).
 *
 * Cells that no surface comes into (trace/enter.h) see all of their corners, and no ray is spent on
 * them. Where the rays of a probe through one that some surface does come into meet none, more of
 * them go at that surface (aim.h).
 *
 * A point outside of the hull that has its light from a place u of it, and is `off` away from
 * there (outside.h), is at depth
 *
 *     d_i(u) - slope_i . off
 *
 * before what corner i sees: of a plane this is exact as well, whichever place the light comes
 * from. Slope_i belongs to the probe, and places and ways to them are continuous, so light is. It
 * is fitted to rays to such points; together with sight_ij, so that a plane can go on outside that
 * no edge meets, where that leaves the inside as it was, else alone.
 *
 * Some points see none of their cell's corners. Then the cell names a stand-in: the probe around
 * that most of these points see, if they see more of it than of the corners.
 */
#ifndef SIGHT_H
#define SIGHT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct leak_mesh;
struct tracer;

struct sights {
    /* corners * (corners - 1) a cell: of each corner, in order, towards each other one; 0 where
     * nothing is in the way. Halves, as packed files hold them. Owned */
    float *sight;
    int32_t *stand_in; /* a probe a cell, or -1; owned */
    /* the same of points outside of the hull: 12 and 1 a cell; owned; NULL: nothing stands there */
    float *outside;
    int32_t *stand_in_outside;
    size_t walled;   /* cells that something stands in */
    size_t stood_in; /* cells with a stand-in */
};

/* Looks around. The result does not depend on the threads. Error: a signal came (interrupt.h). */
struct error *sight_find(struct sights *sights, const struct tracer *tracer,
                         const struct leak_mesh *mesh, int threads);

/* The same of some cells alone: what the others get is worth nothing. */
struct error *sight_find_some(struct sights *sights, const struct tracer *tracer,
                              const struct leak_mesh *mesh, const bool *cell, int threads);
void sights_clear(struct sights *sights);

#endif
