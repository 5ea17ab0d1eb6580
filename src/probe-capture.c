/* probe-capture: path traces the light that reaches each probe of a stream and projects it to SH. */
#include "capture.h"
#include "error.h"
#include "options.h"
#include "progress.h"
#include "scene.h"
#include "stream.h"
#include "warning.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 1024 };

struct arguments {
    struct capture_settings capture;
    int64_t order, rays, bounces;
    int light;
    bool again;
    struct scene_settings scene;
    struct common common;
};

static struct arguments arguments_default(void)
{
    const struct capture_settings c = capture_settings_default();
    return (struct arguments){.capture = c, .order = c.order, .rays = c.rays, .bounces = c.bounces, .light = (int)c.light,
                              .scene = scene_settings_default(), .common = common_default()};
}

/* "sh_error,depth" or "none". */
static struct error *parse_columns(void *value, const char *text)
{
    static const struct {
        const char *name;
        unsigned flag;
    } known[] = {{"sh_error", CAPTURE_ERROR}, {"validity", CAPTURE_VALIDITY}, {"depth", CAPTURE_DEPTH}, {"sky", CAPTURE_SKY},
                 {"none", 0}};
    unsigned columns = 0;
    for (const char *at = text;;) {
        const size_t length = strcspn(at, ",");
        size_t i = 0;
        while (i < sizeof known / sizeof *known && (strlen(known[i].name) != length || strncmp(known[i].name, at, length)))
            i++;
        if (i == sizeof known / sizeof *known)
            return error_usage("expected sh_error, validity, depth, sky or none, separated by commas, got '%s'", text);
        columns |= known[i].flag;
        if (!at[length])
            break;
        at += length + 1;
    }
    *(unsigned *)value = columns;
    return NULL;
}

/* Parses the command line over what stands in `a`. */
static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    static const char *const lights[] = {"all", "direct", "indirect", NULL};
    const struct option_row rows[] = {
        {.name = "order", .argument = "N", .kind = OPTION_INTEGER, .value = &a->order, .least = 1, .most = SH_ORDER_MAX,
         .help = "SH order: N * N coefficients a colour"},
        {.name = "rays", .letter = 'r', .argument = "N", .kind = OPTION_INTEGER, .value = &a->rays, .least = 1,
         .most = CAPTURE_RAYS_MOST, .help = "rays a probe; the error falls faster than the root of their number"},
        {.name = "bounces", .argument = "N", .kind = OPTION_INTEGER, .value = &a->bounces, .most = CAPTURE_BOUNCES_MOST,
         .help = "how often light may scatter on its way"},
        {.name = "light", .argument = "WHICH", .kind = OPTION_CHOICE, .choices = lights, .value = &a->light,
         .help = "capture all light, direct or indirect alone"},
        {.name = "columns", .argument = "LIST", .kind = OPTION_CALL, .value = &a->capture.columns, .parse = parse_columns,
         .shown = "sh_error,validity,depth,sky", .help = "what to write beside sh; none: nothing"},
        {.name = "again", .kind = OPTION_FLAG, .value = &a->again, .help = "capture all probes, not only those that have no light yet"},
        {0}};
    struct option_row scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    program->groups[0] = rows;
    program->groups[1] = scene_settings_rows(&a->scene, scene);
    program->groups[2] = common_rows(&a->common, COMMON_STREAM | COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS, shared);
    struct error *err = options_parse(program, argc, argv);
    memset(program->groups, 0, sizeof program->groups); /* they end with this function */
    a->capture.order = (int)a->order;
    a->capture.rays = (int)a->rays;
    a->capture.bounces = (int)a->bounces;
    a->capture.light = (enum capture_light)a->light;
    a->capture.seed = (uint64_t)a->common.seed;
    return err;
}

/* Where probes were captured before, and not again, what they were captured with takes the place of the defaults, and the
 * command line is read over that. */
static struct error *take_over(struct program *program, struct arguments *a, const struct stream_header *header, int argc,
                               char **argv)
{
    if (a->again || !capture_header_has_settings(header))
        return NULL;
    scene_settings_clear(&a->scene);
    program_clear(program);
    *a = arguments_default();
    struct error *err = capture_settings_from_header(&a->capture, header);
    if (!err)
        err = scene_settings_from_header(&a->scene, header);
    a->order = a->capture.order;
    a->rays = a->capture.rays;
    a->bounces = a->capture.bounces;
    a->light = (int)a->capture.light;
    a->common.seed = (int64_t)a->capture.seed;
    return err ? err : parse(program, a, argc, argv);
}

static struct error *make_header(struct stream_header *header, const struct stream_header *before, const struct arguments *a,
                                 const struct scene *scene, const char *recorded)
{
    char key[32];
    snprintf(key, sizeof key, "%016" PRIx64, scene_key(scene));
    struct error *err = header_copy(header, before);
    if (!err)
        err = header_add_provenance(header, recorded);
    if (!err)
        err = capture_settings_to_header(&a->capture, header);
    if (!err)
        err = scene_settings_to_header(&a->scene, header);
    if (!err)
        err = header_set_key(header, "scene-key", key);
    if (!err && !a->again) {
        err = capture_check_same(before, header);
        if (err)
            err = error_wrap(err, "--again captures all anew");
    }
    return err;
}

/* What the run has seen. */
struct totals {
    size_t probes, captured;
    double sky; /* sum of the captured probes' share of rays that escaped, where it is kept */
};

/* Captures the probes block by block, so that they go on while others are still to come. */
static struct error *capture_table(struct stream_reader *reader, struct stream_writer *writer, const struct arguments *a,
                                   const struct path_tracer *path, const struct table *schema, struct progress *progress,
                                   struct totals *totals)
{
    struct table in = {0}, out = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = table_copy_schema(&out, schema);
    if (!err && a->again)
        table_remove_column(&out, "sh_gradient"); /* of the light that was */
    if (!err)
        err = capture_add_columns(&a->capture, &out);
    if (!err)
        err = stream_writer_table(writer, &out);
    for (size_t got = 1; !err && got;) {
        size_t captured = 0;
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(reader, &in, BLOCK, &got);
        if (!err)
            err = table_resize(&out, 0); /* rows that are new again hold missing values */
        if (!err)
            err = table_resize(&out, got);
        if (err)
            break;
        table_copy_rows(&out, 0, &in, 0, got);
        err = capture_rows(path, &a->capture, &out, 0, got, a->again, (int)a->common.threads, progress, &captured);
        if (!err)
            err = stream_writer_rows(writer, &out, 0, got);
        totals->probes += got;
        totals->captured += captured;
        const struct column *sky = table_column(&out, "sky");
        for (size_t i = 0; sky && i < got; i++)
            totals->sky += (double)column_f32(sky)[i];
    }
    table_clear(&in);
    table_clear(&out);
    return err;
}

static struct error *capture_stream(struct stream_reader *reader, struct stream_writer *writer, const struct arguments *a,
                                    const struct path_tracer *path, struct progress *progress, struct totals *totals)
{
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(reader, &schema, &more);
        if (!err && more && !strcmp(schema.name, "probe"))
            err = capture_table(reader, writer, a, path, &schema, progress, totals);
        else if (!err && more)
            err = stream_copy_table(reader, writer, &schema);
        table_clear(&schema);
    }
    return err;
}

static bool is_dark(const struct scene *scene)
{
    bool dark = !scene->light_count && !scene->sky.radiance[0] && !scene->sky.radiance[1] && !scene->sky.radiance[2];
    for (size_t i = 0; i < scene->material_count; i++)
        dark = dark && !scene_emits(&scene->materials[i]);
    return dark;
}

static void warn_before(const struct scene *scene, struct warnings *warnings)
{
    if (is_dark(scene))
        warnings_add(warnings, "no light", "%s: there is no light in the scene: all probes are black (--sky, --sun, --point and "
                     "--spot add light)", scene->path);
    if (!scene_triangle_count(scene))
        warnings_add(warnings, "empty", "%s: the scene is empty: probes see the sky alone", scene->path);
}

static void warn_after(const struct scene *scene, const struct totals *totals, struct warnings *warnings)
{
    bool white = scene->material_count > 0;
    for (size_t i = 0; i < scene->material_count; i++) {
        const struct scene_material *m = &scene->materials[i];
        white = white && m->albedo_map.texture == SCENE_NONE && fminf(m->albedo.x, fminf(m->albedo.y, m->albedo.z)) > 0.999f;
    }
    if (white && totals->captured && totals->sky == 0)
        warnings_add(warnings, "white", "%s: the scene is closed and reflects all light: only --bounces ends it (--albedo-scale "
                     "or --max-albedo makes walls darker)", scene->path);
    if (totals->probes && !totals->captured)
        warnings_add(warnings, "nothing to do", "all %zu probes have light already (--again captures them anew)", totals->probes);
}

int main(int argc, char **argv)
{
    struct arguments a = arguments_default();
    struct program program = {
        .name = "probe-capture",
        .usage = "[OPTION]... SCENE [STREAM]",
        .summary = "Path traces the light of SCENE that reaches each probe of STREAM (standard input) and\n"
                   "adds it as spherical harmonics. Probes that have light already are left as they are.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct stream_reader *reader = NULL;
    struct stream_writer *writer = NULL;
    struct stream_header header = {0};
    struct scene *scene = NULL;
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct totals totals = {0};
    struct error *err = parse(&program, &a, argc, argv);
    if (!err)
        err = stream_reader_open(&reader, program.operand_count > 1 ? program.operands[1] : "-");
    if (!err)
        err = take_over(&program, &a, stream_reader_header(reader), argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    if (!err)
        err = scene_read(&scene, program.operands[0], &a.scene, true, &warnings);
    if (!err)
        err = make_header(&header, stream_reader_header(reader), &a, scene, program.recorded);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = path_create(&path, tracer, a.capture.bounces);
    if (!err)
        warn_before(scene, &warnings);
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err)
        err = stream_writer_open(&writer, a.common.output,
                                 a.common.encoding == STREAM_AS_READ ? stream_reader_encoding(reader)
                                                                     : (enum stream_encoding)a.common.encoding, &header);
    if (!err) {
        struct progress *progress = progress_start(a.common.progress && !a.common.quiet, program.name, "probes", 0);
        err = capture_stream(reader, writer, &a, &path, progress, &totals);
        progress_end(progress);
    }
    if (!err) {
        warn_after(scene, &totals, &warnings);
        err = stream_writer_finish(writer);
    } else {
        stream_writer_abandon(writer);
    }
    if (!err && !a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    path_clear(&path);
    trace_destroy(tracer);
    scene_destroy(scene);
    stream_reader_close(reader);
    header_clear(&header);
    scene_settings_clear(&a.scene);
    program_clear(&program);
    return error_exit(program.name, err);
}
