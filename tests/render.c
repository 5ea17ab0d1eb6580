/* SPDX-License-Identifier: Apache-2.0 */
/* Rendered pictures against closed forms: furnaces, a floor under the sky, probes of known light, a
 * sphere in the sun; the truth's noise is what it says; overlays cover what they should; the same
 * bytes for any number of threads. */
#include "base/array.h"
#include "image/colour_map.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "render/camera.h"
#include "render/object.h"
#include "render/overlay.h"
#include "render/render.h"
#include "render/shot.h"
#include "render/view.h"
#include "scene/scene_build.h"
#include "stream/stream.h"
#include "support/capture_bench.h"

/* -- set-up ------------------------------------------------------------------------------------ */

static struct camera camera_at(double ex, double ey, double ez, double lx, double ly, double lz,
                               double fov, size_t width, size_t height)
{
    struct camera c;
    const struct vec3 eye = {ex, ey, ez}, at = {lx, ly, lz}, up = {0, 1, 0}, other = {0, 0, 1};
    const struct camera_view view = {.eye = eye,
                                     .look_at = at,
                                     .up = fabs(lx - ex) + fabs(lz - ez) > 0 ? up : other,
                                     .fov = fov,
                                     .width = width,
                                     .height = height};
    must(camera_init(&c, &view));
    return c;
}

static struct render render_of(const struct bench *b, const struct camera *camera, int samples)
{
    return (struct render){.path = &b->path,
                           .camera = camera,
                           .object = {.first = SIZE_MAX},
                           .samples = samples,
                           .samples_most = 1 << 16,
                           .threads = 2};
}

/* One cell about the origin whose probes hold light of this order: coefficient i of probe p is sh[3
 * * order^2 * p + i]. */
static struct stream *one_cell(double size, int order, const float *sh)
{
    static const double corner[12] = {-1, -1, -1, 3, -1, -1, -1, 3, -1, -1, -1, 3};
    struct stream *s = NULL;
    struct table *probes = NULL, *cells = NULL;
    struct column *c = NULL;
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &probes));
    must(table_add_column(probes, "position", COLUMN_F64, 3, &c));
    must(table_resize(probes, 4));
    for (size_t i = 0; i < 12; i++)
        column_f64(table_column(probes, "position"))[i] = size * corner[i];
    must(table_add_column(probes, "sh", COLUMN_F32, (size_t)(3 * order * order), &c));
    memcpy(c->data, sh, (size_t)(12 * order * order) * sizeof *sh);
    must(stream_add_table(s, "tet", &cells));
    must(table_add_column(cells, "vertex", COLUMN_I32, 4, &c));
    must(table_add_column(cells, "neighbour", COLUMN_I32, 4, &c));
    must(table_resize(cells, 1));
    for (int i = 0; i < 4; i++)
        column_i32(table_column(cells, "vertex"))[i] = i;
    return s;
}

/* The same light in all four probes. */
static struct stream *even_cell(double size, int order, const double *sh)
{
    float all[12 * SH_COUNT_MAX];
    const int width = 3 * order * order;
    for (int i = 0; i < 4 * width; i++)
        all[i] = (float)sh[i % width];
    return one_cell(size, order, all);
}

/* Largest distance of any value from a colour, relative to the colour. */
static double off(const struct picture *p, const double rgb[3])
{
    double worst = 0;
    for (size_t i = 0; i < 3 * p->width * p->height; i++)
        worst = fmax(worst, fabs((double)p->rgb[i] - rgb[i % 3]) / rgb[i % 3]);
    return worst;
}

/* -- cameras ----------------------------------------------------------------------------------- */

static void test_camera(void)
{
    const struct camera c = camera_at(1, 2, 3, 4, 4, 9, 50, 64, 48);
    double worst = 0, length = 0, x, y, depth;
    for (int i = 0; i < 100; i++) {
        const double px = 64 * (i % 10 + 0.3) / 10, py = 48 * (i / 10 + 0.6) / 10;
        const struct vec3 d = camera_direction(&c, px, py);
        length = fmax(length, fabs(vec3_length(d) - 1));
        camera_project(&c, vec3_fma(c.eye, 7, d), &x, &y, &depth);
        worst = fmax(worst, fmax(fabs(x - px), fabs(y - py)));
    }
    ok(length < 4e-16, "directions are unit vectors");
    ok(worst < 1e-11, "a direction leads to where it projects");
    ok(camera_project(&c, (struct vec3){4, 4, 9}, &x, &y, &depth) && fabs(x - 32) < 1e-12 &&
           fabs(y - 24) < 1e-12 && fabs(depth - 7) < 1e-12,
       "what is looked at is in the middle, at its distance");
    ok(!camera_project(&c, (struct vec3){-2, 0, -3}, &x, &y, &depth),
       "what is behind the eye is not in the picture");
    const struct vec3 top = camera_direction(&c, 32, 0), bottom = camera_direction(&c, 32, 48);
    ok(fabs(vec3_dot(top, bottom) - cos(50 * PI / 180)) < 1e-12 && top.y > bottom.y,
       "the picture's height is the angle of view, up is up");
    ok(vec3_dot(camera_direction(&c, 64, 24),
                vec3_cross((struct vec3){3, 2, 6}, (struct vec3){0, 1, 0})) > 0,
       "right is right");
    struct camera bad;
    const struct vec3 o = {0, 0, 0}, z = {0, 0, 1}, up = {0, 1, 0};
    const struct camera_view views[3] = {
        {o, o, up, 60, 1, 1}, {o, z, z, 60, 1, 1}, {o, z, up, 180, 1, 1}};
    struct error *err[3];
    for (int i = 0; i < 3; i++)
        err[i] = camera_init(&bad, &views[i]);
    for (int i = 0; i < 3; i++) {
        ok(err[i] && error_status(err[i]) == EXIT_BAD_USAGE, "refused: %s",
           err[i] ? error_message(err[i]) : "");
        error_destroy(err[i]);
    }
}

/* -- furnaces ---------------------------------------------------------------------------------- */

/* Within a closed box of albedo a that emits e, radiance is e / (1 - a) everywhere. */
static void test_furnace(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.5f, 1));
    bench_finish(&b, 64);
    const double truth[3] = {1 / 0.5, 2 / 0.75, 0.5 / 0.875};
    const struct camera camera = camera_at(0.3, -0.2, 0.4, 2, 1, 1.5, 90, 40, 30);
    struct render r = render_of(&b, &camera, 64);
    struct picture p, variance;
    must(render_picture(&r, RENDER_TRUTH, &p, &variance, NULL));
    double z_worst = 0, resolution = 0, chi = 0;
    for (size_t k = 0; k < 3; k++) {
        double mean = 0, of_mean = 0;
        for (size_t i = 0; i < 1200; i++) {
            const double d = (double)p.rgb[3 * i + k] - truth[k];
            mean += d / 1200;
            of_mean += (double)variance.rgb[3 * i + k] / 1200 / 1200;
            chi += d * d / (double)variance.rgb[3 * i + k] / 3600;
        }
        z_worst = fmax(z_worst, fabs(mean) / sqrt(of_mean));
        resolution = fmax(resolution, sqrt(of_mean) / truth[k]);
    }
    ok(z_worst < 5 && resolution < 0.002,
       "furnace: the truth is e / (1 - a) (%.2f standard errors of %.2f %%)", z_worst,
       100 * resolution);
    /* The mean of (error / standard error)^2 of 64 samples is 63/61 for normal ones; skewed ones
     * raise it a little. */
    ok(chi > 0.85 && chi < 1.25, "furnace: pixels are as far off as their variance says (%.3f)",
       chi);
    picture_clear(&p);
    picture_clear(&variance);

    double sh[3] = {0};
    for (int k = 0; k < 3; k++)
        sh[k] = truth[k] * sqrt(4 * PI);
    struct stream *s = even_cell(4, 1, sh);
    struct baked baked;
    must(baked_open(&baked, s, NULL));
    r.baked = &baked;
    r.samples = 2;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    ok(off(&p, truth) < 1e-6, "furnace: so it is by probes that hold it (%.1e)", off(&p, truth));
    picture_clear(&p);
    const double direct[3] = {1 + 0.5, 2 + 0.25 * 2, 0.5 + 0.125 * 0.5};
    r.samples = 256;
    must(render_picture(&r, RENDER_DIRECT, &p, &variance, NULL));
    double z = 0;
    for (size_t k = 0; k < 3; k++) {
        double mean = 0, of_mean = 0;
        for (size_t i = 0; i < 1200; i++) {
            mean += ((double)p.rgb[3 * i + k] - direct[k]) / 1200;
            of_mean += (double)variance.rgb[3 * i + k] / 1200 / 1200;
        }
        z = fmax(z, fabs(mean) / sqrt(of_mean));
    }
    ok(z < 5, "furnace: direct light alone is e (1 + a) (%.2f standard errors)", z);
    picture_clear(&p);
    picture_clear(&variance);
    baked_close(&baked);
    stream_destroy(s);
    bench_clear(&b);
}

/* -- a floor under the sky --------------------------------------------------------------------- */

static void test_floor(void)
{
    struct bench b;
    bench_start(&b);
    b.settings.sky[0] = 1;
    b.settings.sky[1] = 2;
    b.settings.sky[2] = 3;
    add_floor(&b, 1, 0, material(0.6f, 0));
    bench_finish(&b, 8);
    const double truth[3] = {0.6, 0.3 * 2, 0.15 * 3};
    const struct camera camera = camera_at(0, 1, 0, 0, 0, 0, 40, 24, 16);
    struct render r = render_of(&b, &camera, 4);
    struct picture p;
    must(render_picture(&r, RENDER_TRUTH, &p, NULL, NULL));
    ok(off(&p, truth) < 1e-6,
       "a floor under an even sky: albedo times its radiance, without noise (%.1e)",
       off(&p, truth));
    picture_clear(&p);
    must(render_picture(&r, RENDER_DIRECT, &p, NULL, NULL));
    ok(off(&p, truth) < 1e-6, "and all of it is direct light");
    picture_clear(&p);
    /* The sky's half of directions: band 0 and 1; all even bands above are 0, and so is A_3. */
    double sh[27] = {0};
    for (int k = 0; k < 3; k++) {
        sh[k] = (k + 1) * sqrt(PI);            /* 2 pi Y_00 */
        sh[3 + k] = (k + 1) * sqrt(0.75 * PI); /* pi sqrt(3 / 4 pi), of y */
    }
    struct stream *s = even_cell(2, 3, sh);
    struct baked baked;
    must(baked_open(&baked, s, NULL));
    r.baked = &baked;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    ok(off(&p, truth) < 1e-6, "by probes that hold that sky: the same (%.1e)", off(&p, truth));
    picture_clear(&p);
    must(render_picture(&r, RENDER_MIXED, &p, NULL, NULL));
    const double twice[3] = {2 * truth[0], 2 * truth[1], 2 * truth[2]};
    ok(off(&p, twice) < 1e-6, "mixed: direct light and what the probes hold add up");
    picture_clear(&p);
    baked_close(&baked);
    must(header_set_key(&s->header, "sh-content", "irradiance"));
    must(baked_open(&baked, s, NULL));
    double rgb[3];
    struct probe_place place = {.cell = PROBE_COLD};
    baked_irradiance(&baked, &place, (const double[3]){0, 0.1, 0}, (const double[3]){0, 1, 0}, rgb);
    ok(fabs(rgb[0] - (0.5 + 0.75)) < 1e-6, "a stream of irradiance is not convolved again");
    baked_irradiance(&baked, &place, (const double[3]){0, 0.1, 0}, (const double[3]){0, -1, 0},
                     rgb);
    ok(rgb[0] == 0, "and what is below 0 is 0");
    /* Camera rays that meet nothing */
    const struct camera up = camera_at(0, 1, 0, 0, 2, 0.1, 40, 8, 8);
    r.camera = &up;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    ok(off(&p, (const double[3]){1, 2, 3}) < 1e-6, "beyond all surfaces is the sky");
    picture_clear(&p);
    const struct camera far = camera_at(0, 1e12, 0, 0, 0, 0, 40, 8, 8);
    r.camera = &far;
    struct error *err = render_picture(&r, RENDER_TRUTH, &p, NULL, NULL);
    ok(err && strstr(error_message(err), "farther out"), "an eye beyond all measure is refused");
    error_destroy(err);
    picture_clear(&p);
    const struct camera away = camera_at(0, 1e6, 0, 0, 0, 0, 1e-4, 8, 8);
    r.camera = &away;
    must(render_picture(&r, RENDER_TRUTH, &p, NULL, NULL));
    ok(off(&p, truth) < 1e-6, "one that is far away sees the floor all the same");
    picture_clear(&p);
    baked_close(&baked);
    stream_destroy(s);
    bench_clear(&b);
}

/* Probes in a plane, with light that rises along x, over a floor: each pixel has the light of the
 * place below which it is. */
static void test_plane(void)
{
    static const double corner[9] = {-5, 0.5, -5, 15, 0.5, -5, -5, 0.5, 15};
    struct bench b;
    bench_start(&b);
    add_floor(&b, 1, 0, material(0.6f, 0));
    bench_finish(&b, 8);
    struct stream *s = NULL;
    struct table *probes = NULL, *cells = NULL;
    struct column *c = NULL;
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &probes));
    must(table_resize(probes, 3));
    must(table_add_column(probes, "position", COLUMN_F64, 3, &c));
    memcpy(c->data, corner, sizeof corner);
    must(table_add_column(probes, "sh", COLUMN_F32, 3, &c));
    for (size_t i = 0; i < 9; i++)
        column_f32(c)[i] = (float)(corner[i / 3 * 3] + 10);
    must(stream_add_table(s, "tri", &cells));
    must(table_resize(cells, 1));
    must(table_add_column(cells, "vertex", COLUMN_I32, 3, &c));
    for (int i = 0; i < 3; i++)
        column_i32(c)[i] = i;
    must(table_add_column(cells, "neighbour", COLUMN_I32, 3, NULL));
    const struct camera camera = camera_at(0, 1, 0, 0, 0, 0, 40, 24, 16);
    struct render r = render_of(&b, &camera, 4);
    struct baked baked;
    struct picture p;
    must(baked_open(&baked, s, NULL));
    must(baked_complete(&baked));
    r.baked = &baked;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    size_t right = 0;
    double spread = 0;
    for (size_t i = 0; i < 24 * 16; i++) {
        double end[2];
        for (int side = 0; side < 2; side++) {
            const struct vec3 d =
                camera_direction(&camera, (double)(i % 24) + side, (double)(i / 24) + 0.5);
            /* albedo Y_00 (x + 10) where the ray meets the floor */
            end[side] = 0.6 * sqrt(1 / (4 * PI)) * (10 - d.x / d.y);
        }
        const double light = (double)p.rgb[3 * i];
        right += light >= fmin(end[0], end[1]) - 1e-6 && light <= fmax(end[0], end[1]) + 1e-6;
        spread = fmax(spread, light / (0.6 * sqrt(1 / (4 * PI)) * 10) - 1);
    }
    ok(right == 24 * 16 && spread > 0.04,
       "by probes in a plane: each pixel is as bright as the plane above it (%zu)", right);
    picture_clear(&p);
    double spacing = 0;
    must(overlay_spacing(s, &spacing));
    ok(spacing == 20, "the median of a triangle's sides is their distance (%g)", spacing);
    struct overlay o = {0};
    must(overlay_init(&o, &r, s, &baked, &(struct overlay_settings){.cells = true}));
    overlay_clear(&o);
    baked_close(&baked);
    column_f32(table_column(stream_table(s, "probe"), "sh"))[6] = NAN;
    must(baked_open(&baked, s, NULL));
    struct error *err = baked_complete(&baked);
    ok(err && strstr(error_message(err), "probe 2 has no light"), "a probe without light is told");
    error_destroy(err);
    baked_close(&baked);
    stream_destroy(s);
    bench_clear(&b);
}

/* -- objects ----------------------------------------------------------------------------------- */

/* Irradiance from a sun of irradiance 1 from `from`, of order 3, at n. */
static double sun_irradiance(const double from[3], const double n[3])
{
    double y[9], at[9], sum = 0;
    sh_basis(3, from, y);
    sh_basis(3, n, at);
    for (int l = 0, i = 0; l < 3; l++)
        for (; i < (l + 1) * (l + 1); i++)
            sum += sh_cosine(l) * y[i] * at[i];
    return fmax(sum, 0);
}

/* What the middle pixels of a sphere in the sun show, against the same rays met with a sphere by
 * hand. */
static void test_sphere(void)
{
    struct bench b;
    bench_start(&b);
    add_floor(&b, 1e-3, -50, material(0.5f, 0)); /* a scene is never empty */
    must(scene_finish(b.scene, &b.settings, NULL));
    struct object object;
    must(object_init(&object, b.scene, "sphere", false, 0.5, NULL));
    const struct vec3 centre = {0.1, 0.2, -0.1};
    object_place(&object, centre);
    must(trace_create(&b.tracer, b.scene));
    must(path_init(&b.path, b.tracer, 8));
    double sun[3] = {0.48, 0.6, 0.64}, y[9], sh[27];
    sh_basis(3, sun, y);
    for (int i = 0; i < 27; i++)
        sh[i] = y[i / 3] * (i % 3 + 1);
    struct stream *s = even_cell(5, 3, sh);
    struct baked baked;
    must(baked_open(&baked, s, NULL));
    const struct camera camera = camera_at(0.1, 0.4, 3, 0.1, 0.2, -0.1, 25, 24, 24);
    struct render r = render_of(&b, &camera, 256);
    r.baked = &baked;
    r.object = object_at(&object, centre, false);
    struct picture p;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    double worst = 0, most = 0;
    for (size_t py = 6; py < 18; py++)
        for (size_t px = 6; px < 18; px++) {
            double sum = 0;
            for (int i = 0; i < 64; i++) {
                const struct vec3 d = camera_direction(&camera, (double)px + (i % 8 + 0.5) / 8,
                                                       (double)py + (i / 8 + 0.5) / 8);
                const struct vec3 way = vec3_sub(centre, camera.eye);
                const double along = vec3_dot(way, d),
                             under = 0.25 - (vec3_dot(way, way) - along * along);
                double n[3];
                vec3_store(
                    n, vec3_scale(2, vec3_sub(vec3_fma(camera.eye, along - sqrt(fmax(under, 0)), d),
                                              centre)));
                sum += 0.8 / PI * sun_irradiance(sun, n) / 64;
            }
            const struct vec3f c = picture_get(&p, px, py);
            worst = fmax(worst, fmax(fabs((double)c.x - sum), fabs((double)c.z / 3 - sum)));
            most = fmax(most, sum);
        }
    ok(most > 0.2 && worst < 0.005 * most,
       "a sphere in the sun, by probes: the irradiance formula at its normals (%.2f %%)",
       100 * worst / most);
    picture_clear(&p);

    /* By its centre, or at each pixel: light that rises along x. */
    float rising[48] = {0};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            /* x + 10 at the probes of size 5 */
            rising[12 * i + k] = (float)((i == 1 ? 15.0 : -5.0) + 10);
    struct stream *linear = one_cell(5, 2, rising);
    struct baked by_place;
    must(baked_open(&by_place, linear, NULL));
    r.baked = &by_place;
    r.samples = 64;
    /* pi Y_00 (x + 10) albedo / pi */
    const double e = sqrt(PI) / 2 * (0.1 + 10) * 0.8 / PI, all[3] = {e, e, e};
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    const struct picture middle = {24, 1, p.rgb + 3 * 24 * 12};
    const struct vec3f left = picture_get(&p, 8, 12), right = picture_get(&p, 15, 12);
    ok(fabs((double)left.x - all[0]) < 1e-5 && left.x == right.x && middle.rgb[3 * 12] == left.x,
       "an object has the light of its centre");
    picture_clear(&p);
    r.object.per_pixel = true;
    must(render_picture(&r, RENDER_PROBES, &p, NULL, NULL));
    const double slope = (double)(picture_get(&p, 15, 12).x - picture_get(&p, 8, 12).x) /
                         (double)left.x * 10.1;
    ok(slope > 0.3 && slope < 0.45,
       "or, per pixel, that of each point (it rises by %.3f of 7 pixels' 0.37)", slope);
    picture_clear(&p);

    baked_close(&by_place);
    stream_destroy(linear);
    baked_close(&baked);
    stream_destroy(s);
    object_clear(&object);
    bench_clear(&b);
}

/* Path traced, a convex thing under an even sky is albedo times it, wherever it stands. */
static void test_moving(void)
{
    struct bench b;
    bench_start(&b);
    for (int k = 0; k < 3; k++)
        b.settings.sky[k] = 1;
    add_floor(&b, 1e-3, -50, material(0.5f, 0));
    must(scene_finish(b.scene, &b.settings, NULL));
    struct object object;
    must(object_init(&object, b.scene, "sphere", false, 0.5, NULL));
    const struct camera camera = camera_at(3, 0.2, 4, 3, 0.2, 0, 10, 8, 8);
    struct render r = render_of(&b, &camera, 4);
    for (int there = 0; there < 2; there++) {
        struct picture p;
        object_place(&object, (struct vec3){there ? 3 : 0, 0.2, 0});
        must(trace_create(&b.tracer, b.scene));
        must(path_init(&b.path, b.tracer, 8));
        must(render_picture(&r, RENDER_TRUTH, &p, NULL, NULL));
        const double rgb = there ? (double)0.8f : 1, all[3] = {rgb, rgb, rgb};
        ok(off(&p, all) < 1e-5,
           there ? "a white sphere under the sky: 0.8 of it" : "before it comes: the sky");
        picture_clear(&p);
        path_clear(&b.path);
        trace_destroy(b.tracer);
        b.tracer = NULL;
    }
    object_clear(&object);
    bench_clear(&b);
}

/* -- threads, noise ---------------------------------------------------------------------------- */

static void test_lamp(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.5f, 0));
    add_floor(&b, 0.3, 1.5, material(0, 10));
    bench_finish(&b, 16);
    const struct camera camera = camera_at(-1.5, 0, -1.5, 1, -0.5, 1, 70, 50, 37);
    struct render r = render_of(&b, &camera, 8);
    struct picture p[3], variance[3];
    for (int i = 0; i < 2; i++) {
        r.threads = 1 + i;
        must(render_picture(&r, RENDER_TRUTH, &p[i], &variance[i], NULL));
    }
    const size_t bytes = 3 * 50 * 37 * sizeof(float);
    ok(!memcmp(p[0].rgb, p[1].rgb, bytes) && !memcmp(variance[0].rgb, variance[1].rgb, bytes),
       "1 and 2 threads give the same bytes");
    r.seed = 1;
    must(render_picture(&r, RENDER_TRUTH, &p[2], NULL, NULL));
    double apart = 0, expected = 0;
    for (size_t i = 0; i < 3 * 50 * 37; i++) {
        apart += pow((double)p[0].rgb[i] - (double)p[2].rgb[i], 2);
        expected += 2 * (double)variance[0].rgb[i];
    }
    ok(apart > 0.7 * expected && apart < 1.4 * expected,
       "another seed is another picture, as far off as the variance says (%.2f)", apart / expected);
    for (int i = 0; i < 3; i++)
        picture_clear(&p[i]);
    picture_clear(&variance[0]);
    picture_clear(&variance[1]);
    r.error = 0.1;
    r.samples_most = 4096;
    for (int i = 0; i < 2; i++) {
        r.threads = 1 + i;
        must(render_picture(&r, RENDER_TRUTH, &p[i], &variance[i], NULL));
    }
    ok(!memcmp(p[0].rgb, p[1].rgb, bytes), "and so do rounds until the error is small");
    double share = 0, level = 0;
    for (size_t i = 0; i < 50 * 37; i++) {
        const struct vec3f c = picture_get(&p[0], i % 50, i / 50);
        level += (double)luminance_vec3f(c);
        share += sqrt((double)variance[0].rgb[3 * i + 1]) / (double)c.y / (50 * 37);
    }
    ok(share > 0.03 && share < 0.11, "whose standard error is as asked for: %.3f of 0.1", share);
    ok(level > 0, "there is light");
    for (int i = 0; i < 2; i++) {
        picture_clear(&p[i]);
        picture_clear(&variance[i]);
    }
    struct vec3 eye, at, again, at_again;
    must(view_choose(&b.path, 60, 1.5, &eye, &at));
    must(view_choose(&b.path, 60, 1.5, &again, &at_again));
    ok(fmax(fabs(eye.x), fmax(fabs(eye.y), fabs(eye.z))) < 2, "a closed room is seen from within");
    ok(!memcmp(&eye, &again, sizeof eye) && !memcmp(&at, &at_again, sizeof at),
       "the same view every time");
    bench_clear(&b);
}

/* A box without its front is seen through that side. */
static void test_open_box(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1, material(0.5f, 0.1f));
    b.scene->meshes[0].triangle_count = 10; /* the last quad, z = 1, goes */
    bench_finish(&b, 4);
    struct vec3 eye, at;
    must(view_choose(&b.path, 45, 1, &eye, &at));
    ok(eye.z > 0 && at.z < eye.z, "an open box is seen through its open side (%.2f %.2f %.2f)",
       eye.x, eye.y, eye.z);
    bench_clear(&b);
}

/* A floor is seen from above, and the way up can be told. */
static void test_floor_view(void)
{
    struct bench b;
    bench_start(&b);
    add_quad(&b, (const double[12]){0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 0}, material(0.5f, 0.1f));
    bench_finish(&b, 4);
    struct vec3 eye, at;
    must(view_choose(&b.path, 60, 1.5, &eye, &at));
    ok(eye.y > 0 && hypot(at.x - eye.x, at.z - eye.z) > 0.001,
       "a floor is seen from above, and not straight down (%g %g %g)", at.x - eye.x, at.y - eye.y,
       at.z - eye.z);
    bench_clear(&b);
}

/* -- overlays ---------------------------------------------------------------------------------- */

static double covered(const struct overlay *o, int what)
{
    double sum = 0;
    for (size_t i = 0; i < o->share.width * o->share.height; i++)
        sum += (double)o->share.rgb[3 * i + (size_t)what];
    return sum;
}

static void test_overlay(void)
{
    struct bench b;
    bench_start(&b);
    /* a wall before the right half */
    add_quad(&b, (const double[12]){0, -9, -5, 9, -9, -5, 9, 9, -5, 0, 9, -5}, material(0.5f, 0));
    bench_finish(&b, 4);
    double sh[3] = {1, 2, 3};
    struct stream *s = even_cell(1, 1, sh);
    double *position = column_f64(table_column(stream_table(s, "probe"), "position"));
    /* two left, one behind the wall, one behind the eye */
    const double place[12] = {-1, 0, -10, 1, 0, -10, -1, 2, -10, -1, 0, 10};
    memcpy(position, place, sizeof place);
    struct baked baked;
    must(baked_open_probes(&baked, s));
    const struct camera camera = camera_at(0, 0, 0, 0, 0, -1, 45, 320, 200);
    struct render r = render_of(&b, &camera, 1);
    struct overlay o = {0};
    must(overlay_init(&o, &r, s, &baked, &(struct overlay_settings){.probe_radius = 0.5}));
    /* A sphere's outline is a cone; a plane at distance 1 cuts it in an ellipse of half axes tan(a)
     * and sin-like width: by counting rays. */
    double count = 0;
    for (size_t py = 0; py < 200 * 4; py++)
        for (size_t px = 0; px < 160 * 4; px++) {
            const struct vec3 d =
                camera_direction(&camera, ((double)px + 0.5) / 4, ((double)py + 0.5) / 4);
            for (int i = 0; i < 3; i += 2) {
                const struct vec3 way = vec3_load(place + 3 * i);
                const double along = vec3_dot(way, d);
                count += vec3_dot(way, way) - along * along < 0.25 ? 1.0 / 16 : 0;
            }
        }
    ok(count > 400 && fabs(covered(&o, 0) - count) < 1e-3 * count,
       "spheres cover what they should, and none behind a wall (%.1f of %.1f pixels)",
       covered(&o, 0), count);
    double x, y, depth;
    camera_project(&camera, vec3_load(place), &x, &y, &depth);
    const struct vec3f light = picture_get(&o.light, (size_t)x, (size_t)y);
    ok(fabs((double)light.x - sqrt(1 / (4 * PI))) < 1e-6 &&
           fabs((double)light.z - 3 * sqrt(1 / (4 * PI))) < 1e-6,
       "a sphere's light is E / pi of its probe");
    overlay_clear(&o);
    /* at a fortieth of the distances the radius is a half of one; areas go as its square */
    must(overlay_init(&o, &r, s, &baked,
                      &(struct overlay_settings){.probe_radius = 0.5, .probe_share = 0.025}));
    ok(fabs(covered(&o, 0) - count / 4) < 0.05 * count,
       "no sphere is larger than a share of its distance (%.1f of %.1f pixels)", covered(&o, 0),
       count / 4);
    overlay_clear(&o);
    must(overlay_init(&o, &r, s, NULL, &(struct overlay_settings){.cells = true}));
    /* Left of the wall: the edge from (-1, 0) to (-1, 2), half of that from (-1, 0) to (1, 0), half
     * of the diagonal, and what comes from behind. */
    double column = 0;
    for (size_t row = 70; row < 95; row++)
        for (size_t px = (size_t)x - 3; px <= (size_t)x + 3; px++)
            column += (double)o.share.rgb[3 * (row * 320 + px) + 1];
    ok(fabs(column - 25 * 0.5) < 2, "an edge is a line of one pixel, half opaque (%.2f of 12.5)",
       column);
    double right = 0;
    for (size_t i = 0; i < 320 * 200; i++)
        right += i % 320 > 170 && i / 320 > 92 && i / 320 < 98 ? (double)o.share.rgb[3 * i + 1] : 0;
    ok(right == 0, "and none goes through a wall");
    overlay_clear(&o);
    baked_close(&baked);
    stream_destroy(s);
    bench_clear(&b);
}

/* -- shots ------------------------------------------------------------------------------------- */

static void test_difference(void)
{
    struct picture truth, test;
    must(picture_init(&truth, 60, 200));
    must(picture_init(&test, 60, 200));
    for (size_t i = 0; i < 12000; i++) { /* L* of 50 and 60; a quarter of it each way */
        const float fifty = 0.18418651851f, sixty = 0.28123332748f;
        const size_t x = i % 60, y = i / 60;
        const float t = x < 30 ? fifty : sixty, q = y < 100 ? t : x < 30 ? sixty : fifty;
        picture_set(&truth, x, y, (struct vec3f){t, t, t});
        picture_set(&test, x, y, (struct vec3f){q, q, q});
    }
    struct shot shot = {0};
    struct shot_settings settings = {
        .mode = SHOT_DIFFERENCE, .truth = RENDER_TRUTH, .test = RENDER_PROBES, .exposure = 1};
    must(shot_compose(&shot, &truth, NULL, &test, &settings, 1));
    const struct vec3f even = picture_get(&shot.shown, 5, 5),
                       bright = picture_get(&shot.shown, 20, 110),
                       dark = picture_get(&shot.shown, 50, 110);
    const struct vec3f grey = colour_map_at(COLOUR_COOL_WARM, 0.5),
                       red = colour_map_at(COLOUR_COOL_WARM, 1),
                       blue = colour_map_at(COLOUR_COOL_WARM, 0);
    ok(shot.scale == 10, "differences of 10 L* are shown on a scale of 10 (%g)", shot.scale);
    ok(vec3f_length(vec3f_sub(even, grey)) < 1e-3f &&
           vec3f_length(vec3f_sub(bright, red)) < 1e-3f &&
           vec3f_length(vec3f_sub(dark, blue)) < 1e-3f,
       "alike is grey, too bright red, too dark blue");
    ok(fabsf(picture_get(&shot.linear, 20, 110).y - 0.09704680897f) < 1e-6f,
       "the linear picture is the difference of radiance");
    shot_clear(&shot);
    settings.scale = 40;
    must(shot_compose(&shot, &truth, NULL, &test, &settings, 1));
    ok(shot.scale == 40 && vec3f_length(vec3f_sub(picture_get(&shot.shown, 20, 110),
                                                  colour_map_at(COLOUR_COOL_WARM, 0.625))) < 1e-3f,
       "or on that which is asked for");
    shot_clear(&shot);
    settings.mode = SHOT_PAIR;
    must(shot_compose(&shot, &truth, NULL, &test, &settings, 1));
    ok(shot.linear.width == 120 &&
           picture_get(&shot.linear, 80, 110).x == picture_get(&test, 20, 110).x,
       "a pair is both, side by side");
    shot_clear(&shot);
    settings.mode = SHOT_SPLIT;
    must(shot_compose(&shot, &truth, NULL, &test, &settings, 1));
    ok(picture_get(&shot.linear, 29, 50).x == picture_get(&truth, 29, 50).x &&
           picture_get(&shot.linear, 30, 50).x == picture_get(&test, 30, 50).x,
       "a split picture is the truth on the left");
    shot_clear(&shot);
    picture_clear(&truth);
    picture_clear(&test);
}

int main(void)
{
    test_camera();
    test_furnace();
    test_floor();
    test_plane();
    test_sphere();
    test_moving();
    test_lamp();
    test_open_box();
    test_floor_view();
    test_overlay();
    test_difference();
    return tap_done();
}
