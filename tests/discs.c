/* SPDX-License-Identifier: Apache-2.0 */
/* Oriented discs: a place is answered by the discs that cover its side of the surface, as a look at
 * all of them says; what none covers by the one that is nearest for its size; and nothing jumps. */
#include "interpolate/discs.h"
#include "base/array.h"
#include "math/random.h"
#include "math/vec.h"
#include "support/tap.h"

enum { POINTS = 400, PLACES = 3000 };

struct set {
    double position[3 * POINTS];
    float normal[3 * POINTS], radius[POINTS], value[POINTS];
};

static double dot(const double a[3], const float b[3])
{
    return a[0] * (double)b[0] + a[1] * (double)b[1] + a[2] * (double)b[2];
}

static struct vec3 any_normal(struct random *r)
{
    struct vec3 n;
    do {
        n = (struct vec3){random_double(r) - 0.5, random_double(r) - 0.5, random_double(r) - 0.5};
    } while (vec3_dot(n, n) > 0.25 || vec3_dot(n, n) < 0.01);
    return vec3_normalize(n);
}

/* Discs of very different sizes all over a box that is far from the origin. */
static void any_set(struct set *s)
{
    struct random r = random_start(5, 6, 7);
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 3; k++)
            s->position[3 * i + k] = 1000 + 4 * (k + 1) * random_double(&r);
        const struct vec3 n = any_normal(&r);
        s->normal[3 * i] = (float)n.x;
        s->normal[3 * i + 1] = (float)n.y;
        s->normal[3 * i + 2] = (float)n.z;
        s->radius[i] = i % 50 == 7 ? NAN : 0.2f + 3 * random_float(&r) * random_float(&r);
        s->value[i] = random_float(&r);
    }
}

/* The answer by the formulas alone. *weight: their sum; *margin: how far the best of those that do
 * not cover is before the next, in sizes. */
static double by_formula(const struct set *s, const double p[3], const double n[3], int falloff,
                         double *weight, double *margin)
{
    double sum = 0, best = INFINITY, next = INFINITY, value = NAN;
    *weight = 0;
    for (int i = 0; i < POINTS; i++) {
        const double way[3] = {p[0] - s->position[3 * i], p[1] - s->position[3 * i + 1],
                               p[2] - s->position[3 * i + 2]},
                     radius = (double)s->radius[i], facing = dot(n, s->normal + 3 * i),
                     d = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]) / radius,
                     h = 4 * fabs(dot(way, s->normal + 3 * i)) / radius;
        if (!(facing > 0.5) || isnan(radius))
            continue;
        const double w = d < 1 && h < 1 ? pow(1 - d, falloff) * (1 - h) * (2 * facing - 1) : 0,
                     rim = fmax(d, h);
        *weight += w;
        sum += w * (double)s->value[i];
        if (rim < best) {
            next = best;
            best = rim;
            value = (double)s->value[i];
        } else {
            next = fmin(next, rim);
        }
    }
    *margin = next - best;
    return *weight > 0 ? sum / *weight : value;
}

static struct discs *make(const struct set *s, size_t count)
{
    struct discs *discs;
    const struct disc_points points = {count, s->position, s->normal, s->radius};
    must(discs_create(&discs, &points));
    return discs;
}

static void any_place(void)
{
    struct set s;
    any_set(&s);
    struct discs *discs = make(&s, POINTS);
    struct random r = random_start(8, 9, 10);
    int covered = 0, wrong = 0, nearest = 0;
    double ahead[2][6] = {{1001, 1003, 1005, 0, 0, 1}, {990, 1003, 1005, 0, 1, 0}};
    discs_fetch(discs, 2, ahead[0], ahead[0] + 3, 6); /* changes nothing */
    for (int i = 0; i < PLACES; i++) {
        double p[3], n[3], weight, margin;
        float out;
        for (int k = 0; k < 3; k++)
            p[k] = 999 + (4 * (k + 1) + 2) * random_double(&r);
        if (i % 30 == 0)
            p[0] += 100; /* outside of the grid */
        vec3_store(n, any_normal(&r));
        const double truth = by_formula(&s, p, n, 1 + i % 3, &weight, &margin);
        const enum discs_answer answer = discs_blend(discs, p, n, 1 + i % 3, s.value, 1, &out);
        covered += answer == DISCS_COVERED;
        nearest += answer == DISCS_NEAREST;
        /* what rounding may decide is left out */
        if ((weight > 1e-3 || !(weight > 0)) && margin > 1e-3)
            wrong += !(fabs((double)out - truth) < 1e-3) ||
                     (answer == DISCS_COVERED) != (weight > 0);
    }
    ok(!wrong && covered > 300 && nearest > 300,
       "as all discs say: %d places covered, %d not, %d wrong", covered, nearest, wrong);
    discs_destroy(discs);
}

/* Points on both sides of a sheet, as 1 and 0, and on a table a little above it. */
static void sheet(void)
{
    struct set s;
    size_t count = 0;
    for (int side = 0; side < 2; side++)
        for (int x = 0; x < 10; x++)
            for (int y = 0; y < 10; y++, count++) {
                const double p[3] = {x, side ? 1e-6 : -1e-6, y};
                for (int k = 0; k < 3; k++) {
                    s.position[3 * count + (size_t)k] = p[k];
                    s.normal[3 * count + (size_t)k] = k == 1 ? (side ? 1.0f : -1.0f) : 0.0f;
                }
                s.radius[count] = 2;
                s.value[count] = (float)side;
            }
    for (int x = 0; x < 5; x++, count++) {
        const double p[3] = {x, 0.6, 5};
        for (int k = 0; k < 3; k++) {
            s.position[3 * count + (size_t)k] = p[k];
            s.normal[3 * count + (size_t)k] = k == 1 ? 1.0f : 0.0f;
        }
        s.radius[count] = 2;
        s.value[count] = 7;
    }
    struct discs *discs = make(&s, count);
    const double up[3] = {0, 1, 0}, down[3] = {0, -1, 0}, north[3] = {0, 0, 1};
    bool apart = true;
    double jump = 0, before = 0;
    for (int i = 0; i < 2000; i++) {
        const double p[3] = {1 + i * 0.004, 0, 5.3};
        float above, below;
        apart = apart && discs_blend(discs, p, up, 1, s.value, 1, &above) == DISCS_COVERED &&
                discs_blend(discs, p, down, 1, s.value, 1, &below) == DISCS_COVERED && above >= 1 &&
                above <= 1 && below >= 0 && below <= 0;
    }
    ok(apart, "the sides of a sheet are 1 and 0, and a table's top does not count below it");
    for (int i = 0; i <= 40000; i++) { /* through the table's discs and out of all */
        const double p[3] = {-4 + i * 2e-4, 0.01 + i * 2e-5, 5.3};
        float out;
        discs_blend(discs, p, up, 1, s.value, 1, &out);
        if (i)
            jump = fmax(jump, fabs((double)out - before));
        before = (double)out;
    }
    ok(jump < 0.03, "nothing jumps on the way into the discs: %g", jump);
    float out;
    ok(discs_blend(discs, (const double[3]){5, 0, 5}, north, 1, s.value, 1, &out) == DISCS_NONE,
       "what faces elsewhere than all has no answer");
    discs_destroy(discs);
}

/* Places that no float holds, and normals of no length. */
static void far_out(void)
{
    struct set s;
    any_set(&s);
    struct discs *discs = make(&s, POINTS);
    const double way[4] = {1e300, -1e300, 1e40, -1e40}, p[3] = {1e300, 2, -1e300};
    int answered = 0;
    for (int i = 0; i < 12; i++) {
        double from[3] = {1002, 1004, 1006}, n[3] = {0, 0, 0};
        float out = NAN;
        from[i % 3] = way[i / 3];
        n[i % 3] = way[i / 3] > 0 ? 1 : -1;
        discs_fetch(discs, 1, from, n, 3);
        answered += discs_blend(discs, from, n, 1, s.value, 1, &out) == DISCS_NEAREST && out >= 0;
    }
    ok(answered == 12, "%d of 12 places far out are answered", answered);
    float out;
    discs_fetch(discs, 1, p, (const double[3]){0, 0, 0}, 3);
    ok(discs_blend(discs, p, (const double[3]){0, 0, 0}, 1, s.value, 1, &out) == DISCS_NONE,
       "without a normal nothing faces alike");
    discs_destroy(discs);
}

static void none(void)
{
    struct set s = {.radius = {NAN}};
    struct discs *discs;
    const struct disc_points points = {1, s.position, s.normal, s.radius};
    struct error *err = discs_create(&discs, &points);
    ok(err && !discs, "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
}

int main(void)
{
    any_place();
    sheet();
    far_out();
    none();
    return tap_done();
}
