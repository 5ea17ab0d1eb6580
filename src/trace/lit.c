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
    NEAR = 32,    /* d0 squared, in areas that a particle stands for */
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
    uint64_t code;
    size_t hit;
};

static int by_code(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return x->code != y->code ? (x->code > y->code ? 1 : -1)
                              : (x->hit > y->hit) - (x->hit < y->hit);
}

/* The axis that a normal is nearest to, and its sign: 0 .. 5. */
static int side_of(struct vec3f n)
{
    const float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
    return x >= y && x >= z ? n.x < 0 : y >= z ? 2 + (n.y < 0) : 4 + (n.z < 0);
}

/* Side by side, along a Morton curve. */
static uint64_t code_of(const struct tracer *tracer, struct vec3f p, struct vec3f n)
{
    const double side = 2 * tracer->extent, at[3] = {(double)p.x, (double)p.y, (double)p.z};
    uint64_t code = 0;
    for (int k = 0; k < 3; k++) {
        const double share = fmin(fmax(at[k] / side + 0.5, 0), 1);
        const uint64_t c = (uint64_t)(share * ((1 << MORTON) - 1));
        for (int b = 0; b < MORTON; b++)
            code |= (c >> b & 1) << (3 * b + k);
    }
    return code >> 3 | (uint64_t)side_of(n) << 60;
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

static struct error *take_hits(struct lit *lit, const struct particles *particles)
{
    struct place *place = NULL;
    struct error *err = array_create(&place, particles->count, sizeof *place);
    for (size_t i = 0; i < particles->count && !err; i++) {
        const struct particle_hit *hit = &particles->hit[i];
        place[lit->points++] = (struct place){code_of(lit->tracer, hit->position, hit->normal), i};
    }
    if (!err)
        err = array_create(&lit->point, lit->points, sizeof *lit->point);
    if (!err)
        qsort(place, lit->points, sizeof *place, by_code);
    for (size_t i = 0; i < lit->points && !err; i++) {
        const struct particle_hit *hit = &particles->hit[place[i].hit];
        lit->point[i] = (struct point){
            trace_leave(hit->position, 4 * (float)lit->tracer->extent, hit->normal), hit->normal,
            vec3f_scale(1 / (float)ANGLE_PI, vec3f_mul(hit->flux, albedo_of(lit->tracer, hit)))};
    }
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

/* The area that a particle of the mean flux stands for, where the brightest sun is overhead. */
static float area_of(const struct scene *scene, const struct particles *particles)
{
    double flux = 0, most = 0;
    for (size_t i = 0; i < particles->count; i++)
        flux += (double)luminance_vec3f(particles->hit[i].flux);
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind == SCENE_SUN)
            most = fmax(most, luminance_f64(scene->lights[i].intensity));
    return most > 0 ? (float)(flux / (double)particles->count / most) : 0;
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
    err = particles_trace(
        from->tracer, from->lights, from->sky,
        &(struct particles_settings){
            .count = count, .bounces = 1, .suns_only = true, .seed = seed, .threads = threads},
        &particles);
    if (!err && particles.count) {
        l->near = NEAR * area_of(l->tracer->scene, &particles);
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

void lit_learn(const struct lit *lit, const uint32_t *asked, const uint32_t *seen, double *sum)
{
    double all = 0, before = 0, asks = 0, sees = 0;
    for (size_t i = 0; i < lit->clusters; i++) {
        asks += asked[i];
        sees += seen[i];
    }
    /* what few questions say counts as much as one that is answered like all */
    const double mean = sees / fmax(asks, 1);
    for (size_t i = 0; i < lit->clusters; i++) {
        const double weight = sum[i] - before;
        before = sum[i];
        all += weight * fmax((seen[i] + mean) / (asked[i] + 1), LEAST_SEEN);
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
    const struct point *p = &lit->point[begin + (size_t)(x * (double)points)];
    const struct vec3f way = vec3f_sub(p->position, receiver->position);
    const float square = vec3f_dot(way, way), cosine = -vec3f_dot(way, p->normal) / sqrtf(square);
    if (!(cosine > 0))
        return false;
    probability /= (double)points;
    *point = (struct lit_point){
        cluster, p->position, p->normal,
        vec3f_scale((float)((double)(cosine / (square + lit->near)) / probability), p->scattered)};
    return true;
}
