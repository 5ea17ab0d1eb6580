/* SPDX-License-Identifier: Apache-2.0 */
#include "vtk/vtk_probes.h"
#include "base/error.h"
#include "base/warning.h"
#include "image/display.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "stream/cells.h"
#include "stream/light_columns.h"
#include "stream/stream.h"
#include "vtk/vtk_derive.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { NAME_ROOM = 24 };

/* -- columns ---------------------------------------------------------------------------------- */

/* Names of the components of an SH column, L00.r, L00.g, ..., L1-1.r, ...; of a gradient's,
 * L00.r.x. */
static struct error *sh_names(struct vtk_fields *fields, size_t width, bool gradient,
                              const char *const **names)
{
    char **list = NULL, *text = NULL;
    struct error *err = vtk_fields_own(fields, width, sizeof *list, &list);
    if (!err)
        err = vtk_fields_own(fields, width, NAME_ROOM, &text);
    const size_t one = gradient ? width / 3 : width; /* values of one direction */
    for (size_t i = 0; i < width && !err; i++) {
        const size_t coefficient = i % one / 3;
        int l = 0;
        while ((size_t)((l + 1) * (l + 1)) <= coefficient)
            l++;
        list[i] = text + i * NAME_ROOM;
        const int length = snprintf(list[i], NAME_ROOM, "L%d%d.%c", l,
                                    (int)coefficient - l * (l + 1), "rgb"[i % 3]);
        if (gradient)
            snprintf(list[i] + length, NAME_ROOM - (size_t)length, ".%c", "xyz"[i / one]);
    }
    *names = (const char *const *)list;
    return err;
}

static struct error *component_names(struct vtk_fields *fields, const struct table *table,
                                     const struct column *c, const char *const **names)
{
    const struct column *sh = table_column(table, "sh");
    struct light_column what;
    static const char *const vector[] = {"x", "y", "z"}, *const edges[] = {"01", "02", "03",
                                                                           "12", "13", "23"},
                             *const edges_of_three[] = {"01", "02", "12"};
    if (light_column_of(c, sh ? sh->width : 0, &what) && !what.surface && !what.transfer)
        return sh_names(fields, c->width, what.role == LIGHT_GRADIENT, names);
    if (c->width == 3 && c->type != COLUMN_I32)
        *names = vector;
    if (!strcmp(c->name, "occlusion") && c->width == 6)
        *names = edges;
    if (!strcmp(c->name, "occlusion") && c->width == 3)
        *names = edges_of_three;
    return NULL;
}

static bool is_missing(const struct column *c, size_t i)
{
    return c->type == COLUMN_F32 ? isnan(column_f32(c)[i])
                                 : c->type == COLUMN_F64 && isnan(column_f64(c)[i]);
}

/* The column's data; where values are missing a copy in which they are 0. */
static struct error *present(struct vtk_fields *fields, const struct table *table,
                             const struct column *c, const void **data, struct warnings *warnings)
{
    *data = c->data;
    size_t missing = 0; /* a row misses all its values or none */
    for (size_t row = 0; row < table->rows; row++)
        missing += is_missing(c, row * c->width);
    if (!missing)
        return NULL;
    warnings_add(warnings, "missing",
                 "table %s: column %s: %zu of %zu values are missing: 0 is written", table->name,
                 c->name, missing, table->rows);
    const size_t size = column_type_size(c->type), bytes = c->width * size;
    char *copy = NULL;
    struct error *err = vtk_fields_own(fields, table->rows * c->width, size, &copy);
    for (size_t row = 0; row < table->rows && !err; row++)
        if (!is_missing(c, row * c->width))
            memcpy(copy + row * bytes, (const char *)c->data + row * bytes, bytes);
    *data = copy;
    return err;
}

static struct error *add_columns(struct vtk_fields *fields, const struct table *table,
                                 struct warnings *warnings)
{
    static const enum vtk_type types[] = {[COLUMN_F32] = VTK_EXPORT_F32,
                                          [COLUMN_F64] = VTK_EXPORT_F64,
                                          [COLUMN_I32] = VTK_EXPORT_I32};
    struct error *err = NULL;
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        struct vtk_array array = {.name = c->name, .type = types[c->type], .width = c->width};
        err = component_names(fields, table, c, &array.components);
        if (!err)
            err = present(fields, table, c, &array.data, warnings);
        if (!err)
            err = vtk_fields_add(fields, array);
    }
    return err;
}

/* -- derived arrays --------------------------------------------------------------------------- */

/* What the light at each probe looks like. *luminance, for gradients, lives as long as the mesh. */
static struct error *add_light(struct vtk_probes *vtk, const struct table *probes,
                               const struct column *sh, bool convolved, double *exposure,
                               float **luminance)
{
    const size_t n = probes->rows;
    const int order = sh_order_of(sh->width);
    const struct column *sh_gradient = table_column(probes, "sh_gradient");
    float *irradiance = NULL, *brightest = NULL, *gradient = NULL;
    uint8_t *colour = NULL;
    int32_t *captured = NULL;
    struct error *err =
        vtk_fields_add_new(&vtk->points, "irradiance", VTK_EXPORT_F32, 3, n, &irradiance);
    if (!err)
        err = vtk_fields_add_new(&vtk->points, "luminance", VTK_EXPORT_F32, 1, n, luminance);
    if (!err)
        err = vtk_fields_add_new(&vtk->points, "colour", VTK_EXPORT_U8, 3, n, &colour);
    if (!err)
        err = vtk_fields_add_new(&vtk->points, "brightest", VTK_EXPORT_F32, 3, n, &brightest);
    if (!err)
        err = vtk_fields_add_new(&vtk->points, "captured", VTK_EXPORT_I32, 1, n, &captured);
    if (!err && sh_gradient)
        err = vtk_fields_add_new(&vtk->points, "sh_luminance_gradient", VTK_EXPORT_F32, 3, n,
                                 &gradient);
    if (err)
        return err;
    vtk_derive_irradiance(n, order, convolved, column_f32(sh), irradiance);
    vtk_derive_luminance(n, irradiance, *luminance);
    vtk_derive_brightest(n, order, convolved, column_f32(sh), brightest);
    if (sh_gradient)
        vtk_derive_sh_luminance_gradient(n, sh_order_of(sh_gradient->width / 3), convolved,
                                         column_f32(sh_gradient), gradient);
    for (size_t i = 0; i < n; i++)
        captured[i] = !is_missing(sh, i * sh->width);
    if (*exposure <= 0)
        err = display_exposure(n, *luminance, exposure);
    if (!err)
        display_codes(n, irradiance, *exposure, colour);
    return err;
}

static struct error *add_gradients(struct vtk_probes *vtk, const float *luminance)
{
    const struct vtk_mesh *m = &vtk->mesh;
    float *of_points = NULL, *of_cells = NULL;
    static const char name[] = "luminance_gradient";
    struct error *err =
        vtk_fields_add_new(&vtk->points, name, VTK_EXPORT_F32, 3, m->point_count, &of_points);
    if (!err)
        err = vtk_fields_add_new(&vtk->cells, name, VTK_EXPORT_F32, 3, m->cell_count, &of_cells);
    if (err)
        return err;
    vtk_derive_cell_gradient(m, luminance, of_cells);
    return vtk_derive_point_gradient(m, of_cells, of_points);
}

/* Where the hull is: a face (an edge, an end) is on it where there is no neighbour, and so are its
 * probes. */
static struct error *add_hull(struct vtk_probes *vtk, const int32_t *neighbour)
{
    const struct vtk_mesh *mesh = &vtk->mesh;
    int32_t *faces = NULL, *probes = NULL;
    struct error *err =
        vtk_fields_add_new(&vtk->cells, "hull_faces", VTK_EXPORT_I32, 1, mesh->cell_count, &faces);
    if (!err)
        err =
            vtk_fields_add_new(&vtk->points, "hull", VTK_EXPORT_I32, 1, mesh->point_count, &probes);
    const size_t corners = (size_t)mesh->corners;
    for (size_t i = 0; i < corners * mesh->cell_count && !err; i++) {
        if (neighbour[i] >= 0)
            continue;
        const size_t cell = i / corners;
        faces[cell]++;
        for (size_t corner = corners * cell; corner < corners * (cell + 1); corner++)
            if (corner != i)
                probes[mesh->vertex[corner]] = 1;
    }
    return err;
}

/* How many edges of each cell pass through a surface, and how many of these leak (man
 * probe-leakfix). */
static struct error *add_leaks(struct vtk_probes *vtk, const struct column *occlusion)
{
    const size_t count = vtk->mesh.cell_count;
    int32_t *crossed = NULL, *leaking = NULL;
    struct error *err =
        vtk_fields_add_new(&vtk->cells, "crossed_edges", VTK_EXPORT_I32, 1, count, &crossed);
    if (!err)
        err = vtk_fields_add_new(&vtk->cells, "leaking_edges", VTK_EXPORT_I32, 1, count, &leaking);
    for (size_t i = 0; i < occlusion->width * count && !err; i++) {
        crossed[i / occlusion->width] += column_i32(occlusion)[i] > 0;
        leaking[i / occlusion->width] += column_i32(occlusion)[i] == 2;
    }
    return err;
}

/* How far the probes of each cell see towards each other: the share of the way that is free where
 * least is, 1 where nothing stands in the cell (man probe-leakfix). Missing values say nothing. */
static struct error *add_sight(struct vtk_probes *vtk, const float *sight)
{
    const size_t count = vtk->mesh.cell_count,
                 width = (size_t)(vtk->mesh.corners * (vtk->mesh.corners - 1));
    float *free_way = NULL;
    struct error *err =
        vtk_fields_add_new(&vtk->cells, "free_way", VTK_EXPORT_F32, 1, count, &free_way);
    for (size_t i = 0; i < count && !err; i++) {
        float most = 1;
        for (size_t k = 0; k < width; k++)
            most = sight[width * i + k] > most ? sight[width * i + k] : most;
        free_way[i] = 1 / most;
    }
    return err;
}

/* Keys under their names, the command lines as Provenance: a name that no key can have. */
static struct error *add_texts(struct vtk_probes *vtk, const struct stream_header *header,
                               double exposure)
{
    struct vtk_text *texts = NULL;
    char *number = NULL;
    const char **lines = NULL;
    struct error *err = vtk_fields_own(&vtk->points, header->key_count + 2, sizeof *texts, &texts);
    if (!err)
        err = vtk_fields_own(&vtk->points, 1, NAME_ROOM, &number);
    if (!err)
        err = vtk_fields_own(&vtk->points, header->key_count + 1, sizeof *lines, &lines);
    if (err)
        return err;
    size_t count = 0;
    for (size_t i = 0; i < header->key_count; i++) {
        lines[i] = header->keys[i].value;
        texts[count++] =
            (struct vtk_text){.name = header->keys[i].name, .lines = &lines[i], .line_count = 1};
    }
    if (exposure > 0) {
        snprintf(number, NAME_ROOM, "%.9g", exposure);
        lines[header->key_count] = number;
        texts[count++] = (struct vtk_text){
            .name = "Exposure", .lines = &lines[header->key_count], .line_count = 1};
    }
    if (header->provenance_count)
        texts[count++] = (struct vtk_text){.name = "Provenance",
                                           .lines = (const char *const *)header->provenance,
                                           .line_count = header->provenance_count};
    vtk->mesh.texts = texts;
    vtk->mesh.text_count = count;
    return NULL;
}

/* The quality of cells; volumes, areas and aspects are VTK's (vtk_export.h). */
static struct error *add_quality(struct vtk_probes *vtk)
{
    const struct vtk_mesh *m = &vtk->mesh;
    float *angle = NULL;
    double *length = NULL;
    struct error *err = NULL;
    const char *name = m->corners == 4 ? "min_dihedral" : "min_angle";
    if (m->corners >= 3)
        err = vtk_fields_add_new(&vtk->cells, name, VTK_EXPORT_F32, 1, m->cell_count, &angle);
    if (m->corners == 2)
        err = vtk_fields_add_new(&vtk->cells, "length", VTK_EXPORT_F64, 1, m->cell_count, &length);
    if (!err && m->corners == 4)
        vtk_derive_min_dihedral(m->cell_count, m->vertex, m->position, angle);
    if (!err && m->corners == 3)
        vtk_derive_min_angle(m->cell_count, m->vertex, m->position, angle);
    if (!err && m->corners == 2)
        vtk_derive_length(m->cell_count, m->vertex, m->position, length);
    return err;
}

static struct error *add_cells(struct vtk_probes *vtk, const struct cells *cells,
                               struct warnings *warnings)
{
    const struct column *occlusion = table_column(cells->table, "occlusion");
    vtk->mesh.cell_count = cells->table->rows;
    vtk->mesh.corners = cells->corners;
    vtk->mesh.vertex = cells->vertex;
    struct error *err = add_columns(&vtk->cells, cells->table, warnings);
    if (!err)
        err = add_quality(vtk);
    if (!err && cells->neighbour)
        err = add_hull(vtk, cells->neighbour);
    if (!err && occlusion && occlusion->type == COLUMN_I32)
        err = add_leaks(vtk, occlusion);
    if (!err && cells->sight)
        err = add_sight(vtk, cells->sight);
    return err;
}

struct error *vtk_probes_init(struct vtk_probes *vtk, const struct stream *stream, double exposure,
                              struct warnings *warnings)
{
    *vtk = (struct vtk_probes){0};
    const struct table *probes = stream_table(stream, "probe");
    struct cells cells = {0};
    if (!probes || !probes->rows)
        return error_new("there are no probes to show");
    for (size_t i = 0; i < stream->table_count; i++)
        if (&stream->tables[i] != probes && !stream_cell_corners(stream->tables[i].name))
            warnings_add(warnings, "table", "table %s has no shape: it is left out",
                         stream->tables[i].name);
    const struct column *sh = table_column(probes, "sh");
    bool convolved = false;
    float *luminance = NULL;
    vtk->mesh.point_count = probes->rows;
    vtk->mesh.position = column_f64(table_column(probes, "position"));
    struct error *err = content_from_header(&stream->header, &convolved);
    if (!err)
        err = add_columns(&vtk->points, probes, warnings);
    if (!err && cells_exist(stream))
        err = cells_find(stream, &cells);
    if (!err && cells.table && cells.table->rows)
        err = add_cells(vtk, &cells, warnings);
    if (!err && sh)
        err = add_light(vtk, probes, sh, convolved, &exposure, &luminance);
    else if (!err)
        warnings_add(warnings, "no light",
                     "the probes have no light (no column sh): nothing is derived from it");
    if (!err && sh && vtk->mesh.cell_count && vtk->mesh.corners > 1)
        err = add_gradients(vtk, luminance);
    if (!err)
        err = add_texts(vtk, &stream->header, sh ? exposure : 0);
    vtk->mesh.point_arrays = vtk->points.list;
    vtk->mesh.point_array_count = vtk->points.count;
    vtk->mesh.cell_arrays = vtk->cells.list;
    vtk->mesh.cell_array_count = vtk->cells.count;
    if (err)
        vtk_probes_clear(vtk);
    return err;
}

void vtk_probes_clear(struct vtk_probes *vtk)
{
    vtk_fields_clear(&vtk->points);
    vtk_fields_clear(&vtk->cells);
    *vtk = (struct vtk_probes){0};
}
