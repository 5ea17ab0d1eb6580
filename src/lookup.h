/* lookup: the light of a baked stream at a point, as renderers ask for it: irradiance for a normal.
 *
 * All that a renderer knows of cells, interpolation and SH is behind these calls.
 */
#ifndef LOOKUP_H
#define LOOKUP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct locate;
struct stream;

enum { LOOKUP_COLD = -1 };

/* Borrows the stream's columns. */
struct lookup {
    struct locate *locate; /* NULL: probes alone, for lookup_probe */
    const float *sh;
    size_t width, probes;
    int order;
    bool convolved;
};

/* Errors: no light (says to run probe-capture), a probe without it; cells asked for: no cells (says to run probe-tet). */
struct error *lookup_create(struct lookup *lookup, const struct stream *stream, bool cells);
void lookup_clear(struct lookup *lookup);

/* Irradiance at p (finite) on a surface with the unit normal n. *cell: LOOKUP_COLD, or the cell of a point nearby. Bands that were cut
 * off can make irradiance negative: it is 0 there. */
void lookup_irradiance(const struct lookup *lookup, int32_t *cell, const double p[3], const double n[3], double rgb[3]);

/* The same from one probe alone. */
void lookup_probe(const struct lookup *lookup, size_t probe, const double n[3], double rgb[3]);

#endif
