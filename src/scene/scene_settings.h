/* SPDX-License-Identifier: Apache-2.0 */
/* scene_settings: what the user may change of a scene and add to it; options, and the keys that
 * carry them through a stream's header.
 */
#ifndef SCENE_SETTINGS_H
#define SCENE_SETTINGS_H

#include "scene/scene.h"
#include "scene/scene_choice.h"

struct error;
struct option_row;
struct stream_header;

/* What the user may change of a scene, the same options in every program that reads one; kept in
 * the stream's header so that a later stage sees the same light. */
struct scene_settings {
    double sky[3];
    bool sky_given; /* by the command line */
    char *sky_file; /* owned; NULL: uniform sky; absolute where it was found */
    /* of a header's: its name from the scene's folder, or NULL, owned; and the key of its bytes, or
     * 0: not known */
    char *sky_from_scene;
    uint64_t sky_key;
    int sky_map;                /* scene_sky_map */
    double sky_turn;            /* degrees about sky_up, counter-clockwise from above */
    double sky_up[3];           /* of length 1; where the picture's upper edge is */
    double sky_scale;           /* multiplies sky or picture */
    struct scene_light *lights; /* from --sun, --point, --spot; owned */
    size_t light_count, light_capacity;
    /* of the lights, those of a header: the first one of the command line takes the place of them
     * all */
    size_t inherited;
    bool emit_front_only; /* --emit front */
    double albedo_scale;  /* multiplies every albedo factor */
    double max_albedo;    /* limits every albedo after that, at most 1 */
    /* multiplies the file's emission and lights; not the sky, nor lights from options */
    double light_scale;
    bool lenient; /* what is broken in the file is left out with a warning, else it is an error */
    struct scene_choice choice; /* what is left out of the file by name */
};

/* black sky, no lights, scales 1, max_albedo 1, emit both sides */
struct scene_settings scene_settings_default(void);
void scene_settings_clear(struct scene_settings *settings);

enum { SCENE_FILE_ROWS = 4, SCENE_SETTINGS_ROWS = 12 + SCENE_FILE_ROWS };

/* How a picture covers the sky: a panorama twice as wide as high, any panorama, the angular map of
 * a light probe (P. Debevec, "Rendering synthetic objects into real scenes", SIGGRAPH 1998), or the
 * six faces of a cube (scene_sky.h). */
enum scene_sky_map { SCENE_SKY_AUTO, SCENE_SKY_LATLONG, SCENE_SKY_ANGULAR, SCENE_SKY_CUBE };

/* Fills rows (SCENE_SETTINGS_ROWS) with --sky, --sky-map, --sky-turn, --sky-up, --sky-scale, --sun,
 * --point, --spot, --emit, --albedo-scale, --max-albedo, --light-scale, --lenient, --exclude,
 * --only. */
const struct option_row *scene_settings_rows(struct scene_settings *settings,
                                             struct option_row *rows);

/* Writes the settings as header keys, numbers separated by commas as in the options:
 *
 *     sky 0.5,0.6,0.8                     radiance; 0,0,0 beside
 *     sky-file /pictures/clouds.hdr       (only when there is one)
 *     sky-from-scene ../clouds.hdr        its name from the scene's folder
 *     sky-key 0123456789abcdef            of its bytes; it tells whether the picture is the same
 *     sky-map angular                     these four only where they are not the default
 *     sky-turn 90
 *     sky-up 0,0,1
 *     sky-scale 2
 *     sun-1 DX,DY,DZ,R,G,B                lights are numbered in one sequence; directions have
 *                                         length 1
 *     point-2 X,Y,Z,R,G,B
 *     spot-3 X,Y,Z,DX,DY,DZ,COS_INNER,COS_OUTER,R,G,B     cosines where the option has degrees
 *     emit both                           or front
 *     albedo-scale 1
 *     max-albedo 1
 *     light-scale 1
 *     lenient yes                         (only then)
 *     exclude-1 PATTERN                   (scene_choice.h)
 *
 * and reads them back into default settings: scene_settings_from_header(x) of
 * scene_settings_to_header(x) is x to the bit. Keys that are missing keep their default; lights
 * that the header held before are removed. From the header of a stream that was turned
 * (light/rotate.h): an error, no scene has its light. */
struct error *scene_settings_to_header(const struct scene_settings *settings,
                                       struct stream_header *header);
struct error *scene_settings_from_header(struct scene_settings *settings,
                                         const struct stream_header *header);

enum { SCENE_KEY_ROOM = 17 };

/* The scene's key as a header has it (key scene-key). Where `before`, a header's (NULL: none), is
 * the scene's with its picture, it stays so. */
void scene_key_text(const struct scene *scene, const char *before, char text[SCENE_KEY_ROOM]);

/* Whether a header's probes are of another scene, or of one under another picture of the sky, by
 * the header's keys; false where it has none. */
bool scene_differs(const struct scene *scene, const struct stream_header *header);
bool scene_sky_differs(const struct scene *scene, const struct stream_header *header);

/* Takes over where the picture of a scene's sky was found, and its key, for the header. */
struct error *scene_settings_found_sky(struct scene_settings *settings, const struct scene *scene);

/* --lenient, --exclude and --only (SCENE_FILE_ROWS) and their keys alone: how the file is read, for
 * programs that have no say in its light. What the command line gave stays when a header is read
 * over it. */
const struct option_row *scene_file_rows(struct scene_settings *settings, struct option_row *rows);
struct error *scene_file_to_header(const struct scene_settings *settings,
                                   struct stream_header *header);
struct error *scene_file_from_header(struct scene_settings *settings,
                                     const struct stream_header *header);

#endif
