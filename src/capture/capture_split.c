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
    free(split->point);
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

/* Adds a point; two in one place have no weights between them. */
static struct error *add_point(struct capture_split *split, const double p[3])
{
    if (split->point_count == CAPTURE_POINTS_MOST)
        return error_new("more than %d points", (int)CAPTURE_POINTS_MOST);
    for (size_t i = 0; i < split->point_count; i++)
        if (!memcmp(split->point + 3 * i, p, 3 * sizeof *p))
            return error_new("expected each in a place of its own, got two at %g %g %g", p[0], p[1],
                             p[2]);
    struct error *err = array_reserve(&split->point, &split->point_capacity,
                                      3 * (split->point_count + 1), sizeof *split->point);
    if (!err)
        memcpy(split->point + 3 * split->point_count++, p, 3 * sizeof *p);
    return err;
}

struct error *capture_split_read_points(struct capture_split *split, const char *points)
{
    struct stream *stream = NULL;
    struct column *position = NULL;
    split->point_count = 0;
    struct error *err = stream_read(&stream, points);
    if (err)
        return err;
    const struct table *probes = stream_table(stream, "probe");
    if (!probes || !probes->rows)
        err = error_new("expected point lights, a probe each, got none");
    if (!err)
        err = table_require(probes, "position", COLUMN_F64, 3, &position);
    for (size_t i = 0; !err && i < probes->rows; i++)
        err = add_point(split, column_f64(position) + 3 * i);
    stream_destroy(stream);
    return error_wrap(err, "%s", file_input_name(points));
}

/* -- header ------------------------------------------------------------------------------------ */

static const char sun_key[] = "transfer-sun-", point_key[] = "transfer-point-";

/* Keys PREFIX1, PREFIX2 ... of three numbers each, in the place of those that are there. */
static struct error *triples_to_header(struct stream_header *header, const char *prefix,
                                       const double *triple, size_t count)
{
    struct error *err = NULL;
    for (size_t k = header->key_count; k-- > 0;)
        if (!strncmp(header->keys[k].name, prefix, strlen(prefix)))
            header_remove_key(header, header->keys[k].name);
    for (size_t i = 0; i < count && !err; i++) {
        char key[40];
        snprintf(key, sizeof key, "%s%zu", prefix, i + 1);
        err = header_set_reals(header, key, 3, triple + 3 * i);
    }
    return err;
}

struct error *capture_split_to_header(const struct capture_split *split,
                                      struct stream_header *header)
{
    header_remove_key(header, "transfer-sky");
    struct error *err = groups_to_header(&split->groups, header);
    if (!err && split->sky_order)
        err = header_set_whole(header, "transfer-sky", split->sky_order);
    if (!err)
        err = triples_to_header(header, sun_key, split->sun, split->sun_count);
    return err ? err : triples_to_header(header, point_key, split->point, split->point_count);
}

/* Reads the next key of a list, the number-th from 1; *there false: there is none. */
static struct error *next_triple(const struct stream_header *header, const char *prefix,
                                 size_t number, double most, double value[3], bool *there)
{
    char key[40];
    snprintf(key, sizeof key, "%s%zu", prefix, number);
    *there = header_key(header, key) != NULL;
    struct error *err = *there ? header_get_reals(header, key, 3, -most, most, value) : NULL;
    const double *v = value;
    if (*there && !err && most <= 1 && !(fabs(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1) < 1e-9))
        err = error_new("header key %s: expected a direction of length 1", key);
    return err;
}

struct error *capture_split_from_header(struct capture_split *split,
                                        const struct stream_header *header)
{
    capture_split_clear(split);
    struct error *err = groups_from_header(&split->groups, header);
    double value[3];
    bool there = true;
    if (!err)
        err = header_get_int(header, "transfer-sky", 1, SH_ORDER_MAX, &split->sky_order);
    while (!err && there) {
        err = next_triple(header, sun_key, split->sun_count + 1, 1, value, &there);
        if (!err && there)
            err = array_reserve(&split->sun, &split->sun_capacity, 3 * (split->sun_count + 1),
                                sizeof *split->sun);
        if (!err && there)
            memcpy(split->sun + 3 * split->sun_count++, value, sizeof value);
    }
    for (there = true; !err && there;) {
        err = next_triple(header, point_key, split->point_count + 1, DBL_MAX, value, &there);
        if (!err && there)
            err = add_point(split, value);
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
                                  .sun_count = split->sun_count,
                                  .point = split->point,
                                  .point_count = split->point_count};
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
    const struct {
        const char *name;
        size_t first, end;
    } transfer[] = {{"sky", groups, split_suns(s)},
                    {"suns", split_suns(s), split_points(s)},
                    {"points", split_points(s), split_count(s)}};
    size_t next = groups;
    for (size_t t = 0; t < sizeof transfer / sizeof *transfer; t++) {
        if (transfer[t].end == transfer[t].first || next++ != i)
            continue;
        *column = (struct split_column){.first = transfer[t].first,
                                        .count = transfer[t].end - transfer[t].first};
        snprintf(column->name, sizeof column->name, "transfer_%s%s", transfer[t].name,
                 error ? "_error" : "");
        return true;
    }
    return false;
}
