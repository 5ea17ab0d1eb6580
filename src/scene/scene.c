#include "scene/scene.h"
#include "base/array.h"
#include "base/error.h"
#include "image/image.h"
#include "math/hash.h"
#include "scene/scene_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const double scene_identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* -- making and freeing ----------------------------------------------------------------------- */

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

void scene_mesh_clear(struct scene_mesh *mesh)
{
    free(mesh->position);
    free(mesh->index);
    free(mesh->uv);
    free(mesh->material);
    *mesh = (struct scene_mesh){0};
}

void scene_destroy(struct scene *scene)
{
    if (!scene)
        return;
    for (size_t i = 0; i < scene->mesh_count; i++)
        scene_mesh_clear(&scene->meshes[i]);
    for (size_t i = 0; i < scene->material_count; i++)
        free(scene->materials[i].name);
    for (size_t i = 0; i < scene->texture_count; i++)
        free(scene->textures[i].texels);
    if (scene->sky.picture)
        free(scene->sky.picture->texels);
    free(scene->sky.picture);
    free(scene->meshes);
    free(scene->instances);
    free(scene->materials);
    free(scene->textures);
    free(scene->lights);
    free(scene->path);
    free(scene);
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
    instance->mesh = mesh;
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

size_t scene_triangle_count(const struct scene *scene)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->instance_count; i++)
        count += scene->meshes[scene->instances[i].mesh].triangle_count;
    return count;
}

/* -- the key ---------------------------------------------------------------------------------- */

static void hash_texture(struct hash *hash, const struct scene_texture *t)
{
    const uint32_t shape[] = {t->width,  t->height, t->channels, t->bytes,
                              t->wrap_u, t->wrap_v, t->nearest};
    hash_add(hash, shape, sizeof shape);
    hash_add(hash, t->texels,
             (size_t)t->width * t->height * t->channels *
                 (t->bytes ? sizeof(uint8_t) : sizeof(float)));
}

static void hash_map(struct hash *hash, const struct scene_map *map)
{
    hash_add(hash, &map->texture, sizeof map->texture);
    hash_add(hash, map->transform, sizeof map->transform);
}

static void hash_material(struct hash *hash, const struct scene_material *m)
{
    const float factors[] = {m->albedo.x,   m->albedo.y,   m->albedo.z, m->emission.x,
                             m->emission.y, m->emission.z, m->opacity,  m->cutoff};
    const uint32_t alpha = m->alpha;
    hash_add(hash, factors, sizeof factors);
    hash_add(hash, &alpha, sizeof alpha);
    hash_map(hash, &m->albedo_map);
    hash_map(hash, &m->emission_map);
    hash_map(hash, &m->alpha_map);
}

static void hash_mesh(struct hash *hash, const struct scene_mesh *mesh)
{
    const uint64_t shape[] = {mesh->vertex_count, mesh->triangle_count, mesh->uv != NULL};
    hash_add(hash, shape, sizeof shape);
    hash_add(hash, mesh->position, 3 * mesh->vertex_count * sizeof *mesh->position);
    hash_add(hash, mesh->index, 3 * mesh->triangle_count * sizeof *mesh->index);
    hash_add(hash, mesh->material, mesh->triangle_count * sizeof *mesh->material);
    if (mesh->uv)
        hash_add(hash, mesh->uv, 6 * mesh->triangle_count * sizeof *mesh->uv);
}

static void hash_light(struct hash *hash, const struct scene_light *l)
{
    const uint32_t kind = l->kind;
    const double numbers[] = {l->position.x,   l->position.y,  l->position.z,   l->direction.x,
                              l->direction.y,  l->direction.z, l->intensity[0], l->intensity[1],
                              l->intensity[2], l->cos_inner,   l->cos_outer};
    hash_add(hash, &kind, sizeof kind);
    hash_add(hash, numbers, sizeof numbers);
}

uint64_t scene_key(const struct scene *scene)
{
    if (scene->decimated)
        return scene->whole_key;
    struct hash hash;
    hash_start(&hash, 0);
    const uint64_t shape[] = {
        scene->mesh_count,  scene->instance_count,  scene->material_count,     scene->texture_count,
        scene->light_count, scene->emit_front_only, scene->sky.picture != NULL};
    hash_add(&hash, shape, sizeof shape);
    for (size_t i = 0; i < scene->mesh_count; i++)
        hash_mesh(&hash, &scene->meshes[i]);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const uint64_t mesh = scene->instances[i].mesh;
        hash_add(&hash, &mesh, sizeof mesh);
        hash_add(&hash, scene->instances[i].transform, sizeof scene->instances[i].transform);
    }
    for (size_t i = 0; i < scene->material_count; i++)
        hash_material(&hash, &scene->materials[i]);
    for (size_t i = 0; i < scene->texture_count; i++)
        hash_texture(&hash, &scene->textures[i]);
    for (size_t i = 0; i < scene->light_count; i++)
        hash_light(&hash, &scene->lights[i]);
    hash_add(&hash, scene->sky.radiance, sizeof scene->sky.radiance);
    hash_add(&hash, &scene->max_albedo, sizeof scene->max_albedo);
    if (scene->sky.picture)
        hash_texture(&hash, scene->sky.picture);
    return hash_value(&hash);
}
