/* SPDX-License-Identifier: Apache-2.0 */
/* places: numbers of places on a lattice: a hash table with open addresses.
 *
 * A place is three whole numbers of 0 .. PLACES_MOST. Starts as {0}.
 */
#ifndef PLACES_H
#define PLACES_H

#include <stddef.h>
#include <stdint.h>

struct error;

enum { PLACES_MOST = (1 << 21) - 1 }; /* a place is 63 bits */

struct places {
    uint64_t *key; /* place + 1; 0: free; owned */
    int32_t *number;
    size_t size, count; /* size: a power of two */
};

/* The number of a place; -1: none. */
int32_t places_find(const struct places *map, const int32_t x[3]);

/* Of a place that has none. */
struct error *places_add(struct places *map, const int32_t x[3], int32_t number);

void places_clear(struct places *map);

#endif
