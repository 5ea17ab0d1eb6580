/* SPDX-License-Identifier: Apache-2.0 */
/* One probe's capture: rounds of samples, what they add up to, and when they are enough. */
#include "base/array.h"
#include "base/error.h"
#include "capture/ask_lit.h"
#include "capture/capture.h"
#include "capture/capture_split.h"
#include "capture/gradient.h"
#include "capture/guide.h"
#include "capture/occlusion.h"
#include "capture/openings.h"
#include "capture/probe_split.h"
#include "capture/strata.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* Which of a probe's samples a random number belongs to: the upper two bits of its index. */
enum kind { OWN, LIGHTS, SKY, LIT };

/* Of kind LIT: rays by the guide. */
#define GUIDED (UINT32_C(1) << 29)

/* For each ray of its own that a probe traces, it asks so many times for emissive surfaces and for
 * an uneven sky. Cells make these smooth questions converge faster than the paths behind the rays,
 * so fewer are as good. */
#define ASK_SHARE 0.5

/* And with a cache so many times for sunlit points; and before, to learn which of them are seen. */
#define LIT_SHARE 2.0
#define LEARN_SHARE 1.0

/* And without a cache so many rays that look for sunlight, by what some questions tell: so many
 * for each ray, within bounds. */
#define GUIDED_SHARE 0.5
#define LOOK_SHARE 0.125
#define LOOK_LEAST 256
#define LOOK_MOST 1024

/* And so many times whether an even sky is open; of these, the share that goes to all directions
 * alike; and before, to find openings. */
#define OPEN_SHARE 2.0
#define OPEN_EVEN 0.5
#define FIND_SHARE 4.0

/* Where no question found light, the share of questions that could is at most 3 in their number at
 * 95 % (the rule of three: Hanley and Lippman-Hand, JAMA 1983), which 1.96 standard errors are to
 * hold. */
#define UNSEEN 1.53

/* One sample in each of rows * columns cells of the unit square; both even, since cells are judged
 * by four. */
struct grid {
    int rows, columns;
};

static struct grid grid_for(int samples, double columns_per_row)
{
    const double cells = samples > 4 ? samples : 4;
    const int pairs = (int)(sqrt(cells / columns_per_row) / 2 + 0.5),
              rows = 2 * (pairs > 1 ? pairs : 1);
    return (struct grid){.rows = rows, .columns = 2 * (int)ceil(cells / rows / 2)};
}

static struct grid own_grid(int rays)
{
    return grid_for(rays, 3);
}

static int grid_samples(const struct grid *grid)
{
    return grid->rows * grid->columns;
}

int capture_ray_count(int rays)
{
    const struct grid grid = own_grid(rays);
    return grid_samples(&grid);
}

/* A probe at work. */
struct work {
    const struct path_tracer *path;
    const struct capture_settings *settings;
    uint64_t name;
    bool surface;
    struct path_receiver receiver;
    float room; /* trace_start_room */
    struct strata light;
    double gradient[9 * SH_COUNT_MAX]; /* times rays */
    /* light of point, spot and sun lights, which needs no rays; and its gradient */
    double certain[3 * SH_COUNT_MAX];
    double certain_gradient[9 * SH_COUNT_MAX];
    double visibility[SH_COUNT_MAX];
    struct occlusion occlusion;
    double nearness; /* sum of 1 / distance */
    int rays, hits, fronts;
    uint32_t asked[2]; /* of the lights, of the sky */
    /* Where no light was found although something emits: what a question would have found in the
     * mean if nothing stood between, as strata's channels; else 0 */
    double unseen[STRATA_CHANNELS];
    bool opens;         /* an even sky is asked for where it is open, not counted by rays */
    struct ask_lit lit; /* of the cache's sunlit points */
    bool sparse;        /* that is of pictures which are bright at few points, and none was found */
    struct guide guide; /* without cells: there is none */
    float guided;       /* rays by it for each of its own, in this round */
    uint32_t guided_rays;      /* so far */
    struct probe_split *parts; /* NULL: light is not split */
};

/* -- samples ----------------------------------------------------------------------------------- */

/* What a ray met, apart from light. */
static void note(struct work *w, const struct path_sample *s, struct vec3f direction)
{
    w->rays++;
    w->hits += s->hit;
    w->fronts += s->hit && s->front;
    w->nearness += s->hit ? 1 / (double)s->distance : 0;
    if (w->surface && w->settings->columns & CAPTURE_HORIZON)
        occlusion_sort(&w->occlusion, w->receiver.at.normal, w->settings->azimuths, direction,
                       s->hit);
    occlusion_add(&w->occlusion, direction, (double)s->distance / w->path->tracer->scale);
}

/* The samples of a wave: corner k (row by row) of its four f is number k * fours + f. */
struct draw {
    size_t fours;
    int cell[PATH_WAVE]; /* row by row */
    float x[PATH_WAVE];  /* a point of the unit square in that cell */
    double y[PATH_WAVE];
    struct random random[PATH_WAVE];
};

/* Draws a point in each cell of the grid's fours from `four` on; `first` is the number of the first
 * sample of this kind. */
static void draw_points(const struct work *w, enum kind kind, uint32_t first,
                        const struct grid *grid, int four, struct draw *draw)
{
    const int across = grid->columns / 2, left = grid->rows / 2 * across - four;
    draw->fours = left < STRATA_FOURS ? (size_t)left : STRATA_FOURS;
    for (int corner = 0, i = 0; corner < 4; corner++) {
        int row = four / across * 2 + (corner >> 1), column = four % across * 2 + (corner & 1);
        for (size_t f = 0; f < draw->fours; f++, i++) {
            draw->cell[i] = row * grid->columns + column;
            struct random r =
                random_start(w->settings->seed, w->name,
                             (uint32_t)kind << 30 | (first + (uint32_t)draw->cell[i]));
            draw->x[i] = (float)(((double)column + (double)random_float(&r)) / grid->columns);
            draw->y[i] = ((double)row + (double)random_float(&r)) / grid->rows;
            draw->random[i] = r;
            column += 2;
            if (column >= grid->columns) {
                column -= grid->columns;
                row += 2;
            }
        }
    }
}

/* 1 / density of guide_direction, by solid angle. */
static float own_solid_angle(const struct work *w, struct vec3f direction)
{
    return w->surface
               ? (float)ANGLE_PI / float_most(vec3f_dot(direction, w->receiver.at.normal), 1e-6f)
               : 4 * (float)ANGLE_PI;
}

/* Whether light that comes straight from lights is captured. */
static bool wants_direct(const struct work *w)
{
    return w->settings->light == CAPTURE_ALL || w->settings->light == CAPTURE_DIRECT;
}

/* What rays meet where no light is asked for. Where nothing but occlusion is, they end where
 * nothing occludes any more; and where it has a step, any surface before that will do: distance is
 * then one within reach. */
static void meet_surfaces(const struct work *w, const struct draw *draw,
                          const struct vec3f *direction, struct path_sample *met)
{
    const struct capture_settings *s = w->settings;
    const struct tracer *tracer = w->path->tracer;
    const size_t count = 4 * draw->fours;
    const bool near = !(s->columns & ~(unsigned)(CAPTURE_OCCLUSION | CAPTURE_RAYS)),
               far = s->columns & CAPTURE_HORIZON && w->surface;
    const double reach = s->ao_distance * tracer->scale;
    const float most = near && !far && reach < (double)FLT_MAX ? (float)reach : INFINITY;
    /* the horizon is of all surfaces */
    const bool any = near && s->ao_falloff == OCCLUSION_STEP &&
                     !(far && s->ao_distance < (double)INFINITY);
    struct trace_rays ray;
    struct trace_points at;
    int32_t seen[PATH_WAVE];
    for (size_t i = 0; i < count; i++) {
        struct random r = draw->random[i];
        wave_put(&ray.origin, i, w->receiver.at.position);
        wave_put(&ray.direction, i, direction[i]);
        ray.most[i] = most;
        ray.salt[i] = tracer->has_alpha ? random_u32(&r) : 0;
        seen[i] = 1;
    }
    if (any)
        trace_rays_occluded(tracer, count, &ray, seen);
    else
        trace_rays_nearest(tracer, count, &ray, &at);
    for (size_t i = 0; i < count; i++) {
        if (any)
            met[i] = (struct path_sample){
                .hit = !seen[i], .distance = seen[i] ? INFINITY : float_least(most, 1) / 2};
        else
            met[i] = (struct path_sample){
                .hit = at.hit[i], .front = at.front[i], .distance = at.distance[i]};
    }
}

/* Adds where rays met nothing to the sky that a point sees, by the functions in `wave`. */
static void add_visibility(struct work *w, const struct strata_wave *wave, size_t fours,
                           const struct path_sample *met)
{
    for (size_t i = 0; i < 4 * fours && w->settings->columns & CAPTURE_VISIBILITY && !w->surface;
         i++)
        for (int k = 0; k < w->light.functions && !met[i].hit; k++)
            w->visibility[k] += strata_function(wave, k, i / fours, i % fours);
}

/* Rays of the probe's own, where no light is asked for. */
static void take_about(struct work *w, const struct draw *draw, struct strata_wave *wave)
{
    static const struct vec3f dark[PATH_WAVE];
    struct vec3f direction[PATH_WAVE];
    struct path_sample met[PATH_WAVE];
    for (size_t i = 0; i < 4 * draw->fours; i++)
        direction[i] = guide_direction(&w->receiver, draw->x[i], draw->y[i]);
    meet_surfaces(w, draw, direction, met);
    for (size_t i = 0; i < 4 * draw->fours; i++)
        note(w, &met[i], direction[i]);
    if (w->settings->columns & CAPTURE_VISIBILITY)
        strata_add(&w->light, wave, draw->fours, direction, dark, w->receiver.at.normal);
    add_visibility(w, wave, draw->fours, met);
}

/* What a ray of the probe's own counts of scattered light beside those by the guide, and one of
 * these beside its own. */
static float share_beside_guide(const struct work *w, float x, double y)
{
    return w->guided > 0 ? 1 / (1 + w->guided * guide_density(&w->guide, (double)x, y)) : 1;
}

/* Rays of the probe's own; what they saw, unweighted, are a gradient's cells. */
static void take_own(struct work *w, struct draw *draw, struct strata_wave *wave,
                     struct gradient_cells *cells)
{
    const enum capture_light which = w->settings->light;
    const size_t count = 4 * draw->fours;
    struct vec3f direction[PATH_WAVE], light[PATH_WAVE];
    struct path_sample met[PATH_WAVE];
    float solid_angle[PATH_WAVE]; /* 1 / density */
    for (size_t i = 0; i < count; i++)
        direction[i] = guide_direction(&w->receiver, draw->x[i], draw->y[i]);
    if (w->parts)
        split_light_start(&w->parts->light);
    path_samples_split(w->path, &w->receiver,
                       &(struct path_rays){.count = count,
                                           .direction = direction,
                                           .random = draw->random,
                                           .straight_alone = which == CAPTURE_DIRECT},
                       met, w->parts ? &w->parts->light : NULL);
    for (size_t i = 0; i < count; i++) {
        const struct path_sample *m = &met[i];
        const struct vec3f straight =
            which != CAPTURE_INDIRECT && (m->hit || !w->opens) ? m->straight : (struct vec3f){0};
        solid_angle[i] = own_solid_angle(w, direction[i]);
        const struct vec3f scattered =
            vec3f_scale(share_beside_guide(w, draw->x[i], draw->y[i]), m->scattered);
        light[i] = vec3f_scale(solid_angle[i], vec3f_fma(scattered, m->weight, straight));
        note(w, m, direction[i]);
        if (cells->cell) {
            struct gradient_cell *cell = &cells->cell[draw->cell[i]];
            *cell = (struct gradient_cell){.radiance = vec3f_add(m->scattered, straight),
                                           .direction = direction[i]};
            const float off = m->hit ? m->distance * vec3f_dot(m->normal, direction[i]) : 0;
            if (fabsf(off) > w->room)
                cell->plane = vec3f_scale(1 / off, m->normal);
        }
    }
    strata_add(&w->light, wave, draw->fours, direction, light, w->receiver.at.normal);
    if (w->parts)
        probe_split_own(w->parts, wave, draw->fours, direction, met, solid_angle,
                        which != CAPTURE_INDIRECT);
    add_visibility(w, wave, draw->fours, met);
}

/* Questions to the lights or the sky. */
static void ask(struct work *w, enum kind kind, struct draw *draw, struct strata_wave *wave)
{
    const size_t count = 4 * draw->fours;
    struct vec3f direction[PATH_WAVE], light[PATH_WAVE];
    struct path_found found[PATH_WAVE];
    const struct path_draws draws = {
        .count = count, .x = draw->x, .y = draw->y, .random = draw->random};
    (kind == LIGHTS ? path_lights : path_skies)(w->path, &w->receiver, &draws, found);
    for (size_t i = 0; i < count; i++) {
        direction[i] = found[i].direction;
        light[i] = found[i].light;
    }
    strata_add(&w->light, wave, draw->fours, direction, light, w->receiver.at.normal);
    if (w->parts)
        probe_split_asked(w->parts, wave, draw->fours, found);
}

/* Asks whether the sky is open, at points of the unit square. */
static void ask_open(const struct work *w, const struct draw *draw,
                     struct path_found found[PATH_WAVE])
{
    const size_t count = 4 * draw->fours;
    struct vec3f direction[PATH_WAVE];
    for (size_t i = 0; i < count; i++)
        direction[i] = guide_direction(&w->receiver, draw->x[i], draw->y[i]);
    path_open(w->path, &w->receiver,
              &(struct path_rays){.count = count, .direction = direction, .random = draw->random},
              found);
}

/* Takes in what was found by questions whose density is, for a ray, density[0] everywhere, and
 * density[1] times that of the openings. */
static void take_open(struct work *w, const struct openings *openings, const struct draw *draw,
                      const double density[2])
{
    struct strata_wave wave;
    struct vec3f direction[PATH_WAVE], light[PATH_WAVE];
    struct path_found found[PATH_WAVE];
    ask_open(w, draw, found);
    for (size_t i = 0; i < 4 * draw->fours; i++) {
        const double all = density[0] +
                           density[1] * openings_density(openings, (double)draw->x[i], draw->y[i]);
        direction[i] = found[i].direction;
        light[i] = vec3f_scale(own_solid_angle(w, direction[i]) / (float)all, found[i].light);
    }
    strata_add(&w->light, &wave, draw->fours, direction, light, w->receiver.at.normal);
}

/* Finds openings, by questions that are not counted. */
static struct error *find_openings(struct work *w, const struct grid *grid,
                                   struct openings *openings)
{
    struct error *err = openings_init(openings, grid->rows, grid->columns);
    const int fours = grid_samples(grid) / 4;
    struct draw draw;
    struct path_found found[PATH_WAVE];
    for (int four = 0; four < fours && !err; four += (int)draw.fours) {
        draw_points(w, SKY, w->asked[1], grid, four, &draw);
        ask_open(w, &draw, found);
        for (size_t i = 0; i < 4 * draw.fours; i++)
            openings->open[draw.cell[i]] = vec3f_most(found[i].light) > 0;
    }
    w->asked[1] += (uint32_t)grid_samples(grid);
    return err ? err : openings_find(openings);
}

/* Points of openings, `count` in all, from `first` on: corner k of four f is at their place
 * 4 f + k. */
static void draw_openings(const struct work *w, const struct openings *openings, int count,
                          int first, struct draw *draw)
{
    draw->fours = (size_t)(count - first < PATH_WAVE ? count - first : PATH_WAVE) / 4;
    for (size_t k = 0, i = 0; k < 4; k++)
        for (size_t f = 0; f < draw->fours; f++, i++) {
            const uint32_t number = (uint32_t)first + (uint32_t)(4 * f + k);
            double x;
            draw->random[i] = random_start(w->settings->seed, w->name,
                                           (uint32_t)SKY << 30 | (w->asked[1] + number));
            openings_draw(openings, (number + random_double(&draw->random[i])) / count, &x,
                          &draw->y[i]);
            draw->x[i] = (float)x;
        }
}

/* Questions whether the sky is open, for `own` rays. */
static struct error *ask_openings(struct work *w, int own)
{
    struct openings openings = {0};
    const struct grid find = grid_for((int)(FIND_SHARE * own), 3);
    struct error *err = find_openings(w, &find, &openings);
    const double share = openings.count ? OPEN_EVEN : 1;
    const struct grid even = grid_for((int)(share * OPEN_SHARE * own), 3);
    const int evens = grid_samples(&even),
              near = openings.count ? (int)((1 - OPEN_EVEN) * OPEN_SHARE * own) / 4 * 4 : 0;
    const double density[2] = {(double)evens / own, (double)near / own};
    struct draw draw;
    for (int four = 0; four < evens / 4 && !err; four += (int)draw.fours) {
        draw_points(w, SKY, w->asked[1], &even, four, &draw);
        take_open(w, &openings, &draw, density);
    }
    w->asked[1] += (uint32_t)evens;
    for (int first = 0; first < near && !err; first += 4 * (int)draw.fours) {
        draw_openings(w, &openings, near, first, &draw);
        take_open(w, &openings, &draw, density);
    }
    w->asked[1] += (uint32_t)near;
    openings_clear(&openings);
    return err;
}

/* Questions to the sunlit points, `count` of them: corner k of four f is at their place 4 f + k. */
static void ask_lit(struct work *w, int count, float share)
{
    struct strata_wave wave;
    for (int first = 0; first < count; first += PATH_WAVE) {
        const int now = count - first < PATH_WAVE ? count - first : PATH_WAVE;
        const size_t fours = (size_t)now / 4;
        struct vec3f direction[PATH_WAVE], light[PATH_WAVE];
        struct path_found found[PATH_WAVE];
        int place[PATH_WAVE];
        for (size_t k = 0, i = 0; k < 4; k++)
            for (size_t f = 0; f < fours; f++, i++)
                place[i] = first + (int)(4 * f + k);
        ask_lit_wave(&w->lit, count, 4 * fours, place, found);
        for (size_t i = 0; i < 4 * fours; i++) {
            direction[i] = found[i].direction;
            light[i] = vec3f_scale(1 / share, found[i].light);
        }
        strata_add(&w->light, &wave, fours, direction, light, w->receiver.at.normal);
    }
    w->lit.first += (uint32_t)count;
}

/* Rays by the guide, which count what is scattered alone: corner k of four f is at their place
 * 4 f + k of `count`. */
static void take_guided(struct work *w, int count)
{
    struct strata_wave wave;
    for (int first = 0; first < count; first += PATH_WAVE) {
        const size_t fours = (size_t)(count - first < PATH_WAVE ? count - first : PATH_WAVE) / 4;
        struct vec3f direction[PATH_WAVE], light[PATH_WAVE];
        struct path_sample met[PATH_WAVE];
        struct random random[PATH_WAVE];
        float solid_angle[PATH_WAVE];
        for (size_t k = 0, i = 0; k < 4; k++)
            for (size_t f = 0; f < fours; f++, i++) {
                const uint32_t number = (uint32_t)first + (uint32_t)(4 * f + k);
                double x, y;
                random[i] = random_start(w->settings->seed, w->name,
                                         (uint32_t)LIT << 30 | GUIDED | (w->guided_rays + number));
                guide_draw(&w->guide, (number + random_double(&random[i])) / count, &x, &y);
                direction[i] = guide_direction(&w->receiver, (float)x, y);
                solid_angle[i] = own_solid_angle(w, direction[i]) *
                                 share_beside_guide(w, (float)x, y);
            }
        path_samples(
            w->path, &w->receiver,
            &(struct path_rays){.count = 4 * fours, .direction = direction, .random = random}, met);
        for (size_t i = 0; i < 4 * fours; i++)
            light[i] = vec3f_scale(solid_angle[i], met[i].scattered);
        strata_add(&w->light, &wave, fours, direction, light, w->receiver.at.normal);
    }
    w->guided_rays += (uint32_t)count;
}

/* -- rounds ------------------------------------------------------------------------------------ */

/* A sample in every cell of a grid, by fours, as many fours at once as make a wave. */
static void sample_cells(struct work *w, enum kind kind, uint32_t first, const struct grid *grid,
                         struct gradient_cells *cells)
{
    const int fours = grid->rows / 2 * (grid->columns / 2);
    struct draw draw;
    struct strata_wave wave;
    for (int four = 0; four < fours; four += (int)draw.fours) {
        draw_points(w, kind, first, grid, four, &draw);
        if (kind == OWN && w->settings->light == CAPTURE_NONE)
            take_about(w, &draw, &wave);
        else if (kind == OWN)
            take_own(w, &draw, &wave, cells);
        else
            ask(w, kind, &draw, &wave);
    }
}

static void ask_cells(struct work *w, enum kind kind, const struct grid *grid)
{
    uint32_t *asked = &w->asked[kind == SKY];
    sample_cells(w, kind, *asked, grid, NULL);
    *asked += (uint32_t)grid_samples(grid);
}

/* A round of `rays` rays and of the questions that go with them. */
static struct error *take_round(struct work *w, int rays)
{
    const struct grid own = own_grid(rays), asks = grid_for((int)(ASK_SHARE * rays), 1),
                      lit = grid_for((int)(LIT_SHARE * rays), 1);
    const bool direct = wants_direct(w);
    const bool ask_lights = direct && w->path->emissive, ask_sky = direct && w->path->sky.rows;
    const int guided = w->guide.cells ? (int)(GUIDED_SHARE * grid_samples(&own)) / 4 * 4 : 0;
    const float share = (float)grid_samples(&asks) / (float)grid_samples(&own);
    struct gradient_cells cells = {.rows = own.rows, .columns = own.columns};
    struct error *err = NULL;
    if (w->settings->columns & CAPTURE_GRADIENT && !w->surface)
        err = array_create(&cells.cell, (size_t)(own.rows * own.columns), sizeof *cells.cell);
    if (!err) {
        w->receiver.lights_share = w->receiver.sky_share = share;
        w->guided = (float)guided / (float)grid_samples(&own);
        sample_cells(w, OWN, (uint32_t)w->rays, &own, &cells);
        take_guided(w, guided);
        if (ask_lights)
            ask_cells(w, LIGHTS, &asks);
        if (ask_sky)
            ask_cells(w, SKY, &asks);
        if (w->receiver.lit)
            ask_lit(w, grid_samples(&lit), (float)grid_samples(&lit) / (float)grid_samples(&own));
    }
    if (!err && w->opens)
        err = ask_openings(w, grid_samples(&own));
    if (!err && cells.cell) /* distances are local: a world unit is `scale` of them */
        gradient_add_cells(&cells, w->settings->order, grid_samples(&own) * w->path->tracer->scale,
                           w->gradient);
    free(cells.cell);
    return err;
}

/* Whether samples found no light at all. */
static bool found_nothing(const struct work *w)
{
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < w->light.functions; i++)
            if (strata_sum(&w->light, c, i) > 0)
                return false;
    return true;
}

/* A lattice of rank 1. */
static void set_lattice(float x[PATH_WAVE], double y[PATH_WAVE])
{
    for (int i = 0; i < PATH_WAVE; i++) {
        x[i] = ((float)(i * 27 % PATH_WAVE) + 0.5f) / PATH_WAVE;
        y[i] = (i + 0.5) / PATH_WAVE;
    }
}

/* Sets what lights would give that were not seen. */
static void look_for_unseen(struct work *w)
{
    float x[PATH_WAVE];
    double y[PATH_WAVE];
    memset(w->unseen, 0, sizeof w->unseen);
    w->sparse = false;
    if (!w->path->emissive || w->settings->light == CAPTURE_NONE || !found_nothing(w))
        return;
    set_lattice(x, y);
    const struct vec3f light = path_lights_unshadowed(
        w->path, &w->receiver, &(struct path_draws){.count = PATH_WAVE, .x = x, .y = y},
        &w->sparse);
    /* of a picture with few bright points not one may have been met: all of it may be missing */
    const double all = w->sparse ? w->rays / UNSEEN : 1;
    w->unseen[0] = all * (double)light.x;
    w->unseen[1] = all * (double)light.y;
    w->unseen[2] = all * (double)light.z;
    w->unseen[3] = luminance_f64(w->unseen);
}

/* The error of a sum of samples that found none of so much light. */
static double unseen_error(const struct work *w, double unseen)
{
    /* root mean square of the SH basis, mean of a cosine */
    return UNSEEN * unseen * (w->light.order ? sqrt(1 / (4 * ANGLE_PI)) : 0.5);
}

/* Of a sum of samples: strata's, or what was not seen. */
static double variance_of(const struct work *w, int channel, int function)
{
    if (!(w->unseen[channel] > 0))
        return strata_variance(&w->light, channel, function);
    const double error = unseen_error(w, w->unseen[channel]);
    return error * error;
}

/* The error of a group whose light no sample found, for 1 that it would give. The share of the
 * questions that go to it, whose number the rule of three is of, may be small; all of its light may
 * be missing, which 1.96 standard errors are to hold. */
static double unseen_group(const struct work *w, double share)
{
    const double all = (double)w->receiver.lights_share * w->rays / 1.96 / UNSEEN;
    return share > 0 ? fmin(1 / share, all) : all;
}

/* Raises the error of groups whose light no sample found, as that of all light. */
static struct error *raise_errors(const struct work *w, float *part_error)
{
    const struct group_map *groups = w->parts->split->groups;
    const size_t width = 3 * (size_t)w->parts->functions;
    float x[PATH_WAVE];
    double y[PATH_WAVE], *mean = NULL, *share;
    if (!groups || !w->path->emissive || w->settings->light == CAPTURE_INDIRECT)
        return NULL;
    bool found = true;
    for (size_t g = 0; g < groups->count; g++)
        found = found && probe_split_found(w->parts, g);
    if (found)
        return NULL;
    struct error *err = array_create(&mean, 4 * groups->count, sizeof *mean);
    if (err)
        return err;
    share = mean + 3 * groups->count;
    set_lattice(x, y);
    path_groups_unshadowed(w->path, &w->receiver,
                           &(struct path_draws){.count = PATH_WAVE, .x = x, .y = y}, mean, share);
    for (size_t k = 0; k < groups->count * width; k++) {
        const size_t g = k / width;
        const double error = unseen_error(w, mean[3 * g + k % 3]) / w->rays;
        if (!probe_split_found(w->parts, g))
            part_error[k] = (float)(unseen_group(w, share[g]) * error);
    }
    free(mean);
    return NULL;
}

/* Mean irradiance in luminance, and its standard error, times rays: the two whose ratio
 * capture_settings.error bounds. */
static void irradiance_error(const struct work *w, double *mean, double *error)
{
    const int count = w->light.functions;
    double luminance = 0, variance = 0;
    /* of a surface, or of several in the mean */
    for (int i = 0; i < (w->light.order ? 1 : count); i++) {
        luminance += strata_sum(&w->light, 3, i) + w->rays * luminance_f64(w->certain + 3 * i);
        variance += variance_of(w, 3, i);
    }
    if (!w->light.order) {
        *mean = luminance / count;
        *error = sqrt(variance / count);
        return;
    }
    variance = 0;
    for (int l = 0, i = 0; l < w->settings->order; l++)
        for (; i < (l + 1) * (l + 1); i++)
            variance += sh_cosine(l) * sh_cosine(l) * variance_of(w, 3, i);
    *mean = sh_cosine(0) * luminance * sqrt(1 / (4 * ANGLE_PI));
    *error = sqrt(variance / (4 * ANGLE_PI));
}

/* How many more rays a probe needs; 0: none. */
static int rays_wanted(const struct work *w)
{
    /* Rays after which a probe that saw no light is dark; where something emits, its error is to be
     * within what was asked for of the light that there would be without shadows, as well. */
    enum { DARK = 2048 };
    const struct capture_settings *s = w->settings;
    double mean, error;
    if (!(s->error > 0) || w->rays >= s->rays_most)
        return 0;
    irradiance_error(w, &mean, &error);
    const double room = s->rays_most - w->rays;
    if (!(mean > 0)) {
        const double enough = w->unseen[3] > 0 ? UNSEEN / ASK_SHARE / s->error : 0;
        return w->rays < DARK     ? (int)fmin(DARK, room)
               : w->sparse        ? (int)fmin(w->rays, room)
               : w->rays < enough ? (int)fmin(enough - w->rays + 1, room)
                                  : 0;
    }
    const double ratio = error / fmax(mean, s->error_floor * w->rays) / s->error;
    if (ratio <= 1)
        return 0;
    /* By the root of their number; not too far ahead of what so few rays know, nor in steps too
     * small for their cells. */
    const double wanted = w->rays * fmin(fmax(1.1 * ratio * ratio - 1, 0.5), 8);
    return (int)fmin(wanted, room);
}

/* -- lights without a surface ----------------------------------------------------------------- */

static void delta_of(const void *context, const double p[3], double direction[3], double rgb[3])
{
    double distance;
    scene_light_at(context, p, direction, &distance, rgb);
}

static void add_to_normals(struct work *w, const double d[3], const double rgb[3], double visible)
{
    for (int i = 0; i < w->settings->normal_count; i++) {
        const double *n = w->settings->normal + 3 * i,
                     cosine = fmax(d[0] * n[0] + d[1] * n[1] + d[2] * n[2], 0);
        for (int k = 0; k < 3; k++)
            w->certain[3 * i + k] += visible * cosine * rgb[k];
    }
}

/* The part of a delta: the SH in its direction, or a surface's cosine. */
static void add_to_part(struct work *w, size_t part, const double d[3], const double rgb[3],
                        double visible)
{
    double y[SH_COUNT_MAX];
    const struct vec3f n = w->receiver.at.normal;
    if (w->surface)
        y[0] = fmax(d[0] * (double)n.x + d[1] * (double)n.y + d[2] * (double)n.z, 0);
    else
        sh_basis(w->settings->order, d, y);
    probe_split_certain(w->parts, part, y, rgb, visible);
}

/* The light of suns and points that are asked for by themselves. */
static void add_split_lights(struct work *w, const double p[3], const double start[3])
{
    static const double white[3] = {1, 1, 1};
    const struct split *split = w->parts->split;
    for (size_t s = 0; s < split->sun_count; s++) {
        const double *to = split->sun + 3 * s;
        add_to_part(w, split_suns(split) + s, to, white,
                    (double)trace_visibility_sky(w->path->tracer, start, to));
    }
    for (size_t i = 0; i < split->point_count; i++) {
        const struct scene_light light = split_point(split, i);
        double to[3], distance, rgb[3];
        scene_light_at(&light, p, to, &distance, rgb);
        if (rgb[0] > 0)
            add_to_part(w, split_points(split) + i, to, rgb,
                        (double)trace_visibility(w->path->tracer, start, split->point + 3 * i));
    }
}

/* Light that comes straight from point, spot and sun lights: a delta in its direction, certain. */
static void add_punctual(const struct path_tracer *path, struct work *w, const double p[3])
{
    const struct scene *scene = trace_scene(path->tracer);
    double start[3];
    vec3_store(start, trace_to_world(path->tracer, w->receiver.at.position));
    if (w->parts)
        add_split_lights(w, p, start);
    for (size_t i = 0; i < scene->light_count; i++) {
        const struct scene_light *light = &scene->lights[i];
        double d[3], distance, rgb[3];
        scene_light_at(light, p, d, &distance, rgb);
        if (!(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0))
            continue;
        const double at[3] = {light->position.x, light->position.y, light->position.z};
        const float visible = light->kind == SCENE_SUN
                                  ? trace_visibility_sky(path->tracer, start, d)
                                  : trace_visibility(path->tracer, start, at);
        if (w->parts && w->parts->split->groups)
            add_to_part(w, w->parts->split->groups->of_light[i], d, rgb, (double)visible);
        if (w->surface) {
            const struct vec3f n = w->receiver.at.normal;
            const double cosine =
                fmax(d[0] * (double)n.x + d[1] * (double)n.y + d[2] * (double)n.z, 0);
            for (int k = 0; k < 3; k++)
                w->certain[k] += (double)visible * cosine * rgb[k];
            continue;
        }
        if (w->settings->normal_count) {
            add_to_normals(w, d, rgb, (double)visible);
            continue;
        }
        double y[SH_COUNT_MAX];
        sh_basis(w->settings->order, d, y);
        sh_project(w->settings->order, y, rgb, (double)visible, w->certain);
        if (w->settings->columns & CAPTURE_GRADIENT && light->kind != SCENE_SUN && visible > 0)
            gradient_add_delta(&(struct gradient_light){delta_of, light, distance}, p,
                               w->settings->order, (double)visible, w->certain_gradient);
    }
}

/* -- the probe --------------------------------------------------------------------------------- */

/* What more rays do not lower: a cache is as wrong for all of a probe's rays. */
static void add_error_of_cache(const struct path_cache *cache, int functions, int order,
                               struct capture_probe *result)
{
    double square[3] = {0};
    for (int k = 0; k < 3 * functions; k++)
        square[k % 3] += (double)result->sh[k] * (double)result->sh[k];
    for (int l = 0, i = 0; l < order; l++)
        for (; i < (l + 1) * (l + 1) && i < functions; i++)
            for (int c = 0; c < 3; c++)
                result->sh_error[3 * i + c] = (float)hypot((double)result->sh_error[3 * i + c],
                                                           cache->error[l] * sqrt(square[c]));
}

/* The albedo of the surface that a receiver is on: what a ray into it meets first; false:
 * nothing. */
static bool albedo_behind(const struct work *w, float albedo[3])
{
    struct trace_rays ray = {.most = {INFINITY}};
    struct trace_points at;
    wave_put(&ray.origin, 0, w->receiver.at.position);
    wave_put(&ray.direction, 0, vec3f_scale(-1, w->receiver.at.normal));
    trace_rays_nearest(w->path->tracer, 1, &ray, &at);
    if (!at.hit[0])
        return false;
    const struct vec3f a = trace_albedo(w->path->tracer, &at, 0);
    albedo[0] = a.x, albedo[1] = a.y, albedo[2] = a.z;
    return true;
}

static void finish(const struct work *w, struct capture_probe *result)
{
    const int count = w->settings->order * w->settings->order;
    const struct path_cache *cache = w->path->cache;
    for (int k = 0; k < 3 * w->light.functions; k++) {
        result->sh[k] = (float)(strata_sum(&w->light, k % 3, k / 3) / w->rays + w->certain[k]);
        result->sh_error[k] = (float)(sqrt(variance_of(w, k % 3, k / 3)) / w->rays);
    }
    if (cache && !cache->check)
        add_error_of_cache(cache, w->light.functions, w->settings->order, result);
    for (int k = 0; k < 9 * count; k++)
        result->sh_gradient[k] = (float)(w->gradient[k] / w->rays + w->certain_gradient[k]);
    for (int k = 0; k < count; k++)
        result->visibility[k] = (float)(w->visibility[k] * 4 * ANGLE_PI / w->rays);
    result->validity = w->hits ? (float)w->fronts / (float)w->hits : 1;
    result->sky = (float)(w->rays - w->hits) / (float)w->rays;
    result->depth = w->hits ? (float)(w->rays / w->nearness / w->path->tracer->scale) : 0;
    result->ao = (float)(w->occlusion.open / w->rays);
    occlusion_bent(&w->occlusion, result->bent_normal, &result->bent_length);
    occlusion_cone(&w->occlusion, w->surface ? &w->receiver.at.normal : NULL, result->cone);
    occlusion_horizon(&w->occlusion, w->settings->azimuths, result->horizon);
    float albedo[3];
    if (w->surface && w->settings->columns & CAPTURE_AO_BOUNCED && albedo_behind(w, albedo))
        occlusion_bounced(result->ao, albedo, result->ao_bounced);
    else
        result->ao_bounced[0] = result->ao_bounced[1] = result->ao_bounced[2] = NAN;
    result->rays = w->rays;
}

/* Makes sunlit points ready to be asked, where a cache has some. A gradient is of rays alone. */
static struct error *start_lit(struct work *w)
{
    const struct path_cache *cache = w->path->cache;
    if (!cache || cache->check || !cache->lit || w->settings->light == CAPTURE_DIRECT ||
        w->settings->light == CAPTURE_NONE || w->settings->columns & CAPTURE_GRADIENT)
        return NULL;
    w->lit = (struct ask_lit){.path = w->path,
                              .lit = cache->lit,
                              .receiver = &w->receiver,
                              .seed = w->settings->seed,
                              .name = w->name,
                              .first = (uint32_t)LIT << 30};
    return ask_lit_start(&w->lit, (int)(LEARN_SHARE * w->settings->rays));
}

/* Looks where sunlight comes from, where there is no cache. A gradient and parts are of a probe's
 * own rays alone. */
static struct error *start_guide(struct work *w)
{
    const struct capture_settings *s = w->settings;
    if (!w->path->lit || w->path->cache || w->parts || s->light == CAPTURE_DIRECT ||
        s->columns & CAPTURE_GRADIENT)
        return NULL;
    return guide_look(&w->guide, w->path, &w->receiver, s->seed, w->name, (uint32_t)LIT << 30,
                      (int)fmin(fmax(LOOK_SHARE * s->rays, LOOK_LEAST), LOOK_MOST));
}

/* Embree ends the process at a ray from beyond 1.8e18; long before that, floats cannot hold squares
 * of distances. */
static const float farthest = 1e15f;

struct error *capture_probe(const struct path_tracer *paths,
                            const struct capture_settings *settings, const double p[3],
                            const float *normal, struct capture_probe *result)
{
    return capture_probe_split(paths, settings, p, normal, result, NULL, NULL);
}

struct error *capture_probe_split(const struct path_tracer *paths,
                                  const struct capture_settings *settings, const double p[3],
                                  const float *normal, struct capture_probe *result, float *part,
                                  float *part_error)
{
    struct probe_split parts = {0};
    const struct path_tracer *path;
    struct error *err = path_near(paths, p, &path);
    if (err)
        return err;
    struct work w = {
        .path = path,
        .settings = settings,
        .name = random_hash_position(p),
        .surface = normal,
        .occlusion = {.falloff = settings->ao_falloff, .distance = settings->ao_distance}};
    if (settings->normal_count && !normal)
        strata_start_normals(&w.light, settings->normal, settings->normal_count,
                             settings->error > 0);
    else
        strata_start(&w.light, normal ? 0 : settings->order, settings->error > 0);
    if (normal)
        w.receiver.at.normal = vec3f_normalize((struct vec3f){normal[0], normal[1], normal[2]});
    const struct vec3f local = trace_to_local(path->tracer, p);
    if (!(fabsf(local.x) < farthest && fabsf(local.y) < farthest && fabsf(local.z) < farthest))
        return error_new("%g,%g,%g is too far out: more than %g times the scene's size", p[0], p[1],
                         p[2], (double)farthest);
    w.receiver.at.position = trace_start(path->tracer, p, w.receiver.at.normal);
    w.room = trace_start_room(path->tracer, p);
    if (part) {
        err = probe_split_init(&parts, &settings->split->split, normal ? 0 : settings->order);
        w.parts = &parts;
    }
    if (!err && wants_direct(&w))
        add_punctual(path, &w, p);
    w.opens = path->cache && path->cache->opens && !path->cache->check && wants_direct(&w) &&
              !(settings->columns & CAPTURE_GRADIENT);
    if (!err)
        err = start_lit(&w);
    if (!err)
        err = start_guide(&w);
    for (int rays = settings->rays; rays && !err; rays = rays_wanted(&w)) {
        err = take_round(&w, rays);
        if (!err)
            look_for_unseen(&w);
    }
    if (!err)
        finish(&w, result);
    if (!err && part)
        probe_split_finish(&parts, w.rays, part, part_error);
    if (!err && part)
        err = raise_errors(&w, part_error);
    probe_split_clear(&parts);
    ask_lit_end(&w.lit);
    guide_clear(&w.guide);
    return err;
}
