/* SPDX-License-Identifier: Apache-2.0 */
/* interpolate_kind: the kinds of interpolation, behind one interface.
 *
 * A kind is a row of interpolate_kinds[] and lives in a file with those that blend the same things:
 * interpolate_cells.c, interpolate_scattered.c, interpolate_nodes.c. interpolate.c opens what a
 * kind needs, and asks it for the rest.
 */
#ifndef INTERPOLATE_KIND_H
#define INTERPOLATE_KIND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct interpolate;
struct probe_place;

struct interpolate_kind {
    const char *name;     /* of --interpolate */
    bool needs_cells;     /* places are found in the volume */
    bool needs_gradients; /* in->gradient is there */
    bool skips_unknown;   /* probes without a value are as if they were not there */
    bool has_radius;      /* settings' radius and falloff are its own */
    /* Makes in->own of the probes; after an error, too, close frees what there is. NULL: it has
     * nothing of its own. */
    struct error *(*open)(struct interpolate *in, size_t probes);
    void (*close)(void *own);
    /* Of surfaces: the same, and value and width, of in->image; and packs what in->own is of, with
     * *size 0 or too little only telling the size. NULL: packed files are of cells. */
    struct error *(*open_packed)(struct interpolate *in);
    struct error *(*pack)(const struct interpolate *in, enum probe_packing packing, size_t *size,
                          void *image);
    /* Without cells: whether a point is inside of what the probes span. NULL: there is no outside.
     */
    void (*find)(const struct interpolate *in, const double point[3], struct probe_place *place);
    /* Of surfaces: values at a point with a unit normal (interpolate_surface). NULL: of points. */
    struct error *(*surface)(const struct interpolate *in, const double point[3], const double n[3],
                             float *out, bool *covered);
    /* With surface: brings nearer what it will read (interpolate_fetch_surfaces). */
    void (*fetch)(const struct interpolate *in, size_t count, const double *point, const double *n,
                  size_t stride);
    /* The values at a point. NULL: the probes of the place blended with its weights. */
    struct error *(*at)(const struct interpolate *in, const double point[3],
                        const struct probe_place *place, float *out);
};

/* Whether the place's weights are all there is to it: then they tell noise as well, and a packed
 * file holds what is needed. */
static inline bool interpolate_kind_is_plain(const struct interpolate_kind *kind)
{
    return !kind->at;
}

extern const struct interpolate_kind *const interpolate_kinds[]; /* all; NULL after the last */

/* What interpolate_barycentric and interpolate_cubic are along a column (interpolate_along.c). */
extern const struct interpolate_kind interpolate_along_linear, interpolate_along_cubic;

/* The kind of that name; NULL: there is none. */
const struct interpolate_kind *interpolate_kind_find(const char *name);

/* "barycentric, gradient or cubic": the names of all kinds, or of those that need cells; last:
 * between the last two. */
void interpolate_kind_names(char *text, size_t size, bool need_cells, const char *last);

/* For kinds: whether a probe's value is known, the error that one's is not, and of which probe with
 * a weight something is not known where a blend is NaN (NULL: none). */
bool interpolate_has(const struct interpolate *in, size_t probe);
struct error *interpolate_unknown(const struct interpolate *in, int32_t probe);
struct error *interpolate_missing(const struct interpolate *in, const struct probe_place *place);

#endif
