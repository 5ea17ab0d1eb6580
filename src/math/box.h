/* SPDX-License-Identifier: Apache-2.0 */
/* box: the axis-parallel box around points.
 *
 * One without points has low = infinity and high = -infinity.
 */
#ifndef BOX_H
#define BOX_H

#include <math.h>
#include <stddef.h>

struct box {
    double low[3], high[3];
};

static inline struct box box_empty(void)
{
    const double most = (double)INFINITY;
    return (struct box){{most, most, most}, {-most, -most, -most}};
}

/* Grows the box to hold p. */
static inline void box_add(struct box *box, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        box->low[k] = fmin(box->low[k], p[k]);
        box->high[k] = fmax(box->high[k], p[k]);
    }
}

/* The box of 3 * count coordinates. */
static inline struct box box_of(size_t count, const double *position)
{
    struct box box = box_empty();
    for (size_t i = 0; i < count; i++)
        box_add(&box, position + 3 * i);
    return box;
}

/* Its longest side; 0 without points. */
static inline double box_side(const struct box *box)
{
    double side = 0;
    for (int k = 0; k < 3; k++)
        side = fmax(side, box->high[k] - box->low[k]);
    return side;
}

#endif
