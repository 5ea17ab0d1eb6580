/* SPDX-License-Identifier: Apache-2.0 */
#include "light/visibility.h"
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "math/vec.h"
#include "stream/stream.h"

#include <math.h>

/* One probe's: its coefficients, and where the columns have it. */
static void derive(const float *v, float *ao, float *normal, float *length, float *cone)
{
    const double open = (double)v[0] * sqrt(4 * ANGLE_PI), to_sum = sqrt(4 * ANGLE_PI / 3);
    const struct vec3 sum = {to_sum * (double)v[3], to_sum * (double)v[1], to_sum * (double)v[2]},
                      unit = open > 0 ? vec3_normalize(sum) : (struct vec3){0};
    const double l = open > 0 ? fmin(vec3_length(sum) / open, 1) : 0;
    *ao = (float)fmax(open / (4 * ANGLE_PI), 0);
    cone[0] = normal[0] = (float)unit.x;
    cone[1] = normal[1] = (float)unit.y;
    cone[2] = normal[2] = (float)unit.z;
    *length = (float)l;
    cone[3] = open > 0 ? (float)(2 * l - 1) : 1;
}

struct error *visibility_derive(struct stream *stream)
{
    static const struct {
        const char *name;
        size_t width;
    } columns[] = {{"ao", 1}, {"bent_normal", 3}, {"bent_length", 1}, {"cone", 4}};
    enum { COLUMNS = sizeof columns / sizeof *columns };
    struct table *probes = stream_table(stream, "probe");
    struct column *seen = NULL;
    float *to[COLUMNS];
    struct error *err = probes ? table_require(probes, "visibility", COLUMN_F32, 0, &seen)
                               : error_new("expected a table probe, there is none");
    if (!err && seen->width < 4)
        err =
            error_new("column visibility: expected order 2 or more, got 1, which has no direction");
    for (size_t i = 0; i < COLUMNS && !err; i++)
        err = table_add_column(probes, columns[i].name, COLUMN_F32, columns[i].width, NULL);
    if (err)
        return err;
    for (size_t i = 0; i < COLUMNS; i++)
        to[i] = column_f32(table_column(probes, columns[i].name));
    seen = table_column(probes, "visibility"); /* columns may have moved */
    for (size_t row = 0; row < probes->rows; row++) {
        const float *v = column_f32(seen) + row * seen->width;
        if (!isnan(v[0]))
            derive(v, to[0] + row, to[1] + 3 * row, to[2] + row, to[3] + 4 * row);
    }
    header_remove_key(&stream->header, "capture-ao-distance");
    header_remove_key(&stream->header, "capture-ao-falloff");
    return NULL;
}
