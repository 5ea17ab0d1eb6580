/* SPDX-License-Identifier: Apache-2.0 */
/* parts: an emissive triangle cut up by its picture, so that points of it can be drawn where it
 * shines.
 *
 * A triangle is halved along its sides into four, again and again where a part could hold much more
 * light than its mean (emission.h), those first that could hold most; the dark ones are left out.
 * What is even stays whole. A part of a triangle is one as well: its corners 0, 1 and 2 are, in the
 * triangle's barycentric coordinates, (b, c), (b + size, c) and (b, c + size); the one in the
 * middle of four lies upside down, with a size below 0.
 */
#ifndef PARTS_H
#define PARTS_H

#include "trace/trace_local.h"

struct error;

struct light_part {
    float b, c, size;
    float brightness; /* mean luminance, about; 0: dark */
    uint32_t child;   /* the first of four; 0: none */
    uint32_t root;    /* of which it is a part */
    uint32_t light;   /* for who asks, UINT32_MAX at first */
};

/* A triangle that is cut up. */
struct parts_root {
    uint32_t instance, triangle;
    uint32_t part;  /* the whole */
    float area;     /* as the asker measures */
    float uv[3][2]; /* of its corners, and as its emission map reads them: */
    float emission_uv[3][2];
};

struct parts {
    struct parts_root *root; /* owned, and so is: */
    struct light_part *part;
    size_t root_count, count, root_capacity, capacity;
};

/* Adds a triangle whose material's emission varies (emission.h). */
struct error *parts_add(struct parts *parts, const struct tracer *tracer, uint32_t instance,
                        uint32_t triangle, float area);

/* Cuts up all that were added. */
struct error *parts_divide(struct parts *parts, const struct scene *scene);
void parts_clear(struct parts *parts);

/* The part without children that holds the triangle's point (b, c). whole: its root's part. */
uint32_t parts_find(const struct parts *parts, uint32_t whole, float b, float c);

#endif
