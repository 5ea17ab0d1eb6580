/* SPDX-License-Identifier: Apache-2.0 */
#include "math/cell.h"
#include "math/angle.h"
#include "math/vec.h"

const int cell_face[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

void cell_dihedral(const double p[4][3], double angle[6])
{
    struct vec3 normal[4]; /* outward */
    for (int i = 0; i < 4; i++) {
        const struct vec3 a = vec3_load(p[cell_face[i][0]]), b = vec3_load(p[cell_face[i][1]]),
                          c = vec3_load(p[cell_face[i][2]]);
        normal[i] = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
    }
    int n = 0;
    for (int i = 0; i < 4; i++) {
        for (int j = i + 1; j < 4; j++) {
            const double sine = vec3_length(vec3_cross(normal[i], normal[j])),
                         cosine = -vec3_dot(normal[i], normal[j]);
            angle[n++] = angle_atan2(sine, cosine) * (180 / ANGLE_PI);
        }
    }
}

void cell_corner_angles(const double p[3][3], double angle[3])
{
    for (int i = 0; i < 3; i++) {
        const struct vec3 at = vec3_load(p[i]);
        const struct vec3 a = vec3_sub(vec3_load(p[(i + 1) % 3]), at),
                          b = vec3_sub(vec3_load(p[(i + 2) % 3]), at);
        angle[i] = angle_atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b)) * (180 / ANGLE_PI);
    }
}
