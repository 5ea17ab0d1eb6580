/* SPDX-License-Identifier: Apache-2.0 */
/* sh: real spherical harmonics, as radiance is stored in them.
 *
 * Real and orthonormal, in polynomial form without the Condon-Shortley sign, first-band constants
 * positive (Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment
 * maps", SIGGRAPH 2001, eq. 3): Y00 = 0.282095, Y1-1 = 0.488603 y, Y10 = 0.488603 z, Y11 = 0.488603
 * x, ... Index of (l, m): l(l+1)+m. *Order n* means bands 0 .. n-1, n*n coefficients.
 *
 * RGB coefficients are coefficient-major, colour fastest: c[3 * i + channel].
 *
 * Irradiance on a surface with normal n, from the coefficients L of incident radiance:
 * E(n) = sum A_l L_lm Y_lm(n), A = pi, 2pi/3, pi/4, 0, -pi/24, 0 (the same paper, eq. 8).
 */
#ifndef SH_H
#define SH_H

enum { SH_ORDER_MAX = 6, SH_COUNT_MAX = SH_ORDER_MAX * SH_ORDER_MAX };

/* Y_lm(d) for all n*n functions of this order (1 .. SH_ORDER_MAX). d: a unit vector. Only + - * /
 * and sqrt. */
void sh_basis(int order, const double d[3], double *y);

/* The same for SH_WAVE directions at once, x y z each: y[i][k] is function i of direction k. */
enum { SH_WAVE = 64 };
void sh_basis_wave(int order, const float (*direction)[3], double (*y)[SH_WAVE]);

/* A_l, the coefficients of the clamped cosine, l = 0 .. SH_ORDER_MAX-1 (Ramamoorthi and Hanrahan
 * 2001, eq. 7). */
double sh_cosine(int l);

/* Y_00, which is the same in all directions: sqrt(1 / 4 pi). */
#define SH_Y00 0.28209479177387814

/* Adds radiance `rgb` times `weight` (solid angle, sr) from the direction whose basis is y: c +=
 * weight * rgb * y. */
void sh_project(int order, const double *y, const double rgb[3], double weight, double *c);

/* Radiance (W/m2/sr, or the lights' own unit) that the coefficients give for a direction. c:
 * 3*n*n. */
void sh_radiance(int order, const float *c, const double d[3], double rgb[3]);

/* Irradiance at a surface with unit normal n. convolved: the coefficients already hold the factors
 * A_l. */
void sh_irradiance(int order, const float *c, int convolved, const double n[3], double rgb[3]);

/* Multiplies band l of c (3*n*n) by factor[l]. */
void sh_scale_bands(int order, const double *factor, float *c);

/* The direction that light comes from, weighted by luminance: band 1 as a vector (c_11, c_1-1,
 * c_10); its length is the band's amplitude. Zero for order 1. */
void sh_dominant(int order, const float *c, double direction[3]);

/* Order from a count of floats in an `sh` column (3*n*n), or 0 when no order has it. */
int sh_order_of(unsigned long width);

#endif
