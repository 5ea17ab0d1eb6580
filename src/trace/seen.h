/* SPDX-License-Identifier: Apache-2.0 */
/* seen: the probes of a blend that a point sees, by a ray to each in the scene itself.
 *
 * The probes that the point cannot see are dropped from the blend, and the others' weights divided
 * by what is left. Where none of them is seen, the point is blind: the nearest probe around that it
 * sees answers alone. It is exact, and costs up to four rays a point: what visibility that a stream
 * keeps can be held against.
 *
 *     err = seen_create(&seen, tracer, probes, position, light, width);
 *     seen_look(tracer, position, p, &place, &look);
 *     seen_blend(seen, p, &look, &place);
 */
#ifndef SEEN_H
#define SEEN_H

#include "libprobe-query/probe-query.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct interpolate;
struct seen;
struct tracer;

/* position: 3 a probe; light: the first of `width` values a probe, NaN where it has none: such a
 * probe answers for no blind point; NULL: none is known of any, and all may. Both, and the tracer,
 * are borrowed. Read-only once it is
 * there: threads share it. */
struct error *seen_create(struct seen **seen, const struct tracer *tracer, size_t probes,
                          const double *position, const float *light, size_t width);
void seen_destroy(struct seen *seen); /* NULL is legal */

struct seen_look {
    double visible[4]; /* share of light that gets from the point to each probe; 0 without weight */
    double share;      /* of weight from probes that are seen: sum w v */
    double unseen;     /* of weight from those that are not: sum w (1 - v) */
    bool blind;        /* it sees none of them */
};

/* Looks from p for the probes of its place that have weight. */
void seen_look(const struct tracer *tracer, const double *position, const double p[3],
               const struct probe_place *place, struct seen_look *look);

/* The same where `known` was looked from p before: no ray goes to a probe twice. */
void seen_look_again(const struct tracer *tracer, const double *position, const double p[3],
                     const struct probe_place *known, const struct seen_look *seen,
                     const struct probe_place *place, struct seen_look *look);

/* The nearest probe that p sees within four times scatter_spacing, of equals the one with the
 * lowest number; -1: it sees none there. Any thread. */
int32_t seen_nearest(const struct seen *seen, const double p[3]);

/* The mean distance of a probe from the one nearest to it. */
double seen_spacing(const struct seen *seen);

/* The place with the weights of what is seen. A blind point has all of the weight from the nearest
 * probe that it sees around (seen_nearest); where there is none, in matter, the place stays as it
 * is. */
void seen_blend(const struct seen *seen, const double p[3], const struct seen_look *look,
                struct probe_place *place);

/* Makes one of an interpolation's probes and has it take its light from what is seen; it must
 * outlive the interpolation. Error: interpolate_set_sight's. */
struct error *seen_join(struct seen **seen, const struct tracer *tracer, size_t probes,
                        struct interpolate *in);

#endif
