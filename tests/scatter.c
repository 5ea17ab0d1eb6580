/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered probes: the nearest one, those within a radius and the spacing are what going through
 * all of them finds, for sets of points of every kind. */
#include "interpolate/scatter.h"
#include "support/point_sets.h"
#include "support/tap.h"

#include <float.h>
#include <stdint.h>

enum { PROBES = 240, ASKED = 150 };

/* Probes and which of them are not there. */
struct set {
    double position[3 * PROBES];
    bool skipped[PROBES];
};

static bool is_skipped(const void *context, size_t probe)
{
    const struct set *s = context;
    return s->skipped[probe];
}

static double distance_to(const struct set *s, size_t probe, const double p[3])
{
    double square = 0;
    for (size_t k = 0; k < 3; k++) {
        const double d = s->position[3 * probe + k] - p[k];
        square += d * d;
    }
    return sqrt(square);
}

/* The first of the nearest, leaving out `not`. */
static size_t nearest_of_all(const struct set *s, const double p[3], size_t not )
{
    size_t best = SIZE_MAX;
    for (size_t i = 0; i < PROBES; i++)
        if (!s->skipped[i] &&
            i != not &&(best == SIZE_MAX || distance_to(s, i, p) < distance_to(s, best, p)))
            best = i;
    return best;
}

/* Whether the probe is as near as any, but for rounding, and the first of those at its place. */
static bool is_nearest(const struct set *s, const double p[3], size_t probe, double distance)
{
    const double least = distance_to(s, nearest_of_all(s, p, SIZE_MAX), p);
    for (size_t i = 0; i < probe; i++)
        if (!s->skipped[i] &&
            !memcmp(s->position + 3 * i, s->position + 3 * probe, 3 * sizeof *s->position))
            return false;
    return distance == distance_to(s, probe, p) && distance <= least * (1 + 4 * DBL_EPSILON);
}

struct visits {
    const struct set *set;
    const double *p;
    size_t count[PROBES];
    bool wrong_distance;
};

static void visit(void *context, int32_t probe, double distance)
{
    struct visits *v = context;
    v->count[probe]++;
    v->wrong_distance |= distance != distance_to(v->set, (size_t)probe, v->p);
}

/* Between two probes, beside one, at one, or as far away as the set is large. */
static void choose_place(const struct set *s, struct random *r, int i, double p[3])
{
    const double *a = s->position + 3 * (size_t)(random_u32(r) % PROBES),
                 *b = s->position + 3 * (size_t)(random_u32(r) % PROBES);
    const double along[4] = {random_double(r), 1e-3 * random_double(r), 0, 2 + random_double(r)};
    for (int k = 0; k < 3; k++)
        p[k] = a[k] + along[i % 4] * (b[k] - a[k]);
}

static void test_set(enum point_set kind)
{
    struct random r = random_start(5, kind, 0);
    static struct set s;
    struct scatter *scatter;
    make_points(kind, PROBES, &r, s.position);
    for (size_t i = 0; i < PROBES; i++)
        s.skipped[i] = random_u32(&r) % 4 == 0;
    must(scatter_create(&scatter, PROBES, s.position, is_skipped, &s));
    int other = 0, wrong_visits = 0, found = 0;
    for (int i = 0; i < ASKED; i++) {
        double p[3], distance;
        choose_place(&s, &r, i, p);
        const int32_t got = scatter_nearest(scatter, p, &distance);
        other += got < 0 || s.skipped[got] || !is_nearest(&s, p, (size_t)got, distance);
        struct visits v = {.set = &s, .p = p};
        const double radius = distance_to(&s, random_u32(&r) % PROBES, p) * (1 + 1e-9);
        scatter_within(scatter, p, radius, visit, &v);
        for (size_t k = 0; k < PROBES; k++) {
            const bool within = !s.skipped[k] && distance_to(&s, k, p) < radius;
            wrong_visits += v.count[k] != within;
            found += within;
        }
        wrong_visits += v.wrong_distance;
    }
    double spacing = 0;
    size_t there = 0;
    for (size_t i = 0; i < PROBES; i++) {
        const double *p = s.position + 3 * i;
        if (s.skipped[i])
            continue;
        spacing += 2 * distance_to(&s, nearest_of_all(&s, p, i), p);
        there++;
    }
    spacing /= (double)there;
    ok(!other, "%s: the nearest, of several at its place the first (%d are others)",
       point_set_names[kind], other);
    ok(!wrong_visits && (found || kind == SET_ONE_PLACE),
       "%s: each within the radius is visited once, no other (%d of %d are wrong)",
       point_set_names[kind], wrong_visits, found);
    ok(fabs(scatter_spacing(scatter) - spacing) <= 1e-12 * spacing,
       "%s: the spacing is twice the mean distance to the nearest other", point_set_names[kind]);
    scatter_destroy(scatter);
}

static void test_none(void)
{
    static struct set s;
    struct scatter *scatter;
    for (size_t i = 0; i < PROBES; i++)
        s.skipped[i] = true;
    struct error *err = scatter_create(&scatter, PROBES, s.position, is_skipped, &s);
    ok(err && !scatter, "probes of which none is left are refused");
    error_destroy(err);
    s.skipped[77] = false;
    double distance;
    must(scatter_create(&scatter, PROBES, s.position, is_skipped, &s));
    ok(scatter_nearest(scatter, (const double[3]){3, 4, 0}, &distance) == 77 && distance == 5 &&
           scatter_spacing(scatter) == 0,
       "the only one left is the nearest, and has no spacing");
    scatter_destroy(scatter);
}

int main(void)
{
    for (int kind = 0; kind < POINT_SETS; kind++)
        if (kind != SET_SCALES) /* squares of distances would overflow */
            test_set((enum point_set)kind);
    test_none();
    return tap_done();
}
