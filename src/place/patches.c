/* SPDX-License-Identifier: Apache-2.0 */
#include "place/patches.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "math/random.h"
#include "math/sobol.h"
#include "place/exposed.h"
#include "place/point_grid.h"
#include "place/poisson.h"
#include "scene/scene.h"
#include "trace/trace_local.h"

#include <math.h>
#include <stdlib.h>

enum {
    BLOCK = 512,  /* places that a thread takes, */
    BLOCKS = 128, /* and of which it does so many before what they found is summed */
    ASKED = 6     /* points that a place may belong to, at the most: nearer ones may not see it */
};

/* Cosine of the angle up to which two sides face alike. */
#define ALIKE 0.5

/* What sees along a flat surface stands off it by this share of the point's radius. */
#define OFF 1e-3

/* What places' random numbers are named by. */
#define NAME UINT64_C(0x7061746368657300)

/* A place, and the points that it belongs to by its sides. */
struct place_of {
    float share; /* of it that is there */
    struct vec3f albedo;
    int32_t owner[2]; /* front, back; -1: nobody */
};

struct measuring {
    const struct tracer *tracer;
    const struct exposed *exposed;
    const struct patches_settings *settings;
    struct point_grid grid;
    double most;            /* radius */
    size_t count, first;    /* places, and those before these */
    double step, offset;    /* area a place has, and where the first is, in it */
    struct place_of *place; /* BLOCK * BLOCKS; owned */
};

static struct vec3 to_double(struct vec3f a)
{
    return (struct vec3){(double)a.x, (double)a.y, (double)a.z};
}

/* -- to whom it belongs ----------------------------------------------------------------------- */

/* The nearest points that reach a side of a place: the first `count`, near ones first. */
struct near_side {
    int count;
    size_t point[ASKED];
    double square[ASKED]; /* of the distance */
};

/* Those of both sides, as they are looked for. */
struct near_both {
    const struct point_grid *grid;
    struct vec3 p, n;
    double limit; /* squared: farther ones are of no interest to either side */
    struct near_side side[2];
};

static double farthest_of(const struct near_side *side)
{
    return side->count == ASKED ? side->square[ASKED - 1] : (double)INFINITY;
}

static void insert(struct near_side *side, size_t i, double square)
{
    for (int k = 0; k < side->count; k++)
        if (side->point[k] == i)
            return;
    int at = side->count < ASKED ? side->count++ : ASKED - 1;
    for (; at > 0 && side->square[at - 1] > square; at--) {
        side->point[at] = side->point[at - 1];
        side->square[at] = side->square[at - 1];
    }
    side->point[at] = i;
    side->square[at] = square;
}

static void take_near(void *context, size_t i)
{
    struct near_both *b = context;
    const struct grid_point *point = &b->grid->point[i];
    const struct vec3 way = vec3_sub(b->p, point->position), n = to_double(point->normal);
    const double square = vec3_dot(way, way), radius = (double)point->radius,
                 facing = vec3_dot(n, b->n);
    struct near_side *side = &b->side[facing < 0];
    if (!(square < 4 * radius * radius) || !(fabs(facing) > ALIKE) ||
        !(fabs(vec3_dot(way, n)) <= radius / 2) || !(square < farthest_of(side)))
        return;
    insert(side, i, square);
    b->limit = fmin(b->limit, fmax(farthest_of(&b->side[0]), farthest_of(&b->side[1])));
}

/* How far two places stand off a surface that bends away between them to see each other past it,
 * where their normals enclose an angle t: past the ridge where their planes meet, half-way,
 * tan(t/2) / cos(t/2) of half their distance. Past a circle's arc it would be half as far. */
static double stand_off(struct vec3 way, struct vec3 n, struct vec3 facing)
{
    const double cosine = vec3_dot(n, facing);
    const bool bends = vec3_dot(way, facing) < 0 && vec3_dot(way, n) > 0;
    return bends ? 0.5 * vec3_length(way) * sqrt(fmax((1 - cosine) / 2, 0)) / ((1 + cosine) / 2)
                 : 0;
}

static bool sees(const struct measuring *m, struct vec3 p, struct vec3 n,
                 const struct grid_point *q)
{
    const struct vec3 facing = to_double(q->normal);
    const double off = OFF * (double)q->radius + stand_off(vec3_sub(p, q->position), n, facing);
    double a[3], b[3];
    vec3_store(a, vec3_fma(q->position, off, facing));
    vec3_store(b, vec3_fma(p, off, n));
    return trace_visibility(m->tracer, a, b) > 0;
}

static void find_owners(const struct measuring *m, struct vec3 p, struct vec3 n, int32_t owner[2])
{
    struct near_both b = {.grid = &m->grid, .p = p, .n = n, .limit = 4 * m->most * m->most};
    point_grid_near(&m->grid, p, &b.limit, true, take_near, &b);
    for (int side = 0; side < 2; side++) {
        const struct near_side *near = &b.side[side];
        const struct vec3 facing = vec3_scale(side ? -1 : 1, n);
        owner[side] = -1;
        for (int k = 0; k < near->count && owner[side] < 0; k++)
            if (sees(m, p, facing, &m->grid.point[near->point[k]]))
                owner[side] = (int32_t)near->point[k];
    }
}

/* -- places ----------------------------------------------------------------------------------- */

/* The i-th place: triangles get as many as go into their area, spread in each. */
static void choose_point(const struct measuring *m, size_t i, struct trace_point *point)
{
    const struct exposed *e = m->exposed;
    uint32_t instance, triangle, x, y;
    const size_t number =
        exposed_triangle(e, ((double)i + m->offset) * m->step, &instance, &triangle);
    const double before = number ? e->sum[number - 1] : 0,
                 first = ceil(before / m->step - m->offset);
    struct random r = random_start(m->settings->seed, NAME + number, 0);
    sobol_pair((uint32_t)((double)i > first ? (double)i - first : 0), random_u32(&r), &x, &y);
    const float root = sqrtf(((float)(x >> 8) + 0.5f) * 0x1p-24f),
                b = root * (1 - ((float)(y >> 8) + 0.5f) * 0x1p-24f);
    trace_point_at(m->tracer, instance, triangle, b, root - b, point);
}

static struct error *measure_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct measuring *m = context;
    const size_t first = m->first + block * BLOCK,
                 end = first + BLOCK < m->count ? first + BLOCK : m->count;
    if (interrupt_came())
        return interrupt_error();
    for (size_t i = first; i < end; i++) {
        struct place_of *place = &m->place[i - m->first];
        struct trace_point point;
        choose_point(m, i, &point);
        const struct vec3 p = trace_to_world(m->tracer, point.position),
                          n = vec3_normalize(to_double(point.normal));
        *place = (struct place_of){
            1 - (m->tracer->has_alpha ? trace_point_transparency(m->tracer, &point) : 0),
            trace_point_albedo(m->tracer, &point),
            {-1, -1}};
        if (place->share > 0)
            find_owners(m, p, n, place->owner);
    }
    return NULL;
}

/* -- what is summed --------------------------------------------------------------------------- */

struct sum {
    double share, albedo[3];
};

static void add_place(const struct place_of *place, struct sum *sum)
{
    for (int side = 0; side < 2; side++)
        if (place->owner[side] >= 0) {
            struct sum *of = &sum[place->owner[side]];
            const double share = (double)place->share;
            of->share += share;
            of->albedo[0] += share * (double)place->albedo.x;
            of->albedo[1] += share * (double)place->albedo.y;
            of->albedo[2] += share * (double)place->albedo.z;
        }
}

static struct error *measure_all(struct measuring *m, struct sum *sum)
{
    struct error *err = NULL;
    for (m->first = 0; m->first < m->count && !err; m->first += (size_t)BLOCK * BLOCKS) {
        const size_t left = m->count - m->first,
                     count = left < (size_t)BLOCK * BLOCKS ? left : (size_t)BLOCK * BLOCKS;
        err = threads_for(m->settings->threads, (count + BLOCK - 1) / BLOCK, measure_block, m);
        for (size_t i = 0; i < count && !err; i++)
            add_place(&m->place[i], sum);
    }
    return err;
}

/* The albedo of the surface that a point is at: just behind it. */
static struct vec3f albedo_behind(const struct tracer *tracer, const struct grid_point *point)
{
    double p[3];
    vec3_store(p, point->position);
    const struct tracer *near = trace_near(tracer, p);
    struct trace_rays rays;
    struct trace_points hit;
    wave_put(&rays.origin, 0, trace_to_local(near, p));
    wave_put(&rays.direction, 0, vec3f_scale(-1, point->normal));
    rays.most[0] = (float)((double)point->radius * near->scale);
    rays.salt[0] = 0;
    trace_rays_nearest(near, 1, &rays, &hit);
    return hit.hit[0] ? trace_albedo(near, &hit, 0) : (struct vec3f){0, 0, 0};
}

static void tell(const struct measuring *m, const struct sum *sum, struct patch *patch)
{
    for (size_t i = 0; i < m->grid.count; i++) {
        const struct sum *s = &sum[i];
        patch[i].area = (float)(s->share * m->step);
        if (s->share > 0)
            patch[i].albedo = (struct vec3f){(float)(s->albedo[0] / s->share),
                                             (float)(s->albedo[1] / s->share),
                                             (float)(s->albedo[2] / s->share)};
        else
            patch[i].albedo = albedo_behind(m->tracer, &m->grid.point[i]);
    }
}

static struct error *add_points(struct measuring *m, const struct poisson_point *point,
                                size_t count)
{
    double least = (double)INFINITY;
    for (size_t i = 0; i < count; i++)
        if (point[i].radius > 0) {
            least = fmin(least, (double)point[i].radius);
            m->most = fmax(m->most, (double)point[i].radius);
        }
    struct error *err = m->most > 0 ? point_grid_init(&m->grid, least, m->most)
                                    : error_new("no point has a radius above 0");
    for (size_t i = 0; i < count && !err; i++)
        err = point_grid_add(&m->grid, point[i].position, point[i].normal,
                             point[i].radius > 0 ? point[i].radius : (float)m->most);
    return err;
}

struct error *patches_measure(const struct tracer *tracer, const struct poisson_point *point,
                              size_t count, const struct patches_settings *settings,
                              struct patch *patch)
{
    struct exposed exposed;
    struct sum *sum = NULL;
    struct error *err = exposed_init(&exposed, tracer);
    struct random r = random_start(settings->seed, NAME - 1, 0);
    struct measuring m = {.tracer = tracer,
                          .exposed = &exposed,
                          .settings = settings,
                          .count = count * (size_t)settings->places,
                          .offset = random_double(&r)};
    m.step = exposed.area / (double)m.count;
    if (!err)
        err = add_points(&m, point, count);
    if (!err)
        err = array_create(&m.place, (size_t)BLOCK * BLOCKS, sizeof *m.place);
    if (!err)
        err = array_create(&sum, count, sizeof *sum);
    if (!err)
        err = measure_all(&m, sum);
    if (!err)
        tell(&m, sum, patch);
    free(sum);
    free(m.place);
    point_grid_clear(&m.grid);
    exposed_clear(&exposed);
    return err;
}
