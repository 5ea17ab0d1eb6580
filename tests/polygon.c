/* SPDX-License-Identifier: Apache-2.0 */
/* Polygons split into triangles: nothing is lost, nothing covered twice, in whatever plane and
 * however hollow. */
#include "base/error.h"
#include "import/polygon.h"
#include "math/vec.h"
#include "support/tap.h"

#include <stdint.h>
#include <string.h>

static struct vec3 area_vector(const double *a, const double *b, const double *c)
{
    return vec3_scale(0.5, vec3_cross(vec3_sub(vec3_load(b), vec3_load(a)),
                                      vec3_sub(vec3_load(c), vec3_load(a))));
}

/* A pseudo-random number in [0, 1). */
static double number(void)
{
    static unsigned long long state = 88172645463325252ull;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 9007199254740992.0;
}

struct seen {
    double sum;      /* of the triangles' areas */
    struct vec3 net; /* of their area vectors */
    double least;    /* the smallest area */
    bool all_used, in_range;
};

static struct seen look(const struct polygon_room *room, size_t n)
{
    struct seen seen = {.least = (double)INFINITY, .all_used = true, .in_range = true};
    bool used[512] = {false};
    for (size_t t = 0; t < n - 2; t++) {
        const uint32_t *i = room->triangle + 3 * t;
        for (int k = 0; k < 3; k++) {
            seen.in_range = seen.in_range && i[k] < n;
            used[i[k] < n ? i[k] : 0] = true;
        }
        const struct vec3 a =
            area_vector(room->corner + 3 * i[0], room->corner + 3 * i[1], room->corner + 3 * i[2]);
        seen.sum += vec3_length(a);
        seen.net = vec3_add(seen.net, a);
        seen.least = fmin(seen.least, vec3_length(a));
    }
    for (size_t k = 0; k < n; k++)
        seen.all_used = seen.all_used && used[k];
    return seen;
}

/* Simple polygons around a point, in a random plane, either way round; a third has corners on
 * straight sides. */
static void test_simple(void)
{
    struct polygon_room room = {0};
    double worst = 0, least = (double)INFINITY;
    bool whole = true;
    for (int round = 0; round < 20000; round++) {
        const size_t n = 4 + (size_t)(number() * 20);
        struct error *err = polygon_room_for(&room, n);
        if (err)
            bail("%s", error_message(err));
        const struct vec3 u = {number() - 0.5, number() - 0.5, number() - 0.5},
                          v = {number() - 0.5, number() - 0.5, number() - 0.5},
                          o = {100 * number(), 100 * number(), 100 * number()};
        double plane[64][2], area = 0;
        for (size_t i = 0; i < n; i++) {
            const double angle = 2 * acos(-1.0) * ((double)i + 0.8 * number()) / (double)n *
                                 (round % 2 ? -1 : 1);
            const double radius = 0.05 + number();
            plane[i][0] = radius * cos(angle);
            plane[i][1] = radius * sin(angle);
        }
        for (size_t i = 1; i + 1 < n && round % 3 == 0; i += 2)
            for (int k = 0; k < 2; k++)
                plane[i][k] = 0.5 * (plane[i - 1][k] + plane[i + 1][k]);
        for (size_t i = 0; i < n; i++) {
            const double *a = plane[i], *b = plane[(i + 1) % n];
            area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
            vec3_store(room.corner + 3 * i, vec3_fma(vec3_fma(o, a[0], u), a[1], v));
        }
        polygon_split(&room, n);
        const struct seen seen = look(&room, n);
        const double scale = vec3_length(vec3_cross(u, v)), want = fabs(area) * scale;
        whole = whole && seen.all_used && seen.in_range;
        if (scale < 1e-3)
            continue;
        worst = fmax(worst, fmax(fabs(seen.sum - want), fabs(vec3_length(seen.net) - want)) / want);
        least = fmin(least, seen.least / want);
    }
    ok(whole, "every corner of a polygon is used, and no other");
    ok(worst < 1e-8,
       "triangles cover a plane polygon once, turned as it is: relative error of area %.1e", worst);
    ok(least > 1e-9, "corners on straight sides make no triangle without area: smallest share %.1e",
       least);
    polygon_room_clear(&room);
}

static void test_shapes(void)
{
    /* hollow at the last corner */
    static const double dart[4][3] = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
    static const double comb[12][3] = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0},
                                       {4, 1, 0}, {3, 1, 0}, {3, 3, 0}, {2, 3, 0},
                                       {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    static const double bow_tie[4][3] = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
    static const double saddle[4][3] = {{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}};
    static const double doubled[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    static const double line[5][3] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}};
    static const double nothing[4][3] = {
        {0, 0, 0}, {(double)NAN, 0, 0}, {1, (double)INFINITY, 0}, {0, 1, 0}};
    const struct {
        const char *name;
        const double (*corner)[3];
        size_t n;
        double area; /* negative: only that all corners are used */
    } shapes[] = {{"hollow quadrilateral", dart, 4, 1.5},
                  {"comb", comb, 12, 11},
                  {"crossed", bow_tie, 4, -1},
                  {"saddle", saddle, 4, -1},
                  {"doubled corner", doubled, 5, 1},
                  {"line", line, 5, 0},
                  {"corners that are no numbers", nothing, 4, -1}};
    struct polygon_room room = {0};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        struct error *err = polygon_room_for(&room, shapes[s].n);
        if (err)
            bail("%s", error_message(err));
        memcpy(room.corner, shapes[s].corner, shapes[s].n * sizeof *shapes[s].corner);
        polygon_split(&room, shapes[s].n);
        const struct seen seen = look(&room, shapes[s].n);
        ok(seen.all_used && seen.in_range &&
               (shapes[s].area < 0 || fabs(seen.sum - shapes[s].area) < 1e-12),
           "%s: every corner used, area %g", shapes[s].name, seen.sum);
    }
    polygon_room_clear(&room);
}

/* A star of many thousand corners, every other one hollow, is split in reasonable time, and
 * wholly. */
static void test_large(void)
{
    enum { N = 20000 };
    struct polygon_room room = {0};
    struct error *err = polygon_room_for(&room, N);
    if (err)
        bail("%s", error_message(err));
    double area = 0, sum = 0;
    for (size_t i = 0; i < N; i++) {
        const double angle = 2 * acos(-1.0) * (double)i / N, radius = i % 2 ? 1 : 2;
        vec3_store(room.corner + 3 * i, (struct vec3){radius * cos(angle), radius * sin(angle), 7});
        area += 0.5 * 2 * sin(2 * acos(-1.0) / N);
    }
    polygon_split(&room, N);
    for (size_t t = 0; t < N - 2; t++) {
        const uint32_t *i = room.triangle + 3 * t;
        sum += vec3_length(
            area_vector(room.corner + 3 * i[0], room.corner + 3 * i[1], room.corner + 3 * i[2]));
    }
    ok(fabs(sum / area - 1) < 1e-9, "a star of %d corners keeps its area: %.12g", N, sum / area);
    polygon_room_clear(&room);
}

int main(void)
{
    test_simple();
    test_shapes();
    test_large();
    return tap_done();
}
