/* SPDX-License-Identifier: Apache-2.0 */
/* dering: light that SH make negative, mended by the least window that each probe needs.
 *
 * What is projected to a few bands rings: where a small light dominates, the sum of what is left
 * falls below zero on its far side. A window damps the bands. One for all probes blurs those that
 * do not ring as well; here each probe gets its own, as little as keeps its minimum over all
 * directions above a floor (after Sloan, "Deringing spherical harmonics", SIGGRAPH Asia 2017), and
 * a probe that does not ring keeps every bit.
 *
 * The window is that of Abel and Poisson, band l times r^l, 0 <= r <= 1; one r for all three
 * colours, so that no colour fringe appears. A sum of SH windowed so is the harmonic function that
 * continues it into the ball, on the sphere of radius r. So (maximum principle) its minimum only
 * rises as r falls, up to the mean at r = 0: the set of r that keep the floor is an interval from
 * 0, its end is found by bisection, and a second pass finds nothing to do. Of a delta light's
 * irradiance at order 3 it takes 13 % (RMS over directions; r^2 = 56/75); the least Gaussian window
 * that does as much takes 19, that of least bending energy, 1 / (1 + t l^2 (l+1)^2), 42, those of
 * Hann and Lanczos 49.
 *
 * The minimum is found rigorously: see dering_is_above. Floors and tolerances are shares of the
 * mean over directions, colour by colour. A probe that is changed has the least of its colours
 * between DERING_TOLERANCE / 2 and DERING_TOLERANCE above the floor; what is within
 * DERING_TOLERANCE / 4 above it may count as ringing. A probe that rings takes 1 to 9 ms.
 */
#ifndef DERING_H
#define DERING_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct stream_header;
struct table;

#define DERING_TOLERANCE 1e-3
#define DERING_FLOOR_MOST 0.99

/* What must stay above the floor. Radiance that does makes irradiance that does. */
enum dering_target { DERING_NONE, DERING_IRRADIANCE, DERING_RADIANCE };

struct dering_settings {
    enum dering_target target;
    double floor; /* share of the mean over directions, 0 .. DERING_FLOOR_MOST */
};

/* The header key sh-dering: "irradiance 0", the target and the floor; none where nothing is to be
 * done. */
struct error *dering_to_header(const struct dering_settings *settings,
                               struct stream_header *header);
struct error *dering_from_header(struct dering_settings *settings,
                                 const struct stream_header *header);

/* Whether f, the coefficients of one channel (n^2), is at least `level` in all directions: true
 * proves that it is; where its minimum is at least level + slack, it is true, but for a limit of
 * work that light of a mean above 0 does not meet. */
bool dering_is_above(int order, const double *f, double level, double slack);

/* The r of the least window for a probe's sh (3 n^2), a whole multiple of 2^-24; 1: it does not
 * ring; less than 0: no window can keep it above the floor, since its mean is below 0. convolved:
 * sh is irradiance. Radiance of irradiance: order 3 at the most (content.h). */
double dering_window(const struct dering_settings *settings, int order, bool convolved,
                     const float *sh);

/* Windows one probe: its coefficients, their standard error and gradient (as in content_convolve;
 * NULL: not there), r taken as fixed. */
void dering_apply(int order, double r, float *sh, float *error, float *gradient);

/* What a table's probes needed. */
struct dering_count {
    size_t probes; /* that have light */
    size_t changed;
    size_t hopeless; /* left as they are: no window helps */
    double least;    /* r; 1 where none was changed */
};

/* Windows the probes of a table, and keeps r (times what it was before) in its column sh_window. */
struct error *dering_table(struct table *probes, const struct dering_settings *settings,
                           bool convolved, int threads, struct dering_count *count);

/* Counts from the column sh_window. */
void dering_count_add(struct dering_count *count, const struct table *probes);

#endif
