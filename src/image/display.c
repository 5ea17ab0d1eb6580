/* SPDX-License-Identifier: Apache-2.0 */
#include "image/display.h"
#include "base/array.h"
#include "base/error.h"
#include "image/image.h"
#include "math/sort.h"

#include <math.h>
#include <stdlib.h>

struct error *display_exposure(size_t count, const float *luminance, double *exposure)
{
    float *lit = NULL;
    size_t n = 0;
    struct error *err = array_create(&lit, count, sizeof *lit);
    for (size_t i = 0; i < count && !err; i++)
        if (luminance[i] > 0)
            lit[n++] = luminance[i];
    if (n)
        sort_floats(n, lit);
    *exposure = n ? 0.7 / (double)lit[(n - 1) * 95 / 100] : 1;
    free(lit);
    return err;
}

double display_tone(enum display_tone tone, double exposed)
{
    double x = exposed > 0 ? exposed : 0;
    if (tone == DISPLAY_FILMIC) {
        x = fmin(0.6 * x, 1e6);
        x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    }
    return x < 1 ? x : 1;
}

/* By search in the table of what codes mean: pow would differ in its last bit between machines. */
uint8_t display_code(double light)
{
    unsigned low = 0, high = 255;
    while (high - low > 1) {
        const unsigned middle = (low + high) / 2;
        if (light < (double)image_linear[middle])
            high = middle;
        else
            low = middle;
    }
    return (uint8_t)(2 * light < (double)image_linear[low] + (double)image_linear[high] ? low
                                                                                        : high);
}

void display_codes(size_t count, const float *rgb, double exposure, uint8_t *code)
{
    for (size_t i = 0; i < 3 * count; i++)
        code[i] = display_code(exposure * (double)rgb[i]);
}
