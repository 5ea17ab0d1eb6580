/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Kajiya, "The rendering equation", SIGGRAPH 1986.
 * Veach, "Robust Monte Carlo methods for light transport simulation", 1997, ch. 9 (balance
 * heuristic).
 */
#include "trace/path.h"
#include "base/array.h"
#include "base/error.h"
#include "base/once.h"
#include "interpolate/discs.h"
#include "math/angle.h"
#include "scene/scene_shade.h"
#include "trace/lit.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct path_sun {
    struct vec3f to_light, irradiance;
    size_t light; /* of the scene */
};

static struct error *add_suns(struct path_tracer *path)
{
    const struct scene *scene = path->tracer->scene;
    struct error *err = array_create(&path->suns, scene->light_count, sizeof *path->suns);
    for (size_t i = 0; i < scene->light_count && !err; i++) {
        const struct scene_light *l = &scene->lights[i];
        if (l->kind != SCENE_SUN ||
            !(l->intensity[0] > 0 || l->intensity[1] > 0 || l->intensity[2] > 0))
            continue;
        path->suns[path->sun_count++] = (struct path_sun){
            {-(float)l->direction.x, -(float)l->direction.y, -(float)l->direction.z},
            {(float)l->intensity[0], (float)l->intensity[1], (float)l->intensity[2]},
            i};
    }
    return err;
}

/* Makes all that is asked for: lights, sky, suns. */
static struct error *start(void *context)
{
    struct path_tracer *path = context;
    const struct scene_sky *sky = &path->tracer->scene->sky;
    path->sky_shines = sky->picture || sky->radiance[0] > 0 || sky->radiance[1] > 0 ||
                       sky->radiance[2] > 0;
    struct error *err = lights_init(&path->lights, path->tracer);
    for (size_t i = 0; i < path->lights.instance_count && !err; i++)
        path->emissive = path->emissive || path->lights.number[i];
    if (!err)
        err = sky_init(&path->sky, path->tracer->scene);
    return err ? err : add_suns(path);
}

struct error *path_init(struct path_tracer *path, const struct tracer *tracer, int bounces)
{
    *path = (struct path_tracer){.tracer = tracer, .bounces = bounces};
    struct path_tracer *last = path;
    struct error *err = start(path);
    for (const struct tracer *t = tracer->next; t && !err; t = t->next) {
        err = array_create(&last->next, 1, sizeof *last->next);
        if (!err) {
            last = last->next;
            *last = (struct path_tracer){.tracer = t, .bounces = bounces};
            err = once_create(&last->started);
        }
    }
    if (err)
        path_clear(path);
    return err;
}

struct error *path_near(const struct path_tracer *paths, const double p[3],
                        const struct path_tracer **near)
{
    const struct tracer *tracer;
    struct error *err = trace_find_near(paths->tracer, p, &tracer);
    *near = paths;
    if (err || tracer == paths->tracer)
        return err;
    struct path_tracer *path = paths->next;
    while (path->tracer != tracer)
        path = path->next;
    *near = path;
    return once_do(path->started, start, path);
}

void path_use_cache(struct path_tracer *path, const struct path_cache *cache)
{
    for (; path; path = path->next)
        path->cache = cache;
}

void path_use_split(struct path_tracer *path, const struct split *split)
{
    for (; path; path = path->next)
        path->split = split;
}

void path_use_lit(struct path_tracer *path, const struct lit *lit)
{
    for (; path; path = path->next)
        path->lit = lit;
}

void path_clear(struct path_tracer *path)
{
    lights_clear(&path->lights);
    sky_clear(&path->sky);
    free(path->suns);
    once_destroy(path->started);
    path->started = NULL;
    path->suns = NULL;
    if (path->next)
        path_clear(path->next);
    free(path->next);
    path->next = NULL;
}

/* -- random numbers --------------------------------------------------------------------------- */

/* The generators of a wave's paths. */
struct wave_random {
    uint32_t state[4][PATH_WAVE];
};

static void random_put(struct wave_random *r, size_t i, const struct random *random)
{
    for (int k = 0; k < 4; k++)
        r->state[k][i] = random->state[k];
}

static inline uint32_t draw(struct wave_random *r, size_t i)
{
    struct random one = {{r->state[0][i], r->state[1][i], r->state[2][i], r->state[3][i]}};
    const uint32_t bits = random_u32(&one);
    random_put(r, i, &one);
    return bits;
}

TRACE_VECTORS static void draw_bits(struct wave_random *r, size_t count, uint32_t *bits)
{
    for (size_t i = 0; i < count; i++)
        bits[i] = draw(r, i);
}

/* As random_float. */
TRACE_VECTORS static void draw_floats(struct wave_random *r, size_t count, float *x)
{
    for (size_t i = 0; i < count; i++)
        x[i] = (float)(int32_t)(draw(r, i) >> 8) * 0x1p-24f;
}

/* As random_double. */
TRACE_VECTORS static void draw_doubles(struct wave_random *r, size_t count, double *x)
{
    for (size_t i = 0; i < count; i++)
        x[i] = (double)(int32_t)(draw(r, i) >> 5) * 0x1p-27;
    for (size_t i = 0; i < count; i++)
        x[i] += (double)(int32_t)(draw(r, i) >> 6) * 0x1p-53;
}

/* What tells blended surfaces which rays they let through. */
static void draw_salts(const struct path_tracer *path, struct wave_random *r, size_t count,
                       uint32_t *salt)
{
    if (path->tracer->has_alpha)
        draw_bits(r, count, salt);
    else
        memset(salt, 0, count * sizeof *salt);
}

/* -- asking lights and sky -------------------------------------------------------------------- */

/* Where a wave asks from. */
struct receivers {
    size_t count;
    const struct wave_vec *position;
    const struct wave_vec *normal; /* NULL: points, which take light from the whole sphere */
    float share;                   /* questions for each direction of a receiver's own */
    bool punctual;                 /* point and spot lights are asked for, too */
};

/* Questions whether anything stands between a receiver and what was found. */
struct questions {
    struct trace_rays ray;
    struct wave_vec direction; /* to what was found */
    /* its radiance over its density per solid angle, balanced with the receiver's own directions */
    struct wave_vec light;
    int32_t seen[PATH_WAVE]; /* 1: there is something to be asked; then: nothing stands between */
    size_t group[PATH_WAVE]; /* whose light it is; set where the tracer has groups */
};

/* Density per solid angle of a receiver's own directions, by the cosine; of a point. */
static inline float cosine_density(float cosine)
{
    return float_most(cosine, 0) / (float)ANGLE_PI;
}

static const float sphere_density = 1 / (4 * (float)ANGLE_PI);

/* Per solid angle from distance: per area times d^2 / cos. */
static inline float solid_density(float area_density, float distance, float cosine)
{
    return area_density * distance * distance / cosine;
}

static struct lights_receiver receiver_at(const struct receivers *from, size_t i)
{
    return (struct lights_receiver){wave_get(from->position, i),
                                    from->normal ? wave_get(from->normal, i) : (struct vec3f){0},
                                    !from->punctual};
}

/* Points of emissive surfaces that were drawn. */
struct drawn {
    struct wave_vec position, normal, radiance; /* radiance: of the side that shines */
    float density[PATH_WAVE];                   /* per area */
};

static void set_drawn(const struct path_tracer *path, const struct lights_choice *choice,
                      struct drawn *drawn, size_t i)
{
    const struct trace_point *p = &choice->point;
    struct vec3f radiance = trace_point_emission(path->tracer, p);
    if (path->tracer->has_alpha) /* where the surface is not, it does not shine */
        radiance = vec3f_scale(1 - trace_point_transparency(path->tracer, p), radiance);
    wave_put(&drawn->position, i, p->position);
    wave_put(&drawn->normal, i, p->normal);
    wave_put(&drawn->radiance, i, radiance);
    drawn->density[i] = choice->density;
}

/* From each receiver to just above the point that was drawn for it, so that the light does not
 * shadow itself. */
TRACE_VECTORS static void aim(const struct wave_vec *restrict position,
                              const struct wave_vec *restrict facing, bool surface, bool front_only,
                              float share, size_t count, const struct drawn *restrict drawn,
                              struct questions *restrict q)
{
    /* no branch in the loop */
    const float lowest = front_only ? 0 : -1, uniform = surface ? 0 : sphere_density,
                cosines = surface ? 1 : 0;
    for (size_t i = 0; i < count; i++) {
        const struct vec3f origin = wave_get(position, i), point = wave_get(&drawn->position, i),
                           normal = wave_get(&drawn->normal, i);
        const struct vec3f way = vec3f_sub(point, origin), radiance = wave_get(&drawn->radiance, i);
        const float distance = vec3f_length(way);
        const struct vec3f direction = vec3f_scale(1 / distance, way);
        const float cosine = -vec3f_dot(direction, normal), side = cosine > 0 ? 1.0f : -1.0f;
        const float own = uniform +
                          cosines * cosine_density(vec3f_dot(direction, wave_get(facing, i)));
        const float density = solid_density(drawn->density[i], distance, fabsf(cosine));
        const struct vec3f to_target =
            vec3f_sub(trace_leave(point, distance, vec3f_scale(side, normal)), origin);
        const float reach = vec3f_length(to_target);
        const int shines = (distance > 0) & (cosine > lowest) & (fabsf(cosine) > 0) & (own > 0) &
                           (vec3f_most(radiance) > 0);
        q->seen[i] = q->seen[i] ? shines : 0;
        wave_put(&q->ray.origin, i, origin);
        wave_put(&q->ray.direction, i, vec3f_scale(1 / reach, to_target));
        q->ray.most[i] = reach;
        wave_put(&q->direction, i, direction);
        wave_put(&q->light, i, vec3f_scale(1 / (share * density + own), radiance));
    }
}

/* A point or spot light that was drawn, as if it were a radiance: there is no other way to meet
 * it. */
static void aim_punctual(const struct path_tracer *path, struct vec3f position, struct vec3f normal,
                         const struct scene_light *light, float probability, struct questions *q,
                         size_t i)
{
    const struct vec3 p = trace_to_world(path->tracer, position);
    double direction[3], distance, rgb[3];
    scene_light_at(light, (const double[3]){p.x, p.y, p.z}, direction, &distance, rgb);
    const struct vec3f to_light = {(float)direction[0], (float)direction[1], (float)direction[2]};
    const struct vec3f e = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
    q->seen[i] = vec3f_dot(to_light, normal) > 0 && vec3f_most(e) > 0;
    wave_put(&q->ray.origin, i, position);
    wave_put(&q->ray.direction, i, to_light);
    q->ray.most[i] = (float)(distance * path->tracer->scale);
    wave_put(&q->direction, i, to_light);
    wave_put(&q->light, i, vec3f_scale(1 / probability, e));
}

/* The group of a light that was drawn. */
static size_t group_of_choice(const struct path_tracer *path, const struct lights_choice *choice)
{
    const struct group_map *groups = path->split->groups;
    const struct scene *scene = path->tracer->scene;
    return choice->punctual ? groups->of_light[choice->punctual - scene->lights]
                            : group_of_surface(groups, scene, choice->point.instance,
                                               choice->point.triangle, choice->point.material);
}

/* Asks for one light each, drawn by (x, y). Point and spot lights are for surfaces alone. */
static void ask_lights(const struct path_tracer *path, const struct receivers *from,
                       const double *x, const float *y, struct questions *q)
{
    struct drawn drawn;
    struct lights_choice punctual[PATH_WAVE];
    size_t of_punctual[PATH_WAVE], punctuals = 0;
    for (size_t i = 0; i < from->count; i++) {
        const struct lights_receiver receiver = receiver_at(from, i);
        struct lights_choice choice;
        q->seen[i] = lights_sample(&path->lights, path->tracer, &receiver, x[i], y[i], &choice);
        if (q->seen[i] && path->split && path->split->groups)
            q->group[i] = group_of_choice(path, &choice);
        if (q->seen[i] && choice.punctual) {
            punctual[punctuals] = choice;
            of_punctual[punctuals++] = i;
            q->seen[i] = 0;
        }
        if (q->seen[i])
            set_drawn(path, &choice, &drawn, i);
        else /* of no meaning, but numbers all the same */
            drawn.position.x[i] = drawn.position.y[i] = drawn.position.z[i] = drawn.normal.x[i] =
                drawn.normal.y[i] = drawn.normal.z[i] = drawn.radiance.x[i] = drawn.radiance.y[i] =
                    drawn.radiance.z[i] = drawn.density[i] = 0;
    }
    if (path->emissive)
        aim(from->position, from->normal ? from->normal : &drawn.normal, from->normal,
            path->tracer->scene->emit_front_only, from->share, from->count, &drawn, q);
    for (size_t k = 0; k < punctuals && from->punctual; k++) {
        const struct lights_receiver receiver = receiver_at(from, of_punctual[k]);
        aim_punctual(path, receiver.position, receiver.normal, punctual[k].punctual,
                     punctual[k].probability, q, of_punctual[k]);
    }
}

/* Asks for one direction each of an uneven sky, drawn by (x, y). */
static void ask_sky(const struct path_tracer *path, const struct receivers *from, const double *x,
                    const double *y, struct questions *q)
{
    for (size_t i = 0; i < from->count; i++) {
        float density;
        const struct vec3f direction = sky_sample(&path->sky, x[i], y[i], &density);
        const float own = from->normal
                              ? cosine_density(vec3f_dot(direction, wave_get(from->normal, i)))
                              : sphere_density;
        q->seen[i] = own > 0 && density > 0;
        if (path->split && path->split->groups)
            q->group[i] = path->split->groups->of_sky;
        wave_put(&q->ray.origin, i, wave_get(from->position, i));
        wave_put(&q->ray.direction, i, direction);
        q->ray.most[i] = INFINITY;
        wave_put(&q->direction, i, direction);
        wave_put(&q->light, i,
                 vec3f_scale(1 / (from->share * density + own),
                             scene_sky_radiance(path->tracer->scene, direction)));
    }
}

/* The weight of emission that a receiver's ray of density `own` met, against ask_lights. */
static float met_weight(const struct path_tracer *path, const struct path_receiver *from,
                        const struct trace_points *at, size_t i, struct vec3f direction, float own)
{
    const struct trace_point point = {
        .instance = at->instance[i], .triangle = at->triangle[i], .b = at->b[i], .c = at->c[i]};
    const float area_density = lights_density(&path->lights, &from->at, &point);
    if (!(area_density > 0))
        return 1;
    const float cosine = fabsf(vec3f_dot(direction, wave_get(&at->normal, i)));
    return own / (own + from->lights_share * solid_density(area_density, at->distance[i],
                                                           float_most(cosine, FLT_MIN)));
}

/* The weight of the sky that it met, against ask_sky. */
static float sky_weight(const struct path_tracer *path, const struct path_receiver *from,
                        struct vec3f direction, float own)
{
    return path->sky.rows ? own / (own + from->sky_share * sky_density(&path->sky, direction)) : 1;
}

/* Radiance that the surface at a hit emits towards where it is seen from. */
static struct vec3f emitted(const struct path_tracer *path, const struct trace_points *at, size_t i)
{
    const struct scene *scene = path->tracer->scene;
    if (!scene_emits(at->material[i]) || (scene->emit_front_only && !at->front[i]))
        return (struct vec3f){0};
    const struct trace_point point = {.instance = at->instance[i],
                                      .triangle = at->triangle[i],
                                      .b = at->b[i],
                                      .c = at->c[i],
                                      .u = at->u[i],
                                      .v = at->v[i],
                                      .material = at->material[i]};
    return trace_point_emission(path->tracer, &point);
}

/* -- a wave of paths --------------------------------------------------------------------------- */

/* Paths that go on. */
struct wave {
    const struct path_tracer *path;
    size_t count;
    uint32_t sample[PATH_WAVE]; /* whose path it is */
    struct wave_random random;
    struct trace_points at; /* the surface that was met */
    /* from the surface before to there; once a path has turned, the next one */
    struct trace_rays ray;
    struct wave_vec facing;          /* normal of the surface before, on the ray's side */
    struct wave_vec throughput, sum; /* what light it meets counts, and what it has met so far */
    struct wave_vec light;           /* irradiance over pi from what was asked */
    struct questions questions;
    struct wave_vec sunlight;  /* what of light is the suns'; set where there are sunlit points */
    bool known[PATH_WAVE];     /* the cache says what is scattered on; set where there is a cache */
    struct split_light *split; /* NULL: light is not split */
};

/* Turns to the side of the surface that the path came to, and starts from there. */
TRACE_VECTORS static void face(struct wave *w)
{
    for (size_t i = 0; i < w->count; i++) {
        const struct vec3f facing =
            vec3f_scale(w->at.front[i] ? 1.0f : -1.0f, wave_get(&w->at.normal, i));
        wave_put(&w->facing, i, facing);
        wave_put(&w->ray.origin, i,
                 trace_leave(wave_get(&w->at.position, i), w->at.distance[i], facing));
        wave_put(&w->light, i, (struct vec3f){0});
    }
}

/* Traces what was asked, and adds the irradiance over pi of what is seen. */
TRACE_VECTORS static void answer(struct wave *w)
{
    struct questions *q = &w->questions;
    draw_salts(w->path, &w->random, w->count, q->ray.salt);
    trace_rays_occluded(w->path->tracer, w->count, &q->ray, q->seen);
    for (size_t i = 0; i < w->count; i++) {
        const float share =
            cosine_density(vec3f_dot(wave_get(&q->direction, i), wave_get(&w->facing, i)));
        const struct vec3f lit = vec3f_fma(wave_get(&w->light, i), share, wave_get(&q->light, i)),
                           unlit = wave_get(&w->light, i);
        w->light.x[i] = q->seen[i] ? lit.x : unlit.x;
        w->light.y[i] = q->seen[i] ? lit.y : unlit.y;
        w->light.z[i] = q->seen[i] ? lit.z : unlit.z;
    }
}

/* Keeps what was answered by groups. */
static void split_answer(struct wave *w)
{
    const struct questions *q = &w->questions;
    if (!w->split || !w->split->split->groups)
        return;
    for (size_t i = 0; i < w->count; i++)
        if (q->seen[i])
            split_ask(w->split, q->group[i], i,
                      vec3f_scale(cosine_density(vec3f_dot(wave_get(&q->direction, i),
                                                           wave_get(&w->facing, i))),
                                  wave_get(&q->light, i)));
}

TRACE_VECTORS static void ask_sun(const struct path_sun *sun, const struct receivers *from,
                                  struct questions *q)
{
    for (size_t i = 0; i < from->count; i++) {
        q->seen[i] = vec3f_dot(sun->to_light, wave_get(from->normal, i)) > 0;
        wave_put(&q->ray.origin, i, wave_get(from->position, i));
        wave_put(&q->ray.direction, i, sun->to_light);
        q->ray.most[i] = INFINITY;
        wave_put(&q->direction, i, sun->to_light);
        wave_put(&q->light, i, sun->irradiance);
    }
}

/* What tells blended surfaces which rays they let through to a light of a split: of the paths, but
 * none of their draws, which are to be what they are without. */
static uint32_t salt_of(const struct wave *w, size_t i, size_t light)
{
    uint32_t x = w->random.state[0][i] ^
                 (w->random.state[1][i] + 0x9E3779B9u * (uint32_t)(light + 1));
    x = (x ^ x >> 16) * 0x85EBCA6Bu;
    x = (x ^ x >> 13) * 0xC2B2AE35u;
    return x ^ x >> 16;
}

/* Traces what was asked of one light of a split, the `light`-th, and keeps it for its part. */
static void answer_part(struct wave *w, size_t part, size_t light)
{
    struct questions *q = &w->questions;
    for (size_t i = 0; i < w->count; i++)
        q->ray.salt[i] = w->path->tracer->has_alpha ? salt_of(w, i, light) : 0;
    trace_rays_occluded(w->path->tracer, w->count, &q->ray, q->seen);
    for (size_t i = 0; i < w->count; i++)
        if (q->seen[i])
            split_ask(w->split, part, i,
                      vec3f_scale(cosine_density(vec3f_dot(wave_get(&q->direction, i),
                                                           wave_get(&w->facing, i))),
                                  wave_get(&q->light, i)));
}

/* The suns and points whose light is asked for by itself. */
static void ask_split_lights(struct wave *w, const struct receivers *from)
{
    const struct split *split = w->split->split;
    for (size_t s = 0; s < split->sun_count; s++) {
        const double *to = split->sun + 3 * s;
        const struct path_sun sun = {.to_light = {(float)to[0], (float)to[1], (float)to[2]},
                                     .irradiance = {1, 1, 1}};
        ask_sun(&sun, from, &w->questions);
        answer_part(w, split_suns(split) + s, s);
    }
    for (size_t p = 0; p < split->point_count; p++) {
        const struct scene_light light = split_point(split, p);
        for (size_t i = 0; i < w->count; i++)
            aim_punctual(w->path, wave_get(from->position, i), wave_get(from->normal, i), &light, 1,
                         &w->questions, i);
        answer_part(w, split_points(split) + p, split->sun_count + p);
    }
}

/* The light on all surfaces of a wave from what is asked for, without what their scattered rays are
 * to meet. */
static void light_surfaces(struct wave *w)
{
    const struct path_tracer *path = w->path;
    const struct receivers from = {.count = w->count,
                                   .position = &w->ray.origin,
                                   .normal = &w->facing,
                                   .share = 1,
                                   .punctual = true};
    double x[PATH_WAVE], y[PATH_WAVE];
    if (path->lights.count) {
        float across[PATH_WAVE];
        draw_doubles(&w->random, w->count, x);
        draw_floats(&w->random, w->count, across);
        ask_lights(path, &from, x, across, &w->questions);
        answer(w);
        split_answer(w);
    }
    if (path->sky.rows) {
        draw_doubles(&w->random, w->count, x);
        draw_doubles(&w->random, w->count, y);
        ask_sky(path, &from, x, y, &w->questions);
        answer(w);
        split_answer(w);
    }
    if (path->cache && path->cache->lit)
        w->sunlight = w->light;
    for (size_t s = 0; s < path->sun_count; s++) {
        ask_sun(&path->suns[s], &from, &w->questions);
        answer(w);
        for (size_t i = 0; i < w->count && w->split && w->split->split->groups; i++)
            w->questions.group[i] = w->split->split->groups->of_light[path->suns[s].light];
        split_answer(w);
    }
    if (w->split)
        ask_split_lights(w, &from);
    for (size_t i = 0; i < w->count && path->cache && path->cache->lit; i++)
        wave_put(&w->sunlight, i, vec3f_sub(wave_get(&w->light, i), wave_get(&w->sunlight, i)));
}

/* Takes in what is lit, and draws the way on. Texels are sent for before, and read after, the
 * directions are drawn. */
TRACE_VECTORS static void turn(struct wave *w)
{
    const struct scene *scene = w->path->tracer->scene;
    struct scene_texel texel[PATH_WAVE];
    struct wave_vec albedo;
    uint32_t bits[PATH_WAVE];
    float u[PATH_WAVE], turns[PATH_WAVE];
    draw_bits(&w->random, w->count, bits);
    for (size_t i = 0; i < w->count; i++)
        texel[i] = scene_texel_draw(scene, w->at.material[i], w->at.u[i], w->at.v[i], bits[i]);
    draw_floats(&w->random, w->count, u);
    draw_floats(&w->random, w->count, turns);
    draw_salts(w->path, &w->random, w->count, w->ray.salt);
    for (size_t i = 0; i < w->count; i++) {
        wave_put(&w->ray.direction, i,
                 direction_by_cosine(wave_get(&w->facing, i), u[i], turns[i]));
        w->ray.most[i] = INFINITY;
    }
    if (w->path->tracer->has_colour)
        for (size_t i = 0; i < w->count; i++)
            wave_put(&albedo, i,
                     scene_texel_albedo_tinted(scene, &texel[i], wave_get(&w->at.tint, i)));
    else
        for (size_t i = 0; i < w->count; i++)
            wave_put(&albedo, i, scene_texel_albedo(scene, &texel[i]));
    for (size_t i = 0; i < w->count; i++) {
        const struct vec3f throughput =
            vec3f_mul(wave_get(&w->throughput, i), wave_get(&albedo, i));
        wave_put(&w->throughput, i, throughput);
        wave_put(&w->sum, i,
                 vec3f_add(wave_get(&w->sum, i), vec3f_mul(throughput, wave_get(&w->light, i))));
    }
}

/* Adds what a path met by chance to its parts. */
static void split_met(struct wave *w, size_t i, struct vec3f radiance)
{
    const struct split *split = w->split->split;
    const struct vec3f throughput = wave_get(&w->throughput, i);
    if (!w->at.hit[i])
        split_add_sky(w->split, w->sample[i], wave_get(&w->ray.direction, i), throughput);
    if (!split->groups || !(vec3f_most(radiance) > 0))
        return;
    const size_t group = w->at.hit[i] ? split_group_met(split, w->path->tracer->scene, &w->at, i)
                                      : split->groups->of_sky;
    split_add(w->split, group, w->sample[i], vec3f_mul(throughput, radiance));
}

/* What the rays met by chance: the sky, or a surface that emits. */
static void meet(struct wave *w)
{
    const struct path_tracer *path = w->path;
    for (size_t i = 0; i < w->count; i++) {
        struct vec3f radiance = {0};
        float weight = 1;
        if (w->at.hit[i] && !path->emissive)
            continue;
        const struct vec3f direction = wave_get(&w->ray.direction, i);
        const struct path_receiver from = {
            .at = {wave_get(&w->ray.origin, i), wave_get(&w->facing, i), false},
            .lights_share = 1,
            .sky_share = 1};
        const float own = cosine_density(vec3f_dot(direction, from.at.normal));
        if (!w->at.hit[i]) {
            radiance = scene_sky_radiance(path->tracer->scene, direction);
            weight = sky_weight(path, &from, direction, own);
        } else if (vec3f_most(radiance = emitted(path, &w->at, i)) > 0) {
            weight = met_weight(path, &from, &w->at, i, direction, own);
        }
        wave_put(&w->sum, i,
                 vec3f_fma(wave_get(&w->sum, i), weight,
                           vec3f_mul(wave_get(&w->throughput, i), radiance)));
        if (w->split)
            split_met(w, i, vec3f_scale(weight, radiance));
    }
}

/* Moves a path to another place of the wave: what it is made of before it faces a surface. */
static void move_path(struct wave *w, size_t to, size_t from)
{
    w->sample[to] = w->sample[from];
    for (int k = 0; k < 4; k++)
        w->random.state[k][to] = w->random.state[k][from];
    struct wave_vec *const vectors[] = {&w->at.position, &w->at.normal, &w->throughput, &w->sum};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        wave_put(vectors[k], to, wave_get(vectors[k], from));
    w->at.distance[to] = w->at.distance[from];
    w->at.front[to] = w->at.front[from];
    w->at.material[to] = w->at.material[from];
    w->at.u[to] = w->at.u[from];
    w->at.v[to] = w->at.v[from];
    if (w->path->tracer->has_colour)
        wave_put(&w->at.tint, to, wave_get(&w->at.tint, from));
}

/* Ends paths that escaped, that can bring nothing more, or that Russian roulette ends; their sums
 * are done. */
static void end_paths(struct wave *w, bool roulette, struct path_sample *sample)
{
    size_t left = 0;
    for (size_t i = 0; i < w->count; i++) {
        const float most = vec3f_most(wave_get(&w->throughput, i));
        bool on = w->at.hit[i] && most > 0;
        if (on && roulette && most < 1) {
            on = (float)(draw(&w->random, i) >> 8) * 0x1p-24f < most;
            if (on)
                wave_put(&w->throughput, i, vec3f_scale(1 / most, wave_get(&w->throughput, i)));
        }
        if (!on)
            sample[w->sample[i]].scattered = wave_get(&w->sum, i);
        else if (left++ != i)
            move_path(w, left - 1, i);
    }
    w->count = left;
}

/* -- the cache --------------------------------------------------------------------------------- */

/* Whether the cache knows where a path is that faces a surface, and then the irradiance that it
 * says, or, where it has no light yet, the disc. */
static bool ask_cache(struct wave *w, size_t i, struct path_sample *sample, float e[3])
{
    const struct path_cache *cache = w->path->cache;
    const struct vec3 p = trace_to_world(w->path->tracer, wave_get(&w->ray.origin, i));
    const struct vec3f n = wave_get(&w->facing, i);
    const double at[3] = {p.x, p.y, p.z}, normal[3] = {(double)n.x, (double)n.y, (double)n.z};
    if (cache->value)
        return discs_cover(cache->discs, at, normal, cache->value, e);
    const float u = (float)(draw(&w->random, i) >> 8) * 0x1p-24f;
    sample->link.disc = discs_draw(cache->discs, at, normal, u);
    e[0] = e[1] = e[2] = 0;
    return sample->link.disc != CACHE_NONE;
}

/* Takes in what the cache knows. True: some path is known, and is to end. */
static bool read_cache(struct wave *w, struct path_sample *sample)
{
    bool some = false;
    for (size_t i = 0; i < w->count; i++) {
        float e[3];
        w->known[i] = ask_cache(w, i, &sample[w->sample[i]], e);
        if (!w->known[i])
            continue;
        some = true;
        wave_put(&w->light, i,
                 vec3f_fma(wave_get(&w->light, i), 1 / (float)ANGLE_PI,
                           (struct vec3f){e[0], e[1], e[2]}));
    }
    return some;
}

/* Leaves their share of sunlight to the sunlit points. */
static void leave_lit(struct wave *w)
{
    const struct lit *lit = w->path->cache->lit;
    for (size_t i = 0; i < w->count; i++) {
        const struct vec3f sunlight = wave_get(&w->sunlight, i);
        if (!(vec3f_most(sunlight) > 0))
            continue;
        const float share = lit_share(lit, w->at.distance[i]);
        wave_put(&w->light, i, vec3f_fma(wave_get(&w->light, i), -share, sunlight));
    }
}

/* Says what the discs' light would count of known paths that have turned. */
static void set_links(const struct wave *w, int bounce, struct path_sample *sample)
{
    for (size_t i = 0; i < w->count; i++) {
        if (!w->known[i])
            continue;
        const struct vec3f t = wave_get(&w->throughput, i);
        struct path_sample *s = &sample[w->sample[i]];
        s->link.share[0] = t.x, s->link.share[1] = t.y, s->link.share[2] = t.z;
        s->scatters = bounce;
    }
}

/* The sky that known paths meet, where nothing else shines: whether anything is in the way is all
 * that matters. */
static void meet_sky(struct wave *w)
{
    const struct path_tracer *path = w->path;
    int32_t seen[PATH_WAVE];
    for (size_t i = 0; i < w->count; i++)
        seen[i] = w->known[i];
    trace_rays_occluded(path->tracer, w->count, &w->ray, seen);
    for (size_t i = 0; i < w->count; i++) {
        if (!seen[i])
            continue;
        const struct vec3f direction = wave_get(&w->ray.direction, i);
        const struct path_receiver from = {
            .at = {wave_get(&w->ray.origin, i), wave_get(&w->facing, i), false}, .sky_share = 1};
        const float weight = sky_weight(path, &from, direction,
                                        cosine_density(vec3f_dot(direction, from.at.normal)));
        wave_put(&w->sum, i,
                 vec3f_fma(wave_get(&w->sum, i), weight,
                           vec3f_mul(wave_get(&w->throughput, i),
                                     scene_sky_radiance(path->tracer->scene, direction))));
    }
}

/* Ends known paths before their way on is traced. */
static void end_known(struct wave *w, struct path_sample *sample)
{
    size_t left = 0;
    for (size_t i = 0; i < w->count; i++) {
        if (w->known[i]) {
            sample[w->sample[i]].scattered = wave_get(&w->sum, i);
        } else if (left++ != i) {
            move_path(w, left - 1, i);
            wave_put(&w->ray.origin, left - 1, wave_get(&w->ray.origin, i));
            wave_put(&w->ray.direction, left - 1, wave_get(&w->ray.direction, i));
            wave_put(&w->facing, left - 1, wave_get(&w->facing, i));
            w->ray.most[left - 1] = w->ray.most[i];
            w->ray.salt[left - 1] = w->ray.salt[i];
        }
    }
    w->count = left;
}

/* Of paths that are known for the first time, leaves what the cache says of them, negative; what
 * they find from here on is compared with that. */
static void compare(struct wave *w, struct path_sample *sample)
{
    for (size_t i = 0; i < w->count; i++) {
        struct path_sample *s = &sample[w->sample[i]];
        float e[3];
        if (s->compared || !ask_cache(w, i, s, e))
            continue;
        s->compared = true;
        struct vec3f found = vec3f_scale(-1 / (float)ANGLE_PI, (struct vec3f){e[0], e[1], e[2]});
        if (w->path->cache->sky && !w->at.hit[i])
            found = vec3f_add(
                found, scene_sky_radiance(w->path->tracer->scene, wave_get(&w->ray.direction, i)));
        wave_put(&w->sum, i, vec3f_mul(wave_get(&w->throughput, i), found));
    }
}

/* The radiance that the surfaces met by a wave scatter back along its rays: one path each. */
static void scatter(struct wave *w, struct path_sample *sample)
{
    for (int bounce = 1; bounce <= w->path->bounces && w->count; bounce++) {
        face(w);
        light_surfaces(w);
        turn(w);
        if (w->split)
            split_scatter(w->split, w->count, &w->throughput, w->sample);
        trace_rays_nearest(w->path->tracer, w->count, &w->ray, &w->at);
        meet(w);
        end_paths(w, bounce >= 2, sample);
    }
    for (size_t i = 0; i < w->count; i++)
        sample[w->sample[i]].scattered = wave_get(&w->sum, i);
}

/* The same with a cache, which may end them. */
static void scatter_cached(struct wave *w, bool lit, struct path_sample *sample)
{
    const struct path_cache *cache = w->path->cache;
    for (int bounce = 1; bounce <= w->path->bounces && w->count; bounce++) {
        const bool reads = bounce >= cache->after && bounce < w->path->bounces;
        face(w);
        light_surfaces(w);
        if (lit && bounce == 1)
            leave_lit(w);
        bool known = reads && !cache->check && read_cache(w, sample);
        turn(w);
        if (known && !cache->value)
            set_links(w, bounce, sample);
        if (known && !w->path->emissive) {
            if (w->path->sky_shines && !cache->sky)
                meet_sky(w);
            end_known(w, sample);
            known = false;
        }
        trace_rays_nearest(w->path->tracer, w->count, &w->ray, &w->at);
        for (size_t i = 0; i < w->count && known && cache->sky; i++)
            if (w->known[i] && !w->at.hit[i])
                wave_put(&w->throughput, i, (struct vec3f){0});
        meet(w);
        for (size_t i = 0; i < w->count && known; i++)
            if (w->known[i])
                wave_put(&w->throughput, i, (struct vec3f){0});
        if (reads && cache->check)
            compare(w, sample);
        end_paths(w, bounce >= 2, sample);
    }
    for (size_t i = 0; i < w->count; i++)
        sample[w->sample[i]].scattered = wave_get(&w->sum, i);
}

/* -- receivers --------------------------------------------------------------------------------- */

static bool on_surface(const struct lights_receiver *r)
{
    return r->normal.x != 0 || r->normal.y != 0 || r->normal.z != 0;
}

/* What a receiver's own ray met. */
static struct path_sample seen(const struct path_receiver *receiver, const struct wave *w, size_t i)
{
    const struct path_tracer *path = w->path;
    const struct vec3f direction = wave_get(&w->ray.direction, i);
    const float own = on_surface(&receiver->at)
                          ? cosine_density(vec3f_dot(direction, receiver->at.normal))
                          : sphere_density;
    struct path_sample sample = {
        .weight = 1, .distance = w->at.distance[i], .link = {.disc = CACHE_NONE}};
    if (!w->at.hit[i]) {
        sample.straight = scene_sky_radiance(path->tracer->scene, direction);
        sample.weight = sky_weight(path, receiver, direction, own);
        return sample;
    }
    sample.hit = true;
    sample.front = w->at.front[i];
    sample.normal = wave_get(&w->at.normal, i);
    if (path->emissive && vec3f_most(sample.straight = emitted(path, &w->at, i)) > 0)
        sample.weight = met_weight(path, receiver, &w->at, i, direction, own);
    return sample;
}

/* Whose light the radiance is that a receiver's own ray met. */
static uint16_t group_straight(const struct wave *w, size_t i, struct vec3f radiance)
{
    const struct split *split = w->split->split;
    return !(vec3f_most(radiance) > 0) ? GROUP_NONE
           : w->at.hit[i] ? (uint16_t)split_group_met(split, w->path->tracer->scene, &w->at, i)
                          : split->groups->of_sky;
}

void path_samples(const struct path_tracer *path, const struct path_receiver *receiver,
                  const struct path_rays *rays, struct path_sample *sample)
{
    path_samples_split(path, receiver, rays, sample, NULL);
}

void path_samples_split(const struct path_tracer *path, const struct path_receiver *receiver,
                        const struct path_rays *rays, struct path_sample *sample,
                        struct split_light *split)
{
    const size_t count = rays->count;
    struct wave w;
    w.path = path;
    w.count = count;
    w.split = split;
    for (size_t i = 0; i < count; i++) {
        w.sample[i] = (uint32_t)i;
        random_put(&w.random, i, &rays->random[i]);
        wave_put(&w.ray.origin, i, receiver->at.position);
        wave_put(&w.ray.direction, i, rays->direction[i]);
        wave_put(&w.throughput, i, (struct vec3f){1, 1, 1});
        wave_put(&w.sum, i, (struct vec3f){0});
        w.ray.most[i] = INFINITY;
    }
    draw_salts(path, &w.random, count, w.ray.salt);
    trace_rays_nearest(path->tracer, count, &w.ray, &w.at);
    struct path_receiver asking = *receiver; /* its questions are for surfaces alone */
    asking.at.surfaces = true;
    for (size_t i = 0; i < count; i++)
        sample[i] = seen(&asking, &w, i);
    for (size_t i = 0; i < count && w.split && w.split->split->groups; i++)
        w.split->straight[i] = group_straight(&w, i, sample[i].straight);
    if (rays->straight_alone)
        return;
    end_paths(&w, false, sample);
    if (!path->cache) {
        scatter(&w, sample);
        return;
    }
    scatter_cached(&w, receiver->lit, sample);
    for (size_t i = 0; i < count && path->cache->check; i++)
        if (!sample[i].compared)
            sample[i].scattered = (struct vec3f){0};
}

/* What a receiver asks, once a draw. */
static void put_questions(const struct path_tracer *path, const struct path_receiver *receiver,
                          bool sky, const struct path_draws *draws, struct questions *q)
{
    const size_t count = draws->count;
    struct wave_vec position, normal;
    double down[PATH_WAVE];
    const struct receivers from = {.count = count,
                                   .position = &position,
                                   .normal = on_surface(&receiver->at) ? &normal : NULL,
                                   .share = sky ? receiver->sky_share : receiver->lights_share};
    for (size_t i = 0; i < count; i++) {
        down[i] = (double)draws->x[i];
        wave_put(&position, i, receiver->at.position);
        wave_put(&normal, i, receiver->at.normal);
    }
    if (sky)
        ask_sky(path, &from, down, draws->y, q);
    else
        ask_lights(path, &from, draws->y, draws->x, q);
}

/* Asks from one receiver and keeps what is seen. */
static void ask_from(const struct path_tracer *path, const struct path_receiver *receiver, bool sky,
                     const struct path_draws *draws, struct path_found *found)
{
    const size_t count = draws->count;
    struct questions q;
    put_questions(path, receiver, sky, draws, &q);
    for (size_t i = 0; i < count; i++) {
        struct random r = draws->random[i];
        q.ray.salt[i] = path->tracer->has_alpha ? random_u32(&r) : 0;
    }
    trace_rays_occluded(path->tracer, count, &q.ray, q.seen);
    for (size_t i = 0; i < count; i++)
        found[i] = q.seen[i] ? (struct path_found){.direction = wave_get(&q.direction, i),
                                                   .light = wave_get(&q.light, i)}
                             : (struct path_found){0};
    for (size_t i = 0; i < count && path->split && path->split->groups; i++)
        found[i].group = q.seen[i] ? q.group[i] : 0;
}

void path_lights(const struct path_tracer *path, const struct path_receiver *receiver,
                 const struct path_draws *draws, struct path_found *found)
{
    ask_from(path, receiver, false, draws, found);
}

void path_skies(const struct path_tracer *path, const struct path_receiver *receiver,
                const struct path_draws *draws, struct path_found *found)
{
    ask_from(path, receiver, true, draws, found);
}

void path_open(const struct path_tracer *path, const struct path_receiver *receiver,
               const struct path_rays *rays, struct path_found *found)
{
    struct trace_rays ray;
    int32_t seen[PATH_WAVE];
    for (size_t i = 0; i < rays->count; i++) {
        struct random r = rays->random[i];
        wave_put(&ray.origin, i, receiver->at.position);
        wave_put(&ray.direction, i, rays->direction[i]);
        ray.most[i] = INFINITY;
        ray.salt[i] = path->tracer->has_alpha ? random_u32(&r) : 0;
        seen[i] = 1;
    }
    trace_rays_occluded(path->tracer, rays->count, &ray, seen);
    for (size_t i = 0; i < rays->count; i++) {
        const struct vec3f d = rays->direction[i];
        found[i] = (struct path_found){.direction = d};
        if (seen[i])
            found[i].light = scene_sky_radiance(path->tracer->scene, d);
    }
}

void path_lit(const struct path_tracer *path, const struct lit *lit,
              const struct path_receiver *receiver, const double *sum, size_t count,
              const double *x, const struct random *random, struct path_found *found,
              size_t *cluster)
{
    const struct vec3f origin = receiver->at.position;
    struct questions q = {0};
    for (size_t i = 0; i < count; i++) {
        struct lit_point point;
        struct random r = random[i];
        q.seen[i] = lit_draw(lit, &receiver->at, sum, x[i], &point);
        cluster[i] = point.cluster;
        q.ray.salt[i] = path->tracer->has_alpha ? random_u32(&r) : 0;
        if (!q.seen[i])
            continue;
        const struct vec3f way = vec3f_sub(point.position, origin);
        const float reach = vec3f_length(way);
        const struct vec3f direction = vec3f_scale(1 / reach, way);
        wave_put(&q.ray.origin, i, origin);
        wave_put(&q.ray.direction, i, direction);
        q.ray.most[i] = reach;
        wave_put(&q.direction, i, direction);
        wave_put(&q.light, i, point.light);
    }
    trace_rays_occluded(path->tracer, count, &q.ray, q.seen);
    for (size_t i = 0; i < count; i++)
        found[i] = q.seen[i] ? (struct path_found){.direction = wave_get(&q.direction, i),
                                                   .light = wave_get(&q.light, i)}
                             : (struct path_found){0};
}

/* The mean luminance that parts of pictures would give of which points are drawn. */
static float mean_of_pictures(const struct path_tracer *path, const struct lights_receiver *at,
                              const struct path_draws *draws)
{
    const struct lights_receiver asking = {at->position, at->normal, true};
    const float lowest = path->tracer->scene->emit_front_only ? 0 : -1;
    float sum = 0;
    for (size_t i = 0; i < draws->count; i++) {
        struct lights_choice choice;
        if (!lights_sample(&path->lights, path->tracer, &asking, draws->y[i], draws->x[i], &choice))
            continue;
        const struct vec3f way = vec3f_sub(at->position, choice.point.position);
        const float distance = vec3f_length(way),
                    cosine = distance > 0 ? vec3f_dot(way, choice.point.normal) / distance : 0;
        if (cosine > lowest && fabsf(cosine) > 0 && !(vec3f_dot(way, at->normal) > 0))
            sum += choice.brightness / solid_density(choice.density, distance, fabsf(cosine));
    }
    return sum / (float)draws->count;
}

struct vec3f path_lights_unshadowed(const struct path_tracer *path,
                                    const struct path_receiver *receiver,
                                    const struct path_draws *draws, bool *sparse)
{
    struct questions q;
    struct vec3f sum = {0};
    put_questions(path, receiver, false, draws, &q);
    for (size_t i = 0; i < draws->count; i++)
        if (q.seen[i])
            sum = vec3f_add(sum, wave_get(&q.light, i));
    *sparse = !(vec3f_most(sum) > 0);
    if (*sparse) {
        const float grey = mean_of_pictures(path, &receiver->at, draws);
        return (struct vec3f){grey, grey, grey};
    }
    return vec3f_scale(1 / (float)draws->count, sum);
}

/* Adds what lights would give, times `weight`: those from `first` on, `step` apart, a wave of them;
 * returns how many there were. */
static size_t add_unshadowed(const struct path_tracer *path, const struct path_receiver *receiver,
                             size_t first, size_t step, double weight, double *mean)
{
    struct questions q;
    struct drawn drawn;
    struct wave_vec position, normal;
    const struct wave_vec *facing = on_surface(&receiver->at) ? &normal : NULL;
    size_t count = 0, group[PATH_WAVE];
    for (size_t i = first; i < path->lights.count && count < PATH_WAVE; i += step, count++) {
        struct lights_choice choice;
        /* in the middle of the triangle */
        lights_draw(&path->lights, path->tracer, i, 4 / 9.0f, 0.5f, &choice);
        group[count] = group_of_choice(path, &choice);
        q.seen[count] = !choice.punctual;
        if (choice.punctual) { /* of no meaning, but numbers all the same */
            choice.point = (struct trace_point){0};
            choice.density = 0;
            wave_put(&drawn.position, count, choice.point.position);
            wave_put(&drawn.normal, count, choice.point.normal);
            wave_put(&drawn.radiance, count, (struct vec3f){0});
            drawn.density[count] = 0;
        } else {
            set_drawn(path, &choice, &drawn, count);
        }
        /* a picture is dark there, but not all of it */
        if (!choice.punctual && !(vec3f_most(wave_get(&drawn.radiance, count)) > 0))
            wave_put(&drawn.radiance, count,
                     (struct vec3f){choice.brightness, choice.brightness, choice.brightness});
        wave_put(&position, count, receiver->at.position);
        wave_put(&normal, count, receiver->at.normal);
    }
    if (count)
        aim(&position, facing ? facing : &drawn.normal, facing,
            path->tracer->scene->emit_front_only, receiver->lights_share, count, &drawn, &q);
    for (size_t i = 0; i < count; i++) {
        const struct vec3f light = wave_get(&q.light, i);
        double *of = mean + 3 * group[i];
        of[0] += q.seen[i] ? weight * (double)light.x : 0;
        of[1] += q.seen[i] ? weight * (double)light.y : 0;
        of[2] += q.seen[i] ? weight * (double)light.z : 0;
    }
    return count;
}

void path_groups_unshadowed(const struct path_tracer *path, const struct path_receiver *receiver,
                            const struct path_draws *draws, double *mean, double *share)
{
    enum { LIGHTS_MOST = 4096 };
    const size_t groups = path->split->groups->count, count = path->lights.count,
                 step = (count + LIGHTS_MOST - 1) / LIGHTS_MOST;
    const struct lights_receiver asking = {receiver->at.position, receiver->at.normal, true};
    memset(mean, 0, 3 * groups * sizeof *mean);
    memset(share, 0, groups * sizeof *share);
    for (size_t i = 0; i < draws->count; i++) {
        struct lights_choice choice;
        if (lights_sample(&path->lights, path->tracer, &asking, draws->y[i], draws->x[i], &choice))
            share[group_of_choice(path, &choice)] += 1 / (double)draws->count;
    }
    for (size_t first = 0, got = 1; got && first < count; first += got * step)
        got = add_unshadowed(path, receiver, first, step, (double)step, mean);
}
