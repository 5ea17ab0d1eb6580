/* SPDX-License-Identifier: Apache-2.0 */
/* probe-capture: path traces the light that reaches each probe of a stream and projects it to
 * SH. */
#include "base/error.h"
#include "base/file.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "capture/capture_options.h"
#include "import/import_scene.h"
#include "light/convert.h"
#include "scene/scene.h"
#include "stream/stream.h"
#include "topology/decimate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 1024 };

/* A run: what it reads and writes, and what it has seen. */
struct run {
    struct capture_options options;
    struct program *program;
    struct stream_reader *reader;
    struct stream_writer *writer; /* opened when the order is known */
    struct stream_header header;
    const struct scene *scene;
    const struct path_tracer *path;
    struct progress *progress;
    struct warnings *warnings;
    size_t probes, captured; /* of the slice */
    size_t left;             /* that a signal came before */
    struct dering_count dering;
    double sky; /* sum of the captured probes' share of rays that escaped, where it is kept */
};

static struct error *open_writer(struct run *run)
{
    const struct capture_options *o = &run->options;
    const struct capture_record record = {.settings = &o->capture,
                                          .light = &o->scene,
                                          .scene_key = scene_key(run->scene),
                                          .again = o->again,
                                          .command_line = run->program->recorded};
    struct error *err =
        capture_make_header(&run->header, stream_reader_header(run->reader), &record);
    const enum stream_encoding read = stream_reader_encoding(run->reader),
                               asked = o->common.encoding;
    return err ? err
               : stream_writer_open(&run->writer, o->common.output,
                                    asked == STREAM_AS_READ ? read : asked, &run->header);
}

static struct capture_job make_job(const struct run *run)
{
    const struct capture_options *o = &run->options;
    return (struct capture_job){.path = run->path,
                                .settings = &o->capture,
                                .again = o->again,
                                .slice = &o->slice,
                                .threads = o->common.threads,
                                .progress = run->progress};
}

/* Remembers what was captured in a table, whose first row is the slice's next. */
static void note(struct run *run, const struct table *out, const struct capture_job *job)
{
    struct capture_slice *slice = &run->options.slice;
    run->captured += job->captured;
    run->left += job->left;
    for (size_t i = 0; i < out->rows; i++)
        run->probes += (slice->number + i) % slice->parts == slice->part;
    slice->number += out->rows;
    const struct column *sky = table_column(out, "sky");
    for (size_t i = 0; sky && i < out->rows; i++)
        run->sky += isnan(column_f32(sky)[i]) ? 0 : (double)column_f32(sky)[i];
    dering_count_add(&run->dering, out);
}

/* The table that is to be written: what came, and what capture adds. */
static struct error *make_schema(const struct run *run, const struct table *schema,
                                 struct table *out)
{
    struct error *err = table_copy_schema(out, schema);
    if (!err && run->options.again)
        capture_drop_stale(out);
    return err ? err : capture_add_columns(&run->options.capture, out);
}

/* Takes the rows of `in` over into `out`, whose other columns are missing. */
static struct error *take_rows(const struct run *run, const struct table *in, struct table *out)
{
    struct error *err = table_resize(out, 0); /* rows that are new again hold missing values */
    if (!err)
        err = table_resize(out, in->rows);
    if (!err)
        table_copy_rows(out, 0, in, 0, in->rows);
    return !err && run->options.again ? capture_forget(out) : err;
}

/* Captures the probes block by block, so that they go on while others are still to come. */
static struct error *capture_blocks(struct run *run, const struct table *schema, struct table *out)
{
    struct capture_job job = make_job(run);
    struct table in = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = stream_writer_table(run->writer, out);
    for (size_t got = 1; !err && got;) {
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(run->reader, &in, BLOCK, &got);
        if (!err)
            err = take_rows(run, &in, out);
        if (!err)
            err = capture_rows(&job, out, 0, got);
        if (err)
            break;
        note(run, out, &job);
        err = stream_writer_rows(run->writer, out, 0, got);
    }
    table_clear(&in);
    return err;
}

/* Captures all probes to the highest order, and keeps the least that loses no more than it may. */
static struct error *capture_to_least_order(struct run *run, const struct table *schema,
                                            struct table *out)
{
    struct capture_options *o = &run->options;
    struct capture_job job = make_job(run);
    struct table in = {0};
    double lost = 0;
    size_t got = 1;
    struct error *err = table_copy_schema(&in, schema);
    while (!err && got)
        err = stream_reader_rows(run->reader, &in, BLOCK, &got);
    if (!err)
        err = take_rows(run, &in, out);
    if (!err)
        err = capture_least_order(&job, out, o->order_loss, &o->capture.order, &lost);
    if (!err)
        err = open_writer(run);
    if (!err)
        err = stream_writer_table(run->writer, out);
    if (!err)
        err = stream_writer_rows(run->writer, out, 0, out->rows);
    if (!err)
        note(run, out, &job);
    if (!err && !job.left && !o->common.quiet)
        fprintf(stderr, "%s: order %d loses %.2g of the irradiance\n", run->program->name,
                o->capture.order, lost);
    table_clear(&in);
    return err;
}

static struct error *capture_table(struct run *run, const struct table *schema)
{
    struct table out = {0};
    struct error *err = make_schema(run, schema, &out);
    const bool surface = table_column(schema, "normal"),
               choose = run->options.order_auto && !surface;
    if (!err && choose && run->writer)
        err = error_new("--order auto: expected table probe before the others");
    if (!err && !choose && !run->writer)
        err = open_writer(run);
    if (!err)
        err = choose ? capture_to_least_order(run, schema, &out)
                     : capture_blocks(run, schema, &out);
    table_clear(&out);
    return err;
}

static struct error *capture_stream(struct run *run)
{
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        const bool probes = !err && more && !strcmp(schema.name, "probe");
        if (!err && !probes && !run->writer)
            err = open_writer(run);
        if (probes)
            err = capture_table(run, &schema);
        else if (!err && more)
            err = stream_copy_table(run->reader, run->writer, &schema);
        table_clear(&schema);
    }
    return err;
}

static void warn_before(const struct scene *scene, struct warnings *warnings)
{
    if (capture_is_dark(scene))
        warnings_add(
            warnings, "no light",
            "%s: there is no light in the scene: all probes are black (--sky, --sun, --point and "
            "--spot add light)",
            scene->path);
    if (!scene_triangle_count(scene))
        warnings_add(warnings, "empty", "%s: the scene is empty: probes see the sky alone",
                     scene->path);
}

static void warn_after(const struct run *run)
{
    const struct scene *scene = run->scene;
    if (capture_is_white(scene) && run->captured && run->sky == 0)
        warnings_add(run->warnings, "white",
                     "%s: the scene is closed and reflects all light: only --bounces ends it "
                     "(--albedo-scale "
                     "or --max-albedo makes walls darker)",
                     scene->path);
    if (run->probes && !run->captured && !run->left)
        warnings_add(run->warnings, "nothing to do",
                     "all %zu probes%s have light already (--again captures them anew)",
                     run->probes, run->options.slice.parts > 1 ? " of the slice" : "");
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
    struct run run = {.options = capture_options_default(),
                      .program = &program,
                      .warnings = &warnings,
                      .dering = {.least = 1}};
    struct capture_options *o = &run.options;
    struct scene *scene = NULL;
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct error *err = capture_options_parse(o, &program, argc, argv);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "the scene", input, "the probes");
    if (!err)
        err = stream_reader_open(&run.reader, input);
    if (!err)
        err = capture_options_take_over(o, &program, stream_reader_header(run.reader), argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    if (!err)
        err = scene_read(&scene, program.operands[0], &o->scene, true, &warnings);
    if (!err)
        err = scene_decimate(scene, o->capture.decimate, &warnings);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = path_init(&path, tracer, o->capture.bounces);
    if (!err)
        warn_before(scene, &warnings);
    if (!o->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err) {
        run.scene = scene;
        run.path = &path;
        interrupt_catch(); /* from here on there is something to lose */
        run.progress =
            progress_start(o->common.progress && !o->common.quiet, program.name, "probes", 0);
        err = capture_stream(&run);
        progress_end(run.progress);
    }
    if (!err) {
        warn_after(&run);
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
    capture_options_clear(o);
    program_clear(&program);
    return error_exit(program.name, err);
}
