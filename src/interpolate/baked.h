/* SPDX-License-Identifier: Apache-2.0 */
/* baked: the light of a baked stream at any point, and which probes it comes from.
 *
 *     struct baked baked;
 *     err = baked_open(&baked, stream, &settings);
 *     struct probe_place place = {.cell = PROBE_COLD};
 *     baked_locate(&baked, p, &place);
 *     err = baked_light(&baked, p, &place, sh);
 *
 * Everything that measures or shows a stream's light asks through here, so what it sees is what
 * probe-query answers (interpolate.h). Read-only once it is open: threads share it, each with
 * places of its own.
 *
 * A place has the probes and barycentric weights of the cell around the point, in every way of
 * interpolation: a way that takes light from probes without cells is held against the stream's
 * cells all the same, where it has any.
 */
#ifndef BAKED_H
#define BAKED_H

#include "interpolate/interpolate.h"
#include "libprobe-query/sh.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct stream;

struct baked {
    struct interpolate *in; /* owned; NULL: probes alone */
    struct probe_mesh mesh; /* the stream's cells; corners 0: there are none */
    /* of the mesh; owned where there is no interpolation, or it has none of its own */
    struct probe_volume *cells;
    /* the same without the sight that the stream's cells keep; owned; NULL: they keep none */
    struct probe_volume *blind_cells;
    size_t probe_count;
    const double *position; /* 3 a probe; this and what follows is borrowed from the stream */
    const float *sh;        /* width values a probe */
    const float *sh_error;  /* as many; NULL: not known */
    size_t width;
    int order;
    bool convolved; /* sh holds irradiance */
};

/* settings: NULL for probe-query's defaults; their column is sh, whatever they say. The stream must
 * outlive it. Errors: no light (says to run probe-capture), no cells where the way of interpolation
 * needs them (says to run probe-tet), and interpolate.h's. */
struct error *baked_open(struct baked *baked, const struct stream *stream,
                         const struct interpolate_settings *settings);

/* For the light of single probes: without cells, and without light anywhere else. */
struct error *baked_open_probes(struct baked *baked, const struct stream *stream);

/* For cells and what they see: without light anywhere but at the probes, where there is any (else
 * sh is NULL, width 0). Errors: no cells. */
struct error *baked_open_cells(struct baked *baked, const struct stream *stream);

void baked_close(struct baked *baked);

/* Whether light is known at every point; error: of a probe it is not. */
struct error *baked_complete(const struct baked *baked);

/* The place of a point (finite). place->cell: where to look first, or PROBE_COLD. Without cells all
 * weights are 0. Where cells or baked->in have a sight, weights are of what is seen. */
void baked_locate(const struct baked *baked, const double p[3], struct probe_place *place);

/* Whether places have the weights of what is seen. */
bool baked_sees(const struct baked *baked);

/* The same, whatever is seen: of the cell. */
void baked_locate_cell(const struct baked *baked, const double p[3], struct probe_place *place);

/* Whether light is blended with a place's weights, so that other weights give other light. */
bool baked_blends(const struct baked *baked);

/* The light at a point whose place was found: sh[3 * order * order]. Error: one of the probes has
 * no light. */
struct error *baked_light(const struct baked *baked, const double p[3],
                          const struct probe_place *place, double *sh);

/* Irradiance (RGB) at p on a surface with the unit normal n, of what is baked_complete. *place: as
 * for baked_locate. Bands that were cut off can make irradiance negative: it is 0 there. */
void baked_irradiance(const struct baked *baked, struct probe_place *place, const double p[3],
                      const double n[3], double rgb[3]);

/* The same from one probe alone; one without light is dark. */
void baked_probe_irradiance(const struct baked *baked, size_t probe, const double n[3],
                            double rgb[3]);

/* Luminance of a probe's mean irradiance over all directions. */
double baked_brightness(const struct baked *baked, int32_t probe);

/* Variance of the blend's irradiance by its probes' noise, in the mean over all directions: sum of
 * w^2 A_l^2 Var L_lm / 4 pi, luminance, as if the three colours had the same noise, as nearly white
 * light has. NaN where a probe's is not known, and where light is not blended with the place's
 * weights: in other ways than interpolate_barycentric. */
double baked_noise(const struct baked *baked, const struct probe_place *place);

#endif
