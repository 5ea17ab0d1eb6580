/* SPDX-License-Identifier: Apache-2.0 */
/* Light that is turned: SH against the function that is turned, by a rule of integration of its
 * own; rotations as a group; streams and what their keys say. */
#include "light/rotate.h"
#include "base/warning.h"
#include "math/sphere_rule.h"
#include "stream/stream.h"
#include "support/sh_light.h"

#include <string.h>

static void draw_rotation(double m[9])
{
    double axis[3];
    char text[200];
    draw_direction(axis);
    snprintf(text, sizeof text, "%.17g,%.17g,%.17g,%.17g", axis[0], axis[1], axis[2],
             720 * draw() - 360);
    must(rotation_parse(m, "--rotate", text));
}

static void times(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

static void apply(const double m[9], const double v[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[3 * k] * v[0] + m[3 * k + 1] * v[1] + m[3 * k + 2] * v[2];
}

static void transpose(const double m[9], double out[9])
{
    for (int k = 0; k < 9; k++)
        out[k] = m[3 * (k % 3) + k / 3];
}

/* -- the rule of integration ------------------------------------------------------------------ */

/* Of x^a y^b z^c: 4 pi (a-1)!! (b-1)!! (c-1)!! / (a+b+c+1)!!, 0 where one is odd. */
static double moment(int a, int b, int c)
{
    double value = 4 * PI;
    if (a % 2 || b % 2 || c % 2)
        return 0;
    for (int k = a - 1; k > 1; k -= 2)
        value *= k;
    for (int k = b - 1; k > 1; k -= 2)
        value *= k;
    for (int k = c - 1; k > 1; k -= 2)
        value *= k;
    for (int k = a + b + c + 1; k > 1; k -= 2)
        value /= k;
    return value;
}

static void test_rule(void)
{
    double worst = 0, beyond = 0;
    for (int a = 0; a <= SPHERE_RULE_DEGREE + 1; a++)
        for (int b = 0; a + b <= SPHERE_RULE_DEGREE + 1; b++)
            for (int c = 0; a + b + c <= SPHERE_RULE_DEGREE + 1; c++) {
                double sum = 0;
                for (int i = 0; i < SPHERE_RULE_COUNT; i++) {
                    double d[3];
                    const double w = sphere_rule(i, d);
                    sum += w * pow(d[0], a) * pow(d[1], b) * pow(d[2], c);
                }
                double *of = a + b + c <= SPHERE_RULE_DEGREE ? &worst : &beyond;
                *of = fmax(*of, fabs(sum - moment(a, b, c)));
            }
    ok(worst < 1e-13, "the rule is exact up to degree %d: %.1e", SPHERE_RULE_DEGREE, worst);
    ok(beyond > 1e-7, "and not beyond: %.1e", beyond);
}

/* -- SH --------------------------------------------------------------------------------------- */

/* At many directions, the turned SH are the SH turned back: f'(d) = f(R^-1 d). */
static void test_function(void)
{
    double worst = 0, delta = 0;
    for (int k = 0; k < 200; k++) {
        const int order = 1 + k % SH_ORDER_MAX, count = order * order;
        double m[9], back[9], f[3 * SH_COUNT_MAX], g[3 * SH_COUNT_MAX], h[SH_COUNT_MAX];
        struct rotation r;
        draw_rotation(m);
        transpose(m, back);
        must(rotation_init(&r, m));
        for (int i = 0; i < 3 * count; i++)
            f[i] = 2 * draw() - 1;
        rotation_sh(&r, order, 3, f, g);
        for (int i = 0; i < 20; i++) {
            double d[3], before[3], y[SH_COUNT_MAX], y_before[SH_COUNT_MAX];
            draw_direction(d);
            apply(back, d, before);
            sh_basis(order, d, y);
            sh_basis(order, before, y_before);
            for (int c = 0; c < 3; c++) {
                double value = 0, expected = 0;
                for (int j = 0; j < count; j++) {
                    value += y[j] * g[3 * j + c];
                    expected += y_before[j] * f[3 * j + c];
                }
                worst = fmax(worst, fabs(value - expected));
            }
            /* light from one direction, which is no sum of a few functions, is projected */
            apply(m, before, d);
            sh_basis(order, d, y);
            rotation_sh(&r, order, 1, y_before, h);
            for (int j = 0; j < count; j++)
                delta = fmax(delta, fabs(h[j] - y[j]));
        }
    }
    ok(worst < 2e-13, "turned SH are the function turned, orders 1 to 6: %.1e", worst);
    ok(delta < 2e-13, "those of light from d, turned, are of light from R d: %.1e", delta);
}

static double apart(const struct rotation *a, double b[SH_COUNT_MAX][SH_COUNT_MAX])
{
    double worst = 0;
    for (int i = 0; i < SH_COUNT_MAX; i++)
        for (int j = 0; j < SH_COUNT_MAX; j++)
            worst = fmax(worst, fabs(a->sh[i][j] - b[i][j]));
    return worst;
}

static void test_group(void)
{
    static double product[SH_COUNT_MAX][SH_COUNT_MAX], gram[SH_COUNT_MAX][SH_COUNT_MAX];
    static const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double composed = 0, orthogonal = 0, between = 0;
    static struct rotation a, b, ab;
    for (int k = 0; k < 20; k++) {
        double m[9], n[9], mn[9];
        draw_rotation(m);
        draw_rotation(n);
        times(m, n, mn);
        must(rotation_init(&a, m));
        must(rotation_init(&b, n));
        must(rotation_init(&ab, mn));
        for (int i = 0; i < SH_COUNT_MAX; i++)
            for (int j = 0; j < SH_COUNT_MAX; j++) {
                product[i][j] = gram[i][j] = 0;
                for (int l = 0; l < SH_COUNT_MAX; l++) {
                    product[i][j] += a.sh[i][l] * b.sh[l][j];
                    gram[i][j] += a.sh[i][l] * a.sh[j][l];
                }
                orthogonal = fmax(orthogonal, fabs(gram[i][j] - (i == j)));
                if ((int)sqrt(i) != (int)sqrt(j))
                    between = fmax(between, fabs(a.sh[i][j]));
            }
        composed = fmax(composed, apart(&ab, product));
    }
    ok(composed < 1e-12, "one rotation after another is the product: %.1e", composed);
    ok(orthogonal < 1e-12, "matrices are orthogonal: %.1e", orthogonal);
    ok(between == 0, "bands stay apart");
    for (int i = 0; i < SH_COUNT_MAX; i++)
        for (int j = 0; j < SH_COUNT_MAX; j++)
            product[i][j] = i == j;
    must(rotation_init(&a, unit));
    ok(apart(&a, product) < 1e-14, "the identity's is the identity");
}

/* A quarter turn about z takes x to y: Y11 to Y1-1. */
static void test_signs(void)
{
    double m[9];
    struct rotation r;
    must(rotation_parse(m, "--rotate", "0,0,2,90"));
    must(rotation_init(&r, m));
    ok(m[0] == 0 || fabs(m[0]) < 1e-15, "a cosine of 90 degrees is 0");
    ok(r.matrix[0] == 0 && r.matrix[1] == -1 && r.matrix[3] == 1 && r.matrix[8] == 1,
       "a quarter turn is of whole numbers");
    ok(fabs(r.sh[1][3] - 1) < 1e-14 && fabs(r.sh[3][1] + 1) < 1e-14 && fabs(r.sh[2][2] - 1) < 1e-14,
       "about z, seen from above counter-clockwise, light from x comes from y");
}

static bool is_refused(const double m[9], const char *why)
{
    struct rotation r;
    struct error *err = rotation_init(&r, m);
    const bool right = err && strstr(error_message(err), why);
    error_destroy(err);
    return right;
}

static void test_refused(void)
{
    static const double mirror[9] = {-1, 0, 0, 0, 1, 0, 0, 0, 1},
                        through[9] = {-1, 0, 0, 0, -1, 0, 0, 0, -1},
                        long_one[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1},
                        skew[9] = {1, 0, 0, 0.1, 1, 0, 0, 0, 1},
                        nan_one[9] = {(double)NAN, 0, 0, 0, 1, 0, 0, 0, 1};
    ok(is_refused(mirror, "mirrors") && is_refused(through, "mirrors"), "mirrors are refused");
    ok(is_refused(long_one, "length 1") && is_refused(skew, "right angles") &&
           is_refused(nan_one, "length 1"),
       "so is what scales, what is skew, what is not a number");
}

/* -- streams ---------------------------------------------------------------------------------- */

enum { ORDER = 3, WIDTH = 3 * ORDER * ORDER, PROBES = 20 };

/* A field with a gradient: radiance at p from d is sum over i of (c_i + g_i . p) Y_i(d). */
static float value_of(const float *c, const float *g, const double p[3], int i)
{
    double sum = (double)c[i];
    for (int k = 0; k < 3; k++)
        sum += (double)g[k * WIDTH + i] * p[k];
    return (float)sum;
}

static float *add(struct table *t, const char *name, size_t width)
{
    struct column *c;
    must(table_add_column(t, name, COLUMN_F32, width, &c));
    return column_f32(c);
}

static const float *row_of(const struct stream *s, const char *name, size_t row)
{
    const struct column *c = table_column(stream_table(s, "probe"), name);
    return column_f32(c) + row * c->width;
}

/* A stream whose light changes from place to place, with a transfer of a sky of order 2. */
static struct stream *make_stream(void)
{
    struct stream *s;
    struct table *t;
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &t));
    must(table_add_column(t, "position", COLUMN_F64, 3, NULL));
    must(table_resize(t, PROBES));
    float *gradient = add(t, "sh_gradient", 3 * WIDTH), *sh = add(t, "sh", WIDTH),
          *error = add(t, "sh_error", WIDTH), *group = add(t, "sh_lamps", WIDTH),
          *transfer = add(t, "transfer_sky", 4 * WIDTH), *bent = add(t, "bent_normal", 3),
          *cone = add(t, "cone", 4), *cube = add(t, "ambient_cube", 18);
    double *p = column_f64(table_column(t, "position"));
    float c[WIDTH], g[3 * WIDTH];
    for (int i = 0; i < 3 * WIDTH; i++)
        g[i] = (float)(draw() - 0.5);
    for (int i = 0; i < WIDTH; i++)
        c[i] = (float)draw();
    for (int row = 0; row < PROBES; row++) {
        double d[3];
        draw_direction(d);
        for (int k = 0; k < 3; k++) {
            p[3 * row + k] = 4 * draw() - 2;
            bent[3 * row + k] = cone[4 * row + k] = (float)d[k];
        }
        cone[4 * row + 3] = (float)draw();
        for (int i = 0; i < WIDTH; i++) {
            sh[row * WIDTH + i] = group[row * WIDTH + i] = value_of(c, g, p + 3 * row, i);
            error[row * WIDTH + i] = (float)draw();
        }
        for (int i = 0; i < 4 * WIDTH; i++)
            transfer[row * 4 * WIDTH + i] = (float)draw();
        memcpy(gradient + 3 * row * WIDTH, g, sizeof g);
        memset(cube + 18 * row, 0, 18 * sizeof *cube);
    }
    for (int i = 0; i < WIDTH; i++) /* the last has no light yet */
        sh[(PROBES - 1) * WIDTH + i] = NAN;
    must(header_set_key(&s->header, "scene-key", "0123456789abcdef"));
    must(header_set_key(&s->header, "transfer-sun-1", "1,0,0"));
    return s;
}

static struct stream *turned(const char *by, bool light_only)
{
    struct rotation r;
    struct warnings warnings = {0};
    double m[9];
    state = 7; /* the same stream each time */
    struct stream *s = make_stream();
    must(rotation_parse(m, "--rotate", by));
    must(rotation_init(&r, m));
    must(rotate_stream(s, &r, light_only, &warnings));
    ok(warnings_of_kind(&warnings, "basis dropped") == 1 &&
           !table_column(stream_table(s, "probe"), "ambient_cube"),
       "bases go, with a warning");
    warnings_clear(&warnings);
    return s;
}

static double worst_apart(const float *a, const double *b, int count)
{
    double worst = 0;
    for (int i = 0; i < count; i++)
        worst = fmax(worst, fabs((double)a[i] - b[i]));
    return worst;
}

static void widen(const float *from, int count, double *to)
{
    for (int i = 0; i < count; i++)
        to[i] = (double)from[i];
}

/* What a column holds, turned by SH alone, against the stream turned. */
static double off_by_sh(const struct stream *was, const struct stream *is, const char *name,
                        const struct rotation *r)
{
    double worst = 0, before[WIDTH], after[WIDTH];
    for (size_t row = 0; row + 1 < PROBES; row++) {
        widen(row_of(was, name, row), WIDTH, before);
        rotation_sh(r, ORDER, 3, before, after);
        worst = fmax(worst, worst_apart(row_of(is, name, row), after, WIDTH));
    }
    return worst;
}

/* The gradient of the turned field, along a step. */
static double off_gradient(const struct stream *is)
{
    double worst = 0;
    const double *p = column_f64(table_column(stream_table(is, "probe"), "position"));
    for (size_t row = 1; row + 1 < PROBES; row++) {
        const float *c = row_of(is, "sh", 0), *g = row_of(is, "sh_gradient", 0),
                    *other = row_of(is, "sh", row);
        double step[3];
        for (int k = 0; k < 3; k++)
            step[k] = p[3 * row + (size_t)k] - p[k];
        for (int i = 0; i < WIDTH; i++)
            worst = fmax(worst, fabs((double)value_of(c, g, step, i) - (double)other[i]));
    }
    return worst;
}

/* The answer to a sky: the transfer times its SH. */
static void answer(const float *transfer, const double sky[4], double out[WIDTH])
{
    for (int i = 0; i < WIDTH; i++) {
        out[i] = 0;
        for (int j = 0; j < 4; j++)
            out[i] += (double)transfer[j * WIDTH + i] * sky[j];
    }
}

static double off_transfer(const struct stream *was, const struct stream *is,
                           const struct rotation *r, bool light_only)
{
    double worst = 0, sky[4], sky_turned[4], before[WIDTH], expected[WIDTH], got[WIDTH];
    for (size_t row = 0; row < PROBES; row++) {
        for (int j = 0; j < 4; j++)
            sky[j] = draw();
        rotation_sh(r, 2, 1, sky, sky_turned);
        answer(row_of(was, "transfer_sky", row), sky, before);
        rotation_sh(r, ORDER, 3, before, expected);
        answer(row_of(is, "transfer_sky", row), light_only ? sky : sky_turned, got);
        for (int i = 0; i < WIDTH; i++)
            worst = fmax(worst, fabs(got[i] - expected[i]));
    }
    return worst;
}

static void test_stream(bool light_only)
{
    static const char *const by = "1,2,-0.5,77";
    double m[9], n[3], want[3];
    struct rotation r;
    must(rotation_parse(m, "--rotate", by));
    must(rotation_init(&r, m));
    struct stream *is = turned(by, light_only);
    state = 7;
    struct stream *was = make_stream();
    const char *what = light_only ? "light alone: " : "";
    ok(off_by_sh(was, is, "sh", &r) < 2e-6 && off_by_sh(was, is, "sh_lamps", &r) < 2e-6,
       "%sSH of all and of a group are turned", what);
    ok(off_transfer(was, is, &r, light_only) < 2e-6,
       light_only ? "%sthe answer to the same sky is turned"
                  : "%sthe answer to the turned sky is the answer turned",
       what);
    ok(isnan(row_of(is, "sh", PROBES - 1)[0]), "%sa probe without light is left without", what);
    if (!light_only)
        ok(off_gradient(is) < 3e-6, "gradients lead from probe to probe");
    double worst = 0, sigma = 0;
    for (size_t row = 0; row < PROBES; row++) {
        for (int k = 0; k < 3; k++)
            n[k] = (double)row_of(was, "bent_normal", row)[k];
        apply(m, n, want);
        worst = fmax(worst, worst_apart(row_of(is, "bent_normal", row), want, 3));
        worst = fmax(worst, worst_apart(row_of(is, "cone", row), want, 3));
        worst = fmax(
            worst, fabs((double)row_of(is, "cone", row)[3] - (double)row_of(was, "cone", row)[3]));
        for (int i = 0; i < ORDER * ORDER; i++) {
            double sum = 0;
            for (int j = 0; j < ORDER * ORDER; j++)
                sum += pow(r.sh[i][j] * (double)row_of(was, "sh_error", row)[3 * j], 2);
            sigma = fmax(sigma, fabs((double)row_of(is, "sh_error", row)[3 * i] - sqrt(sum)));
        }
    }
    ok(worst < 1e-6, "%sbent normals and cones are turned", what);
    ok(sigma < 1e-6, "%svariances by the squared matrix", what);
    ok(light_only == !memcmp(column_f64(table_column(stream_table(was, "probe"), "position")),
                             column_f64(table_column(stream_table(is, "probe"), "position")),
                             PROBES * 3 * sizeof(double)),
       light_only ? "%sprobes stay" : "%sprobes are turned", what);
    const char *key = header_key(&is->header, light_only ? ROTATED_LIGHT_KEY : ROTATED_KEY);
    ok(key && !header_key(&is->header, light_only ? ROTATED_KEY : ROTATED_LIGHT_KEY),
       "%sthe header says so: %s", what, key ? key : "");
    ok(light_only == !strcmp(header_key(&is->header, "transfer-sun-1"), "1,0,0"),
       "%sthe suns of a transfer turn with the probes", what);

    /* and back */
    double back[9];
    struct warnings warnings = {0};
    transpose(m, back);
    must(rotation_init(&r, back));
    must(rotate_stream(is, &r, light_only, &warnings));
    ok(!header_key(&is->header, ROTATED_KEY) && !header_key(&is->header, ROTATED_LIGHT_KEY),
       "%sturned back, it fits its scene again", what);
    double light = 0;
    for (size_t i = 0; i + 1 < PROBES; i++)
        for (int k = 0; k < WIDTH; k++)
            light =
                fmax(light, fabs((double)row_of(was, "sh", i)[k] - (double)row_of(is, "sh", i)[k]));
    ok(light < 2e-6, "%sand has its light again: %.1e", what, light);
    warnings_clear(&warnings);
    stream_destroy(is);
    stream_destroy(was);
}

int main(void)
{
    test_rule();
    test_function();
    test_group();
    test_signs();
    test_refused();
    test_stream(false);
    test_stream(true);
    return tap_done();
}
