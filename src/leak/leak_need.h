/* SPDX-License-Identifier: Apache-2.0 */
/* leak_need: where a probe takes away most of what leaks.
 *
 * Points that do not see all that they are blended of (measure/unseen.h) each leak by some amount.
 * A new probe makes cells anew where it is in the ball around a cell, that through the cell's
 * corners (Delaunay): points of such cells that see it would be blended of it. So what a probe at x
 * is worth is what leaks at the points of cells whose ball holds x and that see x; and the places
 * to choose from are the points themselves. The best is taken first, and what it serves counts no
 * more for the next (greedy cover: at least 1 - 1/e of the best choice of as many; Nemhauser,
 * Wolsey and Fisher, "An analysis of approximations for maximizing submodular set functions",
 * 1978). A place moves to the middle of what it serves where it sees as much of it from there.
 */
#ifndef LEAK_NEED_H
#define LEAK_NEED_H

#include <stddef.h>

struct error;
struct leak_mesh;
struct tracer;

struct need_point {
    double position[3];
    size_t cell;
    double leaks; /* any unit */
};

/* probe: room for 3 * most, scene units; *count: how many there are, the most useful first. Points
 * come cell by cell. The result does not depend on the threads. */
struct error *leak_need(const struct tracer *tracer, const struct leak_mesh *mesh,
                        const struct need_point *point, size_t points, size_t most, int threads,
                        double *probe, size_t *count);

#endif
