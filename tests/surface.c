/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces of libprobe-query: they answer as discs do, to the bit, out of arrays and out of packed
 * files; halves within what halves cost; and a file that lies is refused, or answers all the same.
 */
#include "interpolate/discs.h"
#include "libprobe-query/probe-query.h"
#include "math/random.h"
#include "support/tap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

enum { POINTS = 300, PLACES = 2000, HEADER = 128, FLIPS = 2000 };

struct set {
    double position[3 * POINTS];
    float normal[3 * POINTS], radius[POINTS], irradiance[3 * POINTS];
};

static void any_set(struct set *s)
{
    struct random r = random_start(5, 6, 7);
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            s->position[3 * i + k] = 1000 + 4 * (k + 1) * random_double(&r);
            s->normal[3 * i + k] = random_float(&r) - 0.5f;
            s->irradiance[3 * i + k] = 5 * random_float(&r);
        }
        s->radius[i] = i % 50 == 7 ? NAN : 0.2f + 3 * random_float(&r) * random_float(&r);
    }
}

static void any_place(struct random *r, double p[3], float n[3])
{
    float square = 0;
    for (int k = 0; k < 3; k++) {
        p[k] = 999 + (4 * (k + 1) + 2) * random_double(r);
        n[k] = random_float(r) - 0.5f;
        square += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] /= sqrtf(square + 1e-9f);
}

static struct probe_discs arrays_of(const struct set *s)
{
    return (struct probe_discs){POINTS, s->position, s->normal, s->radius, s->irradiance};
}

static struct probe_surface *surface_of(const struct set *s)
{
    const struct probe_discs of = arrays_of(s);
    struct probe_surface *surface;
    if (probe_surface_create(&surface, &of, NULL))
        bail("no surface");
    return surface;
}

/* The bytes of a packed surface; the caller's. */
static char *packed(const struct probe_surface *surface, enum probe_packing packing, size_t *size)
{
    *size = probe_surface_pack(surface, packing, NULL, 0);
    char *image = aligned_alloc(64, *size);
    if (!image || probe_surface_pack(surface, packing, image, *size) != *size)
        bail("not packed");
    return image;
}

/* Places where it does not answer as discs do; *most: by how much at the most. */
static int unlike(const struct probe_surface *surface, const struct set *s, float *most)
{
    const struct disc_points points = {POINTS, s->position, s->normal, s->radius};
    struct random r = random_start(8, 9, 10);
    struct discs *discs;
    int wrong = 0;
    must(discs_create(&discs, &points));
    *most = 0;
    for (int i = 0; i < PLACES; i++) {
        double p[3], n[3];
        float normal[3], out[3] = {0}, rgb[3];
        int covered;
        any_place(&r, p, normal);
        for (int k = 0; k < 3; k++)
            n[k] = (double)normal[k];
        const enum discs_answer answer = discs_blend(discs, p, n, 1 + i % 3, s->irradiance, 3, out);
        const enum probe_status status =
            probe_surface_irradiance(surface, p, normal, 1 + i % 3, rgb, &covered);
        wrong += memcmp(out, rgb, sizeof rgb) != 0 || covered != (answer == DISCS_COVERED) ||
                 status != (answer == DISCS_NONE ? PROBE_NO_DISCS : PROBE_OK);
        for (int k = 0; k < 3; k++)
            *most = fmaxf(*most, fabsf(out[k] - rgb[k]));
    }
    discs_destroy(discs);
    return wrong;
}

static void must_open(struct probe_surface **surface, const char *image, size_t size)
{
    if (probe_surface_open(surface, image, size, NULL))
        bail("not opened");
}

static void answers(void)
{
    struct set s;
    float most;
    size_t size, halves;
    any_set(&s);
    struct probe_surface *surface = surface_of(&s), *again;
    ok(!unlike(surface, &s, &most) && probe_surface_probes(surface) == POINTS - POINTS / 50,
       "of arrays: as discs, to the bit, but for those without a radius");
    char *image = packed(surface, PROBE_PACK_FLOAT, &size),
         *half = packed(surface, PROBE_PACK_HALF, &halves);
    ok(!probe_surface_open(&again, image, size, NULL) && !unlike(again, &s, &most),
       "and of a packed file");
    size_t size_again;
    char *image_again = packed(again, PROBE_PACK_FLOAT, &size_again);
    ok(size == size_again && !memcmp(image, image_again, size),
       "which is packed to the same bytes");
    free(image_again);
    probe_surface_destroy(again);
    must_open(&again, half, halves);
    const int others = unlike(again, &s, &most);
    ok(halves < size && others && most > 0 && most < 5 * 0x1p-11f,
       "halves are off by no more than they cost: %g", (double)most);
    probe_surface_destroy(again);
    probe_surface_destroy(surface);
    free(image);
    free(half);
}

static void refused(void)
{
    struct set s;
    size_t row, size;
    struct probe_surface *surface;
    any_set(&s);
    struct probe_discs of = arrays_of(&s);
    const float keep = s.irradiance[3 * 20];
    s.irradiance[3 * 20] = NAN;
    ok(probe_surface_create(&surface, &of, &row) == PROBE_BAD_DISC && row == 20 && !surface,
       "irradiance that is not finite");
    s.irradiance[3 * 20] = keep;
    s.position[3 * 30] = (double)INFINITY;
    ok(probe_surface_create(&surface, &of, &row) == PROBE_BAD_POSITION && row == 30, "a position");
    any_set(&s);
    of.probes = 0;
    ok(probe_surface_create(&surface, &of, NULL) == PROBE_NO_DISCS, "no probes");
    surface = surface_of(&s);
    const double p[3] = {1001, 1001, 1001}, off[3] = {(double)NAN, 0, 0};
    const float n[3] = {0, 0, 1}, no[3] = {0, (float)INFINITY, 0};
    float rgb[3];
    ok(probe_surface_irradiance(surface, off, n, 1, rgb, NULL) == PROBE_BAD_POINT &&
           probe_surface_irradiance(surface, p, no, 1, rgb, NULL) == PROBE_BAD_POINT &&
           probe_surface_irradiance(surface, p, n, 4, rgb, NULL) == PROBE_BAD_ARGUMENT &&
           !probe_surface_pack(surface, (enum probe_packing)7, NULL, 0),
       "a point, a normal, a falloff and a packing that cannot be");
    char *image = packed(surface, PROBE_PACK_HALF, &size);
    struct probe_surface *none;
    ok(probe_surface_open(&none, image, size - 64, NULL) == PROBE_BAD_IMAGE &&
           probe_surface_open(&none, image, 9, NULL) == PROBE_BAD_IMAGE &&
           probe_surface_open(&none, image + 4, size - 4, NULL) == PROBE_BAD_ARGUMENT &&
           probe_surface_open(&none, "something else", 4, NULL) != PROBE_OK,
       "files cut short, elsewhere in memory, or others");
    image[size / 2] ^= 1;
    ok(probe_surface_open(&none, image, size, NULL) == PROBE_BAD_IMAGE, "a bit that changed");
    free(image);
    probe_surface_destroy(surface);
}

/* Bits of a file change, and its checksum is made right. */
static void liars(void)
{
    struct set s;
    size_t size, taken = 0, denied = 0, wrong = 0;
    any_set(&s);
    struct probe_surface *surface = surface_of(&s);
    char *image = packed(surface, PROBE_PACK_HALF, &size), *lie = aligned_alloc(64, size);
    struct random r = random_start(1, 2, 3);
    if (!lie)
        bail("memory is short");
    for (int i = 0; i < FLIPS; i++) {
        const size_t at = i % 2 ? 16 + random_u32(&r) % (HEADER - 16) : random_u32(&r) % size;
        memcpy(lie, image, size);
        lie[at] ^= (char)(1 << random_u32(&r) % 8);
        const uint64_t sum = XXH3_64bits(lie + 16, size - 16);
        memcpy(lie + 8, &sum, sizeof sum);
        struct probe_surface *of;
        if (probe_surface_open(&of, lie, size, NULL)) {
            denied++;
            wrong += of != NULL;
            continue;
        }
        taken++;
        for (int k = 0; k < 20; k++) {
            double p[3];
            float n[3], rgb[3];
            any_place(&r, p, n);
            probe_surface_irradiance(of, p, n, 1, rgb, NULL);
            wrong += isfinite(rgb[0] + rgb[1] + rgb[2]) ? 0 : 1;
        }
        probe_surface_destroy(of);
    }
    ok(taken > FLIPS / 10 && denied > FLIPS / 10 && !wrong,
       "of files that lie %zu are refused, and %zu answer with finite light", denied, taken);
    free(lie);
    free(image);
    probe_surface_destroy(surface);
}

int main(void)
{
    answers();
    refused();
    liars();
    return tap_done();
}
