/* SPDX-License-Identifier: Apache-2.0 */
/* What points on surfaces stand for: areas against closed forms, albedos against the materials'. */
#include "place/patches.h"
#include "place/poisson.h"
#include "support/capture_bench.h"

enum { PLACES = 64 };

static struct poisson points(const struct bench *b, double least, double most)
{
    const struct poisson_settings s = {.least = least,
                                       .most = most,
                                       .distance = 2,
                                       .rays = 64,
                                       .particles = 4096,
                                       .bounces = 8,
                                       .misses = 64,
                                       .points_most = 100000,
                                       .seed = 3,
                                       .threads = 2};
    struct poisson set = {0};
    must(poisson_make(&set, &b->path, &s));
    return set;
}

static struct patch *measure(const struct bench *b, const struct poisson *set, int places,
                             int threads)
{
    const struct patches_settings s = {places, 5, threads};
    struct patch *patch = NULL;
    must(array_create(&patch, set->count, sizeof *patch));
    must(patches_measure(b->tracer, set->point, set->count, &s, patch));
    return patch;
}

static double sum_of(const struct poisson *set, const struct patch *patch)
{
    double sum = 0;
    for (size_t i = 0; i < set->count; i++)
        sum += (double)patch[i].area;
    return sum;
}

/* A box about (0, y, 0), without a floor. */
static void add_box(struct bench *b, double half, double low, double high, struct scene_material m)
{
    const double h = half;
    add_quad(b, (const double[12]){-h, high, -h, -h, high, h, h, high, h, h, high, -h}, m);
    for (int k = 0; k < 4; k++) {
        const double x[4] = {-h, -h, h, h}, z[4] = {-h, h, h, -h};
        const int j = (k + 1) % 4;
        add_quad(b,
                 (const double[12]){x[k], low, z[k], x[j], low, z[j], x[j], high, z[j], x[k], high,
                                    z[k]},
                 m);
    }
}

/* On the floor of a room there is a box, which is dark within, and reaches below the floor. */
static void room(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 2, material(0.5f, 0));
    add_box(&b, 0.5, -2.2, -1, material(0.8f, 0));
    add_light(&b, (struct scene_light){
                      .kind = SCENE_POINT, .position = {1.5, 1, 1}, .intensity = {5, 5, 5}});
    bench_finish(&b, 8);
    struct poisson set = points(&b, 0.2, 0.8);
    struct patch *patch = measure(&b, &set, PLACES, 2), *one = measure(&b, &set, PLACES, 1),
                 *fine = measure(&b, &set, 16 * PLACES, 2);
    const double sum = sum_of(&set, patch);
    ok(fabs(sum - 100) < 0.5, "a room with a box has 100 of lit surface: %g", sum);
    double side[6] = {0}, square = 0, mean = 0;
    size_t wrong = 0;
    for (size_t i = 0; i < set.count; i++) {
        const struct poisson_point *p = &set.point[i];
        const double c[3] = {p->position.x, p->position.y, p->position.z};
        const double difference = (double)patch[i].area - (double)fine[i].area;
        const bool box = fmax(fmax(fabs(c[0]), c[1] + 1.5), fabs(c[2])) < 0.51;
        for (int k = 0; k < 3; k++)
            if (fabs(c[k]) > 1.999)
                side[2 * k + (c[k] > 0)] += (double)patch[i].area;
        square += difference * difference;
        mean += (double)fine[i].area;
        wrong += fabsf(patch[i].albedo.x - (box ? 0.8f : 0.5f)) > 1e-5f ||
                 fabsf(patch[i].albedo.z - (box ? 0.2f : 0.125f)) > 1e-5f;
    }
    mean /= (double)set.count;
    bool all = true;
    for (int k = 0; k < 6; k++)
        all = all && fabs(side[k] - (k == 2 ? 15 : 16)) < 0.15;
    ok(all, "its sides have 16, its floor 15: %g %g %g %g %g %g", side[0], side[1], side[2],
       side[3], side[4], side[5]);
    ok(!wrong, "each has the albedo of its own surface");
    const double off = sqrt(square / (double)set.count) / mean;
    ok(off < 0.06, "areas from %d places a point are %g off those from more", PLACES, off);
    ok(!memcmp(one, patch, set.count * sizeof *patch), "the same for 1 and 2 threads");
    free(patch);
    free(one);
    free(fine);
    poisson_clear(&set);
    bench_clear(&b);
}

/* A ball, whose points are few: they do not see each other along the straight line. */
static void ball(int levels, double radius)
{
    struct bench b;
    bench_start(&b);
    for (int c = 0; c < 3; c++)
        b.settings.sky[c] = 1;
    struct shape shape = shape_sphere(1, levels);
    const double area = shape_area(&shape);
    add_shape(&b, &shape, material(0.5f, 0));
    shape_clear(&shape);
    bench_finish(&b, 8);
    struct poisson set = points(&b, radius, radius);
    struct patch *patch = measure(&b, &set, PLACES, 2);
    const double sum = sum_of(&set, patch);
    ok(fabs(sum / area - 1) < 0.01, "%zu points on a ball have %g of its %g", set.count, sum, area);
    free(patch);
    poisson_clear(&set);
    bench_clear(&b);
}

/* Both sides of a sheet count. Points that come without a radius get the greatest. */
static void sheet(void)
{
    struct bench b;
    bench_start(&b);
    for (int c = 0; c < 3; c++)
        b.settings.sky[c] = 1;
    add_floor(&b, 4, 0, material(0.5f, 0));
    bench_finish(&b, 8);
    struct poisson set = points(&b, 0.1, 0.8);
    for (size_t i = 0; i < set.count; i += 3)
        set.point[i].radius = NAN;
    struct patch *patch = measure(&b, &set, PLACES, 2);
    const double sum = sum_of(&set, patch);
    ok(fabs(sum - 128) < 0.5, "a sheet of 64 is lit on both sides: %g", sum);
    free(patch);
    for (size_t i = 0; i < set.count; i++)
        set.point[i].radius = NAN;
    struct patch none;
    const struct patches_settings s = {1, 1, 1};
    struct error *err = patches_measure(b.tracer, set.point, 1, &s, &none);
    ok(err && strstr(error_message(err), "radius"), "none with a radius: refused");
    error_destroy(err);
    poisson_clear(&set);
    bench_clear(&b);
}

int main(void)
{
    room();
    ball(1, 0.6);
    ball(2, 0.6);
    ball(4, 0.2);
    sheet();
    return tap_done();
}
