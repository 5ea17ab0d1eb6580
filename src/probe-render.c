/* SPDX-License-Identifier: Apache-2.0 */
/* probe-render: pictures of a scene, by its true light and by that of its probes. */
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "render/film.h"
#include "render/render_options.h"
#include "render/scene_film.h"
#include "stream/sight_key.h"
#include "stream/stream.h"

#include <stdio.h>

static struct error *compare_files(const struct render_options *o, const char *truth_path,
                                   const char *test_path)
{
    struct picture truth = {0}, test = {0};
    struct shot shot = {0};
    struct shot_settings settings = o->shot;
    if (!shot_compares(settings.mode))
        settings.mode = SHOT_DIFFERENCE;
    settings.truth = RENDER_TRUTH;
    settings.test = RENDER_PROBES;
    struct error *err = picture_read(&truth, truth_path);
    if (!err)
        err = picture_read(&test, test_path);
    if (!err)
        err = shot_compose(&shot, &truth, NULL, &test, &settings, o->common.threads);
    if (!err)
        err = film_write(&shot, o->output, o->pfm);
    if (!err)
        err = film_print(&shot, o->output, NULL);
    picture_clear(&truth);
    picture_clear(&test);
    shot_clear(&shot);
    return err;
}

/* The view that was chosen: to be kept, or moved on from. */
static void say_view(const char *program, const struct scene_film *film)
{
    const struct vec3 eye = film->eye, look_at = film->look_at;
    fprintf(stderr, "%s: --eye %.4g,%.4g,%.4g --look-at %.4g,%.4g,%.4g\n", program, eye.x, eye.y,
            eye.z, look_at.x, look_at.y, look_at.z);
}

static struct error *film_scene(struct render_options *o, struct program *program, int argc,
                                char **argv, struct warnings *warnings)
{
    struct stream *stream = NULL;
    struct scene_film film = {0};
    struct error *err = NULL;
    const char *input = program->operand_count > 1 ? program->operands[1] : "-";
    const bool probes = program->operand_count > 1 || render_options_show_probes(o);
    if (probes) /* the truth alone needs no stream */
        err = file_inputs_differ(program->operands[0], "the scene", input, "the probes");
    if (!err && probes)
        err = stream_read(&stream, input);
    if (!err && probes)
        err = sight_drop_stale(stream, warnings);
    if (!err && probes)
        err = error_wrap(render_options_take_over(o, program, &stream->header, argc, argv), "%s",
                         file_input_name(input));
    if (!err)
        err = scene_film_init(&film, o, program->operands[0], stream, input, warnings);
    if (film.view_chosen && !o->common.quiet)
        say_view(program->name, &film);
    if (!o->common.quiet)
        warnings_print(warnings, program->name);
    warnings_clear(warnings);
    if (!err)
        err = scene_film_take(&film, o, stream, program->name, warnings);
    scene_film_clear(&film);
    stream_destroy(stream);
    return err;
}

int main(int argc, char **argv)
{
    struct program program = {
        .name = "probe-render",
        .usage = "[OPTION]... -o FILE SCENE [BAKED]\n"
                 "       probe-render --compare [OPTION]... [-o FILE] PICTURE PICTURE",
        .summary = "Takes a picture of SCENE, lit by the probes of BAKED (standard input) or by "
                   "its true light,\n"
                   "and says how far the one is from the other.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct render_options o = render_options_default();
    struct error *err = render_options_parse(&o, &program, argc, argv);
    if (!err && o.compare)
        err = compare_files(&o, program.operands[0], program.operands[1]);
    else if (!err)
        err = film_scene(&o, &program, argc, argv, &warnings);
    if (!err && !o.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    render_options_clear(&o);
    program_clear(&program);
    return error_exit(program.name, err);
}
