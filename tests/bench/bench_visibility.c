/* SPDX-License-Identifier: Apache-2.0 */
/* bench_visibility: ways to tell which probes a point sees, held against each other.
 *
 * Usage: bench_visibility SCENE STREAM WAY TRUTH [POINTS]
 *
 * WAY: all; kept: what the stream's cells keep (probe-leakfix); rays (trace/seen.h); depth8 and
 * depth16: for each probe an octahedral map of so many texels a side, of the distances of surfaces
 * and of their squares, and Chebyshev's inequality for what is farther (McGuire, Mara,
 * Nowrouzezahrai, Luebke, "Real-time global illumination using precomputed light field probes",
 * I3D 2017; Majercik, Guertin, Nowrouzezahrai, McGuire, "Dynamic diffuse global illumination with
 * ray-traced irradiance fields", JCGT 8, 2019). TRUTH: a file of probe-error's, made where it is
 * not there.
 *
 * Prints, as JSON: error, leak (share of weight in the free space of cells that is of unseen
 * probes) and blind (share of that space), as probe-error does; bytes a probe in a packed file;
 * microseconds a lookup on one thread, along walks; and jumps: of a thousand steps along random
 * lines through the probes' box, each a thousandth of it, how many change the light by more than a
 * tenth of the mean, and ten times as much as the steps before and behind.
 */
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "capture/stage.h"
#include "interpolate/baked.h"
#include "math/random.h"
#include "math/vec.h"
#include "measure/assess.h"
#include "stream/stream.h"
#include "trace/seen.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void must(struct error *err)
{
    if (err)
        exit(error_exit("bench_visibility", err));
}

/* -- octahedral maps of distance -------------------------------------------------------------- */

struct depth {
    const struct tracer *tracer;
    const double *position;
    size_t probes;
    int side;     /* texels */
    double reach; /* distances are clamped to it */
    float *map;   /* probes * (side + 2)^2: mean distance and mean square, with a border */
};

/* A direction from octahedral coordinates in [-1, 1] (Cigolle et al., "A survey of efficient
 * representations for independent unit vectors", JCGT 3, 2014), and back. */
static struct vec3 direction_of(double x, double y)
{
    struct vec3 d = {x, y, 1 - fabs(x) - fabs(y)};
    if (d.z < 0) {
        d.x = copysign(1 - fabs(y), x);
        d.y = copysign(1 - fabs(x), y);
    }
    return vec3_normalize(d);
}

static void octahedral(struct vec3 d, double *x, double *y)
{
    const double sum = fabs(d.x) + fabs(d.y) + fabs(d.z);
    *x = d.x / sum;
    *y = d.y / sum;
    if (d.z < 0) {
        const double u = *x;
        *x = copysign(1 - fabs(*y), u);
        *y = copysign(1 - fabs(u), *y);
    }
}

static float *texel_of(const struct depth *d, size_t probe, int x, int y)
{
    const size_t side = (size_t)d->side + 2;
    return d->map + 2 * (side * side * probe + side * (size_t)y + (size_t)x);
}

/* Distances by rays, each spread over the texels about it by the cosine's 50th power, as Majercik
 * et al. do. */
static struct error *fill_map(void *context, size_t probe, int thread)
{
    enum { RAYS = 4096 };
    (void)thread;
    const struct depth *d = context;
    const int side = d->side;
    struct vec3 to[16 * 16];
    double sum[16 * 16][3] = {{0}};
    for (int i = 0; i < side * side; i++)
        to[i] = direction_of(2 * (i % side + 0.5) / side - 1, 2 * (i / side + 0.5) / side - 1);
    for (int k = 0; k < RAYS; k++) {
        const double z = 1 - (2 * k + 1.0) / RAYS, r = sqrt(1 - z * z),
                     turn = k * 2.39996322972865332;
        const double way[3] = {r * cos(turn), r * sin(turn), z};
        const struct trace_hit hit =
            trace_nearest(d->tracer, d->position + 3 * probe, way, d->reach);
        const double far = hit.hit ? hit.distance : d->reach;
        for (int i = 0; i < side * side; i++) {
            const double cosine = vec3_dot(vec3_load(way), to[i]);
            if (cosine < 0.8)
                continue;
            const double weight = pow(cosine, 50);
            sum[i][0] += weight;
            sum[i][1] += weight * far;
            sum[i][2] += weight * far * far;
        }
    }
    for (int y = 0; y < side + 2; y++)
        for (int x = 0; x < side + 2; x++) {
            int i = x - 1, j = y - 1; /* beyond the border the map goes on turned round */
            if (i < 0 || i >= side) {
                i = i < 0 ? 0 : side - 1;
                j = side - 1 - j;
            }
            if (j < 0 || j >= side) {
                j = j < 0 ? 0 : side - 1;
                i = side - 1 - i;
            }
            const double *s = sum[j * side + i];
            texel_of(d, probe, x, y)[0] = (float)(s[1] / s[0]);
            texel_of(d, probe, x, y)[1] = (float)(s[2] / s[0]);
        }
    return NULL;
}

/* Majercik et al. 2019, sec. 5.2, with the cube of Chebyshev's bound. The point has no normal, so
 * there is neither a bias along it nor a weight by it. */
static double depth_visible(const struct depth *d, size_t probe, const double p[3])
{
    const struct vec3 way = vec3_sub(vec3_load(p), vec3_load(d->position + 3 * probe));
    const double far = vec3_length(way);
    double x, y, mean = 0, square = 0;
    if (!(far > 0))
        return 1;
    octahedral(way, &x, &y);
    x = (x + 1) / 2 * d->side + 0.5;
    y = (y + 1) / 2 * d->side + 0.5;
    const int i = (int)x, j = (int)y;
    for (int k = 0; k < 4; k++) {
        const float *t = texel_of(d, probe, i + (k & 1), j + (k >> 1));
        const double w = (k & 1 ? x - i : 1 - (x - i)) * (k >> 1 ? y - j : 1 - (y - j));
        mean += w * (double)t[0];
        square += w * (double)t[1];
    }
    if (far <= mean)
        return 1;
    const double variance = fabs(square - mean * mean), off = far - mean,
                 bound = variance / (variance + off * off);
    return fmax(bound * bound * bound, 0);
}

static void see_by_depth(const void *own, const double p[3], struct probe_place *place)
{
    const struct depth *d = own;
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        if (!(place->weight[i] > 0))
            continue;
        /* never all zero (Majercik et al. keep 0.05 before the cube) */
        const double v = fmax(depth_visible(d, (size_t)place->probe[i], p), 1e-6);
        place->weight[i] *= v;
        sum += place->weight[i];
    }
    for (int i = 0; i < 4 && sum > 0; i++)
        place->weight[i] /= sum;
}

static void depth_join(struct depth *d, const struct tracer *tracer, const struct baked *baked,
                       int side)
{
    const size_t texels = ((size_t)side + 2) * ((size_t)side + 2);
    *d = (struct depth){
        .tracer = tracer, .position = baked->position, .probes = baked->probe_count, .side = side};
    for (size_t c = 0; c < baked->mesh.cells; c++) /* the longest way within a cell */
        for (int i = 1; i < baked->mesh.corners; i++) {
            const int32_t *v = baked->mesh.vertex + (size_t)baked->mesh.corners * c;
            d->reach =
                fmax(d->reach, vec3_length(vec3_sub(vec3_load(d->position + 3 * (size_t)v[i]),
                                                    vec3_load(d->position + 3 * (size_t)v[0]))));
        }
    must(array_create(&d->map, 2 * texels * d->probes, sizeof *d->map));
    must(threads_for(threads_available(), d->probes, fill_map, d));
    const struct interpolate_sight sight = {.see = see_by_depth, .own = d};
    must(interpolate_set_sight(baked->in, &sight));
}

/* -- figures ---------------------------------------------------------------------------------- */

static double brightness_at(const struct baked *baked, const double p[3], struct probe_place *place)
{
    double sum = 0;
    baked_locate(baked, p, place);
    for (int i = 0; i < 4; i++)
        sum += place->weight[i] > 0 ? place->weight[i] * baked_brightness(baked, place->probe[i])
                                    : 0;
    return sum;
}

static void box_of(const struct baked *baked, double low[3], double high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (size_t i = 0; i < baked->probe_count; i++) {
            low[k] = fmin(low[k], baked->position[3 * i + (size_t)k]);
            high[k] = fmax(high[k], baked->position[3 * i + (size_t)k]);
        }
    }
}

static double jumps_of(const struct baked *baked)
{
    enum { LINES = 64, STEPS = 1000 };
    double low[3], high[3], mean = 0;
    size_t jumps = 0;
    struct random r = random_start(1, 0, 0);
    box_of(baked, low, high);
    for (size_t i = 0; i < baked->probe_count; i++)
        mean += baked_brightness(baked, (int32_t)i) / (double)baked->probe_count;
    for (int line = 0; line < LINES; line++) {
        double from[3], to[3], change[STEPS], last = 0;
        struct probe_place place = {.cell = PROBE_COLD};
        for (int k = 0; k < 3; k++) {
            from[k] = low[k] + (high[k] - low[k]) * random_double(&r);
            to[k] = low[k] + (high[k] - low[k]) * random_double(&r);
        }
        for (int i = 0; i <= STEPS; i++) {
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = from[k] + (to[k] - from[k]) * i / STEPS;
            const double now = brightness_at(baked, p, &place);
            if (i)
                change[i - 1] = fabs(now - last);
            last = now;
        }
        for (int i = 1; i + 1 < STEPS; i++)
            jumps += change[i] > 0.1 * mean && change[i] > 10 * change[i - 1] &&
                     change[i] > 10 * change[i + 1];
    }
    return (double)jumps / LINES;
}

static double lookup_time(const struct baked *baked, size_t points)
{
    double low[3], high[3], *point = NULL, sum = 0;
    struct random r = random_start(2, 0, 0);
    struct timespec begin, end;
    box_of(baked, low, high);
    must(array_create(&point, 3 * points, sizeof *point));
    for (size_t i = 0; i < points; i++) /* short walks, as things move */
        for (size_t k = 0; k < 3; k++)
            point[3 * i + k] = i % 100 ? point[3 * i + k - 3] +
                                             (high[k] - low[k]) * 1e-3 * random_double(&r)
                                       : low[k] + (high[k] - low[k]) * 0.9 * random_double(&r);
    struct probe_place place = {.cell = PROBE_COLD};
    float light[3 * SH_COUNT_MAX];
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    for (size_t i = 0; i < points; i++) {
        baked_locate(baked, point + 3 * i, &place);
        probe_blend(&place, baked->sh, baked->width, light);
        sum += (double)light[0];
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    free(point);
    const double seconds = (double)(end.tv_sec - begin.tv_sec) +
                           1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    return isnan(sum) ? NAN : 1e6 * seconds / (double)points;
}

int main(int argc, char **argv)
{
    struct stream *stream = NULL;
    struct stage stage = {0};
    struct baked baked = {0};
    struct seen *seen = NULL;
    struct depth depth = {0};
    struct warnings warnings = {0};
    struct assessment result = {0};
    struct scene_settings given = scene_settings_default();
    const char *way = argc > 3 ? argv[3] : "";
    const bool all = !strcmp(way, "all"), kept = !strcmp(way, "kept"), rays = !strcmp(way, "rays");
    const int side = !strcmp(way, "depth8") ? 8 : !strcmp(way, "depth16") ? 16 : 0;
    if (argc < 5 || !(all || kept || rays || side)) {
        fprintf(stderr, "Usage: bench_visibility SCENE STREAM all|kept|rays|depth8|depth16 TRUTH "
                        "[POINTS]\n");
        return 2;
    }
    const struct interpolate_settings settings = {.column = "sh",
                                                  .outside = kept ? 0 : PROBE_SEE_ALL};
    must(stream_read(&stream, argv[2]));
    must(baked_open(&baked, stream, &settings));
    must(stage_init(&stage, argv[1], &stream->header, &given, &warnings));
    if (rays)
        must(seen_join(&seen, stage.tracer, baked.probe_count, baked.in));
    if (side)
        depth_join(&depth, stage.tracer, &baked, side);
    struct assess_job job = {
        .stage = &stage,
        .baked = &baked,
        .truth = truth_settings_default(),
        .truth_file = argv[4],
        .measure = {.tolerance = 0.05, .dark = 0.25, .bad = 0.25, .threads = threads_available()},
        .leak_samples = 8,
        .command_line = "bench_visibility",
        .program = "bench_visibility",
        .warnings = &warnings};
    must(assess(&result, &job));
    printf("{\"error\": %.5g, \"leak\": %.5g, \"blind\": %.5g",
           report_get(&result.report, "error", "all").value,
           report_get(&result.report, "leak_volume", "all").value,
           report_get(&result.report, "blind", "all").value);
    const double texels = (side + 2.0) * (side + 2.0), probes = (double)baked.probe_count,
                 each = baked.probe_count <= UINT16_MAX ? 26 : 28;
    printf(", \"bytes\": %.4g, \"lookup\": %.3g, \"jumps\": %.3g}\n",
           side   ? 4 * texels
           : kept ? each * (double)baked.mesh.cells / probes
                  : 0,
           lookup_time(&baked, argc > 5 ? strtoul(argv[5], NULL, 10) : 200000), jumps_of(&baked));
    warnings_clear(&warnings);
    assessment_clear(&result);
    baked_close(&baked);
    seen_destroy(seen);
    free(depth.map);
    stage_clear(&stage);
    stream_destroy(stream);
    return 0;
}
