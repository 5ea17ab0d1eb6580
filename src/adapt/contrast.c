/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/contrast.h"
#include "math/angle.h"

#include <math.h>

const char *const contrast_kind_names[] = {[CONTRAST_RMS] = "rms",
                                           [CONTRAST_SIX] = "six",
                                           [CONTRAST_TWENTYSIX] = "twentysix",
                                           [CONTRAST_MSE] = "mse",
                                           NULL};
const char *const contrast_form_names[] = {
    [CONTRAST_ABSOLUTE] = "absolute", [CONTRAST_RELATIVE] = "relative", NULL};

#define LEAST_SHARE 1e-3 /* of the mean, that relative contrasts are of at the least */

static double cosine_of(int i)
{
    int l = 0;
    while ((l + 1) * (l + 1) <= i)
        l++;
    return sh_cosine(l);
}

struct contrast contrast_make(enum contrast_kind kind, enum contrast_form form, int order,
                              double mean)
{
    struct contrast c = {.kind = kind, .form = form, .order = order, .mean = mean};
    int n = 0;
    for (int axes = 1; axes <= 3; axes++) /* that a direction is a sum of */
        for (int i = 0; i < 27; i++) {
            const int d[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
            const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] != axes)
                continue;
            const double unit[3] = {d[0] / length, d[1] / length, d[2] / length};
            sh_basis(order, unit, c.basis[n]);
            for (int k = 0; k < order * order; k++)
                c.basis[n][k] *= cosine_of(k);
            n++;
        }
    return c;
}

double contrast_mean(int order, size_t count, const float *sh)
{
    const size_t width = 3 * (size_t)order * (size_t)order;
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            sum += (double)sh[width * i + (size_t)k];
    return count ? sum * sh_cosine(0) * SH_Y00 / (3 * (double)count) : 0;
}

static double share(const struct contrast *c, double difference, double sum)
{
    const double least = c->mean * LEAST_SHARE,
                 of = c->form == CONTRAST_ABSOLUTE ? c->mean : fmax(sum, least);
    return difference > 0 && of > 0 ? difference / of : 0;
}

static double irradiance(const struct contrast *c, const float *sh, int direction, int channel)
{
    double e = 0;
    for (int i = 0; i < c->order * c->order; i++)
        e += c->basis[direction][i] * (double)sh[3 * i + channel];
    return fmax(e, 0);
}

static double largest(const struct contrast *c, int directions, const float *a, const float *b)
{
    double most = 0;
    for (int d = 0; d < directions; d++)
        for (int k = 0; k < 3; k++) {
            const double ea = irradiance(c, a, d, k), eb = irradiance(c, b, d, k);
            most = fmax(most, share(c, fabs(ea - eb), ea + eb));
        }
    return most;
}

/* Mean square of irradiance by the difference of two SH, or where b is NULL by one. */
static double mean_difference(const struct contrast *c, const float *a, const float *b)
{
    double sum = 0;
    for (int i = 0; i < c->order * c->order; i++) {
        const double cosine = cosine_of(i);
        for (int k = 0; k < 3; k++) {
            const double d = cosine * ((double)a[3 * i + k] - (b ? (double)b[3 * i + k] : 0));
            sum += d * d;
        }
    }
    return sum / (3 * 4 * ANGLE_PI);
}

static double mean_square(const struct contrast *c, const float *a, const float *b)
{
    const int n = 3 * c->order * c->order;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        const double d = (double)a[i] - (double)b[i];
        sum += d * d;
    }
    return sum / n;
}

double contrast(const struct contrast *c, const float *a, const float *b)
{
    return contrast_clean(c, a, b, 0);
}

double contrast_clean(const struct contrast *c, const float *a, const float *b, double noise)
{
    switch (c->kind) {
    case CONTRAST_SIX: return largest(c, 6, a, b);
    case CONTRAST_TWENTYSIX: return largest(c, CONTRAST_DIRECTIONS, a, b);
    case CONTRAST_MSE: return mean_square(c, a, b);
    default:
        return share(c, sqrt(fmax(mean_difference(c, a, b) - noise, 0)),
                     sqrt(mean_difference(c, a, NULL)) + sqrt(mean_difference(c, b, NULL)));
    }
}
