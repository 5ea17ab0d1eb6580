/* SPDX-License-Identifier: Apache-2.0 */
/* bench_rays: what capture costs over the rays it traces.
 *
 *     bench_rays SCENE CAPTURED.probe [RUNS]
 *     bench_rays --render SCENE CAPTURED.probe [RUNS]
 *
 * Captures the stream's probes again, on one thread, with the settings in its header, and remembers
 * every ray that Embree is asked for; then hands the same rays to Embree in a bare loop, in the
 * same order. Both take turns; the medians, the rates and their ratio are printed as one line of
 * JSON, for scripts/bench. --render: takes a picture of the truth in turn with capture instead, and
 * counts the rays of both. The linker puts the functions below between capture and Embree (--wrap).
 */
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "import/import_scene.h"
#include "math/sort.h"
#include "render/camera.h"
#include "render/render.h"
#include "render/view.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"
#include "topology/decimate.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct recorded {
    struct trace_query query;
    struct RTCRay ray;
    bool occlusion;
};

static struct recorded *rays;
static size_t ray_count, ray_capacity;
static bool recording, counting;

void __real_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context,
                          struct RTCRayHit *hit);
void __real_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);
void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context,
                          struct RTCRayHit *hit);
void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);

static void fail(struct error *err)
{
    if (err) {
        fprintf(stderr, "bench_rays: %s\n", error_message(err));
        exit(1);
    }
}

static void record(const struct RTCIntersectContext *context, const struct RTCRay *ray,
                   bool occlusion)
{
    fail(array_reserve(&rays, &ray_capacity, ray_count + 1, sizeof *rays));
    rays[ray_count++] = (struct recorded){*(const struct trace_query *)context, *ray, occlusion};
}

void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context,
                          struct RTCRayHit *hit)
{
    if (recording)
        record(context, &hit->ray, false);
    ray_count += counting;
    __real_rtcIntersect1(scene, context, hit);
}

void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray)
{
    if (recording)
        record(context, ray, true);
    ray_count += counting;
    __real_rtcOccluded1(scene, context, ray);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double replay(const struct tracer *tracer)
{
    const double start = seconds();
    for (size_t i = 0; i < ray_count; i++) {
        struct trace_query query = rays[i].query;
        if (rays[i].occlusion) {
            struct RTCRay ray = rays[i].ray;
            __real_rtcOccluded1(tracer->embree, &query.context, &ray);
        } else {
            struct RTCRayHit hit = {.ray = rays[i].ray};
            hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            __real_rtcIntersect1(tracer->embree, &query.context, &hit);
        }
    }
    return seconds() - start;
}

static double capture_all(const struct path_tracer *path, const struct capture_settings *settings,
                          struct table *probes)
{
    struct capture_job job = {.path = path, .settings = settings, .again = true, .threads = 1};
    const double start = seconds();
    fail(capture_rows(&job, probes, 0, probes->rows));
    return seconds() - start;
}

static double median(double *x, size_t n)
{
    sort_doubles(n, x);
    return (x[(n - 1) / 2] + x[n / 2]) / 2;
}

static double render_truth(const struct path_tracer *path, const struct camera *camera)
{
    const struct render render = {
        .path = path, .camera = camera, .object = {.first = SIZE_MAX}, .samples = 16, .threads = 1};
    struct picture picture;
    const double start = seconds();
    fail(render_picture(&render, RENDER_TRUTH, &picture, NULL, NULL));
    picture_clear(&picture);
    return seconds() - start;
}

enum { RUNS_MOST = 99 };

/* A picture and a capture in turn. */
static void compare_render(const struct path_tracer *path, const struct capture_settings *settings,
                           struct table *probes, int runs)
{
    struct vec3 eye, look_at;
    struct camera camera;
    double capture[RUNS_MOST], render[RUNS_MOST];
    fail(view_choose(path, 60, 16.0 / 9, &eye, &look_at));
    fail(camera_init(&camera, &(struct camera_view){.eye = eye,
                                                    .look_at = look_at,
                                                    .up = {0, 1, 0},
                                                    .fov = 60,
                                                    .width = 320,
                                                    .height = 180}));
    counting = true;
    capture_all(path, settings, probes);
    const size_t of_capture = ray_count;
    render_truth(path, &camera);
    const size_t of_render = ray_count - of_capture;
    counting = false;
    for (int i = 0; i < runs; i++) {
        capture[i] = capture_all(path, settings, probes);
        render[i] = render_truth(path, &camera);
    }
    const double c = median(capture, (size_t)runs), r = median(render, (size_t)runs);
    printf("{\"capture_rays\": %zu, \"render_rays\": %zu, \"capture_mrays\": %.3f, "
           "\"render_mrays\": %.3f, \"paths\": %.3f, \"ratio\": %.3f}\n",
           of_capture, of_render, (double)of_capture / c / 1e6, (double)of_render / r / 1e6,
           320 * 180 * 16 / r / 1e6, (double)of_render / r / ((double)of_capture / c));
}

int main(int argc, char **argv)
{
    const bool render = argc > 1 && !strcmp(argv[1], "--render");
    argv += render;
    argc -= render;
    const int runs = argc == 4 ? atoi(argv[3]) : 5;
    if (argc < 3 || argc > 4 || runs < 1 || runs > RUNS_MOST) {
        fprintf(stderr, "usage: bench_rays [--render] SCENE CAPTURED.probe [RUNS]\n");
        return 2;
    }
    struct stream *stream;
    struct scene *scene;
    struct tracer *tracer;
    struct path_tracer path;
    struct scene_settings light = scene_settings_default();
    struct capture_settings settings = capture_settings_default();
    struct warnings warnings = {0};
    fail(stream_read(&stream, argv[2]));
    fail(scene_settings_from_header(&light, &stream->header));
    fail(capture_settings_from_header(&settings, &stream->header));
    fail(scene_read(&scene, argv[1], &light, true, &warnings));
    const double decimate_start = seconds();
    fail(scene_decimate(scene, settings.decimate, &warnings));
    const double build_start = seconds();
    fail(trace_create(&tracer, scene));
    const double build_end = seconds();
    fail(path_init(&path, tracer, settings.bounces));
    struct table *probes = stream_table(stream, "probe");
    if (render) {
        compare_render(&path, &settings, probes, runs);
        return 0;
    }
    recording = true;
    capture_all(&path, &settings, probes);
    recording = false;
    double capture[RUNS_MOST], bare[RUNS_MOST];
    for (int i = 0; i < runs; i++) {
        capture[i] = capture_all(&path, &settings, probes);
        bare[i] = replay(tracer);
    }
    const double c = median(capture, (size_t)runs), b = median(bare, (size_t)runs);
    printf("{\"probes\": %zu, \"rays\": %zu, \"capture_s\": %.4f, \"bare_s\": %.4f, "
           "\"capture_mrays\": %.3f, \"bare_mrays\": %.3f, "
           "\"ratio\": %.3f, \"triangles\": %zu, \"decimate_s\": %.4f, \"build_s\": %.4f}\n",
           probes->rows, ray_count, c, b, (double)ray_count / c / 1e6, (double)ray_count / b / 1e6,
           b / c, scene_triangle_count(scene), build_start - decimate_start,
           build_end - build_start);
    path_clear(&path);
    trace_destroy(tracer);
    scene_destroy(scene);
    scene_settings_clear(&light);
    warnings_clear(&warnings);
    stream_destroy(stream);
    free(rays);
    return 0;
}
