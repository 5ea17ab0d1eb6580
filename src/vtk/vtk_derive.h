/* SPDX-License-Identifier: Apache-2.0 */
/* vtk_derive: quantities for looking at a bake, made from its columns: colours, luminance,
 * gradients.
 *
 * Arrays are the caller's, sized as stated. A probe without light (sh missing) gets zeros.
 */
#ifndef VTK_DERIVE_H
#define VTK_DERIVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct vtk_mesh;

/* Irradiance, averaged over all normals: the bands above 0 average out, so E = pi Y00 L00 (Y00 L00
 * where the coefficients are convolved). rgb: 3 * count; sh: 3 * order^2 * count. */
void vtk_derive_irradiance(size_t count, int order, bool convolved, const float *sh, float *rgb);

/* Rec. 709 luminance of 3 * count colours. */
void vtk_derive_luminance(size_t count, const float *rgb, float *luminance);

/* The direction that light comes from (sh_dominant), 3 * count: its length is the amplitude of the
 * band in radiance. */
void vtk_derive_brightest(size_t count, int order, bool convolved, const float *sh,
                          float *direction);

/* Gradient of the luminance of the mean irradiance, 3 * count, from column sh_gradient: 9 * order^2
 * * count. */
void vtk_derive_sh_luminance_gradient(size_t count, int order, bool convolved,
                                      const float *sh_gradient, float *gradient);

/* Least dihedral angle of each tetrahedron, degrees: 70.5288 in a regular one, 0 in a flat one.
 * (vtkMeshQuality's minimum angle of a tetrahedron, as of VTK 9.1, is another one in three cells of
 * ten.) */
void vtk_derive_min_dihedral(size_t cell_count, const int32_t *vertex, const double *position,
                             float *angle);

/* Least angle of each triangle, degrees. */
void vtk_derive_min_angle(size_t cell_count, const int32_t *vertex, const double *position,
                          float *angle);

/* Of each segment. */
void vtk_derive_length(size_t cell_count, const int32_t *vertex, const double *position,
                       double *length);

/* Gradient of what is interpolated linearly in each cell of 2 to 4 corners: 3 * cell_count, units
 * of value per scene unit. Exact for linear fields, of which a triangle or segment shows the part
 * along it; 0 in a cell without volume, area or length. */
void vtk_derive_cell_gradient(const struct vtk_mesh *mesh, const float *value, float *gradient);

/* Mean of the gradients of the cells around each probe, weighted with their volume, area or length:
 * 3 * count; 0 without cells. */
struct error *vtk_derive_point_gradient(const struct vtk_mesh *mesh, const float *cell_gradient,
                                        float *gradient);

#endif
