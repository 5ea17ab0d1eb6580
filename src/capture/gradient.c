/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/gradient.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"

#include <stdbool.h>

/* The integral of Y along part of a wall that is short enough for one point of it: its direction,
 * length and normal. */
struct wall {
    double direction[3], normal[3];
    double length;
    int a, b; /* the cells that it parts; the normal goes from a to b */
};

/* 1 / distance to what moves at the wall. */
static float wall_nearness(const struct gradient_cell *a, const struct gradient_cell *b,
                           struct vec3f wall)
{
    const float near_a = vec3f_dot(a->plane, wall), near_b = vec3f_dot(b->plane, wall);
    const bool bulges = vec3f_dot(a->plane, b->direction) > vec3f_dot(b->plane, b->direction) &&
                        vec3f_dot(b->plane, a->direction) > vec3f_dot(a->plane, a->direction);
    return bulges ? float_least(near_a, near_b) : float_most(near_a, near_b);
}

static void add_wall(const struct gradient_cells *cells, const struct wall *wall, int order,
                     double weight, double *d)
{
    const struct gradient_cell *cell_a = &cells->cell[wall->a], *cell_b = &cells->cell[wall->b];
    const struct vec3f direction = {(float)wall->direction[0], (float)wall->direction[1],
                                    (float)wall->direction[2]};
    const struct vec3f gain = vec3f_sub(cell_b->radiance, cell_a->radiance);
    const double speed = weight * wall->length * (double)wall_nearness(cell_a, cell_b, direction);
    if (!(speed > 0) || (gain.x == 0 && gain.y == 0 && gain.z == 0))
        return;
    double y[SH_COUNT_MAX];
    sh_basis(order, wall->direction, y);
    const double rgb[3] = {(double)gain.x, (double)gain.y, (double)gain.z};
    for (int axis = 0; axis < 3; axis++)
        sh_project(order, y, rgb, speed * wall->normal[axis], d + axis * 3 * order * order);
}

/* The walls between rows: arcs of equal z, from the cell below to the one above. */
static void add_parallels(const struct gradient_cells *cells, int order, double weight, double *d)
{
    for (int row = 1; row < cells->rows; row++) {
        const double z = 2.0 * row / cells->rows - 1, r = sqrt(1 - z * z);
        for (int column = 0; column < cells->columns; column++) {
            const double phi = 2 * ANGLE_PI * (column + 0.5) / cells->columns, c = angle_cos(phi),
                         s = angle_sin(phi);
            const int above = row * cells->columns + column;
            const struct wall wall = {.direction = {r * c, r * s, z},
                                      .normal = {-z * c, -z * s, r},
                                      .length = 2 * ANGLE_PI * r / cells->columns,
                                      .a = above - cells->columns,
                                      .b = above};
            add_wall(cells, &wall, order, weight, d);
        }
    }
}

/* The walls between columns: arcs of equal phi, in PARTS since those at the poles are long, from a
 * cell to the next one round. */
static void add_meridians(const struct gradient_cells *cells, int order, double weight, double *d)
{
    enum { PARTS = 2 };
    for (int row = 0; row < cells->rows; row++) {
        for (int part = 0; part < PARTS; part++) {
            double theta[2]; /* from the equator */
            for (int i = 0; i < 2; i++) {
                const double end = 2.0 * (row + i) / cells->rows - 1;
                theta[i] = angle_atan2(end, sqrt(fmax(1 - end * end, 0)));
            }
            const double length = (theta[1] - theta[0]) / PARTS,
                         middle = theta[0] + (part + 0.5) * length;
            const double z = angle_sin(middle), r = angle_cos(middle);
            for (int column = 0; column < cells->columns; column++) {
                const double phi = 2 * ANGLE_PI * (column + 1) / cells->columns, c = angle_cos(phi),
                             s = angle_sin(phi);
                const struct wall wall = {.direction = {r * c, r * s, z},
                                          .normal = {-s, c, 0},
                                          .length = length,
                                          .a = row * cells->columns + column,
                                          .b = row * cells->columns +
                                               (column + 1) % cells->columns};
                add_wall(cells, &wall, order, weight, d);
            }
        }
    }
}

void gradient_add_cells(const struct gradient_cells *cells, int order, double weight, double *d)
{
    add_parallels(cells, order, weight, d);
    add_meridians(cells, order, weight, d);
}

void gradient_add_delta(const struct gradient_light *light, const double p[3], int order,
                        double weight, double *d)
{
    const double step = 1e-4 * light->distance; /* the difference errs by its square, 1e-8 */
    for (int axis = 0; axis < 3; axis++) {
        for (int side = -1; side <= 1; side += 2) {
            double at[3] = {p[0], p[1], p[2]}, direction[3], rgb[3], y[SH_COUNT_MAX];
            at[axis] += side * step;
            light->delta(light->context, at, direction, rgb);
            sh_basis(order, direction, y);
            sh_project(order, y, rgb, side * weight / (2 * step), d + axis * 3 * order * order);
        }
    }
}
