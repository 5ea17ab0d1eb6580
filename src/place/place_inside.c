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
#include "trace/trace.h"

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

/* -- surfaces that are seen from both sides ---------------------------------------------------- */

struct seen {
    size_t fronts, backs;
};

enum { SEEN_ASKED = 4096, SEEN_LEAST = 16 };

static bool is_of_both(const struct seen *s)
{
    return s->fronts + s->backs >= SEEN_LEAST && 4 * s->backs >= s->fronts + s->backs;
}

/* Counts what the positions in the air see of open pieces, by piece and by material. */
static void count_sides(const struct look_job *job, struct seen *of_piece, struct seen *of_material)
{
    const struct place_pieces *pieces = job->pieces;
    for (size_t i = 0; i < job->count; i++) {
        if (look_side(&job->look[i], job->settings) != PLACE_AIR ||
            look_back_share(&job->look[i]) > .5)
            continue;
        for (int k = 0; k < job->settings->rays; k++) {
            const struct place_sight s =
                place_sight(pieces, look_position(job, i), direction_even(k, job->settings->rays));
            if (!s.hit.hit || s.what == SIGHT_UNKNOWN || pieces->solids.closed[s.piece])
                continue;
            const bool back = s.what == SIGHT_BEHIND || s.what == SIGHT_VOID;
            of_piece[s.piece].backs += back;
            of_piece[s.piece].fronts += !back;
            of_material[s.material].backs += back;
            of_material[s.material].fronts += !back;
        }
    }
}

/* Forgets the sides of open pieces that positions in the air see from behind about as often as from
 * before, such as leaves and paper walls. Those that are hardly seen are as others of their
 * material. */
static struct error *forget_two_sided(const struct look_job *job, struct place_pieces *pieces)
{
    const struct scene *scene = trace_scene(job->tracer);
    struct seen *of_piece = NULL, *of_material = NULL;
    struct error *err = array_create(&of_piece, pieces->solids.count, sizeof *of_piece);
    if (!err)
        err = array_create(&of_material, scene->material_count, sizeof *of_material);
    if (!err)
        count_sides(job, of_piece, of_material);
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            const size_t piece = pieces->solids.piece_of[pieces->solids.offset[i] + t];
            const struct seen *s = &of_piece[piece];
            if (!pieces->solids.closed[piece] &&
                is_of_both(s->fronts + s->backs >= SEEN_LEAST ? s
                                                              : &of_material[mesh->material[t]]))
                pieces->kind[piece] = PIECE_UNKNOWN;
        }
    }
    free(of_piece);
    free(of_material);
    return err;
}

static bool has_open_pieces(const struct place_pieces *pieces)
{
    for (size_t i = 0; i < pieces->solids.count; i++)
        if (pieces->kind[i] != PIECE_UNKNOWN && !pieces->solids.closed[i])
            return true;
    return false;
}

/* -- judging ---------------------------------------------------------------------------------- */

enum sheets { SHEETS_AS_FILED, SHEETS_UNKNOWN, SHEETS_TURNED };

struct place_judge {
    const struct tracer *tracer;
    struct place_inside_settings settings;
    struct place_pieces pieces;
    enum sheets sheets;
};

/* Takes what was seen as sheets turned out to look. */
static void apply_sheets(enum sheets sheets, struct look *look)
{
    int *of = look->count;
    const int fronts = of[SIGHT_FRONT];
    if (sheets == SHEETS_AS_FILED)
        return;
    look->asked = false; /* by sides that were turned */
    of[SIGHT_FRONT] = sheets == SHEETS_UNKNOWN ? fronts : of[SIGHT_BEHIND];
    of[SIGHT_BEHIND] = sheets == SHEETS_UNKNOWN ? 0 : fronts;
}

/* How the sheets of the scene look, by the positions that are not in solids. */
static enum sheets judge_sheets(const struct look_job *job, struct warnings *warnings)
{
    const struct place_inside_settings *settings = job->settings;
    const struct look *look = job->look;
    size_t all = 0, mixed = 0, behind = 0, enclosed = 0;
    for (size_t i = 0; i < job->place->count; i++) {
        const enum place_side side = look_side(&look[i], settings);
        const double share = look_back_share(&look[i]);
        if (side == PLACE_SOLID)
            continue;
        all++;
        behind += side == PLACE_BEHIND;
        mixed += look[i].count[SIGHT_BEHIND] >= LOOK_LEAST * settings->rays && share > .25 &&
                 share < .75;
        enclosed += side == PLACE_BEHIND &&
                    look[i].count[SIGHT_ESCAPED] <= ENCLOSED * settings->rays;
    }
    if (2 * mixed > all) {
        warnings_add(warnings, "orientation",
                     "%zu of %zu probes see about as many backs as fronts: open surfaces are not "
                     "oriented, and closed pieces alone tell inside from outside",
                     mixed, all);
        return SHEETS_UNKNOWN;
    }
    if ((double)enclosed > NEARLY_ALL * (double)all ||
        (2 * behind > all && job->pieces->upside_down)) {
        warnings_add(warnings, "orientation",
                     "%zu of %zu probes see backs on nearly all sides: open surfaces are taken as "
                     "turned inside out",
                     behind, all);
        return SHEETS_TURNED;
    }
    return SHEETS_AS_FILED;
}

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
    err = place_pieces_find(&j->pieces, tracer, place, warnings);
    if (!err)
        err = array_create(&job.look, place->count, sizeof *job.look);
    if (!err && has_open_pieces(&j->pieces)) {
        job.count = place->count < SEEN_ASKED ? place->count : SEEN_ASKED;
        err = threads_for(settings->threads, job.count, look_around, &job);
        if (!err)
            err = forget_two_sided(&job, &j->pieces);
    }
    job.count = place->count;
    if (!err)
        err = threads_for(settings->threads, place->count, look_around, &job);
    if (!err)
        j->sheets = judge_sheets(&job, warnings);
    for (size_t i = 0; i < place->count && !err && side; i++) {
        apply_sheets(j->sheets, &job.look[i]);
        side[i] = look_side(&job.look[i], settings);
    }
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

struct error *place_judge_of(struct place_judge **judge, const struct tracer *tracer, size_t count,
                             const double *position, int threads)
{
    struct place place = {.count = count};
    struct place_inside_settings settings = place_inside_default();
    settings.threads = threads;
    if (*judge)
        return NULL;
    struct error *err = array_create(&place.position, 3 * count, sizeof *place.position);
    if (!err) {
        memcpy(place.position, position, 3 * count * sizeof *place.position);
        err = place_judge_create(judge, &place, tracer, &settings, NULL, NULL);
    }
    place_clear(&place);
    return err;
}

enum place_side place_judge_side(const struct place_judge *judge, const double p[3])
{
    struct look look = look_at(&judge->pieces, judge->tracer, &judge->settings, p);
    apply_sheets(judge->sheets, &look);
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
