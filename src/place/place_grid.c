#include "base/error.h"
#include "base/options.h"
#include "math/vec.h"
#include "place/place_method.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

void place_grid_nodes(const struct place_grid *grid, double nodes[3])
{
    for (int k = 0; k < 3; k++) /* a whole number of spacings, but for rounding, is whole */
        nodes[k] = fmax(floor((grid->max[k] - grid->min[k]) / grid->spacing[k] * (1 + 1e-12)), 1);
}

static double node_count(const double min[3], const double max[3], double spacing)
{
    const struct place_grid grid = {.min = {min[0], min[1], min[2]},
                                    .max = {max[0], max[1], max[2]},
                                    .spacing = {spacing, spacing, spacing}};
    double nodes[3];
    place_grid_nodes(&grid, nodes);
    return nodes[0] * nodes[1] * nodes[2];
}

double place_grid_spacing(const double min[3], const double max[3], double count)
{
    double low = 0, high = 0; /* low makes too many, high does not */
    for (int k = 0; k < 3; k++)
        high = fmax(high, max[k] - min[k]);
    for (int step = 0; step < 200 && high - low > 1e-12 * high; step++) {
        const double middle = low + (high - low) / 2;
        if (node_count(min, max, middle) > count)
            low = middle;
        else
            high = middle;
    }
    return high;
}

struct error *place_grid(struct place *place, const struct place_grid *grid, double most)
{
    double nodes[3], start[3];
    place_grid_nodes(grid, nodes);
    struct error *err = place_check_count(nodes[0] * nodes[1] * nodes[2], most);
    for (int k = 0; k < 3; k++) /* centred: what is left of the box is shared by both ends */
        start[k] = (grid->min[k] + grid->max[k]) / 2 - (nodes[k] - 1) / 2 * grid->spacing[k];
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
    *row++ = (struct option_row){.name = "spacing",
                                 .letter = 's',
                                 .argument = "S|SX,SY,SZ",
                                 .kind = OPTION_CALL,
                                 .value = o->spacing,
                                 .parse = parse_spacing,
                                 .given = &o->spacing_given,
                                 .help = "grid: distance between probes, in units of the scene"};
    *row++ = (struct option_row){
        .name = "count",
        .letter = 'n',
        .argument = "N",
        .kind = OPTION_REAL,
        .value = &o->count,
        .least = 1,
        .most = 1e15,
        .given = &o->count_given,
        .help = "grid: the finest spacing that makes at most N probes, before those\n"
                "inside solids go"};
    *row++ = (struct option_row){.name = "bounds",
                                 .argument = "X0,Y0,Z0,X1,Y1,Z1",
                                 .kind = OPTION_REALS,
                                 .count = 6,
                                 .value = o->bounds,
                                 .given = &o->bounds_given,
                                 .help = "grid: fill this box (default: the scene's)"};
    return row;
}

static struct error *check(const struct place_options *o, bool scene)
{
    if (o->spacing_given == o->count_given)
        return error_usage("grid: expected either --spacing or --count");
    if (!scene && !o->bounds_given)
        return error_usage("grid: expected a SCENE or --bounds");
    return NULL;
}

static struct error *find_box(const struct place_options *o, const struct scene *scene,
                              double min[3], double max[3])
{
    if (!o->bounds_given) {
        vec3_store(min, scene->box_min);
        vec3_store(max, scene->box_max);
        return NULL;
    }
    memcpy(min, o->bounds, 3 * sizeof *min);
    memcpy(max, o->bounds + 3, 3 * sizeof *max);
    for (int k = 0; k < 3; k++)
        if (min[k] > max[k])
            return error_usage("--bounds: expected X0,Y0,Z0 below X1,Y1,Z1, got %g above %g",
                               min[k], max[k]);
    return NULL;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      const struct place_world *world)
{
    struct place_grid grid = {.spacing = {o->spacing[0], o->spacing[1], o->spacing[2]}};
    struct error *err = find_box(o, world->scene, grid.min, grid.max);
    if (!err && o->count_given) {
        grid.spacing[0] = place_grid_spacing(grid.min, grid.max, o->count);
        if (!(grid.spacing[0] > 0))
            err = error_new("the box is a point: a grid of it needs --spacing");
        grid.spacing[1] = grid.spacing[2] = grid.spacing[0];
    }
    return err ? err : place_grid(place, &grid, world->most);
}

const struct place_method place_method_grid = {
    .name = "grid", .rows = rows, .check = check, .place = place_by_options};
