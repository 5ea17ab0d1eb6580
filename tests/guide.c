/* SPDX-License-Identifier: Apache-2.0 */
/* Guides: that points are drawn where light is, with the density that is told, along a curve; and
 * that what they bring and what rays to all directions bring add up to the whole. */
#include "capture/guide.h"
#include "base/error.h"
#include "support/tap.h"
#include "trace/path.h"

#include <math.h>

enum { DRAWS = 1 << 14 };

/* The mean over the unit square of a function that is 7 in a corner of it and 1 elsewhere, by as
 * many points of two kinds. */
static double mean_both_ways(const struct guide *g)
{
    double sum = 0;
    for (int i = 0; i < DRAWS; i++) {
        double x = (i % 128 + 0.5) / 128, y = (i / 128 + 0.5) / 128;
        for (int kind = 0; kind < 2; kind++) {
            sum += (x < 0.25 && y < 0.25 ? 7 : 1) / (1 + (double)guide_density(g, x, y));
            guide_draw(g, (i + 0.5) / DRAWS, &x, &y);
        }
    }
    return sum / DRAWS;
}

int main(void)
{
    struct guide g;
    double gain, all = 0, inverse = 0, jump = 0, x_before = 0, y_before = 0;
    must(guide_init(&g, 500));
    ok(g.cells == 512, "as many cells as asked for, at least: %zu", g.cells);
    must(guide_make(&g, &gain));
    ok(!(gain > 0), "no light");
    guide_clear(&g);
    must(guide_init(&g, 512)); /* 16 rows, 32 columns */
    guide_add(&g, 0.001, 0.5, 3);
    guide_add(&g, 0.7, 0.99, 1);
    must(guide_make(&g, &gain));
    ok(guide_density(&g, 0.999, 0.5) > 0 && guide_density(&g, 0.001, 0.45) > 0 &&
           !(guide_density(&g, 0.2, 0.5) > 0),
       "light is spread to the cells about, across the seam");
    ok(gain > 1 && gain < 512, "and worth a guide: %g", gain);
    for (int i = 0; i < 512; i++)
        all += (double)guide_density(&g, (i % 32 + 0.5) / 32, (i / 32 + 0.5) / 16) / 512;
    int outside = 0, low = 0;
    for (int i = 0; i < DRAWS; i++) {
        double x, y;
        guide_draw(&g, (i + 0.5) / DRAWS, &x, &y);
        const double density = (double)guide_density(&g, x, y);
        outside += !(density > 0);
        inverse += density > 0 ? 1 / density / DRAWS : 0;
        low += y < 0.75;
        jump += i ? fmin(hypot(x - x_before, y - y_before), 1) / DRAWS : 0;
        x_before = x, y_before = y;
    }
    ok(fabs(all - 1) < 1e-6, "densities add up to one: %.9g", all);
    int lit = 0;
    for (int i = 0; i < 512; i++)
        lit += guide_density(&g, (i % 32 + 0.5) / 32, (i / 32 + 0.5) / 16) > 0;
    ok(!outside && fabs(inverse - lit / 512.0) < 1e-3, "and are those of the draws: %g, %d cells",
       inverse * 512, lit);
    ok(abs(low - DRAWS * 3 / 4) <= 1, "three quarters of the light get three of the draws: %d",
       low);
    ok(jump < 0.01, "neighbours are near: %g", jump);
    const double mean = mean_both_ways(&g);
    ok(fabs(mean - (1 + 6 / 16.0)) < 1e-3, "both ways together are unbiased: %g", mean);
    guide_clear(&g);

    const struct path_receiver point = {.lit = false}, surface = {.at.normal = {0, 0, -1}};
    const struct vec3f up = guide_direction(&point, 0.3f, 1), off = guide_direction(&surface, 0, 0);
    ok(fabsf(up.z - 1) < 1e-6f && fabsf(off.z + 1) < 1e-6f, "directions of a point and a surface");
    return tap_done();
}
