/* SPDX-License-Identifier: Apache-2.0 */
/* seen: of which probes light is blended at a point that sees some of its cell's.
 *
 * A query will do so by the sight of the cell (leak/sight.h), which rays around each probe are
 * fitted to. Where a few points of each cell are asked for alone, and cells change all the time, a
 * ray from each point to each corner says the same for a tenth of the time, without what the fit
 * cannot hold.
 */
#ifndef SEEN_H
#define SEEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct tracer;

enum { SEEN_KNOWN = 16 }; /* a power of two */

/* Which probes candidates are known to see: of each candidate the last few that were asked for, as
 * the probe + 1 and the bits of a float, 32 each. Any thread may write: what it keeps is what any
 * other would find. Candidates must stay where they are. Starts as {0}. */
struct seen_known {
    _Atomic uint64_t *of; /* SEEN_KNOWN a candidate; owned */
    size_t count, room;
};

/* Makes room for so many candidates. */
struct error *seen_reserve(struct seen_known *known, size_t count);
void seen_clear(struct seen_known *known);

/* Points, and cells of some of them; borrowed. */
struct seen_world {
    const struct tracer *tracer;
    const double *position; /* 3 a candidate */
    const uint32_t *probe;  /* candidates */
    /* probes, and cells beside, 4 a cell */
    const int32_t *vertex, *neighbour;
    struct seen_known *known; /* of the candidates */
};

/* What the light at a candidate is blended of. */
struct blend {
    int32_t cell;     /* that holds it, or that of the hull next to it */
    bool inside;      /* of the hull */
    bool hidden;      /* something is in the way of a corner that has weight */
    bool stood_in;    /* no corner to speak of is seen: another probe answers */
    uint32_t from[4]; /* candidates, that are probes */
    double weight[4]; /* sum 1 */
};

/* The visibility of one candidate from another, 0 to 1. */
double seen_by(const struct seen_world *world, uint32_t a, uint32_t b);

/* The same, 32 bits of it, of a probe, which others will ask for as well: it is kept. */
double seen_probe(const struct seen_world *world, uint32_t x, uint32_t probe);

/* Takes off the weights of corners that candidate x does not see. Where none is left, the nearest
 * probe around that it sees has all. */
void seen_weigh(const struct seen_world *world, uint32_t x, struct blend *blend);

#endif
