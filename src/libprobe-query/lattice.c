/* SPDX-License-Identifier: Apache-2.0 */
#include "lattice.h"

#include <math.h>

struct lattice lattice_fit(size_t count, const double *position)
{
    struct lattice lattice = {0};
    double low[3], extent = 0;
    for (int k = 0; k < 3; k++) {
        low[k] = count ? position[k] : 0;
        double high = low[k];
        for (size_t i = 0; i < count; i++) {
            const double x = position[3 * i + (size_t)k];
            low[k] = x < low[k] ? x : low[k];
            high = x > high ? x : high;
        }
        extent = fmax(extent, high / 2 - low[k] / 2); /* halves: a difference may overflow */
    }
    if (!(extent > 0))
        return lattice;
    int exponent;
    frexp(extent, &exponent);
    /* 2 extents < 2^(exponent + 1), and one more for rounding */
    lattice.step = ldexp(1, exponent + 2 - LATTICE_BITS);
    for (int k = 0; k < 3; k++)
        lattice.origin[k] = rint(low[k] / lattice.step) * lattice.step;
    return lattice;
}

void lattice_snap(const struct lattice *lattice, const double position[3], double site[3])
{
    for (int k = 0; k < 3; k++) /* world steps first: exact, and the same whatever the origin */
        site[k] = lattice->step > 0
                      ? rint(position[k] / lattice->step) - lattice->origin[k] / lattice->step
                      : 0;
}

lattice_volume lattice_orient(const double p0[3], const double p1[3], const double p2[3],
                              const double p3[3])
{
    int64_t a[3], b[3], c[3];
    for (int k = 0; k < 3; k++) {
        a[k] = lattice_whole(p1[k] - p0[k]);
        b[k] = lattice_whole(p2[k] - p0[k]);
        c[k] = lattice_whole(p3[k] - p0[k]);
    }
    lattice_volume sum = 0;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        sum += (lattice_volume)a[k] * ((lattice_volume)b[i] * c[j] - (lattice_volume)b[j] * c[i]);
    }
    return sum;
}
