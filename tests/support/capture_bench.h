/* SPDX-License-Identifier: Apache-2.0 */
/* capture_bench: scenes that are put together by hand, ready to be captured.
 *
 *     struct bench b;
 *     bench_start(&b);
 *     add_cube(&b, 2, material(0.5f, 1));          any of the parts; settings and lights go into
 *                                                  b.settings
 *     bench_finish(&b, 64);
 *     struct capture_probe p = capture(&b, &settings, 0, 0, 0);
 *     bench_clear(&b);
 *
 * A shape is a bare mesh; the tests need its triangles again for the truth. Whatever fails here
 * ends the test.
 */
#ifndef CAPTURE_BENCH_H
#define CAPTURE_BENCH_H

#include "base/array.h"
#include "base/error.h"
#include "capture/capture.h"
#include "math/angle.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI ANGLE_PI

/* -- the bench -------------------------------------------------------------------------------- */

/* A scene that is put together by hand, its tracer and path tracer. */
struct bench {
    struct scene *scene;
    struct tracer *tracer;
    struct path_tracer path;
    struct scene_settings settings;
};

static inline void bench_start(struct bench *b)
{
    *b = (struct bench){.settings = scene_settings_default()};
    must(scene_create(&b->scene));
}

static inline void bench_finish(struct bench *b, int bounces)
{
    must(scene_finish(b->scene, &b->settings, NULL));
    must(trace_create(&b->tracer, b->scene));
    must(path_init(&b->path, b->tracer, bounces));
}

static inline void bench_clear(struct bench *b)
{
    path_clear(&b->path);
    trace_destroy(b->tracer);
    scene_destroy(b->scene);
    scene_settings_clear(&b->settings);
}

static inline struct capture_probe capture(const struct bench *b, const struct capture_settings *s,
                                           double x, double y, double z)
{
    struct capture_probe probe;
    must(capture_probe(&b->path, s, (const double[3]){x, y, z}, NULL, &probe));
    return probe;
}

/* -- parts ------------------------------------------------------------------------------------ */

/* The three channels differ, so that none can stand for another. */
static inline struct scene_material material(float albedo, float emission)
{
    static char name[] = "m";
    return (struct scene_material){.name = name,
                                   .albedo = {albedo, albedo / 2, albedo / 4},
                                   .emission = {emission, 2 * emission, emission / 2},
                                   .albedo_map = {.texture = SCENE_NONE},
                                   .emission_map = {.texture = SCENE_NONE},
                                   .alpha_map = {.texture = SCENE_NONE},
                                   .opacity = 1,
                                   .cutoff = 0.5f};
}

static inline void add_quad(struct bench *b, const double corner[12], struct scene_material m)
{
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    must(scene_add_mesh(b->scene, 4, corner, 2, index, &m));
}

/* A cube about the origin, faces inward. */
static inline void add_cube(struct bench *b, double half, struct scene_material m)
{
    double p[24];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = i >> k & 1 ? half : -half;
    const uint32_t quad[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                 {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t index[36];
    for (int i = 0; i < 6; i++) {
        const uint32_t *q = quad[i], two[6] = {q[0], q[2], q[1], q[0], q[3], q[2]};
        memcpy(index + 6 * i, two, sizeof two);
    }
    must(scene_add_mesh(b->scene, 8, p, 12, index, &m));
}

/* A horizontal square about (0, y, 0), facing up. */
static inline void add_floor(struct bench *b, double half, double y, struct scene_material m)
{
    add_quad(b, (const double[12]){-half, y, -half, -half, y, half, half, y, half, half, y, -half},
             m);
}

static inline void add_light(struct bench *b, struct scene_light light)
{
    struct scene_settings *s = &b->settings;
    must(array_reserve(&s->lights, &s->light_capacity, s->light_count + 1, sizeof *s->lights));
    s->lights[s->light_count++] = light;
}

/* -- shapes ----------------------------------------------------------------------------------- */

struct shape {
    double *position;
    uint32_t *index;
    size_t vertex_count, triangle_count;
};

static inline struct shape shape_create(size_t vertices, size_t triangles)
{
    struct shape s = {.vertex_count = vertices, .triangle_count = triangles};
    must(array_create(&s.position, 3 * vertices, sizeof *s.position));
    must(array_create(&s.index, 3 * triangles, sizeof *s.index));
    return s;
}

static inline void shape_clear(struct shape *s)
{
    free(s->position);
    free(s->index);
    *s = (struct shape){0};
}

static inline void add_shape(struct bench *b, const struct shape *s, struct scene_material m)
{
    must(scene_add_mesh(b->scene, s->vertex_count, s->position, s->triangle_count, s->index, &m));
}

static inline struct vec3 shape_corner(const struct shape *s, size_t triangle, size_t k)
{
    return vec3_load(s->position + 3 * (size_t)s->index[3 * triangle + k]);
}

/* Normal times area of a triangle. */
static inline struct vec3 shape_area_vector(const struct shape *s, size_t triangle)
{
    const struct vec3 a = shape_corner(s, triangle, 0);
    return vec3_scale(0.5, vec3_cross(vec3_sub(shape_corner(s, triangle, 1), a),
                                      vec3_sub(shape_corner(s, triangle, 2), a)));
}

static inline double shape_area(const struct shape *s)
{
    double sum = 0;
    for (size_t t = 0; t < s->triangle_count; t++)
        sum += vec3_length(shape_area_vector(s, t));
    return sum;
}

/* p -> rows (3x3) p + offset, for every vertex. */
static inline void shape_place(struct shape *s, const double rows[9], struct vec3 offset)
{
    for (size_t i = 0; i < s->vertex_count; i++) {
        const struct vec3 p = vec3_load(s->position + 3 * i);
        const struct vec3 q = {vec3_dot(vec3_load(rows), p), vec3_dot(vec3_load(rows + 3), p),
                               vec3_dot(vec3_load(rows + 6), p)};
        vec3_store(s->position + 3 * i, vec3_add(q, offset));
    }
}

static inline void shape_move(struct shape *s, double x, double y, double z)
{
    shape_place(s, (const double[9]){1, 0, 0, 0, 1, 0, 0, 0, 1}, (struct vec3){x, y, z});
}

/* Writes the triangle a b c of the unit sphere, split `levels` times into four, from triangle *next
 * on. */
static inline void sphere_split(struct shape *s, struct vec3 a, struct vec3 b, struct vec3 c,
                                int levels, size_t *next)
{
    if (!levels) {
        const struct vec3 corner[3] = {a, b, c};
        for (size_t k = 0; k < 3; k++) {
            s->index[3 * *next + k] = (uint32_t)(3 * *next + k);
            vec3_store(s->position + 9 * *next + 3 * k, corner[k]);
        }
        ++*next;
        return;
    }
    const struct vec3 ab = vec3_normalize(vec3_add(a, b)), bc = vec3_normalize(vec3_add(b, c)),
                      ca = vec3_normalize(vec3_add(c, a));
    sphere_split(s, a, ab, ca, levels - 1, next);
    sphere_split(s, ab, b, bc, levels - 1, next);
    sphere_split(s, ca, bc, c, levels - 1, next);
    sphere_split(s, ab, bc, ca, levels - 1, next);
}

/* A sphere about the origin, facing outward: an icosahedron of 20 * 4^levels triangles,
 * inscribed. */
static inline struct shape shape_sphere(double radius, int levels)
{
    const double g = (1 + sqrt(5)) / 2;
    const struct vec3 v[12] = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                               {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                               {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    static const int face[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const size_t triangles = (size_t)20 << 2 * levels;
    struct shape s = shape_create(3 * triangles, triangles);
    size_t next = 0;
    for (int i = 0; i < 20; i++)
        sphere_split(&s, vec3_normalize(v[face[i][0]]), vec3_normalize(v[face[i][1]]),
                     vec3_normalize(v[face[i][2]]), levels, &next);
    shape_place(&s, (const double[9]){radius, 0, 0, 0, radius, 0, 0, 0, radius}, (struct vec3){0});
    return s;
}

/* Takes the triangles out of s whose middle, seen from the origin, lies within the cone about the
 * unit `axis`, and returns them. */
static inline struct shape shape_cut(struct shape *s, struct vec3 axis, double cosine)
{
    struct shape cut = shape_create(s->vertex_count, s->triangle_count);
    memcpy(cut.position, s->position, 3 * s->vertex_count * sizeof *s->position);
    size_t kept = 0;
    cut.triangle_count = 0;
    for (size_t t = 0; t < s->triangle_count; t++) {
        const struct vec3 sum =
            vec3_add(shape_corner(s, t, 0), vec3_add(shape_corner(s, t, 1), shape_corner(s, t, 2)));
        const bool within = vec3_dot(vec3_normalize(sum), axis) > cosine;
        uint32_t *to = within ? cut.index + 3 * cut.triangle_count++ : s->index + 3 * kept++;
        memmove(to, s->index + 3 * t, 3 * sizeof *to);
    }
    s->triangle_count = kept;
    return cut;
}

/* A disc about the origin in the plane y = 0: a fan whose area is the disc's. */
static inline struct shape shape_disc(double radius, size_t corners)
{
    struct shape s = shape_create(corners + 1, corners);
    const double step = 2 * PI / (double)corners, r = radius * sqrt(step / sin(step));
    for (size_t i = 0; i < corners; i++) {
        s.position[3 * i + 3] = r * cos(step * (double)i);
        s.position[3 * i + 5] = r * sin(step * (double)i);
        s.index[3 * i + 1] = (uint32_t)(i + 1);
        s.index[3 * i + 2] = (uint32_t)((i + 1) % corners + 1);
    }
    return s;
}

/* A square of 2 n^2 triangles in the plane y = 0, facing up. */
static inline struct shape shape_grid(double half, size_t n)
{
    struct shape s = shape_create((n + 1) * (n + 1), 2 * n * n);
    for (size_t i = 0; i <= n; i++) {
        for (size_t j = 0; j <= n; j++) {
            s.position[3 * (i * (n + 1) + j)] = half * (2 * (double)j / (double)n - 1);
            s.position[3 * (i * (n + 1) + j) + 2] = half * (2 * (double)i / (double)n - 1);
        }
    }
    for (size_t i = 0; i < n * n; i++) {
        const uint32_t at = (uint32_t)(i / n * (n + 1) + i % n), below = at + (uint32_t)n + 1;
        const uint32_t two[6] = {at, below, below + 1, at, below + 1, at + 1};
        memcpy(s.index + 6 * i, two, sizeof two);
    }
    return s;
}

/* -- textures --------------------------------------------------------------------------------- */

/* Adds a texture of floats, which it copies; not smoothed between the texels. */
static inline int32_t add_texture(struct bench *b, uint32_t width, uint32_t height,
                                  unsigned channels, const float *texels)
{
    struct scene_texture t = {
        .width = width, .height = height, .channels = channels, .nearest = true};
    const size_t count = (size_t)width * height * channels;
    int32_t index = SCENE_NONE;
    float *copy = NULL;
    must(array_create(&copy, count, sizeof *copy));
    memcpy(copy, texels, count * sizeof *copy);
    t.texels = copy;
    must(scene_push_texture(b->scene, t, &index));
    return index;
}

/* Gives the mesh that was added last, a quad, texture coordinates: (0, 0), (1, 0), (1, 1), (0, 1)
 * at its corners. */
static inline void map_quad(struct bench *b)
{
    static const float uv[12] = {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};
    struct scene_mesh *mesh = &b->scene->meshes[b->scene->mesh_count - 1];
    must(array_create(&mesh->uv, 12, sizeof *mesh->uv));
    memcpy(mesh->uv, uv, sizeof uv);
}

#endif
