/* SPDX-License-Identifier: Apache-2.0 */
/* Points on the surfaces that light gets to: none where there is no light, none within the radius
 * of another, all that is lit within reach of one, denser where that was asked for. */
#include "place/poisson.h"
#include "math/random.h"
#include "support/capture_bench.h"

static struct poisson_settings settings(double least, double most)
{
    return (struct poisson_settings){.least = least,
                                     .most = most,
                                     .distance = 2,
                                     .rays = 64,
                                     .particles = 4096,
                                     .bounces = 8,
                                     .misses = 64,
                                     .points_most = 100000,
                                     .seed = 3,
                                     .threads = 2};
}

static struct poisson make(const struct bench *b, const struct poisson_settings *s)
{
    struct poisson set = {0};
    must(poisson_make(&set, &b->path, s));
    return set;
}

static double distance(struct vec3 a, struct vec3 b)
{
    return vec3_length(vec3_sub(a, b));
}

/* Points that are within the radius of another that faces alike. */
static size_t too_near(const struct poisson *set)
{
    size_t count = 0;
    for (size_t i = 0; i < set->count; i++)
        for (size_t j = 0; j < set->count; j++) {
            const struct poisson_point *p = &set->point[i], *q = &set->point[j];
            count += i != j && vec3f_dot(p->normal, q->normal) > 0.5f &&
                     distance(p->position, q->position) < (double)q->radius;
        }
    return count;
}

/* The share of places on the sides of a cube about the origin, seen from within or from outside,
 * that are within twice the radius of a point there. */
static double covered(const struct poisson *set, double half, bool within)
{
    enum { PLACES = 2000 };
    struct random r = random_start(1, 2, 3);
    size_t count = 0;
    for (int i = 0; i < PLACES; i++) {
        double p[3];
        const int axis = i % 3;
        for (int k = 0; k < 3; k++)
            p[k] = half * (2 * random_double(&r) - 1);
        p[axis] = i % 2 ? half : -half;
        double n[3] = {0};
        n[axis] = (i % 2 ? 1 : -1) * (within ? -1 : 1);
        for (size_t j = 0; j < set->count; j++) {
            const struct poisson_point *q = &set->point[j];
            const struct vec3 face = {(double)q->normal.x, (double)q->normal.y,
                                      (double)q->normal.z};
            if (vec3_dot(face, vec3_load(n)) > 0.99 &&
                distance(q->position, vec3_load(p)) < 2 * (double)q->radius) {
                count++;
                break;
            }
        }
    }
    return (double)count / PLACES;
}

/* Points an area near the edges of a cube's sides, over those in their middles. */
static double edge_density(const struct poisson *set, double half)
{
    size_t edge = 0, middle = 0;
    for (size_t i = 0; i < set->count; i++) {
        double c[3];
        vec3_store(c, set->point[i].position);
        double low = INFINITY, second = 0, most = 0;
        for (int k = 0; k < 3; k++) {
            low = fmin(low, fabs(c[k]));
            most = fmax(most, fabs(c[k]));
        }
        second = fabs(c[0]) + fabs(c[1]) + fabs(c[2]) - low - most;
        if (most < 0.99 * half)
            continue;
        edge += second > half - 0.5;
        middle += second < half - 2;
    }
    const double inner = 4 * (half - 2) * (half - 2),
                 outer = 4 * half * half - 4 * (half - 0.5) * (half - 0.5);
    return (double)edge / outer / ((double)middle / inner);
}

static void room(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 4, material(0.5f, 0));
    add_cube(&b, 0.5, material(0.5f, 0)); /* closed: no light gets into it */
    add_light(&b, (struct scene_light){
                      .kind = SCENE_POINT, .position = {2.5, 2, 1.5}, .intensity = {5, 5, 5}});
    bench_finish(&b, 8);
    struct poisson_settings s = settings(0.15, 1.2);
    struct poisson set = make(&b, &s);
    size_t inside = 0;
    for (size_t i = 0; i < set.count; i++) {
        const struct vec3 p = set.point[i].position;
        inside += fmax(fmax(fabs(p.x), fabs(p.y)), fabs(p.z)) < 0.5;
    }
    ok(set.count > 300 && !inside, "%zu points, %zu where no light gets", set.count, inside);
    ok(!too_near(&set), "%zu points within the radius of another", too_near(&set));
    ok(covered(&set, 4, true) > 0.995 && covered(&set, 0.5, false) > 0.98,
       "what is lit is within twice the radius of a point: %g, %g", covered(&set, 4, true),
       covered(&set, 0.5, false));
    bool within = true;
    for (size_t i = 0; i < set.count; i++)
        within = within && set.point[i].radius >= 0.1499f && set.point[i].radius <= 1.2f;
    ok(within, "radii are between the least and the greatest");
    const double by_ao = edge_density(&set, 4);
    ok(by_ao > 2, "by occlusion there are %g times as many at a room's edges", by_ao);

    s.threads = 1;
    struct poisson one = make(&b, &s);
    bool same = one.count == set.count;
    for (size_t i = 0; i < one.count && same; i++) {
        const struct poisson_point *p = &one.point[i], *q = &set.point[i];
        same = distance(p->position, q->position) <= 0 && !(p->radius < q->radius) &&
               !(p->radius > q->radius);
    }
    ok(same, "the same points for 1 and 2 threads");
    poisson_clear(&one);
    poisson_clear(&set);

    s.least = s.most = 0.5;
    s.steer = POISSON_NONE;
    set = make(&b, &s);
    const double even = edge_density(&set, 4);
    ok(even > 0.6 && even < 1.6 && !too_near(&set), "by nothing, as many at edges: %g", even);
    poisson_clear(&set);
    s = settings(0.2, 1.2);
    for (s.steer = POISSON_GRADIENT; s.steer <= POISSON_DEPTH; s.steer++) {
        set = make(&b, &s);
        ok(edge_density(&set, 4) > 1.5 * even && !too_near(&set), "by %s, more: %g",
           s.steer == POISSON_DEPTH ? "depth" : "the change of occlusion", edge_density(&set, 4));
        poisson_clear(&set);
    }
    s.steer = POISSON_AO;
    must(poisson_make_count(&set, &b.path, &s, 400));
    ok(set.count <= 400 && set.count >= 360 && fabs(set.most / set.least - 6) < 1e-9,
       "at most 400: %zu, radii %g to %g", set.count, set.least, set.most);
    poisson_clear(&set);
    s = settings(0.05, 0.1);
    s.points_most = 500;
    set = make(&b, &s);
    ok(set.full && set.count == 500, "no more than was allowed");
    poisson_clear(&set);
    bench_clear(&b);
}

/* Points of a coarse set that stay: the rest is filled about them. */
static void kept(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 4, material(0.5f, 0));
    add_light(&b, (struct scene_light){
                      .kind = SCENE_POINT, .position = {2.5, 2, 1.5}, .intensity = {5, 5, 5}});
    bench_finish(&b, 8);
    struct poisson_settings s = settings(0.6, 1.2);
    struct poisson coarse = make(&b, &s);
    s.kept = coarse.point;
    s.kept_count = coarse.count;
    struct poisson again = make(&b, &s);
    ok(again.count <= coarse.count + coarse.count / 50 + 1,
       "a full set of %zu points stays as it is: %zu", coarse.count, again.count);
    s.kept_count = coarse.count / 4;
    s.least = 0.3;
    s.most = 0.6;
    struct poisson set = make(&b, &s);
    size_t stay = 0;
    for (size_t i = 0; i < s.kept_count; i++)
        stay += !memcmp(&set.point[i].position, &coarse.point[i].position, sizeof(struct vec3)) &&
                !(set.point[i].radius > 0.6f);
    ok(stay == s.kept_count && set.count > 2 * coarse.count && !too_near(&set),
       "%zu of %zu stay, with the new radius at the most, and %zu come", stay, s.kept_count,
       set.count - stay);
    ok(covered(&set, 4, true) > 0.99, "what they leave is filled: %g", covered(&set, 4, true));
    poisson_clear(&set);
    set = (struct poisson){0};
    must(poisson_make_count(&set, &b.path, &s, 2 * s.kept_count));
    ok(set.count <= 2 * s.kept_count && set.count > s.kept_count + s.kept_count / 2,
       "a number counts them too: %zu of %zu", set.count, 2 * s.kept_count);
    poisson_clear(&set);
    poisson_clear(&again);
    poisson_clear(&coarse);
    bench_clear(&b);
}

/* Where rays from a surface meet nothing, particles find all of it. */
static void plain(void)
{
    struct bench b;
    bench_start(&b);
    for (int c = 0; c < 3; c++)
        b.settings.sky[c] = 1;
    add_floor(&b, 4, 0, material(0.5f, 0));
    bench_finish(&b, 8);
    const struct poisson_settings s = settings(0.1, 0.8);
    struct poisson set = make(&b, &s);
    bool open = true;
    size_t above = 0;
    for (size_t i = 0; i < set.count; i++) {
        open = open && set.point[i].ao >= 1 && set.point[i].radius >= 0.7999f;
        above += set.point[i].normal.y > 0;
    }
    ok(open && !too_near(&set) && above > 55 && set.count - above > 55,
       "a plain has even points on both of its sides: %zu, %zu", above, set.count - above);
    poisson_clear(&set);
    bench_clear(&b);
}

static void dark(void)
{
    struct bench b;
    bench_start(&b);
    add_floor(&b, 4, 0, material(0.5f, 0));
    bench_finish(&b, 8);
    const struct poisson_settings s = settings(0.1, 0.8);
    struct poisson set = {0};
    struct error *err = poisson_make(&set, &b.path, &s);
    ok(err && strstr(error_message(err), "no light"), "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    poisson_clear(&set);
    bench_clear(&b);
}

int main(void)
{
    room();
    kept();
    plain();
    dark();
    return tap_done();
}
