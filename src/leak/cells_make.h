/* SPDX-License-Identifier: Apache-2.0 */
/* cells_make: cells for a stream's probes, made by running probe-tet.
 *
 * TetGen is AGPL-3, so probe-tet alone links it; whoever needs cells runs that program. It is
 * looked for beside the running program, whatever --program-prefix and the like made of their
 * names, then on the PATH.
 */
#ifndef CELLS_MAKE_H
#define CELLS_MAKE_H

#include <stdbool.h>

struct error;
struct stream;

/* Makes the table of cells, and columns hull_normal and perhaps merged of table probe, anew from
 * the probes' positions and light. full: tetrahedra, however near to a sheet or a line the probes
 * are, if they are in none. The child's own messages go to standard error. Errors: it is not to be
 * found, or failed. */
struct error *cells_make(struct stream *stream, bool full);

/* Gives `to` the cells of `from`, whole, and columns hull_normal and merged of its probes, in the
 * place of its own. Both have as many probes. Error: `from` has no cells. */
struct error *cells_copy(struct stream *to, const struct stream *from);

#endif
