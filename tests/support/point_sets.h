/* SPDX-License-Identifier: Apache-2.0 */
/* point_sets: sets of points of many kinds, for tests of what is made of them. */
#ifndef POINT_SETS_H
#define POINT_SETS_H

#include "math/random.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

enum point_set {
    SET_RANDOM,
    SET_GRID,
    SET_ROTATED_GRID,
    SET_NOISY_GRID,
    SET_ROTATED_NOISY_GRID,
    SET_BOX_GRID,
    SET_OCTREE,
    SET_SMALL_INTEGERS,
    SET_PRISMS,
    SET_CLUSTERS,
    SET_SHELL,
    SET_GLOBE,
    SET_BOX_SURFACE,
    SET_LINE,
    SET_LINE_ONE_OFF,
    SET_PLANE,
    SET_PLANE_GRID,
    SET_PLANE_ONE_OFF,
    SET_TWO_PLANES,
    SET_SLAB,
    SET_DUPLICATES,
    SET_NEAR_DUPLICATES,
    SET_FAR_AWAY,
    SET_FAR_GRID,
    SET_SCALES,
    SET_ONE_PLACE,
    SET_MOMENT_CURVE,
    POINT_SETS
};

static const char *const point_set_names[POINT_SETS] = {"random",
                                                        "grid",
                                                        "rotated grid",
                                                        "noisy grid",
                                                        "rotated noisy grid",
                                                        "grid of boxes",
                                                        "octree",
                                                        "small integers",
                                                        "prisms",
                                                        "clusters",
                                                        "shell",
                                                        "globe",
                                                        "box surface",
                                                        "line",
                                                        "line, one off",
                                                        "plane",
                                                        "grid in a plane",
                                                        "plane, one off",
                                                        "two planes",
                                                        "thin slab",
                                                        "duplicates",
                                                        "near duplicates",
                                                        "far away",
                                                        "grid far away",
                                                        "any scale",
                                                        "one place",
                                                        "moment curve"};

struct rotation {
    double m[3][3];
};

/* Uniform over all, by a unit quaternion. */
static inline struct rotation random_rotation(struct random *r)
{
    double q[4], length;
    do {
        length = 0;
        for (int k = 0; k < 4; k++) {
            q[k] = 2 * random_double(r) - 1;
            length += q[k] * q[k];
        }
    } while (length > 1 || length < 0.01);
    for (int k = 0; k < 4; k++)
        q[k] /= sqrt(length);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return (struct rotation){{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                              {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                              {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

static inline void rotate_points(const struct rotation *rotation, size_t count, double *p)
{
    for (size_t i = 0; i < count; i++) {
        const double q[3] = {p[3 * i], p[3 * i + 1], p[3 * i + 2]};
        for (int k = 0; k < 3; k++)
            p[3 * i + (size_t)k] = rotation->m[k][0] * q[0] + rotation->m[k][1] * q[1] +
                                   rotation->m[k][2] * q[2];
    }
}

static inline double random_scale(struct random *r, double low, double high)
{
    return pow(10, low + (high - low) * random_double(r));
}

/* Fills p (3 * count) with a set of this kind; each call another one. */
static inline void make_points(enum point_set kind, size_t count, struct random *r, double *p)
{
    const size_t cube = (size_t)ceil(cbrt((double)count) - 1e-9),
                 square = (size_t)ceil(sqrt((double)count) - 1e-9);
    const struct rotation rotation = random_rotation(r);
    const double noise = random_scale(r, -12, -2),
                 aspect[3] = {1, random_scale(r, -1, 1), random_scale(r, -1, 1)};
    const double angle = (1 + random_double(r)) / (double)square;
    for (size_t i = 0; i < count; i++) {
        double *q = p + 3 * i;
        const double g[3] = {(double)(i % cube), (double)(i / cube % cube),
                             (double)(i / cube / cube)};
        const double h[2] = {(double)(i % square), (double)(i / square)};
        for (int k = 0; k < 3; k++)
            q[k] = random_double(r);
        switch (kind) {
        case SET_GRID:
        case SET_ROTATED_GRID:
        case SET_FAR_GRID: memcpy(q, g, sizeof g); break;
        case SET_NOISY_GRID:
        case SET_ROTATED_NOISY_GRID:
            for (int k = 0; k < 3; k++)
                q[k] = g[k] + noise * (2 * q[k] - 1);
            break;
        case SET_BOX_GRID:
            for (int k = 0; k < 3; k++)
                q[k] = g[k] * aspect[k];
            break;
        case SET_OCTREE:
            for (int k = 0; k < 3; k++) {
                const double level = (double)(i % 4 == 0 ? 8 : i % 4 == 1 ? 4 : 2);
                q[k] = floor(q[k] * level) / level;
            }
            break;
        case SET_SMALL_INTEGERS:
            for (int k = 0; k < 3; k++)
                q[k] = floor(q[k] * (double)(cube + 1));
            break;
        case SET_PRISMS: /* triangles of equal sides, in layers */
            q[0] = g[0] + g[1] / 2;
            q[1] = g[1] * 0.8660254037844386;
            q[2] = g[2] * aspect[2];
            break;
        case SET_CLUSTERS: {
            const double scale = random_scale(r, -12, 0);
            for (int k = 0; k < 3; k++)
                q[k] = q[k] * scale + (double)((i * 7 + (size_t)k * 3) % 4);
            break;
        }
        case SET_SHELL: {
            double length = 0;
            for (int k = 0; k < 3; k++)
                length += (q[k] - 0.5) * (q[k] - 0.5);
            for (int k = 0; k < 3; k++)
                q[k] = (q[k] - 0.5) / sqrt(length);
            break;
        }
        case SET_GLOBE: /* circles of latitude: as many points on one sphere as there are */
            q[0] = sin(h[0] * angle) * cos(6.283185307179586 * h[1] / (double)square);
            q[1] = sin(h[0] * angle) * sin(6.283185307179586 * h[1] / (double)square);
            q[2] = cos(h[0] * angle);
            break;
        case SET_BOX_SURFACE:
            for (int k = 0; k < 3; k++)
                q[k] = floor(q[k] * (double)cube);
            q[i % 3] = i % 2 ? 0 : (double)cube;
            break;
        case SET_LINE:
        case SET_LINE_ONE_OFF: q[1] = q[2] = 0; break;
        case SET_PLANE:
        case SET_PLANE_ONE_OFF: q[2] = 0; break;
        case SET_PLANE_GRID:
            q[0] = h[0];
            q[1] = h[1] * aspect[1];
            q[2] = 0;
            break;
        case SET_TWO_PLANES: q[2] = (double)(i % 2); break;
        case SET_SLAB: q[2] *= noise; break;
        case SET_DUPLICATES:
        case SET_NEAR_DUPLICATES:
            if (i >= 4 && random_u32(r) % 2) {
                const double *other = p + 3 * (random_u32(r) % i);
                for (int k = 0; k < 3; k++)
                    q[k] = other[k] + (kind == SET_NEAR_DUPLICATES
                                           ? random_scale(r, -16, -3) * (2 * q[k] - 1)
                                           : 0);
            }
            break;
        case SET_SCALES: break;
        case SET_ONE_PLACE: q[0] = q[1] = q[2] = 0.3; break;
        case SET_MOMENT_CURVE: /* every two are joined: most cells for their number */
            q[0] = (double)i / (double)count;
            q[1] = q[0] * q[0];
            q[2] = q[1] * q[0];
            break;
        default: break;
        }
    }
    const double off = random_scale(r, -14, 0);
    if ((kind == SET_LINE_ONE_OFF || kind == SET_PLANE_ONE_OFF) && count)
        p[3 * (random_u32(r) % count) + 2] += off;
    const unsigned turn = kind == SET_ROTATED_GRID || kind == SET_ROTATED_NOISY_GRID ? 1
                          : kind == SET_GRID || kind == SET_NOISY_GRID               ? 0
                                                                       : random_u32(r) % 2;
    if (turn)
        rotate_points(&rotation, count, p);
    const double scale = kind == SET_SCALES ? random_scale(r, -300, 300) : random_scale(r, -3, 3);
    const double offset = kind == SET_FAR_AWAY || kind == SET_FAR_GRID ? random_scale(r, 3, 12) : 0;
    for (size_t i = 0; i < 3 * count; i++)
        p[i] = (p[i] + offset * (double)(1 + i % 3)) * scale;
    for (size_t i = count; i-- > 1;) { /* in any order */
        const size_t j = random_u32(r) % (i + 1);
        for (int k = 0; k < 3; k++) {
            const double swap = p[3 * i + (size_t)k];
            p[3 * i + (size_t)k] = p[3 * j + (size_t)k];
            p[3 * j + (size_t)k] = swap;
        }
    }
}

#endif
