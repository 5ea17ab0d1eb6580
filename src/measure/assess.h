/* SPDX-License-Identifier: Apache-2.0 */
/* assess: all that is measured of a baked stream: its error and the map of it, how it changes, and
 * how its cells leak.
 *
 *     struct assessment result = {0};
 *     err = assess(&result, &job);
 *     ... report_print(&result.report, ...); assess_mark(&result, stream) ...
 *     assessment_clear(&result);
 */
#ifndef ASSESS_H
#define ASSESS_H

#include "measure/measure.h"
#include "measure/truth.h"
#include "measure/unseen.h"
#include "stream/stream.h"

struct baked;
struct warnings;

struct assess_job {
    const struct stage *stage; /* the scene that is true */
    const struct baked *baked;
    struct truth_settings truth;
    /* holds the truth: read where it is there, else traced and written; NULL: traced */
    const char *truth_file;
    struct measure_settings measure;
    /* gets the points with the error at each (measure_error), as a stream; NULL: nothing does */
    const char *map_file;
    enum stream_encoding map_encoding;
    /* of each cell; 0: leaks are not measured, nor are they where there are no cells */
    int leak_samples;
    const char *command_line; /* as recorded */
    const char *program;      /* names the progress */
    bool progress;
    struct warnings *warnings; /* that the truth is noisier than the tolerance is one */
};

/* Starts as {0}. */
struct assessment {
    struct report report;
    struct unseen_cells cells;                         /* where leaks are measured */
    double truth_seconds, error_seconds, leak_seconds; /* what each part took */
};

struct error *assess(struct assessment *result, const struct assess_job *job);

/* Gives the stream's cells the columns leak, leak_light and leak_free, of what was measured. */
struct error *assess_mark(const struct assessment *result, struct stream *stream);

void assessment_clear(struct assessment *result);

#endif
