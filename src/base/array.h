/* SPDX-License-Identifier: Apache-2.0 */
/* array: memory for arrays, checked for overflow and shortage.
 *
 * An array is a pointer and a count side by side, owned by whoever declares them and freed
 * with free(). `array` arguments are the address of that pointer (a T **), whatever T is.
 */
#ifndef ARRAY_H
#define ARRAY_H

#include <stddef.h>

struct error;

/* Makes *array point to `count` zeroed elements of `size` bytes (at least one byte, so that a
 * pointer to an empty array is not NULL). On error *array is NULL. */
struct error *array_create(void *array, size_t count, size_t size);

/* Makes room for at least `count` elements in *array, whose room is now *capacity elements;
 * grows geometrically, keeps what is there. On error both are left as they were. */
struct error *array_reserve(void *array, size_t *capacity, size_t count, size_t size);

#endif
