/* The kinds that blend the probes of a cell. Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005: a first-order Taylor expansion from
 * each probe before blending. Farin, "Triangular Bernstein-Bezier patches", Computer Aided
 * Geometric Design 3, 1986: cubics with quadratic precision.
 */
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"

#include <math.h>

/* How much of the value of corner i, and of its gradient along which way, a kind takes. u:
 * barycentric; way[i][j]: from corner i to corner j. */
static void taylor(const double u[4], double way[4][4][3], int i, double *value, double along[3])
{
    *value = u[i]; /* u_i (f_i + g_i . (q - p_i)), q - p_i = sum_j u_j way_ij */
    for (int j = 0; j < 4; j++)
        for (int k = 0; k < 3; k++)
            along[k] += u[i] * u[j] * way[i][j][k];
}

/* Farin 1986: control points on edges from the slopes at corners, b_iij = f_i + g_i . way_ij / 3;
 * in the middle of faces a quarter of the sum of the face's six of these less a sixth of its
 * corners' sum, which keeps quadratics. The Bernstein polynomials of all are gathered by corner. */
static void bezier(const double u[4], double way[4][4][3], int i, double *value, double along[3])
{
    *value = u[i] * u[i] * (3 - 2 * u[i]);
    for (int j = 0; j < 4; j++) {
        double others = 0;
        for (int k = 0; k < 4 && j != i; k++)
            others += k != i && k != j ? u[k] : 0;
        if (j == i)
            continue;
        *value += u[i] * u[j] * others; /* 6 u_i u_j u_k / 3 for each face, met twice */
        const double slope = u[i] * u[i] * u[j] + u[i] * u[j] * others / 2;
        for (int k = 0; k < 3; k++)
            along[k] += slope * way[i][j][k];
    }
}

/* How a kind takes them. */
typedef void terms(const double u[4], double way[4][4][3], int i, double *value, double along[3]);

static inline struct error *blend_gradients(const struct interpolate *in,
                                            const struct probe_place *place, terms *terms_of,
                                            float *out)
{
    double way[4][4][3];
    const size_t width = in->width;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (size_t k = 0; k < 3; k++)
                way[i][j][k] = in->position[3 * (size_t)place->probe[j] + k] -
                               in->position[3 * (size_t)place->probe[i] + k];
    for (size_t k = 0; k < width; k++)
        out[k] = 0;
    for (int i = 0; i < 4; i++) {
        double value = 0, along[3] = {0};
        if (!(place->weight[i] > 0))
            continue;
        terms_of(place->weight, way, i, &value, along);
        const float v = (float)value, x = (float)along[0], y = (float)along[1], z = (float)along[2];
        const float *f = in->value + (size_t)place->probe[i] * width,
                    *g = in->gradient + 3 * (size_t)place->probe[i] * width;
        for (size_t k = 0; k < width; k++)
            out[k] += v * f[k] + ((x * g[k] + y * g[width + k]) + z * g[2 * width + k]);
    }
    return isnan(out[0]) ? interpolate_missing(in, place) : NULL;
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
const struct interpolate_kind interpolate_gradient = {
    .name = "gradient", .needs_cells = true, .needs_gradients = true, .at = gradient_at};
const struct interpolate_kind interpolate_cubic = {
    .name = "cubic", .needs_cells = true, .needs_gradients = true, .at = cubic_at};
