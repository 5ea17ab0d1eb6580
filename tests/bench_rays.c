/* bench_rays: what capture costs over the rays it traces.
 *
 *     bench_rays SCENE CAPTURED.probe [RUNS]
 *
 * Captures the stream's probes again, on one thread, with the settings in its header, and remembers every ray that Embree is
 * asked for; then hands the same rays to Embree in a bare loop, in the same order. Both take turns; the medians, the rates and
 * their ratio are printed as one line of JSON, for scripts/bench. The linker puts the functions below between capture and
 * Embree (--wrap).
 */
#include "array.h"
#include "capture.h"
#include "error.h"
#include "scene.h"
#include "stream.h"
#include "warning.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

struct recorded {
    struct trace_query query;
    struct RTCRay ray;
    bool occlusion;
};

static struct recorded *rays;
static size_t ray_count, ray_capacity;
static bool recording;

void __real_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *hit);
void __real_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);
void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *hit);
void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);

static void fail(struct error *err)
{
    if (err) {
        fprintf(stderr, "bench_rays: %s\n", error_message(err));
        exit(1);
    }
}

static void record(const struct RTCIntersectContext *context, const struct RTCRay *ray, bool occlusion)
{
    fail(array_reserve(&rays, &ray_capacity, ray_count + 1, sizeof *rays));
    rays[ray_count++] = (struct recorded){*(const struct trace_query *)context, *ray, occlusion};
}

void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *hit)
{
    if (recording)
        record(context, &hit->ray, false);
    __real_rtcIntersect1(scene, context, hit);
}

void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray)
{
    if (recording)
        record(context, ray, true);
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

static double capture_all(const struct path_tracer *path, const struct capture_settings *settings, struct table *probes)
{
    size_t captured;
    const double start = seconds();
    fail(capture_rows(path, settings, probes, 0, probes->rows, true, NULL, 1, NULL, &captured, NULL));
    return seconds() - start;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, size_t n)
{
    qsort(x, n, sizeof *x, ascending);
    return (x[(n - 1) / 2] + x[n / 2]) / 2;
}

int main(int argc, char **argv)
{
    enum { RUNS_MOST = 99 };
    const int runs = argc == 4 ? atoi(argv[3]) : 5;
    if (argc < 3 || argc > 4 || runs < 1 || runs > RUNS_MOST) {
        fprintf(stderr, "usage: bench_rays SCENE CAPTURED.probe [RUNS]\n");
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
    fail(trace_create(&tracer, scene));
    fail(path_create(&path, tracer, settings.bounces));
    struct table *probes = stream_table(stream, "probe");
    recording = true;
    capture_all(&path, &settings, probes);
    recording = false;
    double capture[RUNS_MOST], bare[RUNS_MOST];
    for (int i = 0; i < runs; i++) {
        capture[i] = capture_all(&path, &settings, probes);
        bare[i] = replay(tracer);
    }
    const double c = median(capture, (size_t)runs), b = median(bare, (size_t)runs);
    printf("{\"probes\": %zu, \"rays\": %zu, \"capture_s\": %.4f, \"bare_s\": %.4f, \"capture_mrays\": %.3f, \"bare_mrays\": %.3f, "
           "\"ratio\": %.3f}\n", probes->rows, ray_count, c, b, (double)ray_count / c / 1e6, (double)ray_count / b / 1e6, b / c);
    path_clear(&path);
    trace_destroy(tracer);
    scene_destroy(scene);
    scene_settings_clear(&light);
    warnings_clear(&warnings);
    stream_destroy(stream);
    free(rays);
    return 0;
}
