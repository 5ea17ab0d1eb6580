/* SPDX-License-Identifier: Apache-2.0 */
/* capture_truth: what a probe's coefficients have to be, from closed forms and from quadrature of
 * closed forms.
 *
 * A truth is 3 * order^2 doubles, laid out as the coefficients are; the functions add to it. The
 * quadrature is Gauss and Legendre's over pieces on which the integrand is smooth, so its error is
 * far below any that sampling could show.
 *
 * Based on: Abramowitz and Stegun, "Handbook of Mathematical Functions", 1964: 25.4.29
 * (Gauss-Legendre), 8.14.1 (integrals of P_l). Duffy, "Quadrature over a pyramid or cube of
 * integrands with a singularity at a vertex", SIAM J. Numer. Anal. 19, 1982: the square that is
 * folded to a triangle. Ramamoorthi and Hanrahan, "An efficient representation for irradiance
 * environment maps", SIGGRAPH 2001, eq. 5: rotation of a zonal function. Lambert, "Photometria",
 * 1760: the irradiance from a polygon. Van Oosterom and Strackee, "The solid angle of a plane
 * triangle", IEEE Trans. Biomed. Eng. 30, 1983, eq. 8.
 */
#ifndef CAPTURE_TRUTH_H
#define CAPTURE_TRUTH_H

#include "libprobe-query/sh.h"
#include "support/capture_bench.h"

enum { TRUTH_ORDER = SH_ORDER_MAX, TRUTH_VALUES = 3 * SH_COUNT_MAX, TRUTH_POINTS_MOST = 64 };

/* Adds radiance * solid angle from a unit direction to the truth. */
static inline void add_truth(double *truth, int order, const double d[3], double r, double g,
                             double b, double weight)
{
    double y[SH_COUNT_MAX];
    sh_basis(order, d, y);
    sh_project(order, y, (const double[3]){r, g, b}, weight, truth);
}

/* The same radiance from everywhere. */
static inline void add_uniform(double *truth, const double rgb[3])
{
    for (int k = 0; k < 3; k++)
        truth[k] += rgb[k] * sqrt(4 * PI);
}

/* Nodes and weights of the rule with n points on [0, 1]. */
struct gauss {
    int n;
    double x[TRUTH_POINTS_MOST], w[TRUTH_POINTS_MOST];
};

static inline struct gauss gauss_rule(int n)
{
    struct gauss g = {.n = n};
    for (int i = 0; i < n; i++) {
        double x = cos(PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) { /* Newton's, on P_n */
            double p = 1, before = 0;
            for (int l = 0; l < n; l++) {
                const double next = ((2 * l + 1) * x * p - l * before) / (l + 1);
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        g.x[i] = (1 + x) / 2;
        g.w[i] = 1 / ((1 - x * x) * slope * slope);
    }
    return g;
}

/* -- caps ------------------------------------------------------------------------------------- */

/* A cone of directions about the unit `axis`: zonal coefficients 2 pi integral of Y_l0 from
 * `cosine` to 1 = sqrt(pi / (2l+1)) (P_(l-1)(cosine) - P_(l+1)(cosine)), turned to the axis. */
static inline void add_cap(double *truth, const double axis[3], double cosine, const double rgb[3])
{
    double y[SH_COUNT_MAX], before = 1, p = 1; /* P_(l-1), where P_(-1) = 1, and P_l */
    sh_basis(TRUTH_ORDER, axis, y);
    for (int l = 0; l < TRUTH_ORDER; l++) {
        const double next = ((2 * l + 1) * cosine * p - l * before) / (l + 1);
        const double zonal = sqrt(PI / (2 * l + 1)) * (before - next);
        for (int i = l * l; i < (l + 1) * (l + 1); i++)
            for (int k = 0; k < 3; k++)
                truth[3 * i + k] += sqrt(4 * PI / (2 * l + 1)) * zonal * rgb[k] * y[i];
        before = p;
        p = next;
    }
}

/* -- triangles -------------------------------------------------------------------------------- */

/* A triangle as seen from the origin, with n * n points. */
static inline void add_triangle(double *truth, struct vec3 a, struct vec3 b, struct vec3 c,
                                const struct gauss *g, const double rgb[3])
{
    const struct vec3 ab = vec3_sub(b, a), bc = vec3_sub(c, b), cross = vec3_cross(ab, bc);
    for (int i = 0; i < g->n; i++) {
        for (int j = 0; j < g->n; j++) {
            const struct vec3 p = vec3_fma(a, g->x[i], vec3_fma(ab, g->x[j], bc));
            const double distance = vec3_length(p);
            const double solid = g->w[i] * g->w[j] * g->x[i] * fabs(vec3_dot(cross, p)) /
                                 (distance * distance * distance);
            double d[3];
            vec3_store(d, vec3_scale(1 / distance, p));
            add_truth(truth, TRUTH_ORDER, d, rgb[0], rgb[1], rgb[2], solid);
        }
    }
}

/* The triangles of a shape that face `at`: all that is seen of a convex one. */
static inline void add_facing(double *truth, const struct shape *s, struct vec3 at, int points,
                              const double rgb[3])
{
    const struct gauss g = gauss_rule(points);
    for (size_t t = 0; t < s->triangle_count; t++) {
        const struct vec3 a = vec3_sub(shape_corner(s, t, 0), at),
                          b = vec3_sub(shape_corner(s, t, 1), at);
        if (vec3_dot(shape_area_vector(s, t), a) < 0)
            add_triangle(truth, a, b, vec3_sub(shape_corner(s, t, 2), at), &g, rgb);
    }
}

/* A parallelogram, corner + u * [0, 1] + v * [0, 1], as seen from the origin. */
static inline void add_parallelogram(double *truth, struct vec3 corner, struct vec3 u,
                                     struct vec3 v, const struct gauss *g, const double rgb[3])
{
    const struct vec3 cross = vec3_cross(u, v);
    for (int i = 0; i < g->n; i++) {
        for (int j = 0; j < g->n; j++) {
            const struct vec3 p = vec3_fma(vec3_fma(corner, g->x[i], u), g->x[j], v);
            const double distance = vec3_length(p);
            double d[3];
            vec3_store(d, vec3_scale(1 / distance, p));
            add_truth(truth, TRUTH_ORDER, d, rgb[0], rgb[1], rgb[2],
                      g->w[i] * g->w[j] * fabs(vec3_dot(cross, p)) /
                          (distance * distance * distance));
        }
    }
}

/* Solid angle of a triangle from the origin. */
static inline double triangle_solid_angle(struct vec3 a, struct vec3 b, struct vec3 c)
{
    const struct vec3 u = vec3_normalize(a), v = vec3_normalize(b), w = vec3_normalize(c);
    return 2 * fabs(atan2(vec3_dot(u, vec3_cross(v, w)),
                          1 + vec3_dot(u, v) + vec3_dot(v, w) + vec3_dot(w, u)));
}

/* Irradiance at the origin, on a surface with normal n, from a polygon of radiance 1 that lies
 * wholly before it: the sum over its edges of half their angle times the cosine between n and the
 * edge's plane. */
static inline double lambert_irradiance(const struct vec3 *corner, int count, struct vec3 n)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const struct vec3 a = vec3_normalize(corner[i]),
                          b = vec3_normalize(corner[(i + 1) % count]), cross = vec3_cross(a, b);
        sum += atan2(vec3_length(cross), vec3_dot(a, b)) / 2 * vec3_dot(n, vec3_normalize(cross));
    }
    return fabs(sum);
}

/* -- the whole sphere ------------------------------------------------------------------------- */

typedef void truth_field(const void *context, const double d[3], double rgb[3]);

/* A field of directions, smooth on each of columns * rows pieces of equal azimuth (from +X towards
 * +Z) and height above the plane y = 0. */
static inline void add_field(double *truth, int columns, int rows, truth_field *field,
                             const void *context)
{
    const struct gauss g = gauss_rule(6);
    for (int piece = 0; piece < columns * rows; piece++) {
        for (int i = 0; i < g.n * g.n; i++) {
            const double azimuth = 2 * PI * (piece % columns + g.x[i % g.n]) / columns;
            const double height = PI * ((piece / columns + g.x[i / g.n]) / rows - 0.5);
            const double d[3] = {cos(height) * cos(azimuth), sin(height),
                                 cos(height) * sin(azimuth)};
            double rgb[3];
            field(context, d, rgb);
            add_truth(truth, TRUTH_ORDER, d, rgb[0], rgb[1], rgb[2],
                      g.w[i % g.n] * g.w[i / g.n] * cos(height) * 2 * PI / columns * PI / rows);
        }
    }
}

/* The matrix that turns coefficients as `rows` (3x3, a rotation) turns directions: M_ij = integral
 * of Y_i(d) Y_j(R^T d). 12 heights and 24 azimuths integrate polynomials up to degree 22
 * exactly. */
static inline void rotation_matrix(const double rows[9], double matrix[SH_COUNT_MAX][SH_COUNT_MAX])
{
    const struct gauss g = gauss_rule(12);
    memset(matrix, 0, sizeof(double[SH_COUNT_MAX][SH_COUNT_MAX]));
    for (int point = 0; point < 12 * 24; point++) {
        const double z = 2 * g.x[point / 24] - 1, phi = 2 * PI * (point % 24) / 24,
                     r = sqrt(1 - z * z);
        const double d[3] = {r * cos(phi), r * sin(phi), z};
        double back[3], y[SH_COUNT_MAX], y_back[SH_COUNT_MAX];
        for (int k = 0; k < 3; k++)
            back[k] = rows[k] * d[0] + rows[3 + k] * d[1] + rows[6 + k] * d[2];
        sh_basis(SH_ORDER_MAX, d, y);
        sh_basis(SH_ORDER_MAX, back, y_back);
        for (int i = 0; i < SH_COUNT_MAX * SH_COUNT_MAX; i++)
            matrix[i / SH_COUNT_MAX][i % SH_COUNT_MAX] +=
                4 * PI / 24 * g.w[point / 24] * y[i / SH_COUNT_MAX] * y_back[i % SH_COUNT_MAX];
    }
}

#endif
