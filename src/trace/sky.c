/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/sky.h"
#include "base/array.h"
#include "base/error.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "scene/scene_shade.h"

#include <stdlib.h>

/* E(L^2) / E(L)^2 over the sphere from which a picture is drawn from: below, rays that escape by
 * chance find its light well enough (a clear sky without a sun has 1.1, one with a sun
 * hundreds). */
#define UNEVEN 2.0

/* Mean luminance over a texel's cell of the picture's bilinear interpolation: 3/4 the texel's, 1/8
 * each neighbour's. */
static double cell_luminance(const struct scene_texture *picture, const double *luminance,
                             uint32_t row, uint32_t column)
{
    double sum = 0;
    for (int i = -1; i <= 1; i++) {
        const int64_t y = (int64_t)row + i;
        const size_t at = (size_t)(y < 0                  ? 0
                                   : y >= picture->height ? picture->height - 1
                                                          : y) *
                          picture->width;
        for (int j = -1; j <= 1; j++) {
            const size_t x = ((size_t)column + picture->width + (size_t)(int64_t)j) %
                             picture->width;
            sum += (i ? 0.125 : 0.75) * (j ? 0.125 : 0.75) * luminance[at + x];
        }
    }
    return sum;
}

static struct error *picture_luminance(const struct scene *scene, double **luminance)
{
    const struct scene_texture *picture = scene->sky.picture;
    const size_t count = (size_t)picture->width * picture->height;
    struct error *err = array_create(luminance, count, sizeof **luminance);
    const float *texel = picture->texels;
    const double *scale = scene->sky.radiance;
    const struct vec3 weight = {LUMINANCE_RED * scale[0], LUMINANCE_GREEN * scale[1],
                                LUMINANCE_BLUE * scale[2]};
    for (size_t i = 0; i < count && !err; i++, texel += picture->channels)
        (*luminance)[i] =
            vec3_dot(weight, (struct vec3){(double)texel[0], (double)texel[1], (double)texel[2]});
    return err;
}

/* Fills the cumulative shares; false: the picture is black or even. */
static bool accumulate(struct sky *sky, const struct scene_texture *picture,
                       const double *luminance)
{
    double total = 0, squares = 0, top = 1;
    for (uint32_t i = 0; i < sky->rows; i++) {
        const double bottom = angle_sin(ANGLE_PI * (0.5 - (double)(i + 1) / sky->rows));
        const double solid = (top - bottom) / (2.0 * sky->columns); /* share of the sphere */
        double sum = 0;
        for (uint32_t j = 0; j < sky->columns; j++) {
            const double l = cell_luminance(picture, luminance, i, j);
            sum += l * solid;
            squares += l * l * solid;
            sky->texel[(size_t)i * sky->columns + j] = sum;
        }
        for (uint32_t j = 0; j < sky->columns && sum > 0; j++)
            sky->texel[(size_t)i * sky->columns + j] /= sum;
        total += sum;
        sky->row[i] = total;
        sky->edge[i] = bottom;
        top = bottom;
    }
    for (uint32_t i = 0; i < sky->rows && total > 0; i++)
        sky->row[i] /= total;
    return squares > UNEVEN * total * total;
}

struct error *sky_init(struct sky *sky, const struct scene *scene)
{
    const struct scene_texture *picture = scene->sky.picture;
    *sky = (struct sky){0};
    if (!picture || picture->channels < 3 || picture->bytes)
        return NULL;
    double *luminance = NULL;
    *sky = (struct sky){.rows = picture->height, .columns = picture->width, .axes = &scene->sky};
    struct error *err = picture_luminance(scene, &luminance);
    if (!err)
        err = array_create(&sky->row, sky->rows, sizeof *sky->row);
    if (!err)
        err = array_create(&sky->edge, sky->rows, sizeof *sky->edge);
    if (!err)
        err = array_create(&sky->texel, (size_t)sky->rows * sky->columns, sizeof *sky->texel);
    if (err || !accumulate(sky, picture, luminance))
        sky_clear(sky);
    free(luminance);
    return err;
}

void sky_clear(struct sky *sky)
{
    free(sky->row);
    free(sky->texel);
    free(sky->edge);
    *sky = (struct sky){0};
}

static bool is_above(double a, double b)
{
    return a > b;
}

static bool is_not_above(double a, double b)
{
    return a <= b;
}

/* The first of `count` numbers that is so beside x, where all after it are as well; else the
 * last. */
static uint32_t find(const double *number, uint32_t count, bool (*is)(double, double), double x)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (is(number[middle], x))
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Density per solid angle within a texel. */
static float texel_density(const struct sky *sky, uint32_t row, uint32_t column)
{
    const double *texel = sky->texel + (size_t)row * sky->columns;
    const double p = (sky->row[row] - (row ? sky->row[row - 1] : 0)) *
                     (texel[column] - (column ? texel[column - 1] : 0));
    const double top = row ? sky->edge[row - 1] : 1;
    return (float)(p * sky->columns / (2 * ANGLE_PI * (top - sky->edge[row])));
}

struct vec3f sky_sample(const struct sky *sky, double x, double y, float *density)
{
    const uint32_t row = find(sky->row, sky->rows, is_above, y);
    const double *texel = sky->texel + (size_t)row * sky->columns;
    const uint32_t column = find(texel, sky->columns, is_above, x);
    /* What is left of x and y, within the texel. */
    const double before_y = row ? sky->row[row - 1] : 0, before_x = column ? texel[column - 1] : 0;
    const double fy = (y - before_y) / (sky->row[row] - before_y),
                 fx = (x - before_x) / (texel[column] - before_x);
    const double top = row ? sky->edge[row - 1] : 1, height = top + fy * (sky->edge[row] - top);
    const double azimuth = 2 * ANGLE_PI * ((column + fx) / sky->columns - 0.5),
                 flat = sqrt(fmax(1 - height * height, 0));
    *density = texel_density(sky, row, column);
    return scene_sky_outward(sky->axes,
                             (struct vec3f){(float)(flat * angle_cos(azimuth)), (float)height,
                                            (float)(flat * angle_sin(azimuth))});
}

float sky_density(const struct sky *sky, struct vec3f d)
{
    d = scene_sky_inward(sky->axes, d);
    const double turn = 0.5 + angle_atan2((double)d.z, (double)d.x) / (2 * ANGLE_PI);
    const uint32_t column = (uint32_t)(turn * sky->columns);
    /* the first row whose lower edge is not above the direction */
    const uint32_t row = find(sky->edge, sky->rows, is_not_above, (double)d.y);
    return texel_density(sky, row, column < sky->columns ? column : sky->columns - 1);
}
