/* SPDX-License-Identifier: Apache-2.0 */
/* plan: which programs bake a scene and measure the bake, with which options.
 *
 * What a quality means stands in one table. An option that a stage takes is written by the route
 * of its name, first the quality's, then what the command line gave: a new option of probe-place or
 * another stage is a row of probe-bake's table and a route.
 */
#ifndef PLAN_H
#define PLAN_H

#include "bake/pipe.h"

#include <stdbool.h>

struct error;
struct option_given;

enum plan_quality { PLAN_DRAFT, PLAN_GOOD, PLAN_BEST };
extern const char *const plan_quality_names[]; /* NULL behind the last */

/* The light of a scene that has none and is given none: a day. */
#define PLAN_DAY_SKY "0.5,0.6,0.8"
#define PLAN_DAY_SUN "0.2,-1,0.3,10,9,8"

enum plan_stage {
    PLAN_PLACE,
    PLAN_CAPTURE,
    PLAN_TET,
    PLAN_LEAKFIX,
    PLAN_STAGES, /* of the pipe that bakes */
    PLAN_ERROR = PLAN_STAGES,
    PLAN_PACK,
    PLAN_PAIR,   /* picture: the truth beside the probes' light */
    PLAN_PROBES, /* picture: where the probes are */
    PLAN_ALL
};

struct plan_job {
    enum plan_quality quality;
    const struct option_given *given; /* options of the command line, in order; borrowed */
    size_t given_count;
    bool shown; /* for a person to run: without the options that change no result */
    bool day;   /* the scene gets PLAN_DAY_* */
    bool flat;  /* it has no volume: a grid gets some air above it */
    bool packs; /* the packed file is wanted, and shown with the pipe */
    /* borrowed */
    const char *scene;
    const char *output;                 /* that the pipe writes; "-": standard output */
    const char *baked;                  /* what is measured */
    const char *packed, *pair, *probes; /* the packed file and the pictures */
    const char *exposure;               /* of the second picture; NULL: its own */
};

/* An option of the command line, the last of its name; NULL: it was not given. */
const struct option_given *plan_given(const struct plan_job *job, const char *name);

/* Makes what a stage runs, for pipe_run or pipe_stage_line; pipe_clear ends it. */
struct error *plan_stage(const struct plan_job *job, enum plan_stage which,
                         struct pipe_stage *stage);

#endif
