/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds that blend the probes of a cell. Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005: a first-order Taylor expansion from
 * each probe before blending. Farin, "Triangular Bernstein-Bezier patches", Computer Aided
 * Geometric Design 3, 1986: cubics with quadratic precision.
 */
#include "base/array.h"
#include "interpolate/bound.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"

#include <math.h>
#include <stdlib.h>

/* How much of the slope from corner i to corner j a kind takes, at u: barycentric. */
typedef double slope(const double u[4], int i, int j);

/* u_i (f_i + g_i . (q - p_i)), q - p_i = sum_j u_j way_ij. */
static double taylor(const double u[4], int i, int j)
{
    return u[i] * u[j];
}

/* Farin 1986: control points on edges from the slopes at corners, b_iij = f_i + g_i . way_ij / 3;
 * in the middle of faces a quarter of the sum of the face's six of these less a sixth of its
 * corners' sum, which keeps quadratics. The Bernstein polynomials of all are gathered by slope. */
static double bezier(const double u[4], int i, int j)
{
    double others = 0;
    for (int k = 0; k < 4; k++)
        others += k != i && k != j ? u[k] : 0;
    return u[i] * u[i] * u[j] + u[i] * u[j] * others / 2;
}

/* The slopes of probe i along the way to probe j, of values first .. first + count - 1, less the
 * differences between the two: 0 where light is linear. */
static inline void foretell(const struct interpolate *in, size_t i, size_t j, size_t first,
                            size_t count, float *more)
{
    const size_t width = in->width;
    const double *p = in->position + 3 * i, *q = in->position + 3 * j;
    const float *g = in->gradient + 3 * width * i + first, *a = in->value + width * i + first,
                *b = in->value + width * j + first;
    const float x = (float)(q[0] - p[0]), y = (float)(q[1] - p[1]), z = (float)(q[2] - p[2]);
    for (size_t k = 0; k < count; k++)
        more[k] = ((x * g[k] + y * g[width + k]) + z * g[2 * width + k]) - (b[k] - a[k]);
}

static inline void add_light(const struct interpolate *in, const struct probe_place *place,
                             slope *slope_of, float *out)
{
    const struct bound *bound = in->own;
    const double *u = place->weight;
    float all[3 * SH_COUNT_MAX] = {0}, more[3 * SH_COUNT_MAX], size[4];
    for (int i = 0; i < 4; i++)
        size[i] = u[i] > 0 ? bound_size(bound, in->value + in->width * (size_t)place->probe[i]) : 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            if (i == j || !(u[i] > 0) || !(u[j] > 0))
                continue;
            foretell(in, (size_t)place->probe[i], (size_t)place->probe[j], 0, in->width, more);
            const float most = BOUND_SHARE * (size[i] + size[j]) / 2,
                        part = (float)slope_of(u, i, j) * bound_part(bound_size(bound, more), most);
            for (size_t k = 0; k < in->width; k++)
                all[k] += part * more[k];
        }
    float share[3];
    bound_shares(bound, out, all, share);
    for (size_t k = 0; k < in->width; k++)
        out[k] += share[k % 3] * all[k];
}

/* Values that are not light: one by one. */
static inline void add_values(const struct interpolate *in, const struct probe_place *place,
                              slope *slope_of, float *out)
{
    const double *u = place->weight;
    for (size_t k = 0; k < in->width; k++) {
        float all = 0, span = 0, size[4];
        for (int i = 0; i < 4; i++) {
            size[i] = u[i] > 0 ? fabsf(in->value[in->width * (size_t)place->probe[i] + k]) : 0;
            span += (float)u[i] * size[i];
        }
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) {
                float more;
                if (i == j || !(u[i] > 0) || !(u[j] > 0))
                    continue;
                foretell(in, (size_t)place->probe[i], (size_t)place->probe[j], k, 1, &more);
                all += (float)slope_of(u, i, j) * more *
                       bound_part(fabsf(more), BOUND_SHARE * (size[i] + size[j]) / 2);
            }
        out[k] += all < -span ? -span : all;
    }
}

/* Where all values are linear between the corners, both kinds are the barycentric one, which they
 * reproduce; so they are that and what probes foretell more. */
static inline struct error *blend_gradients(const struct interpolate *in,
                                            const struct probe_place *place, slope *slope_of,
                                            float *out)
{
    probe_blend(place, in->value, in->width, out);
    if (in->order)
        add_light(in, place, slope_of, out);
    else
        add_values(in, place, slope_of, out);
    return isnan(out[0]) ? interpolate_missing(in, place) : NULL;
}

static struct error *open_bound(struct interpolate *in, size_t probes)
{
    struct bound *bound = NULL;
    (void)probes;
    struct error *err = in->order ? array_create(&bound, 1, sizeof *bound) : NULL;
    if (bound)
        bound_start(bound, in->order, in->convolved);
    in->own = bound;
    return err;
}

static struct error *gradient_at(const struct interpolate *in, const double point[3],
                                 const struct probe_place *place, float *out)
{
    (void)point;
    return blend_gradients(in, place, taylor, out);
}

static struct error *cubic_at(const struct interpolate *in, const double point[3],
                              const struct probe_place *place, float *out)
{
    (void)point;
    return blend_gradients(in, place, bezier, out);
}

const struct interpolate_kind interpolate_barycentric = {.name = "barycentric",
                                                         .needs_cells = true};
const struct interpolate_kind interpolate_gradient = {.name = "gradient",
                                                      .needs_cells = true,
                                                      .needs_gradients = true,
                                                      .open = open_bound,
                                                      .close = free,
                                                      .at = gradient_at};
const struct interpolate_kind interpolate_cubic = {.name = "cubic",
                                                   .needs_cells = true,
                                                   .needs_gradients = true,
                                                   .open = open_bound,
                                                   .close = free,
                                                   .at = cubic_at};
