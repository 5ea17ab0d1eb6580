/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds that take probes as points alone (scatter.h). Based on:
 * Bikker, Reijerse, "A precalculated point set for caching shading information", Eurographics short
 * papers, 2009. Shepard, "A two-dimensional interpolation function for irregularly-spaced data",
 * ACM, 1968.
 */
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/scatter.h"

#include <string.h>

/* in->own is the scatter, of the probes with a value. */
static bool skip(const void *in, size_t probe)
{
    return !interpolate_has(in, probe);
}

static struct error *open_nearest(struct interpolate *in, size_t probes)
{
    struct scatter *scatter = NULL;
    struct error *err = scatter_create(&scatter, probes, in->position, skip, in);
    in->own = scatter;
    return err;
}

static struct error *open_shepard(struct interpolate *in, size_t probes)
{
    struct error *err = open_nearest(in, probes);
    if (!err && !(in->settings.radius > 0))
        in->settings.radius = scatter_spacing(in->own);
    return err;
}

static void close_scatter(void *own)
{
    scatter_destroy(own);
}

static struct error *nearest_at(const struct interpolate *in, const double point[3],
                                const struct probe_place *place, float *out)
{
    double distance;
    (void)place;
    memcpy(out, in->value + (size_t)scatter_nearest(in->own, point, &distance) * in->width,
           in->width * sizeof *out);
    return NULL;
}

struct shepard {
    const struct interpolate *in;
    double sum;
    float *out;
};

static void add_probe(void *context, int32_t probe, double distance)
{
    struct shepard *s = context;
    const struct interpolate *in = s->in;
    const double c = 1 - distance / in->settings.radius;
    const double weight = in->settings.falloff == INTERPOLATE_FALL_LINEAR      ? c
                          : in->settings.falloff == INTERPOLATE_FALL_QUADRATIC ? c * c
                                                                               : c * c * c;
    const float *f = in->value + (size_t)probe * in->width;
    s->sum += weight;
    for (size_t k = 0; k < in->width; k++)
        s->out[k] += (float)weight * f[k];
}

/* Bikker and Reijerse 2009, section 5. Where no probe is within the radius, the nearest one's
 * value: that is what the sum becomes as the last one leaves. */
static struct error *shepard_at(const struct interpolate *in, const double point[3],
                                const struct probe_place *place, float *out)
{
    struct shepard s = {.in = in, .out = out};
    for (size_t k = 0; k < in->width; k++)
        out[k] = 0;
    scatter_within(in->own, point, in->settings.radius, add_probe, &s);
    if (!(s.sum > 0))
        return nearest_at(in, point, place, out);
    for (size_t k = 0; k < in->width; k++)
        out[k] = (float)((double)out[k] / s.sum);
    return NULL;
}

const struct interpolate_kind interpolate_nearest = {.name = "nearest",
                                                     .skips_unknown = true,
                                                     .open = open_nearest,
                                                     .close = close_scatter,
                                                     .at = nearest_at};
const struct interpolate_kind interpolate_shepard = {.name = "shepard",
                                                     .skips_unknown = true,
                                                     .has_radius = true,
                                                     .open = open_shepard,
                                                     .close = close_scatter,
                                                     .at = shepard_at};
