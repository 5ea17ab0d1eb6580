/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_ground.h"
#include "base/error.h"
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

struct error *place_ground_column(struct place *place, const struct place_ground *ground,
                                  const double p[3], double first, double step,
                                  const double ends[2], bool within)
{
    const int up = ground->up;
    const double way = ground->way, on = step_of(trace_scene(ground->tracer));
    const double top = way > 0 ? ends[1] : ends[0], bottom = way > 0 ? ends[0] : ends[1];
    double at[3], down[3] = {0}, above = within ? top : way * (double)INFINITY;
    struct error *err = NULL;
    memcpy(at, p, sizeof at);
    at[up] = top + way * on;
    down[up] = -way;
    for (int i = 0; i < DEEP && !err; i++) {
        const struct trace_hit hit =
            trace_nearest(ground->tracer, at, down, fmax(way * (at[up] - bottom), 0) + on);
        double normal[3], foot[3];
        if (!hit.hit)
            return NULL;
        vec3_store(normal, hit.normal);
        memcpy(foot, at, sizeof foot);
        foot[up] = at[up] - way * hit.distance;
        const double room = way * (above - foot[up]);
        /* of what looks down for the most part the topmost may be a box that looks up */
        const bool floor = hit.front != ground->turned || (ground->turned && !i);
        if (floor && fabs(normal[up]) >= FLOOR_LEAST && room >= step / 2)
            for (int k = 0; k < ground->layers && !err; k++) {
                double node[3];
                memcpy(node, foot, sizeof node);
                node[up] += way * (first + k * step);
                if (first + k * step + (within || i ? first : 0) <= room)
                    err = place_append(place, node);
            }
        above = foot[up];
        at[up] = foot[up] - way * on;
    }
    return err;
}
