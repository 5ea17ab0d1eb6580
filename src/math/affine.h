/* SPDX-License-Identifier: Apache-2.0 */
/* affine: maps of space, three rows of four numbers: x' = m[0] x + m[1] y + m[2] z + m[3], ...
 *
 * As scenes place their meshes. Terms are added from the left, everywhere, so that a vertex that is
 * placed twice stands in one place.
 */
#ifndef AFFINE_H
#define AFFINE_H

#include "math/vec.h"

#include <stdbool.h>

static inline struct vec3 affine_point(const double m[12], const double p[3])
{
    const struct vec3 placed = {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3],
                                m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
                                m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]};
    return placed;
}

/* The same in float. */
static inline struct vec3f affine_pointf(const float m[12], const float p[3])
{
    const struct vec3f placed = {m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3],
                                 m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
                                 m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]};
    return placed;
}

/* What volumes are multiplied by: negative where m mirrors. */
static inline double affine_determinant(const double m[12])
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* Whether right hands become left ones: triangles turn round. */
static inline bool affine_mirrors(const double m[12])
{
    return affine_determinant(m) < 0;
}

#endif
