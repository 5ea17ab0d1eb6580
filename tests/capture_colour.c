/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of vertices, and texture coordinates that emission alone reads: what rays meet and what
 * probes capture is what closed forms say, wherever a mesh is placed and however a path gets
 * there. */
#include "support/capture_bench.h"
#include "topology/decimate.h"
#include "trace/trace_local.h"

/* Colours the newest mesh by a function of its vertices' positions. */
typedef void colouring(const double *position, double rgba[4]);

static void colour(struct bench *b, colouring *at)
{
    struct scene_mesh *mesh = &b->scene->meshes[b->scene->mesh_count - 1];
    must(array_create(&mesh->colour, 4 * mesh->vertex_count, sizeof *mesh->colour));
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double rgba[4];
        at(mesh->position + 3 * v, rgba);
        for (size_t k = 0; k < 4; k++)
            mesh->colour[4 * v + k] = (uint16_t)(65535 * rgba[k] + 0.5);
    }
}

/* Along x and z from -1 to 1: red and alpha to the right, green to the front. */
static void ramps(const double *p, double rgba[4])
{
    rgba[0] = (1 + p[0]) / 2;
    rgba[1] = (1 + p[2]) / 2;
    rgba[2] = 0.25;
    rgba[3] = (1 + p[0]) / 2;
}

static void half(const double *p, double rgba[4])
{
    (void)p;
    rgba[0] = rgba[1] = rgba[2] = 0.5;
    rgba[3] = 1;
}

static void white(const double *p, double rgba[4])
{
    (void)p;
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 1;
}

/* The albedo that is met below a point of the floor. */
static struct vec3f below(const struct tracer *t, double x, double z)
{
    struct trace_rays rays = {0};
    struct trace_points at;
    const double p[3] = {x, 5, z};
    wave_put(&rays.origin, 0, trace_to_local(t, p));
    wave_put(&rays.direction, 0, (struct vec3f){0, -1, 0});
    rays.most[0] = INFINITY;
    trace_rays_nearest(t, 1, &rays, &at);
    return at.hit[0] ? trace_albedo(t, &at, 0) : (struct vec3f){-1, -1, -1};
}

static bool is_near(struct vec3f a, double x, double y, double z)
{
    return fabs((double)a.x - x) < 1e-4 && fabs((double)a.y - y) < 1e-4 &&
           fabs((double)a.z - z) < 1e-4;
}

/* -- what rays meet --------------------------------------------------------------------------- */

/* A coloured floor, placed at x = 0 and, mirrored, where `twice`, at x = 4; a plain one at x = 8.
 */
static void start_floors(struct bench *b, bool twice, enum scene_alpha alpha)
{
    const double mirrored[12] = {-1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0};
    struct scene_material m = material(0.8f, 0);
    m.alpha = alpha;
    bench_start(b);
    add_floor(b, 1, 0, m);
    colour(b, ramps);
    if (twice)
        must(scene_push_instance(b->scene, 0, mirrored));
    add_quad(b, (const double[12]){7, 0, -1, 7, 0, 1, 9, 0, 1, 9, 0, -1}, material(0.8f, 0));
    bench_finish(b, 4);
}

static void test_albedo(void)
{
    for (int twice = 0; twice < 2; twice++) {
        struct bench b;
        int right = 0, all = 0;
        start_floors(&b, twice, SCENE_OPAQUE);
        for (double x = -0.9; x < 1; x += 0.3) {
            for (double z = -0.95; z < 1; z += 0.3) {
                const double red = 0.8 * (1 + x) / 2, green = 0.4 * (1 + z) / 2;
                all += 1 + twice;
                right += is_near(below(b.tracer, x, z), red, green, 0.05);
                right += twice && is_near(below(b.tracer, 4 - x, z), red, green, 0.05);
            }
        }
        ok(right == all,
           "a floor %s: colours of vertices times the albedo, linear in between: %d of %d",
           twice ? "placed twice, once mirrored" : "placed once", right, all);
        ok(is_near(below(b.tracer, 8, 0.3), 0.8, 0.4, 0.2),
           "a mesh without colours stays as it is");
        bench_clear(&b);
    }
}

static double seen_through(const struct tracer *t, double x)
{
    const double a[3] = {x, 1, 0.1}, b[3] = {x, -1, 0.1};
    return (double)trace_visibility(t, a, b);
}

static void test_alpha(void)
{
    struct bench b;
    start_floors(&b, true, SCENE_BLEND);
    ok(fabs(seen_through(b.tracer, -0.5) - 0.75) < 1e-4 &&
           fabs(seen_through(b.tracer, 4.5) - 0.75) < 1e-4,
       "a blended surface lets through what the vertices' alpha leaves");
    int passed = 0;
    enum { RAYS = 4000 };
    for (int i = 0; i < RAYS; i++) {
        const struct trace_ray ray = {.origin = trace_to_local(b.tracer, (double[]){-0.5, 1, 0.1}),
                                      .direction = {0, -1, 0},
                                      .most = INFINITY,
                                      .salt = (uint32_t)i * 2654435761u};
        passed += !trace_local_occluded(b.tracer, &ray);
    }
    /* five standard deviations of a binomial distribution */
    ok(fabs(passed - 0.75 * RAYS) < 5 * sqrt(0.75 * 0.25 * RAYS),
       "by chance, as many rays: %d of %d", passed, RAYS);
    bench_clear(&b);
    start_floors(&b, false, SCENE_CUTOUT);
    ok(seen_through(b.tracer, -0.1) == 1 && seen_through(b.tracer, 0.1) == 0,
       "a cut-out is one by the vertices' alpha as well");
    bench_clear(&b);
    start_floors(&b, false, SCENE_OPAQUE);
    ok(seen_through(b.tracer, -0.9) == 0, "an opaque material has no alpha");
    bench_clear(&b);
}

/* -- what probes capture ---------------------------------------------------------------------- */

/* In a closed cube whose walls emit E and have albedo a, radiance is E / (1 - a) everywhere. */
static struct capture_probe furnace(colouring *at, float albedo)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1, material(albedo, 1));
    if (at)
        colour(&b, at);
    bench_finish(&b, 64);
    const struct capture_settings s = capture_settings_default();
    const struct capture_probe p = capture(&b, &s, 0.1, 0.2, -0.3);
    bench_clear(&b);
    return p;
}

static void test_furnace(void)
{
    const struct capture_probe tinted = furnace(half, 0.8f), plain = furnace(NULL, 0.4f),
                               untinted = furnace(white, 0.4f);
    static const double emission[3] = {1, 2, 0.5};
    double off = 0, from_plain = 0;
    for (int c = 0; c < 3; c++) {
        const double a = 0.4 / (1 << c), l = (double)tinted.sh[c] / sqrt(4 * PI);
        off = fmax(off, fabs(l - emission[c] / (1 - a)) / emission[c]);
    }
    for (int k = 0; k < 27; k++)
        from_plain = fmax(from_plain, fabs((double)tinted.sh[k] - (double)plain.sh[k]));
    /* four standard deviations: of the geometric number of bounces after the second */
    ok(off < 0.04,
       "a furnace: colours multiply the albedo at each bounce, and not the emission: "
       "off by %.2g",
       off);
    ok(from_plain < 1e-3, "half the colour is half the albedo, path by path: %.2g", from_plain);
    ok(!memcmp(plain.sh, untinted.sh, sizeof plain.sh), "white vertices change no byte");
}

/* A lamp whose picture reads coordinates of its own. */
static void start_lamp(struct bench *b, bool own)
{
    enum { SIDE = 64 };
    float texels[3 * SIDE * SIDE] = {0}, *blank = NULL;
    for (size_t y = 40; y < 44; y++)
        for (size_t x = 8; x < 12; x++)
            texels[3 * (y * SIDE + x)] = texels[3 * (y * SIDE + x) + 1] = 100;
    const float grey[3] = {0.5f, 0.5f, 0.5f};
    bench_start(b);
    struct scene_material m = material(0.5f, 1);
    m.emission_map = scene_map_of(add_texture(b, SIDE, SIDE, 3, texels));
    m.albedo_map = scene_map_of(add_texture(b, 1, 1, 3, grey));
    add_quad(b, (const double[12]){-5, 0, 0, 5, 0, 0, 5, 10, 0, -5, 10, 0}, m);
    map_quad(b);
    struct scene_mesh *mesh = &b->scene->meshes[b->scene->mesh_count - 1];
    if (own) {
        must(array_create(&blank, 12, sizeof *blank));
        mesh->emission_uv = mesh->uv;
        mesh->uv = blank;
    }
    bench_finish(b, 2);
}

static void test_emission(void)
{
    struct capture_probe p[2];
    for (int own = 0; own < 2; own++) {
        struct bench b;
        const struct capture_settings s = capture_settings_default();
        start_lamp(&b, own);
        p[own] = capture(&b, &s, 1, 3, 4);
        if (own)
            ok(b.path.lights.count > 2,
               "a lamp's picture is found by its own coordinates: %zu parts", b.path.lights.count);
        bench_clear(&b);
    }
    ok(p[0].sh[0] > 0 && !memcmp(p[0].sh, p[1].sh, sizeof p[0].sh),
       "and shines as if all pictures had them: %g", (double)p[1].sh[0]);
}

/* -- decimation ------------------------------------------------------------------------------- */

static void test_decimation(void)
{
    struct bench b;
    bench_start(&b);
    struct shape grid = shape_grid(1, 16);
    add_shape(&b, &grid, material(0.8f, 0));
    shape_clear(&grid);
    colour(&b, ramps);
    must(scene_finish(b.scene, &b.settings, NULL));
    must(scene_decimate(b.scene, 2.0 / 512, NULL));
    must(trace_create(&b.tracer, b.scene));
    int right = 0, all = 0;
    for (double x = -0.9; x < 1; x += 0.3) {
        for (double z = -0.95; z < 1; z += 0.3, all++) {
            const struct vec3f a = below(b.tracer, x, z);
            right += is_near(a, 0.8 * (1 + x) / 2, 0.4 * (1 + z) / 2, 0.05);
        }
    }
    ok(scene_triangle_count(b.scene) == 2 && right == all,
       "a floor of colours that are linear is decimated to %zu triangles, and has them: %d of %d",
       scene_triangle_count(b.scene), right, all);
    trace_destroy(b.tracer);
    b.tracer = NULL;
    bench_clear(&b);
}

int main(void)
{
    test_albedo();
    test_alpha();
    test_furnace();
    test_emission();
    test_decimation();
    return tap_done();
}
