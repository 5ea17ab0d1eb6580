/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_split.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "libprobe-query/sh.h"
#include "scene/scene_settings.h"
#include "scene/scene_sky.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"
#include "trace/path.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void capture_split_clear(struct capture_split *split)
{
    groups_clear(&split->groups);
    group_map_clear(&split->map);
    free(split->sun);
    *split = (struct capture_split){0};
}

/* -- what is asked for ------------------------------------------------------------------------- */

struct error *capture_split_read_groups(struct capture_split *split, const char *groups)
{
    groups_clear(&split->groups);
    return strcmp(groups, "off") ? groups_read(&split->groups, groups) : NULL;
}

static struct error *add_sun(struct capture_split *split, struct vec3 to)
{
    const double size = fmax(fmax(fabs(to.x), fabs(to.y)), fabs(to.z));
    if (!(size > 0))
        return error_new("expected a direction, got 0 0 0");
    if (split->sun_count == CAPTURE_SUNS_MOST)
        return error_new("more than %d suns", (int)CAPTURE_SUNS_MOST);
    struct error *err = array_reserve(&split->sun, &split->sun_capacity, 3 * (split->sun_count + 1),
                                      sizeof *split->sun);
    if (!err)
        vec3_store(split->sun + 3 * split->sun_count++,
                   vec3_normalize((struct vec3){to.x / size, to.y / size, to.z / size}));
    return err;
}

static struct error *take_sun(struct capture_split *split, const char *line, const char *end,
                              const struct scene_settings *settings)
{
    double n[3];
    int count = 0;
    const char *at = line + strspn(line, " \t\r,");
    if (at >= end || *at == '#')
        return NULL;
    while (at < end && *at != '#') {
        at = count < 3 ? number_read_f64(at, end, &n[count]) : NULL;
        if (!at || !isfinite(n[count]) || (at < end && !strchr(" \t\r,#", *at)))
            return error_new("expected X Y Z towards a sun, or AZIMUTH ELEVATION in degrees, got "
                             "'%.*s'",
                             (int)(end - line), line);
        count++;
        at += strspn(at, " \t\r,");
    }
    if (count < 2)
        return error_new("expected 3 numbers towards a sun, or 2 angles, got 1");
    if (count == 2 && !(fabs(n[0]) <= 360 && fabs(n[1]) <= 90))
        return error_new("expected an azimuth of -360 to 360 and an elevation of -90 to 90 "
                         "degrees, got %g %g",
                         n[0], n[1]);
    return add_sun(split,
                   count == 3 ? vec3_load(n) : scene_sky_direction(settings->sky_up, n[0], n[1]));
}

struct error *capture_split_read_suns(struct capture_split *split, const char *suns,
                                      const struct scene_settings *settings)
{
    struct file_input in;
    split->sun_count = 0;
    struct error *err = file_input_open(&in, suns);
    if (err)
        return err;
    for (bool more = true; more && !err;) {
        const char *line;
        size_t length, bytes;
        err = file_input_line(&in, &line, &length, &bytes);
        more = !err && line;
        if (!more)
            break;
        char *text = strndup(line, length);
        err = text ? take_sun(split, text, text + strlen(text), settings) : error_memory();
        free(text);
        in.line++;
        file_input_consume(&in, bytes);
        err = error_wrap(err, "%s:%zu", in.name, in.line);
    }
    if (!err && !split->sun_count)
        err = error_new("%s: expected suns, a direction a line, got none", in.name);
    file_input_close(&in);
    return err;
}

/* -- header ------------------------------------------------------------------------------------ */

static const char sun_key[] = "transfer-sun-";

static bool is_sun_key(const char *name)
{
    return !strncmp(name, sun_key, sizeof sun_key - 1);
}

struct error *capture_split_to_header(const struct capture_split *split,
                                      struct stream_header *header)
{
    for (size_t k = header->key_count; k-- > 0;)
        if (is_sun_key(header->keys[k].name))
            header_remove_key(header, header->keys[k].name);
    header_remove_key(header, "transfer-sky");
    struct error *err = groups_to_header(&split->groups, header);
    if (!err && split->sky_order)
        err = header_set_whole(header, "transfer-sky", split->sky_order);
    for (size_t s = 0; s < split->sun_count && !err; s++) {
        char key[40];
        snprintf(key, sizeof key, "%s%zu", sun_key, s + 1);
        err = header_set_reals(header, key, 3, split->sun + 3 * s);
    }
    return err;
}

struct error *capture_split_from_header(struct capture_split *split,
                                        const struct stream_header *header)
{
    capture_split_clear(split);
    struct error *err = groups_from_header(&split->groups, header);
    if (!err)
        err = header_get_int(header, "transfer-sky", 1, SH_ORDER_MAX, &split->sky_order);
    for (size_t s = 1; !err; s++) {
        char key[40];
        double to[3];
        snprintf(key, sizeof key, "%s%zu", sun_key, s);
        if (!header_key(header, key))
            break;
        err = header_get_reals(header, key, 3, -1, 1, to);
        if (!err && !(fabs(to[0] * to[0] + to[1] * to[1] + to[2] * to[2] - 1) < 1e-9))
            err = error_new("header key %s: expected a direction of length 1", key);
        if (!err)
            err = array_reserve(&split->sun, &split->sun_capacity, 3 * s, sizeof *split->sun);
        if (!err)
            memcpy(split->sun + 3 * split->sun_count++, to, sizeof to);
    }
    return err;
}

struct error *capture_split_check_same(const struct stream_header *before,
                                       const struct stream_header *now)
{
    const struct stream_header *const both[] = {before, now};
    for (int turn = 0; turn < 2; turn++)
        for (size_t k = 0; k < both[turn]->key_count; k++) {
            const char *name = both[turn]->keys[k].name, *was = header_key(before, name),
                       *is = header_key(now, name);
            if (!light_key_is_split(name) || (was && is && !strcmp(was, is)))
                continue;
            return error_new("the probes were captured with %s %s, not %s", name,
                             was ? was : "none", is ? is : "none");
        }
    return NULL;
}

/* -- parts ------------------------------------------------------------------------------------- */

struct error *capture_split_open(struct capture_split *split, const struct scene *scene,
                                 const struct groups_way *way, struct path_tracer *path)
{
    const bool groups = split->groups.count || split->groups.each;
    group_map_clear(&split->map);
    split->split = (struct split){0};
    path_use_split(path, NULL);
    struct error *err = groups ? groups_resolve(&split->groups, scene, way, &split->map) : NULL;
    if (err)
        return err;
    split->split = (struct split){.groups = groups ? &split->map : NULL,
                                  .sky_order = split->sky_order,
                                  .sun = split->sun,
                                  .sun_count = split->sun_count};
    if (capture_split_count(split))
        path_use_split(path, &split->split);
    return NULL;
}

size_t capture_split_count(const struct capture_split *split)
{
    return split ? split_count(&split->split) : 0;
}

bool capture_split_column(const struct capture_split *split, size_t i, bool surface, bool error,
                          struct split_column *column)
{
    const struct split *s = &split->split;
    const char *light = surface ? "irradiance" : "sh";
    const size_t groups = split_sky(s);
    if (i < groups) {
        *column = (struct split_column){.first = i, .count = 1};
        snprintf(column->name, sizeof column->name, "%s%s_%s", light, error ? "_error" : "",
                 split->groups.list[i].name);
        return true;
    }
    const bool sky = s->sky_order && i == groups;
    if (!sky && !(s->sun_count && i == groups + (s->sky_order ? 1 : 0)))
        return false;
    const size_t first = sky ? groups : split_suns(s), end = sky ? split_suns(s) : split_count(s);
    *column = (struct split_column){.first = first, .count = end - first};
    snprintf(column->name, sizeof column->name, "transfer_%s%s", sky ? "sky" : "suns",
             error ? "_error" : "");
    return true;
}
