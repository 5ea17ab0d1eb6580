/* SPDX-License-Identifier: Apache-2.0 */
#include "place/space.h"
#include "base/error.h"
#include "math/affine.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/vec.h"
#include "place/reach.h"
#include "place/up.h"
#include "scene/scene.h"

#include <string.h>

/* Quarters are exact. */
static void turn_of(double degrees, double *x, double *y)
{
    const double turn = degrees - 360 * floor(degrees / 360), quarters = floor(turn / 90 + .5),
                 rest = (turn - 90 * quarters) * ANGLE_PI / 180;
    const double c = angle_cos(rest), s = angle_sin(rest);
    switch ((int)quarters % 4) {
    case 0: *x = c, *y = s; break;
    case 1: *x = -s, *y = c; break;
    case 2: *x = -c, *y = -s; break;
    default: *x = s, *y = -c; break;
    }
}

static void turn_about(const double centre[3], int up, double degrees, const double p[3],
                       double turned[3])
{
    const int u = (up + 1) % 3, v = (up + 2) % 3;
    double x = 1, y = 0;
    turn_of(degrees, &x, &y);
    const double a = p[u] - centre[u], b = p[v] - centre[v];
    turned[up] = p[up];
    turned[u] = centre[u] + (x * a - y * b);
    turned[v] = centre[v] + (y * a + x * b);
}

void place_box_turn(const struct place_box *box, int up, bool back, const double p[3],
                    double turned[3])
{
    double centre[3];
    if (!(box->turn < 0 || box->turn > 0)) {
        memmove(turned, p, 3 * sizeof *p);
        return;
    }
    for (int k = 0; k < 3; k++)
        centre[k] = (box->low[k] + box->high[k]) / 2;
    turn_about(centre, up, back ? -box->turn : box->turn, p, turned);
}

void place_box_hull(const struct place_box *box, int up, double low[3], double high[3])
{
    struct box hull = box_empty();
    for (int i = 0; i < 8; i++) {
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = i >> k & 1 ? box->high[k] : box->low[k];
        place_box_turn(box, up, false, p, p);
        box_add(&hull, p);
    }
    memcpy(low, hull.low, sizeof hull.low);
    memcpy(high, hull.high, sizeof hull.high);
}

void place_box_of_scene(const struct scene *scene, double turn, struct place_box *box)
{
    const int up = up_axis(scene);
    struct box hull = box_empty();
    double centre[3], middle[3];
    *box = (struct place_box){.turn = turn};
    vec3_store(box->low, scene->box_min);
    vec3_store(box->high, scene->box_max);
    if (!(turn < 0 || turn > 0))
        return;
    for (int k = 0; k < 3; k++)
        centre[k] = (box->low[k] + box->high[k]) / 2;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t c = 0; c < 3 * mesh->triangle_count; c++) {
            double p[3];
            vec3_store(p, affine_point(scene->instances[i].transform,
                                       mesh->position + 3 * (size_t)mesh->index[c]));
            turn_about(centre, up, -turn, p, p);
            box_add(&hull, p);
        }
    }
    /* about its own centre, from now on */
    for (int k = 0; k < 3; k++)
        middle[k] = (hull.low[k] + hull.high[k]) / 2;
    double moved[3];
    turn_about(centre, up, turn, middle, moved);
    for (int k = 0; k < 3; k++) {
        const double half = (hull.high[k] - hull.low[k]) / 2;
        box->low[k] = moved[k] - half;
        box->high[k] = moved[k] + half;
    }
}

static bool boxes_hold(const struct place_space *space, const double p[3])
{
    for (int i = 0; i < space->count; i++) {
        const struct place_box *box = &space->box[i];
        double q[3];
        place_box_turn(box, space->up, true, p, q);
        bool in = true;
        for (int k = 0; k < 3; k++)
            in = in && q[k] >= box->low[k] && q[k] <= box->high[k];
        if (in)
            return true;
    }
    return !space->count;
}

bool place_space_holds(const struct place_space *space, const double p[3])
{
    for (int k = 0; k < 3; k++)
        if (!(p[k] >= space->low[k] && p[k] <= space->high[k]))
            return false;
    return boxes_hold(space, p) && (!space->reach || reach_holds(space->reach, p));
}

struct error *place_check_near(const struct scene *scene, const double p[3])
{
    static const double most = 1e15; /* as probe-capture has it */
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min),
                      off = vec3_sub(vec3_load(p), scene->box_min);
    if (vec3_length(off) <= most * vec3_length(size))
        return NULL;
    return error_new("%g,%g,%g is too far out: more than %g times the scene's size", p[0], p[1],
                     p[2], most);
}
