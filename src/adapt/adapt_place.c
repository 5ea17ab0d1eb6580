/* SPDX-License-Identifier: Apache-2.0 */
/* The method `adaptive` of probe-place: its options, and adapt.h. */
#include "adapt/adapt.h"
#include "adapt/place_light.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "place/place_method.h"
#include "place/reach.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 512 }; /* that a probe will be captured with, unless told otherwise */

/* -- options ---------------------------------------------------------------------------------- */

/* A share that is neither none nor all. */
static struct error *parse_share(void *value, const char *text)
{
    const double *share = value;
    struct error *err = options_share(value, text);
    return err || (*share > 0 && *share < 1)
               ? err
               : error_usage("expected a share between 0 and 1, got '%s'", text);
}

static struct option_row *rows(struct place_options *options, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "max-error",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = parse_share,
         .value = &options->adaptive.error,
         .given = &options->adaptive.error_given,
         .shown = "none",
         .help = "adaptive: as few probes as make the error that a player sees\n"
                 "at most this (10% or 0.1) at points that took no part"},
        {.name = "probes",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &options->adaptive.probes,
         .given = &options->adaptive.probes_given,
         .least = 4,
         .most = INT32_MAX,
         .shown = "no limit",
         .help = "adaptive: at most N probes, those of --keep too"},
        {.name = "bytes",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &options->adaptive.bytes,
         .given = &options->adaptive.bytes_given,
         .least = 1,
         .most = 1LL << 52,
         .shown = "no limit",
         .help = "adaptive: at most N bytes of probe-query --pack float"},
        {.name = "gain",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = parse_share,
         .value = &options->adaptive.gain,
         .given = &options->adaptive.gain_given,
         .shown = "none",
         .help = "adaptive: stop where twice the probes took less than this share\n"
                 "off the error"},
        {.name = "noise",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = options_share,
         .value = &options->adaptive.noise,
         .given = &options->adaptive.noise_given,
         .help = "adaptive: spend rays on a probe until the standard error of its\n"
                 "light is below this share of the error that remains; 0: --rays\n"
                 "alone (default: 30%)"},
        {.name = "curve",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &options->adaptive.curve,
         .given = &options->adaptive.curve_given,
         .written = true,
         .shown = "none",
         .unrecorded = true,
         .help = "adaptive: write probes, bytes, errors and seconds of each round\n"
                 "to FILE"}};
    memcpy(row, all, sizeof all);
    return place_light_rows(options, row + sizeof all / sizeof *all);
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    if (!o->adaptive.error_given && !o->adaptive.probes_given && !o->adaptive.bytes_given &&
        !o->adaptive.gain_given)
        return error_usage("adaptive: expected --max-error, --probes, --bytes or --gain");
    if (o->adaptive.curve && !strcmp(o->adaptive.curve, "-"))
        return error_usage("--curve: expected the name of a file, got '-': standard output is for "
                           "the probes");
    return NULL;
}

/* The light of the probes, as probe-capture with these settings would write it. */
static struct error *give_light(struct place *place, const struct adapt_result *result,
                                const struct adapt_job *job)
{
    static const char *const names[] = {"sh", "sh_error", "validity", "depth", "sky"};
    const struct capture_settings *settings = &result->settings;
    const size_t width = candidates_capture_width(&job->candidates);
    struct error *err = table_init(&place->columns, "probe");
    if (!err)
        err = table_resize(&place->columns, result->count);
    if (!err)
        err = capture_add_columns(settings, &place->columns);
    const float *from = result->light;
    for (size_t n = 0; n < sizeof names / sizeof *names && !err; n++) {
        struct column *c = table_column(&place->columns, names[n]);
        for (size_t i = 0; i < result->count; i++)
            memcpy(column_f32(c) + c->width * i, from + width * i, c->width * sizeof *from);
        from += c->width;
    }
    return err ? err : capture_settings_to_header(settings, &place->header);
}

/* -- what is told ----------------------------------------------------------------------------- */

static struct error *write_curve(const struct adapt_result *result, struct file_output *out)
{
    char line[256];
    static const char head[] =
        "probes\tbytes\terror\theld_out\theld_out_low\theld_out_high\tseconds\n";
    struct error *err = file_output_write(out, head, sizeof head - 1);
    for (size_t i = 0; i < result->rows && !err; i++) {
        const struct adapt_row *row = &result->row[i];
        const int length = snprintf(line, sizeof line, "%zu\t%zu\t%.6g\t%.6g\t%.6g\t%.6g\t%.3f\n",
                                    row->probes, row->bytes, row->space, row->judges,
                                    row->judges - 1.96 * row->doubt,
                                    row->judges + 1.96 * row->doubt, row->seconds);
        err = file_output_write(out, line, (size_t)length);
    }
    return err;
}

static void tell_end(const struct adapt_result *result, const struct adapt_limits *limits,
                     const struct place_world *world)
{
    static const char *const ends[] = {[ADAPT_ERROR] = "the error is as asked for",
                                       [ADAPT_PROBES] = "there are as many as --probes allows",
                                       [ADAPT_BYTES] = "there are as many as --bytes allows",
                                       [ADAPT_GAIN] = "twice the probes gained less than --gain",
                                       [ADAPT_MOST] = "there are as many as --max-probes allows",
                                       [ADAPT_FLAT] = "the error is flat, no other probe lowers it",
                                       [ADAPT_INTERRUPT] = "interrupted"};
    const struct adapt_row *last = result->rows ? &result->row[result->rows - 1] : NULL;
    char least[96] = ""; /* the highest orders are held against themselves: nothing is known */
    if (result->least > 0)
        snprintf(least, sizeof least, "; SH of order %d leave %.2f %% of error wherever probes are",
                 result->settings.order, 100 * result->least);
    if (last && limits->error > 0 && result->end != ADAPT_ERROR && result->end != ADAPT_INTERRUPT)
        warnings_add(
            world->warnings, "max-error",
            "the error is %.2f %% at the upper end of its interval, not %.2f %% or less: the "
            "best of %zu probes (%s)%s",
            100 * (last->judges + 1.96 * last->doubt), 100 * limits->error, result->count,
            ends[result->end], least);
    if (world->program)
        fprintf(stderr, "%s: %zu probes of %zu points, %.0f rays each%s: %s\n", world->program,
                result->count, result->candidates, result->rays, least, ends[result->end]);
}

/* -- the method ------------------------------------------------------------------------------- */

/* Places, and writes the curve to an open file, unless NULL. */
static struct error *place_with_curve(struct place *place, const struct place_options *o,
                                      struct place_world *world, struct file_output *curve)
{
    struct place_light light = {0};
    struct adapt_result result = {0};
    struct reach *reach = NULL;
    struct error *err = place_light_open(&light, o, world, RAYS, CAPTURE_ALL);
    light.settings.columns = capture_settings_default().columns; /* as it will be captured */
    if (!err)
        err = place_reach_open(&reach, o, light.tracer, world);
    struct adapt_job job = {.candidates = {.path = &light.path,
                                           .settings = &light.settings,
                                           .by_noise = o->adaptive.noise > 0,
                                           .threads = world->inside.threads,
                                           .inside_rays = world->inside.rays,
                                           .backface_share = world->inside.backface_share,
                                           .warnings = world->warnings},
                            .limits = {.error = o->adaptive.error,
                                       .gain = o->adaptive.gain,
                                       .probes = (size_t)o->adaptive.probes,
                                       .bytes = (size_t)o->adaptive.bytes},
                            .noise = o->adaptive.noise,
                            .probes_most = (size_t)world->most,
                            .program = world->program,
                            .progress = world->progress,
                            .given = light.kept_count,
                            .position = light.kept};
    place_options_space(o, world, reach, &job.candidates.space);
    if (!err)
        err = adapt(&result, &job);
    if (!err)
        err = place_light_give(&light, place, result.count - light.kept_count,
                               result.position + 3 * light.kept_count,
                               place_method_adaptive.origin);
    if (!err)
        err = give_light(place, &result, &job);
    if (!err)
        tell_end(&result, &job.limits, world);
    if (!err && curve)
        err = write_curve(&result, curve);
    world->interrupted = !err && result.end == ADAPT_INTERRUPT;
    adapt_clear(&result);
    reach_destroy(reach);
    place_light_close(&light);
    return err;
}

/* That the curve can be written is found out before there is one. */
static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct file_output curve;
    if (!o->adaptive.curve)
        return place_with_curve(place, o, world, NULL);
    struct error *err = file_output_open(&curve, o->adaptive.curve, false);
    if (err)
        return err;
    err = place_with_curve(place, o, world, &curve);
    if (!err)
        return file_output_finish(&curve);
    file_output_abandon(&curve);
    return err;
}

static const char *const shared[] = {"bounds", "turn", NULL};

const struct place_method place_method_adaptive = {.name = "adaptive",
                                                   .origin = 5,
                                                   .needs_scene = true,
                                                   .sees_light = true,
                                                   .shares = shared,
                                                   .reaches = true,
                                                   .rows = rows,
                                                   .check = check,
                                                   .place = place_by_options};
