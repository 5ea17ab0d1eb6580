/* SPDX-License-Identifier: Apache-2.0 */
/* capture: the light that reaches a probe, with its error and what the rays learned on the way.
 *
 * A probe is a point, whose light is incident radiance as SH; or, where its table has a column
 * `normal`, a surface, whose light is the irradiance of its half of directions, which are drawn by
 * the cosine (Malley's method). A point may as well be asked for the irradiance of surfaces of
 * several normals there, all from the same rays over the whole sphere: exact where SH is cut off,
 * and cheaper than as many surfaces.
 *
 * The directions are cut into cells of equal probability, with one independent sample in each: no
 * other stratification has less error, but none of the cells knows its own variance. It is
 * estimated from every four neighbours, 2 by 2, by the difference between their diagonals, (a + d)
 * - (b + c), to which linear change across the cells adds nothing: four times a cell's variance and
 * what mixed change is left, so the error is a little too large rather than too small (collapsed
 * strata: Cochran, "Sampling Techniques", 1977, sec. 5A.12). The largest of these differences
 * counts twice: light that few rays find is missed by most probes, and what a probe has not seen is
 * about as large as the largest that it has. Emissive surfaces are asked in cells of their own
 * (path_lights), and so is an uneven sky. Point, spot and sun lights enter as deltas in their
 * direction. Sums are in double.
 *
 * A number of rays is fixed, or spent until the error is small enough: see capture_settings. Rounds
 * of rays add up; none is thrown away. N rays make at least N cells: about sqrt(N / 3) rows in z, 3
 * times as many columns in phi, both even. A probe's result depends on the scene, the settings and
 * its position alone.
 */
#ifndef CAPTURE_H
#define CAPTURE_H

#include "libprobe-query/sh.h"
#include "capture/occlusion.h"
#include "light/dering.h"
#include "trace/path.h"

#include <stdbool.h>
#include <stdint.h>

struct cache_options;
struct capture_split;
struct error;
struct progress;
struct scene;
struct scene_settings;
struct stream_header;
struct table;

/* What light is captured. ALL = DIRECT + INDIRECT; emitters and sky seen straight from the probe
 * count as direct, and so do point, spot and sun light. NONE: what rays tell beside light alone;
 * light that probes have stays, and so does what the header says of it. */
enum capture_light { CAPTURE_ALL, CAPTURE_DIRECT, CAPTURE_INDIRECT, CAPTURE_NONE };
extern const char *const capture_light_names[]; /* of a header: not NONE; NULL behind the last */

enum { CAPTURE_RAYS_MOST = 1 << 24, CAPTURE_BOUNCES_MOST = 1 << 16 };

struct capture_settings {
    int order; /* 1 .. SH_ORDER_MAX */
    /* of each probe; rounded up to what the grid of cells needs. Where error is set: of the first
     * round */
    int rays;
    /* 0: rays alone count. Else rays are spent until the probe's relative standard error is at most
     * this, or there are rays_most of them. For a point the relative standard error is that of
     * irradiance, in luminance, in the mean over directions: sqrt(mean over n of Var E(n)) / mean
     * over n of E(n) = sqrt(sum A_l^2 Var L_lm / 4 pi) / (A_0 L_00 Y_00); for a surface that of its
     * irradiance. */
    double error;
    /* irradiance below which a probe counts as this bright, so that the dark costs no more than it
     * is worth */
    double error_floor;
    int rays_most;
    int bounces;
    enum capture_light light;
    uint64_t seed;
    /* share of the scene's triangles that was kept (scene_decimate), by who reads the scene; 1: it
     * is whole */
    double decimate;
    double ao_distance; /* scene units: surfaces beyond do not occlude; INFINITY: all do */
    enum occlusion_falloff ao_falloff; /* not STEP: ao_distance is finite */
    int azimuths;                      /* of the horizon, 1 .. OCCLUSION_AZIMUTHS_MOST */
    unsigned columns;                  /* CAPTURE_* of the columns to write beside light */
    bool convolved; /* sh, its error and gradient are written as irradiance (content.h) */
    struct dering_settings dering; /* what is done to sh before that; of surfaces, nothing */
    /* open: parts of the light that tables get columns of (capture_split.h); borrowed; NULL:
     * none */
    const struct capture_split *split;
    /* For capture_probe at points: instead of SH, the irradiance of surfaces with these unit
     * normals (3 * normal_count, at most SH_COUNT_MAX of them), in sh and sh_error, 3 values each;
     * error is then that of their mean. 0: SH. Gradients and visibility are not to be had. */
    const double *normal;
    int normal_count;
};

enum {
    CAPTURE_ERROR = 1,
    CAPTURE_VALIDITY = 2,
    CAPTURE_DEPTH = 4,
    CAPTURE_SKY = 8,
    CAPTURE_GRADIENT = 16,
    CAPTURE_VISIBILITY = 32,
    CAPTURE_AO = 64,
    CAPTURE_BENT_NORMAL = 128,
    CAPTURE_RAYS = 256,
    CAPTURE_WINDOW = 512, /* sh_window: goes with dering, not asked for by itself */
    CAPTURE_BENT_LENGTH = 1024,
    CAPTURE_CONE = 2048,
    CAPTURE_AO_BOUNCED = 4096,
    CAPTURE_HORIZON = 8192,
    CAPTURE_DEFAULT = CAPTURE_ERROR | CAPTURE_VALIDITY | CAPTURE_DEPTH | CAPTURE_SKY,
    /* those that depend on the occlusion settings: what is there of them is made anew as one */
    CAPTURE_OCCLUSION = CAPTURE_AO | CAPTURE_BENT_NORMAL | CAPTURE_BENT_LENGTH | CAPTURE_CONE |
                        CAPTURE_AO_BOUNCED | CAPTURE_HORIZON,
    CAPTURE_OF_LIGHT = CAPTURE_ERROR | CAPTURE_GRADIENT | CAPTURE_WINDOW, /* nothing without it */
};

/* What one probe learned. Of a surface: its irradiance and the error of that stand first in sh and
 * sh_error. */
struct capture_probe {
    float sh[3 * SH_COUNT_MAX];
    float sh_error[3 * SH_COUNT_MAX]; /* standard error of each value, a cache's among it */
    /* per scene unit: d/dx, d/dy, d/dz of sh (gradient.h); points alone, where asked for */
    float sh_gradient[9 * SH_COUNT_MAX];
    /* projection of V(w): 1 where a ray escapes, else 0; points alone, where asked for */
    float visibility[SH_COUNT_MAX];
    /* share of the rays that met a front side, of those that met any; 1 when none did */
    float validity;
    /* harmonic mean distance of the hits, scene units; a ray that escapes counts as 1/inf = 0. 0:
     * nothing was hit */
    float depth;
    float sky; /* share of the rays that escaped */
    /* mean openness of the rays (occlusion.h): of a surface, k_A of Akenine-Moeller et al.,
     * "Real-time rendering", 4th ed., eq. 11.8 and 11.11; of a point, the same without the
     * cosine */
    float ao;
    /* occlusion_bent, occlusion_cone: */
    float bent_normal[3], bent_length, cone[4];
    /* occlusion_bounced by the albedo of the surface behind it, NaN where nothing is there;
     * surfaces alone, where asked for */
    float ao_bounced[3];
    float horizon[OCCLUSION_AZIMUTHS_MOST]; /* occlusion_horizon; surfaces alone, where asked for */
    int rays;                               /* that were spent on its directions */
    float sh_window; /* r of the window that dering put on it; 1: none. Set by capture_shape */
};

/* Order 3, 512 rays, no error asked for, at most 65536 rays, 64 bounces, all light, seed 0, no ao
 * distance, the whole scene, default columns, radiance as it is. */
struct capture_settings capture_settings_default(void);

/* As header keys (sh-order, sh-content, capture-rays, capture-bounces, capture-light, capture-seed;
 * capture-error, capture-error-floor, capture-max-rays where an error is asked for;
 * capture-ao-distance, capture-ao-falloff and capture-azimuths where they are no defaults;
 * capture-decimate below 1; sh-dering where that is asked for), and back. */
struct error *capture_settings_to_header(const struct capture_settings *settings,
                                         struct stream_header *header);
/* An error when keys make no sense. Missing keys leave the setting as it is. */
struct error *capture_settings_from_header(struct capture_settings *settings,
                                           const struct stream_header *header);

/* Key of light that was not captured for its own sake, and gives way to other settings; its value:
 * the program that traced it. */
#define CAPTURE_BY_KEY "capture-by"

/* Whether the header says that probes were captured. */
bool capture_header_has_settings(const struct stream_header *header);

/* What a captured stream's header tells of how it was made. */
struct capture_record {
    const struct capture_settings *settings;
    const struct cache_options *cache;
    const struct scene_settings *light;
    const struct capture_split *split;   /* NULL: none */
    const struct stream_header *senders; /* has the keys of senders (senders.h); NULL: none */
    const char *scene_key;               /* as the header is to have it; borrowed */
    bool again;                          /* all probes are captured anew */
    const char *command_line;            /* as recorded */
};

/* The header of a captured stream: `before` with the record. An error where probes that are not
 * captured again had other settings or another scene. */
struct error *capture_make_header(struct stream_header *header, const struct stream_header *before,
                                  const struct capture_record *record);

/* How many rays a round of this many has. */
int capture_ray_count(int rays);

/* Captures one probe at p (world, finite): radiance as it is; normal: NULL, or the unit normal of a
 * surface. Refused: p farther out than 1e15 times the scene's size. Any thread. */
struct error *capture_probe(const struct path_tracer *path, const struct capture_settings *settings,
                            const double p[3], const float *normal, struct capture_probe *result);

/* The same, and by parts of settings->split their light and its error: as many floats of sh each
 * (3 order^2, of a surface 3), one part behind the other. */
struct error *capture_probe_split(const struct path_tracer *path,
                                  const struct capture_settings *settings, const double p[3],
                                  const float *normal, struct capture_probe *result, float *part,
                                  float *part_error);

/* De-rings and convolves what was captured of a point, as the settings say. */
void capture_shape(const struct capture_settings *settings, struct capture_probe *result);

/* Adds the columns that the settings ask for to a probe table, where they are missing. An error
 * where parts of light make a row that no stream holds. */
struct error *capture_add_columns(const struct capture_settings *settings, struct table *table);

/* Bytes of a row of a table, and of what in it is light of parts. */
size_t capture_row_bytes(const struct table *table, size_t *split);

/* For capturing anew. Removes columns that no capture fills unless it is asked to, and those made
 * of the light that was. */
void capture_drop_stale(struct table *table);
/* Makes the light of all rows missing, and what was learned with it: rows that are not captured
 * again must not keep light that the header's settings did not make. */
struct error *capture_forget(struct table *table);
/* The same of what a capture without light makes anew: the columns that are asked for, and with
 * them all that depend on the occlusion settings, which the header tells once. */
struct error *capture_forget_unlit(const struct capture_settings *settings, struct table *table);

/* An error when probes captured so far had other settings or another scene (key scene-key) than
 * `now`, which says what differs. */
struct error *capture_check_same(const struct stream_header *before,
                                 const struct stream_header *now);

/* The name of a material that may be glass, by its name, and is opaque; NULL: none. */
const char *capture_find_pane(const struct scene *scene);

/* Whether nothing in the scene shines: all light that is captured is black. */
bool capture_is_dark(const struct scene *scene);

/* Whether every surface reflects all light: in a closed scene nothing but the number of bounces
 * ends it. */
bool capture_is_white(const struct scene *scene);

/* The rows whose turn it is: those whose number, divided by `parts`, leaves `part`. */
struct capture_slice {
    size_t part, parts; /* part < parts */
    size_t number;      /* of the first row that capture_rows is given */
};

/* How rows are captured, and how many were. */
struct capture_job {
    const struct path_tracer *path;
    const struct capture_settings *settings;
    bool again;                        /* rows that have light already as well */
    const struct capture_slice *slice; /* NULL: all rows; capture_least_order takes them all */
    int threads;
    struct progress *progress; /* may be NULL */
    /* Out, of the last call: */
    size_t captured;
    size_t left; /* were to be, and stay as they are, since a signal came (interrupt.h) */
};

/* Captures the rows first .. first+count-1 whose light is missing (again, or where none is
 * captured: all of them) and which are in the slice, into those of its columns that the table
 * has. */
struct error *capture_rows(struct capture_job *job, struct table *table, size_t first,
                           size_t count);

/* Captures a whole table of points, as capture_rows does, to job->settings->order, the highest, and
 * keeps the least order that loses no more than `loss` of its irradiance (order.h): *order (may be
 * that of the settings themselves); *lost: what it loses. Where a signal came, both stay: a part of
 * the probes does not tell what all need. De-ringing follows the choice. */
struct error *capture_least_order(struct capture_job *job, struct table *table, double loss,
                                  int *order, double *lost);

#endif
