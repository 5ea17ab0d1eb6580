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
 * Over cells these are means over the free space of the hull: of points of each cell, that are not
 * inside solids. What sees a probe is in free space, since probes are; the rest is asked of
 * place_inside, and is matter as well where it sees no probe around and its space is narrower than
 * UNSEEN_NARROW of the mean distance between probes (narrow.h), as the void within a wall; a room
 * that no probe is in is wider than that, and counts. They are measured of a blend of all of a
 * cell's probes, and of the blend as it is, by what points see of them where that is known
 * (baked.h): the certificate that probe-leakfix and probe-error print.
 *
 * A cell has points by its size, and no fewer than a least number: those of the additive sequence
 * of three dimensions' golden ratio (Roberts, "The unreasonable effectiveness of quasirandom
 * sequences", 2018), from a random start in each cell. Where no surface is as near to a corner of
 * the cell as its farthest other corner, all is seen, and no ray goes. Each cell is a stratum: the
 * errors of the totals are those of stratified ratios (Cochran, "Sampling techniques", 1977, sec.
 * 6.11), which takes the points for random ones and is too wide rather than too narrow. Intervals
 * are Wilson's (1927) with that variance, and with as many points as weigh as much as those have
 * where surfaces are: where none of n points leaks, the share may still be 3.84 / n; where there
 * are no surfaces, it is 0 (ratio.h).
 */
#ifndef UNSEEN_H
#define UNSEEN_H

#include "measure/bootstrap.h"
#include "measure/sphere.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define UNSEEN_NARROW 0.25

struct baked;
struct error;
struct place_judge;
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

/* Over all cells, of one blend. Shares are from 0 to 1, light is luminance of irradiance. */
struct unseen_blend {
    /* share of weight by volume; of light: NaN where a probe has none */
    struct estimate weight, light;
    /* of E_leak, over free space that is not blind and over the directions; NaN without light */
    double leaked_rms, leaked_bias;
    double blind; /* share of free space that sees none of the blended probes */
    /* the cell that most leaks in: of all light, where it is known, or weight */
    size_t worst_cell;
    double worst_share;    /* of the cell's weight, unseen; 0: nothing leaks */
    double worst_part;     /* of all that leaks, in this cell */
    double worst_point[3]; /* of the cell's points, that which sees least */
};

struct unseen_cells {
    struct unseen_blend all, now; /* of all probes of a cell; as it is */
    bool differ;                  /* the blend goes by what is seen */
    double lost; /* share of free space that sees no probe around at all (seen_nearest) */
    double free_volume;
    size_t points; /* taken */
    size_t near;   /* cells that a surface may be in */
    /* owned, by cell, of the blend as it is: share of weight; rms of E_leak; share that is free
     * space. 0 where no point is free */
    float *cell_weight, *cell_leak, *cell_free;
};

/* A point of a cell from which less than all is seen of what it is blended of. */
struct unseen_point {
    double position[3];
    size_t cell;
    double volume; /* that it stands for */
    double weight; /* unseen */
};

struct unseen_settings {
    int least;     /* points of each cell; 2 or more */
    double points; /* of all cells that a surface may be in, about, shared by their sizes */
    uint64_t seed;
    int threads;
    /* tells what is inside of solids: *judge is made where it is needed and not there yet; the
     * caller's. NULL: for this alone */
    struct place_judge **judge;
    /* called for each free point that does not see all of its blend, in order; NULL: nobody asks */
    struct error *(*keep)(void *context, const struct unseen_point *point);
    void *context;
};

/* Looks from points of cells, which are tetrahedra, triangles (their area is the volume) or
 * segments (their length). Errors: there are no cells, the cell is a point, what `keep` says. The
 * result does not depend on the threads. */
struct error *unseen_cells(struct unseen_cells *cells, const struct tracer *tracer,
                           const struct baked *baked, const struct unseen_settings *settings);
void unseen_cells_clear(struct unseen_cells *cells);

/* Adds their figures, of `all` as it is, of `all-probes` where the blend goes by what is seen;
 * light also relative to the mean irradiance, where the report has that already. */
struct error *unseen_report(struct report *report, const struct unseen_cells *cells, size_t count);

/* NULL, or the error (error_above) that says the figure and the worst cell where the upper end of
 * light that leaks, or where light is not known, of unseen weight, is above `most`. Of a report
 * that unseen_report was called for. */
struct error *unseen_gate(const struct report *report, double most);

#endif
