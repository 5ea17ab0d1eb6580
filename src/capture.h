/* capture: the light that reaches a probe, as SH with its error and what the rays learned on the way.
 *
 * The sphere of directions is cut into equal-area cells of a (z, phi) grid; every cell gets two independent
 * uniform samples, so that the variance within the cell, and with it the standard error of each
 * coefficient, is estimated without bias from the sample itself (two per stratum: Cochran, "Sampling Techniques", 1977,
 * sec. 5A.12). Punctual lights enter as deltas in their direction. Sums are in double.
 *
 * N rays make at least N / 2 cells: sqrt(N / 6) rows in z, about 3 times as many columns in phi; capture_ray_count says how
 * many rays that is. A probe's result depends on the scene, the settings and its position alone.
 */
#ifndef CAPTURE_H
#define CAPTURE_H

#include "sh.h"
#include "path.h"

#include <stdbool.h>
#include <stdint.h>

struct error;
struct stream_header;
struct table;

/* What light is captured. ALL = DIRECT + INDIRECT; emitters and sky seen straight from the probe count as direct, and so do
 * point, spot and sun light. */
enum capture_light { CAPTURE_ALL, CAPTURE_DIRECT, CAPTURE_INDIRECT };

enum { CAPTURE_RAYS_MOST = 1 << 24, CAPTURE_BOUNCES_MOST = 1 << 16 };

struct capture_settings {
    int order;              /* 1 .. SH_ORDER_MAX */
    int rays;               /* asked for; rounded up to what the grid of cells needs */
    int bounces;
    enum capture_light light;
    uint64_t seed;
    unsigned columns;       /* CAPTURE_* of the optional columns to write; sh is always written */
};

enum {
    CAPTURE_SH_ERROR = 1,
    CAPTURE_VALIDITY = 2,
    CAPTURE_DEPTH = 4,
    CAPTURE_SKY = 8,
    CAPTURE_DEFAULT = CAPTURE_SH_ERROR | CAPTURE_VALIDITY | CAPTURE_DEPTH | CAPTURE_SKY,
};

/* What one probe learned. */
struct capture_probe {
    float sh[3 * SH_COUNT_MAX];
    float sh_error[3 * SH_COUNT_MAX]; /* standard error of each coefficient */
    float validity;                   /* share of the rays that met a front side, of those that met any; 1 when none did */
    float depth;                      /* harmonic mean distance of the hits, scene units; a ray that escapes counts as 1/inf = 0. 0: nothing was hit */
    float sky;                        /* share of the rays that escaped */
};

struct capture_settings capture_settings_default(void); /* order 3, 512 rays, 64 bounces, all light, seed 0, default columns */

/* As header keys (sh-order, sh-content, capture-rays, capture-bounces, capture-light, capture-seed), and back. */
struct error *capture_settings_to_header(const struct capture_settings *settings, struct stream_header *header);
/* An error when keys make no sense. Missing keys leave the setting as it is. */
struct error *capture_settings_from_header(struct capture_settings *settings, const struct stream_header *header);

/* Whether the header says that probes were captured. */
bool capture_header_has_settings(const struct stream_header *header);

/* How many rays a probe gets. */
int capture_ray_count(const struct capture_settings *settings);

/* Captures one probe at p (world, finite). Any thread. */
void capture_probe(const struct path_tracer *path, const struct capture_settings *settings, const double p[3],
                   struct capture_probe *result);

/* Adds the columns that the settings ask for to a probe table, where they are missing. */
struct error *capture_add_columns(const struct capture_settings *settings, struct table *table);

/* An error when probes captured so far had other settings or another scene (key scene-key) than `now`, which says what differs. */
struct error *capture_check_same(const struct stream_header *before, const struct stream_header *now);

struct progress;

/* Captures the rows first .. first+count-1 whose sh is missing (again: all of them) on `threads` threads, into those of its columns that the
 * table has. *captured: how many were. */
struct error *capture_rows(const struct path_tracer *path, const struct capture_settings *settings, struct table *table,
                           size_t first, size_t count, bool again, int threads, struct progress *progress,
                           size_t *captured);

#endif
