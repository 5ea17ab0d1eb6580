/* SPDX-License-Identifier: Apache-2.0 */
/* Light beside far things: rays are as fine as where nothing else is (frames.h). */
#include "base/warning.h"
#include "support/capture_bench.h"
#include "trace/frames.h"

/* Where the room is: surveyors count from the equator. */
static const double survey[3] = {500000, 0, -4649776};

/* A quad, moved. */
static void add_quad_at(struct bench *b, const double at[3], const double corner[12],
                        struct scene_material m)
{
    double moved[12];
    for (int i = 0; i < 12; i++)
        moved[i] = corner[i] + at[i % 3];
    add_quad(b, moved, m);
}

/* A closed room of 4 by 4 by 4 with a lamp below its ceiling. */
static void add_room(struct bench *b, const double at[3])
{
    for (int i = 0; i < 6; i++) {
        const int k = i / 2, u = (k + 1) % 3, v = (k + 2) % 3;
        double wall[12];
        for (int c = 0; c < 4; c++) {
            wall[3 * c + k] = i % 2 ? 2 : -2;
            wall[3 * c + u] = c == 1 || c == 2 ? 2 : -2;
            wall[3 * c + v] = c >= 2 ? 2 : -2;
        }
        add_quad_at(b, at, wall, material(0.8f, 0));
    }
    add_quad_at(b, at, (const double[12]){-1, 1.9, -1, 1, 1.9, -1, 1, 1.9, 1, -1, 1.9, 1},
                material(0, 5));
}

enum far { NOTHING, ORIGIN, TRIANGLE, CITY, ROW, ISLANDS, TOWN, GROUND, DOME };
static const char *const names[] = {"nothing",
                                    "a marker at the origin",
                                    "something 1000 km away",
                                    "a city 100 km away",
                                    "houses every 200 km",
                                    "70 houses, one every 100 km",
                                    "a place of 200 times as many triangles",
                                    "a ground of 1000 km below",
                                    "a dome of 1000 km about, off its centre"};

static void add_dome(struct bench *b, const double at[3])
{
    struct shape dome = shape_sphere(1e6, 1);
    shape_move(&dome, at[0] + 3e5, at[1] - 2e5, at[2] + 1e5);
    add_shape(b, &dome, material(0, 0));
    shape_clear(&dome);
}

static void add_far(struct bench *b, enum far far, const double at[3])
{
    const double a = 5e5, big[12] = {-a, -3, -a, -a, -3, a, a, -3, a, a, -3, -a},
                 one[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    if (far == ORIGIN)
        add_quad(b, one, material(0.8f, 0));
    if (far == TRIANGLE)
        add_quad_at(b, (const double[3]){at[0] + 1e6, at[1], at[2]}, one, material(0.8f, 0));
    if (far == CITY)
        add_room(b, (const double[3]){at[0] + 1e5, at[1] + 30, at[2] - 2e4});
    for (int i = 1; i < 5 && far == ROW; i++)
        add_room(b, (const double[3]){at[0] + 2e5 * i, at[1], at[2]});
    for (int i = 1; i < 70 && far == ISLANDS; i++)
        add_room(b, (const double[3]){at[0] + 1e5 * (i % 9), at[1], at[2] + 1e5 * (i / 9)});
    for (int i = 0; i < 1400 && far == TOWN; i++)
        add_quad_at(b, (const double[3]){at[0] + 1e6 + i % 40, at[1], at[2] + i / 40.}, one,
                    material(0.8f, 0));
    if (far == GROUND)
        add_quad_at(b, at, big, material(0.8f, 0));
    if (far == DOME)
        add_dome(b, at);
}

/* Light and its error, in the middle of a room and near a corner. */
struct light {
    double sh[2], error[2];
};

/* Of the first room, or another one. */
static struct light light_beside(enum far far, const double at[3], const double room[3])
{
    struct bench b;
    bench_start(&b);
    add_room(&b, at);
    add_far(&b, far, at);
    bench_finish(&b, 16);
    struct capture_settings s = capture_settings_default();
    s.rays = 16384;
    struct light light;
    for (int k = 0; k < 2; k++) {
        const double off = k ? 1.8 : 0;
        const struct capture_probe probe =
            capture(&b, &s, room[0] - off, room[1] - off, room[2] + off);
        light.sh[k] = (double)probe.sh[0];
        light.error[k] = (double)probe.sh_error[0];
    }
    bench_clear(&b);
    return light;
}

/* The room `at` has the light that it has alone. */
static void test_beside(enum far far, const double at[3])
{
    const struct light alone = light_beside(NOTHING, at, at),
                       beside = light_beside(far, survey, at);
    for (int k = 0; k < 2; k++) {
        const double share = beside.sh[k] / alone.sh[k],
                     error = hypot(alone.error[k], beside.error[k]) / alone.sh[k];
        ok(fabs(share - 1) < 0.01 && error < 0.012, "beside %s%s: %.4f +- %.4f of the light",
           names[far], k ? ", in a corner" : "", share, error);
    }
}

/* What is far is there all the same. */
static void test_occlusion(void)
{
    const double zero[3] = {0};
    for (int k = 0; k < 2; k++) {
        struct bench b;
        bench_start(&b);
        b.settings.sky[0] = b.settings.sky[1] = b.settings.sky[2] = 1;
        add_floor(&b, 2, 0, material(0.5f, 0));
        if (k)
            add_dome(&b, zero);
        bench_finish(&b, 4);
        struct capture_settings s = capture_settings_default();
        const struct capture_probe probe = capture(&b, &s, 0, 1, 0);
        ok(k ? probe.sh[0] <= 0 && probe.sky <= 0 && fabs((double)probe.depth) > 1
             : probe.sh[0] > 1,
           "%s", k ? "a far dome keeps the sky out" : "under the sky there is light");
        const double distance = trace_distance(b.tracer, (const double[3]){0, 1e5, 0});
        ok(fabs(distance - 1e5) < 1, "the floor is %.9g away from 100 km above", distance);
        bench_clear(&b);
    }
}

/* What is no farther apart than in most scenes has one frame, of the whole box. */
static void test_ordinary(void)
{
    struct bench b;
    const double beside[3] = {60, 0, 9};
    bench_start(&b);
    add_room(&b, (const double[3]){0});
    add_room(&b, beside);
    add_floor(&b, 50, -2.5, material(0.5f, 0));
    bench_finish(&b, 1);
    struct frames frames;
    must(frames_find(&frames, b.scene));
    ok(frames.count == 1 && frames.box[0].low[0] <= -50 && frames.box[0].high[0] >= 62,
       "two houses 60 m apart share a frame");
    bench_clear(&b);
}

/* Of pieces that are too far apart and too many it is said, and of one that nobody meant; not of
 * islands, a room each. */
static void test_warnings(void)
{
    static const struct {
        int rooms, side;
        bool marker;
        size_t warnings;
    } tries[] = {{1, 1, false, 0}, {40, 7, false, 0}, {40, 7, true, 1}, {600, 25, false, 2}};
    for (size_t i = 0; i < sizeof tries / sizeof *tries; i++) {
        struct bench b;
        struct warnings warnings = {0};
        bench_start(&b);
        for (int k = 0; k < tries[i].rooms; k++)
            add_room(&b,
                     (const double[3]){1e5 * (k % tries[i].side), 0, 1e5 * (k / tries[i].side)});
        if (tries[i].marker) { /* 2 triangles beside 600 */
            add_quad(&b, (const double[12]){9e6, 0, 0, 9e6, 1, 0, 9e6, 1, 1, 9e6, 0, 1},
                     material(0.8f, 0));
            for (int k = 0; k < 300; k++)
                add_floor(&b, 2, -1 - k / 300., material(0.8f, 0));
        }
        bench_finish(&b, 1);
        must(frames_warn(b.scene, &warnings));
        ok(warnings.count == tries[i].warnings, "%d islands%s: %zu warnings", tries[i].rooms,
           tries[i].marker ? " and a marker" : "", warnings.count);
        warnings_clear(&warnings);
        bench_clear(&b);
    }
}

int main(void)
{
    for (enum far far = ORIGIN; far <= DOME; far++)
        test_beside(far, survey);
    test_beside(CITY, (const double[3]){survey[0] + 1e5, survey[1] + 30, survey[2] - 2e4});
    test_beside(ROW, (const double[3]){survey[0] + 8e5, survey[1], survey[2]});
    test_beside(ISLANDS, (const double[3]){survey[0] + 6e5, survey[1], survey[2] + 7e5});
    test_occlusion();
    test_ordinary();
    test_warnings();
    return tap_done();
}
