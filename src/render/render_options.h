/* SPDX-License-Identifier: Apache-2.0 */
/* render_options: probe-render's command line, and what a stream's header says in its place.
 *
 *     struct render_options o = render_options_default();
 *     err = render_options_parse(&o, &program, argc, argv);
 *     err = render_options_take_over(&o, &program, header, argc, argv);
 *     ...
 *     render_options_clear(&o);
 */
#ifndef RENDER_OPTIONS_H
#define RENDER_OPTIONS_H

#include "interpolate/interpolate_options.h"
#include "render/shot.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"

struct program;

struct render_options {
    struct shot_settings shot;
    const char *output, *pfm, *truth, *object, *path; /* NULL: none */
    bool compare; /* two pictures, the operands, in place of a scene */
    double eye[3], look_at[3], up[3], fov;
    bool eye_given, look_at_given;
    size_t width, height;
    int samples, max_samples, bounces;
    double error, offset, object_radius;
    double draw_probes; /* their radius; NaN: none, 0: automatic */
    bool offset_given, draw_cells, per_pixel;
    struct interpolate_options how;
    enum interpolate_visible visible;
    struct scene_settings scene;
    struct common common;
};

struct render_options render_options_default(void);

/* Parses the command line over what stands in `o`. */
struct error *render_options_parse(struct render_options *o, struct program *program, int argc,
                                   char **argv);

/* The scene's light and the bounces that the header names take the place of the defaults, and the
 * command line is read over that; what light the probes hold decides what a shot shows of them.
 * Error: a mode that this light is not for. */
struct error *render_options_take_over(struct render_options *o, struct program *program,
                                       const struct stream_header *header, int argc, char **argv);

/* Whether the light of the probes fills the picture; whether they are in it at all. */
bool render_options_by_probes(const struct render_options *o);
bool render_options_show_probes(const struct render_options *o);

void render_options_clear(struct render_options *o);

#endif
