/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Bikker, Reijerse, "A precalculated point set for caching shading information",
 * Eurographics short papers, 2009. Ward, Heckbert, "Irradiance gradients", 3rd Eurographics
 * workshop on rendering, 1992.
 */
#include "place/poisson.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/threads.h"
#include "math/direction.h"
#include "math/power.h"
#include "place/exposed.h"
#include "place/point_grid.h"
#include "scene/scene.h"
#include "trace/particles.h"
#include "trace/path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    THROWS = 12,            /* darts that each point throws */
    BATCH_LEAST = 256,      /* darts that are judged at a time: half as many as there are points, */
    BATCH_MOST = 8192,      /* so that few of them are in each other's way */
    BLOCK = PATH_WAVE,      /* darts that a thread takes */
    PARTICLES_LEAST = 1024, /* of the first round; each next has twice as many */
    MISSED = 16,            /* one hit for as many particles says that most miss the scene */
};

/* Cosine of the angle up to which two surfaces face alike. */
#define ALIKE 0.5f

struct dart {
    struct vec3 position;
    struct vec3f normal;
    bool landed;
    float left;   /* share of a particle's light that gets there, after the surfaces on the way */
    float albedo; /* of the surface there */
};

/* What is known of a dart. */
struct verdict {
    float radius, ao;
    bool keep; /* as far as the points before its batch are concerned */
    bool tested;
};

/* What else is known of a point. */
struct told {
    float ao;
    float left; /* share of a particle's light that goes on from there */
};

struct throwing {
    const struct path_tracer *path;
    const struct poisson_settings *settings;
    struct point_grid grid;
    struct told *told; /* of the grid's points; owned, and so is what follows */
    size_t told_capacity;
    struct particles particles; /* of this round */
    struct dart *dart;          /* of this batch */
    struct verdict *verdict;
    float far;                          /* local: at most as far as a particle came to a surface */
    size_t stride, round, first, count; /* of the batch */
    bool by_points;                     /* it is of those that points throw: */
    size_t thrown;                      /* of them, until there */
};

/* Steps of about the golden section of `count` that come to each number below it once. */
static size_t stride_of(size_t count)
{
    size_t stride = (size_t)(0.618034 * (double)count) | 1;
    for (;; stride++) {
        size_t a = count, b = stride;
        while (b) {
            const size_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1)
            return stride;
    }
}

/* -- what stands where ------------------------------------------------------------------------ */

static bool alike(struct vec3f a, struct vec3f b)
{
    return vec3f_dot(a, b) > ALIKE;
}

/* The nearest point whose disc is in the way of one at a place: how far it is. */
struct blocker {
    const struct point_grid *grid;
    struct vec3 p;
    struct vec3f n;
    double least, square;
};

static void look_for_blocker(void *context, size_t i)
{
    struct blocker *b = context;
    const struct grid_point *point = &b->grid->point[i];
    const struct vec3 way = vec3_sub(b->p, point->position);
    const double square = vec3_dot(way, way), radius = (double)point->radius;
    if (!(square < b->square) || !alike(point->normal, b->n))
        return;
    const struct vec3 n = {(double)point->normal.x, (double)point->normal.y,
                           (double)point->normal.z};
    const bool reaches = square < 4 * radius * radius && fabs(vec3_dot(way, n)) <= radius / 2;
    if (square < b->least * b->least)
        b->square = 0; /* that is enough */
    else if (reaches)
        b->square = square;
}

/* Infinity: none within the greatest radius. */
static double blocker_distance(const struct throwing *t, struct vec3 p, struct vec3f n)
{
    const double most = t->settings->most;
    struct blocker b = {&t->grid, p, n, t->settings->least, most * most};
    point_grid_near(&t->grid, p, &b.square, true, look_for_blocker, &b);
    return b.square < most * most ? sqrt(b.square) : (double)INFINITY;
}

static float round_down(double x)
{
    const float f = (float)x;
    return (double)f > x ? nextafterf(f, 0) : f;
}

/* A point that comes. */
struct newcomer {
    struct point_grid *grid;
    struct vec3 p;
    struct vec3f n;
    double least;  /* what is nearer is a twin, which kept points may have: it changes no radius */
    double square; /* of the distance to the nearest that faces alike, or of its radius */
};

/* Makes the radii of those that face alike no more than its distance. */
static void shrink_one(void *context, size_t i)
{
    const struct newcomer *c = context;
    struct grid_point *point = &c->grid->point[i];
    const double distance = vec3_length(vec3_sub(c->p, point->position));
    if (distance < (double)point->radius && distance > c->least && alike(point->normal, c->n))
        point->radius = round_down(distance);
}

static void find_nearest(void *context, size_t i)
{
    struct newcomer *c = context;
    const struct grid_point *point = &c->grid->point[i];
    const struct vec3 way = vec3_sub(c->p, point->position);
    const double square = vec3_dot(way, way);
    if (square < c->square && square > c->least * c->least && alike(point->normal, c->n))
        c->square = square;
}

static struct error *keep(struct throwing *t, const struct dart *dart, const struct verdict *v)
{
    const double most = t->settings->most * t->settings->most, radius = (double)v->radius;
    struct newcomer c = {&t->grid, dart->position, dart->normal, t->settings->least / 2,
                         radius * radius};
    point_grid_near(&t->grid, c.p, &most, true, shrink_one, &c);
    point_grid_near(&t->grid, c.p, &c.square, false, find_nearest, &c);
    struct error *err =
        array_reserve(&t->told, &t->told_capacity, t->grid.count + 1, sizeof *t->told);
    if (err)
        return err;
    t->told[t->grid.count] = (struct told){v->ao, dart->left * dart->albedo};
    return point_grid_add(&t->grid, dart->position, dart->normal, round_down(sqrt(c.square)));
}

/* -- occlusion -------------------------------------------------------------------------------- */

/* Rays by the cosine about a normal: a grid of cells, one ray in each. */
struct hemisphere {
    const struct tracer *tracer;
    struct vec3f start, normal;
    struct random random;
    int rows, columns, stride;
    int asked, open; /* rays until now; those that met nothing within the distance */
    float most;      /* local */
    float distance[POISSON_RAYS_MOST]; /* by row and column; where it is looked for */
};

static void hemisphere_at(const struct throwing *t, const struct dart *dart, struct hemisphere *h)
{
    const struct poisson_settings *s = t->settings;
    double p[3];
    vec3_store(p, dart->position);
    h->tracer = trace_near(t->path->tracer, p);
    h->start = trace_to_local(h->tracer, p);
    h->normal = dart->normal;
    h->random = random_start(s->seed, random_hash_position(p), 1);
    h->rows = (int)sqrt((double)s->rays);
    h->columns = s->rays / h->rows;
    h->stride = (int)stride_of((size_t)(h->rows * h->columns));
    h->asked = h->open = 0;
    h->most = (float)fmin(s->distance * h->tracer->scale, (double)FLT_MAX);
}

/* Asks `count` cells more, in an order that spreads them; distances: how far each sees. */
static void ask(struct hemisphere *h, int count, bool distances)
{
    const int all = h->rows * h->columns;
    struct trace_rays rays;
    struct trace_points points;
    int32_t seen[PATH_WAVE];
    int cell[PATH_WAVE];
    if (count > all - h->asked)
        count = all - h->asked;
    if (count <= 0)
        return;
    for (int i = 0; i < count; i++) {
        cell[i] = (h->asked + i) * h->stride % all;
        const int row = cell[i] / h->columns, column = cell[i] % h->columns;
        const float u = ((float)row + random_float(&h->random)) / (float)h->rows,
                    turn = ((float)column + random_float(&h->random)) / (float)h->columns;
        wave_put(&rays.origin, (size_t)i, h->start);
        wave_put(&rays.direction, (size_t)i, direction_by_cosine(h->normal, u, turn));
        rays.most[i] = h->most;
        rays.salt[i] = h->tracer->has_alpha ? random_u32(&h->random) : 0;
        seen[i] = 1;
    }
    if (distances)
        trace_rays_nearest(h->tracer, (size_t)count, &rays, &points);
    else
        trace_rays_occluded(h->tracer, (size_t)count, &rays, seen);
    for (int i = 0; i < count; i++) {
        const bool open = distances ? !points.hit[i] : seen[i];
        h->open += open;
        if (distances)
            h->distance[cell[i]] = open ? INFINITY : points.distance[i];
    }
    h->asked += count;
}

static bool is_open(float distance)
{
    return distance > FLT_MAX;
}

/* Length of the change of the open share along the surface, times the distance within which
 * occlusion counts: Ward and Heckbert 1992, with 1 and 0 for what is open and what is not. */
static double open_gradient(const struct hemisphere *h)
{
    struct vec3f sum = {0};
    const float columns = (float)h->columns, rows = (float)h->rows;
    for (int k = 0; k < h->columns; k++) {
        const int before = k ? k - 1 : h->columns - 1;
        float out = 0, across = 0;
        for (int j = 0; j < h->rows; j++) {
            const float here = h->distance[j * h->columns + k],
                        beside = h->distance[j * h->columns + before], open = is_open(here),
                        sine = sqrtf((float)j / rows), next = sqrtf((float)(j + 1) / rows);
            if (j) {
                const float within = h->distance[(j - 1) * h->columns + k],
                            change = open - (float)is_open(within);
                if (change < 0 || change > 0)
                    out += sine * (1 - sine * sine) / float_least(here, within) * change;
            }
            const float change = open - (float)is_open(beside);
            if (change < 0 || change > 0)
                across += (next - sine) / float_least(here, beside) * change;
        }
        const struct vec3f u = direction_by_cosine(h->normal, 1, ((float)k + 0.5f) / columns),
                           edge = direction_by_cosine(h->normal, 1, (float)k / columns),
                           v = vec3f_cross(h->normal, edge);
        sum = vec3f_add(sum, vec3f_add(vec3f_scale(2 * (float)ANGLE_PI / columns * out, u),
                                       vec3f_scale(across, v)));
    }
    return (double)vec3f_length(sum) / ANGLE_PI * (double)h->most;
}

/* Share of the distance that is seen in the harmonic mean; 1 at the most. */
static double seen_depth(const struct hemisphere *h)
{
    const int all = h->rows * h->columns;
    double sum = 0;
    for (int i = 0; i < all; i++)
        sum += is_open(h->distance[i]) ? 0 : (double)h->most / (double)h->distance[i];
    return fmin(1, all / sum);
}

/* The radius where the open share is that. */
static double radius_of_share(const struct poisson_settings *s, double open)
{
    return s->least + (s->most - s->least) * open;
}

/* Where little of a particle's light gets to, points are farther apart: they have little to say.
 * The eighth root: with the fourth, and without, Sponza's light has more error at as many points.
 */
static double dim_radius(const struct poisson_settings *s, double radius, float left)
{
    return fmin(radius / (double)sqrtf(sqrtf(sqrtf(left))), s->most);
}

/* Asks all cells, and what steers for the radius. */
static void look_around(const struct throwing *t, struct hemisphere *h, struct verdict *v)
{
    const struct poisson_settings *s = t->settings;
    const bool distances = s->steer == POISSON_GRADIENT || s->steer == POISSON_DEPTH;
    while (h->asked < h->rows * h->columns)
        ask(h, PATH_WAVE, distances);
    const double open = (double)h->open / (h->rows * h->columns);
    double radius = s->most;
    if (s->steer == POISSON_AO)
        radius = radius_of_share(s, open);
    else if (s->steer == POISSON_GRADIENT)
        radius = s->most * fmin(1, 0.25 / open_gradient(h));
    else if (s->steer == POISSON_DEPTH)
        radius = s->most * seen_depth(h);
    v->ao = (float)open;
    v->radius = round_down(fmax(radius, s->least));
}

/* Whether the radius is very likely more than the distance of who is in the way, after some of the
 * rays: at the lower end of the open share that these tell. If not, another dart will tell. */
static bool is_hopeless(const struct poisson_settings *s, const struct hemisphere *h,
                        double distance, float left)
{
    if (s->steer != POISSON_AO)
        return s->steer == POISSON_NONE;
    const double share = (h->open + 0.5) / (h->asked + 1);
    const double least = share - 1.5 * sqrt(share * (1 - share) / (h->asked + 1));
    return dim_radius(s, radius_of_share(s, least), left) > distance;
}

static void judge(const struct throwing *t, const struct dart *dart, struct verdict *v)
{
    enum { SOME = 8 };
    struct hemisphere h;
    *v = (struct verdict){0};
    if (!dart->landed)
        return;
    const double distance = blocker_distance(t, dart->position, dart->normal);
    if (distance < dim_radius(t->settings, t->settings->least, dart->left))
        return;
    hemisphere_at(t, dart, &h);
    if (!isinf(distance)) {
        v->tested = true;
        do {
            if (t->settings->steer == POISSON_AO)
                ask(&h, SOME, false);
            if (is_hopeless(t->settings, &h, distance, dart->left))
                return;
        } while (t->settings->steer == POISSON_AO && h.asked < h.rows * h.columns);
    }
    look_around(t, &h, v);
    v->radius = round_down(dim_radius(t->settings, (double)v->radius, dart->left));
    v->keep = (double)v->radius <= distance;
}

/* -- darts ------------------------------------------------------------------------------------ */

static struct dart dart_at(const struct tracer *tracer, struct vec3f position, float distance,
                           struct vec3f normal, float left, float albedo)
{
    const struct vec3f start = trace_leave(position, distance, normal);
    /* no zero of the normal is negative */
    const struct vec3f n = vec3f_add(normal, (struct vec3f){0, 0, 0});
    return (struct dart){trace_to_world(tracer, start), n, true, left, albedo};
}

/* The greatest share of any colour that the surface at an arrival sends on. */
static float albedo_at(const struct tracer *tracer, const struct particle_hit *hit)
{
    struct trace_point point;
    trace_point_at(tracer, hit->instance, hit->triangle, hit->b, hit->c, &point);
    return vec3f_most(trace_point_albedo(tracer, &point));
}

/* The i-th dart of the round: where a particle arrived, in an order that spreads them over the
 * lights. */
static struct dart dart_of_particle(const struct throwing *t, size_t i)
{
    const struct tracer *tracer = t->path->tracer;
    const struct particle_hit *hit = &t->particles.hit[i * t->stride % t->particles.count];
    return dart_at(tracer, hit->position, t->far, hit->normal, 1, albedo_at(tracer, hit));
}

/* Darts that points throw, one after the other, by the cosine. */
struct throw
{
    size_t count;
    size_t dart[BLOCK]; /* of the batch */
    struct trace_rays rays;
    struct trace_points points;
};

static void add_throw(const struct throwing *t, size_t i, size_t dart, struct throw *w)
{
    const struct tracer *tracer = t->path->tracer;
    const size_t from = i / THROWS;
    const struct grid_point *point = &t->grid.point[from];
    if (!(t->told[from].left > 0))
        return;
    struct random r = random_start(t->settings->seed, UINT64_C(0x6461727400000000) + from,
                                   (uint32_t)(i % THROWS));
    double p[3];
    vec3_store(p, point->position);
    const float u = random_float(&r), turn = random_float(&r);
    wave_put(&w->rays.origin, w->count, trace_to_local(tracer, p));
    wave_put(&w->rays.direction, w->count, direction_by_cosine(point->normal, u, turn));
    w->rays.most[w->count] = INFINITY;
    w->rays.salt[w->count] = tracer->has_alpha ? random_u32(&r) : 0;
    w->dart[w->count++] = dart;
}

static void land(const struct throwing *t, struct throw *w)
{
    const struct tracer *tracer = t->path->tracer;
    trace_rays_nearest(tracer, w->count, &w->rays, &w->points);
    for (size_t k = 0; k < w->count; k++)
        if (w->points.hit[k])
            t->dart[w->dart[k]] = dart_at(
                tracer, wave_get(&w->points.position, k), w->points.distance[k],
                vec3f_scale(w->points.front[k] ? 1.0f : -1.0f, wave_get(&w->points.normal, k)),
                t->told[(t->thrown + w->dart[k]) / THROWS].left,
                vec3f_most(trace_albedo(tracer, &w->points, k)));
}

/* Makes darts of the batch, `count` from its i-th on: of the round's arrivals or thrown ones. */
static void make_darts(const struct throwing *t, size_t first, size_t count)
{
    struct throw w;
    w.count = 0;
    for (size_t k = first; k < first + count; k++) {
        t->dart[k] = (struct dart){0};
        if (t->by_points)
            add_throw(t, t->thrown + k, k, &w);
        else
            t->dart[k] = dart_of_particle(t, t->first + k);
    }
    if (w.count)
        land(t, &w);
}

static struct error *throw_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct throwing *t = context;
    const size_t first = block * BLOCK, left = t->count - first,
                 count = left < BLOCK ? left : BLOCK;
    if (interrupt_came())
        return interrupt_error();
    make_darts(t, first, count);
    for (size_t i = first; i < first + count; i++)
        judge(t, &t->dart[i], &t->verdict[i]);
    return NULL;
}

/* Throws a batch, and keeps those that are not in each other's way either. */
static struct error *throw_batch(struct throwing *t, struct poisson *set, size_t *kept)
{
    struct error *err =
        threads_for(t->settings->threads, (t->count + BLOCK - 1) / BLOCK, throw_block, t);
    for (size_t i = 0; i < t->count && !err; i++) {
        const struct dart *dart = &t->dart[i];
        const struct verdict *v = &t->verdict[i];
        set->darts += dart->landed;
        set->tested += v->tested;
        if (!v->keep || blocker_distance(t, dart->position, dart->normal) < (double)v->radius)
            continue;
        if (t->grid.count >= t->settings->points_most) {
            set->full = true;
            break;
        }
        err = keep(t, dart, v);
        ++*kept;
    }
    return err;
}

/* -- rounds ----------------------------------------------------------------------------------- */

/* How the last darts fared that particles left, as many as there are points. */
struct window {
    size_t darts, kept;
};

/* As many darts as go together. */
static size_t batch_of(const struct throwing *t, size_t left)
{
    const size_t half = t->grid.count / 2, least = half < BATCH_LEAST ? BATCH_LEAST : half,
                 batch = least < BATCH_MOST ? least : BATCH_MOST;
    return batch < left ? batch : left;
}

/* Throws the darts that a round of particles left, and all that points throw, those of points that
 * this brings as well: wherever there is room, it is filled at once, however little of it is seen
 * from elsewhere. */
static struct error *throw_round(struct throwing *t, struct poisson *set, struct window *last)
{
    struct error *err = NULL;
    t->by_points = false;
    t->stride = t->particles.count ? stride_of(t->particles.count) : 1;
    for (t->first = 0; t->first < t->particles.count && !err && !set->full; t->first += t->count) {
        const size_t before = set->darts;
        t->count = batch_of(t, t->particles.count - t->first);
        err = throw_batch(t, set, &last->kept);
        last->darts += set->darts - before;
    }
    t->by_points = true;
    for (; t->thrown < THROWS * t->grid.count && !err && !set->full; t->thrown += t->count) {
        size_t kept = 0;
        t->count = batch_of(t, THROWS * t->grid.count - t->thrown);
        err = throw_batch(t, set, &kept);
    }
    return err;
}

static void throwing_clear(struct throwing *t)
{
    point_grid_clear(&t->grid);
    particles_clear(&t->particles);
    free(t->told);
    free(t->dart);
    free(t->verdict);
}

/* Takes the points out. */
static struct error *take_points(struct throwing *t, struct poisson *set)
{
    free(set->point);
    struct error *err = array_create(&set->point, t->grid.count, sizeof *set->point);
    set->count = err ? 0 : t->grid.count;
    for (size_t i = 0; i < set->count; i++) {
        const struct grid_point *p = &t->grid.point[i];
        set->point[i] = (struct poisson_point){p->position, p->normal, p->radius, t->told[i].ao};
    }
    return err;
}

static struct error *nothing_lit(size_t sent)
{
    if (!sent)
        return error_new("no light gets to any surface: --sky, --sun, --point and --spot add "
                         "light");
    return error_new("none of %zu particles of light gets to a surface: all of it is in the dark, "
                     "or fills too little of the scene's box",
                     sent);
}

/* A round of particles. In a scene that is small in its box, where they miss it, its surface looks
 * for suns and the sky as well. */
static struct error *trace_particles(struct throwing *t, const struct exposed *exposed,
                                     size_t count)
{
    const struct path_tracer *path = t->path;
    const struct particles_settings of = {.count = count,
                                          .bounces = t->settings->bounces,
                                          .even = 0.5,
                                          .seed = t->settings->seed +
                                                  0x9e3779b97f4a7c15 * (uint64_t)t->round,
                                          .threads = t->settings->threads};
    particles_clear(&t->particles);
    struct error *err =
        particles_trace(path->tracer, &path->lights, &path->sky, &of, &t->particles);
    if (!err && t->particles.count < t->particles.sent / MISSED)
        err = exposed_add(exposed, count, of.seed, &t->particles);
    return err;
}

/* Puts the points that stay before all others. They throw no darts: nobody tells how much light
 * gets there, and where it is little, finer points would fill what they cover. */
static struct error *keep_given(struct throwing *t)
{
    struct error *err = NULL;
    for (size_t i = 0; i < t->settings->kept_count && !err; i++) {
        const struct poisson_point *p = &t->settings->kept[i];
        const struct dart dart = {p->position, p->normal, true, 0, 0};
        const float most = round_down(t->settings->most);
        err =
            keep(t, &dart, &(struct verdict){p->radius < most ? p->radius : most, p->ao, true, 0});
    }
    return err;
}

/* exposed: of the tracer's scene. */
static struct error *make(struct poisson *set, const struct path_tracer *path,
                          const struct exposed *exposed, const struct poisson_settings *settings)
{
    const struct tracer *tracer = path->tracer;
    struct throwing t = {.path = path, .settings = settings, .far = 4 * (float)tracer->extent};
    struct window last = {0};
    bool done = false;
    int particles = PARTICLES_LEAST;
    size_t sent = 0;
    struct error *err = point_grid_init(&t.grid, settings->least, settings->most);
    if (!err)
        err = array_create(&t.dart, BATCH_MOST, sizeof *t.dart);
    if (!err)
        err = array_create(&t.verdict, BATCH_MOST, sizeof *t.verdict);
    if (!err)
        err = keep_given(&t);
    set->darts = set->tested = 0;
    set->full = false;
    set->least = settings->least;
    set->most = settings->most;
    set->tries++;
    for (t.round = 0; !err && !done && !set->full; t.round++) {
        err = trace_particles(
            &t, exposed,
            (size_t)(particles < settings->particles ? particles : settings->particles));
        if (!err)
            err = throw_round(&t, set, &last);
        sent += t.particles.sent;
        if (!err && !set->darts && t.round == 3)
            err = nothing_lit(sent);
        if (last.darts >= 1000 && last.darts >= t.grid.count) {
            done = last.kept * (size_t)settings->misses <= last.darts;
            last = (struct window){0};
        }
        particles *= particles < settings->particles ? 2 : 1;
    }
    if (!err)
        err = take_points(&t, set);
    throwing_clear(&t);
    return err;
}

struct error *poisson_make(struct poisson *set, const struct path_tracer *path,
                           const struct poisson_settings *settings)
{
    struct exposed exposed;
    struct error *err = exposed_init(&exposed, path->tracer);
    if (!err)
        err = make(set, path, &exposed, settings);
    exposed_clear(&exposed);
    return err;
}

/* What is known of how many points a greatest radius makes. */
struct search {
    double wanted;
    double few, many;     /* radii that make at most as many, and more; 0: not known */
    double few_n, many_n; /* how many; many_n 0: more than were counted */
};

/* The next radius to try: by the power of radii that numbers go with, between those that are known;
 * at first on the side of few, where it costs little. */
static double next_radius(const struct search *s, bool pilot)
{
    const double to = pilot ? s->wanted / 2 : 0.985 * s->wanted;
    if (!(s->few > 0))
        return 1.3 * s->many;
    double power = 0.5;
    if (s->few > 0 && s->many > 0 && s->many_n > 0)
        power = power_log(s->few / s->many) / power_log(s->many_n / s->few_n);
    const double next = s->few * power_of(s->few_n / to, power);
    const double between = sqrt(s->few * s->many);
    return s->many > 0 && (next <= 1.005 * s->many || !(s->many_n > 0)) ? between : next;
}

struct error *poisson_make_count(struct poisson *set, const struct path_tracer *path,
                                 const struct poisson_settings *settings, size_t count)
{
    enum { TRIES = 10, PILOT = 400 };
    const double ratio = settings->most / settings->least;
    struct poisson best = {0};
    struct exposed exposed;
    struct error *err = exposed_init(&exposed, path->tracer);
    const size_t kept = settings->kept_count;
    struct search search = {.wanted = (double)(count - kept)};
    bool pilot = count > PILOT && !kept;
    double most = sqrt(2 * exposed.area / (pilot ? search.wanted / 16 : (double)count));
    for (int i = 0; i < TRIES && !err; i++) {
        struct poisson_settings s = *settings;
        s.most = most;
        s.least = most / ratio;
        s.points_most = count + count / 32 + 1;
        err = make(set, path, &exposed, &s);
        if (err)
            break;
        const double n = kept ? fmax((double)(set->count - kept), search.wanted / 16)
                              : (double)set->count;
        if (set->count > count) {
            search.many = most;
            search.many_n = set->full ? 0 : n;
        } else {
            search.few = most;
            search.few_n = n;
        }
        if (set->count <= count && set->count > best.count) {
            const struct poisson other = best;
            best = *set;
            *set = (struct poisson){.point = other.point, .tries = best.tries};
        }
        if (n <= search.wanted &&
            (n >= 0.97 * search.wanted || (search.many > 0 && search.few < 1.01 * search.many)))
            break;
        pilot = n < search.wanted / 3 && count > PILOT && !kept && !(search.many > 0);
        most = next_radius(&search, pilot);
    }
    exposed_clear(&exposed);
    if (!err && !best.count)
        err = error_new("no radius makes %zu points or fewer", count);
    best.tries = set->tries;
    poisson_clear(set);
    if (err)
        poisson_clear(&best);
    else
        *set = best;
    return err;
}

void poisson_clear(struct poisson *set)
{
    free(set->point);
    *set = (struct poisson){0};
}
