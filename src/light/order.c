/* SPDX-License-Identifier: Apache-2.0 */
#include "light/order.h"
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

/* Energy of irradiance in each band, summed over probes and colours. */
static void band_energy(size_t count, int order, bool convolved, const float *sh,
                        const float *error, double energy[SH_ORDER_MAX])
{
    const size_t width = (size_t)(3 * order * order);
    memset(energy, 0, SH_ORDER_MAX * sizeof *energy);
    for (size_t i = 0; i < count; i++, sh += width, error += width) {
        if (isnan(sh[0]))
            continue;
        for (int l = 0, k = 0; l < order; l++) {
            const double factor = convolved ? 1 : sh_cosine(l) * sh_cosine(l);
            for (; k < 3 * (l + 1) * (l + 1); k++)
                energy[l] += factor *
                             ((double)sh[k] * (double)sh[k] - (double)error[k] * (double)error[k]);
        }
    }
}

struct error *order_least(const struct table *probes, bool convolved, double share, int *order,
                          double *lost)
{
    struct column *sh, *error;
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (!err)
        err = table_require(probes, "sh_error", COLUMN_F32, sh->width, &error);
    if (err)
        return err;
    const int most = sh_order_of(sh->width);
    double energy[SH_ORDER_MAX], all = 0, beyond = 0;
    band_energy(probes->rows, most, convolved, column_f32(sh), column_f32(error), energy);
    for (int l = 0; l < most; l++)
        all += fmax(energy[l], 0);
    *order = most;
    *lost = 0;
    while (*order > 1) {
        beyond += fmax(energy[*order - 1], 0);
        if (beyond > share * share * all)
            break;
        *lost = all > 0 ? sqrt(beyond / all) : 0;
        --*order;
    }
    return NULL;
}

/* Keeps the first `kept` of every `length` values of a column. */
static struct error *cut(struct table *probes, const char *name, size_t length, size_t kept)
{
    const struct column *old = table_column(probes, name);
    if (!old || old->width % length || kept >= length)
        return NULL;
    const size_t blocks = old->width / length;
    struct table shorter = {0};
    struct column *column;
    struct error *err = table_init(&shorter, probes->name);
    if (!err)
        err = table_add_column(&shorter, name, COLUMN_F32, blocks * kept, &column);
    if (!err)
        err = table_resize(&shorter, probes->rows);
    if (!err) {
        float *to = column_f32(table_column(&shorter, name));
        const float *from = column_f32(old);
        for (size_t i = 0; i < probes->rows * blocks; i++)
            memcpy(to + i * kept, from + i * length, kept * sizeof *to);
        err = table_add_column(probes, name, COLUMN_F32, blocks * kept, NULL);
    }
    if (!err)
        table_copy_rows(probes, 0, &shorter, 0, probes->rows);
    table_clear(&shorter);
    return err;
}

struct error *order_reduce(struct table *probes, int order)
{
    struct column *sh;
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (err)
        return err;
    const size_t was = sh->width / 3, is = (size_t)(order * order);
    for (size_t i = 0; i < probes->column_count && !err; i++) {
        struct light_column what;
        if (light_column_of(&probes->columns[i], 3 * was, &what) && !what.surface)
            err = cut(probes, probes->columns[i].name, (size_t)what.channels * was,
                      (size_t)what.channels * is);
    }
    return err ? err : cut(probes, "visibility", was, is);
}
