/* place_inside: which positions are inside solids.
 *
 * What is a solid? A closed piece of the surface whose faces look outward encloses matter, unless
 * it is a room: a piece that holds another piece of the scene, or a light, encloses air, and so
 * does one whose faces look inward. Open pieces enclose nothing for certain, but a position from
 * which nearly all rays meet back faces is taken to be inside as well (a column without its ends);
 * where most of the positions would go that way, the scene's faces are not oriented and say
 * nothing.
 */
#ifndef PLACE_INSIDE_H
#define PLACE_INSIDE_H

#include <stdbool.h>

struct error;
struct place;
struct tracer;
struct warnings;

struct place_inside_settings {
    int rays;              /* looks around from each position */
    double backface_share; /* of them that must meet back faces of open pieces */
    int threads;
};

struct place_inside_settings place_inside_default(void); /* 64 rays, 0.9, 1 thread */

/* Sets inside[i] for each position. A warning says when the faces turned out not to be oriented. */
struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, bool *inside,
                           struct warnings *warnings);

#endif
