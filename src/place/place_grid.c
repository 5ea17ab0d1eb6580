/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "math/affine.h"
#include "math/vec.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

void place_grid_nodes(const struct place_grid *grid, double nodes[3])
{
    for (int k = 0; k < 3; k++) /* a whole number of spacings, but for rounding, is whole */
        nodes[k] = fmax(floor((grid->max[k] - grid->min[k]) / grid->spacing[k] * (1 + 1e-12)), 1);
}

/* Of a box that grows by `room` spacings along `axis`. */
static double node_count(const double min[3], const double max[3], int axis, double room,
                         double spacing)
{
    struct place_grid grid = {.min = {min[0], min[1], min[2]},
                              .max = {max[0], max[1], max[2]},
                              .spacing = {spacing, spacing, spacing}};
    double nodes[3];
    grid.max[axis] += room * spacing;
    place_grid_nodes(&grid, nodes);
    return nodes[0] * nodes[1] * nodes[2];
}

static double find_spacing(const double min[3], const double max[3], int axis, double room,
                           double count)
{
    double low = 0, high = 0; /* low makes too many, high does not */
    for (int k = 0; k < 3; k++)
        high = fmax(high, max[k] - min[k]);
    if (node_count(min, max, axis, room, high) > count)
        return high; /* as few as there can be */
    for (int step = 0; step < 200 && high - low > 1e-12 * high; step++) {
        const double middle = low + (high - low) / 2;
        if (node_count(min, max, axis, room, middle) > count)
            low = middle;
        else
            high = middle;
    }
    return high;
}

double place_grid_spacing(const double min[3], const double max[3], double count)
{
    return find_spacing(min, max, 0, 0, count);
}

/* Centred: what is left of the box is shared by both ends. */
static double first_node(const struct place_grid *grid, int axis, double nodes)
{
    return (grid->min[axis] + grid->max[axis]) / 2 - (nodes - 1) / 2 * grid->spacing[axis];
}

struct error *place_grid(struct place *place, const struct place_grid *grid, double most)
{
    double nodes[3], start[3];
    place_grid_nodes(grid, nodes);
    struct error *err = place_check_count(nodes[0] * nodes[1] * nodes[2], most);
    for (int k = 0; k < 3; k++)
        start[k] = first_node(grid, k, nodes[k]);
    for (double z = 0; z < nodes[2] && !err; z++)
        for (double y = 0; y < nodes[1] && !err; y++)
            for (double x = 0; x < nodes[0] && !err; x++)
                err = place_append(place, (const double[3]){start[0] + x * grid->spacing[0],
                                                            start[1] + y * grid->spacing[1],
                                                            start[2] + z * grid->spacing[2]});
    return err;
}

/* -- the method ------------------------------------------------------------------------------- */

static struct error *parse_spacing(void *value, const char *text)
{
    double *spacing = value;
    struct error *err = strchr(text, ',') ? options_reals("--spacing", text, 3, spacing)
                                          : options_real("--spacing", text, spacing);
    if (!err && !strchr(text, ','))
        spacing[1] = spacing[2] = spacing[0];
    for (int k = 0; k < 3 && !err; k++)
        if (!(spacing[k] > 0))
            err = error_usage("--spacing: expected a number greater than 0, got %g", spacing[k]);
    return err;
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    *row++ = (struct option_row){
        .name = "spacing",
        .letter = 's',
        .argument = "S|SX,SY,SZ",
        .kind = OPTION_CALL,
        .value = o->spacing,
        .parse = parse_spacing,
        .given = &o->spacing_given,
        .help = "grid, and those that start from one: distance between probes, in units\n"
                "of the scene"};
    *row++ = (struct option_row){
        .name = "count",
        .letter = 'n',
        .argument = "N",
        .kind = OPTION_REAL,
        .value = &o->count,
        .least = 1,
        .most = 1e15,
        .given = &o->count_given,
        .help = "grid, and those that start from one: the finest spacing that makes at\n"
                "most N probes, before those"
                " in no air go"};
    *row++ =
        (struct option_row){.name = "bounds",
                            .argument = "X0,Y0,Z0,X1,Y1,Z1",
                            .kind = OPTION_REALS,
                            .count = 6,
                            .value = o->bounds,
                            .given = &o->bounds_given,
                            .help = "grid, and those that start from one: fill this box (default:\n"
                                    "the scene's, with some air above an open ground); adaptive:\n"
                                    "stay in it"};
    return row;
}

static struct error *check(const struct place_options *o, bool scene)
{
    if (o->spacing_given == o->count_given)
        return error_usage("expected either --spacing or --count");
    if (!scene && !o->bounds_given)
        return error_usage("expected a SCENE or --bounds");
    return NULL;
}

/* -- open grounds ------------------------------------------------------------------------------ */

/* How many spacings of air a grid gets above an open ground that is flatter than two: the layers
 * that a blend needs to tell the ground's light from the sky's. */
#define AIR_LAYERS 3

/* Whether most rays from within the box along the axis escape, through backs but no front: there is
 * no ceiling. */
static struct error *find_open(const struct scene *scene, int axis, double way, bool *open)
{
    enum { SIDE = 12 };
    struct tracer *tracer = NULL;
    struct error *err = trace_create(&tracer, scene);
    double low[3], high[3], step = 0;
    int escaped = 0;
    vec3_store(low, scene->box_min);
    vec3_store(high, scene->box_max);
    for (int k = 0; k < 3; k++)
        step = fmax(step, 1e-5 * (high[k] - low[k]));
    for (int i = 0; i < SIDE * SIDE && !err; i++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        double p[3], d[3] = {0};
        p[axis] = (low[axis] + high[axis]) / 2;
        p[u] = low[u] + (i % SIDE + .5) / SIDE * (high[u] - low[u]);
        p[v] = low[v] + (i / SIDE + .5) / SIDE * (high[v] - low[v]);
        d[axis] = way;
        struct trace_hit hit = trace_nearest(tracer, p, d, INFINITY);
        for (int steps = 0; steps < 64 && hit.hit && !hit.front; steps++) {
            p[axis] += way * (hit.distance + step);
            hit = trace_nearest(tracer, p, d, INFINITY);
        }
        escaped += !hit.hit;
    }
    *open = 2 * escaped > SIDE * SIDE;
    trace_destroy(tracer);
    return err;
}

/* The side of the scene's faces that is looked at along the axis: 1 or -1. The air is above where
 * the axis is Y, as most files have it. */
static double find_way(const struct scene *scene, int axis)
{
    double sum = 0;
    if (axis == 1)
        return 1;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const double *m = scene->instances[i].transform, side = affine_mirrors(m) ? -1 : 1;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            struct vec3 p[3];
            double twice[3];
            for (size_t c = 0; c < 3; c++)
                p[c] = affine_point(m, mesh->position + 3 * (size_t)mesh->index[3 * t + c]);
            vec3_store(twice, vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
            sum += side * twice[axis];
        }
    }
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    return sum < -1e-3 * vec3_dot(size, size) ? -1 : 1;
}

/* Makes the grid of the scene's own box. Where it has a single layer with no ceiling above, that
 * lies in the ground or among what stands on it: then it gets air. */
static struct error *fit_scene(struct place_grid *grid, const struct place_options *o,
                               const struct place_world *world)
{
    static const char *const axes[] = {"X", "Y", "Z"};
    double nodes[3];
    int axis = 0;
    bool open = false;
    place_grid_nodes(grid, nodes);
    for (int k = 1; k < 3; k++)
        if (grid->max[k] - grid->min[k] < grid->max[axis] - grid->min[axis])
            axis = k;
    const double way = find_way(world->scene, axis);
    struct error *err = NULL;
    if (nodes[axis] <= 1)
        err = find_open(world->scene, axis, way, &open);
    if (err || !open)
        return err;
    const double layers = o->count_given ? fmin(AIR_LAYERS, floor(o->count)) : AIR_LAYERS;
    if (o->count_given) {
        const double s = find_spacing(grid->min, grid->max, axis, layers, o->count);
        grid->spacing[0] = grid->spacing[1] = grid->spacing[2] = s;
    }
    const double air = layers * grid->spacing[axis];
    if (way > 0)
        grid->max[axis] += air;
    else
        grid->min[axis] -= air;
    warnings_add(world->warnings, "open ground",
                 "the scene is flat along %s: the grid gets %.0f spacings of air, %g, %s it "
                 "(--bounds says otherwise)",
                 axes[axis], layers, air, way > 0 ? "above" : "below");
    return NULL;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct place_grid grid = {.spacing = {o->spacing[0], o->spacing[1], o->spacing[2]}};
    struct error *err = place_box(o, world->scene, grid.min, grid.max);
    if (!err && o->count_given) {
        grid.spacing[0] = place_grid_spacing(grid.min, grid.max, o->count);
        if (!(grid.spacing[0] > 0))
            err = error_new("the box is a point: a grid of it needs --spacing");
        grid.spacing[1] = grid.spacing[2] = grid.spacing[0];
    }
    if (!err && !o->bounds_given)
        err = fit_scene(&grid, o, world);
    memcpy(world->spacing, grid.spacing, sizeof world->spacing);
    return err ? err : place_grid(place, &grid, world->most);
}

const struct place_method place_method_grid = {
    .name = "grid", .origin = 1, .rows = rows, .check = check, .place = place_by_options};
