/* SPDX-License-Identifier: Apache-2.0 */
/* Light of surfaces whose emission is a picture: against its integral over small pieces of them;
 * how often the error holds it, and what is said where nothing was found. */
#include "libprobe-query/sh.h"
#include "math/luminance.h"
#include "math/random.h"
#include "scene/scene_shade.h"
#include "support/capture_bench.h"

/* An emissive picture on a square in the open, or what else stands there. */
struct sign {
    const char *name;
    uint32_t width, height;
    enum scene_wrap wrap;
    bool nearest;
    float turn[6]; /* of texture coordinates */
    float (*texel)(uint32_t x, uint32_t y);
    bool cut;   /* the picture is of alpha, and cuts out an even light */
    int pieces; /* of a side, to integrate */
};

static float window(uint32_t x, uint32_t y)
{
    return x / 8 == 12 && y / 8 == 37 ? 1000 : 0;
}

static float screen(uint32_t x, uint32_t y)
{
    return x == 100 && y == 300 ? 1e5f : 0.3f;
}

/* Strokes, in about a twelfth of it. */
static float letters(uint32_t x, uint32_t y)
{
    const bool line = y / 32 % 4 == 1, stroke = (x / 8 * 2654435761u >> 16) % 3 == 0;
    return line && stroke ? 20 : 0;
}

static float tile(uint32_t x, uint32_t y)
{
    return x / 4 == 3 && y / 4 == 9 ? 500 : 0;
}

static float dot(uint32_t x, uint32_t y)
{
    return x / 2 == 1500 && y / 2 == 200 ? 1e6f : 0;
}

static float noise(uint32_t x, uint32_t y)
{
    const struct random r = random_start(5, x, y);
    return r.state[0] % 200 == 0 ? 100 : 0.1f;
}

static float even(uint32_t x, uint32_t y)
{
    return 3 + 0 * (float)(x + y);
}

#define AS_IT_IS                                                                                   \
    {                                                                                              \
        1, 0, 0, 0, 1, 0                                                                           \
    }

static const struct sign signs[] = {
    {"one lit window", 512, 512, SCENE_REPEAT, false, AS_IT_IS, window, false, 2048},
    {"the same, not smoothed", 512, 512, SCENE_CLAMP, true, AS_IT_IS, window, false, 2048},
    {"a bright texel on a blue screen", 512, 512, SCENE_REPEAT, false, AS_IT_IS, screen, false,
     2048},
    {"letters", 512, 256, SCENE_CLAMP, false, AS_IT_IS, letters, false, 1024},
    {"tiles", 64, 64, SCENE_REPEAT, false, {20, 0, 0.3f, 0, 20, -3.7f}, tile, false, 2560},
    {"mirrored tiles", 64, 48, SCENE_MIRROR, false, {5, 0, -2.2f, 0, 3, 0}, tile, false, 1280},
    {"a picture that ends", 64, 64, SCENE_CLAMP, false, {3, 0, -1, 0, 3, -1}, tile, false, 1024},
    {"a turned picture",
     64,
     64,
     SCENE_REPEAT,
     false,
     {1.2f, -1.6f, 0.1f, 1.6f, 1.2f, 0},
     tile,
     false,
     1024},
    {"two texels of a large picture", 4096, 512, SCENE_REPEAT, false, AS_IT_IS, dot, false, 4096},
    {"stars", 256, 256, SCENE_REPEAT, false, AS_IT_IS, noise, false, 1024},
    {"an even picture", 16, 16, SCENE_REPEAT, false, AS_IT_IS, even, false, 512},
    {"one place of a picture",
     64,
     64,
     SCENE_REPEAT,
     false,
     {0, 0, 0.2f, 0, 0, 0.4f},
     tile,
     false,
     512},
    {"what is cut out of a light", 512, 512, SCENE_REPEAT, false, AS_IT_IS, window, true, 2048},
};

static void start_sign(struct bench *b, const struct sign *sign)
{
    const size_t count = (size_t)sign->width * sign->height;
    const unsigned channels = sign->cut ? 1 : 3;
    float *texel;
    bench_start(b);
    must(array_create(&texel, channels * count, sizeof *texel));
    for (size_t i = 0; i < count; i++) {
        const float value = sign->texel((uint32_t)(i % sign->width), (uint32_t)(i / sign->width));
        for (unsigned c = 0; c < channels; c++)
            texel[channels * i + c] = sign->cut ? value / 1000 : value;
    }
    struct scene_map map = {.texture = add_texture(b, sign->width, sign->height, channels, texel)};
    free(texel);
    memcpy(map.transform, sign->turn, sizeof map.transform);
    b->scene->textures[map.texture].nearest = sign->nearest;
    b->scene->textures[map.texture].wrap_u = b->scene->textures[map.texture].wrap_v = sign->wrap;
    struct scene_material m = material(0, sign->cut ? 1000 : 1);
    if (sign->cut)
        m.alpha_map = map;
    else
        m.emission_map = map;
    m.alpha = sign->cut ? SCENE_CUTOUT : SCENE_OPAQUE;
    add_quad(b, (const double[12]){-5, 0, 0, 5, 0, 0, 5, 10, 0, -5, 10, 0}, m);
    map_quad(b);
    bench_finish(b, 1);
}

/* L_00 in luminance at p: radiance times solid angle of small squares. */
static double sign_truth(const struct bench *b, int pieces, const double p[3])
{
    const struct scene_material *m = &b->scene->materials[b->scene->meshes[0].material[0]];
    double sum = 0;
    for (int j = 0; j < pieces; j++) {
        for (int i = 0; i < pieces; i++) {
            const double u = (i + 0.5) / pieces, v = (j + 0.5) / pieces, x = 10 * u - 5 - p[0],
                         y = 10 * v - p[1], z = -p[2], d2 = x * x + y * y + z * z;
            const struct vec3f l = scene_emission(b->scene, m, (float)u, (float)v);
            const float there = 1 - scene_transparency(b->scene, m, (float)u, (float)v);
            sum += (double)(there * luminance_vec3f(l)) * fabs(z) / (d2 * sqrt(d2));
        }
    }
    return sum * SH_Y00 * 100 / pieces / pieces;
}

static double luminance_of(const float *rgb)
{
    return luminance_f32((const float[3]){rgb[0], rgb[1], rgb[2]});
}

static void test_sign(const struct sign *sign, int *held, int *all)
{
    enum { TIMES = 24 };
    static const double points[2][3] = {{-3, 1, 8}, {3, 6, 1.5}};
    struct bench b;
    start_sign(&b, sign);
    for (int k = 0; k < 2; k++) {
        const double *p = points[k], truth = sign_truth(&b, sign->pieces, p);
        struct capture_settings s = capture_settings_default();
        double sum = 0, square = 0, error = 0;
        for (int i = 0; i < TIMES; i++) {
            s.seed = (uint64_t)i;
            const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
            const double l = luminance_of(probe.sh), e = luminance_of(probe.sh_error);
            sum += l / TIMES;
            square += (l - truth) * (l - truth) / TIMES;
            error += e / TIMES;
            *held += fabs(l - truth) <= 1.96 * e + 2e-3 * truth;
            ++*all;
        }
        const double deviation = sqrt(square);
        ok(fabs(sum - truth) < 4 * deviation / sqrt(TIMES) + 2e-3 * truth && truth > 0,
           "%s: light %.4g, in the mean of %d captures %.4g", sign->name, truth, TIMES, sum);
        ok(deviation < 0.06 * truth && error < 0.06 * truth &&
               error > 0.5 * deviation - 2e-3 * truth,
           "512 rays are off by %.2g %%, and say %.2g %%", 100 * deviation / truth,
           100 * error / truth);
    }
    bench_clear(&b);
}

static float pane(uint32_t x, uint32_t y)
{
    return x == 5 && y == 40 ? 1000 : 0;
}

/* A texel that is not smoothed is as even as a quad: who says that it is exact is right. */
static void test_exact(void)
{
    enum { TIMES = 16 };
    static const struct sign sign = {"pane",   64,   64,    SCENE_REPEAT, true,
                                     AS_IT_IS, pane, false, 2048};
    static const double p[3] = {-3, 1, 8};
    struct bench b;
    start_sign(&b, &sign);
    const double truth = sign_truth(&b, sign.pieces, p);
    struct capture_settings s = capture_settings_default();
    int held = 0;
    for (int i = 0; i < TIMES; i++) {
        s.seed = (uint64_t)i;
        const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
        held += fabs(luminance_of(probe.sh) - truth) <
                5 * luminance_of(probe.sh_error) + 2e-4 * truth;
    }
    ok(held == TIMES, "%d of %d captures of a pane are off by what they say", held, TIMES);
    bench_clear(&b);
}

/* Panes so many and so small that their picture cannot be cut up: who met none says so. */
static void test_sparse(void)
{
    static const struct sign sign = {"many panes",           64,   64,    SCENE_REPEAT, true,
                                     {300, 0, 0, 0, 300, 0}, pane, false, 512};
    struct bench b;
    start_sign(&b, &sign);
    /* that many panes in the whole are an even light of their mean */
    const struct sign even_sign = {"even", 16, 16, SCENE_REPEAT, true, AS_IT_IS, even, false, 512};
    struct bench mean;
    start_sign(&mean, &even_sign);
    const double p[3] = {-3, 1, 8}, truth = sign_truth(&mean, 512, p) / 3 * 1000 / 4096;
    struct capture_settings s = capture_settings_default();
    int nothing = 0, told = 0;
    for (int i = 0; i < 16; i++) {
        s.seed = (uint64_t)i;
        s.error = 0;
        const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
        if (probe.sh[0] > 0)
            continue;
        nothing++;
        told += luminance_of(probe.sh_error) > 0.9 * truth &&
                luminance_of(probe.sh_error) < 1.1 * truth;
    }
    ok(nothing > 4 && told == nothing, "%d of 16 captures found none of 90000 panes, %d say so",
       nothing, told);
    s.error = 0.05;
    s.rays_most = 65536;
    const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
    ok(probe.rays >= s.rays_most &&
           fabs(luminance_of(probe.sh) - truth) < 3 * luminance_of(probe.sh_error),
       "one that looks for them takes %d rays: %.3g +- %.2g of the light", probe.rays,
       luminance_of(probe.sh) / truth, luminance_of(probe.sh_error) / truth);
    bench_clear(&b);
    bench_clear(&mean);
}

/* What is drawn has the density that is told of it, also of parts of triangles. */
static void test_densities(void)
{
    const struct lights_receiver from = {.position = {0.1f, -0.2f, 0.4f}, .normal = {0, 0, -1}};
    struct random r = random_start(3, 0, 0);
    struct bench b;
    start_sign(&b, &signs[3]);
    double unlike = 0;
    int drawn = 0;
    for (int i = 0; i < 20000; i++) {
        struct lights_choice choice;
        if (!lights_sample(&b.path.lights, b.tracer, &from, random_double(&r), random_float(&r),
                           &choice))
            continue;
        const double density = (double)lights_density(&b.path.lights, &from, &choice.point);
        drawn += fabs(density / (double)choice.density - 1) < 1e-4;
        unlike++;
    }
    /* a point on a border may be told to be of the next part */
    ok(drawn > 0.998 * unlike && unlike > 10000,
       "%d of %.0f points are drawn with the density that is told of them", drawn, unlike);
    ok(b.path.lights.count < 65536, "by %zu parts", b.path.lights.count);
    bench_clear(&b);
}

/* A lamp that a probe cannot see. */
static void test_unseen(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.5f, 0));
    add_quad(&b, (const double[12]){-1, 9, -1, 1, 9, -1, 1, 9, 1, -1, 9, 1}, material(0, 10));
    bench_finish(&b, 4);
    struct capture_settings s = capture_settings_default();
    const double around = 4 * 10 / 81.0 * SH_Y00; /* about what there would be without the cube */
    const struct capture_probe few = capture(&b, &s, 0.1, 0, 0);
    s.rays = 8192;
    const struct capture_probe many = capture(&b, &s, 0.1, 0, 0);
    const double e[2] = {(double)few.sh_error[0], (double)many.sh_error[0]};
    ok(few.sh[0] <= 0 && e[0] > 2 * around / 512 && e[0] < 20 * around / 512,
       "light that is not found has an error (%.2g of what there is outside)", e[0] / around);
    ok(fabs(e[0] / e[1] * few.rays / many.rays - 1) < 0.05, "which goes as 1 / rays (%.3g)",
       e[0] / e[1]);
    s.rays = 128;
    s.error = 0.05;
    const int rays = capture(&b, &s, 0.1, 0, 0).rays;
    ok(rays > 1000 && rays < 3000, "and ends a search for small errors (%d rays)", rays);
    s.error = 3e-4;
    const int more = capture(&b, &s, 0.1, 0, 0).rays;
    ok(more > 10000 && more < 12000, "later for smaller ones (%d rays)", more);
    bench_clear(&b);

    bench_start(&b);
    add_cube(&b, 2, material(0.5f, 0));
    bench_finish(&b, 4);
    s = capture_settings_default();
    ok(capture(&b, &s, 0.1, 0, 0).sh_error[0] <= 0, "where nothing emits, there is none");
    bench_clear(&b);
}

int main(void)
{
    int held = 0, all = 0;
    for (size_t i = 0; i < sizeof signs / sizeof *signs; i++)
        test_sign(&signs[i], &held, &all);
    ok(held > 0.9 * all && held < 0.99 * all,
       "1.96 standard errors hold the truth in %.1f %% of %d", 100.0 * held / all, all);
    test_densities();
    test_unseen();
    test_exact();
    test_sparse();
    return tap_done();
}
