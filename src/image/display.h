/* SPDX-License-Identifier: Apache-2.0 */
/* display: from linear light to what a screen shows.
 *
 * Light is multiplied by an exposure, tone-mapped where that is asked for, and encoded as sRGB (IEC
 * 61966-2-1).
 */
#ifndef DISPLAY_H
#define DISPLAY_H

#include <stddef.h>
#include <stdint.h>

struct error;

enum display_tone {
    DISPLAY_CLIP, /* what is brighter than white is white */
    /* the ACES curve as fitted by K. Narkowicz, "ACES filmic tone mapping curve", 2016, of 0.6
     * times the light */
    DISPLAY_FILMIC,
};

/* The factor that brings the 95th percentile of the luminances above 0 to 0.7; 1 where there are
 * none. */
struct error *display_exposure(size_t count, const float *luminance, double *exposure);

/* Exposed light as the screen's, 0 .. 1. */
double display_tone(enum display_tone tone, double exposed);

/* The sRGB code of screen light: of all codes the one whose light is nearest. */
uint8_t display_code(double light);

/* The codes of 3 * count values, exposed and clipped. */
void display_codes(size_t count, const float *rgb, double exposure, uint8_t *code);

#endif
