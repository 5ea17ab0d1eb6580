/* SPDX-License-Identifier: Apache-2.0 */
/* scatter: probes as points alone, without cells: the nearest one, and all within a radius.
 *
 * A tree of boxes over the probes along a Morton curve (volume.h). Read-only once made: threads
 * share it.
 */
#ifndef SCATTER_H
#define SCATTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scatter;

/* position: 3 a probe, which must outlive it; probes for which skip is true are not there. Error:
 * none is left. */
struct error *scatter_create(struct scatter **scatter, size_t probes, const double *position,
                             bool (*skip)(const void *context, size_t probe), const void *context);
void scatter_destroy(struct scatter *scatter);

/* The probe nearest to p, of equals the one with the lowest number, and its distance. */
int32_t scatter_nearest(const struct scatter *scatter, const double p[3], double *distance);

/* Twice the mean distance of a probe from the one nearest to it: a radius within which there are a
 * few. */
double scatter_spacing(const struct scatter *scatter);

/* Calls visit(context, probe, distance) for the probes nearer than radius to p, in an order that
 * does not depend on p's past. */
void scatter_within(const struct scatter *scatter, const double p[3], double radius,
                    void (*visit)(void *context, int32_t probe, double distance), void *context);

#endif
