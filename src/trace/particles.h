/* SPDX-License-Identifier: Apache-2.0 */
/* particles: light that is followed from where it is emitted to the surfaces that it reaches.
 *
 * Particles start at emissive surfaces (from both sides, unless the scene emits from the front
 * alone), point and spot lights, suns and the sky; suns and sky send theirs through a rectangle or
 * a disc as wide as the scene. Each light has particles in proportion to its power, in luminance,
 * and all particles of a light have about the same flux. At a surface a particle is scattered by
 * the cosine, or ends, with the chance that the surface absorbs light; where it goes on, its flux
 * is multiplied with albedo over that chance. So the flux of all hits within a region of surface
 * adds up, in the mean, to the light that falls on it.
 *
 * Their numbers are even (sobol.h) and named by seed and particle: the same hits in the same order
 * for any number of threads. Particles are numbered light by light; who takes them in turn and
 * wants all lights early takes every k-th.
 */
#ifndef PARTICLES_H
#define PARTICLES_H

#include "trace/lights.h"
#include "trace/sky.h"

struct error;

struct particles_settings {
    size_t count;   /* of particles; below 2^30 */
    int bounces;    /* hits that a particle has at most; at least 1 */
    bool suns_only; /* no other light sends any */
    /* Share of them that goes alike to each sun, the sky and all other lights together, so that a
     * lamp in a closed room gets its own beside the sun; the others go by power */
    double even;
    uint64_t seed;
    int threads;
};

struct particle_hit {
    struct vec3f position; /* local (trace_to_world) */
    struct vec3f normal;   /* unit, of the side that was met; the same in the world */
    struct vec3f flux; /* that arrives: irradiance of the lights' unit times area, local units^2 */
    uint32_t particle; /* whose hit it is */
    uint32_t bounce;   /* 1: straight from the light */
    uint32_t instance, triangle;
    float b, c; /* barycentric weights of the mesh's corners 1 and 2 */
};

struct particles {
    struct particle_hit *hit; /* owned; in order of particle / 64, bounce, particle */
    size_t count;
    size_t sent;    /* particles; 0: nothing shines */
    float sun_area; /* the most that a sun's particle stands for, across its way; local units^2 */
};

/* Nothing shines: no hits. */
struct error *particles_trace(const struct tracer *tracer, const struct lights *lights,
                              const struct sky *sky, const struct particles_settings *settings,
                              struct particles *particles);
void particles_clear(struct particles *particles);

#endif
