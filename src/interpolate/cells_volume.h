/* SPDX-License-Identifier: Apache-2.0 */
/* cells_volume: the cells of a stream (stream/cells.h), of whatever dimension, as libprobe-query
 * (probe-query.h) takes them, and the volume that it makes of them.
 */
#ifndef CELLS_VOLUME_H
#define CELLS_VOLUME_H

#include <stddef.h>

#include "libprobe-query/probe-query.h"

struct error;
struct stream;

/* The arrays of a stream, which stay the stream's. Errors: those of cells_find; cells without
 * column neighbour. */
struct error *cells_volume_mesh(const struct stream *stream, struct probe_mesh *mesh);

/* A volume of a mesh, which must outlive it. Errors name the cell or probe. flags: PROBE_LEAN,
 * PROBE_NEAREST. */
struct error *cells_volume_create(const struct probe_mesh *mesh, unsigned flags,
                                  struct probe_volume **volume);

/* The same of a stream's mesh, blended by the sight that the stream's cells keep, if they do.
 * flags: PROBE_SEE_ALL, too: whatever they keep. */
struct error *cells_volume_open(const struct stream *stream, const struct probe_mesh *mesh,
                                unsigned flags, struct probe_volume **volume);

/* The error of a status; row: where. NULL for PROBE_OK. */
struct error *cells_volume_error(enum probe_status status, size_t row);

#endif
