/* SPDX-License-Identifier: Apache-2.0 */
#include "fit/fit_stream.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "fit/fit_surface.h"
#include "math/vec.h"
#include "stream/faces.h"
#include "stream/light_columns.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What one run works on. */
struct fit {
    const struct fit_settings *settings;
    struct table *probes;      /* of the stream that changes */
    const struct table *table; /* of the samples */
    struct faces faces;
    struct fit_samples samples;
    struct fit_surface surface;
    struct fit_system system;
    bool *used;    /* owned; a sample each */
    bool *reached; /* owned; a vertex each: a sample is on one of its faces */
    char **name;   /* owned list of columns of the samples, borrowed */
    size_t columns;
};

/* -- which columns ---------------------------------------------------------------------------- */

static size_t sh_width(const struct table *table)
{
    const struct column *sh = table_column(table, "sh");
    return sh ? sh->width : 0;
}

static bool is_fitted(const struct table *table, const struct column *column)
{
    static const char *const more[] = {"ao", "sky", "visibility", "bent_normal"};
    struct light_column what;
    if (light_column_of(column, sh_width(table), &what))
        return what.role != LIGHT_ERROR;
    for (size_t i = 0; i < sizeof more / sizeof *more; i++)
        if (!strcmp(column->name, more[i]))
            return true;
    return false;
}

/* Whether a comma-separated list has the name. */
static bool in_list(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *p = list; *p; p += strcspn(p, ","), p += *p == ',')
        if (!strncmp(p, name, length) && strcspn(p, ",") == length)
            return true;
    return false;
}

static struct error *check_list(const struct fit *fit, const char *list)
{
    for (const char *p = list; p && *p; p += strcspn(p, ","), p += *p == ',') {
        char name[FIT_NAME_ROOM];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(p, ","), p);
        const struct column *c = table_column(fit->table, name);
        if (!c)
            return error_new("--columns: the samples have no column %s", name);
        if (c->type != COLUMN_F32 || !strcmp(name, "normal") || !strcmp(name, "weight") ||
            !strcmp(name, "area"))
            return error_new("--columns: expected a column of values, f32, got %s", name);
    }
    return NULL;
}

static struct error *choose_columns(struct fit *fit)
{
    const char *list = fit->settings->columns;
    struct error *err = check_list(fit, list);
    if (!err)
        err = array_create(&fit->name, fit->table->column_count, sizeof *fit->name);
    for (size_t i = 0; i < fit->table->column_count && !err; i++) {
        const struct column *c = &fit->table->columns[i];
        if (list ? in_list(list, c->name) : is_fitted(fit->table, c))
            fit->name[fit->columns++] = c->name;
    }
    if (!err && !fit->columns)
        err = error_new("the samples have no light (probe-capture gives it) and nothing else that "
                        "is fitted");
    return err;
}

/* -- do they belong together ------------------------------------------------------------------ */

/* Samples stand where their faces say, but for the rounding of their weights. */
static struct error *check_place(const struct fit *fit, const double *position, size_t i)
{
    static const double rounding = 1e-6;
    const struct faces *faces = &fit->faces;
    const int32_t face = fit->samples.face[i];
    if (face < 0 || (size_t)face >= faces->count)
        return error_new(
            "sample %zu: expected one of %zu faces, got %d: they are of other vertices", i,
            faces->count, face);
    struct vec3 p = {0, 0, 0};
    double size = 0;
    for (size_t c = 0; c < 3; c++) {
        const struct vec3 v =
            vec3_load(faces->position + 3 * (size_t)faces->vertex[3 * (size_t)face + c]);
        const double w = (double)fit->samples.weight[3 * i + c];
        if (!(w >= 0 && w <= 1))
            return error_new("sample %zu: expected weights from 0 to 1, got %g", i, w);
        p = vec3_fma(p, w, v);
        size += vec3_length(v);
    }
    if (!(vec3_length(vec3_sub(p, vec3_load(position + 3 * i))) <= rounding * size))
        return error_new("sample %zu stands at %g %g %g, its face's point is %g %g %g: they are of "
                         "other vertices",
                         i, position[3 * i], position[3 * i + 1], position[3 * i + 2], p.x, p.y,
                         p.z);
    return NULL;
}

static struct error *check_keys(const struct stream *probes, const struct stream *samples)
{
    const char *ours = header_key(&probes->header, "scene-key"),
               *theirs = header_key(&samples->header, "scene-key");
    if (ours && theirs && strcmp(ours, theirs))
        return error_new("probes and samples were captured in different scenes, or light (keys "
                         "scene-key %s and %s)",
                         ours, theirs);
    return NULL;
}

static struct error *take_samples(struct fit *fit)
{
    struct column *position = NULL, *face = NULL, *weight = NULL, *area = NULL;
    struct error *err = table_require(fit->table, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(fit->table, "face", COLUMN_I32, 1, &face);
    if (!err)
        err = table_require(fit->table, "weight", COLUMN_F32, 3, &weight);
    if (!err)
        err = table_require(fit->table, "area", COLUMN_F32, 1, &area);
    if (err)
        return error_wrap(err, "the samples (of probe-place samples)");
    if (!err)
        err = array_create(&fit->used, fit->table->rows, sizeof *fit->used);
    fit->samples = (struct fit_samples){.face = column_i32(face),
                                        .weight = column_f32(weight),
                                        .area = column_f32(area),
                                        .used = fit->used,
                                        .count = fit->table->rows};
    for (size_t i = 0; i < fit->table->rows && !err; i++)
        err = check_place(fit, column_f64(position), i);
    return err;
}

/* Samples with a value in all columns are used; vertices of their faces are reached. */
static struct error *mark(struct fit *fit, struct fit_report *report)
{
    struct error *err = array_create(&fit->reached, fit->faces.vertices, sizeof *fit->reached);
    for (size_t i = 0; i < fit->table->rows && !err; i++) {
        fit->used[i] = fit->samples.area[i] > 0;
        for (size_t c = 0; c < fit->columns; c++) {
            const struct column *column = table_column(fit->table, fit->name[c]);
            fit->used[i] = fit->used[i] && !isnan(column_f32(column)[column->width * i]);
        }
        report->left_out += !fit->used[i];
        for (size_t c = 0; c < 3 && fit->used[i]; c++)
            fit->reached[fit->faces.vertex[3 * (size_t)fit->samples.face[i] + c]] = true;
    }
    report->samples = fit->table->rows;
    for (size_t i = 0; i < fit->faces.vertices && !err; i++)
        report->unreached += !fit->reached[i];
    return err;
}

/* -- one number of a column ------------------------------------------------------------------- */

/* Where it begins: at what the probe has, or the mean of the samples on its faces, or of all. */
static bool begin(const struct fit *fit, const struct column *own, size_t k, const double *right,
                  double *share, double *x)
{
    double sum = 0;
    bool all = own;
    for (size_t i = 0; i < fit->faces.vertices; i++) {
        share[i] = 0;
        sum += right[i]; /* the mean of all: weights of a sample add up to 1 */
    }
    for (size_t i = 0; i < fit->samples.count; i++)
        for (size_t c = 0; c < 3 && fit->used[i]; c++)
            share[fit->faces.vertex[3 * (size_t)fit->samples.face[i] + c]] +=
                (double)fit->samples.weight[3 * i + c] * (double)fit->samples.area[i] /
                fit->surface.area;
    for (size_t i = 0; i < fit->faces.vertices; i++) {
        const double value = own ? (double)column_f32(own)[own->width * i + k] : NAN;
        all = all && !isnan(value);
        x[i] = !isnan(value) ? value : share[i] > 0 ? right[i] / share[i] : sum;
    }
    return all;
}

/* What values may be: irradiance is not below 0, shares are from 0 to 1. */
static void bounds_of(const struct column *column, double *low, double *high)
{
    struct light_column what;
    *low = -INFINITY;
    *high = INFINITY;
    if (!strcmp(column->name, "ao") || !strcmp(column->name, "sky") ||
        !strcmp(column->name, "validity")) {
        *low = 0;
        *high = 1;
    } else if (light_column_of(column, 0, &what) && what.surface && !what.transfer) {
        *low = 0;
    }
}

static void keep_within(double low, double high, double *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        x[i] = x[i] < low ? low : x[i] > high ? high : x[i];
}

/* A column that is fitted. */
struct part {
    struct fit *fit;
    const struct column *value, *own; /* of the samples; of the probes, NULL: there is none */
    float *result;                    /* width * vertices */
    double *held, *fitted, *all;      /* mean squares, a number of the column each */
    bool *whole;                      /* the probes had all of it */
    int *steps;
};

static struct error *fit_number(void *context, size_t k, int thread)
{
    const struct part *part = context;
    const struct fit *fit = part->fit;
    const size_t n = fit->faces.vertices, width = part->value->width;
    const float *value = column_f32(part->value) + k;
    double *room = NULL, low, high;
    struct fit_effort effort = {0};
    (void)thread;
    struct error *err = array_create(&room, 3 * n, sizeof *room);
    if (err)
        return err;
    double *right = room, *x = room + n, *share = x + n;
    fit_surface_right(&fit->surface, &fit->faces, &fit->samples, value, width, right);
    part->whole[k] = begin(fit, part->own, k, right, share, x);
    fit_surface_error(&fit->surface, &fit->faces, &fit->samples, value, width, x, &part->held[k],
                      &part->all[k]);
    bounds_of(part->value, &low, &high);
    keep_within(low, high, x, n);
    if (!fit->settings->measure)
        err = fit_solve(&fit->system, right, low, high, x, &effort);
    fit_surface_error(&fit->surface, &fit->faces, &fit->samples, value, width, x, &part->fitted[k],
                      &part->all[k]);
    part->steps[k] = effort.steps;
    for (size_t i = 0; i < n && !err; i++)
        part->result[width * i + k] = (float)x[i];
    free(room);
    if (!err && effort.residual > 1e-5)
        err = error_new("column %s: no minimum was found: %d steps left a residual of %g",
                        part->value->name, effort.steps, effort.residual);
    return err;
}

/* -- columns ---------------------------------------------------------------------------------- */

static double root_of(const double *square, size_t count)
{
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += square[k];
    return sqrt(sum / (double)count);
}

static void tell(const struct part *part, struct fit_told *told)
{
    const size_t width = part->value->width;
    struct light_column what;
    bool whole = true;
    *told = (struct fit_told){.fitted = root_of(part->fitted, width),
                              .held = root_of(part->held, width),
                              .all = root_of(part->all, width),
                              .light = light_column_of(part->value, width, &what)};
    snprintf(told->name, sizeof told->name, "%s", part->value->name);
    for (size_t k = 0; k < width; k++) {
        whole = whole && part->whole[k];
        told->steps = part->steps[k] > told->steps ? part->steps[k] : told->steps;
    }
    if (!whole)
        told->held = NAN;
}

/* Means of unit vectors are shorter. */
static void make_unit(float *value, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float *v = value + 3 * i;
        const struct vec3 unit =
            vec3_normalize((struct vec3){(double)v[0], (double)v[1], (double)v[2]});
        v[0] = (float)unit.x;
        v[1] = (float)unit.y;
        v[2] = (float)unit.z;
    }
}

/* The name of a column's error: sh_error, sh_error_NAME. */
static void drop_error(struct table *probes, const struct column *column)
{
    struct light_column what;
    char name[2 * FIT_NAME_ROOM];
    if (!light_column_of(column, column->width, &what) || what.role != LIGHT_VALUE)
        return;
    const size_t base = what.transfer ? strlen(column->name)
                        : what.group  ? strcspn(column->name, "_")
                                      : strlen(column->name);
    snprintf(name, sizeof name, "%.*s_error%s", (int)base, column->name, column->name + base);
    table_remove_column(probes, name);
}

/* Takes the result over. */
static struct error *give(struct fit *fit, const struct part *part)
{
    struct column *column = NULL;
    const struct column *value = part->value;
    const size_t numbers = value->width * fit->faces.vertices;
    if (!strcmp(value->name, "bent_normal"))
        make_unit(part->result, fit->faces.vertices);
    struct error *err =
        table_add_column(fit->probes, value->name, COLUMN_F32, value->width, &column);
    for (size_t i = 0; i < numbers && !err; i++)
        column_f32(column)[i] = part->result[i];
    if (!err)
        drop_error(fit->probes, value);
    return err;
}

static struct error *fit_column(struct fit *fit, const char *name, struct fit_told *told)
{
    const struct column *value = table_column(fit->table, name),
                        *own = table_column(fit->probes, name);
    const size_t width = value->width;
    double *square = NULL;
    struct part part = {.fit = fit, .value = value, .own = own};
    if (own && (own->type != value->type || own->width != width))
        return error_new("column %s: the probes have %s:%zu, the samples %s:%zu", name,
                         column_type_name(own->type), own->width, column_type_name(value->type),
                         width);
    if (!own && fit->settings->measure)
        return error_new("--measure: the probes have no column %s", name);
    struct error *err =
        array_create(&part.result, width * fit->faces.vertices, sizeof *part.result);
    if (!err)
        err = array_create(&square, 3 * width, sizeof *square);
    if (!err)
        err = array_create(&part.whole, width, sizeof *part.whole);
    if (!err)
        err = array_create(&part.steps, width, sizeof *part.steps);
    if (!err) {
        part.held = square;
        part.fitted = square + width;
        part.all = square + 2 * width;
        err = threads_for(fit->settings->threads, width, fit_number, &part);
    }
    if (!err)
        tell(&part, told);
    if (!err && !fit->settings->measure)
        err = give(fit, &part);
    free(part.result);
    free(square);
    free(part.whole);
    free(part.steps);
    return err;
}

/* -- all -------------------------------------------------------------------------------------- */

/* What the samples' header says of their light, where the probes' says nothing. */
static struct error *take_keys(struct stream *probes, const struct stream *samples)
{
    struct error *err = NULL;
    for (size_t i = 0; i < samples->header.key_count && !err; i++) {
        const struct key *key = &samples->header.keys[i];
        if (!header_key(&probes->header, key->name))
            err = header_set_key(&probes->header, key->name, key->value);
    }
    return err;
}

static void warn(const struct fit_report *report, struct warnings *warnings)
{
    bool light = false, lit = false;
    for (size_t i = 0; i < report->count; i++) {
        light = light || report->told[i].light;
        lit = lit || (report->told[i].light && report->told[i].all > 0);
    }
    if (light && !lit)
        warnings_add(warnings, "black", "all samples are black: no light reaches the surface");
    if (report->left_out)
        warnings_add(warnings, "left out", "%zu of %zu samples have no value: left out",
                     report->left_out, report->samples);
    if (report->unreached)
        warnings_add(warnings, "unreached",
                     "%zu probes have no sample on their faces: they keep what they have, or are "
                     "given what --smooth makes of their neighbours",
                     report->unreached);
}

static struct error *run(struct fit *fit, struct fit_report *report)
{
    struct error *err = choose_columns(fit);
    if (!err)
        err = take_samples(fit);
    if (!err)
        err = mark(fit, report);
    if (!err)
        err = fit_surface_make(&fit->surface, &fit->faces, &fit->samples,
                               fit->settings->measure ? 0 : fit->settings->smooth);
    if (!err)
        err = fit_system_init(&fit->system, fit->surface.element, fit->surface.count,
                              fit->faces.vertices);
    if (!err)
        err = array_create(&report->told, fit->columns, sizeof *report->told);
    for (size_t i = 0; i < fit->columns && !err; i++)
        err = fit_column(fit, fit->name[i], &report->told[report->count++]);
    return err;
}

struct error *fit_stream(struct stream *probes, const struct stream *samples,
                         const struct fit_settings *settings, struct fit_report *report,
                         struct warnings *warnings)
{
    struct fit fit = {.settings = settings, .table = stream_table(samples, "probe")};
    struct error *err = fit.table ? faces_of(probes, &fit.faces)
                                  : error_new("the samples have no table probe");
    fit.probes = fit.faces.probes;
    if (!err)
        err = check_keys(probes, samples);
    if (!err)
        err = run(&fit, report);
    if (!err && !settings->measure)
        err = take_keys(probes, samples);
    if (!err)
        warn(report, warnings);
    fit_system_clear(&fit.system);
    fit_surface_clear(&fit.surface);
    free(fit.used);
    free(fit.reached);
    free(fit.name);
    return err;
}

void fit_report_clear(struct fit_report *report)
{
    free(report->told);
    *report = (struct fit_report){0};
}
