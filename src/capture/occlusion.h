/* SPDX-License-Identifier: Apache-2.0 */
/* occlusion: what a probe's rays tell of the surfaces that stand about it, apart from light.
 *
 * Ambient occlusion is the share of directions that are open, k_A of Akenine-Moeller et al.,
 * "Real-time rendering", 4th ed., eq. 11.8; obscurance (eq. 11.11) counts a direction in which a
 * surface is near for a part, rho. Rays are taken to be drawn so that each counts alike: by the
 * cosine about a surface's normal, or uniformly about a point.
 */
#ifndef OCCLUSION_H
#define OCCLUSION_H

#include "math/vec.h"

#include <stdbool.h>

/* rho of a surface at the share t of the distance from which on nothing occludes: 0 at 0, 1 from 1
 * on. STEP 0 up to 1; LINEAR t; SQRT its root (Mendez-Feliu and Sbert, "From obscurances to ambient
 * occlusion", The Visual Computer 25, 2009); EXP (1 - e^-3t) / (1 - e^-3). */
enum occlusion_falloff { OCCLUSION_STEP, OCCLUSION_LINEAR, OCCLUSION_SQRT, OCCLUSION_EXP };
extern const char *const occlusion_falloff_names[]; /* NULL behind the last */

double occlusion_openness(enum occlusion_falloff falloff, double t);

/* What the rays so far add up to; starts at 0 but for the settings. */
struct occlusion {
    enum occlusion_falloff falloff;
    double distance; /* scene units; INFINITY: all surfaces occlude alike */
    double open;     /* sum of rho */
    double sum[3];   /* of rho times direction */
};

/* A ray along the unit direction, which met a surface at that distance (scene units); INFINITY:
 * none. */
void occlusion_add(struct occlusion *occlusion, struct vec3f direction, double distance);

#endif
