#include "place/place.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/angle.h"
#include "math/vec.h"
#include "place/vertices.h"
#include "scene/scene.h"
#include "stream/points.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void place_clear(struct place *place)
{
    free(place->position);
    free(place->normal);
    *place = (struct place){0};
}

static struct error *check_count(double count, double most)
{
    if (count > most)
        return error_new("this makes %.0f probes, more than --max-probes %.0f", count, most);
    return NULL;
}

static struct error *append(struct place *place, const double p[3])
{
    size_t room = place->capacity;
    struct error *err =
        array_reserve(&place->position, &room, place->count + 1, 3 * sizeof *place->position);
    if (err)
        return err;
    place->capacity = room;
    memcpy(place->position + 3 * place->count++, p, 3 * sizeof *p);
    return NULL;
}

/* -- grid ------------------------------------------------------------------------------------- */

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
    struct error *err = check_count(nodes[0] * nodes[1] * nodes[2], most);
    for (int k = 0; k < 3; k++) /* centred: what is left of the box is shared by both ends */
        start[k] = (grid->min[k] + grid->max[k]) / 2 - (nodes[k] - 1) / 2 * grid->spacing[k];
    for (double z = 0; z < nodes[2] && !err; z++)
        for (double y = 0; y < nodes[1] && !err; y++)
            for (double x = 0; x < nodes[0] && !err; x++)
                err = append(place, (const double[3]){start[0] + x * grid->spacing[0],
                                                      start[1] + y * grid->spacing[1],
                                                      start[2] + z * grid->spacing[2]});
    return err;
}

/* -- points and paths ------------------------------------------------------------------------- */

struct error *place_points(struct place *place, const char *path, double most)
{
    enum { BLOCK = 1024 };
    struct points *points = NULL;
    double *value = NULL;
    struct error *err = points_open(&points, path, POINTS_TEXT, false);
    if (!err)
        err = array_create(&value, 6 * BLOCK, sizeof *value);
    for (size_t got = 1; !err && got;) {
        size_t width = 0;
        err = points_read(points, BLOCK, value, &width, &got);
        if (!err && got && width != 3)
            err = points_place(points, 0, error_new("expected x y z, got %zu numbers", width));
        if (!err)
            err = check_count((double)(place->count + got), most);
        for (size_t i = 0; i < got && !err; i++)
            err = append(place, value + 3 * i);
    }
    free(value);
    points_close(points);
    return err;
}

struct error *place_path(struct place *place, const char *path, double step, double most)
{
    struct place vertices = {0};
    struct error *err = place_points(&vertices, path, INFINITY);
    for (size_t i = 0; i < vertices.count && !err; i++) {
        const struct vec3 a = vec3_load(vertices.position + 3 * i);
        err = append(place, vertices.position + 3 * i);
        if (err || i + 1 == vertices.count)
            break;
        const struct vec3 way = vec3_sub(vec3_load(vertices.position + 3 * (i + 1)), a);
        /* none longer than the step */
        const double parts = ceil(vec3_length(way) / step * (1 - 1e-12));
        err = check_count((double)place->count + parts, most);
        for (double n = 1; n < parts && !err; n++) {
            double p[3];
            vec3_store(p, vec3_fma(a, n / parts, way));
            err = append(place, p);
        }
    }
    place_clear(&vertices);
    return err;
}

/* -- vertices --------------------------------------------------------------------------------- */

struct error *place_vertices(struct place *place, const struct scene *scene, double offset,
                             double crease, double most)
{
    struct vertices vertices = {0};
    struct error *err = vertices_find(scene, crease, &vertices);
    if (!err && !vertices.count)
        err = error_new("no face of the scene has an area: there are no vertices");
    if (!err)
        err = check_count((double)vertices.count, most);
    if (!err)
        err = array_create(&place->normal, 3 * vertices.count, sizeof *place->normal);
    for (size_t i = 0; i < vertices.count && !err; i++) {
        const struct vertex *v = &vertices.list[i];
        double p[3];
        vec3_store(p, vec3_fma(vec3_load(v->position), offset, vec3_load(v->normal)));
        for (size_t k = 0; k < 3; k++)
            place->normal[3 * i + k] = (float)v->normal[k];
        err = append(place, p);
    }
    vertices_clear(&vertices);
    return err;
}

/* -- solids ----------------------------------------------------------------------------------- */

enum piece { PIECE_OPEN, PIECE_SOLID, PIECE_ROOM };

struct box {
    double low[3], high[3];
};

static void box_of_pieces(const struct scene *scene, const struct scene_solids *solids,
                          struct box *box)
{
    for (size_t i = 0; i < solids->count; i++)
        box[i] = (struct box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const double *m = scene->instances[i].transform;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            struct box *b = &box[solids->piece_of[solids->offset[i] + t]];
            for (size_t c = 0; c < 3; c++) {
                const double *p = mesh->position + 3 * (size_t)mesh->index[3 * t + c];
                for (int k = 0; k < 3; k++) {
                    const double x = m[4 * k] * p[0] + m[4 * k + 1] * p[1] + m[4 * k + 2] * p[2] +
                                     m[4 * k + 3];
                    b->low[k] = fmin(b->low[k], x);
                    b->high[k] = fmax(b->high[k], x);
                }
            }
        }
    }
}

/* Whether a point is within the box and not at its faces, where what is put on a solid lies. */
static bool well_within(const struct box *box, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        const double margin = 1e-3 * (box->high[k] - box->low[k]);
        if (!(p[k] > box->low[k] + margin && p[k] < box->high[k] - margin))
            return false;
    }
    return true;
}

static bool holds_box(const struct box *outer, const struct box *inner)
{
    double centre[3];
    for (int k = 0; k < 3; k++) {
        if (inner->low[k] < outer->low[k] || inner->high[k] > outer->high[k])
            return false;
        centre[k] = inner->low[k] / 2 + inner->high[k] / 2;
    }
    return well_within(outer, centre);
}

static bool is_room(const struct scene *scene, const struct scene_solids *solids,
                    const struct box *box, size_t piece)
{
    for (size_t i = 0; i < solids->count; i++)
        if (i != piece && holds_box(&box[piece], &box[i]))
            return true;
    for (size_t i = 0; i < scene->light_count; i++) {
        const struct scene_light *light = &scene->lights[i];
        const double p[3] = {light->position.x, light->position.y, light->position.z};
        if (light->kind != SCENE_SUN && well_within(&box[piece], p))
            return true;
    }
    return false;
}

struct by_size {
    double volume;
    size_t piece;
};

static int compare_sizes(const void *a, const void *b)
{
    const struct by_size *x = a, *y = b;
    if (x->volume != y->volume)
        return x->volume > y->volume ? -1 : 1;
    return x->piece < y->piece ? -1 : 1;
}

static struct error *judge_pieces(const struct scene *scene, const struct scene_solids *solids,
                                  enum piece *kind)
{
    enum { ROOMS_LOOKED_FOR = 256 }; /* among the largest pieces: a room is no small one */
    struct box *box = NULL;
    struct by_size *order = NULL;
    struct error *err = array_create(&box, solids->count, sizeof *box);
    if (!err)
        err = array_create(&order, solids->count, sizeof *order);
    if (!err) {
        box_of_pieces(scene, solids, box);
        size_t closed = 0;
        for (size_t i = 0; i < solids->count; i++) {
            kind[i] = !solids->closed[i]      ? PIECE_OPEN
                      : solids->volume[i] > 0 ? PIECE_SOLID
                                              : PIECE_ROOM;
            if (kind[i] == PIECE_SOLID)
                order[closed++] = (struct by_size){solids->volume[i], i};
        }
        qsort(order, closed, sizeof *order, compare_sizes);
        for (size_t i = 0; i < closed && i < ROOMS_LOOKED_FOR; i++)
            if (is_room(scene, solids, box, order[i].piece))
                kind[order[i].piece] = PIECE_ROOM;
    }
    free(box);
    free(order);
    return err;
}

/* How many of the rays around a position meet back faces. */
struct look {
    int solid, open; /* of solids, of open pieces */
};

struct look_job {
    const struct place *place;
    const struct tracer *tracer;
    const struct place_inside_settings *settings;
    const struct scene_solids *solids;
    const enum piece *kind;
    struct look *look;
};

/* Directions of a spherical Fibonacci lattice (Marques et al. 2013). */
static void lattice_direction(int i, int count, double d[3])
{
    const double golden = 0.61803398874989484820,
                 turn = (i * golden - floor(i * golden)) * 2 * ANGLE_PI;
    const double z = 1 - (2 * i + 1.0) / count, r = sqrt(1 - z * z);
    d[0] = r * angle_cos(turn);
    d[1] = r * angle_sin(turn);
    d[2] = z;
}

static struct error *look_around(void *context, size_t index, int thread)
{
    (void)thread;
    const struct look_job *job = context;
    for (int i = 0; i < job->settings->rays; i++) {
        double d[3];
        lattice_direction(i, job->settings->rays, d);
        const struct trace_hit hit =
            trace_nearest(job->tracer, job->place->position + 3 * index, d, INFINITY);
        if (!hit.hit || hit.front)
            continue;
        const enum piece kind =
            job->kind[job->solids->piece_of[job->solids->offset[hit.instance] + hit.triangle]];
        job->look[index].solid += kind == PIECE_SOLID;
        job->look[index].open += kind == PIECE_OPEN;
    }
    return NULL;
}

struct place_inside_settings place_inside_default(void)
{
    return (struct place_inside_settings){.rays = 64, .backface_share = 0.9, .threads = 1};
}

/* Where more of the positions than this see back faces of open pieces, the faces are not oriented:
 * even a level that is hewn out of rock has more air than that. */
#define ORIENTED_SHARE 0.95

static void judge_positions(const struct place *place, const struct place_inside_settings *settings,
                            const struct look *look, bool *inside, struct warnings *warnings)
{
    size_t by_open = 0;
    for (size_t i = 0; i < place->count; i++) {
        /* half of them, from a position on a solid's surface */
        inside[i] = 4 * look[i].solid > settings->rays;
        by_open += !inside[i] &&
                   look[i].solid + look[i].open > settings->backface_share * settings->rays;
    }
    if ((double)by_open > ORIENTED_SHARE * (double)place->count) {
        warnings_add(
            warnings, "orientation",
            "%zu of %zu probes see back faces nearly everywhere: the scene's faces are not "
            "oriented, and only closed solids are recognised",
            by_open, place->count);
        return;
    }
    for (size_t i = 0; i < place->count; i++)
        inside[i] = inside[i] ||
                    look[i].solid + look[i].open > settings->backface_share * settings->rays;
}

struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, bool *inside,
                           struct warnings *warnings)
{
    const struct scene *scene = trace_scene(tracer);
    struct scene_solids solids = {0};
    enum piece *kind = NULL;
    struct look_job job = {
        .place = place, .tracer = tracer, .settings = settings, .solids = &solids};
    struct error *err = scene_solids(scene, &solids, warnings);
    if (!err)
        err = array_create(&kind, solids.count, sizeof *kind);
    if (!err)
        err = array_create(&job.look, place->count, sizeof *job.look);
    if (!err)
        err = judge_pieces(scene, &solids, kind);
    job.kind = kind;
    if (!err)
        err = threads_for(settings->threads, place->count, look_around, &job);
    if (!err)
        judge_positions(place, settings, job.look, inside, warnings);
    free(job.look);
    free(kind);
    scene_solids_clear(&solids);
    return err;
}
