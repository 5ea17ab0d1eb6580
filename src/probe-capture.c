/* SPDX-License-Identifier: Apache-2.0 */
/* probe-capture: path traces the light that reaches each probe of a stream and projects it to
 * SH. */
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "capture/capture_black.h"
#include "capture/capture_options.h"
#include "capture/capture_stream.h"
#include "import/import_scene.h"
#include "light/convert.h"
#include "scene/relit.h"
#include "scene/scene.h"
#include "scene/scene_told.h"
#include "stream/light_columns.h"
#include "stream/stream.h"
#include "topology/decimate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void warn_before(const struct capture_options *o, const struct scene *scene,
                        struct warnings *warnings)
{
    if (o->capture.light != CAPTURE_NONE && capture_is_dark(scene))
        warnings_add(
            warnings, "no light",
            "%s: there is no light in the scene: all probes are black (--sky, --sun, --point and "
            "--spot add light)",
            scene->path);
    if (!scene_triangle_count(scene))
        warnings_add(warnings, "empty", "%s: the scene is empty: probes see the sky alone",
                     scene->path);
}

static void warn_after(const struct capture_run *run, struct warnings *warnings)
{
    const struct scene *scene = run->scene;
    if (run->options.capture.light == CAPTURE_NONE)
        return;
    if (capture_is_white(scene) && run->captured && run->sky == 0)
        warnings_add(warnings, "white",
                     "%s: the scene is closed and reflects all light: only --bounces ends it "
                     "(--albedo-scale "
                     "or --max-albedo makes walls darker)",
                     scene->path);
    if (run->sight_dropped)
        warnings_add(warnings, "sight",
                     "%s: what cells keep of what their points see is of other surfaces: left out "
                     "(probe-leakfix looks anew)",
                     scene->path);
    if (run->probes && !run->captured && !run->left &&
        !header_key(stream_reader_header(run->reader), CAPTURE_BY_KEY))
        warnings_add(warnings, "nothing to do",
                     "all %zu probes%s have light already (--again captures them anew)",
                     run->probes, run->options.slice.parts > 1 ? " of the slice" : "");
}

/* The light of a stream that was relit; that its parts are as they were captured. */
static struct error *relight(struct scene *scene, const struct capture_options *o,
                             const struct stream_header *header, struct warnings *warnings)
{
    const struct scene_settings *s = &o->scene;
    if (relit_is(header) && (s->sky_given || (s->light_count && !s->inherited)))
        return error_new("the stream was relit, and its header names that light: expected no "
                         "--sky, --sun, --point and --spot");
    const struct capture_split *split = &o->split;
    if (relit_is(header) && (split->groups.count || split->groups.each || split->sky_order ||
                             split->sun_count || split->point_count))
        return error_new("the stream was relit: groups and transfers are of light as it is "
                         "captured: expected --groups off and a stream that was relit without "
                         "--keep");
    if (header_key(header, LIGHT_BASIS_KEY))
        return error_new("the stream's groups and transfers are compressed (key %s): expected the "
                         "stream before probe-relight --compress",
                         LIGHT_BASIS_KEY);
    return relit_scene(scene, s, header, warnings);
}

int main(int argc, char **argv)
{
    struct program program = {.name = "probe-capture",
                              .usage = "[OPTION]... SCENE [STREAM]",
                              .summary = "Path traces the light of SCENE that reaches each probe "
                                         "of STREAM (standard input) and\n"
                                         "adds it as spherical harmonics, or as irradiance to "
                                         "probes that have a normal. Probes\n"
                                         "that have light already are left as they are.",
                              .operands_least = 1,
                              .operands_most = 2};
    struct warnings warnings = {0};
    struct capture_run run = {
        .options = capture_options_default(), .dering = {.least = 1}, .order_lost = NAN};
    struct capture_options *o = &run.options;
    struct scene *scene = NULL;
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct error *err = capture_options_parse(o, &program, argc, argv);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "the scene", input, "the probes");
    if (!err && o->groups)
        err = file_inputs_differ(o->groups, "--groups", input, "the probes");
    if (!err && o->transfer_suns)
        err = file_inputs_differ(o->transfer_suns, "--transfer suns", input, "the probes");
    if (!err && o->transfer_surfaces)
        err = file_inputs_differ(o->transfer_surfaces, "--transfer surfaces", input, "the probes");
    if (!err && o->transfer_points)
        err = file_inputs_differ(o->transfer_points, "--transfer points", input, "the probes");
    claim_in_place(input);
    if (!err)
        err = stream_reader_open(&run.reader, input);
    if (!err)
        err = capture_options_take_over(o, &program, stream_reader_header(run.reader), argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    if (!err)
        err = scene_read(&scene, program.operands[0], &o->scene, o->scene.lenient, &warnings);
    if (!err)
        err = scene_settings_found_sky(&o->scene, scene);
    if (!err)
        err = relight(scene, o, stream_reader_header(run.reader), &warnings);
    if (!err)
        err = scene_told(&warnings, stream_reader_header(run.reader), o->common.quiet, &run.told);
    if (!err)
        err = scene_decimate(scene, o->capture.decimate, &warnings);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = path_init(&path, tracer, o->capture.bounces);
    if (!err)
        err = capture_split_open(&o->split, scene,
                                 &(struct groups_way){.added = o->scene.light_count}, &path);
    if (!err)
        warn_before(o, scene, &warnings);
    if (!o->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err) {
        run.command_line = program.recorded;
        run.scene = scene;
        run.path = &path;
        run.program = program.name;
        run.say = o->common.quiet ? NULL : stderr;
        o->capture.split = capture_split_count(&o->split) ? &o->split : NULL;
        interrupt_catch(); /* from here on there is something to lose */
        run.progress =
            progress_start(o->common.progress && !o->common.quiet, program.name, "probes", 0);
        err = capture_stream(&run);
        progress_end(run.progress);
    }
    if (!err && *run.cache_told && !o->common.quiet)
        fprintf(stderr, "%s: %s\n", program.name, run.cache_told);
    if (!isnan(run.order_lost) && !o->common.quiet)
        fprintf(stderr, "%s: order %d loses %.2g of the irradiance\n", program.name,
                o->capture.order, run.order_lost);
    if (!err && !o->dry_run) {
        warn_after(&run, &warnings);
        capture_links_warn(&run.links, &warnings);
        if (o->capture.light != CAPTURE_NONE)
            err = capture_black_warn(&run.black, tracer, &warnings);
    }
    if (!err && !o->dry_run) {
        err = stream_writer_finish(run.writer);
    } else {
        stream_writer_abandon(run.writer);
    }
    if (!err && !o->common.quiet && run.dering.probes)
        convert_report_dering(&run.dering, program.name, stderr);
    if (!err && !o->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err && run.left)
        err = error_new("interrupted: %zu of %zu probes captured; given back to probe-capture, the "
                        "rest is captured",
                        run.captured, run.captured + run.left);
    path_clear(&path);
    trace_destroy(tracer);
    scene_destroy(scene);
    stream_reader_close(run.reader);
    header_clear(&run.header);
    capture_links_clear(&run.links);
    free(run.told);
    capture_options_clear(o);
    program_clear(&program);
    return error_exit(program.name, err);
}
