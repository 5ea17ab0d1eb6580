/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"
#include "base/options.h"
#include "math/vec.h"
#include "place/place_method.h"

#include <math.h>

struct error *place_path(struct place *place, const char *path, double step, double most,
                         struct warnings *warnings)
{
    struct place vertices = {0};
    struct error *err = place_points(&vertices, path, INFINITY, warnings);
    for (size_t i = 0; i < vertices.count && !err; i++) {
        const struct vec3 a = vec3_load(vertices.position + 3 * i);
        err = place_append(place, vertices.position + 3 * i);
        if (err || i + 1 == vertices.count)
            break;
        const struct vec3 way = vec3_sub(vec3_load(vertices.position + 3 * (i + 1)), a);
        /* none longer than the step */
        const double parts = ceil(vec3_length(way) / step * (1 - 1e-12));
        err = place_check_count((double)place->count + parts, most);
        for (double n = 1; n < parts && !err; n++) {
            double p[3];
            vec3_store(p, vec3_fma(a, n / parts, way));
            err = place_append(place, p);
        }
    }
    place_clear(&vertices);
    return err;
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    *row++ =
        (struct option_row){.name = "step",
                            .argument = "S",
                            .kind = OPTION_REAL,
                            .value = &o->step,
                            .least_open = true,
                            .most = INFINITY,
                            .given = &o->step_given,
                            .help = "path: the greatest distance between probes along the path"};
    return row;
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    return o->step_given ? NULL : error_usage("path: expected --step");
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    return place_path(place, world->file, o->step, world->most, world->warnings);
}

const struct place_method place_method_path = {.name = "path",
                                               .origin = 3,
                                               .file_of = "positions",
                                               .rows = rows,
                                               .check = check,
                                               .place = place_by_options};
