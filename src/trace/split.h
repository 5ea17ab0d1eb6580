/* SPDX-License-Identifier: Apache-2.0 */
/* split: light by the parts where it comes from, found by the same paths as all of it.
 *
 * Light transport is linear: what a path brings is a sum over the lights where it ends, and is
 * added, beside the sum, to the part of each (Akenine-Moeller et al., "Real-time rendering", 4th
 * ed., eq. 11.36 and sec. 11.5.3). Parts are, in this order:
 *
 *     groups of the scene's lights (scene/groups.h), which add up to all light;
 *     the response to each SH function Y_j of the radiance of a distant sky, whether the scene has
 *     one or not: a path of throughput b that escapes along w adds b Y_j(w);
 *     the response to suns of irradiance 1 on a surface that faces them;
 *     the response to point lights of radiant intensity 1 (Kristensen, Akenine-Moeller, Jensen,
 *     "Precomputed local radiance transfer for real-time lighting design", SIGGRAPH 2005).
 */
#ifndef SPLIT_H
#define SPLIT_H

#include "scene/groups.h"
#include "trace/trace_local.h"

/* What is asked for; all of it borrowed. */
struct split {
    const struct group_map *groups; /* NULL: none */
    int sky_order;                  /* of the sky's SH; 0: none */
    const double *sun;              /* 3 each: unit, towards it */
    size_t sun_count;
    const double *point; /* 3 each: where it is, in the scene's frame */
    size_t point_count;
};

/* The first part of the sky's, the suns' and the points', and how many there are. */
static inline size_t split_sky(const struct split *split)
{
    return split->groups ? split->groups->count : 0;
}
static inline size_t split_suns(const struct split *split)
{
    return split_sky(split) + (size_t)(split->sky_order * split->sky_order);
}
static inline size_t split_points(const struct split *split)
{
    return split_suns(split) + split->sun_count;
}
static inline size_t split_count(const struct split *split)
{
    return split_points(split) + split->point_count;
}

/* The light of a split's i-th point. */
static inline struct scene_light split_point(const struct split *split, size_t i)
{
    return (struct scene_light){
        .kind = SCENE_POINT, .position = vec3_load(split->point + 3 * i), .intensity = {1, 1, 1}};
}

/* The light of a wave of samples by parts. One thread's. */
struct split_light {
    const struct split *split;
    size_t count;
    struct wave_vec *scattered; /* by part, then sample: as path_sample.scattered; owned */
    struct wave_vec *asked;     /* by part, then path: what is not yet multiplied by the albedo */
    bool *some, *some_asked;    /* by part: something was added; else the part is not set */
    /* by sample: the group of path_sample.straight; GROUP_NONE: it is none's */
    uint16_t straight[TRACE_WAVE];
};

/* Bytes that it takes. */
size_t split_light_bytes(const struct split *split);

struct error *split_light_init(struct split_light *light, const struct split *split);
void split_light_clear(struct split_light *light);

/* Forgets the wave before. */
void split_light_start(struct split_light *light);

/* Adds what a sample's path found. */
void split_add(struct split_light *light, size_t part, size_t sample, struct vec3f rgb);

/* The same of the sky's Y_j, by the path's throughput. */
void split_add_sky(struct split_light *light, size_t sample, struct vec3f direction,
                   struct vec3f throughput);

/* Keeps irradiance over pi at a path's surface, until split_scatter. */
void split_ask(struct split_light *light, size_t part, size_t path, struct vec3f rgb);

/* Adds what was kept, times each path's throughput, to the samples whose paths they are. */
void split_scatter(struct split_light *light, size_t paths, const struct wave_vec *throughput,
                   const uint32_t *sample);

/* The group of the emissive surface that a wave's ray i met. */
static inline size_t split_group_met(const struct split *split, const struct scene *scene,
                                     const struct trace_points *at, size_t i)
{
    return group_of_surface(split->groups, scene, at->instance[i], at->triangle[i],
                            at->material[i]);
}

#endif
