/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/compress.h"
#include "base/array.h"
#include "base/error.h"
#include "relight/compressed.h"
#include "relight/pca.h"
#include "relight/relight.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TABLE_MOST = 64 };

/* The parts' columns of a stream, and their numbers, a row a probe that has light. */
struct parts {
    struct relight relight;
    struct column *column; /* with their data, which are borrowed; owned */
    size_t *width;         /* of each; owned */
    size_t columns, numbers;
    double lamps;  /* what values of transfer_points are multiplied by */
    float *values; /* rows * numbers; owned */
    size_t *probe; /* of each row; owned */
    size_t rows;
};

static void parts_clear(struct parts *p)
{
    relight_clear(&p->relight);
    free(p->column);
    free(p->width);
    free(p->values);
    free(p->probe);
}

static void find_columns(struct parts *p, const struct table *probes)
{
    const struct relight *r = &p->relight;
    for (size_t i = 0; i < r->parts; i++) {
        const struct relight_part *part = &r->part[i];
        /* the light of a stream without groups stays as it is */
        if (part->offset || (r->whole && part->kind == RELIGHT_GROUP))
            continue;
        p->column[p->columns] = probes->columns[part->column];
        p->width[p->columns] = p->column[p->columns].width;
        p->numbers += p->width[p->columns++];
    }
}

static bool has_light(const struct parts *p, size_t probe)
{
    bool has = true;
    for (size_t c = 0; c < p->columns; c++)
        has = has && !isnan(column_f32(&p->column[c])[probe * p->width[c]]);
    return has;
}

static void gather_rows(struct parts *p, size_t probes)
{
    for (size_t i = 0; i < probes; i++) {
        if (!has_light(p, i))
            continue;
        float *to = p->values + p->rows * p->numbers;
        for (size_t c = 0; c < p->columns; to += p->width[c++])
            memcpy(to, column_f32(&p->column[c]) + i * p->width[c], p->width[c] * sizeof *to);
        p->probe[p->rows++] = i;
    }
}

static bool is_of_lamps(const struct column *column)
{
    return !strcmp(column->name, "transfer_points");
}

/* What a lamp of radiant intensity 1 gives goes by the unit of length, squared: of a scene in
 * millimetres nothing would be kept of it, of one in kilometres nothing of all else. So its numbers
 * are made as large as the others, in the root mean square. */
static void scale_lamps(struct parts *p)
{
    double sum[2] = {0}, count[2] = {0};
    p->lamps = 1;
    const float *from = p->values;
    for (size_t i = 0; i < p->rows * p->columns; from += p->width[i++ % p->columns]) {
        const int of = is_of_lamps(&p->column[i % p->columns]);
        const size_t width = p->width[i % p->columns];
        for (size_t k = 0; k < width; k++)
            sum[of] += (double)from[k] * (double)from[k];
        count[of] += (double)width;
    }
    if (!(sum[0] > 0 && sum[1] > 0))
        return;
    p->lamps = sqrt(sum[0] / count[0] / (sum[1] / count[1]));
    float *to = p->values;
    for (size_t i = 0; i < p->rows * p->columns; to += p->width[i++ % p->columns])
        for (size_t k = 0; is_of_lamps(&p->column[i % p->columns]) && k < p->width[i % p->columns];
             k++)
            to[k] = (float)((double)to[k] * p->lamps);
}

static struct error *parts_of(struct parts *p, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    struct error *err = NULL;
    if (!probes)
        return error_new("expected a table probe, there is none");
    if (header_key(&stream->header, COMPRESSED_KEY))
        return error_new("the stream is compressed (key %s): expected one that is not",
                         COMPRESSED_KEY);
    err = relight_from_header(&p->relight, &stream->header);
    if (!err)
        err = relight_find(&p->relight, probes);
    if (!err)
        err = array_create(&p->column, p->relight.parts, sizeof *p->column);
    if (!err)
        err = array_create(&p->width, p->relight.parts, sizeof *p->width);
    if (err)
        return err;
    find_columns(p, probes);
    if (p->numbers > PCA_NUMBERS_MOST)
        return error_new("the parts of a probe's light are %zu numbers: expected at most %d",
                         p->numbers, PCA_NUMBERS_MOST);
    err = array_create(&p->values, probes->rows * p->numbers, sizeof *p->values);
    if (!err)
        err = array_create(&p->probe, probes->rows, sizeof *p->probe);
    if (!err)
        gather_rows(p, probes->rows);
    if (!err)
        scale_lamps(p);
    return err;
}

/* The most vectors that so many clusters can have. */
static size_t vectors_most(const struct parts *p, size_t clusters)
{
    const size_t rows = p->rows / clusters, of_rows = rows ? rows - 1 : 0,
                 most = of_rows < p->numbers ? of_rows : p->numbers;
    return most < PCA_VECTORS_MOST ? most : PCA_VECTORS_MOST;
}

static struct error *check_vectors(const struct parts *p, size_t vectors, size_t clusters)
{
    const size_t most = vectors_most(p, clusters);
    if (vectors <= most)
        return NULL;
    return error_new("--compress: expected at most %zu vectors in each of %zu clusters of %zu "
                     "probes with light, of %zu numbers each, got %zu",
                     most, clusters, p->rows, p->numbers, vectors);
}

/* -- a stream ---------------------------------------------------------------------------------- */

static double share(double left, double all)
{
    return all > 0 ? sqrt(left / all) : 0;
}

/* Makes the new table the first. */
static struct error *add_basis(struct stream *stream, const struct parts *p,
                               const struct pca_fit *fit)
{
    struct table *basis = NULL;
    struct error *err = stream_add_table(stream, COMPRESSED_TABLE, &basis);
    for (size_t c = 0; c < p->columns && !err; c++)
        err = table_add_column(basis, p->column[c].name, COLUMN_F32, p->width[c], NULL);
    if (!err)
        err = table_resize(basis, fit->clusters * (1 + fit->vectors));
    if (err)
        return err;
    const float *from = fit->basis;
    for (size_t row = 0; row < basis->rows; row++)
        for (size_t c = 0; c < p->columns; from += p->width[c++]) {
            const double scale = is_of_lamps(&p->column[c]) ? p->lamps : 1;
            float *to = column_f32(&basis->columns[c]) + row * p->width[c];
            for (size_t k = 0; k < p->width[c]; k++)
                to[k] = (float)((double)from[k] / scale);
        }
    const struct table last = *basis;
    const size_t before = (size_t)(basis - stream->tables);
    memmove(stream->tables + 1, stream->tables, before * sizeof last);
    stream->tables[0] = last;
    return NULL;
}

static struct error *add_rows(struct table *probes, const struct parts *p,
                              const struct pca_fit *fit)
{
    struct column *pca, *cluster;
    struct error *err = table_add_column(probes, "pca", COLUMN_F32, fit->vectors, &pca);
    for (size_t r = 0; r < p->rows && !err; r++)
        memcpy(column_f32(pca) + p->probe[r] * fit->vectors, fit->weight + r * fit->vectors,
               fit->vectors * sizeof(float));
    if (!err && fit->clusters > 1)
        err = table_add_column(probes, "pca_cluster", COLUMN_I32, 1, &cluster);
    for (size_t r = 0; r < p->rows && !err && fit->clusters > 1; r++)
        column_i32(cluster)[p->probe[r]] = fit->cluster[r];
    return err;
}

/* Removes the parts' columns and their errors. */
static struct error *drop_columns(struct table *probes, const struct relight *r)
{
    char **name = NULL;
    size_t count = 0, copied = 0;
    struct error *err = array_create(&name, 2 * r->parts, sizeof *name);
    for (size_t i = 0; i < r->parts && !err; i++) {
        const struct relight_part *part = &r->part[i];
        if (part->offset || (r->whole && part->kind == RELIGHT_GROUP))
            continue;
        name[count++] = probes->columns[part->column].name;
        if (part->error != RELIGHT_NONE)
            name[count++] = probes->columns[part->error].name;
    }
    for (; copied < count && !err; copied += !err) {
        name[copied] = strdup(name[copied]);
        err = name[copied] ? NULL : error_memory();
    }
    for (size_t i = 0; i < count && !err; i++)
        table_remove_column(probes, name[i]);
    for (size_t i = 0; i < copied; i++)
        free(name[i]);
    free(name);
    return err;
}

static struct error *write_parts(struct stream *stream, const struct parts *p,
                                 const struct pca_fit *fit, const double *sums)
{
    double left = 0, all = 0;
    char key[COMPRESSED_KEY_ROOM];
    for (size_t c = 0; c < p->columns; c++) {
        left += sums[c];
        all += sums[p->columns + c];
    }
    struct error *err = add_basis(stream, p, fit); /* whose columns are those of the probes */
    struct table *probes = stream_table(stream, "probe");
    if (!err)
        err = drop_columns(probes, &p->relight);
    if (!err)
        err = add_rows(probes, p, fit);
    if (err)
        return err;
    compressed_key(&stream->header, &stream->tables[0], key);
    err = header_set_key(&stream->header, COMPRESSED_KEY, key);
    return err ? err : header_set_real(&stream->header, COMPRESSED_ERROR_KEY, share(left, all));
}

struct error *compress_stream(struct stream *stream, size_t vectors, size_t clusters, int threads)
{
    struct parts parts = {0};
    struct pca pca = {0};
    struct pca_fit fit = {0};
    double *sums = NULL;
    struct error *err = parts_of(&parts, stream);
    if (!err)
        err = check_vectors(&parts, vectors, clusters);
    if (!err)
        err = array_create(&sums, 2 * parts.columns, sizeof *sums);
    if (!err)
        err = pca_start(&pca, parts.values, parts.rows, parts.numbers, vectors, threads);
    if (!err)
        err = pca_fit(&pca, vectors, clusters, &fit, threads);
    if (!err)
        err =
            pca_error(&pca, &fit, parts.width, parts.columns, sums, sums + parts.columns, threads);
    if (!err)
        err = write_parts(stream, &parts, &fit, sums);
    free(sums);
    pca_fit_clear(&fit);
    pca_clear(&pca);
    parts_clear(&parts);
    return err;
}

/* -- a table ----------------------------------------------------------------------------------- */

static void print_line(const struct parts *p, const struct pca_fit *fit, const double *left,
                       const double *all, FILE *to)
{
    double left_sum = 0, all_sum = 0;
    for (size_t c = 0; c < p->columns; c++) {
        left_sum += left[c];
        all_sum += all[c];
    }
    const size_t bytes =
        p->rows * (fit->vectors * sizeof(float) + (fit->clusters > 1 ? sizeof(int32_t) : 0)) +
        fit->clusters * (1 + fit->vectors) * p->numbers * sizeof(float);
    fprintf(to, "%zu\t%zu\t%zu\t%.6g", fit->vectors, fit->clusters, bytes,
            share(left_sum, all_sum));
    for (size_t c = 0; c < p->columns; c++)
        fprintf(to, "\t%.6g", share(left[c], all[c]));
    fputc('\n', to);
}

struct error *compress_table(const struct stream *stream, size_t clusters, FILE *to, int threads)
{
    struct parts p = {0};
    struct pca pca = {0};
    struct pca_fit fit = {0};
    double *sums = NULL;
    struct error *err = parts_of(&p, stream);
    if (!err)
        err = check_vectors(&p, 1, clusters);
    const size_t most = err ? 0 : vectors_most(&p, clusters),
                 last = most < TABLE_MOST ? most : TABLE_MOST;
    if (!err)
        err = array_create(&sums, 2 * p.columns, sizeof *sums);
    if (!err)
        err = pca_start(&pca, p.values, p.rows, p.numbers, last, threads);
    if (!err) {
        fprintf(to, "# %zu probes of %zu numbers, %zu bytes\nvectors\tclusters\tbytes\tall", p.rows,
                p.numbers, p.rows * p.numbers * sizeof(float));
        for (size_t c = 0; c < p.columns; c++)
            fprintf(to, "\t%s", p.column[c].name);
        fputc('\n', to);
    }
    for (size_t vectors = 1; vectors <= last && !err; vectors *= 2) {
        err = pca_fit(&pca, vectors, clusters, &fit, threads);
        if (!err)
            err = pca_error(&pca, &fit, p.width, p.columns, sums, sums + p.columns, threads);
        if (!err)
            print_line(&p, &fit, sums, sums + p.columns, to);
    }
    free(sums);
    pca_fit_clear(&fit);
    pca_clear(&pca);
    parts_clear(&p);
    return err;
}
