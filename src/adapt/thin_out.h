/* SPDX-License-Identifier: Apache-2.0 */
/* thin_out: which probes are missed least.
 *
 * Where a probe goes, what it gave is given by its neighbours, about as they give it at the place
 * where it stood: its light, in the blends of all candidates around it, is replaced by the blend of
 * the neighbours that it sees, with the weights of the linear fit to them (by inverse squares of
 * distances), and what the errors grow by in all is what the probe is worth.
 */
#ifndef THIN_OUT_H
#define THIN_OUT_H

#include "adapt/choice.h"

/* Finds at most `most` probes that could go, numbers in choice->probe, the least missed first, no
 * two of them in one cell; given ones never. */
struct error *thin_out_find(const struct choice *choice, size_t most, uint32_t *probe,
                            size_t *found);

#endif
