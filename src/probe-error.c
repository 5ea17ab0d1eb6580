/* SPDX-License-Identifier: Apache-2.0 */
/* probe-error: how far a baked stream's light is from path-traced truth, where it leaks, and how
 * smoothly it changes. */
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "capture/stage.h"
#include "interpolate/baked.h"
#include "interpolate/interpolate_options.h"
#include "light/blend.h"
#include "measure/assess.h"
#include "scene/scene_told.h"
#include "stream/common_options.h"
#include "stream/sight_key.h"
#include "stream/stream.h"
#include "trace/seen.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct arguments {
    struct assess_job job;
    struct interpolate_options how;
    struct scene_settings given;
    enum interpolate_visible visible;
    enum report_format format;
    double leak_most;
    bool leak_most_given;
    bool any_scene;
    struct common common;
};

static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    struct assess_job *job = &a->job;
    struct truth_settings *t = &job->truth;
    const struct option_row points[] = {
        {.name = "points",
         .letter = 'n',
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &t->points,
         .least = 1,
         .most = 1e7,
         .given = &t->points_given,
         .help = "random points in free space"},
        {.name = "at",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &t->points_file,
         .shown = "random",
         .help = "the points of FILE instead, x y z a line"},
        {.name = "bounds",
         .argument = "X0,Y0,Z0,X1,Y1,Z1",
         .kind = OPTION_REALS,
         .count = 6,
         .value = t->bounds,
         .given = &t->bounds_given,
         .shown = "the scene's",
         .help = "the box that random points and paths are in"},
        {.name = "reach",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &t->reach_file,
         .shown = "anywhere",
         .help = "random points and paths only where a body gets from the start\n"
                 "points in FILE"},
        {.name = "paths",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &t->paths,
         .most = 1e6,
         .given = &t->paths_given,
         .help = "random straight paths along which change is measured"},
        {.name = "path",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &t->path_file,
         .shown = "random",
         .help = "the path through the points of FILE instead"},
        {.name = "step",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &t->step,
         .least_open = true,
         .most = (double)INFINITY,
         .given = &t->step_given,
         .shown = "1/256 of the box's diagonal",
         .help = "the length of a path over which change is taken"},
        {0}};
    const struct option_row truth[] = {
        {.name = "truth",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &job->truth_file,
         .shown = "none",
         .unrecorded = true,
         .help = "keep the traced light in FILE; where it is there, use it"},
        {.name = "truth-rays",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &t->rays,
         .least = 2,
         .most = CAPTURE_RAYS_MOST,
         .given = &t->rays_given,
         .help = "rays a point"},
        {.name = "truth-error",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &t->error,
         .least_open = true,
         .most = 1,
         .given = &t->error_given,
         .shown = "none",
         .help = "more of them until the standard error of irradiance is below\nthis share of it"},
        {.name = "truth-max-rays",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &t->rays_most,
         .least = 2,
         .most = CAPTURE_RAYS_MOST,
         .help = "rays a point that --truth-error may spend"},
        {.name = "truth-cache",
         .argument = "auto|FILE",
         .kind = OPTION_TEXT,
         .value = &t->cache.name,
         .shown = "off",
         .help = "a preview in place of the truth: paths end in a cache of the\n"
                 "surfaces' indirect light, which is made, or read from FILE"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &t->bounces,
         .most = CAPTURE_BOUNCES_MOST,
         .shown = "the stream's",
         .help = "how often light may scatter on its way"},
        {.name = "any-scene",
         .kind = OPTION_FLAG,
         .value = &a->any_scene,
         .help = "the stream may have been captured in another scene than SCENE,\n"
                 "which is the true one"},
        {0}};
    const struct option_row visible[] = {interpolate_visible_row(&a->visible), {0}};
    const struct option_row figures[] = {
        {.name = "bad",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &job->measure.bad,
         .most = 1,
         .help = "points with an error above this are bad"},
        {.name = "tolerance",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &job->measure.tolerance,
         .most = 1e6,
         .help = "too bright or dark is what is off by more than this share of\n"
                 "the mean irradiance"},
        {.name = "dark",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &job->measure.dark,
         .most = 1e6,
         .help = "points with less than this share of the mean irradiance are\ndark"},
        {.name = "leak-samples",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &job->leak_samples,
         .most = 65536,
         .help = "points in each cell that look for their probes; 0: none"},
        {.name = "max-leak",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = options_share,
         .value = &a->leak_most,
         .given = &a->leak_most_given,
         .shown = "none",
         .unrecorded = true,
         .help = "exit with status 3 where more of the light may leak"},
        {.name = "map",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &job->map_file,
         .written = true,
         .shown = "none",
         .unrecorded = true,
         .help = "write the points with the error at each to FILE, as a probe\nstream"},
        {.name = "tsv",
         .kind = OPTION_SET,
         .count = REPORT_TSV,
         .value = OPTION_ENUM(a->format),
         .unrecorded = true,
         .help = "print a line for each figure: measure, of what, value, and the\n"
                 "ends of its interval"},
        {.name = "json",
         .kind = OPTION_SET,
         .count = REPORT_JSON,
         .value = OPTION_ENUM(a->format),
         .unrecorded = true,
         .help = "the same as JSON"},
        {0}};
    struct option_row body[REACH_OPTION_ROWS] = {{0}};
    reach_option_rows(&t->reach, body);
    option_row(body, "radius")->name = "body-radius"; /* --radius is shepard's */
    struct option_row how[INTERPOLATE_OPTIONS_ROWS], of_file[SCENE_FILE_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        points,
        body,
        truth,
        interpolate_options_rows(&a->how, how),
        visible,
        figures,
        scene_file_rows(&a->given, of_file),
        common_rows(&a->common, COMMON_STREAM | COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS,
                    shared),
        NULL};
    struct option_row *output = option_row(shared, "output");
    output->shown = "none";
    output->help = "write the stream, its cells with columns leak, leak_light\n"
                   "and leak_free, to FILE; - is standard output";
    option_row(shared, "seed")->given = &t->seed_given;
    struct error *err = options_parse(program, groups, argc, argv);
    t->seed = a->common.seed;
    job->measure.seed = (uint64_t)a->common.seed;
    job->measure.threads = a->common.threads;
    for (int k = 0; k < 3 && !err && t->bounds_given; k++)
        if (!(t->bounds[k] <= t->bounds[3 + k]))
            err = error_usage("--bounds: expected X0,Y0,Z0 below X1,Y1,Z1, got %g above %g",
                              t->bounds[k], t->bounds[3 + k]);
    if (!err && t->points_file && t->points_given)
        err = error_usage("--points and --at exclude each other");
    const char *given = reach_option_given(&t->reach);
    if (!err && given && !t->reach_file)
        err = error_usage("%s goes with --reach", t->reach.radius_given ? "--body-radius" : given);
    if (!err)
        err = reach_check_given(&t->reach);
    if (!err && t->reach_file)
        err = file_check_again(t->reach_file, "--reach");
    if (!err && t->path_file && t->paths_given)
        err = error_usage("--paths and --path exclude each other");
    if (!err && job->leak_samples == 1)
        err = error_usage("--leak-samples: expected 0 or at least 2, got 1");
    if (!err && a->common.output && !job->leak_samples)
        err = error_usage("--output needs --leak-samples");
    if (!err && a->leak_most_given && !job->leak_samples)
        err = error_usage("--max-leak needs --leak-samples");
    if (!err)
        err = job->truth.cache.name && !*job->truth.cache.name
                  ? error_usage("--truth-cache: expected auto, a file's name or off, got ''")
                  : cache_options_check(&job->truth.cache);
    return err ? err : interpolate_options_check(&a->how);
}

/* Standard input can be read once. */
static struct error *check_inputs(const struct arguments *a, const char *input)
{
    const struct truth_settings *truth = &a->job.truth;
    const char *const from[] = {input, truth->points_file, truth->path_file};
    int standard = 0;
    for (int i = 0; i < 3; i++)
        standard += from[i] && !strcmp(from[i], "-");
    if (standard > 1)
        return error_usage("only one of the stream, --at and --path can come from standard input");
    /* it is written, where it is not there to be read */
    const char *file = a->job.truth_file;
    struct error *err = file && access(file, F_OK) ? claim_output(file, "truth") : NULL;
    return err ? err : claim_output("-", NULL); /* the report, or the stream */
}

/* What leaks is known of cells alone: there is free space in them to take points of. */
static struct error *check_cells(const struct arguments *a, const struct baked *baked,
                                 struct warnings *warnings)
{
    const char *why = baked->mesh.corners ? "the cell is a point" : "there are no cells";
    if (baked->mesh.corners > 1 || !a->job.leak_samples)
        return NULL;
    if (a->common.output || a->leak_most_given)
        return error_new("%s is of what leaks in cells: %s",
                         a->common.output ? "--output" : "--max-leak", why);
    warnings_add(warnings, "leaks",
                 "leaks are measured of cells, and %s: the report has no figures of them", why);
    return NULL;
}

static struct error *open_baked(struct baked *baked, const struct stream *stream,
                                const struct arguments *a, const char *input,
                                struct warnings *warnings)
{
    struct interpolate_settings settings = interpolate_options_settings(&a->how, "sh");
    settings.outside |= interpolate_visible_flags(a->visible) | PROBE_LEAN;
    struct error *err = baked_open(baked, stream, &settings);
    if (!err)
        err = check_cells(a, baked, warnings);
    return error_wrap(err, "%s", file_input_name(input));
}

static void say_times(const char *program, const struct assessment *result)
{
    fprintf(stderr, "%s: truth %.2f s, error %.2f s, leaks %.2f s\n", program,
            result->truth_seconds, result->error_seconds, result->leak_seconds);
}

/* Marks the cells and writes the stream. */
static struct error *write_marked(struct stream *stream, const struct assessment *result,
                                  const struct common *common, const char *recorded)
{
    struct error *err = assess_mark(result, stream);
    if (!err)
        err = header_add_provenance(&stream->header, recorded);
    return err ? err : stream_write(stream, common->output, common->encoding);
}

int main(int argc, char **argv)
{
    struct arguments a = {.job = {.truth = truth_settings_default(),
                                  .measure = {.tolerance = 0.05, .dark = 0.25, .bad = 0.25},
                                  .leak_samples = 8},
                          .given = scene_settings_default(),
                          .common = common_default()};
    a.common.output = NULL;
    struct program program = {.name = "probe-error",
                              .usage = "[OPTION]... SCENE [STREAM]",
                              .summary = "Measures the light of the baked STREAM (standard input) "
                                         "against light that is path traced\n"
                                         "in SCENE at points between the probes: its error, how "
                                         "much of it comes through walls, and\n"
                                         "how it changes along paths.",
                              .operands_least = 1,
                              .operands_most = 2};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct stage stage = {0};
    struct baked baked = {0};
    struct seen *seen = NULL;
    struct assessment result = {0};
    struct error *err = parse(&program, &a, argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "the scene", input, "the probes");
    if (!err)
        err = check_inputs(&a, input);
    claim_in_place(input);
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = sight_drop_stale(stream, &warnings);
    if (!err)
        err = open_baked(&baked, stream, &a, input, &warnings);
    if (!err)
        err = stage_init(&stage, program.operands[0], &stream->header, &a.given, &warnings);
    if (!err)
        relit_key(&stream->header, a.job.truth.cache.relit);
    if (!err)
        err = scene_told_in(&warnings, &stream->header, a.common.quiet);
    if (!err && stage.other && !a.any_scene)
        err = error_new("%s: this is not the scene that the probes were captured in (its key is "
                        "%s, theirs %s); "
                        "--any-scene measures all the same",
                        program.operands[0], stage.key, stage.captured_key);
    if (!err && stage.other_sky && !stage.other && !a.any_scene)
        err = error_new("%s: this is not the sky that the probes were captured under; --any-scene "
                        "measures all the same",
                        stage.scene->sky.file);
    if (!err)
        sight_warn_other_scene(stream, scene_surface_key(stage.scene), program.operands[0],
                               &warnings);
    if (!err && a.visible == INTERPOLATE_VISIBLE_RAYS)
        err = seen_join(&seen, stage.tracer, baked.probe_count, baked.in);
    const char *blend = err ? NULL : header_key(&stream->header, BLEND_KEY);
    if (blend)
        warnings_add(&warnings, "blend",
                     "the light is a blend of two bakes (key " BLEND_KEY " %s), of which the truth "
                     "is that of the first one's scene: expected a scene as it is between",
                     blend);
    if (!err && !stage.captured)
        warnings_add(&warnings, "settings",
                     "the stream does not say how it was captured: all light, %d bounces, "
                     "and the scene's own lights are taken",
                     stage.capture_settings.bounces);
    if (!err) {
        a.job.stage = &stage;
        a.job.baked = &baked;
        a.job.map_encoding = a.common.encoding;
        a.job.command_line = program.recorded;
        a.job.program = program.name;
        a.job.progress = a.common.progress && !a.common.quiet;
        a.job.warnings = &warnings;
        err = assess(&result, &a.job);
    }
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err && !a.common.quiet)
        say_times(program.name, &result);
    /* then the report gives way */
    const bool to_stdout = a.common.output && !strcmp(a.common.output, "-");
    if (!err && a.common.output)
        err = write_marked(stream, &result, &a.common, program.recorded);
    if (!err)
        err = report_print(&result.report, a.format, to_stdout ? stderr : stdout);
    if (!err && a.leak_most_given)
        err = unseen_gate(&result.report, a.leak_most);
    assessment_clear(&result);
    baked_close(&baked);
    seen_destroy(seen);
    stage_clear(&stage);
    scene_settings_clear(&a.given);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
