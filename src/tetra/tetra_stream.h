/* SPDX-License-Identifier: Apache-2.0 */
/* tetra_stream: cells as tables of the stream whose probes they are of.
 *
 *     err = tetra_lend(&tetra, stream);        the stream is whole, and may be written
 *     ...
 *     tetra_take_back(&tetra, stream);         before either is freed
 *
 * Cells are lent, not copied: they would take as much memory again.
 */
#ifndef TETRA_STREAM_H
#define TETRA_STREAM_H

struct error;
struct stream;
struct table;
struct tetra;

/* Adds the corners of a box as probes, where none stands yet: of `bounds` (x0, y0, z0, x1, y1, z1),
 * or where that is NULL of the probes' own, grown by the margin (enclose.h). What they lack is
 * missing: light is captured by a second pass. Error: there are no probes to enclose. */
struct error *tetra_enclose(struct table *probes, const double bounds[6], double margin);

/* Stores what is known of each probe: columns hull_normal, and merged where any is. */
struct error *tetra_store(const struct tetra *tetra, struct stream *stream);

/* Adds the table of cells, whose columns hold the cells' own arrays. tetra_take_back is legal, and
 * needed, on error too. */
struct error *tetra_lend(const struct tetra *tetra, struct stream *stream);
void tetra_take_back(const struct tetra *tetra, struct stream *stream);

/* The stream's own cells, as if they had just been made; borrowed, so not to be cleared. Errors: no
 * cells, or none with neighbours. */
struct error *tetra_of_stream(struct tetra *tetra, const struct stream *stream);

#endif
