/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/other_light.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "relight/lamp_blend.h"
#include "relight/relight.h"
#include "relight/sky_bands.h"
#include "scene/relit.h"
#include "scene/scene.h"
#include "scene/scene_sky.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct other_light other_light_default(void)
{
    return (struct other_light){.settings = scene_settings_default()};
}

void other_light_clear(struct other_light *light)
{
    scene_settings_clear(&light->settings);
    *light = other_light_default();
}

bool other_light_has_sky(const struct other_light *light)
{
    return light->settings.sky_given || light->sky_probe;
}

/* -- rows of a table -------------------------------------------------------------------------- */

static struct error *copy_settings(struct scene_settings *to, const struct scene_settings *from)
{
    struct stream_header keys = {0};
    struct error *err = scene_settings_to_header(from, &keys);
    if (!err)
        err = scene_settings_from_header(to, &keys);
    to->sky_given = from->sky_given;
    header_clear(&keys);
    return err;
}

/* As the option of that name reads it; what is wrong is data. */
static struct error *read_option(struct scene_settings *settings, const char *name,
                                 const char *text)
{
    struct option_row rows[SCENE_SETTINGS_ROWS];
    scene_settings_rows(settings, rows);
    struct error *err = text ? option_row(rows, name)->parse(settings, text) : NULL;
    if (!err || err == error_memory())
        return err;
    const char *said = error_message(err);
    struct error *data = strncmp(said, "--", 2) ? error_new("--%s: %s", name, said)
                                                : error_new("%s", said);
    error_destroy(err);
    return data;
}

static struct error *read_time(struct other_light *light, const char *text)
{
    if (!text)
        return NULL;
    if (!light->sun_path)
        return error_new("--time: expected --sun-path beside it");
    light->time_given = true;
    return options_real("--time", text, &light->time);
}

struct error *other_light_of_row(struct other_light *row, const struct other_light *all,
                                 const char *sky, const char *sun, const char *point,
                                 const char *time)
{
    *row = *all;
    row->settings = scene_settings_default();
    struct error *err = copy_settings(&row->settings, &all->settings);
    if (!err)
        err = read_option(&row->settings, "sky", sky);
    if (!err)
        err = read_option(&row->settings, "sun", sun);
    if (!err)
        err = read_option(&row->settings, "point", point);
    row->settings.inherited = 0;
    return err ? err : read_time(row, time);
}

/* -- weights ---------------------------------------------------------------------------------- */

/* Adds the sun of a time to those that were given. */
static struct error *add_timed_sun(struct other_light *light)
{
    struct scene_settings *s = &light->settings;
    struct sun_place at;
    struct error *err = sun_path_at(light->sun_path, light->time, &at);
    if (err)
        return err;
    const struct vec3 towards = scene_sky_direction(s->sky_up, at.azimuth, at.elevation);
    struct scene_light sun = {.kind = SCENE_SUN, .direction = vec3_scale(-1, towards)};
    memcpy(sun.intensity, at.rgb, sizeof sun.intensity);
    err = array_reserve(&s->lights, &s->light_capacity, s->light_count + 1, sizeof sun);
    if (!err)
        s->lights[s->light_count++] = sun;
    return err;
}

/* How far off the stored suns one may be before that is worth a word. */
#define SUN_OFF_MOST 1.0

/* Adds the weights of stored suns for one that is asked for. */
static struct error *weigh_sun(const struct other_light *light, const struct relight *r,
                               const struct scene_light *sun, double *weight,
                               struct warnings *warnings)
{
    const struct vec3 to = vec3_scale(-1, sun->direction);
    const double towards[3] = {to.x, to.y, to.z};
    double *blend = NULL;
    if (!r->suns)
        return error_new("there is no transfer of suns: expected a stream of probe-capture "
                         "--transfer suns:FILE");
    if (light->between == SUN_SPHERE && r->suns > SUN_SPHERE_MOST)
        return error_new("--sun-between sphere: expected at most %d suns, got %zu",
                         (int)SUN_SPHERE_MOST, r->suns);
    struct error *err = array_create(&blend, r->suns, sizeof *blend);
    if (err)
        return err;
    const double off = sun_blend(light->between, r->suns, r->sun, towards, blend);
    if (off > SUN_OFF_MOST)
        warnings_add(warnings, "sun off",
                     "a sun is %.1f degrees off those of the transfer: the light is that of the "
                     "nearest direction between them",
                     off);
    for (size_t s = 0; s < r->suns; s++)
        for (size_t c = 0; c < 3; c++)
            weight[3 * s + c] += blend[s] * sun->intensity[c];
    free(blend);
    return NULL;
}

/* The same of stored points. */
static struct error *weigh_point(const struct relight *r, const struct scene_light *lamp,
                                 double *weight, struct warnings *warnings)
{
    const double p[3] = {lamp->position.x, lamp->position.y, lamp->position.z};
    double *blend = NULL, off = 0, size = 0;
    if (!r->points)
        return error_new("there is no transfer of points: expected a stream of probe-capture "
                         "--transfer points:STREAM");
    struct error *err = array_create(&blend, r->points, sizeof *blend);
    if (!err)
        err = lamp_blend(r->points, r->point, p, blend, &off);
    for (size_t i = 0; i < 3 * r->points; i++)
        size = fmax(size, fabs(r->point[i]));
    if (!err && off > 1e-9 * size)
        warnings_add(warnings, "point off",
                     "the point at %g,%g,%g is %.3g outside of those of the transfer: the light is "
                     "that of the nearest place between them",
                     p[0], p[1], p[2], off);
    for (size_t i = 0; i < 3 * r->points && !err; i++)
        weight[i] += blend[i / 3] * lamp->intensity[i % 3];
    free(blend);
    return err;
}

static struct error *weigh_sky(struct other_light *light, const struct relight *r, double *weight,
                               struct warnings *warnings)
{
    struct scene_sky sky = {0};
    if (!other_light_has_sky(light))
        return NULL;
    if (!r->sky_order)
        return error_new("there is no transfer of a sky: expected a stream of probe-capture "
                         "--transfer sky:N");
    if (light->sky_probe)
        return sky_bands_of_probe(light->sky_probe, r->sky_order, weight);
    struct error *err = scene_sky_finish(&sky, NULL, &light->settings, warnings);
    light->settings.sky_key = sky.key;
    if (!err)
        err = sky_bands(&sky, r->sky_order, weight);
    scene_sky_clear(&sky);
    return err;
}

struct error *other_light_weigh(struct other_light *light, const struct relight *r, double *weight,
                                struct warnings *warnings)
{
    const size_t functions = (size_t)(r->sky_order * r->sky_order);
    const struct scene_settings *s = &light->settings;
    if (r->turned && (s->sky_given || s->light_count || light->time_given))
        return error_new(
            "the probes were turned (key rotated or rotated-light): a sky and lights "
            "of the scene come before probe-cat --rotate; --sky-probe may come after it");
    struct error *err = weigh_sky(light, r, weight, warnings);
    if (!err && light->time_given)
        err = add_timed_sun(light);
    bool sun = false, point = false;
    for (size_t i = 0; i < light->settings.light_count && !err; i++) {
        const struct scene_light *l = &light->settings.lights[i];
        const bool is_point = l->kind == SCENE_POINT;
        err = is_point ? weigh_point(r, l, weight + 3 * (functions + r->suns), warnings)
                       : weigh_sun(light, r, l, weight + 3 * functions, warnings);
        point = point || is_point;
        sun = sun || !is_point;
    }
    if (!err && functions && !other_light_has_sky(light))
        warnings_add(warnings, "no sky", "the transfer of a sky adds nothing: no --sky is given");
    if (!err && r->points && !point)
        warnings_add(warnings, "no point",
                     "the transfer of points adds nothing: no --point is given");
    if (!err && r->suns && !sun)
        warnings_add(warnings, "no sun",
                     "the transfer of suns adds nothing: no --sun or --time is given");
    return err;
}

struct error *other_light_to_header(const struct other_light *light, const struct relight *relight,
                                    const double *weight, struct stream_header *header)
{
    struct error *err = relit_light_to_header(&light->settings, light->settings.sky_given, header);
    return !err && light->sky_probe ? relit_sky_sh_to_header(relight->sky_order, weight, header)
                                    : err;
}
