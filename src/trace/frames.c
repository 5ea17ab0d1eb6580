/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/frames.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "math/affine.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* How often a piece's longest side goes into that of what it is parted from before it needs a frame
 * of its own: 8 bits of 24 are lost then. */
#define SMALL 256

/* How often the longest side of all small things goes into the scene's before the rest is but a
 * ground or a sky about them; small is a triangle that is as small beside it. */
#define TINY 1024

enum {
    BINS = 1024,
    EMPTY = BINS / 256,
    PIECES_MOST = 2 * FRAMES_MOST,
    TRIANGLES_MOST = 1 << 22, /* in all frames together; but: */
    FRAMES_LEAST = 8,
};

static struct box triangle_box(const struct scene *scene, const struct scene_instance *instance,
                               size_t triangle)
{
    const struct scene_mesh *mesh = &scene->meshes[instance->mesh];
    struct box box = box_empty();
    for (int k = 0; k < 3; k++) {
        double p[3];
        vec3_store(
            p, affine_point(instance->transform,
                            mesh->position + 3 * (size_t)mesh->index[3 * triangle + (size_t)k]));
        box_add(&box, p);
    }
    return box;
}

static void add_box(struct box *box, const struct box *other)
{
    box_add(box, other->low);
    box_add(box, other->high);
}

/* A triangle of the scene, by instance. */
struct name {
    uint32_t instance, triangle;
};

static struct box box_of_name(const struct scene *scene, struct name name)
{
    return triangle_box(scene, &scene->instances[name.instance], name.triangle);
}

static struct error *list_triangles(const struct scene *scene, struct name **list, size_t *count)
{
    *count = 0;
    for (size_t i = 0; i < scene->instance_count; i++)
        *count += scene->meshes[scene->instances[i].mesh].triangle_count;
    struct error *err = array_create(list, *count, sizeof **list);
    size_t n = 0;
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        for (size_t j = 0; j < scene->meshes[scene->instances[i].mesh].triangle_count; j++)
            (*list)[n++] = (struct name){(uint32_t)i, (uint32_t)j};
    return err;
}

/* Which slices of a box, along each axis, have triangles. */
struct slices {
    const struct box *box;
    double side;
    bool used[3][BINS];
};

static int slice_of(const struct slices *s, int axis, double x)
{
    return (int)fmin(fmax((x - s->box->low[axis]) / s->side * BINS, 0), BINS - 1);
}

static void mark(struct slices *s, const struct box *triangle)
{
    for (int k = 0; k < 3; k++)
        for (int i = slice_of(s, k, triangle->low[k]), last = slice_of(s, k, triangle->high[k]);
             i <= last; i++)
            s->used[k][i] = true;
}

/* Finds the longest empty run of slices between triangles, and its middle: false: none is long
 * enough. */
static bool find_gap(const struct slices *s, int *axis, double *middle)
{
    int longest = EMPTY - 1;
    for (int k = 0; k < 3; k++) {
        int last = 0; /* the first one is used: the box is tight */
        for (int i = 1; i < BINS; i++) {
            if (!s->used[k][i])
                continue;
            if (i - last - 1 > longest) {
                longest = i - last - 1;
                *axis = k;
                *middle = s->box->low[k] + s->side * (i + last + 1) / 2 / BINS;
            }
            last = i;
        }
    }
    return longest >= EMPTY;
}

/* -- pieces ----------------------------------------------------------------------------------- */

/* A part of the scene, in a binary tree: its triangles lie together in a list. */
struct piece {
    struct box box;
    size_t first, count; /* of its triangles */
    int half;            /* the first of the two that it is parted into; 0: none */
    bool torn;           /* it could be parted, but there were too many pieces */
};

struct pieces {
    struct name *triangle; /* owned; NULL where the scene is in one piece */
    struct piece at[2 * PIECES_MOST];
    int count;
};

/* Puts those of a piece's triangles that lie below the middle of a gap first, and parts it. */
static void part(const struct scene *scene, struct pieces *p, int whole, int axis, double middle)
{
    struct piece *piece = &p->at[whole], *half = &p->at[p->count];
    piece->half = p->count;
    p->count += 2;
    half[0] = half[1] = (struct piece){.box = box_empty()};
    size_t low = piece->first, high = piece->first + piece->count;
    while (low < high) {
        const struct name name = p->triangle[low];
        const struct box box = box_of_name(scene, name);
        const bool above = box.low[axis] > middle;
        add_box(&half[above].box, &box);
        if (above) {
            p->triangle[low] = p->triangle[--high];
            p->triangle[high] = name;
        } else {
            low++;
        }
    }
    half[0].first = piece->first;
    half[0].count = low - piece->first;
    half[1].first = low;
    half[1].count = piece->count - half[0].count;
}

static bool needs_parting(const struct scene *scene, const struct pieces *p,
                          const struct piece *piece, int *axis, double *middle)
{
    struct slices slices = {.box = &piece->box, .side = box_side(&piece->box)};
    if (!(slices.side > 0))
        return false;
    if (p->triangle) {
        for (size_t i = piece->first; i < piece->first + piece->count; i++) {
            const struct box box = box_of_name(scene, p->triangle[i]);
            mark(&slices, &box);
        }
    } else {
        for (size_t i = 0; i < scene->instance_count; i++)
            for (size_t j = 0; j < scene->meshes[scene->instances[i].mesh].triangle_count; j++) {
                const struct box box = triangle_box(scene, &scene->instances[i], j);
                mark(&slices, &box);
            }
    }
    return find_gap(&slices, axis, middle);
}

/* Parts pieces until none has a gap. */
static struct error *find_pieces(const struct scene *scene, const struct box *all, struct pieces *p)
{
    *p = (struct pieces){.count = 1, .at = {{.box = *all}}};
    struct error *err = NULL;
    for (int i = 0; i < p->count && !err; i++) {
        int axis;
        double middle;
        if (!needs_parting(scene, p, &p->at[i], &axis, &middle))
            continue;
        if (!p->triangle)
            err = list_triangles(scene, &p->triangle, &p->at[0].count);
        p->at[i].torn = p->count + 2 > 2 * PIECES_MOST;
        if (!err && !p->at[i].torn)
            part(scene, p, i, axis, middle);
    }
    return err;
}

static void clear_pieces(struct pieces *p)
{
    free(p->triangle);
}

/* The least side of the parts of a piece. */
static double least_side(const struct pieces *p, int i)
{
    const int half = p->at[i].half;
    return half ? fmin(least_side(p, half), least_side(p, half + 1)) : box_side(&p->at[i].box);
}

/* Lists the pieces that need a frame: those which have none in them that is small beside them. */
static void gather(const struct pieces *p, int i, int *list, int *count)
{
    if (p->at[i].half && least_side(p, i) * SMALL < box_side(&p->at[i].box)) {
        gather(p, p->at[i].half, list, count);
        gather(p, p->at[i].half + 1, list, count);
    } else {
        list[(*count)++] = i;
    }
}

/* -- frames ----------------------------------------------------------------------------------- */

/* The box of what is small, where that is all in one place; else of all. */
static struct box small_things(const struct scene *scene, const struct box *all)
{
    const double most = box_side(all) / TINY;
    struct box things = box_empty();
    for (size_t i = 0; i < scene->instance_count; i++)
        for (size_t j = 0; j < scene->meshes[scene->instances[i].mesh].triangle_count; j++) {
            const struct box box = triangle_box(scene, &scene->instances[i], j);
            if (box_side(&box) < most)
                add_box(&things, &box);
        }
    const double side = things.low[0] <= things.high[0] ? box_side(&things) : 0;
    return side > 0 && side < most ? things : *all;
}

/* The frames, and which pieces there are: those with frames first, that of most triangles before
 * all. */
static struct error *find(const struct scene *scene, struct frames *frames, struct pieces *p,
                          int list[PIECES_MOST], int *count)
{
    const struct box all = {{scene->box_min.x, scene->box_min.y, scene->box_min.z},
                            {scene->box_max.x, scene->box_max.y, scene->box_max.z}};
    *count = 0;
    *frames = (struct frames){.box = {all}, .count = 1};
    struct error *err = find_pieces(scene, &all, p);
    if (err)
        return err;
    gather(p, 0, list, count);
    if (*count == 1) {
        frames->box[0] = small_things(scene, &all);
        return NULL;
    }
    for (int i = 1; i < *count; i++) /* few: sorted by insertion */
        for (int k = i; k && p->at[list[k]].count > p->at[list[k - 1]].count; k--) {
            const int swap = list[k];
            list[k] = list[k - 1];
            list[k - 1] = swap;
        }
    const double room = (double)TRIANGLES_MOST / (double)p->at[0].count;
    const int most = (int)fmin(fmax(room, FRAMES_LEAST), FRAMES_MOST);
    frames->count = *count < most ? *count : most;
    for (int i = 0; i < frames->count; i++)
        frames->box[i] = p->at[list[i]].box;
    return NULL;
}

struct error *frames_find(struct frames *frames, const struct scene *scene)
{
    struct pieces p;
    int list[PIECES_MOST], count;
    struct error *err = find(scene, frames, &p, list, &count);
    clear_pieces(&p);
    return err;
}

/* -- far pieces ------------------------------------------------------------------------------- */

/* The part of a piece that rays there may be off, beyond which they are coarse. */
#define COARSE 1e-3

/* The share of the largest piece's triangles below which nobody is expected to stand beside
 * them. */
#define FEW 0.01

static struct vec3 middle_of(const struct box *b)
{
    return vec3_scale(.5, vec3_add(vec3_load(b->low), vec3_load(b->high)));
}

static double distance_to(const struct frames *frames, const struct box *box)
{
    double least = (double)INFINITY;
    for (int k = 0; k < frames->count; k++)
        least = fmin(least, vec3_length(vec3_sub(middle_of(box), middle_of(&frames->box[k]))));
    return least;
}

static const char *material_of(const struct scene *scene, struct name name)
{
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[name.instance].mesh];
    const char *text = scene->materials[mesh->material[name.triangle]].name;
    return text ? text : "";
}

/* Of a piece that stands far off with few triangles, or without a frame. */
static void warn_piece(const struct scene *scene, const struct pieces *p, const struct piece *piece,
                       const struct frames *framed, bool coarse, struct warnings *warnings)
{
    const struct vec3 at = middle_of(&piece->box);
    const double away = distance_to(framed, &piece->box), side = box_side(&piece->box),
                 off = 4 * FLT_EPSILON * away;
    char there[64] = "";
    if (!(off > COARSE * side))
        return;
    if (coarse)
        snprintf(there, sizeof there, "there rays start up to %.2g off, and ", off);
    warnings_add(warnings, "far",
                 "%zu triangle%s of material '%s' at %g %g %g, %g across, %s %.3g units away "
                 "from the rest: %sa grid without --bounds fills the way there; if nobody goes "
                 "there, take %s out of the scene",
                 piece->count, piece->count > 1 ? "s" : "",
                 material_of(scene, p->triangle[piece->first]), at.x, at.y, at.z, side,
                 piece->count > 1 ? "are" : "is", away, there, piece->count > 1 ? "them" : "it");
}

/* A piece in which others are far apart: it has one frame for all of them, or none. */
static void warn_torn(const struct pieces *p, const struct piece *piece, struct warnings *warnings)
{
    const double side = box_side(&piece->box), off = 2 * FLT_EPSILON * side;
    if (!(off > COARSE * least_side(p, 0)))
        return;
    warnings_add(warnings, "torn",
                 "the scene has more than %d parts that are far apart: %zu triangles in a box of "
                 "%.3g units share an origin of rays, which start up to %.2g off there; bake parts "
                 "of the scene (--only)",
                 FRAMES_MOST, piece->count, side, off);
}

struct error *frames_warn(const struct scene *scene, struct warnings *warnings)
{
    struct pieces p;
    struct frames frames;
    int list[PIECES_MOST], count;
    struct error *err = find(scene, &frames, &p, list, &count);
    const struct frames first = {.box = {frames.box[0]}, .count = 1};
    for (int i = 1; i < count && !err; i++) {
        const struct piece *piece = &p.at[list[i]];
        const bool framed = i < frames.count,
                   few = (double)piece->count < FEW * (double)p.at[list[0]].count;
        if (!framed || few)
            warn_piece(scene, &p, piece, framed ? &first : &frames, !framed, warnings);
    }
    for (int i = 0; i < count && !err; i++)
        if (p.at[list[i]].torn)
            warn_torn(&p, &p.at[list[i]], warnings);
    clear_pieces(&p);
    return err;
}
