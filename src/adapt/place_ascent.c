/* SPDX-License-Identifier: Apache-2.0 */
/* The method `ascent` of probe-place (P. Sukys, "Light probe cloud generation for games", Chalmers
 * University, 2014, sec. 3.1.2, after Chajdas, Weis and Westermann, "Assisted environment map probe
 * placement", SIGRAD 2011).
 *
 * Probes of a grid go in steps to where light comes from: along the sum of directions weighted by
 * the luminance there, which for SH of order 3 or less, along 6 or 26 directions alike, is band 1
 * (sh_dominant). Steps are taken back that end in the dark, or that end near or behind a surface;
 * whose step it was makes smaller ones from then on, and from the fifth round on all do. Black
 * probes do not go: in the end some stand for their areas (unlit.h). Probes that arrived together
 * merge (cloud.h).
 */
#include "adapt/cloud.h"
#include "adapt/unlit.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "libprobe-query/sh.h"
#include "math/box.h"
#include "math/luminance.h"
#include "math/vec.h"
#include "place/place.h"
#include "place/place_method.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 256, ROUNDS = 16 };
enum { SLOWER_FROM = 5 }; /* round */

/* Steps in spacings. */
static const double FIRST_STEP = 1.0 / 2, LEAST_STEP = 1.0 / 32, SLOWER = 1 / 1.5, TAKEN_BACK = 0.5,
                    STAND_OFF = 1.0 / 16;
static const double MERGE_CONTRAST = 0.05;

enum step_back { STEP_BACK_WALL, STEP_BACK_DARK };

/* -- options ---------------------------------------------------------------------------------- */

static struct option_row *rows(struct place_options *options, struct option_row *row)
{
    static const char *const backs[] = {[STEP_BACK_WALL] = "wall", [STEP_BACK_DARK] = "dark", NULL};
    *row++ = (struct option_row){.name = "step-back",
                                 .argument = "FROM",
                                 .kind = OPTION_CHOICE,
                                 .choices = backs,
                                 .value = OPTION_ENUM(options->step_back),
                                 .given = &options->step_back_given,
                                 .help = "ascent: take steps back that meet a wall or end in the\n"
                                         "dark, or in the dark alone, as the source does"};
    return row;
}

static struct error *check(const struct place_options *o, bool scene)
{
    struct error *err = place_method_grid.check(o, scene);
    if (!err && o->merge.contrast == CONTRAST_MSE && !o->merge.merge_contrast_given)
        err = error_usage("--contrast mse has no bound: expected --merge-contrast");
    if (!err && o->light.order < 2)
        err = error_usage("ascent: expected --order 2 or more, which tells where light comes from");
    return err;
}

/* -- the dark --------------------------------------------------------------------------------- */

/* What a run has beside its cloud. */
struct ascent {
    struct cloud *cloud;
    struct cloud_probe *dark; /* taken out of it; owned, as all here is */
    size_t dark_count;
    double black;   /* luminance of band 0 below which there is no light */
    struct box box; /* of the grid and half a spacing around it */
    bool walls;     /* steps are taken back from them */
    uint32_t *list; /* probes that step, */
    size_t stepping;
    double *to; /* to where, 3 each, and the light there */
    float *sh;
    double *noise;
};

static bool is_dark(const struct ascent *a, const float *sh)
{
    const double bright = luminance_f32(sh);
    return !(bright > 0) || bright < a->black;
}

/* Takes out the black ones, of which those that see nothing are none. */
static struct error *part_dark(struct ascent *a)
{
    struct cloud *cloud = a->cloud;
    double sum = 0;
    size_t left = 0;
    struct error *err = array_create(&a->dark, cloud->count, sizeof *a->dark);
    for (size_t i = 0; i < cloud->count; i++)
        sum += luminance_f32(cloud_light(cloud, i));
    a->black = UNLIT_SHARE * sum / (double)cloud->count;
    for (size_t i = 0; i < cloud->count && !err; i++) {
        const struct cloud_probe *p = &cloud->probe[i];
        if (p->kept >= 0 || !is_dark(a, cloud_light(cloud, i)))
            cloud->probe[left++] = *p;
        else if (unlit_sees_surface(cloud->light->tracer, p->position))
            a->dark[a->dark_count++] = *p;
    }
    if (!err)
        cloud->count = left;
    return err;
}

/* Puts those back that stand for the areas. */
static struct error *give_dark(struct ascent *a, int wanted)
{
    const struct cloud *cloud = a->cloud;
    const double *s = cloud->spacing;
    struct unlit_job job = {.count = a->dark_count,
                            .reach = 1.01 * fmax(s[0], fmax(s[1], s[2])),
                            .tracer = cloud->light->tracer,
                            .wanted = wanted,
                            .seed = cloud->light->settings.seed};
    struct unlit_cluster *cluster = NULL;
    double *position = NULL;
    size_t count = 0, areas = 0;
    struct error *err = array_create(&position, 3 * a->dark_count, sizeof *position);
    for (size_t i = 0; i < a->dark_count && !err; i++)
        memcpy(position + 3 * i, a->dark[i].position, 3 * sizeof *position);
    job.position = position;
    if (!err)
        err = unlit_find(&job, &cluster, &count, &areas);
    for (size_t i = 0; i < count && !err; i++) {
        struct cloud_probe *p = &a->dark[cluster[i].probe];
        p->cluster = (int32_t)cluster[i].size;
        err = cloud_add(a->cloud, p);
    }
    if (!err && a->dark_count && cloud->light->world->program)
        unlit_tell(cloud->light->world->program, a->dark_count, areas, count);
    free(position);
    free(cluster);
    return err;
}

/* -- steps ------------------------------------------------------------------------------------ */

/* Where a probe would step: `step` spacings along its gradient. */
static void step_to(const struct cloud *cloud, const struct cloud_probe *p, double to[3])
{
    struct vec3 d = {(double)p->gradient[0], (double)p->gradient[1], (double)p->gradient[2]};
    const double *s = cloud->spacing,
                 length = vec3_length((struct vec3){d.x / s[0], d.y / s[1], d.z / s[2]});
    vec3_store(to, vec3_fma(vec3_load(p->position), p->step / length, d));
}

/* Whether a step leaves the box or ends out of the region, or a surface is within it and the
 * stand-off. */
static bool is_barred(const struct ascent *a, const struct cloud_probe *p, const double to[3])
{
    const struct vec3 way = vec3_sub(vec3_load(to), vec3_load(p->position));
    const struct reach *region = a->cloud->light->world->reach;
    double beyond[3];
    for (int k = 0; k < 3; k++)
        if (!(to[k] >= a->box.low[k] && to[k] <= a->box.high[k]))
            return true;
    if (region && !reach_holds(region, to))
        return true;
    vec3_store(beyond, vec3_fma(vec3_load(to), STAND_OFF / p->step, way));
    return a->walls && !place_light_is_free(a->cloud->light, p->position, beyond);
}

static void take_back(struct cloud_probe *p, struct place_round *round)
{
    p->step *= TAKEN_BACK;
    p->back++;
    round->back++;
}

/* Lists the probes that step, and where to; those that a wall bars do not. */
static void find_steps(struct ascent *a, struct place_round *round)
{
    struct cloud *cloud = a->cloud;
    a->stepping = 0;
    for (size_t i = 0; i < cloud->count; i++) {
        struct cloud_probe *p = &cloud->probe[i];
        double g[3], *to = a->to + 3 * a->stepping;
        if (p->kept >= 0 || p->step < LEAST_STEP)
            continue;
        sh_dominant(cloud->light->settings.order, cloud_light(cloud, i), g);
        for (int k = 0; k < 3; k++)
            p->gradient[k] = (float)g[k];
        if (!(vec3_length(vec3_load(g)) > 0)) {
            p->step = 0;
            continue;
        }
        step_to(cloud, p, to);
        if (is_barred(a, p, to))
            take_back(p, round);
        else
            a->list[a->stepping++] = (uint32_t)i;
    }
}

/* One round of steps; *going: some probe goes on. */
static struct error *step(struct ascent *a, struct place_round *round, bool *going)
{
    struct cloud *cloud = a->cloud;
    const size_t width = place_light_width(cloud->light);
    round->moved = round->back = 0;
    find_steps(a, round);
    struct error *err =
        place_light_capture_noise(cloud->light, a->stepping, a->to, a->sh, a->noise);
    for (size_t i = 0; i < a->stepping && !err; i++) {
        struct cloud_probe *p = &cloud->probe[a->list[i]];
        const float *sh = a->sh + width * i;
        if (isnan(*sh)) /* a signal came */
            continue;
        if (is_dark(a, sh)) {
            take_back(p, round);
            continue;
        }
        memcpy(p->position, a->to + 3 * i, sizeof p->position);
        memcpy(cloud->sh + width * p->light, sh, width * sizeof *sh);
        cloud->noise[p->light] = a->noise[i];
        p->steps++;
        round->moved++;
    }
    *going = false;
    for (size_t i = 0; i < cloud->count && !err; i++) {
        struct cloud_probe *p = &cloud->probe[i];
        if (round->number >= SLOWER_FROM)
            p->step *= SLOWER;
        *going = *going || (p->kept < 0 && p->step >= LEAST_STEP);
    }
    return err;
}

static struct error *ascend(struct ascent *a, int most, struct place_round *round, const char **end)
{
    struct cloud *cloud = a->cloud;
    struct error *err = array_create(&a->list, cloud->count, sizeof *a->list);
    if (!err)
        err = array_create(&a->to, 3 * cloud->count, sizeof *a->to);
    if (!err)
        err = array_create(&a->sh, cloud->count, place_light_width(cloud->light) * sizeof *a->sh);
    if (!err)
        err = array_create(&a->noise, cloud->count, sizeof *a->noise);
    a->box = box_empty();
    for (size_t i = 0; i < cloud->count; i++) {
        box_add(&a->box, cloud->probe[i].position);
        cloud->probe[i].step = FIRST_STEP;
    }
    for (int k = 0; k < 3; k++) {
        a->box.low[k] -= cloud->spacing[k] / 2;
        a->box.high[k] += cloud->spacing[k] / 2;
    }
    round->probes = cloud->count;
    place_light_tell_round(cloud->light, round);
    *end = NULL;
    while (!err && !*end) {
        bool going = false;
        round->number++;
        err = step(a, round, &going);
        if (interrupt_came())
            *end = "interrupted";
        else if (!going)
            *end = "steps are below a 32nd of the spacing";
        else if (round->number == most)
            *end = "there were as many rounds as --rounds allows";
        if (!err)
            place_light_tell_round(cloud->light, round);
    }
    return err;
}

/* Merges until nothing merges. */
static struct error *merge_all(struct cloud *cloud, const struct place_options *o, double mean,
                               struct place_round *round)
{
    const struct contrast contrast = contrast_make((enum contrast_kind)o->merge.contrast,
                                                   (enum contrast_form)o->merge.form,
                                                   o->light.order, mean);
    const double most = o->merge.merge_contrast_given ? o->merge.merge_contrast : MERGE_CONTRAST;
    struct error *err = NULL;
    bool goes_on = !interrupt_came();
    round->moved = round->back = 0;
    while (!err && goes_on) {
        round->number++;
        err = cloud_merge(cloud, &contrast, o->merge.merge_distance, most, &round->merged);
        round->probes = cloud->count;
        goes_on = round->merged && !interrupt_came();
        if (!err)
            place_light_tell_round(cloud->light, round);
    }
    return err;
}

/* -- the method ------------------------------------------------------------------------------- */

static struct error *tell_columns(struct place *place, const struct cloud *cloud)
{
    struct column *gradient = NULL;
    struct error *err = place_add_column(place, "gradient", COLUMN_F32, 3, NULL);
    if (!err)
        err = place_add_column(place, "steps", COLUMN_I32, 1, NULL);
    if (!err)
        err = place_add_column(place, "back", COLUMN_I32, 1, NULL);
    if (!err)
        err = place_add_column(place, "cluster", COLUMN_I32, 1, NULL);
    gradient = err ? NULL : table_column(&place->columns, "gradient");
    for (size_t i = 0; i < cloud->count && !err; i++) {
        const struct cloud_probe *p = &cloud->probe[i];
        memcpy(column_f32(gradient) + 3 * i, p->gradient, sizeof p->gradient);
        column_i32(table_column(&place->columns, "steps"))[i] = p->steps;
        column_i32(table_column(&place->columns, "back"))[i] = p->back;
        column_i32(table_column(&place->columns, "cluster"))[i] = p->cluster;
    }
    return err;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct place_light light = {0};
    struct cloud cloud = {0};
    struct ascent a = {.cloud = &cloud, .walls = o->step_back == STEP_BACK_WALL};
    struct place_round round = {0};
    const char *end = NULL;
    double mean = 0;
    struct error *err = place_light_open(&light, o, world, RAYS, CAPTURE_INDIRECT);
    if (!err)
        err = cloud_start(&cloud, &light, o);
    if (!err) {
        mean = cloud_mean(&cloud);
        err = part_dark(&a);
    }
    if (!err)
        err = ascend(&a, o->merge.rounds_given ? o->merge.rounds : ROUNDS, &round, &end);
    if (!err)
        err = merge_all(&cloud, o, mean, &round);
    if (!err)
        err = give_dark(&a, o->unlit);
    if (!err)
        err = cloud_give(&cloud, place, place_method_ascent.origin);
    if (!err)
        err = tell_columns(place, &cloud);
    if (!err)
        place_light_tell_end(&light, cloud.count, end);
    world->interrupted = !err && interrupt_came();
    free(a.dark);
    free(a.list);
    free(a.to);
    free(a.sh);
    free(a.noise);
    cloud_clear(&cloud);
    place_light_close(&light);
    return err;
}

static const char *const shared[] = {"spacing",          "count",
                                     "bounds",           "turn",
                                     "clearance",        "ground",
                                     "contrast",         "contrast-form",
                                     "merge-distance",   "merge-contrast",
                                     "rounds",           "unlit",
                                     PLACE_LIGHT_SHARES, NULL};

const struct place_method place_method_ascent = {.name = "ascent",
                                                 .origin = 7,
                                                 .needs_scene = true,
                                                 .sees_light = true,
                                                 .shares = shared,
                                                 .reaches = true,
                                                 .rows = rows,
                                                 .check = check,
                                                 .place = place_by_options};
