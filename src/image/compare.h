/* SPDX-License-Identifier: Apache-2.0 */
/* compare: how far one picture is from another, in numbers.
 *
 * Linear figures are over all pixels and channels of the pictures as they are; FLIP (flip.h) is of
 * what a screen shows of them.
 */
#ifndef COMPARE_H
#define COMPARE_H

#include "image/display.h"
#include "image/picture.h"

struct error;

struct compare {
    double mean; /* of the truth */
    /* mean of the difference over the mean of the truth: too bright above 0, too dark below; 0
     * where all is black */
    double bias;
    double rmse;     /* root mean square difference */
    double relative; /* that over the mean of the truth; 0 where all is black */
    /* the truth's own root mean square error, which is part of rmse; NaN: not known */
    double noise;
    double flip; /* mean */
};

/* How light becomes what a screen shows. */
struct compare_screen {
    double exposure;
    enum display_tone tone;
};

/* What is compared. */
struct compare_pair {
    const struct picture *truth, *test;
    const struct picture *variance; /* of the truth's pixels; NULL: not known */
    struct compare_screen screen;
};

/* map: width * height FLIP values, the caller's room. Errors: sizes differ. */
struct error *compare_pictures(const struct compare_pair *pair, int threads, float *map,
                               struct compare *result);

/* The screen's light of a picture, a new one. */
struct error *compare_show(const struct picture *picture, const struct compare_screen *screen,
                           struct picture *shown);

/* The exposure that suits a picture (display_exposure). */
struct error *compare_exposure(const struct picture *picture, double *exposure);

#endif
