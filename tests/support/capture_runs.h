/* SPDX-License-Identifier: Apache-2.0 */
/* capture_runs: the same probe captured with many seeds, held against a truth or against other
 * runs.
 *
 * One capture shows errors as large as its noise; the mean of K shows them sqrt(K) times smaller.
 * Three statistics, each of them near a standard normal (z) or Student's t with K - 1 degrees of
 * freedom when nothing is wrong:
 *
 *     runs_z             (mean - truth) / sqrt(mean of sh_error^2 / K), the largest of all
 *                        coefficients
 *     runs_bias          the mean along the truth, <value, truth> / <truth, truth> - 1, and its
 *                        standard error from the spread of the K
 *     runs_irradiance_t  the irradiance on 14 normals from orders 1 .. 6, its standard error from
 *                        the spread
 *
 * The largest of 108 |z| passes RUNS_Z_MOST by luck once in 16000 checks; |t| with 31 or more
 * degrees of freedom passes RUNS_T_MOST once in 8e5 (Bonferroni: one check of 252 irradiances once
 * in 3000). Seeds are fixed: luck does not change from day to day. runs_check asks besides that the
 * standard error of the bias be below RUNS_RESOLUTION: a test that could not see 2 % fails.
 *
 * Under sanitizers the runs are RUNS_SANITIZED, whose spread says nothing: z is asked for alone.
 */
#ifndef CAPTURE_RUNS_H
#define CAPTURE_RUNS_H

#include "support/capture_bench.h"
#include "support/capture_truth.h"

enum { RUNS_MOST = 64, RUNS_SANITIZED = 2 };

static const double RUNS_Z_MOST = 5, RUNS_T_MOST = 6, RUNS_RESOLUTION = 0.003;

struct runs {
    int order, count;
    float value[RUNS_MOST][TRUTH_VALUES];
    double variance[TRUTH_VALUES]; /* of the mean of the values, from sh_error */
    double sky, depth, validity;   /* means */
};

static inline int runs_values(const struct runs *r)
{
    return 3 * r->order * r->order;
}

/* Captures the probe at p with the seeds settings.seed, ... + count - 1. */
static inline void runs_take(struct runs *r, const struct bench *b,
                             struct capture_settings settings, const double p[3], int count)
{
    if (SANITIZED)
        count = RUNS_SANITIZED;
    *r = (struct runs){.order = settings.order, .count = count};
    for (int i = 0; i < count; i++, settings.seed++) {
        const struct capture_probe probe = capture(b, &settings, p[0], p[1], p[2]);
        memcpy(r->value[i], probe.sh, sizeof r->value[i]);
        for (int k = 0; k < runs_values(r); k++)
            r->variance[k] += (double)probe.sh_error[k] * (double)probe.sh_error[k] / count / count;
        r->sky += (double)probe.sky / count;
        r->depth += (double)probe.depth / count;
        r->validity += (double)probe.validity / count;
    }
}

/* -- numbers ---------------------------------------------------------------------------------- */

struct estimate {
    double mean, error; /* error: standard error of the mean */
};

static inline struct estimate estimate_of(const double *x, int count)
{
    struct estimate e = {0};
    for (int i = 0; i < count; i++)
        e.mean += x[i] / count;
    for (int i = 0; i < count; i++)
        e.error += (x[i] - e.mean) * (x[i] - e.mean);
    e.error = sqrt(e.error / count / (count - 1));
    return e;
}

static inline struct estimate runs_coefficient(const struct runs *r, int k)
{
    double x[RUNS_MOST];
    for (int i = 0; i < r->count; i++)
        x[i] = (double)r->value[i][k];
    return estimate_of(x, r->count);
}

static inline double largest(const double *x, int count)
{
    double most = 0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

/* How many standard errors off. 1e-5 of the largest value is float's own, and what multiple
 * importance sampling leaves to rays that meet a small emitter by themselves, which none of them
 * may do. */
static inline double deviation(double off, double error, double most)
{
    return fabs(off) / (error + 1e-5 * most + 1e-300);
}

/* -- against a truth -------------------------------------------------------------------------- */

static inline double runs_z(const struct runs *r, const double *truth)
{
    const double most = largest(truth, runs_values(r));
    double worst = 0;
    for (int k = 0; k < runs_values(r); k++)
        worst = fmax(worst,
                     deviation(runs_coefficient(r, k).mean - truth[k], sqrt(r->variance[k]), most));
    return worst;
}

static inline struct estimate runs_bias(const struct runs *r, const double *truth)
{
    double x[RUNS_MOST], square = 0;
    for (int k = 0; k < runs_values(r); k++)
        square += truth[k] * truth[k];
    for (int i = 0; i < r->count; i++) {
        x[i] = -1;
        for (int k = 0; k < runs_values(r); k++)
            x[i] += (double)r->value[i][k] * truth[k] / square;
    }
    return estimate_of(x, r->count);
}

/* Irradiance that a truth gives on a surface with normal n, bands below `order`. */
static inline void truth_irradiance(const double *truth, int order, const double n[3],
                                    double rgb[3])
{
    double y[SH_COUNT_MAX];
    sh_basis(order, n, y);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++)
            for (int k = 0; k < 3; k++)
                rgb[k] += sh_cosine(l) * y[i] * truth[3 * i + k];
}

/* The axes, then the diagonals. */
static inline void runs_normal(int i, double n[3])
{
    for (int k = 0; k < 3; k++)
        n[k] = i < 6 ? (i / 2 == k) * (i % 2 ? -1 : 1) : ((i >> k & 1) ? -1 : 1) / sqrt(3);
}

static inline double runs_irradiance_t(const struct runs *r, const double *truth)
{
    double worst = 0;
    for (int at = 0; at < 14 * r->order; at++) {
        const int order = at / 14 + 1;
        double n[3], e[3][RUNS_MOST], true_e[3];
        runs_normal(at % 14, n);
        truth_irradiance(truth, order, n, true_e);
        for (int i = 0; i < r->count; i++) {
            double rgb[3];
            sh_irradiance(order, r->value[i], 0, n, rgb);
            for (int k = 0; k < 3; k++)
                e[k][i] = rgb[k];
        }
        for (int k = 0; k < 3; k++) {
            const struct estimate mean = estimate_of(e[k], r->count);
            worst = fmax(worst, deviation(mean.mean - true_e[k], mean.error,
                                          PI * largest(truth, runs_values(r))));
        }
    }
    return worst;
}

/* Says whether runs agree with the truth, in the three ways. */
__attribute__((format(printf, 3, 4), unused)) static void runs_check(const struct runs *r,
                                                                     const double *truth,
                                                                     const char *format, ...)
{
    char name[160];
    va_list args;
    va_start(args, format);
    vsnprintf(name, sizeof name, format, args);
    va_end(args);
    const double z = runs_z(r, truth);
    ok(z < RUNS_Z_MOST, "%s: SH of order %d (z = %.2f)", name, r->order, z);
    if (SANITIZED)
        return;
    const double t = runs_irradiance_t(r, truth);
    const struct estimate bias = runs_bias(r, truth);
    ok(deviation(bias.mean, bias.error, 1) < RUNS_T_MOST && bias.error < RUNS_RESOLUTION,
       "%s: off by %+.3f %%, standard error %.3f %%", name, 100 * bias.mean, 100 * bias.error);
    ok(t < RUNS_T_MOST, "%s: irradiance (t = %.2f)", name, t);
}

/* -- against each other ----------------------------------------------------------------------- */

/* The largest of |a + b - c| over its standard error from the spread (Welch's t); b may be NULL. */
static inline double runs_difference_t(const struct runs *a, const struct runs *b,
                                       const struct runs *c)
{
    double worst = 0, most = 0;
    for (int k = 0; k < runs_values(c); k++)
        most = fmax(most, fabs(runs_coefficient(c, k).mean));
    for (int k = 0; k < runs_values(c); k++) {
        const struct estimate x = runs_coefficient(a, k), z = runs_coefficient(c, k);
        const struct estimate y = b ? runs_coefficient(b, k) : (struct estimate){0};
        const double error = sqrt(x.error * x.error + y.error * y.error + z.error * z.error);
        worst = fmax(worst, deviation(x.mean + y.mean - z.mean, error, most));
    }
    return worst;
}

static inline void runs_mean(const struct runs *r, double *mean)
{
    for (int k = 0; k < runs_values(r); k++)
        mean[k] = runs_coefficient(r, k).mean;
}

/* How far a is from b along b's mean, relative. */
static inline struct estimate runs_relative(const struct runs *a, const struct runs *b)
{
    double mean[TRUTH_VALUES];
    runs_mean(b, mean);
    const struct estimate x = runs_bias(a, mean), y = runs_bias(b, mean);
    return (struct estimate){x.mean, sqrt(x.error * x.error + y.error * y.error)};
}

#endif
