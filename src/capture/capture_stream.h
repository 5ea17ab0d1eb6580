/* SPDX-License-Identifier: Apache-2.0 */
/* capture_stream: the probes of a stream captured, from a reader to a writer.
 *
 * Block by block, so that they go on while others are still to come; where the least order is to be
 * found, or there is a cache, all at once. Other tables pass. The writer is opened when the header
 * is known.
 */
#ifndef CAPTURE_STREAM_H
#define CAPTURE_STREAM_H

#include "capture/capture_black.h"
#include "capture/capture_cache.h"
#include "capture/capture_links.h"
#include "capture/capture_options.h"
#include "light/dering.h"
#include "stream/stream.h"

#include <stdio.h>

/* What is read and written, and what was seen. */
struct capture_run {
    struct capture_options options; /* owned; the order, where it was to be found, is set here */
    const char *command_line;       /* as recorded */
    char *told;                     /* of scene_told, for the header; NULL: nothing. The caller's */
    struct stream_reader *reader;
    struct stream_writer *writer; /* NULL before it is opened; the caller's to finish */
    struct stream_header header;  /* that is written; owned */
    struct capture_links links;   /* of surface transfer; owned */
    const struct scene *scene;
    struct path_tracer *path;
    bool other_sight;          /* what the stream keeps of sight is of other surfaces */
    struct progress *progress; /* may be NULL */
    /* where it is said what parts of light take, before they are captured; NULL: nowhere */
    FILE *say;
    const char *program; /* who says it */
    /* Seen: */
    size_t probes, captured; /* of the slice */
    size_t left;             /* that a signal came before */
    bool sight_dropped;      /* cells had sight of other surfaces */
    struct dering_count dering;
    struct capture_black black;
    double sky; /* sum of the captured probes' share of rays that escaped, where it is kept */
    char cache_told[sizeof((struct capture_cache *)0)
                        ->told]; /* what was made of --cache; "": none */
    double order_lost; /* what the order that was found loses of the irradiance; NaN: none was */
};

/* Captures all that the reader has. options.dry_run: says to standard output what that would take,
 * and opens no writer. */
struct error *capture_stream(struct capture_run *run);

#endif
