/* SPDX-License-Identifier: Apache-2.0 */
/* Openings: which cells are near an open one, that points of them are drawn evenly, and that their
 * density is that of the draws. */
#include "capture/openings.h"
#include "base/error.h"
#include "support/tap.h"

#include <math.h>

enum { ROWS = 16, COLUMNS = 48, DRAWS = 64 * 49 };

int main(void)
{
    struct openings o;
    must(openings_init(&o, ROWS, COLUMNS));
    must(openings_find(&o));
    ok(!o.count && !(openings_density(&o, 0.5, 0.5) > 0), "nothing is open");
    openings_clear(&o);
    must(openings_init(&o, ROWS, COLUMNS));
    o.open[8 * COLUMNS] = 1; /* at the seam */
    must(openings_find(&o));
    ok(o.count == 49 && o.open[5 * COLUMNS + COLUMNS - 3] && o.open[11 * COLUMNS + 3] &&
           !o.open[8 * COLUMNS + 4] && !o.open[12 * COLUMNS],
       "what is near an open cell is, across the seam: %zu cells", o.count);
    double sum = 0, all = 0;
    int in[4] = {0}, outside = 0;
    for (int i = 0; i < DRAWS; i++) {
        double x, y;
        openings_draw(&o, (i + 0.5) / DRAWS, &x, &y);
        const double density = openings_density(&o, x, y);
        outside += !(density > 0);
        sum += density > 0 ? 1 / density : 0;
        in[2 * (fmod(y * ROWS, 1) < 0.5) + (fmod(x * COLUMNS, 1) < 0.5)]++;
    }
    for (int i = 0; i < ROWS * COLUMNS; i++)
        all += openings_density(&o, (i % COLUMNS + 0.5) / COLUMNS, (i / COLUMNS + 0.5) / ROWS) /
               (ROWS * COLUMNS);
    ok(!outside && fabs(sum / DRAWS - 49.0 / (ROWS * COLUMNS)) < 1e-9 && fabs(all - 1) < 1e-9,
       "points are drawn there, with that density");
    ok(in[0] == in[1] && in[1] == in[2] && in[2] == in[3], "and evenly within a cell");
    openings_clear(&o);
    must(openings_init(&o, 2, 4)); /* all is near */
    o.open[7] = 1;
    must(openings_find(&o));
    ok(o.count == 8 && fabs(openings_density(&o, 1, 1) - 1) < 1e-12, "few cells are all near");
    openings_clear(&o);
    return tap_done();
}
