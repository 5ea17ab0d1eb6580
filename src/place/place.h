/* place: where probes go.
 *
 * A method yields positions: a grid, given points, steps along a path, or the vertices of the
 * scene. Afterwards, the same way for all, place_inside tells which of them are inside solids.
 *
 * What is a solid? A closed piece of the surface whose faces look outward encloses matter, unless
 * it is a room: a piece that holds another piece of the scene, or a light, encloses air, and so
 * does one whose faces look inward. Open pieces enclose nothing for certain, but a position from
 * which nearly all rays meet back faces is taken to be inside as well (a column without its ends);
 * where most of the positions would go that way, the scene's faces are not oriented and say
 * nothing.
 */
#ifndef PLACE_H
#define PLACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;
struct tracer;
struct warnings;

/* Positions, owned: 3 * count doubles; starts as {0}. */
struct place {
    double *position;
    /* of the surfaces that they are at, unit: 3 * count, owned; NULL: they are at none */
    float *normal;
    size_t count, capacity;
};
void place_clear(struct place *place);

struct place_grid {
    double min[3], max[3]; /* the box; min <= max */
    double spacing[3];     /* greater than 0 */
};

/* How many nodes the grid has along each axis: as many as fit into the box with half a spacing, or
 * the rest of it, left at both ends, at least one. Doubles, since they may exceed any integer. */
void place_grid_nodes(const struct place_grid *grid, double nodes[3]);

/* The smallest spacing, equal along the axes, whose grid has at most `count` nodes (1 or more); the
 * box has a volume. */
double place_grid_spacing(const double min[3], const double max[3], double count);

/* Appends the nodes, x fastest. Errors: more than `most` of them, naming the number. */
struct error *place_grid(struct place *place, const struct place_grid *grid, double most);

/* Appends positions from text, one "x y z" a line (points.h). path "-": standard input. Errors:
 * file:line, more than `most`. */
struct error *place_points(struct place *place, const char *path, double most);

/* Appends positions every `step` along the polyline of such a file, and its vertices. */
struct error *place_path(struct place *place, const char *path, double step, double most);

/* The share of the diagonal of the scene's box by which place_vertices stays off the surface,
 * unless told otherwise. */
#define PLACE_OFFSET_SHARE 1e-3

/* Makes the positions, of which there are none yet, those of the scene's vertices (vertices.h),
 * moved by `offset` along their normals. crease: degrees. Errors: more than `most`. */
struct error *place_vertices(struct place *place, const struct scene *scene, double offset,
                             double crease, double most);

struct place_inside_settings {
    int rays;              /* looks around from each position */
    double backface_share; /* of them that must meet back faces of open pieces */
    int threads;
};

struct place_inside_settings place_inside_default(void); /* 64 rays, 0.9, 1 thread */

/* Sets inside[i] for each position. A warning says when the faces turned out not to be oriented. */
struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, bool *inside,
                           struct warnings *warnings);

#endif
