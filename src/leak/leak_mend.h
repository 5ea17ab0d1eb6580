/* SPDX-License-Identifier: Apache-2.0 */
/* leak_mend: keeps a stream's light from going through walls, and says how much still does.
 *
 * By sight: each cell keeps which of its probes are seen from where (sight.h), and what blends them
 * goes by that. By probes, in rounds of adding some, capturing them, making the cells anew and
 * looking again; none goes inside of solids. A round counts where less weight is unseen after it
 * (unseen.h); else it is undone, and the last. There are two rules for where probes go:
 *
 * - On both sides of walls that edges leak through (leak.h). The first round keeps new probes apart
 *   by the settings' separation, each further one by half as much, down to twice the offset: there
 *   the two probes of a wall stand. It is judged by the blend of all of a cell's probes, and counts
 *   as well where fewer edges leak.
 * - Where one takes away most of what leaks (leak_need.h): half of those that are allowed in the
 *   first round, half of what is left in each further one.
 *
 * What is measured is measured from points that neither sight nor the choice of probes knew of.
 */
#ifndef LEAK_MEND_H
#define LEAK_MEND_H

#include "leak/leak.h"
#include "measure/report.h"

#include <stdbool.h>

struct error;
struct stream;
struct tracer;
struct warnings;

struct leak_mend_job {
    const struct tracer *tracer;
    struct leak_settings settings; /* of the first round */
    bool sight;                    /* cells keep what their points see */
    int64_t rounds;                /* of probes beside walls, at most */
    int64_t probes;                /* where most leaks, at most */
    double probes_most;            /* never more probes than that in all: a warning */
    double points;                 /* that measure; 0: nothing is measured */
    /* where no more leaks (unseen_gate), no probe is added; -1: as many as are asked for. Needs
     * cells of two corners or more */
    double leak_most;
    /* gives the probes from row `first` on light, where the others have some */
    struct error *(*capture)(void *context, struct stream *stream, size_t first);
    void *context;
    /* says how many edges leak, and what else is measured, before and after, on standard error;
     * NULL: nobody does */
    const char *program;
};

/* The stream's cells; borrowed. Errors: there are no probes, or no cells. */
struct error *leak_mesh_of(const struct stream *stream, struct leak_mesh *mesh);

/* Mends. Adds rows to table probe. The cells get column occlusion, leaks.cell_edges of the last
 * round; by sight, columns sight and stand_in, which they lose otherwise: they may be of other
 * walls; where it is measured, column leak. report: starts as {0}, gets what still leaks
 * (unseen_report), if it is measured; the caller's. */
struct error *leak_mend(struct stream *stream, const struct leak_mend_job *job,
                        struct report *report, struct warnings *warnings);

#endif
