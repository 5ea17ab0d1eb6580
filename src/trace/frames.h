/* SPDX-License-Identifier: Apache-2.0 */
/* frames: where the rays of a scene have their local origin (trace.h).
 *
 * One box holds most scenes: its centre is the origin. Where pieces of a scene stand so far apart
 * that beside the space between them they are small, floats about that centre would be too coarse
 * for them, and each piece gets a frame of its own. Pieces are parted where an eighth of the box's
 * longest side, or more, is empty across one of its axes. Where a few large triangles are a ground
 * or a sky about small things, the origin is in the midst of these.
 */
#ifndef FRAMES_H
#define FRAMES_H

#include "math/box.h"
#include "scene/scene.h"

struct warnings;

enum { FRAMES_MOST = 8 };

/* The boxes of a scene's frames, that of most triangles first: at least one. */
struct frames {
    struct box box[FRAMES_MOST];
    int count;
};

struct frames frames_find(const struct scene *scene);

/* Warns of pieces that have no frame, since they have few triangles or there are too many, and are
 * so far from all frames that floats are coarse beside them. */
void frames_warn(const struct scene *scene, struct warnings *warnings);

#endif
