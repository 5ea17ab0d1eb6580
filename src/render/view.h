/* SPDX-License-Identifier: Apache-2.0 */
/* view: where to look at a scene from, when nobody says.
 *
 * Places that light can be looked up at are spread over the scene's box: those whose rays meet
 * fronts, not backs, of surfaces. Eyes are tried at each of them and around the box; of all views,
 * the one is taken that has the most of these places in sight, looks level, and meets few backs and
 * little sky, and is lit. So a room is seen from within, from a corner; a box with an open side
 * through that side; a thing without walls from outside. Y is up. The same view for the same scene
 * on every machine.
 */
#ifndef VIEW_H
#define VIEW_H

#include "trace/path.h"

struct error;

/* fov: vertical, degrees; aspect: width over height. */
struct error *view_choose(const struct path_tracer *path, double fov, double aspect,
                          struct vec3 *eye, struct vec3 *look_at);

#endif
