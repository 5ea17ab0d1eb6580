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
#include <stddef.h>

/* rho of a surface at the share t of the distance from which on nothing occludes: 0 at 0, 1 from 1
 * on. STEP 0 up to 1; LINEAR t; SQRT its root (Mendez-Feliu and Sbert, "From obscurances to ambient
 * occlusion", The Visual Computer 25, 2009); EXP (1 - e^-3t) / (1 - e^-3). */
enum occlusion_falloff { OCCLUSION_STEP, OCCLUSION_LINEAR, OCCLUSION_SQRT, OCCLUSION_EXP };
extern const char *const occlusion_falloff_names[]; /* NULL behind the last */

double occlusion_openness(enum occlusion_falloff falloff, double t);

/* Directions in which a surface's horizon is told. */
enum { OCCLUSION_AZIMUTHS = 8, OCCLUSION_AZIMUTHS_MOST = 64 };

/* What the rays so far add up to; starts at 0 but for the settings. */
struct occlusion {
    enum occlusion_falloff falloff;
    double distance; /* scene units; INFINITY: all surfaces occlude alike */
    size_t rays;
    double open;   /* sum of rho */
    double sum[3]; /* of rho times direction */
    /* Of occlusion_sort: rays by azimuth, and those of them that met a surface. */
    int all[OCCLUSION_AZIMUTHS_MOST], met[OCCLUSION_AZIMUTHS_MOST];
};

/* A ray along the unit direction, which met a surface at that distance (scene units); INFINITY:
 * none. */
void occlusion_add(struct occlusion *occlusion, struct vec3f direction, double distance);

/* Notes a ray of a surface by its azimuth, about its unit normal from the +X axis towards +Z where
 * the normal is +Y: from X, or where the normal is within 8 degrees of that, Z, as it lies in the
 * surface. met: it met a surface, at any distance. */
void occlusion_sort(struct occlusion *occlusion, struct vec3f normal, int azimuths,
                    struct vec3f direction, bool met);

/* The altitude of the horizon in radians above the surface, in sectors of equal width about the
 * azimuths 0, 1 / azimuths, ... of a turn: below it, as much of the sector's cosine is cut off as
 * of its rays, sin^2 of it. Where all that stands there rises from the surface, this is the horizon
 * (Max, "Horizon mapping", The Visual Computer 4, 1988), in the mean over the sector; the mean of
 * cos^2 of it is ambient occlusion, whatever stands there. */
void occlusion_horizon(const struct occlusion *occlusion, int azimuths, float *altitude);

/* The unit mean of directions, so weighted (eq. 11.10), and its length before it was made one: 1
 * where they all are one, 2/3 where a surface's whole half is open, 0 where a point's sphere is.
 * Both 0 where none is open. */
void occlusion_bent(const struct occlusion *occlusion, float normal[3], float *length);

/* The cone that is as open as what is, its axis the bent normal, and the cosine of its half angle.
 * About a point by the length l of the bent normal, cos = 2 l - 1, which is exact where a cone is
 * open (bent cone: Klehm, Ritschel, Eisemann and Seidel, "Bent normals and cones in screen-space",
 * VMV 2011). At a surface, where the cosine bends the axis towards the normal and shortens what is
 * aslant, by its k: a cone at the angle b from the normal has k = sin^2 cos b (ambient aperture:
 * Oat and Sander, "Ambient aperture lighting", I3D 2007), exact about the normal. normal: unit;
 * NULL for a point. 0, 0, 0 and 1 where nothing is open. */
void occlusion_cone(const struct occlusion *occlusion, const struct vec3f *normal, float cone[4]);

/* Ambient occlusion k with the light that occluders scatter, where they have the albedo of the
 * surface and are lit as it is: k / (1 - albedo (1 - k)), by channel (eq. 11.13; Stewart and
 * Langer, "Towards accurate recovery of shape from shading under diffuse lighting", PAMI 19,
 * 1997). */
void occlusion_bounced(float ao, const float albedo[3], float bounced[3]);

#endif
