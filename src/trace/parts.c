/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/parts.h"
#include "base/array.h"
#include "base/error.h"
#include "trace/emission.h"

#include <math.h>
#include <stdlib.h>

/* How many times as bright as its mean a part may be anywhere: even enough. */
#define EVEN 2.0f

/* The share of a triangle's light that is too little to look for. */
#define LITTLE 0x1p-12f

enum {
    CUTS_MOST = 1 << 15, /* of a scene, and: */
    CUTS_EACH = 8,       /* for each of its triangles with pictures */
    DEEPEST = 16,        /* a side is then 2^-16 as long */
};

/* Parts that may be cut, the one that could hold most light first (a binary heap). */
struct candidate {
    float excess; /* area times what it could be brighter than its mean */
    uint32_t part;
};

struct candidates {
    struct candidate *at; /* owned, from 0 */
    size_t count, capacity;
};

static bool comes_before(const struct candidate *a, const struct candidate *b)
{
    if (a->excess > b->excess || a->excess < b->excess)
        return a->excess > b->excess;
    return a->part < b->part;
}

static struct error *push(struct candidates *c, struct candidate one)
{
    struct error *err = array_reserve(&c->at, &c->capacity, c->count + 1, sizeof *c->at);
    if (err)
        return err;
    size_t i = c->count++;
    for (; i && comes_before(&one, &c->at[(i - 1) / 2]); i = (i - 1) / 2)
        c->at[i] = c->at[(i - 1) / 2];
    c->at[i] = one;
    return NULL;
}

static uint32_t pop(struct candidates *c)
{
    const uint32_t first = c->at[0].part;
    const struct candidate last = c->at[--c->count];
    size_t i = 0;
    for (size_t k; (k = 2 * i + 1) < c->count; i = k) {
        if (k + 1 < c->count && comes_before(&c->at[k + 1], &c->at[k]))
            k++;
        if (!comes_before(&c->at[k], &last))
            break;
        c->at[i] = c->at[k];
    }
    c->at[i] = last;
    return first;
}

/* -- cutting ----------------------------------------------------------------------------------- */

struct error *parts_add(struct parts *parts, const struct tracer *t, uint32_t instance,
                        uint32_t triangle, float area)
{
    struct error *err = array_reserve(&parts->root, &parts->root_capacity, parts->root_count + 1,
                                      sizeof *parts->root);
    if (err)
        return err;
    struct parts_root *root = &parts->root[parts->root_count++];
    *root = (struct parts_root){.instance = instance, .triangle = triangle, .area = area};
    for (int k = 0; k < 3; k++) {
        struct trace_point corner;
        trace_point_at(t, instance, triangle, k == 1, k == 2, &corner);
        root->uv[k][0] = root->emission_uv[k][0] = corner.u;
        root->uv[k][1] = root->emission_uv[k][1] = corner.v;
        if (t->geometry[instance].emission_uv)
            trace_uv(t->geometry[instance].emission_uv, &corner, &root->emission_uv[k][0],
                     &root->emission_uv[k][1]);
    }
    return NULL;
}

struct cutting {
    struct parts *parts;
    const struct scene *scene;
    struct emission_maps maps;
    struct candidates candidates;
};

/* Texture coordinates of a part's corners, from those of its root. */
static void part_uv(const struct light_part *p, const float root[3][2], float uv[3][2])
{
    for (int k = 0; k < 3; k++) {
        const float b = p->b + (k == 1 ? p->size : 0), c = p->c + (k == 2 ? p->size : 0);
        for (int i = 0; i < 2; i++)
            uv[k][i] = root[0][i] + b * (root[1][i] - root[0][i]) + c * (root[2][i] - root[0][i]);
    }
}

/* Sets what a part shines, and lines it up where that is uneven. */
static struct error *judge(struct cutting *cutting, uint32_t number)
{
    struct parts *parts = cutting->parts;
    struct light_part *p = &parts->part[number];
    const struct parts_root *root = &parts->root[p->root];
    const struct scene_mesh *mesh =
        &cutting->scene->meshes[cutting->scene->instances[root->instance].mesh];
    float uv[3][2], emission_uv[3][2];
    part_uv(p, (const float(*)[2])root->uv, uv);
    part_uv(p, (const float(*)[2])root->emission_uv, emission_uv);
    const struct emission_range range =
        emission_over(&cutting->maps, mesh->material[root->triangle],
                      (const float(*)[2])emission_uv, (const float(*)[2])uv);
    p->brightness = range.mean;
    const float share = p->size * p->size, most = share * (range.most - range.mean);
    const float whole = parts->part[root->part].brightness;
    if (range.smooth || !(range.most > EVEN * range.mean) || !(most > LITTLE * whole) ||
        fabsf(p->size) <= ldexpf(1, -DEEPEST))
        return NULL;
    return push(&cutting->candidates,
                (struct candidate){.excess = most * root->area, .part = number});
}

static struct error *add_part(struct parts *parts, struct light_part part)
{
    struct error *err =
        array_reserve(&parts->part, &parts->capacity, parts->count + 1, sizeof *parts->part);
    part.light = UINT32_MAX;
    if (!err)
        parts->part[parts->count++] = part;
    return err;
}

static struct error *cut(struct cutting *cutting, uint32_t number)
{
    struct parts *parts = cutting->parts;
    const uint32_t child = (uint32_t)parts->count, root = parts->part[number].root;
    const float b = parts->part[number].b, c = parts->part[number].c,
                half = parts->part[number].size / 2;
    const struct light_part four[4] = {{.b = b, .c = c, .size = half},
                                       {.b = b + half, .c = c, .size = half},
                                       {.b = b, .c = c + half, .size = half},
                                       {.b = b + half, .c = c + half, .size = -half}};
    struct error *err = NULL;
    for (int k = 0; k < 4 && !err; k++) {
        err = add_part(parts, four[k]);
        if (!err) {
            parts->part[child + (uint32_t)k].root = root;
            err = judge(cutting, child + (uint32_t)k);
        }
    }
    parts->part[number].child = child;
    return err;
}

struct error *parts_divide(struct parts *parts, const struct scene *scene)
{
    struct cutting cutting = {.parts = parts, .scene = scene};
    if (!parts->root_count)
        return NULL;
    struct error *err = emission_init(&cutting.maps, scene);
    for (size_t i = 0; i < parts->root_count && !err; i++) {
        parts->root[i].part = (uint32_t)parts->count;
        err = add_part(parts, (struct light_part){.size = 1, .root = (uint32_t)i});
        if (!err)
            err = judge(&cutting, parts->root[i].part);
    }
    const size_t most = CUTS_MOST + CUTS_EACH * parts->root_count;
    for (size_t cuts = 0; cuts < most && cutting.candidates.count && !err; cuts++)
        err = cut(&cutting, pop(&cutting.candidates));
    free(cutting.candidates.at);
    emission_clear(&cutting.maps);
    return err;
}

void parts_clear(struct parts *parts)
{
    free(parts->root);
    free(parts->part);
    *parts = (struct parts){0};
}

uint32_t parts_find(const struct parts *parts, uint32_t whole, float b, float c)
{
    uint32_t at = whole;
    while (parts->part[at].child) {
        int k = 0;
        if (b >= 0.5f)
            k = 1;
        else if (c >= 0.5f)
            k = 2;
        else if (b + c > 0.5f)
            k = 3;
        at = parts->part[at].child + (uint32_t)k;
        b = k == 3 ? 1 - 2 * b : k == 1 ? 2 * b - 1 : 2 * b;
        c = k == 3 ? 1 - 2 * c : k == 2 ? 2 * c - 1 : 2 * c;
    }
    return at;
}
