/* SPDX-License-Identifier: Apache-2.0 */
/* content: what the SH of a stream are of: incident radiance, or irradiance, which is radiance
 * convolved with the cosine.
 *
 * Irradiance has the coefficients E_lm = A_l L_lm (sh.h). A_3 and A_5 are 0: what radiance holds in
 * these bands leaves no trace in irradiance, so irradiance can be turned back up to order 3 alone.
 * The header key sh-content says which it is (man probe.5).
 */
#ifndef CONTENT_H
#define CONTENT_H

#include <stdbool.h>

struct error;
struct stream_header;
struct table;

enum { CONTENT_RADIANCE_ORDER_MAX = 3 }; /* of radiance that can be had from irradiance */

/* convolved: the key is irradiance; false where it is missing. An error when it is something
 * else. */
struct error *content_from_header(const struct stream_header *header, bool *convolved);
struct error *content_to_header(struct stream_header *header, bool convolved);

/* Turns one probe's coefficients (3 n^2 each) from radiance into irradiance; gradient (9 n^2):
 * d/dx, d/dy, d/dz. NULL: not there. */
void content_convolve(int order, float *sh, float *error, float *gradient);

/* Multiplies band l of a block, channels * order^2 values, by factor[l]. */
void content_scale_bands(int order, int channels, const double *factor, float *block);

/* Turns all columns of a table that hold SH of light (light_columns.h) into the other kind. An
 * error where irradiance cannot be undone. */
struct error *content_convert(struct table *probes, bool from, bool to);

#endif
