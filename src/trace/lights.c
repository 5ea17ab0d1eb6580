/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/lights.h"
#include "base/array.h"
#include "base/error.h"
#include "math/luminance.h"
#include "trace/emission.h"
#include "scene/scene_shade.h"

#include <stdlib.h>
#include <string.h>

/* as a light's instance: `triangle` is its number among the scene's lights */
#define PUNCTUAL UINT32_MAX

/* as a light's part */
#define WHOLE UINT32_MAX

struct light {
    uint32_t instance, triangle;
    uint32_t part; /* of the triangle (parts.h) */
    /* of a triangle: corner 0, and from it to the mesh's corners 1 and 2; or where it stands */
    struct vec3f corner, along, across;
    struct vec3f axis;    /* unit: its normal, or the spot's direction */
    float area, strength; /* strength: as a node's */
};

/* Where lights are and which way they face. */
struct bounds {
    struct vec3f low, high;
    struct vec3f axis; /* unit */
    /* of the cone's half angle: normals are no farther from the axis; -1 for lights that shine all
     * round */
    float cosine;
    /* emissive: radiance times area; point and spot: intensity, in local units; luminance */
    float strength;
    float surfaces; /* the part of it that is of surfaces */
};

/* What of them a choice has to know. Children stand together. */
struct light_node {
    struct vec3f centre;
    float radius2; /* of the sphere about the box, squared */
    struct vec3f axis;
    float cosine, sine; /* of the cone */
    float strength, surfaces;
    uint32_t parent;
    uint32_t child; /* the first of two; 0: a leaf, of: */
    /* one light; or two triangles that make a flat quadrilateral, chosen by strength alone */
    uint32_t light, count;
};

/* -- bounds ------------------------------------------------------------------------------------ */

static float sine_of(float cosine)
{
    return sqrtf(float_most(1 - cosine * cosine, 0));
}

/* cos(a - b), or 1 where a < b; angles in [0, pi]. */
static float cosine_between(float sine_a, float cosine_a, float sine_b, float cosine_b)
{
    return cosine_a > cosine_b ? 1 : cosine_a * cosine_b + sine_a * sine_b;
}

/* An upper bound, up to a constant, of what a node's lights give the receiver. */
static float importance(const struct light_node *node, const struct lights_receiver *receiver,
                        bool front_only)
{
    const struct vec3f way = vec3f_sub(receiver->position, node->centre);
    const float radius2 = node->radius2, distance2 = vec3f_dot(way, way),
                strength = receiver->surfaces ? node->surfaces : node->strength;
    if (!(distance2 > radius2)) /* inside the box's sphere: any direction is possible */
        return radius2 > 0 ? strength / radius2 : strength;
    const float inverse2 = 1 / distance2, inverse = sqrtf(inverse2);
    const float sine_box = sqrtf(radius2 * inverse2), cosine_box = sqrtf(1 - radius2 * inverse2);
    float leaving = 1; /* cosine at the light */
    if (node->cosine > -1) {
        float cosine = vec3f_dot(node->axis, way) * inverse;
        cosine = front_only ? cosine : fabsf(cosine);
        const float within = cosine_between(sine_of(cosine), cosine, node->sine, node->cosine);
        leaving = cosine_between(sine_of(within), within, sine_box, cosine_box);
    }
    if (!(leaving > 0))
        return 0;
    float arriving = 1; /* cosine at the surface */
    const struct vec3f n = receiver->normal;
    if (n.x != 0 || n.y != 0 || n.z != 0) {
        const float cosine = -vec3f_dot(n, way) * inverse;
        arriving = float_most(cosine_between(sine_of(cosine), cosine, sine_box, cosine_box), 0);
    }
    return strength * leaving * arriving * inverse2;
}

/* The cone that holds two: about the mean of their axes, as wide as the wider reaches. Not the
 * least, but no angle is needed. */
static void join_cones(const struct bounds *a, const struct bounds *b, bool front_only,
                       struct bounds *to)
{
    to->axis = a->axis;
    to->cosine = -1;
    if (!(a->cosine > -1 && b->cosine > -1))
        return;
    const struct vec3f axis_b =
        !front_only && vec3f_dot(a->axis, b->axis) < 0 ? vec3f_scale(-1, b->axis) : b->axis;
    const struct vec3f sum = vec3f_add(a->axis, axis_b);
    if (!(vec3f_length(sum) > 0))
        return;
    to->axis = vec3f_normalize(sum);
    to->cosine = 1;
    const struct vec3f axes[2] = {a->axis, axis_b};
    const float cones[2] = {a->cosine, b->cosine};
    for (int i = 0; i < 2; i++) {
        const float away = float_least(vec3f_dot(to->axis, axes[i]), 1);
        if (away < -cones[i]) { /* the two angles are more than pi together */
            to->cosine = -1;
            return;
        }
        to->cosine =
            float_least(to->cosine, away * cones[i] - sine_of(away) * sine_of(cones[i]) - 4e-7f);
    }
}

static struct bounds join(const struct bounds *a, const struct bounds *b, bool front_only)
{
    struct bounds both = {.low = {float_least(a->low.x, b->low.x), float_least(a->low.y, b->low.y),
                                  float_least(a->low.z, b->low.z)},
                          .high = {float_most(a->high.x, b->high.x),
                                   float_most(a->high.y, b->high.y),
                                   float_most(a->high.z, b->high.z)},
                          .strength = a->strength + b->strength,
                          .surfaces = a->surfaces + b->surfaces};
    join_cones(a, b, front_only, &both);
    return both;
}

/* -- leaves ------------------------------------------------------------------------------------ */

static struct error *add_light(struct lights *lights, size_t *capacity, struct light light)
{
    struct error *err = light.strength > 0 ? array_reserve(&lights->light, capacity,
                                                           lights->count + 1, sizeof *lights->light)
                                           : NULL;
    if (!err && light.strength > 0)
        lights->light[lights->count++] = light;
    return err;
}

/* The numbers of an instance's triangles among the lights: none yet. */
static struct error *number_instance(struct lights *lights, const struct tracer *t,
                                     uint32_t instance)
{
    if (lights->number[instance])
        return NULL;
    const size_t triangles = t->scene->meshes[t->scene->instances[instance].mesh].triangle_count;
    struct error *err = array_create(&lights->number[instance], triangles, sizeof **lights->number);
    if (!err)
        memset(lights->number[instance], 0xff, triangles * sizeof **lights->number);
    return err;
}

/* A triangle as a light of no strength yet. */
static struct light light_of(const struct tracer *t, uint32_t instance, uint32_t triangle)
{
    struct trace_point corner[3];
    for (int i = 0; i < 3; i++)
        trace_point_at(t, instance, triangle, i == 1, i == 2, &corner[i]);
    struct light light = {.instance = instance,
                          .triangle = triangle,
                          .part = WHOLE,
                          .corner = corner[0].position,
                          .axis = corner[0].normal,
                          .along = vec3f_sub(corner[1].position, corner[0].position),
                          .across = vec3f_sub(corner[2].position, corner[0].position)};
    light.area = 0.5f * vec3f_length(vec3f_cross(light.along, light.across));
    return light;
}

static struct error *add_triangle(struct lights *lights, const struct tracer *t, uint32_t instance,
                                  uint32_t triangle, size_t *capacity)
{
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[instance].mesh];
    const struct scene_material *m = &t->scene->materials[mesh->material[triangle]];
    if (!scene_emits(m))
        return NULL;
    struct light light = light_of(t, instance, triangle);
    if (emission_varies(m))
        return parts_add(&lights->parts, t, instance, triangle, light.area);
    light.strength = luminance_vec3f(m->emission) * light.area;
    struct error *err = number_instance(lights, t, instance);
    return err ? err : add_light(lights, capacity, light);
}

/* A part of a triangle that shines, or all of it. */
static struct error *add_part(struct lights *lights, const struct tracer *t, uint32_t number,
                              size_t *capacity)
{
    const struct light_part *part = &lights->parts.part[number];
    const struct parts_root *root = &lights->parts.root[part->root];
    struct light light = light_of(t, root->instance, root->triangle);
    if (number != root->part) {
        light.part = number;
        light.corner =
            vec3f_fma(vec3f_fma(light.corner, part->b, light.along), part->c, light.across);
        light.along = vec3f_scale(part->size, light.along);
        light.across = vec3f_scale(part->size, light.across);
        light.area *= part->size * part->size;
    }
    light.strength = part->brightness * light.area;
    struct error *err = number_instance(lights, t, root->instance);
    return err ? err : add_light(lights, capacity, light);
}

/* Triangles with pictures, cut up by them. */
static struct error *add_parts(struct lights *lights, const struct tracer *t, size_t *capacity)
{
    struct error *err = parts_divide(&lights->parts, t->scene);
    for (uint32_t i = 0; i < lights->parts.count && !err; i++)
        if (!lights->parts.part[i].child && lights->parts.part[i].brightness > 0)
            err = add_part(lights, t, i, capacity);
    return err;
}

static struct error *add_punctual(struct lights *lights, const struct tracer *t, uint32_t index,
                                  size_t *capacity)
{
    const struct scene_light *light = &t->scene->lights[index];
    if (light->kind == SCENE_SUN)
        return NULL;
    const double position[3] = {light->position.x, light->position.y, light->position.z},
                 scale2 = t->scale * t->scale;
    const struct vec3f intensity = {(float)(light->intensity[0] * scale2),
                                    (float)(light->intensity[1] * scale2),
                                    (float)(light->intensity[2] * scale2)};
    return add_light(lights, capacity,
                     (struct light){.instance = PUNCTUAL,
                                    .part = WHOLE,
                                    .triangle = index,
                                    .corner = trace_to_local(t, position),
                                    .strength = luminance_vec3f(intensity)});
}

static struct error *add_leaves(struct lights *lights, const struct tracer *t)
{
    size_t capacity = 0;
    struct error *err = NULL;
    for (uint32_t i = 0; i < t->scene->instance_count && !err; i++) {
        const size_t triangles = t->scene->meshes[t->scene->instances[i].mesh].triangle_count;
        for (uint32_t j = 0; j < triangles && !err; j++)
            err = add_triangle(lights, t, i, j, &capacity);
    }
    if (!err)
        err = add_parts(lights, t, &capacity);
    for (uint32_t i = 0; i < t->scene->light_count && !err; i++)
        err = add_punctual(lights, t, i, &capacity);
    return err;
}

/* -- tree -------------------------------------------------------------------------------------- */

/* Three times the middle's coordinate. */
static float middle_on(const struct light *l, int axis)
{
    return axis == 0   ? 3 * l->corner.x + l->along.x + l->across.x
           : axis == 1 ? 3 * l->corner.y + l->along.y + l->across.y
                       : 3 * l->corner.z + l->along.z + l->across.z;
}

/* A strict order, so that equal middles make no other tree. */
static bool stands_before(const struct light *a, const struct light *b, int axis)
{
    const float x = middle_on(a, axis), y = middle_on(b, axis);
    if (x != y)
        return x < y;
    if (a->instance != b->instance)
        return a->instance < b->instance;
    return a->triangle != b->triangle ? a->triangle < b->triangle : a->part < b->part;
}

/* Puts the k lights that stand first along an axis first (Hoare's quickselect). */
static void split(struct light *light, size_t count, size_t k, int axis)
{
    for (size_t first = 0, last = count - 1; first < last;) {
        const struct light pivot = light[first + (last - first) / 2];
        size_t i = first, j = last;
        while (i <= j) {
            while (stands_before(&light[i], &pivot, axis))
                i++;
            while (stands_before(&pivot, &light[j], axis))
                j--;
            if (i <= j) {
                const struct light other = light[i];
                light[i++] = light[j];
                light[j] = other;
                if (!j)
                    break;
                j--;
            }
        }
        if (k <= j)
            last = j;
        else if (k >= i)
            first = i;
        else
            break;
    }
}

static int widest_axis(const struct light *light, size_t count)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            low[k] = float_least(low[k], middle_on(&light[i], k));
            high[k] = float_most(high[k], middle_on(&light[i], k));
        }
    }
    int axis = high[1] - low[1] > high[0] - low[0] ? 1 : 0;
    if (high[2] - low[2] > high[axis] - low[axis])
        axis = 2;
    return axis;
}

static struct bounds bounds_of(const struct light *l)
{
    const struct vec3f p = l->corner, q = vec3f_add(p, l->along), r = vec3f_add(p, l->across);
    return (struct bounds){
        .low = {float_least(p.x, float_least(q.x, r.x)), float_least(p.y, float_least(q.y, r.y)),
                float_least(p.z, float_least(q.z, r.z))},
        .high = {float_most(p.x, float_most(q.x, r.x)), float_most(p.y, float_most(q.y, r.y)),
                 float_most(p.z, float_most(q.z, r.z))},
        .axis = l->axis,
        .cosine = l->instance == PUNCTUAL ? -1 : 1,
        .strength = l->strength,
        .surfaces = l->instance == PUNCTUAL ? 0 : l->strength};
}

static void set_bounds(struct light_node *node, const struct bounds *b)
{
    const struct vec3f half = vec3f_scale(0.5f, vec3f_sub(b->high, b->low));
    node->centre = vec3f_add(b->low, half);
    node->radius2 = vec3f_dot(half, half);
    node->axis = b->axis;
    node->cosine = b->cosine;
    node->sine = sine_of(b->cosine);
    node->strength = b->strength;
    node->surfaces = b->surfaces;
}

/* Whether two triangles are the halves of a flat quadrilateral: the same normal, and two corners
 * that are the same. */
static bool make_quadrilateral(const struct light *a, const struct light *b)
{
    if (a->instance != b->instance || a->instance == PUNCTUAL ||
        !(vec3f_dot(a->axis, b->axis) > 0.99999f))
        return false;
    const struct vec3f p[3] = {a->corner, vec3f_add(a->corner, a->along),
                               vec3f_add(a->corner, a->across)};
    const struct vec3f q[3] = {b->corner, vec3f_add(b->corner, b->along),
                               vec3f_add(b->corner, b->across)};
    const float near = 1e-5f * (vec3f_length(a->along) + vec3f_length(b->along));
    int same = 0;
    for (int i = 0; i < 9; i++)
        same += vec3f_length(vec3f_sub(p[i / 3], q[i % 3])) < near;
    return same == 2;
}

/* Makes a leaf of one light or two. */
static struct bounds make_leaf(struct lights *lights, struct light_node *node, uint32_t first,
                               uint32_t count)
{
    const struct light *light = &lights->light[first];
    node->light = first;
    node->count = count;
    for (uint32_t i = 0; i < count; i++) {
        if (light[i].part != WHOLE)
            lights->parts.part[light[i].part].light = first + i;
        else if (light[i].instance != PUNCTUAL)
            lights->number[light[i].instance][light[i].triangle] = first + i;
    }
    const struct bounds bounds = bounds_of(&light[0]);
    if (count == 1)
        return bounds;
    const struct bounds other = bounds_of(&light[1]);
    return join(&bounds, &other, lights->front_only);
}

/* Makes node `at` of `count` lights from `first`: halves them along the axis on which they spread
 * most. */
static struct bounds grow(struct lights *lights, uint32_t at, uint32_t first, uint32_t count,
                          uint32_t *used)
{
    struct light *light = &lights->light[first];
    struct bounds bounds;
    if (count == 1 || (count == 2 && make_quadrilateral(&light[0], &light[1]))) {
        bounds = make_leaf(lights, &lights->node[at], first, count);
    } else {
        const uint32_t half = count / 2, child = *used;
        split(light, count, half, widest_axis(light, count));
        *used += 2;
        lights->node[at].child = child;
        lights->node[child].parent = lights->node[child + 1].parent = at;
        const struct bounds a = grow(lights, child, first, half, used),
                            b = grow(lights, child + 1, first + half, count - half, used);
        bounds = join(&a, &b, lights->front_only);
    }
    set_bounds(&lights->node[at], &bounds);
    return bounds;
}

/* Tells every light which leaf holds it. */
static struct error *number_leaves(struct lights *lights, uint32_t nodes)
{
    struct error *err =
        array_create(&lights->node_of_light, lights->count, sizeof *lights->node_of_light);
    for (uint32_t i = 0; i < nodes && !err; i++)
        for (uint32_t k = 0; k < lights->node[i].count; k++)
            lights->node_of_light[lights->node[i].light + k] = i;
    return err;
}

/* Tells every triangle that is cut up its parts. */
static void number_parts(struct lights *lights)
{
    for (size_t i = 0; i < lights->parts.root_count; i++) {
        const struct parts_root *root = &lights->parts.root[i];
        if (lights->parts.part[root->part].child && lights->number[root->instance])
            lights->number[root->instance][root->triangle] = (uint32_t)lights->count + root->part;
    }
}

struct error *lights_init(struct lights *lights, const struct tracer *t)
{
    *lights = (struct lights){.instance_count = t->scene->instance_count,
                              .front_only = t->scene->emit_front_only};
    struct error *err =
        array_create(&lights->number, t->scene->instance_count, sizeof *lights->number);
    if (!err)
        err = add_leaves(lights, t);
    if (!err && lights->count + lights->parts.count > UINT32_MAX / 2)
        err = error_new("%s: more lights than can be numbered", t->scene->path);
    if (!err && lights->count)
        err = array_create(&lights->node, 2 * lights->count - 1, sizeof *lights->node);
    if (!err && lights->count) {
        uint32_t used = 1;
        grow(lights, 0, 0, (uint32_t)lights->count, &used);
        number_parts(lights);
        err = number_leaves(lights, used);
    }
    if (!err && lights->count && !isfinite(lights->node[0].strength))
        err = error_new("the lights are together beyond what 32 bits can hold: --light-scale "
                        "brings down those of the file");
    if (err)
        lights_clear(lights);
    return err;
}

void lights_clear(struct lights *lights)
{
    for (size_t i = 0; lights->number && i < lights->instance_count; i++)
        free(lights->number[i]);
    free(lights->number);
    free(lights->light);
    free(lights->node);
    free(lights->node_of_light);
    parts_clear(&lights->parts);
    *lights = (struct lights){0};
}

/* -- drawing ----------------------------------------------------------------------------------- */

double lights_strength(const struct lights *lights)
{
    return lights->count ? (double)lights->node[0].strength : 0;
}

/* The share of a node's draws that go to its first child; NaN: its lights cannot reach the
 * receiver. */
static float first_share(const struct lights *lights, const struct light_node *node,
                         const struct lights_receiver *receiver)
{
    const struct light_node *child = lights->node + node->child;
    if (!receiver)
        return child[0].strength / (child[0].strength + child[1].strength);
    const float first = importance(child, receiver, lights->front_only),
                second = importance(child + 1, receiver, lights->front_only);
    return first / (first + second);
}

/* Draws a point of a light by x and y, uniform in [0, 1). */
static void draw_point(const struct lights *lights, const struct tracer *t,
                       const struct light *light, float probability, float x, float y,
                       struct lights_choice *choice)
{
    choice->probability = probability;
    choice->punctual = NULL;
    if (light->instance == PUNCTUAL) {
        choice->punctual = &t->scene->lights[light->triangle];
        return;
    }
    /* Uniform in the triangle (Turk, "Generating random points in triangles", Graphics Gems,
     * 1990). */
    const float r = sqrtf(x), b = r * (1 - y), c = r * y;
    choice->point.position = vec3f_fma(vec3f_fma(light->corner, b, light->along), c, light->across);
    choice->point.normal = light->axis;
    choice->point.instance = light->instance;
    choice->point.triangle = light->triangle;
    choice->point.b = b;
    choice->point.c = c;
    if (light->part != WHOLE) {
        const struct light_part *part = &lights->parts.part[light->part];
        choice->point.b = part->b + part->size * b;
        choice->point.c = part->c + part->size * c;
    }
    trace_point_shade(t, &choice->point);
    choice->density = probability / light->area;
    choice->brightness = light->strength / light->area;
}

bool lights_sample(const struct lights *lights, const struct tracer *t,
                   const struct lights_receiver *receiver, double x, float y,
                   struct lights_choice *choice)
{
    const struct light_node *node = lights->node;
    float probability = 1;
    while (node->child) {
        const float share = first_share(lights, node, receiver);
        if (isnan(share))
            return false;
        const bool second = x >= (double)share;
        x = second ? (x - (double)share) / (1 - (double)share) : x / (double)share;
        probability *= second ? 1 - share : share;
        node = lights->node + node->child + second;
    }
    const struct light *light = &lights->light[node->light];
    if (node->count == 2) {
        const float share = light->strength / node->strength;
        const bool second = x >= (double)share;
        x = second ? (x - (double)share) / (1 - (double)share) : x / (double)share;
        probability *= second ? 1 - share : share;
        light += second;
    }
    draw_point(lights, t, light, probability, (float)x, y, choice);
    return true;
}

void lights_draw(const struct lights *lights, const struct tracer *t, size_t number, float x,
                 float y, struct lights_choice *choice)
{
    draw_point(lights, t, &lights->light[number], 1, x, y, choice);
}

float lights_density(const struct lights *lights, const struct lights_receiver *receiver,
                     const struct trace_point *point)
{
    const uint32_t *numbers = lights->number[point->instance];
    uint32_t number = numbers ? numbers[point->triangle] : UINT32_MAX;
    if (number != UINT32_MAX && number >= lights->count) { /* in parts */
        const uint32_t whole = number - (uint32_t)lights->count;
        number = lights->parts.part[parts_find(&lights->parts, whole, point->b, point->c)].light;
    }
    if (number == UINT32_MAX)
        return 0;
    const struct light *light = &lights->light[number];
    uint32_t at = lights->node_of_light[number];
    float density = 1 / light->area;
    if (lights->node[at].count == 2) {
        const float share = lights->light[lights->node[at].light].strength /
                            lights->node[at].strength;
        density *= number == lights->node[at].light ? share : 1 - share;
    }
    for (uint32_t parent; at; at = parent) {
        parent = lights->node[at].parent;
        const float share = first_share(lights, &lights->node[parent], receiver);
        if (isnan(share))
            return 0;
        density *= at == lights->node[parent].child ? share : 1 - share;
    }
    return density;
}
