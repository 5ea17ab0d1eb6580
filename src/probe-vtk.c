/* probe-vtk: writes probes, tetrahedra and the scene for ParaView. */
#include "array.h"
#include "derive.h"
#include "error.h"
#include "options.h"
#include "scene.h"
#include "sh.h"
#include "stream.h"
#include "surface.h"
#include "vtk_export.h"
#include "warning.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Arrays that go into a file, and what they own. */
struct arrays {
    struct vtk_array *list;
    size_t count, capacity;
    void **owned;
    size_t owned_count, owned_capacity;
};

static void arrays_clear(struct arrays *a)
{
    for (size_t i = 0; i < a->owned_count; i++)
        free(a->owned[i]);
    free(a->owned);
    free(a->list);
    *a = (struct arrays){0};
}

static struct error *add(struct arrays *a, struct vtk_array array)
{
    struct error *err = array_reserve(&a->list, &a->capacity, a->count + 1, sizeof *a->list);
    if (!err)
        a->list[a->count++] = array;
    return err;
}

/* Memory that lives as long as the arrays. */
static struct error *own(struct arrays *a, size_t count, size_t size, void *memory)
{
    void *fresh = NULL;
    struct error *err = array_reserve(&a->owned, &a->owned_capacity, a->owned_count + 1, sizeof *a->owned);
    if (!err)
        err = array_create(&fresh, count, size);
    if (!err)
        a->owned[a->owned_count++] = fresh;
    memcpy(memory, &fresh, sizeof fresh);
    return err;
}

/* Adds an array of `count` tuples that is to be filled. */
static struct error *add_new(struct arrays *a, const char *name, enum vtk_type type, size_t width, size_t count, void *memory)
{
    const size_t size = type == VTK_EXPORT_U8 ? 1 : type == VTK_EXPORT_F64 ? 8 : 4;
    struct error *err = own(a, count * width, size, memory);
    void *data;
    memcpy(&data, memory, sizeof data);
    return err ? err : add(a, (struct vtk_array){.name = name, .type = type, .width = width, .data = data});
}

/* Names of the components of SH columns: L00.r, L00.g, ..., L1-1.r, ... ; with d = 3: L00.r.x for gradients. */
static struct error *sh_names(struct arrays *a, size_t width, size_t directions, const char *const **names)
{
    enum { ROOM = 40 };
    char **list = NULL, *text = NULL;
    struct error *err = own(a, width, sizeof *list, &list);
    if (!err)
        err = own(a, width, ROOM, &text);
    for (size_t i = 0; i < width && !err; i++) {
        const size_t coefficient = i / 3 % (width / 3 / directions), d = i / (width / directions);
        int l = 0;
        while ((size_t)((l + 1) * (l + 1)) <= coefficient)
            l++;
        list[i] = text + i * ROOM;
        snprintf(list[i], ROOM, "L%d%d.%c%s%c", l, (int)coefficient - l * (l + 1), "rgb"[i % 3], directions > 1 ? "." : "",
                 directions > 1 ? "xyz"[d] : '\0');
    }
    *names = (const char *const *)list;
    return err;
}

/* A copy of a float column in which missing values are 0: VTK's bounds take no NaN. */
static struct error *without_missing(struct arrays *a, const struct column *c, size_t rows, const void **data)
{
    *data = c->data;
    const size_t bytes = rows * c->width * column_type_size(c->type);
    bool missing = false;
    for (size_t i = 0; i < rows * c->width && c->type != COLUMN_I32 && !missing; i++)
        missing = isnan(c->type == COLUMN_F32 ? (double)column_f32(c)[i] : column_f64(c)[i]);
    if (!missing)
        return NULL;
    void *copy = NULL;
    struct error *err = own(a, bytes, 1, &copy);
    if (err)
        return err;
    memcpy(copy, c->data, bytes);
    for (size_t i = 0; i < rows * c->width; i++) {
        if (c->type == COLUMN_F32 && isnan(((float *)copy)[i]))
            ((float *)copy)[i] = 0;
        if (c->type == COLUMN_F64 && isnan(((double *)copy)[i]))
            ((double *)copy)[i] = 0;
    }
    *data = copy;
    return NULL;
}

static struct error *add_columns(struct arrays *a, const struct table *table)
{
    static const enum vtk_type types[] = {[COLUMN_F32] = VTK_EXPORT_F32, [COLUMN_F64] = VTK_EXPORT_F64, [COLUMN_I32] = VTK_EXPORT_I32};
    struct error *err = NULL;
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        struct vtk_array array = {.name = c->name, .type = types[c->type], .width = c->width};
        const bool gradient = !strcmp(c->name, "sh_gradient");
        if (!strcmp(c->name, "sh") || !strcmp(c->name, "sh_error") || gradient)
            err = sh_names(a, c->width, gradient ? 3 : 1, &array.components);
        if (!err)
            err = without_missing(a, c, table->rows, &array.data);
        if (!err)
            err = add(a, array);
    }
    return err;
}

/* What is made of the light: irradiance, colour, luminance and its gradients, and where light comes from. */
static struct error *add_light(struct arrays *points, struct arrays *cells, const struct stream *stream, struct warnings *warnings)
{
    const struct table *probes = stream_table(stream, "probe"), *tets = stream_table(stream, "tet");
    const struct column *sh = table_column(probes, "sh");
    if (!sh) {
        warnings_add(warnings, "no light", "the probes have no light (no column sh): positions and cells alone are written");
        return NULL;
    }
    const size_t n = probes->rows;
    const int order = sh_order_of(sh->width);
    const char *content = header_key(&stream->header, "sh-content");
    float *irradiance = NULL, *luminance = NULL, *brightest = NULL, *gradient = NULL, *cell_gradient = NULL, exposure = 1;
    uint8_t *colour = NULL;
    int32_t *captured = NULL;
    struct error *err = add_new(points, "irradiance", VTK_EXPORT_F32, 3, n, &irradiance);
    if (!err)
        err = add_new(points, "colour", VTK_EXPORT_U8, 3, n, &colour);
    if (!err)
        err = add_new(points, "luminance", VTK_EXPORT_F32, 1, n, &luminance);
    if (!err)
        err = add_new(points, "brightest", VTK_EXPORT_F32, 3, n, &brightest);
    if (!err)
        err = add_new(points, "captured", VTK_EXPORT_I32, 1, n, &captured);
    if (err)
        return err;
    derive_irradiance(n, order, content && !strcmp(content, "irradiance"), column_f32(sh), irradiance);
    derive_luminance(n, irradiance, luminance);
    derive_brightest(n, order, column_f32(sh), brightest);
    derive_captured(n, sh->width, column_f32(sh), captured);
    err = derive_exposure(n, luminance, &exposure);
    if (!err)
        derive_codes(n, irradiance, exposure, colour);
    size_t missing = 0;
    for (size_t i = 0; i < n && !err; i++)
        missing += !captured[i];
    if (missing)
        warnings_add(warnings, "missing", "%zu of %zu probes have no light: 0 is written, and 0 in the array captured", missing, n);
    if (err || !tets)
        return err;
    const int32_t *vertex = column_i32(table_column(tets, "vertex"));
    const double *position = column_f64(table_column(probes, "position"));
    err = add_new(points, "luminance_gradient", VTK_EXPORT_F32, 3, n, &gradient);
    if (!err)
        err = add_new(cells, "luminance_gradient", VTK_EXPORT_F32, 3, tets->rows, &cell_gradient);
    if (!err) {
        derive_cell_gradient(tets->rows, vertex, position, luminance, cell_gradient);
        err = derive_point_gradient(n, tets->rows, vertex, position, cell_gradient, gradient);
    }
    return err;
}

/* How many of a cell's faces are on the hull, and how many of its edges leak where probe-leakfix counted. */
static struct error *add_cell_marks(struct arrays *cells, const struct table *tets)
{
    const struct column *neighbour = table_column(tets, "neighbour"), *occlusion = table_column(tets, "occlusion");
    int32_t *hull = NULL, *leaks = NULL;
    struct error *err = neighbour ? add_new(cells, "hull_faces", VTK_EXPORT_I32, 1, tets->rows, &hull) : NULL;
    for (size_t i = 0; neighbour && !err && i < 4 * tets->rows; i++)
        hull[i / 4] += column_i32(neighbour)[i] < 0;
    if (err || !occlusion || occlusion->type != COLUMN_I32 || occlusion->width != 6)
        return err;
    err = add_new(cells, "crossed_edges", VTK_EXPORT_I32, 1, tets->rows, &leaks);
    for (size_t i = 0; !err && i < 6 * tets->rows; i++)
        leaks[i / 6] += column_i32(occlusion)[i] > 0;
    return err;
}

static struct error *header_texts(struct arrays *a, const struct stream_header *header, const struct vtk_text **texts, size_t *count)
{
    struct vtk_text *list = NULL;
    enum { ROOM = 40 };
    char *names = NULL;
    struct error *err = own(a, header->key_count + header->provenance_count, sizeof *list, &list);
    if (!err)
        err = own(a, header->provenance_count, ROOM, &names);
    *count = 0;
    for (size_t i = 0; i < header->key_count && !err; i++)
        list[(*count)++] = (struct vtk_text){header->keys[i].name, header->keys[i].value};
    for (size_t i = 0; i < header->provenance_count && !err; i++) {
        snprintf(names + ROOM * i, ROOM, "made-by-%zu", i + 1);
        list[(*count)++] = (struct vtk_text){names + ROOM * i, header->provenance[i]};
    }
    *texts = list;
    return err;
}

static struct error *write_grid(const struct stream *stream, const char *path, bool ascii, struct warnings *warnings)
{
    const struct table *probes = stream_table(stream, "probe"), *tets = stream_table(stream, "tet");
    struct column *vertex = NULL;
    if (!probes)
        return error_new("there is no table probe");
    if (tets) {
        struct error *err = table_require(tets, "vertex", COLUMN_I32, 4, &vertex);
        if (err)
            return err;
    }
    struct arrays points = {0}, cells = {0};
    struct vtk_mesh mesh = {.point_count = probes->rows, .position = column_f64(table_column(probes, "position"))};
    struct error *err = add_columns(&points, probes);
    if (!err && tets)
        err = add_columns(&cells, tets);
    if (!err)
        err = add_light(&points, &cells, stream, warnings);
    if (!err && tets)
        err = add_cell_marks(&cells, tets);
    if (!err)
        err = header_texts(&points, &stream->header, &mesh.texts, &mesh.text_count);
    if (!err) {
        mesh.cell_count = tets ? tets->rows : 0;
        mesh.vertex = tets ? column_i32(vertex) : NULL;
        mesh.point_arrays = points.list;
        mesh.point_array_count = points.count;
        mesh.cell_arrays = cells.list;
        mesh.cell_array_count = cells.count;
        err = vtk_write_grid(path, &mesh, ascii);
    }
    arrays_clear(&points);
    arrays_clear(&cells);
    return err;
}

static struct error *write_scene(const char *scene_path, const char *path, bool ascii, struct warnings *warnings)
{
    struct scene_settings settings = scene_settings_default();
    struct scene *scene = NULL;
    struct surface surface = {0};
    struct arrays cells = {0};
    uint8_t *colour = NULL;
    struct error *err = scene_read(&scene, scene_path, &settings, false, warnings);
    if (!err)
        err = surface_create(&surface, scene);
    if (!err)
        err = add(&cells, (struct vtk_array){.name = "albedo", .type = VTK_EXPORT_F32, .width = 3, .data = surface.albedo});
    if (!err)
        err = add(&cells, (struct vtk_array){.name = "emission", .type = VTK_EXPORT_F32, .width = 3, .data = surface.emission});
    if (!err)
        err = add(&cells, (struct vtk_array){.name = "material", .type = VTK_EXPORT_I32, .width = 1, .data = surface.material});
    if (!err)
        err = add_new(&cells, "colour", VTK_EXPORT_U8, 3, surface.triangle_count, &colour);
    if (!err) {
        derive_codes(surface.triangle_count, surface.albedo, 1, colour);
        err = vtk_write_surface(path, &(struct vtk_mesh){.point_count = surface.vertex_count, .position = surface.position,
                                                         .cell_count = surface.triangle_count, .vertex = surface.index,
                                                         .cell_arrays = cells.list, .cell_array_count = cells.count}, ascii);
    }
    arrays_clear(&cells);
    surface_clear(&surface);
    scene_destroy(scene);
    scene_settings_clear(&settings);
    return err;
}

/* FILE.vtu gives FILE.scene.vtp. */
static struct error *scene_name(const char *output, char **name)
{
    const size_t length = strlen(output), stem = length > 4 && !strcmp(output + length - 4, ".vtu") ? length - 4 : length;
    *name = NULL;
    return asprintf(name, "%.*s.scene.vtp", (int)stem, output) < 0 ? error_memory() : NULL;
}

int main(int argc, char **argv)
{
    const char *output = NULL, *scene = NULL, *scene_output = NULL;
    bool ascii = false, quiet = false;
    const struct option_row rows[] = {
        {.name = "output", .letter = 'o', .argument = "FILE.vtu", .kind = OPTION_TEXT, .value = &output,
         .help = "write the probes and tetrahedra to FILE.vtu (required); - is standard\noutput"},
        {.name = "scene", .argument = "SCENE", .kind = OPTION_TEXT, .value = &scene, .help = "write the scene as well"},
        {.name = "scene-output", .argument = "FILE.vtp", .kind = OPTION_TEXT, .value = &scene_output, .shown = "FILE.scene.vtp",
         .help = "where the scene goes"},
        {.name = "text", .kind = OPTION_FLAG, .value = &ascii, .help = "write numbers as text"},
        {.name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .value = &quiet, .help = "no warnings"},
        {0}};
    struct program program = {
        .name = "probe-vtk",
        .usage = "[OPTION]... -o FILE.vtu [STREAM]",
        .summary = "Writes the probes and tetrahedra of STREAM (standard input) for ParaView: every column as a\n"
                   "named array, luminance and its gradients, quality and crossed edges of the cells.",
        .groups = {rows},
        .operands_most = 1};
    struct warnings warnings = {0};
    struct stream *stream = NULL;
    char *derived_name = NULL;
    struct error *err = options_parse(&program, argc, argv);
    if (!err && !output)
        err = error_usage("expected --output FILE.vtu");
    if (!err && scene_output && !scene)
        err = error_usage("--scene-output needs --scene");
    if (!err && scene && !scene_output && !strcmp(output, "-"))
        err = error_usage("--scene needs --scene-output where the output is standard output");
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    if (!err)
        err = stream_read(&stream, input);
    if (!err)
        err = write_grid(stream, output, ascii, &warnings);
    if (!err && scene && !scene_output)
        err = scene_name(output, &derived_name);
    if (!err && scene)
        err = write_scene(scene, scene_output ? scene_output : derived_name, ascii, &warnings);
    if (!quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    free(derived_name);
    stream_destroy(stream);
    program_clear(&program);
    return error_exit(program.name, err);
}
