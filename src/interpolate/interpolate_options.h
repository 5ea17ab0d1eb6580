/* SPDX-License-Identifier: Apache-2.0 */
/* interpolate_options: the options that say how light is interpolated, the same in every program
 * that asks for it.
 *
 *     struct interpolate_options how = {0};
 *     struct option_row rows[INTERPOLATE_OPTIONS_ROWS];
 *     ... groups[] = {interpolate_options_rows(&how, rows), ...} ... options_parse ...
 *     err = interpolate_options_check(&how);
 *     settings = interpolate_options_settings(&how, "sh");
 */
#ifndef INTERPOLATE_OPTIONS_H
#define INTERPOLATE_OPTIONS_H

#include "interpolate/interpolate.h"

struct error;
struct option_row;

/* As options give them; {0}: their defaults. */
struct interpolate_options {
    const struct interpolate_kind *kind; /* NULL before interpolate_options_rows */
    enum interpolate_falloff falloff;
    /* auto, extend, nearest, or what a program makes of its own choices beyond these */
    int outside;
    double radius;
};

enum { INTERPOLATE_OPTIONS_ROWS = 5 };

/* Which of the probes around a point light is taken from. */
enum interpolate_visible {
    INTERPOLATE_VISIBLE_KEPT, /* what the cells keep of what their points see; where nothing, all */
    INTERPOLATE_VISIBLE_ALL,  /* of a cell */
    INTERPOLATE_VISIBLE_RAYS, /* those that it sees, by rays in the scene (trace/seen.h) */
};

/* --visible. */
struct option_row interpolate_visible_row(enum interpolate_visible *visible);

/* What a volume is asked for, beside its settings' outside (probe-query.h). */
unsigned interpolate_visible_flags(enum interpolate_visible visible);

/* Fills rows with --interpolate, --radius, --falloff and --outside, and returns them. */
const struct option_row *interpolate_options_rows(struct interpolate_options *options,
                                                  struct option_row *rows);

/* Error: options that exclude each other. */
struct error *interpolate_options_check(const struct interpolate_options *options);

struct interpolate_settings interpolate_options_settings(const struct interpolate_options *options,
                                                         const char *column);

#endif
