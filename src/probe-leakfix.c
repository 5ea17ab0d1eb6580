/* SPDX-License-Identifier: Apache-2.0 */
/* probe-leakfix: keeps light from going through walls: by what the points of each cell see of its
 * probes, or by more probes on both sides of the wall. */
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/stage.h"
#include "leak/dilate.h"
#include "leak/leak_mend.h"
#include "scene/scene_told.h"
#include "stream/common_options.h"
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

static struct error *capture_new(struct stream *stream, struct stage *stage, size_t first,
                                 const struct common *common, const char *program,
                                 struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    const size_t count = probes->rows - first;
    if (!count)
        return NULL;
    if (!stage->captured) {
        warnings_add(
            warnings, "uncaptured",
            "the stream's probes have no light, and so have the %zu new ones: run probe-capture",
            count);
        return NULL;
    }
    struct error *err = stage_decimate(stage, warnings);
    if (err)
        return err;
    struct progress *progress =
        progress_start(common->progress && !common->quiet, program, "probes", count);
    struct capture_job job = {.path = &stage->path,
                              .settings = &stage->capture_settings,
                              .threads = common->threads,
                              .progress = progress};
    err = capture_rows(&job, probes, first, count);
    progress_end(progress);
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

int main(int argc, char **argv)
{
    static const char *const edges[] = {
        [LEAK_WALLS] = "walls", [LEAK_SHADOWS] = "shadows", [LEAK_BOTH] = "both", NULL};
    int no_sight = 0;
    struct stream_selection invalid = {.step = 1, .end = -1};
    struct leak_mend_job job = {
        .settings = {.graze = 0.1, .margin = 0.1, .offset = NAN, .separation = NAN},
        .probes_most = 1e6};
    const struct option_row rows[] = {
        {.name = "no-sight",
         .kind = OPTION_SET,
         .value = OPTION_ENUM(no_sight),
         .count = 1,
         .help = "cells do not keep which of their probes their points see"},
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
         .least = 1,
         .most = INT32_MAX,
         .help = "stop rather than have more probes"},
        {0}};
    struct common common = common_default();
    struct scene_settings given = scene_settings_default();
    struct option_row of_file[SCENE_FILE_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, scene_file_rows(&given, of_file),
        common_rows(&common, COMMON_STREAM | COMMON_THREADS | COMMON_PROGRESS, shared), NULL};
    struct program program = {
        .name = "probe-leakfix",
        .usage = "[OPTION]... SCENE [STREAM]",
        .summary =
            "Keeps the light of the tetrahedra in STREAM (standard input) from going through walls "
            "of\n"
            "SCENE: what blends their probes takes none of those that a point does not see.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct stage stage = {0};
    size_t before = 0;
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "the scene", input, "the probes");
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = error_wrap(complete(&job.settings, stream), "%s", file_input_name(input));
    if (!err)
        err = stage_init(&stage, program.operands[0], &stream->header, &given, &warnings);
    if (!err)
        err = scene_told_in(&warnings, &stream->header, common.quiet);
    if (!err && stage.other)
        warnings_add(
            &warnings, "scene",
            "%s: this is not the scene that the probes were captured in (its key is %s, theirs %s)",
            program.operands[0], stage.key, stage.captured_key);
    if (!err)
        err = check_shadows(&job.settings, &stage, &warnings);
    if (!err) {
        before = stream_table(stream, "probe")->rows;
        job.tracer = stage.tracer;
        job.sight = !no_sight;
        job.settings.threads = common.threads;
        job.program = common.quiet ? NULL : program.name;
        err = leak_mend(stream, &job, &warnings);
    }
    if (!err)
        err = sight_key_set(stream, scene_surface_key(stage.scene));
    if (!err)
        err = capture_new(stream, &stage, before, &common, program.name, &warnings);
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
    stage_clear(&stage);
    scene_settings_clear(&given);
    stream_selection_clear(&invalid);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
