/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/cells.h"
#include "base/error.h"
#include "stream/stream.h"

static struct error *find_sight(struct cells *cells)
{
    const size_t width = (size_t)(cells->corners * (cells->corners - 1));
    struct column *sight, *stand_in = NULL;
    if (!table_column(cells->table, "sight"))
        return NULL;
    struct error *err = table_require(cells->table, "sight", COLUMN_F32, width, &sight);
    if (!err && table_column(cells->table, "stand_in"))
        err = table_require(cells->table, "stand_in", COLUMN_I32, 1, &stand_in);
    if (!err) {
        cells->sight = column_f32(sight);
        cells->stand_in = stand_in ? column_i32(stand_in) : NULL;
    }
    return err;
}

static struct error *find_sight_outside(struct cells *cells)
{
    struct column *slope, *stand_in = NULL;
    if (!cells->sight || cells->corners != 4 || !table_column(cells->table, "sight_outside"))
        return NULL;
    struct error *err = table_require(cells->table, "sight_outside", COLUMN_F32, 12, &slope);
    if (!err && table_column(cells->table, "stand_in_outside"))
        err = table_require(cells->table, "stand_in_outside", COLUMN_I32, 1, &stand_in);
    if (!err) {
        cells->sight_outside = column_f32(slope);
        cells->stand_in_outside = stand_in ? column_i32(stand_in) : NULL;
    }
    return err;
}

struct error *cells_find(const struct stream *stream, struct cells *cells)
{
    *cells = (struct cells){0};
    for (int i = 0; i < STREAM_CORNERS_MOST; i++) {
        struct table *table = stream_table(stream, stream_cell_table[i]);
        if (table && cells->table)
            return error_new("there are two tables of cells, %s and %s: run probe-tet",
                             cells->table->name, table->name);
        if (table)
            *cells = (struct cells){.table = table, .corners = i + 1};
    }
    if (!cells->table)
        return error_new("there are no cells: run probe-tet");
    struct column *vertex = NULL, *neighbour = NULL;
    struct error *err =
        table_require(cells->table, "vertex", COLUMN_I32, (size_t)cells->corners, &vertex);
    if (!err && table_column(cells->table, "neighbour"))
        err = table_require(cells->table, "neighbour", COLUMN_I32, (size_t)cells->corners,
                            &neighbour);
    if (!err)
        err = find_sight(cells);
    if (!err)
        err = find_sight_outside(cells);
    cells->vertex = vertex ? column_i32(vertex) : NULL;
    cells->neighbour = neighbour ? column_i32(neighbour) : NULL;
    return err;
}

bool cells_exist(const struct stream *stream)
{
    for (size_t i = 0; i < stream->table_count; i++)
        if (stream_cell_corners(stream->tables[i].name))
            return true;
    return false;
}

void cells_remove(struct stream *stream)
{
    for (int i = 0; i < STREAM_CORNERS_MOST; i++)
        stream_remove_table(stream, stream_cell_table[i]);
    header_remove_key(&stream->header, CELLS_SIGHT_SCENE);
    header_remove_key(&stream->header, CELLS_SIGHT_CELLS);
    struct table *probes = stream_table(stream, "probe");
    if (probes) {
        table_remove_column(probes, "hull_normal");
        table_remove_column(probes, "merged");
    }
}
