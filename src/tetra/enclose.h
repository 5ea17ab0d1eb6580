/* SPDX-License-Identifier: Apache-2.0 */
/* enclose: the corners of a box that are to be points as well, so that cells fill it.
 *
 * Corners are told from points by their exact coordinates.
 */
#ifndef ENCLOSE_H
#define ENCLOSE_H

#include "math/box.h"

/* The box of `count` points (3 * count; at least one), grown all round by this share of its longest
 * side. */
struct box enclose_box(size_t count, const double *position, double margin);

/* The corners of the box at which no point stands yet, each once; how many: 0 to 8. */
size_t enclose_corners(size_t count, const double *position, const struct box *box,
                       double corner[8][3]);

#endif
