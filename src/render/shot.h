/* SPDX-License-Identifier: Apache-2.0 */
/* shot: a picture to look at: what is rendered, compared, laid out and written on it.
 *
 * Light is exposed, so that the 95th percentile of the truth's luminance (of the picture's, where
 * no truth is taken) is 0.7 of white, or as asked for; the same factor holds for all that is in the
 * picture.
 */
#ifndef SHOT_H
#define SHOT_H

#include "image/compare.h"
#include "render/overlay.h"
#include "render/render.h"

struct error;
struct progress;

enum shot_mode {
    SHOT_TRUTH,
    SHOT_PROBES,
    SHOT_MIXED,
    SHOT_NONE,  /* direct light alone */
    SHOT_SPLIT, /* the left half of the truth, the right half by the probes */
    SHOT_PAIR,  /* the two beside each other */
    /* CIE lightness L* (0 black, 100 white) that the screen shows by the probes, less the truth's:
     * from too dark (blue) to too bright (red) */
    SHOT_DIFFERENCE,
    SHOT_FLIP, /* FLIP's map (flip.h) */
};

struct shot_settings {
    enum shot_mode mode;
    /* what is held against what where two are: RENDER_PROBES or RENDER_MIXED, RENDER_TRUTH or
     * RENDER_DIRECT */
    enum render_light test, truth;
    double exposure; /* 0: automatic */
    enum display_tone tone;
    /* the difference that the colours' ends stand for; 0: automatic, of 1, 2 or 5 times a power of
     * ten the least that 99 % of the pixels are within */
    double scale;
    const struct picture *given_truth; /* NULL: rendered */
    const struct overlay *overlay;     /* NULL: none */
};

struct shot {
    struct picture shown;  /* screen light */
    struct picture linear; /* radiance; of a difference, that of RGB; of FLIP, its values */
    bool compared;
    struct compare figures; /* where compared */
    double exposure, scale;
};

/* Whether a mode needs two pictures. */
bool shot_compares(enum shot_mode mode);

/* How many pictures are rendered, for progress: render_tiles of each. */
int shot_pictures(const struct shot_settings *settings);

/* Makes the shot; starts as {0}. */
struct error *shot_take(struct shot *shot, const struct render *render,
                        const struct shot_settings *settings, struct progress *progress);

/* The same of two pictures that are there (variance: NULL, or of the truth); of the mode, those
 * that compare. */
struct error *shot_compose(struct shot *shot, const struct picture *truth,
                           const struct picture *variance, const struct picture *test,
                           const struct shot_settings *settings, int threads);

void shot_clear(struct shot *shot);

#endif
