/* SPDX-License-Identifier: Apache-2.0 */
/* up: where up is in a scene. */
#ifndef UP_H
#define UP_H

struct scene;

/* The axis that is up: Y, or the shortest side of the scene's box, where that is less than a
 * quarter as long as along Y: of a ground whose Z is up. scene NULL: Y. */
int up_axis(const struct scene *scene);

/* Where the air is above a ground along the axis, 1 or -1: Y is up, as most files have it, and
 * along another axis its fronts look there. */
double up_way(const struct scene *scene, int axis);

#endif
