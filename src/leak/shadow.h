/* SPDX-License-Identifier: Apache-2.0 */
/* shadow: where an edge goes through the border of a shadow (Sukys 2014, sec. 6, without the shadow
 * volumes that it makes there).
 *
 * Suns, points and spots cast shadows with sharp borders in the space between probes, as walls are
 * there for what the probes hold of those lamps. A ray goes from both ends of an edge to each lamp.
 * Where something is in the way of one and not of the other, the border is between them, and is
 * found by halving. A spot's cone, which fades, is no border.
 */
#ifndef SHADOW_H
#define SHADOW_H

#include "math/vec.h"

#include <stdbool.h>

struct scene_light;
struct tracer;

struct shadow_border {
    const struct scene_light *lamp; /* NULL: there is no border */
    double distance;                /* from a, along the edge, scene units */
    bool lit;                       /* the lamp shines on a's side, and not on b's; else not so */
};

/* Finds the border on the way from a to b, where nothing stands: of several lamps, that of the one
 * that is brightest there. It is within `precision` (scene units) of where it is said to be. Edges
 * that lie in the lamp's direction, of which less than the share `graze` is across it, do not
 * count; nor do lamps that do not shine on both ends, whatever stands there. */
struct shadow_border shadow_find(const struct tracer *tracer, struct vec3 a, struct vec3 b,
                                 double graze, double precision);

/* Whether nothing opaque is between p and the lamp. */
bool shadow_lit(const struct tracer *tracer, const struct scene_light *lamp, struct vec3 p);

#endif
