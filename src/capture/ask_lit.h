/* SPDX-License-Identifier: Apache-2.0 */
/* ask_lit: a receiver's questions to sunlit points.
 *
 * Some questions are asked first, and not counted, to learn which clusters of points are seen from
 * there (lit_learn); those that count are then asked of these.
 */
#ifndef ASK_LIT_H
#define ASK_LIT_H

#include "trace/path.h"

struct error;

struct ask_lit {
    const struct path_tracer *path; /* borrowed, and so are: */
    const struct lit *lit;          /* NULL: there are none */
    struct path_receiver *receiver; /* lit is set: whether there is anything to ask for */
    uint64_t seed, name;
    uint32_t first; /* number of the next question */
    double *sum;    /* of the points' clusters; owned */
};

/* Weighs clusters, with what about `questions` questions learn. Points that are not of the
 * receiver's scene, or bring nothing, are nothing. */
struct error *ask_lit_start(struct ask_lit *ask, int questions);
void ask_lit_end(struct ask_lit *ask);

/* Asks `now` questions, at most PATH_WAVE, at these places of `count`. found: solid angle times
 * radiance over the probability, to be summed and divided by `count`. Which of all they are,
 * ask->first tells: the caller adds `count` when it is through. */
void ask_lit_wave(const struct ask_lit *ask, int count, size_t now, const int *place,
                  struct path_found *found);

#endif
