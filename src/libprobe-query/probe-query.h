/* SPDX-License-Identifier: Apache-2.0 */
/* probe-query: the light that probe-tools baked, at any point, for programs that draw moving
 * things.
 *
 * A volume is the probes' positions and the cells between them. Ask it for the place of a point:
 * the cell around it, the cell's probes and their weights. Blend what the probes hold with these
 * weights, and that is the light there:
 *
 *     struct probe_volume *volume;
 *     struct probe_place place = {.cell = PROBE_COLD};   one for each thing that moves: it
 *                                                        remembers the cell
 *     float sh[27], rgb[3];
 *
 *     status = probe_volume_open(&volume, file, size, 0, NULL);   a packed file, in memory or
 *                                                                 mapped
 *     each frame:
 *         probe_volume_locate(volume, position, &place);
 *         probe_volume_light(volume, &place, sh);
 *         probe_irradiance(3, sh, normal, rgb);
 *     probe_volume_destroy(volume);
 *
 * or, from arrays of your own instead of a packed file: probe_volume_create, and probe_blend in
 * place of probe_volume_light.
 *
 * No call prints, exits, or keeps state elsewhere. A volume is read-only once it is made: any
 * number of threads may ask it at once, without locks, each with places of its own. What is given
 * to a volume must outlive it; nothing of it is copied but what is said below.
 *
 * The same point gives the same bytes, whatever cell the search began in. Light is continuous on
 * the faces of cells and across the hull; outside of it, too, where the hull is convex or light
 * goes on along rays (PROBE_EXTEND). Positions are in scene units, right-handed; colour is linear
 * RGB; SH are real and orthonormal with positive constants in the first band, coefficient-major,
 * colour fastest: sh[3 * (l * (l + 1) + m) + channel] (man probe-tools).
 */
#ifndef PROBE_QUERY_H
#define PROBE_QUERY_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum probe_status {
    PROBE_OK,
    PROBE_NO_MEMORY,
    PROBE_BAD_ARGUMENT, /* counts or numbers of corners that cannot be */
    PROBE_NO_CELLS,
    PROBE_BAD_POSITION, /* row: of a probe whose position is not finite */
    PROBE_BAD_VERTEX,   /* row: of a cell that names a probe that does not exist */
    /* row: of a cell whose neighbour does not exist or does not share the face */
    PROBE_BAD_NEIGHBOUR,
    PROBE_BAD_SHAPE,    /* row: of a cell that is flat or inside out */
    PROBE_BAD_POINT,    /* a point that is not finite */
    PROBE_NOT_AN_IMAGE, /* it does not start as a packed file does, or is of a later version */
    PROBE_BAD_IMAGE,    /* it is cut short, or its checksum or counts are wrong */
    PROBE_BAD_SIGHT,    /* row: of a cell whose sight is not finite, or stand-in no probe */
    PROBE_NO_DISCS,     /* no surface probe has a disc; or none faces as a point does */
    PROBE_BAD_DISC,     /* row: of a probe whose normal or irradiance is not finite */
    PROBE_DISCS_APART,  /* they are too far from one another */
    PROBE_DISCS_LARGE,  /* they are too large for that */
    PROBE_NO_GROUPS     /* a volume without groups of lights */
};

/* In English, without a full stop. */
const char *probe_status_text(enum probe_status status);

/* -- volumes ----------------------------------------------------------------------------------- */

/* The arrays of a baked stream: columns position of table probe, and vertex and neighbour of table
 * tet, tri, segment or point. */
struct probe_mesh {
    size_t probes;
    const double *position; /* 3 a probe */
    /* of a cell: 4 tetrahedra; 3, 2, 1: triangles, segments, a point, of probes in a plane, on a
     * line, in a place. Triangles of a bent sheet and segments of a walk, too: there, light is that
     * of their nearest point (man probe.5) */
    int corners;
    size_t cells;
    const int32_t *vertex;    /* `corners` a cell: its probes. Tetrahedra are right-handed */
    const int32_t *neighbour; /* `corners` a cell: the cell opposite each corner, or -1 */
};

struct probe_volume;

enum {
    /* no matrices: a point costs about three times as much, memory beside the given arrays is a
     * tenth */
    PROBE_LEAN = 1,
    /* Outside of the hull, light is that of its nearest point. But before a dent that would jump:
     * where the hull has some, light goes on along rays in cells to infinity, if these leave the
     * hull well. Or always as is said here: */
    PROBE_NEAREST = 2,
    PROBE_EXTEND = 4, /* where it can: see probe_volume_extends */
    /* all probes of a cell are blended, whatever sight a packed file holds */
    PROBE_SEE_ALL = 8,
    /* of probe_volume_open, without PROBE_LEAN: all is checked, but the matrix of a cell is made
     * when the first point comes to it: opening takes half the time, a first point in a cell one
     * and a half times as much. The light is the same, to the bit */
    PROBE_LAZY = 16
};

/* Makes a volume of arrays. Keeps the pointers to vertex and neighbour (with PROBE_LEAN, and where
 * a cell has fewer than 4 corners) or none, and copies positions. Checks every number: a mesh that
 * is not whole is refused, *volume is NULL then, and *row (if not NULL) says where. */
enum probe_status probe_volume_create(struct probe_volume **volume, const struct probe_mesh *mesh,
                                      unsigned flags, size_t *row);

/* Makes a volume of a packed file that lies at `image` (on a multiple of 8 bytes, as malloc and
 * mmap give). Positions and light are used where they lie, and so are cells with PROBE_LEAN or
 * PROBE_LAZY, and where they have fewer than 4 corners; so what lies there must not change while
 * the volume is used. Checks everything, as above. */
enum probe_status probe_volume_open(struct probe_volume **volume, const void *image, size_t size,
                                    unsigned flags, size_t *row);

/* Has a volume of probe_volume_create blend by what points see, as packed files that hold it do.
 * sight: corners * (corners - 1) a cell, of each corner towards each other one, column sight of a
 * stream; stand_in: a probe a cell, or -1, column stand_in. Both are copied. sight NULL: no more.
 * PROBE_BAD_SIGHT: *row (if not NULL) says where, and the volume blends all probes. While it is
 * called, nobody else may use the volume. */
enum probe_status probe_volume_set_sight(struct probe_volume *volume, const float *sight,
                                         const int32_t *stand_in, size_t *row);

/* Has it heed what stands outside of the hull, too; after probe_volume_set_sight, which ends it.
 * slope: 12 a cell, column sight_outside of a stream; stand_in: a probe a cell, or -1, column
 * stand_in_outside, or NULL. Cells without either cost nothing. Both are copied. slope NULL: no
 * more. PROBE_BAD_ARGUMENT: there is no sight, or cells have fewer than 4 corners. */
enum probe_status probe_volume_set_sight_outside(struct probe_volume *volume, const float *slope,
                                                 const int32_t *stand_in, size_t *row);

/* Whether places have the weights of what their points see. */
int probe_volume_sees(const struct probe_volume *volume);

void probe_volume_destroy(struct probe_volume *volume); /* NULL is legal */

size_t probe_volume_probes(const struct probe_volume *volume);
size_t probe_volume_cells(const struct probe_volume *volume);
int probe_volume_corners(const struct probe_volume *volume);

/* Whether light goes on outside of the hull along rays (1), or is that of the hull's nearest point
 * (0): where PROBE_NEAREST asks for that; where PROBE_EXTEND does not ask for rays, and the hull is
 * convex or rays would run along it; where cells have fewer than 4 corners; and where no middle of
 * the mesh sees all of its hull, as it does in what probe-tet makes. */
int probe_volume_extends(const struct probe_volume *volume);

/* Bytes that the volume holds beside what was given to it. */
size_t probe_volume_bytes(const struct probe_volume *volume);

/* -- places ------------------------------------------------------------------------------------ */

enum { PROBE_COLD = -1 }; /* no last cell known */

struct probe_place {
    /* in: where to start to look; out: the cell that holds the point, or the cell of the hull next
     * to it */
    int32_t cell;
    int32_t probe[4]; /* its probes; with sight, one of them may be the cell's stand-in */
    /* each >= 0, sum 1; 0 for corners that there are not. With sight, those that the point does not
     * see have none to speak of */
    double weight[4];
    int inside;      /* of the hull */
    double distance; /* from the hull's nearest point, scene units; 0 inside */
};

/* Finds the place of a point. Always ends; starting near is fast, starting anywhere is right.
 * PROBE_BAD_POINT: not finite, *place is unchanged. */
enum probe_status probe_volume_locate(const struct probe_volume *volume, const double point[3],
                                      struct probe_place *place);

/* Finds the places of `count` points at once: place[k] of the order[k]-th point, or of the k-th
 * where order is NULL. place[0].cell: where to start. point: each begins `stride` doubles behind
 * the last. PROBE_BAD_POINT: one is not finite, and nothing was found. */
enum probe_status probe_volume_locate_many(const struct probe_volume *volume, size_t count,
                                           const double *point, size_t stride,
                                           const uint32_t *order, struct probe_place *place);

/* The order in which `count` points are best looked up: order[k] is the number of the k-th, near
 * ones behind one another (along a Morton curve). point: each begins `stride` doubles behind the
 * last. room: 3 * count numbers of the caller's. */
void probe_volume_order(const struct probe_volume *volume, size_t count, const double *point,
                        size_t stride, uint32_t *order, uint64_t *room);

/* Whether points of a list, which follow one another as above, are so far from each other that
 * looking them up in order pays. */
int probe_volume_scattered(const struct probe_volume *volume, size_t count, const double *point,
                           size_t stride);

/* -- light ------------------------------------------------------------------------------------- */

/* out[k] = sum of weight times row[probe * width + k]. Probes without weight have no say, not even
 * as NaN. */
void probe_blend(const struct probe_place *place, const float *row, size_t width, float *out);

/* Irradiance, RGB, of a surface with unit normal, from the SH of radiance (order 1 to 6: 3 *
 * order^2 numbers). */
void probe_irradiance(int order, const float *sh, const float normal[3], float rgb[3]);

/* The same from SH that are convolved with the cosine already. */
void probe_irradiance_convolved(int order, const float *sh, const float normal[3], float rgb[3]);

/* -- packed files ------------------------------------------------------------------------------ */

enum probe_packing { PROBE_PACK_FLOAT, PROBE_PACK_HALF };

struct probe_image_facts {
    int order;     /* of the SH; 0: it has no light */
    int convolved; /* the SH hold the cosine's factors */
    enum probe_packing packing;
    int vertex_bytes, neighbour_bytes; /* of an index: 2 or 4 */
    size_t bytes_per_probe, bytes_per_cell, bytes;
};

/* What a volume that probe_volume_open made is packed as. All 0 for others. */
struct probe_image_facts probe_volume_image(const struct probe_volume *volume);

/* The SH at a place, from a volume that probe_volume_open made; 3 * order^2 numbers. */
void probe_volume_light(const struct probe_volume *volume, const struct probe_place *place,
                        float *sh);

/* Packs a volume with the SH of its probes (3 * order^2 a probe; order 0: none) into `image` (on a
 * multiple of 8 bytes); probes of no cell are left out. Returns the bytes that it takes; writes
 * only where `size` is enough, so that a first call with size 0 asks for it. Returns 0 when memory
 * is short, a coefficient is not finite, or there is no such order or packing. */
size_t probe_volume_pack(const struct probe_volume *volume, int order, const float *sh,
                         int convolved, enum probe_packing packing, void *image, size_t size);

/* -- groups of lights ------------------------------------------------------------------------- */

/* What `probe-query --pack half --groups` writes holds the light of each group of lights beside all
 * of it (probe-capture --groups). Lamps are dimmed, switched and coloured by weights, three numbers
 * a group, red, green and blue: the light is the sum over groups of weight times what the group
 * gives. Weights are finite; below 0, light is taken away.
 *
 *     when lamps change:  probe_volume_relight(volume, weight, lit);
 *     each frame:         probe_volume_locate(volume, position, &place);
 *                         probe_blend(&place, lit, 3 * order * order, sh);
 */

/* How many there are: 0 where the volume is of arrays or a packed file without. */
size_t probe_volume_groups(const struct probe_volume *volume);

/* The name of a group, from 0, which lives as long as the packed file; NULL: there is none of that
 * number. */
const char *probe_volume_group_name(const struct probe_volume *volume, size_t group);

/* The light of all probes under these weights into sh, of the caller's: 3 * order^2 numbers a
 * probe, the rows that probe_blend takes. Groups whose weights are 0 take no time. To the bit what
 * probe-relight makes of a stream, where the file is of floats. PROBE_NO_GROUPS; and
 * PROBE_BAD_ARGUMENT: a weight is not finite. Nothing is written then. */
enum probe_status probe_volume_relight(const struct probe_volume *volume, const float *weight,
                                       float *sh);

/* The same at one place, without light of all probes: 3 * order^2 numbers, to rounding what
 * probe_blend gives after probe_volume_relight; 0 where there are no groups. Takes about as long as
 * probe_volume_light for each group whose weights are not 0. */
void probe_volume_light_weighted(const struct probe_volume *volume, const struct probe_place *place,
                                 const float *weight, float *sh);

/* Groups of lights: names of a-z 0-9 _ -, 4096 at the most, and SH of their light, of the order of
 * all light: 3 * order^2 a probe. */
struct probe_groups {
    size_t count;
    const char *const *name;
    const float *const *sh;
};

/* probe_volume_pack with groups (NULL, or a count of 0: none). Returns 0 for a bad name as well, or
 * groups without light (order 0). */
size_t probe_volume_pack_groups(const struct probe_volume *volume, int order, const float *sh,
                                int convolved, enum probe_packing packing,
                                const struct probe_groups *groups, void *image, size_t size);

/* -- surfaces ---------------------------------------------------------------------------------- */

/* Probes on surfaces, each an oriented disc with irradiance: what probe-query --interpolate discs
 * answers from, to the bit. The two sides of a sheet stay apart.
 *
 *     struct probe_surface *surface;
 *     status = probe_surface_open(&surface, file, size, NULL);
 *     each frame, for each point of what is lit:
 *         probe_surface_irradiance(surface, position, normal, 1, rgb, NULL);
 *     probe_surface_destroy(surface);
 *
 * As a volume, a surface is read-only once it is made, and no question allocates. */
struct probe_surface;

/* Columns of table probe of a captured stream of surface probes. */
struct probe_discs {
    size_t probes;
    const double *position; /* 3 a probe */
    const float *normal;    /* 3 a probe, of any length; 0 0 0: it answers nothing */
    /* of the disc: twice column radius. NaN, or not above 0: the probe answers nothing */
    const float *radius;
    const float *irradiance; /* RGB, 3 a probe */
};

/* Makes a surface of arrays. Keeps irradiance, and nothing else. Refuses probes with a radius whose
 * other numbers are not finite: *row (if not NULL) says where. */
enum probe_status probe_surface_create(struct probe_surface **surface,
                                       const struct probe_discs *discs, size_t *row);

/* Makes a surface of a packed file that lies at `image`, on a multiple of 8 bytes. Discs are used
 * where they lie, and so is irradiance in floats; halves become floats. Checks everything. */
enum probe_status probe_surface_open(struct probe_surface **surface, const void *image, size_t size,
                                     size_t *row);

void probe_surface_destroy(struct probe_surface *surface); /* NULL is legal */

/* Probes that have discs. */
size_t probe_surface_probes(const struct probe_surface *surface);

/* Bytes that the surface holds beside what was given to it. */
size_t probe_surface_bytes(const struct probe_surface *surface);

/* Irradiance, RGB, at a point of a side with a unit normal, by discs whose weight falls to their
 * rims with this power: 1, 2 or 3. Where none covers it, that of the nearest; *covered (if not
 * NULL) is 1 or 0. PROBE_NO_DISCS: none faces as it does, and rgb is 0; PROBE_BAD_POINT: point or
 * normal is not finite; PROBE_BAD_ARGUMENT: there is no such power. */
enum probe_status probe_surface_irradiance(const struct probe_surface *surface,
                                           const double point[3], const float normal[3],
                                           int falloff, float rgb[3], int *covered);

/* Packs a surface into `image` (on a multiple of 8 bytes), as probe_volume_pack does a volume.
 * Returns 0 where there is no such packing. */
size_t probe_surface_pack(const struct probe_surface *surface, enum probe_packing packing,
                          void *image, size_t size);

#ifdef __cplusplus
}
#endif

#endif
