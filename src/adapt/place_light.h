/* SPDX-License-Identifier: Apache-2.0 */
/* place_light: what methods of placing (place_method.h) that look at light have in common: their
 * options, the tracer, light at positions, what is free air, and probes that stay.
 *
 *     struct place_light light = {0};
 *     err = place_light_open(&light, options, world, 256, CAPTURE_INDIRECT);
 *     ... place_light_air(&light, n, position, air) ...
 *     ... place_light_capture(&light, n, position, sh) ... place_light_is_free(&light, a, b) ...
 *     if (!err) err = place_light_give(&light, place, n, position, origin);
 *     place_light_close(&light);
 *
 * All is the same for any number of threads, and light at a position depends on the seed and the
 * position alone.
 */
#ifndef PLACE_LIGHT_H
#define PLACE_LIGHT_H

#include "capture/capture.h"
#include "trace/path.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct option_row;
struct place;
struct place_judge;
struct place_options;
struct place_world;
struct stream;
struct tracer;

/* Names of the options that all of these methods have: for `shares` of a method. */
#define PLACE_LIGHT_SHARES "rays", "bounces", "light", "order", "keep"

/* Writes the rows of these options, and returns what follows. A method that looks at light has
 * them: one by its rows, the others by their shares. */
struct option_row *place_light_rows(struct place_options *options, struct option_row *row);

/* Starts as {0}. */
struct place_light {
    struct place_world *world;        /* borrowed */
    struct capture_settings settings; /* as the options say */
    struct tracer *tracer;            /* owned, as the path tracer is */
    struct path_tracer path;
    const double *kept; /* positions of --keep, 3 each; borrowed from `stream` */
    size_t kept_count;
    struct stream *stream; /* owned */
    struct place_judge *judge;
    size_t rays; /* that captures have spent */
};

/* Makes all ready. rays, which: those of the method, where the options do not say. From here on a
 * signal is a wish to end (interrupt.h). Errors: the box, what --keep names. place_light_close is
 * legal, and needed, on error too. */
struct error *place_light_open(struct place_light *light, const struct place_options *options,
                               struct place_world *world, int rays, enum capture_light which);
void place_light_close(struct place_light *light);

/* How many floats the light of a position has: 3 order^2. */
size_t place_light_width(const struct place_light *light);

/* Writes the incident radiance at each of `count` positions (3 each) as SH, place_light_width()
 * floats each, with the settings' rays. Shows progress. Once a signal came, those that are left get
 * NaN: interrupt_came() tells. */
struct error *place_light_capture(struct place_light *light, size_t count, const double *position,
                                  float *sh);

/* The same, with the variance that the rays leave in irradiance, in the mean over directions and
 * colours. */
struct error *place_light_capture_noise(struct place_light *light, size_t count,
                                        const double *position, float *sh, double *noise);

/* Tells which positions are in the air (place_inside.h). Those of the first call, the method's
 * start, tell what the scene's surfaces are; later calls ask by them. */
struct error *place_light_air(struct place_light *light, size_t count, const double *position,
                              bool *air);

/* Whether no surface is between a and b. Any thread. */
bool place_light_is_free(const struct place_light *light, const double a[3], const double b[3]);

/* What a round did. */
struct place_round {
    int number;
    size_t probes, merged, added, moved, back; /* back: steps that were taken back */
};

/* Says on standard error what a round did, and why it was the last; not where nobody is to. */
void place_light_tell_round(const struct place_light *light, const struct place_round *round);
void place_light_tell_end(const struct place_light *light, size_t probes, const char *why);

/* Appends the probes that stay, with their own origins, and then `count` positions with this
 * one. The place is empty before. Warns of those that stay where nobody would put them: twice at
 * one place, far outside of the scene's box, or in no air. */
struct error *place_light_give(struct place_light *light, struct place *place, size_t count,
                               const double *position, int origin);

#endif
