/* SPDX-License-Identifier: Apache-2.0 */
/* sun_blend: a sun between those that a transfer has, and where it stands at a time.
 *
 * What a scene gives back to a sun changes little with a few degrees, but for the edges of its
 * shadows; so the answers to the stored suns are blended, with weights that sum to 1:
 *
 *     path    the suns of the list are a way, as over a day: the nearest point of the way, great
 *             arcs from each to the next, linear in the angle between the two
 *     sphere  they stand anywhere: spherical barycentric weights of the triangle of three of them
 *             that holds the sun, of all such the one that is nearest (the facet of their convex
 *             hull that the direction pierces: Delaunay's triangle); outside of all, that of the
 *             nearest way between two of them
 */
#ifndef SUN_BLEND_H
#define SUN_BLEND_H

#include <stddef.h>

struct error;

enum sun_between { SUN_PATH, SUN_SPHERE };

/* Suns that the sphere takes: what is outside of their triangles looks at all pairs. */
enum { SUN_SPHERE_MOST = 4096 };

/* weight (count): of suns towards `sun` (3 * count, unit), for one towards d, a unit vector.
 * Returns how far d is off what could be blended, in degrees. count is 1 or more. */
double sun_blend(enum sun_between between, size_t count, const double *sun, const double d[3],
                 double *weight);

/* Where a sun stands, from a file's lines: TIME AZIMUTH ELEVATION R G B: hours, or whatever grows;
 * degrees, as scene_sky_direction has them; irradiance on a surface that faces it. All are linear
 * between lines: an azimuth that passes 360 goes on to 370. Blank lines and what follows # are
 * skipped. */
struct sun_place {
    double azimuth, elevation, rgb[3];
};

/* Errors name file and line: what is no line of the kind above, times that do not grow, a colour
 * below 0; a time that the file does not have. */
struct error *sun_path_at(const char *path, double time, struct sun_place *place);

#endif
