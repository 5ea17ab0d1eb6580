/* SPDX-License-Identifier: Apache-2.0 */
/* unseen: how much of the light that a point takes from probes comes from those that it cannot see.
 *
 * A point p takes light from probes i with weights w_i that sum to 1; v_i is the share of light
 * that gets from p to probe i (1: seen, 0: behind a wall). The share of weight that comes from
 * unseen probes is u(p) = sum w_i (1 - v_i); of light, with b_i the brightness of a probe (its mean
 * irradiance), sum w_i (1 - v_i) b_i / sum w_i b_i. What leaks is the difference that they make:
 *
 *     E_leak(n) = sum w_i E_i(n) - sum w_i v_i E_i(n) / sum w_i v_i
 *
 * A point that sees none of its probes is blind: all its light is from unseen probes, and what
 * leaks is not known.
 *
 * The weights are the barycentric ones of the cell around p, whatever way light is interpolated.
 *
 * Over cells these are means over free space: random points, spread evenly over each cell, that are
 * not inside solids. What sees a probe is in free space, since probes are; the rest is asked of
 * place_inside. Each cell is a stratum: the errors of the totals are those of stratified ratios
 * (Cochran, "Sampling techniques", 1977, sec. 6.11).
 */
#ifndef UNSEEN_H
#define UNSEEN_H

#include "measure/bootstrap.h"
#include "measure/sphere.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct baked;
struct error;
struct probe_place;
struct report;
struct seen_look;
struct tracer;

struct unseen {
    double weight;        /* u(p) */
    double light, bright; /* sum w_i (1 - v_i) b_i, and sum w_i b_i */
    bool blind;
    /* luminance of E_leak; 0 where nothing leaks or the point is blind */
    double leak[SPHERE_COUNT];
};

/* What of a point's light comes from where it cannot see: of its place, and what it sees of that.
 * basis: of the baked stream. Any thread. */
void unseen_of(const struct baked *baked, const struct sphere_basis *basis,
               const struct probe_place *at, const struct seen_look *look, struct unseen *unseen);

/* Over all cells. Shares are from 0 to 1, light is luminance of irradiance. */
struct unseen_cells {
    struct estimate weight, light; /* shares by volume, and weighted by light */
    /* of E_leak, over free space that is not blind and over the directions */
    double leaked_rms, leaked_bias;
    double blind;      /* share of free space */
    size_t worst_cell; /* with the largest share */
    /* owned, by cell: share of weight; rms of E_leak; share that is free space. 0 where no point is
     * free */
    float *cell_weight, *cell_leak, *cell_free;
    double free_volume;
};

/* Looks from `samples` (2 or more) points of each cell, which are tetrahedra (error: they are not).
 * The result does not depend on the threads. */
struct error *unseen_cells(struct unseen_cells *cells, const struct tracer *tracer,
                           const struct baked *baked, int samples, uint64_t seed, int threads);
void unseen_cells_clear(struct unseen_cells *cells);

/* Adds their figures; light also relative to the mean irradiance, where the report has that
 * already. */
struct error *unseen_report(struct report *report, const struct unseen_cells *cells, size_t count);

#endif
