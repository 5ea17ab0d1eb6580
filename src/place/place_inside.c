/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_inside.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "math/box.h"
#include "math/cubes.h"
#include "math/direction.h"
#include "place/place.h"
#include "place/place_pieces.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where more of the positions than this would go, and hardly anything escapes from them, the sheets
 * look the wrong way. */
#define NEARLY_ALL .95
#define ENCLOSED (1.0 / 8)

struct place_inside_settings place_inside_default(void)
{
    return (struct place_inside_settings){.rays = 64, .backface_share = 0.75, .threads = 1};
}

/* -- looking ---------------------------------------------------------------------------------- */

struct look_job {
    const struct place *place;
    const struct tracer *tracer;
    const struct place_inside_settings *settings;
    const struct place_pieces *pieces;
    size_t count; /* of the positions, evenly taken */
    struct look *look;
};

static const double *look_position(const struct look_job *job, size_t index)
{
    const size_t at = (size_t)((double)index * (double)job->place->count / (double)job->count);
    return job->place->position + 3 * (job->count == job->place->count ? index : at);
}

static struct error *look_around(void *context, size_t index, int thread)
{
    (void)thread;
    const struct look_job *job = context;
    job->look[index] = look_at(job->pieces, job->tracer, job->settings, look_position(job, index));
    return NULL;
}

/* -- looking at many -------------------------------------------------------------------------- */

/* Of many positions, every fourth is looked at first. */
enum { MANY = 10000, STEP = 4 };

/* Whether b is seen from a, not far away. */
static bool is_seen(const struct look_job *job, const double a[3], const double b[3])
{
    return trace_visibility(job->tracer, a, b) >= 1;
}

/* Whether p is between a and b, which are near one another, and sees both. */
static bool is_between(const struct look_job *job, const double p[3], const double a[3],
                       const double b[3])
{
    const struct scene *scene = trace_scene(job->tracer);
    const double size = vec3_length(vec3_sub(scene->box_max, scene->box_min)),
                 to_a = vec3_length(vec3_sub(vec3_load(p), vec3_load(a))),
                 to_b = vec3_length(vec3_sub(vec3_load(p), vec3_load(b))),
                 all = vec3_length(vec3_sub(vec3_load(a), vec3_load(b)));
    return all < size / 16 && to_a + to_b < 1.1 * all && is_seen(job, p, a) && is_seen(job, p, b);
}

static struct error *look_first(void *context, size_t index, int thread)
{
    return look_around(context, STEP * index, thread);
}

/* Looks from the positions between two that were looked at first. Where these are of the same side,
 * who is between them and sees both is of that side, too: in the same air, or the same matter. */
static struct error *look_between(void *context, size_t index, int thread)
{
    const struct look_job *job = context;
    const size_t first = STEP * index, last = first + STEP;
    const struct look *a = &job->look[first], *b = &job->look[last];
    const bool same = last < job->count &&
                      look_side(a, job->settings) == look_side(b, job->settings);
    struct error *err = NULL;
    for (size_t i = first + 1; i < last && i < job->count && !err; i++)
        if (same && is_between(job, look_position(job, i), look_position(job, first),
                               look_position(job, last)))
            job->look[i] = *a;
        else
            err = look_around(context, i, thread);
    return err;
}

static struct error *look_all(struct look_job *job)
{
    const int threads = job->settings->threads;
    job->count = job->place->count;
    if (job->count < MANY)
        return threads_for(threads, job->count, look_around, job);
    const size_t first = (job->count + STEP - 1) / STEP;
    struct error *err = threads_for(threads, first, look_first, job);
    return err ? err : threads_for(threads, first, look_between, job);
}

/* -- air that goes on ------------------------------------------------------------------------- */

/* How far who asks looks for who is in the air, in the mean distance between positions. */
#define SPREAD_REACH 2.5

struct spread {
    const struct look_job *job;
    double reach;
    size_t *asking, *fresh; /* positions: behind sheets on a floor, newly in the air; owned */
    bool *found;            /* of those that ask: they see who is; owned */
    struct cubes air;       /* of the fresh */
};

struct spread_view {
    const struct tracer *tracer;
    const double *from;
};

static bool sees_air(void *context, const double *point)
{
    const struct spread_view *view = context;
    return trace_visibility(view->tracer, view->from, point) >= 1;
}

static struct error *look_for_air(void *context, size_t index, int thread)
{
    (void)thread;
    const struct spread *s = context;
    const double *p = s->job->place->position + 3 * s->asking[index];
    struct spread_view view = {s->job->tracer, p};
    s->found[index] = cubes_find(&s->air, p, s->reach, sees_air, &view, NULL);
    return NULL;
}

/* The mean distance between positions, by the box that they are in. */
static double mean_distance(const struct place *place)
{
    struct box box = box_empty();
    double size = 1;
    int axes = 0;
    for (size_t i = 0; i < place->count; i++)
        box_add(&box, place->position + 3 * i);
    for (int k = 0; k < 3 && place->count; k++)
        if (box.high[k] > box.low[k]) {
            size *= box.high[k] - box.low[k];
            axes++;
        }
    return axes ? pow(size / (double)place->count, 1.0 / axes) : 0;
}

static struct error *look_from_fresh(struct spread *s, size_t fresh, size_t asking)
{
    struct error *err = cubes_init(&s->air, s->reach, fresh);
    for (size_t i = 0; i < fresh && !err; i++)
        cubes_add(&s->air, s->job->place->position + 3 * s->fresh[i]);
    if (!err)
        err = threads_for(s->job->settings->threads, asking, look_for_air, s);
    cubes_clear(&s->air);
    return err;
}

/* The air is one: who stands on a floor behind sheets and sees, near by, who is in the air, is in
 * it as well, and so is who sees that one. So the far corners of a house of walls without
 * thickness are what its doorway is. */
static struct error *spread_air(const struct look_job *job, enum place_side *side)
{
    struct spread s = {.job = job, .reach = SPREAD_REACH * mean_distance(job->place)};
    size_t fresh = 0, asking = 0;
    struct error *err = array_create(&s.asking, job->place->count, sizeof *s.asking);
    if (!err)
        err = array_create(&s.fresh, job->place->count, sizeof *s.fresh);
    if (!err)
        err = array_create(&s.found, job->place->count, sizeof *s.found);
    for (size_t i = 0; i < job->place->count && !err; i++) {
        if (side[i] == PLACE_AIR)
            s.fresh[fresh++] = i;
        else if (side[i] == PLACE_BEHIND && job->look[i].floor)
            s.asking[asking++] = i;
    }
    while (!err && fresh && asking && s.reach > 0) {
        err = look_from_fresh(&s, fresh, asking);
        const size_t asked = asking;
        fresh = asking = 0;
        for (size_t i = 0; i < asked && !err; i++) {
            const size_t position = s.asking[i];
            if (s.found[i])
                side[s.fresh[fresh++] = position] = PLACE_AIR;
            else
                s.asking[asking++] = position;
        }
    }
    free(s.asking);
    free(s.fresh);
    free(s.found);
    return err;
}

/* -- surfaces that are seen from both sides ---------------------------------------------------- */

struct seen {
    double fronts, backs;
    size_t material; /* of a piece: the first of its faces that was seen */
};

/* Probes that are asked; how many looks what is seen of a material counts in what is seen of one
 * of its pieces, and how many what is seen of a piece counts in its material, at most. */
enum { SEEN_ASKED = 4096, SEEN_OF_MATERIAL = 256, SEEN_OF_PIECE = 32 };

static void add_seen(struct seen *sum, const struct seen *s, double most)
{
    const double all = s->fronts + s->backs, weight = all > most ? most / all : 1;
    sum->fronts += weight * s->fronts;
    sum->backs += weight * s->backs;
}

/* Whether a piece is seen from both sides. In a thicket each leaf is seen from few places; what is
 * seen of its material helps. */
static bool is_of_both(const struct seen *piece, const struct seen *material)
{
    struct seen s = *piece;
    add_seen(&s, material, SEEN_OF_MATERIAL);
    return s.backs > 0 && s.backs >= .25 * (s.backs + s.fronts);
}

/* Counts what the positions in the air see of open pieces. */
static void count_sides(const struct look_job *job, struct seen *of_piece)
{
    const struct place_pieces *pieces = job->pieces;
    for (size_t i = 0; i < job->count; i++) {
        if (look_side(&job->look[i], job->settings) != PLACE_AIR ||
            look_back_share(&job->look[i]) > .5)
            continue;
        for (int k = 0; k < PLACE_WAYS; k++) {
            const struct place_sight s = place_sight(pieces, look_position(job, i), pieces->way[k]);
            if (!s.hit.hit || s.what == SIGHT_UNKNOWN || pieces->solids->closed[s.piece])
                continue;
            struct seen *piece = &of_piece[s.piece];
            const bool back = s.what == SIGHT_BEHIND || s.what == SIGHT_VOID;
            if (piece->fronts + piece->backs == 0)
                piece->material = s.material;
            piece->backs += back;
            piece->fronts += !back;
        }
    }
}

/* Forgets the sides of open pieces that positions in the air see from behind about as often as from
 * before, such as leaves and paper walls. *any: there are such. */
static struct error *forget_two_sided(const struct look_job *job, struct place_pieces *pieces,
                                      bool *any)
{
    const struct scene *scene = trace_scene(job->tracer);
    struct seen *of_piece = NULL, *of_material = NULL;
    struct error *err = array_create(&of_piece, pieces->solids->count, sizeof *of_piece);
    if (!err)
        err = array_create(&of_material, scene->material_count, sizeof *of_material);
    if (!err)
        count_sides(job, of_piece);
    for (size_t i = 0; i < pieces->solids->count && !err; i++)
        if (of_piece[i].fronts + of_piece[i].backs > 0)
            add_seen(&of_material[of_piece[i].material], &of_piece[i], SEEN_OF_PIECE);
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            const size_t piece = pieces->solids->piece_of[pieces->solids->offset[i] + t];
            if (pieces->solids->closed[piece] || pieces->kind[piece] == PIECE_UNKNOWN ||
                !is_of_both(&of_piece[piece], &of_material[mesh->material[t]]))
                continue;
            pieces->kind[piece] = PIECE_UNKNOWN;
            *any = true;
        }
    }
    free(of_piece);
    free(of_material);
    return err;
}

static bool has_open_pieces(const struct place_pieces *pieces)
{
    for (size_t i = 0; i < pieces->solids->count; i++)
        if (pieces->kind[i] != PIECE_UNKNOWN && !pieces->solids->closed[i])
            return true;
    return false;
}

/* -- judging ---------------------------------------------------------------------------------- */

enum sheets { SHEETS_RIGHT, SHEETS_TURNED, SHEETS_UNKNOWN };

/* How the sheets of the scene look, by the positions that are not in solids. */
static enum sheets judge_sheets(const struct look_job *job, struct warnings *warnings)
{
    const struct place_inside_settings *settings = job->settings;
    size_t all = 0, mixed = 0, behind = 0, none = 0, enclosed = 0;
    for (size_t i = 0; i < job->place->count; i++) {
        const struct look *look = &job->look[i];
        const enum place_side side = look_side(look, settings);
        const double share = look_back_share(look);
        if (side == PLACE_SOLID)
            continue;
        all++;
        behind += side == PLACE_BEHIND;
        none += side != PLACE_AIR;
        mixed += look->count[SIGHT_BEHIND] >= LOOK_LEAST * look->rays && share > .25 && share < .75;
        enclosed += side == PLACE_BEHIND && look->count[SIGHT_ESCAPED] <= ENCLOSED * look->rays;
    }
    if (2 * mixed > all) {
        warnings_add(warnings, "orientation",
                     "%zu of %zu probes see about as many backs as fronts: open surfaces are not "
                     "oriented, and closed pieces alone tell inside from outside",
                     mixed, all);
        return SHEETS_UNKNOWN;
    }
    if ((double)enclosed <= NEARLY_ALL * (double)all &&
        (!behind || !job->pieces->upside_down || (2 * none <= all && !job->pieces->no_ceiling)))
        return SHEETS_RIGHT;
    warnings_add(warnings, "orientation",
                 "%zu of %zu probes see backs on nearly all sides: open surfaces are taken as "
                 "turned inside out",
                 none, all);
    return SHEETS_TURNED;
}

/* Turns all open pieces, or forgets their sides. */
static void change_sheets(struct place_pieces *pieces, enum sheets sheets)
{
    for (size_t i = 0; i < pieces->solids->count; i++) {
        if (pieces->solids->closed[i] || pieces->kind[i] == PIECE_UNKNOWN)
            continue;
        pieces->turned[i] = !pieces->turned[i];
        pieces->kind[i] = sheets == SHEETS_TURNED ? PIECE_SHEET : PIECE_UNKNOWN;
    }
    if (sheets == SHEETS_TURNED && pieces->upside_down)
        pieces->up = vec3_scale(-1, pieces->up);
}

struct place_judge {
    const struct tracer *tracer;
    struct place_inside_settings settings;
    struct place_pieces pieces;
};

struct error *place_judge_create(struct place_judge **judge, const struct place *place,
                                 const struct tracer *tracer,
                                 const struct place_inside_settings *settings,
                                 enum place_side *side, struct warnings *warnings)
{
    struct place_judge *j = NULL;
    *judge = NULL;
    struct error *err = array_create(&j, 1, sizeof *j);
    if (err)
        return err;
    *j = (struct place_judge){.tracer = tracer, .settings = *settings};
    struct look_job job = {
        .place = place, .tracer = tracer, .settings = settings, .pieces = &j->pieces};
    bool looked = false; /* from all, at the pieces as they are */
    err = place_pieces_find(&j->pieces, tracer, place, warnings);
    if (!err)
        err = array_create(&job.look, place->count, sizeof *job.look);
    if (!err && has_open_pieces(&j->pieces)) {
        job.count = place->count < SEEN_ASKED ? place->count : SEEN_ASKED;
        err = threads_for(settings->threads, job.count, look_around, &job);
        if (!err)
            err = forget_two_sided(&job, &j->pieces, &looked);
        looked = !looked && job.count == place->count;
    }
    if (!err && !looked)
        err = look_all(&job);
    const enum sheets sheets = err ? SHEETS_RIGHT : judge_sheets(&job, warnings);
    if (sheets != SHEETS_RIGHT) {
        change_sheets(&j->pieces, sheets);
        err = side ? look_all(&job) : NULL;
    }
    for (size_t i = 0; i < place->count && !err && side; i++)
        side[i] = look_side(&job.look[i], settings);
    if (!err && side)
        err = spread_air(&job, side);
    free(job.look);
    if (err)
        place_judge_destroy(j);
    else
        *judge = j;
    return err;
}

void place_judge_destroy(struct place_judge *judge)
{
    if (!judge)
        return;
    place_pieces_clear(&judge->pieces);
    free(judge);
}

/* So many of the probes are enough to say how the surfaces look. */
enum { JUDGES = 512 };

struct error *place_judge_of(struct place_judge **judge, const struct tracer *tracer, size_t count,
                             const double *position, int threads)
{
    struct place place = {.count = count};
    struct place_inside_settings settings = place_inside_default();
    settings.threads = threads;
    if (*judge)
        return NULL;
    place.count = count < JUDGES ? count : JUDGES;
    struct error *err = array_create(&place.position, 3 * place.count, sizeof *place.position);
    if (!err) {
        for (size_t i = 0; i < place.count; i++)
            memcpy(place.position + 3 * i, position + 3 * (i * count / place.count),
                   3 * sizeof *place.position);
        err = place_judge_create(judge, &place, tracer, &settings, NULL, NULL);
    }
    place_clear(&place);
    return err;
}

enum place_side place_judge_side(const struct place_judge *judge, const double p[3])
{
    const struct look look = look_at(&judge->pieces, judge->tracer, &judge->settings, p);
    return look_side(&look, &judge->settings);
}

struct error *place_inside(const struct place *place, const struct tracer *tracer,
                           const struct place_inside_settings *settings, enum place_side *side,
                           struct warnings *warnings)
{
    struct place_judge *judge = NULL;
    struct error *err = place_judge_create(&judge, place, tracer, settings, side, warnings);
    place_judge_destroy(judge);
    return err;
}
