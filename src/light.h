/* light: a point on an emissive surface, chosen by how much light it gives.
 *
 * For next-event estimation: lights_sample draws a point on an emissive triangle with probability proportional to the
 * triangle's area times the luminance of its emission, uniformly within it. lights_density is the density of that
 * choice, for multiple importance sampling. A scene without emissive surfaces has no lights, and pays for none.
 */
#ifndef LIGHT_H
#define LIGHT_H

#include "trace_local.h"

struct error;
struct random;

struct lights {
    size_t count;
    struct light *light;  /* emissive triangles that give light; owned */
    double *cumulative;   /* of their shares, last is 1; owned */
    float **density;      /* by instance: NULL, or by triangle the density per area (local units); owned */
    size_t instance_count;
};

struct error *lights_create(struct lights *lights, const struct tracer *tracer);
void lights_clear(struct lights *lights);

/* Draws a point; *density: per area, local units. Needs count > 0. */
void lights_sample(const struct lights *lights, const struct tracer *tracer, struct random *random,
                   struct trace_point *point, float *density);

/* The density with which lights_sample draws this point; 0 for one that it never draws. */
float lights_density(const struct lights *lights, const struct trace_point *point);

#endif
