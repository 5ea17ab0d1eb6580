/* SPDX-License-Identifier: Apache-2.0 */
/* stars: the cells around each probe. */
#ifndef STARS_H
#define STARS_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct leak_mesh;

struct stars {
    size_t *first;  /* of each probe in slot; one more than there are probes; owned */
    uint32_t *slot; /* corners * cell + corner, in order; owned */
};

struct error *stars_init(struct stars *stars, const struct leak_mesh *mesh);
void stars_clear(struct stars *stars);

#endif
