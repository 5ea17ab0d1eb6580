/* probe-query: the light at points, interpolated between the probes around each. */
#include "array.h"
#include "error.h"
#include "options.h"
#include "points.h"
#include "query.h"
#include "warning.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4096 };

static struct error *answer(struct query *query, struct points *points)
{
    double *value = NULL;
    struct error *err = array_create(&value, 6 * BLOCK, sizeof *value);
    for (size_t got = 1; !err && got;) {
        size_t width = 0;
        err = points_read(points, BLOCK, value, &width, &got);
        if (!err)
            err = query_points(query, points, got, width, value);
    }
    free(value);
    return err;
}

int main(int argc, char **argv)
{
    static const char *const from_formats[] = {"text", "binary", NULL};
    static const char *const to_formats[] = {"text", "binary", "stream", NULL};
    int from = POINTS_TEXT, to = QUERY_TEXT;
    bool normals = false, explain = false;
    const char *column = "sh";
    const struct option_row rows[] = {
        {.name = "from", .argument = "FORMAT", .kind = OPTION_CHOICE, .choices = from_formats, .value = &from,
         .help = "points come as text, one a line, or binary: little-endian doubles,\n3 a point", .unrecorded = true},
        {.name = "normals", .kind = OPTION_FLAG, .value = &normals, .unrecorded = true,
         .help = "binary points have 6 doubles, the last 3 a normal (text tells by itself)"},
        {.name = "to", .argument = "FORMAT", .kind = OPTION_CHOICE, .choices = to_formats, .value = &to,
         .help = "light goes out as text, binary (little-endian floats), or a probe\nstream of the points", .unrecorded = true},
        {.name = "column", .argument = "NAME", .kind = OPTION_TEXT, .value = &column,
         .help = "interpolate this column of the probes"},
        {.name = "explain", .kind = OPTION_FLAG, .value = &explain, .unrecorded = true,
         .help = "with text: add the cell, its four probes and their weights, inside or\noutside of the hull, and the distance from it"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    struct program program = {
        .name = "probe-query",
        .usage = "[OPTION]... BAKED [POINTS]",
        .summary = "Reads points (x y z, or x y z nx ny nz) and writes the light there, interpolated between\n"
                   "the probes of BAKED: the SH coefficients, or for a normal the irradiance (R G B).",
        .groups = {rows, common_rows(&common, COMMON_OUTPUT, shared)},
        .operands_least = 1,
        .operands_most = 2};
    struct stream *stream = NULL;
    struct points *points = NULL;
    struct query *query = NULL;
    struct error *err = options_parse(&program, argc, argv);
    if (!err && explain && to != QUERY_TEXT)
        err = error_usage("--explain needs --to text");
    const char *baked = err ? "-" : program.operands[0];
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err && !strcmp(baked, "-") && !strcmp(input, "-"))
        err = error_usage("the baked stream and the points cannot both come from standard input");
    if (!err)
        err = stream_read(&stream, baked);
    if (!err) {
        const struct query_settings settings = {.column = column, .format = (enum query_format)to, .explain = explain,
                                                .output = common.output, .recorded = program.recorded};
        err = error_wrap(query_open(&query, stream, &settings), "%s", baked);
    }
    if (!err)
        err = points_open(&points, input, (enum points_format)from, normals);
    if (!err)
        err = answer(query, points);
    struct warnings warnings = {0};
    if (!err && query_outside(query))
        warnings_add(&warnings, "outside", "%zu points are outside the hull of the probes: light is that of its nearest point",
                     query_outside(query));
    if (!err && !common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err)
        err = query_finish(query);
    else
        query_abandon(query);
    points_close(points);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
