/* SPDX-License-Identifier: Apache-2.0 */
/* What a scene looks like from a point: its maps, materials, sky and lights. */
#include "image/image.h"
#include "math/angle.h"
#include "scene/scene_shade.h"

#include <math.h>

void scene_texture_texel(const struct scene_texture *t, uint32_t x, uint32_t y, float rgba[4])
{
    const size_t at = ((size_t)y * t->width + x) * t->channels;
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 1;
    if (t->bytes) {
        const uint8_t *code = (const uint8_t *)t->texels + at;
        for (unsigned c = 0; c < 3 && t->channels > 1; c++)
            rgba[c] = image_linear[code[c]];
        if (t->channels != 3)
            rgba[3] = (float)code[t->channels - 1] / 255;
    } else {
        const float *value = (const float *)t->texels + at;
        for (unsigned c = 0; c < 3 && t->channels > 1; c++)
            rgba[c] = value[c];
        if (t->channels != 3)
            rgba[3] = value[t->channels - 1];
    }
}

/* As floorf, which is a call, for |x| < 2^31. */
static inline float whole_below(float x)
{
    const float whole = (float)(int32_t)x;
    return whole > x ? whole - 1 : whole;
}

/* A texture coordinate brought into [0, 1]. */
static float wrap(enum scene_wrap wrap, float u)
{
    if (!(fabsf(u) < 1e9f)) /* an overflow of the map's transform */
        return 0;
    if (wrap == SCENE_CLAMP)
        return float_least(float_most(u, 0), 1);
    if (wrap == SCENE_REPEAT)
        return u - whole_below(u);
    const float t = u - 2 * whole_below(u / 2);
    return t > 1 ? 2 - t : t;
}

/* The two texels on either side of s in [0, 1], and the share of the second. Beyond the border lies
 * the other end of a picture that repeats, the border itself of one that does not: a mirrored
 * picture has it there too. */
static float between(enum scene_wrap wrap, uint32_t count, float s, uint32_t texel[2])
{
    const float x = s * (float)count - 0.5f, low = whole_below(x);
    const int64_t first = (int64_t)low, last = (int64_t)count - 1;
    const int64_t before = wrap == SCENE_REPEAT ? last : 0,
                  behind = wrap == SCENE_REPEAT ? 0 : last;
    texel[0] = (uint32_t)(first < 0 ? before : first > last ? last : first);
    texel[1] = (uint32_t)(first + 1 > last ? behind : first + 1);
    return x - low;
}

static uint32_t nearest(uint32_t count, float s)
{
    const uint32_t texel = (uint32_t)(s * (float)count);
    return texel < count ? texel : count - 1;
}

/* A picture at s from the left and t from the top, both in [0, 1]. */
static void sample(const struct scene_texture *texture, float s, float t, float rgba[4])
{
    if (texture->nearest) {
        scene_texture_texel(texture, nearest(texture->width, s), nearest(texture->height, t), rgba);
        return;
    }
    uint32_t x[2], y[2];
    const float fx = between(texture->wrap_u, texture->width, s, x);
    const float fy = between(texture->wrap_v, texture->height, t, y);
    float corner[4][4];
    for (unsigned i = 0; i < 4; i++)
        scene_texture_texel(texture, x[i & 1], y[i >> 1], corner[i]);
    for (unsigned c = 0; c < 4; c++) {
        const float top = corner[0][c] + fx * (corner[1][c] - corner[0][c]);
        const float bottom = corner[2][c] + fx * (corner[3][c] - corner[2][c]);
        rgba[c] = top + fy * (bottom - top);
    }
}

/* Where a map reads its texture: from the left and from the top. */
static void map_point(const struct scene_map *map, const struct scene_texture *texture, float u,
                      float v, float *s, float *t)
{
    const float *m = map->transform;
    *s = wrap(texture->wrap_u, m[0] * u + m[1] * v + m[2]);
    *t = 1 - wrap(texture->wrap_v, m[3] * u + m[4] * v + m[5]);
}

void scene_map_sample(const struct scene *scene, const struct scene_map *map, float u, float v,
                      float rgba[4])
{
    if (map->texture == SCENE_NONE) {
        rgba[0] = rgba[1] = rgba[2] = rgba[3] = 1;
        return;
    }
    const struct scene_texture *texture = &scene->textures[map->texture];
    float s, t;
    map_point(map, texture, u, v, &s, &t);
    sample(texture, s, t, rgba);
}

static struct vec3f colour(const struct scene *scene, struct vec3f factor,
                           const struct scene_map *map, float u, float v)
{
    if (map->texture == SCENE_NONE)
        return factor;
    float rgba[4];
    scene_map_sample(scene, map, u, v, rgba);
    return vec3f_mul(factor, (struct vec3f){rgba[0], rgba[1], rgba[2]});
}

static struct vec3f limited(const struct scene *scene, struct vec3f albedo)
{
    const float most = scene->max_albedo;
    return (struct vec3f){float_least(albedo.x, most), float_least(albedo.y, most),
                          float_least(albedo.z, most)};
}

struct vec3f scene_albedo(const struct scene *scene, const struct scene_material *m, float u,
                          float v)
{
    return limited(scene, colour(scene, m->albedo, &m->albedo_map, u, v));
}

struct vec3f scene_albedo_tinted(const struct scene *scene, const struct scene_material *m,
                                 struct vec3f tint, float u, float v)
{
    return limited(scene, vec3f_mul(tint, colour(scene, m->albedo, &m->albedo_map, u, v)));
}

struct scene_texel scene_texel_draw(const struct scene *scene, const struct scene_material *m,
                                    float u, float v, uint32_t bits)
{
    struct scene_texel texel = {.material = m, .u = u, .v = v};
    if (m->albedo_map.texture == SCENE_NONE)
        return texel;
    const struct scene_texture *texture = &scene->textures[m->albedo_map.texture];
    /* The limit of a mean is not the mean of limits. */
    if (!texture->bytes || texture->channels < 3 || vec3f_most(m->albedo) > scene->max_albedo)
        return texel;
    float s, t;
    map_point(&m->albedo_map, texture, u, v, &s, &t);
    uint32_t x, y;
    if (texture->nearest) {
        x = nearest(texture->width, s);
        y = nearest(texture->height, t);
    } else {
        uint32_t across[2], down[2];
        const float fx = between(texture->wrap_u, texture->width, s, across),
                    fy = between(texture->wrap_v, texture->height, t, down);
        x = across[(float)(bits & 0xffff) < fx * 0x1p16f];
        y = down[(float)(bits >> 16) < fy * 0x1p16f];
    }
    texel.code = (const uint8_t *)texture->texels +
                 ((size_t)y * texture->width + x) * texture->channels;
    __builtin_prefetch(texel.code);
    return texel;
}

struct vec3f scene_texel_albedo_tinted(const struct scene *scene, const struct scene_texel *texel,
                                       struct vec3f tint)
{
    return texel->code ? vec3f_mul(tint, scene_texel_albedo(scene, texel))
                       : scene_albedo_tinted(scene, texel->material, tint, texel->u, texel->v);
}

struct vec3f scene_texel_albedo(const struct scene *scene, const struct scene_texel *texel)
{
    const struct vec3f a = texel->material->albedo;
    const uint8_t *code = texel->code;
    if (code)
        return (struct vec3f){a.x * image_linear[code[0]], a.y * image_linear[code[1]],
                              a.z * image_linear[code[2]]};
    return scene_albedo(scene, texel->material, texel->u, texel->v);
}

struct vec3f scene_emission(const struct scene *scene, const struct scene_material *m, float u,
                            float v)
{
    return colour(scene, m->emission, &m->emission_map, u, v);
}

float scene_transparency(const struct scene *scene, const struct scene_material *m, float u,
                         float v)
{
    return scene_transparency_tinted(scene, m, 1, u, v);
}

float scene_transparency_tinted(const struct scene *scene, const struct scene_material *m,
                                float tint, float u, float v)
{
    if (m->alpha == SCENE_OPAQUE)
        return 0;
    float rgba[4];
    scene_map_sample(scene, &m->alpha_map, u, v, rgba);
    const float alpha = m->opacity * rgba[3] * tint;
    if (m->alpha == SCENE_CUTOUT)
        return alpha < m->cutoff ? 1 : 0;
    return fminf(fmaxf(1 - alpha, 0), 1);
}

struct vec3f scene_sky_radiance(const struct scene *scene, struct vec3f direction)
{
    const struct scene_sky *sky = &scene->sky;
    const struct vec3f factor = {(float)sky->radiance[0], (float)sky->radiance[1],
                                 (float)sky->radiance[2]};
    if (!sky->picture)
        return factor;
    direction = scene_sky_inward(sky, direction);
    const double x = direction.x, y = direction.y, z = direction.z;
    const double azimuth = angle_atan2(z, x), height = angle_atan2(y, sqrt(x * x + z * z));
    float rgba[4];
    sample(sky->picture, (float)(0.5 + azimuth / (2 * ANGLE_PI)), (float)(0.5 - height / ANGLE_PI),
           rgba);
    return vec3f_mul(factor, (struct vec3f){rgba[0], rgba[1], rgba[2]});
}

/* The share of a spot's intensity at this cosine from its axis: glTF 2.0, KHR_lights_punctual,
 * "Inner and Outer Cone Angles". */
static double spot_falloff(const struct scene_light *light, double cosine)
{
    if (cosine >= light->cos_inner)
        return 1;
    if (cosine <= light->cos_outer)
        return 0;
    const double t = (cosine - light->cos_outer) / (light->cos_inner - light->cos_outer);
    return t * t;
}

void scene_light_at(const struct scene_light *light, const double p[3], double to_light[3],
                    double *distance, double rgb[3])
{
    struct vec3 towards;
    double strength;
    if (light->kind == SCENE_SUN) {
        towards = vec3_scale(-1, light->direction);
        *distance = (double)INFINITY;
        strength = 1;
    } else {
        const struct vec3 way = vec3_sub(light->position, vec3_load(p));
        *distance = vec3_length(way);
        towards = vec3_normalize(way);
        strength = *distance > 0 ? 1 / (*distance * *distance) : 0;
        if (light->kind == SCENE_SPOT)
            strength *= spot_falloff(light, -vec3_dot(towards, light->direction));
    }
    vec3_store(to_light, towards);
    for (int c = 0; c < 3; c++)
        rgb[c] = strength * light->intensity[c];
}
