/* SPDX-License-Identifier: Apache-2.0 */
/* poisson: points on the surfaces that light gets to, denser where that is asked for.
 *
 *     struct poisson set = {0};
 *     err = poisson_make(&set, &path, &settings);          radii are given
 *     err = poisson_make_count(&set, &path, &settings, n); or found for n points at the most
 *     ... set.point[i] ...
 *     poisson_clear(&set);
 *
 * Darts are the places where particles of light arrive (particles.h), and those where rays by the
 * cosine from there meet a surface: no light gets from elsewhere. So nothing needs to be known of
 * solids, and what is closed off stays empty. Based on: Bikker and Reijerse, "A precalculated point
 * set for caching shading information", Eurographics short papers, 2009, section 3.
 *
 * Where a dart lands, rays by the cosine tell the share of directions that nothing occludes, and
 * what that is to say decides the radius there; where it was thrown from far from where particles
 * came, and surfaces on the way keep most of the light, the radius is larger. It is kept unless a
 * point that faces alike (normals within 60 degrees) stands within that radius. Nearer than the
 * least radius it never is, and farther than the greatest one it always is, without those rays.
 * Where points get finer, a point holds others off no farther than twice its own radius, and that
 * is never more than the distance to the nearest that faces alike: so any place that is lit is
 * within twice the radius of a point of its surface, once darts find no room (interpolate/discs.h),
 * and no point is within the radius of another.
 *
 * Darts are numbered; of two that do not go together the one with the lower number stays. The set
 * is the same for any number of threads.
 */
#ifndef POISSON_H
#define POISSON_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct path_tracer;

/* What the radius follows, between the least and the greatest. */
enum poisson_steer {
    POISSON_AO,       /* the share of directions that is open: least where none is */
    POISSON_GRADIENT, /* where that changes by a quarter within `distance` or less: greatest */
    POISSON_DEPTH,    /* the harmonic mean distance that is seen; `distance` or more: greatest */
    POISSON_NONE,     /* nothing: greatest everywhere */
};

enum { POISSON_RAYS_MOST = 4096 };

struct poisson_point {
    struct vec3 position; /* off the surface by what rays need to start on its side */
    struct vec3f normal;  /* unit, of the side that is lit */
    float radius;
    float ao; /* the open share, by the cosine */
};

struct poisson_settings {
    double least, most; /* radii, above 0; units of the scene, and so is: */
    double distance;    /* occlusion counts within it */
    enum poisson_steer steer;
    int rays;           /* of occlusion, from each place; POISSON_RAYS_MOST at the most */
    int particles;      /* of light, at the most at a time */
    int bounces;        /* of theirs */
    int misses;         /* the end: darts of particles for one that is kept, of as many as points */
    size_t points_most; /* with those that are kept: */
    /* points that stay, the first of the set; radii above the greatest become that, and NaN does */
    const struct poisson_point *kept;
    size_t kept_count; /* below points_most */
    uint64_t seed;
    int threads;
};

/* Starts as {0}. */
struct poisson {
    struct poisson_point *point; /* owned; in the order in which they were kept */
    size_t count;
    double least, most;   /* radii that were used */
    size_t darts, tested; /* that landed; and those of them whose occlusion was asked for */
    int tries;            /* radii that were tried */
    bool full;            /* there are points_most, and room for more */
};

/* Error: no light gets to any surface, memory, a signal (interrupt.h). */
struct error *poisson_make(struct poisson *set, const struct path_tracer *path,
                           const struct poisson_settings *settings);

/* With the least radii that make at most `count` points, kept ones too, up to some 3 %: settings'
 * radii tell their ratio alone. */
struct error *poisson_make_count(struct poisson *set, const struct path_tracer *path,
                                 const struct poisson_settings *settings, size_t count);

void poisson_clear(struct poisson *set);

#endif
