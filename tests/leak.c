/* SPDX-License-Identifier: Apache-2.0 */
/* Leaks: edges through walls are found, all of them, and the probes that mend them stand off the
 * wall on both sides. */
#include "base/error.h"
#include "leak/leak.h"
#include "math/random.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <string.h>

/* Whether the segment meets the wall x = 0.5 between y, z of 0.2 and 0.8. */
static bool crosses(const double *a, const double *b)
{
    if ((a[0] < 0.5) == (b[0] < 0.5))
        return false;
    const double t = (0.5 - a[0]) / (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]),
                 z = a[2] + t * (b[2] - a[2]);
    return y > 0.2 && y < 0.8 && z > 0.2 && z < 0.8;
}

static struct error *is_left(void *context, const double p[3], bool *free)
{
    (void)context;
    *free = p[0] < 0.5;
    return NULL;
}

static void test_leaks(void)
{
    /* Cells need not be Delaunay here: any four points are a cell to look along. */
    enum { N = 400, CELLS = 500 };
    static double p[3 * N];
    static int32_t v[4 * CELLS];
    struct random r = random_start(2, 0, 0);
    for (int i = 0; i < 3 * N; i++)
        p[i] = random_double(&r);
    for (int i = 0; i < CELLS; i++)
        for (int k = 0; k < 4; k++)
            v[4 * i + k] = (int32_t)((random_u32(&r) % (N / 4)) * 4) + k;
    struct scene *scene = NULL;
    struct scene_settings settings = scene_settings_default();
    struct tracer *tracer = NULL;
    must(scene_create(&scene));
    const double wall[12] = {0.5, 0.2, 0.2, 0.5, 0.8, 0.2, 0.5, 0.8, 0.8, 0.5, 0.2, 0.8};
    const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    const struct scene_material m = {.albedo = {0.5f, 0.5f, 0.5f},
                                     .albedo_map = {.texture = SCENE_NONE},
                                     .emission_map = {.texture = SCENE_NONE},
                                     .alpha_map = {.texture = SCENE_NONE},
                                     .opacity = 1};
    must(scene_add_mesh(scene, 4, wall, 2, index, &m));
    must(scene_finish(scene, &settings, NULL));
    must(trace_create(&tracer, scene));
    struct leak_settings s;
    const struct leak_mesh mesh = {
        .probe_count = N, .position = p, .corners = 4, .cell_count = CELLS, .vertex = v};
    must(leak_settings_for(&s, &mesh));
    s.separation = 0.02; /* the points are dense: probes near all walls */
    s.offset = 0.01;
    struct leaks leaks;
    struct leak_choice chosen;
    struct leak_room room = {.most = SIZE_MAX};
    must(leak_find(&leaks, tracer, &s, &mesh));
    must(leak_choose(&chosen, &leaks, tracer, &s, &mesh, &room));
    size_t wrong = 0, crossed = 0;
    for (int c = 0; c < CELLS; c++) {
        for (int e = 0; e < 6; e++) {
            const double *a = p + 3 * (size_t)v[4 * c + leak_edge[4][e][0]],
                         *b = p + 3 * (size_t)v[4 * c + leak_edge[4][e][1]];
            crossed += crosses(a, b);
            wrong += crosses(a, b) != (leaks.cell_edges[6 * c + e] > 0);
        }
    }
    ok(crossed > 100 && wrong == 0, "edges through a wall: %zu of 3000, %zu wrong", crossed, wrong);
    size_t off = 0, left = 0, pairs = 0;
    for (size_t i = 0; i < chosen.count; i++) {
        const double *q = chosen.probe + 3 * i, distance = fabs(q[0] - 0.5);
        off += fabs(distance - s.offset) > 1e-5 || q[1] < 0.2 || q[1] > 0.8 || q[2] < 0.2 ||
               q[2] > 0.8;
        left += q[0] < 0.5;
        for (size_t j = 0; j < chosen.count; j++)
            pairs += fabs(chosen.probe[3 * j] + q[0] - 1) < 1e-5 &&
                     fabs(chosen.probe[3 * j + 1] - q[1]) + fabs(chosen.probe[3 * j + 2] - q[2]) <
                         0.3;
    }
    ok(chosen.count > 10 && off == 0, "%zu probes stand off the wall by the offset", chosen.count);
    ok(left > 5 && chosen.count - left > 5 && pairs >= chosen.count / 2,
       "on both sides: %zu left, %zu right", left, chosen.count - left);
    struct leaks other;
    struct leak_choice again;
    s.threads = 4;
    must(leak_find(&other, tracer, &s, &mesh));
    must(leak_choose(&again, &other, tracer, &s, &mesh, &room));
    ok(again.count == chosen.count && again.asked == chosen.count &&
           !memcmp(again.probe, chosen.probe, 3 * chosen.count * sizeof(double)) &&
           other.leaking == leaks.leaking,
       "4 threads find the same");
    leak_choice_clear(&again);
    leaks_clear(&other);
    for (room.most = 0; room.most < 6; room.most++) {
        must(leak_choose(&again, &leaks, tracer, &s, &mesh, &room));
        ok(again.asked == chosen.count && again.count <= room.most &&
               again.count + (room.most > 1) >= room.most,
           "room for %zu of %zu: %zu are chosen", room.most, again.asked, again.count);
        leak_choice_clear(&again);
    }
    room.most = 2;
    must(leak_choose(&again, &leaks, tracer, &s, &mesh, &room));
    room.past = again.past;
    leak_choice_clear(&again);
    must(leak_choose(&again, &leaks, tracer, &s, &mesh, &room));
    ok(again.count && again.past > room.past, "then the next best have their turn");
    leak_choice_clear(&again);
    room.past = leaks.asking; /* all of them */
    must(leak_choose(&again, &leaks, tracer, &s, &mesh, &room));
    ok(again.count == 0, "until none is left");
    leak_choice_clear(&again);
    /* one side alone is free: what may not stand on the other takes no room */
    room = (struct leak_room){.most = 4, .is_free = is_left};
    must(leak_choose(&again, &leaks, tracer, &s, &mesh, &room));
    size_t behind = 0;
    for (size_t i = 0; i < again.count; i++)
        behind += again.probe[3 * i] > 0.5;
    ok(again.count >= 3 && behind == 0, "what may not stand takes no room: %zu of 4", again.count);
    leak_choice_clear(&again);
    room = (struct leak_room){.most = SIZE_MAX};
    s.graze = 1;
    must(leak_find(&other, tracer, &s, &mesh));
    must(leak_choose(&again, &other, tracer, &s, &mesh, &room));
    ok(other.crossed == leaks.crossed && other.leaking == 0 && again.count == 0,
       "rays that only graze ask for nothing");
    leak_choice_clear(&again);
    leaks_clear(&other);
    leak_choice_clear(&chosen);
    leaks_clear(&leaks);
    trace_destroy(tracer);
    scene_destroy(scene);
}

int main(void)
{
    test_leaks();
    return tap_done();
}
