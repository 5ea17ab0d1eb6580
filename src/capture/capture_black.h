/* SPDX-License-Identifier: Apache-2.0 */
/* capture_black: whether all probes are black though something shines, and what is in the way.
 *
 *     struct capture_black black = {0};
 *     capture_black_note(&black, table);          after each block of captured rows
 *     err = capture_black_warn(&black, tracer, &warnings);
 */
#ifndef CAPTURE_BLACK_H
#define CAPTURE_BLACK_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct table;
struct tracer;
struct warnings;

enum { CAPTURE_BLACK_PLACES = 128 };

struct capture_black {
    bool light;   /* some probe has some */
    size_t black; /* probes that have none */
    /* every stride-th of them, so that they are of all the stream */
    double place[3 * CAPTURE_BLACK_PLACES];
    size_t places, stride;
};

/* Notes the rows of a probe table that are captured. */
void capture_black_note(struct capture_black *black, const struct table *table);

/* Warns where no probe has light and the scene has: which surface rays from the probes to its sky,
 * lights and emissive surfaces meet first, and the share of them that do. */
struct error *capture_black_warn(const struct capture_black *black, const struct tracer *tracer,
                                 struct warnings *warnings);

#endif
