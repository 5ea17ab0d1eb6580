/* SPDX-License-Identifier: Apache-2.0 */
/* probe-bake: bakes a scene through the whole pipe, and reports how good it became. */
#include "bake/facts.h"
#include "bake/figures.h"
#include "bake/page.h"
#include "bake/pipe.h"
#include "bake/paths.h"
#include "bake/plan.h"
#include "base/claim.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "capture/capture.h"
#include "libprobe-query/sh.h"
#include "light/light_options.h"
#include "place/reach.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct arguments {
    int quality; /* plan_quality */
    double max_error;
    const char *report, *pack;
    bool dry_run, max_error_given, bounds_given;
    /* read by other programs: here they are checked */
    int64_t probes, bytes;
    int order, rays, bounces, light;
    double bounds[6];
    const char *reach;
    struct reach_settings body;
    struct dering_settings dering;
    struct scene_settings scene;
    struct common common;
};

/* -- the work --------------------------------------------------------------------------------- */

static struct error *copy_into(struct file_output *out, const char *path)
{
    struct file_input in;
    struct error *err = file_input_open(&in, path);
    if (err)
        return err;
    while (!err && !in.ended) {
        const unsigned char *bytes;
        size_t got;
        err = file_input_peek(&in, FILE_BLOCK_BYTES, &bytes, &got);
        if (!err)
            err = file_output_write(out, bytes, got);
        file_input_consume(&in, got);
    }
    file_input_close(&in);
    return err;
}

/* A run: what it does, what is shown of it, and what came out. */
struct run {
    const struct arguments *arguments;
    struct plan_job job; /* with our own temporary files */
    struct plan_job shown;
    struct bake_paths paths;
    struct page page;
    char exposure[32]; /* of the first picture, for the second */
};

/* Runs stages first .. end-1 side by side, and reads the figures that they print. */
static struct error *run_stages(struct run *run, int first, int end, struct report *figures)
{
    struct pipe_stage stages[PLAN_ALL] = {0};
    struct error *err = NULL;
    for (int i = first; i < end && !err; i++)
        err = plan_stage(&run->job, (enum plan_stage)i, &stages[i]);
    if (!err)
        err = pipe_run(&stages[first], (size_t)(end - first), run->paths.figures);
    for (int i = first; i < end; i++)
        run->page.seconds[i] = stages[i].seconds;
    if (!err && figures)
        err = figures_read(figures, run->paths.figures);
    pipe_clear(stages, PLAN_ALL);
    return err;
}

/* A day that does not get in is no bake. */
static struct error *check_light(struct run *run)
{
    struct bake_facts *facts = &run->page.of_bake;
    struct error *err = bake_facts_of(run->paths.baked, facts);
    if (!err && run->job.day && facts->black == facts->probes)
        err = error_new("%s: no light of the day gets into the scene: --point X,Y,Z,R,G,B puts one "
                        "within",
                        run->job.scene);
    return err;
}

/* Bakes into the output, which is there when this comes back without an error. */
static struct error *bake(struct run *run, struct file_output *out)
{
    struct error *err = run_stages(run, 0, PLAN_STAGES, NULL);
    if (!err)
        err = check_light(run);
    if (!err)
        err = copy_into(out, run->paths.baked);
    if (!err)
        return file_output_finish(out);
    file_output_abandon(out);
    return err;
}

/* Both pictures, the second as bright as the first. */
static struct error *take_pictures(struct run *run)
{
    struct error *err = run_stages(run, PLAN_PAIR, PLAN_PAIR + 1, &run->page.pictures);
    const double factor = report_get(&run->page.pictures, "exposure", "").value;
    snprintf(run->exposure, sizeof run->exposure, "%.6g", factor);
    if (factor > 0)
        run->job.exposure = run->shown.exposure = run->exposure;
    if (!err)
        err = run_stages(run, PLAN_PROBES, PLAN_PROBES + 1, NULL);
    return err;
}

static struct error *measure(struct run *run)
{
    struct page *page = &run->page;
    struct error *err = run_stages(run, PLAN_PACK, PLAN_PACK + 1, NULL);
    if (!err)
        err = file_bytes(run->job.packed, &page->packed_bytes);
    if (!err)
        err = run_stages(run, PLAN_ERROR, PLAN_ERROR + 1, &page->error);
    if (!err && run->job.pair)
        err = take_pictures(run);
    return err;
}

/* Prints the report to `out`, and to a file where there is one. */
static struct error *tell(const struct page *page, const char *file, FILE *out)
{
    char *text = NULL;
    size_t size = 0;
    struct file_output report;
    FILE *page_out = open_memstream(&text, &size);
    struct error *err = page_out ? page_write(page, page_out) : error_memory();
    if (page_out && fclose(page_out) && !err)
        err = error_memory();
    if (!err && file) {
        err = file_output_open(&report, file, false);
        if (!err)
            err = file_output_write(&report, text, size);
        if (!err)
            err = file_output_finish(&report);
        else
            file_output_abandon(&report);
    }
    /* on standard error it is a message, which may have nobody to hear it */
    if (!err && (fwrite(text, 1, size, out) < size || fflush(out)) && out == stdout)
        err = error_system(errno, "stdout");
    free(text);
    return err;
}

/* What the command line says of the light; NULL: nothing. */
static const char *light_given(const struct program *program)
{
    static const char *const names[] = {"sky", "sun", "point", "spot"};
    for (size_t i = 0; i < program->given_count; i++)
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            if (!strcmp(program->given[i].row->name, names[k]))
                return names[k];
    return NULL;
}

/* Whether there is next to no room between two sides, as on a ground. */
static bool is_flat(const double low[3], const double high[3])
{
    double least = (double)INFINITY, most = 0;
    for (int k = 0; k < 3; k++) {
        least = fmin(least, high[k] - low[k]);
        most = fmax(most, high[k] - low[k]);
    }
    return least < 0.01 * most;
}

/* Reads the scene, and says whether it is to have a day. */
static struct error *look_at_scene(struct run *run, const struct program *program)
{
    const struct arguments *a = run->arguments;
    const char *light = light_given(program), *scene = run->job.scene;
    struct scene_facts *facts = &run->page.of_scene;
    struct error *err = scene_facts_of(scene, &a->scene, facts);
    run->job.flat = !err && !a->bounds_given && is_flat(facts->low, facts->high);
    if (err || !facts->dark)
        return err;
    if (light)
        return error_new("%s: there is no light in the scene, and none of --%s: all would be black",
                         scene, light);
    run->job.day = true;
    facts->sky = true;
    facts->suns = 1;
    if (!a->common.quiet)
        fprintf(stderr,
                "%s: warning: %s: there is no light in the scene: it is baked by day, --sky %s "
                "--sun %s (give --sky, --sun, --point or --spot for a light of your own)\n",
                program->name, scene, PLAN_DAY_SKY, PLAN_DAY_SUN);
    return NULL;
}

/* Better now than after the bake. */
static struct error *can_write(const char *path)
{
    struct file_output out;
    struct error *err = file_output_open(&out, path, true);
    if (!err)
        file_output_abandon(&out);
    return err;
}

/* Names the files of the run, and those that are shown. */
static void name_files(struct run *run, bool readable)
{
    const struct arguments *a = run->arguments;
    struct plan_job *job = &run->job;
    job->pair = run->paths.pair;
    job->probes = run->paths.probes;
    job->output = run->paths.baked;
    job->baked = readable ? a->common.output : run->paths.baked;
    job->packed = a->pack ? a->pack : run->paths.packed;
    run->shown = *job;
    run->shown.shown = true;
    run->shown.output = a->common.output;
}

static struct error *bake_and_tell(struct run *run)
{
    const double began = clock_seconds();
    const struct arguments *a = run->arguments;
    struct page *page = &run->page;
    struct file_output out;
    struct error *err = file_output_open(&out, a->common.output, a->common.encoding != STREAM_TEXT);
    if (err)
        return err;
    page->again = out.target;
    err = a->pack ? can_write(a->pack) : NULL;
    if (!err)
        err = bake_paths_report(&run->paths, a->report, out.target ? a->common.output : NULL);
    /* none is wanted; nor where the stream goes into a pipe and nothing is to be said */
    const bool silent = a->report ? !run->paths.report : !page->again && a->common.quiet;
    pipe_catch();
    if (!err)
        err = bake_paths_make(&run->paths);
    name_files(run, page->again);
    if (!err && !a->common.quiet)
        err = page_pipe(&run->shown, "", stderr);
    if (err) {
        file_output_abandon(&out);
        return err;
    }
    err = bake(run, &out);
    page->bake_time = clock_seconds() - began;
    if (!err && silent)
        return a->pack ? run_stages(run, PLAN_PACK, PLAN_PACK + 1, NULL) : NULL;
    if (!err)
        err = error_wrap(measure(run), "%s is whole, its report is not",
                         file_output_name(a->common.output));
    page->all_time = clock_seconds() - began;
    return err ? err : tell(page, run->paths.text, strcmp(a->common.output, "-") ? stdout : stderr);
}

static struct error *dry_run(struct run *run)
{
    name_files(run, true);
    struct error *err = page_pipe(&run->shown, "", stdout);
    if (!err && (fflush(stdout) || ferror(stdout)))
        err = error_system(errno, "stdout");
    return err;
}

static struct error *check(const struct arguments *a, const struct program *program)
{
    if (!strcmp(program->operands[0], "-"))
        return error_usage("SCENE cannot be standard input: several programs read it");
    if (a->pack && !strcmp(a->pack, "-"))
        return error_usage("--pack: expected a file's name, got '-'");
    const char *of_body = reach_option_given(&a->body);
    if (of_body && !a->reach)
        return error_usage("%s goes with --reach", of_body);
    if (a->reach && !strcmp(a->reach, "-"))
        return error_usage("--reach: expected a file, which several programs read, got '-'");
    struct error *err = reach_check_given(&a->body);
    if (!err && a->reach)
        err = claim_input_of(a->reach);
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
    struct option_row dering[LIGHT_DERING_ROWS], of_scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows,
        body,
        light_dering_rows(&a.dering, dering),
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
    struct run run = {.arguments = &a};
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = check(&a, &program);
    for (int i = 0; i < PLAN_ALL; i++)
        run.page.seconds[i] = -1;
    run.page.job = &run.shown;
    run.page.most_error = a.max_error;
    if (!err) {
        run.job = (struct plan_job){.quality = (enum plan_quality)a.quality,
                                    .given = program.given,
                                    .given_count = program.given_count,
                                    .scene = program.operands[0]};
        err = look_at_scene(&run, &program);
    }
    if (!err)
        err = a.dry_run ? dry_run(&run) : bake_and_tell(&run);
    bake_paths_clear(&run.paths);
    report_clear(&run.page.error);
    report_clear(&run.page.pictures);
    scene_settings_clear(&a.scene);
    program_clear(&program);
    if (pipe_interrupted()) {
        error_destroy(err);
        pipe_pass_on();
    }
    return error_exit(program.name, err);
}
