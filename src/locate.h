/* locate: the cell around a point, the weights of its four probes, and what they blend to.
 *
 * The project's own face of libprobe-query (probe-query.h), with errors as values:
 *
 *     struct locate *l;
 *     err = locate_create(&l, probes, position, cells, vertex, neighbour);
 *     struct locate_weights w = {.cell = LOCATE_COLD};
 *     for each point p:
 *         locate_point(l, p, &w);             walks from the last cell (Cupisz 2012)
 *         locate_blend(&w, sh, width, out);
 *
 * Inside the hull the weights are the barycentric coordinates, which reproduce any linear field. Outside,
 * they are those of the nearest point of the hull: light is constant along what leaves the hull, and
 * continuous across it. A locator is read-only: threads share it, each with weights of its own.
 */
#ifndef LOCATE_H
#define LOCATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct locate;
struct probe_mesh;

enum { LOCATE_COLD = -1 }; /* no last cell known: start anywhere */

struct locate_weights {
    int32_t cell;      /* in: where to start the walk; out: the cell that holds the point, or that bounds the hull next to it */
    int32_t vertex[4]; /* its probes */
    double weight[4];  /* sum to 1, each >= 0 */
    bool inside;       /* of the hull */
    double distance;   /* to the hull's nearest point; 0 inside */
};

/* position: 3 * probe_count; vertex, neighbour: 4 * cell_count, as tetra makes them; all must outlive the locator. Checks every
 * index, that
 * cells have positive volume and that neighbours share faces; errors name the cell. */
struct error *locate_create(struct locate **locate, size_t probe_count, const double *position, size_t cell_count,
                            const int32_t *vertex, const int32_t *neighbour);
/* The same of cells of any dimension (mesh.h). */
struct error *locate_create_mesh(struct locate **locate, const struct probe_mesh *mesh);
void locate_destroy(struct locate *locate);

/* Locates p (finite). Ends always (volume_walk.c says why). */
void locate_point(const struct locate *locate, const double p[3], struct locate_weights *weights);

/* out[k] = sum weight_i value[vertex_i * width + k], k = 0 .. width-1, summed in double. */
void locate_blend(const struct locate_weights *weights, const float *value, size_t width, float *out);

#endif
