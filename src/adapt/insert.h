/* SPDX-License-Identifier: Apache-2.0 */
/* insert: which candidates should be probes as well.
 *
 * Cells with the largest sums of errors are looked into first. Of a few candidates in each the gain
 * is estimated (cavity.h), until so many were that were not known (gains.h); and those that gain
 * most are taken, with few cells in common: what one changes the others hardly do. A share of those
 * that are wanted comes in any case, if need be from more cells: so there are as many rounds as
 * doublings, and each costs what it brings.
 */
#ifndef INSERT_H
#define INSERT_H

#include "adapt/choice.h"

/* Finds at most `most` candidates, those that gain most first. Theirs is at least `share` of a
 * large gain: that which an eighth of `most` exceed; but for a third of `most`, and 2 % of what
 * there is, which may gain less. *found 0: none gains anything. *gain: of all together, of the sum
 * of errors. */
struct error *insert_find(const struct choice *choice, size_t most, double share,
                          uint32_t *candidate, size_t *found, double *gain);

#endif
