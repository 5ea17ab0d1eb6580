/* Based on:
 * Kajiya, "The rendering equation", SIGGRAPH 1986.
 * Veach, "Robust Monte Carlo methods for light transport simulation", 1997, ch. 9 (balance heuristic).
 * Malley's method: cosine-distributed directions from a disc. Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
 */
#include "path.h"
#include "angle.h"
#include "array.h"
#include "error.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define PI 3.14159265f

struct path_sun {
    struct vec3f to_light, irradiance;
};

static struct error *add_suns(struct path_tracer *path)
{
    const struct scene *scene = path->tracer->scene;
    struct error *err = array_create(&path->suns, scene->light_count, sizeof *path->suns);
    for (size_t i = 0; i < scene->light_count && !err; i++) {
        const struct scene_light *l = &scene->lights[i];
        if (l->kind != SCENE_SUN || !(l->intensity[0] > 0 || l->intensity[1] > 0 || l->intensity[2] > 0))
            continue;
        path->suns[path->sun_count++] = (struct path_sun){
            {-(float)l->direction.x, -(float)l->direction.y, -(float)l->direction.z},
            {(float)l->intensity[0], (float)l->intensity[1], (float)l->intensity[2]}};
    }
    return err;
}

struct error *path_create(struct path_tracer *path, const struct tracer *tracer, int bounces)
{
    *path = (struct path_tracer){.tracer = tracer, .bounces = bounces};
    struct error *err = lights_create(&path->lights, tracer);
    for (size_t i = 0; i < path->lights.instance_count && !err; i++)
        path->emissive = path->emissive || path->lights.number[i];
    if (!err)
        err = sky_create(&path->sky, tracer->scene);
    if (!err)
        err = add_suns(path);
    if (err)
        path_clear(path);
    return err;
}

void path_clear(struct path_tracer *path)
{
    lights_clear(&path->lights);
    sky_clear(&path->sky);
    free(path->suns);
    path->suns = NULL;
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

/* -- asking lights and sky ---------------------------------------------------------------------- */

static bool on_surface(const struct lights_receiver *r)
{
    return r->normal.x != 0 || r->normal.y != 0 || r->normal.z != 0;
}

/* Density per solid angle of a receiver's own directions. */
static float own_density(const struct lights_receiver *r, struct vec3f direction)
{
    return on_surface(r) ? float_most(vec3f_dot(direction, r->normal), 0) / PI : 1 / (4 * PI);
}

/* Per solid angle from distance: per area times d^2 / cos. */
static float solid_density(float area_density, float distance, float cosine)
{
    return area_density * distance * distance / cosine;
}

/* Radiance of a drawn point of an emissive surface towards the receiver, over its density per solid angle, balanced with the
 * receiver's own directions; 0 where it is behind something or turned away. */
static struct path_found found_surface(const struct path_tracer *path, const struct lights_receiver *from, float share,
                                       struct lights_choice *choice, struct random *random)
{
    struct path_found found = {0};
    struct trace_point *point = &choice->point;
    const struct vec3f way = vec3f_sub(point->position, from->position);
    const float distance = vec3f_length(way);
    const uint32_t salt = draw_salt(path, random);
    if (!(distance > 0))
        return found;
    found.direction = vec3f_scale(1 / distance, way);
    const float cosine = -vec3f_dot(found.direction, point->normal);
    point->front = cosine > 0;
    point->distance = distance;
    const float own = own_density(from, found.direction);
    struct vec3f radiance = emitted(path, point);
    if (path->tracer->has_alpha) /* where the surface is not, it does not shine */
        radiance = vec3f_scale(1 - scene_transparency(path->tracer->scene, point->material, point->u, point->v), radiance);
    if (!(fabsf(cosine) > 0) || !(own > 0) || !(vec3f_most(radiance) > 0))
        return found;
    const float density = solid_density(choice->density, distance, fabsf(cosine));
    /* To just above the light, so that it does not shadow itself. */
    const struct vec3f target = trace_leave(point, vec3f_scale(cosine > 0 ? 1.0f : -1.0f, point->normal));
    const struct vec3f to_target = vec3f_sub(target, from->position);
    const float reach = vec3f_length(to_target);
    const struct trace_ray ray = {.origin = from->position, .direction = vec3f_scale(1 / reach, to_target), .most = reach, .salt = salt};
    if (!trace_local_occluded(path->tracer, &ray))
        found.light = vec3f_scale(1 / (share * density + own), radiance);
    return found;
}

/* The weight of emission that a ray of density `own` met, against found_surface. */
static float met_weight(const struct path_tracer *path, const struct lights_receiver *from, float share,
                        const struct trace_point *point, struct vec3f direction, float own)
{
    const float area_density = path->emissive ? lights_density(&path->lights, from, point) : 0;
    if (!(area_density > 0))
        return 1;
    const float cosine = fabsf(vec3f_dot(direction, point->normal));
    return own / (own + share * solid_density(area_density, point->distance, float_most(cosine, FLT_MIN)));
}

/* Radiance of the sky from a drawn direction over its density, balanced as above. */
static struct path_found found_sky(const struct path_tracer *path, const struct lights_receiver *from, float share, double x,
                                   double y, struct random *random)
{
    float density;
    struct path_found found = {.direction = sky_sample(&path->sky, x, y, &density)};
    const float own = own_density(from, found.direction);
    const struct trace_ray ray = {.origin = from->position, .direction = found.direction, .most = INFINITY, .salt = draw_salt(path, random)};
    if (own > 0 && density > 0 && !trace_local_occluded(path->tracer, &ray))
        found.light = vec3f_scale(1 / (share * density + own), scene_sky_radiance(path->tracer->scene, found.direction));
    return found;
}

static float sky_weight(const struct path_tracer *path, float share, struct vec3f direction, float own)
{
    return path->sky.rows ? own / (own + share * sky_density(&path->sky, direction)) : 1;
}

/* -- scattering -------------------------------------------------------------------------------- */

struct vec3f path_scatter(struct vec3f n, float u, float turn)
{
    const float r = sqrtf(u), z = sqrtf(1 - u);
    float x, y;
    angle_turn(turn, &x, &y);
    x *= r;
    y *= r;
    const float sign = n.z < 0 ? -1.0f : 1.0f, a = -1 / (sign + n.z), b = n.x * n.y * a;
    const struct vec3f s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, t = {b, sign + n.y * n.y * a, -n.y};
    return vec3f_add(vec3f_scale(x, s), vec3f_add(vec3f_scale(y, t), vec3f_scale(z, n)));
}

/* Irradiance over pi from a point or spot light that was drawn. */
static struct vec3f from_punctual(const struct path_tracer *path, const struct lights_receiver *from, const struct lights_choice *choice,
                                  struct random *random)
{
    const struct scene_light *light = choice->punctual;
    const struct vec3 p = trace_to_world(path->tracer, from->position);
    double direction[3], distance, rgb[3];
    scene_light_at(light, (const double[3]){p.x, p.y, p.z}, direction, &distance, rgb);
    const struct vec3f to_light = {(float)direction[0], (float)direction[1], (float)direction[2]};
    const struct vec3f e = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
    const float cosine = vec3f_dot(to_light, from->normal);
    const uint32_t salt = draw_salt(path, random);
    if (!(cosine > 0) || !(vec3f_most(e) > 0))
        return (struct vec3f){0};
    const struct trace_ray ray = {.origin = from->position, .direction = to_light, .most = (float)(distance * path->tracer->scale), .salt = salt};
    return trace_local_occluded(path->tracer, &ray) ? (struct vec3f){0} : vec3f_scale(cosine / (PI * choice->probability), e);
}

static struct vec3f from_suns(const struct path_tracer *path, const struct lights_receiver *from, struct random *random)
{
    struct vec3f sum = {0};
    for (size_t i = 0; i < path->sun_count; i++) {
        const struct path_sun *sun = &path->suns[i];
        const float cosine = vec3f_dot(sun->to_light, from->normal);
        if (!(cosine > 0))
            continue;
        const struct trace_ray ray = {.origin = from->position, .direction = sun->to_light, .most = INFINITY, .salt = draw_salt(path, random)};
        if (!trace_local_occluded(path->tracer, &ray))
            sum = vec3f_fma(sum, cosine / PI, sun->irradiance);
    }
    return sum;
}

/* Irradiance over pi on a surface from what is asked for light, without what its scattered ray is to meet. */
static struct vec3f lit(const struct path_tracer *path, const struct lights_receiver *from, struct random *random)
{
    struct vec3f sum = {0};
    if (path->lights.count) {
        struct lights_choice choice;
        const double x = random_double(random);
        const float y = random_float(random);
        if (!lights_sample(&path->lights, path->tracer, from, x, y, &choice)) {
            sum = (struct vec3f){0};
        } else if (choice.punctual) {
            sum = from_punctual(path, from, &choice, random);
        } else {
            const struct path_found found = found_surface(path, from, 1, &choice, random);
            sum = vec3f_scale(float_most(vec3f_dot(found.direction, from->normal), 0) / PI, found.light);
        }
    }
    if (path->sky.rows) {
        const double x = random_double(random), y = random_double(random);
        const struct path_found found = found_sky(path, from, 1, x, y, random);
        sum = vec3f_fma(sum, float_most(vec3f_dot(found.direction, from->normal), 0) / PI, found.light);
    }
    return path->sun_count ? vec3f_add(sum, from_suns(path, from, random)) : sum;
}

/* Radiance that a surface point, met along `incoming`, scatters back: one path. What a point is made of is asked only when it
 * has to be known, so that memory answers while rays are traced. */
static struct vec3f scattered(const struct path_tracer *path, const struct trace_point *met, struct vec3f incoming,
                              struct random *random)
{
    const struct scene *scene = path->tracer->scene;
    struct trace_point point = *met;
    struct vec3f sum = {0}, throughput = {1, 1, 1};
    for (int bounce = 1; bounce <= path->bounces; bounce++) {
        const struct vec3f n = vec3f_dot(point.normal, incoming) < 0 ? point.normal : vec3f_scale(-1, point.normal);
        const struct lights_receiver from = {.position = trace_leave(&point, n), .normal = n};
        const struct vec3f light = lit(path, &from, random);
        trace_point_shade(path->tracer, &point);
        const struct scene_texel texel = scene_texel_draw(scene, point.material, point.u, point.v, random_u32(random));
        const float u = random_float(random), turn = random_float(random);
        const struct vec3f direction = path_scatter(n, u, turn);
        const struct trace_ray ray = {.origin = from.position, .direction = direction, .most = INFINITY, .salt = draw_salt(path, random)};
        const bool hit = trace_local_nearest(path->tracer, &ray, &point);
        throughput = vec3f_mul(throughput, scene_texel_albedo(scene, &texel));
        sum = vec3f_add(sum, vec3f_mul(throughput, light));
        if (!hit) {
            const float weight = sky_weight(path, 1, direction, own_density(&from, direction));
            return vec3f_fma(sum, weight, vec3f_mul(throughput, scene_sky_radiance(scene, direction)));
        }
        if (path->emissive) {
            trace_point_shade(path->tracer, &point);
            const struct vec3f e = emitted(path, &point);
            if (vec3f_most(e) > 0) {
                const float weight = met_weight(path, &from, 1, &point, direction, own_density(&from, direction));
                sum = vec3f_fma(sum, weight, vec3f_mul(throughput, e));
            }
        }
        const float most = vec3f_most(throughput);
        if (!(most > 0))
            break;
        if (bounce >= 2 && most < 1) { /* Russian roulette */
            if (random_float(random) >= most)
                break;
            throughput = vec3f_scale(1 / most, throughput);
        }
        incoming = direction;
    }
    return sum;
}

/* -- receivers --------------------------------------------------------------------------------- */

struct path_sample path_sample(const struct path_tracer *path, const struct path_receiver *receiver, struct vec3f direction,
                               bool with_scattered, struct random *random)
{
    struct path_sample sample = {.weight = 1, .distance = INFINITY};
    struct trace_point point;
    const struct trace_ray ray = {.origin = receiver->at.position, .direction = direction, .most = INFINITY, .salt = draw_salt(path, random)};
    if (!trace_local_nearest(path->tracer, &ray, &point)) {
        sample.straight = scene_sky_radiance(path->tracer->scene, direction);
        sample.weight = sky_weight(path, receiver->sky_share, direction, own_density(&receiver->at, direction));
        return sample;
    }
    sample.hit = true;
    sample.front = point.front;
    sample.distance = point.distance;
    sample.normal = point.normal;
    if (with_scattered)
        sample.scattered = scattered(path, &point, direction, random);
    if (path->emissive) {
        trace_point_shade(path->tracer, &point);
        sample.straight = emitted(path, &point);
        if (vec3f_most(sample.straight) > 0)
            sample.weight = met_weight(path, &receiver->at, receiver->lights_share, &point, direction, own_density(&receiver->at, direction));
    }
    return sample;
}

struct path_found path_light(const struct path_tracer *path, const struct path_receiver *receiver, double x, float y, struct random *random)
{
    struct lights_choice choice;
    if (!lights_sample(&path->lights, path->tracer, &receiver->at, x, y, &choice) || choice.punctual)
        return (struct path_found){0};
    return found_surface(path, &receiver->at, receiver->lights_share, &choice, random);
}

struct path_found path_sky(const struct path_tracer *path, const struct path_receiver *receiver, double x, double y, struct random *random)
{
    return found_sky(path, &receiver->at, receiver->sky_share, x, y, random);
}
