/* SPDX-License-Identifier: Apache-2.0 */
/* libprobe-query: the place of a point is right, and the same from wherever the search began,
 * whether the walk or the tree found it, in the lean form and in a packed file; exact at probes, on
 * edges and on faces; light is continuous along lines; cells of any dimension; what is not a mesh
 * is refused. */
#include "base/error.h"
#include "libprobe-query/probe-query.h"
#include "libprobe-query/volume.h"
#include "math/box.h"
#include "math/cell.h"
#include "math/random.h"
#include "support/point_sets.h"
#include "support/tap.h"
#include "tetra/tetra.h"

#include <string.h>

enum { MOST = 3000 };

enum shape {
    RANDOM,
    GRID,
    NOISY_GRID,
    ROUGH_GRID,
    SHELL,
    SLAB,
    FLAT_SLAB,
    NEEDLES,
    FAR_AWAY,
    /* flat cells are peeled off these: their hulls have dents */
    TURNED_FINE,
    TURNED,
    TURNED_ROUGH,
    TURNED_SLAB,
    SHAPES
};
static const char *const shape_names[] = {"random",
                                          "grid",
                                          "noisy grid",
                                          "rough grid",
                                          "shell",
                                          "slab",
                                          "flat slab",
                                          "needles",
                                          "far away",
                                          "turned grid, noise 1e-6",
                                          "turned grid, noise 1e-4",
                                          "turned grid, noise 1e-3",
                                          "turned slab of a grid"};

static void must_be(enum probe_status status, enum probe_status expected)
{
    if (status != expected)
        bail("%s", probe_status_text(status));
}

static bool is_grid(enum shape shape)
{
    return shape == GRID || shape == NOISY_GRID || shape == ROUGH_GRID || shape >= TURNED_FINE;
}

static size_t make(enum shape shape, size_t count, double *p)
{
    static const double noise[SHAPES] = {
        [NOISY_GRID] = 1e-7, [ROUGH_GRID] = 1e-4,   [TURNED_FINE] = 1e-6,
        [TURNED] = 1e-4,     [TURNED_ROUGH] = 1e-3, [TURNED_SLAB] = 1e-4};
    struct random r = random_start(11, (uint64_t)shape, 0);
    const struct rotation turn = random_rotation(&r);
    const size_t side = (size_t)(cbrt((double)count) + 0.5);
    for (size_t i = 0; i < count; i++) {
        double q[3] = {random_double(&r), random_double(&r), random_double(&r)};
        const double g[3] = {(double)(i % side), (double)(i / side % side),
                             (double)(i / side / side)};
        double length = 0;
        for (int k = 0; k < 3; k++)
            length += (q[k] - 0.5) * (q[k] - 0.5);
        for (int k = 0; k < 3; k++) {
            if (is_grid(shape))
                q[k] = g[k] + noise[shape] * q[k];
            else if (shape == SHELL)
                q[k] = (q[k] - 0.5) / sqrt(length);
            else if (shape == FAR_AWAY)
                q[k] += 1e6;
        }
        q[1] *= shape == NEEDLES ? 1e-4 : 1;
        q[2] *= shape == SLAB          ? 0.02
                : shape == FLAT_SLAB   ? 1e-6
                : shape == NEEDLES     ? 1e-4
                : shape == TURNED_SLAB ? 0.05
                                       : 1;
        if (shape >= TURNED_FINE)
            rotate_points(&turn, 1, q);
        memcpy(p + 3 * i, q, sizeof q);
    }
    return is_grid(shape) ? side * side * side : count;
}

struct mesh_of {
    double position[3 * MOST];
    struct tetra t;
    struct probe_mesh mesh;
};

static void make_mesh(enum shape shape, size_t count, struct mesh_of *m)
{
    const size_t n = make(shape, count, m->position);
    must(tetra_build(&m->t, n, m->position, NULL));
    m->mesh = (struct probe_mesh){.probes = n,
                                  .position = m->position,
                                  .corners = 4,
                                  .cells = m->t.cell_count,
                                  .vertex = m->t.vertex,
                                  .neighbour = m->t.neighbour};
}

/* A point within a random cell, or on a face (3 corners), an edge (2), a probe (1) of one. */
static void point_of(const struct probe_mesh *m, struct random *r, int corners, double p[3],
                     size_t *cell)
{
    double w[4] = {0}, sum = 0;
    *cell = random_u32(r) % m->cells;
    for (int i = 0; i < corners; i++)
        sum += w[i] = corners == 1 ? 1 : 0.02 + random_double(r);
    const int turn = (int)(random_u32(r) % (unsigned)m->corners);
    for (int k = 0; k < 3; k++) {
        p[k] = 0;
        for (int i = 0; i < m->corners; i++)
            p[k] += w[i] / sum *
                    m->position[3 * (size_t)m->vertex[(size_t)m->corners * *cell +
                                                      (size_t)((i + turn) % m->corners)] +
                                (size_t)k];
    }
}

static double size_of(const struct probe_mesh *m)
{
    const struct box box = box_of(m->probes, m->position);
    return box_side(&box);
}

/* How far the blend of the probes' positions is from a point. */
static double miss(const struct probe_mesh *m, const struct probe_place *place, const double p[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        double x = -p[k];
        for (int i = 0; i < 4; i++)
            x += place->weight[i] * m->position[3 * (size_t)place->probe[i] + (size_t)k];
        square += x * x;
    }
    return sqrt(square);
}

static bool same_place(const struct probe_place *a, const struct probe_place *b)
{
    return a->cell == b->cell && !memcmp(a->probe, b->probe, sizeof a->probe) &&
           !memcmp(a->weight, b->weight, sizeof a->weight) && a->inside == b->inside &&
           a->distance == b->distance;
}

/* Inside: weights give back the point, whatever the cell that the search began in. */
static void test_inside(enum shape shape)
{
    static struct mesh_of m;
    make_mesh(shape, shape == SHELL ? 400 : 2000, &m);
    struct probe_volume *v, *lean, *tree;
    must_be(probe_volume_create(&v, &m.mesh, 0, NULL), PROBE_OK);
    must_be(probe_volume_create(&lean, &m.mesh, PROBE_LEAN, NULL), PROBE_OK);
    must_be(probe_volume_create(&tree, &m.mesh, 0, NULL), PROBE_OK);
    tree->steps_most = 0; /* what the walk does not find in its first cell, the tree finds */
    const double size = size_of(&m.mesh);
    struct random r = random_start(12, (uint64_t)shape, 0);
    double worst = 0, worst_lean = 0;
    int outside = 0, differ = 0, tree_differs = 0, lean_differs = 0, batch_differs = 0,
        corners_wrong = 0;
    enum { POINTS = 3000 };
    static double point[3 * POINTS];
    static struct probe_place alone[POINTS], many[POINTS];
    for (int i = 0; i < POINTS; i++) {
        size_t cell;
        const int corners = i % 8 < 5 ? 4 : i % 8 - 4;
        point_of(&m.mesh, &r, corners, point + 3 * i, &cell);
        const double *p = point + 3 * i;
        struct probe_place place = {.cell = PROBE_COLD},
                           again = {.cell = (int32_t)(random_u32(&r) % m.mesh.cells)},
                           by_tree = again, small = again;
        probe_volume_locate(v, p, &place);
        probe_volume_locate(v, p, &again);
        probe_volume_locate(tree, p, &by_tree);
        probe_volume_locate(lean, p, &small);
        alone[i] = place;
        outside += !place.inside && place.distance > 1e-9 * size;
        worst = fmax(worst, miss(&m.mesh, &place, p));
        worst_lean = fmax(worst_lean, miss(&m.mesh, &small, p));
        differ += !same_place(&place, &again);
        tree_differs += !same_place(&place, &by_tree);
        lean_differs += place.inside != small.inside;
        if (corners == 1) { /* at a probe: exactly */
            double most = 0;
            int where = 0;
            for (int k = 0; k < 4; k++)
                if (place.weight[k] > most) {
                    most = place.weight[k];
                    where = place.probe[k];
                }
            corners_wrong += most != 1 || memcmp(m.position + 3 * (size_t)where, p, 3 * sizeof *p);
        }
    }
    many[0].cell = PROBE_COLD;
    probe_volume_locate_many(v, POINTS, point, 3, NULL, many);
    for (int i = 0; i < POINTS; i++)
        batch_differs += !same_place(&alone[i], &many[i]);
    ok(outside == 0, "%s: points of cells are inside (%d are not)", shape_names[shape], outside);
    const double allowed = 1e-10 * size + (shape == FAR_AWAY ? 1e6 * 0x1p-50 : 0);
    ok(worst < allowed && worst_lean < allowed,
       "%s: weights give back the point (%.1e, lean %.1e of the size)", shape_names[shape],
       worst / size, worst_lean / size);
    ok(differ == 0 && batch_differs == 0,
       "%s: the same place, bit for bit, from another cell and among many (%d, %d differ)",
       shape_names[shape], differ, batch_differs);
    ok(tree_differs == 0 && lean_differs == 0,
       "%s: the tree finds what the walk finds, the lean form too (%d, %d differ)",
       shape_names[shape], tree_differs, lean_differs);
    ok(corners_wrong == 0, "%s: at a probe, that probe alone", shape_names[shape]);
    probe_volume_destroy(v);
    probe_volume_destroy(lean);
    probe_volume_destroy(tree);
    tetra_clear(&m.t);
}

/* The gradient of the field that is linear in a cell, by its planes. */
static double slope(const struct probe_volume *v, size_t cell, const float *value)
{
    const struct volume_cell *c = &v->cell[cell];
    double square = 0;
    for (int k = 0; k < 3; k++) {
        double g = 0;
        for (int i = 0; i < 3; i++)
            g += c->plane[k][i] * (double)(value[c->vertex[i + 1]] - value[c->vertex[0]]);
        square += g * g;
    }
    return sqrt(square) / v->lattice.step;
}

static const char *outside_name(unsigned flags)
{
    return flags == PROBE_NEAREST ? "nearest" : flags == PROBE_EXTEND ? "extended" : "unasked";
}

/* Along a line that goes in and out, light changes by no more than its steepest cell allows; and
 * from a point to the next in the same cell or the one beside it, by no more than these two
 * allow. */
static void test_continuity(enum shape shape, unsigned flags)
{
    static struct mesh_of m;
    static float value[MOST];
    make_mesh(shape, 500, &m);
    struct probe_volume *v;
    must_be(probe_volume_create(&v, &m.mesh, flags, NULL), PROBE_OK);
    struct random r = random_start(13, (uint64_t)shape, 0);
    for (size_t i = 0; i < m.mesh.probes; i++)
        value[i] = random_float(&r);
    double steepest = 0;
    for (size_t c = 0; c < v->cells; c++)
        steepest = fmax(steepest, slope(v, c, value));
    const double size = size_of(&m.mesh);
    double worst = 0, worst_local = 0;
    struct probe_place place = {.cell = PROBE_COLD};
    for (unsigned line = 0; line < tap_cases(40); line++) {
        double a[3], b[3], length = 0;
        for (int k = 0; k < 3; k++) {
            const double centre = m.position[3 * (random_u32(&r) % m.mesh.probes) + (size_t)k];
            a[k] = centre + size * 2 * (random_double(&r) - 0.5);
            b[k] = centre + size * 2 * (random_double(&r) - 0.5);
            length += (a[k] - b[k]) * (a[k] - b[k]);
        }
        length = sqrt(length);
        enum { STEPS = 4000 };
        float last = 0;
        int32_t cell = -1;
        for (int s = 0; s <= STEPS; s++) {
            double p[3];
            float light;
            for (int k = 0; k < 3; k++)
                p[k] = a[k] + (b[k] - a[k]) * s / STEPS;
            probe_volume_locate(v, p, &place);
            probe_blend(&place, value, 1, &light);
            const double change = fabs((double)light - (double)last) - 1e-6;
            const int32_t here = place.inside ? v->inner[place.cell] : -1;
            bool beside = here >= 0 && here == cell;
            for (int k = 0; k < 4 && here >= 0 && cell >= 0; k++)
                beside = beside || v->cell[cell].neighbour[k] == here;
            if (s)
                worst = fmax(worst, change / (length / STEPS * steepest));
            if (beside)
                worst_local = fmax(worst_local, change / (length / STEPS *
                                                          fmax(slope(v, (size_t)here, value),
                                                               slope(v, (size_t)cell, value))));
            cell = here;
            last = light;
        }
    }
    ok(worst <= 1.0001 && worst_local <= 1.0001,
       "%s, %s: along lines, light changes by at most %.3f of what the cells there allow, %.3f of "
       "the steepest",
       shape_names[shape], outside_name(flags), worst_local, worst);
    probe_volume_destroy(v);
    tetra_clear(&m.t);
}

/* Outside, each point is on one ray: built as p = u . (corners + t rays) and looked up, it gives
 * back u. And light does not jump, across the hull and from an outer cell to the next. */
static void test_outside(enum shape shape)
{
    static struct mesh_of m;
    make_mesh(shape, is_grid(shape) ? 729 : 400, &m);
    struct probe_volume *v;
    must_be(probe_volume_create(&v, &m.mesh, PROBE_EXTEND, NULL), PROBE_OK);
    struct random r = random_start(19, (uint64_t)shape, 0);
    const double size = size_of(&m.mesh);
    double worst = 0, worst_step = 0;
    int lost = 0;
    enum { POINTS = 4000 };
    struct probe_volume *unasked;
    must_be(probe_volume_create(&unasked, &m.mesh, 0, NULL), PROBE_OK);
    ok(probe_volume_extends(unasked) == !v->convex, "%s: unasked, rays are where there are dents",
       shape_names[shape]);
    probe_volume_destroy(unasked);
    ok(probe_volume_extends(v) && (!v->convex || shape < TURNED_FINE),
       "%s: there are rays, of a hull %s dents", shape_names[shape],
       v->convex ? "without" : "with");
    for (int i = 0; i < POINTS && v->rays; i++) {
        int32_t vertex[3];
        double u[3], p[3] = {0}, q[3], far = 0, expected[3] = {0}, got[3] = {0}, next[3] = {0};
        volume_facet_vertex(v, &v->facet[random_u32(&r) % v->facets], vertex);
        u[0] = random_double(&r);
        u[1] = random_double(&r) * (1 - u[0]);
        u[2] = 1 - u[0] - u[1];
        double ray[3][3];
        for (int c = 0; c < 3; c++) {
            volume_outer_ray(v, vertex[c], ray[c]);
            for (int k = 0; k < 3; k++)
                far = fmax(far, fabs(ray[c][k]) * v->lattice.step);
        }
        const double t = size / far * pow(10, 5 * random_double(&r) - 4); /* to 10 sizes away */
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++) {
                expected[k] += u[c] * m.position[3 * vertex[c] + k];
                p[k] += u[c] * (m.position[3 * vertex[c] + k] + t * ray[c][k] * v->lattice.step);
            }
        struct probe_place place = {.cell = PROBE_COLD}, beside = place;
        probe_volume_locate(v, p, &place);
        /* of the hull's thickness */
        const double step = 1e-7 * size * (shape == FLAT_SLAB ? 1e-6 : shape == NEEDLES ? 1e-4 : 1);
        double moved = 0, off = 0;
        for (int k = 0; k < 3; k++)
            q[k] = p[k] + step * (random_double(&r) - 0.5);
        probe_volume_locate(v, q, &beside);
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 4; c++) {
                got[k] += place.weight[c] * m.position[3 * place.probe[c] + k];
                next[k] += beside.weight[c] * m.position[3 * beside.probe[c] + k];
            }
            off += (got[k] - expected[k]) * (got[k] - expected[k]);
            moved += (got[k] - next[k]) * (got[k] - next[k]);
        }
        lost += sqrt(off) > 1e-5 * size;
        worst = fmax(worst, sqrt(off) / size);
        worst_step = fmax(worst_step, sqrt(moved) / size);
    }
    ok(lost == 0,
       "%s: outside, every point is on the ray that it was made on (%d are not, %.0e off at most)",
       shape_names[shape], lost, worst);
    ok(worst_step < 1e-4,
       "%s: outside, the place on the hull does not jump (%.0e for a step of 1e-7 of its "
       "thickness)",
       shape_names[shape], worst_step);
    probe_volume_destroy(v);
    tetra_clear(&m.t);
}

/* What is left of the steepest changes along lines when they are looked at more and more closely.
 * Of what does not jump, nothing. Lines begin near the mesh, and go both through it and by. */
static double steepest_left(const struct probe_volume *v, const struct probe_mesh *m,
                            const float *value, struct random *r)
{
    enum { LINES = 60, STEPS = 300, HALVINGS = 34 };
    const double size = size_of(m) > 0 ? size_of(m) : 1;
    double worst = 0;
    struct probe_place place = {.cell = PROBE_COLD};
    for (int line = 0; line < LINES; line++) {
        double a[3], way[3], last = 0;
        const double *near = m->position +
                             3 * (size_t)m->vertex[random_u32(r) % ((size_t)m->corners * m->cells)],
                     length = size * pow(10, -3 * random_double(r));
        for (int k = 0; k < 3; k++) {
            a[k] = near[k] + length * (random_double(r) - 0.5);
            way[k] = length * (2 * random_double(r) - 1);
        }
        for (int i = 0; i <= STEPS; i++) {
            double at[2] = {(i - 1) / (double)STEPS, i / (double)STEPS}, light[3], p[3];
            float x;
            /* the end of the step, then middles of the half that changes more */
            for (int h = -1; h <= HALVINGS; h++) {
                const double where = h < 0 ? at[1] : (at[0] + at[1]) / 2;
                for (int k = 0; k < 3; k++)
                    p[k] = a[k] + where * way[k];
                probe_volume_locate(v, p, &place);
                probe_blend(&place, value, 1, &x);
                light[2] = (double)x;
                if (h < 0) {
                    light[0] = last;
                    light[1] = last = light[2];
                    if (i == 0 || fabs(light[1] - light[0]) < 0.02)
                        break;
                    continue;
                }
                const int end = fabs(light[2] - light[0]) > fabs(light[2] - light[1]);
                light[end] = light[2];
                at[end] = where;
                if (h == HALVINGS)
                    worst = fmax(worst, fabs(light[1] - light[0]));
            }
        }
    }
    return worst;
}

static void test_no_jumps(enum shape shape)
{
    static struct mesh_of m;
    static float value[MOST];
    make_mesh(shape, is_grid(shape) ? 729 : 400, &m);
    struct random r = random_start(20, (uint64_t)shape, 0);
    for (size_t i = 0; i < m.mesh.probes; i++)
        value[i] = random_float(&r);
    for (unsigned flags = 0; flags <= PROBE_EXTEND; flags += PROBE_NEAREST) {
        struct probe_volume *v;
        must_be(probe_volume_create(&v, &m.mesh, flags, NULL), PROBE_OK);
        const double left = steepest_left(v, &m.mesh, value, &r);
        /* in a dent the nearest point jumps from one side to the other */
        if (probe_volume_extends(v) || v->convex)
            ok(left < 1e-3, "%s, %s: light does not jump: of steps halved 34 times, %.0e is left",
               shape_names[shape], outside_name(flags), left);
        probe_volume_destroy(v);
    }
    tetra_clear(&m.t);
}

/* Whether the outer cell of a facet holds p, by signs of the volume that p spans with the facet
 * moved along the rays, at many places: 2: well within, 1: but for rounding, 0: no. */
static int holds(const struct probe_volume *v, const struct volume_facet *facet, const double p[3])
{
    int32_t vertex[3];
    double ray[3][3], before = 0, from = 0;
    int found = 0;
    volume_facet_vertex(v, facet, vertex);
    for (int c = 0; c < 3; c++)
        volume_outer_ray(v, vertex[c], ray[c]);
    for (int i = 0; i <= 140; i++) {
        double low = from, high = i == 0 ? 0 : pow(10, (i - 80) / 8.0), w[3];
        const double to = high, sign = before;
        for (int h = 0; h < 60; h++) { /* the first time at the end of the stretch, then between */
            const double t = h == 0 ? high : (low + high) / 2;
            double x[3][3], normal[3], off = 0, area = 0;
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++)
                    x[c][k] = volume_site(v, vertex[c])[k] + t * ray[c][k] - p[k];
            for (int k = 0; k < 3; k++) {
                const int a = (k + 1) % 3, b = (k + 2) % 3;
                normal[k] = (x[1][a] - x[0][a]) * (x[2][b] - x[0][b]) -
                            (x[1][b] - x[0][b]) * (x[2][a] - x[0][a]);
                off += normal[k] * x[0][k];
                area += normal[k] * normal[k];
            }
            for (int c = 0; c < 3; c++) {
                const double *e = x[(c + 1) % 3], *f = x[(c + 2) % 3];
                w[c] = 0;
                for (int k = 0; k < 3; k++)
                    w[c] += normal[k] *
                            (e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3]) /
                            area;
            }
            if (h == 0) {
                before = off;
                if (i == 0 || (off < 0) == (sign < 0))
                    break;
            } else if ((off < 0) == (sign < 0)) {
                low = t;
            } else {
                high = t;
            }
            const double least = fmin(fmin(w[0], w[1]), w[2]);
            if (h == 59 && least > -1e-5)
                found = least > 1e-5 ? 2 : found > 1 ? 2 : 1;
        }
        from = to;
    }
    return found;
}

/* A point outside is in the outer cell of one facet, and that is the one that it is given; and
 * outside is what the tree says that it is. */
static void test_one_cell(enum shape shape)
{
    static struct mesh_of m;
    make_mesh(shape, is_grid(shape) ? 343 : 200, &m);
    struct probe_volume *v, *nearest;
    must_be(probe_volume_create(&v, &m.mesh, PROBE_EXTEND, NULL), PROBE_OK);
    must_be(probe_volume_create(&nearest, &m.mesh, PROBE_NEAREST, NULL), PROBE_OK);
    nearest->convex = false; /* which side of the hull a point is on is asked of the tree */
    struct random r = random_start(21, (uint64_t)shape, 0);
    const double size = size_of(&m.mesh);
    const int asked = (int)tap_cases(150);
    int outside = 0, inside = 0, none = 0, several = 0, another = 0, differ = 0;
    for (unsigned i = 0; i < tap_cases(4000); i++) {
        const double *site = m.position +
                             3 * (size_t)m.mesh
                                     .vertex[4 * (size_t)v->facet[random_u32(&r) % v->facets].cell +
                                             random_u32(&r) % 4],
                     off = size * pow(10, 1 - 8 * random_double(&r));
        double p[3], q[3];
        for (int k = 0; k < 3; k++)
            p[k] = site[k] + off * (2 * random_double(&r) - 1);
        struct probe_place place = {.cell = PROBE_COLD},
                           again = {.cell = (int32_t)(random_u32(&r) % m.mesh.cells)},
                           other = again;
        probe_volume_locate(v, p, &place);
        probe_volume_locate(v, p, &again);
        probe_volume_locate(nearest, p, &other);
        differ += !same_place(&place, &again) || place.inside != other.inside;
        inside += place.inside;
        if (place.inside || place.distance < 1e-9 * size || outside >= asked)
            continue;
        outside++;
        volume_coordinates(v, p, q);
        int held = 0, well = 0;
        bool its = false;
        for (size_t f = 0; f < v->facets; f++) {
            const int how = holds(v, &v->facet[f], q);
            held += how > 0;
            well += how > 1;
            its = its || (how > 0 && volume_number(v, (size_t)v->facet[f].cell) == place.cell);
        }
        none += held == 0;
        several += well > 1;
        another += !its;
    }
    ok(outside == asked && inside > asked && none == 0 && several == 0,
       "%s: outside, one outer cell holds each point (%d in none, %d in several of %d)",
       shape_names[shape], none, several, outside);
    ok(another == 0, "%s: outside, that cell is the one that is found (%d are in another)",
       shape_names[shape], another);
    ok(differ == 0,
       "%s: near the hull, the same side of it from anywhere, and as the tree says (%d differ)",
       shape_names[shape], differ);
    probe_volume_destroy(v);
    probe_volume_destroy(nearest);
    tetra_clear(&m.t);
}

/* A mesh whose hull no middle sees all of: a ring. */
static void test_no_rays(void)
{
    static struct mesh_of m;
    make_mesh(GRID, 125, &m);
    size_t kept = 0;
    static int32_t number[8 * MOST];
    for (size_t c = 0; c < m.mesh.cells; c++) { /* a hole through the middle */
        double x[2] = {0, 0};
        for (int i = 0; i < 8; i++)
            x[i % 2] +=
                m.position[3 * (size_t)m.t.vertex[4 * c + (size_t)(i / 2)] + (size_t)(i % 2)] / 4;
        number[c] = fabs(x[0] - 2) < 1 && fabs(x[1] - 2) < 1 ? -1 : (int32_t)kept++;
    }
    for (size_t c = 0; c < m.mesh.cells; c++)
        for (size_t i = 0; i < 4 && number[c] >= 0; i++) {
            const int32_t n = m.t.neighbour[4 * c + i];
            m.t.vertex[4 * (size_t)number[c] + i] = m.t.vertex[4 * c + i];
            m.t.neighbour[4 * (size_t)number[c] + i] = n < 0 ? -1 : number[n];
        }
    m.mesh.cells = kept;
    struct probe_volume *v;
    must_be(probe_volume_create(&v, &m.mesh, PROBE_EXTEND, NULL), PROBE_OK);
    struct probe_place place = {.cell = PROBE_COLD};
    probe_volume_locate(v, (const double[]){2, 2.25, 2}, &place);
    ok(!probe_volume_extends(v) && !place.inside && fabs(place.distance - 0.75) < 1e-9,
       "a ring has no rays, and says so; in its hole is outside, %g from it", place.distance);
    probe_volume_destroy(v);
    tetra_clear(&m.t);
}

/* -- fewer dimensions ------------------------------------------------------------------------- */

enum { SIDE = 12 };

/* Triangles of a bent-free sheet with a direction of its own, segments of a line, or one point. */
static void make_flat(int corners, double *position, int32_t *vertex, int32_t *neighbour,
                      struct probe_mesh *m)
{
    const double u[3] = {0.36, 0.48, 0.8}, w[3] = {0.8, -0.6, 0}, at[3] = {5, -3, 100};
    *m = (struct probe_mesh){
        .position = position, .corners = corners, .vertex = vertex, .neighbour = neighbour};
    for (int j = 0; j < (corners == 3 ? SIDE : 1); j++)
        for (int i = 0; i < (corners > 1 ? SIDE : 1); i++)
            for (int k = 0; k < 3; k++)
                position[3 * (j * SIDE + i) + k] = at[k] + u[k] * i + w[k] * j * 0.7;
    m->probes = corners == 3 ? SIDE * SIDE : corners == 2 ? SIDE : 1;
    m->cells = corners == 3 ? 2 * (SIDE - 1) * (SIDE - 1) : corners == 2 ? SIDE - 1 : 1;
    for (int32_t c = 0; c < (int32_t)m->cells; c++) {
        const int32_t row = c / (2 * (SIDE - 1)), column = c / 2 % (SIDE - 1),
                      a = row * SIDE + column;
        if (corners == 3 && c % 2 == 0) {
            memcpy(vertex + 3 * c, (const int32_t[]){a, a + 1, a + SIDE}, 12);
            memcpy(neighbour + 3 * c,
                   (const int32_t[]){c + 1, column ? c - 1 : -1, row ? c - 2 * (SIDE - 1) + 1 : -1},
                   12);
        } else if (corners == 3) {
            memcpy(vertex + 3 * c, (const int32_t[]){a + 1, a + SIDE + 1, a + SIDE}, 12);
            memcpy(neighbour + 3 * c,
                   (const int32_t[]){row < SIDE - 2 ? c + 2 * (SIDE - 1) - 1 : -1, c - 1,
                                     column < SIDE - 2 ? c + 1 : -1},
                   12);
        } else if (corners == 2) {
            memcpy(vertex + 2 * c, (const int32_t[]){c, c + 1}, 8);
            memcpy(neighbour + 2 * c, (const int32_t[]){c < SIDE - 2 ? c + 1 : -1, c - 1}, 8);
        } else {
            vertex[0] = 0;
            neighbour[0] = -1;
        }
    }
}

static void test_flat(int corners)
{
    static double position[3 * SIDE * SIDE];
    static int32_t vertex[6 * SIDE * SIDE], neighbour[6 * SIDE * SIDE];
    struct probe_mesh m;
    struct probe_volume *v, *packed;
    size_t row;
    make_flat(corners, position, vertex, neighbour, &m);
    must_be(probe_volume_create(&v, &m, 0, &row), PROBE_OK);
    const size_t bytes = probe_volume_pack(v, 0, NULL, 0, PROBE_PACK_FLOAT, NULL, 0);
    void *image = malloc(bytes);
    probe_volume_pack(v, 0, NULL, 0, PROBE_PACK_FLOAT, image, bytes);
    must_be(probe_volume_open(&packed, image, bytes, 0, &row), PROBE_OK);
    struct random r = random_start(15, (uint64_t)corners, 0);
    double worst = 0, worst_above = 0, worst_beyond = 0, worst_packed = 0;
    int outside = 0, differ = 0;
    /* up is across the sheet and the line */
    const double up[3] = {0.48, 0.64, -0.6}, along[3] = {0.36, 0.48, 0.8};
    for (int i = 0; i < 2000; i++) {
        double p[3], q[3];
        size_t cell;
        point_of(&m, &r,
                 corners < 2 || i % 3 == 0   ? 1
                 : i % 3 == 1 && corners > 2 ? 2
                                             : corners,
                 p, &cell);
        struct probe_place place = {.cell = PROBE_COLD},
                           again = {.cell = (int32_t)(random_u32(&r) % m.cells)};
        probe_volume_locate(v, p, &place);
        probe_volume_locate(v, p, &again);
        worst = fmax(worst, miss(&m, &place, p));
        outside += place.distance > 1e-9;
        differ += !same_place(&place, &again);
        const double height = 4 * (random_double(&r) - 0.5);
        for (int k = 0; k < 3; k++)
            q[k] = p[k] + height * up[k];
        probe_volume_locate(v, q, &place);
        worst_above = fmax(worst_above, miss(&m, &place, p));
        probe_volume_locate(packed, q, &again);
        for (int k = 0; k < 4; k++)
            worst_packed = fmax(worst_packed, fabs(again.weight[k] - place.weight[k]));
        for (int k = 0; k < 3; k++) /* beyond the end of the line, or the sheet's side */
            q[k] = position[3 * (SIDE - 1) + k * (corners > 1)] * (corners > 1) +
                   (corners > 1 ? 0 : p[k]);
        for (int k = 0; k < 3; k++)
            q[k] = (corners > 1 ? position[3 * (SIDE - 1) + k] : p[k]) + along[k] * (1 + i % 5) +
                   height * up[k];
        probe_volume_locate(v, q, &place);
        worst_beyond = fmax(worst_beyond,
                            miss(&m, &place, corners > 1 ? position + 3 * (SIDE - 1) : position));
    }
    ok(worst < 1e-9 && outside == 0 && differ == 0,
       "%d corners: places are right (%.0e), inside and the same from anywhere", corners, worst);
    ok(worst_above < 1e-9, "%d corners: a point beside them is where it is above them (%.0e)",
       corners, worst_above);
    ok(worst_beyond < 1e-9, "%d corners: a point beyond their end is at it (%.0e)", corners,
       worst_beyond);
    ok(worst_packed < 1e-9, "%d corners: packed, the same", corners);
    static float value[SIDE * SIDE];
    for (size_t i = 0; i < m.probes; i++)
        value[i] = random_float(&r);
    const double left = steepest_left(v, &m, value, &r);
    ok(left < 1e-3 && !probe_volume_extends(v),
       "%d corners: light does not jump, beside and beyond them (%.0e)", corners, left);
    probe_volume_destroy(v);
    probe_volume_destroy(packed);
    free(image);
}

/* -- packed files ----------------------------------------------------------------------------- */

static void test_packed(void)
{
    static struct mesh_of m;
    static float sh[27 * MOST];
    make_mesh(RANDOM, 2000, &m);
    struct probe_volume *v, *packed[4];
    void *image[2];
    size_t bytes[2];
    must_be(probe_volume_create(&v, &m.mesh, 0, NULL), PROBE_OK);
    struct random r = random_start(16, 0, 0);
    for (size_t i = 0; i < 27 * m.mesh.probes; i++)
        sh[i] = (random_float(&r) - 0.3f) * (i % 27 < 3 ? 1000 : 1);
    for (int half = 0; half < 2; half++) {
        const enum probe_packing packing = half ? PROBE_PACK_HALF : PROBE_PACK_FLOAT;
        bytes[half] = probe_volume_pack(v, 3, sh, 0, packing, NULL, 0);
        image[half] = malloc(bytes[half]);
        ok(probe_volume_pack(v, 3, sh, 0, packing, image[half], bytes[half]) == bytes[half],
           "packs as many bytes as it said");
        must_be(probe_volume_open(&packed[2 * half], image[half], bytes[half], 0, NULL), PROBE_OK);
        must_be(
            probe_volume_open(&packed[2 * half + 1], image[half], bytes[half], PROBE_LEAN, NULL),
            PROBE_OK);
        const struct probe_image_facts facts = probe_volume_image(packed[2 * half]);
        ok(facts.order == 3 && facts.bytes_per_probe == (half ? 24u + 54u : 24u + 108u) &&
               facts.bytes_per_cell == 16 && facts.vertex_bytes == 2,
           "%s: %zu bytes a probe, %zu a cell", half ? "halves" : "floats", facts.bytes_per_probe,
           facts.bytes_per_cell);
    }
    struct probe_volume *lazy;
    must_be(probe_volume_open(&lazy, image[0], bytes[0], PROBE_LAZY, NULL), PROBE_OK);
    double worst[4] = {0}, most = 0;
    int differ = 0;
    for (int i = 0; i < 3000; i++) {
        double p[3];
        float light[27], other[27];
        for (int k = 0; k < 3; k++)
            p[k] = 1.4 * random_double(&r) - 0.2;
        struct probe_place place = {.cell = PROBE_COLD};
        probe_volume_locate(v, p, &place);
        probe_blend(&place, sh, 27, light);
        for (int f = 0; f < 4; f++) {
            place.cell = PROBE_COLD;
            probe_volume_locate(packed[f], p, &place);
            probe_volume_light(packed[f], &place, other);
            for (int k = 0; k < 27; k++)
                worst[f] = fmax(worst[f], fabs((double)(light[k] - other[k])) / (k < 3 ? 1000 : 1));
        }
        most = fmax(most, fabs((double)light[0]));
        struct probe_place other_place = {.cell = PROBE_COLD};
        place.cell = PROBE_COLD;
        probe_volume_locate(packed[0], p, &place);
        probe_volume_locate(lazy, p, &other_place);
        differ += place.cell != other_place.cell || place.inside != other_place.inside ||
                  memcmp(place.weight, other_place.weight, sizeof place.weight) ||
                  memcmp(place.probe, other_place.probe, sizeof place.probe);
    }
    ok(differ == 0, "cells that are made when they are asked for give the same, to the bit");
    probe_volume_destroy(lazy);
    ok(worst[0] < 1e-6 && worst[1] < 1e-6,
       "floats: the light is as before it was packed (%.0e, lean %.0e)", worst[0], worst[1]);
    ok(worst[2] < 5e-4 && worst[3] < 5e-4 && worst[2] > 1e-6,
       "halves: within their rounding, 2^-11 (%.1e, lean %.1e)", worst[2], worst[3]);
    ok(probe_volume_bytes(packed[1]) < probe_volume_bytes(packed[0]) / 8,
       "lean holds %zu bytes beside the file, instead of %zu", probe_volume_bytes(packed[1]),
       probe_volume_bytes(packed[0]));

    struct probe_volume *none = NULL;
    int accepted = 0;
    unsigned char *bad = image[1];
    for (int i = 0; i < 2000; i++) { /* any bit */
        const size_t at = random_u32(&r) % bytes[1];
        bad[at] ^= (unsigned char)(1u << random_u32(&r) % 8);
        unsigned char keep[128];
        memcpy(keep, bad, sizeof keep);
        accepted += probe_volume_open(&none, bad, bytes[1], 0, NULL) == PROBE_OK;
        probe_volume_destroy(none);
        must_be(probe_volume_open(&none, image[0], bytes[0], PROBE_LEAN, NULL), PROBE_OK);
        probe_volume_destroy(none);
        i += 200;
    }
    ok(accepted == 0, "a file with a wrong bit is refused");
    accepted = 0;
    for (size_t size = 0; size < bytes[0]; size += 1 + size / 3)
        accepted += probe_volume_open(&none, image[0], size, 0, NULL) == PROBE_OK;
    ok(accepted == 0, "a file that is cut short is refused");
    static const _Alignas(8) char prose[129] =
        "this is not a packed file, is it? no, it is not. it has no more than "
        "many bytes of english prose, and then some, and an end.....";
    ok(probe_volume_open(&none, prose, 128, 0, NULL) == PROBE_NOT_AN_IMAGE,
       "what is not a packed file is refused as such");
    sh[5] = NAN;
    ok(probe_volume_pack(v, 3, sh, 0, PROBE_PACK_HALF, NULL, 0) == 0,
       "light that is not known is not packed");
    for (int i = 0; i < 4; i++)
        probe_volume_destroy(packed[i]);
    probe_volume_destroy(v);
    free(image[0]);
    free(image[1]);
    tetra_clear(&m.t);
}

/* Every half comes back; every float is rounded to the nearest. Through a mesh of one point. */
static void test_halves(void)
{
    const double position[3] = {1, 2, 3};
    const int32_t vertex = 0, neighbour = -1;
    const struct probe_mesh m = {.probes = 1,
                                 .position = position,
                                 .corners = 1,
                                 .cells = 1,
                                 .vertex = &vertex,
                                 .neighbour = &neighbour};
    struct probe_volume *v, *packed;
    must_be(probe_volume_create(&v, &m, 0, NULL), PROBE_OK);
    struct random r = random_start(17, 0, 0);
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        float sh[3] = {1, 0, 0}, back[3];
        sh[1] = ldexpf(2 * random_float(&r) - 1, -(int)(random_u32(&r) % 30));
        sh[2] = ldexpf(2 * random_float(&r) - 1, -(int)(random_u32(&r) % 12));
        uint64_t image[64];
        const size_t bytes = probe_volume_pack(v, 1, sh, 0, PROBE_PACK_HALF, image, sizeof image);
        must_be(probe_volume_open(&packed, image, bytes, 0, NULL), PROBE_OK);
        struct probe_place place = {.cell = PROBE_COLD};
        probe_volume_locate(packed, position, &place);
        probe_volume_light(packed, &place, back);
        /* half a unit of the last of 11 bits, or of the least subnormal: 2^-24 of a scale of
         * 2^-14 */
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs((double)(back[k] - sh[k])) /
                                    fmax(fabs((double)sh[k]) * 0x1p-11, 0x1p-39));
        probe_volume_destroy(packed);
    }
    ok(worst <= 1 && worst > 0.9,
       "halves are the nearest ones: %.4f of the rounding that is allowed", worst);
    probe_volume_destroy(v);
}

/* -- what is made ------------------------------------------------------------------------------ */

/* Damages one number of a mesh after another; returns how often what is said, or the row, is not
 * that of the first cell that is wrong then. */
static size_t damage(struct mesh_of *m, unsigned flags, size_t stride)
{
    struct probe_volume *v;
    size_t wrong = 0, row;
    for (size_t i = 0; i < 4 * m->mesh.cells; i += stride) {
        const int32_t cell = (int32_t)(i / 4), was = m->t.neighbour[i], corner = m->t.vertex[i],
                      both = was >= 0 && was < cell ? was : cell;
        const int32_t others[] = {-1, cell, cell ? 0 : 1, (int32_t)m->mesh.cells - 1};
        for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
            if (others[k] == was)
                continue;
            m->t.neighbour[i] = others[k];
            wrong += probe_volume_create(&v, &m->mesh, flags, &row) != PROBE_BAD_NEIGHBOUR ||
                     row != (size_t)(others[k] < 0 ? was : both);
        }
        m->t.neighbour[i] = was;
        /* flat, then inside out: an earlier neighbour does not find its face any more */
        for (int inside_out = 0; inside_out < 2; inside_out++) {
            m->t.vertex[i ^ (size_t)inside_out] = inside_out ? corner : m->t.vertex[i ^ 1];
            const enum probe_status status = probe_volume_create(&v, &m->mesh, flags, &row);
            wrong += row == (size_t)cell ? status != PROBE_BAD_SHAPE
                                         : status != PROBE_BAD_NEIGHBOUR || row > (size_t)cell;
        }
        m->t.vertex[i ^ 1] = m->t.vertex[i];
        m->t.vertex[i] = corner;
    }
    return wrong;
}

static void test_damage(void)
{
    static struct mesh_of m;
    make_mesh(RANDOM, 60, &m);
    const size_t wrong = damage(&m, 0, 7) + damage(&m, PROBE_LEAN, 7);
    ok(wrong == 0, "a neighbour or corner of a cell that is wrong is told of that cell (%zu not)",
       wrong);
    tetra_clear(&m.t);
}

/* Planes are quotients of whole numbers, each rounded once: large ones, small ones, ties. */
static void test_planes(void)
{
    static const double low[] = {0, 0x1p10, 0x1p38},
                        size[] = {1, 3, 0x1p13, 0x1p26 + 1, 0x1p38 - 1};
    size_t wrong = 0, cells = 0;
    struct random r = random_start(11, 0, 0);
    for (size_t n = 0; n < 3000; n++) {
        /* four probes, and two that hold the lattice's step at 1 and its origin at 0 */
        const double from = low[n % 3], most = size[n / 3 % 5];
        double p[18] = {0, 0, 0, 0x1p39 - 1, 0, 0};
        for (int i = 6; i < 18; i++)
            p[i] = from + floor(random_double(&r) * most + 0.5);
        int32_t vertex[4] = {2, 3, 4, 5}, neighbour[4] = {-1, -1, -1, -1};
        const lattice_volume whole = lattice_orient(p + 6, p + 9, p + 12, p + 15);
        if (whole < 0) {
            vertex[2] = 5;
            vertex[3] = 4;
        }
        const struct probe_mesh mesh = {6, p, 4, 1, vertex, neighbour};
        struct probe_volume *v;
        const enum probe_status status = probe_volume_create(&v, &mesh, 0, NULL);
        if (!whole != (status == PROBE_BAD_SHAPE))
            wrong++;
        for (int i = 1; i < 4 && v; i++) {
            lattice_volume area[3], constant = 0;
            const double *s[4];
            for (int k = 0; k < 4; k++)
                s[k] = v->site + 3 * v->cell->vertex[k];
            const double *b = s[volume_facet_corner[i][1]], *c = s[volume_facet_corner[i][2]];
            const double volume = (double)lattice_orient(s[0], s[1], s[2], s[3]);
            for (int k = 0; k < 3; k++) {
                const int x = (k + 1) % 3, y = (k + 2) % 3;
                area[k] = (lattice_volume)(b[y] - s[0][y]) * (lattice_volume)(c[x] - s[0][x]) -
                          (lattice_volume)(b[x] - s[0][x]) * (lattice_volume)(c[y] - s[0][y]);
                constant -= area[k] * (lattice_volume)s[0][k];
                wrong += v->cell->plane[k][i - 1] != (double)area[k] / volume;
            }
            wrong += v->cell->plane[3][i - 1] != (double)constant / volume;
            cells++;
        }
        probe_volume_destroy(v);
    }
    ok(wrong == 0 && cells > 3 * 2000, "planes are right to the last bit (%zu of %zu not)", wrong,
       4 * cells);
}

/* -- what is refused -------------------------------------------------------------------------- */

static void test_refused(void)
{
    static struct mesh_of m;
    make_mesh(RANDOM, 100, &m);
    struct probe_volume *v;
    size_t row;
    struct probe_mesh bad = m.mesh;
    bad.cells = 0;
    ok(probe_volume_create(&v, &bad, 0, &row) == PROBE_NO_CELLS && !v, "no cells");
    bad = m.mesh;
    bad.corners = 5;
    ok(probe_volume_create(&v, &bad, 0, &row) == PROBE_BAD_ARGUMENT, "5 corners");
    int32_t was = m.t.vertex[4 * 7 + 2];
    m.t.vertex[4 * 7 + 2] = 100;
    ok(probe_volume_create(&v, &m.mesh, 0, &row) == PROBE_BAD_VERTEX && row == 7,
       "a probe that does not exist, and where");
    m.t.vertex[4 * 7 + 2] = m.t.vertex[4 * 7 + 1];
    ok(probe_volume_create(&v, &m.mesh, 0, &row) == PROBE_BAD_SHAPE && row == 7, "a flat cell");
    m.t.vertex[4 * 7 + 2] = m.t.vertex[4 * 7 + 1];
    m.t.vertex[4 * 7 + 1] = was;
    ok(probe_volume_create(&v, &m.mesh, 0, &row) == PROBE_BAD_SHAPE && row == 7,
       "a cell inside out");
    m.t.vertex[4 * 7 + 1] = m.t.vertex[4 * 7 + 2];
    m.t.vertex[4 * 7 + 2] = was;
    was = m.t.neighbour[9];
    m.t.neighbour[9] = m.t.neighbour[9] == 3 ? 4 : 3;
    ok(probe_volume_create(&v, &m.mesh, 0, &row) == PROBE_BAD_NEIGHBOUR,
       "a neighbour that does not share the face");
    m.t.neighbour[9] = was;
    m.position[3] = INFINITY;
    ok(probe_volume_create(&v, &m.mesh, 0, &row) == PROBE_BAD_POSITION && row == 1,
       "a position that is not finite");
    tetra_clear(&m.t);
    make_mesh(RANDOM, 100, &m);
    must_be(probe_volume_create(&v, &m.mesh, 0, &row), PROBE_OK);
    struct probe_place place = {.cell = 5}, before = place;
    ok(probe_volume_locate(v, (const double[]){0, NAN, 0}, &place) == PROBE_BAD_POINT &&
           !memcmp(&place, &before, sizeof place) &&
           probe_volume_locate(v, (const double[]){-INFINITY, 0, 0}, &place) == PROBE_BAD_POINT,
       "points that are not finite");
    bool whole = true;
    for (int i = 0; i < 64; i++) { /* far out */
        const double far[3] = {i & 1 ? 1e300 : -1e300,
                               i & 2   ? 1e300
                               : i & 4 ? 1
                                       : -1e150,
                               i & 8    ? 1e308
                               : i & 16 ? 0
                                        : 1e-300};
        place.cell = i & 32 ? 2000000000 : -7;
        whole = whole && probe_volume_locate(v, far, &place) == PROBE_OK && !place.inside &&
                place.distance > 1e100 &&
                fabs(place.weight[0] + place.weight[1] + place.weight[2] + place.weight[3] - 1) <
                    1e-9;
    }
    ok(whole, "points at 1e300 have a place");
    probe_volume_destroy(v);
    tetra_clear(&m.t);
}

static void test_irradiance(void)
{
    double worst = 0;
    struct random r = random_start(18, 0, 0);
    for (int order = 1; order <= 6; order++)
        for (int i = 0; i < 200; i++) {
            float sh[108],
                n[3] = {random_float(&r) - 0.5f, random_float(&r) - 0.5f, random_float(&r) - 0.5f},
                three[3], rgb[3], bands[108];
            const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            const float a[6] = {3.14159265f, 2.09439510f, 0.785398163f, 0, -0.130899694f, 0};
            for (int k = 0; k < 3; k++)
                n[k] /= length;
            for (int k = 0; k < 3 * order * order; k++) {
                sh[k] = random_float(&r) - 0.5f;
                bands[k] = sh[k] * a[(int)sqrt(k / 3)];
            }
            probe_irradiance(order, sh, n, rgb);
            probe_irradiance_convolved(order, bands, n, three);
            for (int k = 0; k < 3; k++)
                worst = fmax(worst, fabs((double)(rgb[k] - three[k])));
        }
    ok(worst < 1e-5, "irradiance is that of the convolved coefficients, for all orders (%.0e)",
       worst);
}

int main(void)
{
    for (int shape = 0; shape < SHAPES; shape++)
        test_inside((enum shape)shape);
    for (int shape = RANDOM; shape <= SLAB; shape++)
        for (unsigned flags = 0; flags <= PROBE_EXTEND; flags += PROBE_NEAREST)
            test_continuity((enum shape)shape, flags);
    for (int shape = 0; shape < SHAPES; shape++) {
        test_outside((enum shape)shape);
        test_no_jumps((enum shape)shape);
        test_one_cell((enum shape)shape);
    }
    test_no_rays();
    for (int corners = 1; corners <= 3; corners++)
        test_flat(corners);
    test_packed();
    test_halves();
    test_damage();
    test_planes();
    test_refused();
    test_irradiance();
    return tap_done();
}
