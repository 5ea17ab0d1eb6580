/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"
#include "math/hash.h"

#include <stdlib.h>

void scene_mesh_clear(struct scene_mesh *mesh)
{
    free(mesh->position);
    free(mesh->index);
    free(mesh->uv);
    free(mesh->emission_uv);
    free(mesh->colour);
    free(mesh->material);
    free(mesh->runs);
    *mesh = (struct scene_mesh){0};
}

void scene_sky_clear(struct scene_sky *sky)
{
    if (sky->picture)
        free(sky->picture->texels);
    free(sky->picture);
    free(sky->file);
    free(sky->from_scene);
    *sky = (struct scene_sky){0};
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
    for (size_t i = 0; i < scene->part_count; i++)
        free(scene->parts[i].name);
    scene_sky_clear(&scene->sky);
    free(scene->meshes);
    free(scene->instances);
    free(scene->materials);
    free(scene->textures);
    free(scene->lights);
    free(scene->parts);
    free(scene->path);
    free(scene);
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
    const uint64_t more = (mesh->uv ? 1u : 0u) + (mesh->emission_uv ? 2u : 0u) +
                          (mesh->colour ? 4u : 0u);
    const uint64_t shape[] = {mesh->vertex_count, mesh->triangle_count, more};
    hash_add(hash, shape, sizeof shape);
    hash_add(hash, mesh->position, 3 * mesh->vertex_count * sizeof *mesh->position);
    hash_add(hash, mesh->index, 3 * mesh->triangle_count * sizeof *mesh->index);
    hash_add(hash, mesh->material, mesh->triangle_count * sizeof *mesh->material);
    if (mesh->uv)
        hash_add(hash, mesh->uv, 6 * mesh->triangle_count * sizeof *mesh->uv);
    if (mesh->emission_uv)
        hash_add(hash, mesh->emission_uv, 6 * mesh->triangle_count * sizeof *mesh->emission_uv);
    if (mesh->colour)
        hash_add(hash, mesh->colour, 4 * mesh->vertex_count * sizeof *mesh->colour);
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

static void hash_geometry(struct hash *hash, const struct scene *scene)
{
    for (size_t i = 0; i < scene->mesh_count; i++)
        hash_mesh(hash, &scene->meshes[i]);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const uint64_t mesh = scene->instances[i].mesh;
        hash_add(hash, &mesh, sizeof mesh);
        hash_add(hash, scene->instances[i].transform, sizeof scene->instances[i].transform);
    }
}

uint64_t scene_surface_key(const struct scene *scene)
{
    if (scene->keys_kept)
        return scene->kept_surface_key;
    struct hash hash;
    hash_start(&hash, 0);
    const uint64_t shape[] = {scene->mesh_count, scene->instance_count, scene->material_count};
    hash_add(&hash, shape, sizeof shape);
    hash_geometry(&hash, scene);
    for (size_t i = 0; i < scene->material_count; i++) {
        const struct scene_material *m = &scene->materials[i];
        const float factors[] = {m->opacity, m->cutoff};
        const uint32_t alpha = m->alpha;
        hash_add(&hash, factors, sizeof factors);
        hash_add(&hash, &alpha, sizeof alpha);
        hash_map(&hash, &m->alpha_map);
        if (m->alpha_map.texture >= 0)
            hash_texture(&hash, &scene->textures[m->alpha_map.texture]);
    }
    return hash_value(&hash);
}

static uint64_t find_key(const struct scene *scene, bool picture)
{
    struct hash hash;
    hash_start(&hash, 0);
    const uint64_t shape[] = {
        scene->mesh_count,  scene->instance_count,  scene->material_count,     scene->texture_count,
        scene->light_count, scene->emit_front_only, scene->sky.picture != NULL};
    hash_add(&hash, shape, sizeof shape);
    hash_geometry(&hash, scene);
    for (size_t i = 0; i < scene->material_count; i++)
        hash_material(&hash, &scene->materials[i]);
    for (size_t i = 0; i < scene->texture_count; i++)
        hash_texture(&hash, &scene->textures[i]);
    for (size_t i = 0; i < scene->light_count; i++)
        hash_light(&hash, &scene->lights[i]);
    hash_add(&hash, scene->sky.radiance, sizeof scene->sky.radiance);
    hash_add(&hash, &scene->max_albedo, sizeof scene->max_albedo);
    if (scene->sky.picture && picture)
        hash_texture(&hash, scene->sky.picture);
    if (scene->sky.picture && scene->sky.turned) {
        hash_add(&hash, &scene->sky.front, sizeof scene->sky.front);
        hash_add(&hash, &scene->sky.up, sizeof scene->sky.up);
    }
    return hash_value(&hash);
}

uint64_t scene_key(const struct scene *scene)
{
    return scene->keys_kept ? scene->kept_key : find_key(scene, false);
}

uint64_t scene_key_with_sky(const struct scene *scene)
{
    return scene->keys_kept ? scene->kept_key_with_sky : find_key(scene, true);
}

void scene_keep_keys(struct scene *scene)
{
    scene->kept_key_with_sky = scene_key_with_sky(scene);
    scene->kept_key = scene_key(scene);
    scene->kept_surface_key = scene_surface_key(scene);
    scene->keys_kept = true;
}
