/* SPDX-License-Identifier: Apache-2.0 */
/* Ways to interpolate: each reproduces the fields that it must, is as smooth as it says, and agrees
 * with its formula summed over all probes. */
#include "base/error.h"
#include "interpolate/bound.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/nodes.h"
#include "libprobe-query/sh.h"
#include "math/random.h"
#include "stream/stream.h"
#include "support/tap.h"
#include "tetra/tetra.h"

#include <string.h>

enum { SIDE = 5, MOST = 600, WIDTH = 12 };

/* A polynomial of x, y, z, another one for each of WIDTH values: of this degree in all, or in each
 * coordinate. */
static double power(double x, int n)
{
    double p = 1;
    for (int i = 0; i < n; i++)
        p *= x;
    return p;
}

static double field(int degree, bool each, int value, const double p[3], double gradient[3])
{
    double sum = 0;
    gradient[0] = gradient[1] = gradient[2] = 0;
    for (int i = 0; i <= degree; i++)
        for (int j = 0; j <= degree; j++)
            for (int k = 0; k <= degree; k++) {
                if (!each && i + j + k > degree)
                    continue;
                double c = (double)((value * 7 + i * 5 + j * 3 + k * 11) % 13) / 13 - 0.4;
                c += value < 3 && !i && !j && !k ? 8 : 0; /* light on all sides */
                sum += c * power(p[0], i) * power(p[1], j) * power(p[2], k);
                gradient[0] += i ? c * i * power(p[0], i - 1) * power(p[1], j) * power(p[2], k) : 0;
                gradient[1] += j ? c * j * power(p[0], i) * power(p[1], j - 1) * power(p[2], k) : 0;
                gradient[2] += k ? c * k * power(p[0], i) * power(p[1], j) * power(p[2], k - 1) : 0;
            }
    return sum;
}

/* A stream of probes in a unit cube: at random, or the nodes of an uneven grid, shuffled; with the
 * field, its gradient and cells. */
static struct stream *make(bool grid, int degree, bool each)
{
    struct stream *s = NULL;
    struct table *probes = NULL, *cells = NULL;
    struct tetra t;
    struct random r = random_start(21, grid, 0);
    must(stream_create(&s));
    must(stream_add_table(s, "probe", &probes));
    must(table_add_column(probes, "position", COLUMN_F64, 3, NULL));
    must(table_add_column(probes, "sh", COLUMN_F32, WIDTH, NULL));
    must(table_add_column(probes, "sh_gradient", COLUMN_F32, 3 * WIDTH, NULL));
    must(table_resize(probes, grid ? SIDE * SIDE * SIDE : 150));
    double *p = column_f64(&probes->columns[0]);
    for (size_t i = 0; i < probes->rows; i++) {
        const size_t node = grid ? i * 37 % probes->rows : i;
        const size_t at[3] = {node % SIDE, node / SIDE % SIDE, node / SIDE / SIDE};
        for (size_t k = 0; k < 3; k++)
            p[3 * i + k] = grid ? pow((double)at[k] / (SIDE - 1), 1 + 0.3 * (double)k)
                                : random_double(&r);
        for (int v = 0; v < WIDTH; v++) {
            double g[3];
            column_f32(&probes->columns[1])[WIDTH * i + (size_t)v] =
                (float)field(degree, each, v, p + 3 * i, g);
            for (size_t k = 0; k < 3; k++)
                column_f32(&probes->columns[2])[3 * WIDTH * i + WIDTH * k + (size_t)v] =
                    (float)g[k];
        }
    }
    must(tetra_build(&t, probes->rows, p, NULL));
    must(stream_add_table(s, "tet", &cells));
    must(table_add_column(cells, "vertex", COLUMN_I32, 4, NULL));
    must(table_add_column(cells, "neighbour", COLUMN_I32, 4, NULL));
    must(table_resize(cells, t.cell_count));
    memcpy(cells->columns[0].data, t.vertex, t.cell_count * 16);
    memcpy(cells->columns[1].data, t.neighbour, t.cell_count * 16);
    tetra_clear(&t);
    return s;
}

static struct interpolate *open_kind(const struct stream *s, const struct interpolate_kind *kind,
                                     enum interpolate_falloff falloff, double radius)
{
    struct interpolate *in;
    must(interpolate_open(&in, s,
                          &(struct interpolate_settings){
                              .kind = kind, .falloff = falloff, .radius = radius, .column = "sh"}));
    return in;
}

static void at(const struct interpolate *in, const double p[3], float out[WIDTH],
               struct probe_place *place)
{
    interpolate_find(in, p, place);
    must(interpolate_at(in, p, place, out));
}

/* What is off most at points inside. */
static double worst_of(bool grid, int degree, bool each, const struct interpolate_kind *kind)
{
    struct stream *s = make(grid, degree, each);
    struct interpolate *in = open_kind(s, kind, 0, 0);
    struct random r = random_start(22, 0, 0);
    struct probe_place place = {.cell = PROBE_COLD};
    double worst = 0;
    for (int i = 0; i < 3000; i++) {
        const double p[3] = {random_double(&r), random_double(&r), random_double(&r)};
        float out[WIDTH];
        double g[3];
        at(in, p, out, &place);
        for (int v = 0; v < WIDTH && place.inside; v++)
            worst = fmax(worst, fabs((double)out[v] - field(degree, each, v, p, g)));
    }
    interpolate_close(in);
    stream_destroy(s);
    return worst;
}

static void test_reproduced(void)
{
    const struct {
        const char *name;
        bool grid;
        int degree;
        bool each;
        const struct interpolate_kind *kind;
        bool exact;
    } rows[] = {
        {"barycentric: linear fields", false, 1, false, &interpolate_barycentric, true},
        {"barycentric: not quadratic ones", false, 2, false, &interpolate_barycentric, false},
        {"gradient: linear fields", false, 1, false, &interpolate_gradient, true},
        {"gradient: not quadratic ones", false, 2, false, &interpolate_gradient, false},
        {"cubic: constant fields", false, 0, false, &interpolate_cubic, true},
        {"cubic: linear fields", false, 1, false, &interpolate_cubic, true},
        {"cubic: quadratic fields", false, 2, false, &interpolate_cubic, true},
        {"cubic: not cubic ones", false, 3, false, &interpolate_cubic, false},
        {"nearest: constant fields", false, 0, false, &interpolate_nearest, true},
        {"shepard: constant fields", false, 0, false, &interpolate_shepard, true},
        {"trilinear: linear in each coordinate", true, 1, true, &interpolate_trilinear, true},
        {"trilinear: not quadratic fields", true, 2, false, &interpolate_trilinear, false},
        {"inverse: constant fields", true, 0, false, &interpolate_inverse, true},
        {"inverse: not linear ones", true, 1, false, &interpolate_inverse, false},
        {"tricubic: quadratic in each coordinate, nodes uneven", true, 2, true,
         &interpolate_tricubic, true},
        {"tricubic: not cubic fields", true, 3, false, &interpolate_tricubic, false},
        {"trilinear-gradient: quadratic fields, nodes uneven", true, 2, false,
         &interpolate_trilinear_gradient, true},
        {"trilinear-gradient: not cubic ones", true, 3, false, &interpolate_trilinear_gradient,
         false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const double worst = worst_of(rows[i].grid, rows[i].degree, rows[i].each, rows[i].kind);
        ok(rows[i].exact ? worst < 2e-5 : worst > 1e-4, "%s (%.1e)", rows[i].name, worst);
    }
    const double linear = worst_of(false, 2, false, &interpolate_barycentric),
                 cubic = worst_of(false, 3, false, &interpolate_cubic),
                 plain = worst_of(false, 3, false, &interpolate_barycentric),
                 nodes = worst_of(true, 3, false, &interpolate_tricubic),
                 flat = worst_of(true, 3, false, &interpolate_trilinear);
    ok(cubic < plain / 2 && nodes < flat / 2 && linear > 0,
       "of cubic fields, cubics are off less than half as much as linear ways (%.1e of %.1e, %.1e "
       "of %.1e)",
       cubic, plain, nodes, flat);
}

static void test_inverse(void)
{
    double w[8];
    nodes_inverse((const double[3]){0.25, 0.5, 0.5}, (const double[3]){2, 1, 1}, w);
    const double near = 1 / sqrt(0.75), far = 1 / sqrt(2.75);
    ok(fabs(w[0] - near / (4 * near + 4 * far)) < 1e-15 &&
           fabs(w[7] - far / (4 * near + 4 * far)) < 1e-15,
       "inverse: weights go as 1 / distance (%.6f, %.6f)", w[0], w[7]);
}

/* Along lines no value jumps; at probes the value is the probe's, and, with gradients in a cubic,
 * so is the slope in every direction. */
static void test_smooth(void)
{
    struct stream *s = make(false, 3, false), *g = make(true, 3, false);
    const struct {
        const char *name;
        const struct stream *stream;
        const struct interpolate_kind *kind;
        bool slopes, hits;
    } rows[] = {{"barycentric", g, &interpolate_barycentric, false, true},
                {"gradient", s, &interpolate_gradient, false, true},
                {"cubic", g, &interpolate_cubic, true, true},
                {"shepard", s, &interpolate_shepard, false, false},
                {"trilinear", g, &interpolate_trilinear, false, true},
                {"tricubic", g, &interpolate_tricubic, false, true},
                {"trilinear-gradient", g, &interpolate_trilinear_gradient, false, true},
                {"inverse", g, &interpolate_inverse, false, true}};
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        /* a radius that reaches a probe from all of the lines */
        struct interpolate *in =
            open_kind(rows[row].stream, rows[row].kind, INTERPOLATE_FALL_QUADRATIC, 1.5);
        const struct table *probes = stream_table(rows[row].stream, "probe");
        const double *position = column_f64(&probes->columns[0]);
        const float *value = column_f32(&probes->columns[1]),
                    *gradient = column_f32(&probes->columns[2]);
        struct random r = random_start(23, 0, 0);
        struct probe_place place = {.cell = PROBE_COLD};
        double jump = 0, miss = 0, slope = 0;
        for (int line = 0; line < 60; line++) {
            double a[3], b[3];
            float last[WIDTH], now[WIDTH];
            for (int k = 0; k < 3; k++) {
                a[k] = 2 * random_double(&r) - 0.5;
                b[k] = 2 * random_double(&r) - 0.5;
            }
            enum { STEPS = 2000 };
            for (int i = 0; i <= STEPS; i++) {
                double p[3];
                for (int k = 0; k < 3; k++)
                    p[k] = a[k] + (b[k] - a[k]) * i / STEPS;
                at(in, p, now, &place);
                for (int v = 0; v < WIDTH && i; v++)
                    jump = fmax(jump, fabs((double)(now[v] - last[v])));
                memcpy(last, now, sizeof last);
            }
        }
        for (size_t i = 0; i < probes->rows; i++) {
            float there[WIDTH], near[WIDTH];
            at(in, position + 3 * i, there, &place);
            const double h = 1e-3, way[3] = {random_double(&r) - 0.5, random_double(&r) - 0.5,
                                             random_double(&r) - 0.5};
            double p[3];
            for (size_t k = 0; k < 3; k++)
                p[k] = position[3 * i + k] + h * way[k];
            at(in, p, near, &place);
            for (size_t v = 0; v < WIDTH; v++) {
                double expected = 0;
                for (size_t k = 0; k < 3; k++)
                    expected += way[k] * (double)gradient[3 * WIDTH * i + WIDTH * k + v];
                miss = fmax(miss, fabs((double)(there[v] - value[WIDTH * i + v])));
                if (place.inside)
                    slope = fmax(slope, fabs((double)(near[v] - there[v]) / h - expected));
            }
        }
        if (rows[row].kind == &interpolate_inverse)
            ok(jump > 0.05, "inverse: from cell to cell it does (%.1e)", jump);
        else
            ok(jump < 0.05, "%s: along lines, in and out, no value jumps (%.1e)", rows[row].name,
               jump);
        if (rows[row].hits)
            ok(miss < 1e-6, "%s: at a probe, its value (%.0e)", rows[row].name, miss);
        if (rows[row].kind == &interpolate_barycentric)
            ok(slope > 0.2, "barycentric: not its gradient (%.0e)", slope);
        if (rows[row].slopes)
            ok(slope < 0.02, "%s: at a probe, its gradient in every direction (%.0e)",
               rows[row].name, slope);
        interpolate_close(in);
    }
    stream_destroy(s);
    stream_destroy(g);
}

/* The least irradiance that SH of order 2 have in a few directions, and the most, as shares of
 * their mean. */
static void range_of(const float *sh, double *least, double *most)
{
    struct random r = random_start(25, 0, 0);
    for (int i = 0; i < 20; i++) {
        double n[3], rgb[3], square = 0;
        for (int k = 0; k < 3; k++) {
            n[k] = random_double(&r) - 0.5;
            square += n[k] * n[k];
        }
        for (int k = 0; k < 3; k++)
            n[k] /= sqrt(square);
        sh_irradiance(2, sh, false, n, rgb);
        for (int k = 0; k < 3; k++) {
            *least = fmin(*least, rgb[k]);
            *most = fmax(*most, rgb[k]);
        }
    }
}

static void any_direction(struct random *r, double d[3])
{
    double square;
    do {
        square = 0;
        for (int k = 0; k < 3; k++) {
            d[k] = 2 * random_double(r) - 1;
            square += d[k] * d[k];
        }
    } while (square > 1 || square < 1e-4);
    for (int k = 0; k < 3; k++)
        d[k] /= sqrt(square);
}

/* Beside a small lamp: what is all on one side meets what gradients foretell of the other. Light
 * that no probe has below 0, from any of 500 directions, stays so, of every order. */
static void test_sides(int order)
{
    enum { TRIES = 300, SIDES = 500 };
    static struct bound bound;
    const size_t functions = (size_t)order * (size_t)order;
    struct random r = random_start(27, (uint64_t)order, 0);
    double worst = 0;
    bound_start(&bound, order, false);
    for (int i = 0; i < TRIES; i++) {
        double d[2][3], basis[SH_COUNT_MAX], rgb[3];
        float sh[3 * SH_COUNT_MAX] = {0}, more[3 * SH_COUNT_MAX] = {0}, share[3];
        for (int k = 0; k < 2; k++) { /* a lamp; less of it than there is, from the side */
            any_direction(&r, d[k]);
            sh_basis(order, d[k], basis);
            for (size_t v = 0; v < 3 * functions; v++)
                (k ? more : sh)[v] += (k ? -3.0f : 1.0f) * (float)basis[v / 3];
        }
        double low = 0;
        for (int pass = 0; pass < 2; pass++) {
            struct random sides = random_start(28, (uint64_t)i, 0);
            bound_shares(&bound, sh, more, share);
            for (size_t v = 0; v < 3 * functions && pass; v++)
                sh[v] += share[v % 3] * more[v];
            for (int side = 0; side < SIDES; side++) {
                double n[3];
                any_direction(&sides, n);
                sh_irradiance(order, sh, false, n, rgb);
                low = pass ? low : fmin(low, rgb[0]); /* what it is without */
                worst = pass ? fmin(worst, rgb[0] - low) : worst;
            }
        }
    }
    ok(4 * worst > -0.008, "order %d: what gradients take away leaves %.3f of the mean at least",
       order, 4 * worst);
}

/* Gradients that are a thousand times too large make no light that is negative or brighter than
 * twice that of the probes, and none that jumps; nor do they make other values negative. */
static struct stream *make_steep(bool grid, struct random *r, double *low, double *high)
{
    struct stream *s = make(grid, 2, false);
    struct table *probes = stream_table(s, "probe");
    struct column *thing, *slope;
    must(table_add_column(probes, "thing", COLUMN_F32, 1, &thing));
    must(table_add_column(probes, "thing_gradient", COLUMN_F32, 3, &slope));
    thing = table_column(probes, "thing");
    *low = INFINITY;
    *high = 0;
    for (size_t i = 0; i < probes->rows; i++) {
        range_of(column_f32(&probes->columns[1]) + WIDTH * i, low, high);
        for (size_t k = 0; k < (size_t)3 * WIDTH; k++)
            column_f32(&probes->columns[2])[3 * WIDTH * i + k] *= 1000;
        column_f32(thing)[i] = random_float(r);
        for (size_t k = 0; k < 3; k++)
            column_f32(slope)[3 * i + k] = 1000 * (random_float(r) - 0.5f);
    }
    return s;
}

static void test_bounds(void)
{
    const struct interpolate_kind *const kinds[] = {&interpolate_gradient, &interpolate_cubic,
                                                    &interpolate_trilinear_gradient};
    struct random r = random_start(26, 0, 0), other = random_start(27, 0, 0);
    double low[2], high[2];
    struct stream *const streams[] = {make_steep(false, &r, &low[0], &high[0]),
                                      make_steep(true, &other, &low[1], &high[1])};
    for (int which = 0; which < 3; which++) {
        const int grid = kinds[which] == &interpolate_trilinear_gradient;
        const struct stream *s = streams[grid];
        struct interpolate *in = open_kind(s, kinds[which], 0, 0), *of_thing;
        must(interpolate_open(
            &of_thing, s, &(struct interpolate_settings){.kind = kinds[which], .column = "thing"}));
        double least = INFINITY, most = 0, jump = 0, change = 0, thing_least = INFINITY,
               thing_most = 0;
        struct probe_place place = {.cell = PROBE_COLD};
        for (int line = 0; line < 30; line++) {
            double a[3], b[3];
            float last[WIDTH], now[WIDTH], value;
            for (int k = 0; k < 3; k++) {
                a[k] = random_double(&r);
                b[k] = random_double(&r);
            }
            enum { STEPS = 20000 };
            for (int i = 0; i <= STEPS; i++) {
                double p[3];
                for (int k = 0; k < 3; k++)
                    p[k] = a[k] + (b[k] - a[k]) * i / STEPS;
                at(in, p, now, &place);
                must(interpolate_at(of_thing, p, &place, &value));
                if (i % 20 == 0)
                    range_of(now, &least, &most);
                thing_least = fmin(thing_least, (double)value);
                thing_most = fmax(thing_most, (double)value);
                for (int v = 0; v < WIDTH && i; v++) {
                    jump = fmax(jump, fabs((double)(now[v] - last[v])));
                    change = fmax(change, fabs((double)(now[v] - last[0])));
                }
                memcpy(last, now, sizeof last);
            }
        }
        ok(low[grid] > 0 && least > -0.01 * high[grid] && most < 2 * high[grid],
           "%s: steep gradients keep light within what probes can mean (%.2f .. %.2f of %.2f .. "
           "%.2f)",
           kinds[which]->name, least, most, low[grid], high[grid]);
        ok(jump < 0.02 * change, "%s: and nothing jumps (%.1e of %.1e)", kinds[which]->name, jump,
           change);
        ok(thing_least > -1e-6 && thing_most < 2,
           "%s: another column stays above 0 as well (%.2f .. %.2f)", kinds[which]->name,
           thing_least, thing_most);
        interpolate_close(in);
        interpolate_close(of_thing);
    }
    stream_destroy(streams[0]);
    stream_destroy(streams[1]);
}

static void test_scattered(void)
{
    struct stream *s = make(false, 2, false);
    const struct table *probes = stream_table(s, "probe");
    const double *position = column_f64(&probes->columns[0]);
    float *value = column_f32(&probes->columns[1]);
    for (size_t v = 0; v < WIDTH; v++)
        value[WIDTH * 17 + v] = NAN; /* a probe without light is not there */
    for (int falloff = 0; falloff < 4; falloff++) {
        const double radius = 0.3;
        struct interpolate *in =
            open_kind(s, falloff == 3 ? &interpolate_nearest : &interpolate_shepard,
                      (enum interpolate_falloff)(falloff % 3), falloff == 3 ? 0 : radius);
        struct random r = random_start(24, 0, 0);
        struct probe_place place = {.cell = PROBE_COLD};
        double worst = 0;
        int alone = 0;
        for (int i = 0; i < 1000; i++) {
            double p[3], sum = 0, expected[WIDTH] = {0}, least = INFINITY;
            size_t nearest = 0;
            float out[WIDTH];
            for (int k = 0; k < 3; k++)
                p[k] = 2 * random_double(&r) - 0.5;
            at(in, p, out, &place);
            for (size_t j = 0; j < probes->rows; j++) {
                double square = 0;
                for (size_t k = 0; k < 3; k++)
                    square += (p[k] - position[3 * j + k]) * (p[k] - position[3 * j + k]);
                if (j == 17)
                    continue;
                if (square < least) {
                    least = square;
                    nearest = j;
                }
                const double c = radius - sqrt(square), w = falloff == 3 || c <= 0 ? 0
                                                            : falloff == 0         ? c
                                                            : falloff == 1         ? c * c
                                                                                   : c * c * c;
                sum += w;
                for (size_t v = 0; v < WIDTH; v++)
                    expected[v] += w > 0 ? w * (double)value[WIDTH * j + v] : 0;
            }
            alone += sum == 0;
            for (size_t v = 0; v < WIDTH; v++)
                worst = fmax(worst,
                             fabs((double)out[v] - (sum > 0 ? expected[v] / sum
                                                            : (double)value[WIDTH * nearest + v])));
        }
        ok(worst < 1e-5 && (falloff == 3 || (alone > 0 && alone < 900)),
           "%s: as summed over all probes (%.0e; %d of 1000 points had none within the radius)",
           falloff == 3   ? "nearest"
           : falloff == 0 ? "shepard linear"
           : falloff == 1 ? "shepard quadratic"
                          : "shepard cubic",
           worst, alone);
        interpolate_close(in);
    }
    stream_destroy(s);
}

static void refused(struct stream *s, const struct interpolate_kind *kind, const char *column,
                    const char *why)
{
    struct interpolate *in;
    struct error *err =
        interpolate_open(&in, s, &(struct interpolate_settings){.kind = kind, .column = column});
    ok(err && !in && strstr(error_message(err), why), "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    interpolate_close(in);
}

static void test_refused(void)
{
    struct stream *s = make(false, 1, false), *g = make(true, 1, false);
    refused(s, &interpolate_trilinear, "sh",
            "not the nodes of a grid: 150 probes have 150, 150 and 150 different");
    refused(s, &interpolate_barycentric, "light", "light");
    struct table *probes = stream_table(g, "probe");
    column_f64(&probes->columns[0])[3 * 7] = column_f64(&probes->columns[0])[3 * 8];
    for (size_t k = 0; k < 3; k++)
        column_f64(&probes->columns[0])[3 * 7 + k] = column_f64(&probes->columns[0])[3 * 8 + k];
    refused(g, &interpolate_tricubic, "sh", "are at one node");
    table_remove_column(probes, "sh_gradient");
    refused(g, &interpolate_cubic, "sh",
            "no column sh_gradient): run probe-capture --columns sh_gradient");
    stream_remove_table(s, "tet");
    refused(s, &interpolate_gradient, "sh", "run probe-tet");
    struct interpolate *in;
    must(interpolate_open(
        &in, s, &(struct interpolate_settings){.kind = &interpolate_nearest, .column = "sh"}));
    ok(in != NULL, "nearest needs no cells");
    interpolate_close(in);
    stream_destroy(s);
    stream_destroy(g);
}

/* What a kind fails with on a stream; "" for nothing. */
static void why_not(const struct stream *s, const struct interpolate_kind *kind, char text[512])
{
    struct interpolate *in;
    struct error *err =
        interpolate_open(&in, s, &(struct interpolate_settings){.kind = kind, .column = "sh"});
    snprintf(text, 512, "%s", err ? error_message(err) : "");
    error_destroy(err);
    interpolate_close(in);
}

/* Whether a manual has it as a word that is typed. */
static bool in_manual(const char *program, const char *name)
{
    char path[4096], line[512];
    const char *source = getenv("SRC");
    snprintf(path, sizeof path, "%s/man/%s.1", source ? source : ".", program);
    FILE *f = fopen(path, "r");
    if (!f)
        bail("%s cannot be read", path);
    bool found = false;
    while (fgets(line, sizeof line, f)) {
        bool typed = false; /* after Cm */
        for (char *rest, *at = strtok_r(line, " .\n", &rest); at;
             at = strtok_r(NULL, " .\n", &rest)) {
            found = found || (typed && !strcmp(at, name));
            typed = typed || !strcmp(at, "Cm");
        }
    }
    fclose(f);
    return found;
}

/* Of every kind of the table. */
static void test_table(void)
{
    struct stream *s = make(true, 1, false), *flat = make(true, 1, false);
    table_remove_column(stream_table(flat, "probe"), "sh_gradient");
    stream_remove_table(s, "tet");
    for (int i = 0; interpolate_kinds[i]; i++) {
        const struct interpolate_kind *kind = interpolate_kinds[i];
        char cells[512], gradients[512];
        why_not(s, kind, cells);
        why_not(flat, kind, gradients);
        if (kind->surface) /* that comes first */
            ok(strstr(cells, "no column normal") != NULL, "%s: refused without normals",
               kind->name);
        ok(interpolate_kind_find(kind->name) == kind, "%s is found by its name", kind->name);
        ok(kind->needs_cells ? strstr(cells, "run probe-tet") != NULL : !*cells || kind->surface,
           "%s: %s cells", kind->name, kind->needs_cells ? "refused without" : "needs no");
        ok(kind->needs_gradients ? strstr(gradients, "sh_gradient") != NULL
                                 : !*gradients || kind->surface,
           "%s: %s gradients", kind->name, kind->needs_gradients ? "refused without" : "needs no");
        ok(in_manual("probe-query", kind->name) && in_manual("probe-error", kind->name) &&
               in_manual("probe-render", kind->name),
           "%s is in the manuals", kind->name);
    }
    stream_destroy(s);
    stream_destroy(flat);
}

int main(void)
{
    test_reproduced();
    test_inverse();
    test_smooth();
    test_bounds();
    for (int order = 2; order <= SH_ORDER_MAX; order++)
        test_sides(order);
    test_scattered();
    test_refused();
    test_table();
    return tap_done();
}
