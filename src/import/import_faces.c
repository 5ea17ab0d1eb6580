/* SPDX-License-Identifier: Apache-2.0 */
/* Faces as files have them, made into a mesh of triangles. */
#include "import/import.h"
#include "import/polygon.h"

#include <stdlib.h>
#include <string.h>

/* Whether a face can be used; a warning or an error says why not. */
static struct error *check_face(struct scene_import *import, const struct scene_polygons *polygons,
                                size_t face, size_t first, bool *usable)
{
    const uint32_t size = polygons->size[face];
    *usable = size >= 3;
    if (!*usable) {
        warnings_add(import->warnings, "faces of fewer than 3 corners",
                     "%s: face %zu has %u corners: left out", import->path, face + 1,
                     (unsigned)size);
        return NULL;
    }
    for (size_t k = first; k < first + size; k++) {
        if (polygons->corner[k] < polygons->vertex_count)
            continue;
        *usable = false;
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

struct error *scene_import_polygons(struct scene_import *import,
                                    const struct scene_polygons *polygons)
{
    size_t most = 0;
    for (size_t f = 0; f < polygons->count; f++)
        most += polygons->size[f] > 2 ? polygons->size[f] - 2 : 0;
    struct scene_mesh mesh = {.vertex_count = polygons->vertex_count};
    struct polygon_room room = {0};
    struct error *err = array_create(&mesh.position, 3 * mesh.vertex_count, sizeof *mesh.position);
    if (!err)
        err = array_create(&mesh.index, 3 * most, sizeof *mesh.index);
    if (!err)
        err = array_create(&mesh.material, most, sizeof *mesh.material);
    if (!err && polygons->uv)
        err = array_create(&mesh.uv, 6 * most, sizeof *mesh.uv);
    if (!err && mesh.vertex_count)
        memcpy(mesh.position, polygons->position, 3 * mesh.vertex_count * sizeof *mesh.position);
    for (size_t f = 0, first = 0; f < polygons->count && !err; first += polygons->size[f++]) {
        bool usable = false;
        err = check_face(import, polygons, f, first, &usable);
        if (err || !usable)
            continue;
        err = polygon_room_for(&room, polygons->size[f]);
        if (!err)
            split_face(&mesh, &room, polygons, f, first);
    }
    polygon_room_clear(&room);
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
    grey.albedo = (struct vec3f){0.8f, 0.8f, 0.8f};
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
                                                             .material = material});
    free(material);
    return err;
}

void scene_faces_clear(struct scene_faces *faces)
{
    free(faces->position);
    free(faces->size);
    free(faces->corner);
    *faces = (struct scene_faces){0};
}
