/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/place_light.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/vec.h"
#include "place/place_inside.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "stream/stream.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct option_row *place_light_rows(struct place_options *options, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "rays",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->light.rays,
         .given = &options->light.rays_given,
         .least = 16,
         .most = CAPTURE_RAYS_MOST,
         .shown = "256; adaptive 512; poisson 64",
         .help = "by light: rays at each position that is looked at; adaptive: rays a\n"
                 "probe, at the least (noise): points that could be one get half;\n"
                 "poisson: rays of occlusion"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->light.bounces,
         .given = &options->light.bounces_given,
         .most = CAPTURE_BOUNCES_MOST,
         .help = "by light: how often it may scatter on its way"},
        {.name = "light",
         .argument = "WHICH",
         .kind = OPTION_CHOICE,
         .choices = capture_light_names,
         .value = OPTION_ENUM(options->light.light),
         .given = &options->light.light_given,
         .shown = "all; spawn-merge, ascent indirect",
         .help = "by light: probes for all light, direct or indirect alone"},
        {.name = "order",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->light.order,
         .given = &options->light.order_given,
         .least = 1,
         .most = SH_ORDER_MAX,
         .help = "by light: SH order that the probes will have"},
        {.name = "keep",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &options->light.keep,
         .given = &options->light.keep_given,
         .shown = "none",
         .help = "by light: a stream of probes that stay"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

/* -- open and close --------------------------------------------------------------------------- */

static struct error *read_kept(struct place_light *light, const char *file)
{
    struct column *position = NULL;
    struct error *err = stream_read(&light->stream, file);
    const struct table *probes = err ? NULL : stream_table(light->stream, "probe");
    if (err)
        return err;
    if (!probes)
        return error_new("%s: there is no table probe", file);
    if (table_column(probes, "normal"))
        return error_new("%s: expected probes in space, got probes with normals", file);
    err = table_require(probes, "position", COLUMN_F64, 3, &position);
    if (!err) {
        light->kept_count = probes->rows;
        light->kept = column_f64(position);
    }
    return error_wrap(err, "%s", file);
}

struct error *place_light_open(struct place_light *light, const struct place_options *o,
                               struct place_world *world, int rays, enum capture_light which)
{
    light->world = world;
    light->settings = capture_settings_default();
    light->settings.order = o->light.order;
    light->settings.rays = o->light.rays_given ? o->light.rays : rays;
    light->settings.bounces = o->light.bounces;
    light->settings.light = o->light.light_given ? (enum capture_light)o->light.light : which;
    light->settings.seed = world->seed;
    light->settings.columns = 0;
    struct error *err = o->light.keep ? read_kept(light, o->light.keep) : NULL;
    if (!err)
        err = trace_create(&light->tracer, world->scene);
    if (!err)
        err = path_init(&light->path, light->tracer, light->settings.bounces);
    if (!err)
        interrupt_catch(); /* from here on there is something to lose */
    return err;
}

void place_light_close(struct place_light *light)
{
    place_judge_destroy(light->judge);
    stream_destroy(light->stream);
    path_clear(&light->path);
    trace_destroy(light->tracer);
    *light = (struct place_light){0};
}

/* -- light ------------------------------------------------------------------------------------ */

struct capturing {
    const struct place_light *light;
    const double *position;
    float *sh;
    double *noise; /* NULL: nobody asks */
    struct progress *progress;
};

size_t place_light_width(const struct place_light *light)
{
    return 3 * (size_t)light->settings.order * (size_t)light->settings.order;
}

static double noise_of(int order, const float *error)
{
    double sum = 0;
    for (int l = 0, i = 0; l < order; l++)
        for (; i < 3 * (l + 1) * (l + 1); i++) {
            const double e = sh_cosine(l) * (double)error[i];
            sum += e * e;
        }
    return sum / (3 * 4 * ANGLE_PI);
}

static struct error *capture_one(void *context, size_t i, int thread)
{
    (void)thread;
    const struct capturing *c = context;
    const double *p = c->position + 3 * i;
    const size_t width = place_light_width(c->light);
    float *sh = c->sh + width * i;
    struct capture_probe probe;
    if (interrupt_came()) {
        for (size_t k = 0; k < width; k++)
            sh[k] = NAN;
        return NULL;
    }
    struct error *err = capture_probe(&c->light->path, &c->light->settings, p, NULL, &probe);
    for (size_t k = 0; k < width && !err; k++) {
        sh[k] = probe.sh[k];
        if (!isfinite(sh[k]))
            err = error_new("light is beyond what 32 bits can hold: --light-scale brings it down");
    }
    if (c->noise && !err)
        c->noise[i] = noise_of(c->light->settings.order, probe.sh_error);
    progress_add(c->progress, 1);
    return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
}

struct error *place_light_capture(struct place_light *light, size_t count, const double *position,
                                  float *sh)
{
    return place_light_capture_noise(light, count, position, sh, NULL);
}

struct error *place_light_capture_noise(struct place_light *light, size_t count,
                                        const double *position, float *sh, double *noise)
{
    const struct place_world *world = light->world;
    struct capturing c = {light, position, sh, noise,
                          progress_start(world->progress, world->program, "points", count)};
    struct error *err = threads_for(world->inside.threads, count, capture_one, &c);
    progress_end(c.progress);
    for (size_t i = 0; i < count && !err; i++)
        if (!isnan(sh[place_light_width(light) * i]))
            light->rays += (size_t)capture_ray_count(light->settings.rays);
    return err;
}

/* -- air -------------------------------------------------------------------------------------- */

struct asking {
    const struct place_light *light;
    const double *position;
    bool *air;
};

static struct error *ask_one(void *context, size_t i, int thread)
{
    (void)thread;
    struct asking *a = context;
    a->air[i] = place_judge_side(a->light->judge, a->position + 3 * i) == PLACE_AIR;
    return NULL;
}

/* Makes the judge of these positions, and says which are in the air. */
static struct error *find_first(struct place_light *light, size_t count, const double *position,
                                bool *air)
{
    struct place place = {.count = count};
    enum place_side *side = NULL;
    struct error *err = array_create(&place.position, 3 * count, sizeof *place.position);
    if (!err)
        err = array_create(&side, count, sizeof *side);
    if (!err) {
        memcpy(place.position, position, 3 * count * sizeof *position);
        err = place_judge_create(&light->judge, &place, light->tracer, &light->world->inside, side,
                                 light->world->warnings);
    }
    for (size_t i = 0; i < count && !err; i++)
        air[i] = side[i] == PLACE_AIR;
    place_clear(&place);
    free(side);
    return err;
}

struct error *place_light_air(struct place_light *light, size_t count, const double *position,
                              bool *air)
{
    struct asking a = {light, position, air};
    return light->judge ? threads_for(light->world->inside.threads, count, ask_one, &a)
                        : find_first(light, count, position, air);
}

bool place_light_is_free(const struct place_light *light, const double a[3], const double b[3])
{
    const struct vec3 way = vec3_sub(vec3_load(b), vec3_load(a));
    const double length = vec3_length(way);
    double direction[3];
    if (!(length > 0))
        return true;
    vec3_store(direction, vec3_scale(1 / length, way));
    return !trace_nearest(light->tracer, a, direction, length).hit;
}

/* -- what is told ----------------------------------------------------------------------------- */

void place_light_tell_round(const struct place_light *light, const struct place_round *round)
{
    if (light->world->program)
        fprintf(stderr,
                "%s: round %d: %zu probes, %zu merged, %zu added, %zu moved, %zu stepped back, "
                "%zu rays\n",
                light->world->program, round->number, round->probes, round->merged, round->added,
                round->moved, round->back, light->rays);
}

void place_light_tell_end(const struct place_light *light, size_t probes, const char *why)
{
    if (light->world->program)
        fprintf(stderr, "%s: %zu probes: %s\n", light->world->program, probes, why);
}

/* -- what comes out --------------------------------------------------------------------------- */

static int compare_positions(const void *a, const void *b)
{
    const double *p = a, *q = b;
    for (int k = 0; k < 3; k++)
        if (p[k] < q[k] || p[k] > q[k])
            return p[k] < q[k] ? -1 : 1;
    return 0;
}

/* How many probes that stay are where another one is. */
static struct error *count_same(const struct place_light *light, size_t *same)
{
    double *sorted = NULL;
    struct error *err = array_create(&sorted, 3 * light->kept_count, sizeof *sorted);
    *same = 0;
    if (err)
        return err;
    memcpy(sorted, light->kept, 3 * light->kept_count * sizeof *sorted);
    qsort(sorted, light->kept_count, 3 * sizeof *sorted, compare_positions);
    for (size_t i = 1; i < light->kept_count; i++)
        *same += !compare_positions(sorted + 3 * (i - 1), sorted + 3 * i);
    free(sorted);
    return NULL;
}

/* Farther outside of the scene's box than half its longest side. */
static bool is_far(const struct scene *scene, const double p[3])
{
    struct box box;
    vec3_store(box.low, scene->box_min);
    vec3_store(box.high, scene->box_max);
    const double far = box_side(&box) / 2;
    for (int k = 0; k < 3; k++)
        if (p[k] < box.low[k] - far || p[k] > box.high[k] + far)
            return true;
    return false;
}

/* Warns of probes that stay although nobody would put them there. */
static struct error *warn_kept(struct place_light *light, size_t count, const double *position)
{
    const struct place_world *world = light->world;
    const size_t kept = light->kept_count;
    size_t same = 0, far = 0, buried = 0;
    struct error *err = count_same(light, &same);
    if (!err)
        err = place_judge_of(&light->judge, light->tracer, count ? count : kept,
                             count ? position : light->kept, world->inside.threads);
    for (size_t i = 0; i < kept && !err; i++) {
        const double *p = light->kept + 3 * i;
        if (is_far(world->scene, p))
            far++;
        else
            buried += place_judge_side(light->judge, p) != PLACE_AIR;
    }
    if (same)
        warnings_add(world->warnings, "kept twice",
                     "--keep: %zu of %zu probes are where another one is: all stay, and probe-tet "
                     "takes them for one",
                     same, kept);
    if (far)
        warnings_add(world->warnings, "kept far off",
                     "--keep: %zu of %zu probes are far outside of the scene's box: they stay, and "
                     "cells will reach out to them",
                     far, kept);
    if (buried)
        warnings_add(world->warnings, "kept in no air",
                     "--keep: %zu of %zu probes are in no air, as in solids or under the ground: "
                     "they stay",
                     buried, kept);
    return err;
}

struct error *place_light_give(struct place_light *light, struct place *place, size_t count,
                               const double *position, int origin)
{
    const struct table *probes = light->stream ? stream_table(light->stream, "probe") : NULL;
    const struct column *known = probes ? table_column(probes, "origin") : NULL;
    const size_t kept = light->kept_count;
    struct error *err = kept ? warn_kept(light, count, position) : NULL;
    if (!err)
        err = array_create(&place->origin, kept + count, sizeof *place->origin);
    for (size_t i = 0; i < kept && !err; i++) {
        place->origin[i] = known ? column_i32(known)[i] : -1;
        err = place_append(place, light->kept + 3 * i);
    }
    for (size_t i = 0; i < count && !err; i++) {
        place->origin[kept + i] = origin;
        err = place_append(place, position + 3 * i);
    }
    return err;
}
