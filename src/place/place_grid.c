/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "math/vec.h"
#include "place/place_grid.h"
#include "place/place_ground.h"
#include "place/place_method.h"
#include "place/up.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- nodes ------------------------------------------------------------------------------------ */

/* Along an axis: how many, the first one, and from one to the next. */
struct line {
    double nodes, first, step;
};

static struct line line_of(const struct place_grid *grid, int axis)
{
    const double length = grid->box.high[axis] - grid->box.low[axis], s = grid->spacing[axis],
                 room = length - 2 * (grid->share ? grid->clearance * s : grid->clearance);
    struct line line = {.nodes = 1, .first = (grid->box.low[axis] + grid->box.high[axis]) / 2};
    if (room <= s / 2)
        return line;
    const double steps = fmax(ceil(room / s * (1 - 1e-12)), 1);
    line.nodes = steps + 1;
    line.step = grid->share ? length / (steps + 2 * grid->clearance) : room / steps;
    line.first -= steps / 2 * line.step;
    return line;
}

void place_grid_nodes(const struct place_grid *grid, double nodes[3])
{
    for (int k = 0; k < 3; k++)
        nodes[k] = line_of(grid, k).nodes;
}

static void set_spacing(struct place_grid *grid, int count, double spacing)
{
    for (int i = 0; i < count; i++)
        grid[i].spacing[0] = grid[i].spacing[1] = grid[i].spacing[2] = spacing;
}

/* -- several boxes ---------------------------------------------------------------------------- */

/* The shortest way from node to node; INFINITY where there is one alone. */
static double least_step(const struct place_grid *grid, int without)
{
    double least = INFINITY;
    for (int k = 0; k < 3; k++) {
        const double step = line_of(grid, k).step;
        if (step > 0 && k != without)
            least = fmin(least, step);
    }
    return least;
}

/* Whether p is where the box is, or nearer to a node of it than that; without an axis, -1: none. */
static bool is_taken(const struct place_grid *grid, const double p[3], double near, int without)
{
    double q[3], square = 0;
    bool within = true;
    place_box_turn(&grid->box, grid->up, true, p, q);
    for (int k = 0; k < 3; k++) {
        const struct line line = line_of(grid, k);
        if (k == without)
            continue;
        within = within && q[k] >= grid->box.low[k] && q[k] <= grid->box.high[k];
        const double number = line.step > 0 ? floor((q[k] - line.first) / line.step + .5) : 0,
                     off = q[k] - line.first - fmin(fmax(number, 0), line.nodes - 1) * line.step;
        square += off * off;
    }
    return within || square < near * near;
}

/* Whether a node of grid[at] gives way to an earlier box. */
static bool is_given(const struct place_grid *grid, int at, const double p[3], double own,
                     int without)
{
    for (int i = 0; i < at; i++) {
        const double step = fmin(own, least_step(&grid[i], without));
        if (is_taken(&grid[i], p, step < (double)INFINITY ? step / 2 : 0, without))
            return true;
    }
    return false;
}

/* Whether a node is a corner of a cell of the grid that the region comes into. */
static bool is_wanted(const struct place_grid *grid, const struct reach *reach, const double p[3])
{
    double margin[3], most = 0;
    if (!reach)
        return true;
    for (int k = 0; k < 3; k++) {
        const double step = line_of(grid, k).step;
        margin[k] = step > 0 ? step : (grid->box.high[k] - grid->box.low[k]) / 2;
        most = k == grid->up ? most : fmax(most, margin[k]);
    }
    for (int k = 0; k < 3; k++)
        margin[k] = k == grid->up || !(grid->box.turn < 0 || grid->box.turn > 0) ? margin[k] : most;
    return reach_near(reach, p, margin);
}

static double count_nodes(const struct place_grid *grid, int count)
{
    double all = 0;
    for (int i = 0; i < count; i++) {
        double nodes[3];
        place_grid_nodes(&grid[i], nodes);
        all += nodes[0] * nodes[1] * nodes[2];
    }
    return all;
}

struct error *place_grids(struct place *place, const struct place_grid *grid, int count,
                          const struct reach *reach, double most)
{
    struct error *err = reach ? NULL : place_check_count(count_nodes(grid, count), most);
    for (int i = 0; i < count && !err; i++) {
        const struct line x = line_of(&grid[i], 0), y = line_of(&grid[i], 1),
                          z = line_of(&grid[i], 2);
        const double own = least_step(&grid[i], -1);
        for (double c = 0; c < z.nodes && !err; c++)
            for (double b = 0; b < y.nodes && !err; b++)
                for (double a = 0; a < x.nodes && !err; a++) {
                    double p[3] = {x.first + a * x.step, y.first + b * y.step,
                                   z.first + c * z.step};
                    place_box_turn(&grid[i].box, grid[i].up, false, p, p);
                    if (!is_given(grid, i, p, own, -1) && is_wanted(&grid[i], reach, p))
                        err = place_append(place, p);
                    if (!err && reach)
                        err = place_check_count((double)place->count, most);
                }
    }
    return err;
}

/* -- on the ground ---------------------------------------------------------------------------- */

/* Of those from `first` on. */
static void keep_wanted(struct place *place, size_t first, const struct place_grid *grid,
                        const struct reach *reach)
{
    size_t kept = first;
    for (size_t i = first; i < place->count; i++)
        if (is_wanted(grid, reach, place->position + 3 * i))
            memmove(place->position + 3 * kept++, place->position + 3 * i,
                    3 * sizeof *place->position);
    place->count = kept;
}

/* within: and in the boxes. */
static struct error *place_columns(struct place *place, const struct place_grid *grid, int count,
                                   const struct place_ground *ground, const struct reach *reach,
                                   bool within, double most)
{
    const int up = ground->up, u = (up + 1) % 3, v = (up + 2) % 3;
    struct error *err = NULL;
    double columns = 0;
    for (int i = 0; i < count; i++)
        columns += line_of(&grid[i], u).nodes * line_of(&grid[i], v).nodes;
    if (!reach)
        err = place_check_count(columns * ground->layers, most);
    for (int i = 0; i < count && !err; i++) {
        const struct place_grid *g = &grid[i];
        const struct line x = line_of(g, u), y = line_of(g, v);
        const double own = least_step(g, up), ends[2] = {g->box.low[up], g->box.high[up]},
                     first = g->share ? g->clearance * g->spacing[up] : g->clearance;
        for (double b = 0; b < y.nodes && !err; b++)
            for (double a = 0; a < x.nodes && !err; a++) {
                double p[3] = {0};
                p[u] = x.first + a * x.step;
                p[v] = y.first + b * y.step;
                place_box_turn(&g->box, up, false, p, p);
                const size_t before = place->count;
                if (!is_given(grid, i, p, own, up))
                    err =
                        place_ground_column(place, ground, p, first, g->spacing[up], ends, within);
                keep_wanted(place, before, g, reach);
                if (!err)
                    err = place_check_count((double)place->count, most);
            }
    }
    return err;
}

/* -- by count --------------------------------------------------------------------------------- */

/* Of what is to be counted. */
struct counting {
    struct place_grid *grid;
    int count;
    const struct place_ground *ground; /* NULL: nodes of boxes */
    const struct reach *reach;         /* NULL: anywhere */
    bool within;
    double most; /* that there may be */
};

/* *fits: no more than may be are made with this spacing. */
static struct error *try_spacing(const struct counting *c, double spacing, bool *fits)
{
    set_spacing(c->grid, c->count, spacing);
    *fits = count_nodes(c->grid, c->count) <= c->most;
    if (!c->ground && !c->reach)
        return NULL;
    if (count_nodes(c->grid, c->count) > 1e3 * (c->most + 1000)) { /* hardly any is wanted */
        *fits = false;
        return NULL;
    }
    struct place place = {0};
    struct error *err =
        c->ground ? place_columns(&place, c->grid, c->count, c->ground, c->reach, c->within, 1e15)
                  : place_grids(&place, c->grid, c->count, c->reach, c->most);
    *fits = !err && (double)place.count <= c->most;
    if (err && (double)place.count > c->most) { /* it was not made to its end */
        error_destroy(err);
        err = NULL;
    }
    place_clear(&place);
    return err;
}

/* Gives the grids the smallest spacing that fits. */
static struct error *find_spacing(const struct counting *c)
{
    double low = 0, high = 0; /* low makes too many, high does not */
    bool fits = false;
    for (int i = 0; i < c->count; i++)
        for (int k = 0; k < 3; k++)
            high = fmax(high, 2.5 * (c->grid[i].box.high[k] - c->grid[i].box.low[k]));
    if (!(high > 0))
        return error_new("the box is a point: a grid of it needs --spacing");
    struct error *err = try_spacing(c, high, &fits);
    const double exact = c->ground || c->reach ? 1e-3 : 1e-12;
    for (int step = 0; step < 200 && high - low > exact * high && fits && !err; step++) {
        const double middle = low + (high - low) / 2;
        bool now = false;
        err = try_spacing(c, middle, &now);
        if (now)
            high = middle;
        else
            low = middle;
    }
    set_spacing(c->grid, c->count, high);
    return err;
}

double place_grid_spacing(struct place_grid *grid, int count, double most)
{
    const struct counting c = {.grid = grid, .count = count, .most = most};
    error_destroy(find_spacing(&c));
    return grid->spacing[0];
}

/* -- options ---------------------------------------------------------------------------------- */

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

static struct error *parse_bounds(void *value, const char *text)
{
    struct place_options *o = value;
    double ends[6];
    struct error *err = options_reals("--bounds", text, 6, ends);
    if (!err && o->boxes == PLACE_BOXES)
        err = error_usage("--bounds: expected at most %d boxes", PLACE_BOXES);
    for (int k = 0; k < 3 && !err; k++)
        if (ends[k] > ends[3 + k])
            err = error_usage("--bounds: expected X0,Y0,Z0 below X1,Y1,Z1, got %g above %g",
                              ends[k], ends[3 + k]);
    if (err)
        return err;
    struct place_box *box = &o->box[o->boxes++];
    memcpy(box->low, ends, sizeof box->low);
    memcpy(box->high, ends + 3, sizeof box->high);
    box->turn = o->turn;
    return NULL;
}

static struct error *parse_turn(void *value, const char *text)
{
    struct place_options *o = value;
    double *turn = o->boxes ? &o->box[o->boxes - 1].turn : &o->turn;
    struct error *err = options_real("--turn", text, turn);
    return err || (*turn >= -360 && *turn <= 360)
               ? err
               : error_usage("--turn: expected degrees between -360 and 360, got %g", *turn);
}

/* A length, or a share of the spacing in percent. */
static struct error *parse_clearance(void *value, const char *text)
{
    struct place_options *o = value;
    const size_t length = strlen(text);
    char number[64];
    o->clearance_share = length > 1 && text[length - 1] == '%';
    snprintf(number, sizeof number, "%.*s",
             (int)fmin((double)(length - o->clearance_share), sizeof number - 1.0), text);
    struct error *err = options_real("--clearance", number, &o->clearance);
    if (!err && o->clearance < 0)
        err = error_usage("--clearance: expected a length or a share of 0 or more, got %s", text);
    if (!err && o->clearance_share) {
        o->clearance /= 100;
        if (o->clearance > .5)
            err = error_usage("--clearance: expected 50%% of the spacing or less, got %s", text);
    }
    return err;
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "spacing",
         .letter = 's',
         .argument = "S|SX,SY,SZ",
         .kind = OPTION_CALL,
         .value = o->spacing,
         .parse = parse_spacing,
         .given = &o->spacing_given,
         .help = "grid, and those that start from one: the greatest distance between\n"
                 "probes, in units of the scene"},
        {.name = "count",
         .letter = 'n',
         .argument = "N",
         .kind = OPTION_REAL,
         .value = &o->count,
         .least = 1,
         .most = 1e15,
         .given = &o->count_given,
         .help = "grid, and those that start from one: the finest spacing that makes at\n"
                 "most N probes, before those in no air go; poisson: the least radii"},
        {.name = "bounds",
         .argument = "X0,Y0,Z0,X1,Y1,Z1",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_bounds,
         .given = &o->bounds_given,
         .shown = "the scene's box",
         .help = "grid, and those that start from one: fill this box, may repeat;\n"
                 "adaptive: stay in it"},
        {.name = "turn",
         .argument = "DEGREES",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_turn,
         .given = &o->turn_given,
         .shown = "0",
         .help = "grid: turn the box of the --bounds before it about its middle,\n"
                 "counter-clockwise seen from above; before any: all"},
        {.name = "clearance",
         .argument = "D|SHARE%",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_clearance,
         .given = &o->clearance_given,
         .shown = "10%",
         .help = "grid: how far the outermost probes are from the box, and the\n"
                 "lowest from the ground, as a length or a share of the spacing"},
        {.name = "ground",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->ground,
         .least = 1,
         .most = 1000,
         .given = &o->ground_given,
         .shown = "3 where the scene is an open ground",
         .help = "grid: columns of N probes that stand on the floors below"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

static struct error *check(const struct place_options *o, bool scene)
{
    if (o->spacing_given == o->count_given)
        return error_usage("expected either --spacing or --count");
    if (!scene && !o->bounds_given)
        return error_usage("expected a SCENE or --bounds");
    if (!scene && o->ground_given)
        return error_usage("--ground needs a SCENE");
    if (o->count_given && o->count < o->boxes)
        return error_usage("expected a --count of at least 1 for each of %d boxes, got %g",
                           o->boxes, o->count);
    return NULL;
}

/* -- the method ------------------------------------------------------------------------------- */

/* Layers above an open ground that is flatter than two spacings: those that a blend needs to tell
 * the ground's light from the sky's. */
enum { AIR_LAYERS = 3 };

static struct error *place_on_ground(struct place *place, struct counting *c,
                                     struct place_ground *ground, const struct place_options *o,
                                     double most)
{
    struct error *err = NULL;
    c->ground = ground;
    if (o->count_given && o->count < ground->layers)
        ground->layers = (int)o->count;
    if (o->count_given)
        err = find_spacing(c);
    if (!err)
        err = place_columns(place, c->grid, c->count, ground, c->reach, c->within, most);
    if (!err && o->count_given && (double)place->count > o->count)
        place->count = (size_t)o->count; /* a column alone, of many floors */
    if (!err && !place->count)
        err = error_new("no column of the grid meets a floor: there is no ground to stand on");
    return err;
}

/* The scene's own box, where it has room for one layer and no ceiling, has its probes on the
 * ground. */
static bool is_flat(const struct place_grid *grid, int *axis)
{
    *axis = 0;
    for (int k = 1; k < 3; k++)
        if (grid->box.high[k] - grid->box.low[k] < grid->box.high[*axis] - grid->box.low[*axis])
            *axis = k;
    return grid->box.high[*axis] - grid->box.low[*axis] < 2 * grid->spacing[*axis];
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    static const char *const axes[] = {"X", "Y", "Z"};
    struct place_grid *grid = NULL;
    struct tracer *tracer = NULL;
    struct reach *reach = NULL;
    const int count = o->boxes ? o->boxes : 1;
    struct error *err = array_create(&grid, (size_t)count, sizeof *grid);
    struct counting c = {.grid = grid, .count = count, .within = o->bounds_given, .most = o->count};
    for (int i = 0; i < count && !err; i++) {
        grid[i] = (struct place_grid){.up = up_axis(world->scene),
                                      .spacing = {o->spacing[0], o->spacing[1], o->spacing[2]},
                                      .clearance = o->clearance,
                                      .share = o->clearance_share};
        if (o->boxes)
            grid[i].box = o->box[i];
        else
            place_box_of_scene(world->scene, o->turn, &grid[i].box);
    }
    if (!err && (o->reach_given || o->ground_given))
        err = trace_create(&tracer, world->scene);
    if (!err)
        err = place_reach_open(&reach, o, tracer, world);
    c.reach = reach;
    if (reach && !o->boxes && !(o->turn < 0 || o->turn > 0))
        reach_box(reach, grid->box.low, grid->box.high);
    if (!err && o->count_given)
        err = find_spacing(&c);
    struct place_ground ground = {.layers = o->ground_given ? o->ground : AIR_LAYERS};
    if (!err)
        ground.up = grid->up;
    const bool flat = !err && !o->bounds_given && !reach && is_flat(grid, &ground.up);
    bool stands = false;
    if (flat && !tracer)
        err = trace_create(&tracer, world->scene);
    ground.tracer = tracer;
    if (!err && (flat || o->ground_given))
        stands = place_ground_look(&ground) || o->ground_given;
    if (!err)
        err = stands ? place_on_ground(place, &c, &ground, o, world->most)
                     : place_grids(place, grid, count, reach, world->most);
    if (!err && stands && !o->ground_given)
        warnings_add(world->warnings, "open ground",
                     "the scene is flat along %s: the grid stands on the ground, in %d layers up "
                     "to %g %s it (--ground and --bounds say otherwise)",
                     axes[ground.up], ground.layers,
                     (o->clearance_share ? o->clearance * grid->spacing[ground.up] : o->clearance) +
                         (ground.layers - 1) * grid->spacing[ground.up],
                     ground.way > 0 ? "above" : "below");
    if (grid)
        memcpy(world->spacing, grid->spacing, sizeof world->spacing);
    world->reach = reach;
    trace_destroy(tracer);
    free(grid);
    return err;
}

const struct place_method place_method_grid = {.name = "grid",
                                               .origin = 1,
                                               .reaches = true,
                                               .rows = rows,
                                               .check = check,
                                               .place = place_by_options};
