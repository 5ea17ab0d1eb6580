/* SPDX-License-Identifier: Apache-2.0 */
/* rotate: SH turned, and streams with them.
 *
 * A function f on the sphere, turned by the rotation R, is f(R^-1 d). Its SH are M times those of
 * f, M_ij = integral of Y_i(R d) Y_j(d): a block of (2l+1)^2 a band, since a rotation leaves the
 * band (Ivanic and Ruedenberg, "Rotation matrices for real spherical harmonics", J. Phys. Chem.
 * 100, 1996, and 102, 1998, define it and give a recurrence). Here the integral is taken by a rule
 * that is exact for it (math/sphere_rule.h): a few microseconds, with nothing to go wrong in signs.
 *
 * M is orthogonal, that of a composition is the product, and M of the identity is 1, all to
 * rounding. A standard error is turned as that of independent coefficients: e_i'^2 = sum over j of
 * M_ij^2 e_j^2.
 */
#ifndef ROTATE_H
#define ROTATE_H

#include "libprobe-query/sh.h"

#include <stdbool.h>

struct error;
struct stream;
struct warnings;

struct rotation {
    double matrix[9];                      /* R, a row after the other */
    double cone[4][4];                     /* R, and 1: of a direction and a number that stays */
    double sh[SH_COUNT_MAX][SH_COUNT_MAX]; /* M: 0 between bands */
};

/* Makes it from R. An error where R is no rotation: rows that are not of length 1 and at right
 * angles within 1e-5, or one that mirrors (its determinant is -1). What is off by less is made
 * right; entries within 1e-15 of a whole number are that number, so that a quarter turn keeps a
 * grid one. */
struct error *rotation_init(struct rotation *rotation, const double matrix[9]);

/* R from an option's "X,Y,Z,DEGREES", an axis of any length and an angle, counter-clockwise seen
 * from where the axis points to; or from nine numbers. The usage error names the option where
 * numbers are none. */
struct error *rotation_parse(double matrix[9], const char *option, const char *text);

/* out = M in, `channels` numbers a coefficient; n^2 of them. */
void rotation_sh(const struct rotation *rotation, int order, int channels, const double *in,
                 double *out);

/* The keys that say how a stream's probes were turned (a stream whose light is of a scene alone
 * has it), and by how much further their light alone. Nine numbers each. */
#define ROTATED_KEY "rotated"
#define ROTATED_LIGHT_KEY "rotated-light"

/* Turns a stream about the origin: positions, normals, and all that knows directions; or, with
 * light_only, what comes to each probe, which stays where it is. What fits the scene no more is
 * said by the keys, which go again where all is turned back. Bases go, with a warning. Probes
 * without light are left without. Errors: nothing to turn; light_only of surface probes, whose
 * irradiance is of one normal. */
struct error *rotate_stream(struct stream *stream, const struct rotation *rotation, bool light_only,
                            struct warnings *warnings);

#endif
