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

double sort_find(size_t count, double *value, size_t k)
{
    size_t first = 0, end = count; /* where it is */
    while (end - first > 1) {
        const double middle = value[k];
        size_t low = first, high = end;
        while (low < high) {
            while (value[low] < middle)
                low++;
            while (middle < value[high - 1])
                high--;
            if (low < high) {
                const double x = value[low];
                value[low++] = value[high - 1];
                value[--high] = x;
            }
        }
        /* all before low are at most the middle, all from high on at least */
        if (k < high)
            end = high;
        else if (k >= low)
            first = low;
        else
            break;
    }
    return value[k];
}
