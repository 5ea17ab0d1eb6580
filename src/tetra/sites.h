/* SPDX-License-Identifier: Apache-2.0 */
/* sites: the places of probes on the lattice (lattice.h), each once, in canonical order, and what
 * they span.
 *
 * The order is that of a Hilbert curve (Skilling, "Programming the Hilbert curve", 2004) over the
 * lattice: whatever order the probes came in, the same places come out in the same order, and
 * neighbours stand near each other in memory. Probes on one site, or nearer to each other than is
 * asked for, are merged: one of them, chosen by what it is and not by where it stands in the
 * stream, represents the others.
 *
 * What spans space only by the noise of numbers does not span it: sites within a tolerance of a
 * plane, a line or a point are taken to lie in it. It is the merging distance, four steps of the
 * lattice, or four units in the last place of the largest coordinate, whichever is the most.
 */
#ifndef SITES_H
#define SITES_H

#include "libprobe-query/lattice.h"

#include <stddef.h>
#include <stdint.h>

struct error;

struct sites {
    struct lattice lattice;
    double *site; /* 3 * count: whole numbers; owned */
    int32_t *row; /* count: the probe that stands for each; owned */
    size_t count;
    /* of each probe: the one that represents it, or -1; NULL where none is merged; owned */
    int32_t *merged;
    size_t merged_count;
    int corners; /* of a cell of what they span: 4 space, 3 a plane, 2 a line, 1 a point */
    /* of a plane or line: the axes that it is projected along, such that no two sites fall
     * together */
    int axis[2];
    /* `corners` sites that span it as widely as is found by going for the farthest */
    size_t extreme[4];
};

struct sites_settings {
    double merge; /* probes nearer than this share of the box's largest side are merged */
    /* light_width * count, or NULL: a probe whose light is known (not NaN) goes before one
     * without */
    const float *light;
    size_t light_width;
    int threads;
};

/* Errors: no probe, one that is not finite. */
struct error *sites_make(struct sites *sites, size_t count, const double *position,
                         const struct sites_settings *settings);
void sites_clear(struct sites *sites);

/* The axes to project a plane's (corners 3) or a line's (2) sites along: those it faces least, z
 * dropped first where it hardly matters. Turns clockwise or not as the plane lies. */
void sites_axes(size_t count, const double *site, int corners, int axis[2]);

/* Four sites that span as widely as is found by going for the farthest. */
void sites_extremes(size_t count, const double *site, size_t extreme[4]);

/* A matrix that makes a plane's projection along its axes as it is in space, up to a rotation: the
 * Cholesky factor of its metric. */
void sites_metric(size_t count, const double *site, const int axis[2], double metric[2][2]);

/* Six times the volume of a cell (twice the area of its projection, its length along the axis, 1),
 * exactly and signed. */
lattice_volume sites_volume(int corners, const int axis[2], const double *const p[4]);

#endif
