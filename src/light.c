#include "light.h"
#include "array.h"
#include "error.h"

#include <stdlib.h>
#include <string.h>

enum { PUNCTUAL = UINT32_MAX }; /* as a light's instance: `triangle` is its number among the scene's lights */

struct light {
    uint32_t instance, triangle;
    struct light_node *leaf; /* what is known of it before the tree is made */
};

/* A box of lights, the cone of the directions that they face, and their strength. Children stand together. */
struct light_node {
    struct vec3f low, high;
    struct vec3f axis; /* unit */
    float cosine;      /* of the cone's half angle: normals are no farther from the axis; -1 for lights that shine all round */
    float strength;    /* emissive: radiance times area; point and spot: intensity, in local units; luminance */
    uint32_t parent;
    uint32_t child; /* the first of two; 0: a leaf, of: */
    uint32_t light;
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
static float importance(const struct light_node *node, const struct lights_receiver *receiver, bool front_only)
{
    const struct vec3f centre = vec3f_scale(0.5f, vec3f_add(node->low, node->high));
    const struct vec3f half = vec3f_sub(node->high, centre), way = vec3f_sub(receiver->position, centre);
    const float radius2 = vec3f_dot(half, half), distance2 = vec3f_dot(way, way);
    if (!(distance2 > radius2)) /* inside the box's sphere: any direction is possible */
        return radius2 > 0 ? node->strength / radius2 : node->strength;
    const float inverse = 1 / sqrtf(distance2), sine_box = sqrtf(radius2) * inverse, cosine_box = sine_of(sine_box);
    float leaving = 1; /* cosine at the light */
    if (node->cosine > -1) {
        float cosine = vec3f_dot(node->axis, way) * inverse;
        cosine = front_only ? cosine : fabsf(cosine);
        const float within = cosine_between(sine_of(cosine), cosine, sine_of(node->cosine), node->cosine);
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
    return node->strength * leaving * arriving * inverse * inverse;
}

/* The cone that holds two: about the mean of their axes, as wide as the wider reaches. Not the least, but no angle is needed. */
static void join_cones(const struct light_node *a, const struct light_node *b, bool front_only, struct light_node *to)
{
    to->axis = a->axis;
    to->cosine = -1;
    if (!(a->cosine > -1 && b->cosine > -1))
        return;
    const struct vec3f axis_b = !front_only && vec3f_dot(a->axis, b->axis) < 0 ? vec3f_scale(-1, b->axis) : b->axis;
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
        to->cosine = float_least(to->cosine, away * cones[i] - sine_of(away) * sine_of(cones[i]) - 4e-7f);
    }
}

static void join(const struct light_node *a, const struct light_node *b, bool front_only, struct light_node *to)
{
    to->low = (struct vec3f){float_least(a->low.x, b->low.x), float_least(a->low.y, b->low.y), float_least(a->low.z, b->low.z)};
    to->high = (struct vec3f){float_most(a->high.x, b->high.x), float_most(a->high.y, b->high.y), float_most(a->high.z, b->high.z)};
    to->strength = a->strength + b->strength;
    join_cones(a, b, front_only, to);
}

/* -- leaves ------------------------------------------------------------------------------------ */

/* Luminance of a triangle's emission, averaged over a few points where it has a picture. */
static float emission(const struct tracer *t, uint32_t instance, uint32_t triangle)
{
    enum { STEPS = 4 };
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[instance].mesh];
    const struct scene_material *m = &t->scene->materials[mesh->material[triangle]];
    if (!scene_emits(m))
        return 0;
    if (m->emission_map.texture == SCENE_NONE)
        return vec3f_luminance(m->emission);
    float sum = 0;
    int points = 0;
    for (int i = 0; i < STEPS; i++) {
        for (int j = 0; j < STEPS - i; j++, points++) {
            struct trace_point p;
            trace_point_at(t, instance, triangle, ((float)i + 1.0f / 3) / STEPS, ((float)j + 1.0f / 3) / STEPS, &p);
            sum += vec3f_luminance(scene_emission(t->scene, m, p.u, p.v));
        }
    }
    /* A picture may shine between the points: a share of what it could give keeps every triangle in the draw. */
    return 0.95f * sum / (float)points + 0.05f * vec3f_luminance(m->emission);
}

static float triangle_area(const struct vec3f p[3])
{
    return 0.5f * vec3f_length(vec3f_cross(vec3f_sub(p[1], p[0]), vec3f_sub(p[2], p[0])));
}

/* A leaf for what gives light; its place in the tree comes later. */
static struct error *add_leaf(struct lights *lights, size_t *capacity, struct light light, struct light_node leaf)
{
    struct error *err = array_reserve(&lights->light, capacity, lights->count + 1, sizeof *lights->light);
    if (!err)
        err = array_create(&light.leaf, 1, sizeof *light.leaf);
    if (err)
        return err;
    *light.leaf = leaf;
    lights->light[lights->count++] = light;
    return NULL;
}

static struct error *add_triangle(struct lights *lights, const struct tracer *t, uint32_t instance, uint32_t triangle,
                                  float brightness, size_t *capacity)
{
    struct vec3f p[3];
    trace_corners(t, instance, triangle, p);
    struct light_node leaf = {.low = p[0], .high = p[0], .strength = brightness * triangle_area(p), .cosine = 1};
    if (!(leaf.strength > 0))
        return NULL;
    for (int i = 1; i < 3; i++) {
        const struct light_node corner = {.low = p[i], .high = p[i]};
        struct light_node both = leaf;
        join(&leaf, &corner, true, &both);
        leaf.low = both.low, leaf.high = both.high;
    }
    leaf.axis = vec3f_normalize(vec3f_cross(vec3f_sub(p[1], p[0]), vec3f_sub(p[2], p[0])));
    struct error *err = NULL;
    if (!lights->leaf[instance]) {
        const size_t triangles = t->scene->meshes[t->scene->instances[instance].mesh].triangle_count;
        err = array_create(&lights->leaf[instance], triangles, sizeof **lights->leaf);
        if (!err)
            memset(lights->leaf[instance], 0xff, triangles * sizeof **lights->leaf);
    }
    return err ? err : add_leaf(lights, capacity, (struct light){.instance = instance, .triangle = triangle}, leaf);
}

static struct error *add_punctual(struct lights *lights, const struct tracer *t, uint32_t index, size_t *capacity)
{
    const struct scene_light *light = &t->scene->lights[index];
    if (light->kind == SCENE_SUN)
        return NULL;
    const double position[3] = {light->position.x, light->position.y, light->position.z}, scale2 = t->scale * t->scale;
    const struct vec3f at = trace_to_local(t, position);
    const struct vec3f intensity = {(float)(light->intensity[0] * scale2), (float)(light->intensity[1] * scale2),
                                    (float)(light->intensity[2] * scale2)};
    struct light_node leaf = {.low = at, .high = at, .strength = vec3f_luminance(intensity), .cosine = -1};
    return leaf.strength > 0 ? add_leaf(lights, capacity, (struct light){.instance = PUNCTUAL, .triangle = index}, leaf) : NULL;
}

static struct error *add_leaves(struct lights *lights, const struct tracer *t)
{
    size_t capacity = 0;
    struct error *err = NULL;
    for (uint32_t i = 0; i < t->scene->instance_count && !err; i++) {
        const size_t triangles = t->scene->meshes[t->scene->instances[i].mesh].triangle_count;
        for (uint32_t j = 0; j < triangles && !err; j++) {
            const float brightness = emission(t, i, j);
            if (brightness > 0)
                err = add_triangle(lights, t, i, j, brightness, &capacity);
        }
    }
    for (uint32_t i = 0; i < t->scene->light_count && !err; i++)
        err = add_punctual(lights, t, i, &capacity);
    return err;
}

/* -- tree -------------------------------------------------------------------------------------- */

static float middle_on(const struct light *light, int axis)
{
    const struct light_node *n = light->leaf;
    return axis == 0 ? n->low.x + n->high.x : axis == 1 ? n->low.y + n->high.y : n->low.z + n->high.z;
}

/* A strict order, so that equal middles make no other tree. */
static bool stands_before(const struct light *a, const struct light *b, int axis)
{
    const float x = middle_on(a, axis), y = middle_on(b, axis);
    if (x != y)
        return x < y;
    return a->instance != b->instance ? a->instance < b->instance : a->triangle < b->triangle;
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

/* Makes node `at` of `count` lights from `first`: halves them along the axis on which they spread most. */
static void grow(struct lights *lights, uint32_t at, uint32_t first, uint32_t count, uint32_t *used)
{
    struct light_node *node = &lights->node[at];
    if (count == 1) {
        const struct light *light = &lights->light[first];
        const uint32_t parent = node->parent;
        *node = *light->leaf;
        node->parent = parent;
        node->light = first;
        if (light->instance != PUNCTUAL)
            lights->leaf[light->instance][light->triangle] = at;
        return;
    }
    const uint32_t half = count / 2, child = *used;
    split(lights->light + first, count, half, widest_axis(lights->light + first, count));
    *used += 2;
    node->child = child;
    for (uint32_t i = 0; i < 2; i++) {
        lights->node[child + i].parent = at;
        grow(lights, child + i, i ? first + half : first, i ? count - half : half, used);
    }
    join(&lights->node[child], &lights->node[child + 1], lights->front_only, node);
}

struct error *lights_create(struct lights *lights, const struct tracer *t)
{
    *lights = (struct lights){.instance_count = t->scene->instance_count, .front_only = t->scene->emit_front_only};
    struct error *err = array_create(&lights->leaf, t->scene->instance_count, sizeof *lights->leaf);
    if (!err)
        err = add_leaves(lights, t);
    if (!err && lights->count > UINT32_MAX / 2)
        err = error_new("%s: more lights than can be numbered", t->scene->path);
    if (!err && lights->count)
        err = array_create(&lights->node, 2 * lights->count - 1, sizeof *lights->node);
    if (!err && lights->count) {
        uint32_t used = 1;
        grow(lights, 0, 0, (uint32_t)lights->count, &used);
    }
    for (size_t i = 0; i < lights->count; i++) {
        free(lights->light[i].leaf);
        lights->light[i].leaf = NULL;
    }
    if (err)
        lights_clear(lights);
    return err;
}

void lights_clear(struct lights *lights)
{
    for (size_t i = 0; lights->leaf && i < lights->instance_count; i++)
        free(lights->leaf[i]);
    free(lights->leaf);
    free(lights->light);
    free(lights->node);
    *lights = (struct lights){0};
}

/* -- drawing ----------------------------------------------------------------------------------- */

bool lights_sample(const struct lights *lights, const struct tracer *t, const struct lights_receiver *receiver, double x, float y,
                   struct lights_choice *choice)
{
    const struct light_node *node = lights->node;
    float probability = 1;
    while (node->child) {
        const struct light_node *child = lights->node + node->child;
        const float first = importance(child, receiver, lights->front_only), second = importance(child + 1, receiver, lights->front_only);
        if (!(first + second > 0))
            return false;
        const float share = first / (first + second);
        const bool right = x >= (double)share;
        x = right ? (x - (double)share) / (1 - (double)share) : x / (double)share;
        probability *= right ? 1 - share : share;
        node = child + right;
    }
    const struct light light = lights->light[node->light];
    choice->probability = probability;
    choice->punctual = NULL;
    if (light.instance == PUNCTUAL) {
        choice->punctual = &t->scene->lights[light.triangle];
        return true;
    }
    /* Uniform in the triangle (Turk, "Generating random points in triangles", Graphics Gems, 1990). */
    const float r = sqrtf((float)x);
    struct vec3f p[3];
    trace_corners(t, light.instance, light.triangle, p);
    trace_point_at(t, light.instance, light.triangle, r * (1 - y), r * y, &choice->point);
    choice->density = probability / triangle_area(p);
    return true;
}

float lights_density(const struct lights *lights, const struct tracer *t, const struct lights_receiver *receiver,
                     const struct trace_point *point)
{
    const uint32_t *leaf = lights->leaf[point->instance];
    uint32_t at = leaf ? leaf[point->triangle] : UINT32_MAX;
    if (at == UINT32_MAX)
        return 0;
    struct vec3f p[3];
    trace_corners(t, point->instance, point->triangle, p);
    float density = 1 / triangle_area(p);
    for (uint32_t parent; at; at = parent) {
        parent = lights->node[at].parent;
        const struct light_node *child = lights->node + lights->node[parent].child;
        const float first = importance(child, receiver, lights->front_only), second = importance(child + 1, receiver, lights->front_only);
        if (!(first + second > 0))
            return 0;
        const float share = first / (first + second);
        density *= at == lights->node[parent].child ? share : 1 - share;
    }
    return density;
}
