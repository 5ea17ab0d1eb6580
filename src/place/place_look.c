/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_look.h"
#include "math/box.h"
#include "math/direction.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* From this share of backs on, and up to that, backs and fronts contradict each other. */
#define DOUBTFUL .25
#define CERTAIN .97

int look_backs(const struct look *look)
{
    return look->count[SIGHT_BEHIND] + look->count[SIGHT_VOID];
}

/* Of open surfaces and rooms; solids_count: fronts of solids as well. */
static double share_of(const struct look *look, double solids_count)
{
    const double backs = look_backs(look), all = backs + look->count[SIGHT_FRONT] +
                                                 solids_count * look->count[SIGHT_HULL] +
                                                 .5 * look->count[SIGHT_UNKNOWN];
    return all > 0 ? backs / all : 0;
}

double look_back_share(const struct look *look)
{
    return share_of(look, 1);
}

enum place_side look_side(const struct look *look, const struct place_inside_settings *s)
{
    const double least = LOOK_LEAST * s->rays;
    if (look->count[SIGHT_SOLID] >= least)
        return PLACE_SOLID;
    if (look->count[SIGHT_LAMP])
        return PLACE_AIR;
    if (look->asked)
        return look->side;
    if (!look_backs(look) || look_back_share(look) < s->backface_share)
        return PLACE_AIR;
    if (look->count[SIGHT_VOID] > look->count[SIGHT_BEHIND])
        return PLACE_VOID; /* of a closed piece: a single ray proves it */
    return look_backs(look) >= least ? PLACE_BEHIND : PLACE_AIR;
}

/* -- fronts that are buried ------------------------------------------------------------------- */

/* Whether a front of an open surface is behind a sheet itself: nearly all that it looks at, but
 * along itself, are backs. */
static bool is_buried(const struct place_pieces *pieces, const struct place_sight *front,
                      struct vec3 direction)
{
    enum { RAYS = 64 };
    const struct trace_hit *hit = &front->hit;
    const double facing = vec3_dot(hit->normal, direction) < 0 ? 1 : -1;
    struct look look = {0};
    int asked = 0;
    double p[3]; /* a little before the surface */
    vec3_store(p, vec3_fma(hit->position, -1e-3 * hit->distance, direction));
    for (int i = 0; i < RAYS; i++) {
        const struct vec3 d = direction_even(i, RAYS);
        if (vec3_dot(d, hit->normal) * facing < .5)
            continue;
        look.count[place_sight(pieces, p, d).what]++;
        asked++;
    }
    return !look.count[SIGHT_LAMP] && look_backs(&look) >= .9 * asked;
}

/* Takes away the share of the fronts which are buried; every fourth is asked. */
static void leave_out_buried(const struct place_pieces *pieces, int rays, const double p[3],
                             struct look *look)
{
    int asked = 0, buried = 0, fronts = 0;
    for (int i = 0; i < rays; i++) {
        const struct vec3 d = direction_even(i, rays);
        const struct place_sight s = place_sight(pieces, p, d);
        if (s.what != SIGHT_FRONT || fronts++ % 4)
            continue;
        asked++;
        buried += is_buried(pieces, &s, d);
    }
    if (asked)
        look->count[SIGHT_FRONT] -= fronts * buried / asked;
}

/* -- the surroundings ------------------------------------------------------------------------- */

/* How far places may be from p where nothing is met: to the end of the scene's box, or half its
 * side where that is near. */
static double exit_distance(const struct tracer *tracer, const double p[3], struct vec3 d)
{
    const struct scene *scene = trace_scene(tracer);
    double way[3], exit = INFINITY;
    struct box box;
    vec3_store(box.low, scene->box_min);
    vec3_store(box.high, scene->box_max);
    vec3_store(way, d);
    for (int k = 0; k < 3; k++) {
        const double to = way[k] > 0 ? (box.high[k] - p[k]) / way[k] : (box.low[k] - p[k]) / way[k];
        if (way[k] != 0 && to > 0 && to < exit)
            exit = to;
    }
    const double least = .5 * box_side(&box);
    return isfinite(exit) && exit > least ? exit : least;
}

enum { PLACES = 32, PLACE_RAYS = 32 };

/* What a place tells clearly, by open surfaces and rooms: AIR, BEHIND or VOID; SOLID: nothing.
 * Where much escapes, solids say nothing either way. */
static enum place_side clear_side(const struct place_pieces *pieces, const double q[3],
                                  const struct place_inside_settings *settings)
{
    struct look look = {0};
    for (int k = 0; k < PLACE_RAYS; k++)
        look.count[place_sight(pieces, q, direction_even(k, PLACE_RAYS)).what]++;
    const double least = LOOK_LEAST * PLACE_RAYS,
                 share = share_of(&look, look.count[SIGHT_ESCAPED] < PLACE_RAYS / 4);
    if (look.count[SIGHT_LAMP] || (share < DOUBTFUL && look.count[SIGHT_FRONT] >= least))
        return PLACE_AIR;
    if (share >= settings->backface_share && look_backs(&look) >= least)
        return look.count[SIGHT_VOID] > look.count[SIGHT_BEHIND] ? PLACE_VOID : PLACE_BEHIND;
    return PLACE_SOLID;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* What the surroundings say: of places half way to the farther half of what is seen from p, and so
 * in the same matter or air, those that tell clearly. */
static void ask_around(const struct place_pieces *pieces, const struct tracer *tracer,
                       const struct place_inside_settings *settings, const double p[3],
                       struct look *look)
{
    double distance[PLACES], sorted[PLACES];
    for (int i = 0; i < PLACES; i++) {
        const struct vec3 d = direction_even(i, PLACES);
        const struct place_sight s = place_sight(pieces, p, d);
        distance[i] = s.hit.hit ? s.hit.distance : exit_distance(tracer, p, d);
    }
    memcpy(sorted, distance, sizeof sorted);
    qsort(sorted, PLACES, sizeof *sorted, compare_doubles);
    int says[PLACE_VOID + 1] = {0};
    for (int i = 0; i < PLACES; i++) {
        double q[3];
        if (distance[i] < sorted[PLACES / 2])
            continue;
        vec3_store(q, vec3_fma(vec3_load(p), .5 * distance[i], direction_even(i, PLACES)));
        says[clear_side(pieces, q, settings)]++;
    }
    const int none = says[PLACE_BEHIND] + says[PLACE_VOID];
    if (says[PLACE_AIR] + none < PLACES / 8)
        return;
    look->asked = true;
    look->side = says[PLACE_AIR] >= none                 ? PLACE_AIR
                 : says[PLACE_VOID] > says[PLACE_BEHIND] ? PLACE_VOID
                                                         : PLACE_BEHIND;
}

/* -- looking ---------------------------------------------------------------------------------- */

/* Whether one of the file's lights shines on p. */
static bool is_lit(const struct tracer *tracer, const double p[3])
{
    enum { LIGHTS_ASKED = 64 };
    const struct scene *scene = trace_scene(tracer);
    for (size_t i = 0; i < scene->light_count && i < LIGHTS_ASKED; i++) {
        const struct scene_light *light = &scene->lights[i];
        double to_light[3], distance, rgb[3], from[3];
        if (light->kind == SCENE_SUN)
            continue;
        scene_light_at(light, p, to_light, &distance, rgb);
        vec3_store(from, light->position);
        if (rgb[0] + rgb[1] + rgb[2] > 0 && trace_visibility(tracer, p, from) > 0)
            return true;
    }
    return false;
}

/* Looks at the surface from where no ray met it: far outside, in a corner of the box. Sheets count
 * for nothing at that distance. */
static void look_far(const struct place_pieces *pieces, const double p[3], struct look *look)
{
    for (int i = 0; i < PLACE_TARGETS; i++) {
        const struct vec3 way = vec3_sub(vec3_load(pieces->target[i]), vec3_load(p));
        if (vec3_dot(way, way) > 0)
            look->count[place_sight(pieces, p, vec3_normalize(way)).what]++;
    }
    look->count[SIGHT_BEHIND] = look->count[SIGHT_SOLID] = 0;
}

static bool is_doubtful(const struct look *look)
{
    const double share = look_back_share(look);
    return share >= DOUBTFUL && share < CERTAIN;
}

struct look look_at(const struct place_pieces *pieces, const struct tracer *tracer,
                    const struct place_inside_settings *settings, const double p[3])
{
    struct look look = {0};
    for (int i = 0; i < settings->rays; i++)
        look.count[place_sight(pieces, p, direction_even(i, settings->rays)).what]++;
    if (look.count[SIGHT_ESCAPED] == settings->rays)
        look_far(pieces, p, &look);
    const int *of = look.count;
    if (of[SIGHT_SOLID] < LOOK_LEAST * settings->rays && !of[SIGHT_LAMP]) {
        if (is_doubtful(&look) && of[SIGHT_FRONT])
            leave_out_buried(pieces, settings->rays, p, &look);
        if (is_doubtful(&look) || (look_back_share(&look) < DOUBTFUL && of[SIGHT_HULL] &&
                                   !of[SIGHT_FRONT] && of[SIGHT_ESCAPED] >= settings->rays / 4))
            ask_around(pieces, tracer, settings, p, &look);
    }
    if (look_side(&look, settings) > PLACE_SOLID && is_lit(tracer, p))
        look.count[SIGHT_LAMP]++;
    return look;
}
