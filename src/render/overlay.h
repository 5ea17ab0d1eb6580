/* SPDX-License-Identifier: Apache-2.0 */
/* overlay: the probes and cells of a stream, drawn over a picture of the scene, with the scene's
 * depth.
 *
 * Probes are spheres with their own light: the radiance of a white surface, E(n) / pi; probes
 * without light are grey. Cells are their edges, lines of a width in pixels. Both are cut off where
 * the scene is nearer. 4 x 4 rays a pixel.
 */
#ifndef OVERLAY_H
#define OVERLAY_H

#include "render/render.h"

struct error;
struct stream;

struct overlay_settings {
    double probe_radius; /* scene units; 0: no probes */
    double probe_share;  /* at most this share of the distance from the eye; 0: no limit */
    bool cells;
};

/* What covers a picture. */
struct overlay {
    struct picture light; /* mean radiance of the spheres in a pixel, where there are any */
    struct picture share; /* x: covered by spheres, y: by lines */
};

/* baked: NULL where the probes have no light. Makes the overlay; starts as {0}. */
struct error *overlay_init(struct overlay *overlay, const struct render *render,
                           const struct stream *stream, const struct baked *baked,
                           const struct overlay_settings *settings);
void overlay_clear(struct overlay *overlay);

/* The median distance between neighbours, by the cells' edges; without cells, the cube root of a
 * probe's share of their box. */
struct error *overlay_spacing(const struct stream *stream, double *spacing);

/* The colour of lines on a screen. */
extern const struct vec3f overlay_line;

/* A pixel with what covers it; `light` and `line` are in the pixel's own terms (exposed or not). */
struct vec3f overlay_over(const struct overlay *overlay, size_t x, size_t y, struct vec3f under,
                          struct vec3f light, struct vec3f line);

#endif
