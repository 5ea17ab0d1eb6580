/* SPDX-License-Identifier: Apache-2.0 */
/* What scripts/bench bases runs: irradiance from SH and other bases beside the truth.
 *
 *     bench_bases PROBES TRUTH
 *
 * PROBES: a stream of points with sh of order 6 and the columns of all bases, made of it. TRUTH:
 * surface probes with their irradiance, as many for each of PROBES, one point after the other.
 * Prints one line of JSON for each way to store a probe: bytes, and the RMS, the 95th percentile
 * and the worst of what irradiance in luminance is off, of all directions of all probes, against
 * the probe's mean or, where that is less, a quarter of all probes' mean; the share of directions
 * in which it is below 0. */
#include "base/array.h"
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "light/basis.h"
#include "light/dering.h"
#include "math/luminance.h"
#include "math/sort.h"
#include "stream/stream.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct bench {
    const struct table *probes;
    size_t count, directions;
    const float *sh, *normal, *truth;
    double *mean, *off;
};

static double true_light(const struct bench *b, size_t i)
{
    return luminance_f32(b->truth + 3 * i);
}

/* A way to store a probe: SH of some order, de-rung or not; or another basis. */
struct way {
    char name[32];
    int order; /* 0: a basis */
    bool dering;
    enum basis basis;
};

static void evaluate(const struct bench *b, const struct way *way, size_t probe, const double n[3],
                     const float *sh, double rgb[3])
{
    if (way->order) {
        sh_irradiance(way->order, sh, 0, n, rgb);
        return;
    }
    const struct column *column = table_column(b->probes, basis_column(way->basis));
    basis_irradiance(way->basis, column_f32(column) + probe * column->width, n, rgb);
}

static void measure(const struct bench *b, const struct way *way)
{
    const struct dering_settings settings = {.target = DERING_IRRADIANCE};
    double square = 0, negative = 0;
    for (size_t probe = 0; probe < b->count; probe++) {
        float sh[3 * SH_COUNT_MAX];
        memcpy(sh, b->sh + probe * 3 * SH_COUNT_MAX, sizeof sh);
        const double r = way->dering ? dering_window(&settings, way->order, false, sh) : 1;
        if (r < 1)
            dering_apply(way->order, r, sh, NULL, NULL);
        for (size_t k = 0; k < b->directions; k++) {
            const size_t i = probe * b->directions + k;
            double rgb[3];
            evaluate(b, way, probe,
                     (const double[3]){(double)b->normal[3 * i], (double)b->normal[3 * i + 1],
                                       (double)b->normal[3 * i + 2]},
                     sh, rgb);
            b->off[i] = fabs(luminance_f64(rgb) - true_light(b, i)) / b->mean[probe];
            square += b->off[i] * b->off[i];
            negative += luminance_f64(rgb) < 0;
        }
    }
    const size_t all = b->count * b->directions;
    sort_doubles(all, b->off);
    printf("{\"name\": \"%s\", \"bytes\": %zu, \"rms\": %.6f, \"p95\": %.6f, \"worst\": %.6f, "
           "\"negative\": %.6f}\n",
           way->name,
           way->order ? (size_t)(12 * way->order * way->order) : 4 * basis_width(way->basis),
           sqrt(square / (double)all), b->off[all * 95 / 100], b->off[all - 1],
           negative / (double)all);
}

static struct error *take(struct bench *b, const struct stream *probes, const struct stream *truth)
{
    struct column *sh, *normal, *irradiance, *basis;
    b->probes = stream_table(probes, "probe");
    const struct table *surfaces = stream_table(truth, "probe");
    struct error *err = table_require(b->probes, "sh", COLUMN_F32, 3 * SH_COUNT_MAX, &sh);
    if (!err)
        err = table_require(surfaces, "normal", COLUMN_F32, 3, &normal);
    if (!err)
        err = table_require(surfaces, "irradiance", COLUMN_F32, 3, &irradiance);
    for (int i = 0; i < BASIS_COUNT && !err; i++)
        err = table_require(b->probes, basis_column((enum basis)i), COLUMN_F32,
                            basis_width((enum basis)i), &basis);
    b->count = b->probes->rows;
    if (!err && (!b->count || !surfaces->rows || surfaces->rows % b->count))
        err = error_new("expected as many surfaces for each of %zu probes, got %zu", b->count,
                        surfaces->rows);
    if (!err)
        err = array_create(&b->mean, b->count, sizeof *b->mean);
    if (!err)
        err = array_create(&b->off, surfaces->rows, sizeof *b->off);
    if (err)
        return err;
    b->directions = surfaces->rows / b->count;
    b->sh = column_f32(sh);
    b->normal = column_f32(normal);
    b->truth = column_f32(irradiance);
    double whole = 0;
    for (size_t i = 0; i < surfaces->rows; i++)
        b->mean[i / b->directions] += true_light(b, i) / (double)b->directions;
    for (size_t i = 0; i < b->count; i++)
        whole += b->mean[i] / (double)b->count;
    for (size_t i = 0; i < b->count; i++)
        b->mean[i] = fmax(b->mean[i], whole / 4);
    return NULL;
}

int main(int argc, char **argv)
{
    struct stream *probes = NULL, *truth = NULL;
    struct bench b = {0};
    struct error *err = argc == 3 ? stream_read(&probes, argv[1])
                                  : error_usage("expected PROBES TRUTH");
    if (!err)
        err = stream_read(&truth, argv[2]);
    if (!err)
        err = take(&b, probes, truth);
    for (int order = 1; order <= SH_ORDER_MAX && !err; order++) {
        for (int dering = 0; dering < (order > 1 && order < 5 ? 2 : 1); dering++) {
            struct way way = {.order = order, .dering = dering};
            snprintf(way.name, sizeof way.name, "SH %d%s", order, dering ? ", de-rung" : "");
            measure(&b, &way);
        }
    }
    for (int i = 0; i < BASIS_COUNT && !err; i++) {
        struct way way = {.basis = (enum basis)i};
        snprintf(way.name, sizeof way.name, "%s", basis_name(way.basis));
        measure(&b, &way);
    }
    free(b.mean);
    free(b.off);
    stream_destroy(probes);
    stream_destroy(truth);
    return error_exit("bench_bases", err);
}
