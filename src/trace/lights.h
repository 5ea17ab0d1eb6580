/* SPDX-License-Identifier: Apache-2.0 */
/* lights: which light to ask from where, for next-event estimation.
 *
 * Emissive triangles, point and spot lights stand in one binary tree, whose nodes bound where their
 * lights are, which way they shine and how strongly. lights_sample goes down the tree and at each
 * node takes the child that may give the point more light, with probability in proportion to that
 * bound: power, distance, the cosine at the light and at the surface (Conty Estevez and Kulla,
 * "Importance sampling of many lights with adaptive tree splitting", HPG 2018; the bound itself is
 * that of Pharr, Jakob and Humphreys, "Physically based rendering", 4th ed., 12.6.3). A choice
 * costs the logarithm of their number. A triangle whose emission is a picture stands there in parts
 * that are about even (parts.h); dark ones are not there. lights_density is the density of that
 * choice, for multiple importance sampling. Suns are not in the tree. A scene without lights pays
 * for none.
 */
#ifndef LIGHTS_H
#define LIGHTS_H

#include "trace/parts.h"
#include "trace/trace_local.h"

struct error;
struct random;

struct lights {
    size_t count;            /* emissive triangles or parts of them, points and spots */
    struct light *light;     /* owned, and so are: */
    struct light_node *node; /* the root first; none when count is 0 */
    uint32_t *node_of_light; /* the leaf that holds each */
    /* by instance: NULL, or by triangle its number among the lights; `count` and more: count plus
     * the part that it is the whole of; UINT32_MAX for none */
    uint32_t **number;
    struct parts parts; /* of triangles with pictures */
    size_t instance_count;
    bool front_only; /* surfaces emit from their front side alone */
};

/* Where the light is asked for: a point and, where it is on a surface, the unit normal of the side
 * that is lit (zero: no surface). */
struct lights_receiver {
    struct vec3f position, normal;
    bool surfaces; /* point and spot lights are not drawn, nor wanted */
};

/* A light that was drawn. */
struct lights_choice {
    const struct scene_light *punctual; /* NULL: a point of an emissive surface, in: */
    struct trace_point point;           /* without distance and front */
    float probability;                  /* of this light */
    /* of this point, per area (local units), and mean luminance of the triangle or part of one that
     * it was drawn from; emissive surfaces alone */
    float density, brightness;
};

struct error *lights_init(struct lights *lights, const struct tracer *tracer);
void lights_clear(struct lights *lights);

/* Of all lights together: luminance of radiance times area (local units), and of point and spot
 * lights' intensity. */
double lights_strength(const struct lights *lights);

/* Draws a light by x and a point on it by what is left of x and by y, both uniform in [0, 1):
 * samples whose (x, y) are stratified are stratified over the lights. receiver NULL: none, lights
 * are drawn by their strength. False: no light can reach the receiver. Needs count > 0. */
bool lights_sample(const struct lights *lights, const struct tracer *tracer,
                   const struct lights_receiver *receiver, double x, float y,
                   struct lights_choice *choice);

/* Draws a point on the light of that number, below count, by x and y: it is chosen with probability
 * 1. */
void lights_draw(const struct lights *lights, const struct tracer *tracer, size_t number, float x,
                 float y, struct lights_choice *choice);

/* The density per area (local units) with which lights_sample draws this point of a surface; 0 for
 * one that it never draws. */
float lights_density(const struct lights *lights, const struct lights_receiver *receiver,
                     const struct trace_point *point);

#endif
