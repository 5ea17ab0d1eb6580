/* SPDX-License-Identifier: Apache-2.0 */
/* Faces as files have them, made into a mesh of triangles. */
#include "import/import.h"
#include "import/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a face can be used; a warning or an error says why not. */
static struct error *check_face(struct scene_import *import, const struct scene_polygons *polygons,
                                size_t face, size_t first, bool *usable)
{
    const uint32_t size = polygons->size[face];
    *usable = size >= 3;
    if (!*usable && polygons->edges) {
        warnings_add(import->warnings, "faces of fewer than 3 corners",
                     "%s: face %zu has %u corners, a point or an edge: left out", import->path,
                     face + 1, (unsigned)size);
        return NULL;
    }
    if (!*usable)
        return scene_import_broken(
            import, "faces of fewer than 3 corners", polygons->line ? polygons->line[face] : 0,
            "face %zu has %u corners, expected 3 or more", face + 1, (unsigned)size);
    for (size_t k = first; k < first + size; k++) {
        const size_t vertex = polygons->corner[k];
        const double *p = vertex < polygons->vertex_count ? polygons->position + 3 * vertex : NULL;
        if (p && isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]))
            continue;
        *usable = false;
        if (p)
            return scene_import_broken(
                import, "vertex not finite", polygons->line ? polygons->line[face] : 0,
                "face %zu has a corner at %g %g %g", face + 1, p[0], p[1], p[2]);
        return scene_import_broken(import, "index out of range",
                                   polygons->line ? polygons->line[face] : 0,
                                   "face %zu has a corner that is not among the %zu vertices",
                                   face + 1, polygons->vertex_count);
    }
    return NULL;
}

/* Adds the triangles of one face to a mesh that has room for them. */
static void split_face(struct scene_mesh *mesh, struct polygon_room *room,
                       const struct scene_polygons *polygons, size_t face, size_t first)
{
    const uint32_t size = polygons->size[face];
    for (size_t k = 0; k < size; k++)
        memcpy(room->corner + 3 * k, polygons->position + 3 * (size_t)polygons->corner[first + k],
               3 * sizeof *room->corner);
    polygon_split(room, size);
    for (size_t k = 0; k < 3 * (size_t)(size - 2); k++) {
        const size_t from = first + room->triangle[k], to = 3 * mesh->triangle_count + k;
        mesh->index[to] = polygons->corner[from];
        if (polygons->uv)
            memcpy(mesh->uv + 2 * to, polygons->uv + 2 * from, 2 * sizeof *mesh->uv);
    }
    for (size_t t = 0; t < size - 2; t++)
        mesh->material[mesh->triangle_count++] = polygons->material[face];
}

/* -- colours of faces -------------------------------------------------------------------------- */

/* Vertices by their place and colour. */
struct splitting {
    uint16_t *colour; /* owned: four a vertex */
    bool *taken;      /* owned: by vertex of the file, whether a face has coloured it */
    uint32_t *next;   /* owned: by vertex, another one in its place, or 0 */
    size_t capacity[3];
};

static bool same_colour(const uint16_t a[4], const uint16_t b[4])
{
    return !memcmp(a, b, 4 * sizeof *a);
}

/* Adds a vertex in the place of another. */
static struct error *add_twin(struct scene_mesh *mesh, struct splitting *s, uint32_t vertex,
                              const uint16_t colour[4], uint32_t *twin)
{
    const size_t count = mesh->vertex_count + 1;
    struct error *err = count < UINT32_MAX ? NULL : error_new("more than 2^32 vertices");
    if (!err)
        err = array_reserve(&mesh->position, &s->capacity[0], count, 3 * sizeof *mesh->position);
    if (!err)
        err = array_reserve(&s->colour, &s->capacity[1], count, 4 * sizeof *s->colour);
    if (!err)
        err = array_reserve(&s->next, &s->capacity[2], count, sizeof *s->next);
    if (err)
        return err;
    *twin = (uint32_t)mesh->vertex_count++;
    memcpy(mesh->position + 3 * (size_t)*twin, mesh->position + 3 * (size_t)vertex,
           3 * sizeof *mesh->position);
    memcpy(s->colour + 4 * (size_t)*twin, colour, 4 * sizeof *colour);
    s->next[*twin] = s->next[vertex];
    s->next[vertex] = *twin;
    return NULL;
}

/* Makes a corner's vertex one of this colour: itself, one that stands in its place, or a new one.
 */
static struct error *colour_corner(struct scene_mesh *mesh, struct splitting *s, uint32_t *corner,
                                   const uint16_t colour[4])
{
    const uint32_t vertex = *corner;
    if (!s->taken[vertex]) {
        s->taken[vertex] = true;
        memcpy(s->colour + 4 * (size_t)vertex, colour, 4 * sizeof *colour);
    }
    while (!same_colour(s->colour + 4 * (size_t)*corner, colour)) {
        *corner = s->next[*corner];
        if (!*corner)
            return add_twin(mesh, s, vertex, colour, corner);
    }
    return NULL;
}

/* Colours the vertices by their faces; those between faces of different colours become several.
 * face: of each triangle. */
static struct error *colour_faces(struct scene_import *import, struct scene_mesh *mesh,
                                  const struct scene_polygons *polygons, const uint32_t *face,
                                  bool *blended)
{
    struct splitting s = {.capacity = {mesh->vertex_count, mesh->vertex_count, mesh->vertex_count}};
    uint16_t *colour = NULL;
    struct error *err =
        scene_import_colours(import, polygons->face_colour, polygons->count, &colour, blended);
    if (!err)
        err = array_create(&s.colour, 4 * mesh->vertex_count, sizeof *s.colour);
    if (!err)
        err = array_create(&s.taken, mesh->vertex_count, sizeof *s.taken);
    if (!err)
        err = array_create(&s.next, mesh->vertex_count, sizeof *s.next);
    for (size_t k = 0; k < 3 * mesh->triangle_count && !err; k++)
        err = colour_corner(mesh, &s, &mesh->index[k], colour + 4 * (size_t)face[k / 3]);
    free(s.taken);
    free(s.next);
    free(colour);
    mesh->colour = s.colour;
    return err;
}

/* Gives a mesh the colours of its vertices or faces; what is not opaque is blended. */
static struct error *colour_mesh(struct scene_import *import, struct scene_mesh *mesh,
                                 const struct scene_polygons *polygons, const uint32_t *face)
{
    bool blended = false;
    struct error *err = NULL;
    if (polygons->colour && polygons->colour->count)
        err = scene_import_colours(import, polygons->colour, mesh->vertex_count, &mesh->colour,
                                   &blended);
    else if (face)
        err = colour_faces(import, mesh, polygons, face, &blended);
    for (size_t t = 0; t < mesh->triangle_count && blended && !err; t++) {
        struct scene_material *m = &import->scene->materials[mesh->material[t]];
        if (m->alpha == SCENE_OPAQUE)
            m->alpha = SCENE_BLEND;
    }
    return err;
}

/* The face of each triangle, where faces have colours that count; else *face is NULL. */
static struct error *find_faces(const struct scene_polygons *polygons, size_t most, uint32_t **face)
{
    const bool by_vertex = polygons->colour && polygons->colour->count;
    if (by_vertex || !polygons->face_colour || !polygons->face_colour->count)
        return NULL;
    return array_create(face, most, sizeof **face);
}

/* -- polygons --------------------------------------------------------------------------------- */

/* Adds the runs that begin with a face, whose triangles come next. */
static void add_runs(struct scene_mesh *mesh, const struct scene_polygons *polygons, size_t face)
{
    for (const struct scene_run *run = polygons->runs + mesh->run_count;
         mesh->run_count < polygons->run_count && run->first == face; run++)
        mesh->runs[mesh->run_count++] =
            (struct scene_run){.first = mesh->triangle_count, .part = run->part};
}

struct error *scene_import_polygons(struct scene_import *import,
                                    const struct scene_polygons *polygons)
{
    size_t most = 0;
    for (size_t f = 0; f < polygons->count; f++)
        most += polygons->size[f] > 2 ? polygons->size[f] - 2 : 0;
    struct scene_mesh mesh = {.vertex_count = polygons->vertex_count};
    struct polygon_room room = {0};
    uint32_t *face = NULL;
    struct error *err = array_create(&mesh.position, 3 * mesh.vertex_count, sizeof *mesh.position);
    if (!err)
        err = array_create(&mesh.index, 3 * most, sizeof *mesh.index);
    if (!err)
        err = array_create(&mesh.material, most, sizeof *mesh.material);
    if (!err && polygons->uv)
        err = array_create(&mesh.uv, 6 * most, sizeof *mesh.uv);
    if (!err)
        err = find_faces(polygons, most, &face);
    if (!err && polygons->run_count)
        err = array_create(&mesh.runs, polygons->run_count, sizeof *mesh.runs);
    if (!err && mesh.vertex_count)
        memcpy(mesh.position, polygons->position, 3 * mesh.vertex_count * sizeof *mesh.position);
    for (size_t f = 0, first = 0; f < polygons->count && !err; first += polygons->size[f++]) {
        bool usable = false;
        add_runs(&mesh, polygons, f);
        err = check_face(import, polygons, f, first, &usable);
        if (err || !usable)
            continue;
        err = polygon_room_for(&room, polygons->size[f]);
        const size_t before = mesh.triangle_count;
        if (!err)
            split_face(&mesh, &room, polygons, f, first);
        for (size_t t = before; t < mesh.triangle_count && face; t++)
            face[t] = (uint32_t)f;
    }
    if (!err)
        add_runs(&mesh, polygons, polygons->count);
    polygon_room_clear(&room);
    if (!err)
        err = colour_mesh(import, &mesh, polygons, face);
    free(face);
    size_t place = 0;
    if (err)
        scene_mesh_clear(&mesh);
    else
        err = scene_push_mesh(import->scene, mesh, &place);
    return err ? err : scene_push_instance(import->scene, place, scene_identity);
}

/* -- faces one by one ------------------------------------------------------------------------- */

struct error *scene_faces_vertex(struct scene_faces *faces, double x, double y, double z)
{
    struct error *err = array_reserve(&faces->position, &faces->vertex_capacity,
                                      faces->vertex_count + 1, 3 * sizeof *faces->position);
    if (err)
        return err;
    double *to = faces->position + 3 * faces->vertex_count++;
    to[0] = x;
    to[1] = y;
    to[2] = z;
    return NULL;
}

struct error *scene_faces_begin(struct scene_faces *faces)
{
    struct error *err =
        array_reserve(&faces->size, &faces->capacity, faces->count + 1, sizeof *faces->size);
    if (!err)
        faces->size[faces->count++] = 0;
    return err;
}

struct error *scene_faces_corner(struct scene_faces *faces, uint32_t vertex)
{
    struct error *err = array_reserve(&faces->corner, &faces->corner_capacity,
                                      faces->corner_count + 1, sizeof *faces->corner);
    if (err)
        return err;
    faces->corner[faces->corner_count++] = vertex;
    faces->size[faces->count - 1]++;
    return NULL;
}

struct error *scene_import_faces(struct scene_import *import, const struct scene_faces *faces)
{
    struct scene_material grey = scene_material_default();
    int32_t *material = NULL, number = 0;
    const float albedo = 0.8f;
    struct scene_colours of_vertex = faces->vertex_colour, of_face = faces->face_colour;
    of_vertex.unstated = of_face.unstated = albedo;
    if (!of_vertex.count && !of_face.count)
        grey.albedo = (struct vec3f){albedo, albedo, albedo};
    struct error *err = scene_push_material(import->scene, grey, &number);
    if (!err)
        err = array_create(&material, faces->count, sizeof *material);
    for (size_t f = 0; f < faces->count && !err; f++)
        material[f] = number;
    if (!err)
        err = scene_import_polygons(import,
                                    &(struct scene_polygons){.position = faces->position,
                                                             .vertex_count = faces->vertex_count,
                                                             .size = faces->size,
                                                             .count = faces->count,
                                                             .corner = faces->corner,
                                                             .material = material,
                                                             .edges = faces->edges,
                                                             .colour = &of_vertex,
                                                             .face_colour = &of_face});
    free(material);
    return err;
}

void scene_faces_clear(struct scene_faces *faces)
{
    free(faces->position);
    free(faces->size);
    free(faces->corner);
    scene_colours_clear(&faces->vertex_colour);
    scene_colours_clear(&faces->face_colour);
    *faces = (struct scene_faces){0};
}
