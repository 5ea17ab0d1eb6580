/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/lit.h"
#include "base/array.h"
#include "base/error.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "trace/particles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK = 8,    /* points */
    CLUSTER = 32, /* blocks */
    NEAR = 32,    /* d0 squared, in areas that a sun's particle stands for */
    MORTON = 21,  /* bits an axis */
};

struct point {
    struct vec3f position, normal;
    struct vec3f scattered; /* radiance times area, local units^2 */
};

/* No cluster counts less than this share of what it would bring if all of it were seen. */
#define LEAST_SEEN 0.02

/* Neighbours: a ball that holds them, their mean normal, and how far the others are from it. */
struct block {
    struct vec3f middle, normal;
    float radius, spread, power; /* power: luminance of what they scatter, in all */
};

struct lit {
    const struct tracer *tracer;
    struct point *point; /* owned, and so is: */
    struct block *block, *cluster;
    size_t points, blocks, clusters;
    float near; /* d0 squared */
};

/* -- making ------------------------------------------------------------------------------------ */

static struct vec3f albedo_of(const struct tracer *tracer, const struct particle_hit *hit)
{
    struct trace_point p;
    float tint[4];
    trace_point_at(tracer, hit->instance, hit->triangle, hit->b, hit->c, &p);
    if (!tracer->has_colour)
        return scene_albedo(tracer->scene, p.material, p.u, p.v);
    trace_point_tint(tracer, &p, tint);
    return scene_albedo_tinted(tracer->scene, p.material, (struct vec3f){tint[0], tint[1], tint[2]},
                               p.u, p.v);
}

struct place {
    int group;
    uint64_t code;
    size_t hit;
    struct vec3f scattered;
};

static int by_code(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return x->group != y->group ? (x->group > y->group ? 1 : -1)
           : x->code != y->code ? (x->code > y->code ? 1 : -1)
                                : (x->hit > y->hit) - (x->hit < y->hit);
}

/* The axis that a normal is nearest to, and its sign: 0 .. 5. */
static int side_of(struct vec3f n)
{
    const float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
    return x >= y && x >= z ? n.x < 0 : y >= z ? 2 + (n.y < 0) : 4 + (n.z < 0);
}

/* Points of one side that scatter about as much: within 16 times. */
static int group_of(struct vec3f scattered, struct vec3f n)
{
    const float power = luminance_vec3f(scattered);
    return 6 * (power > 0 ? (int)floorf(log2f(power) / 4) : -64) + side_of(n);
}

/* Side by side, along a Morton curve. */
static uint64_t code_of(const struct tracer *tracer, struct vec3f p)
{
    const double side = 2 * tracer->extent, at[3] = {(double)p.x, (double)p.y, (double)p.z};
    uint64_t code = 0;
    for (int k = 0; k < 3; k++) {
        const double share = fmin(fmax(at[k] / side + 0.5, 0), 1);
        const uint64_t c = (uint64_t)(share * ((1 << MORTON) - 1));
        for (int b = 0; b < MORTON; b++)
            code |= (c >> b & 1) << (3 * b + k);
    }
    return code;
}

static struct block block_of(const struct point *point, size_t count)
{
    struct block b = {0};
    for (size_t i = 0; i < count; i++) {
        b.middle = vec3f_fma(b.middle, 1 / (float)count, point[i].position);
        b.normal = vec3f_fma(b.normal, 1 / (float)count, point[i].normal);
        b.power += luminance_vec3f(point[i].scattered);
    }
    for (size_t i = 0; i < count; i++) {
        b.radius = fmaxf(b.radius, vec3f_length(vec3f_sub(point[i].position, b.middle)));
        b.spread = fmaxf(b.spread, vec3f_length(vec3f_sub(point[i].normal, b.normal)));
    }
    return b;
}

/* Points by groups, each of which fills its clusters up with points that scatter nothing: else a
 * bright one that faces away would take the questions of a dim one that is seen. */
static struct error *take_hits(struct lit *lit, const struct particles *particles)
{
    struct place *place = NULL;
    struct error *err = array_create(&place, particles->count, sizeof *place);
    size_t count = 0, capacity = 0;
    for (size_t i = 0; i < particles->count && !err; i++) {
        const struct particle_hit *hit = &particles->hit[i];
        const struct vec3f scattered =
            vec3f_scale(1 / (float)ANGLE_PI, vec3f_mul(hit->flux, albedo_of(lit->tracer, hit)));
        place[i] = (struct place){group_of(scattered, hit->normal),
                                  code_of(lit->tracer, hit->position), i, scattered};
    }
    if (!err)
        qsort(place, particles->count, sizeof *place, by_code);
    for (size_t i = 0; i < particles->count && !err; i++) {
        const struct particle_hit *hit = &particles->hit[place[i].hit];
        const bool last = i + 1 < particles->count && place[i + 1].group != place[i].group;
        const size_t whole = BLOCK * CLUSTER, after = count + 1,
                     fill = last ? (whole - after % whole) % whole : 0;
        err = array_reserve(&lit->point, &capacity, after + fill, sizeof *lit->point);
        if (err)
            break;
        lit->point[count] =
            (struct point){trace_leave(hit->position, 4 * (float)lit->tracer->extent, hit->normal),
                           hit->normal, place[i].scattered};
        for (size_t k = after; k < after + fill; k++) {
            lit->point[k] = lit->point[count];
            lit->point[k].scattered = (struct vec3f){0};
        }
        count = after + fill;
    }
    lit->points = count;
    free(place);
    return err;
}

/* Puts every `size` points together. */
static struct error *make_blocks(const struct lit *lit, size_t size, struct block **blocks,
                                 size_t *count)
{
    *count = (lit->points + size - 1) / size;
    struct error *err = array_create(blocks, *count, sizeof **blocks);
    for (size_t i = 0; i < *count && !err; i++) {
        const size_t left = lit->points - i * size;
        (*blocks)[i] = block_of(lit->point + i * size, left < size ? left : size);
    }
    return err;
}

struct error *lit_create(struct lit **lit, const struct lit_sources *from, size_t count,
                         uint64_t seed, int threads)
{
    struct particles particles = {0};
    struct lit *l = NULL;
    *lit = NULL;
    struct error *err = array_create(&l, 1, sizeof *l);
    if (err)
        return err;
    l->tracer = from->tracer;
    err = particles_trace(from->tracer, from->lights, from->sky,
                          &(struct particles_settings){.count = count,
                                                       .bounces = 1,
                                                       .suns_only = true,
                                                       .even = 1,
                                                       .seed = seed,
                                                       .threads = threads},
                          &particles);
    if (!err && particles.count) {
        l->near = NEAR * particles.sun_area;
        err = take_hits(l, &particles);
        if (!err)
            err = make_blocks(l, BLOCK, &l->block, &l->blocks);
        if (!err)
            err = make_blocks(l, (size_t)BLOCK * CLUSTER, &l->cluster, &l->clusters);
    }
    particles_clear(&particles);
    if (err || !l->points) {
        lit_destroy(l);
        return err;
    }
    *lit = l;
    return NULL;
}

void lit_destroy(struct lit *lit)
{
    if (!lit)
        return;
    free(lit->point);
    free(lit->block);
    free(lit->cluster);
    free(lit);
}

/* -- asking ------------------------------------------------------------------------------------ */

bool lit_is_of(const struct lit *lit, const struct tracer *tracer)
{
    return lit->tracer == tracer;
}

float lit_share(const struct lit *lit, float distance)
{
    const float square = distance * distance;
    return square / (square + lit->near);
}

size_t lit_clusters(const struct lit *lit)
{
    return lit->clusters;
}

/* The most that the cosine at a point of the block can be; 0: none faces the receiver. */
static inline float most_cosine(const struct block *b, struct vec3f way, float distance)
{
    const float cosine = -vec3f_dot(way, b->normal) / distance;
    return float_least(float_most(cosine + b->spread + 2 * b->radius / distance, 0), 1);
}

/* What a receiver would get of these blocks if nothing stood between, added up block by block. */
static void add_up(const struct lit *lit, const struct lights_receiver *receiver,
                   const struct block *block, size_t count, double *sum)
{
    const struct vec3f n = receiver->normal;
    const bool surface = n.x != 0 || n.y != 0 || n.z != 0;
    double all = 0;
    for (size_t i = 0; i < count; i++) {
        const struct block *b = &block[i];
        const struct vec3f way = vec3f_sub(b->middle, receiver->position);
        const float square = vec3f_dot(way, way), distance = sqrtf(square) + FLT_MIN;
        float weight = b->power * most_cosine(b, way, distance) /
                       (square + b->radius * b->radius + lit->near);
        if (surface) {
            const float cosine = (vec3f_dot(way, n) + b->radius) / (distance + b->radius);
            weight *= float_most(cosine, 0);
        }
        all += (double)weight;
        sum[i] = all;
    }
}

void lit_weigh(const struct lit *lit, const struct lights_receiver *receiver, double *sum)
{
    add_up(lit, receiver, lit->cluster, lit->clusters, sum);
}

void lit_spread(const struct lit *lit, const double *sum, double *spread)
{
    double count = 0, all = 0;
    for (size_t i = 0; i < lit->clusters; i++)
        count += sum[i] > (i ? sum[i - 1] : 0);
    for (size_t i = 0; i < lit->clusters; i++) {
        const double weight = sum[i] - (i ? sum[i - 1] : 0);
        all += weight > 0 ? weight / sum[lit->clusters - 1] + 1 / count : 0;
        spread[i] = all;
    }
}

void lit_learn(const struct lit *lit, const uint32_t *asked, const uint32_t *seen, double *sum)
{
    double all = 0, before = 0, asks = 0, sees = 0, known = 0, unknown = 0;
    for (size_t i = 0; i < lit->clusters; i++) {
        asks += asked[i];
        sees += seen[i];
    }
    /* what few questions say counts as much as one that is answered like all; what none saw takes
     * no more of the questions than what was seen */
    const double mean = sees / fmax(asks, 1);
    for (size_t i = 0; i < lit->clusters; i++) {
        const double weight = sum[i] - before, share = seen[i] / (asked[i] + 1.0);
        before = sum[i];
        known += weight * share;
        unknown += weight * (fmax(share + mean / (asked[i] + 1.0), LEAST_SEEN) - share);
    }
    const double most = known > 0 ? fmin(known / unknown, 1) : 1;
    before = 0;
    for (size_t i = 0; i < lit->clusters; i++) {
        const double weight = sum[i] - before, share = seen[i] / (asked[i] + 1.0);
        before = sum[i];
        all += weight *
               (share + most * (fmax(share + mean / (asked[i] + 1.0), LEAST_SEEN) - share));
        sum[i] = all;
    }
}

/* Draws one of `count` by what was added up and *x, uniform in [0, 1), which it leaves so for what
 * is drawn next. The probability; 0: none brings anything. */
static double draw_one(const double *sum, size_t count, double *x, size_t *drawn)
{
    const double all = sum[count - 1], at = *x * all;
    size_t low = 0, high = count - 1;
    while (low < high) { /* the first whose sum is beyond */
        const size_t middle = (low + high) / 2;
        if (sum[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    const double before = low ? sum[low - 1] : 0, own = sum[low] - before;
    *drawn = low;
    if (!(own > 0))
        return 0;
    *x = fmin((at - before) / own, 1 - 0x1p-53);
    return own / all;
}

bool lit_draw(const struct lit *lit, const struct lights_receiver *receiver, const double *sum,
              double x, struct lit_point *point)
{
    double within[CLUSTER];
    size_t cluster, block;
    double probability = draw_one(sum, lit->clusters, &x, &cluster);
    point->cluster = cluster;
    if (!(probability > 0))
        return false;
    const size_t first = cluster * CLUSTER, blocks = lit->blocks - first,
                 count = blocks < CLUSTER ? blocks : CLUSTER;
    add_up(lit, receiver, lit->block + first, count, within);
    probability *= draw_one(within, count, &x, &block);
    if (!(probability > 0))
        return false;
    const size_t begin = (first + block) * BLOCK, left = lit->points - begin,
                 points = left < BLOCK ? left : BLOCK;
    double power[BLOCK], all = 0;
    size_t drawn;
    for (size_t i = 0; i < points; i++)
        power[i] = all += (double)luminance_vec3f(lit->point[begin + i].scattered);
    probability *= draw_one(power, points, &x, &drawn);
    if (!(probability > 0))
        return false;
    const struct point *p = &lit->point[begin + drawn];
    const struct vec3f way = vec3f_sub(p->position, receiver->position);
    const float square = vec3f_dot(way, way), cosine = -vec3f_dot(way, p->normal) / sqrtf(square);
    if (!(cosine > 0))
        return false;
    *point = (struct lit_point){
        cluster, p->position, p->normal,
        vec3f_scale((float)((double)(cosine / (square + lit->near)) / probability), p->scattered)};
    return true;
}
