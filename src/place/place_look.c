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

static bool is_front(enum sight what)
{
    return what == SIGHT_HULL || what == SIGHT_FRONT;
}

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
    const double least = LOOK_LEAST * look->rays;
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

/* -- views ------------------------------------------------------------------------------------ */

/* What is seen from a position along the first ways. */
struct view {
    int count;
    struct place_sight sight[PLACE_WAYS];
};

/* Looks along more of the ways, and counts what is met there. */
static void look_on(const struct place_pieces *pieces, const double p[3], int count,
                    struct view *view, struct look *look)
{
    for (; view->count < count; view->count++) {
        struct place_sight *s = &view->sight[view->count];
        *s = place_sight(pieces, p, pieces->way[view->count]);
        look->count[s->through]++;
        look->rays++;
    }
}

/* A point a little before the surface that a ray met, and the side of its normal where it is. */
static double before_surface(const struct place_sight *sight, struct vec3 direction, double p[3])
{
    vec3_store(p, vec3_fma(sight->hit.position, -1e-3 * sight->hit.distance, direction));
    return vec3_dot(sight->hit.normal, direction) < 0 ? 1 : -1;
}

/* -- fronts that are buried ------------------------------------------------------------------- */

/* Whether a front of an open surface is behind a sheet itself: nearly all that it looks at, but
 * along itself, are backs. */
static bool is_buried(const struct place_pieces *pieces, const struct place_sight *front,
                      struct vec3 direction)
{
    int asked = 0, others = 0;
    double p[3];
    const double side = before_surface(front, direction, p);
    for (int i = 0; i < PLACE_WAYS; i++)
        asked += vec3_dot(pieces->way[i], front->hit.normal) * side >= .5;
    for (int i = 0; i < PLACE_WAYS && others <= .1 * asked; i++) {
        if (vec3_dot(pieces->way[i], front->hit.normal) * side < .5)
            continue;
        const enum sight what = place_sight(pieces, p, pieces->way[i]).through;
        if (what == SIGHT_LAMP)
            return false;
        others += what != SIGHT_BEHIND && what != SIGHT_VOID;
    }
    return others <= .1 * asked;
}

/* Takes away the share of the fronts which are buried; every fourth is asked. */
static void leave_out_buried(const struct place_pieces *pieces, const struct view *view,
                             struct look *look)
{
    int asked = 0, buried = 0, fronts = 0;
    for (int i = 0; i < view->count; i++) {
        if (view->sight[i].what != SIGHT_FRONT || fronts++ % 4)
            continue;
        asked++;
        buried += is_buried(pieces, &view->sight[i], pieces->way[i]);
    }
    if (asked)
        look->count[SIGHT_FRONT] -= look->count[SIGHT_FRONT] * buried / asked;
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
 * Where much escapes, solids say nothing either way. The first rays are enough where they all say
 * the same. */
static enum place_side clear_side(const struct place_pieces *pieces, const double q[3],
                                  const struct place_inside_settings *settings)
{
    struct view view = {0};
    struct look look = {0};
    const int *of = look.count;
    for (int rays = PLACE_RAYS / 4; rays <= PLACE_RAYS; rays *= 2) {
        look_on(pieces, q, rays, &view, &look);
        const int backs = look_backs(&look), fronts = of[SIGHT_FRONT] + of[SIGHT_HULL];
        if ((!backs && 2 * of[SIGHT_FRONT] >= rays) || (!fronts && 4 * backs >= 3 * rays))
            break;
    }
    const double least = LOOK_LEAST * look.rays,
                 share = share_of(&look, 4 * of[SIGHT_ESCAPED] < look.rays);
    if (of[SIGHT_LAMP] || (share < DOUBTFUL && of[SIGHT_FRONT] >= least))
        return PLACE_AIR;
    if (share >= settings->backface_share && look_backs(&look) >= least)
        return of[SIGHT_VOID] > of[SIGHT_BEHIND] ? PLACE_VOID : PLACE_BEHIND;
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
                       const struct view *view, struct look *look)
{
    double distance[PLACES], sorted[PLACES];
    int air = 0, none = 0, of_void = 0, asked = 0;
    for (int i = 0; i < PLACES; i++)
        distance[i] = view->sight[i].hit.hit ? view->sight[i].hit.distance
                                             : exit_distance(tracer, p, pieces->way[i]);
    memcpy(sorted, distance, sizeof sorted);
    qsort(sorted, PLACES, sizeof *sorted, compare_doubles);
    for (int i = 0; i < PLACES; i++) {
        double q[3];
        if (distance[i] < sorted[PLACES / 2])
            continue;
        vec3_store(q, vec3_fma(vec3_load(p), .5 * distance[i], pieces->way[i]));
        const enum place_side side = clear_side(pieces, q, settings);
        air += side == PLACE_AIR;
        none += side == PLACE_BEHIND || side == PLACE_VOID;
        of_void += side == PLACE_VOID;
        if (++asked >= PLACES / 8 && (air == asked || none == asked))
            break; /* enough of them say the same */
    }
    if (air + none < PLACES / 8)
        return;
    look->asked = true;
    look->side = air >= none ? PLACE_AIR : 2 * of_void > none ? PLACE_VOID : PLACE_BEHIND;
}

/* -- floors ----------------------------------------------------------------------------------- */

/* Whether hardly any back is seen from a front of an open surface or a solid. */
static bool is_free(const struct place_pieces *pieces, const struct place_sight *front,
                    struct vec3 direction)
{
    enum { RAYS = 32 };
    int asked = 0, backs = 0;
    double p[3];
    const double side = before_surface(front, direction, p);
    for (int i = 0; i < RAYS; i++) {
        if (vec3_dot(pieces->way[i], front->hit.normal) * side <= 0)
            continue;
        asked++;
        backs += place_sight(pieces, p, pieces->way[i]).through >= SIGHT_SOLID;
    }
    return 4 * backs <= asked;
}

/* Whether p stands on a floor: what is steeply below are mostly fronts, and level. */
static bool has_floor(const struct place_pieces *pieces, const struct view *view)
{
    int below = 0, floor = 0;
    for (int i = 0; i < view->count; i++) {
        const struct place_sight *s = &view->sight[i];
        if (vec3_dot(pieces->way[i], pieces->up) >= -.85)
            continue;
        below++;
        floor += is_front(s->what) && fabs(vec3_dot(s->hit.normal, pieces->up)) > .5;
    }
    return 2 * floor >= below;
}

/* Whether it sees something of what is free, or of nothing above. So it is on the floors of houses
 * of walls without thickness, and of tents. */
static bool sees_free(const struct place_pieces *pieces, const struct view *view)
{
    enum { FREE_LEAST = 2 };
    int free_ways = 0;
    for (int i = 0; i < view->count; i++)
        free_ways += vec3_dot(pieces->way[i], pieces->up) > 0 &&
                     view->sight[i].what == SIGHT_ESCAPED;
    for (int i = 0; i < view->count && free_ways < FREE_LEAST; i++)
        free_ways += is_front(view->sight[i].what) &&
                     is_free(pieces, &view->sight[i], pieces->way[i]);
    return free_ways >= FREE_LEAST;
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

/* Whether the first rays tell enough: there are no backs, and fronts of sheets or rooms. */
static bool is_clear(const struct look *look)
{
    return !look->count[SIGHT_SOLID] && !look_backs(look) &&
           4 * look->count[SIGHT_FRONT] >= look->rays;
}

/* Looks along as many rays as are asked for. */
static struct look look_along(const struct place_pieces *pieces, const double p[3], int rays)
{
    struct look look = {.rays = rays};
    for (int i = 0; i < rays; i++)
        look.count[place_sight(pieces, p, direction_even(i, rays)).through]++;
    return look;
}

struct look look_at(const struct place_pieces *pieces, const struct tracer *tracer,
                    const struct place_inside_settings *settings, const double p[3])
{
    struct view view = {0};
    struct look look = {0};
    const int *of = look.count;
    look_on(pieces, p, PLACE_WAYS / 4, &view, &look);
    if (settings->rays <= PLACE_WAYS &&
        (is_clear(&look) || of[SIGHT_SOLID] >= LOOK_LEAST * PLACE_WAYS))
        return look;
    look_on(pieces, p, PLACE_WAYS, &view, &look);
    if (settings->rays != PLACE_WAYS)
        look = look_along(pieces, p, settings->rays);
    if (of[SIGHT_ESCAPED] == look.rays)
        look_far(pieces, p, &look);
    if (of[SIGHT_SOLID] < LOOK_LEAST * look.rays && !of[SIGHT_LAMP]) {
        if (is_doubtful(&look) && of[SIGHT_FRONT])
            leave_out_buried(pieces, &view, &look);
        if (is_doubtful(&look) || (look_back_share(&look) < DOUBTFUL && of[SIGHT_HULL] &&
                                   !of[SIGHT_FRONT] && of[SIGHT_ESCAPED] >= look.rays / 4))
            ask_around(pieces, tracer, settings, p, &view, &look);
    }
    if (look_side(&look, settings) > PLACE_SOLID && is_lit(tracer, p))
        look.count[SIGHT_LAMP]++;
    look.floor = look_side(&look, settings) == PLACE_BEHIND && has_floor(pieces, &view);
    if (look.floor && sees_free(pieces, &view)) {
        look.asked = true;
        look.side = PLACE_AIR;
    }
    return look;
}
