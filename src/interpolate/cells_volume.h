/* cells_volume: the cells of a baked stream, of whatever dimension.
 *
 * A stream holds at most one table of cells, named by its simplex: tet, or where the probes are in
 * a plane, on a line or in one place tri, segment or point (man probe.5). libprobe-query
 * (probe-query.h) makes a volume of them.
 */
#ifndef CELLS_VOLUME_H
#define CELLS_VOLUME_H

#include <stdbool.h>
#include <stddef.h>

#include "libprobe-query/probe-query.h"

struct error;
struct stream;

/* Whether a stream has a table of cells. */
bool mesh_exists(const struct stream *stream);

/* The arrays of a stream, which stay the stream's. Errors: no cells (says to run probe-tet), more
 * than one table of them. */
struct error *mesh_find(const struct stream *stream, struct probe_mesh *mesh);

/* A volume of a mesh, which must outlive it. Errors name the cell or probe. flags: PROBE_LEAN,
 * PROBE_NEAREST. */
struct error *mesh_volume(const struct probe_mesh *mesh, unsigned flags,
                          struct probe_volume **volume);

/* The error of a status; row: where. what: the table of cells. NULL for PROBE_OK. */
struct error *mesh_error(enum probe_status status, size_t row);

#endif
