/* SPDX-License-Identifier: Apache-2.0 */
/* lit: places of surfaces that a sun shines on, to be asked for what they scatter.
 *
 * A sun's patches are small, bright and seen by few rays of a probe. Particles from the suns
 * (particles.h) leave points there, each with its share of the sun's flux, which stands for the
 * light of about that much of surface: a probe that asks for points by flux and 1 / d^2 finds all
 * of them with few questions. The kernel is blunt: a point at distance d counts d^2 / (d^2 + d0^2)
 * of what it scatters, d0 some distances between points, and a ray that meets a sunlit surface
 * counts the rest there; both together are the whole, and neither is ever great. Based on: Keller,
 * "Instant radiosity", SIGGRAPH 1997.
 *
 * Neighbours stand in blocks, and these in clusters; a receiver weighs clusters, and then the
 * blocks of one that was drawn, so that there may be many points.
 */
#ifndef LIT_H
#define LIT_H

#include "trace/lights.h"
#include "trace/sky.h"

struct error;
struct lit;

/* Where particles come from, borrowed. */
struct lit_sources {
    const struct tracer *tracer;
    const struct lights *lights;
    const struct sky *sky;
};

/* `count` particles, as many of each sun, and their hits. NULL, without an error: there are
 * none. */
struct error *lit_create(struct lit **lit, const struct lit_sources *from, size_t count,
                         uint64_t seed, int threads);
void lit_destroy(struct lit *lit); /* NULL is legal */

/* Whether the points are in local coordinates of this tracer. */
bool lit_is_of(const struct lit *lit, const struct tracer *tracer);

/* The share that points count of sunlight which a surface scatters, at that distance (local, as
 * all here). */
float lit_share(const struct lit *lit, float distance);

size_t lit_clusters(const struct lit *lit);

/* What a receiver would get of all clusters if nothing stood between, added up one by one: sum has
 * room for lit_clusters. The last is 0: nothing. */
void lit_weigh(const struct lit *lit, const struct lights_receiver *receiver, double *sum);

struct lit_point {
    size_t cluster;
    struct vec3f position, normal; /* off the surface, on its lit side */
    struct vec3f light; /* solid angle times radiance that it brings, over its probability */
};

/* Weighs them for questions that are to learn: half by that, half alike, so that those of a sun
 * that is dim beside another are asked, too. spread has room for lit_clusters. */
void lit_spread(const struct lit *lit, const double *sum, double *spread);

/* Weighs them anew, by how many of the questions that were asked of each were answered (`seen` of
 * `asked`), for other questions than those. */
void lit_learn(const struct lit *lit, const uint32_t *asked, const uint32_t *seen, double *sum);

/* Draws a point by x, uniform in [0, 1), with what was added up. False: it brings nothing; of the
 * point, cluster is set. */
bool lit_draw(const struct lit *lit, const struct lights_receiver *receiver, const double *sum,
              double x, struct lit_point *point);

#endif
