/* SPDX-License-Identifier: Apache-2.0 */
/* The method `spawn-merge` of probe-place (P. Sukys, "Light probe cloud generation for games",
 * Chalmers University, 2014, sec. 3.1.1).
 *
 * From a grid, in rounds: probes that are close and alike merge, and probes come between those that
 * are close and differ, until a round changes nothing, there have been as many as allowed, or there
 * are as many probes as allowed. cloud.h has the two steps. The text leaves open when and how often
 * a pair counts: here pairs of the grid's neighbours merge, those up to its diagonals spawn, and no
 * probe comes nearer to another than a share of the spacing.
 */
#include "adapt/cloud.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "place/place_method.h"

#include <math.h>
#include <string.h>

enum { RAYS = 256, ROUNDS = 8 };

/* Contrasts, unless told: of each form of those that are shares. */
static const double MERGE[] = {[CONTRAST_ABSOLUTE] = 0.05, [CONTRAST_RELATIVE] = 0.05},
                    SPAWN[] = {[CONTRAST_ABSOLUTE] = 0.3, [CONTRAST_RELATIVE] = 0.15};

static struct option_row *rows(struct place_options *options, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "contrast",
         .argument = "HOW",
         .kind = OPTION_CHOICE,
         .choices = contrast_kind_names,
         .value = OPTION_ENUM(options->merge.contrast),
         .given = &options->merge.contrast_given,
         .help = "spawn-merge, ascent: how much light differs: rms over all directions,\n"
                 "the most along six or twentysix, or mse of coefficients (unbounded)"},
        {.name = "contrast-form",
         .argument = "FORM",
         .kind = OPTION_CHOICE,
         .choices = contrast_form_names,
         .value = OPTION_ENUM(options->merge.form),
         .given = &options->merge.form_given,
         .help = "spawn-merge, ascent: as a share of all probes' mean, or relative to\n"
                 "the two that are compared"},
        {.name = "merge-distance",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &options->merge.merge_distance,
         .given = &options->merge.merge_distance_given,
         .most = 10,
         .help = "spawn-merge, ascent: how far probes that merge are apart at the most,\n"
                 "in spacings; 0: none does"},
        {.name = "merge-contrast",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &options->merge.merge_contrast,
         .given = &options->merge.merge_contrast_given,
         .least_open = true,
         .most = INFINITY,
         .shown = "0.05",
         .help = "spawn-merge, ascent: below this they merge"},
        {.name = "spawn-distance",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &options->merge.spawn_distance,
         .given = &options->merge.spawn_distance_given,
         .least_open = true,
         .most = 10,
         .help = "spawn-merge: how far probes that get one between them are apart at the\n"
                 "most, in spacings"},
        {.name = "spawn-contrast",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &options->merge.spawn_contrast,
         .given = &options->merge.spawn_contrast_given,
         .least_open = true,
         .most = INFINITY,
         .shown = "0.3 absolute, 0.15 relative",
         .help = "spawn-merge: above this they do"},
        {.name = "rounds",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->merge.rounds,
         .given = &options->merge.rounds_given,
         .least = 1,
         .most = 10000,
         .shown = "8; ascent 16",
         .help = "spawn-merge, ascent: rounds at the most"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

static double merge_contrast(const struct place_options *o)
{
    return o->merge.merge_contrast_given ? o->merge.merge_contrast : MERGE[o->merge.form];
}

static double spawn_contrast(const struct place_options *o)
{
    return o->merge.spawn_contrast_given ? o->merge.spawn_contrast : SPAWN[o->merge.form];
}

static struct error *check(const struct place_options *o, bool scene)
{
    struct error *err = place_method_grid.check(o, scene);
    if (!err && o->merge.contrast == CONTRAST_MSE &&
        !(o->merge.merge_contrast_given && o->merge.spawn_contrast_given))
        err = error_usage("--contrast mse has no bound: expected --merge-contrast and "
                          "--spawn-contrast");
    if (!err && !(merge_contrast(o) < spawn_contrast(o)))
        err = error_usage("expected --merge-contrast below --spawn-contrast, got %g and %g: probes "
                          "would merge and come again for ever",
                          merge_contrast(o), spawn_contrast(o));
    if (!err && o->least_level_given)
        err = error_usage("spawn-merge: expected --levels MAX alone");
    return err;
}

/* Goes rounds; returns why they ended. */
static struct error *go_rounds(struct cloud *cloud, const struct place_options *o, const char **end)
{
    const struct contrast contrast = contrast_make((enum contrast_kind)o->merge.contrast,
                                                   (enum contrast_form)o->merge.form,
                                                   o->light.order, cloud_mean(cloud));
    const int most = o->merge.rounds_given ? o->merge.rounds : ROUNDS;
    struct cloud_spawn spawn = {.distance = o->merge.spawn_distance,
                                .contrast = spawn_contrast(o),
                                .least = exp2(-o->levels[1]) * (1 - 1e-9),
                                .most = cloud->light->world->most};
    struct place_round round = {.probes = cloud->count};
    struct error *err = NULL;
    place_light_tell_round(cloud->light, &round);
    *end = NULL;
    while (!err && !*end) {
        round.number++;
        err = cloud_merge(cloud, &contrast, o->merge.merge_distance, merge_contrast(o),
                          &round.merged);
        round.added = 0;
        if (!err && !interrupt_came())
            err = cloud_spawn(cloud, &contrast, &spawn, &round.added);
        round.probes = cloud->count;
        if (interrupt_came())
            *end = "interrupted";
        else if (spawn.full)
            *end = "there are as many as --max-probes allows";
        else if (!round.merged && !round.added)
            *end = "nothing changed";
        else if (round.number == most)
            *end = "there were as many rounds as --rounds allows";
        if (!err)
            place_light_tell_round(cloud->light, &round);
    }
    return err;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct place_light light = {0};
    struct cloud cloud = {0};
    const char *end = NULL;
    struct error *err = place_light_open(&light, o, world, RAYS, CAPTURE_INDIRECT);
    if (!err)
        err = cloud_start(&cloud, &light, o);
    if (!err)
        err = go_rounds(&cloud, o, &end);
    if (!err)
        err = cloud_give(&cloud, place, place_method_spawn_merge.origin);
    if (!err)
        place_light_tell_end(&light, cloud.count, end);
    world->interrupted = !err && interrupt_came();
    cloud_clear(&cloud);
    place_light_close(&light);
    return err;
}

static const char *const shared[] = {"spacing", "count",  "bounds",           "turn", "clearance",
                                     "ground",  "levels", PLACE_LIGHT_SHARES, NULL};

const struct place_method place_method_spawn_merge = {.name = "spawn-merge",
                                                      .origin = 6,
                                                      .needs_scene = true,
                                                      .sees_light = true,
                                                      .shares = shared,
                                                      .reaches = true,
                                                      .rows = rows,
                                                      .check = check,
                                                      .place = place_by_options};
