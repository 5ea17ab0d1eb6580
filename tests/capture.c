/* SPDX-License-Identifier: Apache-2.0 */
/* Capture, one probe at a time: what the rays learn, seeds, alpha, instances, the header, and the
 * coverage of sh_error. z-scores, (value - truth) / sh_error, are held within 4.5 (a chance of 7e-6
 * of failing by luck). Closed forms: tests/forms.c; scale and distance: tests/extremes.c. */
#include "math/random.h"
#include "stream/stream.h"
#include "support/capture_bench.h"

/* Largest |z| of the coefficients against a truth. */
static double worst_z(const struct capture_probe *p, int order, const double *truth)
{
    double worst = 0;
    for (int i = 0; i < 3 * order * order; i++) {
        const double off = fabs((double)p->sh[i] - truth[i]),
                     error = (double)p->sh_error[i] + 1e-6 * (1 + fabs(truth[i]));
        worst = fmax(worst, off / error);
    }
    return worst;
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

/* What the rays learn on the way, in a closed box. */
static void test_rays(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.6f, 1));
    bench_finish(&b, 4);
    const struct capture_settings s = capture_settings_default();
    const struct capture_probe p = capture(&b, &s, 0.3, -0.4, 0.2);
    ok(p.sky == 0 && p.validity == 1 && p.depth > 2 && p.depth < 2 * sqrt(3),
       "closed: no ray escapes, depth %.3f", (double)p.depth);
    bench_clear(&b);
}

/* A cube with a lamp on one wall. */
static struct capture_probe capture_room(uint64_t seed)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.7f, 0));
    add_floor(&b, 1, 1.9, material(0.2f, 4));
    bench_finish(&b, 16);
    struct capture_settings s = capture_settings_default();
    s.rays = 1000;
    s.seed = seed;
    const struct capture_probe p = capture(&b, &s, 0.5, -0.3, 0.2);
    bench_clear(&b);
    return p;
}

static void test_seed(void)
{
    const struct capture_probe here = capture_room(0), again = capture_room(0),
                               other = capture_room(1);
    ok(!memcmp(here.sh, again.sh, sizeof(float[27])), "the same seed gives the same bytes");
    ok(memcmp(here.sh, other.sh, sizeof(float[27])), "another seed gives others");
}

static double difference_z(const struct capture_probe *a, const struct capture_probe *b)
{
    double worst = 0;
    for (int i = 0; i < 27; i++) {
        const double ea = (double)a->sh_error[i], eb = (double)b->sh_error[i];
        worst = fmax(worst, fabs((double)a->sh[i] - (double)b->sh[i]) / sqrt(ea * ea + eb * eb));
    }
    return worst;
}

/* The share of coefficients whose truth lies within 1.96 standard errors. */
static void test_coverage(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.7f, 0));
    add_quad(&b, (const double[12]){-1, 1.9, -1, 1, 1.9, -1, 1, 1.9, 1, -1, 1.9, 1},
             material(0.2f, 4));
    bench_finish(&b, 4);
    enum { PROBES = 60, SEEDS = 12 };
    struct capture_settings s = capture_settings_default();
    size_t within = 0, all = 0;
    struct random r = random_start(7, 0, 0);
    for (int i = 0; i < PROBES; i++) {
        const double p[3] = {3 * random_double(&r) - 1.5, 3 * random_double(&r) - 1.5,
                             3 * random_double(&r) - 1.5};
        s.rays = 20000;
        s.seed = 1000;
        const struct capture_probe truth = capture(&b, &s, p[0], p[1], p[2]);
        s.rays = 200;
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            s.seed = seed;
            const struct capture_probe one = capture(&b, &s, p[0], p[1], p[2]);
            for (int k = 0; k < 27; k++, all++) {
                const double e = (double)one.sh_error[k], t = (double)truth.sh_error[k];
                within += fabs((double)one.sh[k] - (double)truth.sh[k]) <
                          1.96 * sqrt(e * e + t * t);
            }
        }
    }
    /* Colours and coefficients of one capture are correlated: as if there were PROBES * SEEDS
     * independent ones, 95 % is met within 4 * sqrt(.95 * .05 / 720) = 3.2 %. */
    const double share = (double)within / (double)all;
    ok(share > 0.918 && share < 0.982,
       "the truth lies within 1.96 sh_error in %.1f %% of %zu cases", 100 * share, all);
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
        ok(worst_z(&p, 3, truth) < 4.5, "%s (z = %.2f)",
           blend ? "a wall of opacity 0.25 lets 3/4 of the sky through"
                 : "a cut-out below its cut-off is not there",
           worst_z(&p, 3, truth));
        const double inside[3] = {0, 0, 0}, outside[3] = {5, 0.1, 0.2};
        ok(fabsf(trace_visibility(b.tracer, inside, outside) - (blend ? 0.75f : 1)) < 1e-6f,
           "and visibility says so");
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
            add_quad(&b, (const double[12]){1, -2, -1, -1, -2, -1, -1, -2, 1, 1, -2, 1},
                     material(0, 1));
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
    ok(difference_z(&p[0], &p[1]) < 4.5, "a mesh placed twice lights as two meshes do (z = %.2f)",
       difference_z(&p[0], &p[1]));
    ok(p[0].sh[0] > 0.3f, "and it shines");
}

static void test_header(void)
{
    struct capture_settings s = {.order = 5,
                                 .rays = 77,
                                 .bounces = 3,
                                 .light = CAPTURE_INDIRECT,
                                 .seed = (uint64_t)1 << 52,
                                 .ao_distance = 1.5,
                                 .ao_falloff = OCCLUSION_SQRT,
                                 .azimuths = 12,
                                 .decimate = 0.3},
                            back = capture_settings_default();
    struct stream_header h = {0};
    must(capture_settings_to_header(&s, &h));
    must(capture_settings_from_header(&back, &h));
    ok(back.order == 5 && back.rays == 77 && back.bounces == 3 && back.light == CAPTURE_INDIRECT &&
           back.seed == s.seed && back.decimate == s.decimate && back.ao_distance == 1.5 &&
           back.ao_falloff == OCCLUSION_SQRT && back.azimuths == 12,
       "settings come back from a header");
    must(header_set_key(&h, "capture-rays", "many"));
    struct error *err = capture_settings_from_header(&back, &h);
    ok(err && strstr(error_message(err), "capture-rays"), "refused: %s",
       err ? error_message(err) : "");
    error_destroy(err);
    header_clear(&h);
}

int main(void)
{
    test_sky();
    test_rays();
    test_seed();
    test_alpha();
    test_instances();
    test_coverage();
    test_header();
    return tap_done();
}
