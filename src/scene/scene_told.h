/* SPDX-License-Identifier: Apache-2.0 */
/* scene_told: what is wrong with a scene is said once in a bake.
 *
 * scene_read marks each of its warnings with a key: of the file's bytes, the warning and its count.
 * A program of the bake takes out those that the stream's header says were told, prints the rest,
 * and adds theirs to the header:
 *
 *     scene-told 4be1cf3a9d0272f6,91c30b5b2f8e3a11
 *
 * Another file, or another warning about it, is told again.
 */
#ifndef SCENE_TOLD_H
#define SCENE_TOLD_H

#include <stdbool.h>
#include <stdint.h>

struct error;
struct stream_header;
struct warnings;

#define SCENE_TOLD_KEY "scene-told"

/* Marks warnings about the scene at `path`, whose file has this hash, and moves them to `to`. */
void scene_told_mark(struct warnings *of_scene, const char *path, uint64_t file,
                     struct warnings *to);

/* Takes out of the list what was told according to the header (NULL: nothing). *told: the key's
 * value with what is told now, or as it was where that is `quiet`; NULL: nothing was told. The
 * caller frees it. */
struct error *scene_told(struct warnings *warnings, const struct stream_header *header, bool quiet,
                         char **told);

/* The same, and puts the key into the header. */
struct error *scene_told_in(struct warnings *warnings, struct stream_header *header, bool quiet);

#endif
