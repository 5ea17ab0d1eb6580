/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/cloud.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "math/cubes.h"
#include "math/vec.h"
#include "place/place_method.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- probes ----------------------------------------------------------------------------------- */

void cloud_clear(struct cloud *cloud)
{
    free(cloud->probe);
    free(cloud->sh);
    free(cloud->noise);
    *cloud = (struct cloud){0};
}

const float *cloud_light(const struct cloud *cloud, size_t probe)
{
    return cloud->sh + place_light_width(cloud->light) * cloud->probe[probe].light;
}

struct error *cloud_add(struct cloud *cloud, const struct cloud_probe *probe)
{
    struct error *err =
        array_reserve(&cloud->probe, &cloud->room, cloud->count + 1, sizeof *cloud->probe);
    if (!err)
        cloud->probe[cloud->count++] = *probe;
    return err;
}

static int compare_probes(const void *left, const void *right)
{
    const struct cloud_probe *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a->position[k] != b->position[k])
            return a->position[k] < b->position[k] ? -1 : 1;
    return (a->kept > b->kept) - (a->kept < b->kept);
}

void cloud_sort(struct cloud *cloud)
{
    qsort(cloud->probe, cloud->count, sizeof *cloud->probe, compare_probes);
}

double cloud_mean(const struct cloud *cloud)
{
    const int order = cloud->light->settings.order;
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < cloud->count; i++)
        if (cloud->probe[i].light != CLOUD_NONE) {
            sum += contrast_mean(order, 1, cloud_light(cloud, i));
            count++;
        }
    return count ? sum / (double)count : 0;
}

struct error *cloud_capture(struct cloud *cloud)
{
    const size_t width = place_light_width(cloud->light);
    double *position = NULL;
    size_t *list = NULL, due = 0;
    struct error *err = array_create(&position, 3 * cloud->count, sizeof *position);
    if (!err)
        err = array_create(&list, cloud->count, sizeof *list);
    for (size_t i = 0; i < cloud->count && !err; i++)
        if (cloud->probe[i].light == CLOUD_NONE) {
            memcpy(position + 3 * due, cloud->probe[i].position, 3 * sizeof *position);
            list[due++] = i;
        }
    if (!err)
        err = array_reserve(&cloud->sh, &cloud->sh_room, cloud->rows + due,
                            width * sizeof *cloud->sh);
    if (!err)
        err = array_reserve(&cloud->noise, &cloud->noise_room, cloud->rows + due,
                            sizeof *cloud->noise);
    float *sh = err ? NULL : cloud->sh + width * cloud->rows;
    if (!err)
        err =
            place_light_capture_noise(cloud->light, due, position, sh, cloud->noise + cloud->rows);
    for (size_t i = 0; i < due && !err; i++)
        if (!isnan(sh[width * i]))
            cloud->probe[list[i]].light = (uint32_t)(cloud->rows + i);
    if (!err)
        cloud->rows += due;
    free(position);
    free(list);
    return err;
}

/* -- the start -------------------------------------------------------------------------------- */

/* Takes out the positions that are in no air. */
static struct error *add_grid(struct cloud *cloud, const struct place *grid)
{
    bool *air = NULL;
    struct error *err = array_create(&air, grid->count, sizeof *air);
    if (!err)
        err = place_light_air(cloud->light, grid->count, grid->position, air);
    for (size_t i = 0; i < grid->count && !err; i++) {
        struct cloud_probe probe = {.kept = -1, .light = CLOUD_NONE};
        memcpy(probe.position, grid->position + 3 * i, sizeof probe.position);
        if (air[i])
            err = cloud_add(cloud, &probe);
    }
    if (!err && !cloud->count)
        err = error_new("none of the grid's %zu nodes is in the air: --bounds tells where it is",
                        grid->count);
    free(air);
    return err;
}

/* Few nodes may miss all the light that there is. */
static struct error *no_light(const struct cloud *cloud)
{
    const bool scattered = cloud->light->settings.light == CAPTURE_INDIRECT;
    if (capture_is_dark(cloud->light->world->scene))
        return error_new("there is no light: --sky, --sun, --point and --spot add light");
    return error_new("no light%s reaches the %zu nodes of the grid that are in the air: more of "
                     "them (--count) may find some%s; --sky, --sun, --point and --spot add light",
                     scattered ? " that surfaces scatter" : "", cloud->count,
                     scattered ? ", and --light all has direct light, too" : "");
}

struct error *cloud_start(struct cloud *cloud, struct place_light *light,
                          const struct place_options *options)
{
    struct place grid = {0};
    cloud->light = light;
    struct error *err = place_method_grid.place(&grid, options, light->world);
    memcpy(cloud->spacing, light->world->spacing, sizeof cloud->spacing);
    if (!err)
        err = add_grid(cloud, &grid);
    for (size_t i = 0; i < light->kept_count && !err; i++) {
        struct cloud_probe probe = {.kept = (int32_t)i, .light = CLOUD_NONE};
        memcpy(probe.position, light->kept + 3 * i, sizeof probe.position);
        err = cloud_add(cloud, &probe);
    }
    if (!err) {
        cloud_sort(cloud);
        err = cloud_capture(cloud);
    }
    if (!err && interrupt_came())
        err = error_new("interrupted before there was anything to keep");
    if (!err && !(cloud_mean(cloud) > 0))
        err = no_light(cloud);
    place_clear(&grid);
    return err;
}

/* -- pairs ------------------------------------------------------------------------------------ */

struct pair {
    uint32_t a, b; /* a < b, in order of position */
    double key;    /* sorted by this, falling */
    double middle[3];
    bool good;
};

struct pairs {
    struct pair *list; /* owned */
    size_t count, room;
};

/* What pairs are looked for. */
struct search {
    const struct cloud *cloud;
    const struct contrast *contrast;
    struct cubes near; /* of probes, in spacings */
    double distance, threshold;
    bool alike;             /* below the threshold; else above it */
    struct cubes other;     /* alike false: of probes too, for their least distance */
    double least;           /* of middles from them */
    struct pairs *of_block; /* pairs whose first probe is of the block */
};

enum { BLOCK = 256 }; /* probes */

static void in_spacings(const struct cloud *cloud, const double p[3], double q[3])
{
    for (int k = 0; k < 3; k++)
        q[k] = p[k] / cloud->spacing[k];
}

/* A probe, and what is found of it. */
struct around {
    const struct search *search;
    uint32_t probe;
    const double *at; /* in spacings */
    struct pairs *pairs;
    struct error *err;
};

/* The ends of a pair, by their coordinates. */
struct ends {
    const double *a, *b;
};

static bool is_other(void *context, const double *point)
{
    const struct ends *ends = context;
    return point != ends->a && point != ends->b;
}

/* Whether no other probe is as near to the middle of two as they are: they are neighbours (Gabriel
 * and Sokal, "A new statistical approach to geographic variation analysis", 1969). */
static bool are_neighbours(const struct search *s, const double *a, const double *b,
                           double distance)
{
    struct ends ends = {a, b};
    double middle[3];
    for (int k = 0; k < 3; k++)
        middle[k] = (a[k] + b[k]) / 2;
    return !cubes_find(&s->near, middle, distance / 2 * (1 + 1e-6), is_other, &ends, NULL);
}

static void consider(struct around *around, uint32_t other, const double *at)
{
    const struct search *s = around->search;
    const struct cloud_probe *a = &s->cloud->probe[around->probe], *b = &s->cloud->probe[other];
    const double distance = vec3_length(vec3_sub(vec3_load(at), vec3_load(around->at)));
    if (s->alike && a->kept >= 0 && b->kept >= 0)
        return;
    /* noise makes nobody differ, nor is it a proof of likeness */
    const double noise = s->alike ? 0 : s->cloud->noise[a->light] + s->cloud->noise[b->light],
                 contrast_of = contrast_clean(s->contrast, cloud_light(s->cloud, around->probe),
                                              cloud_light(s->cloud, other), noise);
    struct pair pair = {.a = around->probe, .b = other, .good = true};
    if (s->alike ? contrast_of >= s->threshold || !are_neighbours(s, around->at, at, distance)
                 : contrast_of <= s->threshold)
        return;
    /* rounding does not tell equal distances of a grid apart */
    pair.key = s->alike ? -floor(distance * 1e6 + .5) : contrast_of;
    for (int k = 0; k < 3; k++)
        pair.middle[k] = (a->position[k] + b->position[k]) / 2;
    if (s->alike && (a->kept >= 0 || b->kept >= 0))
        memcpy(pair.middle, a->kept >= 0 ? a->position : b->position, sizeof pair.middle);
    if (!s->alike) {
        double q[3];
        in_spacings(s->cloud, pair.middle, q);
        if (cubes_find(&s->other, q, s->least, NULL, NULL, NULL))
            return;
    }
    around->err = array_reserve(&around->pairs->list, &around->pairs->room,
                                around->pairs->count + 1, sizeof *around->pairs->list);
    if (!around->err)
        around->pairs->list[around->pairs->count++] = pair;
}

static bool see(void *context, const double *point)
{
    struct around *around = context;
    const uint32_t other = (uint32_t)((point - around->search->near.point) / 3);
    if (other > around->probe && !around->err)
        consider(around, other, point);
    return false;
}

static struct error *search_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct search *s = context;
    struct error *err = NULL;
    for (size_t i = BLOCK * block; i < BLOCK * (block + 1) && i < s->cloud->count && !err; i++) {
        const double *at = s->near.point + 3 * i;
        struct around around = {s, (uint32_t)i, at, &s->of_block[block], NULL};
        cubes_find(&s->near, at, s->distance, see, &around, NULL);
        err = around.err;
    }
    return err;
}

static int compare_pairs(const void *left, const void *right)
{
    const struct pair *a = left, *b = right;
    if (a->key != b->key)
        return a->key > b->key ? -1 : 1;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return (a->b > b->b) - (a->b < b->b);
}

static struct error *join_blocks(struct search *s, size_t blocks, struct pairs *all)
{
    size_t count = 0;
    for (size_t i = 0; i < blocks; i++)
        count += s->of_block[i].count;
    struct error *err = array_reserve(&all->list, &all->room, count, sizeof *all->list);
    for (size_t i = 0; i < blocks && !err; i++) {
        if (s->of_block[i].count)
            memcpy(all->list + all->count, s->of_block[i].list,
                   s->of_block[i].count * sizeof *all->list);
        all->count += s->of_block[i].count;
    }
    if (!err && all->count)
        qsort(all->list, all->count, sizeof *all->list, compare_pairs);
    return err;
}

static struct error *fill_cubes(const struct cloud *cloud, struct cubes *cubes, double size,
                                size_t room)
{
    struct error *err = cubes_init(cubes, size, room);
    for (size_t i = 0; i < cloud->count && !err; i++) {
        double q[3];
        in_spacings(cloud, cloud->probe[i].position, q);
        cubes_add(cubes, q);
    }
    return err;
}

/* Finds the pairs, which are sorted. Closes over the cloud as it is: all of it is captured. */
static struct error *find_pairs(struct search *s, struct pairs *pairs)
{
    const struct cloud *cloud = s->cloud;
    const size_t blocks = (cloud->count + BLOCK - 1) / BLOCK;
    s->distance *= 1 + 1e-9; /* what is just as far counts */
    struct error *err = fill_cubes(cloud, &s->near, s->distance, cloud->count);
    if (!err)
        err = array_create(&s->of_block, blocks, sizeof *s->of_block);
    if (!err)
        err = threads_for(cloud->light->world->inside.threads, blocks, search_block, s);
    if (!err)
        err = join_blocks(s, blocks, pairs);
    for (size_t i = 0; s->of_block && i < blocks; i++)
        free(s->of_block[i].list);
    free(s->of_block);
    cubes_clear(&s->near);
    return err;
}

/* -- what is good of them --------------------------------------------------------------------- */

struct looking {
    const struct cloud *cloud;
    struct pair *list;
};

static struct error *look_along(void *context, size_t i, int thread)
{
    (void)thread;
    const struct looking *s = context;
    struct pair *pair = &s->list[i];
    if (pair->good)
        pair->good = place_light_is_free(s->cloud->light, s->cloud->probe[pair->a].position,
                                         s->cloud->probe[pair->b].position);
    return NULL;
}

/* Nothing leaves the region: what merges to its middle, but for corners of the grid's cells that
 * are out of it both, or is spawned there. */
static bool is_in_region(const struct cloud *cloud, const struct pair *pair, bool merges)
{
    const struct reach *region = cloud->light->world->reach;
    return !region || reach_holds(region, pair->middle) ||
           (merges && !reach_holds(region, cloud->probe[pair->a].position) &&
            !reach_holds(region, cloud->probe[pair->b].position));
}

/* Pairs whose middles are in the air, and the region, stay good; see: and that see each other. */
static struct error *check_pairs(const struct cloud *cloud, struct pairs *pairs, bool sees)
{
    struct looking s = {cloud, pairs->list};
    double *middle = NULL;
    bool *air = NULL;
    struct error *err = array_create(&middle, 3 * pairs->count, sizeof *middle);
    if (!err)
        err = array_create(&air, pairs->count, sizeof *air);
    for (size_t i = 0; i < pairs->count && !err; i++)
        memcpy(middle + 3 * i, pairs->list[i].middle, 3 * sizeof *middle);
    if (!err && pairs->count)
        err = place_light_air(cloud->light, pairs->count, middle, air);
    for (size_t i = 0; i < pairs->count && !err; i++)
        pairs->list[i].good = air[i] && is_in_region(cloud, &pairs->list[i], sees);
    if (!err && sees)
        err = threads_for(cloud->light->world->inside.threads, pairs->count, look_along, &s);
    free(middle);
    free(air);
    return err;
}

/* -- merging ---------------------------------------------------------------------------------- */

enum part { PART_NONE, PART_STAYS, PART_GOES }; /* of a probe in this step's merging */

/* Moves one of each good pair to the middle, where it is to be captured, and takes the other
 * out. */
static struct error *merge_pairs(struct cloud *cloud, const struct pairs *pairs, size_t *merged)
{
    unsigned char *part = NULL;
    size_t left = 0;
    struct error *err = array_create(&part, cloud->count, sizeof *part);
    for (size_t i = 0; i < pairs->count && !err; i++) {
        const struct pair *pair = &pairs->list[i];
        if (!pair->good || part[pair->a] || part[pair->b])
            continue;
        const bool second = cloud->probe[pair->b].kept >= 0;
        struct cloud_probe *stays = &cloud->probe[second ? pair->b : pair->a];
        part[pair->a] = second ? PART_GOES : PART_STAYS;
        part[pair->b] = second ? PART_STAYS : PART_GOES;
        if (stays->kept < 0) {
            memcpy(stays->position, pair->middle, sizeof stays->position);
            stays->light = CLOUD_NONE;
        }
        ++*merged;
    }
    for (size_t i = 0; i < cloud->count && !err; i++)
        if (part[i] != PART_GOES)
            cloud->probe[left++] = cloud->probe[i];
    if (!err)
        cloud->count = left;
    free(part);
    return err;
}

struct error *cloud_merge(struct cloud *cloud, const struct contrast *contrast, double distance,
                          double most, size_t *merged)
{
    struct search search = {.cloud = cloud,
                            .contrast = contrast,
                            .distance = distance,
                            .threshold = most,
                            .alike = true};
    struct pairs pairs = {0};
    *merged = 0;
    if (!(distance > 0))
        return NULL;
    cloud_sort(cloud);
    struct error *err = find_pairs(&search, &pairs);
    if (!err)
        err = check_pairs(cloud, &pairs, true);
    if (!err)
        err = merge_pairs(cloud, &pairs, merged);
    free(pairs.list);
    if (!err) {
        cloud_sort(cloud);
        err = cloud_capture(cloud);
    }
    return err;
}

/* -- spawning --------------------------------------------------------------------------------- */

/* Adds the middles of good pairs, which come by falling contrast. */
static struct error *spawn_pairs(struct cloud *cloud, const struct pairs *pairs,
                                 struct cloud_spawn *spawn, size_t *added)
{
    struct cubes taken = {0};
    struct error *err = fill_cubes(cloud, &taken, spawn->least, cloud->count + pairs->count);
    for (size_t i = 0; i < pairs->count && !err && !spawn->full; i++) {
        struct cloud_probe probe = {.kept = -1, .light = CLOUD_NONE};
        double q[3];
        memcpy(probe.position, pairs->list[i].middle, sizeof probe.position);
        in_spacings(cloud, probe.position, q);
        if (!pairs->list[i].good || cubes_find(&taken, q, spawn->least, NULL, NULL, NULL))
            continue;
        spawn->full = (double)cloud->count >= spawn->most;
        if (spawn->full)
            break;
        cubes_add(&taken, q);
        err = cloud_add(cloud, &probe);
        ++*added;
    }
    cubes_clear(&taken);
    return err;
}

struct error *cloud_spawn(struct cloud *cloud, const struct contrast *contrast,
                          struct cloud_spawn *spawn, size_t *added)
{
    struct search search = {.cloud = cloud,
                            .contrast = contrast,
                            .distance = spawn->distance,
                            .threshold = spawn->contrast,
                            .least = spawn->least};
    struct pairs pairs = {0};
    *added = 0;
    cloud_sort(cloud);
    struct error *err = fill_cubes(cloud, &search.other, spawn->least, cloud->count);
    if (!err)
        err = find_pairs(&search, &pairs);
    if (!err)
        err = check_pairs(cloud, &pairs, false);
    if (!err)
        err = spawn_pairs(cloud, &pairs, spawn, added);
    cubes_clear(&search.other);
    free(pairs.list);
    if (!err) {
        cloud_sort(cloud);
        err = cloud_capture(cloud);
    }
    return err;
}

/* -- what comes out --------------------------------------------------------------------------- */

static int compare_kept(const void *left, const void *right)
{
    const struct cloud_probe *a = left, *b = right;
    if ((a->kept >= 0) != (b->kept >= 0))
        return a->kept >= 0 ? -1 : 1;
    if (a->kept != b->kept)
        return a->kept < b->kept ? -1 : 1;
    return compare_probes(left, right);
}

struct error *cloud_give(struct cloud *cloud, struct place *place, int origin)
{
    const size_t kept = cloud->light->kept_count, others = cloud->count - kept;
    double *position = NULL;
    qsort(cloud->probe, cloud->count, sizeof *cloud->probe, compare_kept);
    struct error *err = array_create(&position, 3 * others, sizeof *position);
    for (size_t i = 0; i < others && !err; i++)
        memcpy(position + 3 * i, cloud->probe[kept + i].position, 3 * sizeof *position);
    if (!err)
        err = place_light_give(cloud->light, place, others, position, origin);
    free(position);
    return err;
}
