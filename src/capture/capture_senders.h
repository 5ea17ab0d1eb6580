/* SPDX-License-Identifier: Apache-2.0 */
/* capture_senders: which senders (senders.h) a probe sees, and how much of each.
 *
 * Rays go out over the sphere, or by the cosine from a surface, on a Fibonacci lattice that is
 * shifted at random for each probe (Cranley and Patterson, SIAM J. Numer. Anal. 1976): each ray by
 * itself is uniform, so the sums have no bias. What a ray meets belongs to the sender that is
 * nearest in radii of its disc, along its surface (discs_nearest). T_s is then the sum of
 * 4 pi / rays Y_lm over the rays that met s, of a surface pi / rays; a sender's form factors are
 * shares of its rays.
 *
 * A probe has K links. It sees more senders than that, so clusters stand for some: beginning with
 * all senders in one, the cluster is cut in two whose share of the rays times the spread of its
 * senders (sender_tree.h) is largest, until there are K. A cluster scatters the mean of its
 * senders, by their areas.
 */
#ifndef CAPTURE_SENDERS_H
#define CAPTURE_SENDERS_H

#include "capture/senders.h"

#include <stdbool.h>
#include <stdint.h>

struct discs;
struct error;
struct path_tracer;
struct table;

struct capture_senders {
    const struct path_tracer *path;
    const struct senders *senders;
    const struct discs *discs; /* of the senders */
    int order;                 /* of SH: T of points */
    bool convolved;            /* T is written as irradiance (content.h) */
    int rays;                  /* a probe; a sender has an eighth of them, 64 at the least */
    uint64_t seed;
    int threads;
    /* Out, added up: rays that met a surface; of these such without a sender that faces alike, and
     * such whose sender is more than twice as far as its disc reaches. */
    uint64_t met, alone, far;
};

/* Fills the links of the senders themselves. */
struct error *capture_senders_link(struct capture_senders *capture, struct senders *senders);

/* Fills the links of rows first .. first + count - 1 that have light and no links yet. */
struct error *capture_senders_rows(struct capture_senders *capture, struct table *table,
                                   size_t first, size_t count);

/* Bytes that a thread needs. */
size_t capture_senders_bytes(const struct senders *senders, int rays);

#endif
