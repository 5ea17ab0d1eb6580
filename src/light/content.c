/* SPDX-License-Identifier: Apache-2.0 */
#include "light/content.h"
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

static const char *const names[] = {"radiance", "irradiance", NULL};

struct error *content_from_header(const struct stream_header *header, bool *convolved)
{
    int content = 0;
    struct error *err = header_get_choice(header, "sh-content", names, &content);
    *convolved = content;
    return err;
}

struct error *content_to_header(struct stream_header *header, bool convolved)
{
    return header_set_key(header, "sh-content", names[convolved]);
}

/* A standard error has no sign, and a gradient three parts. */
static void scale(int order, const double *factor, float *sh, float *error, float *gradient)
{
    double size[SH_ORDER_MAX];
    for (int l = 0; l < order; l++)
        size[l] = fabs(factor[l]);
    if (sh)
        sh_scale_bands(order, factor, sh);
    if (error)
        sh_scale_bands(order, size, error);
    for (int axis = 0; gradient && axis < 3; axis++)
        sh_scale_bands(order, factor, gradient + axis * 3 * order * order);
}

void content_scale_bands(int order, int channels, const double *factor, float *block)
{
    if (channels == 3) {
        sh_scale_bands(order, factor, block);
        return;
    }
    for (int l = 0; l < order; l++)
        for (int i = channels * l * l; i < channels * (l + 1) * (l + 1); i++)
            block[i] = (float)((double)block[i] * factor[l]);
}

void content_convolve(int order, float *sh, float *error, float *gradient)
{
    double factor[SH_ORDER_MAX];
    for (int l = 0; l < order; l++)
        factor[l] = sh_cosine(l);
    scale(order, factor, sh, error, gradient);
}

/* Multiplies the bands of a column that holds light. */
static void convert_column(const struct column *column, size_t rows, size_t width, int order,
                           const double factor[SH_ORDER_MAX])
{
    struct light_column what;
    double own[SH_ORDER_MAX];
    if (!light_column_of(column, width, &what) || what.surface)
        return;
    for (int l = 0; l < order; l++)
        own[l] = what.role == LIGHT_ERROR ? fabs(factor[l]) : factor[l];
    for (size_t i = 0; i < rows * what.blocks; i++)
        content_scale_bands(order, what.channels, own, column_f32(column) + i * what.block);
}

struct error *content_convert(struct table *probes, bool from, bool to)
{
    struct column *sh;
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (err || from == to)
        return err;
    const int order = sh_order_of(sh->width);
    if (from && order > CONTENT_RADIANCE_ORDER_MAX)
        return error_new("radiance of order %d cannot be had from irradiance, in which band 3 "
                         "leaves no trace: expected order %d at the "
                         "most (--order %d cuts it)",
                         order, CONTENT_RADIANCE_ORDER_MAX, CONTENT_RADIANCE_ORDER_MAX);
    double factor[SH_ORDER_MAX];
    for (int l = 0; l < order; l++)
        factor[l] = from ? 1 / sh_cosine(l) : sh_cosine(l);
    for (size_t i = 0; i < probes->column_count; i++)
        convert_column(&probes->columns[i], probes->rows, sh->width, order, factor);
    return NULL;
}
