/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_ground.h"
#include "base/error.h"
#include "math/direction.h"
#include "math/vec.h"
#include "place/up.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

/* Of a floor: the least cosine between its normal and up. */
#define FLOOR_LEAST .342
/* Surfaces that a column goes through, at the most. */
enum { DEEP = 256 };

/* How far rays step from a surface that they go on behind. */
static double step_of(const struct scene *scene)
{
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    return 1e-5 * fmax(size.x, fmax(size.y, size.z));
}

bool place_ground_look(struct place_ground *ground)
{
    enum { SIDE = 12 };
    const struct scene *scene = trace_scene(ground->tracer);
    const int axis = ground->up, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double step = step_of(scene), way = up_way(scene, axis);
    double low[3], high[3];
    int escaped = 0, fronts = 0, backs = 0;
    vec3_store(low, scene->box_min);
    vec3_store(high, scene->box_max);
    for (int i = 0; i < SIDE * SIDE; i++) {
        double p[3], d[3] = {0};
        p[axis] = way > 0 ? high[axis] + step : low[axis] - step;
        p[u] = low[u] + (i % SIDE + .5) / SIDE * (high[u] - low[u]);
        p[v] = low[v] + (i / SIDE + .5) / SIDE * (high[v] - low[v]);
        d[axis] = -way;
        struct trace_hit hit = trace_nearest(ground->tracer, p, d, INFINITY);
        fronts += hit.hit && hit.front;
        backs += hit.hit && !hit.front;
        p[axis] -= way * (hit.distance + step);
        if (!hit.hit || !trace_nearest(ground->tracer, p, d, INFINITY).hit) {
            escaped++; /* what stands alone is no ceiling, whichever way it looks */
            continue;
        }
        p[axis] = (low[axis] + high[axis]) / 2;
        d[axis] = way;
        hit = trace_nearest(ground->tracer, p, d, INFINITY);
        for (int steps = 0; steps < 64 && hit.hit && !hit.front; steps++) {
            p[axis] += way * (hit.distance + step);
            hit = trace_nearest(ground->tracer, p, d, INFINITY);
        }
        escaped += !hit.hit;
    }
    const bool open = 2 * escaped > SIDE * SIDE;
    ground->way = way;
    ground->turned = open && backs > 8 * fronts; /* a ceiling shows its back from above */
    return open;
}

/* What a column goes through, from above. */
struct crossing {
    double at; /* along the up axis */
    bool front, level;
};

static int cross(const struct place_ground *ground, const double p[3], double top, double bottom,
                 struct crossing crossing[DEEP])
{
    const int up = ground->up;
    const double way = ground->way, on = step_of(trace_scene(ground->tracer));
    double from[3], down[3] = {0}, normal[3];
    int count = 0;
    memcpy(from, p, sizeof from);
    from[up] = top + way * on;
    down[up] = -way;
    while (count < DEEP) {
        const struct trace_hit hit =
            trace_nearest(ground->tracer, from, down, fmax(way * (from[up] - bottom), 0) + on);
        if (!hit.hit)
            break;
        vec3_store(normal, hit.normal);
        const double at = from[up] - way * hit.distance;
        crossing[count++] = (struct crossing){at, hit.front, fabs(normal[up]) >= FLOOR_LEAST};
        from[up] = at - way * on;
    }
    return count;
}

/* Whether the crossing at i, a back, is of a thing that is turned inside out: from below it fronts
 * alone are seen, on all sides. */
static bool is_of_thing(const struct place_ground *ground, const double p[3],
                        const struct crossing *crossing, int i, int count)
{
    enum { WAYS = 16 };
    double from[3], d[3];
    if (i + 1 == count || !crossing[i + 1].front)
        return false;
    memcpy(from, p, sizeof from);
    from[ground->up] = (crossing[i].at + crossing[i + 1].at) / 2;
    for (int k = 0; k < WAYS; k++) {
        vec3_store(d, direction_even(k, WAYS));
        const struct trace_hit hit = trace_nearest(ground->tracer, from, d, INFINITY);
        if (!hit.hit || !hit.front)
            return false;
    }
    return true;
}

/* Whether somebody can stand on the crossing at i. The topmost is a floor where most look down, as
 * it may be a box that looks up. */
static bool is_floor(const struct place_ground *ground, const double p[3],
                     const struct crossing *crossing, int i, int count)
{
    const struct crossing *c = &crossing[i];
    return c->level && (c->front != ground->turned ||
                        (ground->turned ? i == 0 : is_of_thing(ground, p, crossing, i, count)));
}

struct error *place_ground_column(struct place *place, const struct place_ground *ground,
                                  const double p[3], double first, double step,
                                  const double ends[2], bool within)
{
    const int up = ground->up;
    const double way = ground->way;
    const double top = way > 0 ? ends[1] : ends[0], bottom = way > 0 ? ends[0] : ends[1];
    double above = within ? top : way * (double)INFINITY;
    struct crossing crossing[DEEP];
    struct error *err = NULL;
    const int count = cross(ground, p, top, bottom, crossing);
    for (int i = 0; i < count && !err; i++) {
        const double foot = crossing[i].at, room = way * (above - foot);
        if (is_floor(ground, p, crossing, i, count) && room >= step / 2)
            for (int k = 0; k < ground->layers && !err; k++) {
                double node[3];
                memcpy(node, p, sizeof node);
                node[up] = foot + way * (first + k * step);
                if (first + k * step + (within || i ? first : 0) <= room)
                    err = place_append(place, node);
            }
        above = foot;
    }
    return err;
}
