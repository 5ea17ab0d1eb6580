/* SPDX-License-Identifier: Apache-2.0 */
/* sky: directions towards the bright parts of a sky picture.
 *
 * A sun in a picture is a few texels that hold most of the light; rays that escape by chance seldom
 * meet them. sky_sample draws a texel with probability in proportion to the luminance that arrives
 * from it, and a direction uniformly within it; sky_density is the density of that, for multiple
 * importance sampling (Pharr, Jakob and Humphreys, "Physically based rendering", 4th ed., 12.5.2).
 * A sky without a picture, or whose picture is even enough for chance, has `rows` 0, and costs
 * nothing.
 */
#ifndef SKY_H
#define SKY_H

#include "scene/scene.h"

struct error;

struct sky {
    uint32_t rows, columns;
    const struct scene_sky *axes; /* borrowed: of the picture */
    /* cumulative share of the rows above and with each, last is 1; owned, and so are: */
    double *row;
    double *texel; /* the same within each row */
    double *edge;  /* y of a direction at the lower edge of each row */
};

struct error *sky_init(struct sky *sky, const struct scene *scene);
void sky_clear(struct sky *sky);

/* A direction by x and y, uniform in [0, 1), and its density per solid angle. Needs rows > 0. */
struct vec3f sky_sample(const struct sky *sky, double x, double y, float *density);
float sky_density(const struct sky *sky, struct vec3f direction);

#endif
