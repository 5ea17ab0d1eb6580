/* SPDX-License-Identifier: Apache-2.0 */
/* probe-bake: bakes a scene through the whole pipe, and reports how good it became. */
#include "bake/pipe.h"
#include "bake/run.h"
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "capture/cache_options.h"
#include "capture/capture.h"
#include "libprobe-query/sh.h"
#include "light/light_options.h"
#include "place/reach.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"

#include <math.h>
#include <string.h>

struct arguments {
    int quality; /* plan_quality */
    double max_error;
    const char *report, *pack;
    bool dry_run, max_error_given, bounds_given;
    /* read by other programs: here they are checked */
    int64_t probes, bytes;
    int order, rays, bounces, light;
    const char *groups, *transfer;
    double bounds[6];
    const char *reach;
    struct reach_settings body;
    struct dering_settings dering;
    struct cache_options cache;
    struct scene_settings scene;
    struct common common;
};

static struct error *check_cache(const struct arguments *a)
{
    struct cache_options cache = a->cache;
    struct error *err = cache_options_check(&cache);
    if (!err)
        err = cache_options_check_renew(&cache);
    if (!err && cache.name && (a->groups || a->transfer))
        err =
            error_usage("--cache: expected no %s beside it: a cache keeps the light of all lights "
                        "in one",
                        a->groups ? "--groups" : "--transfer");
    if (err || !cache.name || !strcmp(cache.name, "auto"))
        return err;
    err = file_check_again(cache.name, "--cache");
    return err ? err : claim_input_of(cache.name);
}

static struct error *check(const struct arguments *a, const struct program *program)
{
    struct error *err = file_check_again(program->operands[0], "SCENE");
    if (!err && a->reach)
        err = file_check_again(a->reach, "--reach");
    if (!err && a->scene.sky_file)
        err = file_check_again(a->scene.sky_file, "--sky");
    if (err)
        return err;
    if (a->report && !*a->report)
        return error_usage("--report: expected a folder's name, or none, got ''");
    if (a->pack && !strcmp(a->pack, "-"))
        return error_usage("--pack: expected a file's name, got '-'");
    const char *of_body = reach_option_given(&a->body);
    if (of_body && !a->reach)
        return error_usage("%s goes with --reach", of_body);
    err = reach_check_given(&a->body);
    if (!err)
        err = check_cache(a);
    if (!err && a->reach)
        err = claim_input_of(a->reach);
    if (!err)
        err = claim_output("-", NULL); /* the report */
    if (err)
        return err;
    if (a->max_error_given && !(a->max_error > 0 && a->max_error < 1))
        return error_usage("--max-error: expected a share between 0 and 1, got %g", a->max_error);
    return light_dering_check(&a->dering);
}

int main(int argc, char **argv)
{
    struct arguments a = {.quality = PLAN_GOOD,
                          .body = reach_default(),
                          .cache = cache_options_default(),
                          .scene = scene_settings_default(),
                          .common = common_default()};
    const struct option_row rows[] = {
        {.name = "quality",
         .argument = "LEVEL",
         .kind = OPTION_CHOICE,
         .choices = plan_quality_names,
         .value = OPTION_ENUM(a.quality),
         .help = "draft: in seconds; good: in a minute; best: in ten"},
        {.name = "max-error",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = options_share,
         .value = &a.max_error,
         .given = &a.max_error_given,
         .shown = "none",
         .help = "as few probes as make the error that a player sees at most this\n"
                 "(10% or 0.1)"},
        {.name = "probes",
         .letter = 'n',
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &a.probes,
         .least = 4,
         .most = INT32_MAX,
         .shown = "by --quality",
         .help = "at most N probes"},
        {.name = "bytes",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &a.bytes,
         .least = 1,
         .most = 1LL << 52,
         .shown = "no limit",
         .help = "as many probes as take at most N bytes, packed"},
        {.name = "bounds",
         .argument = "X0,Y0,Z0,X1,Y1,Z1",
         .kind = OPTION_REALS,
         .count = 6,
         .value = a.bounds,
         .given = &a.bounds_given,
         .shown = "the scene's",
         .help = "the box that probes are for, in units of the scene"},
        {.name = "reach",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a.reach,
         .shown = "anywhere",
         .help = "only where a body gets from the start points in FILE, x y z a line"},
        {.name = "light",
         .argument = "WHICH",
         .kind = OPTION_CHOICE,
         .choices = capture_light_names,
         .value = OPTION_ENUM(a.light),
         .help = "all light, direct or indirect alone"},
        {.name = "rays",
         .letter = 'r',
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a.rays,
         .least = 16,
         .most = CAPTURE_RAYS_MOST,
         .shown = "by --quality",
         .help = "rays a probe"},
        {.name = "order",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a.order,
         .least = 1,
         .most = SH_ORDER_MAX,
         .shown = "by --quality",
         .help = "SH order: N * N coefficients a colour"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a.bounces,
         .most = CAPTURE_BOUNCES_MOST,
         .shown = "64",
         .help = "how often light may scatter on its way"},
        {.name = "groups",
         .argument = "FILE|each",
         .kind = OPTION_TEXT,
         .value = &a.groups,
         .shown = "off",
         .help = "light of each group of lights in columns of its own, as\n"
                 "probe-capture makes them"},
        {.name = "transfer",
         .argument = "sky:N|suns:FILE",
         .kind = OPTION_TEXT,
         .value = &a.transfer,
         .shown = "off",
         .help = "and the response to any sky, or to suns; may repeat"},
        {.name = "pack",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a.pack,
         .written = true,
         .shown = "none",
         .help = "write a packed file for libprobe-query besides"},
        {.name = "report",
         .argument = "DIR",
         .kind = OPTION_TEXT,
         .value = &a.report,
         .shown = "OUT.report",
         .help = "put report.txt, light.png and probes.png into this folder; none:\n"
                 "measure nothing"},
        {.name = "dry-run",
         .kind = OPTION_FLAG,
         .value = &a.dry_run,
         .help = "print the pipe to standard output, and run nothing"},
        {0}};
    struct option_row body[REACH_OPTION_ROWS] = {{0}};
    reach_option_rows(&a.body, body);
    struct option_row dering[LIGHT_DERING_ROWS], cache[CACHE_OPTION_ROWS],
        of_scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows,
        body,
        light_dering_rows(&a.dering, dering),
        cache_option_rows(&a.cache, cache),
        scene_settings_rows(&a.scene, of_scene),
        common_rows(&a.common, COMMON_STREAM | COMMON_SEED | COMMON_THREADS | COMMON_PROGRESS,
                    shared),
        NULL};
    struct program program = {
        .name = "probe-bake",
        .usage = "[OPTION]... SCENE",
        .summary = "Bakes SCENE: runs the pipe of probe-place, probe-capture, probe-tet and "
                   "probe-leakfix\n"
                   "with settings that are good for most scenes, and reports how good the bake is. "
                   "Prints\n"
                   "the pipe to standard error, and the report to standard output.",
        .operands_least = 1,
        .operands_most = 1};
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = check(&a, &program);
    const struct bake_job job = {.program = program.name,
                                 .quality = (enum plan_quality)a.quality,
                                 .given = program.given,
                                 .given_count = program.given_count,
                                 .settings = &a.scene,
                                 .scene = err ? NULL : program.operands[0],
                                 .output = a.common.output,
                                 .pack = a.pack,
                                 .report = a.report,
                                 .most_error = a.max_error,
                                 .bounds_given = a.bounds_given,
                                 .text = a.common.encoding == STREAM_TEXT,
                                 .quiet = a.common.quiet};
    if (!err)
        err = a.dry_run ? bake_show(&job) : bake_run(&job);
    scene_settings_clear(&a.scene);
    program_clear(&program);
    const int status = error_exit(program.name, err);
    if (pipe_interrupted())
        pipe_pass_on();
    return status;
}
