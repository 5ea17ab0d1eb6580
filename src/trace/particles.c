/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/particles.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/angle.h"
#include "math/direction.h"
#include "math/luminance.h"
#include "math/random.h"
#include "math/sobol.h"

#include <stdlib.h>
#include <string.h>

/* What particles' random numbers are named by, where a probe's are by its position. */
#define NAME UINT64_C(0x7061727469636c65)

enum source_kind { SUN, SKY, TREE };

/* A light, or all lights of the tree, or the sky. */
struct source {
    enum source_kind kind;
    const struct scene_light *sun;
    double power;
    uint32_t first, count; /* particles */
};

struct job {
    const struct tracer *tracer;
    const struct lights *lights;
    const struct sky *sky;
    const struct particles_settings *settings;
    struct vec3f middle, half; /* of the scene's box */
    float radius;
    struct source *source; /* owned */
    size_t sources;
    struct particles *block; /* owned, by waves of particles */
};

/* -- sources ----------------------------------------------------------------------------------- */

/* A rectangle across a direction that holds the shadow of the scene's box. */
struct window {
    struct vec3f across, along; /* unit */
    float width, height;        /* half */
};

static struct window window_of(const struct job *job, struct vec3f direction)
{
    const float x = fabsf(direction.x), y = fabsf(direction.y), z = fabsf(direction.z);
    /* along the box's axis that is best seen */
    const struct vec3f axis = x <= y && x <= z ? (struct vec3f){1, 0, 0}
                              : y <= z         ? (struct vec3f){0, 1, 0}
                                               : (struct vec3f){0, 0, 1};
    struct window w;
    w.across = vec3f_normalize(vec3f_cross(direction, axis));
    w.along = vec3f_cross(w.across, direction);
    const struct vec3f h = job->half;
    w.width = fabsf(w.across.x) * h.x + fabsf(w.across.y) * h.y + fabsf(w.across.z) * h.z;
    w.height = fabsf(w.along.x) * h.x + fabsf(w.along.y) * h.y + fabsf(w.along.z) * h.z;
    return w;
}

static struct vec3f direction_of(const struct scene_light *sun)
{
    return (struct vec3f){(float)sun->direction.x, (float)sun->direction.y,
                          (float)sun->direction.z};
}

/* A direction that light comes from, and its radiance over the density per solid angle. */
static struct vec3f sky_draw(const struct job *job, float x, float y, struct vec3f *radiance)
{
    struct vec3f d;
    float density = 1 / (4 * (float)ANGLE_PI);
    if (job->sky->rows) {
        d = sky_sample(job->sky, (double)x, (double)y, &density);
    } else {
        float c, s;
        d.z = 2 * y - 1;
        const float r = sqrtf(float_most(1 - d.z * d.z, 0));
        angle_turn(x, &c, &s);
        d.x = r * c;
        d.y = r * s;
    }
    *radiance =
        vec3f_scale(density > 0 ? 1 / density : 0, scene_sky_radiance(job->tracer->scene, d));
    return d;
}

static float disc_area(const struct job *job)
{
    return (float)ANGLE_PI * job->radius * job->radius;
}

static double sky_power(const struct job *job)
{
    enum { LOOKS = 1024 };
    double sum = 0;
    for (uint32_t i = 0; i < LOOKS; i++) {
        uint32_t x, y;
        struct vec3f radiance;
        sobol_pair(i, 0, &x, &y);
        sky_draw(job, (float)(x >> 8) * 0x1p-24f, (float)(y >> 8) * 0x1p-24f, &radiance);
        sum += (double)luminance_vec3f(radiance);
    }
    return sum / LOOKS * (double)disc_area(job);
}

static void add_source(struct job *job, struct source source)
{
    if (source.power > 0)
        job->source[job->sources++] = source;
}

/* All sources, with particles in proportion to their power. */
static struct error *set_sources(struct job *job)
{
    const struct scene *scene = job->tracer->scene;
    struct error *err = array_create(&job->source, scene->light_count + 2, sizeof *job->source);
    for (size_t i = 0; i < scene->light_count && !err; i++) {
        if (scene->lights[i].kind != SCENE_SUN)
            continue;
        const struct window w = window_of(job, direction_of(&scene->lights[i]));
        const double area = 4 * (double)w.width * (double)w.height;
        add_source(job, (struct source){.kind = SUN,
                                        .sun = &scene->lights[i],
                                        .power = luminance_f64(scene->lights[i].intensity) * area});
    }
    if (!err && !job->settings->suns_only) {
        add_source(job, (struct source){.kind = SKY, .power = sky_power(job)});
        const double sides = job->lights->front_only ? 1 : 2;
        add_source(job, (struct source){.kind = TREE,
                                        .power = ANGLE_PI * sides * lights_strength(job->lights)});
    }
    double all = 0, before = 0; /* shares of the sources until there */
    for (size_t i = 0; i < job->sources; i++)
        all += job->source[i].power;
    for (size_t i = 0; i < job->sources; i++) {
        struct source *s = &job->source[i];
        const double count = (double)job->settings->count;
        const double even = job->settings->even;
        s->first = (uint32_t)(before * count);
        before += (1 - even) * (s->power / all) + even / (double)job->sources;
        s->count = (uint32_t)(i + 1 < job->sources ? before * count : count) - s->first;
    }
    return err;
}

/* -- emission ---------------------------------------------------------------------------------- */

/* Two pairs of numbers of a particle. */
struct numbers {
    double a, b;
    float c, d;
};

/* Where a particle starts. flux of 0: nowhere. */
struct start {
    struct vec3f origin, direction, flux;
};

/* Of a particle, across its way; 0: this is no sun. */
static float sun_area(const struct job *job, const struct source *s)
{
    if (s->kind != SUN || !s->count)
        return 0;
    const struct window w = window_of(job, direction_of(s->sun));
    return 4 * w.width * w.height / (float)s->count;
}

static struct start start_sun(const struct job *job, const struct source *s, struct numbers n)
{
    const struct vec3f d = direction_of(s->sun);
    const struct window w = window_of(job, d);
    const float x = (2 * (float)n.a - 1) * w.width, y = (2 * (float)n.b - 1) * w.height;
    const float share = 4 * w.width * w.height / (float)s->count;
    const double *e = s->sun->intensity;
    return (struct start){
        .origin = vec3f_fma(vec3f_fma(vec3f_fma(job->middle, x, w.across), y, w.along),
                            -1.01f * job->radius, d),
        .direction = d,
        .flux = {share * (float)e[0], share * (float)e[1], share * (float)e[2]}};
}

static struct start start_sky(const struct job *job, const struct source *s, struct numbers n)
{
    struct vec3f radiance;
    const struct vec3f to = sky_draw(job, n.c, n.d, &radiance), d = vec3f_scale(-1, to);
    const struct vec3f axis = fabsf(d.x) <= fabsf(d.y) ? (struct vec3f){1, 0, 0}
                                                       : (struct vec3f){0, 1, 0};
    const struct vec3f across = vec3f_normalize(vec3f_cross(d, axis)),
                       along = vec3f_cross(across, d);
    float x, y;
    angle_turn((float)n.a, &x, &y);
    const float r = sqrtf((float)n.b) * job->radius;
    return (struct start){
        .origin = vec3f_fma(vec3f_fma(vec3f_fma(job->middle, r * x, across), r * y, along),
                            1.01f * job->radius, to),
        .direction = d,
        .flux = vec3f_scale(disc_area(job) / (float)s->count, radiance)};
}

/* Over the sphere; of a spot, over its cone. */
static struct start start_punctual(const struct job *job, const struct source *s,
                                   const struct scene_light *light, float probability,
                                   struct numbers n)
{
    const bool spot = light->kind == SCENE_SPOT;
    const double lowest = spot ? light->cos_outer : -1;
    const float z = (float)(1 - (double)n.d * (1 - lowest)), r = sqrtf(float_most(1 - z * z, 0));
    const struct vec3f axis = spot ? direction_of(light) : (struct vec3f){0, 0, 1};
    const struct vec3f helper = fabsf(axis.x) <= fabsf(axis.y) ? (struct vec3f){1, 0, 0}
                                                               : (struct vec3f){0, 1, 0};
    const struct vec3f across = vec3f_normalize(vec3f_cross(axis, helper)),
                       along = vec3f_cross(across, axis);
    float x, y;
    angle_turn(n.c, &x, &y);
    const struct vec3f d = vec3f_fma(vec3f_fma(vec3f_scale(z, axis), r * x, across), r * y, along);
    const double away[3] = {light->position.x + (double)d.x, light->position.y + (double)d.y,
                            light->position.z + (double)d.z},
                 position[3] = {light->position.x, light->position.y, light->position.z};
    double to_light[3], distance, rgb[3];
    scene_light_at(light, away, to_light, &distance, rgb);
    const double share = 2 * ANGLE_PI * (1 - lowest) * distance * distance * job->tracer->scale *
                         job->tracer->scale / ((double)probability * s->count);
    return (struct start){
        .origin = trace_to_local(job->tracer, position),
        .direction = d,
        .flux = {(float)(share * rgb[0]), (float)(share * rgb[1]), (float)(share * rgb[2])}};
}

static struct start start_tree(const struct job *job, const struct source *s, struct numbers n)
{
    struct lights_choice choice;
    if (!lights_sample(job->lights, job->tracer, NULL, n.a, (float)n.b, &choice))
        return (struct start){0};
    if (choice.punctual)
        return start_punctual(job, s, choice.punctual, choice.probability, n);
    const bool both = !job->lights->front_only;
    const bool back = both && n.c >= 0.5f;
    if (both)
        n.c = 2 * n.c - (back ? 1.0f : 0.0f);
    const struct vec3f normal = vec3f_scale(back ? -1.0f : 1.0f, choice.point.normal);
    struct vec3f radiance = trace_point_emission(job->tracer, &choice.point);
    if (job->tracer->has_alpha)
        radiance = vec3f_scale(1 - trace_point_transparency(job->tracer, &choice.point), radiance);
    const float share = (float)ANGLE_PI * (both ? 2.0f : 1.0f) / (choice.density * (float)s->count);
    return (struct start){.origin = trace_leave(choice.point.position, 0, normal),
                          .direction = direction_by_cosine(normal, n.d, n.c),
                          .flux = vec3f_scale(share, radiance)};
}

static struct start start_of(const struct job *job, uint32_t particle)
{
    size_t i = 0;
    while (i + 1 < job->sources && particle >= job->source[i].first + job->source[i].count)
        i++;
    const struct source *s = &job->source[i];
    const uint32_t seed = sobol_mix((uint32_t)job->settings->seed,
                                    (uint32_t)(job->settings->seed >> 32) + (uint32_t)i);
    uint32_t bits[4];
    sobol_pair(particle - s->first, sobol_mix(seed, 0), &bits[0], &bits[1]);
    sobol_pair(particle - s->first, sobol_mix(seed, 1), &bits[2], &bits[3]);
    const struct numbers n = {.a = bits[0] * 0x1p-32,
                              .b = bits[1] * 0x1p-32,
                              .c = (float)(bits[2] >> 8) * 0x1p-24f,
                              .d = (float)(bits[3] >> 8) * 0x1p-24f};
    return s->kind == SUN   ? start_sun(job, s, n)
           : s->kind == SKY ? start_sky(job, s, n)
                            : start_tree(job, s, n);
}

/* -- flight ------------------------------------------------------------------------------------ */

/* Particles of a wave that go on. */
struct flight {
    size_t count;
    uint32_t particle[TRACE_WAVE];
    struct vec3f flux[TRACE_WAVE];
    struct random random[TRACE_WAVE];
    struct trace_rays ray;
};

static void fly_on(struct flight *f, uint32_t particle, struct random random, struct start start,
                   bool alpha)
{
    const size_t i = f->count++;
    f->particle[i] = particle;
    f->flux[i] = start.flux;
    f->ray.salt[i] = alpha ? random_u32(&random) : 0;
    f->random[i] = random;
    wave_put(&f->ray.origin, i, start.origin);
    wave_put(&f->ray.direction, i, start.direction);
    f->ray.most[i] = INFINITY;
}

/* Whether a particle is scattered at its hit; *start: how it goes on. */
static bool scatters(const struct job *job, const struct trace_points *at, size_t i,
                     const struct particle_hit *hit, struct random *random, struct start *start)
{
    const struct vec3f albedo = trace_albedo(job->tracer, at, i);
    const float chance = float_least(vec3f_most(albedo), 1);
    if (!(random_float(random) < chance))
        return false;
    const float u = random_float(random), turn = random_float(random);
    *start = (struct start){.origin = trace_leave(hit->position, at->distance[i], hit->normal),
                            .direction = direction_by_cosine(hit->normal, u, turn),
                            .flux = vec3f_scale(1 / chance, vec3f_mul(hit->flux, albedo))};
    return true;
}

/* One hit of each particle; those that are scattered are left in the flight. */
static struct error *fly(const struct job *job, struct flight *f, uint32_t bounce,
                         struct particles *to, size_t *capacity)
{
    struct trace_points at;
    const size_t count = f->count;
    trace_rays_nearest(job->tracer, count, &f->ray, &at);
    struct error *err = array_reserve(&to->hit, capacity, to->count + count, sizeof *to->hit);
    f->count = 0;
    for (size_t i = 0; i < count && !err; i++) {
        if (!at.hit[i])
            continue;
        struct particle_hit *hit = &to->hit[to->count++];
        *hit = (struct particle_hit){
            .position = wave_get(&at.position, i),
            .normal = vec3f_scale(at.front[i] ? 1.0f : -1.0f, wave_get(&at.normal, i)),
            .flux = f->flux[i],
            .particle = f->particle[i],
            .bounce = bounce,
            .instance = at.instance[i],
            .triangle = at.triangle[i],
            .b = at.b[i],
            .c = at.c[i]};
        struct random random = f->random[i];
        struct start start;
        if (scatters(job, &at, i, hit, &random, &start))
            fly_on(f, hit->particle, random, start, job->tracer->has_alpha);
    }
    return err;
}

static struct error *trace_block(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct flight f = {.count = 0};
    const size_t first = index * TRACE_WAVE;
    for (size_t i = first; i < first + TRACE_WAVE && i < job->settings->count; i++) {
        const struct start start = start_of(job, (uint32_t)i);
        if (vec3f_most(start.flux) > 0)
            fly_on(&f, (uint32_t)i, random_start(job->settings->seed, NAME, (uint32_t)i), start,
                   job->tracer->has_alpha);
    }
    struct error *err = NULL;
    size_t capacity = 0;
    for (int bounce = 1; bounce <= job->settings->bounces && f.count && !err; bounce++)
        err = fly(job, &f, (uint32_t)bounce, &job->block[index], &capacity);
    return err;
}

/* The hits of all blocks, in order. */
static struct error *gather(const struct job *job, size_t blocks, struct particles *to)
{
    size_t count = 0;
    for (size_t i = 0; i < blocks; i++)
        count += job->block[i].count;
    struct error *err = array_create(&to->hit, count, sizeof *to->hit);
    for (size_t i = 0; i < blocks && !err; i++) {
        if (job->block[i].count)
            memcpy(to->hit + to->count, job->block[i].hit, job->block[i].count * sizeof *to->hit);
        to->count += job->block[i].count;
    }
    return err;
}

struct error *particles_trace(const struct tracer *tracer, const struct lights *lights,
                              const struct sky *sky, const struct particles_settings *settings,
                              struct particles *particles)
{
    const struct scene *scene = tracer->scene;
    *particles = (struct particles){0};
    struct job job = {.tracer = tracer, .lights = lights, .sky = sky, .settings = settings};
    if (scene->box_min.x > scene->box_max.x)
        return NULL;
    const struct vec3f low = trace_to_local(
                           tracer,
                           (const double[3]){scene->box_min.x, scene->box_min.y, scene->box_min.z}),
                       high = trace_to_local(
                           tracer,
                           (const double[3]){scene->box_max.x, scene->box_max.y, scene->box_max.z});
    job.half = vec3f_scale(0.5f, vec3f_sub(high, low));
    job.middle = vec3f_add(low, job.half);
    job.radius = vec3f_length(job.half);
    const size_t blocks = (settings->count + TRACE_WAVE - 1) / TRACE_WAVE;
    struct error *err = set_sources(&job);
    if (!err && job.sources)
        err = array_create(&job.block, blocks, sizeof *job.block);
    if (!err && job.sources)
        err = threads_for(settings->threads, blocks, trace_block, &job);
    if (!err && job.sources)
        err = gather(&job, blocks, particles);
    particles->sent = job.sources ? settings->count : 0;
    for (size_t i = 0; i < job.sources; i++)
        particles->sun_area = fmaxf(particles->sun_area, sun_area(&job, &job.source[i]));
    for (size_t i = 0; i < blocks && job.block; i++)
        free(job.block[i].hit);
    free(job.block);
    free(job.source);
    return err;
}

void particles_clear(struct particles *particles)
{
    free(particles->hit);
    *particles = (struct particles){0};
}
