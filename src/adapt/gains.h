/* SPDX-License-Identifier: Apache-2.0 */
/* gains: what candidates would gain as probes (cavity.h), kept while nothing around them changes.
 *
 * Of each cell of a choice a number stands for all that a gain is made of there: its corners and
 * those of the cells beside it, its candidates, their errors and what these count. Where the sum
 * of those numbers over a cavity is what it was when a gain was estimated, so is the gain. So a
 * round costs what the last one changed, whatever choice it goes on from.
 */
#ifndef GAINS_H
#define GAINS_H

#include "adapt/choice.h"

struct gain {
    uint64_t around; /* of its cavity; 0: nothing is known */
    double value;
    bool doubtful; /* it may well be by chance */
};

/* Starts as {0}. */
struct gains {
    struct gain *of; /* each candidate; owned */
    size_t count, room;
};

/* Makes room for so many candidates. */
struct error *gains_reserve(struct gains *gains, size_t count);
void gains_clear(struct gains *gains);

/* The numbers of the cells of a choice; the caller's to free. */
struct error *gains_cells(const struct choice *choice, uint64_t **cell);

#endif
