/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance and irradiance: both kinds of coefficients against closed forms, orders 1 to 6, with
 * their error and gradient; and what can be turned into which. */
#include "light/content.h"
#include "light/order.h"
#include "stream/stream.h"
#include "support/capture_runs.h"

/* A_l, Ramamoorthi and Hanrahan 2001, eq. 8, by hand. */
static const double A[6] = {PI, 2 * PI / 3, PI / 4, 0, -PI / 24, 0};

static int band_of(int value)
{
    return (int)sqrt(value / 3);
}

/* P_l(x) */
static double legendre(int l, double x)
{
    const double p[6] = {1,
                         x,
                         (3 * x * x - 1) / 2,
                         (5 * x * x - 3) * x / 2,
                         ((35 * x * x - 30) * x * x + 3) / 8,
                         ((63 * x * x - 70) * x * x + 15) * x / 8};
    return p[l];
}

/* A sun in the void: deltas, exact. E(n) = irradiance * sum over l of A_l (2l + 1) / 4 pi P_l(n .
 * d). */
static void test_sun(void)
{
    const double travel[3] = {0.36, -0.8, -0.48}, rgb[3] = {10, 20, 5};
    struct bench b;
    bench_start(&b);
    add_light(&b, (struct scene_light){.kind = SCENE_SUN,
                                       .direction = {travel[0], travel[1], travel[2]},
                                       .intensity = {rgb[0], rgb[1], rgb[2]}});
    bench_finish(&b, 1);
    double worst = 0, band3 = 0;
    for (int order = 1; order <= SH_ORDER_MAX; order++) {
        for (int convolved = 0; convolved < 2; convolved++) {
            struct capture_settings s = capture_settings_default();
            s.order = order;
            s.rays = 16;
            s.convolved = convolved;
            struct capture_probe probe = capture(&b, &s, 0.1, 0.2, 0.3);
            capture_shape(&s, &probe);
            for (int at = 0; at < 14; at++) {
                double n[3], e[3], x = 0, expected = 0;
                runs_normal(at, n);
                sh_irradiance(order, probe.sh, convolved, n, e);
                for (int k = 0; k < 3; k++)
                    x -= n[k] * travel[k];
                for (int l = 0; l < order; l++)
                    expected += A[l] * (2 * l + 1) / (4 * PI) * legendre(l, x);
                for (int k = 0; k < 3; k++)
                    worst = fmax(worst, fabs(e[k] / rgb[k] - expected));
            }
            for (int i = 0; i < 3 * order * order && convolved; i++)
                band3 += band_of(i) == 3 || band_of(i) == 5 ? fabs((double)probe.sh[i]) : 0;
        }
    }
    ok(worst < 1e-6, "a sun's irradiance, orders 1 to 6, from radiance and from irradiance (%.1e)",
       worst);
    ok(band3 == 0, "irradiance has no bands 3 and 5");
    bench_clear(&b);
}

/* A square lamp under a sky, behind which there is none. Noise: means of 32 seeds, by their
 * standard errors. */
static void test_lamp(void)
{
    const double sky[3] = {0.5, 1, 0.25}, lamp[12] = {-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1},
                 p[3] = {0, 0, 0};
    const struct vec3 corner = {-1, 2, -1}, u = {2, 0, 0}, v = {0, 0, 2};
    struct bench b;
    bench_start(&b);
    memcpy(b.settings.sky, sky, sizeof sky);
    add_quad(&b, lamp, material(0, 10));
    bench_finish(&b, 1);
    const struct gauss g = gauss_rule(32);
    double radiance[TRUTH_VALUES] = {0};
    add_uniform(radiance, sky);
    add_parallelogram(radiance, corner, u, v, &g,
                      (const double[3]){10 - sky[0], 20 - sky[1], 5 - sky[2]});
    for (int order = 1; order <= SH_ORDER_MAX; order++) {
        struct capture_settings s = capture_settings_default();
        s.order = order;
        s.rays = 256;
        s.convolved = true;
        double truth[TRUTH_VALUES];
        for (int i = 0; i < TRUTH_VALUES; i++)
            truth[i] = A[band_of(i)] * radiance[i];
        struct runs runs = {.order = order, .count = 32};
        double off_error = 0;
        for (int i = 0; i < runs.count; i++, s.seed++) {
            struct capture_probe probe = capture(&b, &s, p[0], p[1], p[2]);
            const struct capture_probe raw = probe;
            capture_shape(&s, &probe);
            memcpy(runs.value[i], probe.sh, sizeof runs.value[i]);
            for (int k = 0; k < runs_values(&runs); k++) {
                runs.variance[k] += (double)probe.sh_error[k] * (double)probe.sh_error[k] /
                                    runs.count / runs.count;
                off_error = fmax(off_error, fabs((double)probe.sh_error[k] -
                                                 fabs(A[band_of(k)]) * (double)raw.sh_error[k]));
            }
        }
        const double z = runs_z(&runs, truth);
        const struct estimate bias = runs_bias(&runs, truth);
        ok(z < RUNS_Z_MOST && deviation(bias.mean, bias.error, 1) < RUNS_T_MOST &&
               bias.error < RUNS_RESOLUTION && off_error < 1e-6,
           "a lamp under a sky, irradiance of order %d: z = %.2f, off by %+.3f +- %.3f %%", order,
           z, 100 * bias.mean, 100 * bias.error);
    }
    bench_clear(&b);
}

/* -- tables ----------------------------------------------------------------------------------- */

static void make_table(struct table *t, int order)
{
    static const char *const names[3] = {"sh", "sh_error", "sh_gradient"};
    const size_t width = (size_t)(3 * order * order);
    must(table_init(t, "probe"));
    for (int i = 0; i < 3; i++)
        must(table_add_column(t, names[i], COLUMN_F32, (i < 2 ? 1 : 3) * width, NULL));
    must(table_resize(t, 3));
    for (int i = 0; i < 3; i++) {
        const struct column *c = table_column(t, names[i]);
        for (size_t k = 0; k < 2 * c->width; k++) /* the last is not captured */
            column_f32(c)[k] = (float)(1 + k % 7) * (i != 1 && k % 2 ? -0.3f : 0.3f);
    }
}

static void test_conversion(void)
{
    bool there = true, back = true, refused = true;
    for (int order = 1; order <= SH_ORDER_MAX; order++) {
        struct table was = {0}, t = {0};
        make_table(&was, order);
        make_table(&t, order);
        must(content_convert(&t, false, true));
        for (size_t column = 0; column < 3; column++) {
            const struct column *c = &t.columns[column], *d = &was.columns[column];
            for (size_t k = 0; k < 2 * c->width; k++) {
                const double a = A[band_of((int)(k % t.columns[0].width))],
                             expected = (column == 1 ? fabs(a) : a) * (double)column_f32(d)[k];
                there = there && fabs((double)column_f32(c)[k] - expected) < 1e-6;
            }
            there = there && isnan(column_f32(c)[3 * c->width - 1]);
        }
        struct error *err = content_convert(&t, true, false);
        if (order > CONTENT_RADIANCE_ORDER_MAX) {
            refused = refused && err && strstr(error_message(err), "band 3 leaves no trace");
        } else {
            must(err);
            for (size_t column = 0; column < 3; column++)
                for (size_t k = 0; k < 2 * t.columns[column].width; k++) {
                    const double is = (double)column_f32(&t.columns[column])[k],
                                 expected = (double)column_f32(&was.columns[column])[k];
                    back = back && fabs(is - expected) < 2e-7 * fabs(expected);
                }
        }
        error_destroy(err);
        table_clear(&was);
        table_clear(&t);
    }
    ok(there, "sh, its error and its gradient become A_l times what they were; what is missing "
              "stays missing");
    ok(back, "and come back to the last bit or two, up to order 3");
    ok(refused, "irradiance of order 4 and more cannot be undone, and that is said");

    struct table t = {0};
    make_table(&t, 6);
    int order[2];
    double lost[2];
    for (int i = 0; i < 2; i++) {
        must(order_least(&t, i, 0.2, &order[i], &lost[i]));
        if (!i)
            must(content_convert(&t, false, true));
    }
    ok(order[0] == order[1] && fabs(lost[0] - lost[1]) < 1e-6,
       "both need the same order (%d and %d)", order[0], order[1]);
    table_clear(&t);
}

static void test_header(void)
{
    struct stream_header header = {0};
    bool convolved = true;
    must(content_from_header(&header, &convolved));
    ok(!convolved, "without a key it is radiance");
    must(content_to_header(&header, true));
    must(content_from_header(&header, &convolved));
    ok(convolved && !strcmp(header_key(&header, "sh-content"), "irradiance"),
       "the key says irradiance");
    must(header_set_key(&header, "sh-content", "flux"));
    struct error *err = content_from_header(&header, &convolved);
    ok(err && strstr(error_message(err), "expected radiance or irradiance, got 'flux'"),
       "anything else is refused");
    error_destroy(err);
    header_clear(&header);
}

int main(void)
{
    test_sun();
    test_lamp();
    test_conversion();
    test_header();
    return tap_done();
}
