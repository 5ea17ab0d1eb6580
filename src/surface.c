#include "surface.h"
#include "array.h"
#include "error.h"
#include "scene.h"

#include <stdlib.h>

static void add_instance(struct surface *s, const struct scene *scene, const struct scene_instance *instance)
{
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    const double *m = instance->transform;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const double *p = mesh->position + 3 * i;
        for (size_t k = 0; k < 3; k++)
            s->position[3 * (s->vertex_count + i) + k] = m[4 * k] * p[0] + m[4 * k + 1] * p[1] + m[4 * k + 2] * p[2] + m[4 * k + 3];
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const struct scene_material *material = &scene->materials[mesh->material[t]];
        const float *uv = mesh->uv ? mesh->uv + 6 * t : NULL;
        const float u = uv ? (uv[0] + uv[2] + uv[4]) / 3 : 0, v = uv ? (uv[1] + uv[3] + uv[5]) / 3 : 0;
        const struct vec3f albedo = scene_albedo(scene, material, u, v), emission = scene_emission(scene, material, u, v);
        const size_t at = s->triangle_count + t;
        for (size_t k = 0; k < 3; k++)
            s->index[3 * at + k] = (int32_t)(s->vertex_count + mesh->index[3 * t + k]);
        s->albedo[3 * at] = albedo.x;
        s->albedo[3 * at + 1] = albedo.y;
        s->albedo[3 * at + 2] = albedo.z;
        s->emission[3 * at] = emission.x;
        s->emission[3 * at + 1] = emission.y;
        s->emission[3 * at + 2] = emission.z;
        s->material[at] = mesh->material[t];
    }
    s->vertex_count += mesh->vertex_count;
    s->triangle_count += mesh->triangle_count;
}

struct error *surface_create(struct surface *s, const struct scene *scene)
{
    *s = (struct surface){0};
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        vertices += scene->meshes[scene->instances[i].mesh].vertex_count;
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    if (vertices > INT32_MAX || triangles > INT32_MAX / 3)
        return error_new("the scene has more than %d vertices with its instances placed", INT32_MAX);
    struct error *err = array_create(&s->position, 3 * vertices, sizeof *s->position);
    if (!err)
        err = array_create(&s->index, 3 * triangles, sizeof *s->index);
    if (!err)
        err = array_create(&s->albedo, 3 * triangles, sizeof *s->albedo);
    if (!err)
        err = array_create(&s->emission, 3 * triangles, sizeof *s->emission);
    if (!err)
        err = array_create(&s->material, triangles, sizeof *s->material);
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        add_instance(s, scene, &scene->instances[i]);
    if (err)
        surface_clear(s);
    return err;
}

void surface_clear(struct surface *s)
{
    free(s->position);
    free(s->index);
    free(s->albedo);
    free(s->emission);
    free(s->material);
    *s = (struct surface){0};
}
