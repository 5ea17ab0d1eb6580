/* SPDX-License-Identifier: Apache-2.0 */
/* report: named figures with their intervals, as a table for people, as lines for scripts, or as
 * JSON.
 *
 * A figure has the name of a measure and of what it is a measure of ("rms", "dark"). The list is
 * the report; the formats only show it.
 */
#ifndef REPORT_H
#define REPORT_H

#include "measure/bootstrap.h"

#include <stdio.h>

struct error;

struct report_row {
    char measure[32], of[32];
    struct estimate estimate;
};

/* Starts as {0}. */
struct report {
    struct report_row *rows; /* owned */
    size_t count, capacity;
};

enum report_format { REPORT_TABLE, REPORT_TSV, REPORT_JSON };

struct error *report_add(struct report *report, const char *measure, const char *of,
                         struct estimate estimate);

/* A figure without an interval. */
struct error *report_add_number(struct report *report, const char *measure, const char *of,
                                double value);

/* The figure; all NaN where there is none. */
struct estimate report_get(const struct report *report, const char *measure, const char *of);

/* Prints to `out`, and makes sure that it is there. Errors: what the system says. */
struct error *report_print(const struct report *report, enum report_format format, FILE *out);

/* The table of what leaks (unseen_report), each line after `before`. */
void report_print_leaks(const struct report *report, const char *before, FILE *out);

void report_clear(struct report *report);

#endif
