/* SPDX-License-Identifier: Apache-2.0 */
/* probe-query: the light at points, interpolated between the probes around each. */
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "capture/stage.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/interpolate_options.h"
#include "interpolate/occluders.h"
#include "interpolate/query.h"
#include "scene/relit.h"
#include "scene/scene_settings.h"
#include "stream/common_options.h"
#include "stream/points.h"
#include "stream/sight_key.h"
#include "stream/stream.h"
#include "trace/seen.h"

#include <stdlib.h>
#include <string.h>

struct arguments {
    struct interpolate_options how; /* outside: an enum query_outside */
    enum points_format from;
    enum query_format to;
    enum probe_packing pack;
    enum interpolate_visible visible;
    bool normals, explain, groups, transfer;
    const char *column, *along, *scene, *occluders;
};

/* What --visible rays looks through. */
struct sight {
    struct stage stage;
    struct seen *seen;
};

static struct error *open_sight(struct sight *sight, struct interpolate *in,
                                const struct arguments *a, struct warnings *warnings)
{
    struct stage *stage = &sight->stage;
    struct scene_settings given = scene_settings_default();
    if (!in->stream)
        return error_new("a packed file does not say how its scene is read: --visible rays needs "
                         "a stream");
    /* what light became of the scene's is no matter, as that below 0, which cannot be traced */
    struct stream_header header = {0};
    struct error *err = header_copy(&header, &in->stream->header);
    relit_remove(&header);
    if (!err)
        err = stage_init(stage, a->scene, &header, &given, warnings);
    header_clear(&header);
    if (!err && stage->other)
        err = error_new("%s: this is not the scene that the probes were captured in (its key is "
                        "%s, theirs %s)",
                        a->scene, stage->key, stage->captured_key);
    return err ? err
               : seen_join(&sight->seen, stage->tracer, stream_table(in->stream, "probe")->rows,
                           in);
}

/* Points of a file of fewer bytes come to few cells: of a packed file, no others are made ready. */
enum { FEW = 1 << 20 };

/* input: the points. */
static struct error *open_baked(struct interpolate **in, struct stream **stream, const char *path,
                                const char *input, const struct arguments *a,
                                struct warnings *warnings)
{
    struct interpolate_settings settings = interpolate_options_settings(&a->how, a->column);
    settings.along = a->along;
    settings.outside |= interpolate_visible_flags(a->visible);
    settings.outside |= file_is_small(input, FEW) ? PROBE_LAZY : 0;
    if (interpolate_is_packed(path) && a->along)
        return error_new("%s: a packed file has no column %s", path, a->along);
    if (interpolate_is_packed(path))
        return interpolate_open_packed(in, path, &settings);
    struct error *err = stream_read(stream, path);
    if (!err)
        err = sight_drop_stale(*stream, warnings);
    return err ? err : error_wrap(interpolate_open(in, *stream, &settings), "%s", path);
}

static struct error *write_packed(const struct interpolate *in, const struct arguments *a,
                                  const char *path)
{
    struct file_output out;
    char *image;
    size_t size = 0;
    const unsigned parts = (a->groups ? INTERPOLATE_GROUPS : 0) |
                           (a->transfer ? INTERPOLATE_TRANSFER : 0);
    struct error *err = interpolate_pack(in, a->pack, parts, &size, NULL);
    if (!err)
        err = file_output_open(&out, path, true);
    if (err)
        return err;
    err = file_output_room(&out, size, &image);
    if (!err)
        err = interpolate_pack(in, a->pack, parts, &size, image);
    if (!err) {
        out.count += size;
        return file_output_finish(&out);
    }
    file_output_abandon(&out);
    return err;
}

/* What light points outside of the hull have got. */
static const char *light_outside(const struct interpolate *in, enum query_outside outside)
{
    if (outside == QUERY_ZERO)
        return "they have no light";
    if (in->volume && probe_volume_extends(in->volume))
        return "their light goes on from the hull along rays";
    if (outside != QUERY_EXTEND || !in->volume)
        return "their light is that of the hull's nearest point";
    return probe_volume_corners(in->volume) < 4
               ? "the probes are in a plane or on a line, so their light is that of the nearest "
                 "point there"
               : "no middle sees all of it, so their light is that of its nearest point";
}

/* Spheres hide what comes from where they are: of light by direction. */
static struct error *open_occluders(struct occluders **occluders, const struct interpolate *in,
                                    const struct arguments *a)
{
    if (!in->order || in->convolved)
        return error_new("--occluders takes radiance as SH, column sh: %s",
                         in->order ? "these are of irradiance (probe-cat --content radiance)"
                                   : "this has none");
    return occluders_read(occluders, a->occluders);
}

static struct error *answer(struct interpolate *in, const struct arguments *a, const char *input,
                            const struct common *common, const struct program *program,
                            struct warnings *warnings)
{
    struct query_settings settings = {.format = a->to,
                                      .outside = (enum query_outside)a->how.outside,
                                      .explain = a->explain,
                                      .threads = common->threads,
                                      .output = common->output,
                                      .recorded = program->recorded};
    struct query *query = NULL;
    struct points *points = NULL;
    struct sight sight = {0};
    struct occluders *occluders = NULL;
    struct error *err = a->occluders ? open_occluders(&occluders, in, a) : NULL;
    settings.occluders = occluders;
    if (!err && a->visible == INTERPOLATE_VISIBLE_RAYS)
        err = open_sight(&sight, in, a, warnings);
    if (!err)
        err = query_open(&query, in, &settings);
    if (!err)
        err = points_open(&points, input, a->along ? POINTS_TIMES : POINTS_PLACES, a->from,
                          a->normals);
    if (!err)
        err = query_run(query, points);
    if (!err && query_outside(query) && a->along)
        warnings_add(warnings, "outside",
                     "%zu points are before the first probe or behind the "
                     "last: %s",
                     query_outside(query),
                     settings.outside == QUERY_ZERO ? "they have no light"
                                                    : "their light is that end's");
    else if (!err && query_outside(query) && interpolate_of_surfaces(in))
        warnings_add(warnings, "outside", "%zu points are covered by no disc: %s",
                     query_outside(query),
                     settings.outside == QUERY_ZERO
                         ? "they have no light"
                         : "their light is that of the disc whose rim is nearest for its size");
    else if (!err && query_outside(query))
        warnings_add(warnings, "outside", "%zu points are outside the hull of the probes: %s",
                     query_outside(query), light_outside(in, settings.outside));
    if (!err)
        points_warn_end(points, warnings);
    if (!err && !common->quiet)
        warnings_print(warnings, program->name);
    points_close(points);
    seen_destroy(sight.seen);
    stage_clear(&sight.stage);
    if (!err)
        err = query_finish(query);
    else
        query_abandon(query);
    occluders_destroy(occluders);
    return err;
}

int main(int argc, char **argv)
{
    static const char *const from_formats[] = {
        [POINTS_TEXT] = "text", [POINTS_BINARY] = "binary", NULL};
    static const char *const to_formats[] = {
        [QUERY_TEXT] = "text", [QUERY_BINARY] = "binary", [QUERY_STREAM] = "stream", NULL};
    static const char *const outsides[] = {
        [QUERY_AUTO] = "auto", [QUERY_EXTEND] = "extend", [QUERY_NEAREST] = "nearest",
        [QUERY_ZERO] = "zero", [QUERY_ERROR] = "error",   NULL};
    static const char *const packings[] = {
        [PROBE_PACK_FLOAT] = "float", [PROBE_PACK_HALF] = "half", NULL};
    struct arguments a = {.from = POINTS_TEXT, .to = QUERY_TEXT, .column = "sh"};
    bool pack = false;
    const struct option_row rows[] = {
        {.name = "from",
         .argument = "FORMAT",
         .kind = OPTION_CHOICE,
         .choices = from_formats,
         .value = OPTION_ENUM(a.from),
         .help = "points come as text, one a line, or binary: little-endian doubles,\n"
                 "3 a point",
         .unrecorded = true},
        {.name = "normals",
         .kind = OPTION_FLAG,
         .value = &a.normals,
         .unrecorded = true,
         .help = "binary points have 6 doubles, the last 3 a normal (text tells by itself)"},
        {.name = "to",
         .argument = "FORMAT",
         .kind = OPTION_CHOICE,
         .choices = to_formats,
         .value = OPTION_ENUM(a.to),
         .help = "light goes out as text, binary (little-endian floats), or a probe\n"
                 "stream of the points",
         .unrecorded = true},
        {.name = "column",
         .argument = "NAME",
         .kind = OPTION_TEXT,
         .value = &a.column,
         .help = "interpolate this column of the probes"},
        {.name = "along",
         .argument = "NAME",
         .kind = OPTION_TEXT,
         .value = &a.along,
         .shown = "none",
         .help = "points are numbers of this column (time, of probe-place path), t or\n"
                 "t nx ny nz, and light is between that of the probes before and behind"},
        {0}};
    struct option_row how[INTERPOLATE_OPTIONS_ROWS];
    const struct option_row more[] = {
        interpolate_visible_row(&a.visible),
        {.name = "scene",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a.scene,
         .shown = "none",
         .help = "the scene that --visible rays looks through"},
        {.name = "occluders",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a.occluders,
         .shown = "none",
         .help = "spheres (X Y Z RADIUS a line) that hide light from the points"},
        {.name = "pack",
         .argument = "PRECISION",
         .kind = OPTION_CHOICE,
         .choices = packings,
         .value = OPTION_ENUM(a.pack),
         .given = &pack,
         .shown = "no",
         .help = "answer no points: write BAKED as a packed file for libprobe-query, its\n"
                 "light as floats or halves (float, half)"},
        {.name = "groups",
         .kind = OPTION_FLAG,
         .value = &a.groups,
         .help = "with --pack: pack the light of each group of lights, too, for programs\n"
                 "that dim and switch lamps"},
        {.name = "transfer",
         .kind = OPTION_FLAG,
         .value = &a.transfer,
         .help = "with --pack: pack the responses to a sky and to suns, too, as groups"},
        {.name = "explain",
         .kind = OPTION_FLAG,
         .value = &a.explain,
         .unrecorded = true,
         .help = "with text: add the cell, its four probes and their weights, inside or\n"
                 "outside of the hull, and the distance from it"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, interpolate_options_rows(&a.how, how), more,
        common_rows(&common, COMMON_OUTPUT | COMMON_THREADS, shared), NULL};
    struct program program = {
        .name = "probe-query",
        .usage = "[OPTION]... BAKED [POINTS]",
        .summary =
            "Reads points (x y z, or x y z nx ny nz) and writes the light there, interpolated "
            "between\n"
            "the probes of BAKED: the SH coefficients, or for a normal the irradiance (R G B).",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    struct interpolate *in = NULL;
    struct option_row *outside = option_row(how, "outside");
    outside->choices = outsides;
    outside->help = "outside of the hull of the probes: the light of its nearest point\n"
                    "(nearest), light that goes on from it along rays (extend), one of these\n"
                    "as the hull is (auto: see the manual), none (zero), or the point is\n"
                    "refused (error)";
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err && (a.visible == INTERPOLATE_VISIBLE_RAYS) != (a.scene != NULL))
        err = error_usage("--visible rays and --scene need each other");
    if (!err && a.along && (a.scene || pack || a.how.outside == QUERY_EXTEND))
        err = error_usage("--along needs neither cells nor a hull: no --visible rays, --pack or "
                          "--outside extend");
    if (!err && a.occluders && (pack || a.along))
        err = error_usage("--occluders is of points: no --pack and no --along");
    if (!err && pack && a.scene)
        err = error_usage("--pack packs what all probes of a cell hold: no --visible rays");
    if (!err && a.explain && a.to != QUERY_TEXT)
        err = error_usage("--explain needs --to text");
    const char *parts = a.groups ? "--groups" : a.transfer ? "--transfer" : NULL;
    if (!err && parts && !pack)
        err = error_usage("%s is of packed files: it needs --pack", parts);
    if (!err && parts && strcmp(a.column, "sh"))
        err = error_usage("%s packs column sh and those of all groups: no --column", parts);
    if (!err && pack && program.operand_count > 1)
        err = error_usage("--pack takes no points");
    if (!err && pack && !interpolate_kind_is_plain(a.how.kind) && !a.how.kind->pack)
        err = error_usage("--pack packs cells or discs: it needs --interpolate barycentric or "
                          "discs");
    if (!err && a.explain && (a.along || !a.how.kind->needs_cells)) {
        char names[256];
        interpolate_kind_names(names, sizeof names, true, " or ");
        err = error_usage("--explain needs cells: --interpolate %s", names);
    }
    if (!err)
        err = interpolate_options_check(&a.how);
    const char *baked = err ? "-" : program.operands[0];
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err && a.occluders)
        err = file_inputs_differ(a.occluders, "--occluders", input, "the points");
    if (!err && !pack)
        err = file_inputs_differ(baked, "the baked stream", input, "the points");
    if (!err)
        err = open_baked(&in, &stream, baked, input, &a, &warnings);
    if (!err && pack && !in->order && !a.how.kind->pack)
        err = error_usage("--pack packs no column but sh, or that of a group, sh_NAME");
    if (!err)
        err = pack ? write_packed(in, &a, common.output)
                   : answer(in, &a, input, &common, &program, &warnings);
    if (!err && !common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    interpolate_close(in);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
