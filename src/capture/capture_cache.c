/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_cache.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "capture/cache_gather.h"
#include "interpolate/discs.h"
#include "interpolate/scatter.h"
#include "math/luminance.h"
#include "math/power.h"
#include "math/random.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/header_number.h"
#include "stream/stream.h"
#include "trace/lit.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    POINTS_MOST = 1 << 16,
    LINKS_MOST = 1 << 23, /* rays of all points: 128 MB */
    RAYS_LEAST = 16,
    RAYS_MOST = 1024, /* of a point */
    PARTICLES_LEAST = 1 << 15,
    PARTICLES_MOST = 1 << 17,
    CHECKED = 16, /* probes that measure what the cache changes */
    PILOT_LEAST = 64,
    PILOT_MOST = 1024, /* rays of each of them before a cache is made */
    CHECK_LEAST = 512,
    CHECK_MOST = 1 << 15, /* rays of each of them */
    FINER = 2             /* times that a cache is made anew */
};

/* Rays of a cache, of those of all probes. */
#define CACHE_SHARE 0.1

/* Rays of the pilot, of those of all probes: it is traced twice. */
#define PILOT_SHARE 0.01

/* A cache that takes less noise than so many times the rays would costs more than it saves. */
#define GAIN_LEAST 2.2

/* And of one probe, no more than this counts. */
#define GAIN_MOST 1e3

/* How much longer rays take with the questions that go with them. */
#define QUESTIONS_COST 1.4

/* Of a cache that may change 2 % of light, in Sponza and rooms: half the share of a disc's radius
 * in its distance from the probe, and rays of each. */
static const double size_at_2 = 0.45, rays_at_2 = 32;

/* -- points ------------------------------------------------------------------------------------ */

static struct error *make_discs(struct capture_cache *cache)
{
    cache->cache.count = cache->points.count;
    return cache_points_discs(&cache->points, cache->points.radius, &cache->cache.discs);
}

/* -- what it changes --------------------------------------------------------------------------- */

struct checking {
    const struct path_tracer *path;
    const struct capture_settings *settings;
    const struct cache_probes *probes;
    size_t probe[CHECKED];
    struct capture_probe *result; /* CHECKED */
};

/* The probes with the least names: from all of the stream, whatever their order. How many. */
static size_t choose(const struct cache_probes *probes, size_t probe[CHECKED])
{
    uint64_t least[CHECKED];
    size_t count = 0;
    for (size_t i = 0; i < probes->count; i++) {
        uint64_t name = random_hash_position(probes->position + 3 * i);
        if (probes->normal) {
            const float *n = probes->normal + 3 * i;
            const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
            name ^= random_hash_position(normal) >> 1;
        }
        size_t at = count < CHECKED ? count++ : CHECKED;
        for (; at > 0 && name < least[at - 1]; at--)
            if (at < CHECKED) {
                least[at] = least[at - 1];
                probe[at] = probe[at - 1];
            }
        if (at < CHECKED) {
            least[at] = name;
            probe[at] = i;
        }
    }
    return count;
}

static struct error *check_one(void *context, size_t index, int thread)
{
    (void)thread;
    const struct checking *c = context;
    const size_t probe = c->probe[index];
    const float *normal = c->probes->normal ? c->probes->normal + 3 * probe : NULL;
    if (interrupt_came())
        return NULL;
    return capture_probe(c->path, c->settings, c->probes->position + 3 * probe, normal,
                         &c->result[index]);
}

/* Squared length of light as irradiance, over directions, and of its error. */
static void lengths(const struct capture_probe *p, int order, bool surface, double *light,
                    double *error)
{
    *light = *error = 0;
    for (int l = 0, i = 0; l < (surface ? 1 : order); l++)
        for (; i < 3 * (l + 1) * (l + 1); i++) {
            const double a = surface ? 1 : sh_cosine(l);
            *light += a * a * (double)p->sh[i] * (double)p->sh[i];
            *error += a * a * (double)p->sh_error[i] * (double)p->sh_error[i];
        }
}

/* Share of their light that the cache changes, over probes and directions. */
struct change {
    double share, low, high; /* and its interval of 95 % */
    double mean, mean_error; /* by how much there is more of it; 1.96 standard errors of that */
    size_t probes;
};

/* Probes darker than this share of what they have in the root mean square count as that bright. */
#define DARK 0.01

/* Means of what probes say, and 1.96 standard errors of that. */
struct mean {
    double sum, squares;
};

static void mean_add(struct mean *m, double x)
{
    m->sum += x;
    m->squares += x * x;
}

static double mean_error(const struct mean *m, double n)
{
    const double mean = m->sum / n;
    return n > 1 ? 1.96 * sqrt(fmax(m->squares / n - mean * mean, 0) / (n - 1)) : fabs(mean);
}

/* The squares of a difference hold its variance, which is known, but not so well that an upper
 * bound may leave it out. */
static struct change change_of(const struct capture_probe *with, const struct capture_probe *less,
                               size_t count, int order, bool surface)
{
    struct mean certain = {0}, most = {0};
    double all = 0, more = 0, error = 0, least = 0;
    size_t lit = 0;
    for (size_t i = 0; i < count; i++) {
        double light, unused;
        lengths(&with[i], order, surface, &light, &unused);
        least += light / (double)count * DARK * DARK;
    }
    for (size_t i = 0; i < count; i++) {
        double light, off, variance, unused;
        lengths(&with[i], order, surface, &light, &unused);
        lengths(&less[i], order, surface, &off, &variance);
        if (!(light > 0))
            continue;
        mean_add(&certain, (off - variance) / fmax(light, least));
        mean_add(&most, off / fmax(light, least));
        lit++;
        all += luminance_f32(with[i].sh);
        more -= luminance_f32(less[i].sh);
        error += pow(luminance_f32(less[i].sh_error), 2);
    }
    if (!lit)
        return (struct change){0};
    const double n = (double)lit;
    return (struct change){.share = sqrt(fmax(certain.sum / n, 0)),
                           .low = sqrt(fmax(certain.sum / n - mean_error(&certain, n), 0)),
                           .high = sqrt(most.sum / n + mean_error(&most, n)),
                           .mean = more / all,
                           .mean_error = 1.96 * sqrt(error) / all,
                           .probes = lit};
}

/* How wrong a coefficient of each band is (path_cache.error): what the cache changes for certain,
 * and its own noise, by the light that half of its rays give. */
static void set_error(const struct capture_probe *with, const struct capture_probe *less,
                      const struct capture_probe *half, size_t count, int order, bool surface,
                      double error[SH_ORDER_MAX])
{
    const int bands = surface ? 1 : order;
    double square[CHECKED][3] = {0}, least[3] = {0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3 * bands * bands; k++) {
            const double x = (double)with[i].sh[k];
            square[i][k % 3] += x * x;
            least[k % 3] += DARK * DARK * x * x / (double)count;
        }
    for (int l = 0; l < bands; l++) {
        double changed = 0, noise = 0;
        for (size_t i = 0; i < count; i++)
            for (int k = 3 * l * l; k < 3 * (l + 1) * (l + 1); k++) {
                const double x = (double)less[i].sh[k], e = (double)less[i].sh_error[k],
                             y = (double)half[i].sh[k] - (double)with[i].sh[k],
                             light = fmax(square[i][k % 3], least[k % 3]);
                changed += light > 0 ? (x * x - e * e) / light : 0;
                noise += light > 0 ? y * y / light : 0;
            }
        error[l] = sqrt((fmax(changed, 0) + noise) / (3 * (2 * l + 1) * (double)count));
    }
}

/* Measures it at probes from all of the stream, with as many rays as the cache has, or those of the
 * probes. */
static struct error *check(struct capture_cache *cache, struct path_tracer *path,
                           const struct capture_settings *settings,
                           const struct cache_probes *probes, int threads, struct change *change)
{
    const double rays = cache->rays ? (double)cache->points.count * cache->rays / CHECKED / 8
                                    : (double)settings->rays;
    struct capture_probe with[CHECKED] = {0}, less[CHECKED] = {0}, half[CHECKED] = {0};
    struct capture_settings all = *settings;
    all.error = 0;
    all.columns = CAPTURE_ERROR;
    all.rays = (int)fmin(fmax(rays, CHECK_LEAST), CHECK_MOST);
    struct capture_settings scattered = all;
    scattered.light = CAPTURE_INDIRECT;
    struct checking c = {.path = path, .settings = &all, .probes = probes, .result = with};
    const size_t count = choose(probes, c.probe);
    memset(cache->cache.error, 0, sizeof cache->cache.error);
    path_use_cache(path, &cache->cache);
    struct error *err = threads_for(threads, count, check_one, &c);
    if (!err && cache->half) { /* by the same paths */
        float *const value = cache->cache.value;
        cache->cache.value = cache->half;
        c.result = half;
        err = threads_for(threads, count, check_one, &c);
        cache->cache.value = value;
    }
    cache->cache.check = true;
    c.settings = &scattered;
    c.result = less;
    if (!err)
        err = threads_for(threads, count, check_one, &c);
    cache->cache.check = false;
    path_use_cache(path, NULL);
    *change = change_of(with, less, count, settings->order, probes->normal);
    set_error(with, less, cache->half ? half : with, count, settings->order, probes->normal,
              cache->cache.error);
    return err;
}

/* -- a pilot ----------------------------------------------------------------------------------- */

static void set_bounces(struct path_tracer *path, int bounces)
{
    for (; path; path = path->next)
        path->bounces = bounces;
}

/* How many times as much variance a few probes have without a cache as with one that knows all
 * scattered light, where paths end and bring nothing more: *gain is the mean of logarithms, which
 * no single probe decides. */
static struct error *find_gain(struct capture_cache *cache, struct path_tracer *path,
                               const struct capture_settings *settings,
                               const struct cache_probes *probes, int threads, double *gain)
{
    struct capture_probe plain[CHECKED] = {0}, ended[CHECKED] = {0};
    struct capture_settings own = *settings;
    const double rays = PILOT_SHARE / CHECKED * (double)probes->count * settings->rays;
    own.error = 0;
    own.columns = CAPTURE_ERROR;
    own.rays = (int)fmin(fmax(rays, PILOT_LEAST), PILOT_MOST);
    struct checking c = {.path = path, .settings = &own, .probes = probes, .result = plain};
    const size_t count = choose(probes, c.probe);
    const int bounces = path->bounces;
    double sum = 0;
    size_t lit = 0;
    struct error *err = threads_for(threads, count, check_one, &c);
    c.result = ended;
    set_bounces(path, cache->cache.after);
    path_use_cache(path, &cache->cache);
    if (!err)
        err = threads_for(threads, count, check_one, &c);
    path_use_cache(path, NULL);
    set_bounces(path, bounces);
    for (size_t i = 0; i < count; i++) {
        double light, before, after;
        lengths(&plain[i], settings->order, probes->normal, &light, &before);
        lengths(&ended[i], settings->order, probes->normal, &light, &after);
        if (!(before > 0 || after > 0))
            continue;
        /* what rays have not found at all they know no noise of */
        sum += power_log(before > 0
                             ? fmin(fmax(before / fmax(after, DBL_MIN), 1 / GAIN_MOST), GAIN_MOST)
                             : GAIN_MOST);
        lit++;
    }
    *gain = lit ? sum / (double)lit : 0;
    return err;
}

/* -- made -------------------------------------------------------------------------------------- */

static void tell_off(struct capture_cache *cache, const char *why)
{
    cache->on = false;
    snprintf(cache->told, sizeof cache->told, "no cache: %s", why);
}

static void tell(struct capture_cache *cache, const struct change *change)
{
    char rays[64] = "";
    if (cache->rays)
        snprintf(rays, sizeof rays, " of %d rays", cache->rays);
    snprintf(cache->told, sizeof cache->told,
             "cache: %zu points%s change %.2g %% of light (95 %%: %.2g to %.2g), in the mean by "
             "%+.1g +- %.1g %%, at %zu probes",
             cache->points.count, rays, 100 * change->share, 100 * change->low, 100 * change->high,
             100 * change->mean, 100 * change->mean_error, change->probes);
}

/* Rays that the points of a cache may have so that it pays: more, where each ray of a probe brings
 * questions that cost as much. */
static double rays_that_pay(const struct capture_cache *cache,
                            const struct capture_settings *settings,
                            const struct cache_probes *probes)
{
    const double share = cache->cache.lit || cache->cache.opens ? 2 * CACHE_SHARE : CACHE_SHARE;
    return share * (double)probes->count * settings->rays;
}

static struct error *make(struct capture_cache *cache, struct path_tracer *path,
                          const struct capture_settings *settings,
                          const struct cache_probes *probes, double error, int threads)
{
    const double pay = rays_that_pay(cache, settings, probes), most = fmin(pay, LINKS_MOST);
    double rays = fmin(fmax(rays_at_2 * 0.02 / error, RAYS_LEAST), RAYS_MOST);
    const double points = floor(fmin(fmax(most / rays, 1), POINTS_MOST));
    struct error *err = cache_points_find(&cache->points, path, probes, (size_t)points,
                                          size_at_2 * sqrt(error / 0.02), settings->seed, threads);
    const size_t count = cache->points.count;
    if (err || !count || (cache->points.full && points < POINTS_MOST)) {
        tell_off(cache, count ? "so few rays and probes would not pay for it"
                              : "no ray of a probe meets a surface");
        return err;
    }
    /* where there are many probes a cache with less noise costs little */
    rays = fmin(fmax(rays, pay / (double)count), fmin(RAYS_MOST, LINKS_MOST / (double)count));
    cache->rays = (int)rays / 2 * 2;
    err = make_discs(cache);
    if (!err)
        err = cache_gather(&cache->cache, &cache->points, cache->rays, path, settings, threads,
                           &cache->half);
    cache->on = !err;
    return err;
}

static void empty(struct capture_cache *cache)
{
    const struct path_cache was = cache->cache;
    cache->cache.lit = NULL;
    capture_cache_clear(cache);
    cache->cache = (struct path_cache){.after = was.after, .lit = was.lit, .opens = was.opens};
}

/* A cache that changes too much is made anew for half of what this one was. */
static struct error *make_fine(struct capture_cache *cache, struct path_tracer *path,
                               const struct capture_settings *settings,
                               const struct cache_options *options,
                               const struct cache_probes *probes, int threads)
{
    double error = options->error;
    for (int i = 0; i <= FINER; i++, error /= 2) {
        struct change change;
        empty(cache);
        struct error *err = make(cache, path, settings, probes, error, threads);
        if (!err && !cache->on && i)
            break;
        if (err || !cache->on)
            return err;
        err = check(cache, path, settings, probes, threads, &change);
        if (err)
            return err;
        tell(cache, &change);
        if (change.share <= options->error)
            return NULL;
    }
    tell_off(cache, "it changes more of the light than --cache-error allows");
    return NULL;
}

/* Makes none where the pilot says that even the best would not pay. */
static struct error *make_paying(struct capture_cache *cache, struct path_tracer *path,
                                 const struct capture_settings *settings,
                                 const struct cache_options *options,
                                 const struct cache_probes *probes, int threads)
{
    double gain;
    struct error *err = find_gain(cache, path, settings, probes, threads, &gain);
    if (err || gain >= power_log(GAIN_LEAST))
        return err ? err : make_fine(cache, path, settings, options, probes, threads);
    char why[128];
    snprintf(why, sizeof why,
             "at its best it would spare %.2g times the rays, and pays from %g times on", exp(gain),
             GAIN_LEAST);
    tell_off(cache, why);
    return NULL;
}

/* -- read -------------------------------------------------------------------------------------- */

/* Whether a stream's light is the indirect light of these surfaces. */
static struct error *check_header(const struct stream_header *header, const struct scene *scene,
                                  const struct capture_settings *settings,
                                  const struct cache_options *options)
{
    const int after = options->after;
    char relit[RELIT_KEY_ROOM];
    struct capture_settings was = capture_settings_default();
    if (!capture_header_has_settings(header))
        return error_new("expected surface probes with light: run probe-capture --light indirect");
    struct error *err = capture_settings_from_header(&was, header);
    if (err)
        return err;
    relit_key(header, relit);
    if (scene_differs(scene, header) || strcmp(relit, options->relit) != 0)
        return error_new("the cache is of another scene, or of other light in it (--cache-renew "
                         "gathers that anew)");
    if (scene_sky_differs(scene, header))
        return error_new("the cache is of another picture of the sky");
    if (was.light != CAPTURE_INDIRECT)
        return error_new("expected --light indirect, got %s light", capture_light_names[was.light]);
    const char *holds = header_key(header, CACHE_HOLDS);
    if (holds && strcmp(holds, "sky"))
        return error_new("header key " CACHE_HOLDS ": expected sky, got %s", holds);
    if (was.decimate < settings->decimate || was.decimate > settings->decimate)
        return error_new("the cache was captured with --decimate %g, not %g", was.decimate,
                         settings->decimate);
    /* of so many, the last is too dim to tell */
    enum { MANY = 16 };
    if (was.bounces != settings->bounces - after &&
        (was.bounces < MANY || settings->bounces < MANY + after))
        return error_new("expected a cache of --bounces %d, got %d", settings->bounces - after,
                         was.bounces);
    return NULL;
}

/* Whether the light of a stream's points, which is not theirs any more, may be gathered anew. */
static struct error *check_surfaces(const struct stream_header *header, const struct scene *scene,
                                    const struct capture_settings *settings)
{
    char now[24];
    struct capture_settings was = capture_settings_default();
    const char *key = header_key(header, CACHE_SURFACES);
    struct error *err = capture_settings_from_header(&was, header);
    if (err)
        return err;
    snprintf(now, sizeof now, "%016" PRIx64, scene_surface_key(scene));
    if (key && strcmp(key, now) != 0)
        return error_new("the cache is of other surfaces, which --cache-renew cannot mend");
    if (!key && scene_differs(scene, header))
        return error_new("the cache is of another scene, or of other light in it, and its header "
                         "has no key " CACHE_SURFACES ", without which --cache-renew cannot tell "
                         "one from the other");
    if (capture_header_has_settings(header) &&
        (was.decimate < settings->decimate || was.decimate > settings->decimate))
        return error_new("the cache was captured with --decimate %g, not %g", was.decimate,
                         settings->decimate);
    return NULL;
}

/* Of points without light none is. */
static bool is_dark(const void *light, size_t probe)
{
    return light && isnan(((const float *)light)[3 * probe]);
}

/* Half the radius of discs whose points have none of their own. */
static struct error *find_radius(const double *position, const float *light, size_t probes,
                                 double *radius)
{
    struct scatter *scatter = NULL;
    struct error *err = scatter_create(&scatter, probes, position, is_dark, light);
    *radius = err ? 0 : scatter_spacing(scatter) / 2;
    scatter_destroy(scatter);
    return err;
}

/* renewed: they need no light. */
static struct error *take_points(struct capture_cache *cache, const struct table *table,
                                 bool renewed)
{
    struct column *position = NULL, *normal = NULL, *light = NULL, *radius = NULL;
    struct cache_points *p = &cache->points;
    double all = 0;
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err && !table_column(table, "normal"))
        return error_new("expected surface probes, got points without a normal "
                         "(probe-place poisson makes some)");
    if (!err)
        err = table_require(table, "normal", COLUMN_F32, 3, &normal);
    if (!err && (!renewed || table_column(table, "irradiance")))
        err = table_require(table, "irradiance", COLUMN_F32, 3, &light);
    const float *e = light ? column_f32(light) : NULL;
    if (!err && table_column(table, "radius"))
        err = table_require(table, "radius", COLUMN_F32, 1, &radius);
    if (!err && !radius)
        err = find_radius(column_f64(position), e, table->rows, &all);
    if (!err)
        err = array_create(&p->position, 3 * table->rows, sizeof *p->position);
    if (!err)
        err = array_create(&p->normal, 3 * table->rows, sizeof *p->normal);
    if (!err)
        err = array_create(&p->radius, table->rows, sizeof *p->radius);
    if (!err && !renewed)
        err = array_create(&cache->cache.value, 3 * table->rows, sizeof *cache->cache.value);
    for (size_t i = 0; i < table->rows && !err; i++) {
        const double r = radius ? (double)column_f32(radius)[i] : all;
        if (is_dark(e, i))
            continue;
        if (!(r >= (double)FLT_MIN && r <= (double)FLT_MAX / 4))
            return error_new("probe %zu: expected a radius above 0, got %g", i, r);
        memcpy(p->position + 3 * p->count, column_f64(position) + 3 * i, 3 * sizeof(double));
        memcpy(p->normal + 3 * p->count, column_f32(normal) + 3 * i, 3 * sizeof(float));
        if (!renewed)
            memcpy(cache->cache.value + 3 * p->count, e + 3 * i, 3 * sizeof *e);
        p->radius[p->count++] = (float)r;
    }
    if (!err && !p->count)
        err = error_new("expected surface probes with light, got none");
    return err ? err : make_discs(cache);
}

/* Rays of points whose light is gathered anew: as many as it was gathered by, where it was, so that
 * it is to the bit what a cache of these points has that is made. */
static struct error *renewed_rays(struct capture_cache *cache, const struct stream_header *header,
                                  const struct capture_settings *settings,
                                  const struct cache_probes *probes)
{
    const double count = (double)cache->points.count, most = LINKS_MOST / count;
    struct capture_settings was = capture_settings_default();
    struct error *err = capture_settings_from_header(&was, header);
    if (!err && most < RAYS_LEAST)
        err = error_new("--cache-renew: expected at most %d points, got %.0f",
                        LINKS_MOST / RAYS_LEAST, count);
    const double rays = header_key(header, CACHE_SURFACES)
                            ? was.rays
                            : rays_that_pay(cache, settings, probes) / count;
    cache->rays = (int)fmin(fmax(rays, RAYS_LEAST), fmin(RAYS_MOST, most)) / 2 * 2;
    return err;
}

static struct error *read_stream(struct capture_cache *cache, const struct cache_options *options,
                                 const struct scene *scene, const struct capture_settings *settings,
                                 const struct cache_probes *probes)
{
    struct stream *stream = NULL;
    struct error *err = stream_read(&stream, options->name);
    if (err)
        return err;
    const struct table *table = stream_table(stream, "probe");
    err = check_header(&stream->header, scene, settings, options);
    const bool renew = err && options->renew;
    if (renew) {
        error_destroy(err);
        err = check_surfaces(&stream->header, scene, settings);
    }
    if (!err && !table)
        err = error_new("expected table probe");
    if (!err)
        err = take_points(cache, table, renew);
    if (!err && renew)
        err = renewed_rays(cache, &stream->header, settings, probes);
    if (!err)
        err = header_get_int(&stream->header, "capture-rays", 1, CAPTURE_RAYS_MOST,
                             &cache->read_rays);
    cache->cache.sky = !err && header_key(&stream->header, CACHE_HOLDS);
    cache->on = !err;
    stream_destroy(stream);
    return err ? error_wrap(err, "%s", options->name) : NULL;
}

/* Particles of suns: an eighth of the probes' rays. */
static size_t particles_for(const struct capture_settings *settings,
                            const struct cache_probes *probes)
{
    const double rays = 0.125 * (double)probes->count * settings->rays;
    return (size_t)fmin(fmax(rays, PARTICLES_LEAST), PARTICLES_MOST);
}

/* Noise of a few probes' light: the mean square of its share. */
static struct error *find_noise(const struct capture_cache *cache, struct path_tracer *path,
                                const struct capture_settings *settings,
                                const struct cache_probes *probes, int threads, double *noise)
{
    struct capture_probe result[CHECKED] = {0};
    struct capture_settings own = *settings;
    own.error = 0;
    own.columns = CAPTURE_ERROR;
    own.rays = CHECK_LEAST;
    struct checking c = {.path = path, .settings = &own, .probes = probes, .result = result};
    const size_t count = choose(probes, c.probe);
    path_use_cache(path, &cache->cache);
    struct error *err = threads_for(threads, count, check_one, &c);
    path_use_cache(path, NULL);
    *noise = 0;
    for (size_t i = 0; i < count; i++) {
        double light, variance;
        lengths(&result[i], settings->order, probes->normal, &light, &variance);
        *noise += light > 0 ? variance / light : 0;
    }
    return err;
}

/* Sunlit points, and questions whether the sky is open, stay where they take more noise away than
 * as much time of more rays would: out of doors rays find sun and sky as well. */
static struct error *judge(struct capture_cache *cache, struct path_tracer *path,
                           const struct capture_settings *settings,
                           const struct cache_probes *probes, int threads)
{
    struct path_cache *c = &cache->cache;
    struct lit *lit = c->lit;
    double with = 0, without = 0;
    struct error *err = NULL;
    if (lit || c->opens)
        err = find_noise(cache, path, settings, probes, threads, &with);
    if (lit && !err) {
        c->lit = NULL;
        err = find_noise(cache, path, settings, probes, threads, &without);
        if (!err && with * QUESTIONS_COST >= without) {
            lit_destroy(lit);
            with = without;
        } else {
            c->lit = lit;
        }
    }
    if (c->opens && !err) {
        c->opens = false;
        err = find_noise(cache, path, settings, probes, threads, &without);
        c->opens = with * QUESTIONS_COST < without;
    }
    return err;
}

/* Makes what finds suns and an even sky. */
static struct error *light(struct capture_cache *cache, const struct path_tracer *path,
                           const struct capture_settings *settings,
                           const struct cache_probes *probes, int threads)
{
    const struct lit_sources sources = {path->tracer, &path->lights, &path->sky};
    cache->cache.opens = path->sky_shines && !path->sky.rows;
    return lit_create(&cache->cache.lit, &sources, particles_for(settings, probes), settings->seed,
                      threads);
}

/* -- all --------------------------------------------------------------------------------------- */

static struct error *open_stream(struct capture_cache *cache, struct path_tracer *path,
                                 const struct capture_settings *settings,
                                 const struct cache_options *options, const struct scene *scene,
                                 const struct cache_probes *probes, int threads)
{
    struct change change;
    struct error *err = read_stream(cache, options, scene, settings, probes);
    if (!err && cache->rays) {
        err = cache_points_hits(&cache->points, path, probes, settings->seed, threads);
        if (!err)
            err = cache_gather(&cache->cache, &cache->points, cache->rays, path, settings, threads,
                               &cache->half);
    }
    if (!err && probes->count)
        err = check(cache, path, settings, probes, threads, &change);
    if (err || !probes->count)
        return err;
    tell(cache, &change);
    if (change.share > options->error)
        tell_off(cache, "it changes more of the light than --cache-error allows");
    return NULL;
}

struct error *capture_cache_open(struct capture_cache *cache, struct path_tracer *path,
                                 const struct capture_settings *settings,
                                 const struct cache_options *options, const struct scene *scene,
                                 const struct cache_probes *probes, int threads)
{
    struct error *err = NULL;
    *cache = (struct capture_cache){.cache.after = options->after};
    if (!options->name)
        return NULL;
    if (settings->split)
        return error_new("a cache keeps the light of all lights in one, and the probes have groups "
                         "or transfers: expected --cache off");
    const bool made = !strcmp(options->name, "auto");
    if (capture_is_dark(scene)) {
        tell_off(cache, "there is no light");
    } else if (settings->light == CAPTURE_DIRECT || settings->bounces <= options->after) {
        tell_off(cache, "no light scatters on behind it");
    } else if (made && !probes->count) {
        tell_off(cache, "there are no probes");
    } else {
        err = light(cache, path, settings, probes, threads);
        if (!err && made)
            err = make_paying(cache, path, settings, options, probes, threads);
        else if (!err)
            err = open_stream(cache, path, settings, options, scene, probes, threads);
    }
    if (!err && cache->on && probes->count)
        err = judge(cache, path, settings, probes, threads);
    if (!err && cache->on)
        path_use_cache(path, &cache->cache);
    return err;
}

struct error *capture_cache_open_rows(struct capture_cache *cache, struct path_tracer *path,
                                      const struct capture_settings *settings,
                                      const struct cache_options *options,
                                      const struct scene *scene, const struct table *table,
                                      size_t first, size_t count, int threads)
{
    struct column *position = NULL, *normal = NULL;
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err && table_column(table, "normal"))
        err = table_require(table, "normal", COLUMN_F32, 3, &normal);
    if (err)
        return err;
    const struct cache_probes probes = {.position = column_f64(position) + 3 * first,
                                        .normal = normal ? column_f32(normal) + 3 * first : NULL,
                                        .count = count};
    return capture_cache_open(cache, path, settings, options, scene, &probes, threads);
}

struct error *capture_cache_write(const struct capture_cache *cache, const char *path,
                                  const struct capture_settings *settings,
                                  const struct scene *scene, const struct stream_header *header)
{
    const struct cache_options none = {0};
    const struct cache_points *p = &cache->points;
    struct capture_settings own = *settings;
    struct stream *stream = NULL;
    struct table *table = NULL;
    struct column *position = NULL, *c = NULL;
    char surfaces[24];
    own.light = CAPTURE_INDIRECT;
    own.bounces -= cache->cache.after;
    own.rays = cache->rays ? cache->rays : cache->read_rays;
    own.error = 0;
    if (!cache->on)
        return error_new("--cache-out: there is no cache to write: %s", cache->told);
    struct error *err = stream_create(&stream);
    if (!err)
        err = header_copy(&stream->header, header);
    if (!err)
        err = capture_settings_to_header(&own, &stream->header);
    if (!err)
        err = cache_options_to_header(&none, &stream->header);
    if (!err && cache->cache.sky)
        err = header_set_key(&stream->header, CACHE_HOLDS, "sky");
    snprintf(surfaces, sizeof surfaces, "%016" PRIx64, scene_surface_key(scene));
    if (!err)
        err = header_set_key(&stream->header, CACHE_SURFACES, surfaces);
    if (!err)
        err = stream_add_table(stream, "probe", &table);
    if (!err)
        err = table_resize(table, p->count);
    if (!err)
        err = table_add_column(table, "position", COLUMN_F64, 3, &position);
    if (!err)
        memcpy(column_f64(position), p->position, 3 * p->count * sizeof *p->position);
    const struct {
        const char *name;
        size_t width;
        const float *value;
    } columns[] = {
        {"normal", 3, p->normal}, {"radius", 1, p->radius}, {"irradiance", 3, cache->cache.value}};
    for (size_t i = 0; i < 3 && !err; i++) {
        err = table_add_column(table, columns[i].name, COLUMN_F32, columns[i].width, &c);
        if (!err)
            memcpy(column_f32(c), columns[i].value, columns[i].width * p->count * sizeof(float));
    }
    if (!err)
        err = stream_write(stream, path, STREAM_BINARY);
    stream_destroy(stream);
    return err;
}

void capture_cache_clear(struct capture_cache *cache)
{
    cache_clear(&cache->cache);
    cache_points_clear(&cache->points);
    free(cache->half);
    cache->half = NULL;
    cache->on = false;
}
