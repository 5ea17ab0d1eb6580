/* SPDX-License-Identifier: Apache-2.0 */
/* place_look: where one position is, by what rays around it meet first (place_pieces.h). */
#ifndef PLACE_LOOK_H
#define PLACE_LOOK_H

#include "place/place_pieces.h"

#include <stdbool.h>

struct tracer;

struct place_inside_settings {
    int rays;              /* looks around from each position */
    double backface_share; /* of those that meet sheets and rooms, which are backs */
    int threads;
};

/* Where a position is: the values of the column `inside`. */
enum place_side { PLACE_AIR, PLACE_SOLID, PLACE_BEHIND, PLACE_VOID };

/* How many rays around a position met what, of how many that were traced, and what its surroundings
 * say when they were asked. */
struct look {
    int rays;
    int count[SIGHTS];
    bool asked;
    enum place_side side;
    bool floor; /* it has backs around, and a floor below */
};

/* Looks from p. A quarter of the rays comes first: where they all say the same, the others are
 * spared. Where backs and fronts are both seen, fronts that are buried themselves, as the ground is
 * below a house without a floor, are left out; where that is not enough, or nothing but solids is
 * seen, as under a foundation, places that p can see are asked. Whoever stands on a floor that
 * leads to the air is in the air, whatever backs there are around and above. */
struct look look_at(const struct place_pieces *pieces, const struct tracer *tracer,
                    const struct place_inside_settings *settings, const double p[3]);

int look_backs(const struct look *look);
/* The share of backs in what says something; what does not is held to be half front, half
 * nothing. */
double look_back_share(const struct look *look);
enum place_side look_side(const struct look *look, const struct place_inside_settings *settings);

/* Backs that are less than this share of all directions prove nothing: rays along edges, a sign
 * that is seen from behind. */
#define LOOK_LEAST (1.0 / 16)

#endif
