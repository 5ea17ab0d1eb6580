/* SPDX-License-Identifier: Apache-2.0 */
/* place_ground: columns of probes that stand on the floors of a scene.
 *
 * A ray goes down each column. What it meets from above, and is not steeper than 70 degrees, is a
 * floor: the ground, a roof, what is under a bridge. Probes stand at fixed heights above each,
 * where there is room. A ground that shows its back to the sky, as files without orientation have
 * it, is a floor where nearly all of it does.
 */
#ifndef PLACE_GROUND_H
#define PLACE_GROUND_H

#include "place/place.h"

#include <stdbool.h>

struct error;
struct scene;
struct tracer;

struct place_ground {
    const struct tracer *tracer; /* borrowed */
    int up;                      /* axis: 0 to 2 */
    double way;                  /* up is to its positive side: 1, or -1 */
    bool turned;                 /* floors show their backs */
    int layers;                  /* probes in a column, above each floor */
};

/* Whether most rays from within the scene's box along its shortest axis escape, through backs but
 * no front, or there is but one surface along them: there is no ceiling. Of a ground whose tracer
 * and up are known; sets way and turned. */
bool place_ground_look(struct place_ground *ground);

/* Appends the column through p: `first` above each floor that is between these ends, coordinates
 * along up, and on by `step`. within: and not beyond them. */
struct error *place_ground_column(struct place *place, const struct place_ground *ground,
                                  const double p[3], double first, double step,
                                  const double ends[2], bool within);

#endif
