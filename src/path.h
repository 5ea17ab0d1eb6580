/* path: the light that comes to a point, by path tracing.
 *
 * Unbiased Monte Carlo of the rendering equation for Lambertian surfaces (Kajiya 1986): cosine-distributed
 * continuation, next-event estimation of emissive surfaces and punctual lights at every scattering, multiple importance
 * sampling between the two ways to reach an emissive surface (Veach 1997, balance heuristic), Russian roulette by throughput.
 * Sky light arrives on rays that escape.
 */
#ifndef PATH_H
#define PATH_H

#include "light.h"
#include "random.h"

struct path_tracer {
    const struct tracer *tracer;
    struct lights lights;
    int bounces; /* how often a path may scatter */
};

/* One sample of what comes to a point along one direction of the sphere. */
struct path_sample {
    struct vec3f direct;   /* radiance of the emitter or sky that the ray meets, weighted against `light` */
    struct vec3f indirect; /* radiance that the surface there scatters towards the point */
    struct vec3f light;    /* radiance times solid angle of an emissive surface, from light_direction, weighted against `direct` */
    struct vec3f light_direction;
    bool hit, front;  /* what the ray met */
    float distance;   /* local units */
};

struct error *path_create(struct path_tracer *path, const struct tracer *tracer, int bounces);
void path_clear(struct path_tracer *path);

/* Samples from `origin` (local) along the unit `direction`, drawn uniformly over the sphere. The mean of
 * 4 pi Y(direction) (direct + indirect) + Y(light_direction) light over such samples is the incident radiance projected on Y, without
 * what comes straight from punctual lights. with_indirect false: indirect is 0, and costs nothing. */
struct path_sample path_sample(const struct path_tracer *path, struct vec3f origin, struct vec3f direction, bool with_indirect,
                               struct random *random);

#endif
