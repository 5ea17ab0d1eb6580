/* SPDX-License-Identifier: Apache-2.0 */
/* convex: a point as a sum of others, by shares of which none is below 0: that of the least cost,
 * or that of the nearest point there is.
 *
 * With positions x written as (x, y, z, 1), whose shares then sum to 1, and the cost |x|^2 the
 * shares are those of Delaunay's tetrahedron that holds the point: the facet below it of the hull
 * of the points lifted onto a paraboloid (Brown, "Voronoi diagrams from convex hulls", Information
 * Processing Letters 9, 1979). With directions and the cost 1 they are those of the facet of the
 * directions' hull which the point's ray pierces. Points in a plane or on a line are as well.
 */
#ifndef CONVEX_H
#define CONVEX_H

#include <stdbool.h>
#include <stddef.h>

enum { CONVEX_MOST = 4 };

/* Of points, count <= CONVEX_MOST of them, shares above 0. */
struct convex {
    int count;
    size_t point[CONVEX_MOST];
    double share[CONVEX_MOST];
};

/* The sum that is the target, of the least sum of shares times costs, by the simplex method
 * (Dantzig). at: points * dimension numbers of about 1, dimension <= CONVEX_MOST; cost: points;
 * NULL: 1 each. False: no sum is. */
bool convex_least(int dimension, size_t points, const double *at, const double *cost,
                  const double *target, struct convex *sum);

/* The nearest point to `target` of the convex hull of positions, 3 each and of about 1, by a sum of
 * shares that add up to 1 (Wolfe, "Finding the nearest point in a polytope", Mathematical
 * Programming 11, 1976). points is 1 or more. Returns its distance. */
double convex_nearest(size_t points, const double *at, const double target[3], struct convex *sum,
                      double nearest[3]);

#endif
