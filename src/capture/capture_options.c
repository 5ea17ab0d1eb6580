/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_options.h"
#include "base/array.h"
#include "base/error.h"
#include "base/number.h"
#include "base/options.h"
#include "capture/senders.h"
#include "light/light_options.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct capture_options capture_options_default(void)
{
    struct capture_options o = {.capture = capture_settings_default(),
                                .order_loss = 0.01,
                                .slice = {.parts = 1},
                                .cache = cache_options_default(),
                                .scene = scene_settings_default(),
                                .links = 256,
                                .common = common_default()};
    o.capture.rays = 0;
    return o;
}

void capture_options_clear(struct capture_options *o)
{
    scene_settings_clear(&o->scene);
    capture_split_clear(&o->split);
    free(o->cache_held);
    o->cache_held = NULL;
}

/* What --columns may name. */
static const struct {
    const char *name;
    unsigned flag;
} columns_known[] = {{"sh_error", CAPTURE_ERROR},
                     {"irradiance_error", CAPTURE_ERROR},
                     {"validity", CAPTURE_VALIDITY},
                     {"depth", CAPTURE_DEPTH},
                     {"sky", CAPTURE_SKY},
                     {"sh_gradient", CAPTURE_GRADIENT},
                     {"visibility", CAPTURE_VISIBILITY},
                     {"ao", CAPTURE_AO},
                     {"bent_normal", CAPTURE_BENT_NORMAL},
                     {"bent_length", CAPTURE_BENT_LENGTH},
                     {"cone", CAPTURE_CONE},
                     {"ao_bounced", CAPTURE_AO_BOUNCED},
                     {"horizon", CAPTURE_HORIZON},
                     {"rays", CAPTURE_RAYS},
                     {"none", 0}};

/* "sh_error,depth" or "none". */
static struct error *parse_columns(void *value, const char *text)
{
    const size_t count = sizeof columns_known / sizeof *columns_known;
    unsigned columns = 0;
    for (const char *at = text;;) {
        const size_t length = strcspn(at, ",");
        size_t i = 0;
        while (i < count && (strlen(columns_known[i].name) != length ||
                             strncmp(columns_known[i].name, at, length)))
            i++;
        if (i == count)
            return error_usage("expected some of sh_error, irradiance_error, validity, depth, sky, "
                               "sh_gradient, visibility, ao, bent_normal, bent_length, cone, "
                               "ao_bounced, horizon, rays, separated by commas, or none, got '%s'",
                               text);
        columns |= columns_known[i].flag;
        if (!at[length])
            break;
        at += length + 1;
    }
    *(unsigned *)value = columns;
    return NULL;
}

/* "3" or "auto". */
static struct error *parse_order(void *value, const char *text)
{
    if (strcmp(text, "auto") && !(text[0] >= '1' && text[0] <= '0' + SH_ORDER_MAX && !text[1]))
        return error_usage("expected a whole number from 1 to %d, or auto, got '%s'", SH_ORDER_MAX,
                           text);
    struct capture_options *o = value;
    o->order_auto = text[0] == 'a';
    o->capture.order = o->order_auto ? SH_ORDER_MAX : text[0] - '0';
    return NULL;
}

static struct error *parse_content(void *value, const char *text)
{
    if (strcmp(text, "radiance") && strcmp(text, "irradiance"))
        return error_usage("expected one of radiance, irradiance, got '%s'", text);
    *(bool *)value = !strcmp(text, "irradiance");
    return NULL;
}

/* "sky:3", "suns:FILE", "points:STREAM", "surfaces:STREAM" or "off". */
static struct error *parse_transfer(void *value, const char *text)
{
    struct capture_options *o = value;
    if (!strncmp(text, "surfaces:", 9) && text[9]) {
        o->transfer_given = true;
        o->transfer_surfaces = text + 9;
        return NULL;
    }
    const bool sky = !strncmp(text, "sky:", 4), suns = !strncmp(text, "suns:", 5),
               points = !strncmp(text, "points:", 7);
    const char *what = text + (sky ? 4 : suns ? 5 : points ? 7 : 0);
    if (sky ? !(what[0] >= '1' && what[0] <= '5' && !what[1])
            : !((suns || points) && *what) && strcmp(text, "off") != 0)
        return error_usage("expected sky:N, N from 1 to 5, suns:FILE, points:STREAM, "
                           "surfaces:STREAM or off, got '%s'",
                           text);
    o->transfer_given = true;
    if (sky)
        o->transfer_sky = *what - '0';
    else if (points)
        o->transfer_points = what;
    else
        o->transfer_suns = suns ? what : NULL;
    if (!sky && !suns && !points) {
        o->transfer_sky = 0;
        o->transfer_points = NULL;
        o->transfer_surfaces = NULL;
    }
    return NULL;
}

/* "I/N", I from 1. */
static struct error *parse_slice(void *value, const char *text)
{
    struct capture_slice *slice = value;
    const char *end = text + strlen(text);
    int32_t part = 0, parts = 0;
    const char *at = number_read_i32(text, end, &part);
    at = at && at < end && *at == '/' ? number_read_i32(at + 1, end, &parts) : NULL;
    if (at != end || part < 1 || part > parts)
        return error_usage("expected I/N, whole numbers with 1 <= I <= N, got '%s'", text);
    slice->part = (size_t)part - 1;
    slice->parts = (size_t)parts;
    return NULL;
}

/* Rays of the first round where an error is asked for: a share of what it will take at the least,
 * and enough to meet what is bright and seldom seen. (Rounds of 128 that were to tell of 1 % took a
 * sun's patch in the distance for nothing.) */
static int first_round(const struct capture_settings *c)
{
    return (int)fmin(fmax(0.1 / (c->error * c->error), 128), c->rays_most);
}

/* Without light: what is of light alone must not be asked for; nor is what a header says of it. */
static struct error *check_unlit(struct capture_options *o)
{
    if (!o->columns_given)
        o->capture.columns = CAPTURE_AO;
    o->again = false; /* all that is captured is anew */
    if (o->capture.columns & CAPTURE_OF_LIGHT || !o->capture.columns)
        return error_usage(
            "--light none: expected --columns without sh_error, irradiance_error and "
            "sh_gradient, and some others");
    const char *of_light = o->order_auto       ? "--order auto"
                           : o->error_given    ? "--error"
                           : o->groups         ? "--groups"
                           : o->transfer_given ? "--transfer"
                                               : NULL;
    if (of_light)
        return error_usage("--light none: %s is of light", of_light);
    o->capture.error = 0;
    o->cache.name = NULL; /* the header's, too, whose light stays */
    o->capture.dering.target = DERING_NONE;
    return NULL;
}

struct error *capture_options_parse(struct capture_options *o, struct program *program, int argc,
                                    char **argv)
{
    static const char *const lights[] = {[CAPTURE_ALL] = "all",
                                         [CAPTURE_DIRECT] = "direct",
                                         [CAPTURE_INDIRECT] = "indirect",
                                         [CAPTURE_NONE] = "none",
                                         NULL};
    const struct option_row rows[] = {
        {.name = "order",
         .argument = "N|auto",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_order,
         .shown = "3",
         .help = "SH order: N * N coefficients a colour; auto: as few\nas --order-loss allows"},
        {.name = "order-loss",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &o->order_loss,
         .most = 1,
         .help = "share of irradiance that --order auto may lose"},
        {.name = "rays",
         .letter = 'r',
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->capture.rays,
         .given = &o->rays_given,
         .least = 1,
         .most = CAPTURE_RAYS_MOST,
         .shown = "512; with --error 0.1 / SHARE^2, at least 128",
         .help = "rays a probe; the error falls faster than the root of\ntheir number"},
        {.name = "error",
         .letter = 'e',
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &o->capture.error,
         .given = &o->error_given,
         .least_open = true,
         .most = 1,
         .shown = "none",
         .help = "after the first --rays, more of them until the standard\n"
                 "error of irradiance is below this share of it"},
        {.name = "error-floor",
         .argument = "E",
         .kind = OPTION_REAL,
         .value = &o->capture.error_floor,
         .most = (double)INFINITY,
         .help = "irradiance below which --error is a share of this"},
        {.name = "max-rays",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->capture.rays_most,
         .least = 1,
         .most = CAPTURE_RAYS_MOST,
         .help = "rays a probe that --error may spend"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->capture.bounces,
         .most = CAPTURE_BOUNCES_MOST,
         .help = "how often light may scatter on its way"},
        {.name = "light",
         .argument = "WHICH",
         .kind = OPTION_CHOICE,
         .choices = lights,
         .value = OPTION_ENUM(o->capture.light),
         .help = "capture all light, direct or indirect alone; none: the\n"
                 "--columns without light, by default ao"},
        {.name = "content",
         .argument = "WHAT",
         .kind = OPTION_CALL,
         .value = &o->capture.convolved,
         .parse = parse_content,
         .shown = "radiance",
         .help = "what the SH are of: incident radiance, or irradiance,\n"
                 "which is convolved with the cosine"},
        {0}};
    const struct option_row more[] = {
        {.name = "cache-out",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &o->cache_out,
         .written = true,
         .unrecorded = true,
         .help = "write the cache for other captures of the scene"},
        {.name = "columns",
         .argument = "LIST",
         .kind = OPTION_CALL,
         .value = &o->capture.columns,
         .given = &o->columns_given,
         .parse = parse_columns,
         .shown = "sh_error,validity,depth,sky",
         .help = "what to write beside light: of these, sh_gradient,\n"
                 "visibility, ao, bent_normal, bent_length, cone, ao_bounced,\n"
                 "horizon, rays; none: nothing"},
        {.name = "groups",
         .argument = "FILE|each",
         .kind = OPTION_TEXT,
         .value = &o->groups,
         .shown = "off",
         .help = "light of each group of lights in columns of its own: groups\n"
                 "that FILE names, or each light and emissive material"},
        {.name = "transfer",
         .argument = "sky:N|suns:FILE|points:STREAM|surfaces:STREAM",
         .kind = OPTION_CALL,
         .value = o,
         .parse = parse_transfer,
         .shown = "off",
         .help = "the response to light that may be: to each of the N * N SH\n"
                 "functions of a sky, to suns of the directions in FILE, to\n"
                 "point lights at the positions of STREAM, or to what the\n"
                 "surface probes of STREAM scatter; may repeat"},
        {.name = "links",
         .argument = "K",
         .kind = OPTION_INT,
         .value = &o->links,
         .given = &o->links_given,
         .least = 1,
         .most = SENDER_LINKS_MOST,
         .help = "of --transfer surfaces: clusters of them that a probe has\n"
                 "links to, at the most"},
        {.name = "dry-run",
         .kind = OPTION_FLAG,
         .value = &o->dry_run,
         .unrecorded = true,
         .help = "say what a probe and the stream would take, and stop"},
        {.name = "ao-distance",
         .argument = "D",
         .kind = OPTION_REAL,
         .value = &o->capture.ao_distance,
         .least_open = true,
         .most = (double)INFINITY,
         .shown = "none",
         .help = "surfaces beyond do not occlude, for ao and the like"},
        {.name = "ao-falloff",
         .argument = "FORM",
         .kind = OPTION_CHOICE,
         .choices = occlusion_falloff_names,
         .value = OPTION_ENUM(o->capture.ao_falloff),
         .help = "how a surface occludes less up to there: step, linear, sqrt\n"
                 "or exp"},
        {.name = "azimuths",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->capture.azimuths,
         .least = 1,
         .most = OCCLUSION_AZIMUTHS_MOST,
         .help = "directions of the horizon"},
        {.name = "decimate",
         .argument = "SHARE",
         .kind = OPTION_REAL,
         .value = &o->capture.decimate,
         .least_open = true,
         .most = 1,
         .help = "trace in a scene of this share of the triangles: those\n"
                 "that change its surface least are taken away"},
        {.name = "again",
         .kind = OPTION_FLAG,
         .value = &o->again,
         .help = "capture all probes, not only those that have no light yet"},
        {.name = "slice",
         .argument = "I/N",
         .kind = OPTION_CALL,
         .value = &o->slice,
         .parse = parse_slice,
         .shown = "1/1",
         .help = "capture the I-th of N parts of the probes: every N-th from\n"
                 "the I-th on (probe-cat --fill puts slices together)"},
        {0}};
    struct option_row dering[LIGHT_DERING_ROWS], cache[CACHE_OPTION_ROWS],
        scene[SCENE_SETTINGS_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows,
        light_dering_rows(&o->capture.dering, dering),
        cache_option_rows(&o->cache, cache),
        more,
        scene_settings_rows(&o->scene, scene),
        common_rows(&o->common, COMMON_STREAM | COMMON_THREADS | COMMON_SEED | COMMON_PROGRESS,
                    shared),
        NULL};
    option_row(shared, "seed")->value = &o->capture.seed; /* below 2^53: signed or not is one */
    struct error *err = options_parse(program, groups, argc, argv);
    if (!o->capture.rays)
        o->capture.rays = o->capture.error > 0 ? first_round(&o->capture)
                                               : capture_settings_default().rays;
    if (!err && o->order_auto && o->slice.parts > 1)
        err = error_usage(
            "--slice needs a fixed --order: with auto every slice would choose its own");
    if (!err)
        err = cache_options_check(&o->cache);
    if (!err && o->transfer_surfaces && o->order_auto)
        err = error_usage("--transfer surfaces needs a fixed --order");
    if (!err && o->capture.light == CAPTURE_NONE)
        err = check_unlit(o);
    if (!err && o->capture.ao_falloff != OCCLUSION_STEP &&
        !(o->capture.ao_distance < (double)INFINITY))
        err = error_usage("--ao-falloff %s needs --ao-distance",
                          occlusion_falloff_names[o->capture.ao_falloff]);
    if (!err && o->links_given && !o->transfer_surfaces)
        err = error_usage("--links needs --transfer surfaces:STREAM");
    if (!err && o->cache_out && !strcmp(o->cache_out, "-"))
        err = error_usage("--cache-out: expected a file's name, got '-'");
    if (!err && o->cache_out && !o->cache.name)
        err = error_usage("--cache-out needs --cache");
    if (!err)
        err = light_dering_check(&o->capture.dering);
    if (!err && o->order_auto && o->capture.convolved &&
        o->capture.dering.target == DERING_RADIANCE)
        err = error_usage("--order auto de-rings after its choice, when --content irradiance has "
                          "left no radiance: --order N does both");
    return err;
}

static struct error *take_cache(struct capture_options *o, const struct stream_header *header)
{
    struct error *err = cache_options_from_header(&o->cache, header);
    if (err || !o->cache.name)
        return err;
    err = array_create(&o->cache_held, strlen(o->cache.name) + 1, 1);
    if (!err)
        o->cache.name = strcpy(o->cache_held, o->cache.name);
    return err;
}

/* Reads the command line over the header's settings. */
static struct error *read_over(struct capture_options *o, struct program *program,
                               const struct stream_header *header, bool again, int argc,
                               char **argv)
{
    const bool other_rays = again && (o->rays_given || o->error_given);
    capture_options_clear(o);
    program_clear(program);
    *o = capture_options_default();
    const struct capture_settings usual = o->capture;
    struct error *err = scene_settings_from_header(&o->scene, header);
    if (!err)
        err = capture_settings_from_header(&o->capture, header);
    if (!err)
        err = take_cache(o, header);
    if (!err)
        err = capture_split_from_header(&o->split, header);
    if (other_rays) {
        o->capture.rays = usual.rays;
        o->capture.rays_most = usual.rays_most;
        o->capture.error = usual.error;
        o->capture.error_floor = usual.error_floor;
    }
    return err ? err : capture_options_parse(o, program, argc, argv);
}

/* Whether what is asked for is not what the header's probes have. */
static bool asks_otherwise(const struct capture_options *o, const struct stream_header *header)
{
    struct stream_header now = {0};
    struct error *err = header_copy(&now, header);
    if (!err)
        err = capture_settings_to_header(&o->capture, &now);
    if (!err)
        err = cache_options_to_header(&o->cache, &now);
    if (!err)
        err = capture_check_same(header, &now);
    const bool other = err || o->order_auto || o->groups || o->transfer_given ||
                       o->capture.columns & ~(unsigned)CAPTURE_DEFAULT;
    error_destroy(err);
    header_clear(&now);
    return other;
}

/* What the command line says of parts of light takes the place of the header's. */
static struct error *read_split(struct capture_options *o)
{
    if (o->capture.light == CAPTURE_NONE) {
        capture_split_clear(&o->split);
        return NULL;
    }
    struct error *err = o->groups ? capture_split_read_groups(&o->split, o->groups) : NULL;
    if (o->transfer_given) {
        o->split.sky_order = o->transfer_sky;
        o->split.sun_count = 0;
        o->split.point_count = 0;
    }
    if (!err && o->transfer_suns)
        err = capture_split_read_suns(&o->split, o->transfer_suns, &o->scene);
    if (!err && o->transfer_points)
        err = capture_split_read_points(&o->split, o->transfer_points);
    const bool groups = o->split.groups.count || o->split.groups.each;
    if (!err && o->cache.name &&
        (groups || o->split.sky_order || o->split.sun_count || o->split.point_count))
        err = error_usage("%s needs --cache off: a cache keeps the light of all lights in one",
                          groups ? "--groups" : "--transfer");
    return err;
}

/* Takes over what the header says, but for parts of light. */
static struct error *take_over(struct capture_options *o, struct program *program,
                               const struct stream_header *header, int argc, char **argv)
{
    const bool again = o->again;
    if (!capture_header_has_settings(header) && !header_key(header, "capture-ao-distance") &&
        !header_key(header, "capture-azimuths"))
        return scene_file_from_header(&o->scene, header);
    struct error *err = read_over(o, program, header, again, argc, argv);
    if (err || again || o->capture.light == CAPTURE_NONE || !header_key(header, CAPTURE_BY_KEY) ||
        !asks_otherwise(o, header))
        return err;
    err = read_over(o, program, header, true, argc, argv);
    o->again = true;
    return err;
}

struct error *capture_options_take_over(struct capture_options *o, struct program *program,
                                        const struct stream_header *header, int argc, char **argv)
{
    struct error *err = take_over(o, program, header, argc, argv);
    if (!err)
        err = cache_options_check_renew(&o->cache);
    return err ? err : read_split(o);
}
