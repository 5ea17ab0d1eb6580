/* SPDX-License-Identifier: Apache-2.0 */
#include "export/export_mesh.h"
#include "base/array.h"
#include "base/error.h"
#include "stream/faces.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- the colour ------------------------------------------------------------------------------- */

static struct error *find_column(const struct table *probes, const char *name,
                                 const struct column **column)
{
    *column = table_column(probes, name ? name : "irradiance");
    if (!*column && !name)
        *column = table_column(probes, "ao");
    if (!*column && name)
        return error_new("there is no column %s", name);
    if (!*column)
        return error_new("there is neither irradiance nor ao (--colour names another column)");
    if ((*column)->type != COLUMN_F32 || ((*column)->width != 1 && (*column)->width != 3))
        return error_new("column %s: expected f32:1 or f32:3 for a colour, got %s:%zu",
                         (*column)->name, column_type_name((*column)->type), (*column)->width);
    return NULL;
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* What brings the brightest colour of 99 of 100 probes to 1 at most. */
static struct error *find_scale(const struct column *column, size_t rows, double *scale)
{
    float *brightest = NULL;
    size_t count = 0;
    struct error *err = array_create(&brightest, rows, sizeof *brightest);
    for (size_t i = 0; i < rows && !err; i++) {
        const float *v = column_f32(column) + column->width * i;
        float most = v[0];
        for (size_t k = 1; k < column->width; k++)
            most = v[k] > most ? v[k] : most;
        if (most > 0)
            brightest[count++] = most;
    }
    if (!err)
        qsort(brightest, count, sizeof *brightest, compare_floats);
    *scale = count ? 1 / (double)brightest[(count - 1) * 99 / 100] : 1;
    free(brightest);
    return err;
}

static bool is_light(const struct column *column)
{
    struct light_column what;
    return light_column_of(column, 0, &what);
}

/* -- parts ------------------------------------------------------------------------------------ */

/* The faces in the order of their instances; what is not told is one instance. */
struct order {
    int32_t instance;
    uint32_t face;
};

static int compare_order(const void *left, const void *right)
{
    const struct order *a = left, *b = right;
    return a->instance != b->instance ? (a->instance < b->instance ? -1 : 1)
                                      : (a->face > b->face) - (a->face < b->face);
}

static struct error *sort_faces(const struct faces *faces, struct order **order)
{
    struct error *err = array_create(order, faces->count, sizeof **order);
    for (size_t i = 0; i < faces->count && !err; i++)
        (*order)[i] = (struct order){faces->instance ? faces->instance[i] : -1, (uint32_t)i};
    if (!err && faces->count)
        qsort(*order, faces->count, sizeof **order, compare_order);
    return err;
}

/* What a mesh is made of. */
struct making {
    struct export_mesh *mesh;
    const struct faces *faces;
    const struct column *column;
    /* of each probe: the part that has it last, counted from 1, and its number there */
    struct seen {
        uint32_t part, number;
    } * seen;
};

static void take_colour(const struct making *m, size_t row, float *rgb)
{
    const float *v = column_f32(m->column) + m->column->width * row;
    bool clipped = false;
    for (size_t k = 0; k < 3; k++) {
        const float value = v[m->column->width == 3 ? k : 0];
        const double scaled = isnan(value) ? 0 : m->mesh->scale * (double)value;
        clipped = clipped || scaled > 1 || scaled < 0;
        rgb[k] = scaled > 1 ? 1 : scaled > 0 ? (float)scaled : 0;
    }
    m->mesh->clipped += clipped;
    m->mesh->unknown += isnan(*v) ? 1 : 0;
}

static void take_vertex(const struct making *m, size_t row)
{
    struct export_mesh *mesh = m->mesh;
    const size_t to = 3 * mesh->vertices++;
    for (size_t k = 0; k < 3; k++)
        mesh->position[to + k] = (float)m->faces->surface[3 * row + k];
    memcpy(mesh->normal + to, m->faces->normal + 3 * row, 3 * sizeof(float));
    take_colour(m, row, mesh->colour + to);
}

static void take_face(const struct making *m, size_t face)
{
    struct export_mesh *mesh = m->mesh;
    struct export_part *part = &mesh->part[mesh->parts - 1];
    for (size_t c = 0; c < 3; c++) {
        const size_t row = (size_t)m->faces->vertex[3 * face + c];
        struct seen *seen = &m->seen[row];
        if (seen->part != mesh->parts) {
            *seen = (struct seen){(uint32_t)mesh->parts, (uint32_t)part->vertices++};
            take_vertex(m, row);
        }
        mesh->index[3 * mesh->triangles + c] = seen->number;
    }
    mesh->triangles++;
    part->triangles++;
}

static struct error *take_faces(struct making *m)
{
    struct export_mesh *mesh = m->mesh;
    struct order *order = NULL;
    struct error *err = sort_faces(m->faces, &order);
    for (size_t i = 0; i < m->faces->count && !err; i++) {
        if (!i || order[i].instance != order[i - 1].instance)
            mesh->part[mesh->parts++] =
                (struct export_part){order[i].instance, mesh->vertices, 0, mesh->triangles, 0};
        take_face(m, order[i].face);
    }
    free(order);
    return err;
}

/* Room for the most that there can be: three vertices a face, a part a face. */
static struct error *make_room(struct making *m)
{
    struct export_mesh *mesh = m->mesh;
    const size_t count = m->faces->count;
    struct error *err = array_create(&mesh->position, 9 * count, sizeof(float));
    if (!err)
        err = array_create(&mesh->normal, 9 * count, sizeof(float));
    if (!err)
        err = array_create(&mesh->colour, 9 * count, sizeof(float));
    if (!err)
        err = array_create(&mesh->index, 3 * count, sizeof *mesh->index);
    if (!err)
        err = array_create(&mesh->part, count, sizeof *mesh->part);
    return err ? err : array_create(&m->seen, m->faces->vertices, sizeof *m->seen);
}

/* Backs follow the fronts, of the same triangles. */
static bool has_backs(const struct faces *faces)
{
    return faces->triangle && faces->count && faces->count % 2 == 0 &&
           faces->triangle[0] == faces->triangle[faces->count / 2];
}

struct error *export_mesh_make(struct export_mesh *mesh, const struct stream *stream,
                               const char *column, double scale)
{
    struct faces faces = {0};
    struct making m = {.mesh = mesh, .faces = &faces};
    struct error *err = faces_of(stream, &faces);
    if (!err && !faces.count)
        err = error_new("table face: expected at least one face, got none");
    if (!err)
        err = find_column(faces.probes, column, &m.column);
    mesh->scale = isnan(scale) ? 1 : scale;
    if (!err && isnan(scale) && is_light(m.column))
        err = find_scale(m.column, faces.vertices, &mesh->scale);
    if (!err)
        err = make_room(&m);
    if (!err)
        err = take_faces(&m);
    mesh->both = !err && has_backs(&faces);
    free(m.seen);
    return err;
}

void export_mesh_clear(struct export_mesh *mesh)
{
    free(mesh->position);
    free(mesh->normal);
    free(mesh->colour);
    free(mesh->index);
    free(mesh->part);
    *mesh = (struct export_mesh){0};
}
