/* SPDX-License-Identifier: Apache-2.0 */
#include "place/vertices.h"
#include "base/array.h"
#include "base/error.h"
#include "math/affine.h"
#include "math/angle.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A corner of a triangle in the scene. */
struct corner {
    struct vec3 position, normal; /* of its face, unit */
    double angle;                 /* of the face at this corner, radians */
    size_t number;
};

static bool mirrors(const double *m)
{
    const struct vec3 x = {m[0], m[4], m[8]}, y = {m[1], m[5], m[9]}, z = {m[2], m[6], m[10]};
    return vec3_dot(vec3_cross(x, y), z) < 0;
}

static double angle_between(struct vec3 a, struct vec3 b)
{
    return angle_atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
}

/* The three corners of a triangle; returns false where it has no area in the scene. */
static bool make_corners(const struct scene_mesh *mesh, const struct scene_instance *instance,
                         size_t triangle, struct corner corner[3])
{
    struct vec3 p[3];
    for (size_t c = 0; c < 3; c++)
        p[c] = affine_point(instance->transform,
                            mesh->position + 3 * (size_t)mesh->index[3 * triangle + c]);
    struct vec3 normal = vec3_normalize(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
    if (!(vec3_length(normal) > 0))
        return false;
    if (mirrors(instance->transform)) /* turns the winding round, not the front (scene.h) */
        normal = vec3_scale(-1, normal);
    for (size_t c = 0; c < 3; c++) {
        const struct vec3 a = vec3_sub(p[(c + 1) % 3], p[c]), b = vec3_sub(p[(c + 2) % 3], p[c]);
        corner[c] =
            (struct corner){.position = p[c], .normal = normal, .angle = angle_between(a, b)};
    }
    return true;
}

static struct error *collect(const struct scene *scene, struct corner **corners, size_t *count)
{
    size_t number = 0;
    *count = 0;
    struct error *err = array_create(corners, 3 * scene_triangle_count(scene), sizeof **corners);
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++, number += 3) {
            struct corner *corner = *corners + *count;
            if (!make_corners(mesh, &scene->instances[i], t, corner))
                continue;
            for (size_t c = 0; c < 3; c++)
                corner[c].number = number + c;
            *count += 3;
        }
    }
    return err;
}

static int compare_numbers(double a, double b)
{
    return (a > b) - (a < b);
}

/* 0 and -0 are one place. */
static int compare_places(const struct corner *a, const struct corner *b)
{
    int order = compare_numbers(a->position.x, b->position.x);
    order = order ? order : compare_numbers(a->position.y, b->position.y);
    return order ? order : compare_numbers(a->position.z, b->position.z);
}

static int compare_corners(const void *a, const void *b)
{
    const struct corner *x = a, *y = b;
    const int order = compare_places(x, y);
    return order ? order : x->number < y->number ? -1 : 1;
}

static int compare_vertices(const void *a, const void *b)
{
    const struct vertex *x = a, *y = b;
    return x->corner < y->corner ? -1 : 1;
}

static void swap(struct corner *a, struct corner *b)
{
    const struct corner kept = *a;
    *a = *b;
    *b = kept;
}

/* Moves the corners that belong together with the first one to the front; returns how many. */
static size_t gather_group(struct corner *corner, size_t count, double cosine)
{
    size_t in = 1;
    for (size_t done = 0; done < in; done++)
        for (size_t i = in; i < count; i++)
            if (vec3_dot(corner[done].normal, corner[i].normal) >= cosine)
                swap(&corner[in++], &corner[i]);
    return in;
}

/* The vertex of a group. */
static struct vertex make_vertex(const struct corner *corner, size_t count)
{
    struct vec3 sum = {0, 0, 0};
    struct vertex vertex = {.corner = corner->number};
    for (size_t i = 0; i < count; i++) {
        sum = vec3_fma(sum, corner[i].angle, corner[i].normal);
        vertex.corner = corner[i].number < vertex.corner ? corner[i].number : vertex.corner;
    }
    /* radians: what is left of normals that cancel each other, around a pinched tube */
    const double least = 1e-9;
    vec3_store(vertex.position, corner->position);
    vec3_store(vertex.normal, vec3_length(sum) > least ? vec3_normalize(sum) : corner->normal);
    return vertex;
}

/* Notes whose corners they are: by the vertex's first one, until the vertices have their order. */
static void note_corners(struct vertices *vertices, const struct corner *corner, size_t count,
                         size_t first)
{
    for (size_t i = 0; i < count; i++)
        vertices->of_corner[corner[i].number] = first;
}

/* The vertices of corners at one place. */
static struct error *split_place(struct corner *corner, size_t count, double cosine,
                                 struct vertices *vertices)
{
    struct error *err = NULL;
    while (count && !err) {
        const size_t group = gather_group(corner, count, cosine);
        err = array_reserve(&vertices->list, &vertices->capacity, vertices->count + 1,
                            sizeof *vertices->list);
        if (!err) {
            vertices->list[vertices->count] = make_vertex(corner, group);
            note_corners(vertices, corner, group, vertices->list[vertices->count++].corner);
        }
        corner += group;
        count -= group;
    }
    return err;
}

/* In their order vertices are counted by their first corners. */
static void number_corners(struct vertices *vertices)
{
    size_t next = 0;
    for (size_t i = 0; i < vertices->corners; i++) {
        const size_t first = vertices->of_corner[i];
        if (first != SIZE_MAX)
            vertices->of_corner[i] = first == i ? next++ : vertices->of_corner[first];
    }
}

static struct error *start_corners(struct vertices *vertices, size_t corners)
{
    struct error *err = array_create(&vertices->of_corner, corners, sizeof *vertices->of_corner);
    vertices->corners = err ? 0 : corners;
    for (size_t i = 0; i < vertices->corners; i++)
        vertices->of_corner[i] = SIZE_MAX;
    return err;
}

struct error *vertices_find(const struct scene *scene, double crease, struct vertices *vertices)
{
    /* a crease of just that angle is smooth */
    const double rounding = 1e-9, cosine = angle_cos(crease * (ANGLE_PI / 180)) - rounding;
    struct corner *corners = NULL;
    size_t count = 0;
    struct error *err = collect(scene, &corners, &count);
    if (!err)
        err = start_corners(vertices, 3 * scene_triangle_count(scene));
    if (!err)
        qsort(corners, count, sizeof *corners, compare_corners);
    for (size_t first = 0, end = 0; first < count && !err; first = end) {
        while (end < count && !compare_places(&corners[first], &corners[end]))
            end++;
        err = split_place(corners + first, end - first, cosine, vertices);
    }
    if (!err && vertices->count)
        qsort(vertices->list, vertices->count, sizeof *vertices->list, compare_vertices);
    if (!err)
        number_corners(vertices);
    free(corners);
    return err;
}

void vertices_clear(struct vertices *vertices)
{
    free(vertices->list);
    free(vertices->of_corner);
    *vertices = (struct vertices){0};
}
