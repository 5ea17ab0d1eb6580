/* trace: rays against a scene (Embree), and the light they carry (path tracing).
 *
 * Rays are traced in float relative to a local origin, the centre of the scene's box, so that
 * a scene far from the world's origin loses nothing; callers speak world coordinates in double.
 * Embree runs with RTC_SCENE_FLAG_ROBUST and isa=avx (bytes agree between machines); meshes that
 * are placed many times are instances in Embree too. A ray that leaves a surface starts at the hit moved along
 * the geometric normal by 4 FLT_EPSILON max(|p|, t).
 *
 * Cut-outs: a ray passes a surface where its alpha is below the cut-off; blended surfaces let it
 * through with probability 1 - alpha for paths, and in proportion for visibility.
 *
 * A tracer is read-only once made: any number of threads may use it.
 */
#ifndef TRACE_H
#define TRACE_H

#include "vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct random;
struct scene;

struct tracer;

struct trace_hit {
    bool hit;
    double distance;      /* along the unit direction */
    struct vec3 position; /* on the surface */
    struct vec3 normal;   /* geometric, unit, towards the front (counter-clockwise) side */
    bool front;           /* the ray met the front side */
    size_t instance, triangle; /* of the scene; triangle of that instance's mesh */
    float u, v;           /* texture coordinates */
    int32_t material;
};

/* What light a path carries. ALL = DIRECT + INDIRECT; emitters and sky seen straight from the start count as direct, and so do point, spot and sun light. */
enum trace_light { TRACE_ALL, TRACE_DIRECT, TRACE_INDIRECT };

/* Builds the acceleration structure of a scene, which must outlive the tracer. */
struct error *trace_create(struct tracer **tracer, const struct scene *scene);
void trace_destroy(struct tracer *tracer);
const struct scene *trace_scene(const struct tracer *tracer);

/* The nearest surface from `origin` along the unit `direction`, no farther than `most` (INFINITY: no limit). skip_transparent: passes holes
 * of cut-outs and whatever is less than half opaque. Origin and direction must be finite. */
struct trace_hit trace_nearest(const struct tracer *tracer, const double origin[3], const double direction[3], double most,
                               bool skip_transparent);

/* The share of light that gets from a to b, by cut-outs and blends on the way: 0 when an opaque surface is between. */
float trace_visibility(const struct tracer *tracer, const double a[3], const double b[3]);

/* Distance to the nearest point of any surface, at most `most`. */
double trace_surface_distance(const struct tracer *tracer, const double p[3], double most);

/* One sample of the light that comes to `origin` from `direction`: the path's contribution to the incident radiance
 * from that direction, without punctual lights seen straight from the origin (they are deltas: see capture). Emitters and sky met by the
 * first ray count unless light is TRACE_INDIRECT. bounces: how often a path may scatter; Russian roulette ends it earlier, unbiased.
 * *first is what the first ray met. */
struct vec3f trace_radiance(const struct tracer *tracer, const double origin[3], const double direction[3],
                            enum trace_light light, int bounces, struct random *random, struct trace_hit *first);

#endif
