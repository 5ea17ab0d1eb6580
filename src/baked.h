/* baked: the light of a baked stream at any point, and which probes it comes from.
 *
 *     struct baked baked;
 *     err = baked_open(&baked, stream);
 *     baked_locate(&baked, p, BAKED_COLD, &at);
 *     err = baked_light(&baked, &at, sh);
 *
 * Everything that measures a stream asks through here, so what it measures is what probe-query answers.
 */
#ifndef BAKED_H
#define BAKED_H

#include "sh.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct locate;
struct stream;

enum { BAKED_COLD = -1, BAKED_PROBES_MOST = 4 };

struct baked {
    struct locate *locate; /* owned */
    size_t probe_count, cell_count;
    const double *position; /* 3 a probe; this and what follows is borrowed from the stream */
    const int32_t *vertex;  /* 4 a cell */
    const float *sh;        /* width values a probe */
    const float *sh_error;  /* as many; NULL: not known */
    size_t width;
    int order;
    bool convolved; /* sh holds irradiance */
};

/* Whose light a point takes, and how much of each. */
struct baked_at {
    int count; /* of probes, all with weight > 0 */
    int32_t probe[BAKED_PROBES_MOST];
    double weight[BAKED_PROBES_MOST]; /* sum to 1 */
    int32_t cell;
    bool inside; /* of the hull */
};

/* The stream must outlive it. Errors: no cells (says to run probe-tet), no light (says to run probe-capture). */
struct error *baked_open(struct baked *baked, const struct stream *stream);
void baked_close(struct baked *baked);

/* cell: where to look first, or BAKED_COLD. Any thread. */
void baked_locate(const struct baked *baked, const double p[3], int32_t cell, struct baked_at *at);

/* The blend of the probes' coefficients: sh[3 * order * order]. Error: one of the probes has no light. */
struct error *baked_light(const struct baked *baked, const struct baked_at *at, double *sh);

/* Luminance of a probe's mean irradiance over all directions. */
double baked_brightness(const struct baked *baked, int32_t probe);

/* Variance of the blend's irradiance by its probes' noise, in the mean over all directions: sum of w^2 A_l^2 Var L_lm / 4 pi, luminance, as if the
 * three colours had the same noise, as nearly white light has. NaN where a probe's is not known. */
double baked_noise(const struct baked *baked, const struct baked_at *at);

#endif
