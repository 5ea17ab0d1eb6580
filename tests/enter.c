/* SPDX-License-Identifier: Apache-2.0 */
/* Which cells triangles come into, held against clipping: no cell that one is in is missed, however
 * small or thin the triangle is or far from the origin, and none is named that is clear of all.
 */
#include "trace/enter.h"
#include "math/random.h"
#include "support/capture_bench.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

struct triangle {
    struct vec3 corner[3];
};

static struct vec3 anywhere(struct random *r, struct vec3 middle, double size)
{
    const struct vec3 p = {random_double(r) - 0.5, random_double(r) - 0.5, random_double(r) - 0.5};
    return vec3_fma(middle, size, p);
}

/* Whether a part of the triangle is in the tetrahedron whose faces are moved in by `margin` of its
 * heights (below 0: out): Sutherland and Hodgman's clipping, of barycentric coordinates. */
static bool is_in(const struct triangle *t, const struct vec3 p[4], double margin)
{
    double polygon[16][4];
    int sides = 3;
    const struct vec3 a = vec3_sub(p[1], p[0]), b = vec3_sub(p[2], p[0]), c = vec3_sub(p[3], p[0]);
    const double volume = vec3_dot(a, vec3_cross(b, c));
    for (int i = 0; i < 3; i++) {
        const struct vec3 q = vec3_sub(t->corner[i], p[0]);
        polygon[i][1] = vec3_dot(q, vec3_cross(b, c)) / volume;
        polygon[i][2] = vec3_dot(q, vec3_cross(c, a)) / volume;
        polygon[i][3] = vec3_dot(q, vec3_cross(a, b)) / volume;
        polygon[i][0] = 1 - polygon[i][1] - polygon[i][2] - polygon[i][3];
    }
    for (int k = 0; k < 4; k++) {
        double in[16][4];
        const int n = sides;
        memcpy(in, polygon, sizeof in);
        sides = 0;
        for (int i = 0; i < n; i++) {
            const double *u = in[i], *v = in[(i + 1) % n], from = u[k] - margin, to = v[k] - margin;
            if (from >= 0)
                memcpy(polygon[sides++], u, sizeof *polygon);
            if ((from >= 0) == (to >= 0))
                continue;
            for (int j = 0; j < 4; j++)
                polygon[sides][j] = u[j] + from / (from - to) * (v[j] - u[j]);
            sides++;
        }
    }
    return sides > 0;
}

struct count {
    size_t cells, in, missed, wrong;
};

/* Asks for `cells` tetrahedra of about `size` around `middle`. */
static struct count ask(const struct bench *b, const struct triangle *t, size_t triangles,
                        size_t cells, struct vec3 middle, double size, double margin)
{
    struct random r = random_start(2, 0, 0);
    struct count count = {.cells = cells};
    for (size_t i = 0; i < cells; i++) {
        struct vec3 p[4];
        double at[4][3];
        const double *point[4];
        bool in = false, near = false;
        const struct vec3 about = anywhere(&r, middle, 2 * size);
        for (int k = 0; k < 4; k++) {
            p[k] = anywhere(&r, about, size);
            vec3_store(at[k], p[k]);
            point[k] = at[k];
        }
        for (size_t k = 0; k < triangles; k++) {
            in = in || is_in(&t[k], p, margin);
            near = near || is_in(&t[k], p, -margin);
        }
        const bool entered = trace_enter(b->tracer, 4, point, NULL, NULL);
        count.in += in;
        count.missed += in && !entered;
        count.wrong += entered && !near;
    }
    return count;
}

static void add_triangles(struct bench *b, const struct triangle *t, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t index[3] = {0, 1, 2};
        const struct scene_material m = material(0.5f, 0);
        double corner[9];
        for (int k = 0; k < 3; k++)
            vec3_store(corner + 3 * k, t[i].corner[k]);
        must(scene_add_mesh(b->scene, 3, corner, 1, index, &m));
    }
}

static void test_kind(const char *what, double triangle_size, double flat, struct vec3 middle,
                      double size)
{
    enum { TRIANGLES = 12, CELLS = 4000 };
    struct triangle t[TRIANGLES];
    struct random r = random_start(1, 0, 0);
    struct bench b;
    for (int i = 0; i < TRIANGLES; i++) {
        const struct vec3 at = anywhere(&r, middle, 1.5 * size);
        for (int k = 0; k < 3; k++)
            t[i].corner[k] = anywhere(&r, at, size * triangle_size);
        t[i].corner[2] = vec3_fma(t[i].corner[0], 0.5, vec3_sub(t[i].corner[1], t[i].corner[0]));
        t[i].corner[2] = anywhere(&r, t[i].corner[2], size * triangle_size * flat);
    }
    bench_start(&b);
    add_triangles(&b, t, TRIANGLES);
    bench_finish(&b, 1);
    const struct count c = ask(&b, t, TRIANGLES, CELLS, middle, size, 1e-3);
    ok(c.missed == 0 && c.wrong == 0 && c.in > CELLS / 200 && c.in < CELLS,
       "%s: of %zu cells %zu are entered; %zu are missed, %zu named wrongly", what, c.cells, c.in,
       c.missed, c.wrong);
    bench_clear(&b);
}

/* A mesh that is placed twice, once mirrored and squeezed: Embree has it as instances. */
static void test_placed(void)
{
    enum { CELLS = 3000 };
    static const double placed[2][12] = {{1, 0, 0, 0.3, 0, 1, 0, -0.2, 0, 0, 1, 0.1},
                                         {0, -0.5, 0, 0.2, 0.5, 0, 0, 0.4, 0, 0, -2, -0.3}};
    struct shape ball = shape_sphere(0.4, 2);
    struct triangle *t = NULL;
    struct bench b;
    bench_start(&b);
    add_shape(&b, &ball, material(0.5f, 0));
    must(array_create(&t, 2 * ball.triangle_count, sizeof *t));
    for (size_t which = 0; which < 2; which++) {
        const double *m = placed[which];
        if (which)
            must(scene_push_instance(b.scene, 0, m));
        else
            memcpy(b.scene->instances[0].transform, m, sizeof placed[0]);
        for (size_t i = 0; i < 3 * ball.triangle_count; i++) {
            const struct vec3 p = shape_corner(&ball, i / 3, i % 3);
            t[which * ball.triangle_count + i / 3].corner[i % 3] = (struct vec3){
                vec3_dot(vec3_load(m), p) + m[3], vec3_dot(vec3_load(m + 4), p) + m[7],
                vec3_dot(vec3_load(m + 8), p) + m[11]};
        }
    }
    bench_finish(&b, 1);
    const struct count c = ask(&b, t, 2 * ball.triangle_count, CELLS, (struct vec3){0}, 0.3, 1e-3);
    ok(c.missed == 0 && c.wrong == 0 && c.in > CELLS / 20 && c.in < CELLS / 2,
       "placed, turned, squeezed and mirrored: %zu of %zu; %zu are missed, %zu named wrongly", c.in,
       c.cells, c.missed, c.wrong);
    free(t);
    shape_clear(&ball);
    bench_clear(&b);
}

/* -- flat cells, and visits ------------------------------------------------------------------- */

static bool count_visit(void *context, const struct trace_entering *entering)
{
    size_t *count = context;
    (void)entering;
    ++*count;
    return true;
}

static void test_flat_cells(void)
{
    const struct triangle t = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    const double p[4][3] = {{0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.3, 0.2, 1}, {2, 2, 0.5}};
    struct bench b;
    size_t visits = 0;
    bench_start(&b);
    add_triangles(&b, &t, 1);
    bench_finish(&b, 1);
    const double *const across[4] = {p[0], p[1], p[2], p[3]}, *const off[4] = {p[1], p[2], p[3]};
    for (int count = 2; count <= 4; count++)
        ok(trace_enter(b.tracer, count, across, count_visit, &visits) &&
               visits == (size_t)count - 1,
           "a cell of %d corners is entered, and its triangle visited once", count);
    for (int count = 1; count <= 3; count++)
        ok(!trace_enter(b.tracer, count, off, count_visit, &visits) && visits == 3,
           "one of %d corners is not", count);
    const double on[3] = {0.25, 0.25, 0}, *const there[1] = {on};
    ok(trace_enter(b.tracer, 1, there, NULL, NULL), "a point on the surface is");
    bench_clear(&b);
    bench_start(&b);
    bench_finish(&b, 1);
    ok(!trace_enter(b.tracer, 4, across, NULL, NULL), "in an empty scene nothing is");
    bench_clear(&b);
}

int main(void)
{
    const struct vec3 origin = {0}, far = {3e4, -2e4, 1e4};
    test_kind("large triangles", 3, 1, origin, 1);
    test_kind("small ones", 0.05, 1, origin, 1);
    test_kind("splinters", 1, 1e-5, origin, 1);
    test_kind("tiny cells far from the origin", 1, 1, far, 1e-3);
    test_kind("of a world of kilometres", 1, 1, origin, 1e4);
    test_placed();
    test_flat_cells();
    return tap_done();
}
