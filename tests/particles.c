/* SPDX-License-Identifier: Apache-2.0 */
/* The flux that particles bring to surfaces, against closed forms: of each kind of light, straight
 * and after bounces. */
#include "math/sobol.h"
#include "support/capture_bench.h"
#include "support/tap.h"
#include "trace/particles.h"

static struct particles trace(const struct bench *b, size_t count, int bounces, int threads)
{
    const struct particles_settings s = {
        .count = count, .bounces = bounces, .seed = 7, .threads = threads};
    struct particles p;
    must(particles_trace(b->tracer, &b->path.lights, &b->path.sky, &s, &p));
    return p;
}

/* The red flux of hits of a bounce, in the world's units, on sides whose normal leans to `side`
 * (0: on all). */
static double flux(const struct bench *b, const struct particles *p, uint32_t bounce,
                   struct vec3f side)
{
    const double world = 1 / (b->tracer->scale * b->tracer->scale);
    double sum = 0;
    for (size_t i = 0; i < p->count; i++)
        if (p->hit[i].bounce == bounce &&
            !(vec3f_dot(p->hit[i].normal, side) < 0.5f && vec3f_dot(side, side) > 0))
            sum += (double)p->hit[i].flux.x;
    return sum * world;
}

static void is_flux(double got, double truth, double share, const char *what)
{
    ok(fabs(got - truth) <= share * fabs(truth), "%s: %.5g, by the formula %.5g", what, got, truth);
}

static const struct vec3f all = {0}, up = {0, 1, 0}, down = {0, -1, 0};

/* In a closed cube all that a light sends arrives, and albedo goes on; through each face a sixth
 * where the light is in the middle. */
static void cube_of_point_light(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 3, material(0.5f, 0));
    add_light(&b, (struct scene_light){.kind = SCENE_POINT, .intensity = {5, 1, 1}});
    bench_finish(&b, 8);
    struct particles p = trace(&b, 20000, 3, 2), again = trace(&b, 20000, 3, 1);
    is_flux(flux(&b, &p, 1, all), 4 * PI * 5, 1e-5, "a point light's flux arrives");
    is_flux(flux(&b, &p, 1, up), 4 * PI * 5 / 6, 0.01, "a sixth of it on each face");
    is_flux(flux(&b, &p, 2, all), 4 * PI * 5 * 0.5, 0.03, "albedo goes on");
    is_flux(flux(&b, &p, 3, all), 4 * PI * 5 * 0.25, 0.06, "and once more");
    ok(p.count == again.count && !memcmp(p.hit, again.hit, p.count * sizeof *p.hit),
       "the same hits for 1 and 2 threads");
    particles_clear(&p);
    particles_clear(&again);
    bench_clear(&b);
}

/* A spot's flux: inside its inner cone all of the intensity, falling to the outer as
 * clamp((cos - outer) / (inner - outer))^2, whose integral is (inner - outer) / 3. */
static void cube_of_spot(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 3, material(0, 0));
    add_light(&b, (struct scene_light){.kind = SCENE_SPOT,
                                       .direction = {0, -1, 0},
                                       .intensity = {2, 2, 2},
                                       .cos_inner = 0.95,
                                       .cos_outer = 0.8});
    bench_finish(&b, 1);
    struct particles p = trace(&b, 8192, 2, 1);
    is_flux(flux(&b, &p, 1, up), 2 * PI * 2 * (0.05 + 0.15 / 3), 0.01, "a spot's flux");
    is_flux(flux(&b, &p, 1, up), flux(&b, &p, 1, all), 1e-12, "goes down alone");
    particles_clear(&p);
    bench_clear(&b);
}

/* A square lamp that shines both ways, or with its front alone. */
static void cube_of_lamp(bool front)
{
    struct bench b;
    bench_start(&b);
    b.settings.emit_front_only = front;
    add_cube(&b, 2, material(0, 0));
    add_floor(&b, 0.5, 1, material(0, 3));
    bench_finish(&b, 1);
    struct particles p = trace(&b, 8192, 1, 1);
    is_flux(flux(&b, &p, 1, all), (front ? 1 : 2) * PI * 3, 1e-5, "a lamp's flux");
    ok(front == !(flux(&b, &p, 1, up) > 0), "the floor below gets light from its back, if any");
    particles_clear(&p);
    bench_clear(&b);
}

/* A convex body in a sky and a sun: a face gets pi times radiance, and irradiance times cosine. */
static void plate_outdoors(void)
{
    struct bench b;
    bench_start(&b);
    for (int k = 0; k < 3; k++)
        b.settings.sky[k] = 0.7;
    add_floor(&b, 2, 1, material(0.5f, 0));
    bench_finish(&b, 1);
    struct particles p = trace(&b, 30000, 1, 1);
    is_flux(flux(&b, &p, 1, up), 16 * PI * 0.7, 0.02, "a sky's flux from above");
    is_flux(flux(&b, &p, 1, down), 16 * PI * 0.7, 0.02, "and from below");
    particles_clear(&p);
    bench_clear(&b);

    bench_start(&b);
    add_light(&b, (struct scene_light){
                      .kind = SCENE_SUN, .direction = {0.6, -0.8, 0}, .intensity = {3, 1, 1}});
    add_floor(&b, 2, 1, material(0.5f, 0));
    add_floor(&b, 2, -5, material(0.5f, 0));
    bench_finish(&b, 1);
    p = trace(&b, 30000, 1, 1);
    is_flux(flux(&b, &p, 1, all), 2 * 16 * 0.8 * 3, 0.02, "a sun's flux on two plates");
    particles_clear(&p);
    bench_clear(&b);
}

static void dark(void)
{
    struct bench b;
    bench_start(&b);
    add_cube(&b, 1, material(0.5f, 0));
    bench_finish(&b, 1);
    struct particles p = trace(&b, 1000, 2, 2);
    ok(!p.count, "nothing shines: no hits");
    particles_clear(&p);
    bench_clear(&b);
}

/* Each of 2^k boxes of volume 2^-k holds one of 2^k points in a row. */
static void even_points(void)
{
    enum { BITS = 6, COUNT = 1 << BITS };
    int doubles = 0;
    for (uint32_t seed = 0; seed < 8; seed++) {
        for (int cut = 0; cut <= BITS; cut++) {
            bool seen[COUNT] = {0};
            for (uint32_t i = 0; i < COUNT; i++) {
                uint32_t x, y;
                sobol_pair(3 * COUNT + i, seed, &x, &y);
                const uint32_t box = (uint32_t)((uint64_t)x >> (32 - cut) << (BITS - cut)) |
                                     (uint32_t)((uint64_t)y >> (32 - BITS + cut));
                doubles += seen[box];
                seen[box] = true;
            }
        }
    }
    ok(!doubles, "points of a pair are even in all cuts");
}

int main(void)
{
    even_points();
    cube_of_point_light();
    cube_of_spot();
    cube_of_lamp(false);
    cube_of_lamp(true);
    plate_outdoors();
    dark();
    return tap_done();
}
