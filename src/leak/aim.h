/* SPDX-License-Identifier: Apache-2.0 */
/* aim: where to look for surfaces that are known to come into a cell. */
#ifndef AIM_H
#define AIM_H

#include "math/vec.h"

#include <stdint.h>

struct tracer;

enum { AIM_MOST = 8 };

struct aim {
    double u[3];  /* barycentric, of the facet opposite the cell's first corner; sum 1 */
    double share; /* of the facet, that the part of the triangle within the cell hides */
    uint32_t instance, triangle;
};

/* Of the triangles that come into a tetrahedron, those that hide most of the facet opposite its
 * first corner from there, AIM_MOST at most, largest first, each with the middle of what it hides;
 * those that are seen edge-on hide nothing and are left out. Returns how many. corner: world, the
 * first is the eye. */
int aim_find(struct aim aim[AIM_MOST], const struct tracer *tracer, const double *const corner[4]);

#endif
