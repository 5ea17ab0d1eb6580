/* SPDX-License-Identifier: Apache-2.0 */
#include "render/shot.h"
#include "base/array.h"
#include "base/error.h"
#include "image/annotate.h"
#include "image/cielab.h"
#include "image/colour_map.h"
#include "math/sort.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

bool shot_compares(enum shot_mode mode)
{
    return mode >= SHOT_SPLIT;
}

int shot_pictures(const struct shot_settings *s)
{
    return shot_compares(s->mode) && !s->given_truth ? 2 : 1;
}

void shot_clear(struct shot *shot)
{
    picture_clear(&shot->shown);
    picture_clear(&shot->linear);
}

/* -- drawing over ----------------------------------------------------------------------------- */

static struct vec3f screen_light(const struct compare_screen *screen, struct vec3f c)
{
    return (struct vec3f){(float)display_tone(screen->tone, screen->exposure * (double)c.x),
                          (float)display_tone(screen->tone, screen->exposure * (double)c.y),
                          (float)display_tone(screen->tone, screen->exposure * (double)c.z)};
}

/* Puts the overlay over a picture, exposed (screen: how) or linear (its lines are as bright as they
 * look on the screen). */
static void draw_overlay(const struct picture *p, const struct overlay *o,
                         const struct compare_screen *screen, bool exposed)
{
    const struct vec3f line = exposed ? overlay_line
                                      : vec3f_scale((float)(1 / screen->exposure), overlay_line);
    for (size_t y = 0; o && y < p->height; y++)
        for (size_t x = 0; x < p->width; x++) {
            const struct vec3f light = picture_get(&o->light, x, y);
            picture_set(p, x, y,
                        overlay_over(o, x, y, picture_get(p, x, y),
                                     exposed ? screen_light(screen, light) : light, line));
        }
}

/* A picture, linear and shown, with its overlay; takes over `linear`. */
static struct error *show(struct shot *shot, struct picture *linear, const struct shot_settings *s)
{
    const struct compare_screen screen = {shot->exposure, s->tone};
    shot->linear = *linear;
    *linear = (struct picture){0};
    struct error *err = compare_show(&shot->linear, &screen, &shot->shown);
    if (err)
        return err;
    draw_overlay(&shot->shown, s->overlay, &screen, true);
    draw_overlay(&shot->linear, s->overlay, &screen, false);
    return NULL;
}

/* -- differences ------------------------------------------------------------------------------ */

/* 1, 2 or 5 times a power of ten, at least x. */
static double round_up(double x)
{
    double step = 1;
    for (int i = 0; i < 300 && step < x; i++)
        step *= 10;
    for (int i = 0; i < 300 && step / 10 >= x; i++)
        step /= 10; /* x is in (step / 10, step] */
    return x <= step / 5 ? step / 5 : x <= step / 2 ? step / 2 : step;
}

static struct error *choose_scale(const float *difference, size_t count, double *scale)
{
    float *size = NULL;
    struct error *err = array_create(&size, count, sizeof *size);
    if (err)
        return err;
    for (size_t i = 0; i < count; i++)
        size[i] = fabsf(difference[i]);
    sort_floats(count, size);
    const float most = size[(count - 1) * 99 / 100];
    *scale = most > 0 ? round_up((double)most) : 1;
    free(size);
    return NULL;
}

/* L* of what the screen shows. */
static double lightness(const struct picture *p, size_t i, const struct compare_screen *screen)
{
    const struct vec3f c =
        screen_light(screen, (struct vec3f){p->rgb[3 * i], p->rgb[3 * i + 1], p->rgb[3 * i + 2]});
    double lab[3];
    cielab_of((const double[3]){(double)c.x, (double)c.y, (double)c.z}, lab);
    return lab[0];
}

static struct error *show_difference(struct shot *shot, const struct picture *truth,
                                     const struct picture *test, const struct shot_settings *s)
{
    const struct compare_screen screen = {shot->exposure, s->tone};
    const size_t count = truth->width * truth->height;
    float *difference = NULL;
    char low[32], high[32];
    struct error *err = picture_init(&shot->linear, truth->width, truth->height);
    if (!err)
        err = picture_init(&shot->shown, truth->width, truth->height);
    if (!err)
        err = array_create(&difference, count, sizeof *difference);
    for (size_t i = 0; !err && i < 3 * count; i++)
        shot->linear.rgb[i] = test->rgb[i] - truth->rgb[i];
    for (size_t i = 0; !err && i < count; i++)
        difference[i] = (float)(lightness(test, i, &screen) - lightness(truth, i, &screen));
    shot->scale = s->scale;
    if (!err && !(s->scale > 0))
        err = choose_scale(difference, count, &shot->scale);
    for (size_t i = 0; !err && i < count; i++)
        picture_set(&shot->shown, i % truth->width, i / truth->width,
                    colour_map_at(COLOUR_COOL_WARM, ((double)difference[i] / shot->scale + 1) / 2));
    free(difference);
    if (err)
        return err;
    draw_overlay(&shot->shown, s->overlay, &screen, true);
    snprintf(low, sizeof low, "%g too dark", -shot->scale);
    snprintf(high, sizeof high, "+%g too bright", shot->scale);
    annotate_scale(&shot->shown, COLOUR_COOL_WARM, "lightness L* less the truth's",
                   (const char *const[]){low, "0", high});
    return NULL;
}

static struct error *show_flip(struct shot *shot, const struct picture *truth, const float *map,
                               const struct shot_settings *s)
{
    const struct compare_screen screen = {shot->exposure, s->tone};
    struct error *err = picture_init(&shot->linear, truth->width, truth->height);
    if (!err)
        err = picture_init(&shot->shown, truth->width, truth->height);
    for (size_t i = 0; !err && i < truth->width * truth->height; i++) {
        const size_t x = i % truth->width, y = i / truth->width;
        picture_set(&shot->linear, x, y, (struct vec3f){map[i], map[i], map[i]});
        picture_set(&shot->shown, x, y, colour_map_at(COLOUR_MAGMA, (double)map[i]));
    }
    if (err)
        return err;
    draw_overlay(&shot->shown, s->overlay, &screen, true);
    annotate_scale(&shot->shown, COLOUR_MAGMA, "FLIP",
                   (const char *const[]){"0 alike", "0.5", "1"});
    return NULL;
}

/* -- two in one ------------------------------------------------------------------------------- */

static const char *light_name(enum render_light light)
{
    static const char *const name[] = {[RENDER_TRUTH] = "truth",
                                       [RENDER_DIRECT] = "truth, direct",
                                       [RENDER_PROBES] = "probes",
                                       [RENDER_MIXED] = "probes and direct"};
    return name[light];
}

static void label_two(const struct picture *p, double second, const struct shot_settings *s)
{
    const double gap = annotate_height(p) / 2;
    const char *test = light_name(s->test);
    annotate_text(p, gap, gap, light_name(s->truth));
    annotate_text(p, second - gap - annotate_width(p, test), gap, test);
}

/* The left half of one and the right half of the other. */
static struct error *show_split(struct shot *shot, const struct picture *truth,
                                const struct picture *test, const struct shot_settings *s)
{
    struct picture both = {0};
    struct error *err = picture_init(&both, truth->width, truth->height);
    for (size_t y = 0; !err && y < truth->height; y++)
        for (size_t x = 0; x < truth->width; x++)
            picture_set(&both, x, y, picture_get(x < truth->width / 2 ? truth : test, x, y));
    if (!err)
        err = show(shot, &both, s);
    picture_clear(&both);
    if (err)
        return err;
    for (size_t y = 0; y < truth->height; y++)
        picture_set(&shot->shown, truth->width / 2, y, (struct vec3f){1, 1, 1});
    label_two(&shot->shown, (double)truth->width, s);
    return NULL;
}

static struct error *show_pair(struct shot *shot, const struct picture *truth,
                               const struct picture *test, const struct shot_settings *s)
{
    struct shot one = {.exposure = shot->exposure};
    struct error *err = picture_init(&shot->shown, 2 * truth->width, truth->height);
    if (!err)
        err = picture_init(&shot->linear, 2 * truth->width, truth->height);
    for (int i = 0; i < 2 && !err; i++) {
        struct picture copy = {0};
        err = picture_init(&copy, truth->width, truth->height);
        if (err)
            break;
        picture_paste(&copy, 0, 0, i ? test : truth);
        err = show(&one, &copy, s);
        if (!err) {
            picture_paste(&shot->shown, (size_t)i * truth->width, 0, &one.shown);
            picture_paste(&shot->linear, (size_t)i * truth->width, 0, &one.linear);
        }
        picture_clear(&copy);
        shot_clear(&one);
    }
    if (!err)
        label_two(&shot->shown, 2 * (double)truth->width, s);
    return err;
}

struct error *shot_compose(struct shot *shot, const struct picture *truth,
                           const struct picture *variance, const struct picture *test,
                           const struct shot_settings *s, int threads)
{
    float *map = NULL;
    shot->exposure = s->exposure;
    struct error *err = s->exposure > 0 ? NULL : compare_exposure(truth, &shot->exposure);
    if (!err)
        err = array_create(&map, truth->width * truth->height, sizeof *map);
    if (!err) {
        const struct compare_pair pair = {.truth = truth,
                                          .test = test,
                                          .variance = variance,
                                          .screen = {shot->exposure, s->tone}};
        err = compare_pictures(&pair, threads, map, &shot->figures);
    }
    shot->compared = !err;
    if (err)
        ;
    else if (s->mode == SHOT_SPLIT)
        err = show_split(shot, truth, test, s);
    else if (s->mode == SHOT_PAIR)
        err = show_pair(shot, truth, test, s);
    else if (s->mode == SHOT_FLIP)
        err = show_flip(shot, truth, map, s);
    else
        err = show_difference(shot, truth, test, s);
    free(map);
    return err;
}

/* -- rendering -------------------------------------------------------------------------------- */

static enum render_light light_of(enum shot_mode mode)
{
    return mode == SHOT_PROBES  ? RENDER_PROBES
           : mode == SHOT_MIXED ? RENDER_MIXED
           : mode == SHOT_NONE  ? RENDER_DIRECT
                                : RENDER_TRUTH;
}

static struct error *take_one(struct shot *shot, const struct render *render,
                              const struct shot_settings *s, struct progress *progress)
{
    struct picture picture = {0};
    struct error *err = render_picture(render, light_of(s->mode), &picture, NULL, progress);
    shot->exposure = s->exposure;
    if (!err && !(s->exposure > 0))
        err = compare_exposure(&picture, &shot->exposure);
    if (!err)
        err = show(shot, &picture, s);
    picture_clear(&picture);
    return err;
}

struct error *shot_take(struct shot *shot, const struct render *render,
                        const struct shot_settings *s, struct progress *progress)
{
    if (!shot_compares(s->mode))
        return take_one(shot, render, s, progress);
    struct picture truth = {0}, variance = {0}, test = {0};
    struct error *err =
        s->given_truth ? NULL : render_picture(render, s->truth, &truth, &variance, progress);
    if (!err)
        err = render_picture(render, s->test, &test, NULL, progress);
    if (!err)
        err = shot_compose(shot, s->given_truth ? s->given_truth : &truth,
                           s->given_truth ? NULL : &variance, &test, s, render->threads);
    picture_clear(&truth);
    picture_clear(&variance);
    picture_clear(&test);
    return err;
}
