/* SPDX-License-Identifier: Apache-2.0 */
/* place_inside: which positions are in no air.
 *
 * Rays look around from each position, and of them count those alone that meet a surface, whose
 * sides say where the position is (place_pieces.h). Backs of solids prove that it is in their
 * matter. Where nearly all that is met are backs of sheets and rooms, it is under the ground or
 * outside of the level, however much escapes; but not where a lamp shines on it (place_look.h).
 *
 * Of many positions every fourth is looked at first; who stands between two of the same side, near
 * by, and sees both, is of that side.
 *
 * Open pieces that positions in the air see from both sides alike, leaves and paper walls, say
 * nothing. Faces that were never oriented are told by what comes of it: when most of the positions
 * meet as many backs as fronts, sheets say nothing; when nearly all would go and the backs are all
 * around them, the sheets look the wrong way and are turned.
 */
#ifndef PLACE_INSIDE_H
#define PLACE_INSIDE_H

#include "place/place_look.h"

#include <stddef.h>

struct error;
struct place;
struct tracer;
struct warnings;

struct place_inside_settings place_inside_default(void); /* 64 rays, 0.75, 1 thread */

/* What a scene and the probes in it say of its surfaces, for asking of other positions later. */
struct place_judge;

/* Judges by the positions of place; side: as place_inside sets it, or NULL. The tracer must outlive
 * the judge. */
struct error *place_judge_create(struct place_judge **judge, const struct place *place,
                                 const struct tracer *tracer,
                                 const struct place_inside_settings *settings,
                                 enum place_side *side, struct warnings *warnings);
void place_judge_destroy(struct place_judge *judge); /* NULL is legal */

/* Makes one of so many probes, of 512 of them if there are more, with the settings that are usual,
 * unless *judge is there already. */
struct error *place_judge_of(struct place_judge **judge, const struct tracer *tracer, size_t count,
                             const double *position, int threads);

/* Where a position is. Any thread. */
enum place_side place_judge_side(const struct place_judge *judge, const double p[3]);

/* Sets side[i] for each position. A warning says what was taken to be other than the file has
 * it. */
struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, enum place_side *side,
                           struct warnings *warnings);

#endif
