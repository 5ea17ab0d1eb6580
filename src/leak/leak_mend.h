/* SPDX-License-Identifier: Apache-2.0 */
/* leak_mend: keeps a stream's light from going through walls.
 *
 * By sight: each cell keeps which of its probes are seen from where (sight.h), and what blends them
 * goes by that. By probes: more of them on both sides of the walls that cells leak through, in
 * rounds of finding (leak.h), of adding the probes that are asked for, but for those that would
 * stand inside solids, and of making the cells anew. The first round keeps new probes apart by the
 * settings' separation, each further one by half as much, down to twice the offset: there the two
 * probes of a wall stand. New probes have no light.
 */
#ifndef LEAK_MEND_H
#define LEAK_MEND_H

#include "leak/leak.h"

#include <stdbool.h>

struct error;
struct stream;
struct tracer;
struct warnings;

struct leak_mend_job {
    const struct tracer *tracer;
    struct leak_settings settings; /* of the first round */
    bool sight;                    /* cells keep what their points see */
    int64_t rounds;                /* of probes, at most */
    double probes_most;            /* rather than more probes than that, edges leak: a warning */
    /* says how many edges leak, before and after, on standard error; NULL: nobody does */
    const char *program;
};

/* The stream's cells; borrowed. Errors: there are no probes, or no cells. */
struct error *leak_mesh_of(const struct stream *stream, struct leak_mesh *mesh);

/* Mends. Probes: until nothing leaks, what leaks has probes as near as they may be, or a limit is
 * met; adds rows to table probe. The cells get column occlusion, leaks.cell_edges of the last
 * round; by sight, columns sight and stand_in, which they lose otherwise: they may be of other
 * walls. */
struct error *leak_mend(struct stream *stream, const struct leak_mend_job *job,
                        struct warnings *warnings);

#endif
