/* SPDX-License-Identifier: Apache-2.0 */
/* Decimated scenes: flat surfaces lose their triangles and nothing else, round ones keep their area
 * and volume, textures stay where they were, materials and lamps keep their shape, what was closed
 * stays closed, and whatever a file may hold is survived. */
#include "base/warning.h"
#include "import/import_scene.h"
#include "math/random.h"
#include "scene/scene_build.h"
#include "support/capture_bench.h"
#include "topology/decimate.h"
#include "topology/solids.h"

static double mesh_area(const struct scene *s, int32_t material)
{
    double sum = 0;
    for (size_t i = 0; i < s->instance_count; i++) {
        const struct scene_mesh *m = &s->meshes[s->instances[i].mesh];
        const struct shape shape = {m->position, m->index, m->vertex_count, m->triangle_count};
        for (size_t t = 0; t < m->triangle_count; t++)
            if (material == SCENE_NONE || m->material[t] == material)
                sum += vec3_length(shape_area_vector(&shape, t));
    }
    return sum;
}

static void decimate(struct bench *b, double share)
{
    must(scene_decimate(b->scene, share, NULL));
}

static void finish(struct bench *b)
{
    must(scene_finish(b->scene, &b->settings, NULL));
}

/* Rotates the axes: y goes to the axis `to`, and where `back` is set the face looks the other
 * way. */
static void add_wall(struct bench *b, size_t n, int to, bool back)
{
    const double rows[3][9] = {
        {0, 1, 0, 0, 0, 1, 1, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 1, 1, 0, 0, 0, 1, 0}};
    struct shape s = shape_grid(1, n);
    shape_move(&s, 0, 1, 0);
    shape_place(&s, rows[to], (struct vec3){0});
    /* through the origin; turned round, it looks outward again */
    for (size_t k = 0; back && k < 3 * s.vertex_count; k++)
        s.position[k] = -s.position[k];
    for (size_t t = 0; back && t < s.triangle_count; t++) {
        const uint32_t i = s.index[3 * t];
        s.index[3 * t] = s.index[3 * t + 1];
        s.index[3 * t + 1] = i;
    }
    add_shape(b, &s, material(0.5f, 0));
    shape_clear(&s);
}

static struct scene_solids solids_of(const struct scene *s)
{
    struct scene_solids solids;
    must(scene_solids(s, &solids, NULL));
    return solids;
}

static void test_flat(void)
{
    struct bench b;
    bench_start(&b);
    struct shape grid = shape_grid(1, 32);
    add_shape(&b, &grid, material(0.5f, 0));
    shape_clear(&grid);
    finish(&b);
    decimate(&b, 2.0 / 2048);
    ok(scene_triangle_count(b.scene) == 2 && fabs(mesh_area(b.scene, SCENE_NONE) - 4) < 1e-12,
       "a square of 2048 triangles becomes one of 2: %zu", scene_triangle_count(b.scene));
    bench_clear(&b);

    bench_start(&b);
    for (int axis = 0; axis < 3; axis++) {
        add_wall(&b, 8, axis, false);
        add_wall(&b, 8, axis, true);
    }
    finish(&b);
    struct scene_solids solids = solids_of(b.scene);
    ok(solids.closed_count == 1 && fabs(solids.volume[0] - 8) < 1e-12,
       "six walls in six meshes are a closed box");
    scene_solids_clear(&solids);
    decimate(&b, 12.0 / 768);
    solids = solids_of(b.scene);
    ok(scene_triangle_count(b.scene) == 12 && b.scene->meshes[0].vertex_count == 8,
       "768 triangles become 12, on 8 vertices");
    ok(solids.count == 1 && solids.closed_count == 1 && fabs(solids.volume[0] - 8) < 1e-12 &&
           fabs(mesh_area(b.scene, SCENE_NONE) - 24) < 1e-12,
       "which are the same box");
    scene_solids_clear(&solids);
    bench_clear(&b);
}

static void test_round(void)
{
    struct bench b;
    bench_start(&b);
    struct shape sphere = shape_sphere(1, 4), coarse = shape_sphere(1, 2);
    add_shape(&b, &sphere, material(0.5f, 0));
    add_cube(&b, 0.2, material(0.5f, 0)); /* inside, faces inward */
    const double coarse_area = shape_area(&coarse);
    double coarse_volume = 0;
    for (size_t t = 0; t < coarse.triangle_count; t++)
        coarse_volume += vec3_dot(shape_area_vector(&coarse, t), shape_corner(&coarse, t, 0)) / 3;
    shape_clear(&sphere);
    shape_clear(&coarse);
    finish(&b);
    decimate(&b, 0.1);
    struct scene_solids solids = solids_of(b.scene);
    const size_t count = scene_triangle_count(b.scene);
    ok(count <= 513 && count > 505,
       "a sphere of 5120 triangles and a box of 12 become %zu, one in ten", count);
    size_t box = 0;
    double volume = 0;
    for (size_t t = 0; t < count; t++)
        box += solids.volume[solids.piece_of[t]] < 0;
    for (size_t i = 0; i < solids.count; i++)
        volume = fmax(volume, solids.volume[i]);
    ok(solids.closed_count == 2 && box == 12, "of which the box has %zu still", box);
    const double area = mesh_area(b.scene, SCENE_NONE) - 24 * 0.04;
    ok(volume > coarse_volume && volume < 4 * PI / 3,
       "the sphere's volume, %.4f, is between an icosphere's of 320 triangles, %.4f, and the "
       "ball's",
       volume, coarse_volume);
    ok(area > coarse_area && area < 4 * PI, "and so is its area: %.4f, %.4f", area, coarse_area);
    scene_solids_clear(&solids);
    bench_clear(&b);
}

/* The texture coordinates of the chart in test_texture, which has a seam along z = 0.25, and along
 * x = 0 a fold, where u turns back. */
static void chart(double x, double z, bool beyond, double uv[2])
{
    uv[0] = 0.75 * fabs(x) + 0.125 * z + (beyond ? 3 : 0);
    uv[1] = 0.5 * z + 0.25 * (beyond ? x : -x);
}

static void test_texture(void)
{
    struct bench b;
    bench_start(&b);
    struct shape grid = shape_grid(1, 16);
    struct scene_material m = material(0.5f, 0);
    m.albedo_map = scene_map_of(add_texture(&b, 1, 1, 3, (const float[3]){1, 1, 1}));
    add_shape(&b, &grid, m);
    struct scene_mesh *mesh = &b.scene->meshes[0];
    must(array_create(&mesh->uv, 6 * mesh->triangle_count, sizeof *mesh->uv));
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double z = 0;
        for (size_t k = 0; k < 3; k++)
            z += shape_corner(&grid, t, k).z / 3;
        for (size_t k = 0; k < 3; k++) {
            const struct vec3 p = shape_corner(&grid, t, k);
            double uv[2];
            chart(p.x, p.z, z > 0.25, uv);
            mesh->uv[6 * t + 2 * k] = (float)uv[0];
            mesh->uv[6 * t + 2 * k + 1] = (float)uv[1];
        }
    }
    shape_clear(&grid);
    finish(&b);
    decimate(&b, 12.0 / 512);
    mesh = &b.scene->meshes[0];
    double off = 0, span = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p[3], middle = {0};
        for (size_t k = 0; k < 3; k++) {
            p[k] = vec3_load(mesh->position + 3 * (size_t)mesh->index[3 * t + k]);
            middle = vec3_fma(middle, 1.0 / 3, p[k]);
        }
        double uv[2], mean[2] = {0};
        for (size_t k = 0; k < 6; k++)
            mean[k % 2] += (double)mesh->uv[6 * t + k] / 3;
        /* on triangles across a seam or fold, not the mean of the corners' */
        chart(middle.x, middle.z, middle.z > 0.25, uv);
        off = fmax(off, fmax(fabs(uv[0] - mean[0]), fabs(uv[1] - mean[1])));
        span = fmax(span, fmax(fmax(p[0].z, p[1].z), p[2].z) - fmin(fmin(p[0].z, p[1].z), p[2].z));
    }
    ok(mesh->triangle_count <= 12 && span >= 0.75,
       "a chart with a seam and a fold loses its triangles: %zu of 512", mesh->triangle_count);
    ok(off < 1e-6, "and its texture stays where it was, to %.1g", off);
    ok(fabs(mesh_area(b.scene, SCENE_NONE) - 4) < 1e-12, "with its area");
    bench_clear(&b);
}

/* How many of the places along x = y = 0, as an n by n grid has them, hold three vertices. */
static size_t junction(const struct scene *s, size_t n)
{
    size_t found = 0;
    for (size_t i = 0; i <= n; i++) {
        size_t times = 0;
        for (size_t v = 0; v < s->meshes[0].vertex_count; v++) {
            const double *p = s->meshes[0].position + 3 * v;
            times += p[0] == 0 && p[1] == 0 && p[2] == 2 * (double)i / (double)n - 1;
        }
        found += times == 3;
    }
    return found;
}

static void test_borders(void)
{
    struct bench b;
    bench_start(&b);
    struct shape grid = shape_grid(1, 16);
    add_shape(&b, &grid, material(0.5f, 0));
    int32_t other = 0, lamp = 0;
    must(scene_push_material(b.scene,
                             (struct scene_material){.albedo_map = {.texture = SCENE_NONE},
                                                     .emission_map = {.texture = SCENE_NONE},
                                                     .alpha_map = {.texture = SCENE_NONE},
                                                     .opacity = 1},
                             &other));
    must(scene_push_material(b.scene,
                             (struct scene_material){.albedo_map = {.texture = SCENE_NONE},
                                                     .emission_map = {.texture = SCENE_NONE},
                                                     .alpha_map = {.texture = SCENE_NONE},
                                                     .opacity = 1,
                                                     .emission = {1, 1, 1}},
                             &lamp));
    struct scene_mesh *mesh = &b.scene->meshes[0];
    size_t lit = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const struct vec3 c = vec3_scale(
            1.0 / 3, vec3_add(shape_corner(&grid, t, 0),
                              vec3_add(shape_corner(&grid, t, 1), shape_corner(&grid, t, 2))));
        const bool lamps = fabs(c.x - 0.5) < 0.25 && fabs(c.z - 0.5) < 0.25;
        mesh->material[t] = lamps ? lamp : c.x > 0 && c.z < 0 ? other : 0;
        lit += lamps;
    }
    shape_clear(&grid);
    finish(&b);
    decimate(&b, 60.0 / 512);
    mesh = &b.scene->meshes[0];
    size_t still = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        still += mesh->material[t] == lamp;
    ok(lit == 32 && still == 32 && fabs(mesh_area(b.scene, lamp) - 0.25) < 1e-12,
       "emissive triangles stay: %zu", still);
    ok(fabs(mesh_area(b.scene, other) - 1) < 1e-12,
       "a patch of another material keeps its area: %.17g", mesh_area(b.scene, other));
    ok(fabs(mesh_area(b.scene, 0) - 2.75) < 1e-12, "and so does what is around: %.17g",
       mesh_area(b.scene, 0));
    ok(mesh->triangle_count <= 60, "of 512 triangles %zu are left", mesh->triangle_count);
    struct warnings warnings = {0};
    must(scene_decimate(b.scene, 0.1, &warnings));
    ok(mesh->triangle_count >= 32 && warnings_of_kind(&warnings, "decimated") == 1,
       "no more than what is held can be left, with a warning: %zu", mesh->triangle_count);
    warnings_clear(&warnings);
    bench_clear(&b);

    bench_start(&b); /* three sheets that meet on an edge */
    for (int i = 0; i < 3; i++) {
        const double rows[3][9] = {
            {1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0, 1, 0, 0, 0, 0, 1}};
        grid = shape_grid(1, 8);
        for (size_t v = 0; v < grid.vertex_count; v++)
            grid.position[3 * v] += 1;
        shape_place(&grid, rows[i], (struct vec3){0});
        add_shape(&b, &grid, material(0.5f, 0));
        shape_clear(&grid);
    }
    finish(&b);
    decimate(&b, 40.0 / 384);
    ok(junction(b.scene, 8) == 9,
       "sheets that meet on an edge by threes keep all its vertices: %zu", junction(b.scene, 8));
    ok(scene_triangle_count(b.scene) <= 40 && fabs(mesh_area(b.scene, SCENE_NONE) - 12) < 1e-12,
       "and lose the others: %zu triangles of 384", scene_triangle_count(b.scene));
    bench_clear(&b);
}

/* What is looked at about a vertex must not grow with the square of its faces. */
static void test_fans(void)
{
    struct bench b;
    bench_start(&b);
    struct shape disc = shape_disc(1, 200000);
    add_shape(&b, &disc, material(0.5f, 0));
    shape_clear(&disc);
    disc = shape_disc(1, 1000);
    shape_move(&disc, 5, 0, 0);
    add_shape(&b, &disc, material(0.5f, 0));
    shape_clear(&disc);
    finish(&b);
    decimate(&b, 0.1);
    const size_t left = scene_triangle_count(b.scene) - 200000;
    ok(left > 2 && left < 100,
       "a fan of 200000 triangles stays, within the time that there is; one of 1000 becomes one of "
       "%zu",
       left);
    bench_clear(&b);
}

static void test_instances(void)
{
    static const double mirrored[12] = {-1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0},
                        away[12] = {1, 0, 0, 9, 0, 2, 0, 0, 0, 0, 1, 0};
    struct bench b;
    bench_start(&b);
    struct shape sphere = shape_sphere(1, 3);
    add_shape(&b, &sphere, material(0.5f, 0));
    add_shape(&b, &sphere, material(0.5f, 0));
    shape_clear(&sphere);
    memcpy(b.scene->instances[0].transform, mirrored, sizeof mirrored);
    must(scene_push_instance(b.scene, 1, away));
    finish(&b);
    const uint64_t key = scene_key(b.scene);
    decimate(&b, 0.25);
    struct scene_solids solids = solids_of(b.scene);
    ok(b.scene->mesh_count == 2 && b.scene->instance_count == 3 &&
           b.scene->meshes[0].triangle_count == 320 && b.scene->meshes[1].triangle_count == 320,
       "what is placed once and what is placed twice: 1280 triangles become %zu and %zu",
       b.scene->meshes[0].triangle_count, b.scene->meshes[1].triangle_count);
    ok(!memcmp(b.scene->instances[0].transform, scene_identity, sizeof scene_identity) &&
           !memcmp(b.scene->instances[2].transform, away, sizeof away),
       "the one stands where it was placed, the other is placed");
    ok(solids.closed_count == 3 && solids.volume[solids.piece_of[0]] > 3.9 &&
           solids.volume[solids.piece_of[solids.offset[2]]] > 7.8,
       "a mirrored one looks outward still: volume %.3f", solids.volume[solids.piece_of[0]]);
    ok(scene_key(b.scene) == key, "the key is the whole scene's");
    ok(fabs(b.scene->box_min.x - -1) < 0.02 && fabs(b.scene->box_max.x - 10) < 0.02,
       "the box is around them");
    scene_solids_clear(&solids);
    bench_clear(&b);
}

static void test_share(void)
{
    struct bench b;
    bench_start(&b);
    struct shape sphere = shape_sphere(1, 2);
    add_shape(&b, &sphere, material(0.5f, 0));
    finish(&b);
    const double *const before = b.scene->meshes[0].position;
    decimate(&b, 1);
    ok(b.scene->meshes[0].position == before && b.scene->meshes[0].triangle_count == 320 &&
           !b.scene->keys_kept,
       "a share of 1 touches nothing");
    static const double bad[] = {0, -1, 1.5, (double)NAN};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error *err = scene_decimate(b.scene, bad[i], NULL);
        ok(err, "a share of %g is refused", bad[i]);
        error_destroy(err);
    }
    struct bench again;
    bench_start(&again);
    add_shape(&again, &sphere, material(0.5f, 0));
    finish(&again);
    decimate(&b, 0.3);
    decimate(&again, 0.3);
    const struct scene_mesh *m = &b.scene->meshes[0], *n = &again.scene->meshes[0];
    ok(m->triangle_count == n->triangle_count && m->vertex_count == n->vertex_count &&
           !memcmp(m->index, n->index, 3 * m->triangle_count * sizeof *m->index) &&
           !memcmp(m->position, n->position, 3 * m->vertex_count * sizeof *m->position),
       "equal scenes become equal ones");
    shape_clear(&sphere);
    bench_clear(&again);
    bench_clear(&b);
}

/* No index out of range, no more triangles than before, and some left. */
static bool is_legal(const struct scene *s, size_t before)
{
    bool legal = scene_triangle_count(s) > 0 && scene_triangle_count(s) <= before;
    for (size_t i = 0; i < s->mesh_count; i++)
        for (size_t k = 0; k < 3 * s->meshes[i].triangle_count; k++)
            legal = legal && s->meshes[i].index[k] < s->meshes[i].vertex_count;
    return legal;
}

/* Triangles between few places, where many vertices stand on each other: most edges have many
 * faces, some faces come twice. */
static void add_rubble(struct bench *b, struct random *random, double scale, double offset)
{
    double position[3 * 32];
    uint32_t index[3 * 128];
    const uint32_t vertices = 4 + random_u32(random) % 29, triangles = 8 + random_u32(random) % 121;
    for (size_t k = 0; k < 3 * vertices; k++)
        position[k] = floor(3 * random_double(random)) * scale + offset;
    for (size_t k = 0; k < 3 * triangles; k++)
        index[k] = random_u32(random) % vertices;
    must(scene_add_mesh(b->scene, vertices, position, triangles, index,
                        &(struct scene_material){0}));
    b->scene->materials[b->scene->material_count - 1] =
        (struct scene_material){.name = b->scene->materials[b->scene->material_count - 1].name,
                                .albedo_map = {.texture = SCENE_NONE},
                                .emission_map = {.texture = SCENE_NONE},
                                .alpha_map = {.texture = SCENE_NONE},
                                .opacity = 1,
                                .emission = {random_u32(random) % 8 == 0, 0, 0}};
}

static void test_hostile(void)
{
    enum { RUNS = 400 };
    size_t legal = 0, fewer = 0;
    for (uint32_t run = 0; run < RUNS; run++) {
        struct random random = random_start(7, 0, run);
        struct bench b;
        bench_start(&b);
        const double scale = run % 3   ? 1
                             : run % 2 ? 1e-150
                                       : 1e150,
                     offset = run % 5 ? 0 : 1e6 * scale;
        for (uint32_t mesh = 0; mesh < 1 + run % 3; mesh++)
            add_rubble(&b, &random, scale, offset);
        if (run % 4 == 0)
            must(scene_push_instance(b.scene, 0, scene_identity));
        finish(&b);
        const size_t before = scene_triangle_count(b.scene);
        decimate(&b, random_double(&random) * 0.9 + 0.01);
        legal += !before || is_legal(b.scene, before);
        fewer += scene_triangle_count(b.scene) < before;
        bench_clear(&b);
    }
    ok(legal == RUNS, "rubble of all kinds stays a scene: %zu of %d", legal, RUNS);
    ok(fewer > RUNS / 8, "and loses triangles where it can: %zu", fewer);
}

/* A scene of the project with each triangle split into 4^levels. */
static void split(struct scene *s, int levels)
{
    for (size_t i = 0; i < s->mesh_count; i++) {
        struct scene_mesh *m = &s->meshes[i];
        for (int level = 0; level < levels; level++) {
            struct scene_mesh n = {.vertex_count = 6 * m->triangle_count,
                                   .triangle_count = 4 * m->triangle_count};
            must(array_create(&n.position, 3 * n.vertex_count, sizeof *n.position));
            must(array_create(&n.index, 3 * n.triangle_count, sizeof *n.index));
            must(array_create(&n.material, n.triangle_count, sizeof *n.material));
            for (size_t t = 0; t < m->triangle_count; t++) {
                static const uint32_t corner[12] = {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5};
                for (size_t k = 0; k < 6; k++) {
                    const struct vec3 a = vec3_load(m->position +
                                                    3 * (size_t)m->index[3 * t + k % 3]),
                                      c = vec3_load(m->position +
                                                    3 * (size_t)m->index[3 * t + (k + 1) % 3]);
                    vec3_store(n.position + 3 * (6 * t + k),
                               k < 3 ? a : vec3_scale(0.5, vec3_add(a, c)));
                }
                for (size_t k = 0; k < 12; k++)
                    n.index[12 * t + k] = (uint32_t)(6 * t) + corner[k];
                for (size_t k = 0; k < 4; k++)
                    n.material[4 * t + k] = m->material[t];
            }
            scene_mesh_clear(m);
            *m = n;
        }
    }
}

static struct scene *read_scene(const char *name)
{
    char path[4096];
    const char *const source = getenv("SRC");
    struct scene *s = NULL;
    snprintf(path, sizeof path, "%s/scenes/%s", source ? source : ".", name);
    must(scene_read(&s, path, NULL, false, NULL));
    return s;
}

/* The Cornell box in many triangles, decimated to few, is lit as it was. */
static void test_light(void)
{
    struct scene *whole = read_scene("cornell-box.obj"), *fewer = read_scene("cornell-box.obj");
    const size_t triangles = scene_triangle_count(whole);
    split(fewer, 3);
    must(scene_decimate(fewer, 0.0825, NULL));
    ok(scene_triangle_count(fewer) < 2 * triangles + 128,
       "the Cornell box, of %zu triangles, split into %zu and decimated to %zu", triangles,
       64 * triangles, scene_triangle_count(fewer));
    ok(fabs(mesh_area(fewer, SCENE_NONE) / mesh_area(whole, SCENE_NONE) - 1) < 1e-12,
       "has its area");
    struct capture_settings settings = capture_settings_default();
    settings.rays = 4096;
    struct capture_probe probe[2];
    double worst = 0, sum = 0;
    static const double at[3][3] = {{278, 274, 280}, {100, 400, 200}, {400, 60, 150}};
    for (int p = 0; p < 3; p++) {
        for (int i = 0; i < 2; i++) {
            struct tracer *tracer = NULL;
            struct path_tracer path = {0};
            must(trace_create(&tracer, i ? fewer : whole));
            must(path_init(&path, tracer, settings.bounces));
            must(capture_probe(&path, &settings, at[p], NULL, &probe[i]));
            path_clear(&path);
            trace_destroy(tracer);
        }
        for (int k = 0; k < 27; k++) {
            const double off = (double)probe[0].sh[k] - (double)probe[1].sh[k];
            const double error = hypot((double)probe[0].sh_error[k], (double)probe[1].sh_error[k]);
            worst = fmax(worst, fabs(off) / error);
            sum += off * off / (error * error);
        }
    }
    ok(worst < 4 && sum / 81 < 1.6,
       "and its light: off by %.2f standard errors in the RMS of 81 coefficients, %.1f at most",
       sqrt(sum / 81), worst);
    scene_destroy(whole);
    scene_destroy(fewer);
}

/* What was closed is closed, and what was not is not. */
static void test_closed(void)
{
    static const char *const names[] = {"cornell-box.obj", "two-rooms.obj", "coloured-walls.gltf"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct scene *s = read_scene(names[i]);
        if (s->mesh_count && !s->meshes[0].uv)
            split(s, 2);
        struct scene_solids before = solids_of(s);
        const size_t triangles = scene_triangle_count(s);
        must(scene_decimate(s, 0.2, NULL));
        struct scene_solids after = solids_of(s);
        double volume[2] = {0};
        for (size_t p = 0; p < before.count; p++)
            volume[0] += before.volume[p];
        for (size_t p = 0; p < after.count; p++)
            volume[1] += after.volume[p];
        ok(before.closed_count == after.closed_count && before.count == after.count &&
               scene_triangle_count(s) < triangles,
           "%s, %zu triangles decimated to %zu: %zu of %zu pieces are closed, as before", names[i],
           triangles, scene_triangle_count(s), after.closed_count, after.count);
        ok(fabs(volume[0] - volume[1]) <= 1e-9 * fabs(volume[0]),
           "%s: they have their volume: %g, %g", names[i], volume[0], volume[1]);
        scene_solids_clear(&before);
        scene_solids_clear(&after);
        scene_destroy(s);
    }
}

int main(void)
{
    test_flat();
    test_round();
    test_texture();
    test_borders();
    test_fans();
    test_instances();
    test_share();
    test_hostile();
    test_closed();
    test_light();
    return tap_done();
}
