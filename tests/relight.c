/* SPDX-License-Identifier: Apache-2.0 */
/* What relighting rests on: the bands of a sky's picture, against a sum over many directions; suns
 * between suns; and the error of a weighted sum of parts whose errors know of each other. */
#include "relight/relight.h"
#include "base/warning.h"
#include "math/direction.h"
#include "math/eigen.h"
#include "relight/lamp_blend.h"
#include "relight/pca.h"
#include "relight/sky_bands.h"
#include "relight/sun_blend.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "stream/stream.h"
#include "support/sh_light.h"

#include <string.h>

/* -- a sky ------------------------------------------------------------------------------------- */

enum { WIDE = 16, HIGH = 8 };

static void set_axes(struct scene_sky *sky)
{
    double d[3], e[3];
    draw_direction(d);
    draw_direction(e);
    sky->turned = true;
    sky->up = vec3_load(d);
    sky->front = vec3_normalize(vec3_cross(sky->up, vec3_load(e)));
    sky->right = vec3_cross(sky->front, sky->up);
}

/* The largest difference from a sum over directions, as a share of the largest. */
static double off_sum(const struct scene *scene, int order)
{
    enum { DIRECTIONS = 200000 };
    double sum[3 * SH_COUNT_MAX] = {0}, c[3 * SH_COUNT_MAX], worst = 0, most = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        const struct vec3 d = direction_even(i, DIRECTIONS);
        const struct vec3f to = {(float)d.x, (float)d.y, (float)d.z},
                           rgb = scene_sky_radiance(scene, to);
        double y[SH_COUNT_MAX];
        sh_basis(order, (const double[3]){d.x, d.y, d.z}, y);
        sh_project(order, y, (const double[3]){(double)rgb.x, (double)rgb.y, (double)rgb.z},
                   4 * PI / DIRECTIONS, sum);
    }
    must(sky_bands(&scene->sky, order, c));
    for (int i = 0; i < 3 * order * order; i++) {
        worst = fmax(worst, fabs(c[i] - sum[i]));
        most = fmax(most, fabs(sum[i]));
    }
    return worst / most;
}

static void test_sky(void)
{
    float texel[3 * WIDE * HIGH];
    struct scene_texture picture = {
        .width = WIDE, .height = HIGH, .channels = 3, .texels = texel, .wrap_v = SCENE_CLAMP};
    struct scene scene = {.sky = {.radiance = {1, 2, 3}, .picture = &picture}};
    for (int i = 0; i < 3 * WIDE * HIGH; i++)
        texel[i] = (float)draw();
    const double plain = off_sum(&scene, 5);
    set_axes(&scene.sky);
    const double turned = off_sum(&scene, 5);
    ok(plain < 1e-4, "the bands of a picture are its sum over directions: %.1e", plain);
    ok(turned < 1e-4, "and where it is turned: %.1e", turned);
    /* one texel of many */
    memset(texel, 0, sizeof texel);
    texel[3 * (2 * WIDE + 5)] = 1;
    const double one = off_sum(&scene, 5);
    ok(one < 2e-4, "one bright texel: %.1e", one);
    double c[3];
    scene.sky.picture = NULL;
    must(sky_bands(&scene.sky, 1, c));
    ok(fabs(c[1] - 2 * sqrt(4 * PI)) < 1e-12, "a sky of one colour: sqrt(4 pi) times that");
}

/* -- suns -------------------------------------------------------------------------------------- */

static double sum_of(const double *weight, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += weight[i];
    return sum;
}

/* Whether no sun is beyond the plane through the three that have weight. */
static bool is_facet(int count, const double *sun, const double *weight)
{
    struct vec3 at[3];
    int found = 0;
    for (int i = 0; i < count; i++)
        if (weight[i] > 1e-9 && found < 3)
            at[found++] = vec3_load(sun + 3 * i);
    if (found < 3)
        return true;
    const struct vec3 n = vec3_cross(vec3_sub(at[1], at[0]), vec3_sub(at[2], at[0]));
    const double height = vec3_dot(n, at[0]), side = height < 0 ? -1 : 1;
    bool none = true;
    for (int i = 0; i < count; i++)
        none = none && side * (vec3_dot(n, vec3_load(sun + 3 * i)) - height) < 1e-9;
    return none;
}

static void test_suns(void)
{
    /* a day at some latitude: a small circle */
    enum { SUNS = 9 };
    double sun[3 * SUNS], weight[SUNS];
    for (int i = 0; i < SUNS; i++) {
        const double a = PI * i / (SUNS - 1), lean = 0.5;
        sun[3 * i] = cos(a);
        sun[3 * i + 1] = sin(a) * cos(lean);
        sun[3 * i + 2] = sin(a) * sin(lean);
    }
    bool sums = true, near = true, linear = true;
    double off = 0;
    for (int k = 0; k < 200; k++) {
        const double at = (SUNS - 1) * draw(), a = PI * at / (SUNS - 1), lean = 0.5;
        const double d[3] = {cos(a), sin(a) * cos(lean), sin(a) * sin(lean)};
        off = fmax(off, sun_blend(SUN_PATH, SUNS, sun, d, weight));
        sums = sums && fabs(sum_of(weight, SUNS) - 1) < 1e-12;
        for (int i = 0; i < SUNS; i++)
            linear = linear && fabs(weight[i] - fmax(0, 1 - fabs(at - i))) < 1e-9;
    }
    ok(sums && linear && off < 1e-6, "along a way, weights are linear in the angle");
    for (int k = 0; k < 500; k++) {
        double d[3], away = 180;
        draw_direction(d);
        const double is = sun_blend(SUN_PATH, SUNS, sun, d, weight);
        for (int i = 0; i <= 4000; i++) {
            const double a = PI * i / 4000, lean = 0.5,
                         dot = d[0] * cos(a) + sin(a) * (d[1] * cos(lean) + d[2] * sin(lean));
            away = fmin(away, acos(fmin(dot, 1)) * 180 / PI);
        }
        near = near && fabs(is - away) < 0.05;
    }
    ok(near, "elsewhere, of the nearest point of it");

    enum { MANY = 40 };
    double all[3 * MANY], blend[MANY], worst = 0, least = 0, inside = 0, jump = 0;
    bool one = true, farthest = true;
    for (int i = 0; i < MANY; i++)
        draw_direction(all + 3 * i);
    for (int k = 0; k < 200; k++) {
        double d[3], sum[3] = {0}, e[3], next[MANY];
        draw_direction(d);
        inside = fmax(inside, sun_blend(SUN_SPHERE, MANY, all, d, blend));
        for (int i = 0; i < MANY; i++) {
            least = fmin(least, blend[i]);
            for (int c = 0; c < 3; c++)
                sum[c] += blend[i] * all[3 * i + c];
        }
        const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs(sum[c] / length - d[c]));
        sums = sums && fabs(sum_of(blend, MANY) - 1) < 1e-12;
        farthest = farthest && is_facet(MANY, all, blend);
        for (int c = 0; c < 3; c++)
            e[c] = d[c] + 1e-6 * all[3 * (k % MANY) + c];
        const double size = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
        for (int c = 0; c < 3; c++)
            e[c] /= size;
        sun_blend(SUN_SPHERE, MANY, all, e, next);
        for (int i = 0; i < MANY; i++)
            jump = fmax(jump, fabs(next[i] - blend[i]));
    }
    for (int i = 0; i < MANY; i++) {
        sun_blend(SUN_SPHERE, MANY, all, all + 3 * i, blend);
        one = one && fabs(blend[i] - 1) < 1e-9;
    }
    ok(inside == 0 && sums && least >= 0 && worst < 1e-9,
       "on the sphere, weights of three, none below 0, blend the suns to the direction");
    ok(farthest, "of a triangle beyond whose plane there is no sun: Delaunay's");
    ok(jump < 1e-4, "a little farther, they are a little different: %.1e", jump);
    ok(one, "at a sun, it alone");
    const double upright[6] = {0, 1, 0, 1, 0, 0};
    ok(fabs(sun_blend(SUN_SPHERE, 1, upright, (const double[3]){1, 0, 0}, weight) - 90) < 1e-9 &&
           weight[0] == 1,
       "of one sun all is its own, however far off");
    ok(fabs(sun_blend(SUN_SPHERE, 2, upright, (const double[3]){0.6, 0.8, 0}, weight)) < 1e-9 &&
           fabs(weight[0] + weight[1] - 1) < 1e-12 && weight[1] > 0.3 && weight[1] < 0.5,
       "of two, the way between them");
}

/* -- lamps ------------------------------------------------------------------------------------- */

enum { LAMPS = 60 };

/* Whether no lamp stands within the sphere through four others: Delaunay's condition. corner: of
 * weights above 0. */
static bool is_empty(size_t count, const double *at, const size_t corner[4])
{
    struct vec3 e[3];
    double half[3];
    const struct vec3 o = vec3_load(at + 3 * corner[0]);
    for (int k = 0; k < 3; k++) {
        e[k] = vec3_sub(vec3_load(at + 3 * corner[k + 1]), o);
        half[k] = vec3_dot(e[k], e[k]) / 2;
    }
    const double volume = vec3_dot(e[0], vec3_cross(e[1], e[2]));
    struct vec3 centre = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        centre = vec3_fma(centre, half[k] / volume, vec3_cross(e[(k + 1) % 3], e[(k + 2) % 3]));
    const double radius = vec3_length(centre);
    for (size_t i = 0; i < count; i++)
        if (vec3_length(vec3_sub(vec3_sub(vec3_load(at + 3 * i), o), centre)) < radius * (1 - 1e-9))
            return false;
    return true;
}

/* What the weights give of the lamps' positions: how far it is off p. */
static double off_place(size_t count, const double *at, const double *weight, struct vec3 p)
{
    struct vec3 sum = {0, 0, 0};
    double all = 0;
    for (size_t i = 0; i < count; i++) {
        all += weight[i];
        sum = vec3_fma(sum, weight[i], vec3_load(at + 3 * i));
        if (weight[i] < 0)
            return (double)INFINITY;
    }
    return vec3_length(vec3_sub(sum, p)) + fabs(all - 1);
}

/* The distance of the nearest point to p among many of the hull: not below the least. */
static double nearest_drawn(size_t count, const double *at, struct vec3 p)
{
    double least = (double)INFINITY;
    for (int t = 0; t < 20000; t++) {
        struct vec3 x = {0, 0, 0};
        double share[4], all = 0;
        for (int k = 0; k < 4; k++)
            all += share[k] = draw() * draw() * draw();
        for (int k = 0; k < 4; k++)
            x = vec3_fma(x, share[k] / all, vec3_load(at + 3 * (size_t)(draw() * (double)count)));
        least = fmin(least, vec3_length(vec3_sub(x, p)));
    }
    return least;
}

static void test_lamps(void)
{
    double at[3 * LAMPS], weight[LAMPS], off, worst = 0, clamped = 0;
    size_t full = 0, empty = 0, outside = 0;
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        at[i] = 100 + 5 * draw();
    for (int t = 0; t < 200; t++) {
        const struct vec3 p = {100.5 + 4 * draw(), 100.5 + 4 * draw(), 100.5 + 4 * draw()};
        size_t corner[4], corners = 0;
        must(lamp_blend(LAMPS, at, (const double[3]){p.x, p.y, p.z}, weight, &off));
        worst = off > 0 ? worst : fmax(worst, off_place(LAMPS, at, weight, p));
        for (size_t i = 0; i < LAMPS; i++)
            if (weight[i] > 0 && corners < 4)
                corner[corners++] = i;
        full += corners == 4 && !(off > 0);
        empty += corners == 4 && !(off > 0) && is_empty(LAMPS, at, corner);
    }
    ok(worst < 1e-9 && full > 100 && empty == full,
       "a lamp is the sum of a tetrahedron's corners, whose sphere is empty: %zu of %zu (%.1g)",
       empty, full, worst);
    for (int t = 0; t < 20; t++) {
        double d[3];
        draw_direction(d);
        const struct vec3 p = vec3_fma((struct vec3){102, 102, 102}, 8, vec3_load(d));
        must(lamp_blend(LAMPS, at, (const double[3]){p.x, p.y, p.z}, weight, &off));
        outside += off > 0 && fabs(off_place(LAMPS, at, weight, p) - off) < 1e-9;
        clamped = fmax(clamped, off - nearest_drawn(LAMPS, at, p));
    }
    ok(outside == 20 && clamped < 1e-9, "outside of the hull it is the nearest point: %zu, %.2g",
       outside, clamped);
    double exact = 0;
    for (size_t i = 0; i < LAMPS; i++) {
        must(lamp_blend(LAMPS, at, at + 3 * i, weight, &off));
        exact = fmax(exact, fmax(off, fabs(weight[i] - 1)));
    }
    ok(exact < 1e-9, "at a lamp it is that: %.1g", exact);
}

/* Lamps under a ceiling, in a grid, where any four corners of a square have one circle. */
static void test_lamps_in_a_plane(void)
{
    double at[3 * 9], weight[9], off, worst = 0, off_most = 0, far = 0;
    for (int i = 0; i < 9; i++)
        vec3_store(at + 3 * i, (struct vec3){i % 3, 2.5, i / 3});
    for (int t = 0; t < 100; t++) {
        const double p[3] = {2 * draw(), 2.5, 2 * draw()}, below[3] = {p[0], 2, p[2]};
        must(lamp_blend(9, at, p, weight, &off));
        worst = fmax(worst, off_place(9, at, weight, vec3_load(p)));
        off_most = fmax(off_most, off);
        for (int i = 0; i < 9; i++)
            if (weight[i] > 1e-9)
                far = fmax(far, vec3_length(vec3_sub(vec3_load(at + 3 * i), vec3_load(p))));
        must(lamp_blend(9, at, below, weight, &off));
        worst = fmax(worst, fabs(off - 0.5) + off_place(9, at, weight, vec3_load(p)));
    }
    ok(worst < 1e-9 && off_most < 1e-9 && far < 1.42,
       "in a plane it is of a square's corners, below it of the point above: %.1g, %.3g", worst,
       far);
    const double middle[3] = {0.25, 2.5, 0};
    must(lamp_blend(2, at, middle, weight, &off));
    ok(fabs(weight[0] - 0.75) < 1e-12 && fabs(weight[1] - 0.25) < 1e-12 && off < 1e-12,
       "of two, by the way between them: %.17g", weight[0]);
    must(lamp_blend(1, at, middle, weight, &off));
    ok(fabs(weight[0] - 1) < 1e-12 && fabs(off - 0.25) < 1e-12, "of one, that: %.17g", off);
}

/* -- errors ------------------------------------------------------------------------------------ */

enum { GROUPS = 3, ORDER = 1, WIDTH = 3 };

static float *add(struct table *t, const char *name)
{
    struct column *c;
    must(table_add_column(t, name, COLUMN_F32, WIDTH, &c));
    return column_f32(c);
}

/* A table of one probe whose groups have errors e and whose plain sum has error `whole` (NAN: no
 * column). */
static void make_table(struct table *t, const double e[GROUPS], double whole)
{
    static const char *const names[] = {"sh_a", "sh_b", "sh_c"}, *const errors[] = {"sh_error_a",
                                                                                    "sh_error_b",
                                                                                    "sh_error_c"};
    must(table_init(t, "probe"));
    must(table_add_column(t, "position", COLUMN_F64, 3, NULL));
    must(table_resize(t, 1));
    for (int k = 0; k < 3; k++)
        column_f64(table_column(t, "position"))[k] = 0;
    float *sh = add(t, "sh");
    for (int k = 0; k < WIDTH; k++)
        sh[k] = 6;
    if (!isnan(whole)) {
        float *error = add(t, "sh_error");
        for (int k = 0; k < WIDTH; k++)
            error[k] = (float)whole;
    }
    for (int g = 0; g < GROUPS; g++) {
        float *light = add(t, names[g]);
        for (int k = 0; k < WIDTH; k++)
            light[k] = (float)(g + 1);
        float *error = add(t, errors[g]);
        for (int k = 0; k < WIDTH; k++)
            error[k] = (float)e[g];
    }
}

static double error_of(const double e[GROUPS], double whole, const double w[GROUPS])
{
    struct stream_header header = {0};
    struct table in = {0}, out = {0};
    struct relight r = {0};
    struct warnings warnings = {0};
    double weight[3 * GROUPS];
    for (int i = 0; i < 3 * GROUPS; i++)
        weight[i] = w[i / 3];
    must(header_set_key(&header, "group-1", "a emissive"));
    must(header_set_key(&header, "group-2", "b point"));
    must(header_set_key(&header, "group-3", "c sky"));
    make_table(&in, e, whole);
    must(relight_from_header(&r, &header));
    must(relight_find(&r, &in));
    must(relight_schema(&r, &in, &out, &warnings));
    must(relight_rows(&r, weight, &in, &out, 1));
    const double error = (double)column_f32(table_column(&out, "sh_error"))[0];
    warnings_clear(&warnings);
    relight_clear(&r);
    table_clear(&in);
    table_clear(&out);
    header_clear(&header);
    return error;
}

/* Errors that are drawn with one correlation, whose weighted sums' spread is known. */
static void test_errors(void)
{
    static const double e[GROUPS] = {0.3, 0.5, 0.2}, correlations[] = {0, 0.4, -0.3, 1};
    static const double weights[][GROUPS] = {{1, 1, 1},   {1, 0, 0},  {0, 2, 1},
                                             {0.5, 3, 0}, {1, -1, 0}, {2, 2, 2}};
    double worst = 0;
    bool bound = true;
    for (int c = 0; c < 4; c++)
        for (int k = 0; k < 6; k++) {
            double whole = 0, wanted = 0;
            for (int i = 0; i < GROUPS; i++)
                for (int j = 0; j < GROUPS; j++) {
                    const double r = i == j ? 1 : correlations[c];
                    whole += r * e[i] * e[j];
                    wanted += r * weights[k][i] * weights[k][j] * e[i] * e[j];
                }
            const double is = error_of(e, sqrt(fmax(whole, 0)), weights[k]);
            worst = fmax(worst, fabs(is - sqrt(fmax(wanted, 0))));
            bound = bound && error_of(e, (double)NAN, weights[k]) >= sqrt(fmax(wanted, 0)) - 1e-6;
        }
    ok(worst < 1e-6, "errors of one correlation: the weighted sum's is found: %.1e", worst);
    ok(bound, "without the error of the plain sum, it is a bound");
    ok(error_of(e, 9, weights[3]) <= 0.15 + 1.5 + 1e-6 && error_of(e, 0, weights[4]) >= 0,
       "an error that cannot be is taken for the nearest that can");
}

/* -- compression ------------------------------------------------------------------------------- */

enum { SIZE = 60, ROWS = 90, WAVES = 6 };

/* Number i of n of the k-th cosine: over i, orthonormal, and for k > 0 of mean 0. */
static double wave(int k, int i, int n)
{
    return sqrt((k ? 2.0 : 1.0) / n) * cos(PI * k * (i + 0.5) / n);
}

/* A matrix of known vectors, in a shuffled order, and eigenvalues 1, 1/2, 1/4 ... */
static void test_eigen(void)
{
    enum { COUNT = 5 };
    static double matrix[SIZE * SIZE], vector[SIZE * SIZE];
    double value[SIZE], off = 0, aslant = 0;
    for (int k = 0; k < SIZE; k++)
        for (int i = 0; i < SIZE * SIZE; i++)
            matrix[i] += exp2(-k) * wave(k * 7 % SIZE, i / SIZE, SIZE) *
                         wave(k * 7 % SIZE, i % SIZE, SIZE);
    for (int all = 0; all < 2; all++) {
        const int count = all ? SIZE : COUNT;
        must(eigen_leading(matrix, SIZE, (size_t)count, value, vector, 2));
        for (int k = 0; k < count; k++) {
            double along = 0;
            for (int i = 0; i < SIZE; i++)
                along += vector[k * SIZE + i] * wave(k * 7 % SIZE, i, SIZE);
            off = fmax(off, fabs(value[k] - exp2(-k)));
            aslant = k < 20 ? fmax(aslant, fabs(fabs(along) - 1)) : aslant;
        }
    }
    ok(off < 1e-12 && aslant < 1e-9, "eigenvalues and vectors are found: %.1e, %.1e", off, aslant);
    memset(matrix, 0, sizeof matrix);
    must(eigen_leading(matrix, SIZE, COUNT, value, vector, 1));
    double lengths = 0;
    for (int k = 0; k < COUNT; k++)
        lengths = fmax(lengths, fabs(eigen_dot(vector + k * SIZE, vector + k * SIZE, SIZE) - 1));
    ok(lengths < 1e-12 && value[0] == 0, "of nothing, any vectors of length 1");
}

static double left_of(const struct pca *pca, size_t vectors, size_t clusters)
{
    struct pca_fit fit = {0};
    double left, all;
    must(pca_fit(pca, vectors, clusters, &fit, 2));
    must(pca_error(pca, &fit, &pca->numbers, 1, &left, &all, 2));
    pca_fit_clear(&fit);
    return left;
}

static void test_pca(void)
{
    static float values[ROWS * SIZE];
    struct pca pca = {0};
    double off = 0;
    /* waves over rows times waves over numbers: of the k-th the sum of squares is 4^-k */
    for (int i = 0; i < ROWS * SIZE; i++) {
        double sum = 3;
        for (int k = 0; k < WAVES; k++)
            sum += exp2(-k) * wave(k + 1, i / SIZE, ROWS) * wave(k + 2, i % SIZE, SIZE);
        values[i] = (float)sum;
    }
    must(pca_start(&pca, values, ROWS, SIZE, WAVES, 2));
    double left = 0;
    for (int k = WAVES; k > 0; k--) {
        off = fmax(off, fabs(left_of(&pca, (size_t)k, 1) - left));
        left += exp2(-2 * (k - 1));
    }
    ok(off < 1e-6, "what is lost is what the vectors that are left out have: %.1e", off);
    pca_clear(&pca);

    /* two kinds of rows, each on a line of its own */
    for (int i = 0; i < ROWS * SIZE; i++) {
        const int row = i / SIZE, kind = row % 2;
        values[i] = (float)(wave(1 + kind, i % SIZE, SIZE) +
                            wave(3 + kind, i % SIZE, SIZE) * wave(2, row, ROWS));
    }
    must(pca_start(&pca, values, ROWS, SIZE, 2, 2));
    const double one = left_of(&pca, 1, 1), two = left_of(&pca, 1, 2);
    ok(one > 0.1 && two < 1e-10, "each cluster has a line of its own: %.2e, %.1e", one, two);
    ok(left_of(&pca, 2, 2) < 1e-10 && left_of(&pca, 3, 1) < 1e-10,
       "what is more than there is does no harm");
    pca_clear(&pca);
}

int main(void)
{
    test_sky();
    test_suns();
    test_lamps();
    test_lamps_in_a_plane();
    test_errors();
    test_eigen();
    test_pca();
    return tap_done();
}
