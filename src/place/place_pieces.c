/* SPDX-License-Identifier: Apache-2.0 */
#include "place/place_pieces.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "math/affine.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/direction.h"
#include "math/random.h"
#include "place/place.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- seeing ----------------------------------------------------------------------------------- */

/* What a hit says. */
static struct place_sight judge_hit(const struct place_pieces *pieces, struct trace_hit hit)
{
    const struct scene *scene = trace_scene(pieces->tracer);
    struct place_sight sight = {.hit = hit};
    const size_t triangle = pieces->solids->offset[hit.instance] + hit.triangle;
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[hit.instance].mesh];
    sight.material = (size_t)mesh->material[hit.triangle];
    const struct scene_material *m = &scene->materials[sight.material];
    sight.piece = pieces->solids->piece_of[triangle];
    const enum piece_kind kind = pieces->kind[sight.piece];
    const bool turned = pieces->turned[sight.piece] != pieces->solids->turned[triangle],
               front = hit.front != turned, emits = scene_emits(m);
    if (front && pieces->sky[sight.piece])
        sight.what = SIGHT_ESCAPED;
    else if (kind == PIECE_UNKNOWN || m->alpha != SCENE_OPAQUE)
        sight.what = SIGHT_UNKNOWN;
    else if (front)
        sight.what = emits ? SIGHT_LAMP : kind == PIECE_SOLID ? SIGHT_HULL : SIGHT_FRONT;
    else if (kind == PIECE_SOLID)
        sight.what = SIGHT_SOLID;
    else if (kind == PIECE_ROOM)
        sight.what = SIGHT_VOID;
    else
        sight.what = emits || (m->two_sided && pieces->two_sided_means) ? SIGHT_UNKNOWN
                                                                        : SIGHT_BEHIND;
    return sight;
}

struct place_sight place_sight(const struct place_pieces *pieces, const double from[3],
                               struct vec3 direction)
{
    enum { THROUGH = 32 }; /* leaves, one behind another */
    double d[3], p[3];
    vec3_store(d, direction);
    const struct trace_hit hit = trace_nearest(pieces->tracer, from, d, INFINITY);
    if (!hit.hit)
        return (struct place_sight){0};
    struct place_sight first = judge_hit(pieces, hit), next = first;
    const struct scene *scene = trace_scene(pieces->tracer);
    for (int i = 0; i < THROUGH && next.what == SIGHT_UNKNOWN; i++) {
        const double step = 1e-6 * vec3_length(vec3_sub(scene->box_max, scene->box_min));
        vec3_store(p, vec3_fma(next.hit.position, step, direction));
        const struct trace_hit beyond = trace_nearest(pieces->tracer, p, d, INFINITY);
        if (!beyond.hit) {
            first.through = SIGHT_ESCAPED;
            return first;
        }
        next = judge_hit(pieces, beyond);
    }
    first.through = next.what == SIGHT_BEHIND || next.what == SIGHT_VOID ? next.what : first.what;
    return first;
}

/* -- measuring -------------------------------------------------------------------------------- */

enum { SAMPLES = 4 }; /* of a piece: its largest triangles */
enum { SPREAD = 8 };  /* of a piece: points all over it */

struct sample {
    double area;
    double before[3]; /* a little off its middle */
    double behind[3]; /* the same on the other side */
};

struct extent {
    size_t piece;
    struct box box;
    double area;
    struct vec3 sum;               /* of the area times the normal: 0 of what is closed */
    struct vec3 shadow;            /* of the same along each axis, whichever way a face looks */
    double volume;                 /* that it encloses when it is closed but for slits */
    double centre[3];              /* from where the volume is seen */
    struct sample sample[SAMPLES]; /* largest first; no area: none */
    struct sample spread[SPREAD];  /* of triangles by chance, as their areas are */
    bool emits;                    /* if any does, the samples are of those that do */
    bool clear;                    /* light gets through some of it */
};

static void add_sample(struct extent *e, struct sample s)
{
    for (int i = 0; i < SAMPLES; i++)
        if (s.area > e->sample[i].area) {
            const struct sample less = e->sample[i];
            e->sample[i] = s;
            s = less;
        }
}

/* Keeps each triangle with the chance that its area has in the piece's so far, which e->area is. */
static void add_spread(struct extent *e, const struct sample *s, size_t triangle)
{
    struct random r = random_start(0, triangle, 0);
    for (int i = 0; i < SPREAD; i++)
        if (random_float(&r) * e->area < s->area)
            e->spread[i] = *s;
}

/* The sample of a triangle, whose corners are given in the order of its front. */
static struct sample sample_of(const struct vec3 corner[3])
{
    struct sample s = {0};
    const struct vec3 n =
        vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0]));
    const double twice = vec3_length(n);
    const struct vec3 middle =
        vec3_scale(1.0 / 3, vec3_add(corner[0], vec3_add(corner[1], corner[2])));
    const double off = twice > 0 ? 1e-3 / sqrt(twice) : 0; /* 0.001 of its size, by its normal */
    s.area = twice / 2;
    vec3_store(s.before, vec3_fma(middle, off, n));
    vec3_store(s.behind, vec3_fma(middle, -off, n));
    return s;
}

/* The corners of a triangle, in the order of its front. */
static void front_corners(const struct place_pieces *pieces, size_t instance, size_t t,
                          struct vec3 corner[3])
{
    const struct scene *scene = trace_scene(pieces->tracer);
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    const double *m = scene->instances[instance].transform;
    const size_t triangle = pieces->solids->offset[instance] + t;
    const bool turned = (affine_mirrors(m) != pieces->solids->turned[triangle]) !=
                        pieces->turned[pieces->solids->piece_of[triangle]];
    for (size_t c = 0; c < 3; c++)
        corner[turned && c ? 3 - c : c] =
            affine_point(m, mesh->position + 3 * (size_t)mesh->index[3 * t + c]);
}

static void measure_pieces(const struct place_pieces *pieces, struct extent *extent)
{
    const struct scene *scene = trace_scene(pieces->tracer);
    const struct vec3 centre = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    const struct scene_solids *solids = pieces->solids;
    for (size_t i = 0; i < solids->count; i++)
        extent[i] = (struct extent){
            .piece = i, .box = box_empty(), .centre = {centre.x, centre.y, centre.z}};
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            struct extent *e = &extent[solids->piece_of[solids->offset[i] + t]];
            const struct scene_material *material = &scene->materials[mesh->material[t]];
            const bool emits = scene_emits(material);
            struct vec3 corner[3];
            e->clear = e->clear || material->alpha != SCENE_OPAQUE;
            front_corners(pieces, i, t, corner);
            for (size_t c = 0; c < 3; c++) {
                double placed[3];
                vec3_store(placed, corner[c]);
                box_add(&e->box, placed);
            }
            const struct sample s = sample_of(corner);
            e->area += s.area;
            add_spread(e, &s, solids->offset[i] + t);
            const struct vec3 a = vec3_scale(
                0.5, vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
            e->sum = vec3_add(e->sum, a);
            e->shadow = vec3_add(e->shadow, (struct vec3){fabs(a.x), fabs(a.y), fabs(a.z)});
            e->volume += vec3_dot(a, vec3_sub(corner[0], centre)) / 3;
            if (emits && !e->emits)
                memset(e->sample, 0, sizeof e->sample);
            e->emits = e->emits || emits;
            if (emits == e->emits)
                add_sample(e, s);
        }
    }
}

/* -- judging ---------------------------------------------------------------------------------- */

enum { LOOKS = 64 }; /* rays around a lamp or a piece of furniture */

#define NOBODY SIZE_MAX

/* The piece of which most backs are seen, and how many there are; NOBODY when none is. */
struct around {
    size_t piece;
    int backs, hits;
};

static struct around look_around(const struct place_pieces *pieces, const double p[3])
{
    struct around most = {.piece = NOBODY};
    size_t piece[LOOKS];
    int seen = 0;
    for (int i = 0; i < LOOKS; i++) {
        const struct place_sight s = place_sight(pieces, p, direction_even(i, LOOKS));
        most.hits += s.what != SIGHT_ESCAPED;
        if (s.what >= SIGHT_SOLID)
            piece[seen++] = s.piece;
    }
    for (int i = 0; i < seen; i++) {
        int same = 0;
        for (int k = 0; k < seen; k++)
            same += piece[k] == piece[i];
        if (same > most.backs) {
            most.backs = same;
            most.piece = piece[i];
        }
    }
    return most;
}

/* The solid in whose matter somebody is: some backs of it are seen, which is proof enough but for
 * rays along an edge. */
static size_t matter_of(const struct place_pieces *pieces, const struct around *a)
{
    return a->piece != NOBODY && pieces->kind[a->piece] == PIECE_SOLID && a->backs >= LOOKS / 16
               ? a->piece
               : NOBODY;
}

static size_t matter_around(const struct place_pieces *pieces, const double p[3])
{
    const struct around a = look_around(pieces, p);
    return matter_of(pieces, &a);
}

/* The piece that a lamp at p shows to be the wrong way round: the solid that it is in, or the room
 * or sheet whose backs are most of what it shines on. */
static size_t shown_by(const struct place_pieces *pieces, const double p[3])
{
    const struct around a = look_around(pieces, p);
    if (a.piece == NOBODY)
        return NOBODY;
    const bool shown = pieces->kind[a.piece] == PIECE_SOLID
                           ? a.backs >= LOOKS / 16
                           : 4 * a.backs >= 3 * a.hits && 2 * a.hits >= LOOKS;
    return shown ? a.piece : NOBODY;
}

/* What the samples of a piece say alike, by one of these; NOBODY when they differ, or more than
 * `silent` of them say nothing. */
static size_t ask_samples(const struct place_pieces *pieces, const struct extent *e, int silent,
                          size_t (*say)(const struct place_pieces *, const double *))
{
    size_t said = NOBODY;
    for (int i = 0; i < SAMPLES && e->sample[i].area > 0; i++) {
        const size_t now = say(pieces, e->sample[i].before);
        if (now == NOBODY && silent-- > 0)
            continue;
        if (now == NOBODY || now == e->piece || (said != NOBODY && now != said))
            return NOBODY;
        said = now;
    }
    return said;
}

/* The solid in whose matter a piece is for the most part. */
static size_t matter_of_piece(const struct place_pieces *pieces, const struct extent *e)
{
    size_t said = ask_samples(pieces, e, SAMPLES / 2, matter_around);
    int within = 0;
    for (int i = 0; i < SPREAD && said != NOBODY; i++)
        within += matter_around(pieces, e->spread[i].before) == said;
    return 2 * within >= SPREAD ? said : NOBODY;
}

/* Pieces that lamps show to be the wrong way round. */
static void find_lit(const struct place_pieces *pieces, const struct extent *extent, bool *lit)
{
    enum { LAMPS_ASKED = 4096 };
    const struct scene *scene = trace_scene(pieces->tracer);
    size_t asked = 0;
    for (size_t i = 0; i < scene->light_count && asked < LAMPS_ASKED; i++) {
        const struct scene_light *light = &scene->lights[i];
        if (light->kind == SCENE_SUN)
            continue;
        double p[3];
        vec3_store(p, light->position);
        const size_t piece = shown_by(pieces, p);
        if (piece != NOBODY)
            lit[piece] = true;
        asked++;
    }
    for (size_t i = 0; i < pieces->solids->count && asked < LAMPS_ASKED; i++) {
        if (!extent[i].emits || pieces->sky[i])
            continue;
        const size_t piece = ask_samples(pieces, &extent[i], 0, shown_by);
        if (piece != NOBODY)
            lit[piece] = true;
        asked++;
    }
}

/* Whether nothing of the inner box is outside of the outer one: what pokes out of it is no
 * furniture. It may stand on its floor. */
static bool holds(const struct box *outer, const struct box *inner)
{
    const double rounding = 1e-6 * box_side(outer);
    for (int k = 0; k < 3; k++)
        if (!(inner->low[k] >= outer->low[k] - rounding &&
              inner->high[k] <= outer->high[k] + rounding))
            return false;
    return true;
}

struct by_size {
    double size;
    size_t piece;
};

static int compare_sizes(const void *a, const void *b)
{
    const struct by_size *x = a, *y = b;
    if (x->size != y->size)
        return x->size > y->size ? -1 : 1;
    return x->piece < y->piece ? -1 : 1;
}

/* The largest solids: a room is no small one. */
#define ROOMS_LOOKED_FOR 256
/* Furniture has at least this share of the surface that it is in: no bolts, no nails. */
#define FURNITURE_LEAST 1e-3
/* Shares of its own surface which furniture in a room has: with which it is one for certain; when
 * all that there is is in it, a fair part of the probes, too, and it makes no room of its outside;
 * and when nearly all probes are in it, and most that there is. A pipe in a wall of three times its
 * width has a tenth. */
#define FURNITURE_CERTAIN .25
#define FURNITURE_OF_ALL .05
#define FAIR_PART .2
#define FURNITURE_SOME .005
#define NEARLY_ALL .8

/* The area of furniture in each piece that may be a room. What stands on its floor or at its wall
 * has samples that are outside. */
static void find_furniture(const struct place_pieces *pieces, const struct extent *extent,
                           const struct by_size *solid, size_t solids, double *furniture)
{
    for (size_t i = 0; i < pieces->solids->count; i++) {
        const struct extent *e = &extent[i];
        bool may = false;
        for (size_t k = 0; k < solids && !may; k++) {
            const struct extent *room = &extent[solid[k].piece];
            may = room != e && holds(&room->box, &e->box) &&
                  e->area >= FURNITURE_LEAST * room->area;
        }
        const size_t in = may ? matter_of_piece(pieces, e) : NOBODY;
        if (in != NOBODY)
            furniture[in] += e->area;
    }
}

/* Of the probes that are not in other solids: the share in a solid, and the share with fronts all
 * around. */
struct shares {
    double within, enclosed;
};

static struct shares share_probes(const struct place_pieces *pieces, const struct place *place,
                                  size_t piece)
{
    enum { ASKED = 512 };
    size_t in = 0, others = 0, enclosed = 0;
    const size_t asked = place->count < ASKED ? place->count : ASKED;
    for (size_t i = 0; i < asked; i++) {
        const size_t at = (size_t)((double)i * (double)place->count / (double)asked);
        const struct around a = look_around(pieces, place->position + 3 * at);
        const size_t matter = matter_of(pieces, &a);
        in += matter == piece;
        others += matter != piece && matter != NOBODY;
        enclosed += a.piece == NOBODY && a.hits >= .95 * LOOKS;
    }
    const double all = (double)(asked - others);
    return asked > others ? (struct shares){(double)in / all, (double)enclosed / all}
                          : (struct shares){0};
}

/* others: the area of what is neither the piece nor furniture in it. */
static bool is_room(const struct place_pieces *pieces, const struct extent *e, double furniture,
                    double others, const struct place *place)
{
    if (furniture >= FURNITURE_CERTAIN * e->area)
        return true;
    if (furniture < FURNITURE_SOME * e->area)
        return false;
    const struct shares share = share_probes(pieces, place, e->piece);
    return (others <= furniture && share.within >= NEARLY_ALL) ||
           (furniture >= FURNITURE_OF_ALL * e->area && others <= .01 * furniture &&
            share.within >= FAIR_PART && share.enclosed <= .01);
}

static struct error *find_rooms(const struct place_pieces *pieces, const struct extent *extent,
                                const struct place *place, bool *room)
{
    struct by_size *order = NULL;
    double *furniture = NULL;
    size_t solids = 0;
    struct error *err = array_create(&order, pieces->solids->count, sizeof *order);
    if (!err)
        err = array_create(&furniture, pieces->solids->count, sizeof *furniture);
    if (!err) {
        for (size_t i = 0; i < pieces->solids->count; i++)
            if (pieces->kind[i] == PIECE_SOLID)
                order[solids++] = (struct by_size){pieces->solids->volume[i], i};
        qsort(order, solids, sizeof *order, compare_sizes);
        solids = solids < ROOMS_LOOKED_FOR ? solids : ROOMS_LOOKED_FOR;
        find_furniture(pieces, extent, order, solids, furniture);
    }
    double all = 0;
    for (size_t i = 0; i < pieces->solids->count; i++)
        all += pieces->sky[i] ? 0 : extent[i].area;
    for (size_t i = 0; i < solids && !err; i++) {
        const size_t piece = order[i].piece;
        room[piece] = room[piece] || is_room(pieces, &extent[piece], furniture[piece],
                                             all - extent[piece].area - furniture[piece], place);
    }
    free(order);
    free(furniture);
    return err;
}

/* The kinds by the pieces alone. */
static void judge_alone(struct place_pieces *pieces, const struct extent *extent)
{
    for (size_t i = 0; i < pieces->solids->count; i++) {
        const double volume = pieces->turned[i] ? -pieces->solids->volume[i]
                                                : pieces->solids->volume[i];
        if (pieces->solids->unoriented[i])
            pieces->kind[i] = PIECE_UNKNOWN;
        else if (fabs(volume) > 1e-9 * pow(extent[i].area, 1.5)) /* else: both sides of a sheet */
            pieces->kind[i] = volume > 0 ? PIECE_SOLID : PIECE_ROOM;
        else
            pieces->kind[i] = pieces->solids->closed[i] ? PIECE_UNKNOWN : PIECE_SHEET;
    }
}

/* Whether these enclose air, seen from within, but for slits and openings. */
static bool encloses(double area, struct vec3 sum, double volume)
{
    return vec3_length(sum) < .1 * area && volume < -1e-3 * pow(area, 1.5);
}

/* Levels whose faces do not meet corner by corner are no closed pieces, but rooms all the same:
 * sheets that enclose air, alone or all together. */
static void find_levels(struct place_pieces *pieces, const struct extent *extent)
{
    double area = 0, volume = 0;
    struct vec3 sum = {0};
    for (size_t i = 0; i < pieces->solids->count; i++) {
        const struct extent *e = &extent[i];
        if (pieces->kind[i] != PIECE_SHEET || pieces->sky[i])
            continue;
        if (encloses(e->area, e->sum, e->volume)) {
            pieces->kind[i] = PIECE_ROOM;
            continue;
        }
        area += e->area;
        volume += e->volume;
        sum = vec3_add(sum, e->sum);
    }
    if (encloses(area, sum, volume))
        for (size_t i = 0; i < pieces->solids->count; i++)
            if (pieces->kind[i] == PIECE_SHEET && !pieces->sky[i])
                pieces->kind[i] = PIECE_ROOM;
}

/* Whether calling a sheet two-sided means something: not all are called so. */
static bool two_sided_means(const struct place_pieces *pieces)
{
    const struct scene *scene = trace_scene(pieces->tracer);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++)
            if (!scene->materials[mesh->material[t]].two_sided)
                return true;
    }
    return false;
}

/* -- skies ------------------------------------------------------------------------------------ */

/* The volume that a piece would enclose, seen from the middle of what is within. */
static double volume_about(const struct extent *e, const struct box *content)
{
    double to_middle = 0;
    const double sum[3] = {e->sum.x, e->sum.y, e->sum.z};
    for (int k = 0; k < 3; k++)
        to_middle += sum[k] * (.5 * (content->low[k] + content->high[k]) - e->centre[k]);
    return e->volume - to_middle / 3;
}

static double diagonal(const struct box *b)
{
    return vec3_length(vec3_sub(vec3_load(b->high), vec3_load(b->low)));
}

/* Whether a piece bends around all that is within, sees it, is a single shell, does not look up as
 * a valley does, and keeps its distance: it is at least twice as large, which a room's walls, where
 * furniture stands, are not. */
static bool is_sky(const struct extent *shell, const struct box *content)
{
    return 2 * diagonal(content) <= diagonal(&shell->box) && holds(&shell->box, content) &&
           vec3_length(shell->sum) <= .75 * shell->area && shell->sum.y <= .1 * shell->area &&
           shell->sum.z <= .1 * shell->area &&
           volume_about(shell, content) < -.03 * pow(shell->area, 1.5);
}

/* Whether nobody in the content could see the shell as a sky: there are closed pieces alone, some
 * of which look inward, and the shell does not shine, and is no rounder than a box. It is a room,
 * then, and those in it are turned inside out. */
static bool is_room_of_closed(const struct place_pieces *pieces, const struct extent *extent,
                              size_t shell, const struct box *content)
{
    const struct extent *e = &extent[shell];
    const double volume = volume_about(e, content),
                 area = e->area + vec3_length(e->sum),          /* with what closes it */
        round = 36 * ANGLE_PI * volume * volume / pow(area, 3); /* 1 of a ball, 0.52 of a cube */
    size_t inward = 0;
    if (e->emits || round > .53)
        return false;
    for (size_t i = 0; i < pieces->solids->count; i++) {
        if (i == shell || pieces->sky[i] || extent[i].area <= 0)
            continue;
        if (!pieces->solids->closed[i])
            return false;
        inward += pieces->turned[i] || pieces->kind[i] == PIECE_ROOM;
    }
    return inward > 0;
}

/* Shells around all else that look inward. */
static void find_skies(struct place_pieces *pieces, const struct extent *extent)
{
    enum { SHELLS = 4 }; /* a sky, clouds, ... */
    for (int i = 0; i < SHELLS; i++) {
        size_t shell = NOBODY;
        for (size_t k = 0; k < pieces->solids->count; k++)
            if (!pieces->sky[k] &&
                (shell == NOBODY || box_side(&extent[k].box) > box_side(&extent[shell].box)))
                shell = k;
        struct box content = box_empty();
        for (size_t k = 0; k < pieces->solids->count; k++)
            if (k != shell && !pieces->sky[k] && extent[k].area > 0) {
                box_add(&content, extent[k].box.low);
                box_add(&content, extent[k].box.high);
            }
        if (shell == NOBODY || content.low[0] > content.high[0] ||
            pieces->kind[shell] == PIECE_SOLID || pieces->kind[shell] == PIECE_UNKNOWN ||
            !is_sky(&extent[shell], &content) || is_room_of_closed(pieces, extent, shell, &content))
            return;
        pieces->sky[shell] = true;
    }
}

/* -- files that are turned inside out --------------------------------------------------------- */

/* Whether a closed piece that looks inward stands between walls that do, as furniture in a house:
 * what is seen from behind it are their backs on nearly all sides. */
static bool stands_in_walls(const struct place_pieces *pieces, const struct extent *e)
{
    int stands = 0, samples = 0;
    for (; samples < SAMPLES && e->sample[samples].area > 0; samples++) {
        int backs = 0, own = 0;
        for (int i = 0; i < LOOKS; i++) {
            const struct place_sight s =
                place_sight(pieces, e->sample[samples].behind, direction_even(i, LOOKS));
            own += s.hit.hit && s.piece == e->piece;
            backs += s.hit.hit && s.piece != e->piece && s.what == SIGHT_VOID &&
                     pieces->solids->closed[s.piece];
        }
        stands += 4 * backs >= 3 * (LOOKS - own) && 4 * backs >= LOOKS;
    }
    return stands > 0 && 2 * stands >= samples;
}

/* Faces of rooms by the axis that they look along: their area, how many were asked, and how many
 * have a room behind them that is larger than the one before. */
struct behind {
    double area, seen;
    int asked, larger;
};

/* Whether there is much more room behind a face than before it, up to another back. */
static bool is_larger_behind(const struct place_pieces *pieces, const struct sample *s)
{
    const struct vec3 out = vec3_normalize(vec3_sub(vec3_load(s->before), vec3_load(s->behind)));
    const struct place_sight before = place_sight(pieces, s->before, out),
                             behind = place_sight(pieces, s->behind, vec3_scale(-1, out));
    return before.hit.hit && behind.what == SIGHT_VOID &&
           behind.hit.distance >= 3 * before.hit.distance;
}

/* Goes over the faces of closed rooms: reckons their areas, or asks about ASKED of each axis. */
static void ask_behind(const struct place_pieces *pieces, bool ask, struct behind axes[3])
{
    enum { ASKED = 128 };
    const struct scene *scene = trace_scene(pieces->tracer);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            const size_t triangle = pieces->solids->offset[i] + t,
                         piece = pieces->solids->piece_of[triangle];
            struct vec3 corner[3];
            if (pieces->kind[piece] != PIECE_ROOM || pieces->sky[piece])
                continue;
            front_corners(pieces, i, t, corner);
            const struct vec3 n =
                vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0]));
            const double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z), area = vec3_length(n) / 2;
            struct behind *axis = &axes[x > y && x > z ? 0 : y > z ? 1 : 2];
            if (!ask) {
                axis->area += area;
                continue;
            }
            struct random r = random_start(0, triangle, 0);
            for (axis->seen += area;
                 axis->asked < ASKED && axis->seen > (axis->asked + .5) / ASKED * axis->area;
                 axis->asked++) { /* points of it by chance */
                const double a = sqrt((double)random_float(&r)), b = a * (double)random_float(&r);
                const struct vec3 p = vec3_fma(
                    vec3_fma(vec3_scale(1 - a, corner[0]), a - b, corner[1]), b, corner[2]);
                const double off = 1e-3 / sqrt(2 * area);
                struct sample s = {.area = area};
                vec3_store(s.before, vec3_fma(p, off, n));
                vec3_store(s.behind, vec3_fma(p, -off, n));
                axis->larger += is_larger_behind(pieces, &s);
            }
        }
    }
}

/* Whether closed pieces that look inward are walls, not rooms: along each axis a fair part of them
 * has rooms at its back that are much larger than what is before it. Between the rooms of a level
 * is rock as thick as that only to some sides, as it has one floor, or storeys near one another. */
static bool are_walls(const struct place_pieces *pieces)
{
    struct behind axes[3] = {0};
    ask_behind(pieces, false, axes);
    ask_behind(pieces, true, axes);
    for (int k = 0; k < 3; k++)
        if (axes[k].asked == 0 || axes[k].larger < .3 * axes[k].asked)
            return false;
    return true;
}

/* Whether the faces of the whole file look to the wrong side. */
static bool is_file_turned(const struct place_pieces *pieces, const struct extent *extent)
{
    enum { ASKED = 256 }; /* of the pieces that are in boxes of others */
    const size_t count = pieces->solids->count;
    const struct extent *room = NULL;
    double turned = 0, right = 0, within = 0, sheets = 0;
    for (size_t i = 0; i < count; i++)
        if (pieces->kind[i] == PIECE_ROOM && pieces->solids->closed[i] && !pieces->sky[i] &&
            (!room || box_side(&extent[i].box) > box_side(&room->box)))
            room = &extent[i];
    if (!room)
        return false;
    size_t asked = 0;
    for (size_t i = 0; i < count; i++) {
        const struct extent *e = &extent[i];
        if (e == room || pieces->sky[i])
            continue;
        const bool held = holds(&room->box, &e->box);
        if (pieces->kind[i] == PIECE_SOLID)
            right += e->area;
        else if (pieces->kind[i] == PIECE_SHEET) {
            sheets += e->area;
            within += held ? e->area : 0;
        } else if (held && pieces->solids->closed[i] && e->area >= FURNITURE_LEAST * room->area &&
                   asked++ < ASKED && stands_in_walls(pieces, e))
            turned += e->area;
    }
    return turned > right || (right == 0 && are_walls(pieces)) ||
           (pieces->upside_down && right == 0 && sheets > room->area / 2 && within < sheets / 2);
}

/* Turns all, and measures it anew. */
static void turn_file(struct place_pieces *pieces, struct extent *extent, struct warnings *warnings)
{
    for (size_t i = 0; i < pieces->solids->count; i++) {
        pieces->turned[i] = true;
        pieces->sky[i] = false;
    }
    measure_pieces(pieces, extent);
    judge_alone(pieces, extent);
    warnings_add(warnings, "turned",
                 "closed pieces look inward, and so do those within them or the ground below them, "
                 "or they are walls around rooms: the whole surface is taken as turned inside out");
}

/* -- things that are turned inside out -------------------------------------------------------- */

enum { ASKED_OF_THING = SAMPLES + SPREAD };

static const struct sample *asked_of(const struct extent *e, int i)
{
    const struct sample *s = i < SAMPLES ? &e->sample[i] : &e->spread[i - SAMPLES];
    return s->area > 0 ? s : NULL;
}

/* Whether air is behind a face: from half way to what is there, at most half the piece's size off,
 * fronts of others are seen, and not solids alone, as in a slit between a room and a wall. */
static bool has_air_behind(const struct place_pieces *pieces, const struct extent *e,
                           const struct sample *sample)
{
    const struct vec3 from = vec3_load(sample->behind),
                      out = vec3_normalize(vec3_sub(from, vec3_load(sample->before)));
    const struct place_sight ahead = place_sight(pieces, sample->behind, out);
    const double most = diagonal(&e->box),
                 way = ahead.hit.hit ? fmin(ahead.hit.distance, most) : most;
    int fronts = 0, hulls = 0, escaped = 0;
    double p[3];
    vec3_store(p, vec3_fma(from, way / 2, out));
    for (int i = 0; i < LOOKS; i++) {
        const struct place_sight s = place_sight(pieces, p, direction_even(i, LOOKS));
        if (s.hit.hit && s.piece == e->piece)
            continue;
        fronts += s.what == SIGHT_FRONT || s.what == SIGHT_LAMP;
        hulls += s.what == SIGHT_HULL;
        escaped += s.what == SIGHT_ESCAPED;
    }
    return 16 * (fronts + hulls) >= LOOKS && (fronts + escaped > 0 || 16 * way >= most);
}

/* Whether a closed piece that looks inward stands in air, as things do. */
static bool stands_in_air(const struct place_pieces *pieces, const struct extent *e)
{
    int air = 0;
    for (int i = 0; i < ASKED_OF_THING && air < 2; i++) {
        const struct sample *s = asked_of(e, i);
        air += s && has_air_behind(pieces, e, s);
    }
    return air == 2;
}

/* Whether somebody might be in a piece that looks inward: it shines or light gets into it, it has
 * lamps, or holds other pieces. */
static bool is_used(const struct place_pieces *pieces, const struct extent *extent,
                    const struct extent *e)
{
    enum { LAMPS_ASKED = 4096 };
    const struct scene *scene = trace_scene(pieces->tracer);
    if (e->emits || e->clear)
        return true;
    for (int i = 0; i < ASKED_OF_THING; i++) {
        const struct sample *s = asked_of(e, i);
        for (int k = 0; k < LOOKS && s; k++) {
            const struct place_sight seen =
                place_sight(pieces, s->before, direction_even(k, LOOKS));
            if (seen.hit.hit && seen.piece != e->piece && holds(&e->box, &extent[seen.piece].box))
                return true;
        }
    }
    for (size_t i = 0; i < scene->light_count && i < LAMPS_ASKED; i++) {
        double p[3];
        int own = 0;
        vec3_store(p, scene->lights[i].position);
        for (int k = 0; k < LOOKS && scene->lights[i].kind != SCENE_SUN; k++) {
            const struct place_sight s = place_sight(pieces, p, direction_even(k, LOOKS));
            own += s.hit.hit && s.piece == e->piece && s.what == SIGHT_FRONT;
        }
        if (2 * own >= LOOKS)
            return true;
    }
    return false;
}

/* A closed piece that looks inward, with air behind it, has matter before it, which it is turned
 * for. Of one that is used as well nothing is known: there is air on both sides. What is turned
 * shows the others fronts, in a heap: they are asked again. */
static void turn_things(struct place_pieces *pieces, struct extent *extent,
                        struct warnings *warnings)
{
    enum { ASKED = 4096 };
    size_t asked = 0, turned = 0;
    for (bool any = true; any && asked < ASKED;) {
        any = false;
        for (size_t i = 0; i < pieces->solids->count && asked < ASKED; i++) {
            if (pieces->kind[i] != PIECE_ROOM || !pieces->solids->closed[i] || pieces->sky[i])
                continue;
            asked++;
            if (!stands_in_air(pieces, &extent[i]))
                continue;
            const bool used = is_used(pieces, extent, &extent[i]);
            pieces->turned[i] = pieces->turned[i] != !used;
            pieces->kind[i] = used ? PIECE_UNKNOWN : PIECE_SOLID;
            turned += !used;
            any = true;
        }
    }
    if (turned) {
        measure_pieces(pieces, extent);
        warnings_add(warnings, "things",
                     "%zu closed piece%s inward, but stand%s in the air that others are in: taken "
                     "as turned inside out",
                     turned, turned > 1 ? "s face" : " faces", turned > 1 ? "" : "s");
    }
}

static void find_targets(struct place_pieces *pieces, const struct extent *extent)
{
    double all = 0, sum = 0;
    size_t at = 0;
    for (size_t i = 0; i < pieces->solids->count; i++)
        for (int k = 0; k < SAMPLES && !pieces->sky[i]; k++)
            all += extent[i].sample[k].area;
    for (size_t i = 0; i < pieces->solids->count; i++)
        for (int k = 0; k < SAMPLES && !pieces->sky[i]; k++)
            for (sum += extent[i].sample[k].area;
                 at < PLACE_TARGETS && sum > ((double)at + .5) / PLACE_TARGETS * all; at++)
                memcpy(pieces->target[at], extent[i].sample[k].before, sizeof pieces->target[at]);
    while (at > 0 && at < PLACE_TARGETS) { /* but for rounding there are all */
        memcpy(pieces->target[at], pieces->target[at - 1], sizeof pieces->target[at]);
        at++;
    }
}

/* The area by which a sheet looks one way: all of it where it does so on the whole; of a ground,
 * however steep, that looks up or down all over, its shadow's; 0 where it looks to all sides. */
static double one_way_area(const struct extent *e)
{
    const double length = vec3_length(e->sum);
    if (length >= .7 * e->area)
        return e->area;
    return (fabs(e->sum.y) >= .2 * e->area && fabs(e->sum.y) >= .95 * e->shadow.y) ||
                   (fabs(e->sum.z) >= .2 * e->area && fabs(e->sum.z) >= .95 * e->shadow.z)
               ? length
               : 0;
}

/* Whether nothing is where a sheet looks, so that it is no ceiling, and it is no dome, either: all
 * that it would enclose is far less than what a ball does. */
static bool looks_at_nothing(const struct place_pieces *pieces, const struct extent *e,
                             struct vec3 way)
{
    const double volume = volume_about(e, &e->box), area = e->area + vec3_length(e->sum);
    int nothing = 0, asked = 0;
    for (int i = 0; i < SPREAD; i++) {
        asked += e->spread[i].area > 0;
        nothing += e->spread[i].area > 0 && !place_sight(pieces, e->spread[i].before, way).hit.hit;
    }
    return !e->emits && 4 * nothing >= 3 * asked &&
           36 * ANGLE_PI * volume * volume < .25 * pow(area, 3);
}

/* The axis Y or Z that is near, or the direction itself. */
static struct vec3 upward(struct vec3 sum)
{
    const struct vec3 up = vec3_normalize(sum);
    if (fabs(up.y) >= .8)
        return (struct vec3){0, up.y < 0 ? -1 : 1, 0};
    if (fabs(up.z) >= .8)
        return (struct vec3){0, 0, up.z < 0 ? -1 : 1};
    return up;
}

/* Where up is, and whether sheets look down: a ground with a front that nobody stands on. Large
 * sheets that look one way say so; trees and fences do not. */
static void find_up(struct place_pieces *pieces, const struct extent *extent)
{
    double largest = 0, area = 0, bare = 0;
    struct vec3 sum = {0};
    for (size_t i = 0; i < pieces->solids->count; i++)
        if (pieces->kind[i] == PIECE_SHEET && !pieces->sky[i] && extent[i].area > largest)
            largest = extent[i].area;
    for (size_t i = 0; i < pieces->solids->count; i++)
        if (pieces->kind[i] == PIECE_SHEET && !pieces->sky[i] && extent[i].area >= .05 * largest) {
            const double one_way = one_way_area(&extent[i]);
            area += one_way;
            sum = one_way > 0 ? vec3_add(sum, extent[i].sum) : sum;
        }
    const bool one_way = vec3_length(sum) > .5 * area;
    const struct vec3 down = {0, sum.y < -.5 * area ? -1 : 0, sum.y < -.5 * area ? 0 : -1};
    pieces->upside_down = one_way && (sum.y < -.5 * area || sum.z < -.5 * area);
    pieces->up = one_way ? upward(sum) : (struct vec3){0, 1, 0};
    for (size_t i = 0; i < pieces->solids->count && pieces->upside_down; i++)
        if (pieces->kind[i] == PIECE_SHEET && !pieces->sky[i] &&
            vec3_dot(extent[i].sum, down) > 0 && extent[i].area >= .05 * largest &&
            looks_at_nothing(pieces, &extent[i], down))
            bare += one_way_area(&extent[i]);
    pieces->no_ceiling = bare >= .75 * area;
}

/* -- waters ----------------------------------------------------------------------------------- */

static bool is_flat(const struct extent *e)
{
    return vec3_length(e->sum) >= .98 * e->area;
}

/* Whether a flat sheet is met by another that is not from above and below: all over it, that other
 * is below it and shows its front, as the bed of a lake, or above it and shows its back, as hills
 * that the lake goes on in. */
static bool is_water(const struct place_pieces *pieces, const struct extent *extent, size_t piece)
{
    const struct extent *e = &extent[piece];
    const struct vec3 up = vec3_normalize(e->sum);
    int over_bed = 0, in_hill = 0;
    for (int i = 0; i < SPREAD; i++) {
        double p[3];
        const struct place_sight above = place_sight(pieces, e->spread[i].before, up),
                                 self =
                                     place_sight(pieces, e->spread[i].before, vec3_scale(-1, up));
        if (!self.hit.hit || self.piece != piece)
            continue;
        vec3_store(p, vec3_fma(self.hit.position, -self.hit.distance, up));
        const struct place_sight below = place_sight(pieces, p, vec3_scale(-1, up));
        if (above.what == SIGHT_BEHIND && !is_flat(&extent[above.piece]))
            in_hill++;
        else if (below.what == SIGHT_FRONT && below.piece != piece &&
                 !is_flat(&extent[below.piece]))
            over_bed++;
    }
    return in_hill > 0 && over_bed > 0 && in_hill + over_bed >= SPREAD - 1;
}

/* What a water says of air and ground, its hills and its bed say as well. */
static void find_waters(struct place_pieces *pieces, const struct extent *extent)
{
    enum { ASKED = 256 };
    size_t asked = 0;
    double most = 0;
    for (size_t i = 0; i < pieces->solids->count; i++)
        if (pieces->kind[i] == PIECE_SHEET && extent[i].area > most)
            most = extent[i].area;
    for (size_t i = 0; i < pieces->solids->count && asked < ASKED; i++)
        if (pieces->kind[i] == PIECE_SHEET && is_flat(&extent[i]) &&
            extent[i].area >= FURNITURE_LEAST * most) {
            asked++;
            if (is_water(pieces, extent, i))
                pieces->kind[i] = PIECE_UNKNOWN;
        }
}

/* Turns what is the wrong way round, and says so. */
static void turn(struct place_pieces *pieces, const bool *wrong, struct warnings *warnings)
{
    size_t rooms = 0, others = 0;
    for (size_t i = 0; i < pieces->solids->count; i++) {
        if (!wrong[i])
            continue;
        pieces->turned[i] = !pieces->turned[i];
        if (pieces->kind[i] == PIECE_SOLID) {
            pieces->kind[i] = PIECE_ROOM;
            rooms++;
        } else {
            pieces->kind[i] = pieces->kind[i] == PIECE_ROOM ? PIECE_SOLID : PIECE_SHEET;
            others++;
        }
    }
    if (rooms)
        warnings_add(warnings, "rooms",
                     "%zu closed piece%s outward, but hold%s lights or furniture: taken for %s",
                     rooms, rooms > 1 ? "s that face" : " that faces", rooms > 1 ? "" : "s",
                     rooms > 1 ? "rooms" : "a room");
    if (others)
        warnings_add(warnings, "turned",
                     "%zu piece%s the back to a lamp on nearly all sides: taken as turned "
                     "inside out",
                     others, others > 1 ? "s show" : " shows");
}

struct error *place_pieces_find(struct place_pieces *pieces, const struct tracer *tracer,
                                const struct place *place, struct warnings *warnings)
{
    struct extent *extent = NULL;
    bool *wrong = NULL;
    *pieces = (struct place_pieces){.tracer = tracer};
    struct error *err = trace_solids(tracer, &pieces->solids);
    if (!err)
        scene_solids_tell(trace_scene(tracer), pieces->solids, warnings);
    if (!err)
        err = array_create(&pieces->kind, pieces->solids->count, sizeof *pieces->kind);
    if (!err)
        err = array_create(&pieces->turned, pieces->solids->count, sizeof *pieces->turned);
    if (!err)
        err = array_create(&pieces->sky, pieces->solids->count, sizeof *pieces->sky);
    if (!err)
        err = array_create(&pieces->target, PLACE_TARGETS, sizeof *pieces->target);
    if (!err)
        err = array_create(&extent, pieces->solids->count, sizeof *extent);
    if (!err)
        err = array_create(&wrong, pieces->solids->count, sizeof *wrong);
    if (!err) {
        for (int i = 0; i < PLACE_WAYS; i++) /* by a step that spreads the first of them best */
            pieces->way[i] = direction_even(27 * i % PLACE_WAYS, PLACE_WAYS);
        measure_pieces(pieces, extent);
        judge_alone(pieces, extent);
        find_skies(pieces, extent);
        pieces->two_sided_means = two_sided_means(pieces);
        find_up(pieces, extent);
        if (is_file_turned(pieces, extent)) {
            turn_file(pieces, extent, warnings);
            find_skies(pieces, extent);
            find_up(pieces, extent);
        }
        turn_things(pieces, extent, warnings);
        find_levels(pieces, extent);
        find_targets(pieces, extent);
        find_lit(pieces, extent, wrong);
        err = find_rooms(pieces, extent, place, wrong);
    }
    if (!err) {
        turn(pieces, wrong, warnings);
        find_skies(pieces, extent);
        find_waters(pieces, extent);
    }
    free(extent);
    free(wrong);
    return err;
}

void place_pieces_clear(struct place_pieces *pieces)
{
    free(pieces->kind);
    free(pieces->turned);
    free(pieces->sky);
    free(pieces->target);
    *pieces = (struct place_pieces){0};
}
