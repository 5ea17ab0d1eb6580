/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "libprobe-query/lattice.h"
#include "math/cell.h"
#include "math/sort.h"
#include "math/vec.h"
#include "tetra/tetra.h"

#include <math.h>
#include <stdlib.h>

/* Volume, area, length, or 0, in true units of the points. */
static double content(int corners, const struct vec3 p[4])
{
    const struct vec3 a = vec3_sub(p[1], p[0]), b = vec3_sub(p[2], p[0]), c = vec3_sub(p[3], p[0]);
    switch (corners) {
    case 4: return vec3_dot(a, vec3_cross(b, c)) / 6;
    case 3: return vec3_length(vec3_cross(a, b)) / 2;
    case 2: return vec3_length(a);
    default: return 0;
    }
}

/* The least and the largest angle of a cell, degrees: dihedral of a tetrahedron, plain of a
 * triangle, 180 of what has none. */
static void angles(int corners, const struct vec3 p[4], double *least, double *most)
{
    double angle[6], corner[4][3];
    const int count = corners == 4 ? 6 : corners == 3 ? 3 : 0;
    *least = 180;
    *most = 0;
    for (int i = 0; i < 4; i++)
        vec3_store(corner[i], p[i]);
    if (corners == 4)
        cell_dihedral((const double(*)[3])corner, angle);
    if (corners == 3)
        cell_corner_angles((const double(*)[3])corner, angle);
    for (int i = 0; i < count; i++) {
        *least = fmin(*least, angle[i]);
        *most = fmax(*most, angle[i]);
    }
}

/* A hull facet's share of the volume inside: its cone from a reference point, signed. Of triangles,
 * the cone is against the plane's normal. */
static double cone(int corners, struct vec3 reference, const struct vec3 p[4], int i,
                   struct vec3 plane)
{
    struct vec3 q[4] = {reference, reference, reference, reference};
    for (int k = 0; k < corners - 1; k++)
        q[k + 1] = p[corners == 4 ? cell_face[i][k] : (i + 1 + k) % corners];
    if (corners == 3)
        return vec3_dot(plane, vec3_cross(vec3_sub(q[1], q[0]), vec3_sub(q[2], q[0]))) / 2;
    if (corners == 2)
        return (i == 0 ? 1 : -1) * vec3_dot(plane, vec3_sub(q[1], q[0]));
    return content(corners, q);
}

struct error *tetra_measure(const struct tetra *t, size_t count, const double *position,
                            struct tetra_report *report)
{
    *report = (struct tetra_report){.cells = t->cell_count, .angle_least = 180};
    const size_t corners = (size_t)t->corners;
    double *site = NULL, *volume = NULL;
    unsigned char *seen = NULL; /* 1: in a cell, 2: on the hull */
    struct error *err = array_create(&site, 3 * count, sizeof *site);
    if (!err)
        err = array_create(&volume, t->cell_count, sizeof *volume);
    if (!err)
        err = array_create(&seen, count, 1);
    if (err || !t->cell_count)
        goto done;
    const struct lattice lattice = lattice_fit(count, position);
    for (size_t i = 0; i < count; i++)
        lattice_snap(&lattice, position + 3 * i, site + 3 * i);
    const double unit = pow(lattice.step, (double)corners - 1);
    const struct vec3 reference = vec3_load(site + 3 * (size_t)t->vertex[0]);
    struct vec3 plane = {0};
    for (size_t cell = 0; cell < t->cell_count; cell++) {
        struct vec3 p[4] = {reference, reference, reference, reference};
        double least, most;
        for (size_t i = 0; i < corners; i++) {
            const int32_t row = t->vertex[corners * cell + i];
            p[i] = vec3_load(site + 3 * (size_t)row);
            seen[row] |= 1;
        }
        if (cell == 0)
            plane = vec3_normalize(corners == 3
                                       ? vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]))
                                       : vec3_sub(p[1], p[0]));
        volume[cell] = content(t->corners, p) * unit;
        report->volume += volume[cell];
        angles(t->corners, p, &least, &most);
        report->angle_least = fmin(report->angle_least, least);
        report->angle_most = fmax(report->angle_most, most);
        report->angle_histogram[least < 70 ? (int)(least / 5) : 14]++;
        for (size_t i = 0; i < corners; i++) {
            if (t->neighbour[corners * cell + i] >= 0)
                continue;
            report->hull_facets++;
            report->hull_volume += cone(t->corners, reference, p, (int)i, plane) * unit;
            for (size_t k = 0; k < corners; k++)
                if (k != i)
                    seen[t->vertex[corners * cell + k]] |= 2;
        }
    }
    for (size_t i = 0; i < count; i++) {
        report->hull_vertices += seen[i] >> 1;
        report->unused_points += !seen[i];
        report->merged_points += t->merged && t->merged[i] >= 0;
    }
    sort_doubles(t->cell_count, volume);
    report->volume_least = volume[0];
    report->volume_median = volume[t->cell_count / 2];
    report->volume_most = volume[t->cell_count - 1];
done:
    free(site);
    free(volume);
    free(seen);
    return err;
}
