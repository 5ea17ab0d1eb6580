/* SPDX-License-Identifier: Apache-2.0 */
/* probe-tet: makes the Delaunay tetrahedra of a stream's probes. */
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "stream/cells.h"
#include "stream/common_options.h"
#include "stream/stream.h"
#include "tetra/tetra.h"
#include "tetra/tetra_stream.h"

#include <math.h>
#include <stdio.h>

struct enclose {
    bool wanted;
    double margin; /* share of the box's largest side */
    double bounds[6];
    bool bounds_given;
};

struct dials {
    double merge, thin;
};

static struct error *build(struct stream *stream, const struct enclose *enclose,
                           const struct dials *dials, int threads, struct tetra *tetra,
                           struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    struct tetra_settings settings = tetra_settings_default();
    struct error *err = NULL;
    if (enclose->wanted)
        err =
            tetra_enclose(probes, enclose->bounds_given ? enclose->bounds : NULL, enclose->margin);
    const struct column *sh = table_column(probes, "sh");
    settings.merge = dials->merge;
    settings.thin = dials->thin;
    settings.threads = threads;
    settings.light = sh ? column_f32(sh) : NULL;
    settings.light_width = sh ? sh->width : 0;
    cells_remove(stream); /* with what other columns they had: they are untrue now */
    probes = stream_table(stream, "probe");
    if (!err)
        err = tetra_make(tetra, probes->rows, column_f64(table_column(probes, "position")),
                         &settings, warnings);
    return err ? err : tetra_store(tetra, stream);
}

static struct error *write_stream(struct stream *stream, const struct tetra *tetra,
                                  const struct common *common)
{
    struct error *err = tetra_lend(tetra, stream);
    if (!err)
        err = stream_write(stream, common->output, common->encoding);
    tetra_take_back(tetra, stream);
    return err;
}

/* -- what is said of them --------------------------------------------------------------------- */

static struct error *report(const struct stream *stream, const struct tetra *tetra)
{
    const struct table *probes = stream_table(stream, "probe");
    struct tetra_report measured;
    struct error *err =
        tetra_measure(tetra, probes->rows, column_f64(table_column(probes, "position")), &measured);
    if (!err)
        tetra_report_print(&measured, tetra->corners, probes->rows, stderr);
    return err;
}

static struct error *verify(const struct stream *stream, const struct tetra *tetra,
                            const struct program *program, bool quiet)
{
    const struct table *probes = stream_table(stream, "probe");
    struct tetra_verdict verdict;
    struct error *err =
        tetra_verify(tetra, probes->rows, column_f64(table_column(probes, "position")), &verdict);
    if (!err && !quiet)
        fprintf(stderr,
                "%s: %zu %s are sound; of %zu inner facets %zu are not Delaunay, by at most %.2g "
                "of squared distances; %zu dents in the hull\n",
                program->name, tetra->cell_count, tetra_cells_name(tetra->corners),
                verdict.inner_facets, verdict.not_delaunay, verdict.tolerance, verdict.dents);
    return err;
}

int main(int argc, char **argv)
{
    struct enclose enclose = {.margin = 0.05, .bounds = {NAN}};
    bool verify_only = false, want_report = false;
    struct dials dials = {.merge = tetra_settings_default().merge, .thin = 0.35};
    const struct option_row rows[] = {
        {.name = "enclose",
         .kind = OPTION_FLAG,
         .value = &enclose.wanted,
         .help = "add the eight corners of the probes' box as probes, to be captured\n"
                 "by a second pass of probe-capture"},
        {.name = "margin",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &enclose.margin,
         .most = 100,
         .help = "with --enclose: grow the box by this share of its largest side"},
        {.name = "bounds",
         .argument = "X0,Y0,Z0,X1,Y1,Z1",
         .kind = OPTION_REALS,
         .count = 6,
         .value = enclose.bounds,
         .given = &enclose.bounds_given,
         .help = "with --enclose: this box instead"},
        {.name = "merge",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &dials.merge,
         .most = 1,
         .help = "let one of probes that are nearer to each other than this share of\n"
                 "the box's largest side stand for the others in the cells"},
        {.name = "thin",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &dials.thin,
         .most = 1,
         .help = "make triangles of probes that are off a sheet by at most this share\n"
                 "of their spacing, segments along a line or a walk; 0: never"},
        {.name = "report",
         .kind = OPTION_FLAG,
         .value = &want_report,
         .unrecorded = true,
         .help = "print counts, volumes, slivers and angles to standard error"},
        {.name = "verify",
         .kind = OPTION_FLAG,
         .value = &verify_only,
         .unrecorded = true,
         .help = "check the stream's own cells, write nothing, exit with 1 if they are\nbroken"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, common_rows(&common, COMMON_STREAM | COMMON_THREADS, shared), NULL};
    struct program program = {
        .name = "probe-tet",
        .usage = "[OPTION]... [STREAM]",
        .summary =
            "Makes the Delaunay tetrahedra of the probes in STREAM (standard input) and writes\n"
            "the stream with a table of cells and their neighbours: tet of tetrahedra, or tri of\n"
            "triangles, segment, point where the probes lie in a plane, on a line, at one place.",
        .operands_most = 1};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct tetra tetra = {0}, own = {0};
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err && enclose.bounds_given && !enclose.wanted)
        err = error_usage("--bounds needs --enclose");
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    claim_in_place(input);
    if (!err)
        err = stream_read(&stream, input);
    if (!err && !stream_table(stream, "probe"))
        err = error_new("there is no table probe");
    if (!err && verify_only)
        err = tetra_of_stream(&own, stream);
    else if (!err)
        err = build(stream, &enclose, &dials, common.threads, &tetra, &warnings);
    if (!err && verify_only)
        err = verify(stream, &own, &program, common.quiet);
    if (stream)
        err = error_wrap(err, "%s", file_input_name(input));
    if (!err && want_report)
        err = report(stream, verify_only ? &own : &tetra);
    if (!err && !verify_only)
        err = header_add_provenance(&stream->header, program.recorded);
    if (!err && !verify_only)
        err = write_stream(stream, &tetra, &common);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    tetra_clear(&tetra);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
