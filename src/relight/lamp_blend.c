/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/lamp_blend.h"
#include "base/array.h"
#include "base/error.h"
#include "math/convex.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Positions about their middle, as large as 1; p is among them, so that it is no larger. */
struct frame {
    double middle[3], size;
};

static struct frame frame_of(size_t count, const double *position, const double p[3])
{
    struct frame f = {.size = 0};
    for (int c = 0; c < 3; c++) {
        double low = p[c], high = p[c];
        for (size_t i = 0; i < count; i++) {
            low = fmin(low, position[3 * i + (size_t)c]);
            high = fmax(high, position[3 * i + (size_t)c]);
        }
        f.middle[c] = low / 2 + high / 2;
        f.size = fmax(f.size, high / 2 - low / 2);
    }
    f.size = f.size > 0 ? f.size : 1;
    return f;
}

/* x, y, z, 1; returns the height of the paraboloid there. */
static double lift(const struct frame *f, const double p[3], double lifted[4])
{
    double height = 0;
    for (int c = 0; c < 3; c++) {
        lifted[c] = (p[c] - f->middle[c]) / f->size;
        height += lifted[c] * lifted[c];
    }
    lifted[3] = 1;
    return height;
}

struct error *lamp_blend(size_t count, const double *position, const double p[3], double *weight,
                         double *off)
{
    const struct frame frame = frame_of(count, position, p);
    double *at = NULL, *plain = NULL, *cost = NULL, target[4];
    struct convex sum, nearest;
    struct error *err = array_create(&at, 4 * count, sizeof *at);
    if (!err)
        err = array_create(&plain, 3 * count, sizeof *plain);
    if (!err)
        err = array_create(&cost, count, sizeof *cost);
    for (size_t i = 0; i < count && !err; i++) {
        cost[i] = lift(&frame, position + 3 * i, at + 4 * i);
        memcpy(plain + 3 * i, at + 4 * i, 3 * sizeof *plain);
    }
    lift(&frame, p, target);
    *off = 0;
    if (!err && !convex_least(4, count, at, cost, target, &sum)) {
        *off = frame.size * convex_nearest(count, plain, target, &nearest, target);
        if (!convex_least(4, count, at, cost, target, &sum))
            sum = nearest;
    }
    double all = 0;
    memset(weight, 0, count * sizeof *weight);
    for (int k = 0; k < sum.count && !err; k++)
        all += sum.share[k];
    for (int k = 0; k < sum.count && !err; k++)
        weight[sum.point[k]] += sum.share[k] / all;
    free(at);
    free(plain);
    free(cost);
    return err;
}
