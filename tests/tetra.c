/* SPDX-License-Identifier: Apache-2.0 */
/* Tetrahedra and location: every mesh passes the exact checker, and the checker finds each kind of
 * damage; cells are Delaunay; the order of the points does not matter; weights reproduce linear
 * fields, sum to 1, and go over continuously into those of the hull's nearest point, which is found
 * exactly; what cannot be meshed is refused. */
#include "base/error.h"
#include "base/warning.h"
#include "interpolate/cells_volume.h"
#include "libprobe-query/lattice.h"
#include "math/cell.h"
#include "math/random.h"
#include "support/point_sets.h"
#include "support/tap.h"
#include "tetra/enclose.h"
#include "tetra/sites.h"
#include "tetra/tetra.h"

#include <string.h>

enum { MOST = 4000 };

enum shape {
    RANDOM,
    GRID,
    ROTATED_GRID,
    NOISY_GRID,
    SHELL,
    CLUSTERS,
    FLAT_SLAB,
    FAR_AWAY,
    TINY,
    HUGE_SCALE,
    SHAPES
};
static const char *const shape_names[] = {"random",     "grid",      "rotated grid", "noisy grid",
                                          "shell",      "clusters",  "flat slab",    "far away",
                                          "tiny scale", "huge scale"};

/* Points of a shape; returns how many. */
static size_t make(enum shape shape, size_t count, struct random *r, double *p)
{
    const size_t side = (size_t)(cbrt((double)count) + 0.5);
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        double q[3] = {random_double(r), random_double(r), random_double(r)};
        if (shape == GRID || shape == ROTATED_GRID || shape == NOISY_GRID) {
            if (i >= side * side * side)
                break;
            const double g[3] = {(double)(i % side), (double)(i / side % side),
                                 (double)(i / side / side)};
            const double noise = shape == NOISY_GRID ? 1e-9 : 0;
            for (int k = 0; k < 3; k++)
                q[k] = g[k] + noise * q[k];
            if (shape == ROTATED_GRID) { /* about z, by an angle whose sine is 0.6 */
                q[0] = 0.8 * g[0] - 0.6 * g[1];
                q[1] = 0.6 * g[0] + 0.8 * g[1];
            }
        } else if (shape == SHELL) {
            double length = 0;
            for (int k = 0; k < 3; k++)
                length += (q[k] - 0.5) * (q[k] - 0.5);
            for (int k = 0; k < 3; k++)
                q[k] = (q[k] - 0.5) / sqrt(length);
        } else if (shape == CLUSTERS) {
            const double scale = pow(10, -3.0 * (double)(i % 4));
            for (int k = 0; k < 3; k++)
                q[k] = q[k] * scale + (double)(i % 4);
        } else if (shape == FLAT_SLAB) {
            q[2] *= 1e-6;
        } else {
            const double scale = shape == TINY         ? 1e-60
                                 : shape == HUGE_SCALE ? 1e60
                                                       : 1,
                         offset = shape == FAR_AWAY ? 1e7 : 0;
            for (int k = 0; k < 3; k++)
                q[k] = q[k] * scale + offset;
        }
        memcpy(p + 3 * n++, q, sizeof q);
    }
    return n;
}

/* A volume of the cells that were made, as programs use it; light outside is that of the hull's
 * nearest point. */
static struct error *volume_of(const struct tetra *t, size_t n, const double *p,
                               struct probe_volume **volume)
{
    const struct probe_mesh mesh = {.probes = n,
                                    .position = p,
                                    .corners = t->corners,
                                    .cells = t->cell_count,
                                    .vertex = t->vertex,
                                    .neighbour = t->neighbour};
    return cells_volume_create(&mesh, PROBE_NEAREST, volume);
}

static double linear(const double *p)
{
    return 3 + 2 * p[0] - p[1] + 0.5 * p[2];
}

static void test_shapes(void)
{
    static double p[3 * MOST];
    for (int shape = 0; shape < SHAPES; shape++) {
        struct random r = random_start(1, (uint64_t)shape, 0);
        size_t broken = 0, delaunay = 0, sets = 0;
        double worst_sum = 0, worst_field = 0;
        for (size_t count = 4; count <= 1000; count = count * 2 + 1) {
            const size_t n = make((enum shape)shape, count < 8 ? 8 : count, &r, p);
            struct tetra t;
            struct error *err = tetra_build(&t, n, p, NULL);
            if (err) {
                printf("# %s, %zu points: %s\n", shape_names[shape], n, error_message(err));
                error_destroy(err);
                broken++;
                continue;
            }
            sets++;
            struct tetra_verdict verdict;
            must(tetra_verify(&t, n, p, &verdict));
            delaunay += t.stretched ? 0 : verdict.not_delaunay;
            struct probe_volume *l = NULL;
            must(volume_of(&t, n, p, &l));
            struct probe_place w = {.cell = PROBE_COLD};
            for (int i = 0; i < 200; i++) { /* inside: between two probes */
                const double *a = p + 3 * (random_u32(&r) % n), *b = p + 3 * (random_u32(&r) % n),
                             s = random_double(&r);
                double q[3], got = 0, sum = 0, scale = 0;
                for (int k = 0; k < 3; k++)
                    q[k] = a[k] + s * (b[k] - a[k]);
                probe_volume_locate(l, q, &w);
                for (int k = 0; k < 4; k++) {
                    sum += w.weight[k];
                    got += w.weight[k] * linear(p + 3 * (size_t)w.probe[k]);
                    scale = fmax(scale, fabs(linear(p + 3 * (size_t)w.probe[k]) - linear(p)));
                }
                worst_sum = fmax(worst_sum, fabs(sum - 1));
                worst_field = fmax(worst_field, fabs(got - linear(q)) /
                                                    (scale + 1e-300 + 1e-9 * fabs(linear(q))));
            }
            probe_volume_destroy(l);
            tetra_clear(&t);
        }
        ok(!broken && sets >= 8, "%s: %zu sets are meshed and pass the exact checker",
           shape_names[shape], sets);
        ok(delaunay == 0, "%s: cells are Delaunay, or up to the tolerance of a stretch",
           shape_names[shape]);
        ok(worst_sum < 1e-12, "%s: weights sum to 1 (%.1e)", shape_names[shape], worst_sum);
        ok(worst_field < 1e-4, "%s: a linear field comes back, relative to its change (%.1e)",
           shape_names[shape], worst_field);
    }
}

static int compare_rows(const void *a, const void *b)
{
    return memcmp(a, b, 4 * sizeof(double[3]));
}

/* Cells as corner positions, sorted: what does not depend on the order of rows. */
static double *geometry(const struct tetra *t, const double *p)
{
    double *g = calloc(12 * t->cell_count, sizeof *g);
    for (size_t i = 0; i < 4 * t->cell_count; i++)
        memcpy(g + 3 * i, p + 3 * (size_t)t->vertex[i], 3 * sizeof *g);
    qsort(g, t->cell_count, 12 * sizeof *g, compare_rows);
    return g;
}

static void test_order(void)
{
    static double p[3 * MOST], q[3 * MOST];
    for (int shape = 0; shape < SHAPES; shape++) {
        struct random r = random_start(2, (uint64_t)shape, 0);
        const size_t n = make((enum shape)shape, 343, &r, p);
        memcpy(q, p, 3 * n * sizeof *p);
        for (size_t i = n - 1; i > 0; i--) {
            const size_t j = random_u32(&r) % (i + 1);
            double swap[3];
            memcpy(swap, q + 3 * i, sizeof swap);
            memcpy(q + 3 * i, q + 3 * j, sizeof swap);
            memcpy(q + 3 * j, swap, sizeof swap);
        }
        struct tetra a, b;
        must(tetra_build(&a, n, p, NULL));
        must(tetra_build(&b, n, q, NULL));
        double *g = geometry(&a, p), *h = geometry(&b, q);
        ok(a.cell_count == b.cell_count && !memcmp(g, h, 12 * a.cell_count * sizeof *g),
           "%s: shuffled points have the same cells", shape_names[shape]);
        free(g);
        free(h);
        tetra_clear(&a);
        tetra_clear(&b);
    }
}

/* Of points, their ranks in canonical order; of cells, the least of each: in order, also where
 * cells were peeled off. */
static void test_cell_order(void)
{
    static double p[3 * MOST];
    static int32_t rank[MOST];
    size_t peeled = 0;
    for (int kind = 0; kind < 5; kind++) {
        struct random r = random_start(12, (uint64_t)kind, 0);
        const struct rotation rotation = random_rotation(&r);
        const bool plane = kind > 2;
        const size_t side = plane ? 40 : 12,
                     n = kind == 0 ? 2000 : side * side * (plane ? 1 : side);
        for (size_t i = 0; i < n; i++) {
            const double g[3] = {(double)(i % side), (double)(i / side % side),
                                 (double)(i / side / side)};
            for (int k = 0; k < 3; k++)
                p[3 * i + (size_t)k] = kind == 0 ? random_double(&r)
                                                 : g[k] + (kind == 2        ? 1e-6
                                                           : plane && k < 2 ? 1e-4
                                                                            : 0) *
                                                              random_double(&r);
        }
        if (kind)
            rotate_points(&rotation, n, p);
        struct sites sites;
        struct tetra t;
        must(sites_make(&sites, n, p, &(struct sites_settings){.merge = 1e-12, .threads = 1}));
        must(tetra_build(&t, n, p, NULL));
        for (size_t i = 0; i < sites.count; i++)
            rank[sites.row[i]] = (int32_t)i;
        bool first = true, ordered = t.corners == (plane ? 3 : 4);
        int32_t last = 0;
        for (size_t cell = 0; cell < t.cell_count; cell++) {
            int32_t least = INT32_MAX;
            for (int k = 0; k < t.corners; k++) {
                const int32_t here = rank[t.vertex[(size_t)t.corners * cell + (size_t)k]];
                least = here < least ? here : least;
            }
            first = first && (t.corners < 4 || rank[t.vertex[4 * cell]] == least);
            ordered = ordered && least >= last;
            last = least;
        }
        ok(ordered && first, "set %d: cells in order of their first vertex, %zu were peeled off",
           kind, t.peeled);
        peeled += t.peeled;
        tetra_clear(&t);
        sites_clear(&sites);
    }
    ok(peeled > 100, "%zu cells in all were peeled off these", peeled);
}

static void refused(size_t n, const double *p, const char *message)
{
    struct tetra t;
    struct error *err = tetra_build(&t, n, p, NULL);
    ok(err && strstr(error_message(err), message), "refused: %s",
       err ? error_message(err) : "(accepted)");
    error_destroy(err);
    tetra_clear(&t);
}

/* Cells of so many corners, so many of them, sound. */
static void flat(const char *name, size_t n, const double *p, int corners, size_t cells)
{
    struct tetra t;
    struct tetra_verdict verdict;
    must(tetra_build(&t, n, p, NULL));
    struct error *err = tetra_verify(&t, n, p, &verdict);
    ok(!err && t.corners == corners && t.cell_count == cells, "%s: %zu cells of %d corners%s%s",
       name, t.cell_count, t.corners, err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
    tetra_clear(&t);
}

static void test_flat(void)
{
    double p[3 * 400] = {0};
    refused(0, p, "there are no probes");
    flat("probes at one place", 20, p, 1, 1);
    flat("two probes", 2, (double[]){0, 0, 0, 1, 0, 0}, 2, 1);
    flat("three probes", 3, (double[]){0, 0, 0, 1, 0, 0, 0, 1, 0}, 3, 1);
    for (int i = 0; i < 20; i++)
        p[3 * i] = p[3 * i + 1] = p[3 * i + 2] = 0.1 * ((i * 7) % 20);
    flat("a slanted line", 20, p, 2, 19);
    struct random r = random_start(3, 0, 0);
    for (int turn = 0; turn < 10; turn++) {
        const struct rotation rotation = random_rotation(&r);
        for (int i = 0; i < 400; i++) {
            p[3 * i] = i % 20;
            p[3 * i + 1] = (double)(i / 20);
            p[3 * i + 2] = 0;
        }
        rotate_points(&rotation, 400, p);
        flat("a grid in a slanted plane", 400, p, 3, 2 * 19 * 19);
    }
    p[7] = NAN;
    refused(20, p, "probe 2: expected a finite position");
    p[7] = INFINITY;
    refused(20, p, "probe 2: expected a finite position");
}

/* Of probes that are nearer than asked for, one with light stands for the others, whatever their
 * order. */
static void test_merging(void)
{
    double p[3 * 20];
    float light[20];
    struct random r = random_start(7, 0, 0);
    for (int i = 0; i < 60; i++)
        p[i] = random_double(&r);
    for (int i = 0; i < 20; i++)
        light[i] = i == 17 || i < 10 ? 1.0f : NAN;
    memcpy(p + 3 * 17, p + 3 * 12, 3 * sizeof *p); /* 17 has light, 12 has none */
    for (int k = 0; k < 3; k++)
        p[3 * 15 + k] = p[3 * 3 + k] + 1e-5;
    struct tetra_settings settings = tetra_settings_default();
    settings.light = light;
    settings.light_width = 1;
    struct warnings w = {0};
    struct tetra t;
    must(tetra_make(&t, 20, p, &settings, &w));
    ok(t.merged_count == 1 && t.merged[12] == 17 && t.merged[17] == -1 &&
           warnings_of_kind(&w, "merged") == 1,
       "a duplicate without light is merged with one that has some, with a warning");
    tetra_clear(&t);
    warnings_clear(&w);
    settings.merge = 1e-4;
    must(tetra_make(&t, 20, p, &settings, NULL));
    struct tetra_verdict verdict;
    struct error *err = tetra_verify(&t, 20, p, &verdict);
    ok(!err && t.merged_count == 2 && t.merged[15] == 3, "and so is what is nearer than asked for");
    error_destroy(err);
    t.merged[15] = -1;
    err = tetra_verify(&t, 20, p, &verdict);
    ok(err && strstr(error_message(err), "probe 15 is in no cell"),
       "a probe that is neither used nor merged is found: %s", error_message(err));
    error_destroy(err);
    tetra_clear(&t);
}

/* Thin boxes of probes, of which so many are merged that what is left may lie in a plane or on a
 * line, and another one than all did: whatever spans them, they verify, and a volume takes them. */
static void test_merging_spans(void)
{
    const int SETS = (int)tap_cases(600);
    struct random r = random_start(11, 0, 0);
    struct tetra_settings settings = tetra_settings_default();
    settings.merge = 0.1;
    int failed = 0, by_corners[5] = {0};
    char first[200] = "";
    for (int set = 0; set < SETS; set++) {
        double p[3 * 16], side[3];
        size_t n = 0;
        for (int k = 0; k < 3; k++)
            side[k] = (k == 0 ? 1 : 0.3) * random_double(&r);
        for (int node = 0; node < 18; node++) /* 3 x 3 x 2 nodes, some left out */
            if (n < 16 && random_u32(&r) % 4) {
                p[3 * n] = side[0] * (node % 3);
                p[3 * n + 1] = side[1] * (node / 3 % 3);
                p[3 * n++ + 2] = side[2] * (double)(node / 9);
            }
        struct tetra t;
        struct tetra_verdict verdict;
        struct error *err = n ? tetra_make(&t, n, p, &settings, NULL) : NULL;
        if (!err && n) {
            struct probe_volume *volume = NULL;
            by_corners[t.corners]++;
            err = tetra_verify(&t, n, p, &verdict);
            if (!err)
                err = volume_of(&t, n, p, &volume);
            probe_volume_destroy(volume);
            tetra_clear(&t);
        }
        if (err && !failed++)
            snprintf(first, sizeof first, "set %d: %s", set, error_message(err));
        error_destroy(err);
    }
    ok(!failed && by_corners[4] > SETS / 20 && by_corners[3] > SETS / 20 &&
           by_corners[2] > SETS / 100,
       "thin boxes with many merged: %d tetrahedra, %d triangles, %d segments, %d do not verify %s",
       by_corners[4], by_corners[3], by_corners[2], failed, first);
}

/* Grids, turned and disturbed: no slivers to speak of, and all of the box. */
static void test_slivers(void)
{
    enum { SIDE = 12, POINTS = SIDE * SIDE * SIDE };
    static double p[3 * POINTS];
    static const double noises[] = {0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3};
    struct random r = random_start(8, 0, 0);
    for (size_t n = 0; n < sizeof noises / sizeof *noises; n++) {
        size_t slivers = 0, cells = 0, dents = 0;
        double tolerance = 0, volume = INFINITY;
        for (int turn = 0; turn < 4; turn++) {
            const struct rotation rotation = random_rotation(&r);
            for (int i = 0; i < POINTS; i++) {
                const int g[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
                for (int k = 0; k < 3; k++)
                    p[3 * i + k] = g[k] + noises[n] * (2 * random_double(&r) - 1);
            }
            rotate_points(&rotation, turn ? POINTS : 0, p);
            struct tetra t;
            struct tetra_report report;
            struct tetra_verdict verdict;
            must(tetra_build(&t, POINTS, p, NULL));
            must(tetra_verify(&t, POINTS, p, &verdict));
            must(tetra_measure(&t, POINTS, p, &report));
            slivers += report.angle_histogram[0];
            cells += report.cells;
            dents += verdict.dents;
            tolerance = fmax(tolerance, verdict.tolerance);
            volume = fmin(volume, report.volume / pow(SIDE - 1, 3));
            tetra_clear(&t);
        }
        ok((double)slivers <= 1e-3 * (double)cells && tolerance <= 1.0 / 64 && volume > 1 - 1e-3,
           "a grid with noise %g: %zu slivers of %zu cells, Delaunay to %.1e, %zu dents, volume "
           "%.6f",
           noises[n], slivers, cells, tolerance, dents, volume);
    }
}

/* Each damage to a sound mesh is found. */
static void test_checker(void)
{
    static double p[3 * 100];
    struct random r = random_start(4, 0, 0);
    const size_t n = make(RANDOM, 100, &r, p);
    struct tetra t;
    must(tetra_build(&t, n, p, NULL));
    const size_t cells = t.cell_count;
    int missed = 0;
    for (int i = 0; i < 2000; i++) {
        const size_t at = random_u32(&r) % (4 * cells);
        int32_t *index = random_u32(&r) % 2 ? t.vertex : t.neighbour;
        const int32_t was = index[at],
                      now = (int32_t)(random_u32(&r) % (index == t.vertex ? n : cells)) -
                            (index != t.vertex);
        if (now == was)
            continue;
        index[at] = now;
        struct error *err = tetra_check(&t, n, p);
        missed += !err;
        error_destroy(err);
        index[at] = was;
    }
    ok(missed == 0, "2000 damaged meshes: %d pass", missed);
    t.cell_count--;
    struct error *err = tetra_check(&t, n, p);
    ok(err != NULL, "a missing cell is found");
    error_destroy(err);
    tetra_clear(&t);
}

static void test_measure(void)
{
    static double p[3 * 343];
    struct random r = random_start(5, 0, 0);
    const size_t n = make(GRID, 343, &r, p);
    struct tetra t;
    struct tetra_report report;
    must(tetra_build(&t, n, p, NULL));
    must(tetra_measure(&t, n, p, &report));
    ok(fabs(report.volume - 216) < 1e-6 && fabs(report.hull_volume - 216) < 1e-6,
       "a grid's volume is its box's: %.9f", report.volume);
    ok(report.hull_vertices == 343 - 125 && report.unused_points == 0,
       "all of its outer nodes are on the hull");
    ok(report.angle_least > 30, "an exact grid has no slivers: %.1f degrees", report.angle_least);
    bool good = true;
    for (size_t i = 0; i < n; i++) {
        const float *h = t.hull_normal + 3 * i;
        for (size_t k = 0; k < 3; k++) {
            const bool low = p[3 * i + k] == 0, high = p[3 * i + k] == 6;
            good = good && (low ? h[k] < -0.2f : high ? h[k] > 0.2f : fabsf(h[k]) < 0.35f);
        }
    }
    ok(good, "hull normals point outward");
    tetra_clear(&t);
}

/* Nearest point of the hull by trying every face, at a fine barycentric raster: an upper bound of
 * the distance. */
static double raster_distance(const struct tetra *t, const double *p, const double q[3])
{
    enum { STEPS = 40 };
    double best = INFINITY;
    for (size_t i = 0; i < 4 * t->cell_count; i++) {
        if (t->neighbour[i] >= 0)
            continue;
        const double *c[3];
        for (int k = 0; k < 3; k++)
            c[k] = p + 3 * (size_t)t->vertex[i / 4 * 4 + (size_t)cell_face[i % 4][k]];
        for (int a = 0; a <= STEPS; a++)
            for (int b = 0; a + b <= STEPS; b++) {
                double square = 0;
                for (int k = 0; k < 3; k++) {
                    const double x =
                        (a * c[0][k] + b * c[1][k] + (STEPS - a - b) * c[2][k]) / STEPS - q[k];
                    square += x * x;
                }
                best = fmin(best, sqrt(square));
            }
    }
    return best;
}

static void test_outside(void)
{
    static double p[3 * 200];
    struct random r = random_start(6, 0, 0);
    const size_t n = make(RANDOM, 200, &r, p);
    struct tetra t;
    struct probe_volume *l = NULL;
    must(tetra_build(&t, n, p, NULL));
    must(volume_of(&t, n, p, &l));
    double worst = 0, worst_step = 0;
    bool flags = true, same = true;
    struct probe_place w = {.cell = PROBE_COLD}, cold;
    for (int i = 0; i < 300; i++) {
        const double q[3] = {4 * random_double(&r) - 1.5, 4 * random_double(&r) - 1.5,
                             4 * random_double(&r) - 1.5};
        probe_volume_locate(l, q, &w);
        double at[3] = {0};
        for (int k = 0; k < 4; k++)
            for (int m = 0; m < 3; m++)
                at[m] += w.weight[k] * p[3 * (size_t)w.probe[k] + (size_t)m];
        const double distance = sqrt((at[0] - q[0]) * (at[0] - q[0]) +
                                     (at[1] - q[1]) * (at[1] - q[1]) +
                                     (at[2] - q[2]) * (at[2] - q[2]));
        flags = flags && fabs(distance - w.distance) < 1e-9 && w.inside == (w.distance == 0);
        if (!w.inside)
            worst = fmax(worst, w.distance - raster_distance(&t, p, q));
        cold = (struct probe_place){.cell = PROBE_COLD};
        probe_volume_locate(l, q, &cold);
        double other[3] = {0};
        for (int k = 0; k < 4; k++)
            for (int m = 0; m < 3; m++)
                other[m] += cold.weight[k] * p[3 * (size_t)cold.probe[k] + (size_t)m];
        same = same &&
               fabs(other[0] - at[0]) + fabs(other[1] - at[1]) + fabs(other[2] - at[2]) < 1e-9 &&
               cold.inside == w.inside;
        /* A small step moves the interpolated place by no more: the nearest point of a convex
         * body. */
        const double q2[3] = {q[0] + 1e-6, q[1], q[2]};
        probe_volume_locate(l, q2, &w);
        double moved = 0;
        for (int m = 0; m < 3; m++) {
            double x = -at[m];
            for (int k = 0; k < 4; k++)
                x += w.weight[k] * p[3 * (size_t)w.probe[k] + (size_t)m];
            moved += x * x;
        }
        worst_step = fmax(worst_step, sqrt(moved) / 1e-6);
    }
    ok(flags, "inside or outside, distance is that of the place whose light is given");
    ok(worst < 1e-9, "outside, no raster point of the hull is nearer (%.1e)", worst);
    ok(same, "a cold start finds the same place as a walk");
    ok(worst_step < 1.001,
       "the place moves no faster than the point, across the hull as well: %.4f", worst_step);

    bool exact = true;
    for (size_t i = 0; i < n; i++) {
        probe_volume_locate(l, p + 3 * i, &w);
        float value[200], got;
        for (size_t k = 0; k < n; k++)
            value[k] = k == i ? 1 : NAN; /* what has no weight has no say */
        for (int k = 0; k < 4; k++)
            if (w.weight[k] > 0 && w.weight[k] < 1e-9)
                value[w.probe[k]] = 0;
        probe_blend(&w, value, 1, &got);
        exact = exact && got == 1;
    }
    ok(exact, "at a probe, the light is the probe's");
    const double far[3] = {1e300, -1e300, 1e299};
    probe_volume_locate(l, far, &w);
    const double sum = w.weight[0] + w.weight[1] + w.weight[2] + w.weight[3];
    ok(!w.inside && fabs(sum - 1) < 1e-12, "a point at 1e300 has weights");
    probe_volume_destroy(l);

    int32_t was = t.vertex[5];
    t.vertex[5] = 1000;
    struct error *err = volume_of(&t, n, p, &l);
    ok(err && !l, "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    t.vertex[5] = was;
    was = t.neighbour[5];
    t.neighbour[5] = (int32_t)t.cell_count;
    err = volume_of(&t, n, p, &l);
    ok(err && !l, "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    t.neighbour[5] = was;
    tetra_clear(&t);
}

/* A box's corners, each once, but those where a point stands. */
static void test_enclose(void)
{
    const double p[9] = {0, 0, 0, 2, 1, 0, 1, 1, 4};
    double corner[8][3];
    const struct box own = enclose_box(3, p, 0), grown = enclose_box(3, p, 0.25);
    ok(own.low[0] == 0 && own.high[0] == 2 && own.high[1] == 1 && own.high[2] == 4,
       "the box of the points");
    ok(grown.low[0] == -1 && grown.low[1] == -1 && grown.low[2] == -1 && grown.high[0] == 3 &&
           grown.high[1] == 2 && grown.high[2] == 5,
       "grown by a share of its longest side, all round");
    ok(enclose_corners(3, p, &grown, corner) == 8, "eight corners");
    bool apart = true;
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < i; j++)
            apart = apart && memcmp(corner[i], corner[j], sizeof *corner);
    ok(apart && corner[0][0] == -1 && corner[1][0] == 3 && corner[2][1] == 2 && corner[4][2] == 5 &&
           corner[7][0] == 3 && corner[7][1] == 2 && corner[7][2] == 5,
       "all apart, x first");
    ok(enclose_corners(3, p, &own, corner) == 6 && corner[0][0] == 2 && corner[0][1] == 0 &&
           corner[1][0] == 0 && corner[1][1] == 1,
       "none where a point stands");
    const struct box flat = {{0, 0, 3}, {2, 1, 3}}, point = {{5, 5, 5}, {5, 5, 5}};
    ok(enclose_corners(3, p, &flat, corner) == 4, "four of a flat box");
    ok(enclose_corners(3, p, &point, corner) == 1 && corner[0][0] == 5, "one of a point");
    ok(enclose_corners(3, p, &(struct box){{0, 0, 0}, {0, 0, 0}}, corner) == 0,
       "none of a point that is there");
}

int main(void)
{
    test_enclose();
    test_shapes();
    test_order();
    test_cell_order();
    test_flat();
    test_merging();
    test_merging_spans();
    test_slivers();
    test_checker();
    test_measure();
    test_outside();
    return tap_done();
}
