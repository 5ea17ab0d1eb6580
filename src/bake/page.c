/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/page.h"
#include "base/error.h"
#include "base/options.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* -- commands --------------------------------------------------------------------------------- */

static struct error *print_stage(const struct plan_job *job, enum plan_stage which,
                                 const char *before, const char *behind, FILE *out)
{
    struct pipe_stage stage = {0};
    char *line = NULL;
    struct error *err = plan_stage(job, which, &stage);
    if (!err)
        err = pipe_stage_line(&stage, &line);
    if (!err)
        fprintf(out, "%s%s%s\n", before, line, behind);
    free(line);
    pipe_clear(&stage, 1);
    return err;
}

struct error *page_pipe(const struct plan_job *job, const char *before, FILE *out)
{
    char indent[32];
    snprintf(indent, sizeof indent, "%s    ", before);
    struct error *err = print_stage(job, 0, before, " |", out);
    for (int i = 1; i < PLAN_STAGES && !err; i++)
        err = print_stage(job, (enum plan_stage)i, indent, i + 1 < PLAN_STAGES ? " |" : "", out);
    if (err || !job->packs)
        return err;
    if (strcmp(job->output, "-") != 0 && !strcmp(job->baked, job->output))
        return print_stage(job, PLAN_PACK, before, "", out);
    struct plan_job packing = *job; /* no shell could know where the stream went */
    packing.baked = "BAKED";
    snprintf(indent, sizeof indent, "%s# ", before);
    return print_stage(&packing, PLAN_PACK, indent, ", of what came out", out);
}

/* -- figures ---------------------------------------------------------------------------------- */

static void print_name(FILE *out, const char *name)
{
    fprintf(out, "  %-11s ", name);
}

/* Parts of the mean square of the error: what the order of SH cuts off, noise of the probes' rays,
 * and the rest, which is between the probes; NaN where it is not known. */
struct parts {
    double sharp, noise, between;
};

static struct parts parts_of(const struct report *r)
{
    const double rms = report_get(r, "rms", "all").value;
    const double sharp = report_get(r, "cut_off", "all").value / rms;
    const double noise = report_get(r, "capture_noise", "all").value / rms;
    struct parts parts = {sharp * sharp, noise * noise, (double)NAN};
    parts.between = 1 - (isnan(sharp) ? 0 : parts.sharp) - (isnan(noise) ? 0 : parts.noise);
    parts.between = parts.between < 0 ? 0 : parts.between;
    return parts;
}

/* "  error        11.2 %  (10.3 .. 12.1)     what it is" */
static void print_share(FILE *out, const char *name, struct estimate e, const char *what)
{
    char interval[64] = "";
    if (isnan(e.value))
        return;
    if (!isnan(e.low))
        snprintf(interval, sizeof interval, "(%.1f .. %.1f)", 100 * e.low, 100 * e.high);
    print_name(out, name);
    fprintf(out, "%5.1f %%  %-16s %s\n", 100 * e.value, interval, what);
}

static void print_count(FILE *out, const char *name, uint64_t count, const char *what)
{
    print_name(out, name);
    fprintf(out, "%9" PRIu64 "%s%s\n", count, *what ? "  " : "", what);
}

static void print_lights(FILE *out, const struct scene_facts *scene)
{
    const struct {
        size_t count;
        const char *one, *more;
    } kinds[] = {{scene->emissive, "emissive triangle", "emissive triangles"},
                 {scene->points, "point", "points"},
                 {scene->spots, "spot", "spots"},
                 {scene->suns, "sun", "suns"}};
    const char *before = "";
    print_name(out, "lights");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (!kinds[i].count)
            continue;
        fprintf(out, "%s%zu %s", before, kinds[i].count,
                kinds[i].count == 1 ? kinds[i].one : kinds[i].more);
        before = ", ";
    }
    fprintf(out, "%s\n", !scene->sky ? (*before ? "" : "none") : *before ? ", a sky" : "a sky");
}

static void print_scene(FILE *out, const struct page *page)
{
    const struct scene_facts *scene = &page->of_scene;
    fprintf(out, "\nthe scene\n");
    print_name(out, "file");
    fprintf(out, "%s\n", page->job->scene);
    print_name(out, "triangles");
    fprintf(out, "%zu\n", scene->triangles);
    print_lights(out, scene);
    print_name(out, "box");
    fprintf(out, "%.4g %.4g %.4g .. %.4g %.4g %.4g\n", scene->low[0], scene->low[1], scene->low[2],
            scene->high[0], scene->high[1], scene->high[2]);
}

static void print_errors(FILE *out, const struct page *page)
{
    const struct report *r = &page->error;
    char what[128];
    const double points = report_get(r, "points", "all").value;
    fprintf(out, "\nits light, against path-traced truth at %.0f points\n", points);
    print_share(out, "error", report_get(r, "error", "all"), "as a player sees it");
    print_share(out, "bad", report_get(r, "bad", "all"), "of the points are off by more than 25 %");
    print_share(out, "leaks", report_get(r, "leak_light", "all"),
                "of the light comes through walls");
    print_share(out, "not mended", report_get(r, "leak_light", "all-probes"),
                "of the light would, without probe-leakfix");
    print_share(out, "blind", report_get(r, "blind", "all"),
                "of the free space sees no probe of its cell");
    const double flip = report_get(&page->pictures, "flip", "").value;
    const double rmse = report_get(&page->pictures, "relative-rmse", "").value;
    if (isnan(flip))
        return;
    snprintf(what, sizeof what, "of the pictures, noise of the truth and all; relative RMSE %.3f",
             rmse);
    print_name(out, "flip");
    fprintf(out, "%7.3f  %-16s %s\n", flip, "", what);
}

static void print_times(FILE *out, const struct page *page)
{
    static const char *const names[] = {
        [PLAN_PLACE] = "place",     [PLAN_CAPTURE] = "capture",  [PLAN_TET] = "tet",
        [PLAN_LEAKFIX] = "leakfix", [PLAN_ERROR] = "error",      [PLAN_PACK] = "pack",
        [PLAN_PAIR] = "light.png",  [PLAN_PROBES] = "probes.png"};
    fprintf(out, "\nseconds of processor\n");
    for (int i = 0; i < PLAN_ALL; i++) {
        if (page->seconds[i] < 0)
            continue;
        print_name(out, names[i]);
        fprintf(out, "%9.1f\n", page->seconds[i]);
    }
    print_name(out, "on the clock");
    fprintf(out, "%8.1f  the bake; %.1f with this report\n", page->bake_time, page->all_time);
}

/* -- advice ----------------------------------------------------------------------------------- */

__attribute__((format(printf, 3, 4))) static void advise(FILE *out, bool *any, const char *format,
                                                         ...)
{
    va_list args;
    if (!*any)
        fprintf(out, "\nadvice\n");
    *any = true;
    fprintf(out, "  - ");
    va_start(args, format);
    vfprintf(out, format, args);
    va_end(args);
}

/* Above this part of the mean square, what the order cuts off counts: of a sun in the open it is a
 * third, and with order 5 the error that a player sees is 18 %, not 29. */
#define SHARP 0.25

/* What to do against the largest part of an error that is large, or larger than was asked for. */
static void advise_error(FILE *out, bool *any, const struct page *page)
{
    const struct estimate error = report_get(&page->error, "error", "all");
    const struct parts p = parts_of(&page->error);
    const bool above = page->most_error > 0 && error.low > page->most_error;
    if (!above && !(error.value > 0.2))
        return;
    if (above)
        advise(out, any, "--max-error %g %% was not reached, the best is %.1f %%",
               100 * page->most_error, 100 * error.value);
    else
        advise(out, any, "the error is large");
    if (p.noise > p.between && !(p.sharp > p.noise))
        fprintf(out, ": most of it is noise of the probes, and --rays lowers it\n");
    else if (p.sharp > SHARP)
        fprintf(out, ": light is too sharp for SH of this order, as of a sun or a lamp near\n"
                     "    by: --order 5, or --light indirect, and direct light from the game\n");
    else if (above && !plan_given(page->job, "probes") && !plan_given(page->job, "bytes"))
        fprintf(out,
                ": most of\n    it is between the probes, and more of them did not lower it\n");
    else
        fprintf(out, ": most of it is between the probes: more --probes, or a better\n"
                     "    --quality\n");
}

static void print_advice(FILE *out, const struct page *page)
{
    const struct bake_facts *bake = &page->of_bake;
    const struct report *r = &page->error;
    bool any = false;
    if (page->job->day)
        advise(out, &any,
               "the scene has no light: this is a day of --sky %s --sun %s;\n"
               "    give --sky or --sun for one of your own\n",
               PLAN_DAY_SKY, PLAN_DAY_SUN);
    if (bake->black == bake->probes)
        advise(out, &any,
               "no light reaches any probe: is the scene closed, or its lamps hidden?\n"
               "    --point X,Y,Z,R,G,B puts one inside\n");
    else if (bake->black > bake->probes / 10)
        advise(out, &any, "no light reaches %zu of %zu probes\n", bake->black, bake->probes);
    if (bake->in_matter > bake->probes / 20)
        advise(out, &any,
               "%zu of %zu probes see more backs than fronts, as in matter: the scene may\n"
               "    have holes or faces turned round; --exclude leaves out what is in the way\n",
               bake->in_matter, bake->probes);
    advise_error(out, &any, page);
    if (report_get(r, "leak_light", "all").low > 0.05)
        advise(out, &any,
               "much light comes through walls: more --probes, or probe-leakfix --probes N\n");
}

/* How to measure it again. */
static struct error *print_commands(FILE *out, const struct page *page)
{
    struct error *err = NULL;
    fprintf(out, "\nmeasured by\n");
    for (int i = PLAN_ERROR; i < PLAN_ALL && !err; i++)
        if (page->seconds[i] >= 0 && i != PLAN_PACK)
            err = print_stage(page->job, (enum plan_stage)i, "  ", "", out);
    return err;
}

struct error *page_write(const struct page *page, FILE *out)
{
    const struct plan_job *job = page->job;
    fprintf(out, "probe-bake: %s\n", job->output);
    fprintf(out, "\nthe pipe (--quality %s)\n", plan_quality_names[job->quality]);
    struct error *err = page_pipe(job, "  ", out);
    print_scene(out, page);
    fprintf(out, "\nthe bake\n");
    print_count(out, "probes", page->of_bake.probes, "");
    print_count(out, "cells", page->of_bake.cells, "");
    print_count(out, "bytes", page->of_bake.bytes, "of the stream");
    print_count(out, "packed", page->packed_bytes, "bytes as libprobe-query reads it, in floats");
    print_errors(out, page);
    print_times(out, page);
    if (!err && page->again)
        err = print_commands(out, page);
    if (job->pair)
        fprintf(out,
                "\npictures\n  %s\n      the true light, and beside it that of the probes\n"
                "  %s\n      the probes, as spheres that show their light\n",
                job->pair, job->probes);
    print_advice(out, page);
    return err;
}
