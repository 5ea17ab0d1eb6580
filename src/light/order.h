/* SPDX-License-Identifier: Apache-2.0 */
/* order: how many SH bands a stream needs.
 *
 * A surface blurs what it receives: irradiance takes band l times A_l (sh.h), so what high bands
 * hold may not be worth its bytes. The share of irradiance that order n loses is the root of
 *
 *     sum over probes, colours and l >= n of A_l^2 |L_l|^2  over  the same sum over all l,
 *
 * |L_l|^2 = sum over m of L_lm^2 - error_lm^2, since noise has energy of its own, which is not
 * light: the RMS over directions and probes of the irradiance that is missing, against that of the
 * whole (Parseval; Ramamoorthi and Hanrahan, "An efficient representation for irradiance
 * environment maps", 2001, eq. 7).
 */
#ifndef ORDER_H
#define ORDER_H

#include <stdbool.h>

struct error;
struct table;

/* The least order that loses no more than `share` of the irradiance of all probes of a table, from
 * its columns sh and sh_error (of the same order; convolved: of irradiance). *lost: the share that
 * it loses. Probes that are not captured do not count; a dark table needs order 1. */
struct error *order_least(const struct table *probes, bool convolved, double share, int *order,
                          double *lost);

/* Cuts the columns sh, sh_error, sh_gradient and visibility, where they are there, to a lower
 * order. */
struct error *order_reduce(struct table *probes, int order);

#endif
