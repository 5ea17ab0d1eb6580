/* SPDX-License-Identifier: Apache-2.0 */
/* unseen_outside: how much of the light of points outside of the hull comes from probes that they
 * cannot see (unseen.h): the part of the certificate that cells say nothing of.
 *
 * Points are spread evenly over the scene's box, by the additive sequence of three dimensions'
 * golden ratio (Roberts 2018), and those that are outside of the hull and in free space count. Who
 * sees no probe at all around (seen_nearest) is out of what the probes are for, as beyond the walls
 * of a level, and does not; how many these are is said.
 */
#ifndef UNSEEN_OUTSIDE_H
#define UNSEEN_OUTSIDE_H

#include "measure/bootstrap.h"

#include <stdbool.h>
#include <stddef.h>

struct baked;
struct error;
struct report;
struct tracer;
struct unseen_settings;

struct unseen_outside_blend {
    struct estimate weight, light; /* as of struct unseen_blend */
    double blind;
    double worst, worst_point[3]; /* the most unseen weight of a point, and where */
};

struct unseen_outside {
    struct unseen_outside_blend all, now; /* of all probes of a cell; as it is */
    bool differ;                          /* the blend goes by what is seen */
    double lost;   /* share that sees no probe, of these and those that count */
    size_t points; /* that count */
};

/* Looks at so many points of the box; of the settings the seed, threads and judge count. Where the
 * scene's box has no volume, or cells are no tetrahedra, no point counts. */
struct error *unseen_outside(struct unseen_outside *outside, const struct tracer *tracer,
                             const struct baked *baked, const struct unseen_settings *settings,
                             size_t points);

/* Adds their figures, of `outside` as it is, of `outside-all-probes` where the blend goes by what
 * is seen. Nothing where no point counts. */
struct error *unseen_outside_report(struct report *report, const struct unseen_outside *outside);

#endif
