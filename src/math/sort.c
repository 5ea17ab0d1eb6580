/* SPDX-License-Identifier: Apache-2.0 */
#include "math/sort.h"

#include <stdlib.h>

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

void sort_doubles(size_t count, double *value)
{
    qsort(value, count, sizeof *value, compare_doubles);
}

void sort_floats(size_t count, float *value)
{
    qsort(value, count, sizeof *value, compare_floats);
}
