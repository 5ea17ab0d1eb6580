/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/mean_error.h"

#include <math.h>
#include <stdlib.h>

enum { TOGETHER = 40 }; /* points, about */

static const double THETA = 0.28, CLEAR = 3;

static int compare(const void *a, const void *b)
{
    const struct noisy_square *x = a, *y = b;
    if (x->about != y->about)
        return x->about < y->about ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* What the errors of points with these squares are, about: slope * (square - mean) + error. */
struct line {
    double mean, error, slope;
};

static struct line fit(double mean, double spread, double noise, double count)
{
    const double off = sqrt(spread / fmax(count, 1));
    struct line line = {.mean = mean, .slope = 0.5 / sqrt(fmax(mean, off / 2) + 1e-30)};
    if (mean > 0) {
        const double less = mean / sqrt(mean * mean + THETA * fmax(spread - noise, 0));
        line.error = sqrt(mean) * less;
        line.slope *= less;
    }
    return line;
}

struct sum {
    double errors, variance;
    double more; /* that errors may be: where squares are below 0 by more than chance */
};

/* Adds points that are taken together. */
static void add_group(size_t count, const struct noisy_square *point, struct sum *sum)
{
    const double n = (double)count;
    double noise = 0, mean = 0, spread = 0, lows = 0, errors = 0, squares = 0;
    for (size_t i = 0; i < count; i++)
        noise += point[i].noise * point[i].noise / n;
    const double clear = CLEAR * sqrt(noise);
    for (size_t i = 0; i < count; i++)
        if (point[i].square <= clear) {
            lows++;
            mean += point[i].square;
            spread += point[i].square * point[i].square;
        }
    mean /= fmax(lows, 1);
    spread = fmax(spread / fmax(lows, 1) - mean * mean, 0);
    const struct line line = fit(mean, spread, noise, lows);
    for (size_t i = 0; i < count; i++) {
        const double square = point[i].square,
                     error = square > clear ? sqrt(square)
                                            : line.error + line.slope * (square - line.mean);
        errors += error;
        squares += error * error;
    }
    sum->errors += errors;
    sum->variance += n * fmax(squares - errors * errors / n, 0) / fmax(n - 1, 1);
    sum->more += lows * sqrt(fmax(-mean - 2 * sqrt(spread / fmax(lows, 1)), 0));
}

void mean_error(size_t count, struct noisy_square *point, double *mean, double *doubt)
{
    const size_t groups = count / TOGETHER + (count > 0);
    struct sum sum = {0};
    qsort(point, count, sizeof *point, compare);
    for (size_t g = 0; g < groups; g++) {
        const size_t first = count * g / groups, end = count * (g + 1) / groups;
        add_group(end - first, point + first, &sum);
    }
    *mean = count ? sum.errors / (double)count : 0;
    *doubt = count ? (sqrt(sum.variance) + sum.more / 2) / (double)count : 0;
}
