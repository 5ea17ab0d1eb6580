/* SPDX-License-Identifier: Apache-2.0 */
/* Choosing probes by error, of light that is a known function of the place: linear light leaves
 * none, what a probe is foretold to take off comes true when the cells are made anew, probes that
 * come in one round do not get in each other's way, those that light needs do not go, and noise is
 * no error, nor makes the mean of errors less. */
#include "adapt/cavity.h"
#include "adapt/gains.h"
#include "adapt/choice.h"
#include "adapt/insert.h"
#include "adapt/mean_error.h"
#include "adapt/move.h"
#include "adapt/thin_out.h"
#include "math/random.h"
#include "support/capture_bench.h"
#include "support/tap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNERS = 8, SPACE = 600, ALL = CORNERS + SPACE, PROBES = 24 };

typedef double light_at(const double p[3]);

static double linear(const double p[3])
{
    return 1 + p[0] + 2 * p[1] - 0.5 * p[2];
}

static double step(const double p[3])
{
    return p[0] < 0.45 ? 1 : 3;
}

static double bent(const double p[3])
{
    return 1 + 2 * p[0] * p[0] + p[1] * p[2];
}

/* Candidates in the unit cube, and its corners, which are moved out, near surfaces, so that all are
 * inside of them and no four on a circle; that have this light, with noise in both halves of what
 * is true. */
static void fill(struct candidates *c, light_at *light, double noise)
{
    struct random r = random_start(7, 0, 0);
    *c = (struct candidates){.count = ALL, .captured = ALL, .floor = 0.1};
    must(array_create(&c->position, 3 * ALL, sizeof *c->position));
    must(array_create(&c->kind, ALL, sizeof *c->kind));
    must(array_create(&c->refined, ALL, sizeof *c->refined));
    must(array_create(&c->light, ALL, sizeof *c->light));
    for (size_t i = 0; i < ALL; i++) {
        double *p = c->position + 3 * i;
        for (size_t k = 0; k < 3; k++)
            p[k] = i < CORNERS ? 1.2 * (double)(i >> k & 1) - 0.1 * random_double(&r)
                               : random_double(&r);
        c->kind[i] = i < CORNERS ? CANDIDATE_SURFACE : CANDIDATE_SPACE;
        c->refined[i] = true;
        for (int half = 0; half < 2; half++) {
            const double off = noise * (2 * random_double(&r) - 1);
            for (int d = 0; d < SPHERE_COUNT; d++) {
                c->light[i].probe[half][d] = (float)light(p);
                c->light[i].truth[half][d] = (float)(light(p) + off);
            }
        }
    }
}

/* The first ones are chosen: the corners, so that all are inside, and some of space. */
static void choose(struct choice *choice, const struct choice_world *world, size_t count)
{
    uint32_t probe[ALL];
    for (size_t i = 0; i < count; i++)
        probe[i] = (uint32_t)i;
    must(choice_init(choice, world, count, probe, NULL));
}

static void choose_more(struct choice *more, const struct choice *choice, size_t count,
                        const uint32_t *candidate)
{
    uint32_t probe[ALL];
    memcpy(probe, choice->probe, choice->count * sizeof *probe);
    memcpy(probe + choice->count, candidate, count * sizeof *probe);
    must(choice_init(more, &choice->world, choice->count + count, probe, choice));
}

/* What the errors of all that are chosen by neither fell by, as they count in the first. */
static double fell(const struct choice *from, const struct choice *to)
{
    double sum = 0;
    for (uint32_t x = 0; x < ALL; x++)
        if (choice_counts(to, x))
            sum += (double)from->weight[x] *
                   (choice_square((double)from->error[x]) - choice_square((double)to->error[x]));
    return sum;
}

static void test_linear(const struct choice_world *world)
{
    struct choice choice;
    double worst = 0;
    fill(world->candidates, linear, 0);
    choose(&choice, world, PROBES);
    for (uint32_t x = 0; x < ALL; x++)
        worst = fmax(worst, fabs((double)choice.error[x]));
    ok(worst < 1e-5, "linear light is blended without error: %.1e at most", worst);
    choice_clear(&choice);
    candidates_clear(world->candidates);
}

/* Leaves those whose cavities have no cell in common, and returns the sum of what they gain. */
static double keep_apart(const struct choice *choice, size_t count, uint32_t *candidate,
                         size_t *apart)
{
    struct cavity cavity = {0};
    bool *taken = calloc(choice->mesh.cell_count, sizeof *taken);
    double sum = 0;
    *apart = 0;
    for (size_t i = 0; i < count && taken; i++) {
        bool shared = !cavity_dig(&cavity, choice, candidate[i]);
        bool doubtful;
        const double gain = shared ? 0 : cavity_gain(&cavity, choice, candidate[i], &doubtful);
        for (size_t k = 0; k < cavity.cells; k++)
            shared = shared || taken[cavity.cell[k]];
        for (size_t k = 0; k < cavity.cells && !shared; k++)
            taken[cavity.cell[k]] = true;
        if (!shared) {
            candidate[(*apart)++] = candidate[i];
            sum += gain;
        }
    }
    free(taken);
    return sum;
}

static void test_foretold(const struct choice_world *world)
{
    enum { TRIES = 40 };
    struct choice choice;
    static struct cavity cavity;
    double worst = 0;
    int gains = 0;
    fill(world->candidates, step, 0);
    choose(&choice, world, PROBES);
    for (uint32_t i = 0; i < TRIES; i++) {
        const uint32_t x = PROBES + 7 * i;
        struct choice more;
        bool doubtful = true;
        const double gain =
            cavity_dig(&cavity, &choice, x) ? cavity_gain(&cavity, &choice, x, &doubtful) : 0;
        if (doubtful || !(gain > 1e-9))
            continue;
        choose_more(&more, &choice, 1, &x);
        worst = fmax(worst, fabs(fell(&choice, &more) - gain) / gain);
        gains++;
        choice_clear(&more);
    }
    ok(gains > TRIES / 3 && worst < 1e-4,
       "what each of %d probes takes off the errors is as foretold: %.1e of it off at most", gains,
       worst);

    uint32_t candidate[16];
    size_t found = 0;
    double gain = 0;
    struct choice more;
    must(insert_find(&choice, 16, 0.1, candidate, &found, &gain));
    choose_more(&more, &choice, found, candidate);
    ok(found > 1 && fell(&choice, &more) > gain / 2,
       "and %zu that come together, with few cells in common, most of the sum: %.3f of it", found,
       fell(&choice, &more) / gain);
    int border = 0;
    for (size_t i = 0; i < found; i++)
        border += fabs(world->candidates->position[3 * (size_t)candidate[i]] - 0.45) < 0.3;
    ok((size_t)border == found, "where half-spaces of constant light meet they stand near that");
    choice_clear(&more);
    size_t apart = 0;
    gain = keep_apart(&choice, found, candidate, &apart);
    choose_more(&more, &choice, apart, candidate);
    ok(apart > 1 && fabs(fell(&choice, &more) / gain - 1) < 1e-6,
       "%zu without any in common take off the sum, but for %.1e of it", apart,
       fell(&choice, &more) / gain - 1);
    choice_clear(&more);
    choice_clear(&choice);
    candidates_clear(world->candidates);
}

static double off_middle(const struct candidates *c, uint32_t x)
{
    double square = 0;
    for (size_t k = 0; k < 3; k++)
        square += (c->position[3 * x + k] - 0.5) * (c->position[3 * x + k] - 0.5);
    return square;
}

static void test_missed(const struct choice_world *world)
{
    enum { MANY = 60, GO = 12 };
    struct choice choice;
    uint32_t probe[MANY];
    size_t found = 0;
    bool missed = false, given = false;
    fill(world->candidates, linear, 0);
    uint32_t bump = 0;
    for (uint32_t x = 0; x < MANY; x++) /* the probe nearest to the middle */
        bump = off_middle(world->candidates, x) < off_middle(world->candidates, bump) ? x : bump;
    for (uint32_t x = 0; x < ALL; x++) /* what is near shares in a bump of light */
        for (int d = 0; d < SPHERE_COUNT; d++) {
            const double *p = world->candidates->position, *q = p + 3 * (size_t)bump;
            double square = 0;
            for (size_t k = 0; k < 3; k++)
                square += (p[3 * x + k] - q[k]) * (p[3 * x + k] - q[k]);
            const float more = (float)(3 * fmax(1 - 3 * sqrt(square), 0));
            for (int half = 0; half < 2; half++) {
                world->candidates->light[x].truth[half][d] += more;
                world->candidates->light[x].probe[half][d] += more;
            }
        }
    choose(&choice, world, MANY);
    must(thin_out_find(&choice, GO, probe, &found));
    for (size_t i = 0; i < found; i++)
        missed = missed || choice.probe[probe[i]] == bump;
    ok(found > 2 && !missed, "the probe on it is not among the %zu that are missed least", found);
    world->candidates->kind[MANY / 2] = CANDIDATE_GIVEN;
    must(thin_out_find(&choice, MANY, probe, &found));
    for (size_t i = 0; i < found; i++)
        given = given || choice.probe[probe[i]] == MANY / 2;
    ok(!given, "and given ones never are");
    choice_clear(&choice);
    candidates_clear(world->candidates);
}

/* Moves of one choice to another. */
static void choose_moved(struct choice *moved, const struct choice *choice, size_t count,
                         const struct move *move)
{
    uint32_t probe[ALL];
    memcpy(probe, choice->probe, choice->count * sizeof *probe);
    for (size_t i = 0; i < count; i++)
        probe[move[i].probe] = move[i].candidate;
    must(choice_init(moved, &choice->world, choice->count, probe, choice));
}

static void test_moves(const struct choice_world *world)
{
    enum { MANY = 90 };
    struct choice choice, moved;
    struct moves known = {0};
    struct move move[MANY], again[MANY];
    bool good[MANY];
    size_t found = 0, more = 0;
    fill(world->candidates, step, 0);
    choose(&choice, world, MANY);
    must(move_find(&choice, &known, 1, move, &found));
    choose_moved(&moved, &choice, found, move);
    const double gain = known.of[choice.probe[move[0].probe]].gain, one = fell(&choice, &moved);
    ok(found == 1 && gain > 0 && fabs(one / gain - 1) < 0.3,
       "what a probe takes off the errors elsewhere is about as foretold: %.3f of it", one / gain);
    must(move_judge(&choice, &moved, &known, found, move, good));
    ok(good[0], "and that is seen");
    choice_clear(&moved);

    must(move_find(&choice, &known, MANY, move, &found));
    choose_moved(&moved, &choice, found, move);
    must(move_judge(&choice, &moved, &known, found, move, good));
    size_t left = 0, rejected = 0;
    for (size_t i = 0; i < found; i++)
        if (good[i])
            move[left++] = move[i];
    choice_clear(&moved);
    choose_moved(&moved, &choice, left, move);
    ok(left > 2 && fell(&choice, &moved) > one, "%zu of %zu moves together take more off: %.3f",
       left, found, fell(&choice, &moved));
    choice_clear(&moved);
    must(move_judge(&choice, &choice, &known, found, move, good)); /* nothing fell */
    must(move_find(&choice, &known, MANY, again, &more));
    for (size_t i = 0; i < found; i++)
        for (size_t k = 0; k < more; k++)
            rejected += again[k].probe == move[i].probe;
    ok(!rejected, "those that came to nothing are not found again");
    moves_clear(&known);
    for (size_t i = 0; i < choice.count; i++)
        world->candidates->kind[i] = CANDIDATE_GIVEN;
    must(move_find(&choice, &known, MANY, move, &found));
    ok(!found, "given ones stay");
    moves_clear(&known);
    choice_clear(&choice);
    candidates_clear(world->candidates);
}

static void test_noise(const struct choice_world *world)
{
    struct choice choice;
    double sum = 0, squares = 0;
    fill(world->candidates, linear, 0.3);
    choose(&choice, world, PROBES);
    for (uint32_t x = PROBES; x < ALL; x++) {
        const double square = choice_square((double)choice.error[x]);
        sum += square;
        squares += square * square;
    }
    ok(fabs(sum) < 3 * sqrt(squares) && squares > 0,
       "noise of the truth is no error: mean square %.1e, %.1f standard errors", sum / SPACE,
       sum / sqrt(squares));
    choice_clear(&choice);
    candidates_clear(world->candidates);
    fill(world->candidates, bent, 0);
    choose(&choice, world, PROBES);
    ok(choice.errors.space > 0.01, "and what is bent has one: %.3f", choice.errors.space);
    const size_t bytes = choice_bytes(&choice, 3), more = choice_bytes(&choice, 5);
    ok(bytes > PROBES * 4 * 27 && more >= bytes + PROBES * 4 * 3 * 16,
       "%zu bytes with order 3, %zu with 5", bytes, more);
    choice_clear(&choice);
    candidates_clear(world->candidates);
}

/* Judges whose own light is a fifth less than the truth. */
static void test_least(const struct choice_world *world)
{
    struct choice choice;
    struct candidates *c = world->candidates;
    double least = 0;
    fill(c, bent, 0);
    for (size_t x = ALL - 100; x < ALL; x++) {
        c->kind[x] = CANDIDATE_JUDGE;
        for (int half = 0; half < 2; half++)
            for (int d = 0; d < SPHERE_COUNT; d++)
                c->light[x].truth[half][d] *= 1.25f;
    }
    c->judges = 100;
    choose(&choice, world, PROBES);
    must(choice_least_error(&choice, &least));
    ok(fabs(least - 0.2) < 1e-5, "a probe at each judge would leave %.4f", least);
    choice_clear(&choice);
    candidates_clear(c);
}

/* About normal: of mean 0, variance 1. */
static double normal(struct random *r)
{
    double sum = -6;
    for (int i = 0; i < 12; i++)
        sum += random_double(r);
    return sum;
}

/* Errors e of which x = e + noise and y = noise are known: the square x^2 - y^2, the product 2 x y.
 * Every tenth error is ten times as large. */
static void test_mean_error(double noise, double share, int least_held)
{
    enum { POINTS = 2000, TRIES = 20 };
    double off = 0, plain = 0, true_mean = 0;
    int held = 0;
    for (uint32_t try = 0; try < TRIES; try++) {
        struct noisy_square point[POINTS];
        struct random r = random_start(11, 1, try);
        double mean, doubt, sum = 0, roots = 0;
        for (uint32_t i = 0; i < POINTS; i++) {
            const double about = i % 10 ? 0.05 : 0.5, e = about * 2 * random_double(&r),
                         x = e + noise * normal(&r), y = noise * normal(&r), square = x * x - y * y;
            point[i] = (struct noisy_square){about, i, square, 2 * x * y};
            sum += e / POINTS;
            roots += copysign(sqrt(fabs(square)), square) / POINTS;
        }
        mean_error(POINTS, point, &mean, &doubt);
        off += (mean - sum) / TRIES;
        plain += (roots - sum) / TRIES;
        true_mean += sum / TRIES;
        held += fabs(mean - sum) < 1.96 * doubt;
    }
    ok(fabs(off) < share * true_mean && held >= least_held,
       "errors with noise of %.3f: their mean is off by %.1f %% of it (that of roots: %.1f %%), "
       "and "
       "in %d of %d intervals",
       noise, 100 * off / true_mean, 100 * plain / true_mean, held, TRIES);
}

int main(void)
{
    struct bench b;
    struct candidates candidates = {0};
    const double far[9] = {50, 50, 50, 51, 50, 50, 50, 51, 50};
    const uint32_t index[3] = {0, 1, 2};
    const struct scene_material grey = material(0.5f, 0);
    bench_start(&b);
    must(scene_add_mesh(b.scene, 3, far, 1, index, &grey)); /* nothing is in the way */
    bench_finish(&b, 0);
    const struct capture_settings settings = capture_settings_default();
    const struct candidates_job job = {.path = &b.path, .settings = &settings, .threads = 2};
    struct gains gains = {0};
    struct seen_known seen = {0};
    const struct choice_world world = {&candidates, &job, &gains, &seen};
    test_linear(&world);
    test_foretold(&world);
    test_missed(&world);
    test_moves(&world);
    test_noise(&world);
    test_least(&world);
    test_mean_error(0, 1e-6, 20);
    test_mean_error(0.05, 0.04, 16);
    test_mean_error(0.1, 0.12, 0); /* twice as large as most errors */
    gains_clear(&gains);
    seen_clear(&seen);
    bench_clear(&b);
    return tap_done();
}
