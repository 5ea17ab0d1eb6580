/* SPDX-License-Identifier: Apache-2.0 */
/* capture_options: probe-capture's command line, and what a stream's header says in its place.
 *
 *     struct capture_options o = capture_options_default();
 *     err = capture_options_parse(&o, &program, argc, argv);
 *     err = capture_options_take_over(&o, &program, header, argc, argv);
 *     ... o.capture, o.scene, o.common: the header's settings, and the command line over them ...
 *     capture_options_clear(&o);
 */
#ifndef CAPTURE_OPTIONS_H
#define CAPTURE_OPTIONS_H

#include "capture/cache_options.h"
#include "capture/capture.h"
#include "capture/capture_split.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"

struct program;

struct capture_options {
    struct capture_settings capture; /* rays: 0 until parsed; its seed is that of the options */
    bool order_auto;                 /* capture.order is the highest; the least is to be found */
    double order_loss;
    bool again;
    bool rays_given, error_given, columns_given; /* on the command line */
    struct capture_slice slice;                  /* its number: rows that came before */
    struct cache_options cache;
    char *cache_held;      /* its name, where it is a header's; owned */
    const char *cache_out; /* NULL: it is not written */
    /* parts of light: of the header, and over it the command line; to be opened */
    struct capture_split split;
    const char *groups;            /* --groups; NULL: not given */
    bool transfer_given;           /* then: */
    int transfer_sky;              /* 0: none */
    const char *transfer_suns;     /* NULL: none */
    const char *transfer_points;   /* a stream of positions; NULL: none */
    const char *transfer_surfaces; /* a stream of senders; NULL: none */
    int links;                     /* to them: of a probe, at the most */
    bool links_given;
    bool dry_run;
    struct scene_settings scene;
    struct common common; /* but for the seed */
};

struct capture_options capture_options_default(void);

/* Parses the command line over what stands in `o`. */
struct error *capture_options_parse(struct capture_options *o, struct program *program, int argc,
                                    char **argv);

/* Where probes were captured before, the light and what they were captured with take the place of
 * the defaults, and the command line is read over that; where they are captured again and it says
 * how many rays or which error, nothing that the header says of both is left. Light of
 * CAPTURE_BY_KEY is captured again where the command line asks for other settings or more columns.
 */
struct error *capture_options_take_over(struct capture_options *o, struct program *program,
                                        const struct stream_header *header, int argc, char **argv);

void capture_options_clear(struct capture_options *o);

#endif
