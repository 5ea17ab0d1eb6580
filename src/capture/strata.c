/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/strata.h"
#include "math/luminance.h"

#include <math.h>
#include <string.h>

static void start(struct strata *s, int functions, bool luminance)
{
    s->functions = functions;
    s->channels = luminance ? 4 : 3;
    for (int c = 0; c < s->channels; c++)
        memset(s->of[c], 0, (size_t)s->functions * sizeof s->of[c][0]);
}

void strata_start(struct strata *s, int order, bool luminance)
{
    s->order = order;
    s->normal = NULL;
    start(s, order ? order * order : 1, luminance);
}

void strata_start_normals(struct strata *s, const double *normal, int count, bool luminance)
{
    s->order = 0;
    s->normal = normal;
    start(s, count, luminance);
}

/* Fours are added LANES at once: those that are not there have no light. */
static size_t whole_lanes(size_t fours)
{
    return (fours + STRATA_LANES - 1) / STRATA_LANES * STRATA_LANES;
}

static void set_directions(struct strata_wave *wave, size_t fours, const struct vec3f *direction)
{
    for (size_t k = 0; k < 4; k++)
        for (size_t f = 0; f < whole_lanes(fours); f++)
            wave->direction[k * STRATA_FOURS + f] = f < fours ? direction[k * fours + f]
                                                              : direction[0];
}

static void set_light(struct strata_wave *wave, size_t fours, const struct vec3f *light)
{
    for (size_t k = 0; k < 4; k++) {
        for (size_t f = 0; f < whole_lanes(fours); f++) {
            const size_t from = k * fours + f, to = k * STRATA_FOURS + f;
            const struct vec3f l = f < fours ? light[from] : (struct vec3f){0};
            wave->light[0][to] = (double)l.x;
            wave->light[1][to] = (double)l.y;
            wave->light[2][to] = (double)l.z;
            wave->light[3][to] = luminance_f32((const float[3]){l.x, l.y, l.z});
        }
    }
}

/* The clamped cosines between the directions and the unit vector n. */
static void set_cosines(const struct strata_wave *wave, size_t fours, const double n[3], double *to)
{
    for (size_t k = 0; k < 4; k++) {
        for (size_t i = k * STRATA_FOURS; i < k * STRATA_FOURS + whole_lanes(fours); i++) {
            const struct vec3f d = wave->direction[i];
            to[i] = fmax((double)d.x * n[0] + (double)d.y * n[1] + (double)d.z * n[2], 0);
        }
    }
}

static void set_functions(const struct strata *s, struct strata_wave *wave, size_t fours,
                          struct vec3f normal)
{
    if (s->order) {
        sh_basis_wave(s->order, (const float(*)[3])wave->direction, wave->function);
        return;
    }
    for (int i = 0; i < s->functions && s->normal; i++)
        set_cosines(wave, fours, s->normal + 3 * i, wave->function[i]);
    if (s->normal)
        return;
    for (size_t k = 0; k < 4; k++)
        for (size_t f = 0; f < whole_lanes(fours); f++)
            wave->function[0][k * STRATA_FOURS + f] =
                fmax((double)vec3f_dot(wave->direction[k * STRATA_FOURS + f], normal), 0);
}

/* Adds the light of one channel times one function. */
static void add_product(struct strata_sum *to, size_t fours, const double (*light)[STRATA_FOURS],
                        const double (*y)[STRATA_FOURS])
{
    struct strata_sum sum = *to;
    for (size_t f = 0; f < fours; f += STRATA_LANES) {
        for (size_t j = 0; j < STRATA_LANES; j++) {
            const double a = light[0][f + j] * y[0][f + j] + light[3][f + j] * y[3][f + j];
            const double b = light[1][f + j] * y[1][f + j] + light[2][f + j] * y[2][f + j];
            const double square = (a - b) * (a - b);
            sum.sum[j] += a + b;
            sum.square[j] += square;
            sum.largest[j] = square > sum.largest[j] ? square : sum.largest[j];
        }
    }
    *to = sum;
}

void strata_add(struct strata *s, struct strata_wave *wave, size_t fours,
                const struct vec3f *direction, const struct vec3f *light, struct vec3f normal)
{
    set_directions(wave, fours, direction);
    set_functions(s, wave, fours, normal);
    strata_add_again(s, wave, fours, light);
}

void strata_add_again(struct strata *s, struct strata_wave *wave, size_t fours,
                      const struct vec3f *light)
{
    set_light(wave, fours, light);
    for (int c = 0; c < s->channels; c++)
        for (int i = 0; i < s->functions; i++)
            add_product(&s->of[c][i], fours, (const double(*)[STRATA_FOURS])wave->light[c],
                        (const double(*)[STRATA_FOURS])wave->function[i]);
}

double strata_sum(const struct strata *s, int channel, int function)
{
    const double *sum = s->of[channel][function].sum;
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double strata_variance(const struct strata *s, int channel, int function)
{
    const struct strata_sum *of = &s->of[channel][function];
    double square = 0, largest = 0;
    for (int j = 0; j < STRATA_LANES; j++) {
        square += of->square[j];
        largest = fmax(largest, of->largest[j]);
    }
    return square + largest;
}
