/* SPDX-License-Identifier: Apache-2.0 */
/* thin: probes that span space by noise alone: nearly on a line, in a sheet, or along a walk.
 *
 * Delaunay cells of such probes are slivers from noise to noise, of probes that are far from each
 * other. So they are put into the line or plane that they lie near (libprobe-query/span.h), or
 * strung along the walk that they make, and the share of their spacing by which they stand off it
 * is told.
 *
 * Few samples of probes and their neighbours along the canonical order tell whether a set may be
 * thin at all; others pay for nothing else.
 */
#ifndef THIN_H
#define THIN_H

#include "libprobe-query/span.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct sites;
struct tetra;

/* What samples look like: shares of them whose neighbours are as on a line, as in a sheet. */
struct thin_look {
    double line, sheet;
};
struct thin_look thin_look(const struct sites *sites);
bool thin_may_be_line(const struct thin_look *look);
bool thin_may_be_sheet(const struct thin_look *look);

/* Turns a frame of the sites so that it faces what is a sheet around each of them, if together it
 * may be anything else: a long strip that goes up and down has its own middle plane on edge. */
void thin_face(const struct sites *sites, struct span_frame *frame);

/* The sites where they fall in a plane (corners 3) or line (2): sites of their own, whose rows
 * are borrowed. *apart: no two fall together. The caller clears with thin_clear. */
struct error *thin_flatten(const struct sites *sites, int corners, const struct span_frame *frame,
                           struct sites *flat, bool *apart);
void thin_clear(struct sites *flat);

/* By how much sites stand off their line, as a share of the median gap between them along it. */
struct error *thin_off_line(const struct sites *flat, const struct span_frame *frame,
                            double *share);

/* By how much sites stand off the sheet that triangles make of them, as a share of their spacing,
 * the median distance of a nearest neighbour: what 19 of 20 stay below, and the most. Off a site
 * that is straight above or below, and off a plane
 * through a site's neighbours, which may be steep, as a ramp, but not steeper than 70 degrees: then
 * heights count in full. */
struct thin_off {
    double most_of, most, spacing; /* spacing: steps */
};
struct error *thin_off_sheet(const struct tetra *triangles, const struct sites *sites,
                             const struct sites *flat, const struct span_frame *frame,
                             struct thin_off *off);

/* The segments of a walk, if the sites are one, from their Delaunay cells: their minimum spanning
 * tree, and edges of the relative neighbourhood graph that close rings. *walk (2 * *count, owned by
 * the caller) is NULL where they are not: fewer than 8, more than every seventh at a fork, or more
 * than every fifth at a bend of more than 60 degrees; of fewer than 16, any. */
struct error *thin_walk(const struct tetra *cells, const struct sites *sites, int32_t **walk,
                        size_t *count);

/* Of tetrahedra, the share that are noise of lines or sheets: flat ones, of probes which are more
 * than THIN_FAR times as far from each other as from their neighbours. Of a sample, by number (of
 * those in thin parts, if these are a tenth) and by volume. */
#define THIN_FAR 4.5
struct thin_far {
    double cells, volume;
};
struct thin_far thin_far(const struct tetra *tetra, const struct sites *sites);

/* Of each site, how far its second neighbour is, 0 where it is not in a sheet: by sites, owned by
 * the caller. */
struct error *thin_sheets(const struct sites *sites, double **spacing);

#endif
