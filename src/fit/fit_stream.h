/* SPDX-License-Identifier: Apache-2.0 */
/* fit_stream: the probes of one stream get the values that, interpolated over the faces between
 * them, are nearest to those of the samples of another (fit_surface.h).
 */
#ifndef FIT_STREAM_H
#define FIT_STREAM_H

#include "stream/stream.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct warnings;

enum { FIT_NAME_ROOM = 64 };

struct fit_settings {
    double smooth;
    const char *columns; /* comma-separated; NULL: light, ao, sky, visibility, bent_normal */
    bool measure;        /* change nothing: tell alone how far probes are from the samples */
    int threads;
};

/* How well a column does at the samples: roots of mean squares over the surface. */
struct fit_told {
    char name[FIT_NAME_ROOM];
    double held, fitted, all; /* held: of what the probes had, NaN where they had nothing; the
                                 values */
    int steps;
    bool light; /* not a share, or a direction */
};

struct fit_report {
    struct fit_told *told; /* owned; a column each */
    size_t count;
    size_t samples, left_out; /* that have no value */
    size_t unreached;         /* vertices without a sample on any of their faces */
};

/* Changes the columns of `probes`, which take the type and place of the samples' where they are
 * new, and drops their errors, which are no more true; keys of the samples' light are taken over.
 * Errors: the streams do not belong together, a column is none of both, there is nothing to fit. */
struct error *fit_stream(struct stream *probes, const struct stream *samples,
                         const struct fit_settings *settings, struct fit_report *report,
                         struct warnings *warnings);

void fit_report_clear(struct fit_report *report);

#endif
