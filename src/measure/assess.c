/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/assess.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/progress.h"
#include "base/warning.h"
#include "interpolate/baked.h"
#include "math/box.h"
#include "measure/unseen_outside.h"
#include "stream/cells.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { OUTSIDE = 4000 }; /* points of the box that may be outside of the hull */

static struct error *trace(struct truth *truth, const struct assess_job *job)
{
    const struct box box = box_of(job->baked->probe_count, job->baked->position);
    struct progress *progress =
        progress_start(job->progress, job->program, "points", truth_size(&job->truth));
    const struct truth_job traced = {.stage = job->stage,
                                     .settings = &job->truth,
                                     .box = &box,
                                     .command_line = job->command_line,
                                     .threads = job->measure.threads,
                                     .progress = progress,
                                     .warnings = job->warnings};
    struct error *err = truth_trace(truth, &traced);
    progress_end(progress);
    return err;
}

/* The truth from its file; where there is none yet, traced, and kept. */
static struct error *get_truth(struct truth *truth, const struct assess_job *job)
{
    if (job->truth_file && !access(job->truth_file, F_OK))
        return truth_read(truth, job->truth_file, job->stage, &job->truth);
    if (job->truth_file && errno != ENOENT)
        return error_system(errno, "%s", job->truth_file);
    struct error *err = trace(truth, job);
    if (!err && job->truth_file)
        err = stream_write(truth->stream, job->truth_file, STREAM_AS_READ);
    return err;
}

/* Measures the error, and writes the map of it where one is wanted. */
static struct error *measure_points(struct report *report, const struct assess_job *job,
                                    const struct truth *truth)
{
    struct stream *stream = NULL;
    struct table *map = NULL;
    const struct tracer *tracer = job->stage->tracer;
    if (!job->map_file)
        return measure_error(report, truth, job->baked, tracer, &job->measure, NULL);
    struct error *err = stream_create(&stream);
    if (!err)
        err = header_copy(&stream->header, &truth->stream->header);
    if (!err)
        err = header_add_provenance(&stream->header, job->command_line);
    if (!err)
        err = stream_add_table(stream, "probe", &map);
    if (!err)
        err = measure_error(report, truth, job->baked, tracer, &job->measure, map);
    if (!err)
        err = stream_write(stream, job->map_file, job->map_encoding);
    stream_destroy(stream);
    return err;
}

static void warn_of_noise(const struct report *report, const struct assess_job *job)
{
    const struct estimate noise = report_get(report, "noise_mean_relative", "all");
    if (noise.value > job->measure.tolerance)
        warnings_add(job->warnings, "noise",
                     "the truth's noise, %.2g %% of the mean irradiance, is more than --tolerance: "
                     "--truth-rays brings it down",
                     100 * noise.value);
}

struct error *assess(struct assessment *result, const struct assess_job *job)
{
    struct truth truth = {0};
    struct report *report = &result->report;
    const bool leaks = job->leak_samples && job->baked->mesh.corners > 1;
    struct unseen_outside outside = {0};
    const struct unseen_settings settings = {
        .least = job->leak_samples, .seed = job->measure.seed, .threads = job->measure.threads};
    const double start = clock_seconds();
    struct error *err = get_truth(&truth, job);
    const double traced = clock_seconds();
    if (!err && truth_is_preview(&truth))
        err = report_add_number(report, "preview", "all", 1);
    if (!err)
        err = measure_points(report, job, &truth);
    if (!err)
        err = measure_change(report, &truth, job->baked);
    const double measured = clock_seconds();
    if (!err && leaks)
        err = unseen_cells(&result->cells, job->stage->tracer, job->baked, &settings);
    if (!err && leaks)
        err = unseen_outside(&outside, job->stage->tracer, job->baked, &settings, OUTSIDE);
    result->truth_seconds = traced - start;
    result->error_seconds = measured - traced;
    result->leak_seconds = clock_seconds() - measured;
    if (!err && leaks)
        err = unseen_report(report, &result->cells, job->baked->mesh.cells);
    if (!err && leaks)
        err = unseen_outside_report(report, &outside);
    if (!err)
        warn_of_noise(report, job);
    truth_clear(&truth);
    return err;
}

static struct error *store_column(struct stream *stream, const char *name, const float *value)
{
    struct cells cells;
    struct column *column = NULL;
    struct error *err = cells_find(stream, &cells);
    if (!err)
        err = table_add_column(cells.table, name, COLUMN_F32, 1, &column);
    if (!err)
        memcpy(column->data, value, cells.table->rows * sizeof *value);
    return err;
}

struct error *assess_mark(const struct assessment *result, struct stream *stream)
{
    struct error *err = store_column(stream, "leak", result->cells.cell_weight);
    if (!err)
        err = store_column(stream, "leak_light", result->cells.cell_leak);
    return err ? err : store_column(stream, "leak_free", result->cells.cell_free);
}

void assessment_clear(struct assessment *result)
{
    unseen_cells_clear(&result->cells);
    report_clear(&result->report);
}
