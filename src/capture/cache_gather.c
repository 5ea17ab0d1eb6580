/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/cache_gather.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "capture/ask_lit.h"
#include "capture/cache_spots.h"
#include "capture/cache_points.h"
#include "capture/capture.h"
#include "math/angle.h"
#include "math/random.h"
#include "math/sobol.h"
#include "trace/cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SPOT_RAYS = 8, /* of each place on a disc, at the least */
    SKY_RAYS = 4   /* and for each of them, that look for the sky alone */
};

struct gathering {
    const struct path_tracer *path;
    const struct cache_points *points;
    const struct cache_spots *spots;
    uint64_t seed;
    int rays;
    /* 3 a point: all that comes without a link, the same of the first half of the rays, and both of
     * the sky alone */
    float *direct, *half, *sky, *half_sky;
    struct cache_link *link;
    float *scatters; /* 2 a point: of its links by their shares, and these */
};

static void add_light(struct vec3f light, bool is_half, double sum[3], double half[3])
{
    const double rgb[3] = {(double)light.x, (double)light.y, (double)light.z};
    for (int k = 0; k < 3; k++) {
        sum[k] += rgb[k];
        half[k] += is_half ? rgb[k] : 0;
    }
}

/* What sunlit points bring to a receiver which leaves them their share. */
static struct error *gather_lit(const struct gathering *g, const struct path_tracer *path,
                                struct path_receiver *receiver, uint64_t name, double sum[3],
                                double half[3])
{
    struct ask_lit ask = {path, path->cache->lit,    receiver, g->seed,
                          name, 3u << 30 | 3u << 28, NULL};
    struct error *err = ask_lit_start(&ask, g->rays);
    const int count = g->rays;
    for (int first = 0; first < count && receiver->lit && !err; first += PATH_WAVE) {
        const int now = count - first < PATH_WAVE ? count - first : PATH_WAVE;
        struct path_found found[PATH_WAVE];
        int place[PATH_WAVE];
        for (int i = 0; i < now; i++)
            place[i] = first + i;
        ask_lit_wave(&ask, count, (size_t)now, place, found);
        for (int i = 0; i < now; i++) {
            const float cosine = vec3f_dot(found[i].direction, receiver->at.normal);
            add_light(vec3f_scale(float_most(cosine, 0) / (float)ANGLE_PI, found[i].light), i % 2,
                      sum, half);
        }
    }
    ask_lit_end(&ask);
    return err;
}

/* Of the rays that a point has, those from `ray` on that start at one place of its disc: how many,
 * and there. Places are hits, every other of them for the first half of the rays; the middle where
 * there are too few. */
static int spot(const struct gathering *g, const struct path_tracer *path, size_t index, int ray,
                int rays, struct path_receiver *receiver)
{
    const uint32_t first = g->spots->first[index], count = g->spots->first[index + 1] - first;
    const int most = rays / SPOT_RAYS, left = rays - ray,
              places = count < (uint32_t)most ? (int)count : most, even = (places + 1) / 2;
    if (places < 2)
        return left < PATH_WAVE ? left : PATH_WAVE;
    const int place = (int)((int64_t)ray * places / rays),
              end = (int)(((int64_t)(place + 1) * rays + places - 1) / places),
              at = place < even ? 2 * place : 2 * (place - even) + 1;
    const size_t hit = g->spots->hit[first + (uint32_t)at * count / (uint32_t)places];
    const double *p = g->points->hit_position + 3 * hit;
    const float *n = g->points->hit_normal + 3 * hit;
    receiver->at.normal = vec3f_normalize((struct vec3f){n[0], n[1], n[2]});
    receiver->at.position = trace_start(path->tracer, p, receiver->at.normal);
    return end - ray < PATH_WAVE ? end - ray : PATH_WAVE;
}

/* What comes straight from the sky, which rays that nothing else is asked of tell. */
static void gather_sky(const struct gathering *g, const struct path_tracer *path, size_t index,
                       struct path_receiver receiver, uint64_t name, double sum[3], double half[3])
{
    const uint32_t pair = (uint32_t)(name ^ name >> 32) ^ (uint32_t)g->seed ^ 0x9e3779b9;
    const int count = SKY_RAYS * g->rays;
    for (int first = 0, now; first < count && path->cache->sky; first += now) {
        now = spot(g, path, index, first, count, &receiver);
        struct vec3f direction[PATH_WAVE];
        struct random random[PATH_WAVE];
        struct path_found found[PATH_WAVE];
        for (int i = 0; i < now; i++) {
            uint32_t x, y;
            sobol_pair((uint32_t)(first + i), pair, &x, &y);
            direction[i] = direction_by_cosine(receiver.at.normal, (float)(x >> 8) * 0x1p-24f,
                                               (float)(y >> 8) * 0x1p-24f);
            random[i] = random_start(g->seed, name, 3u << 30 | 1u << 28 | (uint32_t)(first + i));
        }
        path_open(path, &receiver, &(struct path_rays){(size_t)now, direction, random, false},
                  found);
        for (int i = 0; i < now; i++)
            add_light(found[i].light, first + i < count / 2, sum, half);
    }
}

static struct error *gather(void *context, size_t index, int thread)
{
    (void)thread;
    const struct gathering *g = context;
    if (interrupt_came())
        return NULL;
    const double *p = g->points->position + 3 * index;
    const float *n = g->points->normal + 3 * index;
    const struct path_tracer *path;
    struct error *err = path_near(g->path, p, &path);
    if (err)
        return err;
    struct path_receiver receiver = {.lights_share = 1, .sky_share = 1};
    receiver.at.normal = vec3f_normalize((struct vec3f){n[0], n[1], n[2]});
    receiver.at.position = trace_start(path->tracer, p, receiver.at.normal);
    const uint64_t name = random_hash_position(p);
    const uint32_t pair = (uint32_t)(name ^ name >> 32) ^ (uint32_t)g->seed;
    double sum[3] = {0}, half[3] = {0}, sky[3] = {0}, half_sky[3] = {0};
    gather_sky(g, path, index, receiver, name, sky, half_sky);
    err = gather_lit(g, path, &receiver, name, sum, half);
    if (err)
        return err;
    for (int first = 0, now; first < g->rays; first += now) {
        struct vec3f direction[PATH_WAVE];
        struct random random[PATH_WAVE];
        struct path_sample sample[PATH_WAVE];
        size_t count = 0;
        now = spot(g, path, index, first, g->rays, &receiver);
        for (int i = first; i < first + now; i++, count++) {
            uint32_t x, y;
            sobol_pair((uint32_t)i, pair, &x, &y);
            direction[count] = direction_by_cosine(receiver.at.normal, (float)(x >> 8) * 0x1p-24f,
                                                   (float)(y >> 8) * 0x1p-24f);
            random[count] = random_start(g->seed, name, 3u << 30 | 1u << 29 | (uint32_t)i);
        }
        path_samples(path, &receiver, &(struct path_rays){count, direction, random, false}, sample);
        for (size_t i = 0; i < count; i++) {
            const bool is_half = (size_t)first + i < (size_t)g->rays / 2;
            add_light(sample[i].scattered, is_half, sum, half);
            const struct cache_link *link = &sample[i].link;
            if (link->disc != CACHE_NONE) {
                g->scatters[2 * index] += link->share[1] * (float)sample[i].scatters;
                g->scatters[2 * index + 1] += link->share[1];
            }
            g->link[index * (size_t)g->rays + (size_t)first + i] = *link;
        }
    }
    const double whole = ANGLE_PI / g->rays, part = ANGLE_PI / (g->rays / 2);
    for (size_t k = 0; k < 3; k++) {
        g->sky[3 * index + k] = (float)(whole / SKY_RAYS * sky[k]);
        g->half_sky[3 * index + k] = (float)(part / SKY_RAYS * half_sky[k]);
        g->direct[3 * index + k] = (float)(whole * sum[k]) + g->sky[3 * index + k];
        g->half[3 * index + k] = (float)(part * half[k]) + g->half_sky[3 * index + k];
    }
    return NULL;
}

/* How often light is passed on from disc to disc so that it scatters `most` times: oftener than
 * once on many links, whose paths went on where no disc was. */
static int passes(const struct gathering *g, int most)
{
    double scatters = 0, shares = 0;
    for (size_t i = 0; i < g->points->count; i++) {
        scatters += (double)g->scatters[2 * i];
        shares += (double)g->scatters[2 * i + 1];
    }
    return scatters > 0 ? (int)fmax(round(most * shares / scatters), 1) : most;
}

struct error *cache_gather(struct path_cache *cache, const struct cache_points *points,
                           int ray_count, struct path_tracer *path,
                           const struct capture_settings *settings, int threads, float **half_value)
{
    const size_t count = points->count;
    const int after = cache->after;
    struct cache_spots spots = {0};
    struct gathering g = {
        .path = path, .points = points, .spots = &spots, .seed = settings->seed, .rays = ray_count};
    const size_t rays = (size_t)ray_count, half = rays / 2;
    float *value = NULL;
    struct error *err = array_create(&g.direct, 3 * count, sizeof *g.direct);
    if (!err)
        err = array_create(&g.half, 3 * count, sizeof *g.half);
    if (!err)
        err = array_create(&g.sky, 3 * count, sizeof *g.sky);
    if (!err)
        err = array_create(&g.half_sky, 3 * count, sizeof *g.half_sky);
    if (!err)
        err = array_create(&g.scatters, 2 * count, sizeof *g.scatters);
    if (!err)
        err = array_create(half_value, 3 * count, sizeof **half_value);
    if (!err)
        err = array_create(&g.link, count * (size_t)g.rays, sizeof *g.link);
    if (!err)
        err = array_create(&value, 3 * count, sizeof *value);
    if (!err)
        err = cache_spots_find(&spots, points, cache->discs);
    const bool sky = cache->sky = cache->opens;
    cache->after = 1; /* each pass is of one scatter */
    path_use_cache(path, cache);
    if (!err)
        err = threads_for(threads, count, gather, &g);
    path_use_cache(path, NULL);
    cache->after = after;
    const int most = err ? 0 : passes(&g, settings->bounces - after);
    if (!err)
        err =
            cache_solve(count, g.rays, sky ? g.sky : NULL, g.direct, g.link, most, threads, value);
    for (size_t i = 1; i < count && !err; i++)
        memmove(g.link + i * half, g.link + i * rays, half * sizeof *g.link);
    if (!err)
        err = cache_solve(count, (int)half, sky ? g.half_sky : NULL, g.half, g.link, most, threads,
                          *half_value);
    cache->value = value;
    cache_spots_clear(&spots);
    free(g.scatters);
    free(g.half_sky);
    free(g.sky);
    free(g.half);
    free(g.direct);
    free(g.link);
    return err;
}
