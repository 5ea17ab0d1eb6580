/* SPDX-License-Identifier: Apache-2.0 */
/* frames: where the rays of a scene have their local origin (trace.h).
 *
 * One box holds most scenes: its centre is the origin. Where pieces of a scene stand so far apart
 * that beside the space between them they are small, floats about that centre would be too coarse
 * for them, and each piece gets a frame of its own, which is made when a ray first starts near it.
 * Pieces are parted where a 256th of the box's longest side, or more, is empty across one of its
 * axes. Where a few large triangles are a ground or a sky about small things, the origin is in the
 * midst of these.
 */
#ifndef FRAMES_H
#define FRAMES_H

#include "math/box.h"
#include "scene/scene.h"

struct error;
struct warnings;

/* As each frame that is made holds all of the scene, there are fewer of scenes of more than 2^14
 * triangles, 8 at least. */
enum { FRAMES_MOST = 256 };

/* The boxes of a scene's frames, that of most triangles first: at least one. */
struct frames {
    struct box box[FRAMES_MOST];
    int count;
};

struct error *frames_find(struct frames *frames, const struct scene *scene);

/* Warns of pieces that are so far from the rest that floats about its centre are coarse beside
 * them, where they have few triangles, which are hardly meant to be there, or no frame, since there
 * are too many. */
struct error *frames_warn(const struct scene *scene, struct warnings *warnings);

#endif
