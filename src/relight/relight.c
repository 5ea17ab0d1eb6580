/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/relight.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "capture/senders.h"
#include "libprobe-query/sh.h"
#include "light/basis.h"
#include "light/rotate.h"
#include "relight/compressed.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_ROOM = 64, CHUNK = 32 };

/* -- what a header says ----------------------------------------------------------------------- */

/* The keys PREFIX1, PREFIX2 ... of three numbers up to `most` each. */
static struct error *read_triples(const struct stream_header *header, const char *prefix,
                                  double most, double **triple, size_t *count)
{
    size_t capacity = 0;
    struct error *err = NULL;
    for (char key[40]; !err; ++*count) {
        snprintf(key, sizeof key, "%s%zu", prefix, *count + 1);
        if (!header_key(header, key))
            return NULL;
        err = array_reserve(triple, &capacity, 3 * (*count + 1), sizeof **triple);
        if (!err)
            err = header_get_reals(header, key, 3, -most, most, *triple + 3 * *count);
    }
    return err;
}

static struct error *read_suns(struct relight *r, const struct stream_header *header)
{
    struct error *err = read_triples(header, "transfer-sun-", 1.001, &r->sun, &r->suns);
    for (size_t s = 0; s < r->suns && !err; s++) {
        const double *d = r->sun + 3 * s;
        if (!(fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-6))
            err = error_new("header key transfer-sun-%zu: expected a direction of length 1", s + 1);
    }
    return err;
}

/* Key dering is of sh alone: parts of which one is damped and others are not do not add up. */
static struct error *check_header(const struct stream_header *header)
{
    if (header_key(header, "sh-dering"))
        return error_new(
            "the light was de-rung (key sh-dering), its parts by what their sum needed: "
            "expected a stream of --dering none; relit light is de-rung by probe-cat");
    return NULL;
}

struct error *relight_from_header(struct relight *r, const struct stream_header *header)
{
    struct error *err = check_header(header);
    if (!err)
        err = groups_from_header(&r->groups, header);
    if (!err)
        err = header_get_int(header, "transfer-sky", 1, SH_ORDER_MAX, &r->sky_order);
    if (!err)
        err = read_suns(r, header);
    if (!err)
        err = read_triples(header, "transfer-point-", DBL_MAX, &r->point, &r->points);
    if (!err && !r->groups.count && !r->sky_order && !r->suns && !r->points)
        err = error_new("there is nothing to relight: expected groups of lights or a transfer (%s)",
                        header_key(header, "weight-1") ? "the stream was relit without --keep"
                                                       : "probe-capture --groups, --transfer");
    r->whole = !r->groups.count;
    r->compressed = header_key(header, COMPRESSED_KEY) != NULL;
    r->again = header_key(header, "weight-1") != NULL;
    r->turned = header_key(header, ROTATED_KEY) || header_key(header, ROTATED_LIGHT_KEY);
    if (!err)
        err = array_create(&r->names, r->groups.count + 1, sizeof *r->names);
    for (size_t g = 0; g < r->groups.count && !err; g++)
        r->names[g] = r->groups.list[g].name;
    return err;
}

void relight_clear(struct relight *r)
{
    groups_clear(&r->groups);
    free(r->names);
    free(r->sun);
    free(r->point);
    free(r->part);
    table_clear(&r->basis);
    *r = (struct relight){0};
}

size_t relight_parts(const struct relight *r)
{
    return r->groups.count + r->whole + (size_t)(r->sky_order * r->sky_order) + r->suns + r->points;
}

/* -- columns ---------------------------------------------------------------------------------- */

static size_t find_column(const struct table *t, const char *name)
{
    for (size_t i = 0; i < t->column_count; i++)
        if (!strcmp(t->columns[i].name, name))
            return i;
    return RELIGHT_NONE;
}

static const char *light_name(const struct relight *r)
{
    return r->surface ? "irradiance" : "sh";
}

/* Adds `count` parts that lie in a column side by side, of the probes or of the basis. */
static struct error *add_parts(struct relight *r, const struct table *probes,
                               enum relight_kind kind, const char *name, const char *error_name,
                               size_t count)
{
    const bool in_basis = r->compressed && !(r->whole && kind == RELIGHT_GROUP);
    const struct table *t = in_basis ? &r->basis : probes;
    const size_t column = find_column(t, name), error = find_column(t, error_name);
    struct column *c;
    if (column == RELIGHT_NONE)
        return error_new("column %s: the header names it, there is none", name);
    struct error *err = table_require(t, name, COLUMN_F32, r->width * count, &c);
    if (!err && error != RELIGHT_NONE)
        err = table_require(t, error_name, COLUMN_F32, r->width * count, &c);
    for (size_t i = 0; i < count && !err; i++)
        r->part[r->parts++] = (struct relight_part){kind, column, error, i * r->width, in_basis};
    r->errors = r->errors && error != RELIGHT_NONE;
    return err;
}

static void part_name(char *to, const struct relight *r, const char *group, bool error)
{
    snprintf(to, NAME_ROOM, "%s_%s%s", light_name(r), error ? "error_" : "", group);
}

static struct error *find_groups(struct relight *r, const struct table *t)
{
    struct error *err = NULL;
    char name[NAME_ROOM], error[NAME_ROOM];
    for (size_t g = 0; g < r->groups.count && !err; g++) {
        part_name(name, r, r->names[g], false);
        part_name(error, r, r->names[g], true);
        err = add_parts(r, t, RELIGHT_GROUP, name, error, 1);
    }
    if (!err && r->whole)
        err = add_parts(r, t, RELIGHT_GROUP, light_name(r),
                        r->surface ? "irradiance_error" : "sh_error", 1);
    return err;
}

/* How wide the light of a probe is, by whatever column is there. */
static struct error *find_width(struct relight *r, const struct table *t)
{
    char name[NAME_ROOM];
    const size_t sh = find_column(t, "sh"), transfer = find_column(t, "transfer_sky"),
                 suns = find_column(t, "transfer_suns"), points = find_column(t, "transfer_points");
    size_t group = RELIGHT_NONE;
    r->surface = sh == RELIGHT_NONE && find_column(t, "normal") != RELIGHT_NONE;
    if (r->groups.count) {
        part_name(name, r, r->names[0], false);
        group = find_column(t, name);
    }
    const size_t sky_functions = (size_t)(r->sky_order * r->sky_order);
    const bool irradiance = find_column(t, "irradiance") != RELIGHT_NONE;
    r->width = sh != RELIGHT_NONE            ? t->columns[sh].width
               : r->compressed && irradiance ? 3
               : group != RELIGHT_NONE       ? t->columns[group].width
               : transfer != RELIGHT_NONE && sky_functions
                   ? t->columns[transfer].width / sky_functions
               : suns != RELIGHT_NONE && r->suns     ? t->columns[suns].width / r->suns
               : points != RELIGHT_NONE && r->points ? t->columns[points].width / r->points
                                                     : 0;
    r->surface = r->surface || (r->width == 3 && irradiance);
    if (!r->width)
        return error_new("the probes have no light (no column sh or irradiance): run "
                         "probe-capture");
    if (r->surface ? r->width != 3 : !sh_order_of(r->width))
        return error_new("expected light of 3 n^2 numbers a probe, got %zu", r->width);
    return NULL;
}

struct error *relight_take_basis(struct relight *r, const struct stream_header *header,
                                 struct table *basis)
{
    char key[COMPRESSED_KEY_ROOM];
    compressed_key(header, basis, key);
    if (strcmp(key, header_key(header, COMPRESSED_KEY)))
        return error_new("table %s is not that of the probes, or their light was changed after it "
                         "was compressed (cut, convolved, de-rung, turned): expected that before "
                         "--compress",
                         basis->name);
    table_clear(&r->basis);
    r->basis = *basis;
    *basis = (struct table){0};
    return NULL;
}

/* The columns of a probe's few numbers. */
static struct error *find_vectors(struct relight *r, const struct table *t)
{
    struct column *c = NULL;
    if (!r->basis.rows)
        return error_new("the stream is compressed (key %s): expected a table %s before table "
                         "probe, there is none",
                         COMPRESSED_KEY, COMPRESSED_TABLE);
    struct error *err = table_require(t, "pca", COLUMN_F32, 0, &c);
    r->pca = find_column(t, "pca");
    r->cluster = find_column(t, "pca_cluster");
    if (!err && r->cluster != RELIGHT_NONE)
        err = table_require(t, "pca_cluster", COLUMN_I32, 1, &c);
    if (err)
        return err;
    r->vectors = t->columns[r->pca].width;
    r->clusters = r->basis.rows / (1 + r->vectors);
    if (r->basis.rows % (1 + r->vectors) || (r->clusters > 1 && r->cluster == RELIGHT_NONE))
        return error_new("table %s has %zu rows: expected %zu for column pca:f32:%zu%s",
                         COMPRESSED_TABLE, r->basis.rows, 1 + r->vectors, r->vectors,
                         r->cluster == RELIGHT_NONE ? "" : ", or a multiple of that");
    return NULL;
}

struct error *relight_find(struct relight *r, const struct table *t)
{
    struct error *err = find_width(r, t);
    if (!err && r->compressed)
        err = find_vectors(r, t);
    if (!err)
        err = array_create(&r->part, relight_parts(r), sizeof *r->part);
    r->errors = true;
    if (!err)
        err = find_groups(r, t);
    if (!err && r->sky_order)
        err = add_parts(r, t, RELIGHT_SKY, "transfer_sky", "transfer_sky_error",
                        (size_t)(r->sky_order * r->sky_order));
    if (!err && r->suns)
        err = add_parts(r, t, RELIGHT_SUN, "transfer_suns", "transfer_suns_error", r->suns);
    if (!err && r->points)
        err = add_parts(r, t, RELIGHT_POINT, "transfer_points", "transfer_points_error", r->points);
    r->sum_error = r->again ? RELIGHT_NONE
                            : find_column(t, r->surface ? "irradiance_error" : "sh_error");
    return err;
}

/* The parts' columns; of a stream without groups its light is one, and stays. */
static void drop_parts(const struct relight *r, const struct table *in, struct table *out)
{
    for (size_t p = 0; p < r->parts; p++) {
        const struct relight_part *part = &r->part[p];
        if (part->in_basis || (r->whole && part->kind == RELIGHT_GROUP))
            continue;
        table_remove_column(out, in->columns[part->column].name);
        if (part->error != RELIGHT_NONE)
            table_remove_column(out, in->columns[part->error].name);
    }
    if (r->compressed) {
        table_remove_column(out, "pca");
        table_remove_column(out, "pca_cluster");
    }
    table_remove_column(out, SENDERS_TRANSFER);
    table_remove_column(out, SENDERS_OF);
}

/* What is of the light as it was. */
static void drop_stale(struct table *out, struct warnings *warnings)
{
    static const char *const other[] = {"sh_gradient", "sh_window"};
    for (size_t k = 0; k < sizeof other / sizeof *other; k++)
        if (table_column(out, other[k])) {
            warnings_add(warnings, other[k], "column %s is of the light as it was: dropped",
                         other[k]);
            table_remove_column(out, other[k]);
        }
    for (int b = 0; b < BASIS_COUNT; b++)
        if (table_column(out, basis_column((enum basis)b)))
            warnings_add(warnings, "basis dropped",
                         "column %s is of the light as it was: dropped (probe-cat --basis %s "
                         "makes it anew)",
                         basis_column((enum basis)b), basis_name((enum basis)b));
    basis_drop(out);
}

void relight_drop_parts(struct table *table, bool keep_links, struct warnings *warnings)
{
    for (size_t i = table->column_count; i-- > 0;) {
        const char *name = table->columns[i].name;
        const bool links = !strcmp(name, SENDERS_TRANSFER) || !strcmp(name, SENDERS_OF);
        if (light_column_is_split(name) && !(links && keep_links))
            table_remove_column(table, name);
    }
    drop_stale(table, warnings);
}

struct error *relight_schema(const struct relight *r, const struct table *in, struct table *out,
                             struct warnings *warnings)
{
    const char *error = r->surface ? "irradiance_error" : "sh_error";
    struct error *err = table_copy_schema(out, in);
    if (err)
        return err;
    /* light stays where it stands; else it comes last */
    struct column *light = table_column(out, light_name(r));
    if (!light || light->width != r->width)
        err = table_add_column(out, light_name(r), COLUMN_F32, r->width, NULL);
    if (!err && r->errors && !table_column(out, error))
        err = table_add_column(out, error, COLUMN_F32, r->width, NULL);
    if (!err && !r->errors && table_column(out, error)) {
        warnings_add(warnings, "no error",
                     "column %s: the errors of the parts are not known (%s): dropped", error,
                     r->compressed ? "a compressed stream has none"
                                   : "probe-capture --columns sh_error keeps them");
        table_remove_column(out, error);
    }
    if (!err && !r->keep)
        drop_parts(r, in, out);
    drop_stale(out, warnings);
    return err;
}

/* -- rows ------------------------------------------------------------------------------------- */

struct rows_job {
    const struct relight *relight;
    const double *weight;
    const struct table *in;
    float *light, *error; /* of the output; error may be NULL */
    size_t rows;
    double *basis; /* the light of each row of a basis; NULL: there is none */
};

static bool is_black(const double weight[3])
{
    return weight[0] == 0 && weight[1] == 0 && weight[2] == 0;
}

static const float *values_of(const struct table *t, size_t column, size_t offset, size_t row)
{
    const struct column *c = &t->columns[column];
    return column_f32(c) + row * c->width + offset;
}

static bool is_captured(const struct rows_job *job, size_t row)
{
    const struct relight *r = job->relight;
    for (size_t p = 0; p < r->parts; p++)
        if (!r->part[p].in_basis &&
            isnan(values_of(job->in, r->part[p].column, r->part[p].offset, row)[0]))
            return false;
    return !r->compressed || !isnan(values_of(job->in, r->pca, 0, row)[0]);
}

enum { WIDTH_MOST = 3 * SH_COUNT_MAX };

/* Adds the parts of a row of a table: those of the basis, or those of the probes. */
static void add_light(const struct rows_job *job, bool of_basis, const struct table *table,
                      size_t row, double *sum)
{
    const struct relight *r = job->relight;
    for (size_t p = 0; p < r->parts; p++) {
        const struct relight_part *part = &r->part[p];
        const double *w = job->weight + 3 * p;
        if (part->in_basis != of_basis || is_black(w))
            continue;
        const float *from = values_of(table, part->column, part->offset, row);
        for (size_t i = 0; i < r->width; i += 3)
            for (size_t c = 0; c < 3; c++)
                sum[i + c] += w[c] * (double)from[i + c];
    }
}

static size_t cluster_of(const struct rows_job *job, size_t row)
{
    const struct relight *r = job->relight;
    return r->cluster == RELIGHT_NONE ? 0 : (size_t)column_i32(&job->in->columns[r->cluster])[row];
}

/* Adds the light of a probe's cluster, and what the probe has of that of each vector. */
static void add_basis(const struct rows_job *job, size_t row, double *sum)
{
    const struct relight *r = job->relight;
    const double *light = job->basis + cluster_of(job, row) * (1 + r->vectors) * r->width;
    const float *pca = values_of(job->in, r->pca, 0, row);
    for (size_t i = 0; i < r->width; i++)
        sum[i] += light[i];
    for (size_t k = 0; k < r->vectors; k++)
        for (size_t i = 0; i < r->width; i++)
            sum[i] += (double)pca[k] * light[(1 + k) * r->width + i];
}

static void light_row(const struct rows_job *job, size_t row, float *to)
{
    const struct relight *r = job->relight;
    double sum[WIDTH_MOST] = {0};
    add_light(job, false, job->in, row, sum);
    if (job->basis)
        add_basis(job, row, sum);
    for (size_t i = 0; i < r->width; i++)
        to[i] = (float)sum[i];
}

/* Sums over parts of one kind: of a value, its square; plain ones, those times weights, and those
 * times their magnitudes. */
struct error_sums {
    double plain, plain_squared, sum, squared, magnitude;
};

static void add_error(struct error_sums *s, double error, double weight)
{
    const double weighted = weight * error;
    s->plain += error;
    s->plain_squared += error * error;
    s->sum += weighted;
    s->squared += weighted * weighted;
    s->magnitude += fabs(weighted);
}

/* whole: the error of the plain sum; NAN: not known. */
static double variance_of_groups(const struct error_sums *s, size_t groups, double whole)
{
    const double between = s->plain * s->plain - s->plain_squared;
    if (groups < 2 || !(between > 0))
        return s->squared;
    if (isnan(whole))
        return s->magnitude * s->magnitude;
    const double least = -1 / ((double)groups - 1),
                 r = fmin(fmax((whole * whole - s->plain_squared) / between, least), 1);
    return fmax(s->squared + r * (s->sum * s->sum - s->squared), 0);
}

static void error_row(const struct rows_job *job, size_t row, float *to)
{
    const struct relight *r = job->relight;
    struct error_sums sums[RELIGHT_KINDS][WIDTH_MOST] = {{{0}}};
    for (size_t p = 0; p < r->parts; p++) {
        const struct relight_part *part = &r->part[p];
        const float *from = values_of(job->in, part->error, part->offset, row);
        for (size_t i = 0; i < r->width; i++)
            add_error(&sums[part->kind][i], (double)from[i], job->weight[3 * p + i % 3]);
    }
    const float *whole = r->sum_error == RELIGHT_NONE ? NULL
                                                      : values_of(job->in, r->sum_error, 0, row);
    const size_t groups = r->groups.count + r->whole;
    for (size_t i = 0; i < r->width; i++) {
        const double suns = sums[RELIGHT_SUN][i].magnitude,
                     points = sums[RELIGHT_POINT][i].magnitude,
                     of_groups = variance_of_groups(&sums[RELIGHT_GROUP][i], groups,
                                                    whole ? (double)whole[i] : (double)NAN);
        to[i] =
            (float)sqrt(of_groups + sums[RELIGHT_SKY][i].squared + suns * suns + points * points);
    }
}

static struct error *do_rows(void *context, size_t index, int thread)
{
    const struct rows_job *job = context;
    const size_t width = job->relight->width, first = index * CHUNK,
                 end = first + CHUNK < job->rows ? first + CHUNK : job->rows;
    (void)thread;
    for (size_t row = first; row < end; row++) {
        float *light = job->light + row * width,
              *error = job->error ? job->error + row * width : NULL;
        const bool captured = is_captured(job, row);
        if (captured && job->basis && cluster_of(job, row) >= job->relight->clusters)
            return error_new("column pca_cluster: expected 0 to %zu where pca is known, got %d",
                             job->relight->clusters - 1,
                             column_i32(&job->in->columns[job->relight->cluster])[row]);
        for (size_t i = 0; i < width && !captured; i++)
            light[i] = NAN;
        for (size_t i = 0; i < width && !captured && error; i++)
            error[i] = NAN;
        if (captured)
            light_row(job, row, light);
        if (captured && error)
            error_row(job, row, error);
    }
    return NULL;
}

struct error *relight_rows(const struct relight *r, const double *weight, const struct table *in,
                           struct table *out, int threads)
{
    struct error *err = table_resize(out, in->rows);
    if (err)
        return err;
    table_copy_rows(out, 0, in, 0, in->rows);
    const struct column *error =
        r->errors ? table_column(out, r->surface ? "irradiance_error" : "sh_error") : NULL;
    struct rows_job job = {.relight = r,
                           .weight = weight,
                           .in = in,
                           .light = column_f32(table_column(out, light_name(r))),
                           .error = error ? column_f32(error) : NULL,
                           .rows = in->rows};
    if (r->compressed)
        err = array_create(&job.basis, r->basis.rows * r->width, sizeof *job.basis);
    for (size_t row = 0; row < r->basis.rows && !err; row++)
        add_light(&job, true, &r->basis, row, job.basis + row * r->width);
    if (!err)
        err = threads_for(threads, (in->rows + CHUNK - 1) / CHUNK, do_rows, &job);
    free(job.basis);
    return err;
}
