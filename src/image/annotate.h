/* SPDX-License-Identifier: Apache-2.0 */
/* annotate: words and scales drawn into a picture (of screen light, 0 .. 1).
 *
 * Letters are stb_easy_font's, whole pixels, as large as suits the picture, with a dark edge that
 * shows on any ground.
 */
#ifndef ANNOTATE_H
#define ANNOTATE_H

#include "image/colour_map.h"
#include "image/picture.h"

/* Writes text with its left upper corner at (x, y). */
void annotate_text(const struct picture *picture, double x, double y, const char *text);

/* The size of a text on this picture. */
double annotate_width(const struct picture *picture, const char *text);
double annotate_height(const struct picture *picture);

/* A scale along the lower edge: the map's colours from 0 to 1, with these words at its start,
 * middle and end, and a title above. */
void annotate_scale(const struct picture *picture, enum colour_map map, const char *title,
                    const char *const label[3]);

#endif
