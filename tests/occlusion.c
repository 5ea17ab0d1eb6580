/* SPDX-License-Identifier: Apache-2.0 */
/* What capture tells of the surfaces about a probe, against closed forms: the mean of captures with
 * different seeds is within 4.5 of its standard errors, as one in 150 thousand would not be. */
#include "support/capture_bench.h"

enum { SEEDS = 32 };

/* The mean of a value of captures with different seeds, and its standard error. */
struct estimate {
    double mean, error;
};

static struct estimate estimate(const struct bench *b, struct capture_settings s, const double p[3],
                                const float *normal,
                                double (*value)(const struct capture_probe *probe))
{
    double sum = 0, square = 0;
    for (int i = 0; i < SEEDS; i++) {
        struct capture_probe probe;
        s.seed = (uint64_t)i;
        must(capture_probe(&b->path, &s, p, normal, &probe));
        const double v = value(&probe);
        sum += v / SEEDS;
        square += v * v / SEEDS;
    }
    return (struct estimate){sum, sqrt(fmax(square - sum * sum, 0) / (SEEDS - 1))};
}

/* That it is the truth, and told well enough to know; `rounding`: of what varies less. */
static void check(const char *name, struct estimate e, double truth, double rounding)
{
    const double error = fmax(e.error, rounding);
    ok(fabs(e.mean - truth) < 4.5 * error && error < 0.01,
       "%s: %.5f (%.5f, %.1f standard errors of %.1e)", name, truth, e.mean,
       (e.mean - truth) / error, error);
}

static double ao_of(const struct capture_probe *p)
{
    return (double)p->ao;
}

static struct capture_settings settings_of(unsigned columns)
{
    struct capture_settings s = capture_settings_default();
    s.light = CAPTURE_NONE;
    s.rays = 1024;
    s.columns = columns;
    return s;
}

/* -- obscurance ------------------------------------------------------------------------------- */

/* Under an endless ceiling at a times the distance: 2 integral of rho(a / c) c dc over c in [0, 1],
 * where rho is 1 for c < a. */
static double under_ceiling(enum occlusion_falloff falloff, double a)
{
    enum { STEPS = 100000 };
    double sum = a * a;
    for (int i = 0; i < STEPS && falloff == OCCLUSION_EXP; i++) {
        const double c = a + (1 - a) * (i + 0.5) / STEPS;
        sum += 2 * (1 - a) / STEPS * c * (1 - exp(-3 * a / c)) / (1 - exp(-3.0));
    }
    return falloff == OCCLUSION_LINEAR ? 2 * a - a * a
           : falloff == OCCLUSION_SQRT ? 4.0 / 3 * sqrt(a) - a * a / 3
                                       : sum;
}

static void test_obscurance(void)
{
    struct bench b;
    bench_start(&b);
    add_floor(&b, 1e4, 1, material(0, 0));
    bench_finish(&b, 1);
    const float up[3] = {0, 1, 0};
    const double origin[3] = {0};
    struct capture_settings s = settings_of(CAPTURE_AO);
    for (int f = 0; occlusion_falloff_names[f]; f++)
        for (int k = 0; k < 2; k++) {
            char name[64];
            const double a = k ? 0.8 : 0.3;
            s.ao_falloff = (enum occlusion_falloff)f;
            s.ao_distance = 1 / a;
            snprintf(name, sizeof name, "%s, under a ceiling at %g of the distance",
                     occlusion_falloff_names[f], a);
            check(name, estimate(&b, s, origin, up, ao_of), under_ceiling(s.ao_falloff, a), 1e-6);
        }
    /* Of a point half of all directions go up, uniformly: 1/2 + 1/2 (a + a ln 1/a). */
    s.ao_falloff = OCCLUSION_LINEAR;
    s.ao_distance = 2;
    check("linear, of a point", estimate(&b, s, origin, NULL, ao_of),
          0.5 + 0.5 * (0.5 + 0.5 * log(2)), 1e-6);
    bench_clear(&b);
}

/* The forms are continuous, 0 at 0 and 1 from the distance on, and none falls. */
static void test_falloff(void)
{
    bool right = true;
    for (int f = 0; occlusion_falloff_names[f]; f++) {
        const enum occlusion_falloff falloff = (enum occlusion_falloff)f;
        double before = 0, widest = 0;
        for (int i = 0; i <= 1200; i++) {
            const double rho = occlusion_openness(falloff, i / 1000.0);
            right = right && rho >= before && (i <= 1000 || rho == 1);
            widest = fmax(widest, rho - before);
            before = rho;
        }
        right = right && occlusion_openness(falloff, 0) == 0 &&
                widest < (falloff == OCCLUSION_STEP ? 1.01 : 0.04);
    }
    ok(right, "openness rises from 0 at no distance to 1 from the distance on");
}

/* Without light the rays are those that there are with it, and end sooner. */
static void test_unlit(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.6f, 1));
    struct shape block = shape_sphere(0.6, 1);
    shape_move(&block, 0.7, -1.2, -0.6);
    add_shape(&b, &block, material(0.5f, 0));
    shape_clear(&block);
    bench_finish(&b, 1);
    static const float normals[2][3] = {{0, 1, 0}, {0.6f, 0, -0.8f}};
    bool same = true;
    for (int i = 0; i < 12; i++) {
        struct capture_probe lit, unlit, far;
        struct capture_settings s = settings_of(CAPTURE_OCCLUSION);
        const double p[3] = {0.3 * (i % 3), -1.9, 0.2 * i - 1};
        const float *normal = i % 4 == 3 ? NULL : normals[i & 1];
        s.ao_falloff = i % 2 ? OCCLUSION_STEP : OCCLUSION_SQRT;
        s.ao_distance = 1.3;
        must(capture_probe(&b.path, &s, p, normal, &unlit));
        s.columns |= CAPTURE_DEPTH;
        must(capture_probe(&b.path, &s, p, normal, &far));
        s.light = CAPTURE_ALL;
        must(capture_probe(&b.path, &s, p, normal, &lit));
        same = same && lit.ao == unlit.ao && lit.ao == far.ao && lit.depth == far.depth &&
               !memcmp(lit.bent_normal, unlit.bent_normal, sizeof lit.bent_normal) && lit.ao > 0 &&
               lit.ao < 1;
    }
    ok(same, "occlusion without light is what it is with it, to the bit");
    struct capture_probe none, far;
    struct capture_settings s = settings_of(CAPTURE_AO);
    const double p[3] = {0.3, -1.9, 0.2};
    must(capture_probe(&b.path, &s, p, normals[0], &none));
    s.ao_distance = 1e9;
    s.ao_falloff = OCCLUSION_EXP;
    must(capture_probe(&b.path, &s, p, normals[0], &far));
    ok(none.ao == 0 && far.ao > 0 && far.ao < 1e-7f,
       "in a closed room all is dark, with a distance beyond it as well");
    bench_clear(&b);
}

/* -- cones ------------------------------------------------------------------------------------ */

static const double axis[3] = {1 / 3.0, 2 / 3.0, -2 / 3.0};

/* A lantern about the origin, open towards the axis within `angle` of it. */
static void start_lantern(struct bench *b, double angle)
{
    enum { SIDES = 2048 };
    const struct vec3 a = vec3_load(axis),
                      x = vec3_normalize(vec3_cross(a, (struct vec3){0, 1, 0})),
                      y = vec3_cross(a, x);
    struct shape s = shape_create(2 * SIDES + 1, 3 * SIDES);
    for (uint32_t i = 0; i < SIDES; i++) {
        const double turn = 2 * PI * i / SIDES;
        for (uint32_t ring = 0; ring < 2; ring++) {
            const double polar = ring ? (angle + PI) / 2 : angle;
            const struct vec3 around = vec3_fma(vec3_scale(cos(turn), x), sin(turn), y);
            vec3_store(s.position + 3 * (2 * i + ring),
                       vec3_fma(vec3_scale(cos(polar), a), sin(polar), around));
        }
        const uint32_t here = 2 * i, next = 2 * ((i + 1) % SIDES), end = 2 * SIDES;
        const uint32_t three[9] = {here,     here + 1, next, next,    here + 1,
                                   next + 1, here + 1, end,  next + 1};
        memcpy(s.index + 9 * i, three, sizeof three);
    }
    vec3_store(s.position + 6 * SIDES, vec3_scale(-1, a));
    bench_start(b);
    add_shape(b, &s, material(0, 0));
    shape_clear(&s);
    bench_finish(b, 1);
}

static double length_of(const struct capture_probe *p)
{
    return (double)p->bent_length;
}

static double cosine_of(const struct capture_probe *p)
{
    return (double)p->cone[3];
}

static double along_axis(const struct capture_probe *p)
{
    return axis[0] * (double)p->cone[0] + axis[1] * (double)p->cone[1] +
           axis[2] * (double)p->cone[2];
}

/* What is open is a cone of half angle 30 or 100 degrees: its cosine comes out, and its axis. */
static void test_cones(void)
{
    const float normal[3] = {(float)axis[0], (float)axis[1], (float)axis[2]};
    const double origin[3] = {0};
    const struct capture_settings s = settings_of(CAPTURE_OCCLUSION);
    for (int k = 0; k < 2; k++) {
        struct bench b;
        const double angle = (k ? 100 : 30) * PI / 180, c = cos(angle);
        start_lantern(&b, angle);
        check("a point's open cone", estimate(&b, s, origin, NULL, cosine_of), c, 1e-6);
        check("its bent normal's length", estimate(&b, s, origin, NULL, length_of), (1 + c) / 2,
              1e-6);
        const double off = 1 - estimate(&b, s, origin, NULL, along_axis).mean;
        ok(off < 1e-3 && off > -1e-6, "its axis (1 - %.1e)", off);
        if (!k) {
            check("a surface's about its normal", estimate(&b, s, origin, normal, cosine_of), c,
                  1e-6);
            check("its bent normal's length", estimate(&b, s, origin, normal, length_of),
                  2.0 / 3 * (1 + c + c * c) / (1 + c), 1e-6);
        }
        bench_clear(&b);
    }
    struct capture_probe open, shut;
    struct bench b;
    bench_start(&b);
    bench_finish(&b, 1);
    must(capture_probe(&b.path, &s, origin, normal, &open));
    ok(open.ao == 1 && open.cone[3] == 0, "of a surface in the open, half of all directions");
    must(capture_probe(&b.path, &s, origin, NULL, &open));
    ok(open.bent_length < 0.01f && open.cone[3] < -0.98f, "of a point there, all of them");
    bench_clear(&b);
    bench_start(&b);
    add_cube(&b, 1, material(0, 0));
    bench_finish(&b, 1);
    must(capture_probe(&b.path, &s, origin, NULL, &shut));
    ok(shut.ao == 0 && shut.bent_length == 0 && shut.cone[0] == 0 && shut.cone[3] == 1,
       "in a closed room none");
    bench_clear(&b);
}

/* -- interreflections ------------------------------------------------------------------------- */

/* All points of a sphere see each part of it alike, so in half of one, under an even sky, all are
 * as bright, and the formula is exact but for the facets. */
static void test_bounced(void)
{
    const float k[3] = {0.25f, 0.5f, 1}, albedo[3] = {0, 0.5f, 1};
    float out[3];
    occlusion_bounced(k[0], albedo, out);
    ok(out[0] == 0.25f && fabs((double)out[1] - 0.25 / 0.625) < 1e-7 && out[2] == 1,
       "what bounces: nothing off black, all off white");
    occlusion_bounced(0, albedo, out);
    ok(out[0] == 0 && out[1] == 0 && out[2] == 0, "and nothing where no light comes in");
    struct bench b;
    bench_start(&b);
    struct shape ball = shape_sphere(1, 4);
    b.settings.sky[0] = b.settings.sky[1] = b.settings.sky[2] = 1;
    for (size_t i = 0; i < 3 * ball.triangle_count; i += 3) { /* inside out */
        const uint32_t other = ball.index[i];
        ball.index[i] = ball.index[i + 1];
        ball.index[i + 1] = other;
    }
    for (size_t i = 0; i < ball.triangle_count; i++) { /* half of it: a bowl */
        const double *p[3];
        for (int c = 0; c < 3; c++)
            p[c] = ball.position + 3 * ball.index[3 * i + (size_t)c];
        if (p[0][1] + p[1][1] + p[2][1] > 0)
            ball.index[3 * i + 1] = ball.index[3 * i + 2] = ball.index[3 * i];
    }
    size_t kept = 0;
    for (size_t i = 0; i < ball.triangle_count; i++)
        if (ball.index[3 * i + 1] != ball.index[3 * i])
            memmove(ball.index + 3 * kept++, ball.index + 3 * i, 3 * sizeof *ball.index);
    ball.triangle_count = kept;
    add_shape(&b, &ball, material(0.8f, 0));
    shape_clear(&ball);
    bench_finish(&b, 64);
    const float up[3] = {0, 1, 0};
    struct capture_settings s = settings_of(CAPTURE_AO | CAPTURE_AO_BOUNCED);
    s.light = CAPTURE_ALL;
    s.rays = 200000;
    struct capture_probe p;
    must(capture_probe(&b.path, &s, (const double[3]){0, -0.995, 0}, up, &p));
    for (int c = 0; c < 3; c++) {
        const double lit = (double)p.sh[c] / PI, error = (double)p.sh_error[c] / PI;
        ok(fabs((double)p.ao_bounced[c] - lit) < 4.5 * error + 0.005,
           "in a bowl of albedo %.1f, where all is as bright: %.4f of the sky's light (%.4f +- "
           "%.4f "
           "path traced), %.4f without",
           0.8 / (1 << c), (double)p.ao_bounced[c], lit, error, (double)p.ao);
    }
    bench_clear(&b);
    bench_start(&b);
    bench_finish(&b, 1);
    must(capture_probe(&b.path, &s, (const double[3]){0}, up, &p));
    ok(isnan(p.ao_bounced[0]), "a point on no surface has no albedo");
    bench_clear(&b);
}

/* -- horizon ---------------------------------------------------------------------------------- */

/* A wall of height 1, d away towards +Z and as good as endless: its edge is atan(cos(a) / d) high
 * at the azimuth a from it. In a sector of 45 degrees, the root of the mean of sin^2. */
static double wall_horizon(double from_wall, double d)
{
    enum { STEPS = 1000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double c = cos(from_wall + PI / 4 * ((i + 0.5) / STEPS - 0.5)), h = c / d;
        sum += c > 0 ? h * h / (1 + h * h) / STEPS : 0;
    }
    return asin(sqrt(sum));
}

static double towards_wall(const struct capture_probe *p)
{
    return (double)p->horizon[2]; /* +X, between, +Z */
}

static double aslant(const struct capture_probe *p)
{
    return (double)p->horizon[1];
}

static double along_wall(const struct capture_probe *p)
{
    return (double)p->horizon[0];
}

static void test_horizon(void)
{
    struct bench b;
    bench_start(&b);
    const double d = 0.5, f = 1e4, origin[3] = {0};
    const float up[3] = {0, 1, 0};
    add_quad(&b, (const double[12]){-f, 0, d, f, 0, d, f, 1, d, -f, 1, d}, material(0, 0));
    bench_finish(&b, 1);
    const struct capture_settings s = settings_of(CAPTURE_AO | CAPTURE_HORIZON);
    check("the horizon towards a wall", estimate(&b, s, origin, up, towards_wall),
          wall_horizon(0, d), 1e-6);
    check("aslant", estimate(&b, s, origin, up, aslant), wall_horizon(PI / 4, d), 1e-6);
    check("along it", estimate(&b, s, origin, up, along_wall), wall_horizon(PI / 2, d), 1e-6);
    struct capture_probe p;
    must(capture_probe(&b.path, &s, origin, up, &p));
    double open = 0;
    for (int i = 0; i < 8; i++)
        open += cos((double)p.horizon[i]) * cos((double)p.horizon[i]) / 8;
    ok(p.horizon[5] == 0 && p.horizon[6] == 0 && p.horizon[7] == 0 &&
           fabs(open - (double)p.ao) < 0.01,
       "behind there is none, and the mean of cos^2 is ambient occlusion (%.4f, %.4f)", open,
       (double)p.ao);
    bench_clear(&b);
}

int main(void)
{
    test_falloff();
    test_obscurance();
    test_unlit();
    test_cones();
    test_bounced();
    test_horizon();
    return tap_done();
}
