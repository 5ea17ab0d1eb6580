/* SPDX-License-Identifier: Apache-2.0 */
/* camera: a pinhole, where its rays go and where a point falls on the picture.
 *
 * Pixel coordinates run from (0, 0), the left upper corner of the picture, to (width, height); the
 * middle of the first pixel is (0.5, 0.5). World coordinates.
 */
#ifndef CAMERA_H
#define CAMERA_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>

struct error;

struct camera {
    struct vec3 eye;
    struct vec3 right, up, forward; /* unit, at right angles */
    double half_width, half_height; /* of the picture at distance 1 */
    size_t width, height;           /* pixels */
};

/* How a camera is set up. */
struct camera_view {
    struct vec3 eye, look_at, up;
    double fov;           /* the whole vertical angle, degrees, above 0 and below 180 */
    size_t width, height; /* pixels */
};

/* Errors: nothing to look at (look_at is eye), up along the view. */
struct error *camera_init(struct camera *camera, const struct camera_view *view);

/* The unit direction through a point of the picture. */
struct vec3 camera_direction(const struct camera *camera, double x, double y);

/* Where p falls, and how far it is along the view; false where it is not before the eye. */
bool camera_project(const struct camera *camera, struct vec3 p, double *x, double *y,
                    double *depth);

#endif
