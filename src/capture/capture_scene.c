/* SPDX-License-Identifier: Apache-2.0 */
/* What can be told of a capture from its scene alone. */
#include "capture/capture.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static bool is_black(const double colour[3])
{
    return colour[0] == 0 && colour[1] == 0 && colour[2] == 0;
}

static bool is_black_sky(const struct scene_sky *sky)
{
    bool black = is_black(sky->radiance);
    if (!black && sky->picture) {
        const struct scene_texture *picture = sky->picture;
        const float *texel = picture->texels;
        const size_t count = (size_t)picture->width * picture->height * picture->channels;
        black = true;
        for (size_t i = 0; i < count && black; i++)
            black = texel[i] == 0;
    }
    return black;
}

bool capture_is_dark(const struct scene *scene)
{
    bool dark = is_black_sky(&scene->sky), emits = false;
    for (size_t i = 0; i < scene->light_count && dark; i++)
        dark = is_black(scene->lights[i].intensity);
    for (size_t i = 0; i < scene->material_count; i++)
        emits = emits || scene_emits(&scene->materials[i]);
    for (size_t m = 0; m < scene->mesh_count && dark && emits; m++) {
        const struct scene_mesh *mesh = &scene->meshes[m];
        for (size_t t = 0; t < mesh->triangle_count && dark; t++)
            dark = !scene_emits(&scene->materials[mesh->material[t]]);
    }
    return dark;
}

const char *capture_find_pane(const struct scene *scene)
{
    static const char *const words[] = {"glass", "window", "pane", "glazing"};
    for (size_t i = 0; i < scene->material_count; i++) {
        const struct scene_material *m = &scene->materials[i];
        for (size_t k = 0; k < sizeof words / sizeof *words; k++)
            if (m->alpha == SCENE_OPAQUE && strcasestr(m->name, words[k]))
                return m->name;
    }
    return NULL;
}

bool capture_is_white(const struct scene *scene)
{
    bool white = scene->material_count > 0;
    for (size_t i = 0; i < scene->mesh_count; i++)
        white = white && !scene->meshes[i].colour;
    for (size_t i = 0; i < scene->material_count; i++) {
        const struct scene_material *m = &scene->materials[i];
        white = white && m->albedo_map.texture == SCENE_NONE &&
                fminf(m->albedo.x, fminf(m->albedo.y, m->albedo.z)) > 0.999f;
    }
    return white;
}
