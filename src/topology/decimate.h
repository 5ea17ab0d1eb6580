/* SPDX-License-Identifier: Apache-2.0 */
/* decimate: a scene of fewer triangles. */
#ifndef DECIMATE_H
#define DECIMATE_H

struct error;
struct scene;
struct warnings;

/* Takes triangles away until `share` of them is left (above 0; 1 leaves the scene as it is), those
 * first that change the surface least: quadric errors (Garland and Heckbert 1997), one order for
 * all meshes that are placed once, which become one mesh in the scene's coordinates; a mesh that is
 * placed often is decimated by itself, to the same share. Vertices that stay are where they were;
 * closed pieces stay closed. Borders, changes of material and seams of texture or colour keep their
 * course as the surface does. What stays whatever the share: emissive triangles, branches of
 * borders and seams, and borders along which other surfaces run. When more than the share is left
 * for that, it is a warning that says how much. The same scene gives the same triangles on every
 * machine. */
struct error *scene_decimate(struct scene *scene, double share, struct warnings *warnings);

#endif
