/* SPDX-License-Identifier: Apache-2.0 */
/* trace: rays against a scene (Embree).
 *
 * Rays are traced in float relative to a local origin, the centre of the scene's box, at a
 * power-of-two scale that brings the box near 1, so that a scene far from the world's origin, or of
 * any size, loses nothing; callers speak world coordinates in double. Where pieces of a scene are
 * small beside the space between them, each has an origin of its own and all of the scene about it
 * (frames.h): what is far is coarse, what is near is not. Embree runs with
 * RTC_SCENE_FLAG_ROBUST and isa=avx (bytes agree between machines); meshes that are placed many
 * times are instances in Embree too.
 *
 * Cut-outs: a ray passes a surface where its alpha is below the cut-off. Blended surfaces let light
 * through in proportion. Scenes without either pay nothing for them.
 *
 * A tracer is read-only once made: any number of threads may use it.
 */
#ifndef TRACE_H
#define TRACE_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;
struct scene_solids;
struct tracer;

struct trace_hit {
    bool hit;
    double distance;           /* along the unit direction */
    struct vec3 position;      /* on the surface */
    struct vec3 normal;        /* geometric, unit, of the front (counter-clockwise) side */
    bool front;                /* the ray met the front side */
    size_t instance, triangle; /* of the scene; triangle of that instance's mesh */
};

/* Builds the acceleration structure of a scene, which must outlive the tracer. */
struct error *trace_create(struct tracer **tracer, const struct scene *scene);
void trace_destroy(struct tracer *tracer);
const struct scene *trace_scene(const struct tracer *tracer);

/* What of the scene is closed (solids.h), made when it is first asked for; the tracer's. */
struct error *trace_solids(const struct tracer *tracer, const struct scene_solids **solids);

/* The nearest surface from `origin` along the unit `direction` (both finite), no farther than
 * `most` (INFINITY: no limit). Passes holes of cut-outs; a blended surface counts when it is more
 * than half opaque. */
struct trace_hit trace_nearest(const struct tracer *tracer, const double origin[3],
                               const double direction[3], double most);

/* The share of light that gets from a to b (finite): 0 when an opaque surface is between, products
 * of transparency else. */
float trace_visibility(const struct tracer *tracer, const double a[3], const double b[3]);

/* The share of light that comes to a along the unit direction from infinity. */
float trace_visibility_sky(const struct tracer *tracer, const double a[3],
                           const double direction[3]);

/* The distance from p (finite) to the nearest surface, whatever it lets through; INFINITY in a
 * scene without any. */
double trace_distance(const struct tracer *tracer, const double p[3]);

/* Whether a surface is nearer to p (finite) than that, which costs less. */
bool trace_is_near(const struct tracer *tracer, const double p[3], double distance);

#endif
