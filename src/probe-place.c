/* probe-place: puts probes into a scene. */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "math/vec.h"
#include "place/place.h"
#include "scene/scene.h"
#include "stream/stream.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum method { METHOD_GRID, METHOD_POINTS, METHOD_PATH, METHOD_VERTICES, METHODS };
enum inside { INSIDE_DROP, INSIDE_KEEP, INSIDE_MARK };

struct arguments {
    double spacing[3], count, bounds[6], step, offset, crease, max_probes;
    bool spacing_given, count_given, bounds_given, step_given, offset_given, crease_given,
        inside_given;
    int inside;
    int64_t inside_rays;
    double backface_share;
    enum method method;
    const char *file, *scene; /* NULL: none */
};

static struct error *parse_spacing(void *value, const char *text)
{
    double *spacing = value;
    struct error *err = strchr(text, ',') ? options_reals("--spacing", text, 3, spacing)
                                          : options_real("--spacing", text, spacing);
    if (!err && !strchr(text, ','))
        spacing[1] = spacing[2] = spacing[0];
    for (int k = 0; k < 3 && !err; k++)
        if (!(spacing[k] > 0))
            err = error_usage("--spacing: expected a number greater than 0, got %g", spacing[k]);
    return err;
}

/* The operands: a method's name, its file, the scene; and which options go with it. */
static struct error *check_arguments(struct arguments *a, const struct program *program)
{
    static const char *const methods[METHODS] = {"grid", "points", "path", "vertices"};
    int m = 0;
    while (m < METHODS && strcmp(program->operands[0], methods[m]))
        m++;
    if (m == METHODS)
        return error_usage("expected a method grid, points, path or vertices, got '%s'",
                           program->operands[0]);
    a->method = (enum method)m;
    const bool has_file = m == METHOD_POINTS || m == METHOD_PATH;
    const int next = has_file ? 2 : 1;
    if (has_file && program->operand_count < 2)
        return error_usage("%s: expected a FILE of positions", methods[m]);
    a->file = has_file ? program->operands[1] : NULL;
    a->scene = program->operand_count > next ? program->operands[next] : NULL;
    if (program->operand_count > next + 1)
        return error_usage("unexpected operand '%s'", program->operands[next + 1]);
    if (m == METHOD_GRID && a->spacing_given == a->count_given)
        return error_usage("grid: expected either --spacing or --count");
    if (m == METHOD_GRID && !a->scene && !a->bounds_given)
        return error_usage("grid: expected a SCENE or --bounds");
    if (m != METHOD_GRID && (a->spacing_given || a->count_given || a->bounds_given))
        return error_usage("--spacing, --count and --bounds go with the method grid");
    if ((m == METHOD_PATH) != a->step_given)
        return error_usage(m == METHOD_PATH ? "path: expected --step"
                                            : "--step goes with the method path");
    if (m == METHOD_VERTICES && !a->scene)
        return error_usage("vertices: expected a SCENE");
    if (m != METHOD_VERTICES && (a->offset_given || a->crease_given))
        return error_usage("--offset and --crease go with the method vertices");
    if (m == METHOD_VERTICES && !a->inside_given)
        a->inside = INSIDE_KEEP;
    if (a->inside_given && !a->scene)
        return error_usage("--inside needs a SCENE");
    return NULL;
}

static struct error *grid_bounds(const struct arguments *a, const struct scene *scene,
                                 double min[3], double max[3])
{
    if (a->bounds_given) {
        memcpy(min, a->bounds, 3 * sizeof *min);
        memcpy(max, a->bounds + 3, 3 * sizeof *max);
        for (int k = 0; k < 3; k++)
            if (min[k] > max[k])
                return error_usage("--bounds: expected X0,Y0,Z0 below X1,Y1,Z1, got %g above %g",
                                   min[k], max[k]);
        return NULL;
    }
    const double low[3] = {scene->box_min.x, scene->box_min.y, scene->box_min.z};
    const double high[3] = {scene->box_max.x, scene->box_max.y, scene->box_max.z};
    memcpy(min, low, sizeof low);
    memcpy(max, high, sizeof high);
    return NULL;
}

static double default_offset(const struct scene *scene)
{
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    return PLACE_OFFSET_SHARE * vec3_length(size);
}

static struct error *place_probes(const struct arguments *a, const struct scene *scene,
                                  struct place *place)
{
    if (a->method == METHOD_POINTS)
        return place_points(place, a->file, a->max_probes);
    if (a->method == METHOD_PATH)
        return place_path(place, a->file, a->step, a->max_probes);
    if (a->method == METHOD_VERTICES)
        return place_vertices(place, scene, a->offset_given ? a->offset : default_offset(scene),
                              a->crease, a->max_probes);
    struct place_grid grid = {.spacing = {a->spacing[0], a->spacing[1], a->spacing[2]}};
    struct error *err = grid_bounds(a, scene, grid.min, grid.max);
    if (!err && a->count_given) {
        grid.spacing[0] = place_grid_spacing(grid.min, grid.max, a->count);
        if (!(grid.spacing[0] > 0))
            err = error_new("the box is a point: a grid of it needs --spacing");
        grid.spacing[1] = grid.spacing[2] = grid.spacing[0];
    }
    return err ? err : place_grid(place, &grid, a->max_probes);
}

/* Recognises what is inside solids; `inside` is a row for each position, or NULL where nobody
 * asks. */
static struct error *find_inside(const struct arguments *a, const struct scene *scene,
                                 const struct place *place, int threads, bool **inside,
                                 struct warnings *warnings)
{
    *inside = NULL;
    if (!scene || a->inside == INSIDE_KEEP)
        return NULL;
    const struct place_inside_settings settings = {
        .rays = (int)a->inside_rays, .backface_share = a->backface_share, .threads = threads};
    struct tracer *tracer = NULL;
    struct error *err = trace_create(&tracer, scene);
    if (!err)
        err = array_create(inside, place->count, sizeof **inside);
    if (!err)
        err = place_inside(place, tracer, &settings, *inside, warnings);
    trace_destroy(tracer);
    return err;
}

static struct error *fill(struct stream *stream, const struct arguments *a,
                          const struct place *place, const bool *inside, struct warnings *warnings)
{
    struct table *probes = NULL;
    struct column *position = NULL, *normal = NULL, *mark = NULL;
    struct error *err = stream_add_table(stream, "probe", &probes);
    if (!err)
        err = table_resize(probes, place->count);
    if (!err && inside && a->inside == INSIDE_MARK)
        err = table_add_column(probes, "inside", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_add_column(probes, "position", COLUMN_F64, 3, NULL);
    if (!err && place->normal)
        err = table_add_column(probes, "normal", COLUMN_F32, 3, &normal);
    position = err ? NULL : table_column(probes, "position");
    mark = err ? NULL : table_column(probes, "inside");
    size_t kept = 0, within = 0;
    for (size_t i = 0; i < place->count && !err; i++) {
        within += inside && inside[i];
        if (inside && inside[i] && a->inside == INSIDE_DROP)
            continue;
        memcpy(column_f64(position) + 3 * kept, place->position + 3 * i, 3 * sizeof(double));
        if (normal)
            memcpy(column_f32(normal) + 3 * kept, place->normal + 3 * i, 3 * sizeof(float));
        if (mark)
            column_i32(mark)[kept] = inside[i];
        kept++;
    }
    if (!err)
        err = table_resize(probes, kept);
    if (!err && within && a->inside == INSIDE_DROP)
        warnings_add(warnings, "inside",
                     "%zu of %zu probes are inside solids: dropped (--inside keep keeps them)",
                     within, place->count);
    if (!err && place->count && !kept)
        err =
            error_new("all %zu probes are inside solids (--inside keep keeps them)", place->count);
    if (!err && !place->count)
        err = error_new("%s: expected at least one position, got none", a->file);
    return err;
}

int main(int argc, char **argv)
{
    static const char *const insides[] = {"drop", "keep", "mark", NULL};
    const struct place_inside_settings inside_default = place_inside_default();
    struct arguments a = {.spacing = {NAN, NAN, NAN},
                          .count = NAN,
                          .bounds = {NAN},
                          .step = NAN,
                          .offset = NAN,
                          .crease = 60,
                          .max_probes = 1e6,
                          .inside_rays = inside_default.rays,
                          .backface_share = inside_default.backface_share};
    const struct option_row rows[] = {
        {.name = "spacing",
         .letter = 's',
         .argument = "S|SX,SY,SZ",
         .kind = OPTION_CALL,
         .value = a.spacing,
         .parse = parse_spacing,
         .given = &a.spacing_given,
         .help = "grid: distance between probes, in units of the scene"},
        {.name = "count",
         .letter = 'n',
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &a.count,
         .least = 1,
         .most = 1e15,
         .given = &a.count_given,
         .help = "grid: the finest spacing that makes at most N probes, before those\n"
                 "inside solids go"},
        {.name = "bounds",
         .argument = "X0,Y0,Z0,X1,Y1,Z1",
         .kind = OPTION_REALS,
         .count = 6,
         .value = a.bounds,
         .given = &a.bounds_given,
         .help = "grid: fill this box (default: the scene's)"},
        {.name = "step",
         .argument = "S",
         .kind = OPTION_REAL,
         .value = &a.step,
         .least_open = true,
         .most = INFINITY,
         .given = &a.step_given,
         .help = "path: the greatest distance between probes along the path"},
        {.name = "offset",
         .argument = "D",
         .kind = OPTION_REAL,
         .value = &a.offset,
         .least_open = true,
         .most = INFINITY,
         .given = &a.offset_given,
         .shown = "0.001 of the scene's diagonal",
         .help = "vertices: how far off the surface, in units of the scene"},
        {.name = "crease",
         .argument = "DEGREES",
         .kind = OPTION_REAL,
         .value = &a.crease,
         .most = 180,
         .given = &a.crease_given,
         .help = "vertices: faces that turn more than this do not share a probe"},
        {.name = "max-probes",
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &a.max_probes,
         .least = 1,
         .most = INT32_MAX,
         .help = "refuse to make more",
         .unrecorded = true},
        {.name = "inside",
         .argument = "HOW",
         .kind = OPTION_CHOICE,
         .choices = insides,
         .value = &a.inside,
         .given = &a.inside_given,
         .shown = "drop; at vertices keep",
         .help = "probes inside solids: drop, keep, or mark in a column `inside`"},
        {.name = "inside-rays",
         .argument = "N",
         .kind = OPTION_INTEGER,
         .value = &a.inside_rays,
         .least = 8,
         .most = 65536,
         .help = "rays around a probe that look for solids"},
        {.name = "backface-share",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &a.backface_share,
         .most = 1,
         .least = 1e-9,
         .help = "share of them that meet back faces inside what is not closed"},
        {0}};
    struct common common = common_default();
    common.encoding = STREAM_BINARY;
    struct option_row shared[COMMON_ROWS];
    struct program program = {
        .name = "probe-place",
        .usage = "grid|points FILE|path FILE|vertices [OPTION]... [SCENE]",
        .summary = "Puts probes into SCENE: on a grid, at the positions in FILE (x y z a line), "
                   "along the\n"
                   "path through them, or at its vertices. Probes inside solids are dropped.",
        .groups = {rows, common_rows(&common, COMMON_STREAM | COMMON_THREADS, shared)},
        .operands_least = 1,
        .operands_most = 3};
    struct warnings warnings = {0};
    struct scene_settings settings = scene_settings_default();
    struct scene *scene = NULL;
    struct stream *stream = NULL;
    struct place place = {0};
    bool *inside = NULL;
    struct error *err = options_parse(&program, argc, argv);
    if (!err)
        err = check_arguments(&a, &program);
    for (int i = 0; i < program.operand_count && !err; i++)
        err = options_record(&program, program.operands[i]);
    if (!err && a.scene)
        err = scene_read(&scene, a.scene, &settings, false, &warnings);
    if (!err)
        err = place_probes(&a, scene, &place);
    if (!err)
        err = find_inside(&a, scene, &place, (int)common.threads, &inside, &warnings);
    if (!err)
        err = stream_create(&stream);
    if (!err)
        err = fill(stream, &a, &place, inside, &warnings);
    if (!err)
        err = header_add_provenance(&stream->header, program.recorded);
    if (!err)
        err = stream_write(stream, common.output, (enum stream_encoding)common.encoding);
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    free(inside);
    place_clear(&place);
    stream_destroy(stream);
    scene_destroy(scene);
    scene_settings_clear(&settings);
    program_clear(&program);
    return error_exit(program.name, err);
}
