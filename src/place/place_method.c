/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_method.h"
#include "place/up.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "math/box.h"
#include "math/vec.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

struct place_options place_options_default(void)
{
    return (struct place_options){.spacing = {NAN, NAN, NAN},
                                  .count = NAN,
                                  .clearance = .1,
                                  .clearance_share = true,
                                  .offset = NAN,
                                  .crease = NAN,
                                  .reach = reach_default(),
                                  .levels = {1, 2},
                                  .octree = {.cut = {NAN, 1, NAN, NAN, NAN}},
                                  .light = {.order = 3, .bounces = 64, .light = -1},
                                  .merge = {.merge_distance = 1.01,
                                            .merge_contrast = NAN,
                                            .spawn_distance = 1.8,
                                            .spawn_contrast = NAN},
                                  .adaptive = {.noise = 0.3},
                                  .poisson = {.particles = 20000, .misses = 32}};
}

const struct option_row *place_option_rows(struct place_options *options, struct option_row *rows)
{
    struct option_row *row = rows;
    for (int i = 0; place_methods[i]; i++)
        if (place_methods[i]->rows)
            row = place_methods[i]->rows(options, row);
    *row = (struct option_row){0};
    return rows;
}

/* The i-th of `count` names joins a list: "a", "a or b", "a, b or c", where last is " or ". */
static void join(char *list, size_t size, int i, int count, const char *last, const char *prefix,
                 const char *name)
{
    const size_t used = strlen(list);
    const char *between = i + 1 < count ? ", " : last;
    snprintf(list + used, size - used, "%s%s%s", i ? between : "", prefix, name);
}

void place_usage(char *text, size_t size)
{
    *text = 0;
    for (int i = 0; place_methods[i]; i++) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s%s", i ? "|" : "", place_methods[i]->name,
                 place_methods[i]->file_of ? " FILE" : "");
    }
    const size_t used = strlen(text);
    snprintf(text + used, size - used, " [OPTION]... [SCENE]");
}

/* A floor, or a single wall, has air before it: an eighth of its longest side. */
static void add_air(struct place_space *space, const struct place_world *world)
{
    static const double FLAT = 0.01, AIR = 0.125;
    static const char *const axes[] = {"X", "Y", "Z"};
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, space->high[k] - space->low[k]);
    if (space->high[space->up] - space->low[space->up] >= FLAT * most)
        return;
    const double way = up_way(world->scene, space->up);
    if (way > 0)
        space->high[space->up] += AIR * most;
    else
        space->low[space->up] -= AIR * most;
    warnings_add(world->warnings, "flat",
                 "the scene is flat along %s: probes go into what is up to %g %s it (--bounds says "
                 "otherwise)",
                 axes[space->up], AIR * most, way > 0 ? "above" : "below");
}

void place_options_space(const struct place_options *o, const struct place_world *world,
                         const struct reach *reach, struct place_space *space)
{
    const struct scene *scene = world->scene;
    *space = (struct place_space){
        .box = o->box, .count = o->boxes, .up = up_axis(scene), .reach = reach};
    struct box all = box_empty();
    for (int i = 0; i < o->boxes; i++) {
        struct box hull;
        place_box_hull(&o->box[i], space->up, hull.low, hull.high);
        box_add(&all, hull.low);
        box_add(&all, hull.high);
    }
    memcpy(space->low, all.low, sizeof all.low);
    memcpy(space->high, all.high, sizeof all.high);
    if (!o->boxes) {
        vec3_store(space->low, scene->box_min);
        vec3_store(space->high, scene->box_max);
        if (!reach)
            add_air(space, world);
    }
    if (!reach)
        return;
    struct box region;
    reach_box(reach, region.low, region.high);
    for (int k = 0; k < 3; k++) { /* heads may stick out of a scene that is an open ground */
        space->low[k] = o->boxes ? fmax(space->low[k], region.low[k]) : region.low[k];
        space->high[k] = o->boxes ? fmin(space->high[k], region.high[k]) : region.high[k];
    }
}

/* -- what was given --------------------------------------------------------------------------- */

static struct error *find_method(const char *name, const struct place_method **method)
{
    char names[256] = "";
    int count = 0;
    while (place_methods[count])
        count++;
    for (int i = 0; i < count; i++) {
        *method = place_methods[i];
        if (!strcmp((*method)->name, name))
            return NULL;
        join(names, sizeof names, i, count, " or ", "", (*method)->name);
    }
    return error_usage("expected a method %s, got '%s'", names, name);
}

struct error *place_operands(int count, const char *const *operands,
                             const struct place_method **method, const char **file,
                             const char **scene)
{
    struct error *err = find_method(operands[0], method);
    if (err)
        return err;
    const int next = (*method)->file_of ? 2 : 1;
    if (count < next)
        return error_usage("%s: expected a FILE of %s", (*method)->name, (*method)->file_of);
    if (count > next + 1)
        return error_usage("unexpected operand '%s'", operands[next + 1]);
    *file = (*method)->file_of ? operands[1] : NULL;
    *scene = count > next ? operands[next] : NULL;
    return NULL;
}

struct error *place_inputs_differ(const struct place_options *o, const char *file,
                                  const char *scene)
{
    const struct {
        const char *path, *is;
    } all[] = {{scene, "the scene"},
               {file, "FILE"},
               {o->reach_file, "the start points of --reach"},
               {o->light.keep, "the probes of --keep"}};
    struct error *err = NULL;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        for (size_t j = 0; j < i && !err; j++)
            if (all[i].path && all[j].path)
                err = file_inputs_differ(all[j].path, all[j].is, all[i].path, all[i].is);
    return err;
}

static bool has_share(const struct place_method *method, const char *name)
{
    for (int i = 0; method->shares && method->shares[i]; i++)
        if (!strcmp(method->shares[i], name))
            return true;
    for (int i = 0; method->reaches && place_reach_shares[i]; i++)
        if (!strcmp(place_reach_shares[i], name))
            return true;
    return false;
}

/* Says which methods take an option of `owner`. */
static struct error *goes_with(const char *option, const struct place_method *owner)
{
    const struct place_method *takes[64];
    char names[512] = "";
    int count = 0;
    for (int i = 0; place_methods[i]; i++)
        if (place_methods[i] == owner || has_share(place_methods[i], option))
            takes[count++] = place_methods[i];
    for (int i = 0; i < count; i++)
        join(names, sizeof names, i, count, " and ", "", takes[i]->name);
    return error_usage("--%s goes with the method%s %s", option, count > 1 ? "s" : "", names);
}

/* Error: an option of a method was given, which is not `used`, the one that places. */
static struct error *check_not_given(struct place_options *options,
                                     const struct place_method *method,
                                     const struct place_method *used)
{
    struct option_row rows[PLACE_OPTION_ROWS];
    const int count = method->rows ? (int)(method->rows(options, rows) - rows) : 0;
    for (int i = 0; i < count; i++)
        if (*rows[i].given && !has_share(used, rows[i].name))
            return goes_with(rows[i].name, method);
    return NULL;
}

struct error *place_options_check(struct place_options *options, const struct place_method *method,
                                  bool scene)
{
    struct error *err = NULL;
    for (int i = 0; place_methods[i] && !err; i++)
        if (place_methods[i] != method)
            err = check_not_given(options, place_methods[i], method);
    if (!err && method->needs_scene && !scene)
        err = error_usage("%s: expected a SCENE", method->name);
    if (!err && method->reaches)
        err = place_reach_check(options, scene);
    if (!err && method->check)
        err = method->check(options, scene);
    return err;
}
