/* SPDX-License-Identifier: Apache-2.0 */
/* relight: the light of probes as a sum of parts that were captured one by one, each times a
 * weight.
 *
 * Light adds up (Akenine-Moeller et al., "Real-time rendering", 4th ed., eq. 11.36): a stream holds
 * what its probes get of each group of lights (columns sh_NAME), of a sky of each SH function
 * (transfer_sky, after Sloan et al., "Precomputed radiance transfer", SIGGRAPH 2002), of suns of
 * irradiance 1 from some directions (transfer_suns), of point lights of radiant intensity 1 at some
 * places (transfer_points). What they get of weighted groups, of a sky of these SH, of suns and of
 * points is the sum, colour by colour.
 *
 * Its standard error. Groups were captured with the same rays, so their errors know of each
 * other. Where the stream has the error of their plain sum, the correlation r, taken to be one for
 * all pairs, follows for each coefficient from
 *
 *     e^2 = sum of e_g^2 + r ((sum of e_g)^2 - sum of e_g^2);
 *
 * the weighted sum's error is then that with w_g e_g for e_g: it is right for one group, and for
 * weights that are all the same. Where it has not, r is 1, and weights their magnitudes: a bound.
 * Answers to the functions of a sky count as independent, those to neighbouring suns and points as
 * wholly dependent (a bound).
 *
 * Of a compressed stream (compressed.h) the basis is relit as probes are, which is quick, as it has
 * few rows; the light of a probe is the sum of these by the probe's few numbers, since all is
 * linear. Its parts have no errors.
 */
#ifndef RELIGHT_H
#define RELIGHT_H

#include "scene/groups.h"
#include "stream/table.h"

#include <stdbool.h>
#include <stddef.h>

struct error;
struct stream_header;
struct warnings;

enum relight_kind { RELIGHT_GROUP, RELIGHT_SKY, RELIGHT_SUN, RELIGHT_POINT, RELIGHT_KINDS };

/* A part: `width` numbers of a row from `offset` in a column. */
struct relight_part {
    enum relight_kind kind;
    size_t column, error; /* of the input's table; RELIGHT_NONE: no error is known */
    size_t offset;
    bool in_basis; /* column is of the basis, in place of the probes */
};

#define RELIGHT_NONE ((size_t)-1)

/* Starts as {0}. */
struct relight {
    /* of the header: */
    struct light_groups groups;
    bool whole;    /* it has none: its sh is one, `rest` */
    char **names;  /* of the groups; borrowed of them; the array is owned */
    int sky_order; /* of transfer_sky; 0: there is none */
    size_t suns;   /* of transfer_suns */
    double *sun;   /* 3 * suns, towards them; owned */
    size_t points; /* of transfer_points */
    double *point; /* 3 * points, where they are; owned */
    bool turned;   /* probes or their light were turned (light/rotate.h) */
    bool again;    /* sh is not the plain sum of the groups: it was relit before */
    bool compressed;
    struct table basis; /* where compressed; owned */
    /* of the table's columns: */
    bool surface;              /* irradiance, not sh */
    size_t width;              /* numbers of the light of a probe */
    struct relight_part *part; /* groups, then the sky's functions, suns, points; owned */
    size_t parts;
    size_t sum_error; /* the column of the plain sum's error, or RELIGHT_NONE */
    bool errors;      /* every part has its error */
    bool keep;        /* the parts' columns stay; set by the caller */
    /* of a basis: */
    size_t pca, cluster; /* columns; RELIGHT_NONE: there is one cluster */
    size_t vectors, clusters;
};

/* What a header says. Errors: it has nothing to be weighed; keys that are wrong. */
struct error *relight_from_header(struct relight *relight, const struct stream_header *header);

/* Takes the table of a compressed stream, which comes before the probes: *basis is empty then.
 * Errors: it is not the one that the header speaks of, or light was changed since. */
struct error *relight_take_basis(struct relight *relight, const struct stream_header *header,
                                 struct table *basis);

/* Finds the parts in table probe (no rows needed). Errors: columns that are missing, or of another
 * shape. */
struct error *relight_find(struct relight *relight, const struct table *probes);

void relight_clear(struct relight *relight);

/* How many parts the header promises: groups, sky_order^2, suns, points. */
size_t relight_parts(const struct relight *relight);

/* Makes *out (no rows) the table of the output: that of the input, its light after the weights,
 * without what is not true of that: gradients, windows, bases, with a warning. */
struct error *relight_schema(const struct relight *relight, const struct table *in,
                             struct table *out, struct warnings *warnings);

/* Removes what is of groups and transfers from a table probe (keep: not the links to senders), and
 * what is of the light as it was, with a warning. */
void relight_drop_parts(struct table *table, bool keep_links, struct warnings *warnings);

/* Fills rows first .. first+count-1 of *out, as many as *in has, from its rows; weight: 3 a part.
 * Probes without light stay so. Errors: a cluster that there is not. */
struct error *relight_rows(const struct relight *relight, const double *weight,
                           const struct table *in, struct table *out, int threads);

#endif
