/* SPDX-License-Identifier: Apache-2.0 */
#include "tetra/tetra.h"

#include <math.h>
#include <stdio.h>

const char *tetra_cells_name(int corners)
{
    static const char *const names[] = {"points", "segments", "triangles", "tetrahedra"};
    return names[corners - 1];
}

static const char *const content_names[] = {"", "length", "area", "volume"};

void tetra_report_print(const struct tetra_report *report, int corners, size_t probes, FILE *out)
{
    const struct tetra_report *r = report;
    fprintf(out,
            "cells           %zu %s\n"
            "probes          %zu, %zu on the hull, %zu merged\n",
            r->cells, tetra_cells_name(corners), probes, r->hull_vertices, r->merged_points);
    if (corners == 1)
        return;
    const char *content = content_names[corners - 1];
    fprintf(out,
            "hull            %zu %s\n"
            "%-15s %.9g",
            r->hull_facets,
            corners == 2   ? "ends"
            : corners == 3 ? "edges"
                           : "faces",
            content, r->volume);
    /* of what bends, the hull holds something else */
    if (corners == 4 || fabs(r->volume - r->hull_volume) <= 1e-6 * r->volume)
        fprintf(out, ", of the hull %.9g", r->hull_volume);
    fprintf(out, "\nof a cell       %.6g least, %.6g median, %.6g most\n", r->volume_least,
            r->volume_median, r->volume_most);
    if (corners == 2)
        return;
    const char *angle = corners == 4 ? "dihedral angle" : "angle";
    fprintf(out,
            "%-15s %.4f least, %.4f most (degrees)\n"
            "slivers         %zu cells below 5 degrees, %.4f %%\n"
            "least %s of a cell, in degrees: cells\n",
            angle, r->angle_least, r->angle_most, r->angle_histogram[0],
            100.0 * (double)r->angle_histogram[0] / (double)r->cells, angle);
    for (int i = 0; i < 15; i++)
        if (r->angle_histogram[i])
            fprintf(out, "  %2d - %2d  %9zu  %5.2f %%\n", 5 * i, 5 * i + 5, r->angle_histogram[i],
                    100.0 * (double)r->angle_histogram[i] / (double)r->cells);
}
