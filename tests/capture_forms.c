/* SPDX-License-Identifier: Apache-2.0 */
/* Capture against closed forms, to order 6, and against itself: what must stay the same when a
 * scene is changed in a way that light does not notice. Each case is the mean of many seeds;
 * capture_runs.h says what is asked of it, and how seldom luck fails it. */
#include "math/random.h"
#include "scene/scene_build.h"
#include "scene/scene_shade.h"
#include "support/capture_runs.h"
#include "support/files.h"

#include <stb_image_write.h>

static struct capture_settings settings_of(int rays, enum capture_light light)
{
    struct capture_settings s = capture_settings_default();
    s.order = SH_ORDER_MAX;
    s.rays = rays;
    s.light = light;
    return s;
}

/* Captures with 32 seeds and holds the result against the truth. */
static void check_at(const struct bench *b, struct capture_settings s, const double p[3],
                     const double *truth, const char *name)
{
    struct runs runs;
    runs_take(&runs, b, s, p, 32);
    runs_check(&runs, truth, "%s", name);
}

/* Channel k of an albedo or emission as material() has it. */
static double albedo_of(double albedo, int k)
{
    return albedo / (1 << k);
}

static double emission_of(double emission, int k)
{
    return emission * (k == 0 ? 1 : k == 1 ? 2 : 0.5);
}

/* -- sky -------------------------------------------------------------------------------------- */

enum { SKY_WIDTH = 32, SKY_HEIGHT = 16 };

/* A sky of radiance 1 + y / 2, 1 + x / 2, 1 + z / 2 at the texels' middles. */
static void write_gradient(const char *name)
{
    float texel[SKY_HEIGHT * SKY_WIDTH][3];
    for (int i = 0; i < SKY_WIDTH * SKY_HEIGHT; i++) {
        const double azimuth = 2 * PI * ((i % SKY_WIDTH + 0.5) / SKY_WIDTH - 0.5),
                     height = PI * (0.5 - (i / SKY_WIDTH + 0.5) / SKY_HEIGHT);
        texel[i][0] = (float)(1 + 0.5 * sin(height));
        texel[i][1] = (float)(1 + 0.5 * cos(height) * cos(azimuth));
        texel[i][2] = (float)(1 + 0.5 * cos(height) * sin(azimuth));
    }
    if (!stbi_write_hdr(files_path(name), SKY_WIDTH, SKY_HEIGHT, 3, *texel))
        bail("%s: could not be written", files_path(name));
}

/* A dim sky with two adjacent texels, 0.08 sr, that give most of its light. */
static void write_sunny(const char *name)
{
    float texel[SKY_HEIGHT * SKY_WIDTH][3];
    for (int i = 0; i < 3 * SKY_WIDTH * SKY_HEIGHT; i++)
        texel[i / 3][i % 3] = 0.125f * (float)(1 + i % 3);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++)
            texel[4 * SKY_WIDTH + 20 + i][k] = 256;
    if (!stbi_write_hdr(files_path(name), SKY_WIDTH, SKY_HEIGHT, 3, *texel))
        bail("%s: could not be written", files_path(name));
}

static void sky_field(const void *context, const double d[3], double rgb[3])
{
    const struct vec3f r =
        scene_sky_radiance(context, (struct vec3f){(float)d[0], (float)d[1], (float)d[2]});
    rgb[0] = (double)r.x, rgb[1] = (double)r.y, rgb[2] = (double)r.z;
}

/* What falls on a surface that faces up. */
static void falling_field(const void *context, const double d[3], double rgb[3])
{
    sky_field(context, d, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] *= fmax(d[1], 0);
}

struct ground {
    const struct scene *scene;
    double radiance[3];
};

static void ground_field(const void *context, const double d[3], double rgb[3])
{
    const struct ground *ground = context;
    if (d[1] > 0)
        sky_field(ground->scene, d, rgb);
    else
        memcpy(rgb, ground->radiance, sizeof ground->radiance);
}

enum sky_kind { UNIFORM, GRADIENT, SUNNY };

/* A sky alone, and above a diffuse ground that sees nothing but the sky: radiance rho E / pi below
 * the horizon. The ground ends at 2e4 times the probe's height, which is 5e-5 of the half space. */
static void test_sky(enum sky_kind sky, bool grounded)
{
    static const char *const names[] = {
        [UNIFORM] = "uniform", [GRADIENT] = "gradient", [SUNNY] = "sunny"};
    const double height = 1, p[3] = {0.2, height, -0.3}, colour[3] = {0.5, 1, 2};
    struct bench b;
    bench_start(&b);
    if (sky != UNIFORM)
        b.settings.sky_file = strdup(files_path(sky == GRADIENT ? "gradient.hdr" : "sunny.hdr"));
    else
        memcpy(b.settings.sky, colour, sizeof colour);
    if (grounded)
        add_floor(&b, 2e4 * height, 0, material(0.7f, 0));
    bench_finish(&b, 4);
    double truth[TRUTH_VALUES] = {0}, falling[TRUTH_VALUES] = {0};
    struct ground ground = {.scene = b.scene};
    add_field(falling, 2 * SKY_WIDTH, 2 * SKY_HEIGHT, falling_field, b.scene);
    for (int k = 0; k < 3; k++) {
        const double e = falling[k] * sqrt(4 * PI),
                     form = sky == UNIFORM ? PI * colour[k] : PI * (k ? 1 : 1 + 0.5 * 2 / 3);
        ground.radiance[k] = albedo_of((double)0.7f, k) * e / PI;
        if (sky != SUNNY)
            ok(fabs(e - form) < (sky == UNIFORM ? 1e-6 : 0.01) * form,
               "the %s sky's irradiance is %.4f: %.4f", names[sky], form, e);
    }
    add_field(truth, 2 * SKY_WIDTH, 2 * SKY_HEIGHT, grounded ? ground_field : sky_field,
              grounded ? (void *)&ground : (void *)b.scene);
    char name[80];
    snprintf(name, sizeof name, "%s sky%s", names[sky], grounded ? " above a ground" : "");
    const int rays = sky == SUNNY ? 4096 : 512;
    struct runs runs;
    runs_take(&runs, &b, settings_of(rays, CAPTURE_ALL), p, 32);
    runs_check(&runs, truth, "%s", name);
    /* Half of the rays meet the ground, at h / cos: the mean of cos / h over the sphere is 1 / (4
     * h). */
    if (grounded)
        ok(fabs(runs.sky - 0.5) < 5 * sqrt(0.25 / (runs.count * rays)) &&
               fabs(runs.depth / (4 * height) - 1) < 0.01 && runs.validity == 1,
           "%s: share of sky %.4f, depth %.4f", name, runs.sky, runs.depth);
    bench_clear(&b);
}

/* -- emitters --------------------------------------------------------------------------------- */

/* A rotation that no axis likes. */
static const double turned[9] = {2.0 / 3,  -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3,
                                 -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3};

/* A disc seen from its axis is a cap of directions. */
static void test_disc(double solid_angle)
{
    const double cosine = 1 - solid_angle / (2 * PI), distance = 1.5, at[3] = {0.3, -0.2, 0.1};
    const struct vec3 axis = {turned[1], turned[4], turned[7]};
    struct bench b;
    struct shape disc = shape_disc(distance * sqrt(1 - cosine * cosine) / cosine, 512);
    shape_place(&disc, turned, vec3_fma(vec3_load(at), distance, axis));
    bench_start(&b);
    add_shape(&b, &disc, material(0, 3));
    bench_finish(&b, 2);
    double truth[TRUTH_VALUES] = {0}, direction[3];
    vec3_store(direction, axis);
    add_cap(truth, direction, cosine, (const double[3]){3, 6, 1.5});
    char name[80];
    snprintf(name, sizeof name, "disc of %g sr", solid_angle);
    check_at(&b, settings_of(4096, CAPTURE_ALL), at, truth, name);
    bench_clear(&b);
    shape_clear(&disc);
}

/* A sphere of 1280 triangles: their solid angles sum to l = 0, and are near the sphere's. */
static void test_sphere(double distance)
{
    const double radius = 0.7, rgb[3] = {2, 4, 1}, at[3] = {0.3, -0.2, 0.1};
    struct bench b;
    struct shape sphere = shape_sphere(radius, 3);
    shape_move(&sphere, at[0] + 2.0 / 3 * distance, at[1] + 2.0 / 3 * distance,
               at[2] - 1.0 / 3 * distance);
    bench_start(&b);
    add_shape(&b, &sphere, material(0, 2));
    bench_finish(&b, 2);
    double truth[TRUTH_VALUES] = {0}, cap[TRUTH_VALUES] = {0}, solid = 0;
    const struct vec3 from = vec3_load(at);
    add_facing(truth, &sphere, from, 8, rgb);
    add_cap(cap, (const double[3]){2.0 / 3, 2.0 / 3, -1.0 / 3},
            sqrt(1 - radius * radius / (distance * distance)), rgb);
    for (size_t t = 0; t < sphere.triangle_count; t++)
        if (vec3_dot(shape_area_vector(&sphere, t), vec3_sub(shape_corner(&sphere, t, 0), from)) <
            0)
            solid += triangle_solid_angle(vec3_sub(shape_corner(&sphere, t, 0), from),
                                          vec3_sub(shape_corner(&sphere, t, 1), from),
                                          vec3_sub(shape_corner(&sphere, t, 2), from));
    ok(fabs(truth[0] * sqrt(4 * PI) / 2 / solid - 1) < 1e-6 && fabs(truth[0] / cap[0] - 1) < 0.02,
       "sphere at %g: quadrature is its triangles' solid angle, %.6f sr, near the sphere's",
       distance, solid);
    char name[80];
    snprintf(name, sizeof name, "sphere of radius %g at %g", radius, distance);
    check_at(&b, settings_of(4096, CAPTURE_ALL), at, truth, name);
    bench_clear(&b);
    shape_clear(&sphere);
}

/* A tilted quad: SH by quadrature, irradiance by Lambert's formula. Order 6 replaces the cosine
 * lobe by a polynomial that is nowhere more than 0.0586 off (at the horizon: 1/4 - 5/32 - 9/256),
 * so that irradiance is within 0.0586 of radiance times solid angle. */
static void test_polygon(double size, bool front_only, bool turned_away)
{
    const struct vec3 corner = {-0.4, 1.1, 0.2}, u = {size, 0.2 * size, 0.1 * size},
                      v = {-0.1 * size, 0.3 * size, 0.8 * size};
    const struct vec3 polygon[4] = {corner, vec3_add(corner, u), vec3_add(vec3_add(corner, u), v),
                                    vec3_add(corner, v)};
    const double at[3] = {0.1, 0.2, -0.3}, rgb[3] = {3, 6, 1.5}, up[3] = {0, 1, 0};
    const struct gauss g = gauss_rule(48);
    double corners[12], truth[TRUTH_VALUES] = {0}, lambert = 0;
    for (int i = 0; i < 4; i++)
        vec3_store(corners + 3 * (turned_away ? 3 - i : i), vec3_add(vec3_load(at), polygon[i]));
    const bool lit = !front_only || !turned_away;
    struct bench b;
    bench_start(&b);
    b.settings.emit_front_only = front_only;
    add_quad(&b, corners, material(0, 3));
    bench_finish(&b, 2);
    if (lit) {
        add_parallelogram(truth, corner, u, v, &g, rgb);
        lambert = rgb[0] * lambert_irradiance(polygon, 4, (struct vec3){0, 1, 0});
    }
    char name[80];
    snprintf(name, sizeof name, "quad of side %g%s%s", size, front_only ? ", front" : "",
             turned_away ? ", turned away" : "");
    struct runs runs;
    runs_take(&runs, &b, settings_of(2048, CAPTURE_ALL), at, 32);
    if (lit) {
        runs_check(&runs, truth, "%s", name);
        double e[RUNS_MOST], seen[3];
        for (int i = 0; i < runs.count; i++) {
            sh_irradiance(SH_ORDER_MAX, runs.value[i], 0, up, seen);
            e[i] = seen[0];
        }
        const struct estimate mean = estimate_of(e, runs.count);
        ok(fabs(mean.mean - lambert) < 0.0587 * truth[0] * sqrt(4 * PI) + RUNS_T_MOST * mean.error,
           "%s: irradiance %.5f near Lambert's %.5f", name, mean.mean, lambert);
    } else {
        double dark[TRUTH_VALUES];
        runs_mean(&runs, dark);
        ok(largest(dark, TRUTH_VALUES) == 0, "%s: dark", name);
    }
    bench_clear(&b);
}

/* -- punctual lights -------------------------------------------------------------------------- */

/* A floor of this albedo and size that one light shines on, seen from above. */
struct lit_floor {
    const struct scene_light *light;
    double at[3], albedo;
};

static void floor_field(const void *context, const double d[3], double rgb[3])
{
    const struct lit_floor *f = context;
    double to[3], distance, e[3];
    memset(rgb, 0, 3 * sizeof *rgb);
    if (!(d[1] < 0))
        return;
    const double t = f->at[1] / -d[1], point[3] = {f->at[0] + t * d[0], 0, f->at[2] + t * d[2]};
    scene_light_at(f->light, point, to, &distance, e);
    for (int k = 0; k < 3; k++)
        rgb[k] = albedo_of(f->albedo, k) * e[k] * fmax(to[1], 0) / PI;
}

/* Over a floor: the light itself a delta, and one bounce by quadrature. */
static void test_punctual(enum scene_light_kind kind)
{
    static const char *const names[] = {
        [SCENE_POINT] = "point", [SCENE_SPOT] = "spot", [SCENE_SUN] = "sun"};
    const struct scene_light light = {.kind = kind,
                                      .position = {1, 3, 0},
                                      .direction = {-0.28, -0.96, 0},
                                      .intensity = {7, 5, 3},
                                      .cos_inner = 0.98,
                                      .cos_outer = 0.6};
    const struct lit_floor lit = {.light = &light, .at = {0, 1, 0.5}, .albedo = 0.5};
    struct bench b;
    bench_start(&b);
    add_floor(&b, 2e4, 0, material(0.5f, 0));
    add_light(&b, light);
    bench_finish(&b, 1);
    double direct[TRUTH_VALUES] = {0}, bounced[TRUTH_VALUES] = {0}, all[TRUTH_VALUES], d[3],
           distance, rgb[3];
    scene_light_at(&light, lit.at, d, &distance, rgb);
    add_truth(direct, TRUTH_ORDER, d, rgb[0], rgb[1], rgb[2], 1);
    add_field(bounced, 96, 96, floor_field, &lit);
    for (int k = 0; k < TRUTH_VALUES; k++)
        all[k] = direct[k] + bounced[k];
    char name[80];
    snprintf(name, sizeof name, "%s light itself", names[kind]);
    check_at(&b, settings_of(64, CAPTURE_DIRECT), lit.at, direct, name);
    snprintf(name, sizeof name, "%s light, one bounce", names[kind]);
    check_at(&b, settings_of(4096, CAPTURE_INDIRECT), lit.at, bounced, name);
    snprintf(name, sizeof name, "%s light, all of it", names[kind]);
    check_at(&b, settings_of(4096, CAPTURE_ALL), lit.at, all, name);
    bench_clear(&b);
}

/* -- many bounces ----------------------------------------------------------------------------- */

/* A closed box whose walls all shine: after n bounces Le (1 + rho + ... + rho^n) from
 * everywhere. */
static void test_furnace(int bounces)
{
    const double rho = (double)0.6f, le = 1.5;
    double truth[TRUTH_VALUES] = {0}, rgb[3];
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.6f, 1.5f));
    bench_finish(&b, bounces);
    for (int k = 0; k < 3; k++)
        rgb[k] = emission_of(le, k) * (1 - pow(albedo_of(rho, k), bounces + 1)) /
                 (1 - albedo_of(rho, k));
    add_uniform(truth, rgb);
    struct capture_settings s = settings_of(1024, CAPTURE_ALL);
    s.bounces = bounces;
    char name[80];
    snprintf(name, sizeof name, "furnace with %d bounces", bounces);
    check_at(&b, s, (const double[3]){0.3, -0.4, 0.2}, truth, name);
    bench_clear(&b);
}

/* A sphere with diffuse walls, of which a patch of share f shines (or is open to the sky): every
 * point of a sphere sees the patch under the same form factor f, so the walls are lit evenly: E =
 * pi Le f / (1 - rho s), s the share that scatters, 1 with a patch that does so too, 1 - f with a
 * hole (Jacquez and Kuppenheim, "Theory of the integrating sphere", J. Opt. Soc. Am. 45, 1955). */
static void test_integrating_sphere(bool hole)
{
    const double rho = (double)0.8f, at[3] = {0.2, -0.3, 0.1}, le[3] = {3, 6, 1.5};
    struct shape wall = shape_sphere(-1, 5);
    const double area = shape_area(&wall);
    struct shape patch = shape_cut(&wall, (struct vec3){0.6, 0, 0.8}, hole ? 0.7 : 0.9);
    const double share = shape_area(&patch) / area;
    struct bench b;
    bench_start(&b);
    add_shape(&b, &wall, material(0.8f, 0));
    if (hole)
        memcpy(b.settings.sky, le, sizeof le);
    else
        add_shape(&b, &patch, material(0.8f, 3));
    bench_finish(&b, 128);
    double truth[TRUTH_VALUES] = {0}, all[TRUTH_VALUES] = {0}, scattered[3], rest[3];
    for (int k = 0; k < 3; k++) {
        const double a = albedo_of(rho, k);
        scattered[k] = a * le[k] * share / (1 - a * (hole ? 1 - share : 1));
        /* what the patch gives beside the walls' radiance */
        rest[k] = hole ? le[k] - scattered[k] : le[k];
    }
    add_uniform(all, scattered);
    add_facing(all, &patch, vec3_load(at), 3, rest);
    add_uniform(truth, scattered);
    if (hole) {
        const double dark[3] = {-scattered[0], -scattered[1], -scattered[2]};
        add_facing(truth, &patch, vec3_load(at), 3, dark);
    }
    const char *name = hole ? "sphere with a hole" : "sphere with a bright patch";
    char full[80];
    struct capture_settings s = settings_of(8192, CAPTURE_INDIRECT);
    s.bounces = 128;
    snprintf(full, sizeof full, "%s, walls", name);
    check_at(&b, s, at, truth, full);
    s.light = CAPTURE_ALL;
    snprintf(full, sizeof full, "%s, all", name);
    check_at(&b, s, at, all, full);
    bench_clear(&b);
    shape_clear(&wall);
    shape_clear(&patch);
}

/* A black sphere that shines within a diffuse one: of what the outer one sends, the share q = (a /
 * b)^2 meets the inner one, the rest itself: radiance rho Le q / (1 - rho (1 - q)). q is the share
 * of the areas, of spheres and of their triangles alike (reciprocity). */
static void test_concentric(double radius)
{
    const double rho = (double)0.7f, at[3] = {0.5, -0.4, 0.3}, le[3] = {3, 6, 1.5};
    struct shape outer = shape_sphere(-1, 4), inner = shape_sphere(radius, 4);
    const double q = shape_area(&inner) / shape_area(&outer);
    struct bench b;
    bench_start(&b);
    add_shape(&b, &outer, material(0.7f, 0));
    add_shape(&b, &inner, material(0, 3));
    bench_finish(&b, 64);
    double truth[TRUTH_VALUES] = {0}, wall[3], rest[3];
    for (int k = 0; k < 3; k++) {
        const double a = albedo_of(rho, k);
        wall[k] = a * le[k] * q / (1 - a * (1 - q));
        rest[k] = le[k] - wall[k];
    }
    add_uniform(truth, wall);
    add_facing(truth, &inner, vec3_load(at), 4, rest);
    char name[80];
    snprintf(name, sizeof name, "spheres of radius %g and 1", radius);
    check_at(&b, settings_of(4096, CAPTURE_ALL), at, truth, name);
    bench_clear(&b);
    shape_clear(&outer);
    shape_clear(&inner);
}

/* -- textures --------------------------------------------------------------------------------- */

enum { TEXELS = 8 };

/* A horizontal square with a texture of its own: texel (i, j) of the picture as a parallelogram
 * seen from `at`. u runs along +z and v along +x on add_floor's square; the picture's top row has v
 * = 1. */
static void add_texel(double *truth, int texel, double half, const double at[3],
                      const double rgb[3])
{
    const struct gauss g = gauss_rule(8);
    const double step = 2 * half / TEXELS;
    const struct vec3 corner = {(TEXELS - 1 - texel / TEXELS) * step - half, 0,
                                texel % TEXELS * step - half};
    add_parallelogram(truth, vec3_sub(corner, vec3_load(at)), (struct vec3){step, 0, 0},
                      (struct vec3){0, 0, step}, &g, rgb);
}

/* A square of random albedos under a uniform sky, which it alone sees: radiance rho(u, v) L. */
static void test_albedo_texture(void)
{
    const double half = 2, at[3] = {0.3, 0.8, -0.4};
    float texel[TEXELS * TEXELS][3];
    struct random random = random_start(3, 0, 0);
    for (int i = 0; i < 3 * TEXELS * TEXELS; i++)
        texel[i / 3][i % 3] = random_float(&random);
    struct bench b;
    bench_start(&b);
    b.settings.sky[0] = b.settings.sky[1] = b.settings.sky[2] = 1;
    struct scene_material m = material(0.8f, 0);
    m.albedo_map = scene_map_of(add_texture(&b, TEXELS, TEXELS, 3, *texel));
    add_floor(&b, half, 0, m);
    map_quad(&b);
    bench_finish(&b, 2);
    double truth[TRUTH_VALUES] = {0};
    for (int i = 0; i < TEXELS * TEXELS; i++) {
        double rgb[3];
        for (int k = 0; k < 3; k++)
            rgb[k] = albedo_of((double)0.8f, k) * (double)texel[i][k];
        add_texel(truth, i, half, at, rgb);
    }
    check_at(&b, settings_of(2048, CAPTURE_INDIRECT), at, truth, "a floor of 64 albedos");
    bench_clear(&b);
}

/* A black square with holes before a uniform sky: cut out by a mask, or blended by it. */
static void test_alpha_texture(bool blend)
{
    const double half = 2, at[3] = {0.3, 0.8, -0.4};
    float texel[TEXELS * TEXELS];
    struct random random = random_start(4, 0, 0);
    for (int i = 0; i < TEXELS * TEXELS; i++)
        texel[i] = random_float(&random);
    struct bench b;
    bench_start(&b);
    memcpy(b.settings.sky, (const double[3]){1, 2, 0.5}, sizeof b.settings.sky);
    struct scene_material m = material(0, 0);
    m.alpha = blend ? SCENE_BLEND : SCENE_CUTOUT;
    m.alpha_map = scene_map_of(add_texture(&b, TEXELS, TEXELS, 1, texel));
    m.cutoff = 0.4f;
    add_floor(&b, half, 0, m);
    map_quad(&b);
    bench_finish(&b, 2);
    double truth[TRUTH_VALUES] = {0}, open = 0;
    add_uniform(truth, b.settings.sky);
    for (int i = 0; i < TEXELS * TEXELS; i++) {
        const double opaque = blend ? (double)texel[i] : texel[i] >= 0.4f;
        add_texel(truth, i, half, at, (const double[3]){-opaque, -2 * opaque, -0.5 * opaque});
    }
    open = truth[0] / sqrt(4 * PI);
    struct runs runs;
    runs_take(&runs, &b, settings_of(1024, CAPTURE_ALL), at, 32);
    runs_check(&runs, truth, "%s square", blend ? "blended" : "cut-out");
    ok(fabs(runs.sky - open) < 5 * sqrt(open * (1 - open) / (runs.count * 1024)),
       "%s square: the share of open sky is %.4f: %.4f", blend ? "blended" : "cut-out", open,
       runs.sky);
    bench_clear(&b);
}

/* A furnace with walls of a fine checkerboard: as if all had the mean albedo. */
static void test_checkerboard(void)
{
    enum { CHECKS = 64 };
    static float texel[CHECKS * CHECKS][3];
    for (int i = 0; i < CHECKS * CHECKS; i++)
        for (int k = 0; k < 3; k++)
            texel[i][k] = (i / CHECKS + i % CHECKS + k) % 2 ? 0.9f : 0.1f;
    struct bench b;
    bench_start(&b);
    struct scene_material m = material(1, 1);
    m.albedo_map = scene_map_of(add_texture(&b, CHECKS, CHECKS, 3, *texel));
    for (int side = 0; side < 6; side++) {
        double corner[12];
        for (int i = 0; i < 4; i++) {
            corner[3 * i + side / 2] = side % 2 ? 1 : -1;
            corner[3 * i + (side / 2 + 1) % 3] = i == 1 || i == 2 ? 1 : -1;
            corner[3 * i + (side / 2 + 2) % 3] = i >= 2 ? 1 : -1;
        }
        add_quad(&b, corner, m);
        map_quad(&b);
    }
    bench_finish(&b, 64);
    double truth[TRUTH_VALUES] = {0}, rgb[3];
    for (int k = 0; k < 3; k++)
        rgb[k] = emission_of(1, k) / (1 - albedo_of(0.5, k));
    add_uniform(truth, rgb);
    check_at(&b, settings_of(1024, CAPTURE_ALL), (const double[3]){0.1, 0.2, -0.15}, truth,
             "furnace of checkerboards");
    bench_clear(&b);
}

/* -- invariants ------------------------------------------------------------------------------- */

/* A room with a window, a tilted panel, two lamps and a bulb. */
struct room {
    const double *rotation; /* NULL: as it stands */
    int colour_turn;        /* channel k of everything becomes channel k + colour_turn */
    double lamp[2], bulb, sky;
};

static void turn_colour(const struct room *room, const double from[3], double factor, double to[3])
{
    for (int k = 0; k < 3; k++)
        to[(k + room->colour_turn) % 3] = factor * from[k];
}

static void add_panel(struct bench *b, const struct room *room, const double panel[9],
                      const double albedo[3], const double emission[3])
{
    const struct vec3 middle = vec3_load(panel), u = vec3_load(panel + 3), v = vec3_load(panel + 6);
    struct shape s = shape_create(4, 2);
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    memcpy(s.index, index, sizeof index);
    for (int i = 0; i < 4; i++)
        vec3_store(s.position + 3 * i,
                   vec3_fma(vec3_fma(middle, i == 1 || i == 2 ? 1 : -1, u), i >= 2 ? 1 : -1, v));
    if (room->rotation)
        shape_place(&s, room->rotation, (struct vec3){0});
    struct scene_material m = material(0, 0);
    m.albedo = (struct vec3f){(float)albedo[0], (float)albedo[1], (float)albedo[2]};
    m.emission = (struct vec3f){(float)emission[0], (float)emission[1], (float)emission[2]};
    add_shape(b, &s, m);
    shape_clear(&s);
}

static struct vec3 turn_point(const struct room *room, struct vec3 p)
{
    const double *r = room->rotation;
    return r ? (struct vec3){vec3_dot(vec3_load(r), p), vec3_dot(vec3_load(r + 3), p),
                             vec3_dot(vec3_load(r + 6), p)}
             : p;
}

static void room_build(struct bench *b, const struct room *room)
{
    static const struct {
        double panel[9], albedo[3];
    } walls[] = {
        {{0, -1, 0, 2, 0, 0, 0, 0, 1.5}, {0.7, 0.6, 0.5}},
        {{0, 1, 0, 2, 0, 0, 0, 0, 1.5}, {0.8, 0.8, 0.7}},
        {{-2, 0, 0, 0, 1, 0, 0, 0, 1.5}, {0.8, 0.2, 0.1}},
        {{2, -0.5, 0, 0, 0.5, 0, 0, 0, 1.5}, {0.2, 0.7, 0.3}},
        {{0, 0, -1.5, 2, 0, 0, 0, 1, 0}, {0.4, 0.5, 0.8}},
        {{0, 0, 1.5, 2, 0, 0, 0, 1, 0}, {0.6, 0.6, 0.6}},
        {{0.4, -0.4, 0.3, 0.5, 0.2, 0.1, -0.1, 0.3, 0.4}, {0.9, 0.5, 0.2}},
    };
    static const double lamps[2][9] = {{-1, 0.6, 0, 0.5, 0, 0, 0, 0, 0.4},
                                       {0.9, -0.2, -0.8, 0.4, 0.1, 0, 0, 0.1, 0.3}};
    static const double shine[2][3] = {{4, 1, 2}, {1, 3, 5}}, dark[3] = {0, 0, 0},
                        bulb[3] = {0.06, 0.04, 0.12}, sky[3] = {0.4, 0.6, 1};
    double albedo[3], emission[3];
    bench_start(b);
    for (size_t i = 0; i < sizeof walls / sizeof *walls; i++) {
        turn_colour(room, walls[i].albedo, 1, albedo);
        add_panel(b, room, walls[i].panel, albedo, dark);
    }
    for (int i = 0; i < 2; i++) {
        turn_colour(room, walls[0].albedo, 1, albedo);
        turn_colour(room, shine[i], room->lamp[i], emission);
        add_panel(b, room, lamps[i], albedo, emission);
    }
    struct scene_light light = {.kind = SCENE_POINT,
                                .position = turn_point(room, (struct vec3){-1.2, 0.3, -0.6})};
    turn_colour(room, bulb, room->bulb, light.intensity);
    turn_colour(room, sky, room->sky, b->settings.sky);
    add_light(b, light);
    bench_finish(b, 32);
}

/* What 32 seeds from `seed` on see of a room. */
static void room_runs(struct runs *runs, const struct room *room, enum capture_light light,
                      uint64_t seed)
{
    struct bench b;
    double p[3];
    vec3_store(p, turn_point(room, (struct vec3){-0.2, 0.1, 0.35}));
    room_build(&b, room);
    struct capture_settings s = settings_of(8192, light);
    s.seed = seed;
    s.bounces = 32;
    runs_take(runs, &b, s, p, 32);
    bench_clear(&b);
}

static const struct room whole = {.lamp = {1, 1}, .bulb = 1, .sky = 1};

/* Two runs, or a sum of two, that must be the same light. */
static void check_same(const struct runs *a, const struct runs *b, const struct runs *sum,
                       const char *name)
{
    if (SANITIZED) {
        tap_skip("%s: too few runs for statistics under sanitizers", name);
        return;
    }
    const double t = runs_difference_t(a, b, sum);
    double mean[TRUTH_VALUES];
    runs_mean(sum, mean);
    const struct estimate x = runs_bias(a, mean),
                          y = b ? runs_bias(b, mean) : (struct estimate){-1, 0},
                          z = runs_bias(sum, mean);
    const struct estimate off = {x.mean + y.mean + 1,
                                 sqrt(x.error * x.error + y.error * y.error + z.error * z.error)};
    ok(t < RUNS_T_MOST, "%s: every coefficient (t = %.2f)", name, t);
    ok(deviation(off.mean, off.error, 1) < RUNS_T_MOST && off.error < RUNS_RESOLUTION,
       "%s: off by %+.3f %%, standard error %.3f %%", name, 100 * off.mean, 100 * off.error);
}

static void test_linear(const struct runs *all)
{
    const struct room first = {.lamp = {1, 0}, .sky = 1}, second = {.lamp = {0, 1}, .bulb = 1};
    const struct room tripled = {.lamp = {3, 3}, .bulb = 3, .sky = 3};
    struct runs a, b;
    room_runs(&a, &first, CAPTURE_ALL, 100);
    room_runs(&b, &second, CAPTURE_ALL, 200);
    check_same(&a, &b, all, "lamp and sky, lamp and bulb sum to all");
    room_runs(&a, &tripled, CAPTURE_ALL, 300);
    for (int i = 0; i < a.count; i++)
        for (int k = 0; k < TRUTH_VALUES; k++)
            a.value[i][k] /= 3;
    check_same(&a, NULL, all, "three times the light is three times as bright");
}

static void test_split(const struct runs *all)
{
    struct runs direct, indirect;
    room_runs(&direct, &whole, CAPTURE_DIRECT, 400);
    room_runs(&indirect, &whole, CAPTURE_INDIRECT, 500);
    check_same(&direct, &indirect, all, "direct and indirect sum to all");
}

static void test_channels(const struct runs *all)
{
    struct room room = whole;
    struct runs turned_colours;
    room.colour_turn = 1;
    room_runs(&turned_colours, &room, CAPTURE_ALL, 600);
    for (int i = 0; i < turned_colours.count; i++) {
        for (int k = 0; k < TRUTH_VALUES; k += 3) {
            float *v = turned_colours.value[i] + k;
            const float last = v[0]; /* red came to stand in green */
            v[0] = v[1];
            v[1] = v[2];
            v[2] = last;
        }
    }
    check_same(&turned_colours, NULL, all, "channels change places as the colours do");
    struct bench b;
    room_build(&b, &(struct room){.bulb = 0});
    b.scene->materials[b.scene->material_count - 1].emission = (struct vec3f){1, 0, 0};
    path_clear(&b.path);
    must(path_init(&b.path, b.tracer, 32));
    const struct capture_probe p = capture(
        &b, &(struct capture_settings){.order = 6, .rays = 1000, .bounces = 32}, -0.2, 0.1, 0.35);
    float others = 0;
    for (int k = 0; k < TRUTH_VALUES; k++)
        others = k % 3 ? fmaxf(others, fabsf(p.sh[k])) : others;
    ok(p.sh[0] > 0 && others == 0, "a red lamp gives red alone: %g, %g", (double)p.sh[0],
       (double)others);
    bench_clear(&b);
}

static void test_rotation(const struct runs *all)
{
    static double matrix[SH_COUNT_MAX][SH_COUNT_MAX];
    struct room room = whole;
    struct runs rotated, expected = *all;
    room.rotation = turned;
    room_runs(&rotated, &room, CAPTURE_ALL, 700);
    rotation_matrix(turned, matrix);
    for (int i = 0; i < all->count; i++) {
        for (int k = 0; k < TRUTH_VALUES; k++) {
            double sum = 0;
            for (int j = 0; j < SH_COUNT_MAX; j++)
                sum += matrix[k / 3][j] * (double)all->value[i][3 * j + k % 3];
            expected.value[i][k] = (float)sum;
        }
    }
    check_same(&rotated, NULL, &expected, "bands turn with the room");
}

/* Orders 1 .. 5 are the beginning of order 6, sh_error too. */
static void test_orders(void)
{
    struct bench b;
    room_build(&b, &whole);
    struct capture_settings s = settings_of(500, CAPTURE_ALL);
    const struct capture_probe most = capture(&b, &s, -0.2, 0.1, 0.35);
    for (s.order = 1; s.order < SH_ORDER_MAX; s.order++) {
        const struct capture_probe p = capture(&b, &s, -0.2, 0.1, 0.35);
        const size_t size = (size_t)(3 * s.order * s.order) * sizeof(float);
        ok(!memcmp(p.sh, most.sh, size) && !memcmp(p.sh_error, most.sh_error, size),
           "order %d is the beginning of order %d", s.order, SH_ORDER_MAX);
    }
    bench_clear(&b);
}

int main(void)
{
    files_begin();
    write_gradient("gradient.hdr");
    write_sunny("sunny.hdr");
    for (int i = 0; i < 6; i++)
        test_sky((enum sky_kind)(i % 3), i / 3);
    files_end();
    static const double solid_angles[] = {5, 1, 0.05, 1e-4};
    for (int i = 0; i < 4; i++)
        test_disc(solid_angles[i]);
    static const double distances[] = {0.85, 3, 50};
    for (int i = 0; i < 3; i++)
        test_sphere(distances[i]);
    for (int i = 0; i < 4; i++)
        test_polygon(i ? 1 : 0.02, i & 1, i & 2);
    for (int kind = 0; kind < 3; kind++)
        test_punctual((enum scene_light_kind)kind);
    for (int bounces = 0; bounces <= 64; bounces = bounces ? bounces * 2 : 1)
        test_furnace(bounces);
    test_integrating_sphere(false);
    test_integrating_sphere(true);
    test_concentric(0.2);
    test_concentric(0.5);
    test_albedo_texture();
    test_alpha_texture(false);
    test_alpha_texture(true);
    test_checkerboard();
    static struct runs all;
    room_runs(&all, &whole, CAPTURE_ALL, 0);
    test_linear(&all);
    test_split(&all);
    test_channels(&all);
    test_rotation(&all);
    test_orders();
    return tap_done();
}
