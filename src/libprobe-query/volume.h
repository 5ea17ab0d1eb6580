/* SPDX-License-Identifier: Apache-2.0 */
/* volume: what the parts of libprobe-query share (probe-query.h is its face).
 *
 *     span.c           the plane or line that probes lie near (span.h)
 *     volume_tree.c    trees of boxes, sorting along a Morton curve (volume_tree.h)
 *     volume.c         what all parts ask a volume and its cells
 *     volume_outer.c   places outside the hull
 *     volume_walk.c    the cell around a point
 *     volume_sight.c   which of its probes the point sees
 *     volume_make.c    made and checked: the cells, the hull
 *     volume_tetra.c   tetrahedra and their matrices, made and checked in one pass
 *     volume_blend.c   weights and SH to light
 *     volume_image.c   packed files
 *
 * Plain C with libc and libm; nothing here prints, exits, or knows of streams. Sites are positions
 * on the lattice (lattice.h), whole numbers, so which side of a face a point is on is decided
 * exactly. A point is looked up where it is rounded to the lattice, 2^-40 of the probes' box.
 */
#ifndef VOLUME_H
#define VOLUME_H

#include "lattice.h"
#include "probe-query.h"
#include "span.h"
#include "volume_tree.h"

#include <stdbool.h>
#include <string.h>

/* A tetrahedron, ready for a look-up: two cache lines. Corners differ, so one whose first two
 * do not is not ready yet (volume_ready). */
struct volume_cell {
    /* weights of corners 1, 2, 3: x plane[0] + y plane[1] + z plane[2] + plane[3], in lattice
     * units; that of corner 0 is what is left to 1 */
    double plane[4][3];
    union {
        int32_t vertex[4];
        uint64_t pair[2];
    };
    int32_t neighbour[4];
};

/* What points outside of the hull see of a cell's corners, where something stands there: by scene
 * unit away from the place on the hull, a corner's depth (sight.h) falls by slope. As packed files
 * hold it. */
struct volume_beyond {
    int32_t cell; /* by the caller's number */
    int32_t stand_in;
    float slope[12]; /* 3 a corner */
};

/* A face of the hull. */
struct volume_facet {
    int32_t cell;   /* whose it is */
    int32_t corner; /* of the cell: the one opposite; -1: it is the whole cell (bent) */
    /* tetrahedra: the facet across the edge opposite each corner of this one, in the order of
     * volume_facet_vertex */
    int32_t across[3];
    float image[3]; /* with rays: of its middle (volume_outer.c) */
};

struct probe_volume {
    unsigned flags;
    int corners;
    size_t probes, cells;
    struct lattice lattice;
    /* lattice = scale * position - shift; scale 0: see volume_coordinates */
    double scale, shift[3];
    /* no probe is 2^50 steps or more from the origin of the scene, and scale is not 0 */
    bool near;
    double low[3], high[3];    /* of the sites */
    double middle[3], half[3]; /* (low + high) / 2 and (high - low) / 2 */
    /* fewer than 4 corners: which of the lattice's axes tell places of the plane or line apart */
    int axis[3];
    /* 3 corners: of the plane; 2 corners: of the line; unit, lattice units */
    double origin[3], normal[3];
    /* fewer than 4 corners: places are looked up where they fall in the plane or on the line, seen
     * along the lattice's axes; or, where probes stand off it by more than rounding, along frame:
     * flat, 3 a probe, are the sites' places there (else NULL) */
    double *flat;
    struct span_frame frame;
    double flat_low[3], flat_high[3];
    /* fewer than 4 corners that lie in no plane or line: light is that of the nearest point of all
     * cells, which are the facets then */
    bool bent;
    const double *site; /* 3 a probe */
    double *site_owned;
    const void *vertex, *neighbour; /* as given: of 2 or 4 bytes an index */
    bool lazy;                      /* a cell is made when it is first asked for */
    int vertex_bytes, neighbour_bytes;
    struct volume_cell *cell; /* in Morton order; NULL: lean or fewer than 4 corners */
    void *cell_owned;
    /* with cell: the caller's number of each of them, and back; NULL where they lay in order */
    int32_t *number, *inner;
    struct volume_tree cell_tree;
    /* where cold walks begin: a cell whose middle is in each box of a grid over the sites,
     * start_side boxes a side, or in one nearby; -1: none */
    int32_t *start;
    size_t start_side;
    /* while it is made, of tetrahedra: of each leaf of their tree, whether it has facets */
    unsigned char *on_hull;
    struct volume_facet *facet; /* in Morton order */
    size_t facets;
    struct volume_tree facet_tree;
    int steps_most; /* of a walk, before the tree is asked */
    bool closed;    /* two facets of the hull meet at each edge */
    bool convex;    /* who leaves through the hull is outside */
    /* outside, light goes on along rays from the core (volume_outer.c); else that of the nearest
     * point */
    bool rays;
    /* the core: a box around centre, core[k] to either side, lattice units */
    double centre[3], core[3];
    /* along these directions, if it is turned; else along the lattice's */
    double core_axis[3][3];
    bool turned;
    /* with rays: boxes over the images of the hull's facets (volume_outer.c) */
    struct volume_tree image_tree;
    /* sight_width halves a cell, by the caller's numbers: inverse depths (sight.h);
     * NULL: every probe is seen */
    const uint16_t *sight;
    const void *stand_in; /* a probe a cell, or -1; with sight */
    int stand_in_bytes;
    void *sight_owned;
    const struct volume_beyond *beyond; /* by cell, ascending; with sight */
    size_t beyonds;
    void *beyond_owned;
    struct probe_image_facts image;
    const void *light; /* of an image */
    float light_scale;
    size_t groups;           /* of lights, of an image */
    const char *group_names; /* one behind the other, each with a 0 at its end */
    const void *group_light; /* as light; of each probe, all groups */
    size_t bytes;            /* owned */
};

/* -- cells, by internal number ---------------------------------------------------------------- */

static inline int32_t volume_index(const void *index, int bytes, size_t i)
{
    if (bytes == 4)
        return ((const int32_t *)index)[i];
    const uint16_t x = ((const uint16_t *)index)[i];
    return x == UINT16_MAX ? -1 : x;
}

/* Whether a cell is made, for who then reads it. */
static inline bool volume_is_ready(const struct volume_cell *cell)
{
    const uint64_t first = __atomic_load_n(&cell->pair[0], __ATOMIC_ACQUIRE);
    return (uint32_t)first != first >> 32;
}

/* The cell, if there are such and it is made; else NULL: what was given says the same. */
static inline const struct volume_cell *volume_made(const struct probe_volume *v, size_t cell)
{
    return v->cell && volume_is_ready(&v->cell[cell]) ? &v->cell[cell] : NULL;
}

static inline int32_t volume_vertex(const struct probe_volume *v, size_t cell, int corner)
{
    const struct volume_cell *made = volume_made(v, cell);
    return made ? made->vertex[corner]
                : volume_index(v->vertex, v->vertex_bytes,
                               (size_t)v->corners * cell + (size_t)corner);
}

static inline int32_t volume_neighbour(const struct probe_volume *v, size_t cell, int corner)
{
    const struct volume_cell *made = volume_made(v, cell);
    return made ? made->neighbour[corner]
                : volume_index(v->neighbour, v->neighbour_bytes,
                               (size_t)v->corners * cell + (size_t)corner);
}

static inline int32_t volume_number(const struct probe_volume *v, size_t cell)
{
    return v->number ? v->number[cell] : (int32_t)cell;
}

static inline const double *volume_site(const struct probe_volume *v, int32_t probe)
{
    return v->site + 3 * (size_t)probe;
}

/* Where a probe is in what the cells span. */
static inline const double *volume_span_site(const struct probe_volume *v, int32_t probe)
{
    return (v->flat ? v->flat : v->site) + 3 * (size_t)probe;
}

/* Weights and probes of a place, from the measures of a cell. */
static inline void volume_place(const struct probe_volume *v, size_t cell, const double weight[4],
                                struct probe_place *place)
{
    const struct volume_cell *made = volume_made(v, cell);
    place->cell = volume_number(v, cell);
    memcpy(place->weight, weight, sizeof place->weight);
    if (made)
        memcpy(place->probe, made->vertex, sizeof place->probe);
    for (int i = 0; i < 4 && !made; i++)
        place->probe[i] = volume_vertex(v, cell, i < v->corners ? i : 0);
}

/* The box of the start grid that p is in, or is nearest to. */
static inline size_t volume_start_box(const struct probe_volume *v, const double p[3])
{
    size_t box = 0;
    for (int k = 0; k < 3; k++) {
        const double most = (double)(v->start_side - 1),
                     at = (p[k] - v->low[k]) / (v->high[k] - v->low[k]) * (double)v->start_side;
        box = v->start_side * box + (at > 0 ? (size_t)(at < most ? at : most) : 0);
    }
    return box;
}

/* Six times the volumes (twice the areas, the lengths, 1) of p with each facet of a cell, exactly;
 * p whole numbers within the sites' box. Their sum is the cell's own. */
void volume_measure(const struct probe_volume *v, size_t cell, const double p[3],
                    lattice_volume volume[4]);

/* The corners of the facet opposite a corner, counter-clockwise from outside; of cells with fewer
 * corners, the last is repeated. Returns how many differ. */
int volume_facet_vertex(const struct probe_volume *v, const struct volume_facet *facet,
                        int32_t vertex[3]);

/* The corners of a tetrahedron's face opposite each corner, counter-clockwise from outside. */
extern const int volume_facet_corner[4][3];

/* -- walking (volume_walk.c) ------------------------------------------------------------------ */

/* Lattice coordinates of a point, not rounded; one that is beyond reach is brought nearer, in its
 * direction, and how far it is (scene units) returned; else 0. */
double volume_coordinates(const struct probe_volume *v, const double point[3],
                          double coordinates[3]);

/* -- sight (volume_sight.c) ------------------------------------------------------------------- */

/* Whether sight and stand_in are what they may be; true where there are none. */
enum probe_status volume_check_sight(const struct probe_volume *v, size_t *row);

/* What is known of the outside at a cell, by the caller's number; NULL: nothing stands there. */
const struct volume_beyond *volume_beyond_of(const struct probe_volume *v, int32_t cell);

/* Takes weight from the corners that a place's point does not see. */
void volume_see(const struct probe_volume *v, struct probe_place *place);

/* The same of a point outside of the hull, p in lattice coordinates. */
void volume_see_outside(const struct probe_volume *v, const double p[3], struct probe_place *place);

/* -- outside (volume_outer.c) ----------------------------------------------------------------- */

/* Finds the core that the hull's rays come from. Leaves v->rays false where there is none. */
enum probe_status volume_outer_init(struct probe_volume *v);

/* The ray that a corner of the hull sends out. */
void volume_outer_ray(const struct probe_volume *v, int32_t probe, double ray[3]);

/* The place of a point outside, in lattice coordinates (not rounded). Returns whether it is certain
 * to be outside, which only rays tell: a point of the hull's inside gets a place as well. */
bool volume_outer(const struct probe_volume *v, const double p[3], struct probe_place *place);

/* -- tetrahedra (volume_tetra.c) -------------------------------------------------------------- */

/* Makes the cells, their tree and where walks start, of indices that are in range. Not sure: a cell
 * may have no positive volume, or not share its face with a neighbour that it names. */
enum probe_status volume_tetra_make(struct probe_volume *v, bool *sure);

/* Where cells are lazy: from now on they are asked for. */
enum probe_status volume_tetra_end(struct probe_volume *v);

/* Makes a cell that is not ready. Any thread: the first that asks puts it where it belongs, others
 * that ask meanwhile get it in *own. */
const struct volume_cell *volume_make_ready(const struct probe_volume *v, size_t cell,
                                            struct volume_cell *own);

static inline const struct volume_cell *volume_ready(const struct probe_volume *v, size_t cell,
                                                     struct volume_cell *own)
{
    const struct volume_cell *there = &v->cell[cell];
    return volume_is_ready(there) ? there : volume_make_ready(v, cell, own);
}

/* -- making (volume_make.c) ------------------------------------------------------------------- */

/* Ends the making of a volume that went as `status` says so far: checks what was given (sites,
 * cells), makes all else and puts v into *volume; on an error, that of before too, destroys it. */
enum probe_status volume_finish(struct probe_volume *v, enum probe_status status, size_t *row,
                                struct probe_volume **volume);

#endif
