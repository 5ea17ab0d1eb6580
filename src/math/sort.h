/* SPDX-License-Identifier: Apache-2.0 */
/* sort: numbers in ascending order. None may be NaN.
 */
#ifndef SORT_H
#define SORT_H

#include <stddef.h>

void sort_doubles(size_t count, double *value);
void sort_floats(size_t count, float *value);

/* What would be value[k], k < count, were they sorted: Hoare's FIND (1961), linear in the mean.
 * Changes their order; those before k are not above it after that, and those behind not below. */
double sort_find(size_t count, double *value, size_t k);

#endif
