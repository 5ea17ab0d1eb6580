/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds for probes along a way, which are asked by when they are there, not where (Tatarchuk,
 * "Irradiance volumes for games", GDC Europe, 2005: splines of light along a character's way). A
 * point is one number, in a column of the probes; its light is between that of the probes before
 * and behind. No cells are needed.
 *
 * Linear; or cubic: Hermite's polynomial, whose slopes at the probes are their gradients along the
 * way's velocity, as far as the light of both bears it (bound.h). The velocity is of the parabola
 * through three probes, or where the way turns a corner there, on each side that of the straight
 * line.
 */
#include "base/array.h"
#include "base/error.h"
#include "interpolate/bound.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "math/vec.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>

/* A probe; those of a way stand in the order of their numbers. */
struct stop {
    double t;
    int32_t probe;
    struct vec3 velocity[2]; /* by t, before it and behind it */
};

struct way {
    struct stop *stop; /* owned */
    size_t count;
    struct bound bound; /* of light, for the cubic */
};

static int compare_stops(const void *a, const void *b)
{
    const struct stop *x = a, *y = b;
    if (x->t != y->t)
        return x->t < y->t ? -1 : 1;
    return x->probe < y->probe ? -1 : 1;
}

static struct vec3 line_velocity(const struct interpolate *in, const struct stop *a)
{
    const double h = a[1].t - a[0].t;
    const struct vec3 way = vec3_sub(vec3_load(in->position + 3 * (size_t)a[1].probe),
                                     vec3_load(in->position + 3 * (size_t)a[0].probe));
    return vec3_scale(h > 0 ? 1 / h : 0, way);
}

/* Whether a way that goes on like this turns a corner: by more than 45 degrees, or at a halt. */
static bool is_corner(struct vec3 before, struct vec3 behind)
{
    return vec3_dot(before, behind) <= sqrt(0.5) * vec3_length(before) * vec3_length(behind);
}

static void find_velocities(const struct interpolate *in, struct way *way)
{
    struct stop *s = way->stop;
    for (size_t i = 0; i < way->count; i++) {
        if (i)
            s[i].velocity[0] = line_velocity(in, &s[i - 1]);
        if (i + 1 < way->count)
            s[i].velocity[1] = line_velocity(in, &s[i]);
    }
    for (size_t i = 1; i + 1 < way->count; i++) {
        const struct vec3 before = s[i].velocity[0], behind = s[i].velocity[1];
        if (is_corner(before, behind))
            continue;
        const double share = (s[i + 1].t - s[i].t) / (s[i + 1].t - s[i - 1].t);
        s[i].velocity[0] = s[i].velocity[1] =
            vec3_fma(vec3_scale(share, before), 1 - share, behind);
    }
    if (way->count > 2) { /* the parabolas go on to the ends */
        struct stop *last = s + way->count - 1;
        if (!is_corner(s[0].velocity[1], s[1].velocity[1]))
            s[0].velocity[1] = vec3_sub(vec3_scale(2, line_velocity(in, s)), s[1].velocity[0]);
        if (!is_corner(last->velocity[0], last[-1].velocity[0]))
            last->velocity[0] =
                vec3_sub(vec3_scale(2, line_velocity(in, last - 1)), last[-1].velocity[1]);
    }
}

static struct error *read_stops(const struct interpolate *in, struct way *way)
{
    const char *name = in->settings.along;
    const struct table *probes = stream_table(in->stream, "probe");
    const struct column *c = table_column(probes, name);
    if (!c)
        return error_new("the probes have no column %s: probe-place path writes time", name);
    if (c->width != 1 || c->type == COLUMN_I32)
        return error_new("column %s: expected one number a probe, f64 or f32", name);
    struct error *err = array_create(&way->stop, probes->rows, sizeof *way->stop);
    for (size_t i = 0; i < probes->rows && !err; i++) {
        const double t = c->type == COLUMN_F64 ? column_f64(c)[i] : (double)column_f32(c)[i];
        if (isnan(t))
            err = error_new("probe %zu has no %s", i, name);
        way->stop[way->count++] = (struct stop){.t = t, .probe = (int32_t)i};
    }
    return err;
}

static struct error *open_way(struct interpolate *in, size_t probes)
{
    struct way *way = NULL;
    struct error *err = array_create(&way, 1, sizeof *way);
    if (err)
        return err;
    in->own = way;
    if (in->order)
        bound_start(&way->bound, in->order, in->convolved);
    if (!probes)
        return error_new("there are no probes");
    err = read_stops(in, way);
    if (!err) {
        qsort(way->stop, way->count, sizeof *way->stop, compare_stops);
        find_velocities(in, way);
    }
    return err;
}

static void close_way(void *own)
{
    struct way *way = own;
    free(way->stop);
    free(way);
}

/* The last probe that is not behind t, of those that have another behind them. */
static size_t find_stop(const struct way *way, double t)
{
    size_t low = 0, high = way->count > 1 ? way->count - 1 : 1;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (way->stop[middle].t <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void find_in_way(const struct interpolate *in, const double t[3], struct probe_place *place)
{
    const struct way *way = in->own;
    const size_t last = way->count - 1, i = find_stop(way, *t), j = i < last ? i + 1 : i;
    const double h = way->stop[j].t - way->stop[i].t,
                 off = fmax(fmax(way->stop[0].t - *t, *t - way->stop[last].t), 0),
                 x = h > 0 ? fmin(fmax((*t - way->stop[i].t) / h, 0), 1) : 0;
    const int32_t a = way->stop[i].probe, b = way->stop[j].probe;
    *place = (struct probe_place){.cell = PROBE_COLD,
                                  .probe = {a, b, b, b},
                                  .weight = {1 - x, x, 0, 0},
                                  .inside = off == 0,
                                  .distance = off};
}

/* What the slope of one of two probes foretells for the other, less the light there: value k. */
static float foretell(const struct interpolate *in, const struct stop *const stop[2], int s,
                      size_t k)
{
    const size_t a = (size_t)stop[0]->probe, b = (size_t)stop[1]->probe,
                 of = (size_t)stop[s]->probe;
    const float *gradient = in->gradient + 3 * of * in->width + k;
    const struct vec3 g = {(double)gradient[0], (double)gradient[in->width],
                           (double)gradient[2 * in->width]};
    return (float)((stop[1]->t - stop[0]->t) * vec3_dot(g, stop[s]->velocity[1 - s])) -
           (in->value[b * in->width + k] - in->value[a * in->width + k]);
}

/* Each of them counts no more than the light of both, as a whole, and all take none below 0. */
static void add_light(const struct interpolate *in, const struct stop *const stop[2],
                      const float weight[2], float *out)
{
    const struct bound *bound = &((const struct way *)in->own)->bound;
    float all[3 * SH_COUNT_MAX] = {0}, more[3 * SH_COUNT_MAX], size = 0, share[3];
    for (int s = 0; s < 2; s++)
        size += bound_size(bound, in->value + in->width * (size_t)stop[s]->probe);
    for (int s = 0; s < 2; s++) {
        for (size_t k = 0; k < in->width; k++)
            more[k] = foretell(in, stop, s, k);
        const float part = weight[s] * bound_part(bound_size(bound, more), size);
        for (size_t k = 0; k < in->width; k++)
            all[k] += part * more[k];
    }
    bound_shares(bound, out, all, share);
    for (size_t k = 0; k < in->width; k++)
        out[k] += share[k % 3] * all[k];
}

/* Values that are not light: one by one. */
static void add_values(const struct interpolate *in, const struct stop *const stop[2],
                       const float weight[2], float *out)
{
    for (size_t k = 0; k < in->width; k++) {
        const float size = fabsf(in->value[in->width * (size_t)stop[0]->probe + k]) +
                           fabsf(in->value[in->width * (size_t)stop[1]->probe + k]);
        float all = 0;
        for (int s = 0; s < 2; s++) {
            const float more = foretell(in, stop, s, k);
            all += weight[s] * more * bound_part(fabsf(more), size);
        }
        out[k] += fmaxf(all, -fabsf(out[k]));
    }
}

/* Hermite's polynomial is the line and what slopes foretell beyond it. */
static struct error *cubic_at(const struct interpolate *in, const double t[3],
                              const struct probe_place *place, float *out)
{
    const struct way *way = in->own;
    const size_t i = find_stop(way, *t), j = i + 1 < way->count ? i + 1 : i;
    const struct stop *const stop[2] = {&way->stop[i], &way->stop[j]};
    const double x = place->weight[1], y = place->weight[0];
    const float weight[2] = {(float)(x * y * y), (float)(-x * x * y)};
    struct error *err = interpolate_missing(in, place);
    if (err)
        return err;
    probe_blend(place, in->value, in->width, out);
    if (!(x > 0 && y > 0)) /* at a probe, which alone has a say */
        return NULL;
    if (in->order)
        add_light(in, stop, weight, out);
    else
        add_values(in, stop, weight, out);
    return NULL;
}

void interpolate_along_position(const struct interpolate *in, const struct probe_place *place,
                                double position[3])
{
    for (size_t k = 0; k < 3; k++) {
        position[k] = 0;
        for (int i = 0; i < 2; i++)
            position[k] += place->weight[i] * in->position[3 * (size_t)place->probe[i] + k];
    }
}

const struct interpolate_kind interpolate_along_linear = {
    .name = "barycentric", .open = open_way, .close = close_way, .find = find_in_way};
const struct interpolate_kind interpolate_along_cubic = {.name = "cubic",
                                                         .needs_gradients = true,
                                                         .open = open_way,
                                                         .close = close_way,
                                                         .find = find_in_way,
                                                         .at = cubic_at};
