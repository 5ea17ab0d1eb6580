/* SPDX-License-Identifier: Apache-2.0 */
#include "vtk/vtk_derive.h"
#include "base/array.h"
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "math/cell.h"
#include "math/luminance.h"
#include "math/vec.h"
#include "vtk/vtk_export.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Mean irradiance of a coefficient L00 of 1. */
static double mean_factor(bool convolved)
{
    return SH_Y00 * (convolved ? 1 : sh_cosine(0));
}

void vtk_derive_irradiance(size_t count, int order, bool convolved, const float *sh, float *rgb)
{
    const size_t width = (size_t)(3 * order * order);
    const double factor = mean_factor(convolved);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = isnan(sh[i * width]) ? 0 : (float)(factor * (double)sh[i * width + k]);
}

void vtk_derive_luminance(size_t count, const float *rgb, float *luminance)
{
    for (size_t i = 0; i < count; i++)
        luminance[i] = luminance_vec3f((struct vec3f){rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
}

/* Rounds to float; what does not fit is 0. */
static void store(float to[3], const double from[3])
{
    for (size_t k = 0; k < 3; k++)
        to[k] = isfinite((float)from[k]) ? (float)from[k] : 0;
}

void vtk_derive_brightest(size_t count, int order, bool convolved, const float *sh,
                          float *direction)
{
    const size_t width = (size_t)(3 * order * order);
    for (size_t i = 0; i < count; i++) {
        double d[3] = {0};
        if (!isnan(sh[i * width]))
            sh_dominant(order, sh + i * width, d);
        for (int k = 0; k < 3 && convolved; k++)
            d[k] /= sh_cosine(1);
        store(direction + 3 * i, d);
    }
}

void vtk_derive_sh_luminance_gradient(size_t count, int order, bool convolved,
                                      const float *sh_gradient, float *gradient)
{
    const size_t width = (size_t)(3 * order * order);
    const double factor = mean_factor(convolved);
    for (size_t i = 0; i < count; i++) {
        double g[3] = {0};
        for (size_t axis = 0; axis < 3; axis++) {
            const float *rgb = sh_gradient + (3 * i + axis) * width;
            if (!isnan(rgb[0]))
                g[axis] = factor * (double)luminance_vec3f((struct vec3f){rgb[0], rgb[1], rgb[2]});
        }
        store(gradient + 3 * i, g);
    }
}

/* The edges of a cell from its first corner; those that it lacks are unit vectors across it. So
 * their determinant is six times the volume of a tetrahedron, twice the area of a triangle, the
 * length of a segment, and what is linear in the cell and does not change across it has one
 * gradient. */
static double cell_edges(int corners, const int32_t *v, const double *position, struct vec3 edge[3])
{
    const struct vec3 p0 = vec3_load(position + 3 * (size_t)v[0]);
    for (int k = 0; k < corners - 1; k++)
        edge[k] = vec3_sub(vec3_load(position + 3 * (size_t)v[k + 1]), p0);
    if (corners == 2) {
        const double x = fabs(edge[0].x), y = fabs(edge[0].y), z = fabs(edge[0].z);
        /* that it is least along */
        const struct vec3 axis = {x <= y && x <= z, y < x && y <= z, z < x && z < y};
        edge[1] = vec3_normalize(vec3_cross(axis, edge[0]));
    }
    if (corners < 4)
        edge[2] = vec3_normalize(vec3_cross(edge[0], edge[1]));
    return vec3_dot(edge[0], vec3_cross(edge[1], edge[2]));
}

void vtk_derive_min_dihedral(size_t cell_count, const int32_t *vertex, const double *position,
                             float *angle)
{
    for (size_t cell = 0; cell < cell_count; cell++) {
        double p[4][3], all[6];
        for (size_t i = 0; i < 4; i++)
            memcpy(p[i], position + 3 * (size_t)vertex[4 * cell + i], sizeof p[i]);
        cell_dihedral((const double(*)[3])p, all);
        double least = all[0];
        for (int k = 1; k < 6; k++)
            least = fmin(least, all[k]);
        angle[cell] = (float)least;
    }
}

void vtk_derive_min_angle(size_t cell_count, const int32_t *vertex, const double *position,
                          float *angle)
{
    for (size_t cell = 0; cell < cell_count; cell++) {
        double p[3][3], all[3];
        for (size_t i = 0; i < 3; i++)
            memcpy(p[i], position + 3 * (size_t)vertex[3 * cell + i], sizeof p[i]);
        cell_corner_angles((const double(*)[3])p, all);
        angle[cell] = (float)fmin(all[0], fmin(all[1], all[2]));
    }
}

void vtk_derive_length(size_t cell_count, const int32_t *vertex, const double *position,
                       double *length)
{
    for (size_t cell = 0; cell < cell_count; cell++) {
        const struct vec3 a = vec3_load(position + 3 * (size_t)vertex[2 * cell]),
                          b = vec3_load(position + 3 * (size_t)vertex[2 * cell + 1]);
        length[cell] = vec3_length(vec3_sub(b, a));
    }
}

void vtk_derive_cell_gradient(const struct vtk_mesh *mesh, const float *value, float *gradient)
{
    const int corners = mesh->corners;
    for (size_t cell = 0; cell < mesh->cell_count; cell++) {
        const int32_t *v = mesh->vertex + (size_t)corners * cell;
        struct vec3 edge[3], g = {0};
        const double volume = cell_edges(corners, v, mesh->position, edge);
        /* Cramer's rule for edge[k] . g = difference[k] */
        for (int k = 0; k < corners - 1 && volume > 0; k++) {
            const double difference = (double)value[v[k + 1]] - (double)value[v[0]];
            g = vec3_fma(g, difference / volume, vec3_cross(edge[(k + 1) % 3], edge[(k + 2) % 3]));
        }
        store(gradient + 3 * cell, (const double[3]){g.x, g.y, g.z});
    }
}

struct error *vtk_derive_point_gradient(const struct vtk_mesh *mesh, const float *cell_gradient,
                                        float *gradient)
{
    const size_t count = mesh->point_count;
    const int corners = mesh->corners;
    double *sum = NULL;
    struct error *err = array_create(&sum, 4 * count, sizeof *sum);
    for (size_t cell = 0; cell < mesh->cell_count && !err; cell++) {
        struct vec3 edge[3];
        const int32_t *v = mesh->vertex + (size_t)corners * cell;
        const double volume = fmax(cell_edges(corners, v, mesh->position, edge), 0);
        for (int i = 0; i < corners; i++) {
            double *at = sum + 4 * (size_t)v[i];
            for (size_t k = 0; k < 3; k++)
                at[k] += volume * (double)cell_gradient[3 * cell + k];
            at[3] += volume;
        }
    }
    for (size_t i = 0; i < count && !err; i++) {
        const double *at = sum + 4 * i, weight = at[3] > 0 ? 1 / at[3] : 0;
        store(gradient + 3 * i, (const double[3]){weight * at[0], weight * at[1], weight * at[2]});
    }
    free(sum);
    return err;
}
