/* SPDX-License-Identifier: Apache-2.0 */
/* sphere_rule: directions and weights whose sum is the integral over the sphere, exact for
 * polynomials of a direction's x, y and z up to degree SPHERE_RULE_DEGREE: products of three
 * spherical harmonics of bands 0 to 5, and of two.
 *
 * Gauss and Legendre's eight heights, 16 even steps around each (Abramowitz and Stegun, "Handbook
 * of mathematical functions", 25.4.29 and table 25.4): degree 15 in z, frequencies up to 15 around.
 */
#ifndef SPHERE_RULE_H
#define SPHERE_RULE_H

enum { SPHERE_RULE_COUNT = 128, SPHERE_RULE_DEGREE = 15 };

/* The i-th unit direction, i < SPHERE_RULE_COUNT; its weight (sr). All weights sum to 4 pi. */
double sphere_rule(int i, double direction[3]);

#endif
