/* SPDX-License-Identifier: Apache-2.0 */
/* scene_sky: a scene's sky from its settings. Its picture is found, made a panorama and turned.
 *
 * A picture of the command line is where it is said to be. One of a stream's header may have moved:
 * it is looked for by its absolute name, by its name from the scene's folder, and beside the scene,
 * and the first that has the key of the header's is taken; with none of it the first that is there,
 * with a warning.
 *
 * Cube maps are sampled bilinearly, four times a texel of the panorama, which is 4 sides of a face
 * wide. Their layouts are those of most programs: a cross whose middle looks to the front, with its
 * arms to the left, right, up and down and the back at the right end, or, upside down, at the lower
 * end; or a strip of right, left, up, down, front, back, each as it stands in the cross.
 */
#ifndef SCENE_SKY_H
#define SCENE_SKY_H

#include "scene/scene.h"

struct error;
struct scene_settings;
struct warnings;

/* scene_path: NULL where the scene is no file. */
struct error *scene_sky_finish(struct scene_sky *sky, const char *scene_path,
                               const struct scene_settings *settings, struct warnings *warnings);

/* The direction of an azimuth and an elevation, in degrees: from where the centre of a picture is
 * that is not turned, counter-clockwise from above; and from the horizon of `up` (of length 1). */
struct vec3 scene_sky_direction(const double up[3], double azimuth, double elevation);

#endif
