/* SPDX-License-Identifier: Apache-2.0 */
/* truth: the light of a scene at points that no probe stands at, path traced.
 *
 * Points are spread evenly over the free space of a box, by seed, or given; paths run through free
 * space in small steps. At each the irradiance along the directions of sphere.h is traced twice,
 * with random numbers of their own, which no capture has: T1 and T2. Their mean is the truth, half
 * their difference has its noise, and for any s
 *
 *     E (s - T1)(s - T2) = (s - truth)^2
 *
 * exactly, whatever the noise: so a mean square error needs no estimate of a variance. Irradiance
 * is summed from the rays of the whole sphere, each by its cosine (capture.h), so nothing is cut
 * off.
 *
 * Where paths end in a cache of the surfaces' light (capture/capture_cache.h), both have its bias
 * and its noise, so that this is a preview, and no truth.
 *
 * It is kept as a probe stream, with the scene's key and light in its header, and serves any stream
 * that was captured in that scene and light. Table probe:
 *
 *     position:f64:3 path:i32:1 surface:f32:1 irradiance_1:f32:96 irradiance_2:f32:96
 *
 * path: -1 for a point, else the number of a path, whose rows are its steps in order; surface:
 * distance to the nearest one, missing where there is none; irradiance_*: RGB for each direction.
 * Key truth-cache: it is a preview, and with which cache.
 */
#ifndef TRUTH_H
#define TRUTH_H

#include "capture/cache_options.h"
#include "capture/stage.h"
#include "measure/sphere.h"
#include "place/reach.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct box;
struct error;
struct progress;
struct stream;
struct warnings;

enum { TRUTH_WIDTH = 3 * SPHERE_COUNT };

/* What is asked for. Where a truth is read instead of traced, what was not `given` is taken as it
 * comes. */
struct truth_settings {
    int64_t points, paths;
    const char *points_file, *path_file; /* instead of random ones; NULL: random */
    double bounds[6];                    /* of random points; NaN: choose */
    double step;                         /* along paths, scene units; NaN: choose */
    int64_t rays;                        /* of each point, both halves together */
    /* of each half, as capture_settings.error; 0: rays alone count */
    double error;
    int64_t rays_most;
    int64_t bounces;            /* -1: the stream's */
    struct cache_options cache; /* no name: the truth itself */
    int64_t seed;
    const char
        *reach_file; /* start points: where a body gets from them (reach.h); NULL: anywhere */
    struct reach_settings reach;
    bool points_given, paths_given, bounds_given, step_given, rays_given, error_given, seed_given;
};

struct truth_settings truth_settings_default(void); /* 1000 points, 16 paths, 4096 rays */

struct truth {
    struct stream *stream; /* owned */
    size_t count;          /* rows; those of points come first */
    size_t points;
    double low[3], high[3]; /* of the box */
    double step;            /* 0: no paths */
    /* Borrowed from the stream: */
    const double *position;
    const int32_t *path;
    const float *surface, *half[2];
};

/* How a truth is traced. */
struct truth_job {
    const struct stage *stage;
    const struct truth_settings *settings;
    const struct box *box;    /* of the probes, for scenes whose own has no volume */
    const char *command_line; /* as recorded */
    int threads;
    struct progress *progress; /* may be NULL */
    struct warnings *warnings;
};

struct error *truth_trace(struct truth *truth, const struct truth_job *job);

/* Reads what truth_trace made. Errors: it is of another scene or light, or not what the settings
 * ask for (says which). */
struct error *truth_read(struct truth *truth, const char *file, const struct stage *stage,
                         const struct truth_settings *settings);

/* Whether it is but a preview. */
bool truth_is_preview(const struct truth *truth);

void truth_clear(struct truth *truth);

/* How many points truth_trace will trace at the most, for progress. */
size_t truth_size(const struct truth_settings *settings);

/* Luminance of row i's irradiance: the mean of both halves, and half their difference. Either may
 * be NULL. */
void truth_luminance(const struct truth *truth, size_t i, double *mean, double *noise);

#endif
