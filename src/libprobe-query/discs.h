/* SPDX-License-Identifier: Apache-2.0 */
/* discs: points on surfaces, each with the disc that it answers for, and which of them cover what.
 *
 *     status = discs_make(&discs, &points);
 *     answer = discs_blend(discs, p, n, falloff, value, width, out);
 *     discs_destroy(discs);
 *
 * Each point is an oriented disc of radius R. It covers a place x with the normal n where n faces
 * as its own does, within 60 degrees, where x is nearer than R, and no farther than R / 4 from its
 * plane: so the sides of a sheet stay apart, and a table's top keeps its light from the floor. Its
 * weight falls to 0 where any of this ends:
 *
 *     (1 - |x - x_p| / R)^1, 2 or 3   (1 - 4 |(x - x_p) . n_p| / R)   (2 n . n_p - 1)
 *
 * Where no disc covers a place, that one answers which would be the first to do so if all grew
 * alike: what is blended stays continuous as the last disc ends. Based on: Bikker and Reijerse, "A
 * precalculated point set for caching shading information", Eurographics short papers, 2009,
 * section 5: a regular grid whose cells name all discs that touch them; a place is looked up in one
 * cell. There, discs stand by the direction of their normals, and those that face elsewhere are
 * passed over.
 *
 * Memory: 40 bytes a point, 4 to 8 for each cell that a disc touches and 4 for each cell, of which
 * there are at most 64 a point. Read-only once made: threads share it.
 */
#ifndef DISCS_H
#define DISCS_H

#include "probe-query.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct discs;

struct disc_points {
    size_t count;
    const double *position; /* 3 a point */
    const float *normal;    /* 3 a point, unit */
    const float *radius;    /* of its disc, above 0; NaN: it has none, and answers nothing */
};

/* Not PROBE_OK: no point has a disc (PROBE_NO_DISCS), discs are too far from one another
 * (PROBE_DISCS_APART) or too large for that (PROBE_DISCS_LARGE), memory. The points are not needed
 * afterwards. */
enum probe_status discs_make(struct discs **discs, const struct disc_points *points);

/* A disc as packed files hold it. Lengths are in cells, positions from the origin of the grid, so
 * that floats hold them well. */
struct disc {
    float position[3], normal[3];
    float inverse;  /* of the radius */
    uint32_t point; /* whose value it has */
};

/* The grid of cubes that they are found in. */
struct discs_grid {
    double origin[3], scale; /* cells a unit */
    int32_t cells[3];
};

const struct discs_grid *discs_grid_of(const struct discs *discs);
const struct disc *discs_list(const struct discs *discs, size_t *count); /* in their order */
size_t discs_bytes(const struct discs *discs); /* that they hold, but for a list of others */

/* The same discs again, of such a list, which must outlive them, and grid: they answer to the bit
 * as those did. Nothing of it is trusted. PROBE_BAD_IMAGE: there is no such grid;
 * PROBE_BAD_DISC: *row is no disc in it. */
enum probe_status discs_make_again(struct discs **discs, const struct disc *list, size_t count,
                                   const struct discs_grid *grid, size_t *row);
void discs_destroy(struct discs *discs); /* NULL is legal */

enum discs_answer {
    DISCS_COVERED,
    DISCS_NEAREST, /* no disc covers the place: one answers */
    DISCS_NONE,    /* no point faces alike; out is not set */
};

/* Blends the values, `width` a point, of the discs that cover a place p (finite), on a side whose
 * unit normal is n. falloff: 1, 2 or 3. */
enum discs_answer discs_blend(const struct discs *discs, const double p[3], const double n[3],
                              int falloff, const float *value, size_t width, float *out);

/* What a surface of probe-query.h is made of; irradiance: 3 a point of its discs. */
struct probe_surface;
const struct discs *surface_discs(const struct probe_surface *surface, const float **irradiance);

enum { DISCS_FLAT = 16 };

/* For who has another way where no disc covers the place. Discs are flatter: R / DISCS_FLAT, not
 * R / 4, off their planes, so that sheets one behind the other stay apart. Falloff is linear; of
 * discs of several sizes the finer ones count more, by 1 / R^2. discs_covers tells whether any
 * does. discs_cover blends 3 values a point; false: none covers the place, out is 0. discs_draw
 * gives one of the points that it would blend, each with the chance that is its weight, by u,
 * uniform in [0, 1); UINT32_MAX: none. discs_nearest gives the one point that answers for the
 * place whether its disc covers that or not: of the least distance, in its radii, with what the
 * place is off its plane, 64 times but at most 2 radii, and twice what the cosine of the normals
 * lacks; UINT32_MAX: no point faces alike. */
bool discs_covers(const struct discs *discs, const double p[3], const double n[3]);
bool discs_cover(const struct discs *discs, const double p[3], const double n[3],
                 const float *value, float out[3]);
uint32_t discs_draw(const struct discs *discs, const double p[3], const double n[3], float u);
uint32_t discs_nearest(const struct discs *discs, const double p[3], const double n[3],
                       float *distance);

/* Brings nearer what lookups at `count` places, 64 at the most, are going to read, where most
 * are far from the ones before them: done for all first, they need not wait for memory one by one.
 * p and n: each begins `stride` doubles behind the last. */
void discs_fetch(const struct discs *discs, size_t count, const double *p, const double *n,
                 size_t stride);

#endif
