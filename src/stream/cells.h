/* SPDX-License-Identifier: Apache-2.0 */
/* cells: the cells of a stream's probes.
 *
 * A stream holds at most one table of cells, named after what they are: tetrahedra (tet), triangles
 * of probes in a plane (tri), segments of probes on a line (segment), or a single point (point).
 */
#ifndef CELLS_H
#define CELLS_H

#include <stdbool.h>
#include <stdint.h>

struct error;
struct stream;

/* The header's keys of what their sight is true of (sight_key.h). */
#define CELLS_SIGHT_SCENE "sight-scene"
#define CELLS_SIGHT_CELLS "sight-cells"

/* A stream's cells; borrowed from it. */
struct cells {
    struct table *table;
    int corners;
    int32_t *vertex, *neighbour; /* corners * table->rows */
    /* which corners a point of a cell sees (leak/sight.h): corners * (corners - 1) and 1 a cell;
     * NULL where probe-leakfix has not looked, or the column was dropped */
    float *sight;
    int32_t *stand_in;
    /* and a point outside of the hull: 12 and 1 a cell; NULL: as on the hull */
    float *sight_outside;
    int32_t *stand_in_outside;
};

/* Whether there is a table of cells. */
bool cells_exist(const struct stream *stream);

/* Errors: there are no cells (says to run probe-tet), or two tables of them, or they lack their
 * column vertex, or a column has another shape. Without column neighbour that is NULL. */
struct error *cells_find(const struct stream *stream, struct cells *cells);

/* Removes what speaks of cells: their table, of table probe the columns hull_normal and merged, and
 * the header's keys of sight. */
void cells_remove(struct stream *stream);

#endif
