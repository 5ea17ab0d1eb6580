/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/narrow.h"
#include "math/direction.h"
#include "math/vec.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

/* Chords are within 20 degrees of any way, so that a gap is told to 6 % of its width. */
enum { CHORDS = 16, LONGEST = 3 };

struct chord {
    double length;
    double middle[3];
};

static double way_to(const struct tracer *tracer, const double p[3], struct vec3 d)
{
    double direction[3];
    vec3_store(direction, d);
    const struct trace_hit hit = trace_nearest(tracer, p, direction, (double)INFINITY);
    return hit.hit ? hit.distance : (double)INFINITY;
}

/* Returns how many have two ends, the longest first; *least: the length of the shortest. */
static int find_chords(const struct tracer *tracer, const double p[3], struct chord chord[CHORDS],
                       double *least)
{
    int count = 0;
    *least = (double)INFINITY;
    for (int i = 0; i < CHORDS; i++) {
        const struct vec3 d = direction_even(i, 2 * CHORDS); /* of the upper half */
        const double ahead = way_to(tracer, p, d), behind = way_to(tracer, p, vec3_scale(-1, d));
        struct chord c = {.length = ahead + behind};
        if (!(c.length < (double)INFINITY))
            continue;
        vec3_store(c.middle, vec3_fma(vec3_load(p), (ahead - behind) / 2, d));
        *least = fmin(*least, c.length);
        int at = count++;
        for (; at > 0 && chord[at - 1].length < c.length; at--)
            chord[at] = chord[at - 1];
        chord[at] = c;
    }
    return count;
}

bool is_narrow(const struct tracer *tracer, const double p[3], double width)
{
    struct chord chord[CHORDS], others[CHORDS];
    double least;
    const int count = find_chords(tracer, p, chord, &least);
    for (int i = 0; i < LONGEST && i < count && least < width; i++)
        find_chords(tracer, chord[i].middle, others, &least);
    return least < width;
}
