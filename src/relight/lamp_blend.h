/* SPDX-License-Identifier: Apache-2.0 */
/* lamp_blend: a point light between those that a transfer has (Kristensen, Akenine-Moeller, Jensen,
 * "Precomputed local radiance transfer for real-time lighting design", SIGGRAPH 2005).
 *
 * Its weights are the barycentric ones of the tetrahedron of Delaunay's, of the lights' positions,
 * that it is in; of the triangle or the segment where they lie in a plane or on a line. Outside of
 * their hull it is taken to stand at the hull's nearest point.
 */
#ifndef LAMP_BLEND_H
#define LAMP_BLEND_H

#include <stddef.h>

struct error;

/* weight (count): of lights at `position` (3 * count, all different) for one at p, with the sum 1.
 * *off: how far p is from what could be blended, in the positions' unit. count is 1 or more. */
struct error *lamp_blend(size_t count, const double *position, const double p[3], double *weight,
                         double *off);

#endif
