/* SPDX-License-Identifier: Apache-2.0 */
/* power: logarithm, exponential and powers that come out the same on every machine.
 *
 * libm picks its instructions by the processor, so its last bit differs between machines; these use
 * + - * / alone, and frexp and ldexp, which are exact. Within 4e-16 of the true value, times 1 +
 * |x| for the exponential of x.
 */
#ifndef POWER_H
#define POWER_H

/* Natural logarithm of x > 0, finite and normal. */
double power_log(double x);

/* e^x, for |x| < 700. */
double power_exp(double x);

/* x^y for x >= 0 and y > 0; 0 for 0. */
double power_of(double x, double y);

#endif
