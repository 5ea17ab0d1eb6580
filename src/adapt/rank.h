/* SPDX-License-Identifier: Apache-2.0 */
/* rank: candidates, cells or probes by what each is worth. */
#ifndef RANK_H
#define RANK_H

#include <stdint.h>

struct rank {
    double value;
    uint32_t number;
};

/* For qsort: the largest value first, and of equals the lowest number. */
static inline int rank_compare(const void *a, const void *b)
{
    const struct rank *x = a, *y = b;
    if (x->value != y->value)
        return x->value > y->value ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

#endif
