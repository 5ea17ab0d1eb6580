/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Williams, "Pyramidal parametrics", SIGGRAPH 1983 (with the most beside the mean). */
#include "trace/emission.h"
#include "base/array.h"
#include "base/error.h"
#include "math/luminance.h"
#include "scene/scene_shade.h"

#include <math.h>
#include <stdlib.h>

enum {
    BLOCKS_MOST = 1 << 20, /* in the lowest level that is kept */
    LEVELS = 33,
    ACROSS = 4, /* blocks of a level that a box spans, at most */
    FIRST_MOST = 9,
    SPANS = (ACROSS << (FIRST_MOST - 1)) + 16,
};

struct block {
    float mean, most;
};

/* Level l has blocks of 2^l by 2^l texels, less at the far ends. Those below `first` are read from
 * the texels. */
struct emission_map {
    const struct scene_texture *texture;
    bool alpha;                      /* the opacity of a surface, not its luminance */
    struct vec3f factor;             /* of luminance */
    const struct scene_material *of; /* alpha: whose */
    int first, last;
    struct block *level[LEVELS]; /* owned */
};

/* A material's maps; -1: none. */
struct emission_use {
    int32_t light, alpha;
};

/* -- pyramids ---------------------------------------------------------------------------------- */

static float texel_value(const struct emission_map *map, uint32_t x, uint32_t y)
{
    float rgba[4];
    scene_texture_texel(map->texture, x, y, rgba);
    if (!map->alpha)
        return float_most(
            luminance_vec3f(vec3f_mul(map->factor, (struct vec3f){rgba[0], rgba[1], rgba[2]})), 0);
    const float opacity = map->of->opacity * rgba[3];
    if (map->of->alpha == SCENE_CUTOUT)
        return opacity < map->of->cutoff ? 0.0f : 1.0f;
    return float_least(float_most(opacity, 0.0f), 1.0f);
}

static uint32_t blocks_on(uint32_t texels, int level)
{
    return (uint32_t)((((uint64_t)texels - 1) >> level) + 1);
}

static struct block get_block(const struct emission_map *map, int level, uint32_t x, uint32_t y)
{
    if (level >= map->first)
        return map->level[level][(size_t)y * blocks_on(map->texture->width, level) + x];
    const float value = texel_value(map, x, y);
    return (struct block){value, value};
}

/* How many texels of a side a block of the level has. */
static uint32_t extent(uint32_t texels, int level, uint32_t at)
{
    const uint64_t begin = (uint64_t)at << level, end = begin + ((uint64_t)1 << level);
    return (uint32_t)((end < texels ? end : texels) - begin);
}

/* A block of all that it holds of a lower level. */
static struct block join(const struct emission_map *map, int level, int lower, uint32_t x,
                         uint32_t y)
{
    const uint32_t width = map->texture->width, height = map->texture->height,
                   step = 1u << (level - lower), columns = blocks_on(width, lower),
                   rows = blocks_on(height, lower);
    double sum = 0, weight = 0;
    struct block all = {0};
    for (uint32_t j = y * step; j < rows && j < (y + 1) * step; j++) {
        for (uint32_t i = x * step; i < columns && i < (x + 1) * step; i++) {
            const struct block one = get_block(map, lower, i, j);
            const double w = (double)extent(width, lower, i) * extent(height, lower, j);
            sum += w * (double)one.mean;
            weight += w;
            all.most = float_most(all.most, one.most);
        }
    }
    all.mean = (float)(sum / weight);
    return all;
}

static struct error *build(struct emission_map *map)
{
    const uint32_t width = map->texture->width, height = map->texture->height;
    map->first = 1;
    while (map->first < FIRST_MOST &&
           (uint64_t)blocks_on(width, map->first) * blocks_on(height, map->first) > BLOCKS_MOST)
        map->first++;
    struct error *err = NULL;
    for (int l = map->first; !err; l++) {
        const uint32_t columns = blocks_on(width, l), rows = blocks_on(height, l);
        struct block *block;
        err = array_create(&block, (size_t)columns * rows, sizeof *block);
        for (uint32_t y = 0; y < rows && !err; y++)
            for (uint32_t x = 0; x < columns; x++)
                block[(size_t)y * columns + x] = join(map, l, l > map->first ? l - 1 : 0, x, y);
        map->level[l] = block;
        map->last = l;
        if (columns == 1 && rows == 1)
            break;
    }
    return err;
}

static bool same_map(const struct emission_map *a, const struct emission_map *b)
{
    if (a->texture != b->texture || a->alpha != b->alpha)
        return false;
    if (a->alpha)
        return a->of->alpha == b->of->alpha && !(a->of->opacity < b->of->opacity) &&
               !(a->of->opacity > b->of->opacity) && !(a->of->cutoff < b->of->cutoff) &&
               !(a->of->cutoff > b->of->cutoff);
    return vec3f_length(vec3f_sub(a->factor, b->factor)) <= 0;
}

/* Finds the map among those that there are, or adds it. */
static struct error *use_map(struct emission_maps *maps, size_t *capacity, struct emission_map map,
                             int32_t *use)
{
    for (size_t i = 0; i < maps->count; i++) {
        if (same_map(&maps->map[i], &map)) {
            *use = (int32_t)i;
            return NULL;
        }
    }
    struct error *err = array_reserve(&maps->map, capacity, maps->count + 1, sizeof *maps->map);
    if (err)
        return err;
    *use = (int32_t)maps->count;
    maps->map[maps->count] = map;
    return build(&maps->map[maps->count++]);
}

bool emission_varies(const struct scene_material *m)
{
    return m->emission_map.texture != SCENE_NONE ||
           (m->alpha != SCENE_OPAQUE && m->alpha_map.texture != SCENE_NONE);
}

struct error *emission_init(struct emission_maps *maps, const struct scene *scene)
{
    size_t capacity = 0;
    *maps = (struct emission_maps){.scene = scene};
    struct error *err = array_create(&maps->use, scene->material_count, sizeof *maps->use);
    for (size_t i = 0; i < scene->material_count && !err; i++) {
        const struct scene_material *m = &scene->materials[i];
        maps->use[i] = (struct emission_use){-1, -1};
        if (!scene_emits(m))
            continue;
        if (m->emission_map.texture != SCENE_NONE)
            err =
                use_map(maps, &capacity,
                        (struct emission_map){.texture = &scene->textures[m->emission_map.texture],
                                              .factor = m->emission},
                        &maps->use[i].light);
        if (!err && m->alpha != SCENE_OPAQUE && m->alpha_map.texture != SCENE_NONE)
            err = use_map(maps, &capacity,
                          (struct emission_map){.texture = &scene->textures[m->alpha_map.texture],
                                                .alpha = true,
                                                .of = m},
                          &maps->use[i].alpha);
    }
    if (err)
        emission_clear(maps);
    return err;
}

void emission_clear(struct emission_maps *maps)
{
    for (size_t i = 0; i < maps->count; i++)
        for (int l = 0; l < LEVELS; l++)
            free(maps->map[i].level[l]);
    free(maps->map);
    free(maps->use);
    *maps = (struct emission_maps){0};
}

/* -- boxes ------------------------------------------------------------------------------------- */

/* Along one axis, in texels, without end to either side. */
struct interval {
    double low, high;
};

/* The blocks of a level that an interval meets, and how many texels of it are in each. */
struct spans {
    int count;
    uint32_t at[SPANS];
    double weight[SPANS];
};

/* Where x is in a picture of n texels: the texel coordinate, and whether it goes backwards. */
static double wrapped(enum scene_wrap wrap, uint32_t n, double x, bool *backwards)
{
    const double turns = floor(x / n), rest = fmin(fmax(x - turns * n, 0), n);
    *backwards = false;
    if (wrap != SCENE_MIRROR)
        return rest;
    *backwards = turns - 2 * floor(turns / 2) > 0.5;
    return *backwards ? n - rest : rest;
}

static void find_spans(enum scene_wrap wrap, uint32_t n, int level, struct interval over,
                       struct spans *spans)
{
    const double size = ldexp(1, level), end = n;
    const uint32_t blocks = blocks_on(n, level);
    spans->count = 0;
    for (double x = over.low; x < over.high && spans->count < SPANS;) {
        double step;
        uint32_t at;
        if (wrap == SCENE_CLAMP && (x < 0 || x >= end)) {
            at = x < 0 ? 0 : blocks - 1;
            step = x < 0 ? -x : over.high - x;
        } else {
            bool backwards;
            const double place = wrapped(wrap, n, x, &backwards);
            if (backwards) {
                at = (uint32_t)fmax(ceil(place / size) - 1, 0);
                step = place - at * size;
            } else {
                at = (uint32_t)(place / size);
                at = at < blocks ? at : blocks - 1;
                step = fmin((at + 1) * size, end) - place;
            }
        }
        /* on, whatever rounding does */
        step = fmin(fmax(step, 1e-9 * (1 + fabs(x))), over.high - x);
        spans->at[spans->count] = at;
        spans->weight[spans->count++] = step;
        x += fmax(step, 1e-12 * (1 + fabs(x)));
    }
}

/* Where the map reads the texture, in texels, from the left and the top; false: too far out, where
 * it reads one place. */
static bool find_box(const struct scene_map *map, const struct scene_texture *texture,
                     const float uv[3][2], struct interval box[2])
{
    const float *m = map->transform;
    for (int k = 0; k < 3; k++) {
        const double s = (double)(m[0] * uv[k][0] + m[1] * uv[k][1] + m[2]),
                     t = (double)(m[3] * uv[k][0] + m[4] * uv[k][1] + m[5]);
        if (!(fabs(s) < 1e9 && fabs(t) < 1e9))
            return false;
        const double at[2] = {s * texture->width, (1 - t) * texture->height};
        for (int axis = 0; axis < 2; axis++) {
            box[axis].low = k ? fmin(box[axis].low, at[axis]) : at[axis];
            box[axis].high = k ? fmax(box[axis].high, at[axis]) : at[axis];
        }
    }
    return true;
}

/* Over a box spread by so many texels to either side. */
static struct emission_range spread_over(const struct emission_map *map,
                                         const struct scene_map *reads, const float uv[3][2],
                                         double spread)
{
    const struct scene_texture *texture = map->texture;
    const uint32_t size[2] = {texture->width, texture->height};
    const enum scene_wrap wrap[2] = {texture->wrap_u, texture->wrap_v};
    struct interval box[2];
    struct spans spans[2];
    struct emission_range range = {.smooth = true};
    if (!find_box(reads, texture, uv, box)) {
        const struct block all = map->level[map->last][0];
        return (struct emission_range){all.mean, all.most, true};
    }
    int level = 0;
    for (int axis = 0; axis < 2; axis++) {
        range.smooth = range.smooth && box[axis].high - box[axis].low < 1;
        /* all of a picture that comes again and again */
        if (wrap[axis] != SCENE_CLAMP)
            box[axis].high = fmin(box[axis].high, box[axis].low + 2.0 * size[axis]);
        box[axis].low -= spread;
        box[axis].high += spread;
        const double inside = wrap[axis] == SCENE_CLAMP
                                  ? fmin(box[axis].high, size[axis]) - fmax(box[axis].low, 0)
                                  : box[axis].high - box[axis].low;
        while (level < map->last && inside > ldexp(ACROSS, level))
            level++;
    }
    level = level < map->first ? 0 : level;
    for (int axis = 0; axis < 2; axis++)
        find_spans(wrap[axis], size[axis], level, box[axis], &spans[axis]);
    double sum = 0, weight = 0;
    for (int j = 0; j < spans[1].count; j++) {
        for (int i = 0; i < spans[0].count; i++) {
            const struct block block = get_block(map, level, spans[0].at[i], spans[1].at[j]);
            const double w = spans[0].weight[i] * spans[1].weight[j];
            sum += w * (double)block.mean;
            weight += w;
            range.most = float_most(range.most, block.most);
        }
    }
    range.mean = (float)(sum / weight);
    return range;
}

/* What rounding may move a place in a picture, texels. */
static const double rounding = 1e-3;

/* Over a box as interpolation spreads it: half a texel to either side. Where there is none a
 * neighbour may be met by rounding, and hardly counts. */
static struct emission_range map_over(const struct emission_map *map, const struct scene_map *reads,
                                      const float uv[3][2])
{
    struct emission_range range =
        spread_over(map, reads, uv, map->texture->nearest ? rounding : 0.5);
    if (map->texture->nearest)
        range.mean = float_most(spread_over(map, reads, uv, 0).mean, (float)rounding * range.mean);
    return range;
}

struct emission_range emission_over(const struct emission_maps *maps, int32_t material,
                                    const float uv[3][2], const float alpha_uv[3][2])
{
    const struct scene_material *m = &maps->scene->materials[material];
    const struct emission_use *use = &maps->use[material];
    const float even = luminance_vec3f(m->emission);
    struct emission_range range = {even, even, true};
    if (use->light >= 0)
        range = map_over(&maps->map[use->light], &m->emission_map, uv);
    if (use->alpha >= 0) {
        const struct emission_range alpha =
            map_over(&maps->map[use->alpha], &m->alpha_map, alpha_uv);
        range.mean *= alpha.mean;
        range.most *= alpha.most;
        range.smooth = range.smooth && alpha.smooth;
    }
    return range;
}
