/* SPDX-License-Identifier: Apache-2.0 */
/* import_scene: a scene from a file: OBJ (with MTL), glTF and GLB, PLY, OFF or STL. */
#ifndef IMPORT_SCENE_H
#define IMPORT_SCENE_H

#include <stdbool.h>

struct error;
struct scene;
struct scene_settings;
struct warnings;

/* Reads a scene by its file name's ending, or by its content where the ending is unknown, and
 * applies the settings. Errors name the file and what is wrong with it: unreadable, without any
 * triangle (legal only for a caller that passes empty_allowed), cut off, a missing buffer, a
 * required extension that is unknown. Missing textures and whatever is not used are warnings. */
struct error *scene_read(struct scene **scene, const char *path,
                         const struct scene_settings *settings, bool empty_allowed,
                         struct warnings *warnings);

#endif
