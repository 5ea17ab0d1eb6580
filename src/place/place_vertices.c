/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "math/vec.h"
#include "place/place_method.h"
#include "place/vertices.h"
#include "scene/scene.h"

#include <math.h>

/* The share of the diagonal of the scene's box by which probes stay off the surface, unless told
 * otherwise. */
#define OFFSET_SHARE 1e-3

/* Faces that turn less share a probe, unless told otherwise: of probes in space the two or three
 * walls of a corner do, and so one stands off them all; the sides of a sheet do not. */
#define CREASE 60
#define CREASE_VOLUME 120

struct error *place_vertices(struct place *place, const struct scene *scene, double offset,
                             double crease, bool volume, double most)
{
    struct vertices vertices = {0};
    struct error *err = vertices_find(scene, crease, &vertices);
    if (!err && !vertices.count)
        err = error_new("no face of the scene has an area: there are no vertices");
    if (!err)
        err = place_check_count((double)vertices.count, most);
    if (!err && !volume)
        err = array_create(&place->normal, 3 * vertices.count, sizeof *place->normal);
    for (size_t i = 0; i < vertices.count && !err; i++) {
        const struct vertex *v = &vertices.list[i];
        double p[3];
        vec3_store(p, vec3_fma(vec3_load(v->position), offset, vec3_load(v->normal)));
        for (size_t k = 0; k < 3 && !volume; k++)
            place->normal[3 * i + k] = (float)v->normal[k];
        err = place_append(place, p);
    }
    vertices_clear(&vertices);
    return err;
}

static const char *const sides[] = {[PLACE_FRONT] = "front", [PLACE_BOTH] = "both", NULL};

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    *row++ = (struct option_row){.name = "offset",
                                 .argument = "D",
                                 .kind = OPTION_REAL,
                                 .value = &o->offset,
                                 .least_open = true,
                                 .most = INFINITY,
                                 .given = &o->offset_given,
                                 .shown = "0.001 of the scene's diagonal; lights: 0.02",
                                 .help = "vertices, lights: how far off, in units of the scene"};
    *row++ = (struct option_row){
        .name = "crease",
        .argument = "DEGREES",
        .kind = OPTION_REAL,
        .value = &o->crease,
        .most = 180,
        .given = &o->crease_given,
        .shown = "60; with --volume 120",
        .help = "vertices: faces that turn more than this do not share a probe"};
    *row++ = (struct option_row){.name = "volume",
                                 .kind = OPTION_FLAG,
                                 .value = &o->volume,
                                 .given = &o->volume_given,
                                 .help = "vertices: probes in space, without normals"};
    *row++ = (struct option_row){.name = "faces",
                                 .kind = OPTION_FLAG,
                                 .value = &o->faces,
                                 .given = &o->faces_given,
                                 .help = "vertices: the faces between them as well, for probe-fit"};
    *row++ =
        (struct option_row){.name = "sides",
                            .argument = "WHICH",
                            .kind = OPTION_CHOICE,
                            .choices = sides,
                            .value = OPTION_ENUM(o->sides),
                            .given = &o->sides_given,
                            .help = "vertices: with --faces, front, where faces look to, or both"};
    return row;
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    if (o->sides_given && !o->faces)
        return error_usage("--sides needs --faces");
    if (o->faces && o->volume)
        return error_usage("expected one of --faces and --volume, got both");
    if (o->faces && o->reach_given)
        return error_usage("--faces needs all vertices: expected no --reach");
    return NULL;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    const struct vec3 size = vec3_sub(world->scene->box_max, world->scene->box_min);
    const double offset = o->offset_given ? o->offset : OFFSET_SHARE * vec3_length(size);
    const double crease = o->crease_given ? o->crease : o->volume ? CREASE_VOLUME : CREASE;
    if (o->faces)
        return place_faces(place, world->scene, offset, crease, (enum place_sides)o->sides,
                           world->most);
    struct error *err = place_vertices(place, world->scene, offset, crease, o->volume, world->most);
    return err ? err : place_reach_keep(place, o, world);
}

const struct place_method place_method_vertices = {.name = "vertices",
                                                   .origin = 4,
                                                   .needs_scene = true,
                                                   .reaches = true,
                                                   .rows = rows,
                                                   .check = check,
                                                   .place = place_by_options};
