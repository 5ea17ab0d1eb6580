/* SPDX-License-Identifier: Apache-2.0 */
/* sort: numbers in ascending order. None may be NaN.
 */
#ifndef SORT_H
#define SORT_H

#include <stddef.h>

void sort_doubles(size_t count, double *value);
void sort_floats(size_t count, float *value);

#endif
