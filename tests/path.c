/* SPDX-License-Identifier: Apache-2.0 */
/* The light that comes along rays, and what lights and the sky are asked for, against closed forms.
 * Means are held against them within 4.5 standard errors, which chance exceeds once in 150,000; and
 * the errors are small. */
#include "math/random.h"
#include "scene/scene_shade.h"
#include "support/capture_bench.h"
#include "support/tap.h"
#include "trace/path.h"

enum { WAVES = 2000 };

/* -- means ------------------------------------------------------------------------------------ */

struct mean {
    double count, sum, square;
};

static void mean_add(struct mean *m, double x)
{
    m->count++;
    m->sum += x;
    m->square += x * x;
}

static double mean_value(const struct mean *m)
{
    return m->sum / m->count;
}

static double mean_error(const struct mean *m)
{
    const double mean = mean_value(m);
    return sqrt(fmax(m->square / m->count - mean * mean, 0) / (m->count - 1));
}

/* floats: what rounding alone may do */
static void is_mean(const struct mean *m, double truth, const char *what)
{
    const double off = mean_value(m) - truth, error = mean_error(m);
    ok(fabs(off) < 4.5 * error + 2e-6 * truth && error < 0.02 * truth,
       "%s: %.6g instead of %.6g, standard error %.2g", what, mean_value(m), truth, error);
}

static bool is_near(double a, double b, double share)
{
    return fabs(a - b) <= share * fabs(b);
}

/* -- receivers -------------------------------------------------------------------------------- */

/* A receiver at a place of the world; normal zero: the whole sphere. */
static struct path_receiver receiver_at(const struct bench *b, double x, double y, double z,
                                        struct vec3f normal, float share)
{
    return (struct path_receiver){
        .at = {.position = trace_to_local(b->tracer, (const double[3]){x, y, z}), .normal = normal},
        .lights_share = share,
        .sky_share = share};
}

static bool is_surface(const struct path_receiver *r)
{
    return r->at.normal.x != 0 || r->at.normal.y != 0 || r->at.normal.z != 0;
}

static struct vec3f draw_direction(const struct path_receiver *r, struct random *random)
{
    const float u = random_float(random), turn = random_float(random);
    if (is_surface(r))
        return direction_by_cosine(r->at.normal, u, turn);
    const float z = 1 - 2 * u, across = sqrtf(float_most(1 - z * z, 0));
    float x, y;
    angle_turn(turn, &x, &y);
    return (struct vec3f){across * x, across * y, z};
}

/* 1 / density of the receiver's own directions, times the cosine. */
static double own_share(const struct path_receiver *r)
{
    return is_surface(r) ? ANGLE_PI : 4 * ANGLE_PI;
}

enum counted { STRAIGHT = 1, SCATTERED = 2, ALL = STRAIGHT | SCATTERED };

/* What a wave of the receiver's own rays and its questions give of irradiance, or of radiance over
 * the sphere: as its users sum them up. */
static double wave_light(const struct path_tracer *path, const struct path_receiver *r,
                         enum counted parts, uint32_t wave)
{
    const int questions = (int)(r->lights_share * PATH_WAVE);
    struct random random[PATH_WAVE];
    struct vec3f direction[PATH_WAVE];
    struct path_sample met[PATH_WAVE];
    struct path_found found[PATH_WAVE];
    float x[PATH_WAVE];
    double y[PATH_WAVE], sum = 0;
    for (uint32_t i = 0; i < PATH_WAVE; i++) {
        random[i] = random_start(1, 0, wave * PATH_WAVE + i);
        direction[i] = draw_direction(r, &random[i]);
    }
    path_samples(path, r,
                 &(struct path_rays){.count = PATH_WAVE, .direction = direction, .random = random},
                 met);
    for (int i = 0; i < PATH_WAVE; i++)
        sum += own_share(r) *
               ((parts & SCATTERED ? (double)met[i].scattered.x : 0) +
                (parts & STRAIGHT ? (double)(met[i].weight * met[i].straight.x) : 0));
    for (int i = 0; i < questions && parts & STRAIGHT; i++) {
        random[i] = random_start(2, 0, wave * PATH_WAVE + (uint32_t)i);
        x[i] = random_float(&random[i]);
        y[i] = random_double(&random[i]);
    }
    const struct path_draws draws = {.count = (size_t)questions, .x = x, .y = y, .random = random};
    if (questions && parts & STRAIGHT)
        (path->emissive ? path_lights : path_skies)(path, r, &draws, found);
    for (int i = 0; i < questions && parts & STRAIGHT; i++)
        sum += (double)found[i].light.x *
               (is_surface(r) ? (double)vec3f_dot(found[i].direction, r->at.normal) : 1);
    return sum / PATH_WAVE;
}

static struct mean light_of(const struct path_tracer *path, const struct path_receiver *r,
                            enum counted parts)
{
    struct mean m = {0};
    for (uint32_t wave = 0; wave < WAVES; wave++)
        mean_add(&m, wave_light(path, r, parts, wave));
    return m;
}

/* -- what rays meet --------------------------------------------------------------------------- */

static void test_what_rays_meet(void)
{
    struct bench b;
    bench_start(&b);
    add_floor(&b, 3, 0, material(0.5f, 4));
    bench_finish(&b, 1);
    const struct path_receiver above = receiver_at(&b, 0.1, 2, 0.2, (struct vec3f){0}, 0),
                               below = receiver_at(&b, 0.1, -2, 0.2, (struct vec3f){0}, 0);
    const struct vec3f slant = {0.6f, -0.8f, 0}, up = {0, 1, 0}, direction[3] = {slant, up, up};
    const struct random random[3] = {{{1, 2, 3, 4}}, {{2, 3, 4, 5}}, {{3, 4, 5, 6}}};
    const struct path_rays rays = {.count = 2, .direction = direction, .random = random},
                           from_below = {.count = 1, .direction = direction + 1, .random = random};
    struct path_sample met[2], back;
    path_samples(&b.path, &above, &rays, met);
    path_samples(&b.path, &below, &from_below, &back);
    ok(met[0].hit && met[0].front && is_near((double)met[0].distance, 2.5 * b.tracer->scale, 1e-6),
       "a ray meets the front of a floor, where it is");
    ok(back.hit && !back.front && is_near((double)back.distance, 2 * b.tracer->scale, 1e-6),
       "and its back from below");
    ok(fabsf(met[0].normal.x) < 1e-6f && fabsf(met[0].normal.z) < 1e-6f &&
           fabsf(fabsf(met[0].normal.y) - 1) < 1e-6f,
       "the normal is the floor's");
    ok(!met[1].hit && isinf(met[1].distance) && met[1].normal.y == 0,
       "a ray into the open meets nothing");
    ok(met[0].straight.x == 4 && met[0].straight.y == 8 && met[0].straight.z == 2 &&
           met[1].straight.x == 0,
       "what shines is seen as bright as it is, channel by channel");
    ok(met[0].weight == 1, "and counts fully where lights are not asked");
    bench_clear(&b);
}

/* -- a square that shines --------------------------------------------------------------------- */

/* Centre above the receiver, a little aside; faces down. */
static const double lamp[12] = {-1, 2, -1, 2, 2, -1, 2, 2, 1, -1, 2, 1};
static const double lamp_radiance = 4;

/* Irradiance of an upright surface at the origin (Lambert 1760). */
static double lamp_irradiance(void)
{
    double sum = 0;
    for (size_t i = 0; i < 4; i++) {
        const struct vec3 a = vec3_normalize(vec3_load(lamp + 3 * i)),
                          b = vec3_normalize(vec3_load(lamp + 3 * ((i + 1) % 4)));
        const struct vec3 edge = vec3_normalize(vec3_cross(a, b));
        sum += acos(vec3_dot(a, b)) * edge.y;
    }
    return lamp_radiance * fabs(sum) / 2;
}

/* Solid angle of a triangle at the origin (Van Oosterom and Strackee 1983). */
static double solid_angle(struct vec3 a, struct vec3 b, struct vec3 c)
{
    const double la = vec3_length(a), lb = vec3_length(b), lc = vec3_length(c);
    return 2 *
           atan2(fabs(vec3_dot(a, vec3_cross(b, c))),
                 la * lb * lc + vec3_dot(a, b) * lc + vec3_dot(b, c) * la + vec3_dot(c, a) * lb);
}

static double lamp_sphere(void)
{
    const struct vec3 p[4] = {vec3_load(lamp), vec3_load(lamp + 3), vec3_load(lamp + 6),
                              vec3_load(lamp + 9)};
    return lamp_radiance * (solid_angle(p[0], p[1], p[2]) + solid_angle(p[0], p[2], p[3]));
}

static void add_lamp(struct bench *b)
{
    add_quad(b, lamp, material(0, (float)lamp_radiance));
}

static void test_lamp(void)
{
    static const struct vec3f up = {0, 1, 0}, nowhere = {0};
    static const float shares[] = {0, 0.25f, 1};
    struct bench b;
    bench_start(&b);
    add_lamp(&b);
    bench_finish(&b, 0);
    ok(b.path.emissive, "a square that shines is a light to be asked");
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        const struct path_receiver surface = receiver_at(&b, 0, 0, 0, up, shares[i]),
                                   point = receiver_at(&b, 0, 0, 0, nowhere, shares[i]);
        char what[80];
        snprintf(what, sizeof what, "irradiance of a lamp, asked %g times a ray",
                 (double)shares[i]);
        const struct mean irradiance = light_of(&b.path, &surface, STRAIGHT),
                          sphere = light_of(&b.path, &point, STRAIGHT);
        is_mean(&irradiance, lamp_irradiance(), what);
        snprintf(what, sizeof what, "its radiance over the sphere, asked %g times a ray",
                 (double)shares[i]);
        is_mean(&sphere, lamp_sphere(), what);
    }
    bench_clear(&b);
}

/* Means of what asking finds, and of what it would find if nothing stood between. */
static void ask_lamp(const struct bench *b, const struct path_receiver *r, struct mean *found,
                     struct mean *unshadowed)
{
    struct random random[PATH_WAVE];
    struct path_found one[PATH_WAVE];
    float x[PATH_WAVE];
    double y[PATH_WAVE];
    const struct path_draws draws = {.count = PATH_WAVE, .x = x, .y = y, .random = random};
    for (uint32_t wave = 0; wave < WAVES / 8; wave++) {
        for (uint32_t i = 0; i < PATH_WAVE; i++) {
            random[i] = random_start(3, 0, wave * PATH_WAVE + i);
            x[i] = random_float(&random[i]);
            y[i] = random_double(&random[i]);
        }
        path_lights(&b->path, r, &draws, one);
        for (int i = 0; i < PATH_WAVE; i++)
            mean_add(found, (double)one[i].light.x);
        bool sparse;
        mean_add(unshadowed, (double)path_lights_unshadowed(&b->path, r, &draws, &sparse).x);
    }
}

static void test_shadow(void)
{
    struct bench b;
    struct mean found = {0}, unshadowed = {0};
    bench_start(&b);
    add_lamp(&b);
    add_floor(&b, 9, 1, material(0, 0));
    bench_finish(&b, 0);
    /* asked so often that its own rays count for nothing beside */
    const struct path_receiver r = receiver_at(&b, 0, 0, 0, (struct vec3f){0}, 1e6f);
    ask_lamp(&b, &r, &found, &unshadowed);
    ok(found.square == 0, "behind a board nothing is found of the lamp");
    is_mean(&unshadowed, lamp_sphere() / 1e6, "which would give, without the board");
    bench_clear(&b);
}

/* -- light that scatters ---------------------------------------------------------------------- */

/* A floor in the light of a sun and of a point: each is asked once at the one scattering, so that a
 * single ray has the whole of it. */
static void test_scattered_once(void)
{
    static const struct scene_light sun = {.kind = SCENE_SUN,
                                           .direction = {0.6, -0.8, 0},
                                           .intensity = {10, 20, 5}},
                                    point = {.kind = SCENE_POINT,
                                             .position = {0.75, 1, 0},
                                             .intensity = {7, 7, 7}};
    /* irradiance on the floor at the origin, from both */
    const double sun_there = 10 * 0.8, d2 = 0.75 * 0.75 + 1, point_there = 7 / d2 * (1 / sqrt(d2));
    for (int bounces = 0; bounces < 2; bounces++)
        for (int k = 0; k < 3; k++) {
            struct bench b;
            struct path_sample met;
            bench_start(&b);
            add_floor(&b, 50, 0, material(0.6f, 0));
            if (k != 1)
                add_light(&b, sun);
            if (k != 0)
                add_light(&b, point);
            bench_finish(&b, bounces);
            const struct path_receiver r = receiver_at(&b, 0, 3, 0, (struct vec3f){0}, 0);
            const struct vec3f down = {0, -1, 0};
            const struct random random = {{1, 2, 3, 4}};
            path_samples(&b.path, &r,
                         &(struct path_rays){.count = 1, .direction = &down, .random = &random},
                         &met);
            const double truth = bounces * 0.6 / ANGLE_PI *
                                 ((k != 1 ? sun_there : 0) + (k != 0 ? point_there : 0));
            ok(is_near((double)met.scattered.x, truth, 1e-5) && met.straight.x == 0,
               "%s, %d bounces: a floor scatters %.6g, %.6g is right",
               k == 0   ? "a sun"
               : k == 1 ? "a point light"
                        : "both",
               bounces, (double)met.scattered.x, truth);
            bench_clear(&b);
        }
}

/* In a closed room whose walls all shine with L and reflect a, radiance is the same from
 * everywhere: L (1 + a + ... a^bounces). */
static void test_furnace(void)
{
    static const int bounces[] = {0, 1, 3, 64};
    for (size_t i = 0; i < sizeof bounces / sizeof *bounces; i++) {
        const double a = 0.7, truth = 3 * (1 - pow(a, bounces[i] + 1)) / (1 - a);
        struct bench b;
        char what[60];
        bench_start(&b);
        add_cube(&b, 2, material((float)a, 3));
        bench_finish(&b, bounces[i]);
        const struct path_receiver r = receiver_at(&b, 0.3, -0.4, 0.5, (struct vec3f){0}, 0.5f);
        struct mean m = light_of(&b.path, &r, ALL);
        snprintf(what, sizeof what, "a room that shines, %d bounces", bounces[i]);
        is_mean(&m, 4 * ANGLE_PI * truth, what);
        bench_clear(&b);
    }
}

static void test_straight_alone(void)
{
    struct bench b;
    struct vec3f direction[PATH_WAVE];
    struct random random[PATH_WAVE];
    struct path_sample met[PATH_WAVE], alone[PATH_WAVE], single;
    int unlike = 0, scattered = 0, depends = 0;
    bench_start(&b);
    add_cube(&b, 2, material(0.7f, 3));
    bench_finish(&b, 8);
    const struct path_receiver r = receiver_at(&b, 0.3, -0.4, 0.5, (struct vec3f){0}, 0.5f);
    for (uint32_t i = 0; i < PATH_WAVE; i++) {
        random[i] = random_start(5, 0, i);
        direction[i] = draw_direction(&r, &random[i]);
    }
    struct path_rays rays = {.count = PATH_WAVE, .direction = direction, .random = random};
    path_samples(&b.path, &r, &rays, met);
    rays.straight_alone = true;
    path_samples(&b.path, &r, &rays, alone);
    for (size_t i = 0; i < PATH_WAVE; i++) {
        unlike += met[i].straight.x != alone[i].straight.x || met[i].weight != alone[i].weight;
        scattered += alone[i].scattered.x != 0 || met[i].scattered.x <= 0;
        const struct path_rays one = {.count = 1, .direction = direction + i, .random = random + i};
        path_samples(&b.path, &r, &one, &single);
        depends += single.scattered.x != met[i].scattered.x ||
                   single.scattered.z != met[i].scattered.z || single.weight != met[i].weight ||
                   single.distance != met[i].distance;
    }
    ok(!unlike && !scattered, "straight light alone is the same, and nothing scatters");
    ok(!depends, "a path has the same light to the bit whatever others go with it");
    bench_clear(&b);
}

/* -- the sky ---------------------------------------------------------------------------------- */

enum { COLUMNS = 24, ROWS = 12 };

/* A sky with one bright place high up, over nothing. */
static void add_sky(struct bench *b)
{
    float *texels = NULL;
    must(array_create(&texels, 3 * COLUMNS * ROWS, sizeof *texels));
    must(array_create(&b->scene->sky.picture, 1, sizeof *b->scene->sky.picture));
    for (size_t i = 0; i < (size_t)3 * COLUMNS * ROWS; i++)
        texels[i] = 1;
    texels[3 * (3 * COLUMNS + 7)] = 150;
    *b->scene->sky.picture = (struct scene_texture){
        .width = COLUMNS, .height = ROWS, .channels = 3, .texels = texels, .wrap_v = SCENE_CLAMP};
}

/* Irradiance of an upright surface, or radiance over the sphere: by the midpoint rule. */
static double sky_light(const struct scene *scene, bool surface)
{
    enum { STEPS = 600 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < 2 * STEPS; k++) {
            const double height = (i + 0.5) / STEPS * 2 - 1, turn = (k + 0.5) / STEPS * ANGLE_PI,
                         across = sqrt(1 - height * height);
            const struct vec3f d = {(float)(across * cos(turn)), (float)height,
                                    (float)(across * sin(turn))};
            if (!surface || height > 0)
                sum += (double)scene_sky_radiance(scene, d).x * (surface ? height : 1);
        }
    return sum * 4 * ANGLE_PI / (2.0 * STEPS * STEPS);
}

static void test_sky(void)
{
    static const struct vec3f up = {0, 1, 0}, nowhere = {0};
    static const float shares[] = {0, 0.25f, 1};
    struct bench b;
    bench_start(&b);
    for (int k = 0; k < 3; k++)
        b.settings.sky[k] = 1;
    add_floor(&b, 1e-3, -5, material(0, 0));
    must(scene_finish(b.scene, &b.settings, NULL));
    add_sky(&b);
    must(trace_create(&b.tracer, b.scene));
    must(path_init(&b.path, b.tracer, 0));
    const double there = sky_light(b.scene, true), around = sky_light(b.scene, false);
    ok(b.path.sky.rows == ROWS && !b.path.emissive, "a sky with a bright place is asked");
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        const struct path_receiver surface = receiver_at(&b, 0, 0, 0, up, shares[i]),
                                   point = receiver_at(&b, 0, 0, 0, nowhere, shares[i]);
        const struct mean irradiance = light_of(&b.path, &surface, STRAIGHT),
                          sphere = light_of(&b.path, &point, STRAIGHT);
        char what[80];
        snprintf(what, sizeof what, "irradiance of a sky, asked %g times a ray", (double)shares[i]);
        is_mean(&irradiance, there, what);
        snprintf(what, sizeof what, "its radiance over the sphere, asked %g times a ray",
                 (double)shares[i]);
        is_mean(&sphere, around, what);
    }
    bench_clear(&b);
}

/* -- directions ------------------------------------------------------------------------------- */

/* By the cosine, the mean cosine is 2/3, its mean square 1/2, and no side is preferred. */
static void test_scatter(void)
{
    enum { DRAWS = 200000 };
    const struct vec3 about[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0.36, -0.48, -0.8}};
    for (size_t i = 0; i < sizeof about / sizeof *about; i++) {
        const struct vec3f n = {(float)about[i].x, (float)about[i].y, (float)about[i].z};
        struct random r = random_start(6, i, 0);
        struct mean cosine = {0}, square = {0};
        struct vec3 sum = {0, 0, 0};
        double length_off = 0, lowest = 1;
        for (int k = 0; k < DRAWS; k++) {
            const float u = random_float(&r);
            const struct vec3f d = direction_by_cosine(n, u, random_float(&r));
            const double c = (double)vec3f_dot(d, n);
            length_off = fmax(length_off, fabs((double)vec3f_length(d) - 1));
            lowest = fmin(lowest, c);
            mean_add(&cosine, c);
            mean_add(&square, c * c);
            sum = vec3_add(sum, (struct vec3){(double)d.x, (double)d.y, (double)d.z});
        }
        const struct vec3 aside =
            vec3_sub(vec3_scale(1.0 / DRAWS, sum), vec3_scale(mean_value(&cosine), about[i]));
        ok(length_off < 1e-6 && lowest > -1e-6, "about normal %zu: unit, on its side", i);
        is_mean(&cosine, 2.0 / 3, "mean cosine");
        is_mean(&square, 1.0 / 2, "mean square");
        /* across, each component has variance 1/4 */
        ok(vec3_length(aside) < 5 * sqrt(0.25 / DRAWS) * sqrt(2), "and to no side");
    }
}

int main(void)
{
    test_what_rays_meet();
    test_lamp();
    test_shadow();
    test_scattered_once();
    test_furnace();
    test_straight_alone();
    test_sky();
    test_scatter();
    return tap_done();
}
