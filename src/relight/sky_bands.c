/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/sky_bands.h"
#include "base/error.h"
#include "base/file.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "light/rotate.h"
#include "math/angle.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

/* The row's sums over its texels of the value times cos m a and sin m a, a the azimuth in the
 * panorama, and of its tent around the axis: 2 (1 - cos m w) / (m^2 w) for texels w wide. */
static void row_waves(const struct scene_texture *picture, uint32_t row, int order,
                      double wave[SH_ORDER_MAX][2][3])
{
    const double wide = 2 * ANGLE_PI / picture->width;
    memset(wave, 0, SH_ORDER_MAX * sizeof *wave);
    for (uint32_t i = 0; i < picture->width; i++) {
        const double azimuth = wide * (i + 0.5) - ANGLE_PI, x = angle_cos(azimuth),
                     y = angle_sin(azimuth);
        float rgba[4];
        double c = 1, s = 0;
        scene_texture_texel(picture, i, row, rgba);
        for (int m = 0; m < order; m++) {
            for (int k = 0; k < 3; k++) {
                wave[m][0][k] += (double)rgba[k] * c;
                wave[m][1][k] += (double)rgba[k] * s;
            }
            const double next = c * x - s * y;
            s = s * x + c * y;
            c = next;
        }
    }
    for (int m = 0; m < order; m++) {
        /* sin^2 loses no digits where the texels are narrow */
        const double half = angle_sin(m * wide / 2),
                     tent = m ? 4 * half * half / (m * m * wide) : wide;
        for (int k = 0; k < 3; k++) {
            wave[m][0][k] *= tent;
            wave[m][1][k] *= tent;
        }
    }
}

/* Adds the integral from `low` to `high` (angle from the upper pole) of (a + b t) sin t times the
 * functions of z alone: Y_lm at azimuth 0, by order^2. */
static void add_stretch(int order, double low, double high, double at_low, double at_high,
                        double *sum)
{
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                   0.8611363115940526},
                        weight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                     0.3478548451374538};
    for (int i = 0; i < 4; i++) {
        const double u = (node[i] + 1) / 2, t = low + u * (high - low), s = angle_sin(t);
        const double w = weight[i] / 2 * (high - low) * s * (at_low + u * (at_high - at_low));
        double y[SH_COUNT_MAX];
        sh_basis(order, (const double[3]){s, 0, angle_cos(t)}, y);
        for (int j = 0; j < order * order; j++)
            sum[j] += w * y[j];
    }
}

/* The integral over all heights of a row's tent times the functions at azimuth 0. */
static void row_heights(uint32_t row, uint32_t rows, int order, double *sum)
{
    const double high = ANGLE_PI / rows, middle = high * (row + 0.5);
    memset(sum, 0, SH_COUNT_MAX * sizeof *sum);
    /* at the poles the outermost row goes on */
    if (row == 0)
        add_stretch(order, 0, middle, 1, 1, sum);
    else
        add_stretch(order, middle - high, middle, 0, 1, sum);
    if (row + 1 == rows)
        add_stretch(order, middle, ANGLE_PI, 1, 1, sum);
    else
        add_stretch(order, middle, middle + high, 1, 0, sum);
}

/* In a frame whose z is up and whose x is to the front; the panorama's azimuth turns to the right,
 * which is -y there. */
static void picture_bands(const struct scene_texture *picture, int order, double *c)
{
    double wave[SH_ORDER_MAX][2][3], height[SH_COUNT_MAX];
    for (uint32_t row = 0; row < picture->height; row++) {
        row_waves(picture, row, order, wave);
        row_heights(row, picture->height, order, height);
        for (int l = 0; l < order; l++)
            for (int m = -l; m <= l; m++) {
                const int positive = m < 0 ? -m : m, i = l * (l + 1) + m;
                const double z = height[l * (l + 1) + positive];
                for (int k = 0; k < 3; k++)
                    c[3 * i + k] += z * (m < 0 ? -wave[positive][1][k] : wave[positive][0][k]);
            }
    }
}

struct error *sky_bands(const struct scene_sky *sky, int order, double *c)
{
    const size_t count = (size_t)(3 * order * order);
    memset(c, 0, count * sizeof *c);
    if (!sky->picture) {
        for (int k = 0; k < 3; k++)
            c[k] = sky->radiance[k] / SH_Y00;
        return NULL;
    }
    double own[3 * SH_COUNT_MAX] = {0};
    struct rotation rotation;
    const struct vec3 front = sky->turned ? sky->front : (struct vec3){1, 0, 0},
                      up = sky->turned ? sky->up : (struct vec3){0, 1, 0},
                      right = sky->turned ? sky->right : (struct vec3){0, 0, 1};
    const double matrix[9] = {front.x, -right.x, up.x,     front.y, -right.y,
                              up.y,    front.z,  -right.z, up.z};
    struct error *err = rotation_init(&rotation, matrix);
    if (err)
        return err;
    picture_bands(sky->picture, order, own);
    for (size_t i = 0; i < count; i++)
        own[i] *= sky->radiance[i % 3];
    rotation_sh(&rotation, order, 3, own, c);
    return NULL;
}

static struct error *read_probe(const struct stream *stream, int order, double *c)
{
    const struct table *probes = stream_table(stream, "probe");
    const struct column *sh = probes ? table_column(probes, "sh") : NULL;
    bool convolved;
    struct error *err = content_from_header(&stream->header, &convolved);
    if (err)
        return err;
    if (!sh)
        return error_new("expected a probe with light (column sh), there is none");
    if (probes->rows != 1)
        return error_new("expected one probe, got %zu: probe-cat --rows N keeps one", probes->rows);
    if (convolved)
        return error_new("expected radiance, got irradiance: probe-cat --content radiance turns it "
                         "back");
    if (sh_order_of(sh->width) < order)
        return error_new("expected light of order %d, that of the transfer, or more, got %d", order,
                         sh_order_of(sh->width));
    if (isnan(column_f32(sh)[0]))
        return error_new("the probe has no light yet: run probe-capture");
    for (int i = 0; i < 3 * order * order; i++)
        c[i] = (double)column_f32(sh)[i];
    return NULL;
}

struct error *sky_bands_of_probe(const char *path, int order, double *c)
{
    struct stream *stream = NULL;
    struct error *err = stream_read(&stream, path);
    if (!err)
        err = error_wrap(read_probe(stream, order, c), "%s", file_input_name(path));
    stream_destroy(stream);
    return err;
}
