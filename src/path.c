/* Based on:
 * Kajiya, "The rendering equation", SIGGRAPH 1986.
 * Veach, "Robust Monte Carlo methods for light transport simulation", 1997, ch. 9 (balance heuristic).
 * Malley's method: cosine-distributed directions from a disc. Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
 */
#include "path.h"
#include "angle.h"
#include "error.h"

#include <float.h>
#include <math.h>

#define PI 3.14159265f

struct error *path_create(struct path_tracer *path, const struct tracer *tracer, int bounces)
{
    *path = (struct path_tracer){.tracer = tracer, .bounces = bounces};
    return lights_create(&path->lights, tracer);
}

void path_clear(struct path_tracer *path)
{
    lights_clear(&path->lights);
}

static uint32_t draw_salt(const struct path_tracer *path, struct random *random)
{
    return path->tracer->has_alpha ? random_u32(random) : 0;
}

/* Radiance that a surface emits towards where it is seen from. */
static struct vec3f emitted(const struct path_tracer *path, const struct trace_point *point)
{
    if (!scene_emits(point->material) || (path->tracer->scene->emit_front_only && !point->front))
        return (struct vec3f){0};
    return scene_emission(path->tracer->scene, point->material, point->u, point->v);
}

/* -- emissive surfaces ------------------------------------------------------------------------- */

/* A way to an emissive surface: what it gives, and how likely it is drawn per solid angle. */
struct connection {
    struct vec3f direction; /* unit, towards the light */
    struct vec3f radiance;  /* 0 when the light is behind something or turned away */
    float density;
};

/* Per solid angle from distance: per area times d^2 / cos. */
static float solid_density(float area_density, float distance, float cosine)
{
    return area_density * distance * distance / cosine;
}

/* Draws a point of an emissive surface and looks whether it is seen from `from`, on the side of `normal` (zero: any side). */
static struct connection connect(const struct path_tracer *path, struct vec3f from, struct vec3f normal, struct random *random)
{
    struct connection c = {0};
    struct trace_point point;
    float area_density;
    lights_sample(&path->lights, path->tracer, random, &point, &area_density);
    const uint32_t salt = draw_salt(path, random);
    const struct vec3f way = vec3f_sub(point.position, from);
    const float distance = vec3f_length(way);
    if (!(distance > 0))
        return c;
    c.direction = vec3f_scale(1 / distance, way);
    const float cosine = -vec3f_dot(c.direction, point.normal);
    point.front = cosine > 0;
    point.distance = distance;
    const float facing = vec3f_dot(c.direction, normal);
    struct vec3f radiance = emitted(path, &point);
    if (path->tracer->has_alpha) /* where the surface is not, it does not shine */
        radiance = vec3f_scale(1 - scene_transparency(path->tracer->scene, point.material, point.u, point.v), radiance);
    if (!(fabsf(cosine) > 0) || facing < 0 || !(vec3f_luminance(radiance) > 0))
        return c;
    c.density = solid_density(area_density, distance, fabsf(cosine));
    /* To just above the light, so that it does not shadow itself. */
    const struct vec3f target = trace_leave(&point, vec3f_scale(cosine > 0 ? 1.0f : -1.0f, point.normal));
    const struct vec3f to_target = vec3f_sub(target, from);
    const float reach = vec3f_length(to_target);
    const struct trace_ray ray = {.origin = from, .direction = vec3f_scale(1 / reach, to_target), .most = reach, .salt = salt};
    if (!trace_local_occluded(path->tracer, &ray))
        c.radiance = radiance;
    return c;
}

/* The weight of light that a ray met by itself with `density` per solid angle, against connect. */
static float met_weight(const struct path_tracer *path, const struct trace_point *point, struct vec3f direction, float density)
{
    const float area_density = path->lights.count ? lights_density(&path->lights, point) : 0;
    const float cosine = fabsf(vec3f_dot(direction, point->normal));
    if (!(area_density > 0))
        return 1;
    return density / (density + solid_density(area_density, point->distance, fmaxf(cosine, FLT_MIN)));
}

/* -- scattering -------------------------------------------------------------------------------- */

/* A cosine-distributed direction about a unit normal. */
static struct vec3f scatter(struct vec3f n, struct random *random)
{
    const float u = random_float(random), turn = random_float(random);
    const float r = sqrtf(u), z = sqrtf(1 - u);
    const double phi = 2 * ANGLE_PI * (double)turn;
    const float x = r * (float)angle_cos(phi), y = r * (float)angle_sin(phi);
    const float sign = n.z < 0 ? -1.0f : 1.0f, a = -1 / (sign + n.z), b = n.x * n.y * a;
    const struct vec3f s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, t = {b, sign + n.y * n.y * a, -n.y};
    return vec3f_add(vec3f_scale(x, s), vec3f_add(vec3f_scale(y, t), vec3f_scale(z, n)));
}

/* Irradiance from punctual light i on a surface at `from` (local) that faces it, unoccluded. */
static struct vec3f punctual_irradiance(const struct tracer *t, size_t i, struct vec3f from, struct vec3f *to_light)
{
    const struct vec3 p = trace_to_world(t, from);
    double direction[3], distance, rgb[3];
    scene_light_at(&t->scene->lights[i], (const double[3]){p.x, p.y, p.z}, direction, &distance, rgb);
    *to_light = (struct vec3f){(float)direction[0], (float)direction[1], (float)direction[2]};
    return (struct vec3f){(float)rgb[0], (float)rgb[1], (float)rgb[2]};
}

/* What punctual lights give a surface at `from` with unit normal n: irradiance over pi. */
static struct vec3f punctual_at(const struct path_tracer *path, struct vec3f from, struct vec3f n, struct random *random)
{
    struct vec3f sum = {0};
    for (size_t i = 0; i < path->tracer->scene->light_count; i++) {
        struct vec3f to_light;
        const struct vec3f e = punctual_irradiance(path->tracer, i, from, &to_light);
        const float cosine = vec3f_dot(to_light, n);
        if (!(cosine > 0) || !(vec3f_luminance(e) > 0))
            continue;
        const struct scene_light *light = &path->tracer->scene->lights[i];
        struct trace_ray ray = {.origin = from, .direction = to_light, .most = INFINITY, .salt = draw_salt(path, random)};
        if (light->kind != SCENE_SUN) {
            const double world[3] = {light->position.x, light->position.y, light->position.z};
            ray.most = vec3f_length(vec3f_sub(trace_to_local(path->tracer, world), from));
        }
        if (!trace_local_occluded(path->tracer, &ray))
            sum = vec3f_fma(sum, cosine / PI, e);
    }
    return sum;
}

/* Radiance that a surface point, met along `incoming`, scatters back: one path. */
static struct vec3f scattered(const struct path_tracer *path, struct trace_point point, struct vec3f incoming,
                              struct random *random)
{
    const struct scene *scene = path->tracer->scene;
    struct vec3f sum = {0}, throughput = {1, 1, 1};
    for (int bounce = 1; bounce <= path->bounces; bounce++) {
        const struct vec3f n = vec3f_dot(point.normal, incoming) < 0 ? point.normal : vec3f_scale(-1, point.normal);
        throughput = vec3f_mul(throughput, scene_albedo(scene, point.material, point.u, point.v));
        const float most = fmaxf(throughput.x, fmaxf(throughput.y, throughput.z));
        if (!(most > 0))
            break;
        if (bounce > 2 && most < 1) { /* Russian roulette */
            if (random_float(random) >= most)
                break;
            throughput = vec3f_scale(1 / most, throughput);
        }
        const struct vec3f from = trace_leave(&point, n);
        sum = vec3f_add(sum, vec3f_mul(throughput, punctual_at(path, from, n, random)));
        if (path->lights.count) {
            const struct connection c = connect(path, from, n, random);
            const float density = vec3f_dot(c.direction, n) / PI; /* of scatter */
            if (c.density > 0 && density > 0)
                sum = vec3f_add(sum, vec3f_scale(density / (c.density + density), vec3f_mul(throughput, c.radiance)));
        }
        const struct vec3f direction = scatter(n, random);
        const struct trace_ray ray = {.origin = from, .direction = direction, .most = INFINITY, .salt = draw_salt(path, random)};
        if (!trace_local_nearest(path->tracer, &ray, &point)) {
            sum = vec3f_add(sum, vec3f_mul(throughput, scene_sky_radiance(scene, direction)));
            break;
        }
        const struct vec3f e = emitted(path, &point);
        if (vec3f_luminance(e) > 0) {
            const float weight = met_weight(path, &point, direction, fmaxf(vec3f_dot(direction, n), 0) / PI);
            sum = vec3f_add(sum, vec3f_scale(weight, vec3f_mul(throughput, e)));
        }
        incoming = direction;
    }
    return sum;
}

struct path_sample path_sample(const struct path_tracer *path, struct vec3f origin, struct vec3f direction, bool with_indirect,
                               struct random *random)
{
    const float sphere = 1 / (4 * PI); /* density of the direction */
    struct path_sample sample = {0};
    if (path->lights.count) {
        const struct connection c = connect(path, origin, (struct vec3f){0}, random);
        if (c.density > 0) {
            sample.light = vec3f_scale(1 / (c.density + sphere), c.radiance);
            sample.light_direction = c.direction;
        }
    }
    struct trace_point point;
    const struct trace_ray ray = {.origin = origin, .direction = direction, .most = INFINITY, .salt = draw_salt(path, random)};
    if (!trace_local_nearest(path->tracer, &ray, &point)) {
        sample.direct = scene_sky_radiance(path->tracer->scene, direction);
        return sample;
    }
    sample.hit = true;
    sample.front = point.front;
    sample.distance = point.distance;
    const struct vec3f e = emitted(path, &point);
    if (vec3f_luminance(e) > 0)
        sample.direct = vec3f_scale(met_weight(path, &point, direction, sphere), e);
    if (with_indirect)
        sample.indirect = scattered(path, point, direction, random);
    return sample;
}
