/* SPDX-License-Identifier: Apache-2.0 */
#include "render/camera.h"
#include "base/error.h"
#include "math/angle.h"

/* Scaled to within 1 first, so that lengths neither overflow nor vanish. */
static struct vec3 unit(struct vec3 a)
{
    const double most = fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
    return most > 0 && most < INFINITY
               ? vec3_normalize((struct vec3){a.x / most, a.y / most, a.z / most})
               : (struct vec3){0};
}

struct error *camera_init(struct camera *c, const struct camera_view *view)
{
    const struct vec3 eye = view->eye, up = view->up;
    *c = (struct camera){.eye = eye,
                         .forward = unit(vec3_sub(view->look_at, eye)),
                         .width = view->width,
                         .height = view->height};
    if (!(vec3_length(c->forward) > 0))
        return error_usage("expected --look-at other than --eye, got (%g, %g, %g) for both", eye.x,
                           eye.y, eye.z);
    const struct vec3 across = vec3_cross(c->forward, unit(up));
    if (!(vec3_length(across) > 1e-6))
        return error_usage("expected --up across the view, got (%g, %g, %g) along it", up.x, up.y,
                           up.z);
    if (!(view->fov > 0 && view->fov < 180))
        return error_usage("expected --fov above 0 and below 180 degrees, got %g", view->fov);
    c->right = vec3_normalize(across);
    c->up = vec3_cross(c->right, c->forward);
    const double half = view->fov * (ANGLE_PI / 360);
    c->half_height = angle_sin(half) / angle_cos(half);
    c->half_width = c->half_height * (double)c->width / (double)c->height;
    return NULL;
}

struct vec3 camera_direction(const struct camera *c, double x, double y)
{
    const double right = (2 * x / (double)c->width - 1) * c->half_width,
                 up = (1 - 2 * y / (double)c->height) * c->half_height;
    return vec3_normalize(vec3_fma(vec3_fma(c->forward, right, c->right), up, c->up));
}

bool camera_project(const struct camera *c, struct vec3 p, double *x, double *y, double *depth)
{
    const struct vec3 way = vec3_sub(p, c->eye);
    *depth = vec3_dot(way, c->forward);
    if (!(*depth > 0))
        return false;
    *x = (vec3_dot(way, c->right) / (*depth * c->half_width) + 1) / 2 * (double)c->width;
    *y = (1 - vec3_dot(way, c->up) / (*depth * c->half_height)) / 2 * (double)c->height;
    return true;
}
