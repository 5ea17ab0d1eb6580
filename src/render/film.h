/* SPDX-License-Identifier: Apache-2.0 */
/* film: one shot, or one for each point of an object's path, rendered, written and reported.
 *
 * Frames go to numbered files where the output's name has a %d (%04d, ...) in it, else side by side
 * onto one contact sheet.
 */
#ifndef FILM_H
#define FILM_H

#include "render/overlay.h"
#include "render/shot.h"

struct error;
struct scene;
struct stream;
struct warnings;

struct film {
    const struct render *render;      /* without path and object, which are made here */
    const struct shot_settings *shot; /* without overlay */
    struct scene *scene;
    const struct stream *stream; /* NULL: none */
    const struct baked *baked;   /* NULL: no light */
    struct overlay_settings overlay;
    int bounces;
    const char *object, *path; /* path NULL: one shot, without an object */
    bool lenient;              /* with what is broken in the object's file */
    double object_radius;      /* 0: its own */
    bool per_pixel;
    const char *output, *pfm; /* NULL: not written */
    const char *program;      /* names the progress */
    bool progress;
};

/* Takes and writes all shots, and prints the figures of those that compare. */
struct error *film_take(const struct film *film, struct warnings *warnings);

/* Writes a shot: PNG, or PFM where the name ends in .pfm. Names may be NULL. */
struct error *film_write(const struct shot *shot, const char *output, const char *pfm);

/* Prints the figures of a shot that compares, a name and a number a line, to standard output; or
 * where the picture went there, to standard error. frame: NULL, or what stands in front. */
struct error *film_print(const struct shot *shot, const char *output, const char *frame);

#endif
