/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/sight_fit.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* It ends after STEPS, or where PATIENCE of them have not made the loss less by more than GAIN of
 * itself. */
enum { STEPS = 80, PATIENCE = 12 };
static const double LEAK = 3, NEAR = 1e-3, GAIN = 2e-3;

/* -- loss ------------------------------------------------------------------------------------- */

/* F of the way that is seen. */
static double seen_weight(double inverse)
{
    const double r = inverse > 1 ? 1 / inverse : 1;
    return r * r * r * (4 - 3 * r);
}

static double inverse_at(const struct sight_ray *ray, const double *sight)
{
    double sum = ray->base;
    for (int i = 0; i < ray->terms; i++)
        sum += sight[ray->neighbour[i]] * ray->u[i];
    return sum;
}

static double loss_of(const struct sight_ray *ray, double inverse)
{
    const double more = seen_weight(inverse) - seen_weight(ray->inverse);
    return ray->share * (more > 0 ? LEAK * more : -more);
}

double sight_fit_loss(size_t count, const struct sight_ray *ray, const double *sight)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += loss_of(&ray[k], inverse_at(&ray[k], sight));
    return sum;
}

/* -- least squares ---------------------------------------------------------------------------- */

/* Solves a x = b, a symmetric, n x n, of which the lower half is read and overwritten; x comes into
 * b (Cholesky). false: a is not positive definite. */
static bool solve(size_t n, double *a, double *b)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            if (i == j && !(sum > 0))
                return false;
            a[i * n + j] = i == j ? sqrt(sum) : sum / a[j * n + j];
        }
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            b[i] -= a[i * n + k] * b[k];
        b[i] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            b[i] -= a[k * n + i] * b[k];
        b[i] /= a[i * n + i];
    }
    return true;
}

/* Adds weight (inverse - target)^2 of a ray. */
static void add_square(const struct sight_ray *ray, double weight, double target, size_t n,
                       double *a, double *b)
{
    for (int i = 0; i < ray->terms; i++) {
        const size_t row = (size_t)ray->neighbour[i];
        for (int j = 0; j < ray->terms; j++)
            a[row * n + (size_t)ray->neighbour[j]] += weight * ray->u[i] * ray->u[j];
        b[row] += weight * ray->u[i] * (target - ray->base);
    }
}

/* What no ray speaks of stays as it is. */
static void hold(size_t n, double share, const double *sight, double *a, double *b)
{
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, a[i * n + i]);
    for (size_t i = 0; i < n; i++) {
        const double by = share * a[i * n + i] + 1e-9 * most;
        a[i * n + i] += by;
        b[i] += by * sight[i];
    }
}

/* The normal equations about `sight`. A ray that meets nothing asks for no more than 1. */
static void gather(size_t count, const struct sight_ray *ray, size_t n, const double *sight,
                   double *a, double *b)
{
    memset(a, 0, n * n * sizeof *a);
    memset(b, 0, n * sizeof *b);
    for (size_t k = 0; k < count; k++) {
        const double inverse = inverse_at(&ray[k], sight), target = fmax(ray[k].inverse, 1);
        if (!(ray[k].inverse > 0) && inverse <= 1)
            continue;
        const double off = fmax(fabs(inverse - target), NEAR * target),
                     weight = fmax(loss_of(&ray[k], inverse), 1e-9 * ray[k].share) / (off * off);
        add_square(&ray[k], weight, target, n, a, b);
    }
    hold(n, 3e-4, sight, a, b);
}

/* Those of what rays met alone, each off by as little of itself as may be: all of a plane, however
 * near to the probe it is, where F says no more how near. */
static void gather_met(size_t count, const struct sight_ray *ray, size_t n, const double *sight,
                       double *a, double *b)
{
    memset(a, 0, n * n * sizeof *a);
    memset(b, 0, n * sizeof *b);
    for (size_t k = 0; k < count; k++)
        if (ray[k].inverse > 0)
            add_square(&ray[k], ray[k].share / (ray[k].inverse * ray[k].inverse), ray[k].inverse, n,
                       a, b);
    hold(n, 1e-12, sight, a, b);
}

struct error *sight_fit(size_t count, const struct sight_ray *ray, size_t n, double *sight)
{
    double *room = NULL, least = INFINITY, aim = INFINITY;
    int last = 0; /* step that reached the aim */
    struct error *err = array_create(&room, n * (n + 2), sizeof *room);
    if (err)
        return err;
    double *a = room, *b = a + n * n, *best = b + n;
    gather_met(count, ray, n, sight, a, b);
    if (solve(n, a, b) && sight_fit_loss(count, ray, b) < sight_fit_loss(count, ray, sight))
        memcpy(sight, b, n * sizeof *sight);
    for (int step = 0; least > 0; step++) {
        const double now = sight_fit_loss(count, ray, sight);
        if (now < least) {
            least = now;
            memcpy(best, sight, n * sizeof *best);
        }
        if (now < aim) {
            aim = now * (1 - GAIN);
            last = step;
        }
        if (step == STEPS || step == last + PATIENCE)
            break;
        gather(count, ray, n, sight, a, b);
        if (!solve(n, a, b))
            break;
        memcpy(sight, b, n * sizeof *sight);
    }
    memcpy(sight, best, n * sizeof *sight);
    free(room);
    return NULL;
}
