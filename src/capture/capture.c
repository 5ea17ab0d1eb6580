/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture.h"
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/progress.h"
#include "base/threads.h"
#include "capture/cache_options.h"
#include "capture/capture_split.h"
#include "capture/senders.h"
#include "light/blend.h"
#include "light/basis.h"
#include "light/content.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const capture_light_names[] = {
    [CAPTURE_ALL] = "all", [CAPTURE_DIRECT] = "direct", [CAPTURE_INDIRECT] = "indirect", NULL};

struct capture_settings capture_settings_default(void)
{
    return (struct capture_settings){.order = 3,
                                     .rays = 512,
                                     .rays_most = 65536,
                                     .bounces = 64,
                                     .decimate = 1,
                                     .ao_distance = (double)INFINITY,
                                     .azimuths = OCCLUSION_AZIMUTHS,
                                     .columns = CAPTURE_DEFAULT};
}

/* -- header ----------------------------------------------------------------------------------- */

/* What occlusion columns depend on. */
static struct error *occlusion_to_header(const struct capture_settings *settings,
                                         struct stream_header *header)
{
    struct error *err = NULL;
    header_remove_key(header, "capture-ao-distance");
    header_remove_key(header, "capture-ao-falloff");
    if (settings->ao_distance < (double)INFINITY)
        err = header_set_real(header, "capture-ao-distance", settings->ao_distance);
    if (!err && settings->ao_falloff != OCCLUSION_STEP)
        err = header_set_key(header, "capture-ao-falloff",
                             occlusion_falloff_names[settings->ao_falloff]);
    header_remove_key(header, "capture-azimuths");
    if (!err && settings->azimuths != OCCLUSION_AZIMUTHS)
        err = header_set_whole(header, "capture-azimuths", settings->azimuths);
    return err;
}

struct error *capture_settings_to_header(const struct capture_settings *settings,
                                         struct stream_header *header)
{
    static const char *const optional[] = {"capture-error", "capture-error-floor",
                                           "capture-max-rays", "capture-decimate"};
    for (size_t i = 0; i < sizeof optional / sizeof *optional; i++)
        header_remove_key(header, optional[i]);
    struct error *err = header_set_whole(header, "sh-order", settings->order);
    if (!err)
        err = content_to_header(header, settings->convolved);
    if (!err)
        err = dering_to_header(&settings->dering, header);
    if (!err)
        err = header_set_key(header, "capture-light", capture_light_names[settings->light]);
    if (!err)
        err = header_set_whole(header, "capture-rays", settings->rays);
    if (!err && settings->error > 0) {
        err = header_set_real(header, "capture-error", settings->error);
        if (!err)
            err = header_set_real(header, "capture-error-floor", settings->error_floor);
        if (!err)
            err = header_set_whole(header, "capture-max-rays", settings->rays_most);
    }
    if (!err)
        err = occlusion_to_header(settings, header);
    if (!err && settings->decimate < 1)
        err = header_set_real(header, "capture-decimate", settings->decimate);
    if (!err)
        err = header_set_whole(header, "capture-bounces", settings->bounces);
    if (!err)
        err = header_set_whole(header, "capture-seed", (int64_t)settings->seed);
    return err;
}

struct error *capture_settings_from_header(struct capture_settings *settings,
                                           const struct stream_header *header)
{
    int light = (int)settings->light, falloff = (int)settings->ao_falloff;
    int64_t seed = (int64_t)settings->seed;
    struct error *err = header_get_int(header, "sh-order", 1, SH_ORDER_MAX, &settings->order);
    if (!err)
        err = header_get_int(header, "capture-rays", 1, CAPTURE_RAYS_MOST, &settings->rays);
    if (!err)
        err =
            header_get_int(header, "capture-max-rays", 1, CAPTURE_RAYS_MOST, &settings->rays_most);
    if (!err)
        err =
            header_get_int(header, "capture-bounces", 0, CAPTURE_BOUNCES_MOST, &settings->bounces);
    if (!err)
        err = header_get_whole(header, "capture-seed", 0, (int64_t)1 << 53, &seed);
    if (!err)
        err = header_get_real(header, "capture-error", 0, DBL_MAX, &settings->error);
    if (!err)
        err = header_get_real(header, "capture-error-floor", 0, DBL_MAX, &settings->error_floor);
    if (!err)
        err = header_get_real(header, "capture-ao-distance", 0, DBL_MAX, &settings->ao_distance);
    if (!err)
        err = header_get_choice(header, "capture-ao-falloff", occlusion_falloff_names, &falloff);
    if (!err)
        err = header_get_int(header, "capture-azimuths", 1, OCCLUSION_AZIMUTHS_MOST,
                             &settings->azimuths);
    if (!err)
        err = header_get_real(header, "capture-decimate", 0, DBL_MAX, &settings->decimate);
    if (!err && !(settings->decimate > 0 && settings->decimate <= 1))
        err = error_new(
            "header key capture-decimate: expected a share above 0 and at most 1, got '%s'",
            header_key(header, "capture-decimate"));
    if (!err)
        err = header_get_choice(header, "capture-light", capture_light_names, &light);
    if (!err)
        err = content_from_header(header, &settings->convolved);
    if (!err)
        err = dering_from_header(&settings->dering, header);
    settings->light = (enum capture_light)light;
    settings->ao_falloff = (enum occlusion_falloff)falloff;
    settings->seed = (uint64_t)seed;
    return err;
}

bool capture_header_has_settings(const struct stream_header *header)
{
    return header_key(header, "capture-rays");
}

struct error *capture_check_same(const struct stream_header *before,
                                 const struct stream_header *now)
{
    static const char *const keys[] = {"sh-order",
                                       "sh-content",
                                       "sh-dering",
                                       "capture-light",
                                       "capture-rays",
                                       "capture-error",
                                       "capture-error-floor",
                                       "capture-max-rays",
                                       "capture-ao-distance",
                                       "capture-ao-falloff",
                                       "capture-azimuths",
                                       "capture-decimate",
                                       "capture-bounces",
                                       "capture-seed",
                                       "capture-cache",
                                       "capture-cache-after",
                                       "capture-cache-error",
                                       "sky-key",
                                       "sky-map",
                                       BLEND_KEY,
                                       "scene-key"};
    if (!capture_header_has_settings(before) || !capture_header_has_settings(now))
        return NULL;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const char *was = header_key(before, keys[i]), *is = header_key(now, keys[i]);
        was = was ? was : "none";
        is = is ? is : "none";
        /* streams had no sky-key at first */
        if (!strcmp(was, is) || (!strcmp(keys[i], "sky-key") && (*was == 'n' || *is == 'n')))
            continue;
        if (!strcmp(keys[i], "scene-key"))
            return error_new(
                "the probes were captured in another scene, or with other light in it");
        return error_new("the probes were captured with %s %s, not %s", keys[i], was, is);
    }
    return capture_split_check_same(before, now);
}

struct error *capture_make_header(struct stream_header *header, const struct stream_header *before,
                                  const struct capture_record *record)
{
    static const struct capture_split whole = {0};
    struct error *err = header_copy(header, before);
    if (!err)
        err = header_add_provenance(header, record->command_line);
    if (record->settings->light == CAPTURE_NONE) {
        const char *was = header_key(before, "scene-key");
        if (!err && was && strcmp(was, record->scene_key) != 0)
            err = error_new("the light of the probes was captured in another scene, or with other "
                            "light in it");
        if (!err)
            err = occlusion_to_header(record->settings, header);
        return err ? err : scene_file_to_header(record->light, header);
    }
    if (!err)
        err = capture_settings_to_header(record->settings, header);
    if (!err)
        err = cache_options_to_header(record->cache, header);
    if (!err)
        err = scene_settings_to_header(record->light, header);
    if (!err)
        err = capture_split_to_header(record->split ? record->split : &whole, header);
    if (!err)
        err = senders_copy_keys(header, record->senders);
    if (!err)
        err = header_set_key(header, "scene-key", record->scene_key);
    header_remove_key(header, CAPTURE_BY_KEY);
    header_remove_key(header, BLEND_KEY);
    if (!err && !record->again)
        err = error_wrap(capture_check_same(before, header), "--again captures all anew");
    return err;
}

/* -- tables ----------------------------------------------------------------------------------- */

/* A column that capture may write: its name beside points and beside surfaces (NULL: not there),
 * its width, where a probe's result holds it, and the flag that asks for it (0: always). */
struct output {
    const char *point, *surface;
    size_t width, offset;
    unsigned flag;
};

enum { OUTPUTS = 14 }; /* without the count of rays, which is no float */

#define AT(member) offsetof(struct capture_probe, member)

static void make_outputs(const struct capture_settings *settings, bool surface,
                         struct output output[OUTPUTS])
{
    const size_t count = (size_t)(settings->order * settings->order),
                 light = surface ? 3 : 3 * count;
    const struct output all[OUTPUTS] = {
        {"sh", "irradiance", light, AT(sh), 0},
        {"sh_error", "irradiance_error", light, AT(sh_error), CAPTURE_ERROR},
        {"sh_gradient", NULL, 9 * count, AT(sh_gradient), CAPTURE_GRADIENT},
        {"sh_window", NULL, 1, AT(sh_window), CAPTURE_WINDOW},
        {"visibility", NULL, count, AT(visibility), CAPTURE_VISIBILITY},
        {"validity", "validity", 1, AT(validity), CAPTURE_VALIDITY},
        {"depth", "depth", 1, AT(depth), CAPTURE_DEPTH},
        {"sky", "sky", 1, AT(sky), CAPTURE_SKY},
        {"ao", "ao", 1, AT(ao), CAPTURE_AO},
        {"bent_normal", "bent_normal", 3, AT(bent_normal), CAPTURE_BENT_NORMAL},
        {"bent_length", "bent_length", 1, AT(bent_length), CAPTURE_BENT_LENGTH},
        {"cone", "cone", 4, AT(cone), CAPTURE_CONE},
        {NULL, "ao_bounced", 3, AT(ao_bounced), CAPTURE_AO_BOUNCED},
        {NULL, "horizon", (size_t)settings->azimuths, AT(horizon), CAPTURE_HORIZON}};
    memcpy(output, all, sizeof all);
}

static struct error *add_column(struct table *table, const char *name, enum column_type type,
                                size_t width, bool wanted)
{
    const struct column *there = table_column(table, name);
    return (there ? there->type != type || there->width != width : wanted)
               ? table_add_column(table, name, type, width, NULL)
               : NULL;
}

size_t capture_row_bytes(const struct table *table, size_t *split)
{
    size_t all = 0;
    *split = 0;
    for (size_t i = 0; i < table->column_count; i++) {
        const struct column *c = &table->columns[i];
        const size_t bytes = c->width * column_type_size(c->type);
        all += bytes;
        *split += light_column_is_split(c->name) ? bytes : 0;
    }
    return all;
}

/* What a stream can hold. */
static struct error *check_room(const struct table *table)
{
    enum { ROW_MOST = 1 << 20, COLUMNS_MOST = 4096 };
    size_t split;
    const size_t bytes = capture_row_bytes(table, &split);
    if (bytes <= ROW_MOST && table->column_count <= COLUMNS_MOST)
        return NULL;
    return error_new("a probe takes %zu bytes in %zu columns, %zu bytes of them for groups and "
                     "transfers: a stream holds at most %d bytes in %d columns (fewer of them, a "
                     "lower --order or --columns none take less)",
                     bytes, table->column_count, split, (int)ROW_MOST, (int)COLUMNS_MOST);
}

/* Adds the columns of parts. */
static struct error *add_split_columns(const struct capture_settings *settings, bool surface,
                                       struct table *table)
{
    const size_t width = surface ? 3 : (size_t)(3 * settings->order * settings->order);
    struct split_column column;
    struct error *err = NULL;
    for (int error = 0; error < (settings->columns & CAPTURE_ERROR ? 2 : 1); error++)
        for (size_t i = 0; settings->split && !err &&
                           capture_split_column(settings->split, i, surface, error, &column);
             i++)
            err = add_column(table, column.name, COLUMN_F32, width * column.count, true);
    return !err && settings->split ? check_room(table) : err;
}

/* Whether a capture has to do with what a flag stands for; with the columns beside light, whether
 * it would fill one that is there. */
static bool fills(const struct capture_settings *settings, unsigned flag)
{
    return settings->light != CAPTURE_NONE ||
           flag & (settings->columns | (unsigned)CAPTURE_OCCLUSION);
}

struct error *capture_add_columns(const struct capture_settings *settings, struct table *table)
{
    const bool surface = table_column(table, "normal");
    struct output output[OUTPUTS];
    make_outputs(settings, surface, output);
    struct error *err = NULL;
    const unsigned columns =
        settings->columns |
        (settings->dering.target != DERING_NONE && !surface ? CAPTURE_WINDOW : 0);
    for (size_t i = 0; i < OUTPUTS && !err; i++) {
        const char *name = surface ? output[i].surface : output[i].point;
        const bool wanted = !output[i].flag || columns & output[i].flag;
        if (!fills(settings, output[i].flag))
            continue;
        if (name)
            err = add_column(table, name, COLUMN_F32, output[i].width, wanted);
        else if (wanted)
            err = error_new("%s is known of probes %s a normal alone",
                            output[i].point ? output[i].point : output[i].surface,
                            surface ? "without" : "with");
    }
    if (!err)
        err = add_column(table, "rays", COLUMN_I32, 1, settings->columns & CAPTURE_RAYS);
    return err ? err : add_split_columns(settings, surface, table);
}

void capture_drop_stale(struct table *table)
{
    table_remove_column(table, "sh_gradient");
    table_remove_column(table, "sh_window");
    table_remove_column(table, "filled");
    for (size_t i = table->column_count; i-- > 0;)
        if (light_column_is_split(table->columns[i].name))
            table_remove_column(table, table->columns[i].name);
    basis_drop(table);
}

struct error *capture_forget(struct table *table)
{
    const struct capture_settings any = capture_settings_default();
    struct output output[OUTPUTS];
    make_outputs(&any, false, output);
    const char *names[2 * OUTPUTS + 1] = {"rays"};
    for (size_t i = 0; i < OUTPUTS; i++) {
        names[2 * i + 1] = output[i].point;
        names[2 * i + 2] = output[i].surface;
    }
    struct error *err = NULL;
    for (size_t i = 0; i < sizeof names / sizeof *names && !err; i++) {
        const struct column *c = names[i] ? table_column(table, names[i]) : NULL;
        if (c)
            err = table_add_column(table, names[i], c->type, c->width, NULL);
    }
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        if (light_column_is_split(c->name))
            err = table_add_column(table, c->name, c->type, c->width, NULL);
    }
    return err;
}

struct error *capture_forget_unlit(const struct capture_settings *settings, struct table *table)
{
    const bool surface = table_column(table, "normal");
    struct output output[OUTPUTS];
    make_outputs(settings, surface, output);
    struct error *err = NULL;
    for (size_t i = 0; i < OUTPUTS && !err; i++) {
        const char *name = surface ? output[i].surface : output[i].point;
        const struct column *c = name ? table_column(table, name) : NULL;
        if (c && fills(settings, output[i].flag))
            err = table_add_column(table, name, c->type, c->width, NULL);
    }
    return err;
}

void capture_shape(const struct capture_settings *settings, struct capture_probe *result)
{
    float *error = result->sh_error,
          *gradient = settings->columns & CAPTURE_GRADIENT ? result->sh_gradient : NULL;
    double r = 1;
    if (settings->dering.target != DERING_NONE)
        r = dering_window(&settings->dering, settings->order, false, result->sh);
    if (r >= 0 && r < 1)
        dering_apply(settings->order, r, result->sh, error, gradient);
    result->sh_window = (float)(r < 0 ? 1 : r);
    if (settings->convolved)
        content_convolve(settings->order, result->sh, error, gradient);
}

/* The same to parts of a point's light: a window is that of the whole, so that they add up to it;
 * what is the response to other light has none. */
static void shape_parts(const struct capture_settings *settings, double window, float *part,
                        float *error)
{
    const size_t width = (size_t)(3 * settings->order * settings->order),
                 groups = split_sky(&settings->split->split),
                 count = capture_split_count(settings->split);
    for (size_t p = 0; p < count; p++) {
        if (p < groups && window < 1)
            dering_apply(settings->order, window, part + p * width, error + p * width, NULL);
        if (settings->convolved)
            content_convolve(settings->order, part + p * width, error + p * width, NULL);
    }
}

/* A column of parts that results go to. */
struct part_column {
    struct column *column;
    size_t first; /* value of all parts' */
    bool error;
};

/* Rows that are due, and where their results go. */
struct due_rows {
    const struct path_tracer *path;
    struct capture_settings settings; /* with the columns that the table has */
    const double *position;
    const float *normal; /* NULL: points */
    const float *albedo; /* of surfaces; NULL: the table does not tell */
    struct output output[OUTPUTS];
    struct column *column[OUTPUTS], *rays; /* NULL: not in the table */
    struct part_column *part;              /* owned */
    size_t part_count, part_capacity;
    size_t part_width; /* values of a part */
    float **parts;     /* by thread: of all parts the light, then its error; owned */
    int part_threads;
    const size_t *row;
    atomic_size_t left; /* rows that a signal came before */
    struct progress *progress;
};

/* Puts what was found into a row of a column. */
static struct error *put(const struct column *column, size_t row, const float *value)
{
    for (size_t k = 0; k < column->width; k++)
        if (!isfinite(value[k]))
            return error_new("probe %zu: %s is beyond what 32 bits can hold: --light-scale "
                             "brings light down",
                             row, column->name);
    memcpy(column_f32(column) + row * column->width, value, column->width * sizeof *value);
    return NULL;
}

static struct error *put_parts(const struct due_rows *due, size_t row, const float *light,
                               const float *error)
{
    struct error *err = NULL;
    for (size_t i = 0; i < due->part_count && !err; i++) {
        const struct part_column *c = &due->part[i];
        err = put(c->column, row, (c->error ? error : light) + c->first);
    }
    return err;
}

static struct error *capture_one(void *context, size_t index, int thread)
{
    struct due_rows *due = context;
    if (interrupt_came()) {
        due->left++;
        return NULL;
    }
    const size_t row = due->row[index];
    const float *normal = due->normal ? due->normal + 3 * row : NULL;
    if (normal && !(vec3f_length((struct vec3f){normal[0], normal[1], normal[2]}) > 0))
        return error_new("probe %zu: expected a normal, got (%g, %g, %g)", row, (double)normal[0],
                         (double)normal[1], (double)normal[2]);
    struct capture_probe result;
    float *light = due->part_count ? due->parts[thread] : NULL,
          *light_error = light ? light + capture_split_count(due->settings.split) * due->part_width
                               : NULL;
    struct error *err = capture_probe_split(due->path, &due->settings, due->position + 3 * row,
                                            normal, &result, light, light_error);
    if (err)
        return error_wrap(err, "probe %zu", row);
    if (!normal)
        capture_shape(&due->settings, &result);
    if (!normal && light)
        shape_parts(&due->settings, (double)result.sh_window, light, light_error);
    if (normal && due->albedo && !isnan(due->albedo[3 * row]))
        occlusion_bounced(result.ao, due->albedo + 3 * row, result.ao_bounced);
    for (size_t i = 0; i < OUTPUTS && !err; i++)
        if (due->column[i] &&
            !(due->output[i].flag == CAPTURE_AO_BOUNCED && isnan(result.ao_bounced[0])))
            err = put(due->column[i], row,
                      (const float *)((const char *)&result + due->output[i].offset));
    if (!err)
        err = put_parts(due, row, light, light_error);
    if (err)
        return err;
    if (due->rays)
        column_i32(due->rays)[row] = result.rays;
    progress_add(due->progress, 1);
    return NULL;
}

/* Finds the columns that parts go to: those that the table has of all that there are. */
static struct error *find_part_columns(struct due_rows *due, const struct table *table)
{
    const bool surface = due->normal;
    struct split_column c;
    struct error *err = NULL;
    due->part_width = surface ? 3 : (size_t)(3 * due->settings.order * due->settings.order);
    for (int error = 0; error < 2; error++)
        for (size_t i = 0; due->settings.split && !err &&
                           capture_split_column(due->settings.split, i, surface, error, &c);
             i++) {
            struct part_column part = {.first = c.first * due->part_width, .error = error};
            if (!table_column(table, c.name))
                continue;
            err = table_require(table, c.name, COLUMN_F32, c.count * due->part_width, &part.column);
            if (!err)
                err = array_reserve(&due->part, &due->part_capacity, due->part_count + 1,
                                    sizeof part);
            if (!err)
                due->part[due->part_count++] = part;
        }
    return err;
}

/* Room for the parts of a probe for each thread. */
static struct error *make_parts(struct due_rows *due, int threads)
{
    struct error *err = NULL;
    if (!due->part_count)
        return NULL;
    err = array_create(&due->parts, (size_t)threads, sizeof *due->parts);
    due->part_threads = err ? 0 : threads;
    for (int t = 0; t < threads && !err; t++)
        err = array_create(&due->parts[t],
                           2 * capture_split_count(due->settings.split) * due->part_width,
                           sizeof **due->parts);
    return err;
}

/* Finds the columns that results go to. */
static struct error *find_columns(struct due_rows *due, const struct table *table)
{
    struct column *position = NULL, *normal = NULL, *albedo = NULL;
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err && table_column(table, "normal"))
        err = table_require(table, "normal", COLUMN_F32, 3, &normal);
    if (err)
        return err;
    due->position = column_f64(position);
    if (table_column(table, "albedo"))
        err = table_require(table, "albedo", COLUMN_F32, 3, &albedo);
    if (err)
        return err;
    due->normal = normal ? column_f32(normal) : NULL;
    due->albedo = albedo ? column_f32(albedo) : NULL;
    make_outputs(&due->settings, normal, due->output);
    unsigned columns = 0;
    for (size_t i = 0; i < OUTPUTS && !err; i++) {
        const char *name = normal ? due->output[i].surface : due->output[i].point;
        if (!name || !fills(&due->settings, due->output[i].flag) ||
            (due->output[i].flag && !table_column(table, name)))
            continue;
        err = table_require(table, name, COLUMN_F32, due->output[i].width, &due->column[i]);
        columns |= due->output[i].flag;
    }
    due->settings.columns = columns;
    if (!err && table_column(table, "rays") && fills(&due->settings, CAPTURE_RAYS))
        err = table_require(table, "rays", COLUMN_I32, 1, &due->rays);
    return err ? err : find_part_columns(due, table);
}

struct error *capture_rows(struct capture_job *job, struct table *table, size_t first, size_t count)
{
    struct due_rows due = {
        .path = job->path, .settings = *job->settings, .progress = job->progress};
    const struct capture_slice *slice = job->slice;
    size_t *row = NULL, due_count = 0;
    job->captured = job->left = 0;
    struct error *err = find_columns(&due, table);
    if (!err)
        err = array_create(&row, count, sizeof *row);
    if (!err)
        err = make_parts(&due, job->threads);
    const struct column *light = due.column[0];
    for (size_t i = first; i < first + count && !err; i++) {
        const bool turn = !slice || (slice->number + i - first) % slice->parts == slice->part;
        if (turn && (job->again || !light || isnan(column_f32(light)[i * light->width])))
            row[due_count++] = i;
    }
    due.row = row;
    if (!err)
        err = threads_for(job->threads, due_count, capture_one, &due);
    job->captured = due_count - due.left;
    job->left = due.left;
    for (int t = 0; t < due.part_threads; t++)
        free(due.parts[t]);
    free(due.parts);
    free(due.part);
    free(row);
    return err;
}
