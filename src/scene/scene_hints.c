/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_hints.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "math/affine.h"
#include "math/box.h"
#include "scene/scene.h"
#include "scene/scene_choice.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* -- names ------------------------------------------------------------------------------------ */

/* How a hull's name begins, what it holds, and how it ends; in any case of letters. */
static const char *const hull_starts[] = {"UCX_", "UBX_", "USP_", "UCP_"};
static const char *const hull_words[] = {"collision", "collider",  "hitbox",
                                         "navmesh",   "invisible", "occluder"};
static const char *const hull_ends[] = {"-col",         "_col",     "-colonly", "-convcol",
                                        "-convcolonly", "-occonly", "-occ"};

/* Where such a word ends in a name: before ".001", which Blender puts behind copies. */
static size_t bare_length(const char *name)
{
    size_t length = strlen(name), digits = 0;
    while (digits < length && isdigit((unsigned char)name[length - 1 - digits]))
        digits++;
    return digits && digits < length && name[length - 1 - digits] == '.' ? length - 1 - digits
                                                                         : length;
}

/* The pattern of names that are such as this one, which is that of a hull; else false. */
static bool hull_pattern(const char *name, char *pattern, size_t size)
{
    const size_t bare = bare_length(name);
    for (size_t i = 0; i < sizeof hull_starts / sizeof *hull_starts; i++)
        if (!strncasecmp(name, hull_starts[i], 4)) {
            snprintf(pattern, size, "%.4s*", name);
            return true;
        }
    for (size_t i = 0; i < sizeof hull_words / sizeof *hull_words; i++) {
        const char *at = strcasestr(name, hull_words[i]);
        if (at) {
            snprintf(pattern, size, "*%.*s*", (int)strlen(hull_words[i]), at);
            return true;
        }
    }
    for (size_t i = 0; i < sizeof hull_ends / sizeof *hull_ends; i++) {
        const size_t length = strlen(hull_ends[i]);
        if (bare > length && !strncasecmp(name + bare - length, hull_ends[i], length)) {
            snprintf(pattern, size, "*%.*s%s", (int)length, name + bare - length,
                     name[bare] ? "*" : "");
            return true;
        }
    }
    return false;
}

/* Where the digit of a name's LOD1, LOD2, ... stands; NULL: it has none. */
static const char *lod_digit(const char *name)
{
    for (const char *at = strcasestr(name, "lod"); at; at = strcasestr(at + 3, "lod")) {
        const char *digit = at + 3 + strspn(at + 3, "_- ");
        if ((at == name || !isalpha((unsigned char)at[-1])) && *digit >= '1' && *digit <= '9' &&
            !isdigit((unsigned char)digit[1]))
            return digit;
    }
    return NULL;
}

/* Whether the finest form of what this is a coarser one of is there as well. */
static bool has_finer(const struct scene *scene, const size_t *triangles, uint32_t part,
                      const char *digit)
{
    const struct scene_part *p = &scene->parts[part - 1];
    const size_t at = (size_t)(digit - p->name);
    for (size_t i = 0; i < scene->part_count; i++) {
        const char *name = scene->parts[i].name;
        if (scene->parts[i].kind == p->kind && triangles[i + 1] && strlen(name) > at &&
            name[at] == '0' && !strncmp(name, p->name, at))
            return true;
    }
    return false;
}

static bool is_of(const struct scene_part *part, bool of_meshes)
{
    return part->kind != SCENE_LIGHT && (part->kind == SCENE_MESH) == of_meshes;
}

/* Warns of hulls among nodes, objects and groups, or else among meshes. */
static bool hint_hulls(const struct scene *scene, const size_t *triangles, bool of_meshes,
                       bool *told, struct warnings *warnings)
{
    bool some = false;
    char pattern[80];
    for (uint32_t k = 1; k <= scene->part_count; k++) {
        const struct scene_part *p = &scene->parts[k - 1];
        told[k] = p->above && told[p->above];
        if (told[k] || !triangles[k] || !is_of(p, of_meshes))
            continue;
        const char *digit = lod_digit(p->name);
        if (hull_pattern(p->name, pattern, sizeof pattern))
            warnings_add(warnings, "hull",
                         "%s: %s '%.60s', %zu triangles, is named as collision hulls and the like "
                         "are, and stops light as any surface: --exclude '%s' leaves it out",
                         scene->path, scene_part_kinds[p->kind], p->name, triangles[k], pattern);
        else if (digit && has_finer(scene, triangles, k, digit))
            warnings_add(warnings, "coarser form",
                         "%s: %s '%.60s', %zu triangles, is named as a coarser form of what is "
                         "there already, and both stop light: --exclude '*%.*s[1-9]*' leaves it "
                         "out",
                         scene->path, scene_part_kinds[p->kind], p->name, triangles[k],
                         (int)(digit - strcasestr(p->name, "lod")), strcasestr(p->name, "lod"));
        else
            continue;
        told[k] = some = true;
    }
    return some;
}

static void hint_hull_materials(const struct scene *scene, const size_t *triangles,
                                struct warnings *warnings)
{
    char pattern[80];
    for (size_t m = 0; m < scene->material_count; m++) {
        const char *name = scene->materials[m].name;
        /* "_col" is a material's colour */
        if (triangles[m] && hull_pattern(name, pattern, sizeof pattern) &&
            !strcasestr(pattern, "_col") && !strcasestr(pattern, "-col"))
            warnings_add(warnings, "hull",
                         "%s: material '%.60s', %zu triangles, is named as collision hulls and the "
                         "like are, and stops light as any surface: --exclude '%s' leaves it out",
                         scene->path, name, triangles[m], pattern);
    }
}

/* -- domes ------------------------------------------------------------------------------------ */

/* What may be a dome: all triangles that a node places, of an object or group, or of a material. */
struct piece {
    struct box box;
    size_t triangles;
    bool lit, dark, clear; /* some of them are not unlit, do not emit, let light through */
};

struct pieces {
    struct piece *instance, *part, *material; /* by number; owned */
    struct piece all;
};

static void add_triangle(struct piece *piece, const double corner[9],
                         const struct scene_material *m)
{
    for (int k = 0; k < 3; k++)
        box_add(&piece->box, corner + 3 * k);
    piece->triangles++;
    piece->lit = piece->lit || !m->unlit;
    piece->dark = piece->dark || !scene_emits(m);
    piece->clear = piece->clear || m->alpha != SCENE_OPAQUE;
}

static void corners_of(const struct scene_mesh *mesh, const double transform[12], size_t t,
                       double corner[9])
{
    for (size_t k = 0; k < 3; k++)
        vec3_store(corner + 3 * k,
                   affine_point(transform, &mesh->position[3 * (size_t)mesh->index[3 * t + k]]));
}

/* Calls `visit` for each triangle as placed. */
static void each_triangle(const struct scene *scene,
                          void (*visit)(void *to, size_t instance, uint32_t part, int32_t material,
                                        const double corner[9]),
                          void *to)
{
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
        size_t run = 0;
        double corner[9];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            while (run < mesh->run_count && mesh->runs[run].first <= t)
                run++;
            corners_of(mesh, instance->transform, t, corner);
            visit(to, i, run ? mesh->runs[run - 1].part : 0, mesh->material[t], corner);
        }
    }
}

struct gather {
    const struct scene *scene;
    struct pieces *pieces;
};

static void gather(void *to, size_t instance, uint32_t part, int32_t material,
                   const double corner[9])
{
    const struct gather *g = to;
    const struct scene_material *m = &g->scene->materials[material];
    add_triangle(&g->pieces->instance[instance], corner, m);
    add_triangle(&g->pieces->part[part], corner, m);
    add_triangle(&g->pieces->material[material], corner, m);
}

/* One of the pieces, by the array that is given. */
struct choice {
    const size_t *instance;
    const uint32_t *part;
    const int32_t *material;
};

static bool is_chosen(const struct choice *c, size_t instance, uint32_t part, int32_t material)
{
    return c->instance ? *c->instance == instance
           : c->part   ? *c->part == part
                       : *c->material == material;
}

/* How a piece looks beside the rest. */
struct shape {
    struct choice choice;
    struct box box;           /* of the piece */
    size_t corners, round[7]; /* on the ball within its box, or on half a ball that fills it */
    struct box rest;
};

/* The share of a corner's distance from the centre that a ball's may differ by. */
static const double round_most = 0.03;

static void look(void *to, size_t instance, uint32_t part, int32_t material, const double corner[9])
{
    struct shape *s = to;
    if (!is_chosen(&s->choice, instance, part, material)) {
        for (int k = 0; k < 3; k++)
            box_add(&s->rest, corner + 3 * k);
        return;
    }
    for (int k = 0; k < 3; k++) {
        double centred[3], half[3];
        for (int a = 0; a < 3; a++) {
            half[a] = (s->box.high[a] - s->box.low[a]) / 2;
            centred[a] = (corner[3 * k + a] - s->box.low[a]) / half[a] - 1;
        }
        s->corners++;
        for (int way = 0; way < 7; way++) { /* the whole; then from each side of the box */
            double square = 0;
            for (int a = 0; a < 3; a++) {
                const double side = way == 0 || (way - 1) / 2 != a ? centred[a]
                                    : way % 2                      ? (centred[a] + 1) / 2
                                                                   : (centred[a] - 1) / 2;
                square += side * side;
            }
            s->round[way] += fabs(sqrt(square) - 1) < round_most;
        }
    }
}

/* Whether the box is about as large as all: it reaches as far on all sides but one, of which it may
 * lack a quarter (ground below half a ball). */
static bool surrounds(const struct box *box, const struct box *all)
{
    int lacking = 0;
    for (int a = 0; a < 3; a++) {
        const double size = box->high[a] - box->low[a],
                     below = (box->low[a] - all->low[a]) / (size > 0 ? size : 1),
                     above = (all->high[a] - box->high[a]) / (size > 0 ? size : 1);
        if (!(size > 0) || below > 0.25 || above > 0.25)
            return false;
        lacking += (below > 0.01) + (above > 0.01);
    }
    const struct vec3 size = vec3_sub(vec3_load(box->high), vec3_load(box->low));
    const double most = fmax(size.x, fmax(size.y, size.z)),
                 least = fmin(size.x, fmin(size.y, size.z));
    return lacking <= 1 && least > 0.1 * most;
}

static bool has_outer_light(const struct scene *scene)
{
    bool light = scene->sky.radiance[0] > 0 || scene->sky.radiance[1] > 0 ||
                 scene->sky.radiance[2] > 0;
    for (size_t i = 0; i < scene->light_count; i++)
        light = light || scene->lights[i].kind == SCENE_SUN;
    return light;
}

/* A level fills its box; a dome has room around what it surrounds. */
static bool is_roomy(const struct shape *s)
{
    int roomy = 0;
    for (int a = 0; a < 3; a++)
        roomy += s->rest.high[a] - s->rest.low[a] < 0.6 * (s->box.high[a] - s->box.low[a]);
    return roomy >= 2; /* grounds are flat */
}

/* What makes a piece that surrounds all else a dome; NULL: it is none. */
static const char *why_dome(const struct scene *scene, const struct piece *piece, const char *name,
                            struct choice choice)
{
    const bool outer = has_outer_light(scene);
    if (!piece->lit)
        return "is unlit and";
    if (!piece->dark && outer)
        return "emits and";
    if (strcasestr(name, "sky"))
        return "";
    struct shape s = {.choice = choice, .box = piece->box, .rest = box_empty()};
    each_triangle(scene, look, &s);
    size_t most = 0;
    for (int way = 0; way < 7; way++)
        most = s.round[way] > most ? s.round[way] : most;
    if (s.corners >= 60 && (double)most > 0.9 * (double)s.corners && (outer || is_roomy(&s)))
        return "is round and";
    return NULL;
}

static bool hint_dome(const struct scene *scene, const struct pieces *pieces,
                      const struct piece *piece, const char *kind, const char *name,
                      struct choice choice, struct warnings *warnings)
{
    if (!piece->triangles || piece->triangles == pieces->all.triangles || piece->clear ||
        !surrounds(&piece->box, &pieces->all.box))
        return false;
    const char *why = why_dome(scene, piece, name, choice);
    if (!why)
        return false;
    warnings_add(warnings, "dome",
                 "%s: %s '%.60s' %s%ssurrounds all else: it shuts sky and sun out, as any surface "
                 "does, and probes fill it; if it is a sky dome, --exclude '%.60s' leaves it out",
                 scene->path, kind, name, why, *why ? " " : "", name);
    return true;
}

/* By node, or else by object and group, or else by material. */
static bool hint_domes(const struct scene *scene, const struct pieces *pieces,
                       struct warnings *warnings)
{
    char name[256];
    bool some = false;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const uint32_t part = scene->instances[i].part;
        if (part &&
            hint_dome(scene, pieces, &pieces->instance[i], "node", scene->parts[part - 1].name,
                      (struct choice){.instance = &i}, warnings))
            some = true;
    }
    for (uint32_t k = 1; k <= scene->part_count && !some; k++) {
        const struct scene_part *p = &scene->parts[k - 1];
        if (hint_dome(scene, pieces, &pieces->part[k], scene_part_kinds[p->kind], p->name,
                      (struct choice){.part = &k}, warnings))
            some = true;
    }
    for (int32_t m = 0; m < (int32_t)scene->material_count && !some; m++) {
        scene_material_name(scene, m, name, sizeof name);
        some = hint_dome(scene, pieces, &pieces->material[m], "material", name,
                         (struct choice){.material = &m}, warnings);
    }
    return some;
}

static void warn_unlit(const struct scene *scene, const size_t *triangles, bool dome,
                       struct warnings *warnings)
{
    for (size_t m = 0; m < scene->material_count && !dome; m++)
        if (scene->materials[m].unlit && triangles[m])
            warnings_add(warnings, "unlit",
                         "%s: material '%.60s' is unlit: its colour is used as its albedo",
                         scene->path, scene->materials[m].name);
}

static struct error *make_pieces(const struct scene *scene, struct pieces *pieces)
{
    struct error *err =
        array_create(&pieces->instance, scene->instance_count, sizeof *pieces->instance);
    if (!err)
        err = array_create(&pieces->part, scene->part_count + 1, sizeof *pieces->part);
    if (!err)
        err = array_create(&pieces->material, scene->material_count, sizeof *pieces->material);
    if (err)
        return err;
    for (size_t i = 0; i < scene->instance_count; i++)
        pieces->instance[i].box = box_empty();
    for (size_t i = 0; i <= scene->part_count; i++)
        pieces->part[i].box = box_empty();
    for (size_t i = 0; i < scene->material_count; i++)
        pieces->material[i].box = box_empty();
    each_triangle(scene, gather, &(struct gather){scene, pieces});
    pieces->all = (struct piece){.triangles = scene_triangle_count(scene)};
    vec3_store(pieces->all.box.low, scene->box_min);
    vec3_store(pieces->all.box.high, scene->box_max);
    return NULL;
}

struct error *scene_hint(const struct scene *scene, struct warnings *warnings)
{
    struct pieces pieces = {0};
    size_t *of_part = NULL, *of_material = NULL;
    bool *told = NULL;
    struct error *err = make_pieces(scene, &pieces);
    if (!err)
        err = scene_count_names(scene, &of_part, &of_material);
    if (!err)
        err = array_create(&told, scene->part_count + 1, sizeof *told);
    if (!err) {
        warn_unlit(scene, of_material, hint_domes(scene, &pieces, warnings), warnings);
        if (!hint_hulls(scene, of_part, false, told, warnings) &&
            !hint_hulls(scene, of_part, true, told, warnings))
            hint_hull_materials(scene, of_material, warnings);
    }
    free(pieces.instance);
    free(pieces.part);
    free(pieces.material);
    free(of_part);
    free(of_material);
    free(told);
    return err;
}
