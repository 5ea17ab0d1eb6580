/* SPDX-License-Identifier: Apache-2.0 */
/* move: which probes would be better elsewhere near by.
 *
 * Of each probe the candidates around it are tried in its stead. Without it its cells are a hole,
 * and with the cells that the candidate takes (cavity.h) a larger one, the faces of which it is
 * joined to: that tells, about, what the errors in it would fall by. A local search by such moves
 * after all probes were chosen one after the other, each by what there was then, finds what none of
 * these steps could see (as the interchanges of M. B. Teitz and P. Bart, "Heuristic methods for
 * estimating the generalized vertex median of a weighted graph", Operations Research 16, 1968).
 */
#ifndef MOVE_H
#define MOVE_H

#include "adapt/choice.h"

struct move {
    uint32_t probe, candidate; /* which of the choice's; where to */
};

/* What is known of the moves of a candidate that is a probe, while nothing around it changes. */
struct move_known {
    uint64_t around; /* of its cells; 0: nothing is known */
    uint32_t candidate;
    double gain;
};

/* Starts as {0}. */
struct moves {
    struct move_known *of; /* each candidate; owned */
    size_t count, room;
};

void moves_clear(struct moves *moves);

/* Finds moves of probes that were not given, at most `most`, which change no cell in common, those
 * that gain most first. */
struct error *move_find(const struct choice *choice, struct moves *known, size_t most,
                        struct move *move, size_t *found);

/* Sets good[i] where the errors around move i fell from one choice to the other, in which all
 * `count` moves were made. Others are not found again while nothing around them changes. */
struct error *move_judge(const struct choice *before, const struct choice *after,
                         struct moves *known, size_t count, const struct move *move, bool *good);

#endif
