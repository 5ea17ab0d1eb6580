/* SPDX-License-Identifier: Apache-2.0 */
/* stream_fill: what one stream of probes lacks, taken from another stream of the same probes.
 *
 * A bake that was done in slices, or was cut short, is several streams of the same probes, each
 * with light for some of them. A probe is found again by its position, to the bit, and by its
 * normal where both streams have that column. Where several probes are at one place, the first of
 * one stream is the first of the other, the second the second, and so on.
 */
#ifndef STREAM_FILL_H
#define STREAM_FILL_H

#include "stream/stream.h"

struct warnings;

/* Fills the missing values of float columns of the probes of `to` from `from`, and adds the columns
 * that it lacks, but hull_normal, which belongs to cells. Values that are there stay. Keys that
 * speak of light are taken over where `to` lacks them; where both have one, they must agree, or the
 * error says which does not. Other keys are taken over, or stay with a warning. History is kept of
 * both, each line once. Other tables of `to` stay, those of `from` do not matter. Warns when probes
 * of `from` are not among those of `to`; `name` says in warnings which stream `from` is, and
 * outlives them. */
struct error *stream_fill(struct stream *to, const struct stream *from, const char *name,
                          struct warnings *warnings);

#endif
