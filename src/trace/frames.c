/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/frames.h"
#include "base/warning.h"
#include "math/affine.h"

#include <float.h>
#include <string.h>

/* How often a piece's longest side goes into the scene's before it needs a frame of its own: 6 bits
 * of 24 are lost then. */
#define SMALL 64

/* How often the longest side of all small things goes into the scene's before the rest is but a
 * ground or a sky about them; small is a triangle that is as small beside it. */
#define TINY 1024

/* The share of a scene's triangles below which nobody is expected to stand beside them. */
#define FEW 0.01

enum { BINS = 64, EMPTY = BINS / 8, PIECES_MOST = 16 };

struct piece {
    struct box box; /* of its triangles */
    size_t triangles;
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

static bool holds(const struct box *outer, const struct box *inner)
{
    for (int k = 0; k < 3; k++)
        if (!(outer->low[k] <= inner->low[k] && inner->high[k] <= outer->high[k]))
            return false;
    return true;
}

/* Calls for each triangle within a box. */
static void each_triangle(const struct scene *scene, const struct box *within,
                          void (*take)(void *context, const struct box *triangle), void *context)
{
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        for (size_t j = 0; j < scene->meshes[instance->mesh].triangle_count; j++) {
            const struct box box = triangle_box(scene, instance, j);
            if (holds(within, &box))
                take(context, &box);
        }
    }
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

static void mark(void *context, const struct box *triangle)
{
    struct slices *s = context;
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

struct halves {
    struct piece *half[2];
    int axis;
    double middle;
};

static void add_to_half(void *context, const struct box *triangle)
{
    struct halves *h = context;
    struct piece *half = h->half[triangle->low[h->axis] > h->middle];
    box_add(&half->box, triangle->low);
    box_add(&half->box, triangle->high);
    half->triangles++;
}

/* Parts pieces until none has a gap. */
static int find_pieces(const struct scene *scene, struct piece *piece)
{
    int count = 1;
    for (int i = 0; i < count;) {
        const struct box box = piece[i].box;
        struct slices slices = {.box = &box, .side = box_side(&box)};
        struct halves halves = {.half = {&piece[i], &piece[count]}};
        if (count < PIECES_MOST && slices.side > 0)
            each_triangle(scene, &box, mark, &slices);
        if (count == PIECES_MOST || !find_gap(&slices, &halves.axis, &halves.middle)) {
            i++;
            continue;
        }
        piece[i] = piece[count] = (struct piece){.box = box_empty()};
        each_triangle(scene, &box, add_to_half, &halves);
        count++;
    }
    return count;
}

struct things {
    struct box box;
    double most; /* longest side of what is small */
};

static void add_thing(void *context, const struct box *triangle)
{
    struct things *t = context;
    if (!(box_side(triangle) < t->most))
        return;
    box_add(&t->box, triangle->low);
    box_add(&t->box, triangle->high);
}

/* The box of what is small, where that is all in one place; else of all. */
static struct box small_things(const struct scene *scene, const struct box *all)
{
    struct things things = {.box = box_empty(), .most = box_side(all) / TINY};
    each_triangle(scene, all, add_thing, &things);
    const double side = things.box.low[0] <= things.box.high[0] ? box_side(&things.box) : 0;
    return side > 0 && side < things.most ? things.box : *all;
}

/* The frames; piece, count: the scene's pieces, of which those that have a frame have no triangles
 * left. */
static struct frames find(const struct scene *scene, struct piece piece[PIECES_MOST], int *count)
{
    const struct box all = {{scene->box_min.x, scene->box_min.y, scene->box_min.z},
                            {scene->box_max.x, scene->box_max.y, scene->box_max.z}};
    struct frames frames = {.box = {all}, .count = 1};
    piece[0] = (struct piece){.box = all, .triangles = 0};
    *count = find_pieces(scene, piece);
    size_t triangles = 0;
    bool small = false;
    for (int i = 0; i<*count && * count> 1; i++)
        triangles += piece[i].triangles;
    for (int i = 0; i<*count && * count> 1; i++)
        small = small || ((double)piece[i].triangles >= FEW * (double)triangles &&
                          box_side(&piece[i].box) * SMALL < box_side(&all));
    if (!small) {
        *count = 0;
        frames.box[0] = small_things(scene, &all);
        return frames;
    }
    for (frames.count = 0; frames.count < FRAMES_MOST; frames.count++) {
        int most = 0;
        for (int i = 1; i < *count; i++)
            if (piece[i].triangles > piece[most].triangles)
                most = i;
        if (!((double)piece[most].triangles >= FEW * (double)triangles) || !piece[most].triangles)
            break;
        frames.box[frames.count] = piece[most].box;
        piece[most].triangles = 0;
    }
    return frames;
}

struct frames frames_find(const struct scene *scene)
{
    struct piece piece[PIECES_MOST];
    int count;
    return find(scene, piece, &count);
}

/* -- far pieces ------------------------------------------------------------------------------- */

/* The part of a piece that rays there may be off, beyond which they are coarse. */
#define COARSE 1e-3

static struct vec3 middle_of(const struct box *b)
{
    return vec3_scale(.5, vec3_add(vec3_load(b->low), vec3_load(b->high)));
}

/* A material of the triangles within a box. */
static const char *material_in(const struct scene *scene, const struct box *within)
{
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t j = 0; j < mesh->triangle_count; j++) {
            const struct box box = triangle_box(scene, &scene->instances[i], j);
            if (holds(within, &box))
                return scene->materials[mesh->material[j]].name;
        }
    }
    return NULL;
}

void frames_warn(const struct scene *scene, struct warnings *warnings)
{
    struct piece piece[PIECES_MOST];
    int count;
    const struct frames frames = find(scene, piece, &count);
    for (int i = 0; i < count; i++) {
        const struct vec3 at = middle_of(&piece[i].box);
        double least = (double)INFINITY;
        for (int k = 0; k < frames.count; k++)
            least = fmin(least, vec3_length(vec3_sub(at, middle_of(&frames.box[k]))));
        const double off = 4 * FLT_EPSILON * least, side = box_side(&piece[i].box);
        if (!piece[i].triangles || !(off > COARSE * side))
            continue;
        const char *name = material_in(scene, &piece[i].box);
        warnings_add(warnings, "far",
                     "%zu triangle%s of material '%s' at %g %g %g, %g across, %s %.3g units away "
                     "from the rest: there rays start up to %.2g off, and a grid without --bounds "
                     "fills the way there; if nobody goes there, take %s out of the scene",
                     piece[i].triangles, piece[i].triangles > 1 ? "s" : "", name ? name : "", at.x,
                     at.y, at.z, side, piece[i].triangles > 1 ? "are" : "is", least, off,
                     piece[i].triangles > 1 ? "them" : "it");
    }
}
