/* SPDX-License-Identifier: Apache-2.0 */
/* probe_split: what a probe's samples tell of each part of its light (trace/split.h): the same
 * sums as of all of it, with functions of the samples that are there already.
 */
#ifndef PROBE_SPLIT_H
#define PROBE_SPLIT_H

#include "capture/strata.h"
#include "trace/split.h"

/* One probe's. */
struct probe_split {
    const struct split *split;
    struct split_light light;
    struct strata *strata; /* by part; owned, and so is: */
    double *certain;       /* by part and value: light that needs no rays */
    int order, functions;  /* as strata's */
};

/* Bytes that it takes. */
size_t probe_split_bytes(const struct split *split);

/* order: of SH; 0: a surface. */
struct error *probe_split_init(struct probe_split *p, const struct split *split, int order);
void probe_split_clear(struct probe_split *p);

/* Adds a wave of own rays, whose scattered light path_samples split into p->light, and with
 * `straight` what they met. wave: as strata_add left it; solid_angle: for which each stands. */
void probe_split_own(struct probe_split *p, struct strata_wave *wave, size_t fours,
                     const struct vec3f *direction, const struct path_sample *met,
                     const float *solid_angle, bool straight);

/* Adds a wave of questions to lights or sky. */
void probe_split_asked(struct probe_split *p, struct strata_wave *wave, size_t fours,
                       const struct path_found *found);

/* Adds light that is certain: function[k] times rgb to part `part`. */
void probe_split_certain(struct probe_split *p, size_t part, const double *function,
                         const double rgb[3], double visible);

/* Whether samples found any light of a part. */
bool probe_split_found(const struct probe_split *p, size_t part);

/* Each part's light and its standard error, 3 * functions each. */
void probe_split_finish(const struct probe_split *p, int rays, float *light, float *error);

#endif
