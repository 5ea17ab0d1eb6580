/* SPDX-License-Identifier: Apache-2.0 */
#include "fit/least_squares.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* The residual at which a solution is done: below the rounding of a float. */
static const double DONE = 1e-8;

/* Steps that are never needed: the scaled elements of faces need some tens, with smoothness some
 * hundreds. */
enum { STEPS_MOST = 20000 };

/* A step along the free gradient that cannot go wrong: 1 / the largest eigenvalue. */
static const double FIXED_STEP = 1.0 / FIT_CORNERS;

void fit_element_add(struct fit_element *element, double scale, const double w[FIT_CORNERS])
{
    double *form = element->form;
    for (int i = 0; i < FIT_CORNERS; i++)
        for (int j = i; j < FIT_CORNERS; j++)
            *form++ += scale * (w[i] * w[j]);
}

struct error *fit_system_init(struct fit_system *system, const struct fit_element *element,
                              size_t elements, size_t unknowns)
{
    static const int diagonal[FIT_CORNERS] = {0, 4, 7, 9};
    *system = (struct fit_system){.element = element, .elements = elements, .unknowns = unknowns};
    struct error *err = array_create(&system->scale, 2 * unknowns, sizeof *system->scale);
    system->inverse = err ? NULL : system->scale + unknowns;
    for (size_t e = 0; e < elements && !err; e++)
        for (int i = 0; i < FIT_CORNERS; i++) {
            if (element[e].at[i] < 0 || (size_t)element[e].at[i] >= unknowns)
                return error_new("element %zu: expected one of %zu unknowns, got %d", e, unknowns,
                                 element[e].at[i]);
            system->scale[element[e].at[i]] += element[e].form[diagonal[i]];
        }
    for (size_t i = 0; i < unknowns && !err; i++) {
        system->inverse[i] = sqrt(system->scale[i]);
        system->scale[i] = system->scale[i] > 0 ? 1 / system->inverse[i] : 0;
    }
    return err;
}

void fit_system_clear(struct fit_system *system)
{
    free(system->scale);
    *system = (struct fit_system){0};
}

/* out = S A S in: S is the scale. */
static void apply(const struct fit_system *s, const double *in, double *out)
{
    for (size_t i = 0; i < s->unknowns; i++)
        out[i] = 0;
    for (size_t e = 0; e < s->elements; e++) {
        const struct fit_element *element = &s->element[e];
        const double *f = element->form;
        const size_t a = (size_t)element->at[0], b = (size_t)element->at[1],
                     c = (size_t)element->at[2], d = (size_t)element->at[3];
        const double x = s->scale[a] * in[a], y = s->scale[b] * in[b], z = s->scale[c] * in[c],
                     w = s->scale[d] * in[d];
        out[a] += f[0] * x + f[1] * y + f[2] * z + f[3] * w;
        out[b] += f[1] * x + f[4] * y + f[5] * z + f[6] * w;
        out[c] += f[2] * x + f[5] * y + f[7] * z + f[8] * w;
        out[d] += f[3] * x + f[6] * y + f[8] * z + f[9] * w;
    }
    for (size_t i = 0; i < s->unknowns; i++)
        out[i] *= s->scale[i];
}

static double dot(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

/* The state of a solution, in scaled unknowns y = x / scale. */
struct solution {
    const struct fit_system *system;
    double low, high;                          /* of x */
    double *y, *right, *gradient, *way, *turn; /* turn: the matrix times the way */
    double *room;                              /* what all of them are in; owned */
};

static double low_of(const struct solution *s, size_t i)
{
    return s->low * s->system->inverse[i];
}

static double high_of(const struct solution *s, size_t i)
{
    return s->high * s->system->inverse[i];
}

/* gradient = S A S y - S b */
static void find_gradient(struct solution *s)
{
    apply(s->system, s->y, s->gradient);
    for (size_t i = 0; i < s->system->unknowns; i++)
        s->gradient[i] -= s->right[i];
}

/* The gradient of an unknown that may move either way, and of one at a bound that wants to leave
 * it. */
static void part(const struct solution *s, size_t i, double *free_part, double *chopped)
{
    const double g = s->gradient[i];
    *free_part = *chopped = 0;
    if (!(s->system->scale[i] > 0))
        return;
    if (s->y[i] <= low_of(s, i))
        *chopped = g < 0 ? g : 0;
    else if (s->y[i] >= high_of(s, i))
        *chopped = g > 0 ? g : 0;
    else
        *free_part = g;
}

/* The squared lengths of both parts. */
static void find_parts(struct solution *s, double *free_square, double *chopped_square)
{
    *free_square = *chopped_square = 0;
    for (size_t i = 0; i < s->system->unknowns; i++) {
        double f, c;
        part(s, i, &f, &c);
        *free_square += f * f;
        *chopped_square += c * c;
    }
}

/* The way that goes along one of them: the free one, or where `leave` the other. */
static void set_way(struct solution *s, bool leave)
{
    for (size_t i = 0; i < s->system->unknowns; i++) {
        double f, c;
        part(s, i, &f, &c);
        s->way[i] = leave ? c : f;
    }
}

/* How far y - a way stays within the bounds. */
static double room_along(const struct solution *s)
{
    double most = INFINITY;
    for (size_t i = 0; i < s->system->unknowns; i++) {
        const double p = s->way[i];
        const double room = p > 0   ? (s->y[i] - low_of(s, i)) / p
                            : p < 0 ? (s->y[i] - high_of(s, i)) / p
                                    : INFINITY;
        most = room < most ? room : most;
    }
    return most;
}

/* y - step way, and no further than the bounds. */
static void go(struct solution *s, double step, const double *way)
{
    for (size_t i = 0; i < s->system->unknowns; i++) {
        if (!(s->system->scale[i] > 0))
            continue;
        const double y = s->y[i] - step * way[i], low = low_of(s, i), high = high_of(s, i);
        s->y[i] = y < low ? low : y > high ? high : y;
    }
}

/* One step of conjugate gradients, or to the first bound and along the free gradient from there. */
static void step_free(struct solution *s)
{
    const size_t n = s->system->unknowns;
    apply(s->system, s->way, s->turn);
    const double curve = dot(s->way, s->turn, n), most = room_along(s),
                 best = dot(s->gradient, s->way, n) / curve;
    if (best <= most) {
        go(s, best, s->way);
        for (size_t i = 0; i < n; i++)
            s->gradient[i] -= best * s->turn[i];
        double bend = 0;
        for (size_t i = 0; i < n; i++) {
            double f, c;
            part(s, i, &f, &c);
            bend += f * s->turn[i];
        }
        bend /= curve;
        for (size_t i = 0; i < n; i++) {
            double f, c;
            part(s, i, &f, &c);
            s->way[i] = f - bend * s->way[i];
        }
        return;
    }
    go(s, most, s->way);
    find_gradient(s);
    set_way(s, false);
    go(s, FIXED_STEP, s->way);
    find_gradient(s);
    set_way(s, false);
}

/* One step of those at bounds that want to leave them. */
static void step_off(struct solution *s)
{
    const size_t n = s->system->unknowns;
    set_way(s, true);
    apply(s->system, s->way, s->turn);
    const double best = dot(s->gradient, s->way, n) / dot(s->way, s->turn, n), most = room_along(s);
    go(s, best < most ? best : most, s->way);
    find_gradient(s);
    set_way(s, false);
}

static struct error *start(struct solution *s, const double *right, const double *x)
{
    const size_t n = s->system->unknowns;
    struct error *err = array_create(&s->room, 5 * n, sizeof *s->room);
    if (err)
        return err;
    s->y = s->room;
    s->right = s->y + n;
    s->gradient = s->right + n;
    s->way = s->gradient + n;
    s->turn = s->way + n;
    for (size_t i = 0; i < n; i++) {
        const double scale = s->system->scale[i];
        s->y[i] = scale > 0 ? x[i] * s->system->inverse[i] : 0;
        s->right[i] = scale * right[i];
    }
    find_gradient(s);
    set_way(s, false);
    return NULL;
}

struct error *fit_solve(const struct fit_system *system, const double *right, double low,
                        double high, double *x, struct fit_effort *effort)
{
    const size_t n = system->unknowns;
    struct solution s = {.system = system, .low = low, .high = high};
    double free_square = 0, chopped_square = 0;
    struct error *err = start(&s, right, x);
    const double size = err ? 0
                            : sqrt(dot(s.right, s.right, n)) + sqrt(dot(s.gradient, s.gradient, n));
    *effort = (struct fit_effort){0};
    for (; !err && effort->steps < STEPS_MOST; effort->steps++) {
        find_parts(&s, &free_square, &chopped_square);
        if (!(sqrt(free_square + chopped_square) > DONE * size))
            break;
        if (chopped_square <= free_square)
            step_free(&s);
        else
            step_off(&s);
    }
    effort->residual = size > 0 ? sqrt(free_square + chopped_square) / size : 0;
    for (size_t i = 0; i < n && !err; i++)
        if (system->scale[i] > 0) /* the bounds themselves, not what rounding makes of them */
            x[i] = s.y[i] <= low_of(&s, i)    ? low
                   : s.y[i] >= high_of(&s, i) ? high
                                              : system->scale[i] * s.y[i];
    free(s.room);
    return err;
}
