/* probe-tet: makes the Delaunay tetrahedra of a stream's probes. */
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "stream/cells.h"
#include "stream/stream.h"
#include "tetra/tetra.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct enclose {
    bool wanted;
    double margin; /* share of the box's largest side */
    double bounds[6];
    bool bounds_given;
};

/* The box to enclose: given, or that of the probes grown by the margin. */
static void enclosing_box(const struct enclose *enclose, const struct table *probes, double box[6])
{
    const double *p = column_f64(table_column(probes, "position"));
    double side = 0;
    for (int k = 0; k < 3; k++) {
        box[k] = INFINITY;
        box[3 + k] = -INFINITY;
        for (size_t i = 0; i < probes->rows; i++) {
            box[k] = fmin(box[k], p[3 * i + (size_t)k]);
            box[3 + k] = fmax(box[3 + k], p[3 * i + (size_t)k]);
        }
        side = fmax(side, box[3 + k] - box[k]);
    }
    for (int k = 0; k < 3; k++) {
        box[k] = enclose->bounds_given ? enclose->bounds[k] : box[k] - enclose->margin * side;
        box[3 + k] = enclose->bounds_given ? enclose->bounds[3 + k]
                                           : box[3 + k] + enclose->margin * side;
    }
}

static bool has_probe_at(const struct table *probes, const double corner[3])
{
    const double *p = column_f64(table_column(probes, "position"));
    for (size_t i = 0; i < probes->rows; i++)
        if (p[3 * i] == corner[0] && p[3 * i + 1] == corner[1] && p[3 * i + 2] == corner[2])
            return true;
    return false;
}

/* Adds the corners of the box that are no probes yet; what they lack is missing: light is captured
 * by a second pass. */
static struct error *add_corners(const struct enclose *enclose, struct table *probes)
{
    if (!probes->rows && !enclose->bounds_given)
        return error_new("there are no probes to enclose");
    double box[6];
    enclosing_box(enclose, probes, box);
    struct error *err = NULL;
    for (int corner = 0; corner < 8 && !err; corner++) {
        const double p[3] = {box[corner & 1 ? 3 : 0], box[corner & 2 ? 4 : 1],
                             box[corner & 4 ? 5 : 2]};
        if (has_probe_at(probes, p))
            continue;
        err = table_resize(probes, probes->rows + 1);
        if (!err)
            memcpy(column_f64(table_column(probes, "position")) + 3 * (probes->rows - 1), p,
                   sizeof p);
    }
    return err;
}

/* -- cells ------------------------------------------------------------------------------------ */

struct column_of {
    const char *name;
    int32_t *data;
};

/* Lends the cells to a table of the stream, which would take as much memory again; take_back before
 * either is freed. */
static struct error *lend(struct stream *stream, const struct tetra *tetra)
{
    const struct column_of columns[] = {{"vertex", tetra->vertex}, {"neighbour", tetra->neighbour}};
    struct table *cells = NULL;
    struct error *err = stream_add_table(stream, stream_cell_table[tetra->corners - 1], &cells);
    for (size_t i = 0; i < 2 && !err; i++) {
        struct column *column = NULL;
        err = table_add_column(cells, columns[i].name, COLUMN_I32, (size_t)tetra->corners, &column);
        if (!err) {
            free(column->data);
            column->data = columns[i].data;
        }
    }
    if (!err)
        cells->rows = cells->capacity = tetra->cell_count;
    return err;
}

static void take_back(struct stream *stream, const struct tetra *tetra)
{
    struct table *cells = stream_table(stream, stream_cell_table[tetra->corners - 1]);
    for (size_t i = 0; cells && i < cells->column_count; i++)
        cells->columns[i].data = NULL;
    if (cells)
        cells->rows = cells->capacity = 0;
}

static struct error *write_stream(struct stream *stream, const struct tetra *tetra,
                                  const struct common *common)
{
    struct error *err = lend(stream, tetra);
    if (!err)
        err = stream_write(stream, common->output, (enum stream_encoding)common->encoding);
    take_back(stream, tetra);
    return err;
}

/* What the probes have to say of it: the hull's normals, and which are merged. */
static struct error *store_columns(struct table *probes, const struct tetra *tetra)
{
    struct column *column = NULL;
    struct error *err = table_add_column(probes, "hull_normal", COLUMN_F32, 3, &column);
    if (!err)
        memcpy(column->data, tetra->hull_normal, 3 * probes->rows * sizeof(float));
    if (!err && tetra->merged)
        err = table_add_column(probes, "merged", COLUMN_I32, 1, &column);
    if (!err && tetra->merged)
        memcpy(column->data, tetra->merged, probes->rows * sizeof(int32_t));
    return err;
}

static struct error *build(struct stream *stream, const struct enclose *enclose, double merge,
                           int threads, struct tetra *tetra, struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    struct tetra_settings settings = tetra_settings_default();
    struct error *err = enclose->wanted ? add_corners(enclose, probes) : NULL;
    const struct column *sh = table_column(probes, "sh");
    settings.merge = merge;
    settings.threads = threads;
    settings.light = sh ? column_f32(sh) : NULL;
    settings.light_width = sh ? sh->width : 0;
    cells_remove(stream); /* with what other columns they had: they are untrue now */
    probes = stream_table(stream, "probe");
    if (!err)
        err = tetra_make(tetra, probes->rows, column_f64(table_column(probes, "position")),
                         &settings, warnings);
    return err ? err : store_columns(probes, tetra);
}

/* The stream's own cells, as if they had just been made; borrowed. */
static struct error *cells_of(const struct stream *stream, struct tetra *tetra)
{
    struct cells cells;
    struct column *merged = NULL;
    struct table *probes = stream_table(stream, "probe");
    struct error *err = cells_find(stream, &cells);
    if (!err && !cells.neighbour)
        err = error_new("table %s has no column neighbour", cells.table->name);
    if (!err && table_column(probes, "merged"))
        err = table_require(probes, "merged", COLUMN_I32, 1, &merged);
    if (!err)
        *tetra = (struct tetra){.corners = cells.corners,
                                .cell_count = cells.table->rows,
                                .vertex = cells.vertex,
                                .neighbour = cells.neighbour,
                                .merged = merged ? column_i32(merged) : NULL};
    return err;
}

/* -- what is said of them --------------------------------------------------------------------- */

static const char *const cells_names[] = {"points", "segments", "triangles", "tetrahedra"};
static const char *const content_names[] = {"", "length", "area", "volume"};

static void print_report(const struct tetra_report *r, int corners, size_t probes)
{
    fprintf(stderr,
            "cells           %zu %s\n"
            "probes          %zu, %zu on the hull, %zu merged\n",
            r->cells, cells_names[corners - 1], probes, r->hull_vertices, r->merged_points);
    if (corners == 1)
        return;
    const char *content = content_names[corners - 1];
    fprintf(stderr,
            "hull            %zu %s\n"
            "%-15s %.9g, of the hull %.9g\n"
            "of a cell       %.6g least, %.6g median, %.6g most\n",
            r->hull_facets,
            corners == 2   ? "ends"
            : corners == 3 ? "edges"
                           : "faces",
            content, r->volume, r->hull_volume, r->volume_least, r->volume_median, r->volume_most);
    if (corners == 2)
        return;
    const char *angle = corners == 4 ? "dihedral angle" : "angle";
    fprintf(stderr,
            "%-15s %.4f least, %.4f most (degrees)\n"
            "slivers         %zu cells below 5 degrees, %.4f %%\n"
            "least %s of a cell, in degrees: cells\n",
            angle, r->angle_least, r->angle_most, r->angle_histogram[0],
            100.0 * (double)r->angle_histogram[0] / (double)r->cells, angle);
    for (int i = 0; i < 15; i++)
        if (r->angle_histogram[i])
            fprintf(stderr, "  %2d - %2d  %9zu  %5.2f %%\n", 5 * i, 5 * i + 5,
                    r->angle_histogram[i],
                    100.0 * (double)r->angle_histogram[i] / (double)r->cells);
}

static struct error *report(const struct stream *stream, const struct tetra *tetra)
{
    const struct table *probes = stream_table(stream, "probe");
    struct tetra_report measured;
    struct error *err =
        tetra_measure(tetra, probes->rows, column_f64(table_column(probes, "position")), &measured);
    if (!err)
        print_report(&measured, tetra->corners, probes->rows);
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
                program->name, tetra->cell_count, cells_names[tetra->corners - 1],
                verdict.inner_facets, verdict.not_delaunay, verdict.tolerance, verdict.dents);
    return err;
}

int main(int argc, char **argv)
{
    struct enclose enclose = {.margin = 0.05, .bounds = {NAN}};
    bool verify_only = false, want_report = false;
    double merge = tetra_settings_default().merge;
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
         .value = &merge,
         .most = 1,
         .help = "let one of probes that are nearer to each other than this share of\n"
                 "the box's largest side stand for the others in the cells"},
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
    struct program program = {
        .name = "probe-tet",
        .usage = "[OPTION]... [STREAM]",
        .summary =
            "Makes the Delaunay tetrahedra of the probes in STREAM (standard input) and writes\n"
            "the stream with a table of cells and their neighbours: tet of tetrahedra, or tri of\n"
            "triangles, segment, point where the probes lie in a plane, on a line, at one place.",
        .groups = {rows, common_rows(&common, COMMON_STREAM | COMMON_THREADS, shared)},
        .operands_most = 1};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct tetra tetra = {0}, own = {0}, *cells = &tetra;
    struct error *err = options_parse(&program, argc, argv);
    if (!err && enclose.bounds_given && !enclose.wanted)
        err = error_usage("--bounds needs --enclose");
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    if (!err)
        err = stream_read(&stream, input);
    if (!err && !stream_table(stream, "probe"))
        err = error_new("there is no table probe");
    if (!err && verify_only)
        err = cells_of(stream, cells = &own);
    else if (!err)
        err = build(stream, &enclose, merge, (int)common.threads, &tetra, &warnings);
    if (!err && verify_only)
        err = verify(stream, cells, &program, common.quiet);
    if (stream)
        err = error_wrap(err, "%s", strcmp(input, "-") ? input : "stdin");
    if (!err && want_report)
        err = report(stream, cells);
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
