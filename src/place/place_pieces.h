/* SPDX-License-Identifier: Apache-2.0 */
/* place_pieces: what the sides of a scene's surface say of inside and outside.
 *
 * A closed piece whose faces look outward encloses matter: whoever sees its back is in it, whatever
 * stands in its box. It is a room all the same when what it encloses is used: when a lamp within
 * looks at its backs, when other pieces within fill it as furniture does, or when there is any such
 * and nearly all probes are within. A closed piece whose faces look inward is a room, and whoever
 * sees its back is outside of it, in the void; but when a lamp looks at its backs it was turned
 * inside out, and so was an empty one that fronts of others look at: it is a thing in their air.
 * Open pieces are sheets, which have air before them and the ground, or the void, behind.
 *
 * A shell that keeps its distance around all else is a sky, and looking at it is looking at
 * nothing. Where closed pieces between the backs of others look inward as those do, or a ground
 * looks away from closed pieces that look inward, or these are walls, with rooms behind them that
 * are much larger than the space before them along all three axes, the whole file is turned inside
 * out.
 *
 * Nothing is known from the sides of open pieces whose faces look to both sides, of closed ones
 * that enclose nothing, of waters (flat sheets that hills rise through), of surfaces with holes
 * (leaves) and of lamps, nor from the backs of sheets that the file calls two-sided, unless it says
 * so of all (an exporter's default). Rays look through them for backs of sheets and rooms.
 */
#ifndef PLACE_PIECES_H
#define PLACE_PIECES_H

#include "math/vec.h"
#include "scene/scene.h"
#include "topology/solids.h"
#include "trace/trace.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct place;
struct warnings;

/* Rays around a point: any first 8, 16, 32 of the ways go to all sides, and so do all. */
enum { PLACE_WAYS = 64 };

enum piece_kind { PIECE_SHEET, PIECE_SOLID, PIECE_ROOM, PIECE_UNKNOWN };

struct place_pieces {
    const struct tracer *tracer;
    const struct scene_solids *solids; /* the tracer's */
    enum piece_kind *kind;
    bool *turned; /* by piece: its fronts are backs */
    bool *sky;    /* by piece: a shell far around all else, like nothing when seen from within */
    bool two_sided_means; /* not all sheets are called two-sided */
    struct vec3 up;       /* where sheets look for the most part, Y where they look everywhere */
    bool upside_down;     /* sheets look down along Y or Z for the most part, */
    bool no_ceiling;      /* and nothing is below them */
    double (*target)[3];  /* points on the surface, PLACE_TARGETS, evenly by area */
    struct vec3 way[PLACE_WAYS]; /* unit */
};
enum { PLACE_TARGETS = 64 };

/* Judges the pieces of the tracer's scene; the tracer must outlive them. place: the probes. */
struct error *place_pieces_find(struct place_pieces *pieces, const struct tracer *tracer,
                                const struct place *place, struct warnings *warnings);
void place_pieces_clear(struct place_pieces *pieces);

enum sight {
    SIGHT_ESCAPED, /* no surface */
    SIGHT_UNKNOWN, /* one that tells nothing */
    SIGHT_HULL,    /* a solid's front */
    SIGHT_FRONT,   /* another's */
    SIGHT_LAMP,    /* a front that emits */
    SIGHT_SOLID,   /* the back of a closed piece, from within its matter */
    SIGHT_VOID,    /* of a room, from outside of it */
    SIGHT_BEHIND   /* of a sheet */
};
enum { SIGHTS = SIGHT_BEHIND + 1 };

/* What a ray meets first, and of which piece unless it escaped. through: the same, but where that
 * tells nothing, the back of a sheet or a room that is met beyond, or nothing where none is. */
struct place_sight {
    enum sight what, through;
    size_t piece, material;
    struct trace_hit hit;
};
struct place_sight place_sight(const struct place_pieces *pieces, const double from[3],
                               struct vec3 direction);

#endif
