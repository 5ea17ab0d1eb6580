/* SPDX-License-Identifier: Apache-2.0 */
/* Which of their cell's probes points see: exact before a flat wall, the same from both sides of a
 * face, never less than all of the weight; kept by volumes and packed files alike.
 */
#include "leak/sight.h"
#include "leak/leak.h"
#include "leak/sight_fit.h"
#include "libprobe-query/probe-query.h"
#include "libprobe-query/sight.h"
#include "math/random.h"
#include "support/capture_bench.h"
#include "support/tap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- a mesh ----------------------------------------------------------------------------------- */

enum { SIDE = 5, PROBES = SIDE * SIDE * SIDE, CUBES = SIDE - 1, CELLS = 6 * CUBES * CUBES * CUBES };

/* Probes at 0 .. 4 of each axis, moved a little; each cube is six tetrahedra (Kuhn 1960), which fit
 * together. */
struct grid {
    double position[3 * PROBES];
    int32_t vertex[4 * CELLS], neighbour[4 * CELLS];
};

static int32_t number(const int at[3])
{
    return at[0] + SIDE * (at[1] + SIDE * at[2]);
}

static bool share_face(const int32_t *a, int corner, const int32_t *b)
{
    int shared = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            shared += i != corner && a[i] == b[j];
    return shared == 3;
}

static void make_grid(struct grid *g, double move)
{
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    struct random r = random_start(1, 0, 0);
    size_t cell = 0;
    for (int i = 0; i < PROBES; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        for (int k = 0; k < 3; k++)
            g->position[3 * i + k] = at[k] + move * (random_double(&r) - 0.5);
    }
    for (int i = 0; i < CUBES * CUBES * CUBES; i++)
        for (int o = 0; o < 6; o++, cell++) {
            int at[3] = {i % CUBES, i / CUBES % CUBES, i / CUBES / CUBES};
            int32_t *v = g->vertex + 4 * cell;
            v[0] = number(at);
            for (int k = 0; k < 3; k++) {
                at[order[o][k]]++;
                v[k + 1] = number(at);
            }
            if (o >= 3) { /* odd orders turn the other way */
                const int32_t swap = v[1];
                v[1] = v[2];
                v[2] = swap;
            }
        }
    for (int c = 0; c < CELLS; c++)
        for (int k = 0; k < 4; k++) {
            g->neighbour[4 * c + k] = -1;
            for (int n = 0; n < CELLS; n++)
                if (n != c && share_face(g->vertex + 4 * c, k, g->vertex + 4 * n))
                    g->neighbour[4 * c + k] = n;
        }
}

static struct leak_mesh mesh_of(const struct grid *g)
{
    return (struct leak_mesh){.probe_count = PROBES,
                              .position = g->position,
                              .corners = 4,
                              .cell_count = CELLS,
                              .vertex = g->vertex,
                              .neighbour = g->neighbour};
}

static struct probe_volume *volume_of(const struct grid *g)
{
    struct probe_volume *v = NULL;
    const struct probe_mesh mesh = {.probes = PROBES,
                                    .position = g->position,
                                    .corners = 4,
                                    .cells = CELLS,
                                    .vertex = g->vertex,
                                    .neighbour = g->neighbour};
    if (probe_volume_create(&v, &mesh, 0, NULL))
        bail("no volume");
    return v;
}

/* Adds a wall: the part of the plane through p with unit normal n that is within `half` of p. */
static void add_wall(struct bench *b, const double p[3], const double n[3], double half)
{
    const struct vec3 normal = vec3_load(n), middle = vec3_load(p);
    const struct vec3 other = fabs(n[0]) < 0.5 ? (struct vec3){1, 0, 0} : (struct vec3){0, 1, 0};
    const struct vec3 u = vec3_normalize(vec3_cross(normal, other)), v = vec3_cross(normal, u);
    double corner[12];
    for (int i = 0; i < 4; i++)
        vec3_store(corner + 3 * i, vec3_fma(vec3_fma(middle, i == 0 || i == 3 ? -half : half, u),
                                            i < 2 ? -half : half, v));
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    const struct scene_material m = material(0.5f, 0);
    must(scene_add_mesh(b->scene, 4, corner, 2, index, &m));
}

/* -- fits ------------------------------------------------------------------------------------- */

/* Rays from a probe through the facets between random neighbours; what they meet is a plane. */
static void test_fit_of_planes(void)
{
    enum { NEIGHBOURS = 12, RAYS = 400, SETS = 200 };
    struct random r = random_start(2, 0, 0);
    double worst = 0, worst_mixed = 0;
    for (int set = 0; set < SETS; set++) {
        double true_sight[NEIGHBOURS], sight[NEIGHBOURS] = {0};
        struct sight_ray ray[RAYS];
        for (int i = 0; i < NEIGHBOURS; i++)
            true_sight[i] = -1 + 5 * random_double(&r);
        for (int k = 0; k < RAYS; k++) {
            double sum = 0, inverse = 0;
            ray[k] = (struct sight_ray){.terms = 3};
            for (int i = 0; i < 3; i++) {
                ray[k].neighbour[i] = (k + 4 * i) % NEIGHBOURS;
                ray[k].u[i] = random_double(&r);
                sum += ray[k].u[i];
            }
            for (int i = 0; i < 3; i++) {
                ray[k].u[i] /= sum;
                inverse += ray[k].u[i] * true_sight[ray[k].neighbour[i]];
            }
            ray[k].inverse = inverse > 1 ? inverse : 0;
            ray[k].share = 1.0 / RAYS;
        }
        must(sight_fit(RAYS, ray, NEIGHBOURS, sight));
        worst = fmax(worst, sight_fit_loss(RAYS, ray, sight));
        for (int k = 0; k < RAYS; k++) /* and where nothing can fit: never worse than the start */
            ray[k].inverse = random_double(&r) < 0.5 ? 0 : 1 / (1 - 0.99 * random_double(&r));
        memset(sight, 0, sizeof sight);
        const double before = sight_fit_loss(RAYS, ray, sight);
        must(sight_fit(RAYS, ray, NEIGHBOURS, sight));
        worst_mixed = fmax(worst_mixed, sight_fit_loss(RAYS, ray, sight) / before);
    }
    ok(worst < 1e-3, "what is linear between neighbours is found: loss %.1e at most", worst);
    ok(worst_mixed < 1, "what is not, is fitted better than not at all: %.2f at most", worst_mixed);
}

/* -- flat walls ------------------------------------------------------------------------------- */

/* Weight of probes on the other side of the plane. */
static double weight_beyond(const struct grid *g, const struct probe_place *place,
                            const double q[3], const double p[3], const double n[3])
{
    double side = 0, beyond = 0;
    for (int k = 0; k < 3; k++)
        side += n[k] * (q[k] - p[k]);
    for (int i = 0; i < 4; i++) {
        double height = 0;
        for (int k = 0; k < 3; k++)
            height += n[k] * (g->position[3 * place->probe[i] + k] - p[k]);
        beyond += height * side < 0 ? place->weight[i] : 0;
    }
    return beyond;
}

static void test_flat_walls(void)
{
    enum { WALLS = 12, POINTS = 4000 };
    static struct grid g;
    struct random r = random_start(3, 0, 0);
    size_t near = 0, leaks = 0, most_probes = 0;
    double mean = 0, plain = 0;
    make_grid(&g, 0.4);
    const struct leak_mesh mesh = mesh_of(&g);
    for (int wall = 0; wall < WALLS; wall++) {
        struct bench b;
        struct sights s;
        double p[3], n[3] = {0};
        for (int k = 0; k < 3; k++) {
            p[k] = 1.5 + random_double(&r);
            n[k] = wall < 3 ? k == wall : random_double(&r) - 0.5;
        }
        vec3_store(n, vec3_normalize(vec3_load(n)));
        bench_start(&b);
        add_wall(&b, p, n, 50);
        bench_finish(&b, 1);
        must(sight_find(&s, b.tracer, &mesh, 2));
        struct probe_volume *v = volume_of(&g), *blind = volume_of(&g);
        if (probe_volume_set_sight(v, s.sight, s.stand_in, NULL))
            bail("no sight");
        for (int i = 0; i < POINTS; i++) {
            double q[3], height = 0;
            struct probe_place place = {.cell = PROBE_COLD}, all = place;
            for (int k = 0; k < 3; k++) {
                q[k] = 0.5 + 3 * random_double(&r);
                height += n[k] * (q[k] - p[k]);
            }
            probe_volume_locate(v, q, &place);
            probe_volume_locate(blind, q, &all);
            const double beyond = weight_beyond(&g, &place, q, p, n);
            mean += beyond;
            plain += weight_beyond(&g, &all, q, p, n);
            near += fabs(height) < 0.01;
            leaks += beyond > 1e-3 && fabs(height) >= 0.01;
            most_probes += place.inside != 0;
        }
        probe_volume_destroy(v);
        probe_volume_destroy(blind);
        sights_clear(&s);
        bench_clear(&b);
    }
    ok(most_probes > WALLS * POINTS / 2 && near < WALLS * POINTS / 10, "points are in cells");
    ok(leaks == 0,
       "a hundredth of a spacing off a flat wall, and farther, nothing is from beyond: "
       "%zu of %d points",
       leaks, WALLS * POINTS);
    ok(mean < plain / 1e5 && plain > WALLS * POINTS / 200,
       "weight from beyond: %.7f %% of all, without sight %.2f %%", 100 * mean / WALLS / POINTS,
       100 * plain / WALLS / POINTS);
}

/* The same walls around the grid: what stands on the way out of the hull, too, whichever place of
 * it light comes from. */
static void test_flat_walls_outside(void)
{
    enum { WALLS = 5, POINTS = 3000 };
    static struct grid g;
    struct random r = random_start(11, 0, 0);
    size_t leaks = 0, asked = 0;
    double mean = 0, plain = 0;
    make_grid(&g, 0);
    const struct leak_mesh mesh = mesh_of(&g);
    const struct probe_mesh cells = {.probes = PROBES,
                                     .position = g.position,
                                     .corners = 4,
                                     .cells = CELLS,
                                     .vertex = g.vertex,
                                     .neighbour = g.neighbour};
    for (int wall = 0; wall < 2 * WALLS; wall++) {
        struct bench b;
        struct sights s;
        double p[3], n[3] = {0};
        for (int k = 0; k < 3; k++) {
            p[k] = 1.5 + random_double(&r);
            n[k] = random_double(&r) - 0.5;
        }
        vec3_store(n, vec3_normalize(vec3_load(n)));
        bench_start(&b);
        add_wall(&b, p, n, 9);
        bench_finish(&b, 1);
        must(sight_find(&s, b.tracer, &mesh, 2));
        struct probe_volume *v = NULL, *blind = NULL;
        const unsigned flags = wall % 2 ? PROBE_EXTEND : PROBE_NEAREST;
        if (probe_volume_create(&v, &cells, flags, NULL) ||
            probe_volume_create(&blind, &cells, flags, NULL) ||
            probe_volume_set_sight(v, s.sight, s.stand_in, NULL) || !s.outside ||
            probe_volume_set_sight_outside(v, s.outside, s.stand_in_outside, NULL))
            bail("no sight");
        for (int i = 0; i < POINTS; i++) {
            double q[3], height = 0;
            struct probe_place place = {.cell = PROBE_COLD}, all = place;
            for (int k = 0; k < 3; k++) {
                q[k] = -0.7 + 5.4 * random_double(&r);
                height += n[k] * (q[k] - p[k]);
            }
            probe_volume_locate(v, q, &place);
            probe_volume_locate(blind, q, &all);
            if (place.inside || fabs(height) < 0.02)
                continue;
            const double beyond = weight_beyond(&g, &place, q, p, n);
            mean += beyond;
            plain += weight_beyond(&g, &all, q, p, n);
            leaks += beyond > 1e-3;
            asked++;
        }
        probe_volume_destroy(v);
        probe_volume_destroy(blind);
        sights_clear(&s);
        bench_clear(&b);
    }
    ok(asked > WALLS * POINTS / 2 && plain > (double)asked / 50, "points are outside of the hull");
    ok(leaks <= asked / 2000 && mean < plain / 500,
       "outside of the hull nothing is from beyond a flat wall: %zu of %zu points, weight %.5f %%, "
       "without sight %.2f %%",
       leaks, asked, 100 * mean / (double)asked, 100 * plain / (double)asked);
}

/* Where nothing stands outside, nothing is kept of it. */
static void test_nothing_outside(void)
{
    static struct grid g;
    struct bench b;
    struct sights s;
    make_grid(&g, 0);
    const struct leak_mesh mesh = mesh_of(&g);
    const double p[6][3] = {{-1, 2, 2}, {5, 2, 2}, {2, -1, 2}, {2, 5, 2}, {2, 2, -1}, {2, 2, 5}};
    bench_start(&b);
    for (int i = 0; i < 6; i++)
        add_wall(&b, p[i], (double[3]){i / 2 == 0, i / 2 == 1, i / 2 == 2}, 3);
    bench_finish(&b, 1);
    must(sight_find(&s, b.tracer, &mesh, 2));
    ok(!s.outside && !s.stand_in_outside && !s.walled, "the walls of a room are before nothing");
    sights_clear(&s);
    bench_clear(&b);
}

/* Probes that all but touch a wall see nothing beyond it. */
static void test_touching(void)
{
    static struct grid g;
    struct random r = random_start(10, 0, 0);
    const struct leak_mesh mesh = mesh_of(&g);
    for (int power = 2; power <= 6; power += 2) {
        const double off = pow(10, -power), p[3] = {2 - off, 0, 0}, n[3] = {1, 0, 0};
        double most = 0;
        struct bench b;
        struct sights s;
        make_grid(&g, 0);
        bench_start(&b);
        add_wall(&b, p, n, 50);
        bench_finish(&b, 1);
        must(sight_find(&s, b.tracer, &mesh, 2));
        struct probe_volume *v = volume_of(&g);
        if (probe_volume_set_sight(v, s.sight, s.stand_in, NULL))
            bail("no sight");
        for (int i = 0; i < 4000; i++) {
            const double q[3] = {1 + 2 * random_double(&r), 4 * random_double(&r),
                                 4 * random_double(&r)};
            struct probe_place place = {.cell = PROBE_COLD};
            if (fabs(q[0] - p[0]) < 0.01)
                continue;
            probe_volume_locate(v, q, &place);
            most = fmax(most, weight_beyond(&g, &place, q, p, n));
        }
        ok(most < 1e-6, "probes 1e-%d off a wall are not seen through it: weight %.1e at most",
           power, most);
        probe_volume_destroy(v);
        sights_clear(&s);
        bench_clear(&b);
    }
}

/* -- other walls ------------------------------------------------------------------------------ */

struct halls {
    struct bench bench;
    struct grid grid;
    struct sights sights;
};

/* A ball and three walls that end within the grid. */
static void make_halls(struct halls *h)
{
    const double at[3][3] = {{1.3, 1.6, 1.4}, {2.7, 2.2, 1.2}, {2.1, 1.1, 2.9}};
    const double n[3][3] = {{1, 0, 0}, {0.6, 0.8, 0}, {0, 0.28, 0.96}};
    make_grid(&h->grid, 0.4);
    bench_start(&h->bench);
    for (int i = 0; i < 3; i++)
        add_wall(&h->bench, at[i], n[i], 0.9);
    bench_finish(&h->bench, 1);
    const struct leak_mesh mesh = mesh_of(&h->grid);
    must(sight_find(&h->sights, h->bench.tracer, &mesh, 1));
}

static void clear_halls(struct halls *h)
{
    sights_clear(&h->sights);
    bench_clear(&h->bench);
}

/* On a face, both cells give the same weights. */
static void test_faces(const struct halls *h)
{
    struct random r = random_start(4, 0, 0);
    double worst = 0;
    size_t faces = 0;
    for (size_t c = 0; c < CELLS; c++)
        for (int k = 0; k < 4; k++) {
            const int32_t n = h->grid.neighbour[4 * c + (size_t)k];
            if (n < 0)
                continue;
            double weight[2][4], u[2][4] = {{0}}, sum = 0;
            const int32_t *v[2] = {h->grid.vertex + 4 * c, h->grid.vertex + 4 * n};
            for (int i = 0; i < 4; i++)
                sum += u[0][i] = i == k ? 0 : random_double(&r);
            for (int i = 0; i < 4; i++) {
                u[0][i] /= sum;
                for (int j = 0; j < 4; j++)
                    if (v[1][j] == v[0][i])
                        u[1][j] = u[0][i];
            }
            for (int side = 0; side < 2; side++) {
                uint16_t sight[12];
                const size_t cell = side ? (size_t)n : c;
                for (size_t i = 0; i < 12; i++)
                    sight[i] = half_of(h->sights.sight[12 * cell + i]);
                const double all = sight_weights(4, sight, u[side], weight[side]);
                for (int i = 0; i < 4; i++)
                    weight[side][i] /= all;
            }
            for (int i = 0; i < 4; i++)
                for (int j = 0; j < 4; j++)
                    if (v[1][j] == v[0][i])
                        worst = fmax(worst, fabs(weight[0][i] - weight[1][j]));
            faces++;
        }
    ok(faces > CELLS && worst < 1e-6, "on %zu faces both cells give the same weights, to %.1e",
       faces, worst);
}

static void test_halls(const struct halls *h)
{
    enum { POINTS = 20000 };
    struct random r = random_start(5, 0, 0);
    struct probe_volume *v = volume_of(&h->grid), *blind = volume_of(&h->grid);
    double unseen[2] = {0}, off = 0, least = 0;
    if (probe_volume_set_sight(v, h->sights.sight, h->sights.stand_in, NULL))
        bail("no sight");
    for (int i = 0; i < POINTS; i++) {
        double q[3];
        for (int k = 0; k < 3; k++)
            q[k] = -0.5 + 5 * random_double(&r);
        for (int which = 0; which < 2; which++) {
            struct probe_place place = {.cell = PROBE_COLD};
            double sum = 0;
            probe_volume_locate(which ? blind : v, q, &place);
            for (int k = 0; k < 4; k++) {
                sum += place.weight[k];
                least = fmin(least, place.weight[k]);
                const double *p = h->grid.position + 3 * place.probe[k];
                if (place.inside)
                    unseen[which] += place.weight[k] *
                                     (1 - (double)trace_visibility(h->bench.tracer, q, p));
            }
            off = fmax(off, fabs(sum - 1));
        }
    }
    ok(off < 1e-12 && least >= 0, "weights sum to 1 (to %.1e), and none is below 0", off);
    ok(unseen[0] < unseen[1] / 5 && unseen[1] > POINTS / 100,
       "unseen weight %.3f %%, without sight %.2f %%", 100 * unseen[0] / POINTS,
       100 * unseen[1] / POINTS);
    probe_volume_destroy(v);
    probe_volume_destroy(blind);
}

static void test_threads(const struct halls *h)
{
    const struct leak_mesh mesh = mesh_of(&h->grid);
    bool same = true;
    for (int threads = 2; threads <= 4; threads++) {
        struct sights s;
        must(sight_find(&s, h->bench.tracer, &mesh, threads));
        same = same && !memcmp(s.sight, h->sights.sight, 12 * CELLS * sizeof *s.sight) &&
               !memcmp(s.stand_in, h->sights.stand_in, CELLS * sizeof *s.stand_in);
        sights_clear(&s);
    }
    ok(same && h->sights.walled > 20, "2, 3 and 4 threads find the same in %zu walled cells",
       h->sights.walled);
}

static void test_some(const struct halls *h)
{
    enum { EVERY = 90 };
    struct leak_mesh mesh = mesh_of(&h->grid);
    struct sights all, some;
    static bool cell[CELLS];
    int off = 0, walled = 0, left = 0;
    mesh.neighbour = NULL; /* those of the hull are always looked at */
    must(sight_find(&all, h->bench.tracer, &mesh, 1));
    for (int i = 0; i < CELLS; i += EVERY)
        cell[i] = true;
    must(sight_find_some(&some, h->bench.tracer, &mesh, cell, 1));
    for (int i = 0; i < CELLS; i++) {
        const size_t width = 12 * sizeof *all.sight;
        const bool same = !memcmp(all.sight + 12 * i, some.sight + 12 * i, width) &&
                          all.stand_in[i] == some.stand_in[i];
        off += cell[i] && !same;
        left += !same;
        for (int k = 0; k < 12 && cell[i]; k++)
            walled += all.sight[12 * i + k] > 1;
    }
    ok(!off && walled && left, "some cells get what they get with all, %d of the others do not",
       left);
    sights_clear(&all);
    sights_clear(&some);
}

static void test_nothing(void)
{
    static struct grid g;
    struct bench b;
    struct sights s;
    double most = 0;
    make_grid(&g, 0.4);
    bench_start(&b);
    add_wall(&b, (const double[3]){-3, 0, 0}, (const double[3]){1, 0, 0}, 50);
    bench_finish(&b, 1);
    const struct leak_mesh mesh = mesh_of(&g);
    must(sight_find(&s, b.tracer, &mesh, 1));
    for (int i = 0; i < 12 * CELLS; i++)
        most = fmax(most, fabs((double)s.sight[i]));
    ok(most == 0 && !s.walled && !s.stood_in, "where nothing stands between probes, all is 0");
    sights_clear(&s);
    bench_clear(&b);
}

/* -- walls that hide between rays ------------------------------------------------------------- */

struct hidden {
    size_t cut, missed;   /* cells that hide something; of these, those whose sight says nothing */
    double unseen, plain; /* weight of unseen probes, with sight and without */
};

/* Looks for the corners of each cell from points of it that see any. */
static struct hidden look_for_hidden(const struct bench *b, const struct grid *g,
                                     const struct sights *s)
{
    enum { POINTS = 40 };
    struct random r = random_start(8, 0, 0);
    struct hidden found = {0};
    for (size_t c = 0; c < CELLS; c++) {
        bool cut = false, said = false;
        uint16_t sight[12];
        for (size_t i = 0; i < 12; i++) {
            sight[i] = half_of(s->sight[12 * c + i]);
            said = said || s->sight[12 * c + i] > 1;
        }
        for (int k = 0; k < POINTS; k++) {
            double u[4], weight[4], q[3] = {0}, all = 0;
            for (int i = 0; i < 4; i++)
                all += u[i] = -log(1 - random_double(&r));
            for (int i = 0; i < 4; i++)
                u[i] /= all;
            for (int i = 0; i < 12; i++)
                q[i % 3] += u[i / 3] * g->position[3 * g->vertex[4 * c + (size_t)i / 3] + i % 3];
            const double sum = sight_weights(4, sight, u, weight);
            double hidden[4], seen = 0;
            for (int i = 0; i < 4; i++) {
                const double *p = g->position + 3 * g->vertex[4 * c + (size_t)i];
                hidden[i] = 1 - (double)trace_visibility(b->tracer, q, p);
                seen = fmax(seen, 1 - hidden[i]);
            }
            for (int i = 0; i < 4 && seen > 0.5; i++) {
                cut = cut || hidden[i] > 0.5;
                found.plain += hidden[i] * u[i] / POINTS;
                found.unseen += hidden[i] * weight[i] / sum / POINTS;
            }
        }
        found.cut += cut;
        found.missed += cut && !said;
    }
    return found;
}

/* Scatters things that `add` makes, of one size, many times over; least: by how many times the
 * weight of unseen probes is to fall. */
static void test_kind(const char *what, void (*add)(struct bench *, struct random *, double),
                      double size, double least)
{
    enum { SETS = 6, THINGS = 5 };
    static struct grid g;
    struct hidden all = {0};
    make_grid(&g, 0.4);
    const struct leak_mesh mesh = mesh_of(&g);
    for (uint32_t set = 0; set < SETS; set++) {
        struct random r = random_start(9, set, 0);
        struct bench b;
        struct sights s;
        bench_start(&b);
        for (int i = 0; i < THINGS; i++)
            add(&b, &r, size);
        bench_finish(&b, 1);
        must(sight_find(&s, b.tracer, &mesh, 2));
        const struct hidden h = look_for_hidden(&b, &g, &s);
        all.cut += h.cut;
        all.missed += h.missed;
        all.unseen += h.unseen;
        all.plain += h.plain;
        sights_clear(&s);
        bench_clear(&b);
    }
    ok(all.cut > 20 && all.unseen * least < all.plain && all.missed * 10 < all.cut,
       "%s %g: unseen weight falls %.1f times (%g at least); %zu of %zu cells keep nothing", what,
       size, all.plain / all.unseen, least, all.missed, all.cut);
}

static void place_thing(struct random *r, double p[3], double n[3])
{
    for (int k = 0; k < 3; k++) {
        p[k] = 0.5 + 3 * random_double(r);
        n[k] = random_double(r) - 0.5;
    }
    vec3_store(n, vec3_normalize(vec3_load(n)));
}

static void add_one_wall(struct bench *b, struct random *r, double size)
{
    double p[3], n[3];
    place_thing(r, p, n);
    add_wall(b, p, n, size / 2);
}

/* Two sheets, `gap` apart. */
static void add_slab(struct bench *b, struct random *r, double gap)
{
    double p[3], n[3];
    place_thing(r, p, n);
    add_wall(b, p, n, 1);
    for (int k = 0; k < 3; k++) {
        p[k] += gap * n[k];
        n[k] = -n[k];
    }
    add_wall(b, p, n, 1);
}

/* A wall that leans by little against a plane of the grid's cells. */
static void add_grazing(struct bench *b, struct random *r, double lean)
{
    double p[3], n[3];
    place_thing(r, p, n);
    const double to[3] = {1, lean * n[1], lean * n[2]};
    p[0] = 1 + (int)p[0];
    vec3_store(n, vec3_normalize(vec3_load(to)));
    add_wall(b, p, n, 1);
}

static void add_ball(struct bench *b, struct random *r, double radius)
{
    double p[3], n[3];
    struct shape ball = shape_sphere(radius, 3);
    place_thing(r, p, n);
    shape_move(&ball, p[0], p[1], p[2]);
    add_shape(b, &ball, material(0.5f, 0));
    shape_clear(&ball);
}

/* A cut-out wall through all of the grid, of which the half up to x = 2 is a hole. Cells whose
 * probes have neighbours on the other side of its edge are left out. */
static void test_cut_out(void)
{
    static const float half_open[2] = {0, 1};
    static struct grid g;
    size_t open = 0, shut = 0, wrong = 0;
    struct bench b;
    struct sights s;
    struct scene_material m = material(0.5f, 0);
    make_grid(&g, 0.4);
    const struct leak_mesh mesh = mesh_of(&g);
    bench_start(&b);
    m.alpha = SCENE_CUTOUT;
    m.alpha_map = scene_map_of(add_texture(&b, 2, 1, 1, half_open));
    const double corner[12] = {-48, -50, 1.5, 52, -50, 1.5, 52, 50, 1.5, -48, 50, 1.5};
    add_quad(&b, corner, m);
    map_quad(&b);
    bench_finish(&b, 1);
    must(sight_find(&s, b.tracer, &mesh, 1));
    for (size_t c = 0; c < CELLS; c++) {
        double low = INFINITY, high = -INFINITY, under = INFINITY, over = -INFINITY;
        bool any = false;
        for (size_t k = 0; k < 4; k++) {
            const double *p = g.position + 3 * g.vertex[4 * c + k];
            low = fmin(low, p[0]);
            high = fmax(high, p[0]);
            under = fmin(under, p[2]);
            over = fmax(over, p[2]);
        }
        for (size_t i = 0; i < 12; i++)
            any = any || s.sight[12 * c + i] > 1;
        const bool crossed = under < 1.45 && over > 1.55;
        open += crossed && high < 1.6;
        shut += crossed && low > 2.4;
        wrong += crossed && high < 1.6 && any;
        wrong += crossed && low > 2.4 && !any;
    }
    ok(open > 20 && shut > 20 && wrong == 0,
       "holes of a cut-out hide nothing: %zu cells at holes, %zu at the rest, %zu wrong", open,
       shut, wrong);
    sights_clear(&s);
    bench_clear(&b);
}

static void test_kinds(void)
{
    test_kind("walls of", add_one_wall, 0.5, 4);
    test_kind("walls of", add_one_wall, 1, 6);
    test_kind("walls of", add_one_wall, 2, 7);
    test_kind("walls that lean by", add_grazing, 0.1, 15);
    test_kind("slabs of", add_slab, 1e-1, 6);
    test_kind("slabs of", add_slab, 1e-3, 7);
    test_kind("slabs of", add_slab, 1e-5, 7);
    test_kind("balls of", add_ball, 0.1, 5);
    test_kind("balls of", add_ball, 0.4, 8);
    test_kind("balls of", add_ball, 1.2, 6);
}

/* -- what keeps it ---------------------------------------------------------------------------- */

static bool same_place(const struct probe_place *a, const struct probe_place *b)
{
    return !memcmp(a->weight, b->weight, sizeof a->weight);
}

static void test_packed(const struct halls *h)
{
    static float slope[12 * CELLS];
    static int32_t other[CELLS];
    enum { POINTS = 3000 };
    struct random r = random_start(6, 0, 0);
    struct probe_volume *v = volume_of(&h->grid), *blind = volume_of(&h->grid), *packed = NULL,
                        *all = NULL;
    size_t differ = 0, differ_all = 0, told_apart = 0, row = 0;
    const size_t bytes = probe_volume_bytes(v);
    if (probe_volume_set_sight(v, h->sights.sight, h->sights.stand_in, NULL))
        bail("no sight");
    ok(probe_volume_sees(v) && !probe_volume_sees(blind), "a volume says whether it has sight");
    ok(probe_volume_bytes(v) - bytes == CELLS * 28, "and counts its bytes: %zu a cell",
       (probe_volume_bytes(v) - bytes) / CELLS);
    const size_t thin = probe_volume_pack(v, 0, NULL, 0, PROBE_PACK_HALF, NULL, 0);
    for (int i = 0; i < 12 * CELLS; i++)
        slope[i] = i / 12 % 5 ? 0 : (float)(i % 7 - 2);
    for (int i = 0; i < CELLS; i++)
        other[i] = i % 3 ? -1 : i % PROBES;
    if (probe_volume_set_sight_outside(v, slope, other, NULL))
        bail("no sight");
    const size_t size = probe_volume_pack(v, 0, NULL, 0, PROBE_PACK_HALF, NULL, 0),
                 less = probe_volume_pack(blind, 0, NULL, 0, PROBE_PACK_HALF, NULL, 0);
    void *image = NULL;
    must(array_create(&image, size, 1));
    probe_volume_pack(v, 0, NULL, 0, PROBE_PACK_HALF, image, size);
    ok(thin - less >= CELLS * 26 && thin - less < CELLS * 26 + 128,
       "a packed file has %zu bytes a cell more", (thin - less) / CELLS);
    ok(size > thin && size - thin < CELLS * 56,
       "and %zu for the cells that something stands beyond", size - thin);
    if (probe_volume_open(&packed, image, size, 0, NULL) ||
        probe_volume_open(&all, image, size, PROBE_SEE_ALL, NULL))
        bail("the packed file is refused");
    for (int i = 0; i < POINTS; i++) {
        double q[3];
        struct probe_place place[4] = {
            {.cell = PROBE_COLD}, {.cell = PROBE_COLD}, {.cell = PROBE_COLD}, {.cell = PROBE_COLD}};
        for (int k = 0; k < 3; k++)
            q[k] = -0.9 + 5.8 * random_double(&r);
        probe_volume_locate(v, q, &place[0]);
        probe_volume_locate(packed, q, &place[1]);
        probe_volume_locate(blind, q, &place[2]);
        probe_volume_locate(all, q, &place[3]);
        differ += !same_place(&place[0], &place[1]);
        differ_all += !same_place(&place[2], &place[3]);
        told_apart += !same_place(&place[0], &place[2]);
    }
    ok(differ == 0 && told_apart > POINTS / 10, "it answers as the volume that it is of does");
    ok(differ_all == 0, "and as one without sight, where all probes are to be seen");
    free(image);
    image = NULL;

    static float sight[12 * CELLS];
    static int32_t stand_in[CELLS];
    memcpy(sight, h->sights.sight, sizeof sight);
    memcpy(stand_in, h->sights.stand_in, sizeof stand_in);
    sight[12 * 7 + 5] = (float)NAN;
    ok(probe_volume_set_sight(v, sight, stand_in, &row) == PROBE_BAD_SIGHT && row == 7 &&
           !probe_volume_sees(v),
       "sight that is no number is refused, with its cell");
    sight[12 * 7 + 5] = 0;
    stand_in[9] = PROBES;
    ok(probe_volume_set_sight(v, sight, stand_in, &row) == PROBE_BAD_SIGHT && row == 9,
       "and so is a stand-in that is no probe");
    stand_in[9] = -2;
    ok(probe_volume_set_sight(v, sight, stand_in, &row) == PROBE_BAD_SIGHT && row == 9,
       "below -1, too");
    ok(probe_volume_set_sight(v, NULL, NULL, &row) == PROBE_OK && probe_volume_bytes(v) == bytes,
       "none is none");
    ok(probe_volume_set_sight_outside(v, sight, NULL, &row) == PROBE_BAD_ARGUMENT,
       "what is outside is of cells with sight");
    stand_in[9] = -1;
    probe_volume_set_sight(v, sight, stand_in, NULL);
    const size_t inside = probe_volume_bytes(v);
    sight[12 * 8 + 3] = INFINITY;
    ok(probe_volume_set_sight_outside(v, sight, stand_in, &row) == PROBE_BAD_SIGHT && row == 8 &&
           probe_volume_sees(v) && probe_volume_bytes(v) == inside,
       "and is refused where it is no number, with its cell");
    probe_volume_set_sight(v, NULL, NULL, NULL);
    probe_volume_destroy(v);
    probe_volume_destroy(blind);
    probe_volume_destroy(packed);
    probe_volume_destroy(all);
}

/* Whatever numbers sight holds, weights are weights. */
static void test_any_sight(const struct halls *h)
{
    enum { SETS = 40, POINTS = 300 };
    static const float odd[] = {0, -0.0f, 1, -1, 65504, -65504, 1e30f, -1e30f, 1e-8f, 2, 0.5f};
    static float sight[12 * CELLS];
    static int32_t stand_in[CELLS];
    struct random r = random_start(7, 0, 0);
    size_t wrong = 0;
    struct probe_volume *v = volume_of(&h->grid);
    for (int set = 0; set < SETS; set++) {
        for (int i = 0; i < 12 * CELLS; i++)
            sight[i] = odd[random_u32(&r) % (sizeof odd / sizeof *odd)];
        for (int i = 0; i < CELLS; i++)
            stand_in[i] = (int32_t)(random_u32(&r) % (PROBES + 1)) - 1;
        if (probe_volume_set_sight(v, sight, stand_in, NULL))
            bail("no sight");
        for (int i = 0; i < POINTS; i++) {
            double q[3], sum = 0;
            struct probe_place place = {.cell = PROBE_COLD};
            for (int k = 0; k < 3; k++)
                q[k] = -1 + 6 * random_double(&r);
            probe_volume_locate(v, q, &place);
            bool legal = true;
            for (int k = 0; k < 4; k++) {
                legal = legal && place.weight[k] >= 0 && place.probe[k] >= 0 &&
                        place.probe[k] < PROBES;
                sum += place.weight[k];
            }
            wrong += !legal || !(fabs(sum - 1) < 1e-9);
        }
    }
    ok(wrong == 0, "whatever sight holds, weights are 0 or more and sum to 1: %zu of %d are not",
       wrong, SETS * POINTS);
    probe_volume_destroy(v);
}

/* What sight is read from: every finite half, subnormal ones and signs as well. */
static void test_halves(void)
{
    size_t wrong = 0;
    for (uint32_t half = 0; half < 0x10000; half++) {
        const int exponent = (int)(half >> 10 & 31), fraction = (int)(half & 1023);
        const float size = ldexpf((float)(exponent ? 1024 + fraction : fraction),
                                  exponent ? exponent - 25 : -24),
                    got = half_value((uint16_t)half);
        if (half_finite((uint16_t)half))
            wrong += fabsf(got) != size || !signbit(got) != !(half & 0x8000);
    }
    ok(wrong == 0, "every finite half is the number that it stands for");
}

/* What is reckoned for two corners at a time is what the formula says (sight.h), to the bit, of any
 * finite halves. */
static void test_depths(void)
{
    enum { SETS = 20000 };
    struct random r = random_start(11, 0, 0);
    size_t wrong = 0;
    for (int set = 0; set < SETS; set++) {
        uint16_t sight[12];
        double u[4], depth[4];
        for (int i = 0; i < 12; i++)
            do
                sight[i] = (uint16_t)(random_u32(&r) & (set % 2 ? 0xffff : 0x83ff)); /* small */
            while (!half_finite(sight[i]));
        for (int i = 0; i < 4; i++)
            u[i] = random_double(&r);
        sight_depths(4, sight, u, depth);
        for (int i = 0, k = 0; i < 4; i++) {
            double expected = 1;
            for (int j = 0; j < 4; j++)
                expected -= j == i ? 0 : (double)half_value(sight[k++]) * u[j];
            wrong += depth[i] != expected;
        }
    }
    ok(wrong == 0, "depths of corners are those of the formula: %zu of %d are not", wrong,
       4 * SETS);
}

int main(void)
{
    static struct halls halls;
    test_halves();
    test_depths();
    test_fit_of_planes();
    test_flat_walls();
    test_flat_walls_outside();
    test_nothing_outside();
    test_touching();
    test_nothing();
    make_halls(&halls);
    test_faces(&halls);
    test_halls(&halls);
    test_threads(&halls);
    test_some(&halls);
    test_packed(&halls);
    test_any_sight(&halls);
    test_kinds();
    test_cut_out();
    clear_halls(&halls);
    return tap_done();
}
