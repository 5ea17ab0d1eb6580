/* capture: the light that reaches a probe, as SH with its error and what the rays learned on the way.
 *
 * The sphere of directions is cut into equal-area cells of a (z, phi) grid; every cell gets two independent
 * uniform samples, so that the variance within the cell, and with it the standard error of each
 * coefficient, is estimated without bias from the sample itself (two per stratum: Cochran, "Sampling Techniques", 1977,
 * sec. 5A.12). Punctual lights enter as deltas in their direction. Sums are in double.
 *
 * A probe's result depends on the scene, the settings and its position alone.
 */
#ifndef CAPTURE_H
#define CAPTURE_H

#include "sh.h"
#include "trace.h"

#include <stdint.h>

struct error;
struct stream_header;
struct table;

struct capture_settings {
    int order;              /* 1 .. SH_ORDER_MAX */
    int rays;               /* asked for; rounded up to what the grid of cells needs */
    int bounces;
    enum trace_light light;
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

struct capture_settings capture_settings_default(void); /* order 3, 512 rays, 64 bounces, all, seed 0, all columns */

/* As header keys (sh-order, sh-content, capture-rays, capture-bounces, capture-light, capture-seed, capture-columns), and back. */
struct error *capture_settings_to_header(const struct capture_settings *settings, struct stream_header *header);
/* An error when the header has no captured probes or the keys make no sense. */
struct error *capture_settings_from_header(struct capture_settings *settings, const struct stream_header *header);

/* Captures one probe at p (world, finite). Any thread. */
void capture_probe(const struct tracer *tracer, const struct capture_settings *settings, const double p[3],
                   struct capture_probe *result);

/* Adds the columns that the settings ask for to a probe table, where they are missing. */
struct error *capture_add_columns(const struct capture_settings *settings, struct table *table);

struct progress;

/* Captures the rows first .. first+count-1 whose sh is missing (again: all of them) on all threads. *captured (may be NULL): how many were. */
struct error *capture_rows(const struct tracer *tracer, const struct capture_settings *settings, struct table *table,
                           size_t first, size_t count, bool again, int threads, struct progress *progress,
                           size_t *captured);

#endif
