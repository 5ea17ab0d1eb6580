/* probe-leakfix: finds edges of the tetrahedra that pass through walls, and puts probes on both
 * sides of the wall. */
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/stage.h"
#include "leak/cells_make.h"
#include "leak/leak.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "stream/cells.h"
#include "stream/common_options.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct arguments {
    double graze, margin, offset, separation, max_probes;
    bool offset_given, separation_given;
    int64_t rounds;
};

static const double *positions(const struct stream *stream)
{
    return column_f64(table_column(stream_table(stream, "probe"), "position"));
}

static struct error *check_stream(const struct stream *stream)
{
    struct cells cells;
    if (!stream_table(stream, "probe"))
        return error_new("there are no cells: run probe-tet");
    return cells_find(stream, &cells);
}

/* The stream's cells, as leaks are looked for in them. */
static struct error *mesh_of(const struct stream *stream, struct leak_mesh *mesh)
{
    struct cells cells;
    struct error *err = cells_find(stream, &cells);
    if (err)
        return err;
    *mesh = (struct leak_mesh){.probe_count = stream_table(stream, "probe")->rows,
                               .position = positions(stream),
                               .corners = cells.corners,
                               .cell_count = cells.table->rows,
                               .vertex = cells.vertex};
    return NULL;
}

static struct error *choose_settings(const struct arguments *a, const struct stream *stream,
                                     int threads, struct leak_settings *settings)
{
    struct leak_mesh mesh;
    struct error *err = mesh_of(stream, &mesh);
    if (!err)
        err = leak_settings_for(settings, &mesh);
    settings->graze = a->graze;
    settings->margin = a->margin;
    settings->offset = a->offset_given ? a->offset : settings->offset;
    settings->separation = a->separation_given ? a->separation : settings->separation;
    settings->threads = threads;
    return err;
}

/* Finds leaks, and the probes that would mend them, but for those that would stand inside
 * solids. */
static struct error *find(struct leaks *leaks, const struct stage *stage,
                          const struct leak_settings *settings, const struct stream *stream)
{
    struct place_inside_settings inside_settings = place_inside_default();
    bool *inside = NULL;
    leaks_clear(leaks);
    struct leak_mesh mesh;
    struct error *err = mesh_of(stream, &mesh);
    if (!err)
        err = leak_find(leaks, stage->tracer, settings, &mesh);
    if (err || !leaks->probe_count)
        return err;
    inside_settings.threads = settings->threads;
    const struct place place = {.position = leaks->probe, .count = leaks->probe_count};
    err = array_create(&inside, leaks->probe_count, sizeof *inside);
    if (!err)
        err = place_inside(&place, stage->tracer, &inside_settings, inside, NULL);
    size_t kept = 0;
    for (size_t i = 0; i < leaks->probe_count && !err; i++)
        if (!inside[i])
            memmove(leaks->probe + 3 * kept++, leaks->probe + 3 * i, 3 * sizeof *leaks->probe);
    leaks->probe_count = kept;
    free(inside);
    return err;
}

/* Adds the probes that the leaks ask for, and makes cells of all. */
static struct error *mend(struct stream *stream, const struct leaks *leaks)
{
    struct table *probes = stream_table(stream, "probe");
    const size_t before = probes->rows;
    struct error *err = table_resize(probes, before + leaks->probe_count);
    if (err)
        return err;
    memcpy(column_f64(table_column(probes, "position")) + 3 * before, leaks->probe,
           3 * leaks->probe_count * sizeof(double));
    return cells_make(stream);
}

static struct error *store_occlusion(struct stream *stream, const struct leaks *leaks)
{
    struct cells cells;
    struct column *occlusion = NULL;
    struct error *err = cells_find(stream, &cells);
    const size_t edges = err ? 0 : (size_t)leak_edges_of(cells.corners);
    if (!edges) /* a single probe has none */
        return err;
    err = table_add_column(cells.table, "occlusion", COLUMN_I32, edges, &occlusion);
    if (!err)
        memcpy(occlusion->data, leaks->cell_edges, edges * cells.table->rows * sizeof(int32_t));
    return err;
}

static void say(const char *program, const char *when, const struct leaks *leaks, size_t probes)
{
    fprintf(stderr,
            "%s: %s: %zu of %zu edges leak (%.2f %%), %zu pass through a surface, %zu probes\n",
            program, when, leaks->leaking, leaks->edges,
            leaks->edges ? 100.0 * (double)leaks->leaking / (double)leaks->edges : 0.0,
            leaks->crossed, probes);
}

/* Rounds of finding and mending, until nothing asks to be mended or a limit is met. program: who
 * says what was found; NULL: nobody. */
static struct error *fix(struct stream *stream, const struct stage *stage,
                         const struct leak_settings *settings, const struct arguments *a,
                         const char *program, struct warnings *warnings)
{
    struct leaks leaks = {0};
    struct error *err = find(&leaks, stage, settings, stream);
    if (!err && program)
        say(program, "before", &leaks, stream_table(stream, "probe")->rows);
    struct leak_settings round_settings = *settings;
    for (int64_t round = 0; !err && leaks.leaking && round < a->rounds; round++) {
        if ((double)(stream_table(stream, "probe")->rows + leaks.probe_count) > a->max_probes) {
            warnings_add(warnings, "max-probes",
                         "%zu more probes would be more than --max-probes %.0f: edges still leak",
                         leaks.probe_count, a->max_probes);
            break;
        }
        if (!leaks.probe_count && round_settings.separation <= 2 * settings->offset)
            break; /* what still leaks has probes as near as they may be */
        if (leaks.probe_count)
            err = mend(stream, &leaks);
        round_settings.separation = fmax(round_settings.separation / 2, 2 * settings->offset);
        if (!err)
            err = find(&leaks, stage, &round_settings, stream);
    }
    if (!err && program)
        say(program, "after", &leaks, stream_table(stream, "probe")->rows);
    if (!err)
        err = store_occlusion(stream, &leaks);
    leaks_clear(&leaks);
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

int main(int argc, char **argv)
{
    struct arguments a = {.graze = 0.1,
                          .margin = 0.1,
                          .offset = NAN,
                          .separation = NAN,
                          .max_probes = 1e6,
                          .rounds = 4};
    const struct option_row rows[] = {
        {.name = "rounds",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &a.rounds,
         .most = 1000,
         .help = "mend at most N times; 0 only counts, and marks the cells"},
        {.name = "graze",
         .argument = "COS",
         .kind = OPTION_REAL,
         .value = &a.graze,
         .most = 1,
         .least = 1e-9,
         .help = "a ray nearer to the surface's plane than this cosine to its normal\n"
                 "only grazes it"},
        {.name = "margin",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &a.margin,
         .most = 0.5,
         .least = 1e-9,
         .help = "no probe where the edge's end is nearer to the wall than this share\n"
                 "of the edge"},
        {.name = "offset",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &a.offset,
         .least_open = true,
         .most = INFINITY,
         .given = &a.offset_given,
         .help = "distance of new probes from the surface (default: 0.05 of the median edge)"},
        {.name = "separation",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &a.separation,
         .least_open = true,
         .most = INFINITY,
         .given = &a.separation_given,
         .help = "in the first round, no new probe nearer than this to one that it sees;\n"
                 "halved in each round (default: 0.5 of the median edge)"},
        {.name = "max-probes",
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &a.max_probes,
         .least = 1,
         .most = INT32_MAX,
         .help = "stop rather than have more probes"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, common_rows(&common, COMMON_STREAM | COMMON_THREADS | COMMON_PROGRESS, shared), NULL};
    struct program program = {
        .name = "probe-leakfix",
        .usage = "[OPTION]... SCENE [STREAM]",
        .summary =
            "Finds edges of the tetrahedra in STREAM (standard input) that pass through walls of "
            "SCENE,\n"
            "puts a probe on each side of the wall, captures it as the others were, and makes the\n"
            "tetrahedra again, until no edge leaks.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct stage stage = {0};
    struct leak_settings settings;
    size_t before = 0;
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = error_wrap(check_stream(stream), "%s", file_input_name(input));
    if (!err)
        err = stage_init(&stage, program.operands[0], &stream->header, &warnings);
    if (!err && stage.other)
        warnings_add(
            &warnings, "scene",
            "%s: this is not the scene that the probes were captured in (its key is %s, theirs %s)",
            program.operands[0], stage.key, stage.captured_key);
    if (!err)
        err = choose_settings(&a, stream, common.threads, &settings);
    if (!err) {
        before = stream_table(stream, "probe")->rows;
        err = fix(stream, &stage, &settings, &a, common.quiet ? NULL : program.name, &warnings);
    }
    if (!err)
        err = capture_new(stream, &stage, before, &common, program.name, &warnings);
    if (!err)
        err = header_add_provenance(&stream->header, program.recorded);
    if (!err)
        err = stream_write(stream, common.output, common.encoding);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    stage_clear(&stage);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
