/* SPDX-License-Identifier: Apache-2.0 */
/* compressed: how a stream says that the parts of its light are stored as a few numbers a probe
 * (pca.h, man probe.5).
 *
 * Table `basis`, which stands before table `probe`, has the parts' columns in its place: 1 + K rows
 * a cluster, its mean and then its vectors. Column pca, f32:K, of a probe says what the vectors are
 * multiplied by; column pca_cluster, i32:1, of which cluster. Key pca-basis is a hash of the table
 * and of the keys that say how light is written, so that light which was turned, cut or convolved
 * since, or probes of another basis, are not taken for what they are not; key pca-error is what was
 * lost, as a share.
 */
#ifndef COMPRESSED_H
#define COMPRESSED_H

#include "stream/light_columns.h"

struct stream_header;

#define COMPRESSED_TABLE LIGHT_BASIS_TABLE
#define COMPRESSED_KEY LIGHT_BASIS_KEY
#define COMPRESSED_ERROR_KEY "pca-error"
/* of a stream that was relit */
#define COMPRESSED_RELIT_ERROR_KEY "relit-pca-error"

enum { COMPRESSED_KEY_ROOM = 17 };

/* The value of the key: XXH3-64, in hexadecimal. */
void compressed_key(const struct stream_header *header, const struct table *basis,
                    char text[COMPRESSED_KEY_ROOM]);

#endif
