/* SPDX-License-Identifier: Apache-2.0 */
/* What probe-error measures is what there is: against light whose error, leaks and change are known
 * in closed form. Checks of chance are held within 4.5 standard errors (7e-6 by luck) unless they
 * say otherwise; seeds are fixed. */
#include "import/import_scene.h"
#include "interpolate/baked.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "math/affine.h"
#include "math/random.h"
#include "measure/bootstrap.h"
#include "measure/measure.h"
#include "measure/report.h"
#include "measure/ruler.h"
#include "measure/ruler.h"
#include "measure/sphere.h"
#include "measure/truth.h"
#include "measure/unseen.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"
#include "support/capture_truth.h"
#include "trace/seen.h"

#include <string.h>

/* Irradiance, in the mean over directions, of the coefficient L00 = 1. */
static double unit_light(void)
{
    return PI * sqrt(1 / (4 * PI));
}

/* A standard normal number (Box and Muller). */
static double normal_number(struct random *r)
{
    const double u = 1 - random_double(r), v = random_double(r);
    return sqrt(-2 * log(u)) * cos(2 * PI * v);
}

/* -- directions -------------------------------------------------------------------------------- */

static double odd_factorial(int n) /* n!! of odd n; 1 for -1 */
{
    return n <= 1 ? 1 : n * odd_factorial(n - 2);
}

static void test_sphere(void)
{
    double worst = 0, beyond = 0, weight = 0, length = 0;
    for (int d = 0; d < SPHERE_COUNT; d++) {
        weight += sphere_weight[d];
        length = fmax(length, fabs(vec3_length(vec3_load(sphere_direction[d])) - 1));
    }
    for (int a = 0; a <= 10; a++) {
        for (int b = 0; a + b <= 10; b++) {
            for (int c = 0; a + b + c <= 10; c++) {
                double value[SPHERE_COUNT];
                for (int d = 0; d < SPHERE_COUNT; d++)
                    value[d] = pow(sphere_direction[d][0], a) * pow(sphere_direction[d][1], b) *
                               pow(sphere_direction[d][2], c);
                const bool odd = a % 2 || b % 2 || c % 2;
                const double mean = odd ? 0
                                        : odd_factorial(a - 1) * odd_factorial(b - 1) *
                                              odd_factorial(c - 1) / odd_factorial(a + b + c + 1);
                double *most = a + b + c <= 9 ? &worst : &beyond;
                *most = fmax(*most, fabs(sphere_mean(value) - mean));
            }
        }
    }
    ok(fabs(weight - 1) < 1e-15 && length < 1e-15, "32 directions of length 1, weights sum to 1");
    ok(worst < 1e-15 && beyond > 1e-5,
       "the mean of x^a y^b z^c is exact up to degree 9 (%.1g), and not beyond (%.1g)", worst,
       beyond);
    /* Irradiance of each basis function along the set is sh_irradiance's. */
    double off = 0;
    for (int convolved = 0; convolved < 2; convolved++) {
        const struct sphere_basis basis = sphere_basis_make(6, convolved);
        struct random r = random_start(1, 0, 0);
        double c[3 * SH_COUNT_MAX], e[3 * SPHERE_COUNT], rgb[3];
        float f[3 * SH_COUNT_MAX];
        for (int i = 0; i < 3 * SH_COUNT_MAX; i++)
            c[i] = (double)(f[i] = random_float(&r));
        sphere_irradiance(&basis, c, 3, e);
        for (int d = 0; d < SPHERE_COUNT; d++) {
            sh_irradiance(6, f, convolved, sphere_direction[d], rgb);
            for (int k = 0; k < 3; k++)
                off = fmax(off, fabs(rgb[k] - e[3 * d + k]));
        }
    }
    ok(off < 1e-12, "irradiance along them is sh_irradiance's (%.1g)", off);
}

/* -- irradiance of several normals from one probe --------------------------------------------- */

static struct capture_settings normals_settings(int rays)
{
    struct capture_settings s = capture_settings_default();
    s.normal = sphere_direction[0];
    s.normal_count = SPHERE_COUNT;
    s.rays = rays;
    return s;
}

static void test_normals(void)
{
    struct bench b;
    bench_start(&b);
    b.settings.sky[0] = 0.5, b.settings.sky[1] = 1, b.settings.sky[2] = 2;
    add_light(&b, (struct scene_light){
                      .kind = SCENE_SUN, .direction = {0.6, -0.8, 0}, .intensity = {10, 20, 30}});
    bench_finish(&b, 4);
    struct capture_settings s = normals_settings(4096);
    struct capture_probe p = capture(&b, &s, 1, 2, 3);
    double worst = 0, coarse = 0;
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double cosine = fmax(-0.6 * sphere_direction[d][0] + 0.8 * sphere_direction[d][1], 0);
        for (int k = 0; k < 3; k++) {
            const double e = PI * b.settings.sky[k] + cosine * 10 * (k + 1);
            worst = fmax(worst, fabs((double)p.sh[3 * d + k] - e) /
                                    ((double)p.sh_error[3 * d + k] + 1e-6 * e));
            coarse = fmax(coarse, (double)p.sh_error[3 * d + k] / e);
        }
    }
    ok(worst < 4.5 && coarse < 0.01,
       "sky and sun: irradiance in 32 directions, no band of it cut off (z = %.2f, noise at most "
       "%.2g)",
       worst, coarse);
    s.error = 0.001;
    s.rays = 64;
    s.rays_most = 1 << 20;
    p = capture(&b, &s, 1, 2, 3);
    double noise = 0, mean = 0;
    for (int d = 0; d < SPHERE_COUNT; d++) {
        mean += (double)p.sh[3 * d + 1] / SPHERE_COUNT;
        noise += (double)p.sh_error[3 * d + 1] * (double)p.sh_error[3 * d + 1] / SPHERE_COUNT;
    }
    ok(sqrt(noise) < 0.0015 * mean && p.rays > 64 && p.rays < 1 << 20,
       "an error of 0.1 %% is met with %d rays: %.2g", p.rays, sqrt(noise) / mean);
    bench_clear(&b);

    /* A lamp, in a room with bounces: each direction as the surface's capture has it, which draws
     * its rays otherwise. */
    bench_start(&b);
    add_cube(&b, 2, material(0.6f, 0));
    add_floor(&b, 0.5, 1.5, material(0.2f, 4));
    bench_finish(&b, 16);
    s = normals_settings(20000);
    p = capture(&b, &s, 0.3, -0.4, 0.2);
    struct capture_settings surface = capture_settings_default();
    surface.rays = 5000;
    worst = coarse = 0;
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const float normal[3] = {(float)sphere_direction[d][0], (float)sphere_direction[d][1],
                                 (float)sphere_direction[d][2]};
        struct capture_probe q;
        must(capture_probe(&b.path, &surface, (const double[3]){0.3, -0.4, 0.2}, normal, &q));
        for (int k = 0; k < 3; k++) {
            const double a = (double)p.sh_error[3 * d + k], c = (double)q.sh_error[k];
            worst =
                fmax(worst, fabs((double)p.sh[3 * d + k] - (double)q.sh[k]) / sqrt(a * a + c * c));
            coarse = fmax(coarse, sqrt(a * a + c * c) / (double)q.sh[k]);
        }
    }
    ok(worst < 4.5 && coarse < 0.1,
       "a lamp-lit room: as 32 surfaces have it (z = %.2f, known to %.2g)", worst, coarse);
    bench_clear(&b);
}

/* -- distance to surfaces --------------------------------------------------------------------- */

/* By the projection onto the triangle's plane and edges, refined by search: slow and sure. */
static double distance_by_search(struct vec3 p, struct vec3 a, struct vec3 b, struct vec3 c)
{
    double best = INFINITY, u0 = 0, v0 = 0, size = 1;
    for (int level = 0; level < 40; level++, size *= 0.6) {
        double u1 = u0, v1 = v0;
        for (int i = -4; i <= 4; i++) {
            for (int j = -4; j <= 4; j++) {
                const double u = fmin(fmax(u0 + i * size / 4, 0), 1),
                             v = fmin(fmax(v0 + j * size / 4, 0), 1 - u);
                const struct vec3 q = vec3_fma(vec3_fma(a, u, vec3_sub(b, a)), v, vec3_sub(c, a));
                const double d = vec3_length(vec3_sub(p, q));
                if (d < best) {
                    best = d;
                    u1 = u;
                    v1 = v;
                }
            }
        }
        u0 = u1;
        v0 = v1;
    }
    return best;
}

static struct vec3 placed_corner(const struct scene *scene, size_t instance, size_t triangle,
                                 size_t corner)
{
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    return affine_point(scene->instances[instance].transform,
                        mesh->position + 3 * (size_t)mesh->index[3 * triangle + corner]);
}

static void test_distance(void)
{
    char path[1024];
    struct scene_settings settings = scene_settings_default();
    struct scene *scene = NULL;
    struct tracer *tracer = NULL;
    const char *source = getenv("SRC");
    snprintf(path, sizeof path, "%s/scenes/coloured-walls.gltf", source ? source : ".");
    must(scene_read(&scene, path, &settings, false, NULL));
    must(trace_create(&tracer, scene));
    struct random r = random_start(3, 0, 0);
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    double worst = 0;
    size_t nearest[64] = {0};
    for (int i = 0; i < 80; i++) {
        struct vec3 p = scene->box_min;
        p = vec3_add(p, (struct vec3){(1.4 * random_double(&r) - 0.2) * size.x,
                                      (1.4 * random_double(&r) - 0.2) * size.y,
                                      (1.4 * random_double(&r) - 0.2) * size.z});
        double at[3], best = INFINITY;
        size_t which = 0;
        vec3_store(at, p);
        for (size_t n = 0; n < scene->instance_count; n++) {
            for (size_t t = 0; t < scene->meshes[scene->instances[n].mesh].triangle_count; t++) {
                const double d = distance_by_search(p, placed_corner(scene, n, t, 0),
                                                    placed_corner(scene, n, t, 1),
                                                    placed_corner(scene, n, t, 2));
                which = d < best ? n : which;
                best = fmin(best, d);
            }
        }
        nearest[which % 64]++;
        worst = fmax(worst, fabs(trace_distance(tracer, at) - best) / vec3_length(size));
    }
    size_t met = 0;
    for (int i = 0; i < 64; i++)
        met += nearest[i] > 0;
    ok(worst < 1e-6 && met >= 4,
       "distance to the nearest surface, of %zu meshes and instances, is that of a search (%.1g)",
       met, worst);
    trace_destroy(tracer);
    scene_destroy(scene);
    struct bench b;
    bench_start(&b);
    bench_finish(&b, 1);
    ok(isinf(trace_distance(b.tracer, (const double[3]){1, 2, 3})),
       "and infinite where there is none");
    bench_clear(&b);
}

/* -- a stream and a truth by hand ------------------------------------------------------------- */

/* One cell with the corners 0, x, y, z; each probe has the light L00 = value, white. */
struct hand {
    struct stream *stream;
    struct baked baked;
};

static void hand_start(struct hand *h, const double corner[12], const double value[4])
{
    struct table *probes, *cells;
    struct column *c;
    must(stream_create(&h->stream));
    must(stream_add_table(h->stream, "probe", &probes));
    must(table_resize(probes, 4));
    must(table_add_column(probes, "position", COLUMN_F64, 3, &c));
    memcpy(c->data, corner, 12 * sizeof *corner);
    must(table_add_column(probes, "sh", COLUMN_F32, 27, &c));
    memset(c->data, 0, 4 * 27 * sizeof(float));
    for (size_t i = 0; i < 4; i++)
        for (size_t k = 0; k < 3; k++)
            column_f32(c)[27 * i + k] = (float)value[i];
    must(stream_add_table(h->stream, "tet", &cells));
    must(table_resize(cells, 1));
    must(table_add_column(cells, "vertex", COLUMN_I32, 4, &c));
    for (int i = 0; i < 4; i++)
        column_i32(c)[i] = i;
    must(table_add_column(cells, "neighbour", COLUMN_I32, 4, &c));
    must(baked_open(&h->baked, h->stream, NULL));
}

static void hand_end(struct hand *h)
{
    baked_close(&h->baked);
    stream_destroy(h->stream);
}

static const double unit_cell[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};

/* A truth at `points` points evenly spread over the unit cell: the same light in all directions,
 * `light` times unit_light() of L00 = light(p), with Gaussian noise in each half, alike in all
 * directions. */
struct hand_truth {
    struct truth truth;
    double *position;
    int32_t *path;
    float *surface, *half[2];
};

typedef double light_field(const double p[3]);

static void hand_truth_start(struct hand_truth *h, size_t points, light_field *field, double noise,
                             uint64_t seed)
{
    struct random r = random_start(seed, 99, 0);
    must(array_create(&h->position, 3 * points, sizeof(double)));
    must(array_create(&h->path, points, sizeof(int32_t)));
    must(array_create(&h->surface, points, sizeof(float)));
    must(array_create(&h->half[0], TRUTH_WIDTH * points, sizeof(float)));
    must(array_create(&h->half[1], TRUTH_WIDTH * points, sizeof(float)));
    for (size_t i = 0; i < points; i++) {
        double *p = h->position + 3 * i;
        do
            for (int k = 0; k < 3; k++)
                p[k] = random_double(&r);
        while (p[0] + p[1] + p[2] >= 1);
        h->path[i] = -1;
        h->surface[i] = (float)p[0];
        for (int half = 0; half < 2; half++) {
            const double e = unit_light() * field(p) + noise * normal_number(&r);
            for (size_t k = 0; k < TRUTH_WIDTH; k++)
                h->half[half][TRUTH_WIDTH * i + k] = (float)e;
        }
    }
    h->truth = (struct truth){.count = points,
                              .points = points,
                              .position = h->position,
                              .path = h->path,
                              .surface = h->surface,
                              .half = {h->half[0], h->half[1]}};
}

static void hand_truth_end(struct hand_truth *h)
{
    free(h->position);
    free(h->path);
    free(h->surface);
    free(h->half[0]);
    free(h->half[1]);
}

/* The scene without anything in it, for those who ask what is seen. */
static struct bench nothing;

static struct report measured(const struct hand *h, const struct truth *t)
{
    const struct measure_settings s = {
        .tolerance = 0.05, .dark = 0.25, .bad = 0.25, .seed = 5, .threads = 2};
    struct report report = {0};
    must(measure_error(&report, t, &h->baked, nothing.tracer, &s, NULL));
    return report;
}

static double got(const struct report *r, const char *measure, const char *of)
{
    return report_get(r, measure, of).value;
}

static double linear(const double p[3])
{
    return 2 + p[0] - 0.5 * p[1] + 3 * p[2];
}

static double three(const double p[3])
{
    (void)p;
    return 3;
}

static const double linear_probes[4] = {2, 3, 1.5, 5};

static void test_linear(void)
{
    struct hand h;
    struct hand_truth t;
    hand_start(&h, unit_cell, linear_probes);
    hand_truth_start(&t, 2000, linear, 0, 1);
    struct report r = measured(&h, &t.truth);
    ok(got(&r, "rms_relative", "all") < 1e-6 && got(&r, "worst_relative", "all") < 2e-6,
       "a linear field: no error (%.1g)", got(&r, "rms_relative", "all"));
    ok(fabs(got(&r, "irradiance", "all") / (unit_light() * (2 + 3.5 / 4)) - 1) < 0.02,
       "and its mean is that of the cell's corners");
    report_clear(&r);
    hand_end(&h);

    const double offset[4] = {2.25, 3.25, 1.75, 5.25};
    hand_start(&h, unit_cell, offset);
    r = measured(&h, &t.truth);
    const double c = 0.25 * unit_light();
    const char *const same[] = {"rms", "rms_colour", "bias", "mean", "p95", "p99", "worst"};
    double off = 0;
    for (int i = 0; i < 7; i++)
        off = fmax(off, fabs(got(&r, same[i], "all") / c - 1));
    ok(off < 1e-5, "a constant offset is each figure of error (%.1g)", off);
    ok(fabs(got(&r, "too_bright", "all") - 1) < 1e-9 && got(&r, "too_dark", "all") == 0,
       "and too bright everywhere");
    const struct estimate e = report_get(&r, "rms", "all");
    ok(e.high - e.low < 1e-5 * e.value, "with no doubt about it");
    report_clear(&r);
    hand_end(&h);
    hand_truth_end(&t);
}

/* -- ways to interpolate ---------------------------------------------------------------------- */

/* The value that a way gives a point, of linear_probes at the corners of the unit cell, by its
 * formula. */
static double by_formula(const struct interpolate_kind *kind, double radius, const double p[3])
{
    double sum = 0, light = 0, nearest = INFINITY, of_nearest = 0;
    for (int i = 0; i < 4; i++) {
        const double d = vec3_length(vec3_sub(vec3_load(p), vec3_load(unit_cell + 3 * i))),
                     w = fmax(1 - d / radius, 0);
        sum += w * w;
        light += w * w * linear_probes[i];
        of_nearest = d < nearest ? linear_probes[i] : of_nearest;
        nearest = fmin(nearest, d);
    }
    return kind == &interpolate_shepard ? light / sum : of_nearest;
}

static void test_kinds(void)
{
    static const struct interpolate_kind *const kinds[] = {
        &interpolate_barycentric, &interpolate_gradient, &interpolate_cubic, &interpolate_nearest,
        &interpolate_shepard};
    static const double slope[3] = {1, -0.5, 3};
    enum { N = 2000 };
    struct hand h;
    struct hand_truth t;
    struct column *gradient;
    hand_start(&h, unit_cell, linear_probes);
    baked_close(&h.baked);
    must(table_add_column(stream_table(h.stream, "probe"), "sh_gradient", COLUMN_F32, 81,
                          &gradient));
    for (size_t i = 0; i < 4 * 81; i++)
        column_f32(gradient)[i] = i % 27 < 3 ? (float)slope[i % 81 / 27] : 0;
    hand_truth_start(&t, N, linear, 0, 6);
    for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++) {
        const struct interpolate_kind *kind = kinds[n];
        const struct interpolate_settings how = {
            .kind = kind, .falloff = INTERPOLATE_FALL_QUADRATIC, .radius = 1.5};
        must(baked_open(&h.baked, h.stream, &how));
        struct report r = measured(&h, &t.truth);
        if (kind->needs_cells) {
            ok(got(&r, "rms_relative", "all") < 1e-6, "%s: no error in a linear field (%.1g)",
               kind->name, got(&r, "rms_relative", "all"));
        } else {
            double square = 0;
            for (size_t i = 0; i < N; i++)
                square += pow(by_formula(how.kind, how.radius, t.position + 3 * i) -
                                  linear(t.position + 3 * i),
                              2) /
                          N;
            const double rms = unit_light() * sqrt(square);
            ok(rms > 0.1 && fabs(got(&r, "rms", "all") / rms - 1) < 1e-5,
               "%s: the error in a linear field is that of its formula, %.4f", kind->name, rms);
        }
        ok(got(&r, "points", "inside-hull") == N && got(&r, "points", "all-seen") == N,
           "%s: hull and sight are those of the cells", kind->name);
        report_clear(&r);
        baked_close(&h.baked);
    }
    hand_truth_end(&t);
    hand_end(&h);
}

/* A stream of probes with light, and cells where `table` is not NULL. */
static struct stream *stream_of(size_t count, const double *position, light_field *field,
                                const char *table)
{
    struct stream *s;
    struct table *probes, *cells;
    struct column *c;
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &probes));
    must(table_resize(probes, count));
    must(table_add_column(probes, "position", COLUMN_F64, 3, &c));
    memcpy(c->data, position, 3 * count * sizeof *position);
    must(table_add_column(probes, "sh", COLUMN_F32, 3, &c));
    for (size_t i = 0; i < 3 * count; i++)
        column_f32(c)[i] = (float)field(position + i / 3 * 3);
    if (!table)
        return s;
    must(stream_add_table(s, table, &cells));
    must(table_resize(cells, 1));
    must(table_add_column(cells, "vertex", COLUMN_I32, count, &c));
    for (size_t i = 0; i < count; i++)
        column_i32(c)[i] = (int32_t)i;
    must(table_add_column(cells, "neighbour", COLUMN_I32, count, NULL));
    return s;
}

static void test_grid(void)
{
    static const double corner[24] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                      0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    struct hand h = {.stream = stream_of(8, corner, linear, NULL)};
    struct hand_truth t;
    hand_truth_start(&t, 500, linear, 0, 7);
    must(baked_open(&h.baked, h.stream,
                    &(struct interpolate_settings){.kind = &interpolate_trilinear}));
    struct report r = measured(&h, &t.truth);
    ok(got(&r, "rms_relative", "all") < 1e-6 && got(&r, "points", "inside-hull") == 500,
       "trilinear, without cells: no error in a linear field (%.1g)",
       got(&r, "rms_relative", "all"));
    ok(isnan(got(&r, "unseen", "all")) && isnan(got(&r, "points", "all-seen")) &&
           isnan(got(&r, "capture_noise", "all")),
       "what takes cells to know is not reported");
    report_clear(&r);
    hand_truth_end(&t);
    hand_end(&h);
}

static double planar(const double p[3])
{
    return 2 + p[0] - 0.5 * p[1];
}

static double collinear(const double p[3])
{
    return 2 + p[0];
}

/* With so many points a cell. */
static struct error *unseen_of_cells(struct unseen_cells *cells, const struct tracer *tracer,
                                     const struct baked *baked, int least)
{
    const struct unseen_settings settings = {.least = least, .seed = 1, .threads = 2};
    return unseen_cells(cells, tracer, baked, &settings);
}

static void test_flat(int corners)
{
    static const char *const tables[] = {NULL, "point", "segment", "tri"};
    /* alike along what the probes do not span */
    light_field *const fields[] = {NULL, three, collinear, planar};
    struct hand h = {
        .stream = stream_of((size_t)corners, unit_cell, fields[corners], tables[corners])};
    struct hand_truth t;
    struct unseen_cells cells;
    hand_truth_start(&t, 500, fields[corners], 0, 8);
    must(baked_open(&h.baked, h.stream, NULL));
    struct report r = measured(&h, &t.truth);
    ok(got(&r, "rms_relative", "all") < 1e-6, "%s: no error in a field that it spans (%.1g)",
       tables[corners], got(&r, "rms_relative", "all"));
    report_clear(&r);
    hand_truth_end(&t);
    hand_truth_start(&t, 500, linear, 0, 8);
    r = measured(&h, &t.truth);
    ok(got(&r, "rms", "all") > 0.1 && got(&r, "unseen", "all") == 0,
       "%s: and one in a field that it does not; its probes are seen", tables[corners]);
    report_clear(&r);
    hand_truth_end(&t);
    struct error *err = unseen_of_cells(&cells, nothing.tracer, &h.baked, 8);
    if (corners == 1)
        ok(err && strstr(error_message(err), "the cell is a point"), "point: it has no space");
    else
        ok(!err && cells.now.weight.value == 0 && cells.now.weight.high == 0 &&
               cells.free_volume > 0 && cells.near == 0,
           "%s: where there are no surfaces, nothing leaks, for certain", tables[corners]);
    error_destroy(err);
    unseen_cells_clear(&cells);
    hand_end(&h);
}

/* One of the probes is off by 1: over a cell the mean of its weight is 1/4, of the weight's square
 * 1/10 (the moments of a uniform point's barycentric coordinates, Dirichlet(1,1,1,1)); P(weight >
 * x) = (1 - x)^3. */
static void test_wrong_probe(void)
{
    enum { N = SANITIZED ? 5000 : 20000 };
    struct hand h;
    struct hand_truth t;
    const double wrong[4] = {3, 3, 4, 3};
    hand_start(&h, unit_cell, wrong);
    hand_truth_start(&t, N, three, 0, 2);
    struct report r = measured(&h, &t.truth);
    const double unit = unit_light();
    /* Standard errors from the moments E w^2 = 1/10, E w^4 = 1/35, and of a quantile sqrt(q (1 - q)
     * / N) / density. */
    const double mean_error = sqrt((0.1 - 0.0625) / N),
                 rms_error = sqrt((1.0 / 35 - 0.01) / N) / (2 * sqrt(0.1));
    const double p95 = 1 - cbrt(0.05), p99 = 1 - cbrt(0.01);
    const double p95_error = sqrt(0.05 * 0.95 / N) / (3 * cbrt(0.05) * cbrt(0.05)),
                 p99_error = sqrt(0.01 * 0.99 / N) / (3 * cbrt(0.01) * cbrt(0.01));
    const double z[5] = {(got(&r, "rms", "all") / unit - sqrt(0.1)) / rms_error,
                         (got(&r, "bias", "all") / unit - 0.25) / mean_error,
                         (got(&r, "mean", "all") / unit - 0.25) / mean_error,
                         (got(&r, "p95", "all") / unit - p95) / p95_error,
                         (got(&r, "p99", "all") / unit - p99) / p99_error};
    for (int i = 0; i < 5; i++)
        ok(fabs(z[i]) < 4.5, "one wrong probe: %s as its weight has it (z = %.2f)",
           ((const char *[]){"rms", "bias", "mean", "95 %", "99 %"})[i], z[i]);
    /* weight > tolerance * 3, but for the light that the probe adds to the stream alone */
    const double share = pow(1 - 0.05 * 3, 3);
    ok(fabs(got(&r, "too_bright", "all") - share) < 4.5 * sqrt(share * (1 - share) / N),
       "and is too bright where that is more than the tolerance");
    ok(got(&r, "worst", "all") / unit > 0.9 && got(&r, "worst", "all") / unit < 1 &&
           got(&r, "worst_y", "all") > 0.9,
       "worst beside it");
    /* Quarters by `surface`, which is x here. */
    double points = 0, square = 0;
    for (int q = 1; q <= 4; q++) {
        char of[24];
        snprintf(of, sizeof of, "surface-%d", q);
        points += got(&r, "points", of);
        square += got(&r, "points", of) * pow(got(&r, "rms", of), 2);
        ok(fabs(got(&r, "points", of) - N / 4.0) <= 1, "quarter %d holds %.0f points", q,
           got(&r, "points", of));
    }
    ok(points == N && fabs(sqrt(square / N) / got(&r, "rms", "all") - 1) < 1e-9,
       "mean squares of the quarters add up to that of all");
    report_clear(&r);
    hand_end(&h);
    hand_truth_end(&t);
}

static double dim_corner(const double p[3])
{
    return p[0] < 0.2 ? 0.1 : 4;
}

static void test_parts(void)
{
    struct hand h;
    struct hand_truth t;
    const double lit[4] = {4, 4, 4, 4};
    hand_start(&h, unit_cell, lit);
    hand_truth_start(&t, 3000, dim_corner, 0, 3);
    size_t dim = 0;
    for (size_t i = 0; i < 3000; i++) {
        dim += t.position[3 * i] < 0.2;
        if (i % 3 == 0) /* out of the hull, beyond the slanted face */
            t.position[3 * i + 2] += 5;
    }
    struct report r = measured(&h, &t.truth);
    ok(got(&r, "points", "inside-hull") == 2000 && got(&r, "points", "outside-hull") == 1000,
       "points inside and outside of the hull are told apart");
    ok(got(&r, "points", "dark") == (double)dim && got(&r, "points", "lit") == 3000 - (double)dim,
       "lit and dark");
    ok(got(&r, "rms", "lit") < 1e-6 && fabs(got(&r, "rms", "dark") / unit_light() - 3.9) < 1e-4 &&
           fabs(got(&r, "too_bright", "dark") - 1) < 1e-9,
       "only the dark ones are off: by what they lack");
    ok(got(&r, "points", "all-seen") == 3000 && got(&r, "points", "some-unseen") == 0,
       "where nothing is, all is seen");
    report_clear(&r);
    hand_end(&h);
    hand_truth_end(&t);
}

/* Noise of the truth: the rms error does not move by more than it says. */
static void test_noise(void)
{
    enum { TRIALS = 200, POINTS = 150 };
    if (SANITIZED) {
        tap_skip("coverage of rms_noise: statistics of the plain build");
        return;
    }
    struct hand h;
    const double wrong[4] = {3, 3, 4, 3};
    hand_start(&h, unit_cell, wrong);
    for (int big = 0; big < 2; big++) {
        const double noise = big ? 1 : 0.1;
        double within = 0, bias = 0, spread = 0, said = 0;
        for (int i = 0; i < TRIALS; i++) {
            struct hand_truth t;
            hand_truth_start(&t, POINTS, three, noise, 1000 + (uint64_t)i);
            struct report r = measured(&h, &t.truth);
            double square = 0; /* of the weight of the wrong probe */
            for (size_t k = 0; k < POINTS; k++)
                square += t.position[3 * k + 1] * t.position[3 * k + 1] / POINTS;
            const double exact = unit_light() * sqrt(square), off = got(&r, "rms", "all") - exact,
                         error = got(&r, "rms_noise", "all");
            within += fabs(off) < 1.96 * error;
            bias += (pow(got(&r, "rms", "all"), 2) - pow(exact, 2)) / TRIALS;
            spread += off * off / TRIALS;
            said += error * error / TRIALS;
            report_clear(&r);
            hand_truth_end(&t);
        }
        /* A coverage of 95 %, within 4 sqrt(.05 * .95 / 200) = 6 %; where noise is far above the
         * error, roots of what is below 0 count as 0, and more is covered. */
        ok(within / TRIALS > 0.89 && (big || within / TRIALS < 0.995),
           "noise %.1f in light off by 0.3: the rms is within 1.96 rms_noise in %.1f %%", noise,
           100 * within / TRIALS);
        ok(sqrt(said / spread) > 0.8 && sqrt(said / spread) < (big ? 2 : 1.25),
           "rms_noise is its spread (%.2f of it)", sqrt(said / spread));
        ok(big || fabs(bias) < 4.5 * 2 * sqrt(0.1) * unit_light() * sqrt(spread / TRIALS),
           "and the mean square is not off in the mean (%.1g)", bias);
    }
    hand_end(&h);
}

/* -- the error that a player sees -------------------------------------------------------------- */

static double corner_is_dark(const double p[3])
{
    return p[0] > 1 - cbrt(0.05) ? 0 : 3; /* a twentieth of the unit cell */
}

static void test_relative(void)
{
    enum { N = SANITIZED ? 5000 : 20000 };
    struct hand h;
    struct hand_truth t;
    const double wrong[4] = {3, 3, 4, 3}, right[4] = {3, 3, 3, 3}, weak[4] = {0.3, 0.3, 0.3, 0.3};
    /* One probe of 3 is 4: off by w / 3, w its weight; more than a quarter where w > 3/4. */
    hand_start(&h, unit_cell, wrong);
    hand_truth_start(&t, N, three, 0, 2);
    struct report r = measured(&h, &t.truth);
    const double z = (got(&r, "error", "all") - 0.25 / 3) / (sqrt((0.1 - 0.0625) / N) / 3),
                 share = 0.25 * 0.25 * 0.25;
    ok(fabs(z) < 4.5, "one wrong probe: error %.4f, by its weight %.4f", got(&r, "error", "all"),
       0.25 / 3);
    ok(fabs(got(&r, "bad", "all") - share) < 4.5 * sqrt(share / N),
       "bad where it is off by more than a quarter: %.4f, by its weight %.4f",
       got(&r, "bad", "all"), share);
    ok(got(&r, "error_seen", "all") == got(&r, "error", "all") &&
           got(&r, "bad_seen", "all") == got(&r, "bad", "all") &&
           got(&r, "blind_points", "all") == 0,
       "where all is seen, what is seen has the same error");
    ok(fabs(got(&r, "white", "all") / (unit_light() * 3 / 0.7) - 1) < 1e-6,
       "white is the 95th percentile of light over 0.7");
    report_clear(&r);
    hand_truth_end(&t);
    hand_end(&h);

    /* A dark corner that is baked as bright as the rest is wrong by 1 and no more; of a tenth of
     * that light, by that over the floor. */
    hand_truth_start(&t, N, corner_is_dark, 0, 3);
    hand_start(&h, unit_cell, right);
    r = measured(&h, &t.truth);
    ok(fabs(got(&r, "error", "all") - 0.05) < 4.5 * sqrt(0.05 / N) &&
           fabs(got(&r, "error", "dark") - 1) < 1e-9 && got(&r, "error", "lit") < 1e-6 &&
           fabs(got(&r, "bad", "dark") - 1) < 1e-9,
       "light in the dark counts 1 a point, whatever it is (%.4f)", got(&r, "error", "all"));
    report_clear(&r);
    hand_end(&h);
    hand_start(&h, unit_cell, weak);
    r = measured(&h, &t.truth);
    ok(fabs(got(&r, "error", "dark") - 0.3 / (RULER_FLOOR * 3 / 0.7)) < 1e-6 &&
           fabs(got(&r, "error", "lit") - 0.9) < 1e-6,
       "little of it as a share of the floor (%.4f); too dark is too dark",
       got(&r, "error", "dark"));
    report_clear(&r);
    hand_end(&h);
    hand_truth_end(&t);

    /* The truth's noise is no error: light that is right has none in the mean; what is off by w / 3
     * has that, and by up to a quarter of the noise less. */
    enum { NOISY = 4000 };
    for (int off = 0; off < 3; off++) {
        const double noise = off == 1 ? 0.05 : 0.3, relative = noise / (3 * unit_light());
        hand_start(&h, unit_cell, off ? wrong : right);
        hand_truth_start(&t, NOISY, three, noise, 4);
        r = measured(&h, &t.truth);
        const double error = got(&r, "error", "all");
        double exact = 0;
        for (size_t i = 0; i < NOISY && off; i++)
            exact += t.position[3 * i + 1] / 3 / NOISY;
        ok(error - exact < 4.5 * relative / sqrt(NOISY) &&
               error - exact > -4.5 * relative / sqrt(NOISY) - relative / 4 * (off > 0),
           "noise of %.3f in the truth: error %.4f, without it %.4f", relative, error, exact);
        report_clear(&r);
        hand_truth_end(&t);
        hand_end(&h);
    }
}

/* Its 95 % interval holds what endless points would give, also where a twentieth of the points is
 * all there is of it. */
static void test_relative_interval(void)
{
    enum { TRIALS = 200, POINTS = 120 };
    if (SANITIZED) {
        tap_skip("coverage of the error's interval: statistics of the plain build");
        return;
    }
    const double wrong[4] = {3, 3, 4, 3}, right[4] = {3, 3, 3, 3};
    for (int rare = 0; rare < 2; rare++) {
        struct hand h;
        const double exact = rare ? 0.05 : 0.25 / 3;
        double within = 0;
        hand_start(&h, unit_cell, rare ? right : wrong);
        for (int i = 0; i < TRIALS; i++) {
            struct hand_truth t;
            hand_truth_start(&t, POINTS, rare ? corner_is_dark : three, rare ? 0 : 0.02,
                             5000 + (uint64_t)i);
            struct report r = measured(&h, &t.truth);
            const struct estimate e = report_get(&r, "error", "all");
            within += e.low <= exact && exact <= e.high;
            report_clear(&r);
            hand_truth_end(&t);
        }
        hand_end(&h);
        /* 95 %, within 3.5 sqrt(.05 * .95 / 200) = 5.4 %; a little less of rare ones, whose mean is
         * skewed. */
        ok(within / TRIALS > 0.95 - 0.054 - 0.03 * rare && within / TRIALS < 0.9951,
           "the 95 %% interval of %s holds it in %.1f %% of samples",
           rare ? "an error that few points have" : "an error", 100 * within / TRIALS);
    }
}

/* -- where the error comes from --------------------------------------------------------------- */

static void test_causes(void)
{
    /* A sun: E = max(cos, 0), whose bands are A_l Y_lm(sun); what an order cuts off is, in the mean
     * square over directions, the sum of A_l^2 (2l+1) / (4 pi)^2 over the others, A_6 = pi/64, A_8
     * = -pi/128, A_10 = 7 pi/1536, ... The 32 directions see bands of more than 4 as each other's:
     * held within 3 %, in the mean over suns. */
    static const double a[9] = {PI,        2 * PI / 3,    PI / 4,         -PI / 24,       PI / 64,
                                -PI / 128, 7 * PI / 1536, -3 * PI / 1024, 33 * PI / 16384};
    static const int band[9] = {0, 1, 2, 4, 6, 8, 10, 12, 14};
    for (int order = 1; order <= SPHERE_ORDER; order++) {
        struct random r = random_start(11, 1, 0);
        double seen = 0, cut = 0;
        for (int i = 0; i < 2000; i++) {
            double value[SPHERE_COUNT],
                s[3] = {normal_number(&r), normal_number(&r), normal_number(&r)};
            vec3_store(s, vec3_normalize(vec3_load(s)));
            for (int d = 0; d < SPHERE_COUNT; d++)
                value[d] = fmax(vec3_dot(vec3_load(s), vec3_load(sphere_direction[d])), 0);
            sphere_cut_off(order, value);
            for (int d = 0; d < SPHERE_COUNT; d++)
                value[d] *= value[d];
            seen += sphere_mean(value) / 2000;
        }
        for (int i = 0; i < 9; i++)
            cut += band[i] >= order ? a[i] * a[i] * (2 * band[i] + 1) / (16 * PI * PI) : 0;
        ok(fabs(sqrt(seen / cut) - 1) < 0.03,
           "order %d cuts %.4f off a sun's irradiance, by its bands %.4f", order, sqrt(seen),
           sqrt(cut));
    }
    /* Probes with noise e in L00: blended, sum w^2 e^2; over a cell the mean of sum w^2 is 4/10. */
    struct hand h;
    struct hand_truth t;
    struct column *error;
    hand_start(&h, unit_cell, linear_probes);
    baked_close(&h.baked);
    must(table_add_column(stream_table(h.stream, "probe"), "sh_error", COLUMN_F32, 27, &error));
    for (size_t i = 0; i < 4 * 27; i++)
        column_f32(error)[i] = i % 27 < 3 ? 0.25f : 0;
    must(baked_open(&h.baked, h.stream, NULL));
    hand_truth_start(&t, 4000, linear, 0, 4);
    struct report r = measured(&h, &t.truth);
    ok(fabs(got(&r, "capture_noise", "all") / (0.25 * unit_light() * sqrt(0.4)) - 1) < 0.02,
       "the capture's noise, blended: %.4f", got(&r, "capture_noise", "all"));
    ok(got(&r, "cut_off", "all") < 1e-6,
       "and nothing is cut off light that is the same from everywhere");
    report_clear(&r);
    hand_truth_end(&t);
    hand_end(&h);
}

/* -- the bootstrap ---------------------------------------------------------------------------- */

static void mean_of(const void *context, const uint32_t *times, double *figure)
{
    const double *x = context;
    figure[0] = 0;
    for (int i = 0; i < 100; i++)
        figure[0] += times[i] * x[i] / 100;
}

static void test_bootstrap(void)
{
    enum { TRIALS = 400 };
    size_t within = 0;
    bool same = true;
    for (uint64_t trial = 0; trial < TRIALS; trial++) {
        double x[100];
        struct random r = random_start(trial, 7, 0);
        for (int i = 0; i < 100; i++)
            x[i] = -log(1 - random_double(&r)); /* exponential, mean 1 */
        struct estimate e, again;
        struct bootstrap_job job = {.count = 100,
                                    .seed = 1,
                                    .name = 2,
                                    .figures = 1,
                                    .reckon = mean_of,
                                    .context = x,
                                    .threads = 2};
        must(bootstrap(&job, &e));
        within += e.low < 1 && e.high > 1;
        if (trial < 4) {
            job.threads = 1;
            must(bootstrap(&job, &again));
            same = same && !memcmp(&e, &again, sizeof e);
        }
    }
    /* The percentile interval of a skewed mean covers a little less than 95 % (Efron and Tibshirani
     * 1993, ch. 14). */
    const double share = (double)within / TRIALS;
    ok(share > 0.89 && share < 0.985, "the 95 %% interval holds the mean in %.1f %% of samples",
       100 * share);
    ok(same, "and does not depend on threads");
}

/* -- leaks ------------------------------------------------------------------------------------ */

/* Two probes at x = 0 with light `left`, two at x = 1 with light `right`. */
static const double bridge[12] = {0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1};

/* Integral over 0 .. c of x^n 6 x (1 - x): x, the weight of the right pair, has that density
 * (Beta(2, 2)). */
static double moment(double c, int n)
{
    return 6 * (pow(c, n + 2) / (n + 2) - pow(c, n + 3) / (n + 3));
}

/* What the certificate says of the bridge with a wall at x = c, from points by volume; of light
 * where it is known. */
static void test_certificate(double c, const struct bench *b, const struct baked *baked)
{
    enum { SEEDS = 40 };
    struct unseen_cells cells;
    struct report report = {0};
    const double share = moment(c, 1) + moment(1 - c, 1);
    int held = 0;
    for (int seed = 0; seed < SEEDS; seed++) {
        const struct unseen_settings settings = {
            .least = 2, .points = 400, .seed = (uint64_t)seed, .threads = 1};
        must(unseen_cells(&cells, b->tracer, baked, &settings));
        held += cells.now.weight.low <= share && share <= cells.now.weight.high;
        if (seed < SEEDS - 1)
            unseen_cells_clear(&cells);
    }
    ok(held >= SEEDS - 5, "its interval holds the closed form %d of %d times", held, SEEDS);
    ok(cells.points == 400 && cells.near == 1 && !cells.differ &&
           cells.all.weight.value == cells.now.weight.value && cells.now.worst_share > 0 &&
           cells.now.worst_part == 1,
       "from as many points as were asked for; the one cell is the worst");
    must(unseen_report(&report, &cells, 1));
    const bool lit = baked->sh != NULL;
    ok(lit == !isnan(report_get(&report, "leak_light", "all").value),
       "light that leaks is known where there is light");
    const struct estimate e = report_get(&report, lit ? "leak_light" : "leak_volume", "all");
    struct error *err = unseen_gate(&report, e.high);
    ok(!err, "a gate at the upper end lets it through");
    err = unseen_gate(&report, (e.value + e.high) / 2);
    ok(err && error_status(err) == EXIT_ABOVE && strstr(error_message(err), "worst cell 0, at") &&
           strstr(error_message(err), lit ? "light that leaks" : "unseen weight"),
       "one below does not, with a status of its own: %s", err ? error_message(err) : "");
    error_destroy(err);
    report_clear(&report);
    unseen_cells_clear(&cells);
}

/* A wall far off the cell, but within what a corner is asked for: no point of n leaks, and the
 * share may be 3.84 / n still, by Wilson's interval. */
static void test_nothing_found(void)
{
    struct bench b;
    struct hand h;
    struct unseen_cells cells;
    const double value[4] = {1, 1, 1, 1};
    bench_start(&b);
    add_quad(&b, (const double[12]){1.01, -50, -50, 1.01, 50, -50, 1.01, 50, 50, 1.01, -50, 50},
             material(0.5f, 0));
    bench_finish(&b, 1);
    hand_start(&h, bridge, value);
    const struct unseen_settings settings = {.least = 2, .points = 1000, .threads = 1};
    must(unseen_cells(&cells, b.tracer, &h.baked, &settings));
    const double n = 1000, z = 1.96, most = z * z / (n + z * z);
    ok(cells.near == 1 && cells.now.weight.value == 0 && cells.now.weight.low == 0 &&
           fabs(cells.now.weight.high - most) < 0.01 * most,
       "none of 1000 points leaks: up to %.4f may, by Wilson %.4f", cells.now.weight.high, most);
    ok(cells.now.worst_share == 0 && cells.lost == 0, "no cell is the worst");
    unseen_cells_clear(&cells);
    hand_end(&h);
    bench_clear(&b);
}

static void test_wall(double c, double left, double right)
{
    struct bench b;
    struct hand h;
    struct unseen_cells cells;
    enum { SAMPLES = 20000 };
    bench_start(&b);
    add_quad(&b, (const double[12]){c, -50, -50, c, 50, -50, c, 50, 50, c, -50, 50},
             material(0.5f, 0));
    bench_finish(&b, 1);
    const double value[4] = {left, left, right, right};
    hand_start(&h, bridge, value);
    must(unseen_of_cells(&cells, b.tracer, &h.baked, SAMPLES));
    /* Left of the wall the right pair is unseen, with weight x; right of it the left pair, with 1 -
     * x. */
    const double from_right = moment(c, 1), from_left = moment(1 - c, 1),
                 share = from_left + from_right;
    const double light = (right * from_right + left * from_left) / ((left + right) / 2);
    const double leak = fabs(right - left) * sqrt(moment(c, 2) + moment(1 - c, 2)),
                 bias = (right - left) * (from_right - from_left);
    const double spread = sqrt((moment(c, 2) + moment(1 - c, 2) - share * share) / SAMPLES);
    ok(fabs(cells.now.weight.value - share) < 4.5 * spread,
       "a wall at %.2f: unseen weight %.4f, by its closed form %.4f", c, cells.now.weight.value,
       share);
    ok(fabs((cells.now.weight.high - cells.now.weight.low) / (2 * 1.96 * spread) - 1) < 0.05,
       "its interval is that of the sample");
    ok(cells.now.light.low - (cells.now.light.high - cells.now.light.low) < light &&
           light < cells.now.light.high + (cells.now.light.high - cells.now.light.low),
       "unseen light %.4f, by its closed form %.4f", cells.now.light.value, light);
    ok(fabs(cells.now.leaked_rms / unit_light() - leak) < 0.02 * leak + 1e-6 &&
           fabs(cells.now.leaked_bias / unit_light() - bias) < 0.03 * leak + 1e-6,
       "light that leaks %.4f and %+.4f, by their closed forms %.4f and %+.4f",
       cells.now.leaked_rms / unit_light(), cells.now.leaked_bias / unit_light(), leak, bias);
    ok(cells.now.blind == 0 && cells.cell_free[0] == 1 &&
           fabs((double)cells.cell_weight[0] - cells.now.weight.value) < 1e-6,
       "nobody is blind; the one cell is all");
    unseen_cells_clear(&cells);
    test_certificate(c, &b, &h.baked);
    struct baked dark = h.baked; /* the same without light */
    dark.sh = NULL;
    test_certificate(c, &b, &dark);
    hand_end(&h);
    bench_clear(&b);
}

/* Two rooms, a wall at x = c between, each with the light of its own probes: the blend is off by
 * the unseen weight's share, what is seen is right. */
static void test_seen(double c)
{
    enum { N = SANITIZED ? 5000 : 20000 };
    struct bench b;
    struct hand h;
    struct hand_truth t;
    bench_start(&b);
    add_quad(&b, (const double[12]){c, -50, -50, c, 50, -50, c, 50, 50, c, -50, 50},
             material(0.5f, 0));
    bench_finish(&b, 1);
    const double value[4] = {1, 1, 2, 2};
    hand_start(&h, bridge, value);
    hand_truth_start(&t, N, three, 0, 6);
    /* evenly spread over the cell, by four exponential weights (Devroye, ch. V) */
    struct random r = random_start(6, 6, 0);
    double exact = 0, unseen = 0;
    for (size_t i = 0; i < N; i++) {
        double w[4], sum = 0, *p = t.position + 3 * i;
        for (int k = 0; k < 4; k++)
            sum += w[k] = -log(1 - random_double(&r));
        for (int k = 0; k < 3; k++) {
            p[k] = 0;
            for (int j = 0; j < 4; j++)
                p[k] += w[j] / sum * bridge[3 * j + k];
        }
        const double true_light = p[0] < c ? 1 : 2, x = p[0] < c ? p[0] : 1 - p[0];
        exact += x / true_light / N; /* blended: 1 + x */
        unseen += x / N;
        for (size_t k = 0; k < TRUTH_WIDTH; k++)
            t.half[0][TRUTH_WIDTH * i + k] = t.half[1][TRUTH_WIDTH * i + k] =
                (float)(unit_light() * true_light);
    }
    const struct measure_settings s = {
        .tolerance = 0.05, .dark = 0.25, .bad = 0.25, .seed = 5, .threads = 2};
    struct report report = {0};
    must(measure_error(&report, &t.truth, &h.baked, b.tracer, &s, NULL));
    ok(fabs(got(&report, "error", "all") - exact) < 1e-5 &&
           fabs(got(&report, "unseen", "all") - unseen) < 1e-5 &&
           got(&report, "error_seen", "all") < 1e-5 && got(&report, "bad_seen", "all") == 0 &&
           got(&report, "blind_points", "all") == 0,
       "a wall at %.2f: error %.4f by unseen weight %.4f, none of what is seen (%.1g)", c,
       got(&report, "error", "all"), got(&report, "unseen", "all"),
       got(&report, "error_seen", "all"));
    report_clear(&report);

    /* the same, as what light is taken from */
    struct seen *seen;
    must(seen_join(&seen, b.tracer, h.baked.probe_count, h.baked.in));
    must(measure_error(&report, &t.truth, &h.baked, b.tracer, &s, NULL));
    ok(got(&report, "error", "all") < 1e-5 && got(&report, "unseen", "all") == 0,
       "light of what is seen alone: no error, no unseen weight");
    report_clear(&report);
    struct unseen_cells cells;
    must(unseen_of_cells(&cells, b.tracer, &h.baked, 100));
    ok(cells.now.weight.value == 0 && cells.now.leaked_rms == 0, "nor does a cell leak");
    unseen_cells_clear(&cells);
    hand_truth_end(&t);
    hand_end(&h);
    seen_destroy(seen);
    bench_clear(&b);
}

/* A point in a closet, x from 0.4 to 0.6, sees none of its cell's probes. */
static void test_blind(void)
{
    struct bench b;
    bench_start(&b);
    for (int k = 0; k < 2; k++) {
        const double x = k ? 0.6 : 0.4;
        add_quad(&b, (const double[12]){x, -50, -50, x, 50, -50, x, 50, 50, x, -50, 50},
                 material(0.5f, 0));
    }
    bench_finish(&b, 1);
    /* 4 and 5 are in it as well, 5 nearer, without light; 6 behind a wall, nearer than all */
    const double position[21] = {0, 1,   0, 0, 0,   0, 1, 0,    0,   1,  0,
                                 1, 0.5, 2, 2, 0.5, 1, 1, 0.39, 0.5, 0.5};
    const float light[7] = {1, 1, 1, 1, 1, NAN, 1};
    struct probe_place place = {.probe = {0, 1, 2, 3}, .weight = {0.25, 0.25, 0.25, 0.25}};
    const double p[3] = {0.5, 0.5, 0.5};
    struct seen *seen;
    struct seen_look look;
    must(seen_create(&seen, b.tracer, 7, position, light, 1));
    seen_look(b.tracer, position, p, &place, &look);
    seen_blend(seen, p, &look, &place);
    ok(look.blind && fabs(look.unseen - 1) < 1e-12 && place.probe[0] == 4 && place.weight[0] == 1 &&
           place.weight[1] == 0 && place.weight[3] == 0,
       "a blind point takes the light of the nearest probe that it sees and that has some (%d)",
       place.probe[0]);
    seen_destroy(seen);

    /* there is none: the blend stays */
    place = (struct probe_place){.probe = {0, 1, 2, 3}, .weight = {0.4, 0.3, 0.2, 0.1}};
    must(seen_create(&seen, b.tracer, 4, position, light, 1));
    seen_look(b.tracer, position, p, &place, &look);
    seen_blend(seen, p, &look, &place);
    ok(look.blind && place.probe[3] == 3 && place.weight[0] == 0.4 && place.weight[3] == 0.1,
       "where it sees none at all it keeps the light of all");
    seen_destroy(seen);

    /* half of the probes seen: theirs are the weights, in their proportion */
    const double left[3] = {0.2, 0.5, 0.1};
    must(seen_create(&seen, b.tracer, 7, position, light, 1));
    seen_look(b.tracer, position, left, &place, &look);
    seen_blend(seen, left, &look, &place);
    ok(!look.blind && fabs(look.unseen - 0.3) < 1e-12 && fabs(place.weight[0] - 4.0 / 7) < 1e-12 &&
           fabs(place.weight[1] - 3.0 / 7) < 1e-12 && place.weight[2] == 0 && place.weight[3] == 0,
       "what is left of the weights sums to 1 again");
    seen_destroy(seen);
    bench_clear(&b);
}

/* The share of the cell's points between two walls that look at each other that see no probe, of
 * which there is none between. */
static double lost_between(double low, double high, struct unseen_cells *cells)
{
    enum { SAMPLES = 4000 };
    struct bench b;
    struct hand h;
    const double value[4] = {1, 1, 1, 1};
    bench_start(&b);
    for (int k = 0; k < 2; k++) {
        const double x = k ? high : low, y = k ? -50 : 50;
        add_quad(&b, (const double[12]){x, -y, -50, x, y, -50, x, y, 50, x, -y, 50},
                 material(0.5f, 0));
    }
    bench_finish(&b, 1);
    hand_start(&h, bridge, value);
    must(unseen_of_cells(cells, b.tracer, &h.baked, SAMPLES));
    const double lost = cells->lost;
    hand_end(&h);
    bench_clear(&b);
    return lost;
}

static void test_lost(void)
{
    struct unseen_cells cells;
    const double share = moment(0.7, 0) - moment(0.3, 0), lost = lost_between(0.3, 0.7, &cells);
    ok(fabs(lost - share) < 0.01 && lost == cells.now.blind && cells.now.worst_share > share,
       "a closet without a probe: %.4f see none, by its volume %.4f", lost, share);
    unseen_cells_clear(&cells);
    ok(lost_between(0.4, 0.6, &cells) == 0,
       "the void of a wall, narrower than a quarter of the probes' distance, is matter");
    unseen_cells_clear(&cells);
}

static void test_solid(void)
{
    struct bench b;
    struct hand h;
    struct unseen_cells cells;
    const double big[12] = {-3, -3, -3, 9, -3, -3, -3, 9, -3, -3, -3, 9}, value[4] = {1, 1, 1, 1};
    struct shape ball = shape_sphere(1.5, 2);
    double volume = 0;
    for (size_t t = 0; t < ball.triangle_count; t++)
        volume += vec3_dot(shape_corner(&ball, t, 0),
                           vec3_cross(shape_corner(&ball, t, 1), shape_corner(&ball, t, 2))) /
                  6;
    bench_start(&b);
    add_shape(&b, &ball, material(0.5f, 0));
    shape_clear(&ball);
    bench_finish(&b, 1);
    hand_start(&h, big, value);
    must(unseen_of_cells(&cells, b.tracer, &h.baked, 4000));
    const double share = volume / 288; /* of the cell */
    ok(fabs(1 - (double)cells.cell_free[0] - share) < 4.5 * sqrt(share / 4000),
       "a solid ball in a cell is no free space: %.4f, by volume %.4f",
       1 - (double)cells.cell_free[0], share);
    ok(fabs(cells.free_volume - (288 - volume)) < 4.5 * 288 * sqrt(share / 4000) &&
           cells.now.blind < 0.01,
       "who is inside it is not blind but gone (%.2g)", cells.now.blind);
    unseen_cells_clear(&cells);
    hand_end(&h);
    bench_clear(&b);
}

/* -- change ----------------------------------------------------------------------------------- */

static void test_change(void)
{
    enum { STEPS = 64 };
    struct hand h;
    struct hand_truth t;
    hand_start(&h, unit_cell, linear_probes); /* along x the light rises by 1 a unit */
    for (int noisy = 0; noisy < 2; noisy++) {
        hand_truth_start(&t, 2 + STEPS + 1, three, 0, 1);
        struct random r = random_start(9, 9, 0);
        for (int i = 0; i <= STEPS; i++) {
            const size_t row = (size_t)(2 + i);
            t.path[row] = 0;
            t.position[3 * row] = i * 0.9 / STEPS;
            t.position[3 * row + 1] = t.position[3 * row + 2] = 0.01;
            for (int half = 0; half < 2; half++) {
                const double e = unit_light() * (2 + 0.5 * t.position[3 * row]) +
                                 (noisy ? 0.002 * normal_number(&r) : 0);
                for (size_t k = 0; k < TRUTH_WIDTH; k++)
                    t.half[half][TRUTH_WIDTH * row + k] = (float)e;
            }
        }
        t.truth.points = 2;
        t.truth.step = 0.9 / STEPS;
        struct report report = {0};
        must(measure_change(&report, &t.truth, &h.baked));
        const double unit = unit_light();
        if (!noisy)
            ok(fabs(got(&report, "change_rms", "probes") / unit - 1) < 1e-4 &&
                   fabs(got(&report, "change_most", "probes") / unit - 1) < 1e-4 &&
                   fabs(got(&report, "change_rms", "truth") / unit - 0.5) < 1e-3 &&
                   fabs(got(&report, "change_excess", "probes") / unit - 0.5) < 1e-3 &&
                   got(&report, "change_steps", "all") == STEPS,
               "change along a path is the light's slope, and the excess the difference to the "
               "truth's");
        /* the noise of a step is sqrt 2 * .002 / .014 = .2, of its square's mean over 64 about .2^2
         * sqrt(2 / 64) and what goes with the slope */
        else
            ok(fabs(pow(got(&report, "change_rms", "truth") / unit, 2) - 0.25) < 0.15 &&
                   got(&report, "change_noise", "truth") > 0.05,
               "noise does not add to the truth's (%.3f instead of 0.5)",
               got(&report, "change_rms", "truth") / unit);
        report_clear(&report);
        hand_truth_end(&t);
    }
    hand_end(&h);
}

int main(void)
{
    bench_start(&nothing);
    bench_finish(&nothing, 1);
    test_sphere();
    test_normals();
    test_distance();
    test_linear();
    test_kinds();
    test_grid();
    for (int corners = 1; corners <= 3; corners++)
        test_flat(corners);
    test_wrong_probe();
    test_parts();
    test_noise();
    test_relative();
    test_relative_interval();
    test_causes();
    test_bootstrap();
    test_wall(0.5, 1, 1);
    test_wall(0.5, 1, 3);
    test_wall(0.25, 1, 3);
    test_seen(0.5);
    test_seen(0.3);
    test_blind();
    test_nothing_found();
    test_lost();
    test_solid();
    test_change();
    bench_clear(&nothing);
    return tap_done();
}
