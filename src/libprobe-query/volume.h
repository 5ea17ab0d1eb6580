/* volume: what the parts of libprobe-query share (probe-query.h is its face).
 *
 *     volume.c         made and checked: the cells, their matrices, the hull
 *     volume_tree.c    trees of boxes over cells and over faces of the hull; sorting along a Morton
 * curve volume_walk.c    the cell around a point volume_outer.c   places outside the hull
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

#include <stdbool.h>

enum { VOLUME_LEAF = 4 }; /* items of a leaf of a tree */

/* A box in lattice units, rounded outward. */
struct volume_box {
    float low[3], high[3];
};

/* A binary tree over runs of VOLUME_LEAF items in their order: level 0 are the leaves' boxes, each
 * level above has half as many, the last one. */
struct volume_tree {
    struct volume_box *box; /* all levels; owned */
    size_t items;
    int levels;
    uint32_t level[34]; /* where each begins in box; [levels]: the count of boxes */
};

/* A tetrahedron, ready for a look-up: two cache lines. */
struct volume_cell {
    /* weights of corners 1, 2, 3: x plane[0] + y plane[1] + z plane[2] + plane[3], in lattice
     * units; that of corner 0 is what is left to 1 */
    double plane[4][3];
    int32_t vertex[4], neighbour[4];
};

/* A face of the hull. */
struct volume_facet {
    int32_t cell;   /* whose it is */
    int32_t corner; /* of the cell: the one opposite */
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
    const double *site; /* 3 a probe */
    double *site_owned;
    const void *vertex, *neighbour; /* as given: of 2 or 4 bytes an index */
    int vertex_bytes, neighbour_bytes;
    struct volume_cell *cell; /* in Morton order; NULL: lean or fewer than 4 corners */
    int32_t *number, *inner;  /* with cell: the caller's number of each of them, and back */
    struct volume_tree cell_tree;
    /* where cold walks begin: a cell whose middle is in each box of a grid over the sites,
     * start_side boxes a side, or in one nearby; -1: none */
    int32_t *start;
    size_t start_side;
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
    struct probe_image_facts image;
    const void *light; /* of an image */
    float light_scale;
    size_t bytes; /* owned */
};

/* -- cells, by internal number ---------------------------------------------------------------- */

static inline int32_t volume_index(const void *index, int bytes, size_t i)
{
    if (bytes == 4)
        return ((const int32_t *)index)[i];
    const uint16_t x = ((const uint16_t *)index)[i];
    return x == UINT16_MAX ? -1 : x;
}

static inline int32_t volume_vertex(const struct probe_volume *v, size_t cell, int corner)
{
    return v->cell ? v->cell[cell].vertex[corner]
                   : volume_index(v->vertex, v->vertex_bytes,
                                  (size_t)v->corners * cell + (size_t)corner);
}

static inline int32_t volume_neighbour(const struct probe_volume *v, size_t cell, int corner)
{
    return v->cell ? v->cell[cell].neighbour[corner]
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

/* -- making (volume.c) ------------------------------------------------------------------------ */

/* Checks what was given (sites, cells) and makes all else. The caller destroys the volume when this
 * fails. */
enum probe_status volume_finish(struct probe_volume *v, size_t *row);

/* -- trees (volume_tree.c) -------------------------------------------------------------------- */

enum probe_status volume_tree_init(struct volume_tree *tree, size_t items); /* makes empty boxes */
void volume_tree_clear(struct volume_tree *tree);
/* grows the box of an item's leaf */
void volume_tree_add(struct volume_tree *tree, size_t item, const double p[3]);
void volume_tree_finish(struct volume_tree *tree); /* makes the levels above */

/* Squared distance of p from a box; 0 inside. */
static inline double volume_box_square(const struct volume_box *box, const double p[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double below = (double)box->low[k] - p[k], above = p[k] - (double)box->high[k];
        const double d = below > above ? below : above;
        square += d > 0 ? d * d : 0;
    }
    return square;
}

/* Calls visit(context, item) for the items of leaves within sqrt(*square) of p, nearer boxes first;
 * visit may lower *square, and ends the search by making it negative. */
void volume_tree_search(const struct volume_tree *tree, const double p[3], double *square,
                        void (*visit)(void *context, size_t item), void *context);

/* An item of a leaf near p. */
size_t volume_tree_near(const struct volume_tree *tree, const double p[3]);

/* Interleaves the first `bits` bits (at most 21) of three numbers. */
uint64_t volume_morton(const uint32_t x[3], int bits);

/* Sorts by key, of which the lowest `bits` bits count, stably: order[k] is the number of the k-th.
 * room: 3 * count. */
void volume_sort(size_t count, const uint64_t *key, int bits, uint32_t *order, uint64_t *room);

/* -- walking (volume_walk.c) ------------------------------------------------------------------ */

/* Lattice coordinates of a point, not rounded; one that is beyond reach is brought nearer, in its
 * direction, and how far it is (scene units) returned; else 0. */
double volume_coordinates(const struct probe_volume *v, const double point[3],
                          double coordinates[3]);

/* Weights and probes of a place from the exact measures of a cell. */
void volume_place(const struct probe_volume *v, size_t cell, const double weight[4],
                  struct probe_place *place);

/* -- outside (volume_outer.c) ----------------------------------------------------------------- */

/* Finds the core that the hull's rays come from. Leaves v->rays false where there is none. */
enum probe_status volume_outer_init(struct probe_volume *v);

/* The ray that a corner of the hull sends out. */
void volume_outer_ray(const struct probe_volume *v, int32_t probe, double ray[3]);

/* The place of a point outside, in lattice coordinates (not rounded). Returns whether it is certain
 * to be outside, which only rays tell: a point of the hull's inside gets a place as well. */
bool volume_outer(const struct probe_volume *v, const double p[3], struct probe_place *place);

#endif
