/* SPDX-License-Identifier: Apache-2.0 */
/* Vertices of a surface with the faces between them (stream/faces.h). */
#include "base/array.h"
#include "base/error.h"
#include "math/vec.h"
#include "place/place.h"
#include "place/vertices.h"
#include "scene/scene.h"
#include "stream/faces.h"

#include <stdbool.h>

/* side 1: of the front, -1: of the back. */
static struct error *append_vertices(struct place *place, const struct vertices *vertices,
                                     double offset, double side)
{
    struct column *surface = table_column(&place->columns, "surface");
    struct error *err = NULL;
    for (size_t i = 0; i < vertices->count && !err; i++) {
        const struct vertex *v = &vertices->list[i];
        const size_t row = place->count;
        double p[3];
        vec3_store(p, vec3_fma(vec3_load(v->position), side * offset, vec3_load(v->normal)));
        for (size_t k = 0; k < 3; k++) {
            place->normal[3 * row + k] = (float)(side * v->normal[k]);
            column_f64(surface)[3 * row + k] = v->position[k];
        }
        err = place_append(place, p);
    }
    return err;
}

/* Faces of the front begin at row 0 and vertex 0, those of the back behind them. */
static void append_faces(struct table *faces, const struct scene *scene,
                         const struct vertices *vertices, bool back)
{
    int32_t *vertex = column_i32(table_column(faces, "vertex")),
            *of_triangle = column_i32(table_column(faces, "triangle")),
            *of_instance = column_i32(table_column(faces, "instance"));
    size_t row = back ? faces->rows / 2 : 0, triangle = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const size_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        for (size_t t = 0; t < count; t++, triangle++) {
            const size_t *corner = vertices->of_corner + 3 * triangle;
            if (*corner == SIZE_MAX)
                continue;
            for (size_t c = 0; c < 3; c++)
                vertex[3 * row + c] =
                    (int32_t)(corner[back ? 2 - c : c] + (back ? vertices->count : 0));
            of_triangle[row] = (int32_t)triangle;
            of_instance[row++] = (int32_t)i;
        }
    }
}

static struct error *make_faces(struct place *place, const struct scene *scene,
                                const struct vertices *vertices, size_t sides)
{
    size_t count = 0;
    for (size_t i = 0; i < vertices->corners; i += 3)
        count += vertices->of_corner[i] != SIZE_MAX;
    struct table *faces = &place->faces;
    struct error *err = table_init(faces, FACES_TABLE);
    if (!err)
        err = table_add_column(faces, "vertex", COLUMN_I32, 3, NULL);
    if (!err)
        err = table_add_column(faces, "triangle", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_add_column(faces, "instance", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_resize(faces, sides * count);
    for (size_t side = 0; side < sides && !err; side++)
        append_faces(faces, scene, vertices, side);
    return err;
}

struct error *place_faces(struct place *place, const struct scene *scene, double offset,
                          double crease, enum place_sides sides, double most)
{
    const size_t count = sides == PLACE_BOTH ? 2 : 1;
    struct vertices vertices = {0};
    struct error *err = vertices_find(scene, crease, &vertices);
    if (!err && !vertices.count)
        err = error_new("no face of the scene has an area: there are no vertices");
    if (!err)
        err = place_check_count((double)(count * vertices.count), most);
    if (!err)
        err = array_create(&place->normal, 3 * count * vertices.count, sizeof *place->normal);
    if (!err)
        err = place_add_column(place, "surface", COLUMN_F64, 3, NULL);
    if (!err)
        err = table_resize(&place->columns, count * vertices.count);
    for (size_t side = 0; side < count && !err; side++)
        err = append_vertices(place, &vertices, offset, side ? -1 : 1);
    if (!err)
        err = make_faces(place, scene, &vertices, count);
    vertices_clear(&vertices);
    return err;
}
