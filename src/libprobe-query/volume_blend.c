/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH
 * 2001.
 *
 * Sums are made in one order, so light is the same bytes everywhere: ((w0 a + w1 b) + (w2 c + w3
 * d)), in floats.
 */
#include "half.h"
#include "sh.h"
#include "volume.h"

#include <math.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

typedef float four __attribute__((vector_size(16)));
typedef uint32_t four_bits __attribute__((vector_size(16)));

static inline four load(const float *from)
{
    four v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* What is blended: rows of probes, with their weights, each four times. */
struct blend {
    four weight[4];
    size_t probe[4];
};

static inline four mix(const struct blend *with, four a, four b, four c, four d)
{
    return (with->weight[0] * a + with->weight[1] * b) +
           (with->weight[2] * c + with->weight[3] * d);
}

/* What has no weight stands in for by what has most: it must not bring in a NaN, and 0 times that
 * is 0. */
__attribute__((noinline)) static void replace(const struct probe_place *place, size_t probe[4])
{
    int most = 0;
    for (int i = 1; i < 4; i++)
        most = place->weight[i] > place->weight[most] ? i : most;
    for (int i = 0; i < 4; i++)
        probe[i] = (size_t)place->probe[place->weight[i] > 0 ? i : most];
}

static inline void choose(const struct probe_place *place, struct blend *with)
{
    const double *w = place->weight;
    for (int i = 0; i < 4; i++) {
        const float weight = (float)w[i];
        with->weight[i] = (four){weight, weight, weight, weight};
    }
    with->probe[0] = (size_t)place->probe[0];
    with->probe[1] = (size_t)place->probe[1];
    with->probe[2] = (size_t)place->probe[2];
    with->probe[3] = (size_t)place->probe[3];
    if (!(w[0] > 0 && w[1] > 0 && w[2] > 0 && w[3] > 0))
        replace(place, with->probe);
}

/* Four at a time; the last four, some of them once more. width >= 4. */
static void blend_fours(const struct blend *with, const float *const row[4], size_t width,
                        float *out)
{
    const float *a = row[0], *b = row[1], *c = row[2], *d = row[3];
    size_t k = 0;
    for (; k + 4 < width; k += 4) {
        const four v = mix(with, load(a + k), load(b + k), load(c + k), load(d + k));
        memcpy(out + k, &v, sizeof v);
    }
    k = width - 4;
    const four v = mix(with, load(a + k), load(b + k), load(c + k), load(d + k));
    memcpy(out + k, &v, sizeof v);
}

#if defined(__x86_64__)
/* The same eight at a time, for processors that can; without fused operations, so the same bits.
 * width >= 8. */
__attribute__((target("avx"))) static void blend_eights(const struct blend *with,
                                                        const float *const row[4], size_t width,
                                                        float *out)
{
    const __m256 w0 = _mm256_set1_ps(with->weight[0][0]), w1 = _mm256_set1_ps(with->weight[1][0]),
                 w2 = _mm256_set1_ps(with->weight[2][0]), w3 = _mm256_set1_ps(with->weight[3][0]);
    for (size_t k = 0;; k += 8) {
        k = k + 8 < width ? k : width - 8;
        const __m256 ab = _mm256_add_ps(_mm256_mul_ps(w0, _mm256_loadu_ps(row[0] + k)),
                                        _mm256_mul_ps(w1, _mm256_loadu_ps(row[1] + k)));
        const __m256 cd = _mm256_add_ps(_mm256_mul_ps(w2, _mm256_loadu_ps(row[2] + k)),
                                        _mm256_mul_ps(w3, _mm256_loadu_ps(row[3] + k)));
        _mm256_storeu_ps(out + k, _mm256_add_ps(ab, cd));
        if (k + 8 == width)
            break;
    }
    _mm256_zeroupper();
}

static bool has_eights(void)
{
    return __builtin_cpu_supports("avx");
}
#else
static void blend_eights(const struct blend *with, const float *const row[4], size_t width,
                         float *out)
{
    blend_fours(with, row, width, out);
}

static bool has_eights(void)
{
    return false;
}
#endif

/* Rows begin `stride` behind one another. */
static inline __attribute__((always_inline)) void blend_floats(const struct probe_place *place,
                                                               const float *row, size_t stride,
                                                               size_t width, float *out)
{
    struct blend with;
    choose(place, &with);
    const float *const rows[4] = {row + with.probe[0] * stride, row + with.probe[1] * stride,
                                  row + with.probe[2] * stride, row + with.probe[3] * stride};
    if (width >= 8 && has_eights())
        blend_eights(&with, rows, width, out);
    else if (width >= 4)
        blend_fours(&with, rows, width, out);
    else
        for (size_t k = 0; k < width; k++)
            out[k] = mix(&with, (four){rows[0][k]}, (four){rows[1][k]}, (four){rows[2][k]},
                         (four){rows[3][k]})[0];
}

void probe_blend(const struct probe_place *place, const float *row, size_t width, float *out)
{
    blend_floats(place, row, width, width, out);
}

/* -- halves ----------------------------------------------------------------------------------- */

/* Four halves (finite) as floats: the bits moved into place, and the exponent's bias made right by
 * a product, which makes subnormal halves right as well. */
static inline four load_half(const uint16_t *from)
{
    const four_bits h = {from[0], from[1], from[2], from[3]};
    const four_bits bits = (h & 0x7fff) << 13, sign = (h & 0x8000) << 16;
    four v;
    memcpy(&v, &bits, sizeof v);
    v *= 0x1p112f;
    four_bits out;
    memcpy(&out, &v, sizeof v);
    out |= sign;
    memcpy(&v, &out, sizeof v);
    return v;
}

static void blend_half(const struct probe_place *place, const uint16_t *row, float scale,
                       size_t stride, size_t width, float *out)
{
    struct blend with;
    const uint16_t *r[4];
    choose(place, &with);
    for (int i = 0; i < 4; i++) {
        with.weight[i] *= scale;
        r[i] = row + with.probe[i] * stride;
    }
    for (size_t k = 0; k < width; k += 4) {
        if (k + 4 > width && width >= 4)
            k = width - 4;
        uint16_t tail[4][4] = {{0}};
        const uint16_t *at[4] = {r[0] + k, r[1] + k, r[2] + k, r[3] + k};
        for (int i = 0; i < 4 && width < 4; i++) {
            memcpy(tail[i], r[i], width * sizeof *tail[i]);
            at[i] = tail[i];
        }
        const four v =
            mix(&with, load_half(at[0]), load_half(at[1]), load_half(at[2]), load_half(at[3]));
        memcpy(out + k, &v, (width < 4 ? width : 4) * sizeof *out);
    }
}

void probe_volume_light(const struct probe_volume *v, const struct probe_place *place, float *sh)
{
    const size_t width = (size_t)(3 * v->image.order * v->image.order);
    if (!width)
        return;
    if (v->image.packing == PROBE_PACK_HALF)
        blend_half(place, v->light, v->light_scale, width, width, sh);
    else
        probe_blend(place, v->light, width, sh);
}

/* -- groups of lights ------------------------------------------------------------------------- */

enum { WIDTH_MOST = 108 };

static bool is_black(const float weight[3])
{
    return weight[0] == 0 && weight[1] == 0 && weight[2] == 0;
}

void probe_volume_light_weighted(const struct probe_volume *v, const struct probe_place *place,
                                 const float *weight, float *sh)
{
    const size_t width = (size_t)(3 * v->image.order * v->image.order), stride = width * v->groups;
    float light[WIDTH_MOST];
    memset(sh, 0, width * sizeof *sh);
    for (size_t g = 0; g < v->groups; g++) {
        const float *const w = weight + 3 * g;
        if (is_black(w))
            continue;
        if (v->image.packing == PROBE_PACK_HALF)
            blend_half(place, (const uint16_t *)v->group_light + g * width, v->light_scale, stride,
                       width, light);
        else
            blend_floats(place, (const float *)v->group_light + g * width, stride, width, light);
        for (size_t k = 0; k < width; k += 3)
            for (size_t c = 0; c < 3; c++)
                sh[k + c] += w[c] * light[k + c];
    }
}

/* Sums are of doubles, group after group, as those of probe-relight. at: of the row of the probe's
 * first group. */
static void relight_row(const struct probe_volume *v, const float *weight, size_t width, size_t at,
                        float *sh)
{
    double sum[WIDTH_MOST] = {0};
    float light[WIDTH_MOST];
    for (size_t g = 0; g < v->groups; g++, at += width) {
        const float *from = (const float *)v->group_light + at;
        const double w[3] = {(double)weight[3 * g], (double)weight[3 * g + 1],
                             (double)weight[3 * g + 2]};
        if (is_black(weight + 3 * g))
            continue;
        if (v->image.packing == PROBE_PACK_HALF) {
            const uint16_t *half = (const uint16_t *)v->group_light + at;
            for (size_t k = 0; k < width; k++)
                light[k] = v->light_scale * half_value(half[k]);
            from = light;
        }
        for (size_t k = 0; k < width; k += 3)
            for (size_t c = 0; c < 3; c++)
                sum[k + c] += w[c] * (double)from[k + c];
    }
    for (size_t k = 0; k < width; k++)
        sh[k] = (float)sum[k];
}

enum probe_status probe_volume_relight(const struct probe_volume *v, const float *weight, float *sh)
{
    const size_t width = (size_t)(3 * v->image.order * v->image.order);
    if (!v->groups)
        return PROBE_NO_GROUPS;
    for (size_t i = 0; i < 3 * v->groups; i++)
        if (!(fabsf(weight[i]) < INFINITY))
            return PROBE_BAD_ARGUMENT;
    for (size_t i = 0; i < v->probes; i++)
        relight_row(v, weight, width, i * v->groups * width, sh + i * width);
    return PROBE_OK;
}

/* -- irradiance ------------------------------------------------------------------------------- */

/* Y_lm(n), up to order 3 (Ramamoorthi and Hanrahan 2001, eq. 3), times A_l (eq. 8) where cosine is
 * set. */
static void basis_three(const float n[3], int cosine, float y[9])
{
    const float x = n[0], z = n[2], a0 = cosine ? 3.14159265f : 1, a1 = cosine ? 2.09439510f : 1,
                a2 = cosine ? 0.785398163f : 1;
    const float c1 = 0.488602512f * a1, c2 = 1.092548431f * a2;
    y[0] = 0.282094792f * a0;
    y[1] = c1 * n[1];
    y[2] = c1 * z;
    y[3] = c1 * x;
    y[4] = c2 * (x * n[1]);
    y[5] = c2 * (n[1] * z);
    y[6] = 0.315391565f * a2 * (3 * z * z - 1);
    y[7] = c2 * (x * z);
    y[8] = 0.546274215f * a2 * (x * x - n[1] * n[1]);
}

/* Sum of y[i] sh[i] for red, green, blue, and the next red for nobody. */
static inline __attribute__((always_inline)) four weighted_sum(int count, const float *y,
                                                               const float *sh)
{
    four sum = {0};
    const float *last = sh + 3 * (count - 1); /* there is no next */
#pragma GCC unroll 8
    for (int i = 0; i < count - 1; i++)
        sum += y[i] * load(sh + 3 * i);
    return sum + y[count - 1] * (four){last[0], last[1], last[2]};
}

static void irradiance(int order, const float *sh, int cosine, const float normal[3], float rgb[3])
{
    if (order > 3) {
        const double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
        double e[3];
        sh_irradiance(order, sh, !cosine, n, e);
        for (int k = 0; k < 3; k++)
            rgb[k] = (float)e[k];
        return;
    }
    float y[9];
    four sum;
    basis_three(normal, cosine, y);
    /* the usual one is unrolled */
    sum = order == 3 ? weighted_sum(9, y, sh) : weighted_sum(order * order, y, sh);
    rgb[0] = sum[0];
    rgb[1] = sum[1];
    rgb[2] = sum[2];
}

void probe_irradiance(int order, const float *sh, const float normal[3], float rgb[3])
{
    irradiance(order, sh, 1, normal, rgb);
}

void probe_irradiance_convolved(int order, const float *sh, const float normal[3], float rgb[3])
{
    irradiance(order, sh, 0, normal, rgb);
}
