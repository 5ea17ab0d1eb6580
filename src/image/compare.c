/* SPDX-License-Identifier: Apache-2.0 */
#include "image/compare.h"
#include "base/array.h"
#include "base/error.h"
#include "image/flip.h"
#include "math/luminance.h"

#include <math.h>
#include <stdlib.h>

struct error *compare_show(const struct picture *picture, const struct compare_screen *screen,
                           struct picture *shown)
{
    struct error *err = picture_init(shown, picture->width, picture->height);
    for (size_t i = 0; !err && i < 3 * picture->width * picture->height; i++)
        shown->rgb[i] =
            (float)display_tone(screen->tone, screen->exposure * (double)picture->rgb[i]);
    return err;
}

struct error *compare_exposure(const struct picture *picture, double *exposure)
{
    float *luminance = NULL;
    const size_t count = picture->width * picture->height;
    struct error *err = array_create(&luminance, count, sizeof *luminance);
    for (size_t i = 0; i < count && !err; i++)
        luminance[i] =
            luminance_vec3f(picture_get(picture, i % picture->width, i / picture->width));
    if (!err)
        err = display_exposure(count, luminance, exposure);
    free(luminance);
    return err;
}

static void compare_linear(const struct picture *truth, const struct picture *variance,
                           const struct picture *test, struct compare *result)
{
    const size_t count = 3 * truth->width * truth->height;
    double mean = 0, difference = 0, square = 0, noise = 0;
    for (size_t i = 0; i < count; i++) {
        const double t = (double)truth->rgb[i], d = (double)test->rgb[i] - t;
        mean += t;
        difference += d;
        square += d * d;
        noise += variance ? (double)variance->rgb[i] : NAN;
    }
    const double n = (double)count;
    *result = (struct compare){.mean = mean / n,
                               .bias = mean > 0 ? difference / mean : 0,
                               .rmse = sqrt(square / n),
                               .relative = mean > 0 ? sqrt(square / n) / (mean / n) : 0,
                               .noise = sqrt(noise / n)};
}

struct error *compare_pictures(const struct compare_pair *pair, int threads, float *map,
                               struct compare *result)
{
    const struct picture *truth = pair->truth, *test = pair->test;
    struct picture shown[2] = {{0}, {0}};
    if (truth->width != test->width || truth->height != test->height)
        return error_new("the pictures differ in size: %zu x %zu and %zu x %zu pixels",
                         truth->width, truth->height, test->width, test->height);
    compare_linear(truth, pair->variance, test, result);
    struct error *err = compare_show(truth, &pair->screen, &shown[0]);
    if (!err)
        err = compare_show(test, &pair->screen, &shown[1]);
    if (!err)
        err =
            flip_compare(&shown[0], &shown[1], flip_pixels_per_degree, threads, map, &result->flip);
    picture_clear(&shown[0]);
    picture_clear(&shown[1]);
    return err;
}
