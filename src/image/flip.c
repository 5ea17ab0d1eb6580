/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Andersson et al., "FLIP: A difference evaluator for alternating images", HPG 2020.
 * Equations and tables are theirs. Every filter of theirs is a product of one across and one down,
 * or a sum of two such; so it is done here. */
#include "image/flip.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "image/cielab.h"
#include "math/angle.h"
#include "math/power.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

const double flip_pixels_per_degree = 3840 * (ANGLE_PI / 180);

enum { RADIUS_MOST = 256, TAPS = 2 * RADIUS_MOST + 1 };

/* One direction of a filter. */
struct kernel {
    int radius;
    double weight[TAPS];
};

/* exp(-x^2 factor), summing to 1. */
static void gaussian(struct kernel *k, int radius, double factor)
{
    double sum = 0;
    k->radius = radius;
    for (int x = -radius; x <= radius; x++)
        sum += k->weight[x + radius] = power_exp(-fmin(x * x * factor, 690));
    for (int i = 0; i <= 2 * radius; i++)
        k->weight[i] /= sum;
}

/* First (edges) or second (points) derivative of a Gaussian, its weights of each sign summing to 1
 * (sec. 4.2.1). */
static void derivative(struct kernel *k, int radius, double deviation, int order)
{
    double positive = 0, negative = 0;
    k->radius = radius;
    for (int x = -radius; x <= radius; x++) {
        const double square = x * x / (deviation * deviation),
                     g = power_exp(-fmin(square / 2, 690));
        const double w = order == 1 ? -x * g : (square - 1) * g;
        k->weight[x + radius] = w;
        positive += w > 0 ? w : 0;
        negative -= w < 0 ? w : 0;
    }
    for (int i = 0; i <= 2 * radius; i++)
        k->weight[i] /= k->weight[i] > 0 ? positive : negative;
}

/* -- filtering -------------------------------------------------------------------------------- */

enum { PLANES = 3 }; /* of a picture: luminance Y, Cx (red-green), Cz (blue-yellow), as in YCxCz */

struct filter {
    const double *from;
    double *to, *between; /* width * height each */
    size_t width, height;
    const struct kernel *across, *down;
    double share;
    bool add; /* share times the result to what is there */
};

static size_t clamp(ptrdiff_t i, size_t count)
{
    return i < 0 ? 0 : (size_t)i < count ? (size_t)i : count - 1;
}

static struct error *filter_across(void *context, size_t row, int thread)
{
    (void)thread;
    const struct filter *f = context;
    const double *from = f->from + row * f->width;
    for (size_t x = 0; x < f->width; x++) {
        double sum = 0;
        for (int i = -f->across->radius; i <= f->across->radius; i++)
            sum += f->across->weight[i + f->across->radius] *
                   from[clamp((ptrdiff_t)x + i, f->width)];
        f->between[row * f->width + x] = sum;
    }
    return NULL;
}

static struct error *filter_down(void *context, size_t row, int thread)
{
    (void)thread;
    const struct filter *f = context;
    double *to = f->to + row * f->width;
    for (size_t x = 0; x < f->width && !f->add; x++)
        to[x] = 0;
    for (int i = -f->down->radius; i <= f->down->radius; i++) {
        const double weight = f->share * f->down->weight[i + f->down->radius];
        const double *from = f->between + clamp((ptrdiff_t)row + i, f->height) * f->width;
        for (size_t x = 0; x < f->width; x++)
            to[x] += weight * from[x];
    }
    return NULL;
}

/* Arrays of a comparison, in one piece of memory. */
struct work {
    size_t width, height, count;
    int threads;
    double *memory, *between;
    double *plane[2][PLANES];    /* of the pictures */
    double *filtered[2][PLANES]; /* as the eye takes them */
    double *feature[2][2][2];    /* edges and points, across and down */
};

/* A plane through a filter that is the product of these two. */
static struct error *pass(const struct work *w, struct filter f)
{
    f.between = w->between;
    f.width = w->width;
    f.height = w->height;
    struct error *err = threads_for(w->threads, w->height, filter_across, &f);
    return err ? err : threads_for(w->threads, w->height, filter_down, &f);
}

/* Contrast sensitivity (table 1): sums of a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees, made to
 * sum to 1. */
static struct error *filter_eye(const struct work *w, double ppd)
{
    static const double a[PLANES][2] = {{1, 0}, {1, 0}, {34.1, 13.5}},
                        b[PLANES][2] = {{0.0047, 1}, {0.0053, 1}, {0.04, 0.025}};
    const int radius = (int)ceil(3 * sqrt(0.04 / (2 * ANGLE_PI * ANGLE_PI)) * ppd);
    struct error *err = NULL;
    for (int plane = 0; plane < PLANES; plane++) {
        struct kernel kernel[2];
        double whole[2] = {0};
        for (int i = 0; i < 2; i++) {
            const double factor = ANGLE_PI * ANGLE_PI / (b[plane][i] * ppd * ppd);
            double sum = 0;
            for (int x = -radius; x <= radius; x++)
                sum += power_exp(-fmin(x * x * factor, 690));
            gaussian(&kernel[i], radius, factor);
            whole[i] = a[plane][i] * sqrt(ANGLE_PI / b[plane][i]) * sum * sum;
        }
        for (int picture = 0; picture < 2 && !err; picture++) {
            struct filter f = {.from = w->plane[picture][plane], .to = w->filtered[picture][plane]};
            for (int i = 0; i < 2 && !err; i++) {
                if (i && !(whole[i] > 0))
                    continue;
                f.across = f.down = &kernel[i];
                f.share = whole[i] / (whole[0] + whole[1]);
                f.add = i > 0;
                err = pass(w, f);
            }
        }
    }
    return err;
}

/* Edges and points of Y, whose width is 0.082 degrees (sec. 4.2.1). */
static struct error *find_features(const struct work *w, double ppd)
{
    const double deviation = 0.5 * 0.082 * ppd;
    const int radius = (int)ceil(3 * deviation);
    struct kernel smooth, sharp[2];
    gaussian(&smooth, radius, 1 / (2 * deviation * deviation));
    struct error *err = NULL;
    for (int kind = 0; kind < 2; kind++)
        derivative(&sharp[kind], radius, deviation, kind + 1);
    for (int picture = 0; picture < 2; picture++)
        for (int kind = 0; kind < 2 && !err; kind++) {
            struct filter f = {.from = w->plane[picture][0],
                               .to = w->feature[picture][kind][0],
                               .across = &sharp[kind],
                               .down = &smooth,
                               .share = 1};
            err = pass(w, f);
            f.to = w->feature[picture][kind][1];
            f.across = &smooth;
            f.down = &sharp[kind];
            if (!err)
                err = pass(w, f);
        }
    return err;
}

/* -- differences ------------------------------------------------------------------------------ */

/* CIELAB with the Hunt effect: less light, less colour (eq. 3). */
static void hunt(const double rgb[3], double lab[3])
{
    cielab_of(rgb, lab);
    lab[1] *= 0.01 * lab[0];
    lab[2] *= 0.01 * lab[0];
}

/* HyAB: city-block between lightness and the rest (Abasi et al. 2020). */
static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* The largest colour difference, green against blue, to the power q_c. */
static double largest_difference(void)
{
    double green[3], blue[3];
    hunt((const double[3]){0, 1, 0}, green);
    hunt((const double[3]){0, 0, 1}, blue);
    return power_of(hyab(green, blue), 0.7);
}

/* Colour difference 0 .. 1 (eq. 4, q_c = 0.7, p_c = 0.4, p_t = 0.95). */
static double colour_difference(const struct work *w, size_t i, double largest)
{
    double lab[2][3];
    for (int picture = 0; picture < 2; picture++) {
        double *const *f = w->filtered[picture];
        const double y = (f[0][i] + 16) / 116, xyz[3] = {y + f[1][i] / 500, y, y - f[2][i] / 200};
        double rgb[3];
        cielab_rgb(xyz, rgb);
        for (int k = 0; k < 3; k++)
            rgb[k] = fmin(fmax(rgb[k], 0), 1);
        hunt(rgb, lab[picture]);
    }
    const double difference = power_of(hyab(lab[0], lab[1]), 0.7), knee = 0.4 * largest;
    return difference < knee ? 0.95 / knee * difference
                             : 0.95 + (difference - knee) / (largest - knee) * 0.05;
}

/* Feature difference 0 .. 1 (eq. 5, q_f = 0.5): that of edges or of points, whichever is larger. */
static double feature_difference(const struct work *w, size_t i)
{
    double most = 0;
    for (int kind = 0; kind < 2; kind++) {
        double size[2];
        for (int picture = 0; picture < 2; picture++) {
            const double x = w->feature[picture][kind][0][i], y = w->feature[picture][kind][1][i];
            /* of (Y + 16) / 116, whose filters sum to 0 */
            size[picture] = sqrt(x * x + y * y) / 116;
        }
        most = fmax(most, fabs(size[0] - size[1]));
    }
    return fmin(sqrt(most / sqrt(2)), 1);
}

/* -- all of it -------------------------------------------------------------------------------- */

static struct error *work_init(struct work *w, const struct picture *p, int threads)
{
    enum { ARRAYS = 1 + 4 * PLANES + 8 };
    *w = (struct work){
        .width = p->width, .height = p->height, .count = p->width * p->height, .threads = threads};
    struct error *err = array_create(&w->memory, ARRAYS * w->count, sizeof *w->memory);
    double *next = w->memory;
    if (err)
        return err;
    w->between = next;
    for (int picture = 0; picture < 2; picture++) {
        for (int plane = 0; plane < PLANES; plane++) {
            w->plane[picture][plane] = next += w->count;
            w->filtered[picture][plane] = next += w->count;
        }
        for (int i = 0; i < 4; i++)
            w->feature[picture][i / 2][i % 2] = next += w->count;
    }
    return NULL;
}

/* YCxCz: CIELAB without its cube root. */
static void fill_planes(const struct work *w, const struct picture *p, double *const plane[PLANES])
{
    for (size_t i = 0; i < w->count; i++) {
        const double rgb[3] = {(double)p->rgb[3 * i], (double)p->rgb[3 * i + 1],
                               (double)p->rgb[3 * i + 2]};
        double xyz[3];
        cielab_xyz(rgb, xyz);
        plane[0][i] = 116 * xyz[1] - 16;
        plane[1][i] = 500 * (xyz[0] - xyz[1]);
        plane[2][i] = 200 * (xyz[1] - xyz[2]);
    }
}

struct error *flip_compare(const struct picture *reference, const struct picture *test, double ppd,
                           int threads, float *map, double *mean)
{
    struct work w;
    *mean = 0;
    if (reference->width != test->width || reference->height != test->height)
        return error_new("the pictures differ in size: %zu x %zu and %zu x %zu pixels",
                         reference->width, reference->height, test->width, test->height);
    if (!(ppd > 0 && ppd * 0.135077 < RADIUS_MOST))
        return error_new("%g pixels a degree, expected above 0 and below 1895", ppd);
    struct error *err = work_init(&w, reference, threads);
    if (err)
        return err;
    fill_planes(&w, reference, w.plane[0]);
    fill_planes(&w, test, w.plane[1]);
    err = filter_eye(&w, ppd);
    if (!err)
        err = find_features(&w, ppd);
    const double largest = largest_difference();
    for (size_t i = 0; i < w.count && !err; i++) {
        const double difference =
            power_of(colour_difference(&w, i, largest), 1 - feature_difference(&w, i));
        map[i] = (float)difference;
        *mean += difference / (double)w.count;
    }
    free(w.memory);
    return err;
}
