/* Capture against closed forms, by z-scores: (value - truth) / sh_error. One z-score is held within 4.5 (a chance of 7e-6 of
 * failing by luck), the coverage of sh_error within what is stated there. */
#include "capture.h"
#include "error.h"
#include "random.h"
#include "scene.h"
#include "sh.h"
#include "stream.h"
#include "tap.h"
#include "trace.h"
#include "warning.h"

#include <string.h>

#define PI 3.14159265358979323846

static void must(struct error *err)
{
    if (err)
        bail("%s", error_message(err));
}

/* A scene that is put together by hand, its tracer and path tracer. */
struct bench {
    struct scene *scene;
    struct tracer *tracer;
    struct path_tracer path;
    struct scene_settings settings;
};

static void bench_start(struct bench *b)
{
    *b = (struct bench){.settings = scene_settings_default()};
    must(scene_create(&b->scene));
}

static void bench_finish(struct bench *b, int bounces)
{
    must(scene_finish(b->scene, &b->settings, NULL));
    must(trace_create(&b->tracer, b->scene));
    must(path_create(&b->path, b->tracer, bounces));
}

static void bench_clear(struct bench *b)
{
    path_clear(&b->path);
    trace_destroy(b->tracer);
    scene_destroy(b->scene);
    scene_settings_clear(&b->settings);
}

static struct scene_material material(float albedo, float emission)
{
    static char name[] = "m";
    return (struct scene_material){.name = name, .albedo = {albedo, albedo / 2, albedo / 4}, .emission = {emission, 2 * emission, emission / 2},
                                   .albedo_map = {.texture = SCENE_NONE}, .emission_map = {.texture = SCENE_NONE},
                                   .alpha_map = {.texture = SCENE_NONE}, .opacity = 1, .cutoff = 0.5f};
}

static void add_quad(struct bench *b, const double corner[12], struct scene_material m)
{
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    must(scene_add_mesh(b->scene, 4, corner, 2, index, &m));
}

/* A cube about the origin, faces inward. */
static void add_cube(struct bench *b, double half, struct scene_material m)
{
    double p[24];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = i >> k & 1 ? half : -half;
    const uint32_t quad[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t index[36];
    for (int i = 0; i < 6; i++) {
        const uint32_t *q = quad[i], two[6] = {q[0], q[2], q[1], q[0], q[3], q[2]};
        memcpy(index + 6 * i, two, sizeof two);
    }
    must(scene_add_mesh(b->scene, 8, p, 12, index, &m));
}

static struct capture_probe capture(const struct bench *b, const struct capture_settings *s, double x, double y, double z)
{
    struct capture_probe probe;
    must(capture_probe(&b->path, s, (const double[3]){x, y, z}, NULL, &probe));
    return probe;
}

/* Largest |z| of the coefficients against a truth. */
static double worst_z(const struct capture_probe *p, int order, const double *truth)
{
    double worst = 0;
    for (int i = 0; i < 3 * order * order; i++) {
        const double off = fabs((double)p->sh[i] - truth[i]), error = (double)p->sh_error[i] + 1e-6 * (1 + fabs(truth[i]));
        worst = fmax(worst, off / error);
    }
    return worst;
}

/* Adds radiance * solid angle from a direction to the truth. */
static void add_truth(double *truth, int order, const double d[3], double r, double g, double b, double weight)
{
    double y[SH_COUNT_MAX];
    sh_basis(order, d, y);
    sh_project(order, y, (const double[3]){r, g, b}, weight, truth);
}

static void test_sky(void)
{
    struct bench b;
    bench_start(&b);
    b.settings.sky[0] = 0.5, b.settings.sky[1] = 1, b.settings.sky[2] = 2;
    bench_finish(&b, 8);
    struct capture_settings s = capture_settings_default();
    const struct capture_probe p = capture(&b, &s, 1, 2, 3);
    double truth[27] = {0};
    const double y00 = sqrt(4 * PI);
    truth[0] = 0.5 * y00, truth[1] = y00, truth[2] = 2 * y00;
    ok(worst_z(&p, 3, truth) < 4.5, "uniform sky: only Y00 (z = %.2f)", worst_z(&p, 3, truth));
    ok(p.sky == 1 && p.depth == 0 && p.validity == 1, "and all rays escape");
    bench_clear(&b);
}

static void test_furnace(void)
{
    const float rho = 0.6f, le = 1.5f;
    for (int bounces = 0; bounces <= 64; bounces = bounces ? bounces * 4 : 1) {
        struct bench b;
        bench_start(&b);
        add_cube(&b, 2, material(rho, le));
        bench_finish(&b, bounces);
        struct capture_settings s = capture_settings_default();
        s.rays = 2000;
        s.bounces = bounces;
        double truth[27] = {0}, worst = 0;
        for (int k = 0; k < 3; k++) {
            const double r = (double)rho / (1 << k), e = (double)le * (k == 0 ? 1 : k == 1 ? 2 : 0.5);
            truth[k] = e * (1 - pow(r, bounces + 1)) / (1 - r) * sqrt(4 * PI);
        }
        for (int i = 0; i < 4; i++) {
            const struct capture_probe p = capture(&b, &s, 0.3 * i, -0.4 * i, 0.2 * i);
            worst = fmax(worst, worst_z(&p, 3, truth));
            if (!i)
                ok(p.sky == 0 && p.validity == 1 && p.depth > 2 && p.depth < 2 * sqrt(3), "closed: no ray escapes, depth %.3f", (double)p.depth);
        }
        ok(worst < 4.5, "furnace with %d bounces: Le (1 - rho^(n+1)) / (1 - rho) everywhere (z = %.2f)", bounces, worst);
        bench_clear(&b);
    }
}

/* A square lamp overhead, against cubature of its own and Lambert's formula. */
static void test_lamp(bool front_only, bool facing_down)
{
    for (int size = 0; size < 3; size++) {
        const double half = size == 0 ? 2 : size == 1 ? 0.3 : 0.01, h = 1.5;
        struct bench b;
        bench_start(&b);
        b.settings.emit_front_only = front_only;
        const double s = facing_down ? 1 : -1; /* turns the order of the corners round */
        const double corner[12] = {-half, h, -half * s, half, h, -half * s, half, h, half * s, -half, h, half * s};
        add_quad(&b, corner, material(0, 3));
        bench_finish(&b, 4);
        struct capture_settings settings = capture_settings_default();
        settings.rays = 1000;
        double truth[27] = {0}, lambert = 0;
        enum { STEPS = 200 };
        const bool lit = facing_down || !front_only;
        for (int i = 0; i < STEPS * STEPS && lit; i++) {
            const double x = half * (2 * (i % STEPS + 0.5) / STEPS - 1) - 0.4, z = half * (2 * (i / STEPS + 0.5) / STEPS - 1) - 0.1;
            const double r = sqrt(x * x + h * h + z * z), d[3] = {x / r, h / r, z / r};
            const double solid = (2 * half / STEPS) * (2 * half / STEPS) * h / (r * r * r);
            add_truth(truth, 3, d, 3, 6, 1.5, solid);
            lambert += 3 * solid * d[1];
        }
        double worst = 0, mean = 0, variance = 0;
        for (int i = 0; i < 8; i++) {
            settings.seed = (uint64_t)i;
            const struct capture_probe p = capture(&b, &settings, 0.4, 0, 0.1);
            double rgb[3];
            worst = fmax(worst, worst_z(&p, 3, truth));
            sh_irradiance(3, p.sh, 0, (const double[3]){0, 1, 0}, rgb);
            mean += rgb[0] / 8;
            variance += (double)p.sh_error[0] * (double)p.sh_error[0];
        }
        ok(worst < 4.5, "lamp of half side %g%s%s: SH as by cubature (z = %.2f)", half, front_only ? ", front" : "",
           facing_down ? ", facing" : ", turned away", worst);
        /* The cosine lobe of order 3 misses bands 4 and up: A_4 / A_0 = 1/24, so a few percent of a narrow lamp. */
        ok(!lit ? mean == 0 : fabs(mean - lambert) < 0.07 * lambert + 5 * sqrt(variance), "its irradiance is near Lambert's %.4f: %.4f", lambert, mean);
        bench_clear(&b);
    }
}

/* Punctual lights over a wide floor: the delta itself, and one bounce by cubature over the floor. */
static void test_punctual(void)
{
    for (int kind = 0; kind < 3; kind++) {
        struct bench b;
        bench_start(&b);
        const double f = 1000;
        add_quad(&b, (const double[12]){-f, 0, -f, -f, 0, f, f, 0, f, f, 0, -f}, material(0.5f, 0));
        struct scene_light light = {.kind = (enum scene_light_kind)kind, .position = {1, 3, 0}, .direction = {0.6, -0.8, 0},
                                    .intensity = {7, 5, 3}, .cos_inner = 0.9, .cos_outer = 0.6};
        b.settings.lights = malloc(sizeof light);
        b.settings.lights[0] = light;
        b.settings.light_count = b.settings.light_capacity = 1;
        bench_finish(&b, 1);
        struct capture_settings s = capture_settings_default();
        s.rays = 4000;
        const double at[3] = {0, 1, 0.5};
        double truth[27] = {0}, direct[27] = {0}, d[3], distance, rgb[3];
        scene_light_at(&b.scene->lights[0], at, d, &distance, rgb);
        add_truth(direct, 3, d, rgb[0], rgb[1], rgb[2], 1);
        enum { NZ = 400, NPHI = 800 }; /* directions below the horizon, where rays meet the floor */
        for (int i = 0; i < NZ; i++) {
            for (int j = 0; j < NPHI; j++) {
                const double y = -(i + 0.5) / NZ, r = sqrt(1 - y * y), phi = 2 * PI * (j + 0.5) / NPHI;
                const double dir[3] = {r * cos(phi), y, r * sin(phi)}, t = at[1] / -y;
                const double floor_point[3] = {at[0] + t * dir[0], 0, at[2] + t * dir[2]};
                double to[3], far, e[3];
                if (fabs(floor_point[0]) > f || fabs(floor_point[2]) > f)
                    continue;
                scene_light_at(&b.scene->lights[0], floor_point, to, &far, e);
                const double cosine = fmax(to[1], 0) / PI;
                add_truth(truth, 3, dir, 0.5 * e[0] * cosine, 0.25 * e[1] * cosine, 0.125 * e[2] * cosine, 2 * PI / (NZ * NPHI));
            }
        }
        const char *name = kind == SCENE_POINT ? "point" : kind == SCENE_SPOT ? "spot" : "sun";
        s.light = CAPTURE_DIRECT;
        const struct capture_probe p = capture(&b, &s, at[0], at[1], at[2]);
        ok(worst_z(&p, 3, direct) < 1, "%s light reaches the probe as a delta", name);
        s.light = CAPTURE_INDIRECT;
        const struct capture_probe q = capture(&b, &s, at[0], at[1], at[2]);
        ok(worst_z(&q, 3, truth) < 4.5, "%s light over a floor: one bounce as by cubature (z = %.2f)", name, worst_z(&q, 3, truth));
        s.light = CAPTURE_ALL;
        const struct capture_probe all = capture(&b, &s, at[0], at[1], at[2]);
        double worst = 0;
        for (int i = 0; i < 27; i++)
            worst = fmax(worst, fabs((double)all.sh[i] - (double)p.sh[i] - (double)q.sh[i]));
        ok(worst < 1e-5, "%s light: direct + indirect = all (%.1e)", name, worst);
        bench_clear(&b);
    }
}

/* A cube with a lamp on one wall, scaled and moved; the light must not change. */
static struct capture_probe capture_room(double scale, double offset, double emission, int order, uint64_t seed)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2 * scale, material(0.7f, 0));
    const double h = scale;
    add_quad(&b, (const double[12]){-h, 1.9 * scale, -h, h, 1.9 * scale, -h, h, 1.9 * scale, h, -h, 1.9 * scale, h}, material(0.2f, (float)emission));
    for (size_t m = 0; m < b.scene->mesh_count; m++)
        for (size_t i = 0; i < 3 * b.scene->meshes[m].vertex_count; i++)
            b.scene->meshes[m].position[i] += offset;
    bench_finish(&b, 16);
    struct capture_settings s = capture_settings_default();
    s.rays = 1000;
    s.order = order;
    s.seed = seed;
    const struct capture_probe p = capture(&b, &s, 0.5 * scale + offset, -0.3 * scale + offset, 0.2 * scale + offset);
    bench_clear(&b);
    return p;
}

static double difference_z(const struct capture_probe *a, const struct capture_probe *b, double factor)
{
    double worst = 0;
    for (int i = 0; i < 27; i++) {
        const double ea = factor * (double)a->sh_error[i], eb = (double)b->sh_error[i];
        worst = fmax(worst, fabs(factor * (double)a->sh[i] - (double)b->sh[i]) / sqrt(ea * ea + eb * eb));
    }
    return worst;
}

static void test_scale(void)
{
    const struct capture_probe here = capture_room(1, 0, 4, 3, 0);
    static const double scales[] = {1e-6, 1e-3, 1e3, 1e6};
    for (int i = 0; i < 4; i++) {
        const struct capture_probe p = capture_room(scales[i], 0, 4, 3, 1);
        ok(difference_z(&here, &p, 1) < 4.5 && fabs((double)p.depth / (scales[i] * (double)here.depth) - 1) < 0.05,
           "the room at scale %g has the same light (z = %.2f)", scales[i], difference_z(&here, &p, 1));
    }
    const struct capture_probe moved = capture_room(1, 4e6, 4, 3, 2), bright = capture_room(1, 0, 4e8, 3, 3);
    ok(difference_z(&here, &moved, 1) < 4.5, "so has the room moved by a million times its size (z = %.2f)", difference_z(&here, &moved, 1));
    ok(difference_z(&here, &bright, 1e8) < 4.5, "light is linear in the lamp, over 1e8 (z = %.2f)", difference_z(&here, &bright, 1e8));
    const struct capture_probe again = capture_room(1, 0, 4, 3, 0), high = capture_room(1, 0, 4, 6, 0);
    ok(!memcmp(here.sh, again.sh, sizeof(float[27])), "the same seed gives the same bytes");
    ok(!memcmp(here.sh, high.sh, sizeof(float[27])), "order 3 is the beginning of order 6");
}

/* The share of coefficients whose truth lies within 1.96 standard errors. */
static void test_coverage(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.7f, 0));
    add_quad(&b, (const double[12]){-1, 1.9, -1, 1, 1.9, -1, 1, 1.9, 1, -1, 1.9, 1}, material(0.2f, 4));
    bench_finish(&b, 4);
    enum { PROBES = 60, SEEDS = 12 };
    struct capture_settings s = capture_settings_default();
    size_t within = 0, all = 0;
    struct random r = random_start(7, 0, 0);
    for (int i = 0; i < PROBES; i++) {
        const double p[3] = {3 * random_double(&r) - 1.5, 3 * random_double(&r) - 1.5, 3 * random_double(&r) - 1.5};
        s.rays = 20000;
        s.seed = 1000;
        const struct capture_probe truth = capture(&b, &s, p[0], p[1], p[2]);
        s.rays = 200;
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            s.seed = seed;
            const struct capture_probe one = capture(&b, &s, p[0], p[1], p[2]);
            for (int k = 0; k < 27; k++, all++) {
                const double e = (double)one.sh_error[k], t = (double)truth.sh_error[k];
                within += fabs((double)one.sh[k] - (double)truth.sh[k]) < 1.96 * sqrt(e * e + t * t);
            }
        }
    }
    /* Colours and coefficients of one capture are correlated: as if there were PROBES * SEEDS independent ones, 95 % is met within
     * 4 * sqrt(.95 * .05 / 720) = 3.2 %. */
    const double share = (double)within / (double)all;
    ok(share > 0.918 && share < 0.982, "the truth lies within 1.96 sh_error in %.1f %% of %zu cases", 100 * share, all);
    bench_clear(&b);
}

/* A wall that is blended, or a cut-out of known mean: light passes in proportion. */
static void test_alpha(void)
{
    for (int blend = 0; blend < 2; blend++) {
        struct bench b;
        bench_start(&b);
        b.settings.sky[0] = b.settings.sky[1] = b.settings.sky[2] = 1;
        struct scene_material m = material(0, 0);
        m.alpha = blend ? SCENE_BLEND : SCENE_CUTOUT;
        m.opacity = blend ? 0.25f : 0.4f; /* below the cut-off: a hole all over */
        add_cube(&b, 1, m);
        bench_finish(&b, 4);
        struct capture_settings s = capture_settings_default();
        s.rays = 4000;
        const struct capture_probe p = capture(&b, &s, 0.1, 0.2, 0.3);
        double truth[27] = {0};
        truth[0] = truth[1] = truth[2] = (blend ? 0.75 : 1) * sqrt(4 * PI);
        ok(worst_z(&p, 3, truth) < 4.5, "%s (z = %.2f)", blend ? "a wall of opacity 0.25 lets 3/4 of the sky through" : "a cut-out below its cut-off is not there",
           worst_z(&p, 3, truth));
        const double inside[3] = {0, 0, 0}, outside[3] = {5, 0.1, 0.2};
        ok(fabsf(trace_visibility(b.tracer, inside, outside) - (blend ? 0.75f : 1)) < 1e-6f, "and visibility says so");
        bench_clear(&b);
    }
}

/* One mesh placed twice gives what two meshes give; a mirrored one keeps its front. */
static void test_instances(void)
{
    struct capture_probe p[2];
    for (int flat = 0; flat < 2; flat++) {
        struct bench b;
        bench_start(&b);
        b.settings.emit_front_only = true;
        add_quad(&b, (const double[12]){-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1}, material(0, 1));
        if (flat) {
            add_quad(&b, (const double[12]){1, -2, -1, -1, -2, -1, -1, -2, 1, 1, -2, 1}, material(0, 1));
        } else {
            struct scene_instance *grown = realloc(b.scene->instances, 2 * sizeof *grown);
            b.scene->instances = grown;
            grown[1] = grown[0];
            grown[1].transform[0] = -1; /* mirrored twice: turned by 180 degrees about z */
            grown[1].transform[5] = -1;
            b.scene->instance_count = b.scene->instance_capacity = 2;
        }
        bench_finish(&b, 2);
        struct capture_settings s = capture_settings_default();
        s.seed = (uint64_t)flat;
        p[flat] = capture(&b, &s, 0.2, 0.1, 0);
        bench_clear(&b);
    }
    ok(difference_z(&p[0], &p[1], 1) < 4.5, "a mesh placed twice lights as two meshes do (z = %.2f)", difference_z(&p[0], &p[1], 1));
    ok(p[0].sh[0] > 0.3f, "and it shines");
}

static void test_header(void)
{
    struct capture_settings s = {.order = 5, .rays = 77, .bounces = 3, .light = CAPTURE_INDIRECT, .seed = (uint64_t)1 << 52}, back = capture_settings_default();
    struct stream_header h = {0};
    must(capture_settings_to_header(&s, &h));
    must(capture_settings_from_header(&back, &h));
    ok(back.order == 5 && back.rays == 77 && back.bounces == 3 && back.light == CAPTURE_INDIRECT && back.seed == s.seed, "settings come back from a header");
    must(header_set_key(&h, "capture-rays", "many"));
    struct error *err = capture_settings_from_header(&back, &h);
    ok(err && strstr(error_message(err), "capture-rays"), "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    header_clear(&h);
}

int main(void)
{
    test_sky();
    test_furnace();
    test_lamp(false, true);
    test_lamp(true, true);
    test_lamp(true, false);
    test_punctual();
    test_scale();
    test_alpha();
    test_instances();
    test_coverage();
    test_header();
    return tap_done();
}
