/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render_options.h"
#include "base/error.h"
#include "base/number.h"
#include "base/options.h"
#include "capture/capture.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

struct render_options render_options_default(void)
{
    return (struct render_options){.shot = {.mode = SHOT_PROBES},
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

/* "960x540" */
static struct error *parse_size(void *value, const char *text)
{
    struct render_options *o = value;
    const char *end = text + strlen(text);
    int32_t width = 0, height = 0;
    const char *at = number_read_i32(text, end, &width);
    at = at && *at == 'x' ? number_read_i32(at + 1, end, &height) : NULL;
    if (at != end || width < 1 || height < 1 || width > PICTURE_SIDE_MOST ||
        height > PICTURE_SIDE_MOST)
        return error_usage("expected WIDTHxHEIGHT, whole numbers from 1 to %d, got '%s'",
                           PICTURE_SIDE_MOST, text);
    o->width = (size_t)width;
    o->height = (size_t)height;
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

struct error *render_options_parse(struct render_options *o, struct program *program, int argc,
                                   char **argv)
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
         .value = &o->output,
         .written = true,
         .unrecorded = true,
         .help = "write the picture to FILE, which appears only when it is whole:\n"
                 "PNG, or PFM where its name ends in .pfm; - is standard\n"
                 "output; with --path, %d or %04d in it is the frame's number"},
        {.name = "pfm",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &o->pfm,
         .written = true,
         .help = "write the linear picture to FILE besides, as PFM"},
        {.name = "mode",
         .letter = 'm',
         .argument = "MODE",
         .kind = OPTION_CHOICE,
         .choices = modes,
         .value = OPTION_ENUM(o->shot.mode),
         .help = "what is shown: the truth; light of the probes alone; mixed:\n"
                 "direct light traced, the rest of the probes; none: direct\n"
                 "light, without the probes; split or pair: truth and probes;\n"
                 "their difference in colours; flip: FLIP's map"},
        {.name = "compare",
         .kind = OPTION_FLAG,
         .value = &o->compare,
         .help = "compare two pictures that are there, in place of a scene"},
        {.name = "eye",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = o->eye,
         .given = &o->eye_given,
         .shown = "a place from which much is seen",
         .help = "where the camera is"},
        {.name = "look-at",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = o->look_at,
         .given = &o->look_at_given,
         .shown = "the scene's centre, where --eye is given",
         .help = "a point in the middle of the picture"},
        {.name = "up",
         .argument = "X,Y,Z",
         .kind = OPTION_REALS,
         .count = 3,
         .value = o->up,
         .help = "the way up"},
        {.name = "fov",
         .argument = "DEGREES",
         .kind = OPTION_REAL,
         .value = &o->fov,
         .least_open = true,
         .most = 179,
         .help = "the picture's height as an angle"},
        {.name = "size",
         .argument = "WxH",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_size,
         .shown = "960x540",
         .help = "pixels"},
        {.name = "samples",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->samples,
         .least = 1,
         .most = 1 << 20,
         .help = "paths a pixel"},
        {.name = "error",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &o->error,
         .least_open = true,
         .most = 1,
         .shown = "none",
         .help = "more rounds of --samples for a pixel until the standard error\n"
                 "of its luminance is below this share of it"},
        {.name = "max-samples",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->max_samples,
         .least = 1,
         .most = 1 << 24,
         .help = "paths a pixel that --error may spend"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->bounces,
         .most = CAPTURE_BOUNCES_MOST,
         .shown = "as the probes were captured, or 64",
         .help = "how often the truth's light may scatter"},
        {.name = "truth",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &o->truth,
         .help = "take the truth from this picture rather than trace it"},
        {.name = "offset",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &o->offset,
         .most = INFINITY,
         .given = &o->offset_given,
         .shown = "0.15 of the probes' median distance",
         .help = "probes are looked up this far off a surface, along its normal"},
        {.name = "exposure",
         .argument = "FACTOR|auto",
         .kind = OPTION_CALL,
         .value = &o->shot.exposure,
         .parse = parse_auto,
         .shown = "auto",
         .help = "from radiance to display colour; auto brings the 95th\n"
                 "percentile of luminance to 0.7"},
        {.name = "tone-map",
         .argument = "CURVE",
         .kind = OPTION_CHOICE,
         .choices = tones,
         .value = OPTION_ENUM(o->shot.tone),
         .help = "clip what is brighter than white, or a filmic curve (ACES)"},
        {.name = "scale",
         .argument = "S|auto",
         .kind = OPTION_CALL,
         .value = &o->shot.scale,
         .parse = parse_auto,
         .shown = "auto",
         .help = "the difference of lightness L* that the ends of the colours\n"
                 "stand for"},
        {.name = "draw-probes",
         .argument = "R|auto",
         .kind = OPTION_CALL,
         .value = &o->draw_probes,
         .parse = parse_auto,
         .shown = "none",
         .help = "draw the probes as spheres of this radius; auto: a tenth of\n"
                 "their distance"},
        {.name = "draw-cells",
         .kind = OPTION_FLAG,
         .value = &o->draw_cells,
         .help = "draw the edges of the cells"},
        {.name = "object",
         .argument = "FILE|sphere",
         .kind = OPTION_TEXT,
         .value = &o->object,
         .shown = "sphere",
         .help = "a thing that stands at each point of --path, lit by the\nprobes at its centre"},
        {.name = "object-radius",
         .argument = "LENGTH",
         .kind = OPTION_REAL,
         .value = &o->object_radius,
         .least_open = true,
         .most = INFINITY,
         .shown = "a mesh as it is, a sphere 3 % of the diagonal",
         .help = "its size"},
        {.name = "path",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &o->path,
         .help = "points x y z, one a line: a frame each"},
        {.name = "per-pixel",
         .kind = OPTION_FLAG,
         .value = &o->per_pixel,
         .help = "look probes up at each point of the object"},
        {0}};
    struct option_row how[INTERPOLATE_OPTIONS_ROWS], scene[SCENE_SETTINGS_ROWS],
        shared[COMMON_ROWS];
    const struct option_row visible[] = {interpolate_visible_row(&o->visible), {0}};
    const struct option_row *const groups[] = {
        rows,
        interpolate_options_rows(&o->how, how),
        visible,
        scene_settings_rows(&o->scene, scene),
        common_rows(&o->common, COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS, shared),
        NULL};
    struct error *err = options_parse(program, groups, argc, argv);
    if (err)
        return err;
    if (o->compare && program->operand_count != 2)
        return error_usage("--compare needs two pictures: the truth, and what is held against it");
    if (!o->compare && !o->output && !o->pfm)
        return error_usage("expected --output FILE or --pfm FILE");
    if ((o->object || o->per_pixel || o->object_radius > 0) && !o->path)
        return error_usage("--object, --object-radius and --per-pixel need --path");
    if (o->look_at_given && !o->eye_given)
        return error_usage("--look-at needs --eye");
    if (o->truth && (!shot_compares(o->shot.mode) || o->path))
        return error_usage(
            "--truth is for the modes split, pair, difference and flip, without --path");
    return interpolate_options_check(&o->how);
}

struct error *render_options_take_over(struct render_options *o, struct program *program,
                                       const struct stream_header *header, int argc, char **argv)
{
    struct capture_settings capture = capture_settings_default();
    scene_settings_clear(&o->scene);
    program_clear(program);
    *o = render_options_default();
    struct error *err = capture_settings_from_header(&capture, header);
    if (!err)
        err = scene_settings_from_header(&o->scene, header);
    o->bounces = capture.bounces;
    o->shot.test = capture.light == CAPTURE_INDIRECT ? RENDER_MIXED : RENDER_PROBES;
    o->shot.truth = capture.light == CAPTURE_DIRECT ? RENDER_DIRECT : RENDER_TRUTH;
    if (!err)
        err = render_options_parse(o, program, argc, argv);
    if (!err && o->shot.mode == SHOT_MIXED && capture.light != CAPTURE_INDIRECT)
        err = error_new("the probes hold direct light already: --mode mixed needs probes captured "
                        "with --light indirect");
    return err;
}

bool render_options_by_probes(const struct render_options *o)
{
    return o->shot.mode != SHOT_TRUTH && o->shot.mode != SHOT_NONE;
}

bool render_options_show_probes(const struct render_options *o)
{
    return render_options_by_probes(o) || !isnan(o->draw_probes) || o->draw_cells;
}

void render_options_clear(struct render_options *o)
{
    scene_settings_clear(&o->scene);
}
