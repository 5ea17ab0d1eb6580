/* SPDX-License-Identifier: Apache-2.0 */
/* What makes a legal scene of what an importer read: triangles with an area, numbers in range, the
 * user's settings. */
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "image/image.h"
#include "math/affine.h"
#include "math/box.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "scene/scene_sky.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- geometry --------------------------------------------------------------------------------- */

static bool all_finite(const double *x, size_t count)
{
    bool finite = true;
    for (size_t i = 0; i < count; i++)
        finite = finite && isfinite(x[i]);
    return finite;
}

static double largest(struct vec3 a)
{
    return fmax(fmax(fabs(a.x), fabs(a.y)), fabs(a.z));
}

/* Whether the cross product of the edges is no more than the rounding of its own computation (also
 * when it is not a number). The edges are brought near 1 first, so that neither tiny nor huge
 * scenes leave the range of double. */
static bool is_degenerate(const double *a, const double *b, const double *c)
{
    struct vec3 e = vec3_sub(vec3_load(b), vec3_load(a)), f = vec3_sub(vec3_load(c), vec3_load(a));
    const double size_e = largest(e), size_f = largest(f);
    /* fmax passes over NaN */
    const bool finite = 0 * e.x + 0 * e.y + 0 * e.z + 0 * f.x + 0 * f.y + 0 * f.z == 0;
    if (!(finite && size_e > 0 && size_f > 0))
        return true;
    e = (struct vec3){e.x / size_e, e.y / size_e, e.z / size_e};
    f = (struct vec3){f.x / size_f, f.y / size_f, f.z / size_f};
    return !(largest(vec3_cross(e, f)) > 4 * DBL_EPSILON);
}

/* Keeps the triangles that have an area, in order, and the vertices that they use. */
static struct error *mesh_clean(struct scene_mesh *mesh, struct warnings *warnings, size_t number)
{
    bool *drop = NULL;
    struct error *err = array_create(&drop, mesh->triangle_count, sizeof *drop);
    if (err)
        return err;
    const double *p = mesh->position;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *i = &mesh->index[3 * t];
        if (i[0] >= mesh->vertex_count || i[1] >= mesh->vertex_count ||
            i[2] >= mesh->vertex_count) {
            warnings_add(warnings, "index out of range",
                         "triangle %zu of mesh %zu has a corner that is not among the mesh's %zu "
                         "vertices: left out",
                         t, number, mesh->vertex_count);
            drop[t] = true;
            continue;
        }
        drop[t] = is_degenerate(&p[3 * (size_t)i[0]], &p[3 * (size_t)i[1]], &p[3 * (size_t)i[2]]);
    }
    scene_mesh_drop(mesh, drop);
    free(drop);

    const size_t kept = mesh->triangle_count;
    uint32_t *place = NULL; /* 0: not used; otherwise the new number, from 1 */
    err = array_create(&place, mesh->vertex_count, sizeof *place);
    if (err)
        return err;
    for (size_t k = 0; k < 3 * kept; k++)
        place[mesh->index[k]] = 1;
    uint32_t used = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        if (!place[v])
            continue;
        memmove(&mesh->position[3 * (size_t)used], &mesh->position[3 * v],
                3 * sizeof *mesh->position);
        if (mesh->colour)
            memmove(&mesh->colour[4 * (size_t)used], &mesh->colour[4 * v],
                    4 * sizeof *mesh->colour);
        place[v] = ++used;
    }
    for (size_t k = 0; k < 3 * kept; k++)
        mesh->index[k] = place[mesh->index[k]] - 1;
    mesh->vertex_count = used;
    free(place);
    return NULL;
}

/* White takes nothing away: without it nothing is paid. */
static void mesh_clean_colour(struct scene_mesh *mesh)
{
    size_t k = 0;
    while (mesh->colour && k < 4 * mesh->vertex_count && mesh->colour[k] == UINT16_MAX)
        k++;
    if (k < 4 * mesh->vertex_count)
        return;
    free(mesh->colour);
    mesh->colour = NULL;
}

static void mesh_clean_uv(const struct scene_mesh *mesh, float *uv, struct warnings *warnings,
                          size_t number)
{
    for (size_t k = 0; uv && k < 6 * mesh->triangle_count; k++) {
        if (isfinite(uv[k]))
            continue;
        uv[k] = 0;
        warnings_add(warnings, "texture coordinate not finite",
                     "triangle %zu of mesh %zu has a texture coordinate that is not a finite "
                     "number: 0 is used",
                     k / 6, number);
    }
}

/* The volume of a transformed unit cube, after each row was brought near 1: 0 when space is
 * squeezed flat, negative when it is mirrored. */
static double openness(const double m[12])
{
    struct vec3 row[3];
    for (int i = 0; i < 3; i++) {
        row[i] = (struct vec3){m[4 * i], m[4 * i + 1], m[4 * i + 2]};
        const double size = largest(row[i]);
        if (!(size > 0))
            return 0;
        row[i] = (struct vec3){row[i].x / size, row[i].y / size, row[i].z / size};
    }
    return vec3_dot(row[0], vec3_cross(row[1], row[2]));
}

/* Below this a float cannot hold the matrix's inverse, which ray tracers need of an instance. */
static const double openness_least = 1e-6;

static void turn_uv(float *uv, size_t t)
{
    for (size_t k = 6 * t + 2; uv && k < 6 * t + 4; k++) {
        const float u = uv[k];
        uv[k] = uv[k + 2];
        uv[k + 2] = u;
    }
}

/* Turns a triangle's front to the other side. */
static void turn(struct scene_mesh *mesh, size_t t)
{
    const uint32_t i = mesh->index[3 * t + 1];
    mesh->index[3 * t + 1] = mesh->index[3 * t + 2];
    mesh->index[3 * t + 2] = i;
    turn_uv(mesh->uv, t);
    turn_uv(mesh->emission_uv, t);
}

/* Gives an instance that is squeezed flat a mesh of its own, already placed. */
static struct error *instance_flatten(struct scene *scene, size_t number)
{
    double matrix[12];
    memcpy(matrix, scene->instances[number].transform, sizeof matrix);
    const struct scene_mesh *from = &scene->meshes[scene->instances[number].mesh];
    struct scene_mesh mesh = {.vertex_count = from->vertex_count,
                              .triangle_count = from->triangle_count,
                              .part = from->part};
    struct error *err = array_create(&mesh.position, 3 * mesh.vertex_count, sizeof *mesh.position);
    if (!err)
        err = array_create(&mesh.index, 3 * mesh.triangle_count, sizeof *mesh.index);
    if (!err)
        err = array_create(&mesh.material, mesh.triangle_count, sizeof *mesh.material);
    if (!err && from->uv)
        err = array_create(&mesh.uv, 6 * mesh.triangle_count, sizeof *mesh.uv);
    if (!err && from->emission_uv)
        err = array_create(&mesh.emission_uv, 6 * mesh.triangle_count, sizeof *mesh.emission_uv);
    if (!err && from->colour)
        err = array_create(&mesh.colour, 4 * mesh.vertex_count, sizeof *mesh.colour);
    if (err) {
        scene_mesh_clear(&mesh);
        return err;
    }
    for (size_t v = 0; v < mesh.vertex_count; v++)
        vec3_store(&mesh.position[3 * v], affine_point(matrix, &from->position[3 * v]));
    memcpy(mesh.index, from->index, 3 * mesh.triangle_count * sizeof *mesh.index);
    memcpy(mesh.material, from->material, mesh.triangle_count * sizeof *mesh.material);
    if (mesh.uv)
        memcpy(mesh.uv, from->uv, 6 * mesh.triangle_count * sizeof *mesh.uv);
    if (mesh.emission_uv)
        memcpy(mesh.emission_uv, from->emission_uv,
               6 * mesh.triangle_count * sizeof *mesh.emission_uv);
    if (mesh.colour)
        memcpy(mesh.colour, from->colour, 4 * mesh.vertex_count * sizeof *mesh.colour);
    for (size_t t = 0; t < mesh.triangle_count && openness(matrix) < 0; t++)
        turn(&mesh, t);
    size_t place = 0;
    err = scene_push_mesh(scene, mesh, &place);
    if (!err) {
        scene->instances[number].mesh = place;
        memcpy(scene->instances[number].transform, scene_identity, sizeof scene_identity);
    }
    return err;
}

static struct error *check_instances(struct scene *scene)
{
    struct error *err = NULL;
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        if (instance->mesh >= scene->mesh_count)
            err = error_new("instance %zu places mesh %zu of %zu", i, instance->mesh,
                            scene->mesh_count);
        else if (!all_finite(instance->transform, 12))
            err = error_new("instance %zu has a transform that is not finite", i);
        else if (!(fabs(openness(instance->transform)) > openness_least))
            err = instance_flatten(scene, i);
    }
    return err;
}

/* Drops meshes that have no triangle or are placed nowhere, and instances of none. */
static struct error *drop_unused(struct scene *scene)
{
    size_t *place = NULL; /* 0: not used; otherwise the new number, from 1 */
    struct error *err = array_create(&place, scene->mesh_count, sizeof *place);
    if (err)
        return err;
    for (size_t i = 0; i < scene->instance_count; i++)
        place[scene->instances[i].mesh] = scene->meshes[scene->instances[i].mesh].triangle_count >
                                          0;
    size_t meshes = 0, instances = 0;
    for (size_t i = 0; i < scene->mesh_count; i++) {
        if (!place[i]) {
            scene_mesh_clear(&scene->meshes[i]);
            continue;
        }
        scene->meshes[meshes++] = scene->meshes[i];
        place[i] = meshes;
    }
    for (size_t i = 0; i < scene->instance_count; i++) {
        const size_t mesh = place[scene->instances[i].mesh];
        if (mesh == 0)
            continue;
        scene->instances[instances] = scene->instances[i];
        scene->instances[instances++].mesh = mesh - 1;
    }
    scene->mesh_count = meshes;
    scene->instance_count = instances;
    free(place);
    return NULL;
}

static struct error *find_box(struct scene *scene)
{
    struct box box = box_empty();
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            double p[3];
            vec3_store(p, affine_point(instance->transform, &mesh->position[3 * v]));
            if (!all_finite(p, 3))
                return error_new("instance %zu places a vertex beyond the range of numbers", i);
            box_add(&box, p);
        }
    }
    scene->box_min = vec3_load(box.low);
    scene->box_max = vec3_load(box.high);
    return NULL;
}

struct error *scene_finish_geometry(struct scene *scene, struct warnings *warnings)
{
    struct error *err = check_instances(scene);
    if (!err)
        err = drop_unused(scene);
    size_t before = 0, after = 0;
    for (size_t i = 0; i < scene->mesh_count && !err; i++) {
        struct scene_mesh *mesh = &scene->meshes[i];
        for (size_t t = 0; t < mesh->triangle_count && !err; t++)
            if (mesh->material[t] < 0 || (size_t)mesh->material[t] >= scene->material_count)
                err = error_new("triangle %zu of mesh %zu has material %d of %zu", t, i,
                                (int)mesh->material[t], scene->material_count);
        if (!err && mesh->vertex_count > UINT32_MAX)
            err = error_new("mesh %zu has %zu vertices, expected at most 2^32", i,
                            mesh->vertex_count);
        before += mesh->triangle_count;
        if (!err)
            err = mesh_clean(mesh, warnings, i);
        if (!err)
            mesh_clean_uv(mesh, mesh->uv, warnings, i);
        if (!err)
            mesh_clean_uv(mesh, mesh->emission_uv, warnings, i);
        if (!err)
            mesh_clean_colour(mesh);
        after += mesh->triangle_count;
    }
    scene->degenerate_count = before - after;
    if (!err && before > after)
        warnings_add(warnings, "degenerate triangles",
                     "%s%s%zu of %zu triangles have no area and are left out",
                     scene->path ? scene->path : "", scene->path ? ": " : "", before - after,
                     before);
    if (!err)
        err = drop_unused(scene);
    return err ? err : find_box(scene);
}

/* -- materials, lights, settings --------------------------------------------------------------- */

/* Makes a factor legal: a negative number or none becomes 0. */
static float legal_factor(float x, const char *what, const struct scene_material *m,
                          struct warnings *warnings)
{
    if (isfinite(x) && x >= 0)
        return x;
    warnings_add(warnings, "material out of range", "material '%s': %s of %g: 0 is used", m->name,
                 what, (double)x);
    return 0;
}

static struct vec3f legal_colour(struct vec3f c, const char *what, const struct scene_material *m,
                                 struct warnings *warnings)
{
    return (struct vec3f){legal_factor(c.x, what, m, warnings),
                          legal_factor(c.y, what, m, warnings),
                          legal_factor(c.z, what, m, warnings)};
}

/* Scaled in double; light that is too bright for a float is no darkness, so it is an error. */
static struct error *finish_emission(struct scene_material *m, double scale,
                                     struct warnings *warnings)
{
    float *const channel[3] = {&m->emission.x, &m->emission.y, &m->emission.z};
    for (int c = 0; c < 3; c++) {
        const double scaled = (double)*channel[c] * scale;
        if (scaled > (double)FLT_MAX)
            return error_new("material '%s': an emission of %g is beyond what 32 bits can hold",
                             m->name, scaled);
        *channel[c] =
            (float)((double)legal_factor(*channel[c], "an emission", m, warnings) * scale);
    }
    return NULL;
}

static struct error *check_map(const struct scene *scene, struct scene_map *map,
                               const struct scene_material *m, struct warnings *warnings)
{
    if (map->texture != SCENE_NONE &&
        (map->texture < 0 || (size_t)map->texture >= scene->texture_count))
        return error_new("material '%s' reads texture %d of %zu", m->name, (int)map->texture,
                         scene->texture_count);
    for (int i = 0; i < 6; i++) {
        if (isfinite(map->transform[i]))
            continue;
        warnings_add(warnings, "map transform not finite",
                     "material '%s': a texture transform that is not finite is ignored", m->name);
        *map = scene_map_of(map->texture);
    }
    return NULL;
}

/* The largest value that a texture's colour takes. */
static float texture_most(const struct scene_texture *t)
{
    float most = 0;
    const size_t count = (size_t)t->width * t->height;
    for (size_t i = 0; i < count; i++)
        for (unsigned c = 0; c < (t->channels < 3 ? t->channels : 3); c++) {
            const size_t at = i * t->channels + c;
            most = fmaxf(most, t->channels == 1 ? 1
                               : t->bytes       ? image_linear[((const uint8_t *)t->texels)[at]]
                                                : ((const float *)t->texels)[at]);
        }
    return most;
}

/* Says once a kind where max_albedo takes light away; the limit itself is applied in
 * scene_albedo. */
static void warn_albedo(const struct scene *scene, const struct scene_material *m,
                        struct warnings *warnings)
{
    float most = fmaxf(fmaxf(m->albedo.x, m->albedo.y), m->albedo.z);
    if (m->albedo_map.texture != SCENE_NONE) {
        const struct scene_texture *t = &scene->textures[m->albedo_map.texture];
        if (most > scene->max_albedo || !t->bytes)
            most *= texture_most(t);
    }
    if (most > scene->max_albedo)
        warnings_add(warnings, "albedo limited",
                     "material '%s': its albedo of up to %.4g is limited to %.4g", m->name,
                     (double)most, (double)scene->max_albedo);
}

static struct error *finish_material(struct scene *scene, struct scene_material *m,
                                     const struct scene_settings *settings,
                                     struct warnings *warnings)
{
    struct error *err = check_map(scene, &m->albedo_map, m, warnings);
    if (!err)
        err = check_map(scene, &m->emission_map, m, warnings);
    if (!err)
        err = check_map(scene, &m->alpha_map, m, warnings);
    if (err)
        return err;
    m->textured = m->albedo_map.texture != SCENE_NONE || m->emission_map.texture != SCENE_NONE ||
                  m->alpha_map.texture != SCENE_NONE;
    m->albedo = vec3f_scale((float)settings->albedo_scale,
                            legal_colour(m->albedo, "an albedo", m, warnings));
    err = finish_emission(m, settings->light_scale, warnings);
    if (err)
        return err;
    if (!(m->opacity >= 0 && m->opacity <= 1)) {
        const float used = m->opacity < 0 ? 0.0f : 1.0f;
        warnings_add(warnings, "material out of range",
                     "material '%s': an opacity of %g: %g is used", m->name, (double)m->opacity,
                     (double)used);
        m->opacity = used;
    }
    if (!isfinite(m->cutoff))
        m->cutoff = 0.5f;
    warn_albedo(scene, m, warnings);
    return NULL;
}

static bool light_is_legal(const struct scene_light *light)
{
    const double d = vec3_dot(light->direction, light->direction);
    const bool placed =
        light->kind == SCENE_SUN ||
        (isfinite(light->position.x) && isfinite(light->position.y) && isfinite(light->position.z));
    const bool aimed = light->kind == SCENE_POINT || fabs(d - 1) < 1e-6;
    const bool cone = light->kind != SCENE_SPOT || light->cos_inner >= light->cos_outer;
    return placed && aimed && cone && all_finite(light->intensity, 3) && light->intensity[0] >= 0 &&
           light->intensity[1] >= 0 && light->intensity[2] >= 0;
}

/* The file's lights scaled, then the settings' as they stand. */
static struct error *finish_lights(struct scene *scene, const struct scene_settings *settings,
                                   struct warnings *warnings)
{
    size_t kept = 0;
    for (size_t i = 0; i < scene->light_count; i++) {
        struct scene_light light = scene->lights[i];
        if (!light_is_legal(&light)) {
            warnings_add(
                warnings, "light out of range",
                "light %zu has a negative or endless intensity, no place or no direction: left out",
                i);
            continue;
        }
        for (int c = 0; c < 3; c++)
            light.intensity[c] *= settings->light_scale;
        scene->lights[kept++] = light;
    }
    scene->light_count = kept;
    struct error *err = NULL;
    for (size_t i = 0; i < settings->light_count && !err; i++)
        err = scene_push_light(scene, settings->lights[i]);
    return err;
}

struct error *scene_finish(struct scene *scene, const struct scene_settings *settings,
                           struct warnings *warnings)
{
    const struct scene_settings none = scene_settings_default();
    if (!settings)
        settings = &none;
    scene->max_albedo = (float)settings->max_albedo;
    scene->emit_front_only = settings->emit_front_only;
    struct error *err = NULL;
    for (size_t i = 0; i < scene->material_count && !err; i++)
        err = finish_material(scene, &scene->materials[i], settings, warnings);
    if (!err)
        err = scene_finish_geometry(scene, warnings);
    if (err && scene->path)
        return error_wrap(err, "%s", scene->path);
    if (!err)
        err = finish_lights(scene, settings, warnings);
    return err ? err : scene_sky_finish(&scene->sky, scene->path, settings, warnings);
}
