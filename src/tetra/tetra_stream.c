/* SPDX-License-Identifier: Apache-2.0 */
#include "tetra/tetra_stream.h"
#include "base/error.h"
#include "stream/cells.h"
#include "stream/stream.h"
#include "tetra/enclose.h"
#include "tetra/tetra.h"

#include <stdlib.h>
#include <string.h>

struct error *tetra_enclose(struct table *probes, const double bounds[6], double margin)
{
    const size_t before = probes->rows;
    const double *position = column_f64(table_column(probes, "position")), *b = bounds;
    if (!before && !bounds)
        return error_new("there are no probes to enclose");
    const struct box box = bounds ? (struct box){{b[0], b[1], b[2]}, {b[3], b[4], b[5]}}
                                  : enclose_box(before, position, margin);
    double corner[8][3];
    const size_t missing = enclose_corners(before, position, &box, corner);
    struct error *err = table_resize(probes, before + missing);
    if (!err)
        memcpy(column_f64(table_column(probes, "position")) + 3 * before, corner,
               missing * sizeof *corner);
    return err;
}

struct error *tetra_store(const struct tetra *tetra, struct stream *stream)
{
    struct table *probes = stream_table(stream, "probe");
    struct column *column = NULL;
    struct error *err = table_add_column(probes, "hull_normal", COLUMN_F32, 3, &column);
    if (!err)
        memcpy(column->data, tetra->hull_normal, 3 * probes->rows * sizeof(float));
    if (!err && tetra->merged)
        err = table_add_column(probes, "merged", COLUMN_I32, 1, &column);
    if (!err && tetra->merged)
        memcpy(column->data, tetra->merged, probes->rows * sizeof(int32_t));
    return err;
}

struct error *tetra_lend(const struct tetra *tetra, struct stream *stream)
{
    const struct {
        const char *name;
        int32_t *data;
    } columns[] = {{"vertex", tetra->vertex}, {"neighbour", tetra->neighbour}};
    struct table *cells = NULL;
    struct error *err = stream_add_table(stream, stream_cell_table[tetra->corners - 1], &cells);
    for (size_t i = 0; i < 2 && !err; i++) {
        struct column *column = NULL;
        err = table_add_column(cells, columns[i].name, COLUMN_I32, (size_t)tetra->corners, &column);
        if (!err) {
            free(column->data);
            column->data = columns[i].data;
        }
    }
    if (!err)
        cells->rows = cells->capacity = tetra->cell_count;
    return err;
}

void tetra_take_back(const struct tetra *tetra, struct stream *stream)
{
    struct table *cells = stream_table(stream, stream_cell_table[tetra->corners - 1]);
    for (size_t i = 0; cells && i < cells->column_count; i++)
        cells->columns[i].data = NULL;
    if (cells)
        cells->rows = cells->capacity = 0;
}

struct error *tetra_of_stream(struct tetra *tetra, const struct stream *stream)
{
    struct cells cells;
    struct column *merged = NULL;
    struct table *probes = stream_table(stream, "probe");
    struct error *err = cells_find(stream, &cells);
    if (!err && !cells.neighbour)
        err = error_new("table %s has no column neighbour", cells.table->name);
    if (!err && table_column(probes, "merged"))
        err = table_require(probes, "merged", COLUMN_I32, 1, &merged);
    if (!err)
        *tetra = (struct tetra){.corners = cells.corners,
                                .cell_count = cells.table->rows,
                                .vertex = cells.vertex,
                                .neighbour = cells.neighbour,
                                .merged = merged ? column_i32(merged) : NULL};
    return err;
}
