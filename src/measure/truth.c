/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/truth.h"
#include "base/array.h"
#include "base/error.h"
#include "base/progress.h"
#include "base/threads.h"
#include "base/warning.h"
#include "capture/capture_cache.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/random.h"
#include "math/vec.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "scene/scene_settings.h"
#include "stream/header_number.h"
#include "stream/stream.h"
#include "trace/trace.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MOST = 32 };    /* of a random path */
enum { STEPS_ACROSS = 256 }; /* the step's share of the box's diagonal */
enum { TRIES = 64 };         /* candidates for each free point */
enum { REACH_TRIES = 4096 }; /* points of the box for each candidate in the region */
enum { DIRECTIONS = 4 };     /* tried for each path */

/* What random numbers are for: part of their name. */
enum { FOR_POINT = 1, FOR_PATH };

struct truth_settings truth_settings_default(void)
{
    return (struct truth_settings){.points = 1000,
                                   .paths = 16,
                                   .bounds = {NAN},
                                   .step = NAN,
                                   .rays = 4096,
                                   .rays_most = 65536,
                                   .cache = cache_options_default(),
                                   .reach = reach_default(),
                                   .bounces = -1};
}

/* -- header ----------------------------------------------------------------------------------- */

static int64_t bounces_of(const struct stage *stage, const struct truth_settings *settings)
{
    return settings->bounces >= 0 ? settings->bounces : stage->capture_settings.bounces;
}

/* The keys that say what a truth is of. bounds, step: as they were chosen. */
static struct error *describe(struct stream_header *header, const struct stage *stage,
                              const struct truth_settings *s, const double bounds[6], double step)
{
    struct error *err = header_set_key(header, "scene-key", stage->key);
    if (!err)
        err = header_set_key(header, "truth-light",
                             capture_light_names[stage->capture_settings.light]);
    if (!err)
        err = header_set_whole(header, "truth-bounces", bounces_of(stage, s));
    if (!err)
        err = header_set_whole(header, "truth-rays", s->rays);
    if (!err)
        err = header_set_real(header, "truth-error", s->error);
    if (!err)
        err = header_set_whole(header, "truth-points", s->points_file ? 0 : s->points);
    if (!err)
        err = header_set_whole(header, "truth-paths", s->path_file ? 0 : s->paths);
    if (!err)
        err = header_set_whole(header, "truth-seed", s->seed);
    if (!err)
        err = header_set_reals(header, "truth-bounds", 6, bounds);
    if (!err)
        err = header_set_real(header, "truth-step", step);
    if (!err && *stage->relit)
        err = header_set_key(header, "truth-relit", stage->relit);
    char key[REACH_KEY];
    if (!err && s->reach_file)
        err = reach_key(s->reach_file, &s->reach, key);
    if (!err && s->reach_file)
        err = header_set_key(header, "truth-reach", key);
    return err;
}

#define CACHE_KEY "truth-cache"

static struct error *check_described(const struct stream_header *is,
                                     const struct stream_header *wanted, const struct scene *scene,
                                     const struct truth_settings *s)
{
    const struct {
        const char *key;
        bool asked;
    } keys[] = {{"truth-light", true},
                {"truth-bounces", true},
                {"truth-rays", s->rays_given},
                {"truth-error", s->error_given},
                {"truth-points", s->points_given || s->points_file},
                {"truth-paths", s->paths_given || s->path_file},
                {"truth-seed", s->seed_given},
                {"truth-bounds", s->bounds_given},
                {"truth-reach", s->reach_file},
                {"truth-step", s->step_given}};
    const char *key = header_key(is, "scene-key");
    if (!key || !header_key(is, "truth-rays"))
        return error_new("this is not a truth that probe-error made");
    if (scene_differs(scene, is))
        return error_new("this truth is of another scene, or of other light in it (its key is %s, "
                         "the scene's %s)",
                         key, header_key(wanted, "scene-key"));
    if (scene_sky_differs(scene, is))
        return error_new("this truth is under another sky than %s", scene->sky.file);
    const char *relit = header_key(wanted, "truth-relit"), *was = header_key(is, "truth-relit");
    if (!relit != !was || (relit && strcmp(relit, was)))
        return error_new("this truth is of other light than the stream was relit with");
    const char *cache = header_key(is, CACHE_KEY);
    if (cache && (!s->cache.name || strcmp(cache, s->cache.name) != 0))
        return error_new("this is no truth but a preview of it, of light through a cache: expected "
                         "--truth-cache %s",
                         cache);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const char *has = header_key(is, keys[i].key), *asked = header_key(wanted, keys[i].key);
        if (keys[i].asked && (!has || strcmp(has, asked)))
            return error_new("this truth has %s %s, not %s as asked for", keys[i].key,
                             has ? has : "none", asked);
    }
    return NULL;
}

/* -- where ------------------------------------------------------------------------------------ */

static void choose_bounds(const struct truth_settings *s, const struct scene *scene,
                          const struct box *box, double bounds[6])
{
    const struct box own = {{scene->box_min.x, scene->box_min.y, scene->box_min.z},
                            {scene->box_max.x, scene->box_max.y, scene->box_max.z}};
    const double most = box_side(&own);
    bool solid = most > 0 && most < (double)INFINITY;
    for (int k = 0; k < 3; k++)
        solid = solid && own.high[k] - own.low[k] > 1e-3 * most;
    const struct box *from = solid ? &own : box; /* a floor, or nothing, has no space of its own */
    for (int k = 0; k < 3; k++) {
        bounds[k] = s->bounds_given ? s->bounds[k] : from->low[k];
        bounds[3 + k] = s->bounds_given ? s->bounds[3 + k] : from->high[k];
    }
}

/* Where points and paths are taken. */
struct space {
    const struct truth_job *job;
    double bounds[6];
    double step;               /* along paths */
    const struct reach *reach; /* NULL: anywhere in the bounds */
};

static bool is_reached(const struct space *space, const double p[3])
{
    return !space->reach || reach_holds(space->reach, p);
}

static void free_candidate(const struct space *space, size_t number, double p[3])
{
    const double *bounds = space->bounds;
    struct random r =
        random_start((uint64_t)space->job->settings->seed, FOR_POINT, (uint32_t)number);
    for (int k = 0; k < 3; k++)
        p[k] = bounds[k] + (bounds[3 + k] - bounds[k]) * random_double(&r);
}

/* The first candidates of the box that are in the air. */
static struct error *place_free(struct place *place, const struct space *space)
{
    const struct truth_job *job = space->job;
    const size_t wanted = (size_t)job->settings->points;
    struct place_inside_settings inside_settings = place_inside_default();
    struct place candidates = {0};
    enum place_side *side = NULL;
    inside_settings.threads = job->threads;
    struct error *err = array_create(&place->position, 3 * wanted, sizeof *place->position);
    if (!err)
        err = array_create(&candidates.position, 3 * wanted, sizeof *candidates.position);
    if (!err)
        err = array_create(&side, wanted, sizeof *side);
    size_t next = 0;
    for (size_t turn = 0; turn < TRIES && place->count < wanted && !err; turn++) {
        candidates.count = 0;
        for (size_t i = 0; i < REACH_TRIES * wanted && candidates.count < wanted; i++) {
            double *p = candidates.position + 3 * candidates.count;
            free_candidate(space, next++, p);
            candidates.count += is_reached(space, p);
        }
        err = place_inside(&candidates, job->stage->tracer, &inside_settings, side, job->warnings);
        for (size_t i = 0; i < candidates.count && place->count < wanted && !err; i++)
            if (side[i] == PLACE_AIR)
                memcpy(place->position + 3 * place->count++, candidates.position + 3 * i,
                       3 * sizeof(double));
    }
    if (!err && place->count < wanted)
        err = error_new("%zu of %zu random points are in free space: --bounds says where it is",
                        place->count, next);
    place_clear(&candidates);
    free(side);
    return err;
}

static void random_direction(struct random *r, double d[3])
{
    const double z = 2 * random_double(r) - 1, turn = 2 * ANGLE_PI * random_double(r),
                 radius = sqrt(1 - z * z);
    d[0] = radius * angle_cos(turn);
    d[1] = radius * angle_sin(turn);
    d[2] = z;
}

/* How many steps may be taken from p along d: to shortly before a surface, and not out of the
 * box. */
static int free_steps(const struct space *space, const double p[3], const double d[3])
{
    const double *bounds = space->bounds, step = space->step;
    const struct trace_hit hit =
        trace_nearest(space->job->stage->tracer, p, d, 2 * STEPS_MOST * step);
    double most = hit.hit ? 0.95 * hit.distance : STEPS_MOST * step;
    for (int k = 0; k < 3; k++) {
        if (d[k] > 0)
            most = fmin(most, fmax((bounds[3 + k] - p[k]) / d[k], 0));
        if (d[k] < 0)
            most = fmin(most, fmax((bounds[k] - p[k]) / d[k], 0));
    }
    int steps = (int)fmin(floor(most / step), STEPS_MOST);
    for (int i = 1; i <= steps; i++) {
        double q[3];
        vec3_store(q, vec3_fma(vec3_load(p), i * step, vec3_load(d)));
        if (!is_reached(space, q))
            steps = i - 1;
    }
    return steps;
}

/* Appends one straight path from a point on; of the directions tried, that with the longest way.
 * Returns its steps. */
static struct error *place_random_path(struct place *place, const struct space *space,
                                       const double start[3], size_t number, size_t *rows)
{
    struct random r =
        random_start((uint64_t)space->job->settings->seed, FOR_PATH, (uint32_t)number);
    double best[3] = {0};
    int steps = 0;
    for (int turn = 0; turn < DIRECTIONS; turn++) {
        double d[3];
        random_direction(&r, d);
        const int free = free_steps(space, start, d);
        if (free > steps) {
            steps = free;
            memcpy(best, d, sizeof best);
        }
    }
    *rows = steps > 0 ? (size_t)steps + 1 : 0; /* a point in a corner has no way to go */
    struct error *err = array_reserve(&place->position, &place->capacity, place->count + *rows,
                                      3 * sizeof *place->position);
    for (size_t i = 0; i < *rows && !err; i++)
        vec3_store(place->position + 3 * place->count++,
                   vec3_fma(vec3_load(start), (double)i * space->step, vec3_load(best)));
    return err;
}

/* The positions of points, and behind them those of paths; path[i] the number of the path. */
static struct error *place_all(const struct space *space, struct place *place, int32_t **path,
                               size_t *points)
{
    const struct truth_settings *s = space->job->settings;
    *path = NULL;
    struct error *err = s->points_file ? place_points(place, s->points_file, 1e9, NULL)
                                       : place_free(place, space);
    if (!err && !place->count)
        err = error_new("%s: expected at least one point, got none", s->points_file);
    *points = place->count;
    place->capacity = place->capacity > place->count ? place->capacity : place->count;
    struct place starts = {0};
    if (!err && !s->path_file && s->paths)
        err = array_create(&starts.position, 3 * place->count, sizeof *starts.position);
    if (starts.position)
        memcpy(starts.position, place->position, 3 * place->count * sizeof *starts.position);
    size_t *rows = NULL;
    const size_t paths = s->path_file ? 1 : (size_t)s->paths;
    if (!err)
        err = array_create(&rows, paths, sizeof *rows);
    if (!err && s->path_file) {
        err = place_path(place, s->path_file, &(struct place_way){.step = space->step}, 1e9, NULL);
        rows[0] = place->count - *points;
    }
    for (size_t i = 0; i < paths && !s->path_file && !err; i++)
        err = place_random_path(place, space, starts.position + 3 * (i % *points), i, &rows[i]);
    if (!err)
        err = array_create(path, place->count, sizeof **path);
    for (size_t i = 0; i < *points && !err; i++)
        (*path)[i] = -1;
    for (size_t n = 0, at = *points; n < paths && !err; n++)
        for (size_t i = 0; i < rows[n]; i++)
            (*path)[at++] = (int32_t)n;
    free(rows);
    place_clear(&starts);
    return err;
}

/* -- tracing ---------------------------------------------------------------------------------- */

/* Points at work. */
struct work {
    const struct path_tracer *path_tracer;
    const struct tracer *tracer;
    struct capture_settings settings;
    const double *position;
    float *surface, *half[2];
    int64_t seed;
    struct progress *progress;
};

static struct error *trace_one(void *context, size_t index, int thread)
{
    (void)thread;
    struct work *work = context;
    const double *p = work->position + 3 * index;
    struct capture_settings s = work->settings;
    for (int half = 0; half < 2; half++) {
        struct capture_probe result;
        /* no --seed of a capture is as large */
        s.seed = (uint64_t)work->seed | (uint64_t)1 << (62 + half);
        struct error *err = capture_probe(work->path_tracer, &s, p, NULL, &result);
        for (size_t k = 0; k < TRUTH_WIDTH && !err; k++)
            if (!isfinite(result.sh[k]))
                err = error_new("light is beyond what 32 bits can hold");
        if (err)
            return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
        memcpy(work->half[half] + TRUTH_WIDTH * index, result.sh, TRUTH_WIDTH * sizeof(float));
    }
    const double distance = trace_distance(work->tracer, p);
    work->surface[index] = distance < (double)INFINITY ? (float)distance : NAN;
    progress_add(work->progress, 1);
    return NULL;
}

static struct error *add_columns(struct table *table)
{
    struct error *err = table_add_column(table, "position", COLUMN_F64, 3, NULL);
    if (!err)
        err = table_add_column(table, "path", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_add_column(table, "surface", COLUMN_F32, 1, NULL);
    if (!err)
        err = table_add_column(table, "irradiance_1", COLUMN_F32, TRUTH_WIDTH, NULL);
    if (!err)
        err = table_add_column(table, "irradiance_2", COLUMN_F32, TRUTH_WIDTH, NULL);
    return err;
}

/* Points the truth's arrays into its stream. */
static struct error *find_columns(struct truth *t)
{
    const struct table *table = stream_table(t->stream, "probe");
    struct column *position = NULL, *path = NULL, *surface = NULL, *half[2] = {NULL};
    if (!table)
        return error_new("there is no table probe");
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(table, "path", COLUMN_I32, 1, &path);
    if (!err)
        err = table_require(table, "surface", COLUMN_F32, 1, &surface);
    if (!err)
        err = table_require(table, "irradiance_1", COLUMN_F32, TRUTH_WIDTH, &half[0]);
    if (!err)
        err = table_require(table, "irradiance_2", COLUMN_F32, TRUTH_WIDTH, &half[1]);
    if (err)
        return err;
    t->count = table->rows;
    t->position = column_f64(position);
    t->path = column_i32(path);
    t->surface = column_f32(surface);
    t->half[0] = column_f32(half[0]);
    t->half[1] = column_f32(half[1]);
    t->points = 0;
    while (t->points < t->count && t->path[t->points] < 0)
        t->points++;
    for (size_t i = 0; i < t->count; i++)
        if ((i >= t->points) != (t->path[i] >= 0) || isnan(t->half[0][TRUTH_WIDTH * i]) ||
            isnan(t->half[1][TRUTH_WIDTH * i]))
            return error_new("row %zu: a path's row before a point's, or light that is missing", i);
    return t->points ? NULL : error_new("there are no points");
}

static double default_step(const double bounds[6])
{
    const struct vec3 diagonal = vec3_sub(vec3_load(bounds + 3), vec3_load(bounds));
    return vec3_length(diagonal) / STEPS_ACROSS;
}

/* Opens the cache for a preview, where one is asked for, and says what it is. */
static struct error *open_cache(const struct truth_job *job, struct path_tracer *tracer,
                                const struct table *table, struct capture_cache *cache)
{
    const struct truth_settings *s = job->settings;
    struct capture_settings settings = job->stage->capture_settings;
    settings.bounces = tracer->bounces;
    settings.rays = (int)s->rays;
    struct error *err = capture_cache_open_rows(cache, tracer, &settings, &s->cache,
                                                job->stage->scene, table, 0, table->rows,
                                                job->threads);
    if (!err && *cache->told)
        warnings_add(job->warnings, "preview", "%s%s",
                     cache->on ? "a preview, and not the truth: " : "", cache->told);
    return error_wrap(err, "--truth-cache");
}

/* Traces the light at the places of a table, into its columns. *preview: through a cache. */
static struct error *trace_table(const struct truth_job *job, const struct table *table,
                                 bool *preview)
{
    struct capture_cache cache = {0};
    const struct truth_settings *s = job->settings;
    struct path_tracer tracer = job->stage->path;
    tracer.bounces = (int)bounces_of(job->stage, s);
    const int rays = (int)((s->rays + 1) / 2);
    struct work work = {.path_tracer = &tracer,
                        .tracer = job->stage->tracer,
                        .position = column_f64(table_column(table, "position")),
                        .seed = s->seed,
                        .progress = job->progress,
                        .surface = column_f32(table_column(table, "surface")),
                        .half = {column_f32(table_column(table, "irradiance_1")),
                                 column_f32(table_column(table, "irradiance_2"))},
                        .settings = job->stage->capture_settings};
    work.settings.rays = rays;
    work.settings.error = s->error;
    work.settings.error_floor = 0;
    work.settings.rays_most = (int)fmax((double)s->rays_most / 2, rays);
    work.settings.columns = 0;
    work.settings.normal = sphere_direction[0];
    work.settings.normal_count = SPHERE_COUNT;
    struct error *err = open_cache(job, &tracer, table, &cache);
    if (!err)
        err = threads_for(job->threads, table->rows, trace_one, &work);
    path_use_cache(&tracer, NULL);
    *preview = cache.on;
    capture_cache_clear(&cache);
    return err;
}

/* The region that points are in, if one is asked for, and the bounds within those of it. */
static struct error *open_reach(struct reach **reach, const struct truth_job *job,
                                struct space *space)
{
    const struct truth_settings *s = job->settings;
    struct reach_settings settings = s->reach;
    settings.threads = job->threads;
    if (!s->reach_file)
        return NULL;
    struct error *err =
        reach_create(reach, s->reach_file, job->stage->tracer, &settings, job->warnings);
    if (err)
        return err;
    space->reach = *reach;
    if (!s->bounds_given) /* else the points of this box that are in the region */
        reach_box(*reach, space->bounds, space->bounds + 3);
    return NULL;
}

/* Refuses early what there is no memory for: points are judged, and traced, for long before all of
 * it is needed. */
static struct error *check_memory(const struct truth_settings *s)
{
    enum { EACH = 3 * sizeof(double) + sizeof(int32_t) + (1 + 2 * TRUTH_WIDTH) * sizeof(float) };
    void *room = NULL;
    struct error *err = array_create(&room, truth_size(s), EACH);
    free(room);
    return error_memory_for(err,
                            "%.3g GB for the truth at %zu points (--points and --paths), %d "
                            "bytes each",
                            (double)truth_size(s) * EACH / 1e9, truth_size(s), (int)EACH);
}

struct error *truth_trace(struct truth *truth, const struct truth_job *job)
{
    const struct stage *stage = job->stage;
    const struct truth_settings *s = job->settings;
    struct space space = {.job = job};
    *truth = (struct truth){0};
    struct place place = {0};
    int32_t *path = NULL;
    size_t points = 0;
    struct table *table = NULL;
    bool preview = false;
    choose_bounds(s, stage->scene, job->box, space.bounds);
    struct reach *reach = NULL;
    struct error *err = open_reach(&reach, job, &space);
    space.step = s->step_given ? s->step : default_step(space.bounds);
    if (!err && (!(space.step > 0) || !(space.step < (double)INFINITY)))
        err = error_new("the box is a point: --bounds says where to look");
    if (!err)
        err = check_memory(s);
    if (!err)
        err = place_all(&space, &place, &path, &points);
    if (!err)
        err = stream_create(&truth->stream);
    if (!err)
        err = stream_add_table(truth->stream, "probe", &table);
    if (!err)
        err = add_columns(table);
    if (!err)
        err = table_resize(table, place.count);
    if (!err)
        err = header_add_provenance(&truth->stream->header, job->command_line);
    if (!err)
        err = scene_settings_to_header(&stage->scene_settings, &truth->stream->header);
    if (!err)
        err = describe(&truth->stream->header, stage, s, space.bounds, space.step);
    if (!err) {
        memcpy(column_f64(table_column(table, "position")), place.position,
               3 * place.count * sizeof(double));
        memcpy(column_i32(table_column(table, "path")), path, place.count * sizeof *path);
        err = trace_table(job, table, &preview);
    }
    if (!err && preview)
        err = header_set_key(&truth->stream->header, CACHE_KEY, s->cache.name);
    if (!err)
        err = find_columns(truth);
    truth->step = space.step;
    memcpy(truth->low, space.bounds, sizeof truth->low);
    memcpy(truth->high, space.bounds + 3, sizeof truth->high);
    free(path);
    place_clear(&place);
    reach_destroy(reach);
    return err;
}

/* -- reading ---------------------------------------------------------------------------------- */

/* Whether the rows from `first` on are at these positions, all of them. */
static bool same_positions(const struct truth *t, size_t first, size_t count,
                           const struct place *place)
{
    return place->count == count &&
           !memcmp(t->position + 3 * first, place->position, 3 * count * sizeof(double));
}

static struct error *check_positions(const struct truth *t, const struct truth_settings *s)
{
    struct place points = {0}, path = {0};
    struct error *err = s->points_file ? place_points(&points, s->points_file, 1e9, NULL) : NULL;
    if (!err && s->path_file)
        err = place_path(&path, s->path_file,
                         &(struct place_way){.step = s->step_given ? s->step : t->step}, 1e9, NULL);
    if (!err && s->points_file && !same_positions(t, 0, t->points, &points))
        err = error_new("this truth is not at the points of %s", s->points_file);
    if (!err && s->path_file && !same_positions(t, t->points, t->count - t->points, &path))
        err = error_new("this truth is not along the path of %s", s->path_file);
    place_clear(&points);
    place_clear(&path);
    return err;
}

static struct error *check_read(struct truth *t, const struct stage *stage,
                                const struct truth_settings *s)
{
    const struct stream_header *is = &t->stream->header;
    struct stream_header wanted = {0};
    double bounds[6];
    struct error *err = describe(&wanted, stage, s, s->bounds, s->step);
    if (!err)
        err = check_described(is, &wanted, stage->scene, s);
    if (!err)
        err = find_columns(t);
    if (!err)
        err = header_require(is, "truth-bounds");
    if (!err)
        err = header_get_reals(is, "truth-bounds", 6, -DBL_MAX, DBL_MAX, bounds);
    if (!err)
        err = header_require(is, "truth-step");
    if (!err)
        err = header_get_real(is, "truth-step", 0, DBL_MAX, &t->step);
    if (!err) {
        memcpy(t->low, bounds, sizeof t->low);
        memcpy(t->high, bounds + 3, sizeof t->high);
        err = check_positions(t, s);
    }
    header_clear(&wanted);
    return err;
}

struct error *truth_read(struct truth *truth, const char *file, const struct stage *stage,
                         const struct truth_settings *settings)
{
    *truth = (struct truth){0};
    struct error *err = stream_read(&truth->stream, file);
    return err ? err : error_wrap(check_read(truth, stage, settings), "%s", file);
}

bool truth_is_preview(const struct truth *truth)
{
    return header_key(&truth->stream->header, CACHE_KEY);
}

void truth_clear(struct truth *truth)
{
    stream_destroy(truth->stream);
    *truth = (struct truth){0};
}

size_t truth_size(const struct truth_settings *s)
{
    return s->points_file || s->path_file ? 0 : (size_t)(s->points + s->paths * (STEPS_MOST + 1));
}

void truth_luminance(const struct truth *t, size_t i, double *mean, double *noise)
{
    double sum[TRUTH_WIDTH], difference[TRUTH_WIDTH];
    for (size_t k = 0; k < TRUTH_WIDTH; k++) {
        const double a = (double)t->half[0][TRUTH_WIDTH * i + k],
                     b = (double)t->half[1][TRUTH_WIDTH * i + k];
        sum[k] = (a + b) / 2;
        difference[k] = (a - b) / 2;
    }
    if (mean)
        sphere_luminance(sum, mean);
    if (noise)
        sphere_luminance(difference, noise);
}
