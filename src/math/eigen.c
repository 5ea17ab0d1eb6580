/* SPDX-License-Identifier: Apache-2.0 */
#include "math/eigen.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 8, STEPS = 24, SWEEPS = 40, SPARE = 16 };

double eigen_dot(const double *a, const double *b, size_t count)
{
    double lane[LANES] = {0}, sum = 0;
    size_t i = 0;
    for (; i + LANES <= count; i += LANES)
        for (size_t l = 0; l < LANES; l++)
            lane[l] += a[i + l] * b[i + l];
    for (; i < count; i++)
        sum += a[i] * b[i];
    for (size_t l = 0; l < LANES; l++)
        sum += lane[l];
    return sum;
}

/* -- small matrices: Jacobi's rotations -------------------------------------------------------- */

/* Turns rows p and q of count numbers by an angle of cosine c and sine s. */
static void turn(double *p, double *q, size_t count, double c, double s)
{
    for (size_t i = 0; i < count; i++) {
        const double x = p[i], y = q[i];
        p[i] = c * x - s * y;
        q[i] = s * x + c * y;
    }
}

/* Makes a[p][q] 0; rows of v are the vectors. */
static void rotate(double *a, double *v, size_t n, size_t p, size_t q)
{
    const double between = a[p * n + q];
    if (between == 0)
        return;
    const double half = (a[q * n + q] - a[p * n + p]) / (2 * between),
                 tangent = (half < 0 ? -1 : 1) / (fabs(half) + sqrt(half * half + 1)),
                 c = 1 / sqrt(tangent * tangent + 1), s = tangent * c;
    turn(a + p * n, a + q * n, n, c, s);
    for (size_t i = 0; i < n; i++)
        turn(a + i * n + p, a + i * n + q, 1, c, s);
    turn(v + p * n, v + q * n, n, c, s);
}

/* Makes *a, n * n, diagonal, and rows of *v its vectors. */
static void diagonalise(double *a, double *v, size_t n)
{
    memset(v, 0, n * n * sizeof *v);
    for (size_t i = 0; i < n; i++)
        v[i * n + i] = 1;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double off = 0, all = 0;
        for (size_t i = 0; i < n * n; i++) {
            all += a[i] * a[i];
            off += i / n == i % n ? 0 : a[i] * a[i];
        }
        if (!(off > 1e-30 * all))
            return;
        for (size_t p = 0; p + 1 < n; p++)
            for (size_t q = p + 1; q < n; q++)
                rotate(a, v, n, p, q);
    }
}

/* -- large ones: a block of vectors ------------------------------------------------------------ */

struct block {
    const double *matrix;
    size_t size, count;
    double *from, *to; /* count * size */
};

static struct error *multiply(void *context, size_t index, int thread)
{
    const struct block *b = context;
    (void)thread;
    for (size_t i = 0; i < b->size; i++)
        b->to[index * b->size + i] =
            eigen_dot(b->matrix + i * b->size, b->from + index * b->size, b->size);
    return NULL;
}

/* Anything that is the same everywhere and leans to no vector (Steele et al., "Fast splittable
 * pseudorandom number generators", 2014). */
static double any_number(uint64_t index)
{
    uint64_t z = (index + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 4503599627370496.0 - 1;
}

/* Takes from vector `index` what it has of those before it, twice, since once leaves rounding. */
static double make_orthogonal(double *vector, size_t size, size_t index)
{
    double *v = vector + index * size;
    const double before = sqrt(eigen_dot(v, v, size));
    for (int turns = 0; turns < 2; turns++)
        for (size_t k = 0; k < index; k++) {
            const double *u = vector + k * size, part = eigen_dot(u, v, size);
            for (size_t i = 0; i < size; i++)
                v[i] -= part * u[i];
        }
    const double length = sqrt(eigen_dot(v, v, size));
    for (size_t i = 0; i < size && length > 0; i++)
        v[i] /= length;
    return before > 0 ? length / before : 0;
}

/* A vector of which nothing is left gets any other in its place. */
static void make_orthonormal(double *vector, size_t size, size_t count)
{
    for (size_t k = 0; k < count; k++)
        for (uint64_t attempt = 0; !(make_orthogonal(vector, size, k) > 1e-10) && attempt < 8;
             attempt++)
            for (size_t i = 0; i < size; i++)
                vector[k * size + i] = any_number((attempt * count + k) * size + i);
}

/* Of a diagonal matrix, which value is the k-th, largest first. */
static void order_values(const double *a, size_t n, size_t *order)
{
    for (size_t k = 0; k < n; k++) {
        size_t at = k;
        for (; at > 0 && a[order[at - 1] * (n + 1)] < a[k * (n + 1)]; at--)
            order[at] = order[at - 1];
        order[at] = k;
    }
}

/* Turns the block so that its vectors are those of the matrix within it: b->to is the matrix times
 * b->from, and is overwritten. */
static struct error *settle(struct block *b, size_t count, double *value, double *vector)
{
    const size_t n = b->count;
    double *a = NULL, *v = NULL;
    size_t *order = NULL;
    struct error *err = array_create(&a, n * n, sizeof *a);
    if (!err)
        err = array_create(&v, n * n, sizeof *v);
    if (!err)
        err = array_create(&order, n, sizeof *order);
    for (size_t i = 0; i < n && !err; i++)
        for (size_t k = 0; k <= i; k++)
            a[i * n + k] = a[k * n + i] =
                eigen_dot(b->from + i * b->size, b->to + k * b->size, b->size);
    if (!err) {
        diagonalise(a, v, n);
        order_values(a, n, order);
        memset(vector, 0, count * b->size * sizeof *vector);
    }
    for (size_t k = 0; k < count && !err; k++) {
        value[k] = fmax(a[order[k] * (n + 1)], 0);
        for (size_t j = 0; j < n; j++)
            for (size_t i = 0; i < b->size; i++)
                vector[k * b->size + i] += v[order[k] * n + j] * b->from[j * b->size + i];
    }
    free(a);
    free(v);
    free(order);
    return err;
}

struct error *eigen_leading(const double *matrix, size_t size, size_t count, double *value,
                            double *vector, int threads)
{
    const size_t wanted = count + count / 2 + SPARE;
    struct block b = {.matrix = matrix, .size = size, .count = wanted < size ? wanted : size};
    struct error *err = array_create(&b.from, b.count * size, sizeof *b.from);
    if (!err)
        err = array_create(&b.to, b.count * size, sizeof *b.to);
    for (size_t i = 0; i < b.count * size && !err; i++)
        b.to[i] = b.count == size ? (double)(i / size == i % size) : any_number(i);
    /* a block of all vectors is at its end from the start */
    for (int step = b.count == size ? STEPS - 1 : 0; step < STEPS && !err; step++) {
        double *swap = b.from;
        b.from = b.to;
        b.to = swap;
        make_orthonormal(b.from, size, b.count);
        err = threads_for(threads, b.count, multiply, &b);
    }
    if (!err)
        err = settle(&b, count, value, vector);
    free(b.from);
    free(b.to);
    return err;
}
