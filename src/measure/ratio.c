/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/ratio.h"

#include <math.h>

void stratum_add(struct stratum *s, double y, double x)
{
    s->y += y;
    s->x += x;
    s->yy += y * y;
    s->xy += x * y;
    s->xx += x * x;
}

void ratio_add(struct ratio *r, const struct stratum *s, size_t count, double volume, bool near)
{
    const double n = (double)count, part = volume / n, spread = volume * part / (n - 1);
    r->above += part * s->y;
    r->below += part * s->x;
    r->near += near ? part * s->x : 0;
    r->yy += spread * (s->yy - s->y * s->y / n);
    r->xy += spread * (s->xy - s->x * s->y / n);
    r->xx += spread * (s->xx - s->x * s->x / n);
    r->square += near ? part * part * s->xx : 0;
}

struct estimate ratio_estimate(const struct ratio *r)
{
    const double z = 1.96;
    if (!(r->below > 0))
        return (struct estimate){0};
    const double value = r->above / r->below,
                 variance = fmax(r->yy - 2 * value * r->xy + value * value * r->xx, 0) /
                            (r->below * r->below),
                 one = r->near > 0 ? r->square / (r->near * r->below) : 0,
                 middle = (value + z * z * one / 2) / (1 + z * z * one),
                 half = z * sqrt(variance + z * z * one * one / 4) / (1 + z * z * one);
    return (struct estimate){.value = value,
                             .low = fmin(fmax(middle - half, 0), value),
                             .high = fmax(fmin(middle + half, 1), value)};
}
