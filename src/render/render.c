/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Kajiya, "The rendering equation", SIGGRAPH 1986.
 * M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018: R2, the sequence of
 * the plastic number.
 */
#include "render/render.h"
#include "base/array.h"
#include "base/error.h"
#include "base/progress.h"
#include "base/threads.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PIXELS = RENDER_TILE * RENDER_TILE };

/* -- rays ------------------------------------------------------------------------------------- */

static double scene_size(const struct scene *scene)
{
    return vec3_length(vec3_sub(scene->box_max, scene->box_min));
}

/* From near the scene, however far the eye is. */
struct render_ray render_ray(const struct render *r, struct vec3 direction)
{
    const struct tracer *t = r->path->tracer;
    const struct vec3 centre = vec3_scale(0.5, vec3_add(t->scene->box_min, t->scene->box_max));
    const double skipped =
        fmax(vec3_dot(vec3_sub(centre, r->camera->eye), direction) - scene_size(t->scene), 0);
    double start[3];
    vec3_store(start, vec3_fma(r->camera->eye, skipped, direction));
    return (struct render_ray){
        .origin = trace_to_local(t, start),
        .skipped = skipped,
        .direction = {(float)direction.x, (float)direction.y, (float)direction.z}};
}

/* -- samples ---------------------------------------------------------------------------------- */

/* A thread's work on a tile. */
struct tile {
    const struct render *render;
    struct path_tracer direct; /* of one bounce */
    enum render_light light;
    /* where the next lookup starts; the tile's first starts cold, so that no other tile matters */
    struct probe_place place;
};

/* Sums over a pixel's samples. */
struct pixel {
    size_t x, y;
    double shift[2]; /* of its samples' places */
    double sum[3], square[3], luminance_square;
    int samples;
    bool wanted; /* more */
};

/* Samples that go together from one origin: whose they are, their directions, and what their paths
 * are random by. */
struct wave {
    size_t count;
    struct vec3f origin;
    struct pixel *pixel[PATH_WAVE];
    struct vec3f direction[PATH_WAVE];
    struct random random[PATH_WAVE];
};

/* What the probes make of point i of a wave. */
static struct vec3f lit_by_probes(struct tile *tile, const struct trace_points *at, size_t i,
                                  struct vec3f direction)
{
    const struct render *r = tile->render;
    const struct tracer *t = r->path->tracer;
    const bool of_object = at->instance[i] >= r->object.first;
    const struct vec3 position = trace_to_world(t, wave_get(&at->position, i));
    const struct vec3f facing = wave_get(&at->normal, i);
    struct vec3 normal = {(double)facing.x, (double)facing.y, (double)facing.z};
    if (vec3f_dot(facing, direction) > 0)
        normal = vec3_scale(-1, normal);
    if (of_object && r->object.sphere)
        normal = vec3_normalize(vec3_sub(position, r->object.centre));
    double p[3], n[3], e[3];
    vec3_store(n, normal);
    vec3_store(p, of_object && !r->object.per_pixel ? r->object.centre
                                                    : vec3_fma(position, r->offset, normal));
    baked_irradiance(r->baked, &tile->place, p, n, e);
    const struct vec3f irradiance = {(float)(e[0] / ANGLE_PI), (float)(e[1] / ANGLE_PI),
                                     (float)(e[2] / ANGLE_PI)};
    return vec3f_mul(trace_albedo(t, at, i), irradiance);
}

/* Adds the light of the probes to the samples of a wave. */
static void add_probes(struct tile *tile, const struct wave *w, struct vec3f *light)
{
    const struct tracer *t = tile->render->path->tracer;
    struct trace_rays rays;
    struct trace_points at;
    for (size_t i = 0; i < w->count; i++) {
        struct random random = w->random[i];
        wave_put(&rays.origin, i, w->origin);
        wave_put(&rays.direction, i, w->direction[i]);
        rays.most[i] = INFINITY;
        /* as path_samples draws it, so that both meet the same surfaces */
        rays.salt[i] = t->has_alpha ? random_u32(&random) : 0;
    }
    trace_rays_nearest(t, w->count, &rays, &at);
    for (size_t i = 0; i < w->count; i++)
        if (at.hit[i])
            light[i] = vec3f_add(light[i], lit_by_probes(tile, &at, i, w->direction[i]));
}

/* The light of a wave's samples. */
static void take_wave(struct tile *tile, const struct wave *w, struct vec3f *light)
{
    const struct path_tracer *path = tile->light == RENDER_DIRECT || tile->light == RENDER_MIXED
                                         ? &tile->direct
                                         : tile->render->path;
    const struct path_receiver receiver = {.at = {.position = w->origin}};
    const struct path_rays rays = {.count = w->count,
                                   .direction = w->direction,
                                   .random = w->random,
                                   .straight_alone = tile->light == RENDER_PROBES};
    struct path_sample sample[PATH_WAVE];
    path_samples(path, &receiver, &rays, sample);
    for (size_t i = 0; i < w->count; i++)
        light[i] = vec3f_add(sample[i].straight, sample[i].scattered);
    if (tile->light == RENDER_PROBES || tile->light == RENDER_MIXED)
        add_probes(tile, w, light);
}

/* Takes what waits, and adds it to its pixels. */
static void end_wave(struct tile *tile, struct wave *w)
{
    struct vec3f light[PATH_WAVE];
    take_wave(tile, w, light);
    for (size_t i = 0; i < w->count; i++) {
        struct pixel *p = w->pixel[i];
        const double rgb[3] = {(double)light[i].x, (double)light[i].y, (double)light[i].z},
                     luminance = (double)luminance_vec3f(light[i]);
        for (int k = 0; k < 3; k++) {
            p->sum[k] += rgb[k];
            p->square[k] += rgb[k] * rgb[k];
        }
        p->luminance_square += luminance * luminance;
    }
    w->count = 0;
}

static uint64_t pixel_name(const struct pixel *p)
{
    return (uint64_t)p->y << 32 | p->x;
}

/* Adds a pixel's next sample to a wave, after what waits in it where that does not go with it. */
static void add_sample(struct tile *tile, struct wave *w, struct pixel *p)
{
    const struct render *r = tile->render;
    const double across = p->shift[0] + 0.75487766624669276 * p->samples,
                 down = p->shift[1] + 0.56984029099805327 * p->samples;
    const struct vec3 direction = camera_direction(r->camera, (double)p->x + across - floor(across),
                                                   (double)p->y + down - floor(down));
    const struct render_ray ray = render_ray(r, direction);
    if (w->count == PATH_WAVE || (w->count && ray.skipped > 0)) /* that has an origin of its own */
        end_wave(tile, w);
    w->origin = ray.origin;
    w->pixel[w->count] = p;
    w->direction[w->count] = ray.direction;
    w->random[w->count++] = random_start(r->seed, pixel_name(p), (uint32_t)p->samples++);
    if (ray.skipped > 0)
        end_wave(tile, w);
}

/* Adds a round of samples to each pixel that wants more. */
static void add_round(struct tile *tile, struct pixel *pixel, size_t count)
{
    struct wave w = {.count = 0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < tile->render->samples && pixel[i].wanted; k++)
            add_sample(tile, &w, &pixel[i]);
    if (w.count)
        end_wave(tile, &w);
}

/* -- a tile ----------------------------------------------------------------------------------- */

/* Variance of a mean of n. */
static double variance_of_mean(double sum, double square, int n)
{
    return n > 1 ? fmax(square - sum * sum / n, 0) / n / (n - 1) : 0;
}

/* Decides which pixels of a tile need more. The variance is a mean over neighbours, since a pixel
 * alone that has not met the bright thing that others met would think that it was done. */
static bool want_more(const struct render *r, struct pixel *pixel, size_t width, size_t height)
{
    double variance[PIXELS], mean = 0;
    bool any = false;
    for (size_t i = 0; i < width * height; i++) {
        variance[i] = variance_of_mean(luminance_f64(pixel[i].sum), pixel[i].luminance_square,
                                       pixel[i].samples);
        mean += luminance_f64(pixel[i].sum) / pixel[i].samples / (double)(width * height);
    }
    for (size_t i = 0; i < width * height; i++) {
        const size_t x = i % width, y = i / width;
        double around = 0;
        int count = 0;
        for (size_t row = y ? y - 1 : 0; row <= y + 1 && row < height; row++)
            for (size_t column = x ? x - 1 : 0; column <= x + 1 && column < width;
                 column++, count++)
                around += variance[row * width + column];
        const double level = fmax(luminance_f64(pixel[i].sum) / pixel[i].samples, 0.1 * mean);
        pixel[i].wanted = sqrt(around / count) > r->error * level &&
                          pixel[i].samples + r->samples <= r->samples_most;
        any = any || pixel[i].wanted;
    }
    return any;
}

struct job {
    const struct render *render;
    enum render_light light;
    const struct picture *picture, *variance;
    struct progress *progress;
};

static size_t tiles_across(const struct camera *camera)
{
    return (camera->width + RENDER_TILE - 1) / RENDER_TILE;
}

size_t render_tiles(const struct camera *camera)
{
    return tiles_across(camera) * ((camera->height + RENDER_TILE - 1) / RENDER_TILE);
}

static struct error *store_pixel(const struct job *job, const struct pixel *pixel)
{
    float mean[3], variance[3];
    for (int k = 0; k < 3; k++) {
        mean[k] = (float)(pixel->sum[k] / pixel->samples);
        variance[k] = (float)variance_of_mean(pixel->sum[k], pixel->square[k], pixel->samples);
        if (!isfinite(mean[k]) || !isfinite(variance[k]))
            return error_new("pixel (%zu, %zu): light is beyond what 32 bits can hold: "
                             "--light-scale brings light down",
                             pixel->x, pixel->y);
    }
    picture_set(job->picture, pixel->x, pixel->y, (struct vec3f){mean[0], mean[1], mean[2]});
    if (job->variance)
        picture_set(job->variance, pixel->x, pixel->y,
                    (struct vec3f){variance[0], variance[1], variance[2]});
    return NULL;
}

static struct error *take_tile(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    const struct render *r = job->render;
    const struct camera *camera = r->camera;
    struct tile tile = {
        .render = r, .direct = *r->path, .light = job->light, .place = {.cell = PROBE_COLD}};
    struct pixel pixel[PIXELS];
    const size_t left = index % tiles_across(camera) * RENDER_TILE,
                 top = index / tiles_across(camera) * RENDER_TILE;
    const size_t width = camera->width - left < RENDER_TILE ? camera->width - left : RENDER_TILE;
    const size_t height = camera->height - top < RENDER_TILE ? camera->height - top : RENDER_TILE;
    tile.direct.bounces = tile.direct.bounces < 1 ? tile.direct.bounces : 1;
    for (size_t i = 0; i < width * height; i++) {
        pixel[i] = (struct pixel){.x = left + i % width, .y = top + i / width, .wanted = true};
        struct random random = random_start(r->seed, pixel_name(&pixel[i]), UINT32_MAX);
        for (int k = 0; k < 2; k++)
            pixel[i].shift[k] = random_double(&random);
    }
    for (bool more = true; more; more = r->error > 0 && want_more(r, pixel, width, height))
        add_round(&tile, pixel, width * height);
    struct error *err = NULL;
    for (size_t i = 0; i < width * height && !err; i++)
        err = store_pixel(job, &pixel[i]);
    progress_add(job->progress, 1);
    return err;
}

struct error *render_picture(const struct render *r, enum render_light light,
                             struct picture *picture, struct picture *variance,
                             struct progress *progress)
{
    const struct scene *scene = r->path->tracer->scene;
    const struct vec3 centre = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    *picture = (struct picture){0};
    if (variance)
        *variance = (struct picture){0};
    if (!(vec3_length(vec3_sub(r->camera->eye, centre)) <= 1e9 * scene_size(scene)))
        return error_new("the eye is farther out than 1e9 times the scene's size: (%g, %g, %g)",
                         r->camera->eye.x, r->camera->eye.y, r->camera->eye.z);
    struct error *err = picture_init(picture, r->camera->width, r->camera->height);
    if (!err && variance)
        err = picture_init(variance, r->camera->width, r->camera->height);
    struct render near = *r;
    if (!err)
        err = path_near(r->path,
                        (const double[3]){r->camera->eye.x, r->camera->eye.y, r->camera->eye.z},
                        &near.path);
    struct job job = {.render = &near,
                      .light = light,
                      .picture = picture,
                      .variance = variance,
                      .progress = progress};
    return err ? err : threads_for(r->threads, render_tiles(r->camera), take_tile, &job);
}
