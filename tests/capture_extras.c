/* SPDX-License-Identifier: Apache-2.0 */
/* What capture learns beside a point's light: gradient, surfaces, occlusion, visibility; and how it
 * spends: error bounds, orders. Against closed forms, and against other captures. */
#include "libprobe-query/sh.h"
#include "light/order.h"
#include "math/luminance.h"
#include "math/random.h"
#include "stream/stream.h"
#include "support/capture_bench.h"
#include "support/capture_truth.h"

/* -- gradient ---------------------------------------------------------------------------------- */

/* A room with a lamp and a block whose edges hide and bulge. */
static void start_room(struct bench *b)
{
    bench_start(b);
    /* its back would light the slit above it, which rays seldom meet */
    b->settings.emit_front_only = true;
    add_cube(b, 2, material(0.6f, 0));
    add_quad(b, (const double[12]){-0.8, 1.6, -0.8, 0.6, 1.6, -0.8, 0.6, 1.6, 0.9, -0.8, 1.6, 0.9},
             material(0, 4));
    struct shape block = shape_sphere(0.6, 0); /* an icosahedron */
    shape_move(&block, 0.7, -1.2, -0.6);
    add_shape(b, &block, material(0.5f, 0));
    shape_clear(&block);
}

/* Mean gradient of K captures, and its variance. */
static void mean_gradient(const struct bench *b, struct capture_settings s, const double p[3],
                          int count, double *mean, double *variance)
{
    enum { VALUES = 81 };
    double square[VALUES] = {0};
    memset(mean, 0, VALUES * sizeof *mean);
    s.columns = CAPTURE_GRADIENT;
    for (int i = 0; i < count; i++) {
        s.seed = (uint64_t)i;
        const struct capture_probe probe = capture(b, &s, p[0], p[1], p[2]);
        for (int k = 0; k < VALUES; k++) {
            mean[k] += (double)probe.sh_gradient[k] / count;
            square[k] += (double)probe.sh_gradient[k] * (double)probe.sh_gradient[k] / count;
        }
    }
    for (int k = 0; k < VALUES; k++)
        variance[k] = fmax(square[k] - mean[k] * mean[k], 0) / (count - 1);
}

/* The same from six captures, h away along each axis. */
static void six_captures(const struct bench *b, struct capture_settings s, const double p[3],
                         double h, double *gradient, double *variance)
{
    s.columns = CAPTURE_ERROR;
    for (int axis = 0; axis < 3; axis++) {
        struct capture_probe at[2];
        for (int side = 0; side < 2; side++) {
            double q[3] = {p[0], p[1], p[2]};
            q[axis] += side ? h : -h;
            s.seed = (uint64_t)(100 + 2 * axis + side);
            at[side] = capture(b, &s, q[0], q[1], q[2]);
        }
        for (int k = 0; k < 27; k++) {
            const double e0 = (double)at[0].sh_error[k], e1 = (double)at[1].sh_error[k];
            gradient[27 * axis + k] = ((double)at[1].sh[k] - (double)at[0].sh[k]) / (2 * h);
            variance[27 * axis + k] = (e0 * e0 + e1 * e1) / (4 * h * h);
        }
    }
}

/* Walls that move with planes are exact in the limit of small cells; at 4096 rays what the cells
 * cut off is 1 to 2 % of the gradient. A sign, a factor or an axis that is wrong is off by its
 * whole size. */
static void test_gradient(enum capture_light light)
{
    static const double points[4][3] = {
        {0.3, 0.5, -0.4}, {-0.9, -0.3, 0.7}, {1.1, 0.9, 1.2}, {0.1, -0.7, 0.2}};
    struct bench b;
    start_room(&b);
    bench_finish(&b, 1);
    double off = 0, noise = 0, size = 0, along = 0;
    for (int i = 0; i < 4; i++) {
        double free[81], free_variance[81], six[81], six_variance[81];
        struct capture_settings s = capture_settings_default();
        s.light = light;
        s.rays = 4096;
        mean_gradient(&b, s, points[i], 8, free, free_variance);
        s.rays = 200000;
        six_captures(&b, s, points[i], 0.04, six, six_variance);
        for (int k = 0; k < 81; k++) {
            off += (free[k] - six[k]) * (free[k] - six[k]);
            noise += free_variance[k] + six_variance[k];
            size += six[k] * six[k] - six_variance[k];
            along += free[k] * six[k];
        }
    }
    const double left = sqrt(fmax(off - noise, 0) / size);
    ok(left < 0.04,
       "%s light: the gradient is that of six shifted captures, but for %.1f %% beside a noise of "
       "%.1f %%",
       light == CAPTURE_DIRECT ? "direct" : "indirect", 100 * left, 100 * sqrt(noise / size));
    ok(fabs(along / size - 1) < 0.03, "and as large (ratio %.3f)", along / size);
    bench_clear(&b);
}

/* A point light in the open: d/dx of I Y(d) / r^2. */
static void test_point_gradient(void)
{
    struct bench b;
    bench_start(&b);
    add_light(&b, (struct scene_light){
                      .kind = SCENE_POINT, .position = {1, 2, -1}, .intensity = {3, 5, 7}});
    bench_finish(&b, 1);
    struct capture_settings s = capture_settings_default();
    s.columns = CAPTURE_GRADIENT;
    const double p[3] = {0.2, -0.3, 0.4}, way[3] = {0.8, 2.3, -1.4};
    const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
    const double r2 = way[0] * way[0] + way[1] * way[1] + way[2] * way[2], r = sqrt(r2);
    double worst = 0;
    for (int axis = 0; axis < 3; axis++) {
        /* d(r^-2)/dp = 2 way / r^4; L_00 = I Y00 / r^2; L_11 = I 0.4886 way_x / r^3 */
        const double d00 = 3 * SH_Y00 * 2 * way[axis] / (r2 * r2);
        const double d11 =
            3 * 0.48860251190292 *
            (3 * way[0] * way[axis] / (r2 * r2 * r) - (axis == 0 ? 1 / (r2 * r) : 0));
        worst = fmax(worst, fabs((double)probe.sh_gradient[27 * axis] - d00) +
                                fabs((double)probe.sh_gradient[27 * axis + 9] - d11));
    }
    ok(worst < 1e-6, "the gradient of a point light's delta is its closed form's (%.1e)", worst);
    bench_clear(&b);
}

/* -- surfaces ---------------------------------------------------------------------------------- */

static struct capture_probe capture_surface(const struct bench *b, const struct capture_settings *s,
                                            double x, double y, double z, const float n[3])
{
    struct capture_probe probe;
    must(capture_probe(&b->path, s, (const double[3]){x, y, z}, n, &probe));
    return probe;
}

static void test_surfaces(void)
{
    struct bench b;
    bench_start(&b);
    b.settings.sky[0] = 1, b.settings.sky[1] = 2, b.settings.sky[2] = 3;
    add_light(&b, (struct scene_light){
                      .kind = SCENE_SUN, .direction = {0, -0.6, -0.8}, .intensity = {10, 20, 30}});
    bench_finish(&b, 1);
    struct capture_settings s = capture_settings_default();
    s.rays = 64;
    const struct capture_probe up = capture_surface(&b, &s, 0, 0, 0, (const float[3]){0, 1, 0});
    const struct capture_probe away = capture_surface(&b, &s, 0, 0, 0, (const float[3]){0, 0, -1});
    ok(fabs((double)up.sh[0] - (PI + 6)) < 1e-5 && fabs((double)up.sh[2] - 3 * (PI + 6)) < 1e-4 &&
           up.sh_error[0] < 1e-5f,
       "a surface under a sky and a sun: pi L + E cos, to the digit (%.6f)", (double)up.sh[0]);
    ok(fabs((double)away.sh[0] - PI) < 1e-5, "turned from the sun: pi L (%.6f)",
       (double)away.sh[0]);
    bench_clear(&b);

    /* A square lamp above and to the side, by Lambert's formula: E = L / 2 sum of angle * (edge
     * normal . n). */
    const double quad[12] = {0.2, 1.5, -0.5, 1.2, 1.5, -0.5, 1.2, 1.5, 0.5, 0.2, 1.5, 0.5};
    double lambert = 0;
    for (int i = 0; i < 4; i++) {
        const struct vec3 a = vec3_normalize(vec3_load(quad + 3 * i)),
                          c = vec3_normalize(vec3_load(quad + 3 * ((i + 1) % 4)));
        lambert += 0.5 * acos(vec3_dot(a, c)) * vec3_normalize(vec3_cross(a, c)).y;
    }
    lambert = fabs(lambert) * 3;
    bench_start(&b);
    add_quad(&b, quad, material(0, 3));
    bench_finish(&b, 1);
    double mean = 0, variance = 0;
    for (int i = 0; i < 32; i++) {
        s.seed = (uint64_t)i;
        const struct capture_probe p = capture_surface(&b, &s, 0, 0, 0, (const float[3]){0, 1, 0});
        mean += (double)p.sh[0] / 32;
        variance += (double)p.sh_error[0] * (double)p.sh_error[0] / 32 / 32;
    }
    ok(fabs(mean - lambert) < 4.5 * sqrt(variance) && sqrt(variance) < 0.01 * lambert,
       "a lamp over a surface: Lambert's %.5f (%.5f +- %.5f)", lambert, mean, sqrt(variance));
    bench_clear(&b);
}

/* A wall of height 1 beside the surface, d away and as good as endless: what is open are the
 * directions that make an angle below pi - atan(1 / d) with the floor, seen along the wall. */
static void test_occlusion(void)
{
    struct bench b;
    bench_start(&b);
    const double d = 0.5, f = 1e4;
    add_quad(&b, (const double[12]){d, 0, -f, d, 0, f, d, 1, f, d, 1, -f}, material(0, 0));
    bench_finish(&b, 1);
    struct capture_settings s = capture_settings_default();
    s.rays = 100000;
    s.columns = CAPTURE_AO | CAPTURE_BENT_NORMAL;
    const float up[3] = {0, 1, 0};
    const struct capture_probe open = capture_surface(&b, &s, 0, 0, 0, up);
    const double t = PI - atan2(1, d), ao = 0.5 * (1 - cos(t));
    ok(fabs((double)open.ao - ao) < 0.003 && fabs((double)open.sky - ao) < 0.003,
       "beside a wall: k_A %.4f (%.4f)", ao, (double)open.ao);
    const double across = -sin(t) * sin(t) / 2, above = t / 2 - sin(2 * t) / 4,
                 length = sqrt(across * across + above * above);
    ok(fabs((double)open.bent_normal[0] - across / length) < 0.01 &&
           fabs((double)open.bent_normal[1] - above / length) < 0.01 &&
           fabs((double)open.bent_normal[2]) < 0.01,
       "the bent normal leans from it: %.3f, %.3f (%.3f, %.3f)", across / length, above / length,
       (double)open.bent_normal[0], (double)open.bent_normal[1]);
    s.ao_distance = 0.4;
    const struct capture_probe near = capture_surface(&b, &s, 0, 0, 0, up);
    ok(near.ao == 1 && near.sky == open.sky, "what is beyond the ao distance does not occlude");
    bench_clear(&b);

    bench_start(&b); /* a wide ceiling at height 1, within reach for cosines above 1 / 1.6 */
    add_floor(&b, f, 1, material(0, 0));
    bench_finish(&b, 1);
    s.ao_distance = 1.6;
    const struct capture_probe below = capture_surface(&b, &s, 0, 0, 0, up);
    ok(fabs((double)below.ao - 1 / 2.56) < 0.003 && below.sky < 0.001f,
       "under a ceiling: (height / distance)^2 = %.4f (%.4f)", 1 / 2.56, (double)below.ao);
    bench_clear(&b);
}

/* Above an endless floor the open half has V = 1/2 + sign(y)/2: L_00 = sqrt(pi), L_1-1 = pi 0.4886,
 * L_2m = 0. */
static void test_visibility(void)
{
    struct bench b;
    bench_start(&b);
    add_floor(&b, 1e5, 0, material(0, 0));
    bench_finish(&b, 1);
    struct capture_settings s = capture_settings_default();
    s.rays = 200000;
    s.columns = CAPTURE_VISIBILITY;
    const struct capture_probe p = capture(&b, &s, 0, 1, 0);
    double worst = 0;
    for (int i = 0; i < 9; i++)
        worst = fmax(worst, fabs((double)p.visibility[i] - (i == 0   ? sqrt(PI)
                                                            : i == 1 ? 0.48860251190292 * PI
                                                                     : 0)));
    ok(worst < 0.005, "the sky that a probe above a floor sees, as SH (off by %.4f)", worst);
    bench_clear(&b);
}

/* -- what it costs ---------------------------------------------------------------------------- */

/* Relative error of irradiance in luminance, in the mean over directions, as capture_settings.error
 * has it. */
static double irradiance_off(const struct capture_probe *p, const struct capture_probe *truth)
{
    double off = 0;
    for (int l = 0, i = 0; l < 3; l++)
        for (; i < (l + 1) * (l + 1); i++) {
            const double d = luminance_f32(p->sh + 3 * i) - luminance_f32(truth->sh + 3 * i);
            off += sh_cosine(l) * sh_cosine(l) * d * d;
        }
    const double mean = luminance_f32(truth->sh);
    return sqrt(off) / (PI * mean);
}

static void test_error_bound(void)
{
    enum { PROBES = 40 };
    static const double bounds[] = {0.1, 0.05, 0.02};
    struct bench b;
    start_room(&b);
    bench_finish(&b, 3);
    double before = 0;
    for (int i = 0; i < 3; i++) {
        struct random r = random_start(3, 0, 0);
        double square = 0, rays = 0;
        int most = 0;
        for (int k = 0; k < PROBES; k++) {
            const double p[3] = {3 * random_double(&r) - 1.5, 3 * random_double(&r) - 1.2,
                                 3 * random_double(&r) - 1.5};
            struct capture_settings s = capture_settings_default();
            s.rays = 128;
            s.error = bounds[i];
            const struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
            s.error = 0;
            s.rays = 60000;
            s.seed = 77;
            const struct capture_probe truth = capture(&b, &s, p[0], p[1], p[2]);
            const double off = irradiance_off(&probe, &truth);
            square += off * off / PROBES;
            rays += (double)probe.rays / PROBES;
            most = probe.rays > most ? probe.rays : most;
        }
        /* 40 probes tell the root of the mean to 11 %; rounds stop somewhat below the bound. */
        ok(sqrt(square) < 1.25 * bounds[i] && sqrt(square) > 0.3 * bounds[i],
           "error %g asked for, %.4f had, %.0f rays a probe", bounds[i], sqrt(square), rays);
        ok(rays > before && most < 65536, "less error costs more rays, %d at most", most);
        before = rays;
    }
    struct capture_settings s = capture_settings_default();
    s.rays = 128;
    s.error = 1e-4;
    s.rays_most = 1000;
    ok(capture(&b, &s, 0.1, 0.2, 0.3).rays <= 1040, "no more than --max-rays are spent");
    s.rays_most = 65536;
    s.error = 0.02;
    s.error_floor = 1e6;
    ok(capture(&b, &s, 0.1, 0.2, 0.3).rays == capture_ray_count(128),
       "irradiance far below the floor is not worth a second round");
    bench_clear(&b);

    bench_start(&b); /* dark, but for a sun that shines elsewhere */
    add_cube(&b, 2, material(0.6f, 0));
    bench_finish(&b, 3);
    s.error_floor = 0;
    ok(capture(&b, &s, 0, 0, 0).rays < 3000, "a probe that sees no light ends");
    bench_clear(&b);

    bench_start(&b);
    add_light(&b, (struct scene_light){
                      .kind = SCENE_SUN, .direction = {0, -1, 0}, .intensity = {10, 10, 10}});
    bench_finish(&b, 3);
    const struct capture_probe sunny = capture(&b, &s, 0, 0, 0);
    ok(sunny.rays == capture_ray_count(128), "a sun alone is certain (%d rays)", sunny.rays);
    bench_clear(&b);
}

/* -- the light tree --------------------------------------------------------------------------- */

/* Densities of all that can be drawn add up to one, and are those that lights_density tells; among
 * point lights, of which none is wanted, too. */
static void test_light_tree(bool points)
{
    enum { LAMPS = 300, DRAWS = 100000 };
    struct bench b;
    struct random r = random_start(11, 0, 0);
    bench_start(&b);
    b.settings.emit_front_only = true;
    for (int i = 0; i < LAMPS; i++) {
        struct shape lamp = shape_sphere(0.08 + 0.1 * random_double(&r), 0);
        shape_move(&lamp, 20 * random_double(&r), 20 * random_double(&r), 20 * random_double(&r));
        add_shape(&b, &lamp, material(0, (float)pow(10, 3 * random_double(&r))));
        shape_clear(&lamp);
    }
    for (int i = 0; i < LAMPS && points; i++) {
        struct scene_light light = {.kind = SCENE_POINT, .intensity = {9, 9, 9}};
        light.position =
            (struct vec3){20 * random_double(&r), 20 * random_double(&r), 20 * random_double(&r)};
        must(scene_push_light(b.scene, light));
    }
    bench_finish(&b, 1);
    const struct lights *lights = &b.path.lights;
    const struct lights_receiver from = {
        .position = {0.1f, -0.2f, 0.05f}, .normal = {0, 1, 0}, .surfaces = points};
    double sum = 0, unlike = 0;
    size_t drawn = 0, unwanted = 0;
    for (int i = 0; i < DRAWS; i++) {
        struct lights_choice choice;
        if (!lights_sample(lights, b.tracer, &from, random_double(&r), random_float(&r), &choice))
            continue;
        drawn++;
        unwanted += choice.punctual != NULL;
        const double density =
            choice.punctual ? 0 : (double)lights_density(lights, &from, &choice.point);
        unlike = fmax(unlike, fabs(density / (double)choice.density - 1));
    }
    ok(unlike < 1e-4 && !unwanted, "a point is drawn with the density that is told of it (%.1e)%s",
       unlike, points ? ", and no point light" : "");
    /* A draw may end where a node's lights all turn out to be behind the surface: its share is then
     * nobody's. */
    const double share = (double)drawn / DRAWS;
    for (uint32_t i = 0; i < b.scene->instance_count; i++) {
        for (uint32_t k = 0; k < b.scene->meshes[b.scene->instances[i].mesh].triangle_count; k++) {
            struct trace_point p;
            struct vec3f c[3];
            trace_point_at(b.tracer, i, k, 0.3f, 0.3f, &p);
            trace_corners(b.tracer, i, k, c);
            const float area =
                0.5f * vec3f_length(vec3f_cross(vec3f_sub(c[1], c[0]), vec3f_sub(c[2], c[0])));
            sum += (double)lights_density(lights, &from, &p) * (double)area;
        }
    }
    ok(share > 0.7 && fabs(sum - share) < 5 * sqrt(share * (1 - share) / DRAWS) + 1e-4,
       "over all triangles of %zu lights it adds up to the share of draws that find one (%.4f, "
       "%.4f)",
       lights->count, sum, share);
    bench_clear(&b);
}

/* -- orders ----------------------------------------------------------------------------------- */

static void test_order(void)
{
    enum { ROWS = 5, WIDTH = 108 };
    struct table t = {0};
    struct column *column;
    must(table_init(&t, "probe"));
    must(table_add_column(&t, "sh", COLUMN_F32, WIDTH, NULL));
    must(table_add_column(&t, "sh_error", COLUMN_F32, WIDTH, NULL));
    must(table_add_column(&t, "sh_gradient", COLUMN_F32, 3 * WIDTH, &column));
    must(table_resize(&t, ROWS));
    float *sh = column_f32(table_column(&t, "sh")),
          *error = column_f32(table_column(&t, "sh_error"));
    float *gradient = column_f32(table_column(&t, "sh_gradient"));
    for (int i = 0; i < ROWS * WIDTH; i++) {
        const int k = i % WIDTH / 3, l = (int)sqrt(k);
        sh[i] = l == 0 ? 1 : k == l * l ? 0.5f : 0.01f;
        error[i] = l == 0 || k == l * l ? 0 : 0.01f; /* all the rest is noise */
    }
    for (int i = 0; i < 3 * ROWS * WIDTH; i++)
        gradient[i] = (float)(i % (3 * WIDTH));
    /* Energies A_0^2 and A_l^2 / 4; the noise is taken out. */
    const double a[6] = {PI * PI, PI * PI / 9, PI * PI / 64, 0, PI * PI / 2304, 0};
    double all = 0, beyond = 0;
    for (int l = 0; l < 6; l++)
        all += a[l];
    static const int expected[6] = {1, 2, 3, 3, 5, 5};
    bool right = true;
    for (int l = 5; l >= 0; l--) {
        int order;
        double lost;
        must(order_least(&t, false, sqrt(beyond / all) + 1e-6, &order, &lost));
        right = right && order == expected[l] && fabs(lost - sqrt(beyond / all)) < 1e-4;
        beyond += a[l];
    }
    ok(right, "the least order by the share of irradiance that it loses, without the noise's");
    must(order_reduce(&t, 2));
    sh = column_f32(table_column(&t, "sh"));
    gradient = column_f32(table_column(&t, "sh_gradient"));
    ok(table_column(&t, "sh")->width == 12 && table_column(&t, "sh_gradient")->width == 36 &&
           sh[12] == 1 && sh[15] == 0.5f && gradient[36 + 12] == WIDTH &&
           gradient[36 + 25] == 2 * WIDTH + 1,
       "columns are cut to it, each axis of the gradient by itself");
    table_clear(&t);
}

int main(void)
{
    test_gradient(CAPTURE_DIRECT);
    test_gradient(CAPTURE_INDIRECT);
    test_point_gradient();
    test_surfaces();
    test_occlusion();
    test_visibility();
    test_error_bound();
    test_light_tree(false);
    test_light_tree(true);
    test_order();
    return tap_done();
}
