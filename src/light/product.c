/* SPDX-License-Identifier: Apache-2.0 */
#include "light/product.h"
#include "base/error.h"
#include "base/warning.h"
#include "libprobe-query/sh.h"
#include "light/basis.h"
#include "light/content.h"
#include "math/sphere_rule.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

enum { CHANNELS_MOST = 3 };

void product_sh(int order, int channels, const float *f, int of_order, const float *g,
                float *product)
{
    double sum[CHANNELS_MOST * SH_COUNT_MAX] = {0};
    for (int k = 0; k < SPHERE_RULE_COUNT; k++) {
        double d[3], y[SH_COUNT_MAX], scale = 0;
        const double weight = sphere_rule(k, d);
        sh_basis(order > of_order ? order : of_order, d, y);
        for (int j = 0; j < of_order * of_order; j++)
            scale += (double)g[j] * y[j];
        for (int c = 0; c < channels; c++) {
            double value = 0;
            for (int i = 0; i < order * order; i++)
                value += (double)f[channels * i + c] * y[i];
            for (int i = 0; i < order * order; i++)
                sum[channels * i + c] += weight * scale * value * y[i];
        }
    }
    for (int i = 0; i < channels * order * order; i++)
        product[i] = (float)sum[i];
}

/* The order of a column of one channel; 0: it is none. */
static int order_of(const struct column *c)
{
    return c->type == COLUMN_F32 ? sh_order_of(3 * c->width) : 0;
}

static void multiply(struct column *light, const struct light_column *what, const struct column *by,
                     size_t rows)
{
    const int order = sh_order_of(what->block), of_order = order_of(by);
    for (size_t row = 0; row < rows; row++) {
        const float *g = column_f32(by) + row * by->width;
        for (size_t b = 0; b < what->blocks; b++) {
            float *f = column_f32(light) + row * light->width + b * what->block;
            if (!isnan(f[0]) && !isnan(g[0]))
                product_sh(order, 3, f, of_order, g, f);
            else
                for (size_t i = 0; i < what->block; i++)
                    f[i] = NAN;
        }
    }
}

static struct error *check(const struct stream *stream, const char *name)
{
    const struct table *probes = stream_table(stream, "probe");
    const struct column *by = probes ? table_column(probes, name) : NULL;
    bool convolved;
    struct error *err = content_from_header(&stream->header, &convolved);
    if (err)
        return err;
    if (!probes || !table_column(probes, "sh"))
        return error_new("expected probes with light (column sh)");
    if (!by || !order_of(by))
        return error_new("--product: expected a column of SH, f32 of n^2 numbers, %s %s",
                         by ? "not" : "there is no", name);
    if (convolved)
        return error_new("--product is of radiance, got irradiance: --content radiance turns it "
                         "back");
    if (header_key(&stream->header, LIGHT_BASIS_KEY))
        return error_new("groups and transfers are compressed (key %s): expected the stream before "
                         "that",
                         LIGHT_BASIS_KEY);
    return NULL;
}

struct error *product_stream(struct stream *stream, const char *column, struct warnings *warnings)
{
    struct error *err = check(stream, column);
    if (err)
        return err;
    struct table *probes = stream_table(stream, "probe");
    const struct column *by = table_column(probes, column);
    const size_t width = table_column(probes, "sh")->width;
    bool gone = table_column(probes, "sh_window");
    for (size_t i = 0; i < probes->column_count; i++) {
        struct light_column what;
        struct column *c = &probes->columns[i];
        if (light_column_of(c, width, &what) && !what.surface && what.role == LIGHT_VALUE)
            multiply(c, &what, by, probes->rows);
    }
    for (size_t i = probes->column_count; i-- > 0;) {
        struct light_column what;
        if (!light_column_of(&probes->columns[i], width, &what) || what.role == LIGHT_VALUE)
            continue;
        gone = true;
        table_remove_column(probes, probes->columns[i].name);
    }
    table_remove_column(probes, "sh_window");
    basis_drop(probes);
    if (gone)
        warnings_add(warnings, "product",
                     "errors, gradients and windows are of the light as it was: dropped");
    return NULL;
}
