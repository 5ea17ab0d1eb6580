/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/cache_points.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/discs.h"
#include "math/angle.h"
#include "math/random.h"
#include "trace/path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    RAYS_MOST = 1 << 17, /* of all probes */
    RAYS_EACH = 128,     /* of one, at the most */
    LEVELS = 7,          /* of points' sizes, each half of the one above */
    BEHIND_RAYS = 4,
    ROOM_RAYS = 24, /* of a point, twice, that look how near surfaces are */
    TRIES = 4,      /* sizes that are tried */
    FINER = 8       /* times that holes get finer points */
};

/* Cosine of the angle up to which two sides face alike, as discs have it. */
static const float alike = 0.5f;

/* -- hits -------------------------------------------------------------------------------------- */

struct hit {
    double position[3];
    float normal[3];
    float distance;
    uint64_t name; /* that of the probe, and the ray: decides between equals */
    uint32_t ray;
};

struct pilot {
    const struct path_tracer *path;
    const struct cache_probes *probes;
    const size_t *probe; /* that take part */
    uint64_t seed;
    int rays;
    struct hit *hit; /* `rays` a probe; distance 0: none */
};

static struct error *shoot(void *context, size_t index, int thread)
{
    (void)thread;
    const struct pilot *pilot = context;
    const struct cache_probes *probes = pilot->probes;
    const size_t number = pilot->probe[index];
    const double *p = probes->position + 3 * number;
    const float *n = probes->normal ? probes->normal + 3 * number : NULL;
    const struct path_tracer *path;
    struct error *err = path_near(pilot->path, p, &path);
    struct path_receiver receiver = {0};
    if (err)
        return err;
    if (n)
        receiver.at.normal = vec3f_normalize((struct vec3f){n[0], n[1], n[2]});
    receiver.at.position = trace_start(path->tracer, p, receiver.at.normal);
    const uint64_t name = random_hash_position(p);
    for (int first = 0; first < pilot->rays; first += PATH_WAVE) {
        struct vec3f direction[PATH_WAVE];
        struct random random[PATH_WAVE];
        struct path_sample sample[PATH_WAVE];
        size_t count = 0;
        for (int i = first; i < pilot->rays && count < PATH_WAVE; i++, count++) {
            struct random *r = &random[count];
            *r = random_start(pilot->seed, name, 3u << 30 | (uint32_t)i);
            const float x = random_float(r), y = ((float)i + random_float(r)) / (float)pilot->rays;
            if (n) {
                direction[count] = direction_by_cosine(receiver.at.normal, y, x);
            } else {
                const float z = 2 * y - 1, across = sqrtf(float_most(1 - z * z, 0));
                float c, s;
                angle_turn(x, &c, &s);
                direction[count] = (struct vec3f){across * c, across * s, z};
            }
        }
        path_samples(path, &receiver,
                     &(struct path_rays){count, direction, random, .straight_alone = true}, sample);
        for (size_t i = 0; i < count; i++) {
            struct hit *hit = &pilot->hit[index * (size_t)pilot->rays + (size_t)first + i];
            const struct path_sample *s = &sample[i];
            if (!s->hit)
                continue;
            const struct vec3f facing = vec3f_scale(s->front ? 1 : -1, s->normal);
            const struct vec3 at = trace_to_world(
                path->tracer,
                trace_leave(vec3f_fma(receiver.at.position, s->distance, direction[i]), s->distance,
                            facing));
            *hit = (struct hit){.position = {at.x, at.y, at.z},
                                .normal = {facing.x, facing.y, facing.z},
                                .distance = (float)((double)s->distance / path->tracer->scale),
                                .name = name,
                                .ray = (uint32_t)first + (uint32_t)i};
        }
    }
    return NULL;
}

struct named {
    uint64_t name;
    size_t probe;
};

static int by_name(const void *a, const void *b)
{
    const struct named *x = a, *y = b;
    return x->name != y->name ? (x->name > y->name ? 1 : -1)
                              : (x->probe > y->probe) - (x->probe < y->probe);
}

/* The probes that take part: by name, so that their order does not matter; one of each place. */
static struct error *choose(const struct cache_probes *probes, size_t most, size_t **chosen,
                            size_t *count)
{
    struct named *named = NULL;
    *count = 0;
    struct error *err = array_create(&named, probes->count, sizeof *named);
    if (!err)
        err = array_create(chosen, probes->count, sizeof **chosen);
    for (size_t i = 0; i < probes->count && !err; i++)
        named[i] = (struct named){random_hash_position(probes->position + 3 * i), i};
    if (!err)
        qsort(named, probes->count, sizeof *named, by_name);
    for (size_t i = 0; i < probes->count && *count < most && !err; i++)
        if (!i || named[i].name != named[i - 1].name)
            (*chosen)[(*count)++] = named[i].probe;
    free(named);
    return err;
}

static int coarse_first(const void *a, const void *b)
{
    const struct hit *x = a, *y = b;
    if (x->distance < y->distance || x->distance > y->distance)
        return x->distance < y->distance ? 1 : -1;
    if (x->name != y->name)
        return x->name > y->name ? 1 : -1;
    return (x->ray > y->ray) - (x->ray < y->ray);
}

static struct error *find_hits(const struct path_tracer *path, const struct cache_probes *probes,
                               uint64_t seed, int threads, struct hit **hits, size_t *count)
{
    size_t *probe = NULL, chosen = 0;
    struct pilot pilot = {.path = path, .probes = probes, .seed = seed};
    struct error *err = choose(probes, RAYS_MOST / 8, &probe, &chosen);
    *count = 0;
    if (!err && chosen) {
        pilot.probe = probe;
        pilot.rays = RAYS_MOST / (int)chosen < RAYS_EACH ? RAYS_MOST / (int)chosen : RAYS_EACH;
        err = array_create(&pilot.hit, chosen * (size_t)pilot.rays, sizeof *pilot.hit);
        if (!err)
            err = threads_for(threads, chosen, shoot, &pilot);
        for (size_t i = 0; i < chosen * (size_t)pilot.rays && !err; i++)
            if (pilot.hit[i].distance > 0)
                pilot.hit[(*count)++] = pilot.hit[i];
        qsort(pilot.hit, *count, sizeof *pilot.hit, coarse_first);
    }
    *hits = pilot.hit;
    free(probe);
    return err;
}

static struct error *keep_hits(struct cache_points *points, const struct hit *hit, size_t hits)
{
    struct error *err = array_create(&points->hit_position, 3 * hits, sizeof(double));
    if (!err)
        err = array_create(&points->hit_normal, 3 * hits, sizeof(float));
    for (size_t i = 0; i < hits && !err; i++) {
        memcpy(points->hit_position + 3 * i, hit[i].position, sizeof hit[i].position);
        memcpy(points->hit_normal + 3 * i, hit[i].normal, sizeof hit[i].normal);
    }
    points->hits = err ? 0 : hits;
    return err;
}

/* -- thinning ---------------------------------------------------------------------------------- */

/* Points by cells of a level, in chains. */
struct thin {
    const struct hit *hit;
    double cell; /* of the finest level */
    uint32_t *kept;
    size_t count;
    /* an entry is a point in a cell of a level */
    struct entry {
        int32_t cell[3], level;
        uint32_t hit, next;
    } * entry;
    size_t entries, capacity;
    uint32_t *slot;
    size_t slots; /* a power of 2 */
};

static size_t slot_of(const struct thin *t, const int32_t cell[3], int level)
{
    uint64_t h = (uint32_t)cell[0] * 0x9e3779b97f4a7c15u ^ (uint32_t)cell[1] * 0xc2b2ae3d27d4eb4fu ^
                 (uint32_t)cell[2] * 0x165667b19e3779f9u ^ (uint64_t)level * 0xd6e8feb86659fd93u;
    h = (h ^ h >> 32) * 0xd6e8feb86659fd93u;
    return (size_t)(h >> 32) & (t->slots - 1);
}

static void cell_of(const struct thin *t, const double p[3], int level, int32_t cell[3])
{
    const double side = ldexp(t->cell, level);
    for (int k = 0; k < 3; k++) {
        const double c = floor(p[k] / side);
        cell[k] = (int32_t)fmin(fmax(c, -0x1p30), 0x1p30);
    }
}

static bool is_taken(const struct thin *t, const struct hit *hit, double radius, int level)
{
    int32_t middle[3], cell[3];
    cell_of(t, hit->position, level, middle);
    for (cell[2] = middle[2] - 1; cell[2] <= middle[2] + 1; cell[2]++)
        for (cell[1] = middle[1] - 1; cell[1] <= middle[1] + 1; cell[1]++)
            for (cell[0] = middle[0] - 1; cell[0] <= middle[0] + 1; cell[0]++)
                for (uint32_t e = t->slot[slot_of(t, cell, level)]; e; e = t->entry[e - 1].next) {
                    const struct entry *entry = &t->entry[e - 1];
                    const struct hit *other = &t->hit[entry->hit];
                    double square = 0;
                    float facing = 0;
                    for (int k = 0; k < 3; k++) {
                        const double off = other->position[k] - hit->position[k];
                        square += off * off;
                        facing += other->normal[k] * hit->normal[k];
                    }
                    if (entry->level == level && square < radius * radius && facing > alike)
                        return true;
                }
    return false;
}

static struct error *keep(struct thin *t, uint32_t number, int level)
{
    const struct hit *hit = &t->hit[number];
    struct error *err = NULL;
    t->kept[t->count++] = number;
    for (int l = level; l >= 0 && !err; l--) {
        err = array_reserve(&t->entry, &t->capacity, t->entries + 1, sizeof *t->entry);
        if (err)
            break;
        struct entry *e = &t->entry[t->entries++];
        cell_of(t, hit->position, l, e->cell);
        uint32_t *slot = &t->slot[slot_of(t, e->cell, l)];
        e->level = l;
        e->hit = number;
        e->next = *slot;
        *slot = (uint32_t)t->entries;
    }
    return err;
}

/* The radius of a hit: of those that are very near or far, that of the rest. */
static double radius_of(const struct hit *hit, double size, double middle)
{
    return size * fmin(fmax((double)hit->distance, middle / 8), middle * 8);
}

static struct error *thin(struct thin *t, size_t hits, double size, double middle, size_t most)
{
    struct error *err = NULL;
    t->count = t->entries = 0;
    t->cell = size * middle / 8;
    memset(t->slot, 0, t->slots * sizeof *t->slot);
    for (uint32_t i = 0; i < hits && t->count < most && !err; i++) {
        const double radius = radius_of(&t->hit[i], size, middle);
        int level = (int)ceil(log2(radius / t->cell));
        level = level < 0 ? 0 : level >= LEVELS ? LEVELS - 1 : level;
        if (!is_taken(t, &t->hit[i], radius, level))
            err = keep(t, i, level);
    }
    return err;
}

/* Adds what was kept. */
static struct error *add_points(struct cache_points *points, const struct thin *t, double size,
                                double middle)
{
    const size_t before = points->count, count = before + t->count;
    size_t room[4] = {before, before, before, before};
    struct error *err =
        array_reserve(&points->position, &room[0], count, 3 * sizeof *points->position);
    if (!err)
        err = array_reserve(&points->normal, &room[1], count, 3 * sizeof *points->normal);
    if (!err)
        err = array_reserve(&points->radius, &room[2], count, sizeof *points->radius);
    if (!err)
        err = array_reserve(&points->reach, &room[3], count, sizeof *points->reach);
    for (size_t i = before; i < count && !err; i++) {
        const struct hit *hit = &t->hit[t->kept[i - before]];
        memcpy(points->position + 3 * i, hit->position, sizeof hit->position);
        memcpy(points->normal + 3 * i, hit->normal, sizeof hit->normal);
        points->reach[i] = (float)radius_of(hit, size, middle);
    }
    points->count = err ? before : count;
    return err;
}

/* -- room -------------------------------------------------------------------------------------- */

struct room {
    const struct path_tracer *path;
    const struct cache_points *points;
    uint64_t seed;
    size_t first; /* point that has none yet */
};

/* The elevation of a ray that looks along the surface: within the height that a disc covers. */
static float low_sine(struct random *r)
{
    const float x = random_float(r);
    return 0.004f + x * x / DISCS_FLAT;
}

/* How far behind a point another surface is, on which a disc could lie as well. */
static float find_behind(const struct path_tracer *path, const double p[3], struct vec3f normal,
                         uint64_t seed, uint64_t name)
{
    struct path_receiver receiver = {.at.normal = vec3f_scale(-1, normal)};
    receiver.at.position = trace_start(path->tracer, p, receiver.at.normal);
    struct vec3f direction[BEHIND_RAYS];
    struct random random[BEHIND_RAYS];
    struct path_sample sample[BEHIND_RAYS];
    float behind = INFINITY;
    for (uint32_t i = 0; i < BEHIND_RAYS; i++) {
        random[i] = random_start(seed, name, 15u << 28 | i);
        const float x = random_float(&random[i]) / 4,
                    y = ((float)i + random_float(&random[i])) / BEHIND_RAYS;
        direction[i] = direction_by_cosine(receiver.at.normal, x, y);
    }
    path_samples(path, &receiver, &(struct path_rays){BEHIND_RAYS, direction, random, true},
                 sample);
    for (size_t i = 0; i < BEHIND_RAYS; i++)
        behind = fminf(behind, sample[i].distance * -vec3f_dot(direction[i], normal));
    return behind;
}

/* A disc ends where other surfaces are, whose far sides have other light: before what stands on its
 * plane or hangs low above it, which half of the rays look for, along the surface, and no farther
 * than about the nearest of what the other half see, by the cosine. */
static struct error *make_room(void *context, size_t number, int thread)
{
    (void)thread;
    const struct room *room = context;
    const size_t index = room->first + number;
    const double *p = room->points->position + 3 * index;
    const float *n = room->points->normal + 3 * index;
    const struct path_tracer *path;
    struct error *err = path_near(room->path, p, &path);
    if (err)
        return err;
    struct path_receiver receiver = {.at.normal = {n[0], n[1], n[2]}};
    receiver.at.position = trace_start(path->tracer, p, receiver.at.normal);
    const uint64_t name = random_hash_position(p);
    struct vec3f direction[2 * ROOM_RAYS];
    struct random random[2 * ROOM_RAYS];
    struct path_sample sample[2 * ROOM_RAYS];
    for (size_t i = 0; i < 2 * ROOM_RAYS; i++) {
        struct random *r = &random[i];
        *r = random_start(room->seed, name, 7u << 29 | (uint32_t)i);
        const float stratum = ((float)(i % ROOM_RAYS) + random_float(r)) / ROOM_RAYS,
                    sine = low_sine(r);
        direction[i] = i < ROOM_RAYS
                           ? direction_by_cosine(receiver.at.normal, 1 - sine * sine, stratum)
                           : direction_by_cosine(receiver.at.normal, stratum, random_float(r));
    }
    path_samples(path, &receiver, &(struct path_rays){2 * ROOM_RAYS, direction, random, true},
                 sample);
    const float behind = find_behind(path, p, receiver.at.normal, room->seed, name);
    float along = INFINITY, nearest = INFINITY, second = INFINITY;
    for (size_t i = 0; i < ROOM_RAYS; i++) {
        const float d = sample[ROOM_RAYS + i].distance;
        along = fminf(along, sample[i].distance);
        second = fminf(second, fmaxf(nearest, d));
        nearest = fminf(nearest, d);
    }
    room->points->radius[index] =
        fminf(room->points->reach[index],
              (float)((double)fminf(fminf(along, second), DISCS_FLAT * behind) /
                      path->tracer->scale / 2));
    return NULL;
}

static struct error *give_room(struct cache_points *points, const struct path_tracer *path,
                               size_t first, uint64_t seed, int threads)
{
    struct room room = {path, points, seed, first};
    return threads_for(threads, points->count - first, make_room, &room);
}

struct error *cache_points_discs(const struct cache_points *points, const float *radius,
                                 struct discs **discs)
{
    float *twice = NULL;
    struct error *err = array_create(&twice, points->count, sizeof *twice);
    for (size_t i = 0; i < points->count && !err; i++)
        twice[i] = 2 * radius[i];
    const struct disc_points p = {points->count, points->position, points->normal, twice};
    if (!err)
        err = discs_create(discs, &p);
    free(twice);
    return err;
}

/* Leaves the hits that no disc covers; *count: how many. */
static struct error *keep_holes(const struct cache_points *points, struct hit *hit, size_t *count)
{
    struct discs *discs = NULL;
    struct error *err = cache_points_discs(points, points->radius, &discs);
    size_t left = 0;
    for (size_t i = 0; i < *count && !err; i++) {
        const float *n = hit[i].normal;
        const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
        if (!discs_covers(discs, hit[i].position, normal))
            hit[left++] = hit[i];
    }
    discs_destroy(discs);
    *count = left;
    return err;
}

/* Points with discs so small that they end where surfaces are near leave holes, which get finer
 * ones. */
static struct error *fill_holes(struct cache_points *points, const struct path_tracer *path,
                                struct thin *t, struct hit *hit, size_t *hits, double middle,
                                size_t most, uint64_t seed, int threads)
{
    double size = points->size;
    struct error *err = NULL;
    for (int i = 0; i < FINER && points->count < most && !err; i++) {
        const size_t first = points->count;
        size /= 2;
        err = keep_holes(points, hit, hits);
        if (!err)
            err = thin(t, *hits, size, middle, most - first);
        if (!err)
            err = add_points(points, t, size, middle);
        if (!err)
            err = give_room(points, path, first, seed, threads);
    }
    return err;
}

struct error *cache_points_find(struct cache_points *points, const struct path_tracer *path,
                                const struct cache_probes *probes, size_t most, double size,
                                uint64_t seed, int threads)
{
    struct hit *hit = NULL;
    size_t hits = 0;
    struct thin t = {.slots = 1};
    *points = (struct cache_points){0};
    struct error *err = find_hits(path, probes, seed, threads, &hit, &hits);
    if (!err)
        err = keep_hits(points, hit, hits);
    while (t.slots < 4 * most)
        t.slots *= 2;
    if (!err)
        err = array_create(&t.kept, hits, sizeof *t.kept);
    if (!err)
        err = array_create(&t.slot, t.slots, sizeof *t.slot);
    t.hit = hit;
    const double middle = hits ? (double)hit[hits / 2].distance : 0;
    for (int i = 0; i < TRIES && !err && hits; i++, size *= 1.4) {
        points->size = size;
        err = thin(&t, hits, size, middle, most);
        points->full = t.count >= most;
        if (!points->full)
            break;
    }
    if (!err)
        err = add_points(points, &t, points->size, middle);
    if (!err)
        err = give_room(points, path, 0, seed, threads);
    if (!err && points->count)
        err = fill_holes(points, path, &t, hit, &hits, middle, most, seed, threads);
    free(t.kept);
    free(t.slot);
    free(t.entry);
    free(hit);
    if (err)
        cache_points_clear(points);
    return err;
}

struct error *cache_points_hits(struct cache_points *points, const struct path_tracer *path,
                                const struct cache_probes *probes, uint64_t seed, int threads)
{
    struct hit *hit = NULL;
    size_t hits = 0;
    struct error *err = find_hits(path, probes, seed, threads, &hit, &hits);
    if (!err)
        err = keep_hits(points, hit, hits);
    free(hit);
    return err;
}

void cache_points_clear(struct cache_points *points)
{
    free(points->position);
    free(points->normal);
    free(points->radius);
    free(points->reach);
    free(points->hit_position);
    free(points->hit_normal);
    *points = (struct cache_points){0};
}
