/* Based on:
 * Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH 2001.
 *
 * Sums are made in one order, so light is the same bytes everywhere: ((w0 a + w1 b) + (w2 c + w3 d)), in floats.
 */
#include "sh.h"
#include "volume.h"

#include <string.h>

typedef float four __attribute__((vector_size(16)));
typedef uint32_t four_bits __attribute__((vector_size(16)));

static inline four load(const float *from)
{
    four v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline four mix(const four w[4], four a, four b, four c, four d)
{
    return (w[0] * a + w[1] * b) + (w[2] * c + w[3] * d);
}

/* What has no weight stands in for by what has most: it must not bring in a NaN, and 0 times that is 0. */
static inline void choose(const struct probe_place *place, float weight[4], size_t probe[4])
{
    int most = 0;
    if (place->weight[0] > 0 && place->weight[1] > 0 && place->weight[2] > 0 && place->weight[3] > 0) { /* nearly always */
        for (int i = 0; i < 4; i++) {
            weight[i] = (float)place->weight[i];
            probe[i] = (size_t)place->probe[i];
        }
        return;
    }
    for (int i = 1; i < 4; i++)
        most = place->weight[i] > place->weight[most] ? i : most;
    for (int i = 0; i < 4; i++) {
        weight[i] = (float)place->weight[i];
        probe[i] = (size_t)place->probe[place->weight[i] > 0 ? i : most];
    }
}

void probe_blend(const struct probe_place *place, const float *row, size_t width, float *out)
{
    float weight[4];
    size_t probe[4];
    choose(place, weight, probe);
    const float *a = row + probe[0] * width, *b = row + probe[1] * width, *c = row + probe[2] * width, *d = row + probe[3] * width;
    if (width < 4) {
        for (size_t k = 0; k < width; k++)
            out[k] = (weight[0] * a[k] + weight[1] * b[k]) + (weight[2] * c[k] + weight[3] * d[k]);
        return;
    }
    four w[4];
    for (int i = 0; i < 4; i++)
        w[i] = (four){weight[i], weight[i], weight[i], weight[i]};
    size_t k = 0;
    for (; k + 4 <= width; k += 4) {
        const four v = mix(w, load(a + k), load(b + k), load(c + k), load(d + k));
        memcpy(out + k, &v, sizeof v);
    }
    if (k < width) { /* the last four once more */
        k = width - 4;
        const four v = mix(w, load(a + k), load(b + k), load(c + k), load(d + k));
        memcpy(out + k, &v, sizeof v);
    }
}

/* -- halves -------------------------------------------------------------------------------------- */

/* Four halves (finite) as floats: the bits moved into place, and the exponent's bias made right by a product, which makes
 * subnormal halves right as well. */
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

static void blend_half(const struct probe_place *place, const uint16_t *row, float scale, size_t width, float *out)
{
    float weight[4];
    size_t probe[4];
    choose(place, weight, probe);
    four w[4];
    const uint16_t *r[4];
    for (int i = 0; i < 4; i++) {
        const float s = weight[i] * scale;
        w[i] = (four){s, s, s, s};
        r[i] = row + probe[i] * width;
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
        const four v = mix(w, load_half(at[0]), load_half(at[1]), load_half(at[2]), load_half(at[3]));
        memcpy(out + k, &v, (width < 4 ? width : 4) * sizeof *out);
    }
}

void probe_volume_light(const struct probe_volume *v, const struct probe_place *place, float *sh)
{
    const size_t width = (size_t)(3 * v->image.order * v->image.order);
    if (!width)
        return;
    if (v->image.packing == PROBE_PACK_HALF)
        blend_half(place, v->light, v->light_scale, width, sh);
    else
        probe_blend(place, v->light, width, sh);
}

/* -- irradiance ---------------------------------------------------------------------------------- */

/* Y_lm(n), up to order 3 (Ramamoorthi and Hanrahan 2001, eq. 3), times A_l (eq. 8) where cosine is set. */
static void basis_three(const float n[3], int cosine, float y[9])
{
    const float x = n[0], z = n[2], a0 = cosine ? 3.14159265f : 1, a1 = cosine ? 2.09439510f : 1, a2 = cosine ? 0.785398163f : 1;
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
    float y[9], r = 0, g = 0, b = 0;
    basis_three(normal, cosine, y);
    for (int i = 0; i < order * order; i++) {
        r += y[i] * sh[3 * i];
        g += y[i] * sh[3 * i + 1];
        b += y[i] * sh[3 * i + 2];
    }
    rgb[0] = r;
    rgb[1] = g;
    rgb[2] = b;
}

void probe_irradiance(int order, const float *sh, const float normal[3], float rgb[3])
{
    irradiance(order, sh, 1, normal, rgb);
}

void probe_irradiance_convolved(int order, const float *sh, const float normal[3], float rgb[3])
{
    irradiance(order, sh, 0, normal, rgb);
}
