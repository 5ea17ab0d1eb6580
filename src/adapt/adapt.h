/* SPDX-License-Identifier: Apache-2.0 */
/* adapt: probes where they lower the error most that a player sees.
 *
 * Of candidates whose light is known (candidates.h) a few far apart are the first probes. Then go
 * rounds: cells are made, every candidate is blended of what it sees and held against its own light
 * by the ruler (choice.h), and those that lower the sum of errors most become probes (insert.h), at
 * most a fifth of what there is a round, so that all rounds together cost a small multiple of the
 * last. Whenever there are half as many more, the choice is looked at as queries will see it
 * (choice_look), and its errors are told. Then turns: those that are missed least go (thin_out.h),
 * as many others come, and the turn is kept if the error fell.
 *
 * The error of the candidates of space guides the choice, and so is too good; that of the judges,
 * which take no part, is the one that is told and that ends the rounds: where it is low enough, or
 * where twice the probes have not lowered it beyond its noise.
 */
#ifndef ADAPT_H
#define ADAPT_H

#include "adapt/candidates.h"
#include "capture/capture.h"

#include <stdbool.h>
#include <stddef.h>

/* When to stop; 0: not for that. At least one is set. */
struct adapt_limits {
    double error;  /* of the judges, the upper end of its interval: then as few as have it */
    size_t probes; /* at most so many, given ones too; 4 or more */
    size_t bytes;  /* of the packed file, at most so many */
    double gain;   /* the last doubling took less than this share off the error */
};

/* What a choice came to that was looked at. */
struct adapt_row {
    size_t probes, bytes;
    double space, judges, doubt; /* errors; doubt: standard error of that of judges */
    double seconds;              /* since the start, capture of candidates and all */
};

struct adapt_job {
    struct candidates_job candidates;
    struct adapt_limits limits;
    size_t probes_most; /* --max-probes, whatever the limits */
    /* Standard error of a probe's light, as a share of the error that remains: so many rays they
     * get. 0: the settings' */
    double noise;
    /* says on standard error how it goes; NULL: nobody does */
    const char *program;
    bool progress;
    size_t given;           /* positions of probes that stay; */
    const double *position; /* 3 each */
};

/* Why it stopped. */
enum adapt_end {
    ADAPT_NONE, /* it goes on */
    ADAPT_ERROR,
    ADAPT_PROBES,
    ADAPT_BYTES,
    ADAPT_GAIN,
    ADAPT_MOST, /* probes_most came first */
    ADAPT_FLAT, /* no candidate lowers the error beyond its noise */
    ADAPT_INTERRUPT
};

/* Starts as {0}. */
struct adapt_result {
    double *position;                 /* 3 each, given ones first; owned */
    struct capture_settings settings; /* with which probes get their light */
    /* what probe-capture would find, candidates_capture_width each; NaN where a signal came before;
     * owned */
    float *light;
    size_t count;
    /* of all looks, in order; the last is the result's, but after a signal; owned */
    struct adapt_row *row;
    size_t rows, room;
    enum adapt_end end;
    size_t candidates;
    double rays;  /* of a probe, in the mean */
    double least; /* error that SH of this order leave wherever probes are (choice_least_error) */
};

/* Errors: no light, no free space, a box or free space that is flat, a limit that has no room for 4
 * probes beside the given ones; a signal before the light of 4 candidates was traced. After a later
 * one there are the probes until then, before the first look without a row. */
struct error *adapt(struct adapt_result *result, const struct adapt_job *job);
void adapt_clear(struct adapt_result *result);

#endif
