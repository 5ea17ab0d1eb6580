/* SPDX-License-Identifier: Apache-2.0 */
/* probe-vtk: writes probes, tetrahedra and the scene for ParaView. */
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_told.h"
#include "stream/sight_key.h"
#include "stream/stream.h"
#include "vtk/vtk_export.h"
#include "vtk/vtk_probes.h"
#include "vtk/vtk_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct vtk_options {
    const char *output, *scene, *scene_output;
    struct scene_settings given; /* how the scene's file is read */
    double exposure;
    enum vtk_encoding encoding;
    bool quiet;
};

/* The scene with the settings of the bake; its sky is no surface. */
static struct error *read_scene(struct scene **scene, const char *path,
                                struct scene_settings *settings, const struct stream_header *header,
                                struct warnings *warnings)
{
    struct error *err = scene_settings_from_header(settings, header);
    free(settings->sky_file);
    settings->sky_file = NULL;
    return err ? err : scene_read(scene, path, settings, false, warnings);
}

/* FILE.vtu gives FILE.scene.vtp. */
static struct error *scene_name(const char *output, char **name)
{
    const size_t length = strlen(output);
    const size_t stem = length > 4 && !strcmp(output + length - 4, ".vtu") ? length - 4 : length;
    if (asprintf(name, "%.*s.scene.vtp", (int)stem, output) >= 0)
        return NULL;
    *name = NULL;
    return error_memory();
}

static struct error *check_options(const struct vtk_options *o)
{
    if (!o->output)
        return error_usage("expected --output FILE.vtu");
    if ((o->given.lenient || o->given.choice.count) && !o->scene)
        return error_usage("--lenient, --exclude and --only need --scene");
    if (o->scene_output && !o->scene)
        return error_usage("--scene-output needs --scene");
    if (o->scene && !o->scene_output && !strcmp(o->output, "-"))
        return error_usage("--scene needs --scene-output where the output is standard output");
    if (o->scene_output && !strcmp(o->output, o->scene_output))
        return error_usage("--scene-output and --output are the same: %s", o->output);
    return NULL;
}

/* Everything is read and made before anything is written. */
static struct error *run(struct vtk_options *o, const char *input, struct warnings *warnings)
{
    struct stream *stream = NULL;
    struct scene *scene = NULL;
    struct vtk_probes cells = {0};
    struct vtk_scene surface = {0};
    char *name = NULL;
    struct error *err = stream_read(&stream, input);
    if (!err)
        err = sight_drop_stale(stream, warnings);
    if (!err && o->scene)
        err = read_scene(&scene, o->scene, &o->given, &stream->header, warnings);
    if (!err)
        err = scene_told_in(warnings, &stream->header, o->quiet);
    if (!err) /* which borrows the header, from here on as it is */
        err = error_wrap(vtk_probes_init(&cells, stream, o->exposure, warnings), "%s",
                         file_input_name(input));
    if (!err && o->scene)
        err = error_wrap(vtk_scene_init(&surface, scene), "%s", o->scene);
    if (!err && o->scene && !o->scene_output)
        err = scene_name(o->output, &name);
    if (!err)
        err = vtk_export_grid(o->output, &cells.mesh, o->encoding);
    if (!err && o->scene)
        err = vtk_export_surface(name ? name : o->scene_output, &surface.mesh, o->encoding);
    free(name);
    vtk_scene_clear(&surface);
    scene_destroy(scene);
    vtk_probes_clear(&cells);
    stream_destroy(stream);
    return err;
}

int main(int argc, char **argv)
{
    struct vtk_options options = {.encoding = VTK_EXPORT_BASE64, .given = scene_settings_default()};
    struct option_row of_file[SCENE_FILE_ROWS];
    const struct option_row rows[] = {
        {.name = "output",
         .letter = 'o',
         .argument = "FILE.vtu",
         .kind = OPTION_TEXT,
         .value = &options.output,
         .written = true,
         .help = "write the probes and tetrahedra to FILE.vtu, which appears only when it is\n"
                 "whole (required); - is standard output"},
        {.name = "scene",
         .argument = "SCENE",
         .kind = OPTION_TEXT,
         .value = &options.scene,
         .shown = "",
         .help = "write the scene's surface as well"},
        {.name = "scene-output",
         .argument = "FILE.vtp",
         .kind = OPTION_TEXT,
         .value = &options.scene_output,
         .written = true,
         .shown = "FILE.scene.vtp",
         .help = "where the surface goes"},
        {.name = "exposure",
         .argument = "FACTOR",
         .kind = OPTION_REAL,
         .value = &options.exposure,
         .least = 0,
         .least_open = true,
         .most = INFINITY,
         .shown = "automatic",
         .help = "from irradiance to display colour; automatic brings the 95th percentile of\n"
                 "luminance to 0.7"},
        {.name = "compress",
         .kind = OPTION_SET,
         .value = OPTION_ENUM(options.encoding),
         .count = VTK_EXPORT_COMPRESSED,
         .help = "compress the arrays with zlib"},
        {.name = "text",
         .kind = OPTION_SET,
         .value = OPTION_ENUM(options.encoding),
         .count = VTK_EXPORT_TEXT,
         .help = "write numbers as text"},
        {.name = "quiet",
         .letter = 'q',
         .kind = OPTION_FLAG,
         .value = &options.quiet,
         .help = "no warnings"},
        {0}};
    const struct option_row *const groups[] = {rows, scene_file_rows(&options.given, of_file),
                                               NULL};
    struct program program = {
        .name = "probe-vtk",
        .usage = "[OPTION]... -o FILE.vtu [STREAM]",
        .summary = "Writes the probes and tetrahedra of STREAM (standard input) for ParaView: "
                   "every column as a\n"
                   "named array, luminance and its gradients, quality and leaks of the cells.",
        .operands_most = 1};
    struct warnings warnings = {0};
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err)
        err = check_options(&options);
    if (!err)
        err = run(&options, program.operand_count ? program.operands[0] : "-", &warnings);
    if (!options.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    scene_settings_clear(&options.given);
    program_clear(&program);
    return error_exit(program.name, err);
}
