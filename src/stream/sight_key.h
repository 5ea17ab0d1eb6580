/* SPDX-License-Identifier: Apache-2.0 */
/* sight_key: what the sight of a stream's cells (leak/sight.h) is true of.
 *
 *     sight-scene 4be1cf3a9d0272f6
 *     sight-cells 91c30b5b2f8e3a11
 *
 * Columns sight and stand_in speak of surfaces, and of where the probes of each cell stand. Keys of
 * both go into the header; what is not true any more is left out, with a warning: surfaces are
 * known to probe-capture, probes and cells to who reads the columns. Sight without keys is taken as
 * it is.
 */
#ifndef SIGHT_KEY_H
#define SIGHT_KEY_H

#include <stdbool.h>
#include <stdint.h>

struct error;
struct stream;
struct stream_header;
struct warnings;

/* Says what the stream's sight is true of: the surfaces of this key (scene_surface_key), and the
 * cells as they stand. Without sight, removes the keys. */
struct error *sight_key_set(struct stream *stream, uint64_t surfaces);

void sight_key_remove(struct stream_header *header);

/* Whether a key of the header is one of these. */
bool sight_key_is(const char *name);

/* Whether the header says that sight is of other surfaces. */
bool sight_key_other_scene(const struct stream_header *header, uint64_t surfaces);

/* Removes sight of other probes or cells than the stream has, with a warning. */
struct error *sight_drop_stale(struct stream *stream, struct warnings *warnings);

/* Warns where the stream keeps sight of other surfaces than those of the scene at `path`, in which
 * it is looked at: it is used all the same, as a game would. */
void sight_warn_other_scene(const struct stream *stream, uint64_t surfaces, const char *path,
                            struct warnings *warnings);

/* The columns of cells that speak of surfaces: of other ones, they go together. */
#define SIGHT_COLUMNS                                                                              \
    "sight,stand_in,sight_outside,stand_in_outside,occlusion,leak,leak_light,leak_free"

#endif
