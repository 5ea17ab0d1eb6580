/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "place/place_method.h"
#include "place/reach.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <string.h>

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    *row++ = (struct option_row){.name = "reach",
                                 .argument = "FILE",
                                 .kind = OPTION_TEXT,
                                 .value = &o->reach_file,
                                 .given = &o->reach_given,
                                 .shown = "anywhere",
                                 .help = "reach: for the other methods: only where a body gets "
                                         "from the\nstart points in FILE"};
    return reach_option_rows(&o->reach, row);
}

const char *const place_reach_shares[] = {"reach",    "radius", "height", "climb",     "drop",
                                          "headroom", "cell",   "fly",    "max-cells", NULL};

struct error *place_reach_check(const struct place_options *o, bool scene)
{
    const char *given = reach_option_given(&o->reach);
    if (given && !o->reach_given)
        return error_usage("%s goes with --reach, or the method reach", given);
    if (o->reach_given && !scene)
        return error_usage("--reach needs a SCENE");
    return reach_check_given(&o->reach);
}

struct error *place_reach_open(struct reach **reach, const struct place_options *o,
                               const struct tracer *tracer, const struct place_world *world)
{
    struct reach_settings settings = o->reach;
    settings.threads = world->inside.threads;
    settings.program = world->progress ? world->program : NULL;
    *reach = NULL;
    return o->reach_given ? reach_create(reach, o->reach_file, tracer, &settings, world->warnings)
                          : NULL;
}

struct error *place_reach_keep(struct place *place, const struct place_options *o,
                               const struct place_world *world)
{
    struct tracer *tracer = NULL;
    struct reach *reach = NULL;
    struct error *err = o->reach_given ? trace_create(&tracer, world->scene) : NULL;
    if (!err)
        err = place_reach_open(&reach, o, tracer, world);
    const size_t all = place->count;
    size_t kept = 0;
    for (size_t i = 0; i < all && reach; i++) {
        if (!reach_holds(reach, place->position + 3 * i))
            continue;
        memmove(place->position + 3 * kept, place->position + 3 * i, 3 * sizeof *place->position);
        if (place->normal)
            memmove(place->normal + 3 * kept, place->normal + 3 * i, 3 * sizeof *place->normal);
        if (place->origin)
            place->origin[kept] = place->origin[i];
        if (kept < i)
            table_copy_rows(&place->columns, kept, &place->columns, i, 1);
        kept++;
    }
    if (reach) {
        place->count = kept;
        err = table_resize(&place->columns, kept);
    }
    if (reach && kept < all)
        warnings_add(world->warnings, "reach", "%zu of %zu positions are out of reach: dropped",
                     all - kept, all);
    if (!err && reach && !kept)
        err = error_new("all %zu positions are out of reach", all);
    reach_destroy(reach);
    trace_destroy(tracer);
    return err;
}

/* -- the method ------------------------------------------------------------------------------- */

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    return o->reach_given ? error_usage("reach: the start points are its FILE, --reach goes with "
                                        "other methods")
                          : reach_check_given(&o->reach);
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct reach_settings settings = o->reach;
    struct tracer *tracer = NULL;
    struct reach *reach = NULL;
    settings.threads = world->inside.threads;
    settings.program = world->progress ? world->program : NULL;
    struct error *err = trace_create(&tracer, world->scene);
    if (!err)
        err = reach_create(&reach, world->file, tracer, &settings, world->warnings);
    if (!err)
        err = place_check_count((double)reach_count(reach), world->most);
    for (size_t i = 0; !err && i < reach_count(reach); i++) {
        double p[3];
        reach_place(reach, i, p);
        err = place_append(place, p);
    }
    reach_destroy(reach);
    trace_destroy(tracer);
    return err;
}

const struct place_method place_method_reach = {.name = "reach",
                                                .origin = 11,
                                                .file_of = "start points",
                                                .needs_scene = true,
                                                .rows = rows,
                                                .check = check,
                                                .place = place_by_options};
