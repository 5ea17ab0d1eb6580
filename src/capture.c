#include "capture.h"
#include "angle.h"
#include "array.h"
#include "error.h"
#include "progress.h"
#include "scene.h"
#include "stream.h"
#include "threads.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const light_names[] = {[CAPTURE_ALL] = "all", [CAPTURE_DIRECT] = "direct", [CAPTURE_INDIRECT] = "indirect"};

struct capture_settings capture_settings_default(void)
{
    return (struct capture_settings){.order = 3, .rays = 512, .bounces = 64, .columns = CAPTURE_DEFAULT};
}

/* -- header ----------------------------------------------------------------------------------- */

static struct error *set_number(struct stream_header *header, const char *key, uint64_t value)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRIu64, value);
    return header_set_key(header, key, text);
}

struct error *capture_settings_to_header(const struct capture_settings *settings, struct stream_header *header)
{
    struct error *err = set_number(header, "sh-order", (uint64_t)settings->order);
    if (!err)
        err = header_set_key(header, "sh-content", "radiance");
    if (!err)
        err = header_set_key(header, "capture-light", light_names[settings->light]);
    if (!err)
        err = set_number(header, "capture-rays", (uint64_t)settings->rays);
    if (!err)
        err = set_number(header, "capture-bounces", (uint64_t)settings->bounces);
    if (!err)
        err = set_number(header, "capture-seed", settings->seed);
    return err;
}

static struct error *get_number(const struct stream_header *header, const char *key, uint64_t least, uint64_t most, uint64_t *value)
{
    const char *text = header_key(header, key);
    if (!text)
        return NULL;
    char *end;
    const unsigned long long number = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || number < least || number > most)
        return error_new("header key %s: expected a whole number from %" PRIu64 " to %" PRIu64 ", got '%s'", key, least, most, text);
    *value = number;
    return NULL;
}

struct error *capture_settings_from_header(struct capture_settings *settings, const struct stream_header *header)
{
    uint64_t order = (uint64_t)settings->order, rays = (uint64_t)settings->rays, bounces = (uint64_t)settings->bounces;
    struct error *err = get_number(header, "sh-order", 1, SH_ORDER_MAX, &order);
    if (!err)
        err = get_number(header, "capture-rays", 1, CAPTURE_RAYS_MOST, &rays);
    if (!err)
        err = get_number(header, "capture-bounces", 0, CAPTURE_BOUNCES_MOST, &bounces);
    if (!err)
        err = get_number(header, "capture-seed", 0, (uint64_t)1 << 53, &settings->seed);
    settings->order = (int)order;
    settings->rays = (int)rays;
    settings->bounces = (int)bounces;
    const char *light = header_key(header, "capture-light");
    for (int i = 0; light && i < 3; i++) {
        if (!strcmp(light, light_names[i])) {
            settings->light = (enum capture_light)i;
            light = NULL;
        }
    }
    if (!err && light)
        err = error_new("header key capture-light: expected all, direct or indirect, got '%s'", light);
    return err;
}

bool capture_header_has_settings(const struct stream_header *header)
{
    return header_key(header, "capture-rays");
}

struct error *capture_check_same(const struct stream_header *before, const struct stream_header *now)
{
    static const char *const keys[] = {"sh-order",        "sh-content",   "capture-light", "capture-rays",
                                       "capture-bounces", "capture-seed", "scene-key"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const char *was = header_key(before, keys[i]), *is = header_key(now, keys[i]);
        if (!was || !is || !strcmp(was, is))
            continue;
        if (!strcmp(keys[i], "scene-key"))
            return error_new("the probes were captured in another scene, or with other light in it");
        return error_new("the probes were captured with %s %s, not %s", keys[i], was, is);
    }
    return NULL;
}

/* -- one probe -------------------------------------------------------------------------------- */

struct grid {
    int rows, columns; /* cells in z and phi */
};

static struct grid grid_for(const struct capture_settings *settings)
{
    const int cells = settings->rays / 2 > 2 ? settings->rays / 2 + settings->rays % 2 : 2;
    int rows = (int)sqrt(cells / 3.0);
    rows = rows > 1 ? rows : 1;
    return (struct grid){.rows = rows, .columns = (cells + rows - 1) / rows};
}

int capture_ray_count(const struct capture_settings *settings)
{
    const struct grid grid = grid_for(settings);
    return 2 * grid.rows * grid.columns;
}

/* A uniform direction within cell (row, column) of the sphere: equal steps of z have equal areas (Archimedes). */
static void cell_direction(const struct grid *grid, int row, int column, struct random *random, double d[3])
{
    const double z = 2 * (row + (double)random_float(random)) / grid->rows - 1;
    const double phi = 2 * ANGLE_PI * (column + (double)random_float(random)) / grid->columns;
    const double r = sqrt(fmax(1 - z * z, 0));
    d[0] = r * angle_cos(phi);
    d[1] = r * angle_sin(phi);
    d[2] = z;
}

/* What the samples of a probe add up to. */
struct sums {
    double sh[3 * SH_COUNT_MAX];       /* of the samples */
    double variance[3 * SH_COUNT_MAX]; /* of squared differences within cells */
    double inverse_distance;
    int rays, hits, fronts;
};

static void project(const struct capture_settings *settings, struct vec3f rgb, const double d[3], double weight, double *sh)
{
    if (rgb.x == 0 && rgb.y == 0 && rgb.z == 0)
        return;
    double y[SH_COUNT_MAX];
    sh_basis(settings->order, d, y);
    sh_project(settings->order, y, (const double[3]){(double)rgb.x, (double)rgb.y, (double)rgb.z}, weight, sh);
}

/* Projects one sample into sh, which is zero, and counts what its ray met. */
static void take_sample(const struct path_tracer *path, const struct capture_settings *settings, struct vec3f origin,
                        const double d[3], struct random *random, double *sh, struct sums *sums)
{
    const struct vec3f direction = {(float)d[0], (float)d[1], (float)d[2]};
    const struct path_sample s = path_sample(path, origin, direction, settings->light != CAPTURE_DIRECT, random);
    struct vec3f radiance = s.indirect;
    if (settings->light == CAPTURE_DIRECT)
        radiance = s.direct;
    else if (settings->light == CAPTURE_ALL)
        radiance = vec3f_add(s.direct, s.indirect);
    project(settings, radiance, d, 4 * ANGLE_PI, sh);
    if (settings->light != CAPTURE_INDIRECT) {
        const struct vec3f l = s.light_direction;
        project(settings, s.light, (const double[3]){(double)l.x, (double)l.y, (double)l.z}, 1, sh);
    }
    sums->rays++;
    sums->hits += s.hit;
    sums->fronts += s.hit && s.front;
    if (s.hit)
        sums->inverse_distance += 1 / (double)s.distance;
}

/* Two samples of one cell. */
static void take_cell(const struct path_tracer *path, const struct capture_settings *settings, const struct grid *grid, int row,
                      int column, uint64_t name, struct vec3f origin, struct sums *sums)
{
    const int values = 3 * settings->order * settings->order;
    double sample[2][3 * SH_COUNT_MAX];
    for (int i = 0; i < 2; i++) {
        struct random random = random_start(settings->seed, name, (uint32_t)(2 * (row * grid->columns + column) + i));
        double d[3];
        cell_direction(grid, row, column, &random, d);
        memset(sample[i], 0, (size_t)values * sizeof **sample);
        take_sample(path, settings, origin, d, &random, sample[i], sums);
    }
    for (int k = 0; k < values; k++) {
        const double difference = sample[0][k] - sample[1][k];
        sums->sh[k] += sample[0][k] + sample[1][k];
        sums->variance[k] += difference * difference;
    }
}

/* Light that comes straight from point, spot and sun lights: a delta in its direction. */
static void add_punctual(const struct path_tracer *path, const struct capture_settings *settings, const double p[3],
                         struct vec3f origin, double *sh)
{
    const struct scene *scene = trace_scene(path->tracer);
    double start[3];
    vec3_store(start, trace_to_world(path->tracer, origin));
    for (size_t i = 0; i < scene->light_count; i++) {
        const struct scene_light *light = &scene->lights[i];
        double d[3], distance, rgb[3];
        scene_light_at(light, p, d, &distance, rgb);
        if (!(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0))
            continue;
        const double at[3] = {light->position.x, light->position.y, light->position.z};
        const float visible =
            light->kind == SCENE_SUN ? trace_visibility_sky(path->tracer, start, d) : trace_visibility(path->tracer, start, at);
        double y[SH_COUNT_MAX];
        sh_basis(settings->order, d, y);
        sh_project(settings->order, y, rgb, (double)visible, sh);
    }
}

void capture_probe(const struct path_tracer *path, const struct capture_settings *settings, const double p[3],
                   struct capture_probe *result)
{
    const struct grid grid = grid_for(settings);
    const uint64_t name = random_hash_position(p);
    const struct vec3f origin = trace_start(path->tracer, p);
    struct sums sums = {0};
    for (int row = 0; row < grid.rows; row++)
        for (int column = 0; column < grid.columns; column++)
            take_cell(path, settings, &grid, row, column, name, origin, &sums);
    /* The mean over cells of the mean of two; its variance from each cell's (x1 - x2)^2 / 4. */
    const int values = 3 * settings->order * settings->order;
    const double cells = grid.rows * grid.columns;
    for (int k = 0; k < values; k++) {
        sums.sh[k] /= 2 * cells;
        result->sh_error[k] = (float)(sqrt(sums.variance[k]) / (2 * cells));
    }
    if (settings->light != CAPTURE_INDIRECT)
        add_punctual(path, settings, p, origin, sums.sh);
    for (int k = 0; k < values; k++)
        result->sh[k] = (float)sums.sh[k];
    result->validity = sums.hits ? (float)sums.fronts / (float)sums.hits : 1;
    result->sky = (float)(sums.rays - sums.hits) / (float)sums.rays;
    result->depth = sums.hits ? (float)(sums.rays / sums.inverse_distance / path->tracer->scale) : 0;
}

/* -- tables ----------------------------------------------------------------------------------- */

struct error *capture_add_columns(const struct capture_settings *settings, struct table *table)
{
    const size_t width = (size_t)(3 * settings->order * settings->order);
    const struct {
        unsigned flag;
        const char *name;
        size_t width;
    } columns[] = {{0, "sh", width}, {CAPTURE_SH_ERROR, "sh_error", width}, {CAPTURE_VALIDITY, "validity", 1},
                   {CAPTURE_DEPTH, "depth", 1}, {CAPTURE_SKY, "sky", 1}};
    struct error *err = NULL;
    for (size_t i = 0; i < sizeof columns / sizeof *columns && !err; i++) {
        const struct column *there = table_column(table, columns[i].name);
        const bool wanted = !columns[i].flag || settings->columns & columns[i].flag;
        if (there ? there->type != COLUMN_F32 || there->width != columns[i].width : wanted)
            err = table_add_column(table, columns[i].name, COLUMN_F32, columns[i].width, NULL);
    }
    return err;
}

/* The rows to be captured, and where their results go; a column that the table lacks is NULL. */
struct job {
    const struct path_tracer *path;
    const struct capture_settings *settings;
    const double *position;
    struct column *sh, *sh_error, *validity, *depth, *sky;
    const size_t *row;
    struct progress *progress;
};

static void store(const struct column *column, size_t row, const float *value)
{
    if (column)
        memcpy(column_f32(column) + row * column->width, value, column->width * sizeof *value);
}

static struct error *capture_one(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    const size_t row = job->row[index];
    struct capture_probe result;
    capture_probe(job->path, job->settings, job->position + 3 * row, &result);
    for (int k = 0; k < 3 * job->settings->order * job->settings->order; k++)
        if (!isfinite(result.sh[k]))
            return error_new("probe %zu: the light is beyond what 32 bits can hold: --light-scale brings it down", row);
    store(job->sh, row, result.sh);
    store(job->sh_error, row, result.sh_error);
    store(job->validity, row, &result.validity);
    store(job->depth, row, &result.depth);
    store(job->sky, row, &result.sky);
    progress_add(job->progress, 1);
    return NULL;
}

struct error *capture_rows(const struct path_tracer *path, const struct capture_settings *settings, struct table *table,
                           size_t first, size_t count, bool again, int threads, struct progress *progress,
                           size_t *captured)
{
    const size_t width = (size_t)(3 * settings->order * settings->order);
    struct column *position = NULL;
    struct job job = {.path = path, .settings = settings, .progress = progress};
    size_t *row = NULL;
    *captured = 0;
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(table, "sh", COLUMN_F32, width, &job.sh);
    if (!err)
        err = array_create(&row, count, sizeof *row);
    if (err)
        return err;
    job.position = column_f64(position);
    job.sh_error = table_column(table, "sh_error");
    job.validity = table_column(table, "validity");
    job.depth = table_column(table, "depth");
    job.sky = table_column(table, "sky");
    for (size_t i = first; i < first + count; i++)
        if (again || isnan(column_f32(job.sh)[i * width]))
            row[(*captured)++] = i;
    job.row = row;
    err = threads_for(threads, *captured, capture_one, &job);
    free(row);
    return err;
}
