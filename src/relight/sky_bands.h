/* SPDX-License-Identifier: Apache-2.0 */
/* sky_bands: the first bands of a sky: the SH of its radiance.
 *
 * A picture is what rays see of it (scene_sky_radiance): bilinear between texels, in the angles
 * of the panorama. Its integral with a function is a sum over texels of the texel times that of
 * its tent: around the up axis in closed form, from pole to pole by Gauss and Legendre's rule on
 * every half of a row. So a picture of a few bands is found as it is.
 */
#ifndef SKY_BANDS_H
#define SKY_BANDS_H

struct error;
struct scene_sky;

/* c: 3 * order^2, coefficient by coefficient. An error where its axes are none. */
struct error *sky_bands(const struct scene_sky *sky, int order, double *c);

/* The same of what a probe sees, as the sky of an object that stands there: the light of the one
 * probe of the stream at `path` ("-": standard input). Errors: more probes or none, no light,
 * irradiance, fewer bands than order. */
struct error *sky_bands_of_probe(const char *path, int order, double *c);

#endif
