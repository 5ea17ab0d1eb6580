/* SPDX-License-Identifier: Apache-2.0 */
/* leak: edges of the tetrahedra that pass through walls, and the probes that mend them (Sukys 2014,
 * sec. 3.2.2).
 *
 * Light is blended along an edge from end to end. Where a surface crosses the edge, the light of
 * one side leaks to the other, over the whole way from the surface to the edge's end. So a ray goes
 * along each edge from both ends. Where one meets a surface, the edge is *crossed*; it *leaks*, and
 * asks for a probe just off the surface, where the end is far from it (relative to the edge, and to
 * the distance at which probes stand off) and the ray does not merely graze it. Probes go in in
 * pairs, one on each side of the wall, unless one is near enough already; then the mesh joins twin
 * to twin through the wall, and what is blended through it is no more than the gap. Probes in a
 * plane or on a line get theirs on the edges, and stay in that plane or on that line. What is
 * mended in one round makes new cells, so rounds follow, each with half the separation of the last,
 * until no edge leaks.
 *
 * The same is done, where it is asked for, on free edges that go through the border of a lamp's
 * shadow (shadow.h): a pair stands on both sides of it, on the edge.
 */
#ifndef LEAK_H
#define LEAK_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct tracer;

/* Cells of probes; borrowed. */
struct leak_mesh {
    size_t probe_count;
    const double *position; /* 3 a probe */
    int corners;            /* of a cell: 4, 3, 2 or 1 */
    size_t cell_count;
    const int32_t *vertex;    /* `corners` a cell */
    const int32_t *neighbour; /* `corners` a cell; NULL: what is outside is not looked at */
};

static inline struct vec3 leak_mesh_probe(const struct leak_mesh *mesh, int32_t probe)
{
    return vec3_load(mesh->position + 3 * (size_t)probe);
}

enum leak_edges { LEAK_WALLS, LEAK_SHADOWS, LEAK_BOTH };

struct leak_settings {
    enum leak_edges edges; /* which ask for probes */
    /* least |cos| between ray and surface normal for a surface to count as a wall to mend */
    double graze;
    double margin; /* least distance from an end to the surface, as a share of the edge */
    double offset; /* how far off the surface a new probe stands, scene units */
    /* least distance from a new probe to another one that it sees, scene units */
    double separation;
    int threads;
};

/* graze 0.1, margin 0.1; offset and separation from the cells: 0.05 and 0.5 times the median edge.
 */
struct error *leak_settings_for(struct leak_settings *settings, const struct leak_mesh *mesh);

/* How many edges a cell of so many corners has: 6, 3, 1, 0. */
int leak_edges_of(int corners);

/* The order in which they are counted: by corners of a cell, the corners of each edge. */
extern const int leak_edge[5][6][2];

struct leak_candidate;

struct leaks {
    size_t edges;   /* of the mesh */
    size_t crossed; /* by a surface */
    size_t leaking; /* crossed, with an end that is far from the surface */
    /* free, through the border of a shadow, with an end that is far from it; 0 where shadows are
     * not looked for */
    size_t shadowed;
    size_t asking; /* for probes: of these, what the settings are for */
    /* leak_edges_of(corners) * cell_count: 2 where the cell's edge leaks, 1 where it is only
     * crossed, else 0; owned */
    int32_t *cell_edges;
    struct leak_candidate *candidate; /* those that ask, in canonical order; owned */
};

/* Looks along the edges of the cells. The result does not depend on the number of threads, or on
 * the order of the probes. */
struct error *leak_find(struct leaks *leaks, const struct tracer *tracer,
                        const struct leak_settings *settings, const struct leak_mesh *mesh);
void leaks_clear(struct leaks *leaks);

/* How many probes may be chosen, and where. */
struct leak_room {
    size_t most;
    /* where more are asked for than that: so many edges, from the worst on, had their turn */
    size_t past;
    /* whether a probe may stand at p; NULL: anywhere */
    struct error *(*is_free)(void *context, const double p[3], bool *free);
    void *context;
};

struct leak_choice {
    double *probe; /* 3 a probe: where; owned */
    size_t count;
    size_t asked; /* for: count, unless that was more than there is room for */
    size_t past;  /* edges, from the worst on, that have had their turn with these */
};

/* Chooses probes for the edges that ask, of the mesh that was looked along. All of them; where that
 * is more than there is room for, those at the edges along which light leaks farthest. The result
 * does not depend on the order of the probes. */
struct error *leak_choose(struct leak_choice *choice, const struct leaks *leaks,
                          const struct tracer *tracer, const struct leak_settings *settings,
                          const struct leak_mesh *mesh, const struct leak_room *room);
void leak_choice_clear(struct leak_choice *choice);

#endif
