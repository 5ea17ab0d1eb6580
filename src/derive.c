#include "derive.h"
#include "array.h"
#include "error.h"
#include "sh.h"
#include "vec.h"

#include <math.h>
#include <stdlib.h>

void derive_irradiance(size_t count, int order, bool convolved, const float *sh, float *rgb)
{
    const size_t width = (size_t)(3 * order * order);
    const double y00 = 0.28209479177387814, factor = convolved ? y00 : y00 * sh_cosine(0);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = isnan(sh[i * width]) ? 0 : (float)(factor * (double)sh[i * width + k]);
}

void derive_luminance(size_t count, const float *rgb, float *luminance)
{
    for (size_t i = 0; i < count; i++)
        luminance[i] = vec3f_luminance((struct vec3f){rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
}

void derive_brightest(size_t count, int order, const float *sh, float *direction)
{
    const size_t width = (size_t)(3 * order * order);
    for (size_t i = 0; i < count; i++) {
        double d[3] = {0};
        if (!isnan(sh[i * width]))
            sh_dominant(order, sh + i * width, d);
        for (size_t k = 0; k < 3; k++)
            direction[3 * i + k] = (float)d[k];
    }
}

void derive_captured(size_t count, size_t width, const float *sh, int32_t *captured)
{
    for (size_t i = 0; i < count; i++)
        captured[i] = !isnan(sh[i * width]);
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

struct error *derive_exposure(size_t count, const float *luminance, float *exposure)
{
    float *lit = NULL;
    size_t n = 0;
    struct error *err = array_create(&lit, count, sizeof *lit);
    for (size_t i = 0; i < count && !err; i++)
        if (luminance[i] > 0)
            lit[n++] = luminance[i];
    if (n)
        qsort(lit, n, sizeof *lit, compare_floats);
    *exposure = n ? 0.7f / lit[(n - 1) * 95 / 100] : 1;
    free(lit);
    return err;
}

/* IEC 61966-2-1. */
static uint8_t srgb_code(float linear)
{
    const float x = fminf(fmaxf(linear, 0), 1);
    const float s = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * s + 0.5f);
}

void derive_codes(size_t count, const float *rgb, float exposure, uint8_t *code)
{
    for (size_t i = 0; i < 3 * count; i++)
        code[i] = srgb_code(exposure * rgb[i]);
}

/* Six times the volume. */
static double cell_volume(const int32_t *v, const double *position, struct vec3 edge[3])
{
    const struct vec3 p0 = vec3_load(position + 3 * (size_t)v[0]);
    for (int k = 0; k < 3; k++)
        edge[k] = vec3_sub(vec3_load(position + 3 * (size_t)v[k + 1]), p0);
    return vec3_dot(edge[0], vec3_cross(edge[1], edge[2]));
}

void derive_cell_gradient(size_t cell_count, const int32_t *vertex, const double *position, const float *value, float *gradient)
{
    for (size_t cell = 0; cell < cell_count; cell++) {
        const int32_t *v = vertex + 4 * cell;
        struct vec3 edge[3], g = {0};
        const double volume = cell_volume(v, position, edge);
        if (volume > 0) { /* Cramer's rule for edge[k] . g = difference[k] */
            for (int k = 0; k < 3; k++) {
                const double difference = (double)value[v[k + 1]] - (double)value[v[0]];
                g = vec3_fma(g, difference / volume, vec3_cross(edge[(k + 1) % 3], edge[(k + 2) % 3]));
            }
        }
        const float limited[3] = {(float)g.x, (float)g.y, (float)g.z};
        for (size_t k = 0; k < 3; k++)
            gradient[3 * cell + k] = isfinite(limited[k]) ? limited[k] : 0; /* of a cell without thickness */
    }
}

struct error *derive_point_gradient(size_t count, size_t cell_count, const int32_t *vertex, const double *position,
                                    const float *cell_gradient, float *gradient)
{
    double *sum = NULL;
    struct error *err = array_create(&sum, 4 * count, sizeof *sum);
    for (size_t cell = 0; cell < cell_count && !err; cell++) {
        struct vec3 edge[3];
        const double volume = fmax(cell_volume(vertex + 4 * cell, position, edge), 0);
        for (size_t i = 0; i < 4; i++) {
            double *at = sum + 4 * (size_t)vertex[4 * cell + i];
            for (size_t k = 0; k < 3; k++)
                at[k] += volume * (double)cell_gradient[3 * cell + k];
            at[3] += volume;
        }
    }
    for (size_t i = 0; i < count && !err; i++)
        for (size_t k = 0; k < 3; k++)
            gradient[3 * i + k] = sum[4 * i + 3] > 0 ? (float)(sum[4 * i + k] / sum[4 * i + 3]) : 0;
    free(sum);
    return err;
}
