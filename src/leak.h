/* leak: edges of the tetrahedra that pass through walls, and the probes that mend them (Sukys 2014, sec. 3.2.2).
 *
 * Light is blended along an edge from end to end. Where a surface crosses the edge, the light of one side leaks to the
 * other, over the whole way from the surface to the edge's end. So a ray goes along each edge from both ends; where one meets
 * a surface, a probe belongs on the side it came from, just off the surface: then what is blended through the wall is no more than
 * the gap. No probe goes in where the ray only grazes the surface, where the end itself is near the surface (relative to
 * the edge), or where a probe on the same side is near already. What is mended in one round makes new cells, so
 * rounds follow until no edge asks for a probe.
 *
 * An edge is *crossed* when a surface is on it, and *leaks* when it also asks for a probe. After mending, edges still cross
 * walls, from one side's probe to the other's; they no longer leak.
 */
#ifndef LEAK_H
#define LEAK_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct tracer;

struct leak_settings {
    double graze;      /* least |cos| between ray and surface normal for a surface to count as a wall to mend */
    double margin;     /* least distance from an end to the surface, as a share of the edge */
    double offset;     /* how far off the surface a new probe stands, scene units */
    double separation; /* least distance from a new probe to another one that it sees, scene units */
    int threads;
};

/* graze 0.1, margin 0.1; offset and separation from the cells: 0.05 and 0.5 times the median edge. */
struct error *leak_settings_for(struct leak_settings *settings, const double *position, size_t cell_count, const int32_t *vertex);

/* The order in which a cell's six edges are counted: vertices of edge e. */
extern const int leak_edge[6][2];

struct leaks {
    size_t edges;        /* of the mesh */
    size_t crossed;      /* by a surface */
    size_t leaking;      /* crossed, and asking for a probe */
    int32_t *cell_edges; /* 6 * cell_count: 1 where the cell's edge is crossed, else 0; owned */
    double *probe;       /* 3 * probe_count: positions of the probes asked for, in canonical order; owned */
    size_t probe_count;
};

/* Looks along the edges of the cells. The result does not depend on the number of threads, or on the order of the probes. */
struct error *leak_find(struct leaks *leaks, const struct tracer *tracer, const struct leak_settings *settings,
                        size_t probe_count, const double *position, size_t cell_count, const int32_t *vertex);
void leaks_clear(struct leaks *leaks);

#endif
