/* SPDX-License-Identifier: Apache-2.0 */
/* Radiosity by gathering against closed forms: an integrating sphere, concentric spheres, two
 * parallel plates, and as many scatterings as are asked for; rays, which are right in the mean
 * alone, by z-scores. */
#include "trace/cache.h"
#include "base/array.h"
#include "base/error.h"
#include "math/random.h"
#include "support/tap.h"

#include <math.h>
#include <stdlib.h>

enum { DISCS = 600, RAYS = 64 };

/* Of a sphere every part sees every other alike, so rays end anywhere: E = D + albedo mean E. */
static void fill_sphere(struct cache_link *link, uint64_t seed, float albedo)
{
    for (size_t i = 0; i < (size_t)DISCS * RAYS; i++) {
        struct random r = random_start(seed, i, 0);
        link[i] = (struct cache_link){random_u32(&r) % DISCS, {albedo, albedo / 2, 0}};
    }
}

static void test_sphere(void)
{
    struct cache_link *link = NULL;
    float direct[3 * DISCS], value[3 * DISCS];
    must(array_create(&link, (size_t)DISCS * RAYS, sizeof *link));
    enum { SETS = 16 };
    for (int bright = 0; bright < 2; bright++) {
        const float albedo = bright ? 0.9f : 0.5f;
        double sum = 0, squares = 0, other = 0, none = 0;
        for (uint64_t set = 0; set < SETS; set++) {
            double mean = 0, green = 0;
            fill_sphere(link, set, albedo);
            for (size_t i = 0; i < DISCS; i++) /* light on a cap, as through a port */
                direct[3 * i] = direct[3 * i + 1] = direct[3 * i + 2] = i < DISCS / 10 ? 10 : 0;
            must(cache_solve(DISCS, RAYS, NULL, direct, link, 1000, 2, value));
            for (size_t i = 0; i < DISCS; i++) {
                mean += (double)value[3 * i] / DISCS;
                green += (double)value[3 * i + 1] / DISCS;
                none = fmax(none, fabs((double)(value[3 * i + 2] - direct[3 * i + 2])));
            }
            sum += mean;
            squares += mean * mean;
            other += green / SETS;
        }
        const double mean = sum / SETS, error = sqrt((squares / SETS - mean * mean) / (SETS - 1)),
                     expected = 1 / (1 - (double)albedo), z = (mean - expected) / error;
        ok(fabs(z) < 4 && error < 0.05 * expected, "a sphere of albedo %g: %g, z %.2f",
           (double)albedo, mean, z);
        ok(fabs(other * (1 - (double)albedo / 2) - 1) < 0.02, "and in another colour: %g", other);
        ok(!(none > 0), "nothing where nothing is reflected");
    }
    free(link);
}

/* The inner sphere sees the outer one alone; from there, a ray meets the inner one where the sine
 * of its angle is at most the ratio of their radii, and sin^2 of rays by the cosine is uniform. */
static void test_spheres(void)
{
    enum { SETS = 16, INNER = DISCS / 4, OUTER = DISCS - INNER };
    const float a1 = 0.8f, a2 = 0.5f, d1 = 3, d2 = 1, seen = 0.36f; /* radii .6 and 1 */
    struct cache_link *link = NULL;
    float direct[3 * DISCS], value[3 * DISCS];
    double sum[2] = {0}, squares[2] = {0};
    must(array_create(&link, (size_t)DISCS * RAYS, sizeof *link));
    for (size_t k = 0; k < 3 * (size_t)DISCS; k++)
        direct[k] = k < 3 * (size_t)INNER ? d1 : d2;
    for (uint64_t set = 0; set < SETS; set++) {
        double mean[2] = {0};
        for (size_t i = 0; i < (size_t)DISCS * RAYS; i++) {
            struct random r = random_start(set, i, 1);
            const bool inner = i / RAYS >= INNER && random_float(&r) < seen;
            const uint32_t disc = inner ? random_u32(&r) % INNER : INNER + random_u32(&r) % OUTER;
            const float a = inner ? a1 : a2;
            link[i] = (struct cache_link){disc, {a, a, a}};
        }
        must(cache_solve(DISCS, RAYS, NULL, direct, link, 1000, 2, value));
        for (size_t i = 0; i < DISCS; i++)
            mean[i >= INNER] += (double)value[3 * i] / (i < INNER ? INNER : OUTER);
        for (int k = 0; k < 2; k++) {
            sum[k] += mean[k];
            squares[k] += mean[k] * mean[k];
        }
    }
    const double q = (double)seen, b1 = (double)a1, b2 = (double)a2,
                 outer = ((double)d2 + q * b1 * (double)d1) / (1 - q * b1 * b2 - (1 - q) * b2),
                 expected[2] = {(double)d1 + b2 * outer, outer};
    for (int k = 0; k < 2; k++) {
        const double mean = sum[k] / SETS,
                     error = sqrt((squares[k] / SETS - mean * mean) / (SETS - 1)),
                     z = (mean - expected[k]) / error;
        ok(fabs(z) < 4 && error < 0.02 * expected[k], "concentric spheres, %s: %g, z %.2f",
           k ? "outer" : "inner", mean, z);
    }
    free(link);
}

/* Endless plates see each other alone: E1 = D1 + a2 E2, E2 = D2 + a1 E1. */
static void test_plates(void)
{
    const float a1 = 0.3f, a2 = 0.8f;
    struct cache_link link[2 * RAYS];
    const float direct[6] = {1, 1, 1, 0.25f, 0.25f, 0.25f};
    float value[6], few[6], one[6];
    for (size_t r = 0; r < RAYS; r++) {
        link[r] = (struct cache_link){1, {a2, a2, a2}};
        link[RAYS + r] = (struct cache_link){0, {a1, a1, a1}};
    }
    must(cache_solve(2, RAYS, NULL, direct, link, 1000, 1, value));
    const double e1 = (1 + 0.8 * 0.25) / (1 - 0.24), e2 = (0.25 + 0.3) / (1 - 0.24);
    ok(fabs((double)value[0] / e1 - 1) < 1e-4 && fabs((double)value[3] / e2 - 1) < 1e-4,
       "parallel plates: %g, %g", (double)value[0], (double)value[3]);
    must(cache_solve(2, RAYS, NULL, direct, link, 2, 1, few));
    ok(fabs((double)few[0] - 1.2) < 1e-6 && fabs((double)few[3] - 0.55) < 1e-6,
       "light that scattered twice: %g, %g", (double)few[0], (double)few[3]);
    must(cache_solve(2, RAYS, NULL, direct, link, 1, 1, one));
    ok(fabs((double)one[0] - 1) < 1e-6 && fabs((double)one[3] - 0.25) < 1e-6, "and once");
    must(cache_solve(2, RAYS, direct, direct, link, 1, 1, few));
    ok(fabs((double)few[0] - 1.2) < 1e-6 && fabs((double)few[3] - 0.55) < 1e-6,
       "what comes straight and then scattered once: %g, %g", (double)few[0], (double)few[3]);
    for (size_t r = 1; r < 2 * RAYS; r += 2)
        link[r].disc = CACHE_NONE; /* half of the rays end at no disc */
    must(cache_solve(2, RAYS, NULL, direct, link, 2, 1, few));
    ok(fabs((double)few[0] - 1.1) < 1e-6, "rays that end elsewhere bring nothing: %g",
       (double)few[0]);
}

int main(void)
{
    test_sphere();
    test_spheres();
    test_plates();
    return tap_done();
}
