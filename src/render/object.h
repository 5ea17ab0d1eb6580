/* SPDX-License-Identifier: Apache-2.0 */
/* object: a thing that moves through a scene, and is lit by its probes.
 *
 * It is added to a finished scene as instances of its own, which are then placed anew for every
 * picture; a tracer is made of each.
 */
#ifndef OBJECT_H
#define OBJECT_H

#include "render/render.h"

struct error;
struct scene;
struct warnings;

struct object {
    struct scene *scene; /* borrowed: holds the object's instances from `first` on */
    size_t first, count;
    /* count: where each instance stands in the object's own coordinates, centred; owned */
    double (*own)[12];
    double radius; /* of the object as it is, about its centre */
    double scale;
    bool sphere;
    struct vec3 box_min, box_max; /* of the scene without it */
};

/* Adds the mesh in the file at `path` (lenient: what is broken in it is left out), or a white
 * sphere (albedo 0.8) for "sphere". radius 0: a mesh as it is, a sphere of 3 % of the scene's
 * diagonal; else that which the object is to have. Lights and sky of its file are left alone. */
struct error *object_init(struct object *object, struct scene *scene, const char *path,
                          bool lenient, double radius, struct warnings *warnings);
void object_clear(struct object *object);

/* Puts its centre (of a mesh: its box's) to p. The scene's tracer has to be made anew. */
void object_place(const struct object *object, struct vec3 p);

/* For render_picture. */
struct render_object object_at(const struct object *object, struct vec3 p, bool per_pixel);

#endif
