/* SPDX-License-Identifier: Apache-2.0 */
/* Octrees of probes: each that is one is recognised and nothing else is; between its probes values
 * are means of theirs, linear fields come out exactly, and no face or edge shows in the values, nor
 * in the slopes of cubics.
 *
 *     octree [SETS [SEED]]     of the mutated ones; part of make check with few
 */
#include "base/error.h"
#include "interpolate/nodes.h"
#include "interpolate/octree.h"
#include "math/random.h"
#include "support/tap.h"

#include <string.h>

enum { ROOM = 60000, DEEPEST = 16 }; /* a root cell is 2^DEEPEST units */

static uint32_t below(struct random *r, size_t n)
{
    return (uint32_t)(random_double(r) * (double)n);
}

/* -- octrees to be found ---------------------------------------------------------------------- */

struct cell {
    int32_t x[3], size;
};

/* Probes, and the leaves that they are corners of. */
struct set {
    uint64_t node[ROOM];
    double position[3 * ROOM];
    size_t probes, leaves;
    struct cell leaf[ROOM];
    int32_t roots[3];
    double low[3], root[3]; /* root: sizes of a root cell; 0: flat */
};

static void place(const struct set *s, const double x[3], double p[3])
{
    for (int k = 0; k < 3; k++)
        p[k] = s->low[k] + x[k] / (1 << DEEPEST) * s->root[k];
}

static int compare(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static void add_nodes(struct set *s, const struct cell *c, int parts)
{
    for (int i = 0; i < (parts + 1) * (parts + 1) * (parts + 1) && s->probes < ROOM; i++) {
        const int at[3] = {i % (parts + 1), i / (parts + 1) % (parts + 1),
                           i / (parts + 1) / (parts + 1)};
        uint64_t node = 0;
        for (int k = 0; k < 3; k++)
            node = node << 21 | (uint64_t)(s->root[k] > 0 ? c->x[k] + at[k] * c->size / parts : 0);
        s->node[s->probes++] = node;
    }
}

static void cut(struct set *s, size_t leaf)
{
    const struct cell c = s->leaf[leaf];
    add_nodes(s, &c, 2);
    for (int part = 0; part < 8; part++) {
        struct cell *to = part ? &s->leaf[s->leaves++] : &s->leaf[leaf];
        *to = (struct cell){.size = c.size / 2};
        for (int k = 0; k < 3; k++)
            to->x[k] = c.x[k] + (part >> k & 1) * c.size / 2;
    }
}

/* Sorts the nodes, leaves one of each, and shuffles them if a seed is given. */
static void finish(struct set *s, uint64_t shuffle)
{
    size_t n = 0;
    struct random r = random_start(shuffle, 0, 0);
    qsort(s->node, s->probes, sizeof *s->node, compare);
    for (size_t i = 0; i < s->probes; i++)
        if (!n || s->node[i] != s->node[n - 1])
            s->node[n++] = s->node[i];
    s->probes = n;
    for (size_t i = n - 1; i > 0 && shuffle; i--) {
        const size_t j = below(&r, i + 1);
        const uint64_t swap = s->node[i];
        s->node[i] = s->node[j];
        s->node[j] = swap;
    }
    for (size_t i = 0; i < n; i++) {
        const double x[3] = {(double)(s->node[i] >> 42), (double)(s->node[i] >> 21 & 0x1fffff),
                             (double)(s->node[i] & 0x1fffff)};
        place(s, x, s->position + 3 * i);
    }
}

static void start(struct set *s, const int32_t roots[3], const double low[3], const double root[3])
{
    *s = (struct set){.roots = {roots[0], roots[1], roots[2]},
                      .low = {low[0], low[1], low[2]},
                      .root = {root[0], root[1], root[2]}};
    for (int i = 0; i < roots[0] * roots[1] * roots[2]; i++) {
        const int at[3] = {i % roots[0], i / roots[0] % roots[1], i / roots[0] / roots[1]};
        struct cell *c = &s->leaf[s->leaves++];
        *c = (struct cell){.size = 1 << DEEPEST};
        for (int k = 0; k < 3; k++)
            c->x[k] = at[k] << DEEPEST;
        add_nodes(s, c, 1);
    }
}

/* Cells cut at random, to some depth. */
static void make_random(struct set *s, uint64_t seed, int cuts, int deepest)
{
    struct random r = random_start(seed, 1, 0);
    start(s, (int32_t[3]){2, 1, 3}, (double[3]){-1, 20, 3e3}, (double[3]){1, 0.3, 2.5});
    for (int tries = 20 * cuts; cuts > 0 && tries > 0; tries--) {
        /* late ones are small */
        const size_t leaf = below(&r, 4)
                                ? s->leaves - 1 - below(&r, s->leaves < 16 ? s->leaves : 16)
                                : below(&r, s->leaves);
        if (s->leaf[leaf].size > 1 << (DEEPEST - deepest)) {
            cut(s, leaf);
            cuts--;
        }
    }
    finish(s, seed);
}

static float *field(const struct set *s, size_t width, uint64_t seed)
{
    float *value = malloc(s->probes * width * sizeof *value);
    for (size_t i = 0; value && i < s->probes; i++)
        for (size_t v = 0; v < width; v++) { /* of the place, not of the row */
            struct random r = random_start(seed, s->node[i], (uint32_t)v);
            value[i * width + v] = random_float(&r);
        }
    if (!value)
        bail("memory");
    return value;
}

static float *filled(const struct octree *t, bool cubic, size_t width, const float *value)
{
    float *data;
    must(octree_fill(t, cubic, width, value, &data));
    return data;
}

/* A place in the box, in units; now and then on one of the planes. */
static void anywhere(const struct set *s, struct random *r, double x[3])
{
    for (int k = 0; k < 3; k++) {
        x[k] = random_double(r) * (double)(s->roots[k] << DEEPEST);
        if (!below(r, 4))
            x[k] = floor(x[k] / (1 << (DEEPEST - 3)) + 0.5) * (1 << (DEEPEST - 3));
    }
}

/* -- properties ------------------------------------------------------------------------------- */

static struct set a, b;

static void test_found(void)
{
    int wrong = 0;
    double worst = 0, least = 1, most = 0, sum = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        struct octree t;
        struct random r = random_start(seed, 2, 0);
        make_random(&a, seed, 12, seed % 2 ? 3 : 9);
        must(octree_find(&t, a.probes, a.position));
        /* each probe's spacing is its largest leaf's */
        for (size_t i = 0; i < a.probes; i++) {
            const int32_t x[3] = {(int32_t)(a.node[i] >> 42), (int32_t)(a.node[i] >> 21 & 0x1fffff),
                                  (int32_t)(a.node[i] & 0x1fffff)};
            int32_t size = 0;
            for (size_t j = 0; j < a.leaves; j++) {
                bool corner = true;
                for (int k = 0; k < 3; k++)
                    corner = corner &&
                             (x[k] == a.leaf[j].x[k] || x[k] == a.leaf[j].x[k] + a.leaf[j].size);
                if (corner && a.leaf[j].size > size)
                    size = a.leaf[j].size;
            }
            wrong += (int64_t)t.spacing[i] * (1 << DEEPEST) != (int64_t)size * t.root;
        }
        /* column i is 1 at probe i alone: values are weights */
        const size_t n = a.probes;
        float *one = calloc(n * n, sizeof *one), *weight = malloc(n * sizeof *weight);
        for (size_t i = 0; one && i < n; i++)
            one[i * n + i] = 1;
        float *data = filled(&t, false, n, one);
        for (int i = 0; i < 200; i++) {
            double x[3], p[3], all = 0;
            anywhere(&a, &r, x);
            place(&a, x, p);
            octree_at(&t, false, n, data, p, weight);
            for (size_t v = 0; v < n; v++) {
                all += (double)weight[v];
                least = fmin(least, (double)weight[v]);
                most = fmax(most, (double)weight[v]);
            }
            sum = fmax(sum, fabs(all - 1));
        }
        for (size_t i = 0; i < n; i++) {
            octree_at(&t, false, n, data, a.position + 3 * i, weight);
            worst = fmax(worst, fabs((double)weight[i] - 1));
        }
        free(one);
        free(weight);
        free(data);
        octree_clear(&t);
    }
    ok(!wrong,
       "octrees cut at random are found, in any order of the probes, and each probe's largest cell "
       "(%d wrong)",
       wrong);
    ok(least >= 0 && most <= 1 && sum < 1e-6,
       "linear: weights are 0 to 1 (%g, %g) and sum to 1 (off by %.0e)", least, most, sum);
    ok(worst < 1e-6, "linear: at a probe, its value (%.0e)", worst);
}

/* Linear fields, and each probe's value, in both ways. */
static void test_reproduced(void)
{
    double linear[2] = {0}, hit[2] = {0};
    for (uint64_t seed = 1; seed <= 10; seed++)
        for (int cubic = 0; cubic < 2; cubic++) {
            enum { WIDTH = 4 };
            static const double slope[WIDTH][3] = {
                {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, -0.4, 0.2}};
            struct octree t;
            struct random r = random_start(seed, 3, 0);
            float out[WIDTH];
            make_random(&a, seed, 60, 6);
            must(octree_find(&t, a.probes, a.position));
            float *value = field(&a, WIDTH, seed), *data = filled(&t, cubic, WIDTH, value);
            for (size_t i = 0; i < a.probes; i++) {
                octree_at(&t, cubic, WIDTH, data, a.position + 3 * i, out);
                for (size_t v = 0; v < WIDTH; v++)
                    hit[cubic] = fmax(hit[cubic], fabs((double)(out[v] - value[WIDTH * i + v])));
            }
            free(data);
            for (size_t i = 0; i < a.probes; i++)
                for (size_t v = 0; v < WIDTH; v++) {
                    double f = 0;
                    for (size_t k = 0; k < 3; k++)
                        f += slope[v][k] * (a.position[3 * i + k] - a.low[k]) / a.root[k];
                    value[WIDTH * i + v] = (float)f;
                }
            data = filled(&t, cubic, WIDTH, value);
            for (int i = 0; i < 2000; i++) {
                double x[3], p[3];
                anywhere(&a, &r, x);
                place(&a, x, p);
                octree_at(&t, cubic, WIDTH, data, p, out);
                for (int v = 0; v < WIDTH; v++) {
                    double f = 0;
                    for (int k = 0; k < 3; k++)
                        f += slope[v][k] * x[k] / (1 << DEEPEST);
                    linear[cubic] = fmax(linear[cubic], fabs((double)out[v] - f));
                }
            }
            free(value);
            free(data);
            octree_clear(&t);
        }
    ok(linear[0] < 2e-6 && linear[1] < 2e-6,
       "linear fields come out (linear off by %.0e, cubic by %.0e)", linear[0], linear[1]);
    /* positions 3e3 away are rounded */
    ok(hit[0] < 1e-6 && hit[1] < 5e-6, "at a probe, its value (%.0e, %.0e)", hit[0], hit[1]);
}

/* Across each face of each leaf: how far values are apart on both sides at a distance of 1e-9, and
 * slopes across it. */
static void test_smooth(void)
{
    double jump[2] = {0}, kink[2] = {0}, steepest[2] = {0};
    for (uint64_t seed = 1; seed <= 10; seed++)
        for (int cubic = 0; cubic < 2; cubic++) {
            enum { WIDTH = 3 };
            struct octree t;
            struct random r = random_start(seed, 4, 0);
            make_random(&a, seed, 40, 4);
            must(octree_find(&t, a.probes, a.position));
            float *value = field(&a, WIDTH, seed), *data = filled(&t, cubic, WIDTH, value);
            for (size_t leaf = 0; leaf < a.leaves; leaf++)
                for (int side = 0; side < 6 * 8; side++) {
                    const struct cell *c = &a.leaf[leaf];
                    const int axis = side / 2 % 3;
                    double x[3], p[3], far[3], step;
                    float near[2][WIDTH], away[2][WIDTH];
                    /* on the face; now and then on an edge or in its middle */
                    for (int k = 0; k < 3; k++) {
                        const double in = below(&r, 3) ? random_double(&r)
                                                       : (double)below(&r, 5) / 4;
                        x[k] = c->x[k] + c->size * (k == axis ? side % 2 : in);
                    }
                    if (x[axis] <= 0 || x[axis] >= a.roots[axis] << DEEPEST)
                        continue;
                    place(&a, x, p);
                    for (int way = 0; way < 2; way++) {
                        memcpy(far, p, sizeof far);
                        step = a.root[axis] * 1e-9;
                        far[axis] = p[axis] + (way ? step : -step);
                        octree_at(&t, cubic, WIDTH, data, far, near[way]);
                        step = a.root[axis] / 4096;
                        far[axis] = p[axis] + (way ? step : -step);
                        octree_at(&t, cubic, WIDTH, data, far, away[way]);
                    }
                    for (int v = 0; v < WIDTH; v++) {
                        const double up = (double)(away[1][v] - near[1][v]) * 4096,
                                     down = (double)(near[0][v] - away[0][v]) * 4096;
                        jump[cubic] = fmax(jump[cubic], fabs((double)(near[1][v] - near[0][v])));
                        kink[cubic] = fmax(kink[cubic], fabs(up - down));
                        steepest[cubic] = fmax(steepest[cubic], fabs(up));
                    }
                }
            free(value);
            free(data);
            octree_clear(&t);
        }
    ok(jump[0] < 2e-6 && jump[1] < 4e-6,
       "across faces of cells no value jumps (linear %.0e, cubic %.0e)", jump[0], jump[1]);
    ok(kink[1] < steepest[1] / 20 && kink[0] > steepest[0] / 2,
       "nor does a cubic's slope (by %.2g where slopes are up to %.2g; a linear one's by %.2g of "
       "%.2g)",
       kink[1], steepest[1], kink[0], steepest[0]);
}

/* Along lines from border to border values change no faster than they may: by the steepest slope of
 * any cell. */
static void test_lines(void)
{
    enum { WIDTH = 3, STEPS = 20000 };
    struct octree t;
    struct random r = random_start(5, 5, 0);
    make_random(&a, 5, 60, 5);
    must(octree_find(&t, a.probes, a.position));
    float *value = field(&a, WIDTH, 5);
    for (int cubic = 0; cubic < 2; cubic++) {
        float *data = filled(&t, cubic, WIDTH, value);
        double most = 0;
        for (int line = 0; line < 40; line++) {
            double from[3], to[3];
            float last[WIDTH], now[WIDTH];
            anywhere(&a, &r, from);
            anywhere(&a, &r, to);
            for (int i = 0; i <= STEPS; i++) {
                double x[3], p[3];
                for (int k = 0; k < 3; k++)
                    x[k] = from[k] + (to[k] - from[k]) * i / STEPS;
                place(&a, x, p);
                octree_at(&t, cubic, WIDTH, data, p, now);
                for (int v = 0; v < WIDTH && i; v++)
                    most = fmax(most, fabs((double)(now[v] - last[v])));
                memcpy(last, now, sizeof last);
            }
        }
        /* a step is at most 6 / STEPS of a root cell along all axes, the least cell 1/32 of one,
         * values 0 to 1 */
        const double bound = 32.0 * 6 / STEPS * (cubic ? 4 : 1) + 1e-6;
        ok(most < bound, "%s: along lines no step changes more than slopes allow (%.1e of %.1e)",
           cubic ? "cubic" : "linear", most, bound);
        free(data);
    }
    free(value);
    octree_clear(&t);
}

static void test_order(void)
{
    enum { WIDTH = 5 };
    struct octree s, t;
    struct random r = random_start(6, 6, 0);
    make_random(&a, 6, 40, 6);
    b = a;
    finish(&b, 77);
    must(octree_find(&s, a.probes, a.position));
    must(octree_find(&t, b.probes, b.position));
    float *of_a = field(&a, WIDTH, 6), *of_b = field(&b, WIDTH, 6);
    ok(memcmp(of_a, of_b, a.probes * WIDTH * sizeof *of_a) != 0, "the rows are in another order");
    for (int cubic = 0; cubic < 2; cubic++) {
        float *x_a = filled(&s, cubic, WIDTH, of_a), *x_b = filled(&t, cubic, WIDTH, of_b),
              at_a[WIDTH], at_b[WIDTH];
        int differ = 0;
        for (int i = 0; i < 20000; i++) {
            double x[3], p[3];
            anywhere(&a, &r, x);
            place(&a, x, p);
            octree_at(&s, cubic, WIDTH, x_a, p, at_a);
            octree_at(&t, cubic, WIDTH, x_b, p, at_b);
            differ += memcmp(at_a, at_b, sizeof at_a) != 0;
        }
        ok(!differ, "%s: the same bytes for any order of the probes", cubic ? "cubic" : "linear");
        free(x_a);
        free(x_b);
    }
    free(of_a);
    free(of_b);
    octree_clear(&s);
    octree_clear(&t);
}

/* An even grid is an octree, too: as the grid's own code has it. */
static void test_grid(void)
{
    static const int32_t sides[][3] = {{4, 4, 4}, {3, 5, 1}, {1, 1, 1}, {8, 2, 6}};
    double worst[2] = {0};
    for (size_t size = 0; size < sizeof sides / sizeof *sides; size++) {
        struct octree t;
        struct nodes g;
        struct random r = random_start(size, 7, 0);
        start(&a, sides[size], (double[3]){0, -7, 100}, (double[3]){1, 2, 0.25});
        finish(&a, 7 + size);
        must(octree_find(&t, a.probes, a.position));
        must(nodes_find(&g, a.probes, a.position));
        float *value = field(&a, 1, 7);
        for (int cubic = 0; cubic < 2; cubic++) {
            float *data = filled(&t, cubic, 1, value), out;
            for (int i = 0; i < 2000; i++) {
                double x[3], p[3], weight[3][4], sum = 0;
                size_t node[3][4];
                anywhere(&a, &r, x);
                place(&a, x, p);
                for (int k = 0; k < 3; k++)
                    (cubic ? nodes_cubic : nodes_linear)(&g, k, p[k], node[k], weight[k]);
                for (int j = 0; j < 64; j++) {
                    const size_t at = (node[2][j / 16] * g.count[1] + node[1][j / 4 % 4]) *
                                          g.count[0] +
                                      node[0][j % 4];
                    sum += weight[2][j / 16] * weight[1][j / 4 % 4] * weight[0][j % 4] *
                           (double)value[g.probe[at]];
                }
                octree_at(&t, cubic, 1, data, p, &out);
                worst[cubic] = fmax(worst[cubic], fabs((double)out - sum));
            }
            free(data);
        }
        free(value);
        nodes_clear(&g);
        octree_clear(&t);
    }
    ok(worst[0] < 1e-6 && worst[1] < 1e-6,
       "an even grid has the values of the grid's own code (linear off by %.0e, cubic by %.0e)",
       worst[0], worst[1]);
}

/* In a plane and on a line. */
static void test_flat(void)
{
    static const int32_t roots[2][3] = {{2, 1, 1}, {1, 1, 3}};
    static const double root[2][3] = {{1, 0, 1}, {0, 0, 1}};
    for (int kind = 0; kind < 2; kind++) {
        struct octree t;
        struct random r = random_start(8, 8, 0);
        double worst = 0;
        start(&a, roots[kind], (double[3]){5, 6, 7}, root[kind]);
        for (int i = 0; i < 10; i++)
            cut(&a, i % 3 ? a.leaves - 8 : below(&r, a.leaves));
        finish(&a, 8);
        must(octree_find(&t, a.probes, a.position));
        float *value = field(&a, 1, 8);
        for (size_t i = 0; i < a.probes; i++)
            value[i] = (float)(a.position[3 * i] + 2 * a.position[3 * i + 2] - 19);
        for (int cubic = 0; cubic < 2; cubic++) {
            float *data = filled(&t, cubic, 1, value), out;
            for (int i = 0; i < 1000; i++) {
                double x[3], p[3];
                anywhere(&a, &r, x);
                place(&a, x, p);
                octree_at(&t, cubic, 1, data, p, &out);
                worst = fmax(worst, fabs((double)out - (p[0] + 2 * p[2] - 19)));
            }
            free(data);
        }
        ok(worst < 2e-6 && t.nodes < 4 * t.probes,
           "%s: cells are flat, linear fields come out (%.0e)", kind ? "on a line" : "in a plane",
           worst);
        free(value);
        octree_clear(&t);
    }
}

static bool refused(const double *position, size_t probes, const char *why)
{
    struct octree t;
    struct error *err = octree_find(&t, probes, position);
    const bool right = err && strstr(error_message(err), why);
    if (!right)
        printf("# %s\n", err ? error_message(err) : "not refused");
    octree_clear(&t);
    error_destroy(err);
    return right;
}

static void test_refused(void)
{
    int taken = 0;
    make_random(&a, 9, 25, 3);
    /* without any one of them, it is none; but a cell whose probes are no one else's may only be
     * whole */
    for (size_t i = 0; i < a.probes; i++) {
        struct octree t;
        b = a;
        memmove(b.position + 3 * i, b.position + 3 * (i + 1),
                3 * (b.probes - i - 1) * sizeof *b.position);
        struct error *err = octree_find(&t, b.probes - 1, b.position);
        taken += !err;
        octree_clear(&t);
        error_destroy(err);
    }
    ok(!taken, "without any one of its %zu probes it is none (%d were taken)", a.probes, taken);
    start(&a, (int32_t[3]){2, 2, 2}, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    cut(&a, 0);
    finish(&a, 0);
    const size_t last = a.probes;
    double *more = a.position + 3 * last;
    more[0] = 1.5, more[1] = 0.5, more[2] = 1;
    ok(refused(a.position, last + 1, "at 1.5 0.5 1 is no corner of a cell"),
       "a probe too much, in a face");
    more[0] = more[1] = more[2] = 1.5;
    ok(refused(a.position, last + 1,
               "there is no probe at 1.5 1 1, a node of the cell (with a probe in its middle) from "
               "1 1 1 to 2 2 2"),
       "a probe too much, in the middle of a cell");
    more[0] = 1.3;
    ok(refused(a.position, last + 1, "x = "), "a probe where no halving comes to");
    memcpy(more, a.position + 3 * 4, 3 * sizeof *more);
    ok(refused(a.position, last + 1, "probes 4 and 46 are at one node"), "two probes in one place");
    more[0] = 1e300;
    ok(refused(a.position, last + 1, ""), "a probe far away");
    more[0] = 3;
    ok(refused(a.position, last + 1,
               "there is no probe at 3 0 0, a corner of the cell from 2 0 0 to 3 1 1"),
       "a probe outside");
    struct random r = random_start(9, 9, 0);
    for (size_t i = 0; i < 3 * 1000; i++)
        b.position[i] = random_double(&r);
    ok(refused(b.position, 1000, "is not where halving") ||
           refused(b.position, 1000, "differ too much"),
       "probes at random");
    ok(refused(b.position, 0, "no probes"), "no probes");
}

/* Positions that are a little off, far from the origin, very small and very large. */
static void test_scales(void)
{
    static const double scales[] = {1, 1e-300, 1e300, 1e-6, 1e12};
    int lost = 0;
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++)
        for (int far = 0; far < 2; far++) {
            struct octree t;
            struct random r = random_start(i, 10, 0);
            make_random(&a, 10, 30, 5);
            for (size_t j = 0; j < 3 * a.probes; j++) {
                const double off = (random_double(&r) - 0.5) * a.root[j % 3] * 2e-7;
                a.position[j] = scales[i] *
                                (((a.position[j] - a.low[j % 3]) + off) + (far ? 1e4 : 0));
            }
            struct error *err = octree_find(&t, a.probes, a.position);
            if (err)
                printf("# %g: %s\n", scales[i], error_message(err));
            lost += err != NULL;
            error_destroy(err);
            octree_clear(&t);
        }
    ok(!lost, "a scale, an offset and a ten-millionth off do not matter (%d lost)", lost);
}

/* Whatever positions there are, finding ends, and what is found answers everywhere. */
static void test_mutated(unsigned long sets, uint64_t seed)
{
    unsigned long found = 0, wrong = 0;
    for (unsigned long i = 0; i < sets; i++) {
        struct octree t;
        struct random r = random_start(seed, 11, (uint32_t)i);
        make_random(&a, seed + i, (int)below(&r, 12), 1 + (int)below(&r, DEEPEST));
        for (uint32_t m = below(&r, 3); m > 0; m--) {
            const size_t at = below(&r, 3 * a.probes), other = below(&r, 3 * a.probes);
            static const double numbers[] = {0, -0.0, 1e300, -1e300, 1.7e308, -1.7e308, 5e-324, 1};
            switch (below(&r, 6)) {
            case 0: a.position[at] = numbers[below(&r, 8)]; break;
            case 1: a.position[at] = a.position[other]; break;
            case 2: a.position[at] *= 1 + 1e-6 * (random_double(&r) - 0.5); break;
            case 3:
                memcpy(a.position + at / 3 * 3, a.position + 3 * --a.probes,
                       3 * sizeof *a.position);
                break;
            case 4:
                memcpy(a.position + 3 * a.probes++,
                       (double[3]){a.position[at / 3 * 3], a.position[other / 3 * 3 + 1],
                                   a.position[at / 3 * 3 + 2]},
                       3 * sizeof *a.position);
                break;
            default:
                a.position[at] = (a.position[at] + a.position[other / 3 * 3 + at % 3]) / 2;
                break;
            }
        }
        struct error *err = octree_find(&t, a.probes, a.position);
        if (!err) {
            float *value = malloc(a.probes * sizeof *value), out;
            for (size_t j = 0; value && j < a.probes; j++)
                value[j] = 1;
            for (int cubic = 0; cubic < 2 && value; cubic++) {
                float *data = filled(&t, cubic, 1, value);
                for (int k = 0; k < 20; k++) {
                    const double p[3] = {8 * random_double(&r) - 4,
                                         1e300 * (random_double(&r) - 0.5),
                                         3e3 + 10 * random_double(&r)};
                    octree_at(&t, cubic, 1, data, p, &out);
                    wrong += fabsf(out - 1) < 1e-4f ? 0 : 1;
                }
                free(data);
            }
            free(value);
        }
        found += !err;
        error_destroy(err);
        octree_clear(&t);
    }
    ok(!wrong && found > sets / 10 && found < sets,
       "%lu sets of mutated positions: an octree (%lu times) that answers, or an error", sets,
       found);
}

int main(int argc, char **argv)
{
    const unsigned long sets = argc > 1 ? strtoul(argv[1], NULL, 10) : 3000;
    test_found();
    test_reproduced();
    test_smooth();
    test_lines();
    test_order();
    test_grid();
    test_flat();
    test_refused();
    test_scales();
    test_mutated(sets, argc > 2 ? strtoull(argv[2], NULL, 10) : 1);
    return tap_done();
}
