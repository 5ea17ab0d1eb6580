#include "place/place_inside.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/affine.h"
#include "math/angle.h"
#include "math/box.h"
#include "place/place.h"
#include "scene/scene.h"
#include "topology/solids.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

enum piece { PIECE_OPEN, PIECE_SOLID, PIECE_ROOM };

static void box_of_pieces(const struct scene *scene, const struct scene_solids *solids,
                          struct box *box)
{
    for (size_t i = 0; i < solids->count; i++)
        box[i] = box_empty();
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const double *m = scene->instances[i].transform;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            struct box *b = &box[solids->piece_of[solids->offset[i] + t]];
            for (size_t c = 0; c < 3; c++) {
                const double *p = mesh->position + 3 * (size_t)mesh->index[3 * t + c];
                double placed[3];
                vec3_store(placed, affine_point(m, p));
                box_add(b, placed);
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
