/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/pca.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/eigen.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK = 64, BAND = 32, TURNS = 16 };

static size_t chunks_of(size_t count, size_t chunk)
{
    return (count + chunk - 1) / chunk;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* -- all rows ---------------------------------------------------------------------------------- */

/* Row less the mean. */
static void centre(const struct pca *pca, size_t row, double *to)
{
    const float *from = pca->values + row * pca->numbers;
    for (size_t i = 0; i < pca->numbers; i++)
        to[i] = (double)from[i] - pca->mean[i];
}

struct all_job {
    struct pca *pca;
    double *matrix; /* numbers * numbers */
    double *room;   /* a row a thread */
};

/* Rows of the sum of products: the upper right half of a band of it. */
static struct error *sum_products(void *context, size_t index, int thread)
{
    const struct all_job *job = context;
    const size_t n = job->pca->numbers, first = index * BAND, end = least(first + BAND, n);
    double *row = job->room + (size_t)thread * n;
    for (size_t r = 0; r < job->pca->rows; r++) {
        centre(job->pca, r, row);
        for (size_t i = first; i < end; i++) {
            double *to = job->matrix + i * n;
            const double value = row[i];
            for (size_t j = first; j < n; j++)
                to[j] += value * row[j];
        }
    }
    return NULL;
}

static struct error *place_rows(void *context, size_t index, int thread)
{
    const struct all_job *job = context;
    struct pca *pca = job->pca;
    double *row = job->room + (size_t)thread * pca->numbers;
    for (size_t r = index * CHUNK; r < least((index + 1) * CHUNK, pca->rows); r++) {
        centre(pca, r, row);
        for (size_t k = 0; k < pca->count; k++)
            pca->place[r * pca->count + k] =
                eigen_dot(row, pca->vector + k * pca->numbers, pca->numbers);
    }
    return NULL;
}

static void find_mean(struct pca *pca)
{
    for (size_t r = 0; r < pca->rows; r++)
        for (size_t i = 0; i < pca->numbers; i++)
            pca->mean[i] += (double)pca->values[r * pca->numbers + i];
    for (size_t i = 0; i < pca->numbers; i++)
        pca->mean[i] /= (double)pca->rows;
}

static struct error *find_vectors(struct all_job *job, int threads)
{
    struct pca *pca = job->pca;
    const size_t n = pca->numbers;
    double *value = NULL;
    struct error *err = array_create(&value, pca->count, sizeof *value);
    if (!err)
        err = array_create(&job->matrix, n * n, sizeof *job->matrix);
    if (!err)
        err = threads_for(threads, chunks_of(n, BAND), sum_products, job);
    for (size_t i = 0; i < n && !err; i++)
        for (size_t j = 0; j < i; j++)
            job->matrix[i * n + j] = job->matrix[j * n + i];
    if (!err)
        err = eigen_leading(job->matrix, n, pca->count, value, pca->vector, threads);
    free(job->matrix);
    free(value);
    return err;
}

struct error *pca_start(struct pca *pca, const float *values, size_t rows, size_t numbers,
                        size_t most, int threads)
{
    *pca = (struct pca){
        .values = values, .rows = rows, .numbers = numbers, .count = least(numbers, 2 * most + 32)};
    struct all_job job = {.pca = pca};
    struct error *err = array_create(&pca->mean, numbers, sizeof *pca->mean);
    if (!err)
        err = array_create(&pca->vector, pca->count * numbers, sizeof *pca->vector);
    if (!err)
        err = array_create(&pca->place, rows * pca->count, sizeof *pca->place);
    if (!err)
        err = array_create(&job.room, (size_t)threads * numbers, sizeof *job.room);
    if (!err) {
        find_mean(pca);
        err = find_vectors(&job, threads);
    }
    if (!err)
        err = threads_for(threads, chunks_of(rows, CHUNK), place_rows, &job);
    free(job.room);
    return err;
}

void pca_clear(struct pca *pca)
{
    free(pca->mean);
    free(pca->vector);
    free(pca->place);
    *pca = (struct pca){0};
}

/* -- clusters ---------------------------------------------------------------------------------- */

struct fit_job {
    const struct pca *pca;
    struct pca_fit *fit;
    double *mean;    /* clusters * count, in places */
    double *vector;  /* clusters * vectors * count */
    size_t *changed; /* of a chunk of rows, how many went to another cluster */
    double *room;    /* count a thread */
};

static double distance(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

/* Each row goes to the nearest of some rows that lie far apart: the first is farthest from the
 * mean, the next is farthest from those that are. */
static struct error *spread(struct fit_job *job)
{
    const struct pca *pca = job->pca;
    const size_t count = pca->count;
    double *far = NULL, *origin = NULL;
    struct error *err = array_create(&far, pca->rows, sizeof *far);
    if (!err)
        err = array_create(&origin, count, sizeof *origin);
    for (size_t r = 0; r < pca->rows && !err; r++)
        far[r] = distance(pca->place + r * count, origin, count);
    for (size_t c = 0; c < job->fit->clusters && !err; c++) {
        size_t seed = 0;
        for (size_t r = 1; r < pca->rows; r++)
            if (far[r] > far[seed])
                seed = r;
        for (size_t r = 0; r < pca->rows; r++) {
            const double d = distance(pca->place + r * count, pca->place + seed * count, count);
            if (c && d >= far[r])
                continue;
            far[r] = d;
            job->fit->cluster[r] = (int32_t)c;
        }
    }
    free(far);
    free(origin);
    return err;
}

/* Mean and vectors of the rows of a cluster; one without rows stays as it was. */
static struct error *fit_cluster(void *context, size_t index, int thread)
{
    const struct fit_job *job = context;
    const struct pca *pca = job->pca;
    const size_t n = pca->count, vectors = job->fit->vectors;
    double *mean = job->mean + index * n, *row = job->room + (size_t)thread * n, *matrix = NULL,
           *value = NULL, members = 0;
    struct error *err = array_create(&matrix, n * n, sizeof *matrix);
    if (!err)
        err = array_create(&value, vectors, sizeof *value);
    for (size_t r = 0; r < pca->rows; r++)
        members += job->fit->cluster[r] == (int32_t)index;
    if (err || members == 0)
        goto done;
    memset(mean, 0, n * sizeof *mean);
    for (size_t r = 0; r < pca->rows; r++)
        for (size_t i = 0; i < n && job->fit->cluster[r] == (int32_t)index; i++)
            mean[i] += pca->place[r * n + i] / members;
    for (size_t r = 0; r < pca->rows; r++) {
        if (job->fit->cluster[r] != (int32_t)index)
            continue;
        for (size_t i = 0; i < n; i++)
            row[i] = pca->place[r * n + i] - mean[i];
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++)
                matrix[i * n + j] += row[i] * row[j];
    }
    err = eigen_leading(matrix, n, vectors, value, job->vector + index * vectors * n, 1);
done:
    free(matrix);
    free(value);
    return err;
}

/* What a cluster leaves of a row; room: count numbers, which become the row less the mean. */
static double left_by(const struct fit_job *job, size_t cluster, size_t row, double *room)
{
    const size_t n = job->pca->count, vectors = job->fit->vectors;
    const double *place = job->pca->place + row * n, *mean = job->mean + cluster * n;
    for (size_t i = 0; i < n; i++)
        room[i] = place[i] - mean[i];
    double left = eigen_dot(room, room, n);
    for (size_t k = 0; k < vectors; k++) {
        const double part = eigen_dot(room, job->vector + (cluster * vectors + k) * n, n);
        left -= part * part;
    }
    return left;
}

static struct error *choose_clusters(void *context, size_t index, int thread)
{
    const struct fit_job *job = context;
    double *room = job->room + (size_t)thread * job->pca->count;
    job->changed[index] = 0;
    for (size_t r = index * CHUNK; r < least((index + 1) * CHUNK, job->pca->rows); r++) {
        const size_t was = (size_t)job->fit->cluster[r];
        size_t best = was;
        double left = left_by(job, was, r, room);
        for (size_t c = 0; c < job->fit->clusters; c++) {
            const double other = c == was ? left : left_by(job, c, r, room);
            if (other < left) {
                best = c;
                left = other;
            }
        }
        job->changed[index] += best != was;
        job->fit->cluster[r] = (int32_t)best;
    }
    return NULL;
}

static struct error *find_clusters(struct fit_job *job, int threads)
{
    const size_t chunks = chunks_of(job->pca->rows, CHUNK);
    struct error *err = spread(job);
    for (size_t turn = 0, changed = 1; turn < TURNS && changed && !err; turn++) {
        err = threads_for(threads, job->fit->clusters, fit_cluster, job);
        if (!err)
            err = threads_for(threads, chunks, choose_clusters, job);
        changed = 0;
        for (size_t c = 0; c < chunks && !err; c++)
            changed += job->changed[c];
    }
    return err;
}

/* Adds a vector in places, as one of numbers. */
static void unplace(const struct pca *pca, const double *place, double *to)
{
    for (size_t k = 0; k < pca->count; k++)
        for (size_t i = 0; i < pca->numbers; i++)
            to[i] += place[k] * pca->vector[k * pca->numbers + i];
}

static struct error *store_basis(void *context, size_t index, int thread)
{
    const struct fit_job *job = context;
    const struct pca *pca = job->pca;
    const size_t vectors = job->fit->vectors, cluster = index / (1 + vectors),
                 k = index % (1 + vectors);
    double *sum = NULL;
    struct error *err = array_create(&sum, pca->numbers, sizeof *sum);
    (void)thread;
    if (err)
        return err;
    if (!k)
        memcpy(sum, pca->mean, pca->numbers * sizeof *sum);
    unplace(pca,
            k ? job->vector + (cluster * vectors + k - 1) * pca->count
              : job->mean + cluster * pca->count,
            sum);
    for (size_t i = 0; i < pca->numbers; i++)
        job->fit->basis[index * pca->numbers + i] = (float)sum[i];
    free(sum);
    return NULL;
}

static struct error *store_weights(void *context, size_t index, int thread)
{
    const struct fit_job *job = context;
    const size_t n = job->pca->count, vectors = job->fit->vectors;
    double *room = job->room + (size_t)thread * n;
    for (size_t r = index * CHUNK; r < least((index + 1) * CHUNK, job->pca->rows); r++) {
        const size_t cluster = (size_t)job->fit->cluster[r];
        left_by(job, cluster, r, room);
        for (size_t k = 0; k < vectors; k++)
            job->fit->weight[r * vectors + k] =
                (float)eigen_dot(room, job->vector + (cluster * vectors + k) * n, n);
    }
    return NULL;
}

struct error *pca_fit(const struct pca *pca, size_t vectors, size_t clusters, struct pca_fit *fit,
                      int threads)
{
    pca_fit_clear(fit);
    *fit = (struct pca_fit){.vectors = vectors, .clusters = clusters};
    struct fit_job job = {.pca = pca, .fit = fit};
    const size_t chunks = chunks_of(pca->rows, CHUNK), basis = clusters * (1 + vectors);
    struct error *err = array_create(&fit->basis, basis * pca->numbers, sizeof *fit->basis);
    if (!err)
        err = array_create(&fit->weight, pca->rows * vectors, sizeof *fit->weight);
    if (!err)
        err = array_create(&fit->cluster, pca->rows, sizeof *fit->cluster);
    if (!err)
        err = array_create(&job.mean, clusters * pca->count, sizeof *job.mean);
    if (!err)
        err = array_create(&job.vector, clusters * vectors * pca->count, sizeof *job.vector);
    if (!err)
        err = array_create(&job.changed, chunks, sizeof *job.changed);
    if (!err)
        err = array_create(&job.room, (size_t)threads * pca->count, sizeof *job.room);
    if (!err)
        err = find_clusters(&job, threads);
    if (!err)
        err = threads_for(threads, basis, store_basis, &job);
    if (!err)
        err = threads_for(threads, chunks, store_weights, &job);
    free(job.mean);
    free(job.vector);
    free(job.changed);
    free(job.room);
    return err;
}

void pca_fit_clear(struct pca_fit *fit)
{
    free(fit->basis);
    free(fit->weight);
    free(fit->cluster);
    *fit = (struct pca_fit){0};
}

/* -- errors ------------------------------------------------------------------------------------ */

struct error_job {
    const struct pca *pca;
    const struct pca_fit *fit;
    const size_t *width;
    size_t columns;
    double *sum; /* of a chunk of rows: of each column what is left, then of each all */
};

static struct error *measure_rows(void *context, size_t index, int thread)
{
    const struct error_job *job = context;
    const struct pca *pca = job->pca;
    const size_t n = pca->numbers, vectors = job->fit->vectors;
    double *sum = job->sum + 2 * index * job->columns, *row = NULL;
    struct error *err = array_create(&row, n, sizeof *row);
    (void)thread;
    for (size_t r = index * CHUNK; r < least((index + 1) * CHUNK, pca->rows) && !err; r++) {
        const float *values = pca->values + r * n,
                    *basis = job->fit->basis + (size_t)job->fit->cluster[r] * (1 + vectors) * n;
        for (size_t i = 0; i < n; i++)
            row[i] = (double)values[i] - (double)basis[i];
        for (size_t k = 0; k < vectors; k++) {
            const double weight = (double)job->fit->weight[r * vectors + k];
            for (size_t i = 0; i < n; i++)
                row[i] -= weight * (double)basis[(1 + k) * n + i];
        }
        for (size_t c = 0, first = 0; c < job->columns; first += job->width[c++])
            for (size_t i = first; i < first + job->width[c]; i++) {
                sum[c] += row[i] * row[i];
                sum[job->columns + c] += (double)values[i] * (double)values[i];
            }
    }
    free(row);
    return err;
}

struct error *pca_error(const struct pca *pca, const struct pca_fit *fit, const size_t *width,
                        size_t columns, double *left, double *all, int threads)
{
    const size_t chunks = chunks_of(pca->rows, CHUNK);
    struct error_job job = {.pca = pca, .fit = fit, .width = width, .columns = columns};
    struct error *err = array_create(&job.sum, 2 * chunks * columns, sizeof *job.sum);
    if (!err)
        err = threads_for(threads, chunks, measure_rows, &job);
    for (size_t c = 0; c < columns && !err; c++) {
        left[c] = all[c] = 0;
        for (size_t i = 0; i < chunks; i++) {
            left[c] += job.sum[2 * i * columns + c];
            all[c] += job.sum[(2 * i + 1) * columns + c];
        }
    }
    free(job.sum);
    return err;
}
