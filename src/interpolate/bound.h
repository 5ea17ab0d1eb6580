/* SPDX-License-Identifier: Apache-2.0 */
/* bound: how far light that gradients foretell may go from that of the probes.
 *
 * Near a surface a gradient grows as 1 / distance to it, and holds as far as that; cells reach
 * farther. So what a gradient adds to the blend of the probes is bounded, twice, by light alone:
 *
 * - What probe i foretells at probe j of its cell, less what is there, counts no more than
 *   BOUND_SHARE of the mean light of the two (a limiter of slopes as in finite volumes: Barth and
 *   Jespersen 1989, but of the whole of a probe's light, along edges).
 * - What all of them add takes no more light away, on any side, than the blend of the probes has.
 *
 * Both depend on what is continuous between cells, and leave linear fields as they are: there is
 * nothing to add.
 */
#ifndef BOUND_H
#define BOUND_H

#include "libprobe-query/sh.h"

#include <stdbool.h>
#include <stddef.h>

/* What is foretold beyond what is there, as a share of the mean light of the two probes. */
#define BOUND_SHARE 1.0f

enum { BOUND_SIDES = 26, BOUND_ACROSS = 7, BOUND_FINE = 6 * BOUND_ACROSS * BOUND_ACROSS };

struct bound {
    int functions;                         /* of SH */
    float side[BOUND_SIDES][SH_COUNT_MAX]; /* irradiance of each function there */
    float fine[BOUND_FINE][SH_COUNT_MAX];  /* and between, which counts where it is dim */
    float square[SH_COUNT_MAX];            /* of each, its mean square over all directions */
};

/* Of SH, of radiance or convolved ones. */
void bound_start(struct bound *bound, int order, bool convolved);

/* The RMS irradiance of 3 * functions coefficients. */
float bound_size(const struct bound *bound, const float *sh);

/* What counts of `more`, of which `most` may. */
static inline float bound_part(float more, float most)
{
    return more > most ? most / more : 1;
}

/* The largest share of each colour of `more`, 1 at most, that can be added to sh. */
void bound_shares(const struct bound *bound, const float *sh, const float *more, float share[3]);

#endif
