#include "interpolate/cells_volume.h"
#include "base/error.h"
#include "stream/stream.h"

bool mesh_exists(const struct stream *stream)
{
    bool there = false;
    for (int i = 0; i < STREAM_CORNERS_MOST; i++)
        there = there || stream_table(stream, stream_cell_table[i]);
    return there;
}

struct error *mesh_find(const struct stream *stream, struct probe_mesh *mesh)
{
    const struct table *probes = stream_table(stream, "probe"), *cells = NULL;
    struct column *vertex = NULL, *neighbour = NULL;
    int corners = 0;
    *mesh = (struct probe_mesh){0};
    if (!probes)
        return error_new("there is no table probe");
    for (int i = 0; i < STREAM_CORNERS_MOST; i++) {
        const struct table *t = stream_table(stream, stream_cell_table[i]);
        if (t && cells)
            return error_new("there are two tables of cells, %s and %s: run probe-tet", cells->name,
                             t->name);
        if (t) {
            cells = t;
            corners = i + 1;
        }
    }
    if (!cells)
        return error_new("there are no cells: run probe-tet");
    struct error *err = table_require(cells, "vertex", COLUMN_I32, (size_t)corners, &vertex);
    if (!err)
        err = table_require(cells, "neighbour", COLUMN_I32, (size_t)corners, &neighbour);
    if (!err)
        *mesh = (struct probe_mesh){.probes = probes->rows,
                                    .position = column_f64(table_column(probes, "position")),
                                    .corners = corners,
                                    .cells = cells->rows,
                                    .vertex = column_i32(vertex),
                                    .neighbour = column_i32(neighbour)};
    return err;
}

struct error *mesh_volume(const struct probe_mesh *mesh, unsigned flags,
                          struct probe_volume **volume)
{
    size_t row;
    const enum probe_status status = probe_volume_create(volume, mesh, flags, &row);
    return mesh_error(status, row);
}

struct error *mesh_error(enum probe_status status, size_t row)
{
    switch (status) {
    case PROBE_OK: return NULL;
    case PROBE_NO_MEMORY: return error_memory();
    case PROBE_BAD_POSITION: return error_new("probe %zu: expected a finite position", row);
    case PROBE_BAD_VERTEX:
    case PROBE_BAD_NEIGHBOUR:
    case PROBE_BAD_SHAPE: return error_new("cell %zu: %s", row, probe_status_text(status));
    default: return error_new("%s", probe_status_text(status));
    }
}
