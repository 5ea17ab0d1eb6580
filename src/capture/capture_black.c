/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_black.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "math/affine.h"
#include "math/angle.h"
#include "scene/scene.h"
#include "scene/scene_choice.h"
#include "scene/scene_shade.h"
#include "stream/table.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SKY_RAYS = 32, LIGHTS_MOST = 64, EMITTERS_MOST = 64 };

static void note_place(struct capture_black *black, const double p[3])
{
    if (!black->stride)
        black->stride = 1;
    if (black->black++ % black->stride)
        return;
    if (black->places == CAPTURE_BLACK_PLACES) { /* every other one stays */
        for (size_t i = 1; 2 * i < black->places; i++)
            memcpy(black->place + 3 * i, black->place + 6 * i, 3 * sizeof(double));
        black->places /= 2;
        black->stride *= 2;
    }
    memcpy(black->place + 3 * black->places++, p, 3 * sizeof(double));
}

void capture_black_note(struct capture_black *black, const struct table *table)
{
    const struct column *light = table_column(table, "sh"),
                        *position = table_column(table, "position");
    if (!light)
        light = table_column(table, "irradiance");
    for (size_t i = 0; light && position && i < table->rows && !black->light; i++) {
        const float *values = column_f32(light) + i * light->width;
        if (isnan(values[0]))
            continue;
        for (size_t k = 0; k < light->width; k++)
            black->light = black->light || !(values[k] == 0);
        if (!black->light)
            note_place(black, column_f64(position) + 3 * i);
    }
}

/* -- what is in the way ----------------------------------------------------------------------- */

/* A surface that rays met: a material, of a node, an object or a group. */
struct obstacle {
    uint32_t part;
    int32_t material;
    size_t count;
};

struct survey {
    const struct tracer *tracer;
    const struct scene *scene;
    struct obstacle *list;
    size_t count, capacity;
    size_t asked, stopped;
};

/* A ray to a light so far away; `instance` and `triangle` of it, where it is a surface. */
static struct error *ask(struct survey *s, const double from[3], const double direction[3],
                         double distance, const struct trace_hit *light)
{
    s->asked++;
    const struct trace_hit hit = trace_nearest(s->tracer, from, direction, distance);
    if (!hit.hit || (light && hit.instance == light->instance && hit.triangle == light->triangle))
        return NULL;
    s->stopped++;
    const struct scene_instance *instance = &s->scene->instances[hit.instance];
    const struct scene_mesh *mesh = &s->scene->meshes[instance->mesh];
    const uint32_t run = scene_part_of(mesh, hit.triangle), part = run ? run : instance->part;
    const int32_t material = mesh->material[hit.triangle];
    size_t i = 0;
    while (i < s->count && (s->list[i].part != part || s->list[i].material != material))
        i++;
    struct error *err = NULL;
    if (i == s->count)
        err = array_reserve(&s->list, &s->capacity, s->count + 1, sizeof *s->list);
    if (!err && i == s->count)
        s->list[s->count++] = (struct obstacle){.part = part, .material = material};
    if (!err)
        s->list[i].count++;
    return err;
}

/* Directions as even as those of a sunflower's seeds. */
static struct error *ask_sky(struct survey *s, const double from[3])
{
    struct error *err = NULL;
    const double *sky = s->scene->sky.radiance;
    if (!(sky[0] > 0 || sky[1] > 0 || sky[2] > 0))
        return NULL;
    for (int i = 0; i < SKY_RAYS && !err; i++) {
        const double y = 1 - (2 * i + 1.0) / SKY_RAYS, r = sqrt(1 - y * y),
                     turn = fmod(i * 0.6180339887498949, 1) * 2 * ANGLE_PI;
        const double d[3] = {r * angle_cos(turn), y, r * angle_sin(turn)};
        err = ask(s, from, d, (double)INFINITY, NULL);
    }
    return err;
}

static struct error *ask_lights(struct survey *s, const double from[3])
{
    struct error *err = NULL;
    const size_t count = s->scene->light_count, step = (count + LIGHTS_MOST - 1) / LIGHTS_MOST;
    for (size_t i = 0; i < count && !err; i += step) {
        double direction[3], distance, rgb[3];
        scene_light_at(&s->scene->lights[i], from, direction, &distance, rgb);
        if (rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0)
            err = ask(s, from, direction, distance, NULL);
    }
    return err;
}

/* Some triangles that emit, and their centres. */
struct emitters {
    struct trace_hit at[EMITTERS_MOST];
    size_t count;
};

static bool is_emitter(const struct scene *scene, const struct scene_mesh *mesh, size_t t)
{
    return scene_emits(&scene->materials[mesh->material[t]]);
}

static void find_emitters(const struct scene *scene, struct emitters *found)
{
    size_t all = 0, number = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++)
            all += is_emitter(scene, mesh, t);
    }
    const size_t step = (all + EMITTERS_MOST - 1) / EMITTERS_MOST;
    for (size_t i = 0; i < scene->instance_count && all; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            if (!is_emitter(scene, mesh, t) || number++ % step)
                continue;
            struct vec3 sum = {0};
            for (size_t k = 0; k < 3; k++)
                sum = vec3_add(sum,
                               affine_point(instance->transform,
                                            &mesh->position[3 * (size_t)mesh->index[3 * t + k]]));
            found->at[found->count++] = (struct trace_hit){
                .position = vec3_scale(1 / 3.0, sum), .instance = i, .triangle = t};
        }
    }
}

static struct error *ask_emitters(struct survey *s, const struct emitters *emitters,
                                  const double from[3])
{
    struct error *err = NULL;
    for (size_t i = 0; i < emitters->count && !err; i++) {
        const struct vec3 way = vec3_sub(emitters->at[i].position, vec3_load(from));
        const double distance = vec3_length(way);
        double direction[3];
        if (!(distance > 0))
            continue;
        vec3_store(direction, vec3_scale(1 / distance, way));
        err = ask(s, from, direction, distance * (1 - 1e-6), &emitters->at[i]);
    }
    return err;
}

static int by_count(const void *a, const void *b)
{
    const struct obstacle *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count) - (x->count > y->count)
           : x->part != y->part ? (x->part > y->part) - (x->part < y->part)
                                : x->material - y->material;
}

static void name_obstacle(const struct survey *s, const struct obstacle *o, char *text, size_t size)
{
    char material[64], part[128];
    scene_material_name(s->scene, o->material, material, sizeof material);
    scene_part_path(s->scene, o->part, part, sizeof part);
    snprintf(text, size, "material '%s'%s%s%s%s%s (%.0f %%)", material, o->part ? " of " : "",
             o->part ? scene_part_kinds[s->scene->parts[o->part - 1].kind] : "",
             o->part ? " '" : "", part, o->part ? "'" : "",
             100.0 * (double)o->count / (double)s->asked);
}

static void warn(const struct survey *s, size_t probes, struct warnings *warnings)
{
    char first[256], second[256];
    const char *pane = capture_find_pane(s->scene);
    if (s->stopped * 2 < s->asked || !s->count) {
        warnings_add(warnings, "all black",
                     "%s: all %zu probes are black though there is light, and little stands in its "
                     "way: it shines elsewhere, or on one side alone, or --light leaves it out",
                     s->scene->path, probes);
        return;
    }
    name_obstacle(s, &s->list[0], first, sizeof first);
    if (s->count > 1)
        name_obstacle(s, &s->list[1], second, sizeof second);
    warnings_add(
        warnings, "all black",
        "%s: all %zu probes are black though there is light; of the ways to it from the "
        "probes %.0f %% are stopped, first by %s%s%s%s%s%s (--exclude leaves such things out)",
        s->scene->path, probes, 100.0 * (double)s->stopped / (double)s->asked, first,
        s->count > 1 ? ", " : "", s->count > 1 ? second : "", pane ? "; material '" : "",
        pane ? pane : "", pane ? "' may be glass, and is opaque" : "");
}

struct error *capture_black_warn(const struct capture_black *black, const struct tracer *tracer,
                                 struct warnings *warnings)
{
    const struct scene *scene = trace_scene(tracer);
    if (black->light || !black->black || capture_is_dark(scene))
        return NULL;
    struct survey s = {.tracer = tracer, .scene = scene};
    struct emitters emitters = {0};
    struct error *err = NULL;
    find_emitters(scene, &emitters);
    for (size_t i = 0; i < black->places && !err; i++) {
        const double *from = black->place + 3 * i;
        err = ask_sky(&s, from);
        if (!err)
            err = ask_lights(&s, from);
        if (!err)
            err = ask_emitters(&s, &emitters, from);
    }
    if (!err && s.count)
        qsort(s.list, s.count, sizeof *s.list, by_count);
    if (!err)
        warn(&s, black->black, warnings);
    free(s.list);
    return err;
}
