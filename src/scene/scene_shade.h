/* SPDX-License-Identifier: Apache-2.0 */
/* scene_shade: what a scene looks like from a point: its maps, materials, sky and lights. */
#ifndef SCENE_SHADE_H
#define SCENE_SHADE_H

#include "scene/scene.h"

/* A texel, x from the left and y from the top: linear RGB and alpha, 1 where it has none. */
void scene_texture_texel(const struct scene_texture *texture, uint32_t x, uint32_t y,
                         float rgba[4]);

/* Value of a map at (u, v): linear RGB, and alpha (1 where the texture has none). */
void scene_map_sample(const struct scene *scene, const struct scene_map *map, float u, float v,
                      float rgba[4]);

struct vec3f scene_albedo(const struct scene *scene, const struct scene_material *m, float u,
                          float v);

/* Where the vertices have colours: `tint` is theirs, factor of the albedo. */
struct vec3f scene_albedo_tinted(const struct scene *scene, const struct scene_material *m,
                                 struct vec3f tint, float u, float v);

/* The colour that vertices have at a point of a triangle: linear RGB and alpha. colour: a mesh's;
 * vertex: the triangle's; b, c: the point's barycentric weights of corners 1 and 2. */
static inline void scene_tint(const uint16_t *colour, const uint32_t vertex[3], float b, float c,
                              float rgba[4])
{
    const uint16_t *p = colour + 4 * (size_t)vertex[0], *q = colour + 4 * (size_t)vertex[1],
                   *r = colour + 4 * (size_t)vertex[2];
    for (int k = 0; k < 4; k++) {
        const float at_p = p[k], at_q = q[k], at_r = r[k];
        rgba[k] = (at_p + b * (at_q - at_p) + c * (at_r - at_p)) * (1.0f / 65535);
    }
}

/* The same of one texel, drawn with the weight that it has in the interpolation: the right albedo
 * in the mean, at a quarter of the reads from memory. scene_texel_draw (`bits`: 32 random bits)
 * sends for it, scene_texel_albedo reads it: what is done between the two hides the way to
 * memory. */
struct scene_texel {
    const struct scene_material *material;
    const uint8_t *code; /* NULL: to be interpolated, at: */
    float u, v;
};
struct scene_texel scene_texel_draw(const struct scene *scene, const struct scene_material *m,
                                    float u, float v, uint32_t bits);
struct vec3f scene_texel_albedo(const struct scene *scene, const struct scene_texel *texel);
struct vec3f scene_texel_albedo_tinted(const struct scene *scene, const struct scene_texel *texel,
                                       struct vec3f tint);

struct vec3f scene_emission(const struct scene *scene, const struct scene_material *m, float u,
                            float v);
/* The share of light that passes through the surface here: 0 opaque, 1 hole. */
float scene_transparency(const struct scene *scene, const struct scene_material *m, float u,
                         float v);
/* Where the vertices have colours: `tint` is their alpha, factor of the material's. */
float scene_transparency_tinted(const struct scene *scene, const struct scene_material *m,
                                float tint, float u, float v);

/* Radiance of the sky from a unit direction (pointing away from the viewer). */
/* A direction in the axes of the sky's picture, and back. */
static inline struct vec3f scene_sky_inward(const struct scene_sky *sky, struct vec3f d)
{
    const struct vec3 v = {(double)d.x, (double)d.y, (double)d.z};
    return sky->turned ? (struct vec3f){(float)vec3_dot(sky->front, v), (float)vec3_dot(sky->up, v),
                                        (float)vec3_dot(sky->right, v)}
                       : d;
}

static inline struct vec3f scene_sky_outward(const struct scene_sky *sky, struct vec3f d)
{
    if (!sky->turned)
        return d;
    const struct vec3 v =
        vec3_add(vec3_scale((double)d.x, sky->front),
                 vec3_add(vec3_scale((double)d.y, sky->up), vec3_scale((double)d.z, sky->right)));
    return (struct vec3f){(float)v.x, (float)v.y, (float)v.z};
}

struct vec3f scene_sky_radiance(const struct scene *scene, struct vec3f direction);

/* Irradiance-like strength of a punctual light at p, unoccluded: *to_light is the unit direction
 * towards it, *distance how far (INFINITY for a sun); rgb: what falls on a surface that faces it.
 * At the light itself: distance 0, no direction, black. */
void scene_light_at(const struct scene_light *light, const double p[3], double to_light[3],
                    double *distance, double rgb[3]);

#endif
