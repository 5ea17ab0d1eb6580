/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/shadow.h"
#include "math/luminance.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "trace/trace.h"

#include <math.h>

bool shadow_lit(const struct tracer *tracer, const struct scene_light *lamp, struct vec3 p)
{
    double from[3], to[3];
    vec3_store(from, p);
    vec3_store(to, lamp->kind == SCENE_SUN ? vec3_scale(-1, lamp->direction) : lamp->position);
    return (lamp->kind == SCENE_SUN ? trace_visibility_sky(tracer, from, to)
                                    : trace_visibility(tracer, from, to)) > 0.5f;
}

/* Luminance of what the lamp gives to p if nothing is in the way; *to_light: where it comes
 * from. */
static double shine(const struct scene_light *lamp, struct vec3 p, struct vec3 *to_light)
{
    double at[3], towards[3], distance, rgb[3];
    vec3_store(at, p);
    scene_light_at(lamp, at, towards, &distance, rgb);
    *to_light = vec3_load(towards);
    return luminance_f64(rgb);
}

/* The share of the edge's unit direction that is across the lamp's. */
static double across(struct vec3 direction, struct vec3 to_light)
{
    return vec3_length(vec3_cross(direction, to_light));
}

struct shadow_border shadow_find(const struct tracer *tracer, struct vec3 a, struct vec3 b,
                                 double graze, double precision)
{
    const struct scene *scene = trace_scene(tracer);
    const struct vec3 way = vec3_sub(b, a);
    const double length = vec3_length(way);
    const struct vec3 direction = vec3_scale(1 / length, way);
    struct shadow_border border = {0};
    double brightest = 0;
    for (size_t i = 0; i < scene->light_count; i++) {
        const struct scene_light *lamp = &scene->lights[i];
        struct vec3 to_a, to_b;
        const double bright = fmin(shine(lamp, a, &to_a), shine(lamp, b, &to_b));
        if (!(bright > brightest) ||
            !(fmin(across(direction, to_a), across(direction, to_b)) >= graze))
            continue;
        const bool lit = shadow_lit(tracer, lamp, a);
        if (lit == shadow_lit(tracer, lamp, b))
            continue;
        brightest = bright;
        border = (struct shadow_border){.lamp = lamp, .lit = lit};
    }
    double near = 0, far = length;
    while (border.lamp && far - near > 2 * precision) {
        const double middle = (near + far) / 2;
        if (shadow_lit(tracer, border.lamp, vec3_fma(a, middle, direction)) == border.lit)
            near = middle;
        else
            far = middle;
    }
    border.distance = (near + far) / 2;
    return border;
}
