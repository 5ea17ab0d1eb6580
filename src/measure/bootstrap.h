/* SPDX-License-Identifier: Apache-2.0 */
/* bootstrap: how far a figure could be off because other points might have been drawn.
 *
 * The points are drawn again, with replacement, as many as there are, a thousand times; the figure
 * is reckoned from each such set, and the middle 95 % of the results are its interval (the
 * percentile method: Efron and Tibshirani, "An introduction to the bootstrap", 1993, ch. 13). What
 * noise each point's value has is in it, since it is drawn along. It says little of figures that
 * one point decides.
 */
#ifndef BOOTSTRAP_H
#define BOOTSTRAP_H

#include <stddef.h>
#include <stdint.h>

struct error;

/* A figure with the ends of its 95 % interval; NaN: there is none. */
struct estimate {
    double value, low, high;
};

enum { BOOTSTRAP_SETS = 1000 };

/* Reckons `figures` figures from a set in which point i counts times[i] times (they sum to the
 * number of points). Any thread. */
typedef void bootstrap_reckon(const void *context, const uint32_t *times, double *figure);

/* What is drawn again, and reckoned from it. */
struct bootstrap_job {
    size_t count;        /* points; fewer than 8 have no interval */
    uint64_t seed, name; /* the sets depend on these and the count alone */
    int figures;
    bootstrap_reckon *reckon;
    const void *context; /* of reckon */
    int threads;
};

/* Fills estimate[figures]. */
struct error *bootstrap(const struct bootstrap_job *job, struct estimate *estimate);

#endif
