/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/candidates.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/progress.h"
#include "base/threads.h"
#include "capture/capture.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "math/random.h"
#include "math/vec.h"
#include "measure/ruler.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "trace/trace.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { TRIES = 64 }; /* points of the box for each free one that is wanted, at the most */
enum { JUDGES = 500, JUDGES_MOST = 2000, JUDGE_EVERY = 20 }; /* of space for each judge */
enum { SURFACE_EVERY = 3 };                                  /* of space for each near a surface */
enum { TRUTH_ORDER = 5 };               /* of SH: but for 7 % of that of one distant lamp */
enum { FOR_JUDGE = 0x61, FOR_SURFACE }; /* what random numbers are for: part of their name */

/* Rays of both halves, as shares of those that a probe will be captured with. What noise chosen
 * ones have is in the errors of all around them, and a quarter of their rays are those of the
 * capture itself. */
static const double JUDGE_RAYS = 4, CHOICE_RAYS = 0.5, PROBE_RAYS = 4;

/* Standard errors of judges' halves, in those of probes: there are many judges, and a few probes
 * are in the errors of all. */
static const double JUDGE_NOISE = 2.5;

/* Rays of a half, at the least: errors from more noise would be capped. */
enum { HALF_LEAST = 64, JUDGE_HALF_LEAST = 128 };

/* Of memory for each, with what two choices keep of it: measured. */
static const double BYTES = 1430;

/* Those near surfaces are this far off, as shares of the box's mean side. */
static const double OFF_LEAST = 0.004, OFF_MOST = 0.06;

/* -- the lists -------------------------------------------------------------------------------- */

static struct error *append(struct candidates *c, const double p[3], enum candidate_kind kind)
{
    struct error *err =
        array_reserve(&c->position, &c->room[0], c->count + 1, 3 * sizeof *c->position);
    if (!err)
        err = array_reserve(&c->kind, &c->room[1], c->count + 1, sizeof *c->kind);
    if (!err)
        err = array_reserve(&c->refined, &c->room[3], c->count + 1, sizeof *c->refined);
    if (!err)
        err = array_reserve(&c->capture, &c->room[4], c->count + 1, sizeof *c->capture);
    if (err)
        return error_wrap(err, "%zu points to choose probes from", c->count + 1);
    c->capture[c->count] = NULL;
    c->refined[c->count] = false;
    memcpy(c->position + 3 * c->count, p, 3 * sizeof *p);
    c->kind[c->count++] = (unsigned char)kind;
    c->space += kind == CANDIDATE_SPACE;
    c->judges += kind == CANDIDATE_JUDGE;
    return NULL;
}

struct error *candidates_give(struct candidates *c, const double position[3])
{
    return append(c, position, CANDIDATE_GIVEN);
}

void candidates_clear(struct candidates *c)
{
    free(c->position);
    free(c->kind);
    free(c->refined);
    for (size_t i = 0; c->capture && i < c->count; i++)
        free(c->capture[i]);
    free(c->capture);
    free(c->light);
    *c = (struct candidates){0};
}

/* -- in space --------------------------------------------------------------------------------- */

/* The i-th point of the even sequence, or of the random one. */
static void point_of(const struct candidates_job *job, enum candidate_kind kind, size_t i,
                     double p[3])
{
    /* 1 / g, 1 / g^2, 1 / g^3 of g^4 = g + 1 */
    static const double step[3] = {0.8191725133961644, 0.6710436067037892, 0.5497004779019702};
    struct random r =
        random_start(job->settings->seed, FOR_JUDGE, kind == CANDIDATE_JUDGE ? (uint32_t)i + 1 : 0);
    for (int k = 0; k < 3; k++) {
        double x = random_double(&r);
        if (kind == CANDIDATE_SPACE)
            x += (double)i * step[k];
        p[k] = job->space.low[k] + (job->space.high[k] - job->space.low[k]) * (x - floor(x));
    }
}

/* Adds so many of a kind, in the air; *tried: those of the sequence that were looked at. */
static struct error *spread(struct candidates *c, const struct candidates_job *job,
                            enum candidate_kind kind, size_t wanted, size_t *tried)
{
    const struct place_inside_settings settings = {
        .rays = job->inside_rays, .backface_share = job->backface_share, .threads = job->threads};
    const size_t most = TRIES * (wanted + 64);
    size_t found = 0, looked = 0;
    struct error *err = NULL;
    while (!err && found < wanted && looked < most && !interrupt_came()) {
        const size_t left = wanted - found, turn = left + left / 4 + 64;
        struct place place = {0};
        size_t *after = NULL; /* of each, how many of the sequence are used up with it */
        enum place_side *side = NULL;
        err = array_create(&place.position, 3 * turn, sizeof *place.position);
        if (!err)
            err = array_create(&after, turn, sizeof *after);
        if (!err)
            err = array_create(&side, turn, sizeof *side);
        for (size_t i = 0; i < TRIES * turn && place.count < turn && !err; i++) {
            double *p = place.position + 3 * place.count;
            point_of(job, kind, *tried + i, p);
            if (place_space_holds(&job->space, p))
                after[place.count++] = *tried + i + 1;
        }
        if (!err && !place.count)
            err = error_new("none of %zu points of the box is in the space that is asked for",
                            TRIES * turn);
        if (!err)
            err = place_inside(&place, job->path->tracer, &settings, side, job->warnings);
        err = error_wrap(err, "%zu points of the box", turn);
        size_t i = 0;
        for (; i < place.count && found < wanted && !err; i++)
            if (side[i] == PLACE_AIR) {
                err = append(c, place.position + 3 * i, kind);
                found++;
            }
        if (!err)
            *tried = after[i - 1];
        looked += i;
        free(side);
        free(after);
        place_clear(&place);
    }
    if (!err && found < wanted && !interrupt_came())
        err = error_new("%zu of %zu points of the box are in free space: --bounds says where it is",
                        found, looked);
    return err;
}

/* -- near surfaces ---------------------------------------------------------------------------- */

/* How far it is from p along d to where the space ends, and the inward normal there. */
static double way_out(const struct place_space *space, const double p[3], const double d[3],
                      struct vec3 *normal)
{
    double least = (double)INFINITY, inward[3] = {0};
    int axis = 0;
    for (int k = 0; k < 3; k++) {
        const double way = d[k] > 0   ? (space->high[k] - p[k]) / d[k]
                           : d[k] < 0 ? (space->low[k] - p[k]) / d[k]
                                      : (double)INFINITY;
        axis = way < least ? k : axis;
        least = fmin(least, way);
    }
    inward[axis] = d[axis] > 0 ? -1 : 1;
    *normal = vec3_load(inward);
    return least;
}

/* Goes from p along d to a surface or to where the space ends, and back to `off` before it or half
 * of the way. Returns whether there is one. */
static bool go(const struct candidates_job *job, double p[3], struct vec3 d, double off,
               struct vec3 *normal)
{
    double direction[3];
    vec3_store(direction, d);
    double way = way_out(&job->space, p, direction, normal);
    const struct trace_hit hit = trace_nearest(job->path->tracer, p, direction, way);
    if (hit.hit) {
        *normal = hit.front ? hit.normal : vec3_scale(-1, hit.normal);
        way = hit.distance;
    }
    if (!(way > 0 && way < (double)INFINITY))
        return false;
    const double slope = fmax(-vec3_dot(*normal, d), 0.1);
    const double back = fmin(off / slope, way / 2);
    vec3_store(p, vec3_fma(vec3_load(p), way - back, d));
    return true;
}

/* From a point of space to a wall, or where there is none to the end of the space; of those, every
 * second on along it to an edge; of those, every second to a corner. */
static struct error *add_near_surface(struct candidates *c, const struct candidates_job *job,
                                      size_t from, size_t number)
{
    const double *low = job->space.low, *high = job->space.high,
                 side = cbrt((high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]));
    struct random r = random_start(job->settings->seed, FOR_SURFACE, (uint32_t)number);
    const double z = 2 * random_double(&r) - 1, turn = 2 * ANGLE_PI * random_double(&r),
                 width = sqrt(1 - z * z), u = random_double(&r),
                 off = side * OFF_LEAST * exp2(u * u * log2(OFF_MOST / OFF_LEAST));
    const struct vec3 d = {width * angle_cos(turn), width * angle_sin(turn), z};
    struct vec3 wall, next;
    double p[3];
    memcpy(p, c->position + 3 * from, sizeof p);
    if (!go(job, p, d, off, &wall))
        return NULL;
    const struct vec3 along =
        vec3_normalize(vec3_fma(d, -vec3_dot(d, wall), wall)); /* in the wall's plane */
    if (number % 2 && vec3_length(along) > 0.5 && go(job, p, along, off, &next)) {
        struct vec3 edge = vec3_cross(wall, next);
        const bool corner = number % 4 == 3 && vec3_length(edge) > 0.1;
        edge = vec3_normalize(number % 8 > 3 ? edge : vec3_scale(-1, edge));
        if (corner)
            go(job, p, edge, off, &next);
    }
    return place_space_holds(&job->space, p) ? append(c, p, CANDIDATE_SURFACE) : NULL;
}

struct error *candidates_spread(struct candidates *c, const struct candidates_job *job,
                                size_t space)
{
    const size_t before = c->count, first = c->space;
    if (space <= first)
        return NULL;
    struct error *err = spread(c, job, CANDIDATE_SPACE, space - first, &c->space_tried);
    const size_t end = c->count, share = space / JUDGE_EVERY,
                 judges = share < JUDGES        ? JUDGES
                          : share > JUDGES_MOST ? JUDGES_MOST
                                                : share;
    if (!err && judges > c->judges)
        err = spread(c, job, CANDIDATE_JUDGE, judges - c->judges, &c->judges_tried);
    for (size_t i = before, number = first; i < end && !err; i++, number++)
        if (number % SURFACE_EVERY == 0)
            err = add_near_surface(c, job, i, number / SURFACE_EVERY);
    return err;
}

double candidates_memory(size_t space)
{
    return BYTES * (double)space * (1 + 1.0 / SURFACE_EVERY);
}

/* -- light ------------------------------------------------------------------------------------ */

struct tracing {
    const struct candidates *c;
    const struct candidates_job *job;
    struct capture_settings settings; /* order: of the truth */
    bool by_noise;                    /* of a list: its errors are asked for */
    struct sphere_basis probe, truth;
    const uint32_t *list; /* of candidates; NULL: those from `first` on */
    size_t first;
    unsigned char *done;
};

struct capture_settings candidates_settings(const struct candidates *c,
                                            const struct candidates_job *job)
{
    struct capture_settings settings = *job->settings;
    settings.error = c->noise;
    settings.error_floor = c->noise_floor;
    return settings;
}

static struct tracing tracing_of(const struct candidates *c, const struct candidates_job *job)
{
    const int order = job->settings->order;
    struct tracing t = {
        .c = c,
        .job = job,
        .settings = *job->settings,
        .first = c->captured,
        .probe = sphere_basis_make(order, false),
        .truth = sphere_basis_make(order > TRUTH_ORDER ? order : TRUTH_ORDER, false)};
    t.settings.order = t.truth.order;
    t.settings.columns = 0;
    t.settings.convolved = false;
    return t;
}

/* Whether a candidate is one that probes are made of, now or before. */
static bool is_probe(const struct tracing *t, size_t i)
{
    return t->c->kind[i] != CANDIDATE_JUDGE && (t->list || t->c->kind[i] == CANDIDATE_GIVEN);
}

static struct error *too_bright(void)
{
    return error_new("light is beyond what 32 bits can hold: --light-scale brings it down");
}

/* Of a half. */
static int rays_of(const struct tracing *t, size_t i, int half)
{
    const double rays = t->job->settings->rays;
    const bool judge = t->c->kind[i] == CANDIDATE_JUDGE;
    const int least = judge ? JUDGE_HALF_LEAST : HALF_LEAST;
    const double both = judge && !t->job->by_noise ? JUDGE_RAYS : CHOICE_RAYS;
    const double share = !is_probe(t, i) ? both / 2 : half ? PROBE_RAYS - 1 : 1;
    return (int)fmin(fmax(ceil(share * rays), least), CAPTURE_RAYS_MOST);
}

/* Luminance of a judge's irradiance along the directions, and what SH of the order hold of it: of
 * the highest nothing is known, so all. */
static struct error *look_at_judge(const struct tracing *t, const struct capture_probe *light,
                                   float *probe, float *truth)
{
    double value[SPHERE_COUNT], left[SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        value[d] = left[d] = luminance_f32(light->sh + 3 * d);
        if (!isfinite(value[d]))
            return too_bright();
    }
    sphere_cut_off(t->probe.order, left);
    for (int d = 0; d < SPHERE_COUNT; d++) {
        truth[d] = (float)value[d];
        probe[d] = (float)(t->probe.order > SPHERE_ORDER ? value[d] : value[d] - left[d]);
    }
    return NULL;
}

/* Luminance of irradiance along the directions. */
static struct error *look(const struct sphere_basis *basis, const struct capture_probe *light,
                          float *value)
{
    double c[SH_COUNT_MAX], e[SPHERE_COUNT];
    for (int i = 0; i < basis->order * basis->order; i++)
        c[i] = luminance_f32(light->sh + 3 * i);
    sphere_irradiance(basis, c, 1, e);
    for (int d = 0; d < SPHERE_COUNT; d++) {
        value[d] = (float)e[d];
        if (!isfinite(value[d]))
            return too_bright();
    }
    return NULL;
}

size_t candidates_capture_width(const struct candidates_job *job)
{
    return 6 * (size_t)(job->settings->order * job->settings->order) + 4;
}

/* Keeps what a capture found. */
static struct error *keep(const struct tracing *t, size_t i, const struct capture_probe *light)
{
    const size_t values = 3 * (size_t)(t->job->settings->order * t->job->settings->order);
    float **to = &t->c->capture[i];
    struct error *err = *to ? NULL
                            : array_create(to, candidates_capture_width(t->job), sizeof **to);
    if (err)
        return err;
    memcpy(*to, light->sh, values * sizeof **to);
    memcpy(*to + values, light->sh_error, values * sizeof **to);
    (*to)[2 * values] = light->validity;
    (*to)[2 * values + 1] = light->depth;
    (*to)[2 * values + 2] = light->sky;
    (*to)[2 * values + 3] = (float)light->rays;
    return NULL;
}

/* One half. The first of a probe is the capture itself where that has rays enough; else it is
 * traced beside. SH of a higher order have the same coefficients of the lower. */
static struct error *trace_half(const struct tracing *t, size_t i, int half,
                                struct capture_probe *light)
{
    const double *p = t->c->position + 3 * i;
    struct capture_settings settings = t->settings;
    const int rays = rays_of(t, i, half);
    const bool capture = is_probe(t, i) && !half;
    struct error *err = NULL;
    if (capture) {
        err = capture_probe(t->job->path, &settings, p, NULL, light);
        if (!err)
            err = keep(t, i, light);
        if (err || rays == settings.rays)
            return err;
    }
    settings.error *= JUDGE_NOISE;
    if (t->c->kind[i] == CANDIDATE_JUDGE) {
        settings.normal = sphere_direction[0];
        settings.normal_count = SPHERE_COUNT;
    }
    /* no --seed of a capture is as large, nor those of truths (truth.c) */
    settings.seed |= (uint64_t)(half + 2) << 60;
    settings.rays = rays;
    return capture_probe(t->job->path, &settings, p, NULL, light);
}

/* A probe where noise counts. Its truth stays, which has no random number in common with it. */
static struct error *trace_probe(const struct tracing *t, size_t i)
{
    struct capture_settings settings = t->settings;
    struct capture_probe light;
    settings.order = t->probe.order; /* of it noise is told */
    struct error *err =
        capture_probe(t->job->path, &settings, t->c->position + 3 * i, NULL, &light);
    if (!err)
        err = keep(t, i, &light);
    for (int half = 0; half < 2 && !err; half++)
        err = look(&t->probe, &light, t->c->light[i].probe[half]);
    return err;
}

static struct error *trace_halves(const struct tracing *t, size_t i)
{
    struct error *err = NULL;
    for (int half = 0; half < 2 && !err; half++) {
        struct capture_probe light;
        float *probe = t->c->light[i].probe[half], *truth = t->c->light[i].truth[half];
        err = trace_half(t, i, half, &light);
        if (!err && t->c->kind[i] == CANDIDATE_JUDGE)
            err = look_at_judge(t, &light, probe, truth);
        else if (!err) {
            err = look(&t->probe, &light, probe);
            if (!err)
                err = look(&t->truth, &light, truth);
        }
    }
    return err;
}

static struct error *trace_one(void *context, size_t index, int thread)
{
    (void)thread;
    struct tracing *t = context;
    const size_t i = t->list ? t->list[index] : t->first + index;
    const double *p = t->c->position + 3 * i;
    if (interrupt_came())
        return NULL;
    struct error *err = t->by_noise && is_probe(t, i) ? trace_probe(t, i) : trace_halves(t, i);
    if (err)
        return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
    t->done[index] = 1;
    progress_add(t->job->progress, 1);
    return NULL;
}

/* Takes out those that got no light; the first `kept` stay as they are. */
static void drop(struct candidates *c, const unsigned char *done)
{
    size_t to = c->captured;
    c->space = c->judges = 0;
    for (size_t i = 0; i < c->count; i++) {
        if (i >= c->captured && !done[i - c->captured]) {
            free(c->capture[i]);
            continue;
        }
        if (i >= c->captured) {
            memmove(c->position + 3 * to, c->position + 3 * i, 3 * sizeof *c->position);
            c->kind[to] = c->kind[i];
            c->capture[to] = c->capture[i];
            c->light[to++] = c->light[i];
        }
        c->space += c->kind[i] == CANDIDATE_SPACE;
        c->judges += c->kind[i] == CANDIDATE_JUDGE;
    }
    c->count = to;
}

static struct error *find_floor(struct candidates *c)
{
    float *mean = NULL;
    size_t n = 0;
    double white = 0;
    struct error *err = array_create(&mean, c->count, sizeof *mean);
    for (size_t i = 0; i < c->count && !err; i++) {
        double truth[SPHERE_COUNT];
        if (c->kind[i] != CANDIDATE_SPACE && c->kind[i] != CANDIDATE_JUDGE)
            continue;
        for (int d = 0; d < SPHERE_COUNT; d++)
            truth[d] = ((double)c->light[i].truth[0][d] + (double)c->light[i].truth[1][d]) / 2;
        mean[n++] = (float)fmax(sphere_mean(truth), 0);
    }
    if (!err)
        err = ruler_white(n, mean, &white);
    c->floor = RULER_FLOOR * white;
    free(mean);
    return err;
}

struct error *candidates_capture(struct candidates *c, const struct candidates_job *job)
{
    const size_t count = c->count - c->captured;
    struct tracing t = tracing_of(c, job);
    struct error *err = array_reserve(&c->light, &c->room[2], c->count, sizeof *c->light);
    if (!err)
        err = array_create(&t.done, count, sizeof *t.done);
    err = error_wrap(err, "the light of %zu points to choose probes from", c->count);
    if (!err)
        err = threads_for(job->threads, count, trace_one, &t);
    if (!err && interrupt_came())
        drop(c, t.done);
    for (size_t i = c->captured; i < c->count && !err; i++)
        c->refined[i] = c->kind[i] == CANDIDATE_GIVEN;
    if (!err)
        c->captured = c->count;
    if (!err)
        err = find_floor(c);
    free(t.done);
    return err;
}

void candidates_set_noise(struct candidates *c, double noise)
{
    c->noise = noise;
    c->noise_floor = c->floor;
    memset(c->refined, 0, c->count * sizeof *c->refined);
}

struct error *candidates_refine(struct candidates *c, const struct candidates_job *job,
                                size_t count, const uint32_t *probe)
{
    struct tracing t = tracing_of(c, job);
    uint32_t *list = NULL;
    size_t due = 0;
    t.by_noise = c->noise > 0;
    struct error *err = array_create(&list, count + c->judges, sizeof *list);
    if (!err)
        err = array_create(&t.done, count + c->judges, sizeof *t.done);
    for (size_t i = 0; i < count && !err; i++)
        if (!c->refined[probe[i]])
            list[due++] = probe[i];
    for (uint32_t x = 0; x < c->count && t.by_noise && !err; x++)
        if (c->kind[x] == CANDIDATE_JUDGE && !c->refined[x])
            list[due++] = x;
    t.list = list;
    if (t.by_noise) {
        t.settings.error = c->noise;
        t.settings.error_floor = c->noise_floor;
    }
    if (!err)
        err = threads_for(job->threads, due, trace_one, &t);
    for (size_t i = 0; i < due && !err; i++)
        c->refined[list[i]] = t.done[i];
    free(list);
    free(t.done);
    return err;
}
