/* probe-render: pictures of a scene, by its true light and by that of its probes. */
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "base/options.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "import/import_scene.h"
#include "interpolate/baked.h"
#include "interpolate/interpolate_options.h"
#include "render/film.h"
#include "render/shot.h"
#include "render/view.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"
#include "stream/stream.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct arguments {
    struct shot_settings shot;
    const char *output, *pfm, *truth, *object, *path;
    bool compare;
    double eye[3], look_at[3], up[3], fov;
    bool eye_given, look_at_given;
    size_t width, height;
    int samples, max_samples, bounces;
    double error, offset, object_radius, draw_probes; /* draw_probes: NAN none, 0 automatic */
    bool offset_given, bounces_given, draw_cells, per_pixel;
    struct interpolate_options how;
    struct scene_settings scene;
    struct common common;
};

static struct arguments arguments_default(void)
{
    return (struct arguments){.shot = {.mode = SHOT_PROBES},
                              .up = {0, 1, 0},
                              .fov = 60,
                              .width = 960,
                              .height = 540,
                              .samples = 64,
                              .max_samples = 4096,
                              .bounces = capture_settings_default().bounces,
                              .draw_probes = (double)NAN,
                              .scene = scene_settings_default(),
                              .common = common_default()};
}

/* -- the command line -------------------------------------------------------------------------- */

/* "960x540" */
static struct error *parse_size(void *value, const char *text)
{
    struct arguments *a = value;
    const char *end = text + strlen(text);
    int32_t width = 0, height = 0;
    const char *at = number_read_i32(text, end, &width);
    at = at && *at == 'x' ? number_read_i32(at + 1, end, &height) : NULL;
    if (at != end || width < 1 || height < 1 || width > PICTURE_SIDE_MOST ||
        height > PICTURE_SIDE_MOST)
        return error_usage("expected WIDTHxHEIGHT, whole numbers from 1 to %d, got '%s'",
                           PICTURE_SIDE_MOST, text);
    a->width = (size_t)width;
    a->height = (size_t)height;
    return NULL;
}

/* A number above 0, or "auto", which is 0. */
static struct error *parse_auto(void *value, const char *text)
{
    double *number = value;
    *number = 0;
    if (!strcmp(text, "auto"))
        return NULL;
    struct error *err = options_real("the value", text, number);
    return err || *number > 0 ? err
                              : error_usage("expected a number above 0, or auto, got '%s'", text);
}

static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    static const char *const modes[] = {[SHOT_TRUTH] = "truth",
                                        [SHOT_PROBES] = "probes",
                                        [SHOT_MIXED] = "mixed",
                                        [SHOT_NONE] = "none",
                                        [SHOT_SPLIT] = "split",
                                        [SHOT_PAIR] = "pair",
                                        [SHOT_DIFFERENCE] = "difference",
                                        [SHOT_FLIP] = "flip",
                                        NULL};
    static const char *const tones[] = {[DISPLAY_CLIP] = "clip", [DISPLAY_FILMIC] = "filmic", NULL};
    const struct option_row rows[] = {
        {.name = "output",
         .letter = 'o',
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->output,
         .unrecorded = true,
         .help = "write the picture to FILE, which appears only when it is whole:\n"
                 "PNG, or PFM where its name ends in .pfm; - is standard\n"
                 "output; with --path, %d or %04d in it is the frame's number"},
        {.name = "pfm",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->pfm,
         .help = "write the linear picture to FILE besides, as PFM"},
        {.name = "mode",
         .letter = 'm',
         .argument = "MODE",
         .kind = OPTION_CHOICE,
         .choices = modes,
         .value = OPTION_ENUM(a->shot.mode),
         .help = "what is shown: the truth; light of the probes alone; mixed:\n"
                 "direct light traced, the rest of the probes; none: direct\n"
                 "light, without the probes; split or pair: truth and probes;\n"
                 "their difference in colours; flip: FLIP's map"},
        {.name = "compare",
         .kind = OPTION_FLAG,
         .value = &a->compare,
         .help = "compare two pictures that are there, in place of a scene"},
        {.name = "eye",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = a->eye,
         .given = &a->eye_given,
         .shown = "a place from which much is seen",
         .help = "where the camera is"},
        {.name = "look-at",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = a->look_at,
         .given = &a->look_at_given,
         .shown = "the scene's centre, where --eye is given",
         .help = "a point in the middle of the picture"},
        {.name = "up",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = a->up,
         .help = "the way up"},
        {.name = "fov",
         .argument = "DEGREES",
         .kind = OPTION_REAL,
         .value = &a->fov,
         .least_open = true,
         .most = 179,
         .help = "the picture's height as an angle"},
        {.name = "size",
         .argument = "WxH",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_size,
         .shown = "960x540",
         .help = "pixels"},
        {.name = "samples",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a->samples,
         .least = 1,
         .most = 1 << 20,
         .help = "paths a pixel"},
        {.name = "error",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &a->error,
         .least_open = true,
         .most = 1,
         .shown = "none",
         .help = "more rounds of --samples for a pixel until the standard error\n"
                 "of its luminance is below this share of it"},
        {.name = "max-samples",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a->max_samples,
         .least = 1,
         .most = 1 << 24,
         .help = "paths a pixel that --error may spend"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a->bounces,
         .most = CAPTURE_BOUNCES_MOST,
         .given = &a->bounces_given,
         .shown = "as the probes were captured, or 64",
         .help = "how often the truth's light may scatter"},
        {.name = "truth",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->truth,
         .help = "take the truth from this picture rather than trace it"},
        {.name = "offset",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &a->offset,
         .most = INFINITY,
         .given = &a->offset_given,
         .shown = "0.15 of the probes' median distance",
         .help = "probes are looked up this far off a surface, along its normal"},
        {.name = "exposure",
         .argument = "FACTOR|auto",
         .kind = OPTION_CALL,
         .value = &a->shot.exposure,
         .parse = parse_auto,
         .shown = "auto",
         .help = "from radiance to display colour; auto brings the 95th\n"
                 "percentile of luminance to 0.7"},
        {.name = "tone-map",
         .argument = "CURVE",
         .kind = OPTION_CHOICE,
         .choices = tones,
         .value = OPTION_ENUM(a->shot.tone),
         .help = "clip what is brighter than white, or a filmic curve (ACES)"},
        {.name = "scale",
         .argument = "S|auto",
         .kind = OPTION_CALL,
         .value = &a->shot.scale,
         .parse = parse_auto,
         .shown = "auto",
         .help = "the difference of lightness L* that the ends of the colours\n"
                 "stand for"},
        {.name = "draw-probes",
         .argument = "R|auto",
         .kind = OPTION_CALL,
         .value = &a->draw_probes,
         .parse = parse_auto,
         .shown = "none",
         .help = "draw the probes as spheres of this radius; auto: a tenth of\n"
                 "their distance"},
        {.name = "draw-cells",
         .kind = OPTION_FLAG,
         .value = &a->draw_cells,
         .help = "draw the edges of the cells"},
        {.name = "object",
         .argument = "FILE|sphere",
         .kind = OPTION_TEXT,
         .value = &a->object,
         .shown = "sphere",
         .help = "a thing that stands at each point of --path, lit by the\nprobes at its centre"},
        {.name = "object-radius",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &a->object_radius,
         .least_open = true,
         .most = INFINITY,
         .shown = "a mesh as it is, a sphere 3 % of the diagonal",
         .help = "its size"},
        {.name = "path",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->path,
         .help = "points x y z, one a line: a frame each"},
        {.name = "per-pixel",
         .kind = OPTION_FLAG,
         .value = &a->per_pixel,
         .help = "look probes up at each point of the object"},
        {0}};
    struct option_row how[INTERPOLATE_OPTIONS_ROWS], scene[SCENE_SETTINGS_ROWS],
        shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, interpolate_options_rows(&a->how, how), scene_settings_rows(&a->scene, scene),
        common_rows(&a->common, COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS, shared), NULL};
    struct error *err = options_parse(program, groups, argc, argv);
    if (err)
        return err;
    if (a->compare && program->operand_count != 2)
        return error_usage("--compare needs two pictures: the truth, and what is held against it");
    if (!a->compare && !a->output && !a->pfm)
        return error_usage("expected --output FILE or --pfm FILE");
    if ((a->object || a->per_pixel || a->object_radius > 0) && !a->path)
        return error_usage("--object, --object-radius and --per-pixel need --path");
    if (a->look_at_given && !a->eye_given)
        return error_usage("--look-at needs --eye");
    if (a->truth && (!shot_compares(a->shot.mode) || a->path))
        return error_usage(
            "--truth is for the modes split, pair, difference and flip, without --path");
    return interpolate_options_check(&a->how);
}

/* -- two pictures ------------------------------------------------------------------------------ */

static struct error *compare_files(const struct arguments *a, const char *truth_path,
                                   const char *test_path)
{
    struct picture truth = {0}, test = {0};
    struct shot shot = {0};
    struct shot_settings settings = a->shot;
    if (!shot_compares(settings.mode))
        settings.mode = SHOT_DIFFERENCE;
    settings.truth = RENDER_TRUTH;
    settings.test = RENDER_PROBES;
    struct error *err = picture_read(&truth, truth_path);
    if (!err)
        err = picture_read(&test, test_path);
    if (!err)
        err = shot_compose(&shot, &truth, NULL, &test, &settings, a->common.threads);
    if (!err)
        err = film_write(&shot, a->output, a->pfm);
    if (!err)
        err = film_print(&shot, a->output, NULL);
    picture_clear(&truth);
    picture_clear(&test);
    shot_clear(&shot);
    return err;
}

/* -- a scene ----------------------------------------------------------------------------------- */

/* What the stream says of its light: settings that the command line did not give, and which light
 * its probes hold. */
static struct error *take_over(struct program *program, struct arguments *a,
                               const struct stream_header *header, int argc, char **argv)
{
    struct capture_settings capture = capture_settings_default();
    scene_settings_clear(&a->scene);
    program_clear(program);
    *a = arguments_default();
    struct error *err = capture_settings_from_header(&capture, header);
    if (!err)
        err = scene_settings_from_header(&a->scene, header);
    a->bounces = capture.bounces;
    a->shot.test = capture.light == CAPTURE_INDIRECT ? RENDER_MIXED : RENDER_PROBES;
    a->shot.truth = capture.light == CAPTURE_DIRECT ? RENDER_DIRECT : RENDER_TRUTH;
    if (!err)
        err = parse(program, a, argc, argv);
    if (!err && a->shot.mode == SHOT_MIXED && capture.light != CAPTURE_INDIRECT)
        err = error_new("the probes hold direct light already: --mode mixed needs probes captured "
                        "with --light indirect");
    return err;
}

static void check_scene(const struct scene *scene, const struct stream_header *header,
                        struct warnings *warnings)
{
    char key[32];
    snprintf(key, sizeof key, "%016" PRIx64, scene_key(scene));
    const char *captured = header_key(header, "scene-key");
    if (captured && strcmp(captured, key))
        warnings_add(warnings, "scene",
                     "%s: the probes were captured in another scene, or with other light in it "
                     "(its key is %s, theirs %s)",
                     scene->path, key, captured);
}

static struct error *aim(const struct arguments *a, const char *program, const struct scene *scene,
                         struct camera *camera)
{
    struct vec3 eye = vec3_load(a->eye), look_at = vec3_load(a->look_at);
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct error *err = NULL;
    if (a->eye_given && !a->look_at_given)
        look_at = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    if (!a->eye_given)
        err = trace_create(&tracer, scene);
    if (!err && !a->eye_given)
        err = path_init(&path, tracer, 2);
    if (!err && !a->eye_given)
        err = view_choose(&path, a->fov, (double)a->width / (double)a->height, &eye, &look_at);
    path_clear(&path);
    trace_destroy(tracer);
    if (!err && !a->eye_given && !a->common.quiet) /* to be kept, or moved on from */
        fprintf(stderr, "%s: --eye %.4g,%.4g,%.4g --look-at %.4g,%.4g,%.4g\n", program, eye.x,
                eye.y, eye.z, look_at.x, look_at.y, look_at.z);
    const struct camera_view view = {.eye = eye,
                                     .look_at = look_at,
                                     .up = vec3_load(a->up),
                                     .fov = a->fov,
                                     .width = a->width,
                                     .height = a->height};
    return err ? err : camera_init(camera, &view);
}

/* The light of the probes everywhere, or that which they have themselves. */
static struct error *open_light(struct baked *baked, const struct stream *stream,
                                const struct arguments *a, bool everywhere)
{
    const struct interpolate_settings settings = interpolate_options_settings(&a->how, "sh");
    struct error *err = everywhere ? baked_open(baked, stream, &settings)
                                   : baked_open_probes(baked, stream);
    return err ? err : baked_complete(baked);
}

/* Fills in what is to be filmed, and films it. */
static struct error *film_scene(struct program *program, struct arguments *a,
                                const char *scene_path, const struct stream *stream,
                                const char *input, struct warnings *warnings)
{
    struct scene *scene = NULL;
    struct baked baked = {0};
    struct camera camera;
    struct picture truth = {0};
    double spacing = 0;
    const bool by_probes = a->shot.mode != SHOT_TRUTH && a->shot.mode != SHOT_NONE,
               draw_probes = !isnan(a->draw_probes);
    const bool light =
        stream && (by_probes || (draw_probes && table_column(stream_table(stream, "probe"), "sh")));
    struct error *err =
        stream && !stream_table(stream, "probe") ? error_new("there is no table probe") : NULL;
    if (!err && light)
        err = open_light(&baked, stream, a, by_probes);
    if (!err && stream)
        err = overlay_spacing(stream, &spacing);
    if (draw_probes && !(a->draw_probes > 0))
        a->draw_probes = 0.1 * spacing;
    err = error_wrap(err, "%s", file_input_name(input));
    if (!err)
        err = scene_read(&scene, scene_path, &a->scene, false, warnings);
    if (!err && stream)
        check_scene(scene, &stream->header, warnings);
    if (!err)
        err = aim(a, program->name, scene, &camera);
    if (!err && a->truth)
        err = picture_read(&truth, a->truth);
    if (!a->common.quiet)
        warnings_print(warnings, program->name);
    warnings_clear(warnings);
    if (!err) {
        const struct render render = {.camera = &camera,
                                      .baked = &baked,
                                      .object = {.first = SIZE_MAX},
                                      .samples = a->samples,
                                      .offset = a->offset_given ? a->offset : 0.15 * spacing,
                                      .error = a->error,
                                      .samples_most = a->max_samples,
                                      .seed = (uint64_t)a->common.seed,
                                      .threads = a->common.threads};
        a->shot.given_truth = a->truth ? &truth : NULL;
        const struct film film = {.render = &render,
                                  .shot = &a->shot,
                                  .scene = scene,
                                  .stream = stream,
                                  .baked = light ? &baked : NULL,
                                  .overlay = {draw_probes ? a->draw_probes : 0, a->draw_cells},
                                  .bounces = a->bounces,
                                  .object = a->object ? a->object : "sphere",
                                  .path = a->path,
                                  .object_radius = a->object_radius,
                                  .per_pixel = a->per_pixel,
                                  .output = a->output,
                                  .pfm = a->pfm,
                                  .program = program->name,
                                  .progress = a->common.progress && !a->common.quiet};
        err = film_take(&film, warnings);
    }
    picture_clear(&truth);
    baked_close(&baked);
    scene_destroy(scene);
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
    struct arguments a = arguments_default();
    struct stream *stream = NULL;
    struct error *err = parse(&program, &a, argc, argv);
    if (!err && a.compare) {
        err = compare_files(&a, program.operands[0], program.operands[1]);
    } else if (!err) {
        const char *scene = program.operands[0],
                   *input = program.operand_count > 1 ? program.operands[1] : "-";
        const bool probes = (a.shot.mode != SHOT_TRUTH && a.shot.mode != SHOT_NONE) ||
                            !isnan(a.draw_probes) || a.draw_cells;
        if (probes || program.operand_count > 1) { /* the truth alone needs no stream */
            err = stream_read(&stream, input);
            if (!err)
                err = error_wrap(take_over(&program, &a, &stream->header, argc, argv), "%s",
                                 file_input_name(input));
        }
        if (!err)
            err = film_scene(&program, &a, scene, stream, input, &warnings);
    }
    if (!err && !a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    stream_destroy(stream);
    scene_settings_clear(&a.scene);
    program_clear(&program);
    return error_exit(program.name, err);
}
