/* SPDX-License-Identifier: Apache-2.0 */
/* dilate: probes that stand in matter get light of those that stand in the air (Cupisz, "Light
 * probe interpolation using tetrahedral tessellations", GDC 2012, on bad probes).
 *
 * A probe in matter is black, and darkens what is blended with it where nothing asks what is seen.
 * It gets all columns of light of the nearest valid probe that it sees. From in matter it sees out
 * through the backs of surfaces, but through no front: what it sees is the air around the matter,
 * and not what is behind the next wall. Near it, a probe that it sees without that comes first.
 * Which probes are invalid is said by a condition; that they are dark says nothing.
 */
#ifndef DILATE_H
#define DILATE_H

#include <stddef.h>

struct error;
struct stream_selection;
struct table;
struct tracer;

struct dilate_count {
    size_t filled; /* probes that hold the light of another now */
    size_t unseen; /* of these, those that see no valid one near: it is that of the nearest */
};

/* Probes for which all conditions of `invalid` hold, and that have light, get that of others;
 * column filled says which: 1, else 0. Error: a condition's column is not there, there is no column
 * sh, or no probe is valid. The result does not depend on the threads. */
struct error *dilate(struct table *probes, const struct stream_selection *invalid,
                     const struct tracer *tracer, int threads, struct dilate_count *count);

#endif
