/* SPDX-License-Identifier: Apache-2.0 */
/* page: the report of a bake, on one page of plain text.
 *
 * A line a figure, its name first, so that scripts can find it; shares in percent, intervals of
 * 95 % in parentheses; at the end, advice where a figure is bad.
 */
#ifndef PAGE_H
#define PAGE_H

#include "bake/facts.h"
#include "bake/plan.h"
#include "measure/report.h"

#include <stdio.h>

struct page {
    const struct plan_job *job; /* as it is shown */
    bool again;                 /* its measuring commands can be run again */
    struct scene_facts of_scene;
    struct bake_facts of_bake;
    struct report error;    /* probe-error's figures */
    struct report pictures; /* probe-render's of the pair, whose "of" is empty; may be empty */
    uint64_t packed_bytes;
    double most_error;          /* --max-error; 0: none */
    double seconds[PLAN_ALL];   /* of all cores; below 0: it did not run */
    double bake_time, all_time; /* seconds on the clock */
};

/* Writes the pipe as a shell takes it, a line a stage, and what packs it; `before` stands before
 * each line. */
struct error *page_pipe(const struct plan_job *job, const char *before, FILE *out);

struct error *page_write(const struct page *page, FILE *out);

#endif
