/* SPDX-License-Identifier: Apache-2.0 */
/* probe-leakfix: keeps light from going through walls: by what the points of each cell see of its
 * probes, or by more probes on both sides of the wall. */
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/capture_cache.h"
#include "capture/stage.h"
#include "leak/dilate.h"
#include "leak/leak_mend.h"
#include "measure/unseen.h"
#include "scene/scene_told.h"
#include "stream/common_options.h"
#include "stream/light_columns.h"
#include "stream/sight_key.h"
#include "stream/stream.h"
#include "stream/stream_edit.h"

#include <math.h>
#include <stdio.h>

/* Lengths that were not given are taken from the cells. */
static struct error *complete(struct leak_settings *settings, const struct stream *stream)
{
    struct leak_mesh mesh;
    struct leak_settings usual = {0};
    struct error *err = leak_mesh_of(stream, &mesh);
    if (!err)
        err = leak_settings_for(&usual, &mesh);
    if (isnan(settings->offset))
        settings->offset = usual.offset;
    if (isnan(settings->separation))
        settings->separation = usual.separation;
    return err;
}

/* What new probes are captured with. */
struct capturing {
    struct stage *stage;        /* of the whole scene */
    struct stage simpler;       /* of that which the others were captured in, once it is needed */
    struct cache_options cache; /* as they were, but for what the command line gave */
    const char *scene, *program;
    const struct common *common;
    struct warnings *warnings;
};

/* The stage that the others were captured on; where that was of fewer triangles, another than walls
 * are looked for in. */
static struct error *stage_of(struct capturing *c, const struct stream_header *header,
                              struct stage **stage)
{
    *stage = c->stage;
    if (!(c->stage->capture_settings.decimate < 1))
        return NULL;
    *stage = &c->simpler;
    if (c->simpler.scene)
        return NULL;
    struct stream_header as_read = {0};
    struct scene_settings given = scene_settings_default();
    struct warnings twice = {0}; /* what it is read again for was said the first time */
    struct error *err = header_copy(&as_read, header);
    if (!err)
        err = scene_file_to_header(&c->stage->scene_settings, &as_read);
    if (!err)
        err = stage_init(&c->simpler, c->scene, &as_read, &given, &twice);
    if (!err)
        err = stage_decimate(&c->simpler, c->warnings);
    scene_settings_clear(&given);
    header_clear(&as_read);
    warnings_clear(&twice);
    return err;
}

static struct error *capture_new(void *context, struct stream *stream, size_t first)
{
    struct capturing *c = context;
    struct table *probes = stream_table(stream, "probe");
    const size_t count = probes->rows - first;
    struct stage *stage;
    struct capture_cache cache = {0};
    if (!c->stage->captured) {
        warnings_add(c->warnings, "uncaptured",
                     "the stream's probes have no light, and so have new ones: run probe-capture");
        return NULL;
    }
    struct error *err = stage_of(c, &stream->header, &stage);
    if (!err)
        err = capture_cache_open_rows(&cache, &stage->path, &stage->capture_settings, &c->cache,
                                      stage->scene, probes, first, count, c->common->threads);
    if (!err && *cache.told && !c->common->quiet)
        fprintf(stderr, "%s: %s\n", c->program, cache.told);
    if (err) {
        capture_cache_clear(&cache);
        return error_wrap(err, c->cache.name_given
                                   ? "--cache"
                                   : "the cache of the stream's probes (--cache off: without it)");
    }
    struct progress *progress =
        progress_start(c->common->progress && !c->common->quiet, c->program, "probes", count);
    struct capture_job job = {.path = &stage->path,
                              .settings = &stage->capture_settings,
                              .threads = c->common->threads,
                              .progress = progress};
    err = capture_rows(&job, probes, first, count);
    progress_end(progress);
    path_use_cache(&stage->path, NULL);
    capture_cache_clear(&cache);
    return err;
}

static struct error *check(const struct leak_mend_job *job, bool gate)
{
    if ((gate || job->probes) && !(job->points > 0))
        return error_usage("%s needs --points", gate ? "--max-leak" : "--probes");
    if (job->points > 0 && job->points < 100)
        return error_usage("--points: expected 0 or at least 100, got %.0f", job->points);
    return NULL;
}

static struct error *check_cache(struct cache_options *cache, const struct leak_mend_job *job)
{
    struct error *err = cache_options_check(cache);
    if (!err && cache->name && !job->rounds && !job->probes)
        err = error_usage("--cache is for new probes: it needs --rounds or --probes");
    return err;
}

/* Whether there are borders of shadows in the probes' light, where they are asked for. */
static struct error *check_shadows(const struct leak_settings *settings, const struct stage *stage,
                                   struct warnings *warnings)
{
    if (settings->edges == LEAK_WALLS)
        return NULL;
    if (stage->capture_settings.light == CAPTURE_INDIRECT)
        return error_new("the probes hold indirect light, where shadows have no borders: --edges "
                         "walls, or probe-capture --light all or direct");
    if (!stage->scene->light_count)
        warnings_add(warnings, "shadows",
                     "%s: there is no sun, point or spot whose shadow has a border: --edges looks "
                     "for none",
                     stage->scene->path);
    return NULL;
}

static struct error *parse_condition(void *value, const char *text)
{
    return stream_selection_add(value, text);
}

/* Gives light to the probes that stand in matter, and says to how many. */
static struct error *dilate_light(struct stream *stream, const struct stream_selection *invalid,
                                  const struct stage *stage, const struct common *common,
                                  const char *program)
{
    struct dilate_count count;
    struct table *probes = stream_table(stream, "probe");
    if (!invalid->condition_count)
        return NULL;
    struct error *err = dilate(probes, invalid, stage->tracer, common->threads, &count);
    if (!err && !common->quiet)
        fprintf(stderr,
                "%s: %zu of %zu probes hold the light of another: %zu of one that they see, %zu of "
                "the nearest\n",
                program, count.filled, probes->rows, count.filled - count.unseen, count.unseen);
    return error_wrap(err, "--dilate");
}

/* Whether light was split into groups, or there are transfers. */
static bool keeps_parts(const struct stream_header *header)
{
    bool keeps = false;
    for (size_t k = 0; k < header->key_count; k++)
        keeps = keeps || light_key_is_split(header->keys[k].name);
    return keeps;
}

int main(int argc, char **argv)
{
    static const char *const edges[] = {
        [LEAK_WALLS] = "walls", [LEAK_SHADOWS] = "shadows", [LEAK_BOTH] = "both", NULL};
    int no_sight = 0;
    bool gate = false, most_given = false;
    double leak_most = 0;
    struct stream_selection invalid = {.step = 1, .end = -1};
    struct leak_mend_job job = {
        .settings = {.graze = 0.1, .margin = 0.1, .offset = NAN, .separation = NAN},
        .points = 10000};
    const struct option_row rows[] = {
        {.name = "no-sight",
         .kind = OPTION_SET,
         .value = OPTION_ENUM(no_sight),
         .count = 1,
         .help = "cells do not keep which of their probes their points see"},
        {.name = "points",
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &job.points,
         .most = 1e9,
         .help = "points in free space that measure what leaks; 0: nothing is measured"},
        {.name = "max-leak",
         .argument = "SHARE",
         .kind = OPTION_CALL,
         .parse = options_share,
         .value = &leak_most,
         .given = &gate,
         .shown = "none",
         .help = "exit with status 3 where more of the light may leak; where no more\n"
                 "does, no probe is added"},
        {.name = "probes",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &job.probes,
         .most = INT32_MAX,
         .help = "put at most N more probes where they take away most of what leaks"},
        {.name = "rounds",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &job.rounds,
         .most = 1000,
         .help = "where edges go through walls, put more probes on both sides, at most N\n"
                 "times"},
        {.name = "edges",
         .argument = "WHICH",
         .kind = OPTION_CHOICE,
         .choices = edges,
         .value = OPTION_ENUM(job.settings.edges),
         .help = "they go in where edges meet walls, the borders of shadows that suns,\n"
                 "points and spots cast (shadows), or both"},
        {.name = "dilate",
         .argument = "CONDITION",
         .kind = OPTION_CALL,
         .value = &invalid,
         .parse = parse_condition,
         .shown = "none",
         .help = "probes for which CONDITION holds, as 'validity < 0.5', get the light of\n"
                 "the nearest other that they see; given more than once, all must hold"},
        {.name = "graze",
         .argument = "COS",
         .kind = OPTION_REAL,
         .value = &job.settings.graze,
         .most = 1,
         .least = 1e-9,
         .help = "a ray nearer to the surface's plane than this cosine to its normal\n"
                 "only grazes it"},
        {.name = "margin",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &job.settings.margin,
         .most = 0.5,
         .least = 1e-9,
         .help = "no probe where the edge's end is nearer to the wall than this share\n"
                 "of the edge"},
        {.name = "offset",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &job.settings.offset,
         .least_open = true,
         .most = INFINITY,
         .help = "distance of new probes from the surface (default: 0.05 of the median edge)"},
        {.name = "separation",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &job.settings.separation,
         .least_open = true,
         .most = INFINITY,
         .help = "in the first round, no new probe nearer than this to one that it sees;\n"
                 "halved in each round (default: 0.5 of the median edge)"},
        {.name = "max-probes",
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &job.probes_most,
         .given = &most_given,
         .least = 1,
         .most = INT32_MAX,
         .shown = "1000000, or twice the stream's",
         .help = "never have more probes than this in all"},
        {0}};
    struct common common = common_default();
    struct scene_settings given = scene_settings_default();
    struct stage stage = {0};
    struct warnings warnings = {0};
    struct capturing capturing = {.stage = &stage,
                                  .cache = cache_options_default(),
                                  .common = &common,
                                  .warnings = &warnings};
    struct option_row of_cache[CACHE_OPTION_ROWS], of_file[SCENE_FILE_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, cache_option_rows(&capturing.cache, of_cache), scene_file_rows(&given, of_file),
        common_rows(&common, COMMON_STREAM | COMMON_THREADS | COMMON_PROGRESS, shared), NULL};
    for (size_t i = 0; of_cache[i].kind != OPTION_FLAG; i++)
        of_cache[i].shown = "as captured";
    struct program program = {
        .name = "probe-leakfix",
        .usage = "[OPTION]... SCENE [STREAM]",
        .summary =
            "Keeps the light of the tetrahedra in STREAM (standard input) from going through walls "
            "of\n"
            "SCENE: what blends their probes takes none of those that a point does not see.",
        .operands_least = 1,
        .operands_most = 2};
    struct stream *stream = NULL;
    struct report report = {0};
    capturing.program = program.name;
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = check(&job, gate);
    if (!err)
        err = check_cache(&capturing.cache, &job);
    if (!err)
        err = options_record(&program, program.operands[0]);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "the scene", input, "the probes");
    claim_in_place(input);
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = error_wrap(complete(&job.settings, stream), "%s", file_input_name(input));
    if (!err && !most_given)
        job.probes_most = fmax(1e6, 2 * (double)stream_table(stream, "probe")->rows);
    if (!err)
        err = stage_init(&stage, program.operands[0], &stream->header, &given, &warnings);
    if (!err)
        err = cache_options_from_header(&capturing.cache, &stream->header);
    if (!err)
        err = cache_options_check_renew(&capturing.cache);
    if (!err)
        err = scene_told_in(&warnings, &stream->header, common.quiet);
    if (!err && stage.other)
        warnings_add(
            &warnings, "scene",
            "%s: this is not the scene that the probes were captured in (its key is %s, theirs %s)",
            program.operands[0], stage.key, stage.captured_key);
    if (!err && *stage.relit && keeps_parts(&stream->header))
        warnings_add(&warnings, "parts",
                     "the stream was relit and keeps the parts of its light: probes that are added "
                     "have the light of now, and no parts");
    if (!err)
        err = check_shadows(&job.settings, &stage, &warnings);
    if (!err) {
        capturing.scene = program.operands[0];
        job.capture = capture_new;
        job.context = &capturing;
        job.leak_most = gate ? leak_most : -1;
        job.tracer = stage.tracer;
        job.sight = !no_sight;
        job.settings.threads = common.threads;
        job.program = common.quiet ? NULL : program.name;
        err = leak_mend(stream, &job, &report, &warnings);
    }
    if (!err)
        err = sight_key_set(stream, scene_surface_key(stage.scene));
    if (!err)
        err = dilate_light(stream, &invalid, &stage, &common, program.name);
    if (!err)
        err = scene_file_to_header(&stage.scene_settings, &stream->header);
    if (!err)
        err = header_add_provenance(&stream->header, program.recorded);
    if (!err)
        err = stream_write(stream, common.output, common.encoding);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err && gate)
        err = unseen_gate(&report, leak_most);
    report_clear(&report);
    stage_clear(&capturing.simpler);
    stage_clear(&stage);
    scene_settings_clear(&given);
    stream_selection_clear(&invalid);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
