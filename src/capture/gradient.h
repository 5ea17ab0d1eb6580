/* SPDX-License-Identifier: Apache-2.0 */
/* gradient: how a probe's SH changes as the probe moves, from the rays that it traced anyway.
 *
 * The sphere is cut into cells (z, phi); each has a radiance and a distance to what is seen there.
 * When the probe moves by dx, the picture of a surface at distance r moves over the sphere by
 * -(dx - w (w . dx)) / r; the wall between two cells moves with the nearer surface, which is the
 * one whose edge it would be, and the cell on one side gains what the other loses:
 *
 *     dL_lm = sum over walls of (L_b - L_a) (dx . t) / min(r_a, r_b)
 *             * integral of Y_lm along the wall
 *
 * with t the wall's normal on the sphere, from a to b, and r where the planes that were hit lie in
 * the wall's direction; across an edge that bulges towards the probe the farther of them is what is
 * seen (after Ward and Heckbert, "Irradiance gradients", EGWR 1992, translational gradient, with
 * Y_lm in place of the cosine). Radiance of Lambertian surfaces does not change with the view, so
 * as cells shrink the sum tends to the gradient. What is infinitely far does not move; nor does a
 * plane that the probe lies in, which fills half of the sphere and goes on doing so wherever the
 * probe goes on its side. Light of point and spot lights changes as its closed form does, its
 * visibility held.
 */
#ifndef GRADIENT_H
#define GRADIENT_H

#include "math/vec.h"

#include <stddef.h>

/* What is seen in a cell, through one direction of it. */
struct gradient_cell {
    struct vec3f radiance;
    struct vec3f direction; /* unit */
    /* of what is hit: its product with a direction is 1 / distance; 0: nothing, or what the probe
     * lies in */
    struct vec3f plane;
};

/* Cells of the sphere: `rows` equal steps of z from -1, times `columns` equal steps of phi, row by
 * row. */
struct gradient_cells {
    int rows, columns;
    struct gradient_cell *cell; /* rows * columns */
};

/* Adds the gradient times weight to d: d/dx, d/dy, d/dz, each of 3 * order^2 values. */
void gradient_add_cells(const struct gradient_cells *cells, int order, double weight, double *d);

/* A point or spot light: a delta of irradiance rgb in its direction, by a closed form. */
typedef void gradient_delta(const void *context, const double p[3], double direction[3],
                            double rgb[3]);
struct gradient_light {
    gradient_delta *delta;
    const void *context;
    double distance; /* from where the gradient is asked for */
};

/* Adds the gradient at p of rgb(p) Y(direction(p)), times weight, by central differences. */
void gradient_add_delta(const struct gradient_light *light, const double p[3], int order,
                        double weight, double *d);

#endif
