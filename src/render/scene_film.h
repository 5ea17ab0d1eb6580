/* SPDX-License-Identifier: Apache-2.0 */
/* scene_film: a scene with the probes of a stream, as options ask for it, made ready and filmed.
 *
 *     struct scene_film film = {0};
 *     err = scene_film_init(&film, &options, scene, stream, input, &warnings);
 *     ... what is to be said before the work ...
 *     err = scene_film_take(&film, &options, stream, program, &warnings);
 *     scene_film_clear(&film);
 */
#ifndef SCENE_FILM_H
#define SCENE_FILM_H

#include "render/film.h"

struct render_options;

struct scene_film {
    struct scene *scene;
    struct baked baked;
    bool light;            /* baked is open */
    struct tracer *tracer; /* of rays that look for the probes; NULL: there are none */
    struct seen *seen;
    double spacing; /* of the probes */
    struct camera camera;
    bool view_chosen;         /* nobody said where to look: */
    struct vec3 eye, look_at; /* from here to there */
    struct picture truth;     /* where one is given */
};

/* Reads the scene, opens the stream's light, aims. stream: NULL, or what was read from `input`.
 * scene_film_clear is legal, and needed, on error too. */
struct error *scene_film_init(struct scene_film *film, const struct render_options *options,
                              const char *scene_path, const struct stream *stream,
                              const char *input, struct warnings *warnings);

/* Takes and writes the shots (film_take). program: names the progress. */
struct error *scene_film_take(const struct scene_film *film, const struct render_options *options,
                              const struct stream *stream, const char *program,
                              struct warnings *warnings);

void scene_film_clear(struct scene_film *film);

#endif
