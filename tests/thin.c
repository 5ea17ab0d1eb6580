/* SPDX-License-Identifier: Apache-2.0 */
/* Thin sets: probes in one layer or one row, wherever they are, however large and whichever way
 * they face, become triangles of their sheet or segments of their line or walk, in which each probe
 * is found; a known field between them is better than that of the nearest probe; off a plane or
 * line it is continuous, off a walk it is that of the nearest point. What has layers does not. */
#include "base/error.h"
#include "base/warning.h"
#include "interpolate/cells_volume.h"
#include "math/random.h"
#include "support/point_sets.h"
#include "support/tap.h"
#include "tetra/tetra.h"

#include <math.h>
#include <string.h>

enum { MOST = 700, POINTS = 400 };

enum shape {
    FLOOR,
    SCATTERED,
    RAMP,
    STAIR,
    TERRAIN,
    PIPE,
    STRIP,
    LINE,
    BEND,
    RING,
    EIGHT,
    SPIRAL,
    SHAPES
};
static const char *const names[SHAPES] = {"floor",
                                          "scattered floor",
                                          "ramp and floors",
                                          "stair",
                                          "terrain",
                                          "a third of a pipe",
                                          "long strip",
                                          "line",
                                          "walk with a bend",
                                          "ring",
                                          "eight",
                                          "spiral stair"};

static bool is_row(enum shape shape)
{
    return shape >= LINE;
}

/* A place of the shape for u, v in 0 .. 1; probes are about 1 apart. */
static void place_at(enum shape shape, double u, double v, double p[3])
{
    const double turn = 2 * 3.14159265358979 * u;
    p[0] = 20 * u;
    p[1] = 0;
    p[2] = 20 * v;
    if (shape == RAMP)
        p[1] = 0.6 * fmin(fmax(p[0] - 6, 0), 8);
    if (shape == STAIR)
        p[1] = 0.3 * floor(p[0]);
    if (shape == TERRAIN)
        p[1] = 2 * sin(0.4 * p[0]) * cos(0.3 * p[2]);
    if (shape == PIPE) {
        const double angle = 0.5236 + turn / 3; /* 30 to 150 degrees */
        p[0] = -9.5 * cos(angle);
        p[1] = -9.5 * sin(angle);
    }
    if (shape == STRIP) {
        p[0] = 150 * u;
        p[1] = 0.6 * fmin(fmax(p[0] - 40, 0), 80);
        p[2] = 2 * v;
    }
    if (shape == LINE || shape == BEND)
        p[2] = shape == BEND ? 20 * fmax(u - 0.5, 0) * 2 : 0;
    if (shape == BEND)
        p[0] = 20 * fmin(2 * u, 1);
    if (shape == RING || shape == SPIRAL) {
        p[0] = 6 * cos(shape == RING ? turn : 3 * turn);
        p[1] = shape == RING ? 0 : 20 * u;
        p[2] = 6 * sin(shape == RING ? turn : 3 * turn);
    }
    if (shape == EIGHT) {
        p[0] = 10 * sin(turn);
        p[2] = 6 * sin(2 * turn);
    }
}

static double field(const double p[3])
{
    return 2 + cos(0.4 * p[0]) * cos(0.4 * p[2]) + 0.3 * sin(0.35 * p[1]);
}

struct set {
    size_t count;
    double position[3 * MOST], point[3 * POINTS];
    float value[MOST];
    double truth[POINTS];
};

/* Of a shape with noise, turned, scaled and moved. */
static void make_set(enum shape shape, double noise, double scale, double offset, struct set *s)
{
    struct random r = random_start(5, (uint64_t)shape, (uint32_t)(1000 * noise));
    const struct rotation turn = random_rotation(&r);
    const int across = is_row(shape)    ? 1
                       : shape == STRIP ? 3
                                        : 21,
              along = shape == LINE || shape == BEND ? 41
                      : shape == RING                ? 38
                      : shape == EIGHT               ? 64
                      : shape == SPIRAL              ? 120
                      : shape == STRIP               ? 151
                                                     : 21;
    const int closed = shape == RING || shape == EIGHT;
    s->count = (size_t)(across * along);
    for (int i = 0; i < across * along; i++) {
        const int row = i / along;
        double u = (double)(i % along) / (along - !closed),
               v = across > 1 ? (double)row / (across - 1) : 0;
        if (shape == SCATTERED) {
            u = random_double(&r);
            v = random_double(&r);
        }
        place_at(shape, u, v, s->position + 3 * i);
        for (int k = 0; k < 3; k++)
            if (is_row(shape) || k == 1)
                s->position[3 * i + k] += noise * (2 * random_double(&r) - 1) *
                                          (shape == LINE || shape == BEND ? 0.5 : 1);
        s->value[i] = (float)field(s->position + 3 * i);
    }
    for (int i = 0; i < POINTS; i++) {
        double *p = s->point + 3 * i;
        place_at(shape, 0.05 + 0.9 * random_double(&r), 0.05 + 0.9 * random_double(&r), p);
        for (int k = 0; k < 3; k++)
            p[k] += 0.1 * (2 * random_double(&r) - 1);
        s->truth[i] = field(p);
    }
    rotate_points(&turn, s->count, s->position);
    rotate_points(&turn, POINTS, s->point);
    for (size_t i = 0; i < 3 * s->count; i++)
        s->position[i] = scale * (s->position[i] + offset);
    for (size_t i = 0; i < 3 * POINTS; i++)
        s->point[i] = scale * (s->point[i] + offset);
}

static double distance(const double *p, const double *q)
{
    return hypot(hypot(p[0] - q[0], p[1] - q[1]), p[2] - q[2]);
}

static double light_at(const struct probe_volume *v, const struct set *s, const double *p,
                       struct probe_place *place)
{
    float light;
    probe_volume_locate(v, p, place);
    probe_blend(place, s->value, 1, &light);
    return (double)light;
}

static double nearest_light(const struct set *s, const double *p)
{
    size_t best = 0;
    for (size_t i = 1; i < s->count; i++)
        if (distance(s->position + 3 * i, p) < distance(s->position + 3 * best, p))
            best = i;
    return (double)s->value[best];
}

/* How much farther p is from its place than from the nearest of all segments. */
static double missed(const struct tetra *t, const struct set *s, const struct probe_place *place,
                     const double *p)
{
    double best = INFINITY, at[3] = {0};
    for (size_t cell = 0; cell < t->cell_count; cell++) {
        const double *a = s->position + 3 * t->vertex[2 * cell],
                     *b = s->position + 3 * t->vertex[2 * cell + 1];
        double along = 0, square = 0, q[3];
        for (int k = 0; k < 3; k++) {
            along += (p[k] - a[k]) * (b[k] - a[k]);
            square += (b[k] - a[k]) * (b[k] - a[k]);
        }
        along = fmin(fmax(along / square, 0), 1);
        for (int k = 0; k < 3; k++)
            q[k] = a[k] + along * (b[k] - a[k]);
        best = fmin(best, distance(p, q));
    }
    for (int k = 0; k < 12; k++)
        at[k % 3] += place->weight[k / 3] * s->position[3 * place->probe[k / 3] + k % 3];
    return distance(p, at) - best;
}

static struct probe_mesh mesh_of(const struct tetra *t, const struct set *s)
{
    return (struct probe_mesh){.probes = s->count,
                               .position = s->position,
                               .corners = t->corners,
                               .cells = t->cell_count,
                               .vertex = t->vertex,
                               .neighbour = t->neighbour};
}

static void test_shape(enum shape shape, double noise, double scale, double offset)
{
    static struct set s;
    struct tetra t = {0};
    struct tetra_verdict verdict;
    struct tetra_settings settings = tetra_settings_default();
    struct warnings warnings = {0};
    struct probe_volume *v = NULL;
    settings.thin = 0.35;
    make_set(shape, noise, scale, offset, &s);
    must(tetra_make(&t, s.count, s.position, &settings, &warnings));
    struct error *err = tetra_verify(&t, s.count, s.position, &verdict);
    const struct probe_mesh mesh = mesh_of(&t, &s);
    if (!err)
        err = cells_volume_create(&mesh, 0, &v);
    double own = 1, error = 0, error_nearest = 0, miss = 0;
    for (size_t i = 0; i < s.count && !err; i++) {
        struct probe_place place = {.cell = PROBE_COLD};
        double here = 0;
        probe_volume_locate(v, s.position + 3 * i, &place);
        for (int k = 0; k < 4; k++)
            here += place.probe[k] == (int32_t)i ? place.weight[k] : 0;
        own = t.merged && t.merged[i] >= 0 ? own : fmin(own, here);
    }
    for (size_t i = 0; i < POINTS && !err; i++) {
        const double *p = s.point + 3 * i;
        struct probe_place place = {.cell = (int32_t)(i % t.cell_count)}, cold = {.cell = -1};
        const double light = light_at(v, &s, p, &place);
        err = light == light_at(v, &s, p, &cold)
                  ? NULL
                  : error_new("light depends on where the search began");
        error += fabs(light - s.truth[i]) / POINTS;
        error_nearest += fabs(nearest_light(&s, p) - s.truth[i]) / POINTS;
        if (t.thin == TETRA_WALK)
            miss = fmax(miss, missed(&t, &s, &place, p) / scale);
    }
    ok(!err && t.corners == (is_row(shape) ? 2 : 3) && own > 1 - 1e-4 &&
           error < 0.7 * error_nearest && miss < 1e-6 &&
           (!t.thin || warnings.count == 1 + (t.merged_count > 0)),
       "%s, noise %g, scale %g, offset %g: %d corners, own weight %g, error %.4f, nearest %.4f, "
       "miss %.2g%s%s",
       names[shape], noise, scale, offset, t.corners, own, error, error_nearest, miss,
       err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
    probe_volume_destroy(v);
    warnings_clear(&warnings);
    tetra_clear(&t);
}

/* Along lines through a noisy floor and past it, the step in which light changes most is looked at
 * in steps 64 times as fine: there are no jumps. */
static void test_continuity(enum shape shape, double noise)
{
    enum { LINES = 30, STEPS = 1000, FINER = 64 };
    static struct set s;
    struct tetra t = {0};
    struct tetra_settings settings = tetra_settings_default();
    struct probe_volume *v;
    struct random r = random_start(9, (uint64_t)shape, 0);
    settings.thin = 0.35;
    make_set(shape, noise, 1, 0, &s);
    must(tetra_make(&t, s.count, s.position, &settings, NULL));
    const struct probe_mesh mesh = mesh_of(&t, &s);
    must(cells_volume_create(&mesh, 0, &v));
    double left = 0;
    for (int line = 0; line < LINES; line++) {
        double a[3], b[3], p[3], change = 0, last = 0, steepest = 0;
        struct probe_place place = {.cell = PROBE_COLD};
        for (int k = 0; k < 3; k++) {
            a[k] = s.position[3 * (random_u32(&r) % s.count) + (size_t)k] +
                   30 * (random_double(&r) - 0.5);
            b[k] = s.position[3 * (random_u32(&r) % s.count) + (size_t)k] +
                   30 * (random_double(&r) - 0.5);
        }
        for (int i = 0; i <= STEPS; i++) {
            for (int k = 0; k < 3; k++)
                p[k] = a[k] + (b[k] - a[k]) * i / STEPS;
            const double light = light_at(v, &s, p, &place);
            if (i && fabs(light - last) > change) {
                change = fabs(light - last);
                steepest = i;
            }
            last = light;
        }
        for (int i = 0; i <= FINER; i++) { /* the step that changed most, in finer ones */
            for (int k = 0; k < 3; k++)
                p[k] = a[k] + (b[k] - a[k]) * (steepest - 1 + (double)i / FINER) / STEPS;
            const double light = light_at(v, &s, p, &place);
            left = i ? fmax(left, fabs(light - last)) : left;
            last = light;
        }
    }
    ok(left < 0.02, "%s, noise %g: in steps of 1/64000 of a line light changes by %.2g at most",
       names[shape], noise, left);
    probe_volume_destroy(v);
    tetra_clear(&t);
}

/* Storeys of noisy floors, with a ramp or without: tetrahedra between them, and on the lowest and
 * the highest not those of the noise. */
static void test_storeys(void)
{
    static const struct {
        int storeys, side;
        double apart, noise;
        bool ramp;
    } tries[] = {{2, 16, 2, 0.05, false}, {2, 16, 4, 0.05, false}, {3, 14, 4, 0.1, false},
                 {6, 10, 4, 0.05, false}, {2, 16, 8, 0.3, false},  {3, 14, 8, 0.05, false},
                 {2, 16, 6, 0.1, true}};
    static struct set s;
    static struct set mixed;
    for (size_t try = 0; try < sizeof tries / sizeof *tries; try++) {
        struct random r = random_start(11, (uint64_t)try, 0);
        const struct rotation turn = random_rotation(&r);
        const int side = tries[try].side, floor = side * side;
        struct tetra t = {0}, other = {0};
        struct tetra_verdict verdict;
        struct tetra_settings settings = tetra_settings_default();
        struct warnings warnings = {0};
        struct probe_volume *v = NULL, *w = NULL;
        settings.thin = 0.35;
        s.count = 0;
        for (int i = 0; i < tries[try].storeys * floor; i++) {
            double *p = s.position + 3 * s.count;
            p[0] = i % side;
            p[1] = i / floor * tries[try].apart + tries[try].noise * (2 * random_double(&r) - 1);
            p[2] = i % floor / side;
            s.value[s.count++] = (float)field(p);
        }
        for (int i = 0; i < 40 && tries[try].ramp; i++) { /* down from the upper floor */
            double *p = s.position + 3 * s.count;
            p[0] = side + i / 4 * 0.8;
            p[1] = tries[try].apart - i / 4 * 0.6;
            p[2] = 5 + i % 4;
            s.value[s.count++] = (float)field(p);
        }
        for (int i = 0; i < POINTS; i++) {
            double *p = s.point + 3 * i;
            p[0] = 0.5 + (side - 2) * random_double(&r);
            p[1] = i % tries[try].storeys * tries[try].apart + 0.2 * random_double(&r) - 0.1;
            p[2] = 0.5 + (side - 2) * random_double(&r);
            s.truth[i] = field(p);
        }
        rotate_points(&turn, s.count, s.position);
        rotate_points(&turn, POINTS, s.point);
        mixed = s;
        for (size_t i = 0; i < s.count; i++) { /* backwards */
            memcpy(mixed.position + 3 * i, s.position + 3 * (s.count - 1 - i),
                   3 * sizeof *s.position);
            mixed.value[i] = s.value[s.count - 1 - i];
        }
        must(tetra_make(&t, s.count, s.position, &settings, &warnings));
        must(tetra_make(&other, s.count, mixed.position, &settings, NULL));
        struct error *err = tetra_verify(&t, s.count, s.position, &verdict);
        const struct probe_mesh mesh = mesh_of(&t, &s), mesh_mixed = mesh_of(&other, &mixed);
        must(cells_volume_create(&mesh, 0, &v));
        must(cells_volume_create(&mesh_mixed, 0, &w));
        double error = 0, error_nearest = 0, unlike = 0, miss = 0;
        struct probe_place place = {.cell = PROBE_COLD};
        for (size_t i = 0; i < POINTS; i++) {
            const double *p = s.point + 3 * i, light = light_at(v, &s, p, &place);
            struct probe_place there = {.cell = PROBE_COLD};
            error += fabs(light - s.truth[i]) / POINTS;
            error_nearest += fabs(nearest_light(&s, p) - s.truth[i]) / POINTS;
            unlike = fmax(unlike, fabs(light_at(w, &mixed, p, &there) - light));
        }
        for (size_t i = 0; i < s.count; i++)
            miss =
                fmax(miss, fabs(light_at(v, &s, s.position + 3 * i, &place) - (double)s.value[i]));
        ok(!err && t.corners == 4 && verdict.dents > 0 && error < 0.6 * error_nearest &&
               miss < 1e-5 && unlike < 1e-5 && warnings.count == 0,
           "%d storeys, %g apart, noise %g%s: error %.4f, nearest %.4f, at probes %.1g, after "
           "shuffling %.1g%s%s",
           tries[try].storeys, tries[try].apart, tries[try].noise,
           tries[try].ramp ? ", with a ramp" : "", error, error_nearest, miss, unlike,
           err ? ": " : "", err ? error_message(err) : "");
        error_destroy(err);
        probe_volume_destroy(v);
        probe_volume_destroy(w);
        warnings_clear(&warnings);
        tetra_clear(&t);
        tetra_clear(&other);
    }
}

/* A noisy floor beside a volume stays full of the floor's noise: that is told. */
static void test_beside(void)
{
    static struct set s;
    struct random r = random_start(12, 0, 0);
    struct tetra t = {0};
    struct tetra_settings settings = tetra_settings_default();
    struct warnings warnings = {0};
    settings.thin = 0.35;
    s.count = 616;
    for (size_t i = 0; i < s.count; i++) {
        const size_t k = i - 400;
        double *p = s.position + 3 * i;
        p[0] = i < 400 ? (double)(i % 20) : 20 + (double)(k % 6);
        p[1] = i < 400 ? 0.1 * (2 * random_double(&r) - 1) : (double)(k / 6 % 6);
        p[2] = i < 400 ? (double)(i / 20) : (double)(k / 36) + 0.02 * random_double(&r);
    }
    must(tetra_make(&t, s.count, s.position, &settings, &warnings));
    ok(t.corners == 4 && warnings_of_kind(&warnings, "far") == 1,
       "of the noise of a floor beside a volume one is told");
    warnings_clear(&warnings);
    tetra_clear(&t);
}

/* Two layers, boxes of 1:4, random ones, few: tetrahedra, and not a word. */
static void test_full(void)
{
    static struct set s;
    for (int kind = 0; kind < 12; kind++) {
        struct random r = random_start(3, (uint64_t)kind, 0);
        struct tetra t = {0};
        struct tetra_settings settings = tetra_settings_default();
        struct warnings warnings = {0};
        const double side[3] = {kind == 1 || kind == 4 ? 4 : 1, kind == 2 ? 4 : 1,
                                kind == 3 ? 0.5 : 1};
        const int layers = kind % 4 == 0 ? 2 : 5;
        settings.thin = 0.35;
        s.count = kind >= 8 ? (size_t)(5 + 20 * (kind - 8)) : (size_t)(100 * layers);
        for (size_t i = 0; i < s.count; i++) {
            const double grid[3] = {(double)(i % 10), (double)(i / 100), (double)(i / 10 % 10)};
            for (int k = 0; k < 3; k++)
                s.position[3 * i + (size_t)k] =
                    kind >= 8 ? random_double(&r)
                              : side[k] * (grid[k] + (kind >= 5 ? 0.2 * random_double(&r) : 0));
        }
        must(tetra_make(&t, s.count, s.position, &settings, &warnings));
        ok(t.corners == 4 && warnings.count == 0, "what fills space (%d: %zu probes) is not thin",
           kind, s.count);
        warnings_clear(&warnings);
        tetra_clear(&t);
    }
}

int main(void)
{
    static const double noises[] = {0, 0.1, 0.2, 0.3};
    for (int shape = 0; shape < SHAPES; shape++)
        for (int k = 0; k < 4; k++)
            if (shape != SCATTERED || k < 3) /* scattered ones are nearer to some */
                test_shape((enum shape)shape, noises[k],
                           k == 1   ? 1e-3
                           : k == 2 ? 1e3
                                    : 1,
                           k == 3 ? 1e4 : 0);
    test_continuity(FLOOR, 0.2);
    test_continuity(SCATTERED, 0.1);
    test_continuity(LINE, 0.2);
    test_full();
    test_storeys();
    test_beside();
    return tap_done();
}
