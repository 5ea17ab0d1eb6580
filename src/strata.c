#include "strata.h"

#include <math.h>
#include <string.h>

void strata_start(struct strata *s, int order, bool luminance)
{
    s->order = order;
    s->functions = order ? order * order : 1;
    s->channels = luminance ? 4 : 3;
    for (int c = 0; c < s->channels; c++)
        memset(s->of[c], 0, (size_t)s->functions * sizeof s->of[c][0]);
}

void strata_set(struct strata_wave *wave, size_t corner, size_t four, struct vec3f radiance, struct vec3f direction, float solid_angle)
{
    const double weight = (double)solid_angle;
    const double r = weight * (double)radiance.x, g = weight * (double)radiance.y, b = weight * (double)radiance.z;
    const size_t sample = corner * STRATA_FOURS + four;
    wave->direction[sample] = direction;
    wave->light[0][sample] = r;
    wave->light[1][sample] = g;
    wave->light[2][sample] = b;
    wave->light[3][sample] = 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/* Fours are added LANES at once: those that are not there add nothing. */
static size_t whole_lanes(size_t fours)
{
    return (fours + STRATA_LANES - 1) / STRATA_LANES * STRATA_LANES;
}

void strata_functions(const struct strata *s, struct strata_wave *wave, size_t fours, struct vec3f normal)
{
    for (size_t k = 0; k < 4; k++) {
        for (size_t f = fours; f < whole_lanes(fours); f++)
            wave->direction[k * STRATA_FOURS + f] = wave->direction[0];
        if (s->order)
            continue;
        for (size_t f = 0; f < whole_lanes(fours); f++)
            wave->function[0][k * STRATA_FOURS + f] = fmax((double)vec3f_dot(wave->direction[k * STRATA_FOURS + f], normal), 0);
    }
    if (s->order)
        sh_basis_wave(s->order, wave->direction, wave->function);
}

void strata_add(struct strata *s, struct strata_wave *wave, size_t fours)
{
    for (int c = 0; c < s->channels; c++) {
        double(*light)[STRATA_FOURS] = (double(*)[STRATA_FOURS])wave->light[c];
        for (size_t k = 0; k < 4; k++)
            for (size_t f = fours; f < whole_lanes(fours); f++)
                light[k][f] = 0;
        for (int i = 0; i < s->functions; i++) {
            const double(*y)[STRATA_FOURS] = (const double(*)[STRATA_FOURS])wave->function[i];
            struct strata_sum sum = s->of[c][i];
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
            s->of[c][i] = sum;
        }
    }
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
