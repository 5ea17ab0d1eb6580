/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_inside.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/direction.h"
#include "place/place.h"
#include "place/place_pieces.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

/* Backs that are less than this share of all directions prove nothing: rays along edges, a sign
 * that is seen from behind. */
#define LEAST_SEEN (1.0 / 16)
/* From this share of backs on, it is asked whether the fronts are behind a sheet themselves. */
#define DOUBTFUL .25
/* Where more of the positions than this would go, and hardly anything escapes from them, the sheets
 * look the wrong way. */
#define NEARLY_ALL .95
#define ENCLOSED (1.0 / 8)

struct place_inside_settings place_inside_default(void)
{
    return (struct place_inside_settings){.rays = 64, .backface_share = 0.75, .threads = 1};
}

/* -- looking ---------------------------------------------------------------------------------- */

/* How many rays around a position met what. */
struct look {
    int count[SIGHTS];
};

struct look_job {
    const struct place *place;
    const struct tracer *tracer;
    const struct place_inside_settings *settings;
    const struct place_pieces *pieces;
    struct look *look;
};

static int backs_of(const struct look *look)
{
    return look->count[SIGHT_BEHIND] + look->count[SIGHT_VOID];
}

/* Of what says something; what does not is held to be half front, half nothing. */
static double back_share(const struct look *look)
{
    const double backs = backs_of(look),
                 all = backs + look->count[SIGHT_FRONT] + .5 * look->count[SIGHT_UNKNOWN];
    return all > 0 ? backs / all : 0;
}

static enum place_side side_of(const struct look *look, const struct place_inside_settings *s)
{
    const double least = LEAST_SEEN * s->rays;
    if (look->count[SIGHT_SOLID] >= least)
        return PLACE_SOLID;
    if (look->count[SIGHT_LAMP] || !backs_of(look) || back_share(look) < s->backface_share)
        return PLACE_AIR;
    if (look->count[SIGHT_VOID] > look->count[SIGHT_BEHIND])
        return PLACE_VOID; /* of a closed piece: a single ray proves it */
    return backs_of(look) >= least ? PLACE_BEHIND : PLACE_AIR;
}

/* Whether a front that was seen is behind a sheet itself. A solid's is when most that it looks at
 * are backs, and it does not look up: a foundation under the ground, but not the ground behind a
 * wall. Any is when it looks at nothing else: the floor in a box that has no bottom. */
static bool is_buried(const struct place_pieces *pieces, const struct place_sight *front,
                      struct vec3 direction)
{
    enum { RAYS = 32 }; /* half of them into the surface: left out */
    const struct trace_hit *hit = &front->hit;
    const double facing = vec3_dot(hit->normal, direction);
    struct look look = {0};
    double p[3]; /* a little before the surface */
    vec3_store(p, vec3_fma(hit->position, -1e-3 * hit->distance, direction));
    for (int i = 0; i < RAYS; i++) {
        const struct vec3 d = direction_even(i, RAYS);
        if (vec3_dot(d, hit->normal) * facing < 0)
            look.count[place_sight(pieces, p, d).what]++;
    }
    if (look.count[SIGHT_LAMP])
        return false;
    const double upward = vec3_dot(hit->normal, pieces->up) * (facing < 0 ? 1 : -1);
    if (pieces->kind[front->piece] == PIECE_SOLID && upward < .5)
        return back_share(&look) >= .5;
    return back_share(&look) >= .9 && look.count[SIGHT_ESCAPED] <= RAYS / 16;
}

/* Takes away the share of the fronts which are buried; every fourth is asked. */
static void leave_out_buried(const struct look_job *job, const double p[3], struct look *look)
{
    int asked = 0, buried = 0, fronts = 0;
    for (int i = 0; i < job->settings->rays; i++) {
        const struct vec3 d = direction_even(i, job->settings->rays);
        const struct place_sight s = place_sight(job->pieces, p, d);
        if (s.what != SIGHT_FRONT || fronts++ % 4)
            continue;
        asked++;
        buried += is_buried(job->pieces, &s, d);
    }
    if (asked)
        look->count[SIGHT_FRONT] -= fronts * buried / asked;
}

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

static struct error *look_around(void *context, size_t index, int thread)
{
    (void)thread;
    const struct look_job *job = context;
    const double *p = job->place->position + 3 * index;
    struct look *look = &job->look[index];
    for (int i = 0; i < job->settings->rays; i++)
        look->count[place_sight(job->pieces, p, direction_even(i, job->settings->rays)).what]++;
    if (look->count[SIGHT_ESCAPED] == job->settings->rays)
        look_far(job->pieces, p, look);
    const double share = back_share(look);
    if (side_of(look, job->settings) == PLACE_AIR && !look->count[SIGHT_LAMP] &&
        share >= DOUBTFUL && share < job->settings->backface_share)
        leave_out_buried(job, p, look);
    if (side_of(look, job->settings) > PLACE_SOLID && is_lit(job->tracer, p))
        look->count[SIGHT_LAMP]++;
    return NULL;
}

/* -- judging ---------------------------------------------------------------------------------- */

/* How the sheets of the scene look, by the positions that are not in solids. */
static void judge_sheets(const struct look_job *job, struct warnings *warnings)
{
    const struct place_inside_settings *settings = job->settings;
    struct look *look = job->look;
    size_t all = 0, mixed = 0, behind = 0, enclosed = 0;
    for (size_t i = 0; i < job->place->count; i++) {
        const enum place_side side = side_of(&look[i], settings);
        const double share = back_share(&look[i]);
        if (side == PLACE_SOLID)
            continue;
        all++;
        behind += side == PLACE_BEHIND;
        mixed += look[i].count[SIGHT_BEHIND] >= LEAST_SEEN * settings->rays && share > .25 &&
                 share < .75;
        enclosed += side == PLACE_BEHIND &&
                    look[i].count[SIGHT_ESCAPED] <= ENCLOSED * settings->rays;
    }
    if (2 * mixed > all)
        warnings_add(warnings, "orientation",
                     "%zu of %zu probes see about as many backs as fronts: open surfaces are not "
                     "oriented, and closed pieces alone tell inside from outside",
                     mixed, all);
    else if ((double)enclosed > NEARLY_ALL * (double)all ||
             (2 * behind > all && job->pieces->upside_down))
        warnings_add(warnings, "orientation",
                     "%zu of %zu probes see backs on nearly all sides: open surfaces are taken as "
                     "turned inside out",
                     behind, all);
    else
        return;
    for (size_t i = 0; i < job->place->count; i++) {
        int *of = look[i].count, fronts = of[SIGHT_FRONT];
        of[SIGHT_FRONT] = 2 * mixed > all ? of[SIGHT_FRONT] : of[SIGHT_BEHIND];
        of[SIGHT_BEHIND] = 2 * mixed > all ? 0 : fronts;
    }
}

struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, enum place_side *side,
                           struct warnings *warnings)
{
    struct place_pieces pieces = {0};
    struct look_job job = {
        .place = place, .tracer = tracer, .settings = settings, .pieces = &pieces};
    struct error *err = place_pieces_find(&pieces, tracer, place, warnings);
    if (!err)
        err = array_create(&job.look, place->count, sizeof *job.look);
    if (!err)
        err = threads_for(settings->threads, place->count, look_around, &job);
    if (!err)
        judge_sheets(&job, warnings);
    for (size_t i = 0; i < place->count && !err; i++)
        side[i] = side_of(&job.look[i], settings);
    free(job.look);
    place_pieces_clear(&pieces);
    return err;
}
