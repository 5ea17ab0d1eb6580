/* SPDX-License-Identifier: Apache-2.0 */
/* run: a whole bake: the pipe into the output, then what is measured, and the report.
 *
 * The output appears when the pipe is whole and no signal came. From then on it stays, whatever
 * becomes of the report; files of an earlier report are taken away before, and pictures of one that
 * does not get whole as well, so that none speaks of another bake.
 */
#ifndef RUN_H
#define RUN_H

#include "bake/plan.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct option_given;
struct scene_settings;

/* What a command line asks for; all is borrowed. */
struct bake_job {
    const char *program; /* whose warnings it prints */
    enum plan_quality quality;
    const struct option_given *given; /* its options, in order */
    size_t given_count;
    const struct scene_settings *settings;
    const char *scene, *output; /* output "-": standard output */
    const char *pack, *report;  /* NULL: none; beside the output. report "none": none */
    double most_error;          /* 0: none */
    bool bounds_given, text, quiet;
};

/* Prints the pipe to standard output, and runs nothing but the reading of the scene. */
struct error *bake_show(const struct bake_job *job);

/* Runs it: prints the pipe to standard error, and the report to standard output (standard error
 * where the stream goes there). Catches signals (pipe.h): where one came, nothing temporary is left
 * and the caller is to end by it. */
struct error *bake_run(const struct bake_job *job);

#endif
