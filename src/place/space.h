/* SPDX-License-Identifier: Apache-2.0 */
/* space: the part of a scene that probes and points are for: boxes, which may be turned.
 *
 * A box is turned about the line through its centre along the up axis. Of the axes, u and v follow
 * up in the order X Y Z X: a turn goes from u to v, counter-clockwise seen from above.
 * A region that can be reached (reach.h) may limit it further.
 */
#ifndef SPACE_H
#define SPACE_H

#include <stdbool.h>

struct reach;
struct scene;

struct place_box {
    double low[3], high[3]; /* before the turn */
    double turn;            /* degrees */
};

enum { PLACE_BOXES = 64 }; /* as many can be given */

struct place_space {
    double low[3], high[3];      /* what holds all of it */
    const struct place_box *box; /* borrowed; the space is in one of them; NULL: as above */
    int count;
    int up;                    /* axis: 0 to 2 */
    const struct reach *reach; /* and in this region as well; borrowed; NULL: anywhere */
};

bool place_space_holds(const struct place_space *space, const double p[3]);

/* Turns p from where the box stands to where it was before its turn, or back. */
void place_box_turn(const struct place_box *box, int up, bool back, const double p[3],
                    double turned[3]);

/* What holds the turned box. */
void place_box_hull(const struct place_box *box, int up, double low[3], double high[3]);

/* The smallest box with this turn, in degrees, that holds the scene. */
void place_box_of_scene(const struct scene *scene, double turn, struct place_box *box);

/* Error: p is so far out that no ray of 32 bits gets from there to the scene. */
struct error *place_check_near(const struct scene *scene, const double p[3]);

#endif
