/* SPDX-License-Identifier: Apache-2.0 */
/* patches: what of the surface each point of a set (poisson.h) stands for.
 *
 *     err = patches_measure(path.tracer, set.point, set.count, &settings, patch);
 *
 * Places of the scene's surface, even by area and on both of its sides, go to the nearest point
 * that faces alike, within 60 degrees, reaches them (within twice its radius, and no farther off
 * its plane than half of it) and sees them: what is dark beside a lit place, behind what keeps the
 * light away, is nobody's. Two that face apart, as on a ball, see each other over the surface
 * between them. Of cut-outs and blended surfaces, the share counts that is there.
 *
 * Areas sum to that of what is lit and covered by points; each is about places^-3/4 of it off.
 * The result is the same for any number of threads.
 */
#ifndef PATCHES_H
#define PATCHES_H

#include "math/vec.h"

#include <stddef.h>
#include <stdint.h>

struct error;
struct poisson_point;
struct tracer;

struct patch {
    float area;          /* units of the scene, squared; 0: no place was nearest to it */
    struct vec3f albedo; /* its mean, or of the point itself where the area is 0 */
};

struct patches_settings {
    int places; /* a point, of the surface's front, at least 1 */
    uint64_t seed;
    int threads;
};

/* patch: one a point, the caller's. A radius that is NaN is as large as the greatest of the others.
 * Error: memory, a signal (interrupt.h). */
struct error *patches_measure(const struct tracer *tracer, const struct poisson_point *point,
                              size_t count, const struct patches_settings *settings,
                              struct patch *patch);

#endif
