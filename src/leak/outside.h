/* SPDX-License-Identifier: Apache-2.0 */
/* outside: free points outside of the hull, and which of the probes that they take their light from
 * they see.
 *
 * Light outside comes from a place on the hull, its nearest point or the one that rays lead back to
 * (libprobe-query/volume_outer.c), and a wall may stand between the two. Points are looked at by
 * either, in turns. The points are met from where they are seen: rays go out from the probes
 * of the hull, each to what it meets or to the end of the scene's box, and one point of each, at
 * random, that is outside of the hull is looked at from the probes that its light comes from; and
 * from probes behind the hull's faces that a wall cuts, in a room with none of the hull. So what no
 * probe around sees, as behind the walls of a room, has no say.
 */
#ifndef OUTSIDE_H
#define OUTSIDE_H

#include "libprobe-query/probe-query.h"
#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct leak_mesh;
struct tracer;

struct outside_look {
    double point[3];
    double weight[4]; /* of the corners of the cell at the place that its light comes from */
    /* how near to each corner something stands on the way to the point, which is 1; 0:
     * it sees the point, or has no weight there */
    float inverse[4];
    int32_t cell; /* of that place */
    int32_t from; /* a probe that sees the point */
    /* what the first of them that does not see it met: its unit normal, and how far along that it
     * is from the point */
    float normal[3], height;
};

/* Looks by what they are of: those of i are of[first[i]] on. */
struct outside_list {
    size_t *first; /* one more than there are; owned */
    uint32_t *of;  /* owned */
};

struct outside {
    const struct leak_mesh *mesh;   /* borrowed */
    struct probe_volume *volume[2]; /* of nearest points, and of rays where there are any; owned */
    struct outside_look *look;      /* owned */
    size_t count, capacity;
    struct outside_list by_probe, by_cell;
};

/* Looks around. Of cells with fewer than 4 corners, and of a mesh without neighbours, nothing is
 * looked at. The result does not depend on the threads. */
struct error *outside_init(struct outside *outside, const struct tracer *tracer,
                           const struct leak_mesh *mesh, int threads);
void outside_clear(struct outside *outside);

/* How far a look's point is away from the place that it has its light from, scene units. */
void outside_way(const struct outside *outside, const struct outside_look *look, double off[3]);

/* Whether one of the points that take their light from a cell is not seen by a probe of it. */
bool outside_is_blocked(const struct outside *outside, size_t cell);

/* Whether a look is of such a point; then the plane of what stands before it: of ways from p,
 * inverse depth is plane . way. */
bool outside_plane(const struct outside_look *look, const double p[3], struct vec3 *plane);

/* How near to p something stands on the way to q, which is 1; 0: nothing before. */
double outside_inverse(const struct tracer *tracer, const double p[3], const double q[3]);

#endif
