/* SPDX-License-Identifier: Apache-2.0 */
/* leak_mend: puts probes on both sides of the walls that a stream's cells leak through.
 *
 * Rounds of finding (leak.h), of adding the probes that are asked for, but for those that would
 * stand inside solids, and of making the cells anew. The first round keeps new probes apart by the
 * settings' separation, each further one by half as much, down to twice the offset: there the two
 * probes of a wall stand. New probes have no light.
 */
#ifndef LEAK_MEND_H
#define LEAK_MEND_H

#include "leak/leak.h"

struct error;
struct stream;
struct tracer;
struct warnings;

struct leak_mend_job {
    const struct tracer *tracer;
    struct leak_settings settings; /* of the first round */
    int64_t rounds;                /* at most; 0: leaks are only counted */
    double probes_most;            /* rather than more probes than that, edges leak: a warning */
    /* says how many edges leak, before and after, on standard error; NULL: nobody does */
    const char *program;
};

/* The stream's cells; borrowed. Errors: there are no probes, or no cells. */
struct error *leak_mesh_of(const struct stream *stream, struct leak_mesh *mesh);

/* Mends until nothing leaks, what leaks has probes as near as they may be, or a limit is met. Adds
 * rows to table probe, and to the cells column occlusion: leaks.cell_edges of the last round. */
struct error *leak_mend(struct stream *stream, const struct leak_mend_job *job,
                        struct warnings *warnings);

#endif
