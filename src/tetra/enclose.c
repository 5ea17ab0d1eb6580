/* SPDX-License-Identifier: Apache-2.0 */
#include "tetra/enclose.h"

#include <string.h>

struct box enclose_box(size_t count, const double *position, double margin)
{
    struct box box = box_of(count, position);
    const double more = margin * box_side(&box);
    for (int k = 0; k < 3; k++) {
        box.low[k] -= more;
        box.high[k] += more;
    }
    return box;
}

/* Bit c is set where p is corner c, whose bits 0, 1, 2 say on which side of x, y, z it is; several,
 * where the box is flat. */
static unsigned corners_at(const struct box *box, const double p[3])
{
    static const unsigned lows[3] = {0x55, 0x33, 0x0f};
    unsigned corners = 0xff;
    for (int k = 0; k < 3; k++)
        corners &= (p[k] == box->low[k] ? lows[k] : 0) | (p[k] == box->high[k] ? ~lows[k] : 0);
    return corners;
}

size_t enclose_corners(size_t count, const double *position, const struct box *box,
                       double corner[8][3])
{
    unsigned there = 0;
    size_t missing = 0;
    for (size_t i = 0; i < count; i++)
        there |= corners_at(box, position + 3 * i);
    for (unsigned c = 0; c < 8; c++) {
        if (there >> c & 1)
            continue;
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = c >> k & 1 ? box->high[k] : box->low[k];
        there |= corners_at(box, p);
        memcpy(corner[missing++], p, sizeof p);
    }
    return missing;
}
