/* SPDX-License-Identifier: Apache-2.0 */
/* openings: where a receiver sees the sky, so that it can be asked for there.
 *
 * What a room gets from a sky comes through few directions, which few rays find; whether one is
 * open is told by a ray that is cheap. Some questions, one in each cell of the unit square of the
 * receiver's directions, are asked first, and not counted: they say which cells are open. Those and
 * all within some cells of them get a share of the questions that count for themselves, the others
 * go to all alike. Each is divided by the density of both ways together (Veach, "Robust Monte Carlo
 * methods for light transport simulation", 1997, ch. 9, balance heuristic), which is unbiased,
 * since the cells do not depend on the questions that count.
 */
#ifndef OPENINGS_H
#define OPENINGS_H

#include <stddef.h>
#include <stdint.h>

struct error;

struct openings {
    int rows, columns;
    uint8_t *open;  /* of each cell, row by row: 1 where one met the sky; owned, and so is: */
    uint32_t *cell; /* those that are open or near */
    size_t count;
};

/* No cell is open. */
struct error *openings_init(struct openings *openings, int rows, int columns);
void openings_clear(struct openings *openings); /* one of zeros is legal */

/* Finds the cells, once `open` is set; afterwards that says which are open or near. The last
 * column is beside the first. */
struct error *openings_find(struct openings *openings);

/* A point of those cells, by t, uniform in [0, 1): values of t that are near make points that are.
 * Needs count > 0. */
void openings_draw(const struct openings *openings, double t, double *x, double *y);

/* Density of that at a point of the unit square. */
double openings_density(const struct openings *openings, double x, double y);

#endif
