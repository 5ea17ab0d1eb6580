/* SPDX-License-Identifier: Apache-2.0 */
/* vtk_probes: a stream's probes and cells as a mesh of named arrays, every column and what is
 * derived from them.
 *
 * man/probe-vtk.1 lists the arrays. Where the stream has a column of the name of a derived array,
 * the column stays.
 */
#ifndef VTK_PROBES_H
#define VTK_PROBES_H

#include "vtk/vtk_fields.h"

struct error;
struct stream;
struct warnings;

/* Borrows from the stream what it can. Starts as {0}. */
struct vtk_probes {
    struct vtk_mesh mesh;
    struct vtk_fields points, cells;
};

/* exposure: the factor from irradiance to display colour; 0: chosen from the light
 * (display_exposure). Errors: no probes, cells without their column vertex. Missing values become
 * 0, with a warning. */
struct error *vtk_probes_init(struct vtk_probes *vtk, const struct stream *stream, double exposure,
                              struct warnings *warnings);
void vtk_probes_clear(struct vtk_probes *vtk);

#endif
