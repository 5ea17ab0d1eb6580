/* place: where probes go. Each method yields positions; solids are recognised afterwards, the same way for all.
 */
#ifndef PLACE_H
#define PLACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;
struct scene_solids;
struct tracer;

/* Positions, owned: 3 * count doubles; free with place_clear. */
struct place {
    double *position;
    size_t count, capacity;
};
void place_clear(struct place *place);

struct place_grid {
    double min[3], max[3]; /* box, min <= max */
    double spacing[3];     /* > 0; the grid is centred in the box, with a probe at each node */
};

/* Spacing for about (and at most) `count` probes in the box, equal along the axes. */
double place_spacing_for(const double min[3], const double max[3], double count);

/* How many probes a grid has: as a double, since it may exceed any integer. */
double place_grid_count(const struct place_grid *grid);
struct error *place_grid(struct place *place, const struct place_grid *grid);

/* Positions from text, one "x y z" a line; # comments and blank lines are skipped. path "-": standard input. Errors: file:line. */
struct error *place_points(struct place *place, const char *path);

/* Positions every `step` along the polyline of such a file, its vertices included. most: refuse to make more than that. */
struct error *place_path(struct place *place, const char *path, double step, double most);

/* Which positions are inside solids: inside[i] set. A position is inside when it is inside a closed piece of the surface (by
 * parity of crossings), or when more than backface_share of rays around it meet back faces first. */
struct error *place_inside(const struct place *place, const struct tracer *tracer, const struct scene_solids *solids,
                           double backface_share, int rays, uint64_t seed, int threads, bool *inside);

#endif
