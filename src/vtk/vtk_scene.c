/* SPDX-License-Identifier: Apache-2.0 */
#include "vtk/vtk_scene.h"
#include "base/error.h"
#include "image/display.h"
#include "math/affine.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"

#include <string.h>

struct arrays {
    double *position; /* 3 a vertex */
    int32_t *index;   /* 3 a triangle */
    float *albedo, *emission, *opacity;
    int32_t *material;
};

static void add_to(float sum[3], float weight, struct vec3f c)
{
    sum[0] += weight * c.x;
    sum[1] += weight * c.y;
    sum[2] += weight * c.z;
}

/* Whether a material looks the same all over. */
static bool is_plain(const struct scene_material *m)
{
    return m->albedo_map.texture == SCENE_NONE && m->emission_map.texture == SCENE_NONE &&
           m->alpha_map.texture == SCENE_NONE;
}

/* One texture coordinate between those of the corners. */
static float between(const float corner[6], float b, float c)
{
    return (1 - b - c) * corner[0] + b * corner[2] + c * corner[4];
}

/* Means over triangle t, of colours over what is opaque of it. Sampled in the centres of the 16
 * triangles that it falls into when its edges are quartered: strips, in which triangles stand on
 * their base and on their tip in turn. */
static void shade(const struct scene *scene, const struct scene_mesh *mesh, size_t t,
                  float albedo[3], float emission[3], float *opacity)
{
    const struct scene_material *m = &scene->materials[mesh->material[t]];
    const float *uv = mesh->uv ? mesh->uv + 6 * t : (const float[6]){0},
                *emission_uv = mesh->emission_uv ? mesh->emission_uv + 6 * t : uv;
    const int parts = (is_plain(m) || !mesh->uv) && !mesh->colour ? 1 : 4;
    float weight = 0;
    for (int i = 0; i < parts; i++) {
        for (int j = 0; j < 2 * (parts - i) - 1; j++) {
            const float third = (float)(1 + j % 2) / 3;
            const float b = ((float)i + third) / (float)parts,
                        c = ((float)(j / 2) + third) / (float)parts;
            const float u = between(uv, b, c), v = between(uv + 1, b, c);
            float tint[4] = {1, 1, 1, 1};
            if (mesh->colour)
                scene_tint(mesh->colour, mesh->index + 3 * t, b, c, tint);
            const float opaque = 1 - scene_transparency_tinted(scene, m, tint[3], u, v);
            add_to(albedo, opaque,
                   scene_albedo_tinted(scene, m, (struct vec3f){tint[0], tint[1], tint[2]}, u, v));
            add_to(emission, opaque,
                   scene_emission(scene, m, between(emission_uv, b, c),
                                  between(emission_uv + 1, b, c)));
            weight += opaque;
        }
    }
    for (size_t k = 0; k < 3 && weight > 0; k++) {
        albedo[k] /= weight;
        emission[k] /= weight;
    }
    *opacity = weight / (float)(parts * parts);
}

static void add_instance(struct vtk_mesh *to, const struct arrays *a, const struct scene *scene,
                         const struct scene_instance *instance)
{
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    const double *m = instance->transform;
    const bool mirrored = affine_mirrors(m); /* turns the winding round, not the front */
    for (size_t i = 0; i < mesh->vertex_count; i++)
        vec3_store(a->position + 3 * (to->point_count + i),
                   affine_point(m, mesh->position + 3 * i));
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const size_t at = to->cell_count + t;
        for (size_t k = 0; k < 3; k++)
            a->index[3 * at + (mirrored ? 2 - k : k)] =
                (int32_t)(to->point_count + mesh->index[3 * t + k]);
        shade(scene, mesh, t, a->albedo + 3 * at, a->emission + 3 * at, a->opacity + at);
        a->material[at] = mesh->material[t];
    }
    to->point_count += mesh->vertex_count;
    to->cell_count += mesh->triangle_count;
}

/* The display colour: of the surface, or where it emits, of its light at full brightness. */
static struct error *add_colour(struct vtk_scene *vtk, const struct arrays *a)
{
    float *shown = NULL;
    uint8_t *colour = NULL;
    const size_t n = vtk->mesh.cell_count;
    struct error *err = vtk_fields_own(&vtk->cells, 3 * n, sizeof *shown, &shown);
    if (!err)
        err = vtk_fields_add_new(&vtk->cells, "colour", VTK_EXPORT_U8, 3, n, &colour);
    for (size_t i = 0; i < n && !err; i++) {
        const float *e = a->emission + 3 * i, most = fmaxf(fmaxf(e[0], e[1]), e[2]);
        for (size_t k = 0; k < 3; k++)
            shown[3 * i + k] = most > 0 ? e[k] / most : a->albedo[3 * i + k];
    }
    if (!err)
        display_codes(n, shown, 1, colour);
    return err;
}

static struct error *add_material_names(struct vtk_scene *vtk, const struct scene *scene)
{
    const char **names = NULL;
    struct vtk_text *text = NULL;
    struct error *err = vtk_fields_own(&vtk->cells, scene->material_count, sizeof *names, &names);
    if (!err)
        err = vtk_fields_own(&vtk->cells, 1, sizeof *text, &text);
    if (err)
        return err;
    for (size_t i = 0; i < scene->material_count; i++)
        names[i] = scene->materials[i].name;
    *text =
        (struct vtk_text){.name = "Materials", .lines = names, .line_count = scene->material_count};
    vtk->mesh.texts = text;
    vtk->mesh.text_count = 1;
    return NULL;
}

struct error *vtk_scene_init(struct vtk_scene *vtk, const struct scene *scene)
{
    *vtk = (struct vtk_scene){0};
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        vertices += scene->meshes[scene->instances[i].mesh].vertex_count;
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    if (vertices > INT32_MAX)
        return error_new("the scene has %zu vertices with its instances placed, more than %d",
                         vertices, INT32_MAX);
    struct arrays a = {0};
    struct error *err = vtk_fields_own(&vtk->cells, 3 * vertices, sizeof *a.position, &a.position);
    if (!err)
        err = vtk_fields_own(&vtk->cells, 3 * triangles, sizeof *a.index, &a.index);
    if (!err)
        err = vtk_fields_add_new(&vtk->cells, "albedo", VTK_EXPORT_F32, 3, triangles, &a.albedo);
    if (!err)
        err =
            vtk_fields_add_new(&vtk->cells, "emission", VTK_EXPORT_F32, 3, triangles, &a.emission);
    if (!err)
        err = vtk_fields_add_new(&vtk->cells, "opacity", VTK_EXPORT_F32, 1, triangles, &a.opacity);
    if (!err)
        err =
            vtk_fields_add_new(&vtk->cells, "material", VTK_EXPORT_I32, 1, triangles, &a.material);
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        add_instance(&vtk->mesh, &a, scene, &scene->instances[i]);
    if (!err)
        err = add_colour(vtk, &a);
    if (!err)
        err = add_material_names(vtk, scene);
    vtk->mesh.position = a.position;
    vtk->mesh.vertex = a.index;
    vtk->mesh.cell_arrays = vtk->cells.list;
    vtk->mesh.cell_array_count = vtk->cells.count;
    if (err)
        vtk_scene_clear(vtk);
    return err;
}

void vtk_scene_clear(struct vtk_scene *vtk)
{
    vtk_fields_clear(&vtk->cells);
    *vtk = (struct vtk_scene){0};
}
