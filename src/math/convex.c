/* SPDX-License-Identifier: Apache-2.0 */
#include "math/convex.h"
#include "math/vec.h"

#include <math.h>
#include <string.h>

/* -- linear equations ------------------------------------------------------------------------- */

enum { ROOM = CONVEX_MOST + 1 };

/* Solves a x = b for several b at once, n <= ROOM, by Gauss and Jordan with pivots; b becomes x.
 * False: a is singular. */
static bool solve(int n, double a[ROOM][ROOM], int sides, double b[ROOM][ROOM])
{
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            pivot = fabs(a[i][k]) > fabs(a[pivot][k]) ? i : pivot;
        if (!(fabs(a[pivot][k]) > 1e-13))
            return false;
        for (int j = 0; j < n || j < sides; j++) {
            const double x = a[k][j], y = b[k][j];
            if (j < n)
                a[k][j] = a[pivot][j], a[pivot][j] = x;
            if (j < sides)
                b[k][j] = b[pivot][j], b[pivot][j] = y;
        }
        for (int i = 0; i < n; i++) {
            const double factor = i == k ? 0 : a[i][k] / a[k][k];
            for (int j = k; j < n; j++)
                a[i][j] -= factor * a[k][j];
            for (int j = 0; j < sides; j++)
                b[i][j] -= factor * b[k][j];
        }
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < sides; j++)
            b[i][j] /= a[i][i];
    return true;
}

/* -- the least cost --------------------------------------------------------------------------- */

#define AXIS ((size_t)-1)

/* As many points as there are dimensions, of which the target is a sum. Axes, with which the search
 * begins, cost more than any point: their cost is counted apart. */
struct basis {
    int n;
    size_t points;
    const double *at, *cost, *target;
    size_t point[CONVEX_MOST]; /* AXIS: sign times the axis */
    double sign[CONVEX_MOST];
    double inverse[ROOM][ROOM]; /* row k times a point: its share of corner k */
    double share[CONVEX_MOST];
    double price[2][CONVEX_MOST]; /* of axes, of costs: times a point, what its corners cost */
};

static double cost_of(const struct basis *b, size_t point)
{
    return b->cost ? b->cost[point] : 1;
}

static double times(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* Finds shares and prices; false: the corners are not independent. */
static bool price(struct basis *b)
{
    double a[ROOM][ROOM] = {{0}};
    memset(b->inverse, 0, sizeof b->inverse);
    for (int k = 0; k < b->n; k++)
        for (int i = 0; i < b->n; i++) {
            a[i][k] = b->point[k] == AXIS ? (i == k ? b->sign[k] : 0)
                                          : b->at[(size_t)b->n * b->point[k] + (size_t)i];
            b->inverse[i][k] = i == k;
        }
    if (!solve(b->n, a, b->n, b->inverse))
        return false;
    memset(b->price, 0, sizeof b->price);
    for (int k = 0; k < b->n; k++) {
        const bool axis = b->point[k] == AXIS;
        b->share[k] = fmax(times(b->n, b->inverse[k], b->target), 0);
        for (int i = 0; i < b->n; i++)
            b->price[axis ? 0 : 1][i] += b->inverse[k][i] * (axis ? 1 : cost_of(b, b->point[k]));
    }
    return true;
}

/* The point that saves the most: of axes first, then of costs where it takes no more of axes; the
 * first of those that save, where a search has gone on for long (Bland). AXIS: none does. */
static size_t find_saving(const struct basis *b, bool first)
{
    size_t found = AXIS;
    double most[2] = {0, 0}, size[2] = {1, 1};
    for (int s = 0; s < 2; s++)
        for (int i = 0; i < b->n; i++)
            size[s] += fabs(b->price[s][i]);
    for (size_t p = 0; p < b->points; p++) {
        const double *at = b->at + (size_t)b->n * p;
        const double axes = times(b->n, b->price[0], at),
                     costs = times(b->n, b->price[1], at) - cost_of(b, p);
        const double limit = 1e-10 * size[0];
        if (axes < -limit || (axes <= limit && !(costs > 1e-10 * size[1])))
            continue;
        const bool by_axes = axes > limit,
                   more = by_axes ? axes > most[0] : !(most[0] > 0) && costs > most[1];
        if (found == AXIS || (more && !first)) {
            found = p;
            most[0] = by_axes ? axes : 0;
            most[1] = costs;
        }
    }
    return found;
}

/* The corner whose share falls to 0 first as that of a point grows; -1: none does. */
static int find_leaving(const struct basis *b, const double *at)
{
    double least = (double)INFINITY;
    int leaves = -1;
    for (int k = 0; k < b->n; k++) {
        const double slope = times(b->n, b->inverse[k], at);
        if (!(slope > 1e-12))
            continue;
        const double reach = b->share[k] / slope;
        const bool tie = leaves >= 0 && !(reach > least) && !(reach < least);
        if (reach < least || (tie && b->point[k] > b->point[leaves])) { /* axes leave first */
            least = reach;
            leaves = k;
        }
    }
    return leaves;
}

bool convex_least(int dimension, size_t points, const double *at, const double *cost,
                  const double *target, struct convex *sum)
{
    enum { STEPS_MOST = 1000, STEPS_USUAL = 100 };
    struct basis b = {.n = dimension, .points = points, .at = at, .cost = cost, .target = target};
    for (int k = 0; k < dimension; k++) {
        b.point[k] = AXIS;
        b.sign[k] = target[k] < 0 ? -1 : 1;
    }
    bool fine = price(&b);
    for (int step = 0; step < STEPS_MOST && fine; step++) {
        const size_t next = find_saving(&b, step >= STEPS_USUAL);
        const int leaves = next == AXIS ? -1 : find_leaving(&b, at + (size_t)dimension * next);
        if (leaves < 0)
            break;
        b.point[leaves] = next;
        fine = price(&b);
    }
    *sum = (struct convex){0};
    for (int k = 0; k < dimension && fine; k++) {
        fine = b.point[k] != AXIS || b.share[k] < 1e-9;
        if (b.point[k] == AXIS || !(b.share[k] > 0))
            continue;
        sum->point[sum->count] = b.point[k];
        sum->share[sum->count++] = b.share[k];
    }
    return fine;
}

/* -- the nearest point ------------------------------------------------------------------------ */

static struct vec3 sum_of(const struct convex *sum, const double *at)
{
    struct vec3 x = {0, 0, 0};
    for (int k = 0; k < sum->count; k++)
        x = vec3_fma(x, sum->share[k], vec3_load(at + 3 * sum->point[k]));
    return x;
}

/* The shares, of any sign, of the point nearest to the target where the points of a sum go on
 * without end; false: they are not independent. */
static bool nearest_of_all(const struct convex *sum, const double *at, struct vec3 target,
                           double share[CONVEX_MOST])
{
    const int n = sum->count + 1;
    double a[ROOM][ROOM] = {{0}}, b[ROOM][ROOM] = {{0}};
    for (int i = 0; i < sum->count; i++)
        for (int j = 0; j < sum->count; j++)
            a[i][j] = vec3_dot(vec3_sub(vec3_load(at + 3 * sum->point[i]), target),
                               vec3_sub(vec3_load(at + 3 * sum->point[j]), target));
    for (int i = 0; i < sum->count; i++)
        a[i][n - 1] = a[n - 1][i] = 1;
    b[n - 1][0] = 1;
    const bool fine = solve(n, a, 1, b);
    for (int i = 0; i < sum->count; i++)
        share[i] = b[i][0];
    return fine;
}

static void drop(struct convex *sum, int k)
{
    sum->count--;
    for (int i = k; i < sum->count; i++) {
        sum->point[i] = sum->point[i + 1];
        sum->share[i] = sum->share[i + 1];
    }
}

/* Goes to the nearest point of the sum's points, past those whose share it would make negative. */
static void settle(struct convex *sum, const double *at, struct vec3 target)
{
    for (;;) {
        double share[CONVEX_MOST], step = 1;
        int out = -1;
        if (!nearest_of_all(sum, at, target, share)) {
            drop(sum, sum->count - 1); /* the newest adds nothing */
            return;
        }
        for (int k = 0; k < sum->count; k++) {
            const double reach = share[k] > 0 ? 1 : sum->share[k] / (sum->share[k] - share[k]);
            if (!(share[k] > 0) && (out < 0 || reach < step)) {
                step = fmin(reach, 1);
                out = k;
            }
        }
        for (int k = 0; k < sum->count; k++)
            sum->share[k] += step * (share[k] - sum->share[k]);
        if (out < 0)
            return;
        drop(sum, out);
    }
}

double convex_nearest(size_t points, const double *at, const double target[3], struct convex *sum,
                      double nearest[3])
{
    enum { STEPS_MOST = 1000 };
    const struct vec3 to = vec3_load(target);
    *sum = (struct convex){.count = 1, .share = {1}};
    struct vec3 x = sum_of(sum, at);
    for (int step = 0; step < STEPS_MOST; step++) {
        const struct vec3 away = vec3_sub(x, to);
        const double now = vec3_dot(away, away);
        double least = (double)INFINITY;
        size_t next = 0;
        for (size_t p = 0; p < points; p++) {
            const double height = vec3_dot(away, vec3_sub(vec3_load(at + 3 * p), to));
            if (height < least) {
                least = height;
                next = p;
            }
        }
        if (sum->count == CONVEX_MOST || !(least < now - 1e-12 * (1 + now)))
            break;
        sum->point[sum->count] = next;
        sum->share[sum->count++] = 0;
        settle(sum, at, to);
        const struct vec3 then = sum_of(sum, at);
        if (!(vec3_length(vec3_sub(then, to)) < vec3_length(away)))
            break;
        x = then;
    }
    vec3_store(nearest, x);
    return vec3_length(vec3_sub(x, to));
}
