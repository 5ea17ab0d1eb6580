/* SPDX-License-Identifier: Apache-2.0 */
/* stage: the scene that a stream was captured in, with the light and the settings that its header
 * names.
 *
 * What comes after probe-capture and sees the scene again starts here.
 */
#ifndef STAGE_H
#define STAGE_H

#include "capture/capture.h"
#include "capture/capture_split.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"

#include <stdbool.h>

struct error;
struct stream_header;
struct warnings;

struct stage {
    struct scene_settings scene_settings;
    struct capture_settings capture_settings;
    bool captured;  /* the header names settings: probes have light */
    bool other;     /* they have it from another scene than this */
    bool other_sky; /* or under another picture of the sky */
    /* of this scene, of the one that they were captured in ("": not known) */
    char key[24], captured_key[24];
    char relit[24]; /* what became of the light (relit_key) */
    struct scene *scene;
    struct tracer *tracer;
    struct path_tracer path;
    struct capture_split split; /* by which the probes were captured */
};

/* Reads the scene at `path` as the header says, in the light that it was relit with (scene/relit.h;
 * another scene keeps its own), and in its place `given` (scene_file_rows), which
 * is taken over and left at its default. stage_clear is legal, and needed, on error too. */
struct error *stage_init(struct stage *stage, const char *path, const struct stream_header *header,
                         struct scene_settings *given, struct warnings *warnings);

/* The scene is the whole one, until this makes it the one that probes were captured in, where that
 * was decimated: for who is to capture as they were. */
struct error *stage_decimate(struct stage *stage, struct warnings *warnings);
void stage_clear(struct stage *stage);

#endif
