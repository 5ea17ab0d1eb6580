/* SPDX-License-Identifier: Apache-2.0 */
/* Senders and links to them, in a closed cube, where all is known: what is seen sums to all there
 * is, with any number of links; form factors are those of the closed form and reciprocal; light
 * that scatters is the geometric series; neither threads nor clusters change that. */
#include "capture/capture_senders.h"
#include "base/array.h"
#include "base/error.h"
#include "interpolate/discs.h"
#include "relight/radiosity.h"
#include "stream/table.h"
#include "support/capture_bench.h"

enum { SIDE = 5, FACE = SIDE * SIDE, COUNT = 6 * FACE, RAYS = 1024 };

/* A cube of half 1 with SIDE^2 senders on each face, each for a square. */
struct furnace {
    struct bench bench;
    struct senders senders;
    struct discs *discs;
    struct capture_senders capture;
};

static void set_senders(struct senders *s, size_t links)
{
    *s = (struct senders){.count = COUNT, .links = links};
    must(array_create(&s->position, 3 * COUNT, sizeof *s->position));
    must(array_create(&s->normal, 3 * COUNT, sizeof *s->normal));
    must(array_create(&s->radius, COUNT, sizeof *s->radius));
    must(array_create(&s->area, COUNT, sizeof *s->area));
    must(array_create(&s->albedo, 3 * COUNT, sizeof *s->albedo));
    for (int i = 0; i < COUNT; i++) {
        const int face = i / FACE, axis = face / 2, side = face % 2 ? 1 : -1;
        const double across[2] = {(2 * (i % SIDE) + 1.0) / SIDE - 1,
                                  (2 * (i % FACE / SIDE) + 1.0) / SIDE - 1};
        s->position[3 * i + axis] = side;
        s->position[3 * i + (axis + 1) % 3] = across[0];
        s->position[3 * i + (axis + 2) % 3] = across[1];
        s->normal[3 * i + axis] = (float)-side;
        s->radius[i] = 1.0f / SIDE;
        s->area[i] = 4.0f / FACE;
        for (int c = 0; c < 3; c++)
            s->albedo[3 * i + c] = 0.8f / (float)(1 << c);
    }
    const struct sender_points points = {COUNT, s->position, s->normal, s->albedo};
    must(sender_tree_create(&s->tree, &points));
}

static void start(struct furnace *f, size_t links, int threads)
{
    bench_start(&f->bench);
    add_cube(&f->bench, 1, material(0.8f, 0));
    bench_finish(&f->bench, 0);
    set_senders(&f->senders, links);
    must(senders_discs(&f->senders, &f->discs));
    f->capture = (struct capture_senders){.path = &f->bench.path,
                                          .senders = &f->senders,
                                          .discs = f->discs,
                                          .order = 3,
                                          .rays = 8 * RAYS,
                                          .threads = threads};
    must(capture_senders_link(&f->capture, &f->senders));
}

static void end(struct furnace *f)
{
    senders_clear(&f->senders);
    discs_destroy(f->discs);
    bench_clear(&f->bench);
}

/* The senders of a node, first to last in the order. */
static struct sender_node find_node(const struct sender_tree *tree, uint32_t number)
{
    struct sender_node node = sender_tree_root(tree);
    int level = 0;
    while (number >> (level + 1))
        level++;
    while (level--)
        node = sender_tree_half(node, number >> level & 1);
    return node;
}

/* Form factors between all: every link is to one sender. */
static void form_factors(const struct senders *s, double *f)
{
    memset(f, 0, COUNT * COUNT * sizeof *f);
    for (size_t i = 0; i < COUNT * s->links; i++)
        if (s->link[i]) {
            const struct sender_node node = find_node(&s->tree, (uint32_t)s->link[i]);
            f[i / s->links * COUNT + s->tree.sender[node.first]] = (double)s->share[i];
        }
}

static void test_form_factors(void)
{
    static double f[COUNT * COUNT];
    struct furnace a, b;
    double off = 0, opposite = 0, chi = 0, pairs = 0;
    start(&a, COUNT, 1);
    form_factors(&a.senders, f);
    for (int i = 0; i < COUNT; i++) {
        double sum = 0;
        for (int k = 0; k < COUNT; k++)
            sum += f[i * COUNT + k];
        off = fmax(off, fabs(sum - 1));
    }
    ok(off < 1e-6, "what a sender sees of all others sums to 1");
    for (int k = FACE; k < 2 * FACE; k++)
        opposite += f[FACE / 2 * COUNT + k];
    /* of a square from a point before its middle, at the distance of its side: Howell, "A catalog
     * of radiation heat transfer configuration factors", B-3; 4 standard errors */
    const double q = 0.5 / sqrt(1.25), truth = 4 / PI * q * atan(q);
    ok(fabs(opposite - truth) < 4 * sqrt(truth * (1 - truth) / RAYS),
       "a face from the middle of the opposite one is %.4f, as the closed form's %.4f", opposite,
       truth);
    for (int i = 0; i < FACE; i++)
        for (int k = FACE; k < 2 * FACE; k++) {
            const double there = f[i * COUNT + k], back = f[k * COUNT + i];
            chi += (there - back) * (there - back) * RAYS / fmax(there + back, 1.0 / RAYS);
            pairs++;
        }
    ok(chi / pairs < 1.2, "A_i F_ik = A_k F_ki within the noise of so many rays: chi^2 %.2f a pair",
       chi / pairs);
    start(&b, COUNT, 3);
    ok(!memcmp(a.senders.link, b.senders.link, COUNT * COUNT * sizeof(int32_t)) &&
           !memcmp(a.senders.share, b.senders.share, COUNT * COUNT * sizeof(float)),
       "whatever the number of threads");
    ok(!a.capture.alone && !a.capture.far && a.capture.met == COUNT * RAYS,
       "all rays met a surface with a sender");
    end(&a);
    end(&b);
}

static void test_furnace(size_t links)
{
    static const int bounces[] = {0, 1, 2, 5, 400};
    struct furnace f;
    float direct[3 * COUNT];
    double *node, off = 0;
    size_t most = 0, least = COUNT;
    start(&f, links, 1);
    for (int i = 0; i < 3 * COUNT; i++)
        direct[i] = (float)PI;
    must(array_create(&node, 3 * f.senders.tree.nodes, sizeof *node));
    for (size_t n = 0; n < sizeof bounces / sizeof *bounces; n++) {
        must(radiosity_solve(&f.senders, direct, bounces[n], 1, node));
        for (int c = 0; c < 3; c++) {
            const double rho = (double)(0.8f / (float)(1 << c)),
                         truth = rho * (1 - pow(rho, bounces[n])) / (1 - rho);
            for (size_t i = 0; i < COUNT; i++)
                off = fmax(off,
                           fabs(node[3 * (size_t)f.senders.link[i * links] + (size_t)c] - truth));
        }
    }
    ok(off < 1e-5, "n bounces of even light are rho (1 - rho^n) / (1 - rho): %zu links", links);
    for (size_t i = 0; i < COUNT; i++) {
        size_t used = 0;
        while (used < links && f.senders.link[i * links + used])
            used++;
        most = used > most ? used : most;
        least = used < least ? used : least;
    }
    ok(most <= links && (links == COUNT || least == links), "%zu to %zu of them are used", least,
       most);
    free(node);
    end(&f);
}

static void test_probes(bool surface)
{
    struct furnace f;
    struct table t;
    struct column *c;
    const double half = surface ? PI : sqrt(4 * PI);
    double off = 0;
    start(&f, 20, 1);
    f.capture.rays = 4096;
    must(table_init(&t, "probe"));
    must(table_resize(&t, 2));
    must(table_add_column(&t, "position", COLUMN_F64, 3, &c));
    memcpy(column_f64(c), (const double[]){0.3, 0.1, -0.5, 0.9, 0.9, -0.9}, 6 * sizeof(double));
    if (surface) {
        must(table_add_column(&t, "normal", COLUMN_F32, 3, &c));
        memcpy(column_f32(c), (const float[]){0, 1, 0, 0, 0, -1}, 6 * sizeof(float));
    }
    must(table_add_column(&t, surface ? "irradiance" : "sh", COLUMN_F32, surface ? 3 : 27, &c));
    for (size_t i = 0; i < c->width; i++)
        column_f32(c)[i] = 0; /* the second has no light: its turn is not yet */
    must(senders_add_columns(&f.senders, 3, &t));
    must(capture_senders_rows(&f.capture, &t, 0, 2));
    const size_t functions = surface ? 1 : 9;
    const float *value = column_f32(table_column(&t, SENDERS_TRANSFER));
    for (size_t k = 0; k < functions; k++) {
        double sum = 0;
        for (size_t i = 0; i < 20; i++)
            sum += (double)value[i * functions + k];
        off = fmax(off, fabs(sum - (k ? 0 : half)));
    }
    ok(off < (surface ? 1e-5 : 0.02), "a %s sees light of 1 from all around, off by %.4f",
       surface ? "surface" : "probe", off);
    ok(isnan(value[20 * functions]) && column_i32(table_column(&t, SENDERS_OF))[20] == -1,
       "a probe without light gets no links");
    table_clear(&t);
    end(&f);
}

static void test_tree(void)
{
    struct senders s;
    struct sender_tree again;
    int32_t place[COUNT];
    set_senders(&s, 1);
    const struct sender_points points = {COUNT, s.position, s.normal, s.albedo};
    for (int i = 0; i < COUNT; i++)
        place[s.tree.sender[i]] = i;
    must(sender_tree_take(&again, &points, place));
    ok(!memcmp(again.sender, s.tree.sender, COUNT * sizeof *again.sender) &&
           !memcmp(again.spread, s.tree.spread, again.nodes * sizeof *again.spread),
       "an order that is taken over is the tree again");
    sender_tree_clear(&again);
    place[3] = place[4];
    struct error *err = sender_tree_take(&again, &points, place);
    ok(err && strstr(error_message(err), "a place of its own"), "two at one place are refused");
    error_destroy(err);
    sender_tree_clear(&again);
    senders_clear(&s);
}

/* A sheet close behind another, whose sender is nearer. */
static void test_sheets(void)
{
    const double position[] = {0, 0, 0, 0.3, 0, -0.01};
    const float normal[] = {0, 0, 1, 0, 0, 1}, radius[] = {0.5f, 0.5f};
    struct discs *discs;
    float distance;
    must(discs_create(&discs, &(struct disc_points){2, position, normal, radius}));
    const double front[] = {0.3, 0, 0}, back[] = {0, 0, -0.01}, up[] = {0, 0, 1},
                 down[] = {0, 0, -1};
    ok(discs_nearest(discs, front, up, &distance) == 0 && distance > 0.59f && distance < 0.61f &&
           discs_nearest(discs, back, up, &distance) == 1,
       "a place belongs to the sender of its own sheet");
    ok(discs_nearest(discs, front, down, &distance) == UINT32_MAX, "and side");
    discs_destroy(discs);
}

int main(void)
{
    test_tree();
    test_sheets();
    test_form_factors();
    test_furnace(COUNT);
    test_furnace(12);
    test_probes(false);
    test_probes(true);
    return tap_done();
}
