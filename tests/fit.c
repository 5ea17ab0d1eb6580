/* SPDX-License-Identifier: Apache-2.0 */
/* Least squares at vertices: what is linear on each face comes back exactly, the result satisfies
 * the normal equations, or within bounds what takes their place, and is never worse than where it
 * began. */
#include "fit/fit_surface.h"
#include "fit/least_squares.h"
#include "math/random.h"
#include "stream/faces.h"
#include "support/tap.h"

#include <string.h>

enum {
    SIDE = 9,
    VERTICES = SIDE * SIDE,
    FACES = 2 * (SIDE - 1) * (SIDE - 1),
    SAMPLES = 10 * FACES
};

/* A sheet with bumps, its faces, and samples with weights of their corners. */
static double surface[3 * VERTICES];
static int32_t vertex[3 * FACES], face[SAMPLES];
static float weight[3 * SAMPLES], area[SAMPLES], value[SAMPLES];
static bool used[SAMPLES];
static const struct faces faces = {.surface = surface,
                                   .position = surface,
                                   .vertices = VERTICES,
                                   .vertex = vertex,
                                   .count = FACES};
static const struct fit_samples samples = {
    .face = face, .weight = weight, .area = area, .used = used, .count = SAMPLES};

static void make_sheet(void)
{
    struct random random = random_start(1, 2, 3);
    for (size_t i = 0; i < VERTICES; i++) {
        surface[3 * i] = (double)(i % SIDE) + .3 * random_double(&random);
        surface[3 * i + 1] = (double)(i / SIDE) + .3 * random_double(&random);
        surface[3 * i + 2] = random_double(&random);
    }
    for (int32_t i = 0; i < FACES; i++) {
        const int32_t v = i / 2 / (SIDE - 1) * SIDE + i / 2 % (SIDE - 1),
                      corner[2][3] = {{v, v + 1, v + SIDE}, {v + 1, v + SIDE + 1, v + SIDE}};
        memcpy(vertex + 3 * i, corner[i % 2], sizeof corner[0]);
    }
    for (size_t i = 0; i < SAMPLES; i++) {
        const float u = random_float(&random), v = random_float(&random) * (1 - u);
        face[i] = (int32_t)(i % FACES);
        weight[3 * i] = u;
        weight[3 * i + 1] = v;
        weight[3 * i + 2] = 1 - u - v;
        area[i] = (float)faces_area(&faces, (size_t)face[i]) * (.5F + random_float(&random));
        used[i] = true;
    }
}

static double at_sample(const double *x, size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < 3; c++)
        sum += (double)weight[3 * i + c] * x[vertex[3 * (size_t)face[i] + c]];
    return sum;
}

/* Fits the values from x on; returns the mean square error before. */
static double fit(double smooth, double low, double high, double *x, struct fit_effort *effort)
{
    struct fit_surface made;
    struct fit_system system = {0};
    double right[VERTICES], before, all;
    must(fit_surface_make(&made, &faces, &samples, smooth));
    must(fit_system_init(&system, made.element, made.count, VERTICES));
    fit_surface_right(&made, &faces, &samples, value, 1, right);
    fit_surface_error(&made, &faces, &samples, value, 1, x, &before, &all);
    must(fit_solve(&system, right, low, high, x, effort));
    fit_system_clear(&system);
    fit_surface_clear(&made);
    return before;
}

static double error_of(const double *x)
{
    struct fit_surface made;
    double error, all;
    must(fit_surface_make(&made, &faces, &samples, 0));
    fit_surface_error(&made, &faces, &samples, value, 1, x, &error, &all);
    fit_surface_clear(&made);
    return error;
}

static void noisy_values(double low, double high)
{
    struct random random = random_start(4, 5, 6);
    for (size_t i = 0; i < SAMPLES; i++)
        value[i] = (float)(low + (high - low) * random_double(&random));
}

static void test_exact(void)
{
    struct random random = random_start(7, 8, 9);
    double truth[VERTICES], x[VERTICES] = {0}, worst = 0;
    struct fit_effort effort;
    for (size_t i = 0; i < VERTICES; i++)
        truth[i] = 4 * random_double(&random) - 2;
    for (size_t i = 0; i < SAMPLES; i++)
        value[i] = (float)at_sample(truth, i);
    fit(0, -INFINITY, INFINITY, x, &effort);
    for (size_t i = 0; i < VERTICES; i++)
        worst = fmax(worst, fabs(x[i] - truth[i]));
    ok(worst < 1e-5, "what is linear on each face comes back: %g off, %d steps", worst,
       effort.steps);
}

/* x, y and z are without bends in a plane alone. */
static void test_plane_is_smooth(void)
{
    double flat[3 * VERTICES], x[VERTICES] = {0}, worst = 0;
    struct fit_effort effort;
    memcpy(flat, surface, sizeof flat);
    for (size_t i = 0; i < VERTICES; i++)
        surface[3 * i + 2] = 0;
    for (size_t i = 0; i < SAMPLES; i++) {
        double truth[VERTICES];
        for (size_t v = 0; v < VERTICES; v++)
            truth[v] = 3 * surface[3 * v] - 2 * surface[3 * v + 1] + 1;
        value[i] = (float)at_sample(truth, i);
    }
    fit(100, -INFINITY, INFINITY, x, &effort);
    for (size_t v = 0; v < VERTICES; v++)
        worst = fmax(worst, fabs(x[v] - (3 * surface[3 * v] - 2 * surface[3 * v + 1] + 1)));
    ok(worst < 1e-4, "what is linear in a plane has no bends: %g off with --smooth 100", worst);
    memcpy(surface, flat, sizeof flat);
}

/* d/dx_i of the mean square error, by differences: it is quadratic, so they are exact. */
static double slope(double *x, size_t i)
{
    const double kept = x[i];
    x[i] = kept + 1;
    const double up = error_of(x);
    x[i] = kept - 1;
    const double down = error_of(x);
    x[i] = kept;
    return (up - down) / 2;
}

static void test_normal_equations(void)
{
    double x[VERTICES] = {0}, bounded[VERTICES], worst = 0, wrong = 0;
    int at_bounds = 0;
    struct fit_effort effort;
    noisy_values(-1, 1);
    fit(0, -INFINITY, INFINITY, x, &effort);
    for (size_t i = 0; i < VERTICES; i++)
        worst = fmax(worst, fabs(slope(x, i)));
    ok(worst < 1e-9, "the normal equations hold: %g at most, %d steps", worst, effort.steps);
    for (size_t i = 0; i < VERTICES; i++)
        bounded[i] = .05;
    const double before = fit(0, 0, .1, bounded, &effort);
    for (size_t i = 0; i < VERTICES; i++) {
        const double g = slope(bounded, i);
        const bool low = bounded[i] <= 0, high = bounded[i] >= .1;
        at_bounds += low || high;
        wrong = fmax(wrong, low ? -g : high ? g : fabs(g));
        wrong = fmax(wrong, bounded[i] < 0 || bounded[i] > .1 ? 1 : 0);
    }
    ok(wrong < 1e-9 && at_bounds > 10 && at_bounds < VERTICES,
       "within bounds they hold where it is free, %d vertices are at one: %g at most", at_bounds,
       wrong);
    ok(error_of(bounded) <= before && error_of(x) <= error_of(bounded),
       "never worse than before, and bounds cost: %g, %g, %g", before, error_of(bounded),
       error_of(x));
}

static void test_smooth_costs(void)
{
    double last = -1;
    bool grows = true;
    noisy_values(0, 1);
    for (double smooth = 0; smooth < 20; smooth = smooth * 10 + .01) {
        double x[VERTICES] = {0};
        struct fit_effort effort;
        fit(smooth, -INFINITY, INFINITY, x, &effort);
        grows = grows && error_of(x) > last;
        last = error_of(x);
    }
    ok(grows, "the more bends count, the more error is left");
}

static void test_unreached(void)
{
    double x[VERTICES], smooth[VERTICES];
    struct fit_effort effort;
    for (size_t i = 0; i < SAMPLES; i++) {
        value[i] = 1;
        used[i] = vertex[3 * (size_t)face[i]] && vertex[3 * (size_t)face[i] + 1] &&
                  vertex[3 * (size_t)face[i] + 2];
    }
    for (size_t i = 0; i < VERTICES; i++)
        x[i] = smooth[i] = 5;
    fit(0, -INFINITY, INFINITY, x, &effort);
    fit(.01, -INFINITY, INFINITY, smooth, &effort);
    ok(x[0] == 5 && fabs(x[40] - 1) < 1e-6, "a vertex that no sample reaches stays: %g", x[0]);
    ok(fabs(smooth[0] - 1) < 1e-4, "or is as smooth as its neighbours: %g", smooth[0]);
    memset(value, 0, sizeof value);
    fit(0, 0, INFINITY, x, &effort);
    ok(fabs(x[40]) < 1e-8 && effort.steps < 100, "all black is black: %g in %d steps", x[40],
       effort.steps);
    memset(used, 0, sizeof used);
    struct fit_surface made;
    struct error *err = fit_surface_make(&made, &faces, &samples, 0);
    ok(err && strstr(error_message(err), "no sample"), "without samples it is refused");
    error_destroy(err);
    fit_surface_clear(&made);
}

int main(void)
{
    make_sheet();
    test_exact();
    test_plane_is_smooth();
    test_normal_equations();
    test_smooth_costs();
    test_unreached();
    return tap_done();
}
