#include "base/array.h"
#include "base/error.h"
#include "place/place_method.h"
#include "stream/points.h"

#include <math.h>
#include <stdlib.h>

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

static struct error *append_points(struct place *place, const char *path, bool normals, double most)
{
    enum { BLOCK = 1024 };
    struct points *points = NULL;
    double *value = NULL;
    const size_t before = place->count;
    size_t room = 0;
    struct error *err = points_open(&points, path, POINTS_TEXT, false);
    if (!err)
        err = array_create(&value, 6 * BLOCK, sizeof *value);
    for (size_t got = 1; !err && got;) {
        size_t width = 0;
        err = points_read(points, BLOCK, value, &width, &got);
        if (!err && got && width != 3 && !normals)
            err = points_place(
                points, 0, error_new("expected x y z, without a normal, got %zu numbers", width));
        if (!err)
            err = place_check_count((double)(place->count + got), most);
        for (size_t i = 0; i < got && !err; i++) {
            if (width == 6)
                err = points_place(points, i, append_normal(place, &room, value + width * i + 3));
            if (!err)
                err = place_append(place, value + width * i);
        }
    }
    if (!err && place->count == before)
        err = error_new("%s: expected at least one position, got none", path);
    free(value);
    points_close(points);
    return err;
}

struct error *place_points(struct place *place, const char *path, double most)
{
    return append_points(place, path, false, most);
}

struct error *place_surface_points(struct place *place, const char *path, double most)
{
    return append_points(place, path, true, most);
}

static struct error *place_by_options(struct place *place, const struct place_options *options,
                                      const struct place_world *world)
{
    (void)options;
    return place_surface_points(place, world->file, world->most);
}

const struct place_method place_method_points = {
    .name = "points", .file_of = "positions", .place = place_by_options};
