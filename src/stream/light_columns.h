/* SPDX-License-Identifier: Apache-2.0 */
/* light_columns: which columns of a table `probe` hold light: all of it, that of a group of lights,
 * the response to light that may be.
 *
 * What is linear in light and done to one of them (fewer bands, irradiance of radiance, the light
 * of another probe) is done to them all, by going through the table's columns:
 *
 *     struct light_column what;
 *     if (light_column_of(&table->columns[i], sh_width, &what)) ... what.blocks of what.block ...
 *
 * Names: sh, sh_error, sh_gradient, irradiance, irradiance_error; sh_NAME and sh_error_NAME (and of
 * irradiance) of group NAME; transfer_sky, transfer_suns, transfer_points and their _error;
 * transfer_surfaces, and beside it transfer_senders, which is no light (man probe.5).
 */
#ifndef LIGHT_COLUMNS_H
#define LIGHT_COLUMNS_H

#include "stream/table.h"

enum light_role { LIGHT_VALUE, LIGHT_ERROR, LIGHT_GRADIENT };

struct light_column {
    enum light_role role;
    bool surface;  /* irradiance of a surface, 3 values; else SH */
    bool transfer; /* the response to light that may be; else light of the scene */
    bool group;    /* of one group alone */
    int channels;  /* 3; of what has no colour 1 */
    /* one behind the other: coefficients of what SH's order says, channels * n^2, or colours of
     * surfaces, one for each channel */
    size_t block, blocks;
};

/* Whether a column is light, by its name and type, and, where that is asked, its width: sh_width is
 * that of column sh (0: there is none). */
bool light_column_of(const struct column *column, size_t sh_width, struct light_column *what);

/* Whether a name is that of light which was split: of a group or a transfer, or of all of them
 * compressed. */
bool light_column_is_split(const char *name);

/* The table of what such parts are made of, which speaks of no probe, and the key that says that
 * there is one; and those of the points whose light probes have links to (capture/senders.h). */
#define LIGHT_BASIS_TABLE "basis"
#define LIGHT_BASIS_KEY "pca-basis"
#define LIGHT_SENDERS_TABLE "sender"
#define LIGHT_SENDERS_KEY "transfer-senders"

/* Whether a table is one of these, which stay what they are whichever probes there are. */
bool light_table_is(const char *name);

/* Whether it is of parts that are compressed: pca, pca_cluster. */
bool light_column_is_compressed(const char *name);

/* Whether a header key says into which parts light was split: group-N, transfer-sky,
 * transfer-sun-N, transfer-point-N, or how they are compressed: pca-basis, pca-error. */
bool light_key_is_split(const char *key);

/* Whether light is another where a header has the key than where it has not: a light of options,
 * what was relit, how it was turned. */
bool light_key_changes(const char *key);

#endif
