/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Golub, Van Loan, "Matrix Computations", 4th ed., 2013, sec. 8.5: Jacobi's rotations. */
#include "span.h"
#include "lattice.h"

#include <math.h>
#include <string.h>

void span_axes(double m[3][3], double axis[3][3])
{
    for (int k = 0; k < 9; k++)
        axis[k / 3][k % 3] = k % 4 == 0;
    for (int sweep = 0; sweep < 3 * 16; sweep++) {
        const int i = sweep % 3, j = (i + 1) % 3;
        if (fabs(m[i][j]) <= 0x1p-52 * sqrt(fabs(m[i][i] * m[j][j])))
            continue;
        const double theta = (m[j][j] - m[i][i]) / (2 * m[i][j]),
                     t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
        const double c = 1 / sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; k++) {
            const double x = m[k][i], y = m[k][j];
            m[k][i] = c * x - s * y;
            m[k][j] = s * x + c * y;
        }
        for (int k = 0; k < 3; k++) {
            const double x = m[i][k], y = m[j][k], p = axis[i][k], q = axis[j][k];
            m[i][k] = c * x - s * y;
            m[j][k] = s * x + c * y;
            axis[i][k] = c * p - s * q;
            axis[j][k] = s * p + c * q;
        }
    }
}

/* Sums of whole numbers below 2^42, and of products of two, of up to 2^31 sites: exact. */
static void find_moments(struct span_frame *frame, size_t count, const double *site,
                         const unsigned char *used, double moment[3][3])
{
    lattice_volume sum[3] = {0}, product[3][3] = {{0}};
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        n += !used || used[i];
        for (int k = 0; k < 3 && (!used || used[i]); k++)
            sum[k] += lattice_whole(site[3 * i + (size_t)k]);
    }
    for (int k = 0; k < 3; k++)
        frame->middle[k] = n ? (double)(sum[k] / (lattice_volume)n) : 0;
    for (size_t i = 0; i < count; i++)
        for (int j = 0; j < 9 && (!used || used[i]); j++)
            product[j / 3][j % 3] +=
                (lattice_volume)lattice_whole(site[3 * i + (size_t)(j / 3)] -
                                              frame->middle[j / 3]) *
                lattice_whole(site[3 * i + (size_t)(j % 3)] - frame->middle[j % 3]);
    for (int j = 0; j < 9; j++)
        moment[j / 3][j % 3] = (double)product[j / 3][j % 3];
}

/* Coordinates of a place along the frame's axes, from its middle. */
static void along_axes(const struct span_frame *frame, const double p[3], double x[3])
{
    for (int i = 0; i < 3; i++)
        x[i] = frame->axis[i][0] * (p[0] - frame->middle[0]) +
               frame->axis[i][1] * (p[1] - frame->middle[1]) +
               frame->axis[i][2] * (p[2] - frame->middle[2]);
}

void span_find(struct span_frame *frame, size_t count, const double *site,
               const unsigned char *used, int corners)
{
    double moment[3][3], axis[3][3];
    int order[3] = {0, 1, 2};
    *frame = (struct span_frame){.off = 0};
    find_moments(frame, count, site, used, moment);
    span_axes(moment, axis);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 2; j++)
            if (moment[order[j]][order[j]] < moment[order[j + 1]][order[j + 1]]) {
                const int swap = order[j];
                order[j] = order[j + 1];
                order[j + 1] = swap;
            }
    memcpy(frame->axis[0], axis[order[0]], sizeof axis[0]);
    memcpy(frame->axis[1], axis[order[1]], sizeof axis[1]);
    for (int k = 0; k < 3; k++) {
        const double *a = frame->axis[0], *b = frame->axis[1];
        frame->axis[2][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    }
    for (size_t i = 0; i < count; i++) {
        double x[3];
        if (used && !used[i])
            continue;
        along_axes(frame, site + 3 * i, x);
        frame->off = fmax(frame->off, corners == 3 ? fabs(x[2]) : hypot(x[1], x[2]));
    }
}

void span_flatten(const struct span_frame *frame, int corners, const double p[3], double flat[3])
{
    const double middle = (double)((uint64_t)1 << (LATTICE_BITS - 1));
    double x[3];
    along_axes(frame, p, x);
    for (int k = 0; k < 3; k++)
        flat[k] = k < corners - 1 ? x[k] / 4 + middle : 0;
}
