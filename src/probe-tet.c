/* probe-tet: makes the Delaunay tetrahedra of a stream's probes. */
#include "error.h"
#include "options.h"
#include "stream.h"
#include "tetra.h"
#include "warning.h"

#include <math.h>
#include <stdio.h>
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
        box[3 + k] = enclose->bounds_given ? enclose->bounds[3 + k] : box[3 + k] + enclose->margin * side;
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

/* Adds the corners of the box that are no probes yet; what they lack is missing: light is captured by a second pass. */
static struct error *add_corners(const struct enclose *enclose, struct table *probes)
{
    if (!probes->rows && !enclose->bounds_given)
        return error_new("there are no probes to enclose");
    double box[6];
    enclosing_box(enclose, probes, box);
    struct error *err = NULL;
    for (int corner = 0; corner < 8 && !err; corner++) {
        const double p[3] = {box[corner & 1 ? 3 : 0], box[corner & 2 ? 4 : 1], box[corner & 4 ? 5 : 2]};
        if (has_probe_at(probes, p))
            continue;
        err = table_resize(probes, probes->rows + 1);
        if (!err)
            memcpy(column_f64(table_column(probes, "position")) + 3 * (probes->rows - 1), p, sizeof p);
    }
    return err;
}

/* Puts the cells into table tet, and the hull's normals beside the probes. */
static struct error *store(struct stream *stream, const struct tetra *tetra)
{
    struct table *cells = NULL;
    struct column *column = NULL;
    const size_t bytes = 4 * tetra->cell_count * sizeof(int32_t);
    struct error *err = stream_add_table(stream, "tet", &cells); /* what other columns the old cells had is untrue now */
    if (!err)
        err = table_resize(cells, tetra->cell_count);
    if (!err)
        err = table_add_column(cells, "vertex", COLUMN_I32, 4, &column);
    if (!err)
        memcpy(column->data, tetra->vertex, bytes);
    if (!err)
        err = table_add_column(cells, "neighbour", COLUMN_I32, 4, &column);
    if (!err)
        memcpy(column->data, tetra->neighbour, bytes);
    struct table *probes = stream_table(stream, "probe");
    if (!err)
        err = table_add_column(probes, "hull_normal", COLUMN_F32, 3, &column);
    if (!err)
        memcpy(column->data, tetra->hull_normal, 3 * probes->rows * sizeof(float));
    return err;
}

static struct error *cells_of(const struct stream *stream, const struct table **cells, const int32_t **vertex,
                              const int32_t **neighbour)
{
    struct column *column = NULL;
    *cells = stream_table(stream, "tet");
    if (!*cells)
        return error_new("there is no table tet to check: run probe-tet without --check first");
    struct error *err = table_require(*cells, "vertex", COLUMN_I32, 4, &column);
    *vertex = err ? NULL : column_i32(column);
    if (!err)
        err = table_require(*cells, "neighbour", COLUMN_I32, 4, &column);
    *neighbour = err ? NULL : column_i32(column);
    return err;
}

static void print_report(const struct tetra_report *r, size_t probes)
{
    fprintf(stderr,
            "cells           %zu\n"
            "probes          %zu, %zu on the hull, %zu in no cell\n"
            "hull faces      %zu\n"
            "volume          %.9g, of the hull %.9g\n"
            "cell volume     %.6g least, %.6g median, %.6g most\n"
            "dihedral angle  %.4f least, %.4f most (degrees)\n"
            "least dihedral angle of a cell, in degrees: cells\n",
            r->cells, probes, r->hull_vertices, r->unused_points, r->hull_faces, r->volume, r->hull_volume,
            r->volume_least, r->volume_median, r->volume_most, r->angle_least, r->angle_most);
    for (int i = 0; i < 15; i++)
        if (r->angle_histogram[i])
            fprintf(stderr, "  %2d - %2d  %9zu  %5.2f %%\n", 5 * i, 5 * i + 5, r->angle_histogram[i],
                    100.0 * (double)r->angle_histogram[i] / (double)r->cells);
}

static struct error *report(const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe"), *cells = NULL;
    const int32_t *vertex, *neighbour;
    struct tetra_report measured;
    struct error *err = cells_of(stream, &cells, &vertex, &neighbour);
    if (!err)
        err = tetra_measure(cells->rows, vertex, neighbour, probes->rows,
                            column_f64(table_column(probes, "position")), &measured);
    if (!err)
        print_report(&measured, probes->rows);
    return err;
}

static struct error *check(const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe"), *cells = NULL;
    const int32_t *vertex, *neighbour;
    struct error *err = cells_of(stream, &cells, &vertex, &neighbour);
    return err ? err : tetra_check(cells->rows, vertex, neighbour, probes->rows,
                                   column_f64(table_column(probes, "position")));
}

static struct error *build(struct stream *stream, const struct enclose *enclose, const char *recorded,
                           struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    struct tetra tetra = {0};
    struct error *err = enclose->wanted ? add_corners(enclose, probes) : NULL;
    if (!err)
        err = tetra_build(&tetra, probes->rows, column_f64(table_column(probes, "position")), warnings);
    if (!err)
        err = store(stream, &tetra);
    if (!err)
        err = header_add_provenance(&stream->header, recorded);
    tetra_clear(&tetra);
    return err;
}

int main(int argc, char **argv)
{
    struct enclose enclose = {.margin = 0.05, .bounds = {NAN}};
    bool check_only = false, want_report = false;
    const struct option_row rows[] = {
        {.name = "enclose", .kind = OPTION_FLAG, .value = &enclose.wanted,
         .help = "add the eight corners of the probes' box as probes, to be captured\nby a second pass of probe-capture"},
        {.name = "margin", .argument = "SHARE", .kind = OPTION_REAL, .value = &enclose.margin, .most = 100,
         .help = "with --enclose: grow the box by this share of its largest side"},
        {.name = "bounds", .argument = "X0,Y0,Z0,X1,Y1,Z1", .kind = OPTION_REALS, .count = 6, .value = enclose.bounds,
         .given = &enclose.bounds_given, .help = "with --enclose: this box instead"},
        {.name = "report", .kind = OPTION_FLAG, .value = &want_report, .unrecorded = true,
         .help = "print counts, volumes and angles to standard error"},
        {.name = "check", .kind = OPTION_FLAG, .value = &check_only, .unrecorded = true,
         .help = "check the stream's own cells, write nothing, exit with 1 if they are broken"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    struct program program = {
        .name = "probe-tet",
        .usage = "[OPTION]... [STREAM]",
        .summary = "Makes the Delaunay tetrahedra of the probes in STREAM (standard input) and writes\n"
                   "the stream with a table tet of cells and their neighbours.",
        .groups = {rows, common_rows(&common, COMMON_STREAM, shared)},
        .operands_most = 1};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct error *err = options_parse(&program, argc, argv);
    if (!err && enclose.bounds_given && !enclose.wanted)
        err = error_usage("--bounds needs --enclose");
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    if (!err)
        err = stream_read(&stream, input);
    if (!err && !stream_table(stream, "probe"))
        err = error_new("there is no table probe");
    if (!err)
        err = check_only ? check(stream) : build(stream, &enclose, program.recorded, &warnings);
    if (stream)
        err = error_wrap(err, "%s", strcmp(input, "-") ? input : "stdin");
    if (!err && want_report)
        err = report(stream);
    if (!err && !check_only)
        err = stream_write(stream, common.output, (enum stream_encoding)common.encoding);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
