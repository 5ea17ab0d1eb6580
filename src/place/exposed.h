/* SPDX-License-Identifier: Apache-2.0 */
/* exposed: places of a scene's surface, even by area, that suns and the sky see.
 *
 *     err = exposed_init(&exposed, tracer);
 *     err = exposed_add(&exposed, count, seed, &particles);
 *     exposed_clear(&exposed);
 *
 * In a scene that is small in its box, particles from suns and the sky pass it by: they aim at all
 * of the box (particles.h). From the surface, a ray finds what is seen at once.
 */
#ifndef EXPOSED_H
#define EXPOSED_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct particles;
struct tracer;

struct exposed {
    const struct tracer *tracer;
    double *sum;   /* of the area until each triangle, instance by instance, one side; owned */
    size_t *first; /* each instance's first triangle in it, and the end; owned */
    double area;   /* of all */
};

/* The tracer must outlive it. Error: memory. */
struct error *exposed_init(struct exposed *exposed, const struct tracer *tracer);
void exposed_clear(struct exposed *exposed); /* of {0} is legal */

/* Where `area` of it falls, from 0 to all: the instance and its triangle. Returns the number of
 * that in `sum`. */
size_t exposed_triangle(const struct exposed *exposed, double area, uint32_t *instance,
                        uint32_t *triangle);

/* Looks from `count` places, below 2^30, to suns and the sky in turn, to the latter by the cosine,
 * and adds those that see light as hits without flux, particle or bounce. Error: memory. */
struct error *exposed_add(const struct exposed *exposed, size_t count, uint64_t seed,
                          struct particles *particles);

#endif
