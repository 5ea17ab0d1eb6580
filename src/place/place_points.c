/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "place/place_method.h"
#include "stream/points.h"

#include <math.h>

/* Unit, and all three or none. */
static struct error *append_normal(struct place *place, size_t *room, const double n[3])
{
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0) || !isfinite(length))
        return error_new("expected a normal with a length, got %g %g %g", n[0], n[1], n[2]);
    struct error *err =
        array_reserve(&place->normal, room, place->count + 1, 3 * sizeof *place->normal);
    for (size_t k = 0; k < 3 && !err; k++)
        place->normal[3 * place->count + k] = (float)(n[k] / length);
    return err;
}

struct taking {
    struct place *place;
    bool normals;
    double most;
    size_t room; /* for normals */
};

static struct error *take(void *context, const struct points *points, const double *value,
                          size_t width, size_t count)
{
    struct taking *t = context;
    if (width != 3 && !t->normals)
        return points_place(points, 0,
                            error_new("expected x y z, without a normal, got %zu numbers", width));
    struct error *err = place_check_count((double)(t->place->count + count), t->most);
    for (size_t i = 0; i < count && !err; i++) {
        if (width == 6)
            err = points_place(points, i, append_normal(t->place, &t->room, value + width * i + 3));
        if (!err)
            err = place_append(t->place, value + width * i);
    }
    return err;
}

static struct error *append_points(struct place *place, const char *path, bool normals, double most,
                                   struct warnings *warnings)
{
    struct taking taking = {.place = place, .normals = normals, .most = most};
    return points_read_all(path, POINTS_PLACES, take, &taking, warnings);
}

struct error *place_points(struct place *place, const char *path, double most,
                           struct warnings *warnings)
{
    return append_points(place, path, false, most, warnings);
}

struct error *place_surface_points(struct place *place, const char *path, double most,
                                   struct warnings *warnings)
{
    return append_points(place, path, true, most, warnings);
}

static struct error *place_by_options(struct place *place, const struct place_options *options,
                                      struct place_world *world)
{
    struct error *err = place_surface_points(place, world->file, world->most, world->warnings);
    return err ? err : place_reach_keep(place, options, world);
}

const struct place_method place_method_points = {.name = "points",
                                                 .origin = 2,
                                                 .file_of = "positions",
                                                 .reaches = true,
                                                 .place = place_by_options};
