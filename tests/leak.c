/* Placement and leaks: grids fill their box evenly and keep to their count; what is inside solids
 * is recognised and rooms are not; edges through walls are found, all of them, and the probes that
 * mend them stand off the wall on both sides. */
#include "base/error.h"
#include "leak/leak.h"
#include "math/random.h"
#include "math/vec.h"
#include "place/place.h"
#include "scene/scene.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <string.h>
#include <unistd.h>

static void test_grid(void)
{
    const double boxes[][6] = {{0, 0, 0, 10, 4, 7},
                               {-3, 5, 1, -2, 5.5, 9},
                               {0, 0, 0, 1, 0, 1},
                               {1e6, 0, 0, 1e6 + 1, 1, 1}};
    for (int i = 0; i < 4; i++) {
        const double *low = boxes[i], *high = boxes[i] + 3;
        for (double count = 1; count < 1e5; count = count * 3 + 1) {
            struct place_grid grid = {.min = {low[0], low[1], low[2]},
                                      .max = {high[0], high[1], high[2]}};
            grid.spacing[0] = grid.spacing[1] = grid.spacing[2] =
                place_grid_spacing(low, high, count);
            double nodes[3];
            place_grid_nodes(&grid, nodes);
            const double made = nodes[0] * nodes[1] * nodes[2];
            struct place place = {0};
            must(place_grid(&place, &grid, 1e6));
            bool within = true;
            struct vec3 sum = {0};
            for (size_t n = 0; n < place.count; n++) {
                const double *p = place.position + 3 * n;
                for (int k = 0; k < 3; k++)
                    within = within && p[k] >= low[k] - 1e-6 && p[k] <= high[k] + 1e-6;
                sum = vec3_add(sum, vec3_load(p));
            }
            const struct vec3 middle = vec3_scale(0.5, vec3_add(vec3_load(low), vec3_load(high)));
            const double off = vec3_length(vec3_sub(vec3_scale(1 / made, sum), middle));
            /* A finer spacing by a little makes more than was asked for: it is the finest. */
            for (int k = 0; k < 3; k++)
                grid.spacing[k] *= 1 - 1e-6;
            place_grid_nodes(&grid, nodes);
            ok((double)place.count == made && made <= count && within &&
                   off < 1e-6 * (1 + fabs(middle.x)) && nodes[0] * nodes[1] * nodes[2] > count,
               "box %d, at most %.0f probes: %.0f, centred, and not one fits more evenly", i, count,
               made);
            place_clear(&place);
        }
    }
    const struct place_grid grid = {.max = {1, 1, 1}, .spacing = {1e-4, 1e-4, 1e-4}};
    struct place place = {0};
    struct error *err = place_grid(&place, &grid, 1e6);
    ok(err && strstr(error_message(err), "1000000000000 probes") && !place.count, "refused: %s",
       err ? error_message(err) : "");
    error_destroy(err);
    place_clear(&place);
}

static void test_path(void)
{
    char name[] = "/tmp/probe-path-XXXXXX";
    const int fd = mkstemp(name);
    FILE *f = fd < 0 ? NULL : fdopen(fd, "w");
    if (!f)
        bail("no temporary file");
    fputs("# a corner\n0 0 0\n\n10 0 0\n10 3.5 0\n10 3.5 0\n", f);
    fclose(f);
    struct place place = {0};
    must(place_path(&place, name, 1, 1e6));
    double longest = 0, length = 0;
    for (size_t i = 1; i < place.count; i++) {
        const double d = vec3_length(
            vec3_sub(vec3_load(place.position + 3 * i), vec3_load(place.position + 3 * i - 3)));
        longest = fmax(longest, d);
        length += d;
    }
    ok(longest <= 1 + 1e-12 && fabs(length - 13.5) < 1e-9 && place.count == 1 + 10 + 4 + 1,
       "a path of 13.5 in steps of at most 1: %zu probes", place.count);
    place_clear(&place);
    f = fopen(name, "w");
    fputs("0 0 0\n1 2\n", f);
    fclose(f);
    struct error *err = place_points(&place, name, 1e6);
    ok(err && strstr(error_message(err), ":2: expected 3 numbers, as in the lines before, got 2"),
       "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    place_clear(&place);
    unlink(name);
}

/* A box of 12 triangles, outward or inward. */
static void add_box(struct scene *scene, const double low[3], const double high[3], bool outward,
                    int faces)
{
    double p[24];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = i >> k & 1 ? high[k] : low[k];
    const uint32_t quad[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                 {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t index[36];
    for (int i = 0; i < faces; i++) {
        const uint32_t *q = quad[i];
        const uint32_t a = outward ? 1 : 2, c = outward ? 2 : 1, d = outward ? 3 : 2,
                       e = outward ? 2 : 3;
        const uint32_t two[6] = {q[0], q[a], q[c], q[0], q[e], q[d]};
        memcpy(index + 6 * i, two, sizeof two);
    }
    const struct scene_material m = {.albedo = {0.5f, 0.5f, 0.5f},
                                     .albedo_map = {.texture = SCENE_NONE},
                                     .emission_map = {.texture = SCENE_NONE},
                                     .alpha_map = {.texture = SCENE_NONE},
                                     .opacity = 1};
    must(scene_add_mesh(scene, 8, p, (size_t)(2 * faces), index, &m));
}

/* Which of random positions in -1 .. 11 are inside, by place_inside. */
static size_t inside_count(struct scene *scene, bool (*expected)(const double *p), size_t *wrong)
{
    enum { N = 2000 };
    static double p[3 * N];
    static bool inside[N];
    struct scene_settings settings = scene_settings_default();
    struct tracer *tracer = NULL;
    struct random r = random_start(1, 0, 0);
    for (int i = 0; i < 3 * N; i++)
        p[i] = 12 * random_double(&r) - 1;
    const struct place place = {.position = p, .count = N};
    const struct place_inside_settings s = place_inside_default();
    must(scene_finish(scene, &settings, NULL));
    must(trace_create(&tracer, scene));
    must(place_inside(&place, tracer, &s, inside, NULL));
    size_t count = 0;
    *wrong = 0;
    for (int i = 0; i < N; i++) {
        count += inside[i];
        *wrong += inside[i] != expected(p + 3 * i);
    }
    trace_destroy(tracer);
    scene_destroy(scene);
    return count;
}

static bool in_box(const double *p, double low, double high)
{
    return p[0] > low && p[0] < high && p[1] > low && p[1] < high && p[2] > low && p[2] < high;
}

static bool in_cube(const double *p)
{
    return in_box(p, 2, 5);
}

static bool nowhere(const double *p)
{
    (void)p;
    return false;
}

static void test_inside(void)
{
    const double low[3] = {2, 2, 2}, high[3] = {5, 5, 5}, room_low[3] = {0, 0, 0},
                 room_high[3] = {10, 10, 10};
    struct scene *scene = NULL;
    size_t wrong;
    must(scene_create(&scene));
    add_box(scene, low, high, true, 6);
    size_t count = inside_count(scene, in_cube, &wrong);
    ok(count > 20 && wrong == 0, "a solid cube: %zu inside, %zu wrong", count, wrong);
    must(scene_create(&scene));
    add_box(scene, room_low, room_high, false, 6);
    count = inside_count(scene, nowhere, &wrong);
    ok(wrong == 0, "a room whose faces look inward holds air: %zu inside", count);
    must(scene_create(&scene));
    add_box(scene, room_low, room_high, true, 6);
    add_box(scene, low, high, true, 6);
    count = inside_count(scene, in_cube, &wrong);
    ok(count > 20 && wrong == 0,
       "a room whose faces look outward holds air, for it holds the cube: %zu inside, %zu wrong",
       count, wrong);
    must(scene_create(&scene));
    add_box(scene, room_low, room_high, true, 1); /* one wall */
    count = inside_count(scene, nowhere, &wrong);
    ok(wrong == 0, "behind a single wall is not inside: %zu", count);
}

/* Whether the segment meets the wall x = 0.5 between y, z of 0.2 and 0.8. */
static bool crosses(const double *a, const double *b)
{
    if ((a[0] < 0.5) == (b[0] < 0.5))
        return false;
    const double t = (0.5 - a[0]) / (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]),
                 z = a[2] + t * (b[2] - a[2]);
    return y > 0.2 && y < 0.8 && z > 0.2 && z < 0.8;
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
    must(leak_find(&leaks, tracer, &s, &mesh));
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
    for (size_t i = 0; i < leaks.probe_count; i++) {
        const double *q = leaks.probe + 3 * i, distance = fabs(q[0] - 0.5);
        off += fabs(distance - s.offset) > 1e-5 || q[1] < 0.2 || q[1] > 0.8 || q[2] < 0.2 ||
               q[2] > 0.8;
        left += q[0] < 0.5;
        for (size_t j = 0; j < leaks.probe_count; j++)
            pairs += fabs(leaks.probe[3 * j] + q[0] - 1) < 1e-5 &&
                     fabs(leaks.probe[3 * j + 1] - q[1]) + fabs(leaks.probe[3 * j + 2] - q[2]) <
                         0.3;
    }
    ok(leaks.probe_count > 10 && off == 0, "%zu probes stand off the wall by the offset",
       leaks.probe_count);
    ok(left > 5 && leaks.probe_count - left > 5 && pairs >= leaks.probe_count / 2,
       "on both sides: %zu left, %zu right", left, leaks.probe_count - left);
    struct leaks other;
    s.threads = 4;
    must(leak_find(&other, tracer, &s, &mesh));
    ok(other.probe_count == leaks.probe_count &&
           !memcmp(other.probe, leaks.probe, 3 * leaks.probe_count * sizeof(double)) &&
           other.leaking == leaks.leaking,
       "4 threads find the same");
    leaks_clear(&other);
    s.graze = 1;
    must(leak_find(&other, tracer, &s, &mesh));
    ok(other.crossed == leaks.crossed && other.leaking == 0 && other.probe_count == 0,
       "rays that only graze ask for nothing");
    leaks_clear(&other);
    leaks_clear(&leaks);
    trace_destroy(tracer);
    scene_destroy(scene);
}

int main(void)
{
    test_grid();
    test_path();
    test_inside();
    test_leaks();
    return tap_done();
}
