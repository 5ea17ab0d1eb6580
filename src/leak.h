/* leak: edges of the tetrahedra that pass through walls, and the probes that mend them (Sukys 2014, sec. 3.2.2).
 *
 * An edge leaks when a ray along it, from either end, hits a surface: light would be interpolated through the wall.
 * A probe goes in on each side of the wall that is hit, moved off the surface, unless the ray grazes the surface or the hit lies too near
 * (relative to the edge's length) to the end that the probe would be next to.
 */
#ifndef LEAK_H
#define LEAK_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct tracer;

struct leak_settings {
    double graze;  /* least |cos| between ray and surface normal for a hit to count as a wall to mend */
    double margin; /* least distance from hit to the near end, as a share of the edge */
    double offset; /* how far off the surface a new probe stands, as a share of the edge */
};

struct leak_settings leak_settings_default(void);

struct leak_report {
    size_t edges, leaking; /* edges of the mesh; edges that a surface crosses (grazing ones included) */
    size_t mendable;       /* leaking edges that asked for at least one new probe */
};

/* Finds leaking edges of the cells and the probes that would mend them. *probes: 3 * *probe_count positions, malloc'ed, owned by the
 * caller, in a canonical order without duplicates, none inside another's offset distance. cell_leaks (may be NULL): for each cell,
 * how many of its six edges leak. Same result for any thread count. */
struct error *leak_find(const struct tracer *tracer, const struct leak_settings *settings, size_t probe_count,
                        const double *position, size_t cell_count, const int32_t *vertex, int threads,
                        struct leak_report *report, int32_t *cell_leaks, double **probes, size_t *new_count);

#endif
