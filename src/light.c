#include "light.h"
#include "array.h"
#include "error.h"
#include "random.h"

#include <stdlib.h>

struct light {
    uint32_t instance, triangle;
};

static float area(const struct tracer *t, uint32_t instance, uint32_t triangle)
{
    struct vec3f p[3];
    trace_corners(t, instance, triangle, p);
    return 0.5f * vec3f_length(vec3f_cross(vec3f_sub(p[1], p[0]), vec3f_sub(p[2], p[0])));
}

/* Luminance of a triangle's emission, averaged over a few points where it has a picture. */
static float emission(const struct tracer *t, uint32_t instance, uint32_t triangle)
{
    enum { STEPS = 4 };
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[instance].mesh];
    const struct scene_material *m = &t->scene->materials[mesh->material[triangle]];
    if (!scene_emits(m))
        return 0;
    if (m->emission_map.texture == SCENE_NONE)
        return vec3f_luminance(m->emission);
    float sum = 0;
    int points = 0;
    for (int i = 0; i < STEPS; i++) {
        for (int j = 0; j < STEPS - i; j++, points++) {
            struct trace_point p;
            trace_point_at(t, instance, triangle, ((float)i + 1.0f / 3) / STEPS, ((float)j + 1.0f / 3) / STEPS, &p);
            sum += vec3f_luminance(scene_emission(t->scene, m, p.u, p.v));
        }
    }
    /* A picture may shine between the points: a share of what it could give keeps every triangle in the draw. */
    return 0.95f * sum / (float)points + 0.05f * vec3f_luminance(m->emission);
}

/* Weighs the triangles of one instance: adds those that give light. */
static struct error *add_instance(struct lights *lights, const struct tracer *t, uint32_t instance, size_t *capacity, double *total)
{
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[instance].mesh];
    struct error *err = NULL;
    for (uint32_t i = 0; i < mesh->triangle_count && !err; i++) {
        const float brightness = emission(t, instance, i);
        const float power = brightness > 0 ? brightness * area(t, instance, i) : 0;
        if (!(power > 0))
            continue;
        size_t room = *capacity;
        err = array_reserve(&lights->light, &room, lights->count + 1, sizeof *lights->light);
        if (!err)
            err = array_reserve(&lights->cumulative, capacity, lights->count + 1, sizeof *lights->cumulative);
        if (!err && !lights->density[instance])
            err = array_create(&lights->density[instance], mesh->triangle_count, sizeof(float));
        if (err)
            break;
        *total += (double)power;
        lights->light[lights->count] = (struct light){instance, i};
        lights->cumulative[lights->count++] = *total;
        lights->density[instance][i] = brightness; /* share of power over area: to be divided by the total */
    }
    return err;
}

struct error *lights_create(struct lights *lights, const struct tracer *t)
{
    *lights = (struct lights){.instance_count = t->scene->instance_count};
    size_t capacity = 0;
    double total = 0;
    struct error *err = array_create(&lights->density, t->scene->instance_count, sizeof *lights->density);
    for (size_t i = 0; i < t->scene->instance_count && !err; i++)
        err = add_instance(lights, t, (uint32_t)i, &capacity, &total);
    if (err) {
        lights_clear(lights);
        return err;
    }
    for (size_t i = 0; i < lights->count; i++) {
        const struct light l = lights->light[i];
        lights->cumulative[i] /= total;
        lights->density[l.instance][l.triangle] = (float)((double)lights->density[l.instance][l.triangle] / total);
    }
    return NULL;
}

void lights_clear(struct lights *lights)
{
    for (size_t i = 0; lights->density && i < lights->instance_count; i++)
        free(lights->density[i]);
    free(lights->density);
    free(lights->light);
    free(lights->cumulative);
    *lights = (struct lights){0};
}

void lights_sample(const struct lights *lights, const struct tracer *tracer, struct random *random,
                   struct trace_point *point, float *density)
{
    const double x = random_double(random);
    size_t low = 0, high = lights->count - 1;
    while (low < high) { /* the first whose cumulative share is above x */
        const size_t middle = low + (high - low) / 2;
        if (lights->cumulative[middle] > x)
            high = middle;
        else
            low = middle + 1;
    }
    /* Uniform in the triangle (Turk, "Generating random points in triangles", Graphics Gems, 1990). */
    const float r = sqrtf(random_float(random)), s = random_float(random);
    trace_point_at(tracer, lights->light[low].instance, lights->light[low].triangle, r * (1 - s), r * s, point);
    *density = lights->density[lights->light[low].instance][lights->light[low].triangle];
}

float lights_density(const struct lights *lights, const struct trace_point *point)
{
    const float *density = lights->density[point->instance];
    return density ? density[point->triangle] : 0;
}
