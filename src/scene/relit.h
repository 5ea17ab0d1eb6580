/* SPDX-License-Identifier: Apache-2.0 */
/* relit: a scene in the light that probe-relight gave a stream, so that its truth can be traced.
 *
 * The header's other keys say what light the stream was captured in, of which scene-key is; these
 * say what became of it:
 *
 *     relit-group-1 lamps material=lamp*   what was group-1 (groups.h): its columns may be gone
 *     weight-1 0.5,0.5,0.4              what the group's light is multiplied by
 *     relit-sky 0.3,0.2,0.1             a sky in place of the captured one: the keys sky,
 *     relit-sky-file ...                sky-file, sky-key, sky-map, ... (scene_settings.h)
 *     relit-sun-1 DX,DY,DZ,R,G,B        suns and points beside the captured ones, numbered
 *     relit-point-2 X,Y,Z,R,G,B         together
 *     relit-sky-sh R,G,B,R,G,B,...      a sky of these SH, which no scene has: it cannot be traced
 */
#ifndef RELIT_H
#define RELIT_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct light_groups;
struct scene;
struct scene_settings;
struct stream_header;
struct warnings;

#define RELIT_SKY_SH_KEY "relit-sky-sh"

/* Whether a header's light was relit. */
bool relit_is(const struct stream_header *header);

/* Removes the keys of this page. */
void relit_remove(struct stream_header *header);

/* Groups and their weights, three each. Without groups there is one weight, of all light. */
struct error *relit_weights_to_header(const struct light_groups *groups, const double *weight,
                                      struct stream_header *header);

/* Of the settings, the sky (where `sky`), the suns and the points. */
struct error *relit_light_to_header(const struct scene_settings *light, bool sky,
                                    struct stream_header *header);

/* sh: 3 * order^2. */
struct error *relit_sky_sh_to_header(int order, const double *sh, struct stream_header *header);

/* Makes the light of a scene, read by these settings as it was captured, that of the header; its
 * keys stay. A sky and lights that the command line gave stay as they are. Errors: light that
 * cannot be traced: SH of a sky, or weights below 0; keys that are wrong; groups that the scene
 * does not have. */
struct error *relit_scene(struct scene *scene, const struct scene_settings *settings,
                          const struct stream_header *header, struct warnings *warnings);

enum { RELIT_KEY_ROOM = 17 };

/* A key of what became of the light: XXH3-64 of the keys of this page, in hexadecimal; "" where it
 * was not relit. */
void relit_key(const struct stream_header *header, char text[RELIT_KEY_ROOM]);

#endif
