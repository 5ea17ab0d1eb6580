/* SPDX-License-Identifier: Apache-2.0 */
/* probe-place: puts probes into a scene. */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "import/import_scene.h"
#include "place/place_inside.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_told.h"
#include "stream/common_options.h"
#include "stream/stream.h"
#include "trace/frames.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum inside { INSIDE_DROP, INSIDE_KEEP, INSIDE_MARK };

struct arguments {
    struct place_options options;
    double max_probes;
    enum inside inside;
    bool inside_given;
    int inside_rays;
    double backface_share;
    bool list;
    bool light_given, seed_given; /* the scene's light, the seed */
};

/* Recognises where the positions are; `side` is a row for each, or NULL where nobody asks. */
static struct error *find_inside(const struct arguments *a, const struct scene *scene,
                                 const struct place *place, int threads, enum place_side **side,
                                 struct warnings *warnings)
{
    *side = NULL;
    if (!scene || a->inside == INSIDE_KEEP)
        return NULL;
    const struct place_inside_settings settings = {
        .rays = a->inside_rays, .backface_share = a->backface_share, .threads = threads};
    struct tracer *tracer = NULL;
    struct error *err = NULL;
    for (size_t i = 0; i < place->count && !err; i++)
        err = place_check_near(scene, place->position + 3 * i);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = array_create(side, place->count, sizeof **side);
    if (!err)
        err = place_inside(place, tracer, &settings, *side, warnings);
    trace_destroy(tracer);
    return err;
}

/* Says in one line how many of the probes are in no air, and why; then what is done about them. */
static void tell_inside(const size_t of[], size_t all, const char *done, char *text, size_t size)
{
    static const char *const where[] = {[PLACE_SOLID] = "inside solids",
                                        [PLACE_BEHIND] = "under or behind open surfaces",
                                        [PLACE_VOID] = "outside of closed rooms"};
    const size_t some = of[PLACE_SOLID] + of[PLACE_BEHIND] + of[PLACE_VOID];
    bool told = false;
    size_t used = some == all ? (size_t)snprintf(text, size, "all %zu probes are ", all)
                              : (size_t)snprintf(text, size, "%zu of %zu probes are ", some, all);
    for (int i = PLACE_SOLID; i <= PLACE_VOID; i++) {
        if (of[i] == some)
            used += (size_t)snprintf(text + used, size - used, "%s", where[i]);
        else if (of[i])
            used += (size_t)snprintf(text + used, size - used, "%s%zu %s",
                                     told ? ", " : "in no air: ", of[i], where[i]);
        told = told || of[i];
    }
    snprintf(text + used, size - used, "%s", done);
}

static struct error *fill(struct stream *stream, const struct arguments *a,
                          const struct place *place, const enum place_side *side,
                          struct warnings *warnings)
{
    struct table *probes = NULL;
    struct column *position = NULL, *normal = NULL, *mark = NULL, *origin = NULL;
    struct error *err = stream_add_table(stream, "probe", &probes);
    if (!err)
        err = table_resize(probes, place->count);
    if (!err && side && a->inside == INSIDE_MARK)
        err = table_add_column(probes, "inside", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_add_column(probes, "position", COLUMN_F64, 3, NULL);
    if (!err && place->normal)
        err = table_add_column(probes, "normal", COLUMN_F32, 3, NULL);
    if (!err && place->origin)
        err = table_add_column(probes, "origin", COLUMN_I32, 1, NULL);
    for (size_t i = 0; i < place->columns.column_count && !err; i++) {
        const struct column *c = &place->columns.columns[i];
        err = table_add_column(probes, c->name, c->type, c->width, NULL);
    }
    position = err ? NULL : table_column(probes, "position");
    normal = err ? NULL : table_column(probes, "normal");
    origin = err ? NULL : table_column(probes, "origin");
    mark = err || !side ? NULL : table_column(probes, "inside"); /* else the method's own */
    size_t kept = 0, of[PLACE_VOID + 1] = {0};
    for (size_t i = 0; i < place->count && !err; i++) {
        of[side ? side[i] : PLACE_AIR]++;
        if (side && side[i] && a->inside == INSIDE_DROP)
            continue;
        memcpy(column_f64(position) + 3 * kept, place->position + 3 * i, 3 * sizeof(double));
        if (normal)
            memcpy(column_f32(normal) + 3 * kept, place->normal + 3 * i, 3 * sizeof(float));
        if (origin)
            column_i32(origin)[kept] = place->origin[i];
        if (mark)
            column_i32(mark)[kept] = (int32_t)side[i];
        table_copy_rows(probes, kept, &place->columns, i, place->columns.column_count ? 1 : 0);
        kept++;
    }
    if (!err)
        err = table_resize(probes, kept);
    char text[512];
    if (!err && of[PLACE_AIR] < place->count) {
        tell_inside(of, place->count,
                    a->inside == INSIDE_DROP ? ": dropped (--inside keep keeps them)" : ": marked",
                    text, sizeof text);
        warnings_add(warnings, "inside", "%s", text);
    }
    if (!err && !place->count)
        err = error_new("there is no place for a probe within --bounds and what --reach gets to");
    if (!err && !kept) {
        tell_inside(of, place->count, "", text, sizeof text);
        err = error_new("%s: none is in the air (--inside keep keeps them, though no light may "
                        "get there; --bounds tells a grid where the air is)",
                        text);
    }
    return err;
}

/* The faces between the probes, where the method made some. */
static struct error *add_faces(struct stream *stream, const struct place *place)
{
    struct table *faces = NULL;
    if (!place->faces.name)
        return NULL;
    struct error *err = stream_add_table(stream, place->faces.name, &faces);
    for (size_t i = 0; i < place->faces.column_count && !err; i++) {
        const struct column *c = &place->faces.columns[i];
        err = table_add_column(faces, c->name, c->type, c->width, NULL);
    }
    if (!err)
        err = table_resize(faces, place->faces.rows);
    if (!err)
        table_copy_rows(faces, 0, &place->faces, 0, place->faces.rows);
    return err;
}

/* Options that do not go with the method. */
static struct error *check_given(const struct arguments *a, const struct scene_settings *settings,
                                 const struct place_method *method, bool scene)
{
    if (a->inside_given && !scene)
        return error_usage("--inside needs a SCENE");
    if (a->inside_given && method->sees_light && !method->asks_air && a->inside != INSIDE_DROP)
        return error_usage("%s places no probes where there is no air: --inside goes with others",
                           method->name);
    if (settings->choice.count && !scene)
        return error_usage("--exclude and --only need a SCENE");
    if (a->options.faces && a->inside_given && a->inside == INSIDE_DROP)
        return error_usage("--faces needs all vertices: expected no --inside drop");
    if ((a->light_given && !method->sees_light) ||
        (a->seed_given && !method->sees_light && !method->random))
        return error_usage("%s does not look at light: neither --seed nor options of the scene's "
                           "light go with it",
                           method->name);
    return NULL;
}

/* The keys of light that was traced, as probe-capture has them, and who traced it. */
static struct error *add_light_keys(struct stream_header *header, const struct place *place,
                                    const struct scene *scene, struct scene_settings *settings)
{
    char key[SCENE_KEY_ROOM];
    struct error *err = NULL;
    for (size_t i = 0; i < place->header.key_count && !err; i++)
        err = header_set_key(header, place->header.keys[i].name, place->header.keys[i].value);
    if (!err)
        err = scene_settings_found_sky(settings, scene);
    if (!err)
        err = scene_settings_to_header(settings, header);
    if (!err) {
        scene_key_text(scene, NULL, key);
        err = header_set_key(header, "scene-key", key);
    }
    return err ? err : header_set_key(header, CAPTURE_BY_KEY, "probe-place");
}

static struct error *place_probes(struct arguments *a, struct program *program,
                                  struct scene_settings *settings, const struct common *common,
                                  struct warnings *warnings)
{
    struct scene *scene = NULL;
    struct stream *stream = NULL;
    struct place place = {0};
    enum place_side *side = NULL;
    const struct place_method *method = NULL;
    struct place_world world = {.most = a->max_probes,
                                .warnings = warnings,
                                .inside = {.rays = a->inside_rays,
                                           .backface_share = a->backface_share,
                                           .threads = common->threads},
                                .seed = (uint64_t)common->seed,
                                .program = common->quiet ? NULL : program->name,
                                .progress = common->progress && !common->quiet};
    const char *scene_path = NULL;
    struct error *err = place_operands(program->operand_count, program->operands, &method,
                                       &world.file, &scene_path);
    if (!err)
        err = place_inputs_differ(&a->options, world.file, scene_path);
    if (!err)
        err = place_options_check(&a->options, method, scene_path != NULL);
    if (!err)
        err = check_given(a, settings, method, scene_path != NULL);
    for (int i = 0; i < program->operand_count && !err; i++)
        err = options_record(program, program->operands[i]);
    if (!err && scene_path)
        err = scene_read(&scene, scene_path, settings, false, warnings);
    if (!err && scene)
        err = frames_warn(scene, warnings);
    world.scene = scene;
    for (int i = 0; i < a->options.boxes && scene && !err; i++) {
        err = place_check_near(scene, a->options.box[i].low);
        if (!err)
            err = place_check_near(scene, a->options.box[i].high);
        err = error_wrap(err, "--bounds");
    }
    if (!err)
        err = method->place(&place, &a->options, &world);
    /* at a surface half of the rays may be inside; and a stream's probes are there already */
    if (!err && (place.normal || place.from) && !a->inside_given)
        a->inside = INSIDE_KEEP;
    if (!err && method->sees_light && !method->asks_air)
        a->inside = INSIDE_KEEP;
    if (!err)
        err = find_inside(a, scene, &place, common->threads, &side, warnings);
    if (!err)
        err = stream_create(&stream);
    if (!err && place.from)
        err = header_copy(&stream->header, &place.from->header);
    if (!err)
        err = fill(stream, a, &place, side, warnings);
    if (!err)
        err = add_faces(stream, &place);
    if (!err && !place.from)
        err = scene_file_to_header(settings, &stream->header);
    if (!err)
        err = scene_told_in(warnings, &stream->header, common->quiet);
    if (!err && place.header.key_count)
        err = add_light_keys(&stream->header, &place, scene, settings);
    if (!err && world.interrupted)
        err = header_set_key(&stream->header, "place-interrupted", "yes");
    if (!err)
        err = header_add_provenance(&stream->header, program->recorded);
    if (!err)
        err = stream_write(stream, common->output, common->encoding);
    if (!err && world.interrupted)
        err = error_new("interrupted: the %zu probes until then are written", place.count);
    free(side);
    place_clear(&place);
    reach_destroy(world.reach);
    stream_destroy(stream);
    scene_destroy(scene);
    return err;
}

static struct error *list_names(const struct program *program,
                                const struct scene_settings *settings, struct warnings *warnings)
{
    struct scene *scene = NULL;
    struct error *err = program->operand_count == 1
                            ? scene_read(&scene, program->operands[0], settings, false, warnings)
                            : error_usage("--list expects a SCENE alone");
    if (!err)
        err = scene_list_names(scene, stdout);
    scene_destroy(scene);
    return err;
}

int main(int argc, char **argv)
{
    static const char *const insides[] = {
        [INSIDE_DROP] = "drop", [INSIDE_KEEP] = "keep", [INSIDE_MARK] = "mark", NULL};
    const struct place_inside_settings inside_default = place_inside_default();
    struct arguments a = {.options = place_options_default(),
                          .max_probes = 1e6,
                          .inside_rays = inside_default.rays,
                          .backface_share = inside_default.backface_share};
    struct scene_settings settings = scene_settings_default();
    const struct option_row of_all[] = {
        {.name = "max-probes",
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &a.max_probes,
         .least = 1,
         .most = INT32_MAX,
         .help = "refuse to make more; adaptive and spawn-merge end there"},
        {.name = "inside",
         .argument = "HOW",
         .kind = OPTION_CHOICE,
         .choices = insides,
         .value = OPTION_ENUM(a.inside),
         .given = &a.inside_given,
         .shown = "drop; with a normal, and unlit, keep",
         .help = "probes in no air: drop, keep, or mark in a column `inside` (1 in a\n"
                 "solid, 2 under or behind an open surface, 3 outside of a room)"},
        {.name = "inside-rays",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a.inside_rays,
         .least = 8,
         .most = 65536,
         .help = "rays around a probe that look for the sides of surfaces"},
        {.name = "backface-share",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &a.backface_share,
         .most = 1,
         .least = 1e-9,
         .help = "share of the sides that they meet of open surfaces and rooms which are\n"
                 "backs where there is no air"},
        {.name = "list",
         .kind = OPTION_FLAG,
         .value = &a.list,
         .unrecorded = true,
         .help = "print the names that --exclude and --only can name, and how many\n"
                 "triangles each has, and place nothing"},
        {0}};
    struct common common = common_default();
    common.encoding = STREAM_BINARY;
    struct option_row of_methods[PLACE_OPTION_ROWS], of_file[SCENE_FILE_ROWS],
        of_scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        place_option_rows(&a.options, of_methods), of_all, scene_settings_rows(&settings, of_scene),
        common_rows(&common, COMMON_STREAM | COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS,
                    shared),
        NULL};
    scene_file_rows(&settings, of_file);
    for (struct option_row *row = of_scene; row->name; row++)
        row->given = option_row(of_file, row->name) ? row->given : &a.light_given;
    option_row(shared, "seed")->given = &a.seed_given;
    char usage[320];
    struct program program = {
        .name = "probe-place",
        .usage = usage,
        .summary =
            "Puts probes into SCENE: on a grid, at the positions in FILE (x y z a line, or x y z "
            "nx ny nz), along the\npath through them, at its vertices, on surfaces that light gets "
            "to (poisson), around its lights, as an\noctree, wherever a body gets (reach); or by "
            "its light: adaptive, where they lower the error most that\na player sees; "
            "spawn-merge, where light differs; ascent, where it comes from; unlit, a few for the\n"
            "dark; samples, over the faces between vertices, for probe-fit. Probes inside solids, "
            "under the ground or\noutside of a closed level are dropped.",
        .operands_least = 1,
        .operands_most = 3};
    struct warnings warnings = {0};
    place_usage(usage, sizeof usage);
    const size_t used = strlen(usage);
    snprintf(usage + used, sizeof usage - used, "\n       probe-place --list [OPTION]... SCENE");
    struct error *err = options_parse(&program, groups, argc, argv);
    if (!err && a.list)
        err = list_names(&program, &settings, &warnings);
    else if (!err)
        err = place_probes(&a, &program, &settings, &common, &warnings);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    scene_settings_clear(&settings);
    program_clear(&program);
    return error_exit(program.name, err);
}
