/* SPDX-License-Identifier: Apache-2.0 */
/* flip: how different two pictures look to a person who flips between them.
 *
 * P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astroem, M. D. Fairchild, "FLIP: A
 * difference evaluator for alternating images", HPG 2020 (LDR-FLIP): a colour difference of what
 * the eye's contrast sensitivity lets through (sec. 4.1), made larger where edges and points appear
 * or vanish (sec. 4.2). 0: alike; 1: as different as can be.
 */
#ifndef FLIP_H
#define FLIP_H

#include "image/picture.h"

struct error;

/* Pixels a degree of a person 0.7 m before a screen that is 0.7 m wide and has 3840 pixels across
 * (the paper's default). */
extern const double flip_pixels_per_degree;

/* map: width * height, the caller's room. Pictures of equal size, of screen light 0 .. 1, linear
 * (display.h). *mean: over all pixels. */
struct error *flip_compare(const struct picture *reference, const struct picture *test,
                           double pixels_per_degree, int threads, float *map, double *mean);

#endif
