/* SPDX-License-Identifier: Apache-2.0 */
/* narrow: gaps that nobody gets into, such as the voids within walls, as against rooms.
 *
 * A space is as wide at a point as the shortest chord there, of some that go through it evenly to
 * all sides. In the corners of a room chords are short, too, but long ones lead to its midst. So a
 * point is in a narrow space where that is narrow at the point itself and in the middles of the
 * longest chords through it.
 */
#ifndef NARROW_H
#define NARROW_H

#include <stdbool.h>

struct tracer;

/* Whether the space around p (finite) is narrower than `width`, scene units. Any thread. */
bool is_narrow(const struct tracer *tracer, const double p[3], double width);

#endif
