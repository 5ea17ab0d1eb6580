/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/cells_volume.h"
#include "base/error.h"
#include "stream/cells.h"
#include "stream/stream.h"

struct error *cells_volume_mesh(const struct stream *stream, struct probe_mesh *mesh)
{
    const struct table *probes = stream_table(stream, "probe");
    struct column *neighbour;
    struct cells cells;
    *mesh = (struct probe_mesh){0};
    if (!probes)
        return error_new("there is no table probe");
    struct error *err = cells_find(stream, &cells);
    if (!err)
        err =
            table_require(cells.table, "neighbour", COLUMN_I32, (size_t)cells.corners, &neighbour);
    if (!err)
        *mesh = (struct probe_mesh){.probes = probes->rows,
                                    .position = column_f64(table_column(probes, "position")),
                                    .corners = cells.corners,
                                    .cells = cells.table->rows,
                                    .vertex = cells.vertex,
                                    .neighbour = cells.neighbour};
    return err;
}

struct error *cells_volume_create(const struct probe_mesh *mesh, unsigned flags,
                                  struct probe_volume **volume)
{
    size_t row;
    const enum probe_status status = probe_volume_create(volume, mesh, flags, &row);
    return cells_volume_error(status, row);
}

struct error *cells_volume_open(const struct stream *stream, const struct probe_mesh *mesh,
                                unsigned flags, struct probe_volume **volume)
{
    size_t row;
    struct cells cells;
    struct error *err = cells_volume_create(mesh, flags, volume);
    if (err || flags & PROBE_SEE_ALL)
        return err;
    err = cells_find(stream, &cells);
    if (!err) {
        enum probe_status status =
            probe_volume_set_sight(*volume, cells.sight, cells.stand_in, &row);
        if (!status)
            status = probe_volume_set_sight_outside(*volume, cells.sight_outside,
                                                    cells.stand_in_outside, &row);
        err = cells_volume_error(status, row);
    }
    if (err) {
        probe_volume_destroy(*volume);
        *volume = NULL;
    }
    return err;
}

struct error *cells_volume_error(enum probe_status status, size_t row)
{
    switch (status) {
    case PROBE_OK: return NULL;
    case PROBE_NO_MEMORY: return error_memory();
    case PROBE_BAD_POSITION: return error_new("probe %zu: expected a finite position", row);
    case PROBE_BAD_VERTEX:
    case PROBE_BAD_NEIGHBOUR:
    case PROBE_BAD_SHAPE:
    case PROBE_BAD_SIGHT: return error_new("cell %zu: %s", row, probe_status_text(status));
    default: return error_new("%s", probe_status_text(status));
    }
}
