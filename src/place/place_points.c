#include "base/array.h"
#include "base/error.h"
#include "place/place_method.h"
#include "stream/points.h"

#include <stdlib.h>

struct error *place_points(struct place *place, const char *path, double most)
{
    enum { BLOCK = 1024 };
    struct points *points = NULL;
    double *value = NULL;
    const size_t before = place->count;
    struct error *err = points_open(&points, path, POINTS_TEXT, false);
    if (!err)
        err = array_create(&value, 6 * BLOCK, sizeof *value);
    for (size_t got = 1; !err && got;) {
        size_t width = 0;
        err = points_read(points, BLOCK, value, &width, &got);
        if (!err && got && width != 3)
            err = points_place(points, 0, error_new("expected x y z, got %zu numbers", width));
        if (!err)
            err = place_check_count((double)(place->count + got), most);
        for (size_t i = 0; i < got && !err; i++)
            err = place_append(place, value + 3 * i);
    }
    if (!err && place->count == before)
        err = error_new("%s: expected at least one position, got none", path);
    free(value);
    points_close(points);
    return err;
}

static struct error *place_by_options(struct place *place, const struct place_options *options,
                                      const struct place_world *world)
{
    (void)options;
    return place_points(place, world->file, world->most);
}

const struct place_method place_method_points = {
    .name = "points", .file_of = "positions", .place = place_by_options};
