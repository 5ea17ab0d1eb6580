/* SPDX-License-Identifier: Apache-2.0 */
#include "place/exposed.h"
#include "base/array.h"
#include "base/error.h"
#include "math/direction.h"
#include "math/random.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "trace/particles.h"
#include "trace/trace_local.h"

#include <math.h>
#include <stdlib.h>

/* What places' random numbers are named by. */
#define NAME UINT64_C(0x6578706f73656400)

static double triangle_area(const struct scene_mesh *mesh, size_t triangle, const double m[12])
{
    struct vec3 corner[3];
    for (size_t c = 0; c < 3; c++) {
        const struct vec3 p = vec3_load(mesh->position + 3 * mesh->index[3 * triangle + c]);
        corner[c] = (struct vec3){m[0] * p.x + m[1] * p.y + m[2] * p.z,
                                  m[4] * p.x + m[5] * p.y + m[6] * p.z,
                                  m[8] * p.x + m[9] * p.y + m[10] * p.z};
    }
    return vec3_length(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0]))) /
           2;
}

struct error *exposed_init(struct exposed *e, const struct tracer *tracer)
{
    const struct scene *scene = tracer->scene;
    *e = (struct exposed){.tracer = tracer};
    struct error *err = array_create(&e->first, scene->instance_count + 1, sizeof *e->first);
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        e->first[i + 1] = e->first[i] + scene->meshes[scene->instances[i].mesh].triangle_count;
    if (!err)
        err = array_create(&e->sum, e->first[scene->instance_count], sizeof *e->sum);
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        for (size_t k = e->first[i]; k < e->first[i + 1]; k++) {
            e->area += triangle_area(&scene->meshes[scene->instances[i].mesh], k - e->first[i],
                                     scene->instances[i].transform);
            e->sum[k] = e->area;
        }
    return err;
}

void exposed_clear(struct exposed *e)
{
    free(e->sum);
    free(e->first);
    *e = (struct exposed){0};
}

/* The number of the first of `count` ascending ones that is above x; the last, if none is. */
static size_t find_double(const double *of, size_t count, double x)
{
    size_t low = 0;
    for (size_t high = count - 1; low < high;) {
        const size_t middle = low + (high - low) / 2;
        if (of[middle] > x)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static size_t instance_of(const struct exposed *e, size_t triangle)
{
    size_t low = 0;
    for (size_t high = e->tracer->scene->instance_count; high - low > 1;) {
        const size_t middle = low + (high - low) / 2;
        if (e->first[middle] <= triangle)
            low = middle;
        else
            high = middle;
    }
    return low;
}

size_t exposed_triangle(const struct exposed *e, double area, uint32_t *instance,
                        uint32_t *triangle)
{
    const size_t number = find_double(e->sum, e->first[e->tracer->scene->instance_count], area),
                 of = instance_of(e, number);
    *instance = (uint32_t)of;
    *triangle = (uint32_t)(number - e->first[of]);
    return number;
}

/* The k-th sun's direction to it; false: there are not so many. */
static bool to_sun(const struct scene *scene, size_t k, struct vec3f *to)
{
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind == SCENE_SUN && !k--) {
            const struct vec3 d = scene->lights[i].direction;
            *to = (struct vec3f){-(float)d.x, -(float)d.y, -(float)d.z};
            return true;
        }
    return false;
}

/* A place, and the ray from there to the light that may see it; false: none does. */
static bool choose(const struct exposed *e, size_t i, uint64_t seed, struct trace_rays *rays,
                   size_t lane, struct particle_hit *hit)
{
    const struct tracer *tracer = e->tracer;
    const struct scene *scene = tracer->scene;
    struct random r = random_start(seed, NAME, (uint32_t)i);
    uint32_t instance, triangle;
    exposed_triangle(e, random_double(&r) * e->area, &instance, &triangle);
    const float root = sqrtf(random_float(&r)), b = root * (1 - random_float(&r));
    struct trace_point point;
    struct vec3f to = {0};
    size_t suns = 0;
    while (to_sun(scene, suns, &to))
        suns++;
    trace_point_at(tracer, instance, triangle, b, root - b, &point);
    const bool sun = to_sun(scene, i % (suns + 1), &to);
    const float u = random_float(&r), turn = random_float(&r);
    const bool front = sun ? vec3f_dot(to, point.normal) > 0 : random_u32(&r) & 1;
    const struct vec3f n = vec3f_scale(front ? 1.0f : -1.0f, point.normal);
    if (!sun)
        to = direction_by_cosine(n, u, turn);
    if (tracer->has_alpha && random_float(&r) < trace_point_transparency(tracer, &point))
        return false;
    wave_put(&rays->origin, lane, trace_leave(point.position, 4 * (float)tracer->extent, n));
    wave_put(&rays->direction, lane, to);
    rays->most[lane] = INFINITY;
    rays->salt[lane] = tracer->has_alpha ? random_u32(&r) : 0;
    *hit = (struct particle_hit){.position = point.position,
                                 .normal = n,
                                 .instance = point.instance,
                                 .triangle = point.triangle,
                                 .b = point.b,
                                 .c = point.c};
    return sun || vec3f_most(scene_sky_radiance(scene, to)) > 0;
}

struct error *exposed_add(const struct exposed *e, size_t count, uint64_t seed,
                          struct particles *particles)
{
    size_t capacity = particles->count;
    struct error *err =
        array_reserve(&particles->hit, &capacity, particles->count + count, sizeof *particles->hit);
    if (err || !(e->area > 0))
        return err;
    for (size_t i = 0; i < count;) {
        struct trace_rays rays;
        struct particle_hit hit[TRACE_WAVE];
        int32_t seen[TRACE_WAVE];
        size_t asked = 0;
        for (; i < count && asked < TRACE_WAVE; i++)
            asked += choose(e, i, seed, &rays, asked, &hit[asked]);
        for (size_t k = 0; k < asked; k++)
            seen[k] = 1;
        trace_rays_occluded(e->tracer, asked, &rays, seen);
        for (size_t k = 0; k < asked; k++)
            if (seen[k])
                particles->hit[particles->count++] = hit[k];
    }
    return NULL;
}
