/* SPDX-License-Identifier: Apache-2.0 */
/* Capture at the ends of its range: tiny, huge and far-off scenes, very bright beside very dim,
 * walls that are almost white, probes on walls, a million triangles, one and none. Each case prints
 * a row
 *
 *     # extreme NAME: error E % +- S %, z Z
 *
 * with the error along the truth (a closed form), its standard error, and the largest deviation of
 * a coefficient in units of sh_error; capture_runs.h says what is asked of them. */
#include "scene/scene_build.h"
#include "stream/stream.h"
#include "support/capture_runs.h"

static struct capture_settings settings_of(int rays, int bounces)
{
    struct capture_settings s = capture_settings_default();
    s.order = SH_ORDER_MAX;
    s.rays = rays;
    s.bounces = bounces;
    return s;
}

/* Prints the row and holds it: the error's standard error is to be below `resolution`. */
static void check_row(const struct runs *r, const double *truth, double resolution,
                      const char *name)
{
    const struct estimate bias = runs_bias(r, truth);
    const double z = runs_z(r, truth);
    printf("# extreme %s: error %+.4f %% +- %.4f %%, z %.2f\n", name, 100 * bias.mean,
           100 * bias.error, z);
    ok(z < RUNS_Z_MOST && (SANITIZED || (deviation(bias.mean, bias.error, 1) < RUNS_T_MOST &&
                                         bias.error < resolution)),
       "%s: as the closed form", name);
}

/* -- scale and place -------------------------------------------------------------------------- */

/* A sphere with a bright patch, as in tests/forms.c: even light, rho Le f / (1 - rho), on its
 * walls. */
static void test_scale(double scale, double offset)
{
    const double at[3] = {0.2, -0.3, 0.1}, le[3] = {3, 6, 1.5}, to = scale * offset;
    struct shape wall = shape_sphere(-1, 4);
    const double area = shape_area(&wall);
    struct shape patch = shape_cut(&wall, (struct vec3){0.6, 0, 0.8}, 0.8);
    double truth[TRUTH_VALUES] = {0}, even[3];
    for (int k = 0; k < 3; k++) {
        const double a = (double)0.8f / (1 << k);
        even[k] = a * le[k] * shape_area(&patch) / area / (1 - a);
    }
    add_uniform(truth, even);
    add_facing(truth, &patch, vec3_load(at), 4, le);
    shape_place(&wall, (const double[9]){scale, 0, 0, 0, scale, 0, 0, 0, scale},
                (struct vec3){to, -to, to / 3});
    shape_place(&patch, (const double[9]){scale, 0, 0, 0, scale, 0, 0, 0, scale},
                (struct vec3){to, -to, to / 3});
    struct bench b;
    bench_start(&b);
    add_shape(&b, &wall, material(0.8f, 0));
    add_shape(&b, &patch, material(0.8f, 3));
    bench_finish(&b, 128);
    const double p[3] = {scale * at[0] + to, scale * at[1] - to, scale * at[2] + to / 3};
    struct runs runs;
    char name[80];
    runs_take(&runs, &b, settings_of(1024, 128), p, 32);
    snprintf(name, sizeof name, "scale %g, moved by %g sizes", scale, offset);
    check_row(&runs, truth, RUNS_RESOLUTION, name);
    /* From r within the unit sphere the distance t obeys 1/t = (r c + sqrt(1 - r^2 + r^2 c^2)) / (1
     * - r^2), c the cosine from the radius; its mean over c is (1 + (1 - r^2) / r artanh r) / (2 (1
     * - r^2)). */
    const double r = sqrt(0.14), depth = 2 * (1 - r * r) / (1 + (1 - r * r) / r * atanh(r));
    ok(fabs(runs.depth / scale / depth - 1) < 0.01, "%s: depth %.4f of %.4f, in scene units", name,
       runs.depth / scale, depth);
    bench_clear(&b);
    shape_clear(&wall);
    shape_clear(&patch);
}

/* -- emitters --------------------------------------------------------------------------------- */

/* A disc of this solid angle, seen along its axis from afar. */
static void test_small_emitter(double solid_angle)
{
    static const double turned[9] = {2.0 / 3,  -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3,
                                     -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3};
    const double distance = 4, axis[3] = {turned[1], turned[4], turned[7]}, at[3] = {0.1, 0.2, 0.3};
    const double sine2 = solid_angle / PI * (1 - solid_angle / (4 * PI)), cosine = sqrt(1 - sine2);
    struct shape disc = shape_disc(distance * sqrt(sine2) / cosine, 256);
    struct bench b;
    shape_place(&disc, turned, vec3_fma(vec3_load(at), distance, vec3_load(axis)));
    bench_start(&b);
    add_shape(&b, &disc, material(0, 1e4f));
    bench_finish(&b, 4);
    /* As zonal functions of a direction: 1 - P_l(cosine) is lost below 1e-8 sr, and smaller than
     * float's own. */
    double truth[TRUTH_VALUES] = {0};
    const double rgb[3] = {1e4, 2e4, 5e3};
    if (solid_angle > 1e-6)
        add_cap(truth, axis, cosine, rgb);
    else
        add_truth(truth, TRUTH_ORDER, axis, rgb[0], rgb[1], rgb[2], solid_angle);
    struct runs runs;
    char name[80];
    runs_take(&runs, &b, settings_of(256, 4), at, 32);
    snprintf(name, sizeof name, "emitter of %g sr", solid_angle);
    check_row(&runs, truth, RUNS_RESOLUTION, name);
    bench_clear(&b);
    shape_clear(&disc);
}

struct lit_floor {
    double at[3], lamp[3], intensity;
};

/* A small disc that faces down is a light of intensity I cos. */
static void floor_field(const void *context, const double d[3], double rgb[3])
{
    const struct lit_floor *f = context;
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (!(d[1] < 0))
        return;
    const double t = f->at[1] / -d[1], x = f->at[0] + t * d[0] - f->lamp[0],
                 z = f->at[2] + t * d[2] - f->lamp[2], h = f->lamp[1];
    const double square = x * x + h * h + z * z, e = f->intensity * h * h / (square * square);
    for (int k = 0; k < 3; k++)
        rgb[k] = 0.5 / (1 << k) * e * (k == 0 ? 1 : k == 1 ? 2 : 0.5) / PI;
}

/* One bounce, off a floor, from a lamp that is 1e-4 sr or less from wherever light falls. */
static void test_small_lamp_bounce(void)
{
    const double radius = 0.01;
    const struct lit_floor lit = {
        .at = {0, 1, 0.5}, .lamp = {1, 3, 0}, .intensity = 1e4 * PI * radius * radius};
    struct shape disc = shape_disc(radius, 256);
    struct bench b;
    shape_move(&disc, 1, 3, 0);
    bench_start(&b);
    add_shape(&b, &disc, material(0, 1e4f));
    add_floor(&b, 2e4, 0, material(0.5f, 0));
    bench_finish(&b, 4);
    double truth[TRUTH_VALUES] = {0};
    add_field(truth, 64, 64, floor_field, &lit);
    struct runs runs;
    struct capture_settings s = settings_of(1024, 4);
    s.light = CAPTURE_INDIRECT;
    runs_take(&runs, &b, s, lit.at, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, "floor under a lamp of 3e-5 sr");
    bench_clear(&b);
    shape_clear(&disc);
}

/* The runs of one channel alone. */
static void only_channel(struct runs *r, double *truth, int channel)
{
    for (int k = 0; k < TRUTH_VALUES; k++) {
        if (k % 3 == channel)
            continue;
        truth[k] = r->variance[k] = 0;
        for (int i = 0; i < r->count; i++)
            r->value[i][k] = 0;
    }
}

/* A red lamp of radiance 1e8 beside a green one of 1e-8: each is right, in its own channel. */
static void test_contrast(void)
{
    const double red[12] = {-1.5, 1, -0.5, -0.5, 1, -0.5, -0.5, 1, 0.5, -1.5, 1, 0.5};
    const double green[12] = {0.5, 1, -0.5, 1.5, 1, -0.5, 1.5, 1, 0.5, 0.5, 1, 0.5};
    const struct vec3 u = {1, 0, 0}, v = {0, 0, 1};
    const struct gauss g = gauss_rule(40);
    struct scene_material m = material(0, 0);
    struct bench b;
    bench_start(&b);
    m.emission = (struct vec3f){1e8f, 0, 0};
    add_quad(&b, red, m);
    m.emission = (struct vec3f){0, 1e-8f, 0};
    add_quad(&b, green, m);
    bench_finish(&b, 4);
    static struct runs runs, one;
    runs_take(&runs, &b, settings_of(8192, 4), (const double[3]){0, 0, 0}, 64);
    for (int channel = 0; channel < 2; channel++) {
        double truth[TRUTH_VALUES] = {0};
        add_parallelogram(truth, vec3_load(red), u, v, &g, (const double[3]){(double)1e8f, 0, 0});
        add_parallelogram(truth, vec3_load(green), u, v, &g,
                          (const double[3]){0, (double)1e-8f, 0});
        one = runs;
        only_channel(&one, truth, channel);
        check_row(&one, truth, RUNS_RESOLUTION,
                  channel ? "radiance 1e-8 beside 1e8" : "radiance 1e8 beside 1e-8");
    }
    bench_clear(&b);
}

/* -- albedo ----------------------------------------------------------------------------------- */

/* A closed box of shining walls: Le (1 - rho^(n+1)) / (1 - rho). A path lives for 1 / (1 - rho)
 * bounces. */
static void test_white(float albedo, int rays, double resolution)
{
    enum { BOUNCES = 10000 };
    double truth[TRUTH_VALUES] = {0}, rgb[3];
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(albedo, 1));
    bench_finish(&b, BOUNCES);
    for (int k = 0; k < 3; k++) {
        const double rho = (double)albedo / (1 << k);
        rgb[k] = (k == 0 ? 1 : k == 1 ? 2 : 0.5) * (1 - pow(rho, BOUNCES + 1)) / (1 - rho);
    }
    add_uniform(truth, rgb);
    struct runs runs;
    char name[80];
    runs_take(&runs, &b, settings_of(rays, BOUNCES), (const double[3]){0.3, -0.4, 0.2}, 32);
    snprintf(name, sizeof name, "closed box of albedo %g", (double)albedo);
    check_row(&runs, truth, resolution, name);
    bench_clear(&b);
}

/* -- probes on walls -------------------------------------------------------------------------- */

/* whether the wall is in the middle of the scene's box, where floats are finest */
enum wall { ALONE, UNDER_ANOTHER };

/* A square under an even sky scatters rho L to both sides: a probe close above sees that below and
 * L above. One that stands on it is taken to be before its front. */
static void test_near_wall(double height, enum wall wall, const char *name)
{
    const double rho = 0.5, half = 10, p[3] = {0.7, height, -1.3};
    struct bench b;
    bench_start(&b);
    memcpy(b.settings.sky, (const double[3]){1, 1, 1}, sizeof b.settings.sky);
    add_floor(&b, half, 0, material((float)rho, 0));
    if (wall == UNDER_ANOTHER)
        add_floor(&b, 1e-3, 7, material((float)rho, 0));
    bench_finish(&b, 2);
    double truth[TRUTH_VALUES] = {0};
    const double below[3] = {rho - 1, rho / 2 - 1, rho / 4 - 1};
    add_uniform(truth, (const double[3]){1, 1, 1});
    add_cap(truth, (const double[3]){0, height < 0 ? 1 : -1, 0}, 0, below);
    struct runs runs;
    runs_take(&runs, &b, settings_of(512, 2), p, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, name);
    bench_clear(&b);
}

/* On a wall, an edge and in a corner of a closed box that shines: the same light as anywhere in it,
 * with none lost through the walls. */
static void test_in_corner(double x, double y, double z, const char *name)
{
    double truth[TRUTH_VALUES] = {0};
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1.1, material(0.5f, 1));
    bench_finish(&b, 64);
    add_uniform(truth, (const double[3]){1 / 0.5, 2 / 0.75, 0.5 / 0.875});
    struct runs runs;
    runs_take(&runs, &b, settings_of(2048, 64), (const double[3]){x, y, z}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, name);
    ok(runs.sky == 0 && runs.validity == 1, "%s: no ray escapes", name);
    bench_clear(&b);
}

/* The same in a corner of a box that is placed twice, the second time mirrored, turned about and
 * grown. */
static void test_in_instance(void)
{
    double truth[TRUTH_VALUES] = {0};
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1.1, material(0.5f, 1));
    const double mirrored[12] = {0, -2, 0, 30, 2, 0, 0, -7, 0, 0, -2, 5};
    must(scene_push_instance(b.scene, 0, mirrored));
    bench_finish(&b, 64);
    add_uniform(truth, (const double[3]){1 / 0.5, 2 / 0.75, 0.5 / 0.875});
    struct runs runs;
    runs_take(&runs, &b, settings_of(2048, 64), (const double[3]){30 + 2.2, -7 + 2.2, 5 - 2.2}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, "probe in a corner of a mirrored box");
    ok(runs.sky == 0 && runs.validity == 1, "probe in a corner of a mirrored box: no ray escapes");
    bench_clear(&b);
}

/* A wall shields a probe that stands on its front from a sun and a bulb behind it, not from those
 * before it. */
static void test_shielded(void)
{
    for (int behind = 0; behind < 2; behind++) {
        const double side = behind ? -1 : 1, p[3] = {0.7, 0, -1.3};
        struct bench b;
        bench_start(&b);
        add_floor(&b, 10, 0, material(0, 0));
        add_floor(&b, 1e-3, 7, material(0, 0));
        add_light(&b, (struct scene_light){.kind = SCENE_SUN,
                                           .direction = {0.6, -0.8 * side, 0},
                                           .intensity = {1, 2, 3}});
        add_light(&b, (struct scene_light){.kind = SCENE_POINT,
                                           .position = {0.7, 2 * side, -1.3},
                                           .intensity = {4, 4, 4}});
        bench_finish(&b, 2);
        double truth[TRUTH_VALUES] = {0};
        add_truth(truth, TRUTH_ORDER, (const double[3]){-0.6, 0.8, 0}, 1, 2, 3, 1);
        add_truth(truth, TRUTH_ORDER, (const double[3]){0, 1, 0}, 1, 1, 1, 1);
        struct runs runs;
        runs_take(&runs, &b, settings_of(64, 2), p, 2);
        if (behind) {
            runs_mean(&runs, truth);
            ok(largest(truth, TRUTH_VALUES) == 0,
               "probe on a wall: lights behind it do not shine through");
        } else {
            ok(runs_z(&runs, truth) < 1, "probe on a wall: lights before it shine");
        }
        bench_clear(&b);
    }
}

/* Points of a tilted black square, with its normal or against it: whichever side, the sky's
 * irradiance is pi, and none of it is lost to the square itself. */
static void test_surface_points(void)
{
    static const double turned[9] = {2.0 / 3,  -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3,
                                     -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3};
    enum { POINTS = 64 };
    struct shape square = shape_grid(3, 1);
    struct bench b;
    shape_place(&square, turned, (struct vec3){0.1, 7.3, -4.7});
    bench_start(&b);
    memcpy(b.settings.sky, (const double[3]){1, 1, 1}, sizeof b.settings.sky);
    add_shape(&b, &square, material(0, 0));
    add_floor(&b, 1e-3, -20, material(0, 0));
    bench_finish(&b, 2);
    const struct capture_settings s = settings_of(64, 2);
    double worst = 0;
    for (int i = 0; i < 2 * POINTS; i++) {
        const double x = 5 * (i / 2 % 8 + 0.3) / 8 - 2.5, z = 5 * (i / 16 + 0.4) / 8 - 2.5,
                     side = i % 2 ? -1 : 1;
        const double p[3] = {turned[0] * x + turned[2] * z + 0.1,
                             turned[3] * x + turned[5] * z + 7.3,
                             turned[6] * x + turned[8] * z - 4.7};
        const float normal[3] = {(float)(side * turned[1]), (float)(side * turned[4]),
                                 (float)(side * turned[7])};
        struct capture_probe probe;
        must(capture_probe(&b.path, &s, p, normal, &probe));
        worst = fmax(worst, fabs((double)probe.sh[0] / PI - 1));
    }
    printf("# extreme points of a surface: error %.4f %% at most\n", 100 * worst);
    ok(worst < 1e-5, "points of a surface: irradiance from all of the sky");
    bench_clear(&b);
    shape_clear(&square);
}

/* The border of a square, where half of the half space below is the square and half is open: 7/8 of
 * the light. Rays that pass the border nearer than floats can tell count as hits (no ray may slip
 * between two triangles), which widens the square by less than 1 %. */
static void test_on_border(void)
{
    const double half = 10, p[3] = {half, 0, -1.3};
    struct bench b;
    bench_start(&b);
    memcpy(b.settings.sky, (const double[3]){1, 1, 1}, sizeof b.settings.sky);
    add_floor(&b, half, 0, material(0.5f, 0));
    bench_finish(&b, 2);
    struct runs runs;
    runs_take(&runs, &b, settings_of(512, 2), p, 32);
    double mean[TRUTH_VALUES];
    runs_mean(&runs, mean);
    const double share = mean[0] / sqrt(4 * PI);
    printf("# extreme probe on the border of a wall: error %+.4f %%\n", 100 * (share / 0.875 - 1));
    bool finite = true;
    for (int k = 0; k < TRUTH_VALUES; k++)
        finite = finite && isfinite(mean[k]) && isfinite(runs.variance[k]);
    ok(finite && fabs(share / 0.875 - 1) < 0.01,
       "probe on the border of a wall: finite, and within 1 %% of the light that one above it has");
    bench_clear(&b);
}

/* -- how many triangles ----------------------------------------------------------------------- */

/* A square lamp, cut into 2 n^2 triangles. */
static void test_triangle_count(size_t n, const char *name)
{
    struct shape grid = shape_grid(0.6, n);
    struct bench b;
    shape_move(&grid, 0.3, 1, 0.2);
    bench_start(&b);
    add_shape(&b, &grid, material(0, 3));
    bench_finish(&b, 2);
    ok(scene_triangle_count(b.scene) == 2 * n * n, "%s: all %zu are kept", name, 2 * n * n);
    double truth[TRUTH_VALUES] = {0};
    const struct gauss g = gauss_rule(40);
    add_parallelogram(truth, (struct vec3){-0.3, 1, -0.4}, (struct vec3){1.2, 0, 0},
                      (struct vec3){0, 0, 1.2}, &g, (const double[3]){3, 6, 1.5});
    struct runs runs;
    runs_take(&runs, &b, settings_of(2048, 2), (const double[3]){0, 0, 0}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, name);
    bench_clear(&b);
    shape_clear(&grid);
}

/* A closed sphere of a million triangles, none of which lets light through. */
static void test_tight(void)
{
    struct shape sphere = shape_sphere(-1, 8);
    struct bench b;
    bench_start(&b);
    add_shape(&b, &sphere, material(0.5f, 1));
    bench_finish(&b, 64);
    double truth[TRUTH_VALUES] = {0};
    add_uniform(truth, (const double[3]){1 / 0.5, 2 / 0.75, 0.5 / 0.875});
    struct runs runs;
    runs_take(&runs, &b, settings_of(512, 64), (const double[3]){0.1, 0.2, 0.3}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, "closed sphere of 1310720 triangles");
    ok(runs.sky == 0, "closed sphere of 1310720 triangles: no ray escapes");
    bench_clear(&b);
    shape_clear(&sphere);
}

static void test_single(void)
{
    const double corner[9] = {-0.7, 1, -0.2, 0.9, 1.4, 0.1, 0.2, 0.8, 1.1}, rgb[3] = {3, 6, 1.5};
    const uint32_t index[3] = {0, 1, 2};
    const struct scene_material m = material(0.5f, 3);
    struct bench b;
    bench_start(&b);
    must(scene_add_mesh(b.scene, 3, corner, 1, index, &m));
    bench_finish(&b, 4);
    double truth[TRUTH_VALUES] = {0};
    const struct gauss g = gauss_rule(40);
    add_triangle(truth, vec3_load(corner), vec3_load(corner + 3), vec3_load(corner + 6), &g, rgb);
    struct runs runs;
    runs_take(&runs, &b, settings_of(1024, 4), (const double[3]){0, 0, 0}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, "one triangle");
    bench_clear(&b);
}

/* No triangle, with and without a sky. */
static void test_empty(void)
{
    struct bench b;
    struct runs runs;
    double truth[TRUTH_VALUES] = {0}, mean[TRUTH_VALUES];
    bench_start(&b);
    bench_finish(&b, 4);
    runs_take(&runs, &b, settings_of(64, 4), (const double[3]){1e7, 0, -1e-7}, 2);
    runs_mean(&runs, mean);
    ok(largest(mean, TRUTH_VALUES) == 0 && runs.sky == 1,
       "nothing at all: dark, and all rays escape");
    bench_clear(&b);
    bench_start(&b);
    memcpy(b.settings.sky, (const double[3]){1e8, 1, 1e-8}, sizeof b.settings.sky);
    bench_finish(&b, 4);
    add_uniform(truth, b.settings.sky);
    runs_take(&runs, &b, settings_of(64, 4), (const double[3]){1e7, 0, -1e-7}, 32);
    check_row(&runs, truth, RUNS_RESOLUTION, "no triangle, sky of 1e8, 1, 1e-8");
    runs_mean(&runs, mean);
    ok(fabs(mean[2] / truth[2] - 1) < 1e-5, "and its dim channel is there: %g", mean[2]);
    bench_clear(&b);
}

/* -- what cannot be held ---------------------------------------------------------------------- */

/* Captures one probe at x, 0.2, 0.3 in a box that shines so brightly, by way of a table. */
static struct error *capture_table(double x, float emission)
{
    struct bench b;
    struct table table;
    struct column *position;
    const struct capture_settings s = settings_of(64, 64);
    bench_start(&b);
    add_cube(&b, 1, material(0.5f, emission));
    bench_finish(&b, 64);
    must(table_init(&table, "probe"));
    must(table_add_column(&table, "position", COLUMN_F64, 3, &position));
    must(capture_add_columns(&s, &table));
    must(table_resize(&table, 1));
    memcpy(column_f64(table_column(&table, "position")), (const double[3]){x, 0.2, 0.3},
           sizeof(double[3]));
    struct capture_job job = {.path = &b.path, .settings = &s, .again = true, .threads = 1};
    struct error *err = capture_rows(&job, &table, 0, 1);
    table_clear(&table);
    bench_clear(&b);
    return err;
}

/* Light that overflows 32 bits on its way is refused, with what helps; so is a probe from where no
 * ray can come. */
static void test_refused(void)
{
    /* the lamps can be held, what they give the probe cannot */
    struct error *err = capture_table(0.1, 3e37f);
    ok(err && strstr(error_message(err), "probe 0") && strstr(error_message(err), "--light-scale"),
       "radiance of 3e37: %s", err ? error_message(err) : "not refused");
    error_destroy(err);
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1, material(0.5f, 1e38f));
    must(scene_finish(b.scene, &b.settings, NULL));
    must(trace_create(&b.tracer, b.scene));
    err = path_init(&b.path, b.tracer, 64);
    ok(err && strstr(error_message(err), "--light-scale"), "radiance of 1e38: %s",
       err ? error_message(err) : "not refused");
    error_destroy(err);
    bench_clear(&b);
    static const double far[] = {1e16, 1e19, 1e40, 1e300};
    for (int i = 0; i < 4; i++) {
        err = capture_table(far[i], 1);
        ok(err && strstr(error_message(err), "too far"), "a probe at %g: %s", far[i],
           err ? error_message(err) : "not refused");
        error_destroy(err);
    }
    err = capture_table(1e14, 1);
    ok(!err, "a probe at 1e14 is captured%s%s", err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
}

int main(void)
{
    static const double scales[] = {1e-6, 1e-3, 1, 1e3, 1e6}, offsets[] = {1e3, 1e5, 1e7};
    for (int i = 0; i < 5; i++)
        test_scale(scales[i], 0);
    for (int i = 0; i < 3; i++)
        test_scale(1, offsets[i]);
    test_scale(1e-6, 1e7);
    test_scale(1e6, 1e7);
    for (int exponent = 4; exponent <= 12; exponent += 2)
        test_small_emitter(pow(10, -exponent));
    test_small_lamp_bounce();
    test_contrast();
    test_white(0.9f, 4096, RUNS_RESOLUTION);
    test_white(0.99f, 1024, 0.006);
    test_white(0.999f, 128, 0.02);
    test_near_wall(1e-3, ALONE, "probe 1e-3 above a wall");
    test_near_wall(1e-7, ALONE, "probe 1e-7 above a wall");
    test_near_wall(-1e-7, ALONE, "probe 1e-7 below a wall");
    test_near_wall(1e-7, UNDER_ANOTHER, "probe 1e-7 above a wall off the middle");
    test_near_wall(-1e-7, UNDER_ANOTHER, "probe 1e-7 below a wall off the middle");
    test_near_wall(0, ALONE, "probe on a wall");
    test_near_wall(0, UNDER_ANOTHER, "probe on a wall off the middle");
    test_in_corner(0.3, -0.2, 1.1, "probe on a wall of a box");
    test_in_corner(0.3, -1.1, 1.1, "probe on an edge of a box");
    test_in_corner(1.1, -1.1, 1.1, "probe in a corner of a box");
    test_in_instance();
    test_shielded();
    test_surface_points();
    test_on_border();
    test_triangle_count(1, "2 triangles");
    test_triangle_count(708, "1002528 triangles");
    test_tight();
    test_single();
    test_empty();
    test_refused();
    return tap_done();
}
