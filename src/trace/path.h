/* SPDX-License-Identifier: Apache-2.0 */
/* path: the light that comes to a point, by path tracing.
 *
 * Unbiased Monte Carlo of the rendering equation for Lambertian surfaces (Kajiya 1986):
 * cosine-distributed continuation; at every scattering one light of the tree (lights.h), one
 * direction of an uneven sky picture (sky.h) and every sun is asked; multiple importance sampling
 * between the ways to reach an emissive surface or the sky (Veach 1997, balance heuristic); Russian
 * roulette by throughput. What a scene does not have is not asked for.
 *
 * Paths go in waves, each stage of all of them before the next stage of any: while one path's
 * arithmetic waits for its operands, or for memory, another's is done, and Embree has many rays in
 * a row.
 *
 * A receiver is a point that takes light from the whole sphere, or a surface that takes it from its
 * half. Its light straight from emissive surfaces and from an uneven sky comes in two parts, whose
 * expectations add up: what its own rays meet, and what path_lights and path_skies find. Light
 * straight from point, spot and sun lights is the caller's.
 */
#ifndef PATH_H
#define PATH_H

#include "math/direction.h"
#include "math/random.h"
#include "trace/cache.h"
#include "trace/lights.h"
#include "trace/sky.h"
#include "trace/split.h"

struct path_tracer {
    const struct tracer *tracer;
    struct lights lights;
    struct sky sky;
    struct path_sun *suns; /* owned */
    size_t sun_count;
    bool emissive; /* the tree holds emissive surfaces */
    bool sky_shines;
    int bounces;                    /* how often a path may scatter */
    const struct path_cache *cache; /* borrowed; NULL: none (path_use_cache) */
    const struct split *split;      /* borrowed; NULL: none (path_use_split) */
    const struct lit *lit;          /* borrowed; NULL: none (path_use_lit) */
    struct path_tracer *next;       /* the same of tracer->next; owned */
    struct once *started;           /* what path_near starts; owned; NULL: it was from the start */
};

/* How a receiver's directions are drawn, against which light that it could meet both ways is
 * weighted. */
struct path_receiver {
    /* local; normal zero: the whole sphere, uniformly; else the half about it, by the cosine */
    struct lights_receiver at;
    float lights_share, sky_share; /* questions of path_lights and path_skies for each sample */
    bool lit; /* sunlit points of the cache are asked for (path_lit): rays leave them their share */
};

/* What comes along one direction of a receiver. */
struct path_sample {
    struct vec3f straight;  /* radiance of the emissive surface or sky that the ray meets */
    float weight;           /* of that, against path_lights or path_skies */
    struct vec3f scattered; /* radiance that the surface there scatters towards the receiver */
    bool hit, front;        /* what the ray met */
    float distance;         /* local units; INFINITY where it met nothing */
    struct vec3f normal;    /* unit, of the surface there; 0 where it met nothing */
    /* Of a cache without values: the disc where the path ended; share / pi times its irradiance is
     * to be added to scattered */
    struct cache_link link;
    int scatters;  /* on the link's way */
    bool compared; /* with what a cache says (its check) */
};

/* What one question to the lights or the sky found. */
struct path_found {
    struct vec3f direction; /* unit */
    /* radiance over the density per solid angle of both ways together (share times its own, and the
     * receiver's): to be summed over all questions and divided by the number of samples; 0: none */
    struct vec3f light;
    size_t group; /* whose light it is, where the tracer has groups */
};

struct error *path_init(struct path_tracer *path, const struct tracer *tracer, int bounces);
void path_clear(struct path_tracer *path);

/* Lets paths of a tracer and of those that follow it end in a cache, which is to outlive that;
 * NULL: in none. Not while they are used. */
void path_use_cache(struct path_tracer *path, const struct path_cache *cache);

/* Lets a tracer and those that follow it split light into parts, where path_samples_split asks
 * for that; NULL: into none. No light that is kept in a cache can be split. */
void path_use_split(struct path_tracer *path, const struct split *split);

/* Lets receivers look for light with these points, which are to outlive that; NULL: with none. */
void path_use_lit(struct path_tracer *path, const struct lit *lit);

/* Of a path tracer and those that follow it, the one to use for what p sees (trace_find_near), made
 * now if nobody was there before. */
struct error *path_near(const struct path_tracer *paths, const double p[3],
                        const struct path_tracer **near);

enum { PATH_WAVE = TRACE_WAVE }; /* paths that go together */

/* A receiver's own rays; borrowed. */
struct path_rays {
    size_t count; /* at most PATH_WAVE */
    const struct vec3f *direction;
    const struct random *random; /* of each ray */
    bool straight_alone;         /* scattered is 0 then, and costs nothing */
};

/* What comes along each ray. */
void path_samples(const struct path_tracer *path, const struct path_receiver *receiver,
                  const struct path_rays *rays, struct path_sample *sample);

/* The same, and in `split`, which was started, what is scattered by parts. */
void path_samples_split(const struct path_tracer *path, const struct path_receiver *receiver,
                        const struct path_rays *rays, struct path_sample *sample,
                        struct split_light *split);

/* Points of the unit square, uniform, by which lights or sky are drawn; borrowed. */
struct path_draws {
    size_t count; /* at most PATH_WAVE */
    const float *x;
    const double *y;
    const struct random *random; /* of each point, for what else is drawn */
};

/* Asks once a draw for the emissive surfaces (needs path->emissive) or the sky (needs
 * path->sky.rows). */
void path_lights(const struct path_tracer *path, const struct path_receiver *receiver,
                 const struct path_draws *draws, struct path_found *found);
void path_skies(const struct path_tracer *path, const struct path_receiver *receiver,
                const struct path_draws *draws, struct path_found *found);

/* Asks once a direction whether it goes to the sky. light: its radiance. */
void path_open(const struct path_tracer *path, const struct path_receiver *receiver,
               const struct path_rays *rays, struct path_found *found);

/* Asks for points that are lit, once for each x in [0, 1), with what lit_weigh added up.
 * light: solid angle times radiance, over the probability. cluster: of each point. */
void path_lit(const struct path_tracer *path, const struct lit *lit,
              const struct path_receiver *receiver, const double *sum, size_t count,
              const double *x, const struct random *random, struct path_found *found,
              size_t *cluster);

/* What path_lights would find in the mean if nothing stood between. draws->random is not used.
 * Where all points that are drawn are dark, it is what the pictures that they are points of shine
 * in the mean, in grey, and *sparse is true: it is found at few points. */
struct vec3f path_lights_unshadowed(const struct path_tracer *path,
                                    const struct path_receiver *receiver,
                                    const struct path_draws *draws, bool *sparse);

/* For each group of the tracer what questions to its emissive surfaces alone would find in the mean
 * if nothing stood between, 3 a group, by the middle of each surface, or of some where there are
 * many; and the share of questions that go to it. Both are set. */
void path_groups_unshadowed(const struct path_tracer *path, const struct path_receiver *receiver,
                            const struct path_draws *draws, double *mean, double *share);

#endif
