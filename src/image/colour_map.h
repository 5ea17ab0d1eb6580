/* SPDX-License-Identifier: Apache-2.0 */
/* colour_map: numbers as colours whose steps look alike.
 *
 * COOL_WARM, for what has a sign: K. Moreland, "Diverging color maps for scientific visualization",
 * ISVC 2009, sec. 4.3: from blue (59, 76, 192) over light grey (221, 221, 221) to red (180, 4, 38),
 * in steps that CIELAB calls even. ParaView's default. MAGMA, for magnitudes: S. van der Walt and
 * N. Smith's, of matplotlib (bids.github.io/colormap, CC0); FLIP's own.
 */
#ifndef COLOUR_MAP_H
#define COLOUR_MAP_H

#include "math/vec.h"

enum colour_map { COLOUR_COOL_WARM, COLOUR_MAGMA };

/* The colour at t in [0, 1] (beyond: the end's), linear light. */
struct vec3f colour_map_at(enum colour_map map, double t);

#endif
