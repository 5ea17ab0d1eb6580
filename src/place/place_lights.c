/* SPDX-License-Identifier: Apache-2.0 */
/* The method `lights`: probes around what shines.
 *
 * A point or spot light has six, on the axes. An emissive surface is cut into pieces: connected
 * triangles that look along the same of the six axes, more or less, and are no larger than some
 * offsets, so that a lamp's box has a piece a side, a bulb six, a luminous ceiling many. Each has a
 * probe before its middle, weighed by what shines there, on each side that emits. What is behind
 * another surface as seen from there gets none. After Sukys, "Light probe placement" (3.1.3), who
 * says no more than that there are several around each light.
 */
#include "base/array.h"
#include "base/error.h"
#include "math/affine.h"
#include "math/luminance.h"
#include "math/vec.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "trace/emission.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The offset, as a share of the diagonal of the scene's box, unless told otherwise; the largest
 * side of a piece, in offsets; and that of what it is put together of, in pieces. */
static const double OFFSET_SHARE = 0.02, PIECE_SIDE = 10, SHARD_SIDE = 0.125;

enum { SHARDS_MOST = 1000000 };

/* A part of an emissive surface. */
struct shard {
    struct vec3 corner[3];
    struct vec3 normal; /* of its front, times its area */
    double weight;      /* area times brightness */
    uint32_t component;
    int facet;        /* the axis that it looks along, 0 .. 5 */
    uint32_t cell[3]; /* of its facet */
    size_t number;
};

/* A triangle that shines, or a part of one. */
struct glow {
    struct vec3 corner[3];
    float uv[3][2], alpha_uv[3][2];   /* for its emission map and its alpha map */
    const struct emission_maps *maps; /* NULL: it shines evenly */
    int32_t material;
    double brightness; /* where it does */
    uint32_t component;
    bool mirrored;
};

struct lamps {
    const struct scene *scene;
    const struct tracer *tracer;
    double offset;
    struct shard *shard;
    size_t count, capacity;
    size_t surfaces, pieces, hidden;
};

/* -- shards ----------------------------------------------------------------------------------- */

/* The axis, of ties the first; a little more does not make another of it. */
static int facet_of(struct vec3 normal, bool mirrored)
{
    double n[3];
    int axis = 0;
    vec3_store(n, mirrored ? vec3_scale(-1, normal) : normal);
    for (int k = 1; k < 3; k++)
        if (fabs(n[k]) > 1.01 * fabs(n[axis]))
            axis = k;
    return 2 * axis + (n[axis] < 0);
}

static void halve_uv(const float a[2], const float b[2], float middle[2])
{
    for (int k = 0; k < 2; k++)
        middle[k] = (a[k] + b[k]) / 2;
}

/* What is left when corner `gone` goes to the middle between it and corner `kept`. */
static struct glow half_of(const struct glow *whole, int gone, int kept)
{
    struct glow half = *whole;
    half.corner[gone] = vec3_scale(0.5, vec3_add(whole->corner[gone], whole->corner[kept]));
    halve_uv(whole->uv[gone], whole->uv[kept], half.uv[gone]);
    halve_uv(whole->alpha_uv[gone], whole->alpha_uv[kept], half.alpha_uv[gone]);
    return half;
}

static struct error *add_whole(struct lamps *l, const struct glow *g)
{
    const struct vec3 *p = g->corner,
                      twice = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
    const double brightness =
        g->maps ? (double)emission_over(g->maps, g->material, g->uv, g->alpha_uv).mean
                : g->brightness;
    if (!(vec3_length(twice) > 0) || !(brightness > 0))
        return NULL;
    if (l->count >= SHARDS_MOST)
        return error_new("the surfaces that emit are too large for pieces of ten times --offset "
                         "%g: expected a larger one",
                         l->offset);
    struct error *err = array_reserve(&l->shard, &l->capacity, l->count + 1, sizeof *l->shard);
    if (err)
        return err;
    l->shard[l->count] = (struct shard){.corner = {p[0], p[1], p[2]},
                                        .normal = vec3_scale(g->mirrored ? -0.5 : 0.5, twice),
                                        .weight = vec3_length(twice) / 2 * brightness,
                                        .component = g->component,
                                        .facet = facet_of(twice, g->mirrored),
                                        .number = l->count};
    l->count++;
    return NULL;
}

/* Halves along the longest side what is too large. */
static struct error *add_glow(struct lamps *l, const struct glow *g)
{
    int longest = 0;
    double length[3];
    for (int k = 0; k < 3; k++) {
        length[k] = vec3_length(vec3_sub(g->corner[(k + 1) % 3], g->corner[k]));
        longest = length[k] > length[longest] ? k : longest;
    }
    if (length[longest] <= SHARD_SIDE * PIECE_SIDE * l->offset)
        return add_whole(l, g);
    const struct glow one = half_of(g, (longest + 1) % 3, longest),
                      two = half_of(g, longest, (longest + 1) % 3);
    struct error *err = add_glow(l, &one);
    return err ? err : add_glow(l, &two);
}

/* -- components: emissive triangles that share corners ----------------------------------------- */

struct corner {
    struct vec3 p;
    uint32_t triangle;
};

struct emitter {
    uint32_t instance, triangle;
    uint32_t parent; /* of the disjoint sets */
};

static int compare_numbers(double a, double b)
{
    return (a > b) - (a < b);
}

static int compare_corners(const void *a, const void *b)
{
    const struct corner *x = a, *y = b;
    int order = compare_numbers(x->p.x, y->p.x);
    order = order ? order : compare_numbers(x->p.y, y->p.y);
    order = order ? order : compare_numbers(x->p.z, y->p.z);
    return order ? order : (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static void corners_of(const struct scene *scene, const struct emitter *e, struct vec3 p[3])
{
    const struct scene_instance *instance = &scene->instances[e->instance];
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    for (size_t c = 0; c < 3; c++)
        p[c] = affine_point(instance->transform,
                            mesh->position + 3 * (size_t)mesh->index[3 * (size_t)e->triangle + c]);
}

static uint32_t find_set(struct emitter *e, uint32_t i)
{
    while (e[i].parent != i)
        i = e[i].parent = e[e[i].parent].parent;
    return i;
}

/* Joins the emitters that have a corner in one place. */
static struct error *connect(const struct scene *scene, struct emitter *emitter, size_t count)
{
    struct corner *corner = NULL;
    struct error *err = array_create(&corner, 3 * count, sizeof *corner);
    for (size_t i = 0; i < count && !err; i++) {
        struct vec3 p[3];
        corners_of(scene, &emitter[i], p);
        emitter[i].parent = (uint32_t)i;
        for (size_t c = 0; c < 3; c++)
            corner[3 * i + c] = (struct corner){p[c], (uint32_t)i};
    }
    if (!err && count)
        qsort(corner, 3 * count, sizeof *corner, compare_corners);
    for (size_t i = 1; i < 3 * count && !err; i++) {
        const struct corner *a = &corner[i - 1], *b = &corner[i];
        if (compare_numbers(a->p.x, b->p.x) || compare_numbers(a->p.y, b->p.y) ||
            compare_numbers(a->p.z, b->p.z))
            continue;
        const uint32_t x = find_set(emitter, a->triangle), y = find_set(emitter, b->triangle);
        emitter[x > y ? x : y].parent = x > y ? y : x;
    }
    free(corner);
    return err;
}

/* -- what emits -------------------------------------------------------------------------------- */

static double brightness_of(const struct scene_material *m)
{
    return luminance_f64(
        (const double[3]){(double)m->emission.x, (double)m->emission.y, (double)m->emission.z});
}

/* Those of the scene's triangles whose material shines. */
static struct error *find_emitters(const struct scene *scene, struct emitter **emitter,
                                   size_t *count)
{
    size_t room = 0;
    struct error *err = NULL;
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count && !err; t++) {
            if (!scene_emits(&scene->materials[mesh->material[t]]))
                continue;
            err = array_reserve(emitter, &room, *count + 1, sizeof **emitter);
            if (!err)
                (*emitter)[(*count)++] =
                    (struct emitter){.instance = (uint32_t)i, .triangle = (uint32_t)t};
        }
    }
    return err;
}

static struct glow glow_of(const struct scene *scene, const struct emitter *e,
                           const struct emission_maps *maps)
{
    const struct scene_instance *instance = &scene->instances[e->instance];
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    struct glow g = {.material = mesh->material[e->triangle],
                     .mirrored = affine_mirrors(instance->transform)};
    const struct scene_material *m = &scene->materials[g.material];
    const size_t first = 6 * (size_t)e->triangle;
    const float *uv = mesh->emission_uv ? mesh->emission_uv : mesh->uv;
    g.brightness = brightness_of(m);
    g.maps = emission_varies(m) ? maps : NULL;
    if (uv)
        memcpy(g.uv, uv + first, sizeof g.uv);
    if (mesh->uv)
        memcpy(g.alpha_uv, mesh->uv + first, sizeof g.alpha_uv);
    corners_of(scene, e, g.corner);
    return g;
}

static struct error *find_shards(struct lamps *l)
{
    struct emission_maps maps = {0};
    struct emitter *emitter = NULL;
    size_t count = 0;
    struct error *err = find_emitters(l->scene, &emitter, &count);
    if (!err && count)
        err = emission_init(&maps, l->scene);
    if (!err)
        err = connect(l->scene, emitter, count);
    for (uint32_t i = 0; i < count && !err; i++) {
        const size_t before = l->count;
        struct glow g = glow_of(l->scene, &emitter[i], &maps);
        g.component = find_set(emitter, i);
        err = add_glow(l, &g);
        l->surfaces += g.component == i && l->count > before;
    }
    emission_clear(&maps);
    free(emitter);
    return err;
}

/* -- pieces ------------------------------------------------------------------------------------ */

static int compare_facets(const struct shard *x, const struct shard *y)
{
    return x->component != y->component ? x->component < y->component ? -1 : 1
                                        : x->facet - y->facet;
}

static int compare_cells(const struct shard *x, const struct shard *y)
{
    int order = compare_facets(x, y);
    for (int k = 2; k >= 0 && !order; k--)
        order = (x->cell[k] > y->cell[k]) - (x->cell[k] < y->cell[k]);
    return order;
}

static int compare_shards(const void *a, const void *b)
{
    const struct shard *x = a, *y = b;
    const int order = compare_cells(x, y);
    return order ? order : x->number < y->number ? -1 : 1;
}

/* Divides the box of a facet evenly into cells that are small enough, and its shards among them. */
static void divide_facet(struct shard *shard, size_t count, double side)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * count; i++) {
        double p[3];
        vec3_store(p, shard[i / 3].corner[i % 3]);
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], p[k]);
            high[k] = fmax(high[k], p[k]);
        }
    }
    for (size_t i = 0; i < count; i++) {
        double p[3];
        const struct vec3 *c = shard[i].corner;
        vec3_store(p, vec3_scale(1.0 / 3, vec3_add(vec3_add(c[0], c[1]), c[2])));
        for (int k = 0; k < 3; k++) {
            const double cells = fmax(ceil((high[k] - low[k]) / side * (1 - 1e-9)), 1),
                         at = floor((p[k] - low[k]) / (high[k] - low[k]) * cells);
            shard[i].cell[k] = cells > 1 ? (uint32_t)fmin(fmax(at, 0), cells - 1) : 0;
        }
    }
}

/* One probe before a piece: `side` 1 before its front, -1 behind it. */
static struct error *place_before(struct lamps *l, struct place *place, const struct shard *shard,
                                  size_t count, double side, const struct place_world *world)
{
    struct vec3 middle = {0}, normal = {0};
    double all = 0, top = 0, from[3], to[3];
    for (size_t i = 0; i < count; i++) {
        const struct vec3 *c = shard[i].corner;
        all += shard[i].weight;
        normal = vec3_fma(normal, side, shard[i].normal);
        middle = vec3_fma(middle, shard[i].weight / 3, vec3_add(vec3_add(c[0], c[1]), c[2]));
    }
    middle = vec3_scale(1 / all, middle);
    normal = vec3_normalize(normal);
    for (size_t i = 0; i < 3 * count; i++) /* the whole piece is behind the probe */
        top = fmax(top, vec3_dot(vec3_sub(shard[i / 3].corner[i % 3], middle), normal));
    vec3_store(from, vec3_fma(middle, top + 1e-3 * l->offset, normal));
    vec3_store(to, vec3_fma(middle, top + l->offset, normal));
    if (!(trace_visibility(l->tracer, from, to) > 0)) {
        l->hidden++;
        return NULL;
    }
    struct error *err = place_check_count((double)place->count + 1, world->most);
    return err ? err : place_append(place, to);
}

static struct error *place_surfaces(struct lamps *l, struct place *place,
                                    const struct place_world *world)
{
    struct error *err = find_shards(l);
    if (err || !l->count)
        return err;
    qsort(l->shard, l->count, sizeof *l->shard, compare_shards);
    for (size_t first = 0, end = 0; first < l->count; first = end) {
        while (end < l->count && !compare_facets(&l->shard[first], &l->shard[end]))
            end++;
        divide_facet(l->shard + first, end - first, PIECE_SIDE * l->offset);
    }
    qsort(l->shard, l->count, sizeof *l->shard, compare_shards);
    for (size_t first = 0, end = 0; first < l->count && !err; first = end) {
        while (end < l->count && !compare_cells(&l->shard[first], &l->shard[end]))
            end++;
        l->pieces++;
        err = place_before(l, place, l->shard + first, end - first, 1, world);
        if (!err && !l->scene->emit_front_only)
            err = place_before(l, place, l->shard + first, end - first, -1, world);
    }
    return err;
}

/* -- point and spot lights --------------------------------------------------------------------- */

static struct error *place_around(struct lamps *l, struct place *place,
                                  const struct scene_light *light, const struct place_world *world)
{
    double from[3], to[3];
    vec3_store(from, light->position);
    struct error *err = place_check_near(world->scene, from);
    for (int k = 0; k < 6 && !err; k++) {
        vec3_store(to, light->position);
        to[k / 2] += k % 2 ? -l->offset : l->offset;
        if (!(trace_visibility(l->tracer, from, to) > 0)) {
            l->hidden++;
            continue;
        }
        err = place_check_count((double)place->count + 1, world->most);
        if (!err)
            err = place_append(place, to);
    }
    return err;
}

static bool shines(const struct scene_light *light)
{
    return light->kind != SCENE_SUN && luminance_f64(light->intensity) > 0;
}

/* -- the method -------------------------------------------------------------------------------- */

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    const struct scene *scene = world->scene;
    const double diagonal = vec3_length(vec3_sub(scene->box_max, scene->box_min));
    struct tracer *tracer = NULL;
    struct lamps l = {.scene = scene,
                      .offset = o->offset_given ? o->offset : OFFSET_SHARE * diagonal};
    size_t lights = 0;
    struct error *err = trace_create(&tracer, scene);
    l.tracer = tracer;
    for (size_t i = 0; i < scene->light_count && !err; i++)
        if (shines(&scene->lights[i])) {
            lights++;
            err = place_around(&l, place, &scene->lights[i], world);
        }
    if (!err)
        err = place_surfaces(&l, place, world);
    if (!err && !lights && !l.surfaces)
        err = error_new("the scene has no point or spot light and no surface that emits (no probe "
                        "is near a sun or the sky)");
    if (!err && !place->count)
        err = error_new("all places %g from the lights are behind other surfaces: a smaller "
                        "--offset leaves some in sight",
                        l.offset);
    if (!err)
        err = array_create(&place->origin, place->count, sizeof *place->origin);
    for (size_t i = 0; i < place->count && !err; i++)
        place->origin[i] = place_method_lights.origin;
    if (!err && world->program)
        fprintf(stderr,
                "%s: point and spot lights: %zu, emissive surfaces: %zu, pieces of them: %zu, "
                "places behind other surfaces: %zu, probes: %zu\n",
                world->program, lights, l.surfaces, l.pieces, l.hidden, place->count);
    free(l.shard);
    trace_destroy(tracer);
    return err ? err : place_reach_keep(place, o, world);
}

static const char *const shared[] = {"offset", NULL};

const struct place_method place_method_lights = {.name = "lights",
                                                 .origin = 10,
                                                 .needs_scene = true,
                                                 .sees_light = true,
                                                 .asks_air = true,
                                                 .reaches = true,
                                                 .shares = shared,
                                                 .place = place_by_options};
