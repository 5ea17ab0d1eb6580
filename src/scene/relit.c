/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/relit.h"
#include "base/array.h"
#include "base/error.h"
#include "base/number.h"
#include "libprobe-query/sh.h"
#include "math/hash.h"
#include "scene/groups.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "scene/scene_sky.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KEY_ROOM = 64 };

static const char prefix[] = "relit-", weight_prefix[] = "weight-";

static bool starts(const char *name, const char *with)
{
    return !strncmp(name, with, strlen(with));
}

bool relit_is(const struct stream_header *header)
{
    for (size_t k = 0; k < header->key_count; k++)
        if (starts(header->keys[k].name, prefix) || starts(header->keys[k].name, weight_prefix))
            return true;
    return false;
}

void relit_remove(struct stream_header *header)
{
    for (size_t k = header->key_count; k-- > 0;)
        if (starts(header->keys[k].name, prefix) || starts(header->keys[k].name, weight_prefix))
            header_remove_key(header, header->keys[k].name);
}

/* -- written ---------------------------------------------------------------------------------- */

/* Takes over the keys of `from` that begin so, as relit-KEY. */
static struct error *take_keys(const struct stream_header *from, const char *beginning,
                               struct stream_header *header)
{
    struct error *err = NULL;
    for (size_t k = 0; k < from->key_count && !err; k++) {
        char name[KEY_ROOM];
        if (!starts(from->keys[k].name, beginning))
            continue;
        snprintf(name, sizeof name, "%s%s", prefix, from->keys[k].name);
        err = header_set_key(header, name, from->keys[k].value);
    }
    return err;
}

struct error *relit_weights_to_header(const struct light_groups *groups, const double *weight,
                                      struct stream_header *header)
{
    struct stream_header keys = {0};
    struct error *err = groups->count ? groups_to_header(groups, &keys)
                                      : header_set_key(&keys, "group-1", "rest");
    if (!err)
        err = take_keys(&keys, "group-", header);
    for (size_t g = 0; g < (groups->count ? groups->count : 1) && !err; g++) {
        char key[KEY_ROOM];
        snprintf(key, sizeof key, "%s%zu", weight_prefix, g + 1);
        err = header_set_reals(header, key, 3, weight + 3 * g);
    }
    header_clear(&keys);
    return err;
}

struct error *relit_light_to_header(const struct scene_settings *light, bool sky,
                                    struct stream_header *header)
{
    struct stream_header keys = {0};
    struct error *err = scene_settings_to_header(light, &keys);
    if (!err && sky)
        err = take_keys(&keys, "sky", header);
    if (!err)
        err = take_keys(&keys, "sun-", header);
    if (!err)
        err = take_keys(&keys, "point-", header);
    header_clear(&keys);
    return err;
}

struct error *relit_sky_sh_to_header(int order, const double *sh, struct stream_header *header)
{
    char text[3 * SH_COUNT_MAX * (NUMBER_ROOM + 1)], *at = text;
    for (int i = 0; i < 3 * order * order; i++) {
        at = number_write_f64(at, sh[i]);
        *at++ = ',';
    }
    at[-1] = 0;
    return header_set_key(header, RELIT_SKY_SH_KEY, text);
}

/* -- read ------------------------------------------------------------------------------------- */

/* The keys relit-NAME as keys NAME. */
static struct error *bare_keys(const struct stream_header *header, struct stream_header *keys)
{
    struct error *err = NULL;
    for (size_t k = 0; k < header->key_count && !err; k++)
        if (starts(header->keys[k].name, prefix))
            err =
                header_set_key(keys, header->keys[k].name + strlen(prefix), header->keys[k].value);
    return err;
}

static struct error *read_weights(const struct stream_header *header, size_t groups, double *weight)
{
    struct error *err = NULL;
    for (size_t g = 0; g < groups && !err; g++) {
        char key[KEY_ROOM];
        snprintf(key, sizeof key, "%s%zu", weight_prefix, g + 1);
        err = header_require(header, key);
        if (!err)
            err = header_get_reals(header, key, 3, -DBL_MAX, DBL_MAX, weight + 3 * g);
        for (int c = 0; c < 3 && !err; c++)
            if (weight[3 * g + (size_t)c] < 0)
                err = error_new("the stream was relit with light below 0 (key %s), which cannot "
                                "be traced",
                                key);
    }
    return err;
}

/* Lights of the command line took the place of those of the header. */
static bool gives_lights(const struct scene_settings *settings)
{
    return settings->light_count && !settings->inherited;
}

static struct error *weigh(struct scene *scene, const struct scene_settings *settings,
                           const struct stream_header *header, const struct stream_header *bare)
{
    struct light_groups groups = {0};
    struct group_map map = {0};
    double *weight = NULL;
    struct error *err = groups_from_header(&groups, bare);
    const size_t count = groups.count;
    if (!err && !count)
        err = header_require(header, "relit-group-1");
    /* lights of the command line may be left for one more group, which stays as it is */
    if (!err)
        err = array_create(&weight, 3 * (count + 1), sizeof *weight);
    for (size_t c = 0; c < 3 && !err; c++)
        weight[3 * count + c] = 1;
    if (!err)
        err = read_weights(header, groups.count, weight);
    if (!err)
        err = groups_resolve(
            &groups, scene,
            &(struct groups_way){.added = settings->light_count,
                                 .lenient = gives_lights(settings) || settings->sky_given},
            &map);
    if (!err)
        err = groups_scale(scene, &map, weight, GROUPS_ADDED);
    group_map_clear(&map);
    groups_clear(&groups);
    free(weight);
    return err;
}

static struct error *replace_sky(struct scene *scene, const struct scene_settings *light,
                                 struct warnings *warnings)
{
    scene_sky_clear(&scene->sky);
    return scene_sky_finish(&scene->sky, scene->path, light, warnings);
}

struct error *relit_scene(struct scene *scene, const struct scene_settings *settings,
                          const struct stream_header *header, struct warnings *warnings)
{
    struct scene_settings light = scene_settings_default();
    if (!relit_is(header))
        return NULL;
    if (header_key(header, RELIT_SKY_SH_KEY) && !settings->sky_given)
        return error_new("the stream was relit with the SH of a sky (key " RELIT_SKY_SH_KEY
                         "), which no scene has");
    struct stream_header bare = {0};
    scene_keep_keys(scene);
    struct error *err = bare_keys(header, &bare);
    if (!err)
        err = weigh(scene, settings, header, &bare);
    if (!err)
        err = error_wrap(scene_settings_from_header(&light, &bare), "keys relit-*");
    if (!err && header_key(header, "relit-sky") && !settings->sky_given)
        err = replace_sky(scene, &light, warnings);
    for (size_t i = 0; i < light.light_count && !err && !gives_lights(settings); i++)
        err = scene_push_light(scene, light.lights[i]);
    scene_settings_clear(&light);
    header_clear(&bare);
    return err;
}

void relit_key(const struct stream_header *header, char text[RELIT_KEY_ROOM])
{
    struct hash hash;
    hash_start(&hash, 0);
    for (size_t k = 0; k < header->key_count; k++) {
        const struct key *key = &header->keys[k];
        if (starts(key->name, prefix) || starts(key->name, weight_prefix)) {
            hash_add(&hash, key->name, strlen(key->name) + 1);
            hash_add(&hash, key->value, strlen(key->value) + 1);
        }
    }
    const uint64_t value = hash_value(&hash);
    *text = 0;
    if (relit_is(header))
        snprintf(text, RELIT_KEY_ROOM, "%016" PRIx64, value);
}
