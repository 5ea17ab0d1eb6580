/* SPDX-License-Identifier: Apache-2.0 */
/* probe-export: writes what was baked in formats of other programs. */
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "export/export_mesh.h"
#include "stream/common_options.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The formats, by the first operand. */
static const struct format {
    const char *name;
    struct error *(*write)(const struct export_mesh *mesh, const char *path);
} formats[] = {{"glb", export_glb}, {"ply", export_ply}};

struct arguments {
    const char *colour;
    double scale; /* NAN: not given */
    struct common common;
};

static struct error *find_format(const char *name, const struct format **format)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (!strcmp(formats[i].name, name)) {
            *format = &formats[i];
            return NULL;
        }
    return error_usage("expected a format glb or ply, got '%s'", name);
}

static void warn(const struct export_mesh *mesh, struct warnings *warnings)
{
    if (mesh->clipped)
        warnings_add(warnings, "clipped",
                     "%zu of %zu vertices are beyond 0 to 1 and clipped (--scale)", mesh->clipped,
                     mesh->vertices);
    if (mesh->unknown)
        warnings_add(warnings, "unknown", "%zu of %zu vertices have no value: black", mesh->unknown,
                     mesh->vertices);
}

static struct error *export_stream(const struct arguments *a, const struct program *program,
                                   struct warnings *warnings)
{
    const char *input = program->operand_count > 1 ? program->operands[1] : "-";
    const struct format *format = NULL;
    struct stream *stream = NULL;
    struct export_mesh mesh = {0};
    struct error *err = find_format(program->operands[0], &format);
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = error_wrap(export_mesh_make(&mesh, stream, a->colour, a->scale), "%s",
                         file_input_name(input));
    if (!err)
        err = format->write(&mesh, a->common.output);
    if (!err && !a->common.quiet)
        fprintf(stderr,
                "%s: %zu vertices, %zu triangles in %zu parts, colours are values times %g\n",
                program->name, mesh.vertices, mesh.triangles, mesh.parts, mesh.scale);
    if (!err)
        warn(&mesh, warnings);
    export_mesh_clear(&mesh);
    stream_destroy(stream);
    return err;
}

int main(int argc, char **argv)
{
    struct arguments a = {.scale = NAN, .common = common_default()};
    const struct option_row rows[] = {
        {.name = "colour",
         .argument = "COLUMN",
         .kind = OPTION_TEXT,
         .value = &a.colour,
         .shown = "irradiance, or else ao",
         .help = "the colour of vertices: a column of one or three values"},
        {.name = "scale",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &a.scale,
         .least_open = true,
         .most = INFINITY,
         .shown = "1; of light, 99 of 100 vertices are at most 1",
         .help = "multiply values by X; beyond 1 they are clipped"},
        {0}};
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {rows, common_rows(&a.common, COMMON_OUTPUT, shared),
                                               NULL};
    struct program program = {
        .name = "probe-export",
        .usage = "glb|ply [OPTION]... [STREAM]",
        .summary = "Writes the faces between the probes of STREAM (standard input) with their "
                   "light as colours of\n"
                   "vertices: binary glTF, or PLY.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = export_stream(&a, &program, &warnings);
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    program_clear(&program);
    return error_exit(program.name, err);
}
