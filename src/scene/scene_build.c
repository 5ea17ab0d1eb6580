/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_build.h"
#include "base/array.h"
#include "base/error.h"
#include "image/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const double scene_identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

struct error *scene_create(struct scene **scene)
{
    struct error *err = array_create(scene, 1, sizeof **scene);
    if (!err) {
        (*scene)->max_albedo = 1;
        (*scene)->box_min = (struct vec3){(double)INFINITY, (double)INFINITY, (double)INFINITY};
        (*scene)->box_max = (struct vec3){-(double)INFINITY, -(double)INFINITY, -(double)INFINITY};
    }
    return err;
}

struct scene_texture scene_texture_of(const struct image *image)
{
    return (struct scene_texture){.width = image->width,
                                  .height = image->height,
                                  .channels = image->channels,
                                  .bytes = image->bytes,
                                  .texels = image->texels};
}

struct scene_map scene_map_of(int32_t texture)
{
    return (struct scene_map){.texture = texture, .transform = {1, 0, 0, 0, 1, 0}};
}

struct scene_material scene_material_default(void)
{
    return (struct scene_material){.albedo = {1, 1, 1},
                                   .albedo_map = scene_map_of(SCENE_NONE),
                                   .emission_map = scene_map_of(SCENE_NONE),
                                   .alpha = SCENE_OPAQUE,
                                   .opacity = 1,
                                   .cutoff = 0.5f,
                                   .alpha_map = scene_map_of(SCENE_NONE)};
}

struct error *scene_push_mesh(struct scene *scene, struct scene_mesh mesh, size_t *index)
{
    struct error *err = array_reserve(&scene->meshes, &scene->mesh_capacity, scene->mesh_count + 1,
                                      sizeof *scene->meshes);
    if (err) {
        scene_mesh_clear(&mesh);
        return err;
    }
    if (index)
        *index = scene->mesh_count;
    scene->meshes[scene->mesh_count++] = mesh;
    return NULL;
}

struct error *scene_push_instance(struct scene *scene, size_t mesh, const double transform[12])
{
    struct error *err = array_reserve(&scene->instances, &scene->instance_capacity,
                                      scene->instance_count + 1, sizeof *scene->instances);
    if (err)
        return err;
    struct scene_instance *instance = &scene->instances[scene->instance_count++];
    *instance = (struct scene_instance){.mesh = mesh};
    memcpy(instance->transform, transform, sizeof instance->transform);
    return NULL;
}

struct error *scene_push_material(struct scene *scene, struct scene_material material,
                                  int32_t *index)
{
    struct error *err = scene->material_count < INT32_MAX ? NULL
                                                          : error_new("more than 2^31 materials");
    if (!err && !material.name)
        err = array_create(&material.name, 1, 1);
    if (!err)
        err = array_reserve(&scene->materials, &scene->material_capacity, scene->material_count + 1,
                            sizeof *scene->materials);
    if (err) {
        free(material.name);
        return err;
    }
    if (index)
        *index = (int32_t)scene->material_count;
    scene->materials[scene->material_count++] = material;
    return NULL;
}

struct error *scene_push_texture(struct scene *scene, struct scene_texture texture, int32_t *index)
{
    struct error *err = scene->texture_count < INT32_MAX ? NULL
                                                         : error_new("more than 2^31 textures");
    if (!err)
        err = array_reserve(&scene->textures, &scene->texture_capacity, scene->texture_count + 1,
                            sizeof *scene->textures);
    if (err) {
        free(texture.texels);
        return err;
    }
    if (index)
        *index = (int32_t)scene->texture_count;
    scene->textures[scene->texture_count++] = texture;
    return NULL;
}

struct error *scene_push_light(struct scene *scene, struct scene_light light)
{
    struct error *err = array_reserve(&scene->lights, &scene->light_capacity,
                                      scene->light_count + 1, sizeof *scene->lights);
    if (!err)
        scene->lights[scene->light_count++] = light;
    return err;
}

struct error *scene_push_part(struct scene *scene, enum scene_part_kind kind, const char *name,
                              uint32_t above, uint32_t *part)
{
    struct error *err = scene->part_count < UINT32_MAX
                            ? array_reserve(&scene->parts, &scene->part_capacity,
                                            scene->part_count + 1, sizeof *scene->parts)
                            : error_new("more than 2^32 names");
    char *copy = err ? NULL : strdup(name);
    if (!err && !copy)
        err = error_memory();
    if (err)
        return err;
    scene->parts[scene->part_count++] =
        (struct scene_part){.kind = kind, .name = copy, .above = above};
    *part = (uint32_t)scene->part_count;
    return NULL;
}

void scene_mesh_drop(struct scene_mesh *mesh, const bool *drop)
{
    size_t kept = 0, run = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        while (run < mesh->run_count && mesh->runs[run].first == t)
            mesh->runs[run++].first = kept;
        if (drop[t])
            continue;
        if (kept < t) {
            memmove(&mesh->index[3 * kept], &mesh->index[3 * t], 3 * sizeof *mesh->index);
            if (mesh->uv)
                memmove(&mesh->uv[6 * kept], &mesh->uv[6 * t], 6 * sizeof *mesh->uv);
            if (mesh->emission_uv)
                memmove(&mesh->emission_uv[6 * kept], &mesh->emission_uv[6 * t],
                        6 * sizeof *mesh->emission_uv);
            mesh->material[kept] = mesh->material[t];
        }
        kept++;
    }
    for (; run < mesh->run_count; run++)
        mesh->runs[run].first = kept;
    mesh->triangle_count = kept;
}

struct error *scene_add_mesh(struct scene *scene, size_t vertex_count, const double *position,
                             size_t triangle_count, const uint32_t *index,
                             const struct scene_material *material)
{
    struct scene_mesh mesh = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    struct scene_material copy = *material;
    size_t place = 0;
    int32_t number = 0;
    copy.name = strdup(material->name ? material->name : "");
    struct error *err = copy.name ? scene_push_material(scene, copy, &number) : error_memory();
    if (!err)
        err = array_create(&mesh.position, 3 * vertex_count, sizeof *mesh.position);
    if (!err)
        err = array_create(&mesh.index, 3 * triangle_count, sizeof *mesh.index);
    if (!err)
        err = array_create(&mesh.material, triangle_count, sizeof *mesh.material);
    if (err) {
        scene_mesh_clear(&mesh);
        return err;
    }
    if (vertex_count)
        memcpy(mesh.position, position, 3 * vertex_count * sizeof *position);
    if (triangle_count)
        memcpy(mesh.index, index, 3 * triangle_count * sizeof *index);
    for (size_t t = 0; t < triangle_count; t++)
        mesh.material[t] = number;
    err = scene_push_mesh(scene, mesh, &place);
    return err ? err : scene_push_instance(scene, place, scene_identity);
}
