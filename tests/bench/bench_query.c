/* SPDX-License-Identifier: Apache-2.0 */
/* bench_query: what libprobe-query takes in memory, for scripts/bench query: no files, no program.
 *
 * Usage: bench_query STREAM POINTS [RUNS]       POINTS: doubles, x y z each
 *
 * Prints, as JSON, the median of millions of points a second on one thread, from an array of points
 * to an array of light: "calls": a probe_volume_locate and a probe_blend a point, as a game calls
 * them; "batch": probe_volume_locate_many of 64 points at a time; "irradiance": calls, and
 * probe_irradiance for a normal in place of the light itself.
 */
#include "base/error.h"
#include "interpolate/interpolate.h"
#include "math/sort.h"
#include "stream/stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct work {
    const struct interpolate *in;
    size_t count;
    const double *point;
    float *light;
};

static void run_calls(const struct work *w)
{
    struct probe_place place = {.cell = PROBE_COLD};
    for (size_t i = 0; i < w->count; i++) {
        probe_volume_locate(w->in->volume, w->point + 3 * i, &place);
        probe_blend(&place, w->in->value, w->in->width, w->light + i * w->in->width);
    }
}

static void run_batch(const struct work *w)
{
    enum { BATCH = 64 };
    struct probe_place place[BATCH];
    place[0].cell = PROBE_COLD;
    for (size_t i = 0; i < w->count; i += BATCH) {
        const size_t n = w->count - i < BATCH ? w->count - i : BATCH;
        probe_volume_locate_many(w->in->volume, n, w->point + 3 * i, 3, NULL, place);
        for (size_t k = 0; k < n; k++)
            probe_blend(&place[k], w->in->value, w->in->width, w->light + (i + k) * w->in->width);
        place[0].cell = place[n - 1].cell;
    }
}

static void run_irradiance(const struct work *w)
{
    static const float normal[8][3] = {{1, 0, 0},       {0, 1, 0},      {0, 0, 1},
                                       {.6F, .8F, 0},   {0, .6F, -.8F}, {-.8F, 0, .6F},
                                       {-.6F, -.8F, 0}, {0, 0, -1}};
    struct probe_place place = {.cell = PROBE_COLD};
    float *sh = w->light + 3 * w->count; /* one point's */
    for (size_t i = 0; i < w->count; i++) {
        probe_volume_locate(w->in->volume, w->point + 3 * i, &place);
        probe_blend(&place, w->in->value, w->in->width, sh);
        probe_irradiance(w->in->order, sh, normal[i % 8], w->light + 3 * i);
    }
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Millions of points a second, after a run that is not counted. */
static double rate(void (*run)(const struct work *w), const struct work *w, int runs)
{
    double spent[100];
    run(w);
    for (int i = 0; i < runs; i++) {
        const double start = seconds();
        run(w);
        spent[i] = seconds() - start;
    }
    sort_doubles((size_t)runs, spent);
    return 1e-6 * (double)w->count / spent[runs / 2];
}

static bool read_points(const char *path, double **point, size_t *count)
{
    FILE *file = fopen(path, "rb");
    bool read = file && !fseek(file, 0, SEEK_END);
    const long bytes = read ? ftell(file) : 0;
    *count = (size_t)(bytes > 0 ? bytes : 0) / (3 * sizeof **point);
    *point = malloc(3 * *count * sizeof **point + 1);
    read = read && *point && !fseek(file, 0, SEEK_SET) &&
           fread(*point, 3 * sizeof **point, *count, file) == *count;
    if (file)
        fclose(file);
    return read && *count > 0;
}

int main(int argc, char **argv)
{
    const int runs = argc > 3 ? atoi(argv[3]) : 5;
    struct stream *stream = NULL;
    struct interpolate *in = NULL;
    double *point = NULL;
    struct work w = {0};
    if (argc < 3 || runs < 1 || runs > 100 || !read_points(argv[2], &point, &w.count)) {
        fprintf(stderr, "Usage: bench_query STREAM POINTS [RUNS]\n");
        free(point);
        return 2;
    }
    struct error *err = stream_read(&stream, argv[1]);
    if (!err)
        err = interpolate_open(&in, stream, &(struct interpolate_settings){.column = "sh"});
    if (!err) {
        w.in = in;
        w.point = point;
        w.light = malloc((w.count + 1) * in->width * sizeof *w.light);
        err = w.light ? NULL : error_memory();
    }
    if (!err)
        printf("{\"calls\": %.3f, \"batch\": %.3f, \"irradiance\": %.3f}\n",
               rate(run_calls, &w, runs), rate(run_batch, &w, runs),
               rate(run_irradiance, &w, runs));
    free(w.light);
    free(point);
    interpolate_close(in);
    stream_destroy(stream);
    return error_exit("bench_query", err);
}
