/* SPDX-License-Identifier: Apache-2.0 */
#include "render/object.h"
#include "base/array.h"
#include "base/error.h"
#include "import/import_scene.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* of a sphere: 20 * 4^LEVELS triangles, whose normals are within a degree of its own */
enum { LEVELS = 5 };

/* -- a sphere ---------------------------------------------------------------------------------- */

struct sphere {
    double *position;
    uint32_t *index;
    size_t triangles;
};

/* Splits a triangle of the unit sphere `levels` times into four. */
static void split(struct sphere *s, struct vec3 a, struct vec3 b, struct vec3 c, int levels)
{
    if (!levels) {
        const struct vec3 corner[3] = {a, b, c};
        for (size_t k = 0; k < 3; k++) {
            s->index[3 * s->triangles + k] = (uint32_t)(3 * s->triangles + k);
            vec3_store(s->position + 9 * s->triangles + 3 * k, corner[k]);
        }
        s->triangles++;
        return;
    }
    const struct vec3 ab = vec3_normalize(vec3_add(a, b)), bc = vec3_normalize(vec3_add(b, c)),
                      ca = vec3_normalize(vec3_add(c, a));
    split(s, a, ab, ca, levels - 1);
    split(s, ab, b, bc, levels - 1);
    split(s, ca, bc, c, levels - 1);
    split(s, ab, bc, ca, levels - 1);
}

/* The unit sphere, from an octahedron. */
static struct error *add_sphere(struct scene *scene)
{
    const size_t triangles = (size_t)8 << 2 * LEVELS;
    struct sphere s = {0};
    struct scene_material white = scene_material_default();
    white.albedo = (struct vec3f){0.8f, 0.8f, 0.8f};
    struct error *err = array_create(&s.position, 9 * triangles, sizeof *s.position);
    if (!err)
        err = array_create(&s.index, 3 * triangles, sizeof *s.index);
    for (int i = 0; i < 8 && !err; i++) {
        const struct vec3 x = {i & 1 ? -1 : 1, 0, 0}, y = {0, i & 2 ? -1 : 1, 0},
                          z = {0, 0, i & 4 ? -1 : 1};
        const bool turned = (i ^ i >> 1 ^ i >> 2) & 1;
        split(&s, x, turned ? z : y, turned ? y : z, LEVELS);
    }
    if (!err)
        err = scene_add_mesh(scene, 3 * triangles, s.position, triangles, s.index, &white);
    free(s.position);
    free(s.index);
    return err;
}

/* -- moving a mesh over ------------------------------------------------------------------------ */

static void shift_map(struct scene_map *map, size_t textures)
{
    if (map->texture != SCENE_NONE)
        map->texture += (int32_t)textures;
}

/* Moves what `from` holds, but its lights, to the end of `to`. What was moved is emptied, so that
 * both can be destroyed. */
static struct error *move_over(struct scene *to, struct scene *from)
{
    const size_t textures = to->texture_count, materials = to->material_count,
                 meshes = to->mesh_count;
    struct error *err = NULL;
    for (size_t i = 0; i < from->texture_count && !err; i++) {
        err = scene_push_texture(to, from->textures[i], NULL);
        from->textures[i].texels = NULL;
    }
    for (size_t i = 0; i < from->material_count && !err; i++) {
        struct scene_material m = from->materials[i];
        shift_map(&m.albedo_map, textures);
        shift_map(&m.emission_map, textures);
        shift_map(&m.alpha_map, textures);
        from->materials[i].name = NULL;
        err = scene_push_material(to, m, NULL);
    }
    for (size_t i = 0; i < from->mesh_count && !err; i++) {
        struct scene_mesh mesh = from->meshes[i];
        mesh.part = 0;
        mesh.run_count = 0; /* their names stay behind */
        for (size_t t = 0; t < mesh.triangle_count; t++)
            mesh.material[t] += (int32_t)materials;
        from->meshes[i] = (struct scene_mesh){0};
        err = scene_push_mesh(to, mesh, NULL);
    }
    for (size_t i = 0; i < from->instance_count && !err; i++)
        err =
            scene_push_instance(to, meshes + from->instances[i].mesh, from->instances[i].transform);
    return err;
}

static struct error *add_file(struct scene *scene, const char *path, bool lenient,
                              struct vec3 *centre, double *radius, struct warnings *warnings)
{
    struct scene_settings settings = scene_settings_default();
    settings.lenient = lenient;
    struct scene *mesh = NULL;
    struct error *err = scene_read(&mesh, path, &settings, false, warnings);
    if (err)
        return err;
    *centre = vec3_scale(0.5, vec3_add(mesh->box_min, mesh->box_max));
    *radius = vec3_length(vec3_sub(mesh->box_max, mesh->box_min)) / 2;
    err = move_over(scene, mesh);
    scene_destroy(mesh);
    return err;
}

/* -- the object -------------------------------------------------------------------------------- */

struct error *object_init(struct object *o, struct scene *scene, const char *path, bool lenient,
                          double radius, struct warnings *warnings)
{
    struct vec3 centre = {0};
    *o = (struct object){.scene = scene,
                         .first = scene->instance_count,
                         .radius = 1,
                         .sphere = !strcmp(path, "sphere"),
                         .box_min = scene->box_min,
                         .box_max = scene->box_max};
    struct error *err = o->sphere ? add_sphere(scene)
                                  : add_file(scene, path, lenient, &centre, &o->radius, warnings);
    o->count = scene->instance_count - o->first;
    if (!err)
        err = array_create(&o->own, o->count, sizeof *o->own);
    if (err)
        return err;
    for (size_t i = 0; i < o->count; i++) {
        memcpy(o->own[i], scene->instances[o->first + i].transform, sizeof o->own[i]);
        o->own[i][3] -= centre.x;
        o->own[i][7] -= centre.y;
        o->own[i][11] -= centre.z;
    }
    const double usual = o->sphere ? 0.03 * vec3_length(vec3_sub(o->box_max, o->box_min))
                                   : o->radius;
    o->scale = (radius > 0 ? radius : usual) / o->radius;
    return NULL;
}

void object_clear(struct object *o)
{
    free(o->own);
    *o = (struct object){0};
}

void object_place(const struct object *o, struct vec3 p)
{
    const double offset[3] = {p.x, p.y, p.z}, r = o->radius * o->scale;
    for (size_t i = 0; i < o->count; i++)
        for (int k = 0; k < 12; k++)
            o->scene->instances[o->first + i].transform[k] = o->scale * o->own[i][k] +
                                                             (k % 4 == 3 ? offset[k / 4] : 0);
    o->scene->box_min = (struct vec3){fmin(o->box_min.x, p.x - r), fmin(o->box_min.y, p.y - r),
                                      fmin(o->box_min.z, p.z - r)};
    o->scene->box_max = (struct vec3){fmax(o->box_max.x, p.x + r), fmax(o->box_max.y, p.y + r),
                                      fmax(o->box_max.z, p.z + r)};
}

struct render_object object_at(const struct object *o, struct vec3 p, bool per_pixel)
{
    return (struct render_object){
        .first = o->first, .centre = p, .sphere = o->sphere, .per_pixel = per_pixel};
}
