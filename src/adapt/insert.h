/* SPDX-License-Identifier: Apache-2.0 */
/* insert: which candidates should be probes as well.
 *
 * Cells with the largest sums of errors are looked into first. Of a number of candidates in each
 * the gain is estimated (cavity.h), and those that gain most are taken, with few
 * cells in common: what one changes the others hardly do.
 */
#ifndef INSERT_H
#define INSERT_H

#include "adapt/choice.h"

/* Finds at most `most` candidates, those that gain most first. Theirs is at least `share` of a
 * large gain: that which an eighth of `most` exceed. *found 0: none gains anything. *gain: of all
 * together, of the sum of errors. */
struct error *insert_find(const struct choice *choice, size_t most, double share,
                          uint32_t *candidate, size_t *found, double *gain);

#endif
