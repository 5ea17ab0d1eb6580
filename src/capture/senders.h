/* SPDX-License-Identifier: Apache-2.0 */
/* senders: points of surfaces that stand for the light which their surroundings scatter.
 *
 * What a probe gets of scattered light is the sum over senders s of T_s B_s: T_s is what it sees of
 * the surface that s stands for, projected to SH, and B_s the radiance that this surface scatters.
 * T depends on the scene's shape alone, so it is captured once (columns transfer_surfaces and
 * transfer_senders of table probe), and B follows from whatever light falls on the senders
 * (relight/radiosity.h). Based on: Akenine-Moeller et al., "Real-time rendering", 4th ed., section
 * 11.5.3, after Enlighten; there the links of a receiver are to clusters of surface patches.
 *
 * Table sender, which stands before table probe, is all that a stream holds of them:
 *
 *     position f64:3, normal f32:3, radius, area f32:1, albedo f32:3     as of surface probes
 *     place i32:1       in the order of clusters (sender_tree.h)
 *     link i32:K        clusters that the sender sees, as numbers of nodes; 0: no more
 *     share f32:K       of its half of directions, by the cosine: form factors
 *
 * Keys: transfer-surfaces K, the links of a probe and of a sender; transfer-senders, XXH3-64 of
 * what the senders are, in hexadecimal.
 */
#ifndef SENDERS_H
#define SENDERS_H

#include "capture/sender_tree.h"
#include "stream/light_columns.h"

#include <stdbool.h>

struct discs;
struct error;
struct stream_header;
struct table;

#define SENDERS_TABLE LIGHT_SENDERS_TABLE
#define SENDERS_LINKS_KEY "transfer-surfaces"
#define SENDERS_KEY LIGHT_SENDERS_KEY
#define SENDERS_TRANSFER "transfer_surfaces"
#define SENDERS_OF "transfer_senders"

enum { SENDER_LINKS_MOST = 4096 };

/* Starts as {0}. All arrays are owned. */
struct senders {
    size_t count;
    double *position;                       /* 3 a sender, scene units */
    float *normal, *radius, *area, *albedo; /* 3, 1 (scene units), 1 (squared), 3 */
    struct sender_tree tree;
    size_t links;  /* K */
    int32_t *link; /* K a sender; NULL: not captured yet, and then so is: */
    float *share;  /* K a sender */
};

/* Reads a stream of surface probes with radius, area and albedo, as probe-place poisson --areas
 * writes it, and finds their tree. Errors: what is missing, or is no number. */
struct error *senders_read(struct senders *senders, const char *path, size_t links);

/* From the table of a stream with its header, and to a table that is empty, and the header. */
struct error *senders_from_table(struct senders *senders, const struct table *table,
                                 const struct stream_header *header);
struct error *senders_to_table(const struct senders *senders, struct table *table);
struct error *senders_to_header(const struct senders *senders, struct stream_header *header);

/* Takes over the keys of senders that a header has (NULL: none). */
struct error *senders_copy_keys(struct stream_header *to, const struct stream_header *from);

/* That a table probe has these senders, as they were read. */
struct error *senders_check_same(const struct senders *senders, const struct table *table);

/* Adds the columns of links to a table probe, each K: transfer_surfaces as many values for each
 * (order^2; surfaces: 1), missing; transfer_senders. */
struct error *senders_add_columns(const struct senders *senders, int order, struct table *table);

/* That this is a table probe with the links of such senders; width: values a link. */
struct error *senders_find_columns(const struct senders *senders, const struct table *table,
                                   size_t *width);

/* The discs that say which sender stands for a place (twice radius). */
struct error *senders_discs(const struct senders *senders, struct discs **discs);

void senders_clear(struct senders *senders);

#endif
