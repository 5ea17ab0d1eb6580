/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/run.h"
#include "bake/facts.h"
#include "bake/figures.h"
#include "bake/page.h"
#include "bake/paths.h"
#include "bake/pipe.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a run does, what is shown of it, and what came out. */
struct run {
    const struct bake_job *asked;
    struct plan_job job; /* with our own temporary files */
    struct plan_job shown;
    struct bake_paths paths;
    struct page page;
    char exposure[32]; /* of the first picture, for the second */
};

static void clear(struct run *run)
{
    bake_paths_clear(&run->paths);
    report_clear(&run->page.error);
    report_clear(&run->page.pictures);
}

/* -- what is to be done ----------------------------------------------------------------------- */

/* What the command line says of the light; NULL: nothing. */
static const char *light_given(const struct bake_job *asked)
{
    static const char *const names[] = {"sky", "sun", "point", "spot"};
    for (size_t i = 0; i < asked->given_count; i++)
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            if (!strcmp(asked->given[i].row->name, names[k]))
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

/* A grid knows neither errors nor bytes. */
static void warn_flat(const struct bake_job *asked)
{
    static const char *const names[] = {"max-error", "bytes"};
    for (size_t i = 0; i < asked->given_count && !asked->quiet; i++)
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            if (!strcmp(asked->given[i].row->name, names[k]))
                fprintf(stderr,
                        "%s: warning: %s: the scene has no volume and gets a grid, which --%s says "
                        "nothing of (--probes does, and --bounds gives a volume)\n",
                        asked->program, asked->scene, names[k]);
}

/* Reads the scene, and says whether it is to have a day. */
static struct error *look_at_scene(struct run *run)
{
    const struct bake_job *asked = run->asked;
    const char *light = light_given(asked), *scene = asked->scene;
    struct scene_facts *facts = &run->page.of_scene;
    struct error *err = scene_facts_of(scene, asked->settings, facts);
    run->job.flat = !err && !asked->bounds_given && is_flat(facts->low, facts->high);
    if (run->job.flat)
        warn_flat(asked);
    if (err || !facts->dark)
        return err;
    if (light)
        return error_new("%s: there is no light in the scene, and none of --%s: all would be black",
                         scene, light);
    run->job.day = true;
    facts->sky = true;
    facts->suns = 1;
    if (!asked->quiet)
        fprintf(stderr,
                "%s: warning: %s: there is no light in the scene: it is baked by day, --sky %s "
                "--sun %s (give --sky, --sun, --point or --spot for a light of your own)\n",
                asked->program, scene, PLAN_DAY_SKY, PLAN_DAY_SUN);
    return NULL;
}

static struct error *begin(struct run *run, const struct bake_job *asked)
{
    *run = (struct run){.asked = asked,
                        .job = {.quality = asked->quality,
                                .given = asked->given,
                                .given_count = asked->given_count,
                                .scene = asked->scene}};
    for (int i = 0; i < PLAN_ALL; i++)
        run->page.seconds[i] = -1;
    run->page.job = &run->shown;
    run->page.most_error = asked->most_error;
    return look_at_scene(run);
}

/* Names the files of the run, and those that are shown. readable: the output can be read again. */
static void name_files(struct run *run, bool readable)
{
    const struct bake_job *asked = run->asked;
    struct plan_job *job = &run->job;
    job->pair = run->paths.pair;
    job->probes = run->paths.probes;
    job->output = run->paths.baked;
    job->baked = readable ? asked->output : run->paths.baked;
    job->packed = asked->pack ? asked->pack : run->paths.packed;
    run->shown = *job;
    run->shown.shown = true;
    run->shown.packs = asked->pack;
    run->shown.output = asked->output;
}

struct error *bake_show(const struct bake_job *asked)
{
    struct run run;
    struct error *err = begin(&run, asked);
    name_files(&run, true);
    if (!err)
        err = page_pipe(&run.shown, "", stdout);
    if (!err && (fflush(stdout) || ferror(stdout)))
        err = error_system(errno, "stdout");
    clear(&run);
    return err;
}

/* -- the bake --------------------------------------------------------------------------------- */

static struct error *copy_into(struct file_output *out, const char *path)
{
    struct file_input in;
    struct error *err = file_input_open(&in, path);
    if (err)
        return err;
    while (!err && !in.ended && !pipe_interrupted()) {
        const unsigned char *bytes;
        size_t got;
        err = file_input_peek(&in, FILE_BLOCK_BYTES, &bytes, &got);
        if (!err)
            err = file_output_write(out, bytes, got);
        file_input_consume(&in, got);
    }
    file_input_close(&in);
    return !err && pipe_interrupted() ? error_new("interrupted") : err;
}

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

/* Bakes into the output, which is there when this comes back without an error; what another bake's
 * report says is not, any more. */
static struct error *bake(struct run *run, struct file_output *out)
{
    struct error *err = run_stages(run, 0, PLAN_STAGES, NULL);
    if (!err)
        err = check_light(run);
    if (!err)
        err = copy_into(out, run->paths.baked);
    if (err) {
        file_output_abandon(out);
        return pipe_interrupted() ? error_wrap(err, "nothing is written") : err;
    }
    err = file_output_finish(out);
    if (!err)
        bake_paths_forget(&run->paths);
    return err;
}

/* -- the report ------------------------------------------------------------------------------- */

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
    struct error *err = file_bytes(run->job.packed, &page->packed_bytes);
    if (!err)
        err = run_stages(run, PLAN_ERROR, PLAN_ERROR + 1, &page->error);
    if (!err && run->job.pair)
        err = take_pictures(run);
    return err;
}

static struct error *write_report(const char *file, const char *text, size_t size)
{
    struct file_output report;
    struct error *err = file_output_open(&report, file, false);
    if (!err)
        err = file_output_write(&report, text, size);
    if (!err)
        return file_output_finish(&report);
    file_output_abandon(&report);
    return err;
}

/* The output is there: it is measured, and told of, in a file where there is one. */
static struct error *report(struct run *run, double began)
{
    struct page *page = &run->page;
    FILE *out = strcmp(run->asked->output, "-") ? stdout : stderr;
    char *text = NULL;
    size_t size = 0;
    FILE *page_out = NULL;
    struct error *err = measure(run);
    page->all_time = clock_seconds() - began;
    if (!err)
        page_out = open_memstream(&text, &size);
    if (!err)
        err = page_out ? page_write(page, page_out) : error_memory();
    if (page_out && fclose(page_out) && !err)
        err = error_memory();
    if (!err && run->paths.text)
        err = write_report(run->paths.text, text, size);
    if (err)
        bake_paths_forget(&run->paths);
    /* on standard error it is a message, which may have nobody to hear it */
    else if ((fwrite(text, 1, size, out) < size || fflush(out)) && out == stdout)
        err = error_system(errno, "stdout");
    free(text);
    return error_wrap(err, "%s is whole, its report is not", file_output_name(run->asked->output));
}

/* -- all of it -------------------------------------------------------------------------------- */

/* Better now than after the bake. */
static struct error *can_write(const char *path)
{
    struct file_output out;
    struct error *err = file_output_open(&out, path, true);
    if (!err)
        file_output_abandon(&out);
    return err;
}

/* Names and makes what the run needs beside its output, and says what it runs. */
static struct error *prepare(struct run *run, const struct file_output *out)
{
    const struct bake_job *asked = run->asked;
    struct error *err = asked->pack ? can_write(asked->pack) : NULL;
    run->page.again = out->target;
    if (!err)
        err = bake_paths_report(&run->paths, asked->report, run->page.again ? asked->output : NULL);
    pipe_catch(asked->quiet ? NULL
                            : "probe-bake: interrupted: the probes until now are baked; once more "
                              "ends it at once, with nothing written\n");
    if (!err)
        err = bake_paths_make(&run->paths);
    name_files(run, run->page.again);
    if (!err && !asked->quiet)
        err = page_pipe(&run->shown, "", stderr);
    return err;
}

struct error *bake_run(const struct bake_job *asked)
{
    struct run run;
    struct file_output out;
    const double began = clock_seconds();
    struct error *err = begin(&run, asked);
    if (!err)
        err = file_output_open(&out, asked->output, !asked->text);
    if (err) {
        clear(&run);
        return err;
    }
    err = prepare(&run, &out);
    if (err)
        file_output_abandon(&out);
    else
        err = bake(&run, &out);
    run.page.bake_time = clock_seconds() - began;
    if (!err && pipe_cut_short())
        err = error_new("interrupted: %s is whole, with the probes until then; %s",
                        file_output_name(asked->output),
                        asked->pack ? "it is neither packed nor measured" : "it is not measured");
    /* none is wanted; nor where the stream goes into a pipe and nothing is to be said */
    const bool silent = asked->report ? !run.paths.report : !run.page.again && asked->quiet;
    if (!err && (asked->pack || !silent))
        err = error_wrap(run_stages(&run, PLAN_PACK, PLAN_PACK + 1, NULL),
                         "%s is whole, what is packed is not", file_output_name(asked->output));
    if (!err && !silent)
        err = report(&run, began);
    clear(&run);
    return err;
}
