/* surface: a scene's triangles in world coordinates, one colour each, for looking at.
 */
#ifndef SURFACE_H
#define SURFACE_H

#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;

/* Owned arrays; starts as {0}. */
struct surface {
    double *position; /* 3 * vertex_count, instances placed */
    size_t vertex_count;
    int32_t *index; /* 3 * triangle_count */
    size_t triangle_count;
    float *albedo, *emission; /* 3 * triangle_count, at the triangle's centre */
    int32_t *material;        /* triangle_count: of the scene */
};

struct error *surface_create(struct surface *surface, const struct scene *scene);
void surface_clear(struct surface *surface);

#endif
