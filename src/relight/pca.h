/* SPDX-License-Identifier: Apache-2.0 */
/* pca: rows of numbers as a few numbers each: the mean plus a sum of a few vectors, which are the
 * same for all rows (principal component analysis) or for all of a cluster.
 *
 * The vectors are those that leave the least sum of squares. Clusters are found by turns: each is
 * fitted to its rows, and each row goes to the cluster that leaves the least of it (Sloan et al.,
 * "Clustered principal components for precomputed radiance transfer", SIGGRAPH 2003). They start
 * with the rows nearest to some that lie far from each other, and are looked for within the first
 * vectors of all rows, 2 K + 32 of them, so that they cost little.
 *
 *     struct pca pca = {0};
 *     struct pca_fit fit = {0};
 *     err = pca_start(&pca, values, rows, numbers, 16, threads);
 *     ... err = pca_fit(&pca, 16, 1, &fit, threads);
 *     ... err = pca_error(&pca, &fit, width, columns, left, all, threads);
 *
 * The same bits on every machine and for any number of threads.
 */
#ifndef PCA_H
#define PCA_H

#include <stddef.h>
#include <stdint.h>

struct error;

/* 8 numbers^2 bytes of memory are needed to find the vectors, 8 (2 K + 32) a row to use them. */
enum { PCA_NUMBERS_MOST = 8192, PCA_VECTORS_MOST = 128, PCA_CLUSTERS_MOST = 256 };

struct pca {
    const float *values; /* rows * numbers; borrowed */
    size_t rows, numbers;
    size_t count;   /* vectors that are known */
    double *mean;   /* numbers */
    double *vector; /* count * numbers */
    double *place;  /* rows * count: of each row less the mean */
};

struct pca_fit {
    size_t vectors, clusters;
    float *basis;     /* clusters * (1 + vectors) * numbers: of each its mean, then its vectors */
    float *weight;    /* rows * vectors: what its cluster's vectors are multiplied by */
    int32_t *cluster; /* rows */
};

/* Looks at rows; most: the most vectors that will be asked for. There is a row at least. */
struct error *pca_start(struct pca *pca, const float *values, size_t rows, size_t numbers,
                        size_t most, int threads);
void pca_clear(struct pca *pca);

/* Makes *fit, which is {0} or of an earlier call, one of so many vectors and clusters. */
struct error *pca_fit(const struct pca *pca, size_t vectors, size_t clusters, struct pca_fit *fit,
                      int threads);
void pca_fit_clear(struct pca_fit *fit);

/* Sums of squares over all rows, for each of some columns of which width[i] numbers make up a row:
 * of what the fit, as it is stored, leaves, and of the values. */
struct error *pca_error(const struct pca *pca, const struct pca_fit *fit, const size_t *width,
                        size_t columns, double *left, double *all, int threads);

#endif
