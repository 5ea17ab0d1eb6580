/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes as data: what scene_finish leaves of them, how maps, materials, sky and lights are read,
 * which pieces are closed, and settings that survive the way through options and header to the
 * bit. */
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "image/image.h"
#include "math/angle.h"
#include "math/direction.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "scene/scene_shade.h"
#include "stream/stream.h"
#include "support/files.h"
#include "support/tap.h"
#include "topology/solids.h"

#include <float.h>
#include <inttypes.h>
#include <stb_image_write.h>
#include <string.h>

/* A pseudo-random number in [0, 1). */
static double number(void)
{
    static uint64_t state = 88172645463325252u;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 9007199254740992.0;
}

static void test_linear(void)
{
    double worst = 0;
    for (int i = 0; i < 256; i++) {
        const double c = i / 255.0, l = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        worst = fmax(worst, fabs((double)image_linear[i] - l) / fmax(l, 1e-9));
    }
    ok(worst < 6.1e-8 && image_linear[0] == 0 && image_linear[255] == 1,
       "the sRGB table is right to a float: %.1e", worst);
}

/* -- maps ------------------------------------------------------------------------------------- */

/* A scene with one texture of `size` texels a side, float RGBA, whose red is its column and green
 * its row (from the top). */
static struct scene *grid_texture(uint32_t size, enum scene_wrap wrap, bool nearest)
{
    struct scene *scene;
    must(scene_create(&scene));
    struct scene_texture t = {.width = size,
                              .height = size,
                              .channels = 4,
                              .wrap_u = wrap,
                              .wrap_v = wrap,
                              .nearest = nearest};
    float *texels = calloc((size_t)size * size * 4, sizeof *texels);
    for (uint32_t y = 0; y < size; y++)
        for (uint32_t x = 0; x < size; x++) {
            float *p = texels + 4 * (y * size + x);
            p[0] = (float)x;
            p[1] = (float)y;
            p[2] = 1;
            p[3] = 0.25f;
        }
    t.texels = texels;
    must(scene_push_texture(scene, t, NULL));
    return scene;
}

static bool sample_is(const struct scene *scene, float u, float v, double red, double green)
{
    const struct scene_map map = scene_map_of(0);
    float rgba[4];
    scene_map_sample(scene, &map, u, v, rgba);
    const bool is = fabs((double)rgba[0] - red) < 1e-5 && fabs((double)rgba[1] - green) < 1e-5 &&
                    rgba[3] == 0.25f;
    if (!is)
        printf("# at %g %g: %g %g %g\n", (double)u, (double)v, (double)rgba[0], (double)rgba[1],
               (double)rgba[3]);
    return is;
}

static void test_maps(void)
{
    struct scene *s = grid_texture(8, SCENE_CLAMP, false);
    bool linear = true;
    /* between the outermost texels' middles the picture is its own bilinear interpolation */
    for (int i = 0; i < 1000; i++) {
        const double u = 1 / 16.0 + number() * 14 / 16, v = 1 / 16.0 + number() * 14 / 16;
        linear = linear && sample_is(s, (float)u, (float)v, u * 8 - 0.5, (1 - v) * 8 - 0.5);
    }
    ok(linear, "texels are interpolated bilinearly, row 0 at v = 1");
    ok(sample_is(s, -3, 5, 0, 0) && sample_is(s, 0, 0, 0, 7) && sample_is(s, 9, -2, 7, 7),
       "clamp: the border goes on");
    scene_destroy(s);

    s = grid_texture(8, SCENE_REPEAT, false);
    ok(sample_is(s, 0, 0.5f, 3.5, 3.5) && sample_is(s, 1, 0.5f, 3.5, 3.5) &&
           sample_is(s, 5.25f, -3.75f, 1.5, 5.5),
       "repeat: the first texel follows the last");
    const struct scene_map wild[] = {{.texture = 0, .transform = {FLT_MAX, FLT_MAX, 0, 0, 1, 0}}};
    float rgba[4];
    scene_map_sample(s, wild, 1e9f, 1e9f, rgba);
    ok(isfinite(rgba[0]) && rgba[0] <= 7, "coordinates that overflow still read a texel");
    const struct scene_map turned = {.texture = 0, .transform = {0, 2, 0.125f, -1, 0, 0.5f}};
    float direct[4];
    scene_map_sample(s, &turned, 0.3f, 0.2f, rgba);
    const struct scene_map plain = scene_map_of(0), none = scene_map_of(SCENE_NONE);
    scene_map_sample(s, &plain, 2 * 0.2f + 0.125f, -0.3f + 0.5f, direct);
    ok(!memcmp(rgba, direct, sizeof rgba),
       "a map's transform is applied to (u, v) before sampling");
    scene_map_sample(s, &none, 0.3f, 0.2f, rgba);
    ok(rgba[0] == 1 && rgba[1] == 1 && rgba[2] == 1 && rgba[3] == 1,
       "no texture is white and opaque");
    scene_destroy(s);

    s = grid_texture(8, SCENE_MIRROR, false);
    ok(sample_is(s, 1.25f, -0.25f, 5.5, 5.5) && sample_is(s, 2.25f, 0.5f, 1.5, 3.5) &&
           sample_is(s, 1, 1, 7, 0),
       "mirror: every other picture is turned round");
    scene_destroy(s);

    s = grid_texture(8, SCENE_REPEAT, true);
    ok(sample_is(s, 0.99f, 0.99f, 7, 0) && sample_is(s, 0.125f, 0.124f, 1, 7) &&
           sample_is(s, 1, 0, 0, 7),
       "nearest: one texel, as the file asks");
    scene_destroy(s);
}

static void test_materials(void)
{
    struct scene *s;
    must(scene_create(&s));
    const uint8_t codes[2][4] = {{255, 188, 0, 255}, {255, 188, 0, 51}};
    struct scene_texture t = {.width = 2,
                              .height = 1,
                              .channels = 4,
                              .bytes = true,
                              .nearest = true,
                              .texels = malloc(8)};
    memcpy(t.texels, codes, sizeof codes);
    must(scene_push_texture(s, t, NULL));
    struct scene_material m = scene_material_default();
    m.albedo = (struct vec3f){0.5f, 0.5f, 0.5f};
    m.albedo_map = m.alpha_map = m.emission_map = scene_map_of(0);
    m.emission = (struct vec3f){2, 0, 0};
    struct vec3f a = scene_albedo(s, &m, 0.1f, 0.5f);
    ok(a.x == 0.5f && fabs((double)a.y - 0.5 * 0.50289) < 1e-4 && a.z == 0,
       "albedo is the factor times the linear texel");
    s->max_albedo = 0.25f;
    a = scene_albedo(s, &m, 0.1f, 0.5f);
    ok(a.x == 0.25f && a.y <= 0.25f, "max_albedo limits what comes of it");
    ok(scene_emission(s, &m, 0.1f, 0.5f).x == 2 && scene_emits(&m),
       "so is emission, without a limit");
    m.alpha = SCENE_OPAQUE;
    ok(scene_transparency(s, &m, 0.9f, 0.5f) == 0,
       "an opaque material has no holes, whatever its texture says");
    m.alpha = SCENE_CUTOUT;
    ok(scene_transparency(s, &m, 0.9f, 0.5f) == 1 && scene_transparency(s, &m, 0.1f, 0.5f) == 0,
       "a cut-out passes below its cutoff");
    m.alpha = SCENE_BLEND;
    m.opacity = 0.5f;
    ok(fabs((double)scene_transparency(s, &m, 0.9f, 0.5f) - 0.9) < 1e-6,
       "a blend passes 1 - opacity times alpha");
    m.emission = (struct vec3f){0};
    ok(!scene_emits(&m), "black does not emit");
    scene_destroy(s);
}

/* -- sky and lights --------------------------------------------------------------------------- */

/* The picture of test_sky turned, put upright in other frames, and brighter. */
static void test_sky_axes(struct scene_settings *settings, struct warnings *warnings)
{
    const struct {
        double turn, up[3], scale;
        struct vec3f centre, top, right; /* where these look */
    } frames[] = {{90, {0, 1, 0}, 1, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}},
                  {0, {0, 0, 1}, 2, {1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                  {90, {0, 0, 1}, 1, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
                  {-180, {0, -1, 0}, 1, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                  {0, {1, 0, 0}, 0.5, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        struct scene *s;
        settings->sky_turn = frames[i].turn;
        settings->sky_scale = frames[i].scale;
        memcpy(settings->sky_up, frames[i].up, sizeof settings->sky_up);
        must(scene_create(&s));
        must(scene_finish(s, settings, warnings));
        const struct vec3f centre = scene_sky_radiance(s, frames[i].centre),
                           right = scene_sky_radiance(s, frames[i].right),
                           top = scene_sky_radiance(s, frames[i].top);
        const double scale = frames[i].scale;
        ok(fabs((double)centre.x / scale - 32.5) < 0.1 &&
               fabs((double)right.x / scale - 48.5) < 0.1 &&
               fabs((double)centre.y / scale - 16.5) < 0.1 && fabs((double)top.y / scale - 1) < 0.1,
           "the sky turned by %g, up %g %g %g, times %g", frames[i].turn, frames[i].up[0],
           frames[i].up[1], frames[i].up[2], scale);
        scene_destroy(s);
    }
    settings->sky_turn = 0;
    settings->sky_scale = settings->sky_up[1] = 1;
    settings->sky_up[0] = 0;
}

/* The middle of a square picture that is brighter to the right and the top, as an angular map. */
static void test_sky_maps(void)
{
    enum { W = 64 };
    static float pixels[W][W][3];
    struct warnings warnings = {0};
    for (int y = 0; y < W; y++)
        for (int x = 0; x < W; x++) {
            pixels[y][x][0] = 64 + (float)(2 * x + 1 - W);
            pixels[y][x][1] = 64 - (float)(2 * y + 1 - W);
            pixels[y][x][2] = 1;
        }
    stbi_write_hdr(files_path("probe.hdr"), W, W, 3, &pixels[0][0][0]);
    struct scene_settings settings = scene_settings_default();
    struct scene *s;
    settings.sky_file = strdup(files_path("probe.hdr"));
    must(scene_create(&s));
    struct error *err = scene_finish(s, &settings, &warnings);
    ok(err && strstr(error_message(err), "64 x 64 texels") &&
           strstr(error_message(err), "--sky-map angular"),
       "a square is no panorama: %s", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);
    settings.sky_map = SCENE_SKY_ANGULAR;
    must(scene_create(&s));
    must(scene_finish(s, &settings, &warnings));
    const struct {
        struct vec3f direction;
        double right, top; /* of the half side */
    } ways[] = {{{1, 0, 0}, 0, 0},
                {{0, 0, 1}, 0.5, 0},
                {{0, 1, 0}, 0, 0.5},
                {{0, 0, -1}, -0.5, 0},
                {{sqrtf(0.5f), -sqrtf(0.5f), 0}, 0, -0.25}};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        const struct vec3f r = scene_sky_radiance(s, ways[i].direction);
        ok(fabs((double)r.x - 64 - 64 * ways[i].right) < 1.5 &&
               fabs((double)r.y - 64 - 64 * ways[i].top) < 1.5 && fabs((double)r.z - 1) < 0.01,
           "an angular map: %g to the right, %g up", ((double)r.x - 64) / 64,
           ((double)r.y - 64) / 64);
    }
    scene_destroy(s);
    settings.sky_map = SCENE_SKY_LATLONG;
    must(scene_create(&s));
    must(scene_finish(s, &settings, &warnings));
    ok(s->sky.picture && s->sky.picture->width == W, "latlong takes any sides");
    scene_destroy(s);
    scene_settings_clear(&settings);
    warnings_clear(&warnings);
}

/* Faces whose light grows evenly from left to right and from top to bottom, with a colour of its
 * own for each, as in every layout. */
static void test_sky_cubes(void)
{
    enum { N = 16 };
    static const struct {
        const char *name;
        int across, down, at[6][2];
        bool turned; /* the back, by half a turn */
    } layouts[] = {
        {"a cross that lies", 4, 3, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}, false},
        {"a cross that stands", 3, 4, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}, true},
        {"a strip", 6, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}, false},
        {"a column", 1, 6, {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}, false}};
    /* of right, left, up, down, front, back: where they look, and their right and their top */
    static const float axes[6][3][3] = {
        {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}}, {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
        {{0, 1, 0}, {0, 0, 1}, {-1, 0, 0}}, {{0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
        {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},  {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};
    static float pixels[6 * N * 6 * N * 3];
    for (size_t l = 0; l < sizeof layouts / sizeof *layouts; l++) {
        const int wide = layouts[l].across * N;
        memset(pixels, 0, sizeof pixels);
        for (int f = 0; f < 6; f++)
            for (int i = 0; i < N * N; i++) {
                const bool turned = f == 5 && layouts[l].turned;
                const int x = i % N, y = i / N, column = turned ? N - 1 - x : x,
                          row = turned ? N - 1 - y : y;
                float *to = pixels + 3 * ((layouts[l].at[f][1] * N + y) * wide +
                                          layouts[l].at[f][0] * N + x);
                to[0] = 100 + (float)column;
                to[1] = 100 + (float)row;
                to[2] = 64 + 16 * (float)f;
            }
        stbi_write_hdr(files_path("cube.hdr"), wide, layouts[l].down * N, 3, pixels);
        struct warnings warnings = {0};
        struct scene_settings settings = scene_settings_default();
        settings.sky_file = strdup(files_path("cube.hdr"));
        struct scene *s;
        must(scene_create(&s));
        struct error *err = scene_finish(s, &settings, &warnings);
        ok(err && strstr(error_message(err), "--sky-map cube"), "%s is no panorama: %s",
           layouts[l].name, err ? error_message(err) : "");
        error_destroy(err);
        scene_destroy(s);
        settings.sky_map = SCENE_SKY_CUBE;
        must(scene_create(&s));
        must(scene_finish(s, &settings, &warnings));
        double worst = 0;
        for (int f = 0; f < 6; f++)
            for (int k = 0; k < 9; k++) {
                const float a = 0.75f * (float)(k % 3 - 1), b = 0.75f * (float)(k / 3 - 1);
                const float(*way)[3] = axes[f];
                struct vec3f d = {way[0][0] + a * way[1][0] + b * way[2][0],
                                  way[0][1] + a * way[1][1] + b * way[2][1],
                                  way[0][2] + a * way[1][2] + b * way[2][2]};
                const float length = sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
                d = (struct vec3f){d.x / length, d.y / length, d.z / length};
                const struct vec3f r = scene_sky_radiance(s, d);
                worst = fmax(worst, fabs((double)r.x - 99.5 - 8 * (1 + (double)a)));
                worst = fmax(worst, fabs((double)r.y - 99.5 - 8 * (1 - (double)b)));
                worst = fmax(worst, fabs((double)r.z - 64 - 16 * f));
            }
        ok(worst < 1, "%s: every face is where it should be, to %.2g of %d texels", layouts[l].name,
           worst, N);
        scene_destroy(s);
        settings.sky_map = SCENE_SKY_ANGULAR;
        must(scene_create(&s));
        err = scene_finish(s, &settings, &warnings);
        ok(err && strstr(error_message(err), "expects a square"), "nor an angular map");
        error_destroy(err);
        scene_destroy(s);
        scene_settings_clear(&settings);
        warnings_clear(&warnings);
    }
}

static void test_sky(void)
{
    enum { W = 64, H = 32 };
    static float pixels[H][W][3];
    struct warnings warnings = {0};
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            pixels[y][x][0] = (float)(x + 1);
            pixels[y][x][1] = (float)(y + 1);
            pixels[y][x][2] = 0.5f;
        }
    stbi_write_hdr(files_path("sky.hdr"), W, H, 3, &pixels[0][0][0]);
    struct scene_settings settings = scene_settings_default();
    settings.sky_file = strdup(files_path("sky.hdr"));
    struct scene *s;
    must(scene_create(&s));
    must(scene_finish(s, &settings, &warnings));
    const struct {
        struct vec3f direction;
        double column, row; /* of W, H; from the left, from the top */
    } ways[] = {{{1, 0, 0}, 0.5, 0.5},
                {{0, 0, 1}, 0.75, 0.5},
                {{0, 0, -1}, 0.25, 0.5},
                {{sqrtf(0.5f), 0, sqrtf(0.5f)}, 0.625, 0.5},
                {{sqrtf(0.5f), sqrtf(0.5f), 0}, 0.5, 0.25},
                {{0, -sqrtf(0.5f), sqrtf(0.5f)}, 0.75, 0.75}};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        const struct vec3f r = scene_sky_radiance(s, ways[i].direction);
        ok(fabs((double)r.x - (ways[i].column * W + 0.5)) < 0.01 * W / 8 &&
               fabs((double)r.y - (ways[i].row * H + 0.5)) < 0.02,
           "the sky towards %g %g %g is at column %g, row %g", (double)ways[i].direction.x,
           (double)ways[i].direction.y, (double)ways[i].direction.z, (double)r.x - 0.5,
           (double)r.y - 0.5);
    }
    const struct vec3f up = scene_sky_radiance(s, (struct vec3f){0, 1, 0}),
                       down = scene_sky_radiance(s, (struct vec3f){0, -1, 0});
    ok(up.y == 1 && down.y == H, "+Y is the picture's top, -Y its bottom");
    const struct vec3f left = scene_sky_radiance(s, (struct vec3f){-1, 0, 1e-5f}),
                       right = scene_sky_radiance(s, (struct vec3f){-1, 0, -1e-5f});
    ok(fabs((double)left.x - (double)right.x) < 0.1 && fabs((double)left.x - (W + 1) / 2.0) < 0.1,
       "the picture's ends meet without a seam");
    double mean = 0, rows = 0, weights = 0;
    for (int i = 0; i < 200000; i++) { /* directions even over the sphere */
        const struct vec3 d = direction_even(i, 200000);
        const struct vec3f way = {(float)d.x, (float)d.z, (float)d.y};
        mean += (double)scene_sky_radiance(s, way).y / 200000;
    }
    for (int y = 0; y < H; y++) {
        const double weight = sin(acos(-1.0) * (y + 0.5) / H);
        rows += weight * (y + 1);
        weights += weight;
    }
    ok(fabs(mean / (rows / weights) - 1) < 1e-3,
       "mean radiance over all directions is the picture's: %g, %g", mean, rows / weights);
    scene_destroy(s);
    test_sky_axes(&settings, &warnings);
    free(settings.sky_file);
    settings.sky_file = strdup(files_path("none.hdr"));
    must(scene_create(&s));
    struct error *err = scene_finish(s, &settings, &warnings);
    ok(err && strstr(error_message(err), "none.hdr: No such file or directory"),
       "a missing sky is named: %s", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);
    scene_settings_clear(&settings);
    warnings_clear(&warnings);
}

static void test_lights(void)
{
    const double p[3] = {1, 2, 3};
    double way[3], distance, rgb[3];
    struct scene_light light = {.kind = SCENE_POINT, .position = {1, 2, 5}, .intensity = {8, 4, 0}};
    scene_light_at(&light, p, way, &distance, rgb);
    ok(way[2] == 1 && distance == 2 && rgb[0] == 2 && rgb[1] == 1 && rgb[2] == 0,
       "a point light falls off as 1/d^2");
    light.position = vec3_load(p);
    scene_light_at(&light, p, way, &distance, rgb);
    ok(distance == 0 && rgb[0] == 0, "at the light itself there is none");
    light =
        (struct scene_light){.kind = SCENE_SUN, .direction = {0, -1, 0}, .intensity = {3, 2, 1}};
    scene_light_at(&light, p, way, &distance, rgb);
    ok(way[1] == 1 && isinf(distance) && rgb[0] == 3 && rgb[2] == 1,
       "a sun is endlessly far and everywhere the same");
    light = (struct scene_light){.kind = SCENE_SPOT,
                                 .direction = {1, 0, 0},
                                 .intensity = {1, 1, 1},
                                 .cos_inner = cos(0.2),
                                 .cos_outer = cos(0.6)};
    bool right = true;
    for (double angle = 0; angle < 3; angle += 0.01) {
        const double q[3] = {2 * cos(angle), 2 * sin(angle), 0};
        const double t = fmin(fmax((cos(angle) - cos(0.6)) / (cos(0.2) - cos(0.6)), 0), 1);
        scene_light_at(&light, q, way, &distance, rgb);
        right = right && fabs(rgb[1] - t * t / 4) < 1e-12;
    }
    ok(right, "a spot falls off between its angles as glTF says");
    light.cos_inner = light.cos_outer;
    const double inside[3] = {2 * cos(0.59), 2 * sin(0.59), 0},
                 outside[3] = {2 * cos(0.61), 2 * sin(0.61), 0};
    scene_light_at(&light, inside, way, &distance, rgb);
    right = fabs(rgb[0] - 0.25) < 1e-12;
    scene_light_at(&light, outside, way, &distance, rgb);
    ok(right && rgb[0] == 0, "equal angles make a sharp edge, not a division by 0");
}

/* -- finishing -------------------------------------------------------------------------------- */

static const double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const uint32_t square_index[6] = {0, 1, 2, 0, 2, 3};

static void test_degenerate(void)
{
    struct warnings warnings = {0};
    struct scene *s;
    must(scene_create(&s));
    const double position[] = {
        0, 0,   0,     1e-200, 0,   0,   0,     1e-200,      0, 0, 0,
        0, 0.1, 0.3,   0.7,    0.3, 0.9, 2.1,   (double)NAN, 0, 0, (double)INFINITY,
        0, 0,   1e200, 0,      0,   0,   1e200, 0,           9, 9, 9};
    const uint32_t index[] = {0, 1, 2,           /* tiny, but whole */
                              3, 4, 5,           /* on a line, but for rounding */
                              0, 0, 1,           /* a corner twice */
                              0, 1, 6,  0, 1, 7, /* no numbers */
                              0, 1, 99,          /* no vertex */
                              0, 8, 9 /* huge, but whole */};
    const struct scene_material m = scene_material_default();
    must(scene_add_mesh(s, 11, position, 7, index, &m));
    must(scene_finish(s, NULL, &warnings));
    ok(scene_triangle_count(s) == 2 && s->degenerate_count == 5,
       "triangles without area, numbers or vertices are left out: %zu", s->degenerate_count);
    ok(warnings_of_kind(&warnings, "degenerate triangles") == 1 &&
           warnings_of_kind(&warnings, "index out of range") == 1,
       "with one warning that counts them");
    ok(s->meshes[0].vertex_count == 5 && s->box_max.z == 0 && s->box_max.x == 1e200,
       "vertices that no triangle uses do not count for the box");
    scene_destroy(s);

    must(scene_create(&s));
    must(scene_add_mesh(s, 3, position, 1, (const uint32_t[]){0, 0, 0}, &m));
    must(scene_finish(s, NULL, &warnings));
    ok(s->mesh_count == 0 && s->instance_count == 0 && s->box_min.x > s->box_max.x,
       "a mesh without triangles goes, and its instance");
    scene_destroy(s);
    warnings_clear(&warnings);
}

static void test_instances(void)
{
    struct warnings warnings = {0};
    struct scene *s;
    must(scene_create(&s));
    const struct scene_material m = scene_material_default();
    must(scene_add_mesh(s, 4, square, 2, square_index, &m));
    const double moved[12] = {0, 0, 2, 10, 0, 3, 0, 20, 1, 0, 0, 30},
                 flat[12] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 0, 7},
                 gone[12] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    must(scene_push_instance(s, 0, moved));
    must(scene_push_instance(s, 0, flat));
    must(scene_push_instance(s, 0, gone));
    must(scene_finish(s, NULL, &warnings));
    ok(scene_triangle_count(s) == 6,
       "an instance squeezed flat stays when it has an area, and goes when it has none");
    ok(s->box_max.x == 10 && s->box_max.y == 23 && s->box_max.z == 31 && s->box_min.z == 0,
       "the box holds every instance");
    bool invertible = true;
    for (size_t i = 0; i < s->instance_count; i++) {
        const double *t = s->instances[i].transform;
        invertible = invertible &&
                     vec3_dot(vec3_load(t), vec3_cross(vec3_load(t + 4), vec3_load(t + 8))) != 0;
    }
    ok(invertible, "every matrix that is left has an inverse");
    scene_destroy(s);

    must(scene_create(&s));
    must(scene_add_mesh(s, 4, square, 2, square_index, &m));
    const double mirrored[12] = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, -1e-9, 0};
    memcpy(s->instances[0].transform, mirrored, sizeof mirrored);
    must(scene_finish(s, NULL, &warnings));
    const double *p = s->meshes[0].position;
    const uint32_t *k = s->meshes[0].index;
    ok(vec3_cross(vec3_sub(vec3_load(p + 3 * k[1]), vec3_load(p + 3 * k[0])),
                  vec3_sub(vec3_load(p + 3 * k[2]), vec3_load(p + 3 * k[0])))
               .z < 0,
       "what is mirrored and squeezed flat keeps its front");
    scene_destroy(s);

    must(scene_create(&s));
    must(scene_add_mesh(s, 4, square, 2, square_index, &m));
    s->meshes[0].material[1] = 7;
    struct error *err = scene_finish(s, NULL, &warnings);
    ok(err, "a material out of range is an error: %s", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);

    struct scene_material bright = m;
    struct scene_settings scaled = scene_settings_default();
    bright.emission = (struct vec3f){1e-20f, 0, 0};
    scaled.light_scale = 1e40;
    must(scene_create(&s));
    must(scene_add_mesh(s, 4, square, 2, square_index, &bright));
    must(scene_finish(s, &scaled, &warnings));
    ok(fabsf(s->materials[0].emission.x / 1e20f - 1) < 1e-6f,
       "a scale that no float holds brings up light that is dim");
    scene_destroy(s);
    must(scene_create(&s));
    bright.emission.x = 1;
    must(scene_add_mesh(s, 4, square, 2, square_index, &bright));
    err = scene_finish(s, &scaled, &warnings);
    ok(err && strstr(error_message(err), "beyond what 32 bits can hold"),
       "light that no float holds is no darkness: %s", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);

    must(scene_create(&s));
    must(scene_add_mesh(s, 4, square, 2, square_index, &m));
    s->instances[0].transform[3] = (double)NAN;
    err = scene_finish(s, NULL, &warnings);
    ok(err, "a transform that is not finite is an error: %s", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);
    warnings_clear(&warnings);
}

static void test_factors(void)
{
    struct warnings warnings = {0};
    struct scene_settings settings = scene_settings_default();
    struct scene *s;
    must(scene_create(&s));
    struct scene_material m = scene_material_default();
    m.albedo = (struct vec3f){-1, NAN, 3};
    m.emission = (struct vec3f){2, NAN, -4};
    m.opacity = 2;
    must(scene_add_mesh(s, 4, square, 2, square_index, &m));
    must(scene_push_light(s, (struct scene_light){.kind = SCENE_POINT, .intensity = {1, 2, 3}}));
    must(scene_push_light(s, (struct scene_light){.kind = SCENE_POINT, .intensity = {1, -2, 3}}));
    must(scene_push_light(s, (struct scene_light){.kind = SCENE_SUN, .intensity = {1, 2, 3}}));
    struct scene_light extra = {.kind = SCENE_POINT, .intensity = {5, 5, 5}};
    settings.lights = &extra;
    settings.light_count = 1;
    settings.light_scale = 10;
    settings.albedo_scale = 0.5;
    settings.sky[1] = 4;
    must(scene_finish(s, &settings, &warnings));
    const struct scene_material *f = &s->materials[0];
    ok(f->albedo.x == 0 && f->albedo.y == 0 && f->albedo.z == 1.5f && f->emission.x == 20 &&
           f->emission.y == 0 && f->emission.z == 0 && f->opacity == 1,
       "factors that are negative or no numbers become 0, the rest is scaled");
    ok(warnings_of_kind(&warnings, "material out of range") == 5 &&
           warnings_of_kind(&warnings, "albedo limited") == 1,
       "each with a warning");
    ok(scene_albedo(s, f, 0, 0).z == 1, "no surface gives back more light than it gets");
    ok(s->light_count == 2 && s->lights[0].intensity[2] == 30 && s->lights[1].intensity[0] == 5 &&
           warnings_of_kind(&warnings, "light out of range") == 2,
       "the file's lights are scaled, the options' are not, impossible ones are left out");
    ok(s->sky.radiance[1] == 4 && scene_sky_radiance(s, (struct vec3f){0, 1, 0}).y == 4,
       "the sky is the settings'");
    scene_destroy(s);
    warnings_clear(&warnings);
}

/* -- the key ---------------------------------------------------------------------------------- */

static struct scene *keyed(int change)
{
    struct scene *s = grid_texture(4, SCENE_REPEAT, false);
    struct scene_material m = scene_material_default();
    m.albedo_map = scene_map_of(0);
    m.name = (char *)(uintptr_t)(change == 1 ? "other name" : "name");
    double position[12];
    memcpy(position, square, sizeof position);
    if (change == 2)
        position[4] = 1e-300;
    must(scene_add_mesh(s, 4, position, 2, square_index, &m));
    must(scene_push_light(s, (struct scene_light){.kind = SCENE_POINT, .intensity = {1, 2, 3}}));
    struct scene_settings settings = scene_settings_default();
    settings.emit_front_only = change == 3;
    settings.sky[2] = change == 4;
    settings.max_albedo = change == 5 ? 0.5 : 1;
    settings.light_scale = change == 6 ? 2 : 1;
    settings.albedo_scale = change == 7 ? 0.5 : 1;
    if (change == 8)
        s->textures[0].nearest = true;
    if (change == 9)
        ((float *)s->textures[0].texels)[5] += 1;
    if (change == 10)
        s->materials[0].alpha = SCENE_CUTOUT;
    if (change == 11)
        s->instances[0].transform[3] = 1;
    must(scene_finish(s, &settings, NULL));
    return s;
}

static void test_key(void)
{
    uint64_t keys[12];
    for (int i = 0; i < 12; i++) {
        struct scene *s = keyed(i);
        keys[i] = scene_key(s);
        scene_destroy(s);
    }
    struct scene *again = keyed(0);
    bool differ = true;
    for (int i = 2; i < 12; i++)
        for (int j = 0; j < i; j++)
            differ = differ && (keys[i] != keys[j] || j == i);
    ok(scene_key(again) == keys[0] && keys[1] == keys[0],
       "equal scenes have equal keys, whatever their materials are called");
    ok(differ, "whatever light depends on changes the key");
    scene_destroy(again);
}

/* The sky's picture has a key of its own; streams of before have one of both. */
static void test_sky_key(void)
{
    static const char *const names[] = {"day.hdr", "dusk.hdr"};
    struct scene *s[2];
    struct stream_header header = {0};
    char key[SCENE_KEY_ROOM], number[32];
    for (int i = 0; i < 2; i++) {
        const float texels[2 * 3] = {1, 2, (float)i, 3, 4, 5};
        if (!stbi_write_hdr(files_path(names[i]), 2, 1, 3, texels))
            bail("%s", names[i]);
        struct scene_settings settings = scene_settings_default();
        settings.sky_file = strdup(files_path(names[i]));
        s[i] = grid_texture(4, SCENE_REPEAT, false);
        const struct scene_material m = scene_material_default();
        must(scene_add_mesh(s[i], 4, square, 2, square_index, &m));
        must(scene_finish(s[i], &settings, NULL));
        scene_settings_clear(&settings);
    }
    scene_key_text(s[0], NULL, key);
    must(header_set_key(&header, "scene-key", key));
    ok(scene_key(s[0]) == scene_key(s[1]) && !scene_differs(s[1], &header),
       "under another picture of the sky a scene is the same");
    ok(!scene_sky_differs(s[1], &header), "a stream that has no key of the sky is of any");
    snprintf(number, sizeof number, "%016" PRIx64, s[0]->sky.key);
    must(header_set_key(&header, "sky-key", number));
    ok(!scene_sky_differs(s[0], &header) && scene_sky_differs(s[1], &header),
       "which the sky's own key tells");
    snprintf(number, sizeof number, "%016" PRIx64, scene_key_with_sky(s[0]));
    must(header_set_key(&header, "scene-key", number));
    scene_key_text(s[0], number, key);
    ok(!scene_differs(s[0], &header) && scene_differs(s[1], &header) && !strcmp(key, number),
       "keys of streams that are of scene and picture are known, and stay");
    header_clear(&header);
    for (int i = 0; i < 2; i++)
        scene_destroy(s[i]);
}

/* -- settings --------------------------------------------------------------------------------- */

/* Reads a command line ("--sky 1,2,3|...", words separated by blanks) into settings. */
static struct error *read_options(const char *line, struct scene_settings *settings)
{
    char buffer[1024], *argv[32];
    int argc = 0;
    struct option_row rows[SCENE_SETTINGS_ROWS];
    const struct option_row *const groups[] = {scene_settings_rows(settings, rows), NULL};
    struct program program = {.name = "probe-x", .usage = "", .summary = ""};
    snprintf(buffer, sizeof buffer, "probe-x %s", line);
    for (char *save = NULL, *word = strtok_r(buffer, " ", &save); word;
         word = strtok_r(NULL, " ", &save))
        argv[argc++] = word;
    argv[argc] = NULL;
    struct error *err = options_parse(&program, groups, argc, argv);
    program_clear(&program);
    return err;
}

static void refuse(const char *line, const char *part)
{
    struct scene_settings settings = scene_settings_default();
    struct error *err = read_options(line, &settings);
    ok(err && error_status(err) == EXIT_BAD_USAGE && strstr(error_message(err), part), "%s: %s",
       line, err ? error_message(err) : "(accepted)");
    error_destroy(err);
    scene_settings_clear(&settings);
}

static bool same_light(const struct scene_light *a, const struct scene_light *b)
{
    return a->kind == b->kind && !memcmp(&a->position, &b->position, sizeof a->position) &&
           !memcmp(&a->direction, &b->direction, sizeof a->direction) &&
           !memcmp(a->intensity, b->intensity, sizeof a->intensity) &&
           a->cos_inner == b->cos_inner && a->cos_outer == b->cos_outer;
}

static bool same_settings(const struct scene_settings *a, const struct scene_settings *b)
{
    bool same = !memcmp(a->sky, b->sky, sizeof a->sky) && !a->sky_file == !b->sky_file &&
                (!a->sky_file || !strcmp(a->sky_file, b->sky_file)) &&
                !a->sky_from_scene == !b->sky_from_scene &&
                (!a->sky_from_scene || !strcmp(a->sky_from_scene, b->sky_from_scene)) &&
                a->sky_key == b->sky_key && a->sky_map == b->sky_map &&
                a->light_count == b->light_count && a->emit_front_only == b->emit_front_only &&
                a->albedo_scale == b->albedo_scale && a->max_albedo == b->max_albedo &&
                a->light_scale == b->light_scale;
    for (size_t i = 0; same && i < a->light_count; i++)
        same = same_light(&a->lights[i], &b->lights[i]);
    return same;
}

static void test_settings(void)
{
    struct scene_settings settings = scene_settings_default();
    must(read_options("--sky .5,.6,.8 --sun .2,-1,.3,10,9,8 --point 1,2,3,4,5,6 --spot "
                      "0.1,0,0,0,0,-2,10,40,1,1,1 "
                      "--sun 1e300,0,1e300,1,0,0 --emit front --albedo-scale 0.9 --max-albedo 0.8 "
                      "--light-scale 1e-3",
                      &settings));
    const struct scene_light *l = settings.lights;
    ok(settings.sky[2] == 0.8 && settings.light_count == 4 && settings.emit_front_only &&
           settings.max_albedo == 0.8,
       "options fill the settings");
    bool unit = true;
    for (int i = 0; i < 4; i++)
        unit = unit && (l[i].kind == SCENE_POINT ||
                        fabs(vec3_dot(l[i].direction, l[i].direction) - 1) < 1e-15);
    ok(unit && fabs(l[3].direction.x - sqrt(0.5)) < 1e-15,
       "directions are made unit, however long they are");
    ok(fabs(l[2].cos_outer - cos(40 * acos(-1.0) / 180)) < 1e-15 && l[2].cos_inner > l[2].cos_outer,
       "angles are degrees");

    struct stream_header header = {0};
    struct scene_settings back = scene_settings_default();
    must(header_set_key(&header, "sun-9", "an old light"));
    must(header_set_key(&header, "sky-file", "old.hdr"));
    must(header_set_key(&header, "sunny-1", "not ours"));
    must(scene_settings_to_header(&settings, &header));
    must(scene_settings_from_header(&back, &header));
    ok(same_settings(&settings, &back), "settings come back from the header to the bit");
    ok(header_key(&header, "sunny-1") && !header_key(&header, "sun-9"),
       "keys that are not ours stay, old lights go");
    scene_settings_clear(&back);
    settings.lights[0].intensity[0] = nextafter(settings.lights[0].intensity[0], 99);
    must(scene_settings_from_header(&back, &header));
    ok(!same_settings(&settings, &back), "and the comparison sees one bit");
    scene_settings_clear(&back);
    header_clear(&header);

    must(read_options(
        "--sky clouds.hdr --sky-turn 30 --sky-up 0,0,9 --sky-scale 2 --sky-map angular",
        &settings));
    settings.sky_from_scene = strdup("../clouds.hdr");
    settings.sky_key = 0x0123456789abcdef;
    must(scene_settings_to_header(&settings, &header));
    must(scene_settings_from_header(&back, &header));
    ok(settings.sky_file && same_settings(&settings, &back) && settings.sky[0] == 0 &&
           back.sky_turn == 30 && back.sky_up[2] == 1 && back.sky_up[1] == 0 &&
           back.sky_scale == 2 && back.sky_map == SCENE_SKY_ANGULAR,
       "a picture of the sky, too");
    must(read_options("--sky 1,1,1", &settings));
    ok(!settings.sky_file && !settings.sky_from_scene && !settings.sky_key && settings.sky[0] == 1,
       "the last --sky wins");
    scene_settings_clear(&back);
    scene_settings_clear(&settings);

    const struct {
        const char *key, *value;
    } wrong[] = {{"sky", "1,2"},
                 {"sky", "1,2,-3"},
                 {"sun-1", "0,0,2,1,1,1"},
                 {"spot-1", "0,0,0,1,0,0,0.1,0.2,1,1,1"},
                 {"point-3", "1,2,3,nan,0,0"},
                 {"sky-key", "0123456789abcdeg"},
                 {"emit", "back"},
                 {"max-albedo", "2"},
                 {"light-scale", "x"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        must(header_set_key(&header, "sky-file", "clouds.hdr"));
        must(header_set_key(&header, wrong[i].key, wrong[i].value));
        struct error *err = scene_settings_from_header(&back, &header);
        ok(err && error_status(err) == EXIT_BAD_DATA && strstr(error_message(err), wrong[i].key),
           "header refused: %s", err ? error_message(err) : "(accepted)");
        error_destroy(err);
        scene_settings_clear(&back);
        header_clear(&header);
    }
    refuse("--sky 1,2", "expected 3 finite numbers");
    refuse("--sky -1,0,0", "at least 0");
    static const char *const skies[] = {"nan,0,0", "inf,1,1", "1;1;1", "0x1,0,0", "1,2,x", "white"};
    for (size_t i = 0; i < sizeof skies / sizeof *skies; i++) {
        char line[64];
        snprintf(line, sizeof line, "--sky %s", skies[i]);
        refuse(line, "expected 3 finite numbers separated by commas, or the name of a picture");
    }
    refuse("--sun 0,0,0,1,1,1", "expected a direction");
    refuse("--sun 0,0,1,1,1", "expected 6");
    refuse("--point 0,0,1,1,1,-1", "at least 0");
    refuse("--spot 0,0,0,0,0,1,30,20,1,1,1", "INNER <= OUTER");
    refuse("--spot 0,0,0,0,0,1,30,91,1,1,1", "INNER <= OUTER");
    refuse("--emit back", "expected one of both, front");
    refuse("--max-albedo 1.5", "at most 1");
    refuse("--albedo-scale -1", "at least 0");
}

/* -- closed pieces ---------------------------------------------------------------------------- */

/* A box from `low` to `high`, front side out, as 12 triangles of 8 vertices. */
static void add_box(struct scene *s, struct vec3 low, struct vec3 high, size_t triangles)
{
    static const uint32_t index[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    double p[24];
    for (int i = 0; i < 8; i++)
        vec3_store(p + 3 * i, (struct vec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y,
                                            i & 4 ? high.z : low.z});
    const struct scene_material m = scene_material_default();
    must(scene_add_mesh(s, 8, p, triangles, index, &m));
}

static struct scene_solids solids_of(struct scene *s)
{
    struct scene_solids solids;
    must(scene_finish(s, NULL, NULL));
    must(scene_solids(s, &solids, NULL));
    return solids;
}

static void test_solids(void)
{
    const struct vec3 o = {0, 0, 0}, one = {1, 1, 1}, two = {2, 2, 2};
    struct scene *s;
    must(scene_create(&s));
    add_box(s, o, two, 12);
    add_box(s, (struct vec3){10, 0, 0}, (struct vec3){11, 1, 1}, 11); /* a triangle misses */
    struct scene_solids solids = solids_of(s);
    ok(solids.count == 2 && solids.closed_count == 1 && solids.closed[0] &&
           fabs(solids.volume[0] - 8) < 1e-12,
       "a box is closed and has its volume, a box with a hole is not");
    ok(solids.offset[1] == 12 && solids.piece_of[solids.offset[1]] == 1,
       "every triangle knows its piece");
    scene_solids_clear(&solids);
    scene_destroy(s);

    must(scene_create(&s));
    add_box(s, o, one, 12);
    const double mirrored[12] = {-2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 0};
    must(scene_push_instance(s, 0, mirrored));
    solids = solids_of(s);
    ok(solids.count == 2 && solids.closed_count == 2 && fabs(solids.volume[1] - 8) < 1e-12,
       "a mesh placed twice gives two pieces; mirroring does not turn it inside out");
    scene_solids_clear(&solids);
    scene_destroy(s);

    must(scene_create(&s));
    add_box(s, o, one, 12);
    memcpy(s->instances[0].transform, mirrored, sizeof mirrored);
    solids = solids_of(s);
    ok(solids.closed_count == 1 && fabs(solids.volume[0] - 8) < 1e-12, "nor a mesh placed once");
    for (size_t t = 0; t < 12; t++) {
        uint32_t *i = s->meshes[0].index + 3 * t, swap = i[1];
        i[1] = i[2];
        i[2] = swap;
    }
    scene_solids_clear(&solids);
    must(scene_solids(s, &solids, NULL));
    ok(solids.closed_count == 1 && fabs(solids.volume[0] + 8) < 1e-12,
       "a box with its fronts inside has a negative volume");
    scene_solids_clear(&solids);
    scene_destroy(s);

    must(scene_create(&s)); /* the same box as 12 meshes of one triangle each, moved far away */
    struct scene *parts;
    must(scene_create(&parts));
    add_box(s, (struct vec3){1e6, 1e6, 1e6}, (struct vec3){1e6 + 1, 1e6 + 1, 1e6 + 1}, 12);
    for (size_t t = 0; t < 12; t++) {
        const struct scene_material m = scene_material_default();
        double p[9];
        for (int k = 0; k < 3; k++)
            memcpy(p + 3 * k, s->meshes[0].position + 3 * s->meshes[0].index[3 * t + (size_t)k],
                   3 * sizeof *p);
        must(scene_add_mesh(parts, 3, p, 1, (const uint32_t[]){0, 1, 2}, &m));
    }
    solids = solids_of(parts);
    ok(solids.count == 1 && solids.closed_count == 1 && fabs(solids.volume[0] - 1) < 1e-9,
       "equal positions weld, across meshes too: %zu pieces", solids.count);
    scene_solids_clear(&solids);
    scene_destroy(parts);
    scene_destroy(s);

    const struct {
        const char *name;
        struct vec3 low, high;
    } touching[] = {{"a corner", one, two},
                    {"an edge", {1, 1, 0}, {2, 2, 1}},
                    {"a side", {1, 0, 0}, {2, 1, 1}},
                    {"a part of a side", {1, 0.25, 0.25}, {2, 0.75, 0.75}}};
    for (size_t i = 0; i < sizeof touching / sizeof *touching; i++) {
        must(scene_create(&s));
        add_box(s, o, one, 12);
        add_box(s, touching[i].low, touching[i].high, 12);
        solids = solids_of(s);
        ok(solids.count == 2 && solids.closed_count == 2,
           "boxes that share %s stay two closed pieces: %zu of %zu", touching[i].name,
           solids.closed_count, solids.count);
        scene_solids_clear(&solids);
        scene_destroy(s);
    }

    must(scene_create(&s)); /* one face turned round */
    add_box(s, o, one, 12);
    const uint32_t swap = s->meshes[0].index[1];
    s->meshes[0].index[1] = s->meshes[0].index[2];
    s->meshes[0].index[2] = swap;
    solids = solids_of(s);
    ok(solids.count == 1 && solids.closed_count == 1 && fabs(solids.volume[0] - 1) < 1e-12 &&
           solids.turned[0] && !solids.turned[1],
       "a box with a face turned round is closed: that face is turned back");
    scene_solids_clear(&solids);
    scene_destroy(s);

    must(scene_create(&s)); /* every face twice, then a fan of many faces on one edge */
    add_box(s, o, one, 12);
    s->meshes[0].index = realloc(s->meshes[0].index, 72 * sizeof(uint32_t));
    s->meshes[0].material = realloc(s->meshes[0].material, 24 * sizeof(int32_t));
    memcpy(s->meshes[0].index + 36, s->meshes[0].index, 36 * sizeof(uint32_t));
    memcpy(s->meshes[0].material + 12, s->meshes[0].material, 12 * sizeof(int32_t));
    s->meshes[0].triangle_count = 24;
    double fan[36] = {0, 0, 0, 0, 0, 1};
    uint32_t fan_index[30];
    for (uint32_t i = 0; i < 10; i++) {
        vec3_store(fan + 6 + 3 * i, (struct vec3){cos(i), sin(i), 0});
        memcpy(fan_index + 3 * i, (const uint32_t[]){0, 1, i + 2}, 3 * sizeof *fan_index);
    }
    const struct scene_material m = scene_material_default();
    must(scene_add_mesh(s, 12, fan, 10, fan_index, &m));
    solids = solids_of(s);
    ok(solids.closed_count == 0,
       "doubled faces and edges of many faces are not closed, and do no harm");
    scene_solids_clear(&solids);
    scene_destroy(s);

    must(scene_create(&s));
    solids = solids_of(s);
    ok(solids.count == 0, "an empty scene has no pieces");
    scene_solids_clear(&solids);
    scene_destroy(s);
}

int main(void)
{
    files_begin();
    test_linear();
    test_maps();
    test_materials();
    test_sky();
    test_sky_maps();
    test_sky_cubes();
    test_lights();
    test_degenerate();
    test_instances();
    test_factors();
    test_key();
    test_sky_key();
    test_settings();
    test_solids();
    files_end();
    return tap_done();
}
