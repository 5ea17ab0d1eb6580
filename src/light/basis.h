/* SPDX-License-Identifier: Apache-2.0 */
/* basis: irradiance as games store it, in other bases than SH.
 *
 * Each is a column of table probe (man probe.5, "Other bases"), made by least squares from the
 * irradiance E that a probe's SH give: it makes the integral of (E(n) - fit(n))^2 over all
 * directions n the least, colour by colour.
 *
 *     cube        ambient_cube, 6 colours: +X -X +Y -Y +Z -Z. E(n) = sum over axes of n_axis^2
 *                 times the side that n is on.
 *                 McTaggart, "Half-Life 2 / Valve Source shading", GDC 2004.
 *     dice        ambient_dice, 12 colours, one for each corner v of an icosahedron: E(n) = sum
 *                 over v . n > 0 of (0.7 (v . n)^2 / 2 + 0.3 (v . n)^4 5/6) colour. Both powers sum
 *                 to 1 in every direction.
 *                 Iwanicki and Sloan, "Ambient dice", EGSR 2017: the variant of radial basis
 *                 functions.
 *     dice-cubic  ambient_dice_cubic, 12 times a colour and its derivatives along two tangents: a
 *                 hybrid cubic Bezier triangle in the homogeneous barycentric coordinates of each
 *                 face, smooth across edges. The same paper, after Foley and Opitz, "Hybrid cubic
 *                 Bezier triangle patches", 1992.
 *     ahd         ahd, ambient colour A, highlight colour H and its unit direction d: E(n) = A +
 *                 H max(0, n . d), A and H not below 0.
 *                 Akenine-Moeller et al., "Real-time rendering", 4th ed., sec. 10.3.3.
 *
 * Corner 4 g + 2 a + b of the icosahedron has (1 - 2a) 0.850651 on axis g, (1 - 2b) 0.525731 on the
 * next one, 0 on the third (axes X, Y, Z, X, ...): the tangents are u, the unit vector of the third
 * axis, and v x u.
 *
 * Blends of probes are exact for all but ahd, whose directions do not blend.
 */
#ifndef BASIS_H
#define BASIS_H

#include <stdbool.h>
#include <stddef.h>

struct error;
struct table;

enum basis { BASIS_CUBE, BASIS_DICE, BASIS_DICE_CUBIC, BASIS_AHD, BASIS_COUNT };

enum { BASIS_WIDTH_MOST = 108 };

const char *basis_name(enum basis basis);   /* "cube", as options name it */
const char *basis_column(enum basis basis); /* "ambient_cube" */
size_t basis_width(enum basis basis);       /* floats a probe; colour runs fastest */

/* Irradiance on a surface with unit normal n. */
void basis_irradiance(enum basis basis, const float *c, const double n[3], double rgb[3]);

/* What fits probes of one order to a basis. Any thread may use it. */
struct basis_fit;
struct error *basis_fit_create(struct basis_fit **fit, enum basis basis, int order);
void basis_fit_destroy(struct basis_fit *fit);

/* Fits sh (3 n^2; convolved: irradiance) into c. */
void basis_fit_probe(const struct basis_fit *fit, bool convolved, const float *sh, float *c);

/* How far fits are from the irradiance that they were made of, in luminance, over all probes and
 * 384 directions, as shares of a probe's mean irradiance. Probes without light or with no mean do
 * not count. */
struct basis_error {
    size_t probes;
    double rms, worst;
    size_t worst_probe;
};

/* "cube,ahd" into one flag a basis; a usage error says what was expected. */
struct error *basis_parse(bool basis[BASIS_COUNT], const char *text);

/* Adds the basis's column to a table that has sh. error: NULL, or where to put how good it is. */
struct error *basis_convert(struct table *probes, enum basis basis, bool convolved, int threads,
                            struct basis_error *error);

/* Removes the columns of all bases: the light that they are of is no more. */
void basis_drop(struct table *probes);

#endif
