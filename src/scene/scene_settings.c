/* SPDX-License-Identifier: Apache-2.0 */
/* The light that a file cannot hold: options, and the keys that carry them through the stream. */
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "light/rotate.h"
#include "math/angle.h"
#include "scene/scene_settings.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct scene_settings scene_settings_default(void)
{
    return (struct scene_settings){
        .sky_up = {0, 1, 0}, .sky_scale = 1, .albedo_scale = 1, .max_albedo = 1, .light_scale = 1};
}

static void forget_sky(struct scene_settings *settings)
{
    free(settings->sky_file);
    free(settings->sky_from_scene);
    settings->sky_file = settings->sky_from_scene = NULL;
    settings->sky_key = 0;
}

void scene_settings_clear(struct scene_settings *settings)
{
    forget_sky(settings);
    free(settings->lights);
    scene_choice_clear(&settings->choice);
    *settings = scene_settings_default();
}

/* -- numbers made into settings --------------------------------------------------------------- */

static struct error *check_light(const double rgb[3])
{
    for (int c = 0; c < 3; c++)
        if (rgb[c] < 0)
            return error_usage("expected light of at least 0, got %.15g", rgb[c]);
    return NULL;
}

static struct error *add_light(struct scene_settings *settings, const struct scene_light *light)
{
    struct error *err = check_light(light->intensity);
    if (!err)
        err = array_reserve(&settings->lights, &settings->light_capacity, settings->light_count + 1,
                            sizeof *settings->lights);
    if (!err)
        settings->lights[settings->light_count++] = *light;
    return err;
}

/* A light of the command line: those of a header give way to what it says. */
static struct error *give_light(struct scene_settings *settings, const struct scene_light *light)
{
    if (settings->inherited)
        settings->light_count = settings->inherited = 0;
    return add_light(settings, light);
}

/* Makes a direction of any length a unit one. */
static struct error *make_unit(struct vec3 *direction)
{
    const double size = fmax(fmax(fabs(direction->x), fabs(direction->y)), fabs(direction->z));
    if (!(size > 0))
        return error_usage("expected a direction, got 0,0,0");
    *direction = vec3_normalize(
        (struct vec3){direction->x / size, direction->y / size, direction->z / size});
    return NULL;
}

/* -- options ---------------------------------------------------------------------------------- */

/* Numbers that are wrong are no file that is missing. */
static bool is_meant_as_numbers(const char *text)
{
    return strchr(text, ',') || !strpbrk(text, "./") ||
           text[strspn(text, "0123456789.;+-eE \t")] == 0;
}

static struct error *parse_sky(void *value, const char *text)
{
    struct scene_settings *settings = value;
    char *file = NULL;
    double rgb[3] = {0};
    struct error *err = NULL;
    if (text[strspn(text, "0123456789.,+-eE")] == 0) {
        err = options_reals("--sky", text, 3, rgb);
        if (!err)
            err = check_light(rgb);
    } else if (!(file = realpath(text, NULL))) {
        /* a later stage may run in another folder; what is not there is named as it was given */
        file = strdup(text);
        err = !file ? error_memory()
              : is_meant_as_numbers(text)
                  ? error_usage("expected 3 finite numbers separated by commas, or the name of a "
                                "picture, got '%s': there is no such file",
                                text)
                  : NULL;
    }
    if (err) {
        free(file);
        return err;
    }
    settings->sky_given = true;
    memcpy(settings->sky, rgb, sizeof rgb);
    forget_sky(settings);
    settings->sky_file = file;
    return NULL;
}

static const char *const map_names[] = {"auto", "latlong", "angular", "cube", NULL};

static struct error *parse_sky_up(void *value, const char *text)
{
    struct scene_settings *settings = value;
    double n[3];
    struct error *err = options_reals("--sky-up", text, 3, n);
    if (err)
        return err;
    struct vec3 up = vec3_load(n);
    err = make_unit(&up);
    if (!err)
        vec3_store(settings->sky_up, up);
    return err;
}

static struct error *parse_sun(void *value, const char *text)
{
    double n[6];
    struct error *err = options_reals("--sun", text, 6, n);
    if (err)
        return err;
    struct scene_light light = {
        .kind = SCENE_SUN, .direction = vec3_load(n), .intensity = {n[3], n[4], n[5]}};
    err = make_unit(&light.direction);
    return err ? err : give_light(value, &light);
}

static struct error *parse_point(void *value, const char *text)
{
    double n[6];
    struct error *err = options_reals("--point", text, 6, n);
    const struct scene_light light = {
        .kind = SCENE_POINT, .position = vec3_load(n), .intensity = {n[3], n[4], n[5]}};
    return err ? err : give_light(value, &light);
}

static struct error *parse_spot(void *value, const char *text)
{
    double n[11];
    struct error *err = options_reals("--spot", text, 11, n);
    if (err)
        return err;
    if (!(0 <= n[6] && n[6] <= n[7] && n[7] <= 90))
        return error_usage("expected angles 0 <= INNER <= OUTER <= 90, got %.15g and %.15g", n[6],
                           n[7]);
    struct scene_light light = {.kind = SCENE_SPOT,
                                .position = vec3_load(n),
                                .direction = vec3_load(n + 3),
                                .intensity = {n[8], n[9], n[10]},
                                .cos_inner = angle_cos(n[6] * (ANGLE_PI / 180)),
                                .cos_outer = angle_cos(n[7] * (ANGLE_PI / 180))};
    err = make_unit(&light.direction);
    return err ? err : give_light(value, &light);
}

static const char *const lenient_names[] = {"no", "yes", NULL};
static const char *const emit_names[] = {"both", "front", NULL}; /* by emit_front_only */

static struct error *parse_emit(void *value, const char *text)
{
    struct scene_settings *settings = value;
    if (strcmp(text, "both") && strcmp(text, "front"))
        return error_usage("expected one of both, front, got '%s'", text);
    settings->emit_front_only = !strcmp(text, "front");
    return NULL;
}

const struct option_row *scene_file_rows(struct scene_settings *settings, struct option_row *rows)
{
    rows[0] = (struct option_row){
        .name = "lenient",
        .kind = OPTION_FLAG,
        .value = &settings->lenient,
        .help = "what is broken in the scene's file is left out with a warning, and\n"
                "is no error"};
    scene_choice_rows(&settings->choice, rows + 1);
    rows[SCENE_FILE_ROWS - 1] = (struct option_row){0};
    return rows;
}

const struct option_row *scene_settings_rows(struct scene_settings *settings,
                                             struct option_row *rows)
{
    const struct option_row table[] = {
        {.name = "sky",
         .argument = "R,G,B|FILE",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_sky,
         .help = "radiance where there is no surface: one colour, or a\n"
                 "panorama (Radiance .hdr, OpenEXR)",
         .shown = "0,0,0"},
        {.name = "sky-map",
         .argument = "MAP",
         .kind = OPTION_CHOICE,
         .value = OPTION_ENUM(settings->sky_map),
         .choices = map_names,
         .help = "what the picture is: auto, a panorama of 2:1; latlong, of\n"
                 "any sides; angular, the map of a square light probe; cube,\n"
                 "six faces as a cross or a strip"},
        {.name = "sky-turn",
         .argument = "DEGREES",
         .kind = OPTION_REAL,
         .value = &settings->sky_turn,
         .least = -360,
         .most = 360,
         .help = "turns the picture about the up axis, counter-clockwise\n"
                 "from above"},
        {.name = "sky-up",
         .argument = "X,Y,Z",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_sky_up,
         .help = "where the picture's upper edge is",
         .shown = "0,1,0"},
        {.name = "sky-scale",
         .argument = "FACTOR",
         .kind = OPTION_REAL,
         .value = &settings->sky_scale,
         .most = (double)INFINITY,
         .help = "multiplies the sky, picture or colour"},
        {.name = "sun",
         .argument = "DX,DY,DZ,R,G,B",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_sun,
         .help = "parallel light: the direction that it travels, and its\n"
                 "irradiance on a perpendicular surface; may repeat"},
        {.name = "point",
         .argument = "X,Y,Z,R,G,B",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_point,
         .help = "point light: place and radiant intensity; may repeat"},
        {.name = "spot",
         .argument = "X,Y,Z,DX,DY,DZ,INNER,OUTER,R,G,B",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_spot,
         .help = "spot light: place, direction, the half angles in degrees\n"
                 "where it begins to fall off and ends, radiant intensity;\nmay repeat"},
        {.name = "emit",
         .argument = "SIDES",
         .kind = OPTION_CALL,
         .value = settings,
         .parse = parse_emit,
         .help = "sides from which surfaces emit: both or front",
         .shown = "both"},
        {.name = "albedo-scale",
         .argument = "FACTOR",
         .kind = OPTION_REAL,
         .value = &settings->albedo_scale,
         .most = (double)INFINITY,
         .help = "multiplies every albedo"},
        {.name = "max-albedo",
         .argument = "ALBEDO",
         .kind = OPTION_REAL,
         .value = &settings->max_albedo,
         .most = 1,
         .help = "limits every albedo, after the scale"},
        {.name = "light-scale",
         .argument = "FACTOR",
         .kind = OPTION_REAL,
         .value = &settings->light_scale,
         .most = (double)INFINITY,
         .help = "multiplies the lights and the emission of the scene's file"},
    };
    memcpy(rows, table, sizeof table);
    scene_file_rows(settings, rows + sizeof table / sizeof *table);
    return rows;
}

/* -- header keys ------------------------------------------------------------------------------ */

/* How a light is written: its name, and which numbers in which order. */
static const struct light_form {
    const char *name;
    enum scene_light_kind kind;
    int count;
} light_forms[] = {{"sun", SCENE_SUN, 6}, {"point", SCENE_POINT, 6}, {"spot", SCENE_SPOT, 11}};

enum { FORM_COUNT = sizeof light_forms / sizeof *light_forms };

static void light_to_numbers(const struct scene_light *light, double *n)
{
    if (light->kind != SCENE_SUN) {
        vec3_store(n, light->position);
        n += 3;
    }
    if (light->kind != SCENE_POINT) {
        vec3_store(n, light->direction);
        n += 3;
    }
    if (light->kind == SCENE_SPOT) {
        *n++ = light->cos_inner;
        *n++ = light->cos_outer;
    }
    memcpy(n, light->intensity, sizeof light->intensity);
}

static struct scene_light light_from_numbers(enum scene_light_kind kind, const double *n)
{
    struct scene_light light = {.kind = kind};
    if (kind != SCENE_SUN) {
        light.position = vec3_load(n);
        n += 3;
    }
    if (kind != SCENE_POINT) {
        light.direction = vec3_load(n);
        n += 3;
    }
    if (kind == SCENE_SPOT) {
        light.cos_inner = *n++;
        light.cos_outer = *n++;
    }
    memcpy(light.intensity, n, sizeof light.intensity);
    return light;
}

/* The form of the light that a key like "spot-3" holds, or NULL. */
static const struct light_form *form_of_key(const char *key)
{
    for (int f = 0; f < FORM_COUNT; f++) {
        const size_t length = strlen(light_forms[f].name);
        if (!strncmp(key, light_forms[f].name, length) && key[length] == '-' &&
            key[length + 1] >= '1' && key[length + 1] <= '9' &&
            key[length + 1 + strspn(key + length + 1, "0123456789")] == 0)
            return &light_forms[f];
    }
    return NULL;
}

static const struct light_form *form_of_kind(enum scene_light_kind kind)
{
    int f = 0;
    while (light_forms[f].kind != kind)
        f++;
    return &light_forms[f];
}

static struct error *set_light(struct stream_header *header, const struct scene_light *light,
                               size_t number)
{
    const struct light_form *form = form_of_kind(light->kind);
    double numbers[HEADER_REALS_MOST];
    char name[32];
    snprintf(name, sizeof name, "%s-%zu", form->name, number);
    light_to_numbers(light, numbers);
    return header_set_reals(header, name, form->count, numbers);
}

struct error *scene_file_to_header(const struct scene_settings *settings,
                                   struct stream_header *header)
{
    header_remove_key(header, "lenient");
    struct error *err = scene_choice_to_header(&settings->choice, header);
    return !err && settings->lenient ? header_set_key(header, "lenient", lenient_names[true]) : err;
}

struct error *scene_file_from_header(struct scene_settings *settings,
                                     const struct stream_header *header)
{
    int lenient = settings->lenient;
    struct error *err = header_get_choice(header, "lenient", lenient_names, &lenient);
    settings->lenient = lenient;
    return err ? err : scene_choice_from_header(&settings->choice, header);
}

/* Keys of what is not the default alone. */
static struct error *sky_to_header(const struct scene_settings *s, struct stream_header *header)
{
    static const char *const names[] = {"sky-file", "sky-from-scene", "sky-key",  "sky-map",
                                        "sky-turn", "sky-up",         "sky-scale"};
    char number[32];
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        header_remove_key(header, names[k]);
    struct error *err = header_set_reals(header, "sky", 3, s->sky);
    if (!err && s->sky_file)
        err = header_set_key(header, "sky-file", s->sky_file);
    if (!err && s->sky_from_scene)
        err = header_set_key(header, "sky-from-scene", s->sky_from_scene);
    snprintf(number, sizeof number, "%016" PRIx64, s->sky_key);
    if (!err && s->sky_key)
        err = header_set_key(header, "sky-key", number);
    if (!err && s->sky_map != SCENE_SKY_AUTO)
        err = header_set_key(header, "sky-map", map_names[s->sky_map]);
    if (!err && !(s->sky_turn == 0))
        err = header_set_real(header, "sky-turn", s->sky_turn);
    if (!err && !(s->sky_up[1] == 1))
        err = header_set_reals(header, "sky-up", 3, s->sky_up);
    if (!err && !(s->sky_scale == 1))
        err = header_set_real(header, "sky-scale", s->sky_scale);
    return err;
}

static struct error *set_sky_names(struct scene_settings *settings, const char *file,
                                   const char *from_scene)
{
    settings->sky_file = strdup(file);
    settings->sky_from_scene = from_scene ? strdup(from_scene) : NULL;
    return settings->sky_file && !from_scene == !settings->sky_from_scene ? NULL : error_memory();
}

static struct error *sky_key_from_header(struct scene_settings *s,
                                         const struct stream_header *header)
{
    const char *text = header_key(header, "sky-key");
    if (!text)
        return NULL;
    if (strlen(text) != 16 || text[strspn(text, "0123456789abcdef")])
        return error_new("header key sky-key: expected 16 hexadecimal digits, got '%.40s'", text);
    s->sky_key = strtoull(text, NULL, 16);
    return NULL;
}

static struct error *sky_from_header(struct scene_settings *s, const struct stream_header *header)
{
    const char *file = header_key(header, "sky-file");
    struct error *err = header_get_reals(header, "sky", 3, 0, DBL_MAX, s->sky);
    if (!err)
        err = header_get_choice(header, "sky-map", map_names, &s->sky_map);
    if (!err)
        err = header_get_real(header, "sky-turn", -360, 360, &s->sky_turn);
    if (!err)
        err = header_get_reals(header, "sky-up", 3, -1, 1, s->sky_up);
    const struct vec3 up = vec3_load(s->sky_up);
    if (!err && !(fabs(vec3_dot(up, up) - 1) < 1e-9))
        err = error_new("header key sky-up: expected a direction of length 1");
    if (!err)
        err = header_get_real(header, "sky-scale", 0, DBL_MAX, &s->sky_scale);
    if (err || !file)
        return err;
    forget_sky(s);
    err = sky_key_from_header(s, header);
    return err ? err : set_sky_names(s, file, header_key(header, "sky-from-scene"));
}

struct error *scene_settings_found_sky(struct scene_settings *settings, const struct scene *scene)
{
    const struct scene_sky *sky = &scene->sky;
    if (!sky->file)
        return NULL;
    forget_sky(settings);
    settings->sky_key = sky->key;
    return set_sky_names(settings, sky->file, sky->from_scene);
}

struct error *scene_settings_to_header(const struct scene_settings *settings,
                                       struct stream_header *header)
{
    for (size_t k = header->key_count; k-- > 0;)
        if (form_of_key(header->keys[k].name))
            header_remove_key(header, header->keys[k].name);
    struct error *err = sky_to_header(settings, header);
    for (size_t i = 0; i < settings->light_count && !err; i++)
        err = set_light(header, &settings->lights[i], i + 1);
    if (!err)
        err = header_set_key(header, "emit", emit_names[settings->emit_front_only]);
    if (!err)
        err = header_set_real(header, "albedo-scale", settings->albedo_scale);
    if (!err)
        err = header_set_real(header, "max-albedo", settings->max_albedo);
    if (!err)
        err = header_set_real(header, "light-scale", settings->light_scale);
    return err ? err : scene_file_to_header(settings, header);
}

/* A wrong value is bad data here, not a wrong command line. */
static struct error *as_data(struct error *err)
{
    if (!err || err == error_memory())
        return err;
    struct error *data = error_new("%s", error_message(err));
    error_destroy(err);
    return data;
}

static struct error *get_light(struct scene_settings *settings, const struct stream_header *header,
                               const char *key, const struct light_form *form)
{
    double numbers[HEADER_REALS_MOST];
    struct error *err = header_get_reals(header, key, form->count, -DBL_MAX, DBL_MAX, numbers);
    if (err)
        return err;
    const struct scene_light light = light_from_numbers(form->kind, numbers);
    if (form->kind != SCENE_POINT && !(fabs(vec3_dot(light.direction, light.direction) - 1) < 1e-9))
        return error_new("header key %s: expected a direction of length 1", key);
    if (!(light.cos_outer <= light.cos_inner && light.cos_inner <= 1 && light.cos_outer >= -1))
        return error_new("header key %s: expected cosines -1 <= OUTER <= INNER <= 1", key);
    return error_wrap(as_data(add_light(settings, &light)), "header key %s", key);
}

/* What was turned is not what the scene makes. */
static struct error *check_unturned(const struct stream_header *header)
{
    const char *all = header_key(header, ROTATED_KEY),
               *light = header_key(header, ROTATED_LIGHT_KEY);
    if (all)
        return error_new("the probes were turned (key " ROTATED_KEY
                         "), and no scene fits them: take the stream from before probe-cat "
                         "--rotate, or turn it back");
    if (light)
        return error_new("the light of the probes was turned (key " ROTATED_LIGHT_KEY
                         "), and is not the scene's: take the stream from before probe-cat "
                         "--rotate-light, or turn it back");
    return NULL;
}

struct error *scene_settings_from_header(struct scene_settings *settings,
                                         const struct stream_header *header)
{
    int front = settings->emit_front_only;
    struct error *err = check_unturned(header);
    if (!err)
        err = sky_from_header(settings, header);
    if (!err)
        err = header_get_choice(header, "emit", emit_names, &front);
    if (!err)
        err = header_get_real(header, "albedo-scale", 0, DBL_MAX, &settings->albedo_scale);
    if (!err)
        err = header_get_real(header, "max-albedo", 0, 1, &settings->max_albedo);
    if (!err)
        err = header_get_real(header, "light-scale", 0, DBL_MAX, &settings->light_scale);
    if (!err)
        err = scene_file_from_header(settings, header);
    for (size_t k = 0; k < header->key_count && !err; k++) {
        const struct light_form *form = form_of_key(header->keys[k].name);
        if (form)
            err = get_light(settings, header, header->keys[k].name, form);
    }
    settings->emit_front_only = front;
    settings->inherited = settings->light_count;
    return err;
}

/* -- the keys of what light came from --------------------------------------------------------- */

void scene_key_text(const struct scene *scene, const char *before, char text[SCENE_KEY_ROOM])
{
    snprintf(text, SCENE_KEY_ROOM, "%016" PRIx64, scene_key(scene));
    if (!before || !scene->sky.picture || !strcmp(before, text))
        return;
    char with_sky[SCENE_KEY_ROOM];
    snprintf(with_sky, sizeof with_sky, "%016" PRIx64, scene_key_with_sky(scene));
    if (!strcmp(before, with_sky))
        memcpy(text, with_sky, sizeof with_sky);
}

bool scene_differs(const struct scene *scene, const struct stream_header *header)
{
    char key[SCENE_KEY_ROOM];
    const char *before = header_key(header, "scene-key");
    scene_key_text(scene, before, key);
    return before && strcmp(before, key);
}

bool scene_sky_differs(const struct scene *scene, const struct stream_header *header)
{
    char key[SCENE_KEY_ROOM];
    const char *before = header_key(header, "sky-key");
    snprintf(key, sizeof key, "%016" PRIx64, scene->sky.key);
    return before && scene->sky.picture && strcmp(before, key);
}
