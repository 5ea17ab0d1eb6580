/* SPDX-License-Identifier: Apache-2.0 */
/* strata: sums of stratified samples of light, and how far off they may be.
 *
 * The light of a receiver is a vector of products, light times function: the SH basis in the
 * sample's direction for a point, the cosine alone for a surface, the cosines to several normals
 * where they are asked for; in red, green, blue and, where it is wanted, luminance. There is one
 * sample in each cell, so none knows its own variance. Cells come in fours, 2 by 2, and a four is
 * judged by the difference between its diagonals (capture.h says why, and why the largest counts
 * twice).
 *
 * Sums are in double, in STRATA_LANES partial sums, so that several fours are added by each
 * instruction; always in the same order.
 */
#ifndef STRATA_H
#define STRATA_H

#include "libprobe-query/sh.h"
#include "trace/path.h"

#include <stdbool.h>

enum { STRATA_LANES = 4, STRATA_FOURS = PATH_WAVE / 4, STRATA_CHANNELS = 4 };

/* Samples of up to STRATA_FOURS fours: corner k of four f stands at k * STRATA_FOURS + f. */
struct strata_wave {
    struct vec3f direction[PATH_WAVE];
    double light[STRATA_CHANNELS][PATH_WAVE];
    double function[SH_COUNT_MAX][PATH_WAVE];
};

struct strata_sum {
    double sum[STRATA_LANES];     /* of samples */
    double square[STRATA_LANES];  /* of differences between diagonals, squared */
    double largest[STRATA_LANES]; /* of those squares */
};

struct strata {
    int order;               /* of SH; 0: a surface, whose one function is the cosine, or: */
    const double *normal;    /* of several surfaces at one point, 3 a function; NULL: none */
    int functions, channels; /* 3, or 4 with luminance */
    struct strata_sum of[STRATA_CHANNELS][SH_COUNT_MAX];
};

/* Starts without samples. order 0: a surface. */
void strata_start(struct strata *strata, int order, bool luminance);

/* As strata_start, for the cosines to `count` unit normals (at most SH_COUNT_MAX), which outlive
 * it. */
void strata_start_normals(struct strata *strata, const double *normal, int count, bool luminance);

/* Adds `fours` fours, at most STRATA_FOURS: corner k (row by row) of four f is sample k * fours +
 * f. direction: unit; light: radiance times the solid angle for which the sample stands; normal: a
 * surface's. Leaves the functions of the samples in `wave`. */
void strata_add(struct strata *strata, struct strata_wave *wave, size_t fours,
                const struct vec3f *direction, const struct vec3f *light, struct vec3f normal);

/* Adds other light of the samples that strata_add of a like strata left in `wave`. */
void strata_add_again(struct strata *strata, struct strata_wave *wave, size_t fours,
                      const struct vec3f *light);

/* Function i of corner k of four f, as strata_add left it. */
static inline double strata_function(const struct strata_wave *wave, int i, size_t k, size_t f)
{
    return wave->function[i][k * STRATA_FOURS + f];
}

/* The sum of samples, and the square of its standard error. */
double strata_sum(const struct strata *strata, int channel, int function);
double strata_variance(const struct strata *strata, int channel, int function);

#endif
