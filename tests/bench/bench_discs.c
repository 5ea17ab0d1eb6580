/* SPDX-License-Identifier: Apache-2.0 */
/* bench_discs: what a lookup by discs costs beside other lookups and the ray that found the place.
 *
 *     bench_discs SCENE POINTS.probe [RUNS]
 *
 * Rays by the cosine leave the stream's surface points (those of probe-place poisson) in an order
 * that has nothing to do with where they are, and where they meet the scene three values are looked
 * up: by discs, one by one and with what 64 lookups read fetched ahead; from the nearest point; by
 * the weights of Shepard within twice the mean distance of points. All are functions of the
 * library, called once a place, in turn on one thread; medians are printed as one line of JSON, for
 * scripts/bench, in microseconds of CPU.
 */
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "import/import_scene.h"
#include "interpolate/discs.h"
#include "interpolate/scatter.h"
#include "math/direction.h"
#include "math/random.h"
#include "math/sort.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"
#include "trace/trace_local.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { RUNS_MOST = 99, RAYS = 1 << 18, KINDS = 5, AHEAD = 64 };

struct place {
    double p[3], n[3];
};

/* What is timed. */
struct bench {
    const struct tracer *tracer;
    struct discs *discs;
    struct scatter *scatter;
    double radius; /* of Shepard */
    float *value;  /* 3 a point */
    struct vec3f (*ray)[2];
    struct place *place; /* in the order of rays */
    size_t places, covered;
    float sum; /* of all that was looked up: nothing may be left out */
};

static void fail(struct error *err)
{
    if (err) {
        fprintf(stderr, "bench_discs: %s\n", error_message(err));
        exit(1);
    }
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double median(double *x, size_t n)
{
    sort_doubles(n, x);
    return (x[(n - 1) / 2] + x[n / 2]) / 2;
}

/* Traces all rays; places: where they hit, if it is not NULL. */
static void trace_all(struct bench *b, struct place *place)
{
    struct trace_rays rays;
    struct trace_points at;
    b->places = place ? 0 : b->places;
    for (size_t first = 0; first < RAYS; first += TRACE_WAVE) {
        for (size_t i = 0; i < TRACE_WAVE; i++) {
            wave_put(&rays.origin, i, b->ray[first + i][0]);
            wave_put(&rays.direction, i, b->ray[first + i][1]);
            rays.most[i] = INFINITY;
            rays.salt[i] = (uint32_t)(first + i);
        }
        trace_rays_nearest(b->tracer, TRACE_WAVE, &rays, &at);
        for (size_t i = 0; i < TRACE_WAVE; i++) {
            b->sum += at.hit[i] ? at.distance[i] : 0;
            if (!place || !at.hit[i])
                continue;
            struct place *to = &place[b->places++];
            const struct vec3f n = vec3f_scale(at.front[i] ? 1.0f : -1.0f, wave_get(&at.normal, i));
            vec3_store(to->p, trace_to_world(b->tracer, wave_get(&at.position, i)));
            vec3_store(to->n, (struct vec3){(double)n.x, (double)n.y, (double)n.z});
        }
    }
}

/* fetch: what AHEAD lookups are going to read is brought nearer before. */
static void look_up(struct bench *b, bool fetch)
{
    b->covered = 0;
    for (size_t i = 0; i < b->places; i++) {
        float out[3];
        if (fetch && !(i % AHEAD))
            discs_fetch(b->discs, b->places - i < AHEAD ? b->places - i : AHEAD, b->place[i].p,
                        b->place[i].n, 6);
        const enum discs_answer answer =
            discs_blend(b->discs, b->place[i].p, b->place[i].n, 1, b->value, 3, out);
        b->covered += answer == DISCS_COVERED;
        b->sum += answer == DISCS_NONE ? 0 : out[0];
    }
}

static void look_nearest(struct bench *b)
{
    for (size_t i = 0; i < b->places; i++) {
        double distance;
        b->sum += b->value[3 * scatter_nearest(b->scatter, b->place[i].p, &distance)];
    }
}

struct shepard {
    const struct bench *b;
    double weight, sum[3];
};

static void add_point(void *context, int32_t point, double distance)
{
    struct shepard *s = context;
    const double weight = 1 - distance / s->b->radius;
    s->weight += weight;
    for (int k = 0; k < 3; k++)
        s->sum[k] += weight * (double)s->b->value[3 * point + k];
}

static void look_shepard(struct bench *b)
{
    for (size_t i = 0; i < b->places; i++) {
        struct shepard s = {.b = b};
        scatter_within(b->scatter, b->place[i].p, b->radius, add_point, &s);
        b->sum += s.weight > 0 ? (float)(s.sum[0] / s.weight) : 0;
    }
}

static bool skip(const void *context, size_t point)
{
    (void)context, (void)point;
    return false;
}

/* Rays from points in a random order, one after the other. */
static void make_rays(struct bench *b, const struct table *points, const float *normal)
{
    struct random r = random_start(1, 2, 3);
    const double *position = column_f64(table_column(points, "position"));
    fail(array_create(&b->ray, RAYS, sizeof *b->ray));
    for (size_t i = 0; i < RAYS; i++) {
        const size_t from = (size_t)(random_double(&r) * (double)points->rows);
        const float u = random_float(&r), turn = random_float(&r);
        const struct vec3f n = {normal[3 * from], normal[3 * from + 1], normal[3 * from + 2]};
        b->ray[i][0] = trace_to_local(b->tracer, position + 3 * from);
        b->ray[i][1] = direction_by_cosine(n, u, turn);
    }
}

static void prepare(struct bench *b, const struct table *points)
{
    const struct column *normal = table_column(points, "normal"),
                        *radius = table_column(points, "radius");
    const double *position = column_f64(table_column(points, "position"));
    float *twice = NULL;
    if (!normal || !radius)
        fail(error_new("expected points with columns normal and radius"));
    fail(array_create(&twice, points->rows, sizeof *twice));
    fail(array_create(&b->value, 3 * points->rows, sizeof *b->value));
    fail(array_create(&b->place, RAYS, sizeof *b->place));
    for (size_t i = 0; i < points->rows; i++) {
        twice[i] = 2 * column_f32(radius)[i];
        for (size_t k = 0; k < 3; k++)
            b->value[3 * i + k] = (float)((7 * i + k) % 13);
    }
    make_rays(b, points, column_f32(normal));
    trace_all(b, b->place);
    fail(scatter_create(&b->scatter, points->rows, position, skip, NULL));
    b->radius = scatter_spacing(b->scatter);
    const double start = seconds();
    fail(discs_create(&b->discs,
                      &(struct disc_points){points->rows, position, column_f32(normal), twice}));
    printf("{\"points\": %zu, \"places\": %zu, \"made_s\": %.4f, ", points->rows, b->places,
           seconds() - start);
    free(twice);
}

int main(int argc, char **argv)
{
    const int runs = argc == 4 ? atoi(argv[3]) : 5;
    if (argc < 3 || argc > 4 || runs < 1 || runs > RUNS_MOST) {
        fprintf(stderr, "usage: bench_discs SCENE POINTS.probe [RUNS]\n");
        return 2;
    }
    struct stream *stream;
    struct scene *scene;
    struct tracer *tracer;
    struct scene_settings light = scene_settings_default();
    struct warnings warnings = {0};
    struct bench b = {0};
    fail(stream_read(&stream, argv[2]));
    fail(scene_settings_from_header(&light, &stream->header));
    fail(scene_read(&scene, argv[1], &light, true, &warnings));
    fail(trace_create(&tracer, scene));
    b.tracer = tracer;
    prepare(&b, stream_table(stream, "probe"));
    double time[KINDS][RUNS_MOST];
    for (int run = -1; run < runs; run++) { /* the first is not counted */
        for (int kind = 0; kind < KINDS; kind++) {
            const double start = seconds();
            switch (kind) {
            case 0: look_up(&b, false); break;
            case 1: look_up(&b, true); break;
            case 2: look_nearest(&b); break;
            case 3: look_shepard(&b); break;
            default: trace_all(&b, NULL); break;
            }
            if (run >= 0)
                time[kind][run] = 1e6 * (seconds() - start) /
                                  (kind < KINDS - 1 ? (double)b.places : (double)RAYS);
        }
    }
    static const char *const names[KINDS] = {"discs", "discs_fetched", "nearest", "shepard", "ray"};
    for (int kind = 0; kind < KINDS; kind++)
        printf("\"%s\": %.4f, ", names[kind], median(time[kind], (size_t)runs));
    printf("\"covered\": %.4f, \"sum\": %g}\n", (double)b.covered / (double)b.places,
           (double)b.sum);
    discs_destroy(b.discs);
    scatter_destroy(b.scatter);
    trace_destroy(tracer);
    scene_destroy(scene);
    scene_settings_clear(&light);
    warnings_clear(&warnings);
    stream_destroy(stream);
    free(b.value);
    free(b.ray);
    free(b.place);
    return 0;
}
