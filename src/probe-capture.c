/* probe-capture: path traces the light that reaches each probe of a stream and projects it to SH. */
#include "capture.h"
#include "error.h"
#include "interrupt.h"
#include "number.h"
#include "options.h"
#include "order.h"
#include "progress.h"
#include "scene.h"
#include "stream.h"
#include "warning.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 1024 };

struct arguments {
    struct capture_settings capture;
    int64_t rays, max_rays, bounces;
    int order; /* 0: the least that order_loss allows */
    double order_loss;
    int light;
    bool again;
    struct capture_slice slice; /* its number: rows that came before */
    struct scene_settings scene;
    struct common common;
};

static struct arguments arguments_default(void)
{
    const struct capture_settings c = capture_settings_default();
    return (struct arguments){.capture = c, .order = c.order, .order_loss = 0.01, .rays = 0, .max_rays = c.rays_most,
                              .bounces = c.bounces, .light = (int)c.light, .slice = {.parts = 1},
                              .scene = scene_settings_default(), .common = common_default()};
}

/* What --columns may name. */
static const struct {
    const char *name;
    unsigned flag;
} columns_known[] = {{"sh_error", CAPTURE_ERROR},          {"irradiance_error", CAPTURE_ERROR}, {"validity", CAPTURE_VALIDITY},
                     {"depth", CAPTURE_DEPTH},             {"sky", CAPTURE_SKY},                {"sh_gradient", CAPTURE_GRADIENT},
                     {"visibility", CAPTURE_VISIBILITY},   {"ao", CAPTURE_AO},                  {"bent_normal", CAPTURE_BENT_NORMAL},
                     {"rays", CAPTURE_RAYS},               {"none", 0}};

/* "sh_error,depth" or "none". */
static struct error *parse_columns(void *value, const char *text)
{
    const size_t count = sizeof columns_known / sizeof *columns_known;
    unsigned columns = 0;
    for (const char *at = text;;) {
        const size_t length = strcspn(at, ",");
        size_t i = 0;
        while (i < count && (strlen(columns_known[i].name) != length || strncmp(columns_known[i].name, at, length)))
            i++;
        if (i == count)
            return error_usage("expected some of sh_error, irradiance_error, validity, depth, sky, sh_gradient, visibility, ao, "
                               "bent_normal, rays, separated by commas, or none, got '%s'", text);
        columns |= columns_known[i].flag;
        if (!at[length])
            break;
        at += length + 1;
    }
    *(unsigned *)value = columns;
    return NULL;
}

/* "3" or "auto". */
static struct error *parse_order(void *value, const char *text)
{
    if (strcmp(text, "auto") && !(text[0] >= '1' && text[0] <= '0' + SH_ORDER_MAX && !text[1]))
        return error_usage("expected a whole number from 1 to %d, or auto, got '%s'", SH_ORDER_MAX, text);
    *(int *)value = text[0] == 'a' ? 0 : text[0] - '0';
    return NULL;
}

/* "I/N", I from 1. */
static struct error *parse_slice(void *value, const char *text)
{
    struct capture_slice *slice = value;
    const char *end = text + strlen(text);
    int32_t part = 0, parts = 0;
    const char *at = number_read_i32(text, end, &part);
    at = at && at < end && *at == '/' ? number_read_i32(at + 1, end, &parts) : NULL;
    if (at != end || part < 1 || part > parts)
        return error_usage("expected I/N, whole numbers with 1 <= I <= N, got '%s'", text);
    slice->part = (size_t)part - 1;
    slice->parts = (size_t)parts;
    return NULL;
}

/* Rays of the first round where an error is asked for: a share of what it will take at the least, and enough to meet what is bright and
 * seldom seen. (Rounds of 128 that were to tell of 1 % took a sun's patch in the distance for nothing.) */
static int first_round(const struct capture_settings *c)
{
    return (int)fmin(fmax(0.1 / (c->error * c->error), 128), c->rays_most);
}

/* Parses the command line over what stands in `a`. */
static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    static const char *const lights[] = {"all", "direct", "indirect", NULL};
    const struct option_row rows[] = {
        {.name = "order", .argument = "N|auto", .kind = OPTION_CALL, .value = &a->order, .parse = parse_order, .shown = "3",
         .help = "SH order: N * N coefficients a colour; auto: as few\nas --order-loss allows"},
        {.name = "order-loss", .argument = "SHARE", .kind = OPTION_REAL, .value = &a->order_loss, .most = 1,
         .help = "share of irradiance that --order auto may lose"},
        {.name = "rays", .letter = 'r', .argument = "N", .kind = OPTION_INTEGER, .value = &a->rays, .least = 1,
         .most = CAPTURE_RAYS_MOST, .shown = "512; with --error 0.1 / SHARE^2, at least 128",
         .help = "rays a probe; the error falls faster than the root of\ntheir number"},
        {.name = "error", .letter = 'e', .argument = "SHARE", .kind = OPTION_REAL, .value = &a->capture.error, .least_open = true, .most = 1,
         .shown = "none", .help = "after the first --rays, more of them until the standard\nerror of irradiance is below this share of it"},
        {.name = "error-floor", .argument = "E", .kind = OPTION_REAL, .value = &a->capture.error_floor, .most = (double)INFINITY,
         .help = "irradiance below which --error is a share of this"},
        {.name = "max-rays", .argument = "N", .kind = OPTION_INTEGER, .value = &a->max_rays, .least = 1, .most = CAPTURE_RAYS_MOST,
         .help = "rays a probe that --error may spend"},
        {.name = "bounces", .argument = "N", .kind = OPTION_INTEGER, .value = &a->bounces, .most = CAPTURE_BOUNCES_MOST,
         .help = "how often light may scatter on its way"},
        {.name = "light", .argument = "WHICH", .kind = OPTION_CHOICE, .choices = lights, .value = &a->light,
         .help = "capture all light, direct or indirect alone"},
        {.name = "columns", .argument = "LIST", .kind = OPTION_CALL, .value = &a->capture.columns, .parse = parse_columns,
         .shown = "sh_error,validity,depth,sky",
         .help = "what to write beside light: of these, sh_gradient,\nvisibility, ao, bent_normal, rays; none: nothing"},
        {.name = "ao-distance", .argument = "D", .kind = OPTION_REAL, .value = &a->capture.ao_distance, .least_open = true,
         .most = (double)INFINITY, .shown = "none", .help = "surfaces beyond do not occlude, for ao and bent_normal"},
        {.name = "again", .kind = OPTION_FLAG, .value = &a->again, .help = "capture all probes, not only those that have no light yet"},
        {.name = "slice", .argument = "I/N", .kind = OPTION_CALL, .value = &a->slice, .parse = parse_slice, .shown = "1/1",
         .help = "capture the I-th of N parts of the probes: every N-th from\nthe I-th on (probe-cat --fill puts slices together)"},
        {0}};
    struct option_row scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    program->groups[0] = rows;
    program->groups[1] = scene_settings_rows(&a->scene, scene);
    program->groups[2] = common_rows(&a->common, COMMON_STREAM | COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS, shared);
    struct error *err = options_parse(program, argc, argv);
    memset(program->groups, 0, sizeof program->groups); /* they end with this function */
    a->capture.order = a->order ? a->order : SH_ORDER_MAX;
    a->capture.rays_most = (int)a->max_rays;
    a->capture.rays = a->rays ? (int)a->rays : a->capture.error > 0 ? first_round(&a->capture) : capture_settings_default().rays;
    a->capture.bounces = (int)a->bounces;
    a->capture.light = (enum capture_light)a->light;
    a->capture.seed = (uint64_t)a->common.seed;
    if (!err && !a->order && a->slice.parts > 1)
        err = error_usage("--slice needs a fixed --order: with auto every slice would choose its own");
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
    a->max_rays = a->capture.rays_most;
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

/* A run: what it reads and writes, and what it has seen. */
struct run {
    struct arguments arguments;
    struct program *program;
    struct stream_reader *reader;
    struct stream_writer *writer; /* opened when the order is known */
    struct stream_header header;
    const struct scene *scene;
    const struct path_tracer *path;
    struct progress *progress;
    struct warnings *warnings;
    size_t probes, captured; /* of the slice */
    size_t left;             /* that a signal came before */
    double sky; /* sum of the captured probes' share of rays that escaped, where it is kept */
};

static struct error *open_writer(struct run *run)
{
    const struct arguments *a = &run->arguments;
    struct error *err = make_header(&run->header, stream_reader_header(run->reader), a, run->scene, run->program->recorded);
    const enum stream_encoding read = stream_reader_encoding(run->reader), asked = (enum stream_encoding)a->common.encoding;
    return err ? err : stream_writer_open(&run->writer, a->common.output, asked == STREAM_AS_READ ? read : asked, &run->header);
}

/* Makes the light of all rows missing, and what was learned with it: rows that are not captured again must not keep light that
 * the header's settings did not make. */
static struct error *forget_light(struct table *table)
{
    struct error *err = NULL;
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        const char *known = !strcmp(c->name, "sh") ? "sh" : !strcmp(c->name, "irradiance") ? "irradiance" : NULL;
        for (size_t k = 0; k < sizeof columns_known / sizeof *columns_known && !known; k++)
            if (columns_known[k].flag && !strcmp(c->name, columns_known[k].name))
                known = columns_known[k].name;
        if (known)
            err = table_add_column(table, known, c->type, c->width, NULL);
    }
    return err;
}

/* Captures what is without light in the table, whose first row is the slice's next, and remembers what was seen. */
static struct error *capture_block(struct run *run, struct table *out)
{
    struct arguments *a = &run->arguments;
    size_t captured = 0, left = 0;
    struct error *err = a->again ? forget_light(out) : NULL;
    if (!err)
        err = capture_rows(run->path, &a->capture, out, 0, out->rows, a->again, &a->slice, (int)a->common.threads, run->progress,
                           &captured, &left);
    run->captured += captured;
    run->left += left;
    for (size_t i = 0; i < out->rows; i++)
        run->probes += (a->slice.number + i) % a->slice.parts == a->slice.part;
    a->slice.number += out->rows;
    const struct column *sky = table_column(out, "sky");
    for (size_t i = 0; sky && i < out->rows && !err; i++)
        run->sky += isnan(column_f32(sky)[i]) ? 0 : (double)column_f32(sky)[i];
    return err;
}

/* The table that is to be written: what came, and what capture adds. */
static struct error *make_schema(const struct run *run, const struct table *schema, struct table *out)
{
    struct error *err = table_copy_schema(out, schema);
    if (!err && run->arguments.again)
        table_remove_column(out, "sh_gradient"); /* of the light that was */
    return err ? err : capture_add_columns(&run->arguments.capture, out);
}

/* Captures the probes block by block, so that they go on while others are still to come. */
static struct error *capture_blocks(struct run *run, const struct table *schema, struct table *out)
{
    struct table in = {0};
    struct error *err = table_copy_schema(&in, schema);
    if (!err)
        err = stream_writer_table(run->writer, out);
    for (size_t got = 1; !err && got;) {
        err = table_resize(&in, 0);
        if (!err)
            err = stream_reader_rows(run->reader, &in, BLOCK, &got);
        if (!err)
            err = table_resize(out, 0); /* rows that are new again hold missing values */
        if (!err)
            err = table_resize(out, got);
        if (err)
            break;
        table_copy_rows(out, 0, &in, 0, got);
        err = capture_block(run, out);
        if (!err)
            err = stream_writer_rows(run->writer, out, 0, got);
    }
    table_clear(&in);
    return err;
}

/* Captures all probes to the highest order, and keeps the least that loses no more than it may. */
static struct error *capture_to_least_order(struct run *run, const struct table *schema, struct table *out)
{
    struct arguments *a = &run->arguments;
    const bool keep_error = a->capture.columns & CAPTURE_ERROR;
    struct table in = {0};
    double lost = 0;
    size_t got = 1;
    a->capture.columns |= CAPTURE_ERROR;
    struct error *err = capture_add_columns(&a->capture, out);
    if (!err)
        err = table_copy_schema(&in, schema);
    while (!err && got)
        err = stream_reader_rows(run->reader, &in, BLOCK, &got);
    if (!err)
        err = table_resize(out, in.rows);
    if (!err) {
        table_copy_rows(out, 0, &in, 0, in.rows);
        err = capture_block(run, out);
    }
    const bool whole = !run->left; /* a part of the probes does not tell what all need */
    if (!err && whole)
        err = order_least(out, a->order_loss, &a->capture.order, &lost);
    if (!err && whole)
        err = order_reduce(out, a->capture.order);
    if (!err && !keep_error)
        table_remove_column(out, "sh_error");
    if (!err)
        err = open_writer(run);
    if (!err)
        err = stream_writer_table(run->writer, out);
    if (!err)
        err = stream_writer_rows(run->writer, out, 0, out->rows);
    if (!err && whole && !a->common.quiet)
        fprintf(stderr, "%s: order %d loses %.2g of the irradiance\n", run->program->name, a->capture.order, lost);
    table_clear(&in);
    return err;
}

static struct error *capture_table(struct run *run, const struct table *schema)
{
    struct table out = {0};
    struct error *err = make_schema(run, schema, &out);
    const bool surface = table_column(schema, "normal"), choose = !run->arguments.order && !surface;
    if (!err && choose && run->writer)
        err = error_new("--order auto: expected table probe before the others");
    if (!err && !choose && !run->writer)
        err = open_writer(run);
    if (!err)
        err = choose ? capture_to_least_order(run, schema, &out) : capture_blocks(run, schema, &out);
    table_clear(&out);
    return err;
}

static struct error *capture_stream(struct run *run)
{
    struct error *err = NULL;
    for (bool more = true; !err && more;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        const bool probes = !err && more && !strcmp(schema.name, "probe");
        if (!err && !probes && !run->writer)
            err = open_writer(run);
        if (probes)
            err = capture_table(run, &schema);
        else if (!err && more)
            err = stream_copy_table(run->reader, run->writer, &schema);
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

static void warn_after(const struct run *run)
{
    const struct scene *scene = run->scene;
    bool white = scene->material_count > 0;
    for (size_t i = 0; i < scene->material_count; i++) {
        const struct scene_material *m = &scene->materials[i];
        white = white && m->albedo_map.texture == SCENE_NONE && fminf(m->albedo.x, fminf(m->albedo.y, m->albedo.z)) > 0.999f;
    }
    if (white && run->captured && run->sky == 0)
        warnings_add(run->warnings, "white", "%s: the scene is closed and reflects all light: only --bounces ends it (--albedo-scale "
                     "or --max-albedo makes walls darker)", scene->path);
    if (run->probes && !run->captured && !run->left)
        warnings_add(run->warnings, "nothing to do", "all %zu probes%s have light already (--again captures them anew)", run->probes,
                     run->arguments.slice.parts > 1 ? " of the slice" : "");
}

int main(int argc, char **argv)
{
    struct program program = {
        .name = "probe-capture",
        .usage = "[OPTION]... SCENE [STREAM]",
        .summary = "Path traces the light of SCENE that reaches each probe of STREAM (standard input) and\n"
                   "adds it as spherical harmonics, or as irradiance to probes that have a normal. Probes\n"
                   "that have light already are left as they are.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct run run = {.arguments = arguments_default(), .program = &program, .warnings = &warnings};
    struct arguments *a = &run.arguments;
    struct scene *scene = NULL;
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct error *err = parse(&program, a, argc, argv);
    if (!err)
        err = stream_reader_open(&run.reader, program.operand_count > 1 ? program.operands[1] : "-");
    if (!err)
        err = take_over(&program, a, stream_reader_header(run.reader), argc, argv);
    if (!err)
        err = options_record(&program, program.operands[0]);
    if (!err)
        err = scene_read(&scene, program.operands[0], &a->scene, true, &warnings);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = path_create(&path, tracer, a->capture.bounces);
    if (!err)
        warn_before(scene, &warnings);
    if (!a->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err) {
        run.scene = scene;
        run.path = &path;
        interrupt_catch(); /* from here on there is something to lose */
        run.progress = progress_start(a->common.progress && !a->common.quiet, program.name, "probes", 0);
        err = capture_stream(&run);
        progress_end(run.progress);
    }
    if (!err) {
        warn_after(&run);
        err = stream_writer_finish(run.writer);
    } else {
        stream_writer_abandon(run.writer);
    }
    if (!err && !a->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    if (!err && run.left)
        err = error_new("interrupted: %zu of %zu probes captured; given back to probe-capture, the rest is captured", run.captured,
                        run.captured + run.left);
    path_clear(&path);
    trace_destroy(tracer);
    scene_destroy(scene);
    stream_reader_close(run.reader);
    header_clear(&run.header);
    scene_settings_clear(&a->scene);
    program_clear(&program);
    return error_exit(program.name, err);
}
