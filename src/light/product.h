/* SPDX-License-Identifier: Apache-2.0 */
/* product: light times another function of direction that a probe has, as its own visibility of the
 * sky.
 *
 * The SH of a product are sums of triple product integrals,
 *
 *     (f g)_k = sum over i, j of f_i g_j times the integral of Y_i Y_j Y_k
 *
 * (Ng, Ramamoorthi, Hanrahan, "Triple product wavelet integrals for all-frequency relighting",
 * SIGGRAPH 2004; Akenine-Moeller et al., "Real-time rendering", 4th ed., eq. 11.30), found by a
 * rule that is exact for them (sphere_rule.h). Bands above those that are kept are lost. The
 * integral of
 * f g is (f g)_0 / Y_00, the dot product of their SH.
 */
#ifndef PRODUCT_H
#define PRODUCT_H

#include <stddef.h>

struct error;
struct stream;
struct warnings;

/* product (channels * order^2) becomes the SH of f times g: f is of as many channels, g of one
 * (of_order^2), for all of them. product may be f. */
void product_sh(int order, int channels, const float *f, int of_order, const float *g,
                float *product);

/* Multiplies the radiance of all columns of light (light_columns.h) by a column of SH of each
 * probe. Probes without one of the two have no light. Errors, gradients, windows and other bases
 * go, with a warning. Errors: no such column, or not of n^2 numbers; irradiance; compressed
 * light. */
struct error *product_stream(struct stream *stream, const char *column, struct warnings *warnings);

#endif
