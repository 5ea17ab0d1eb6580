/* SPDX-License-Identifier: Apache-2.0 */
/* The kind that takes surface probes as oriented discs (discs.h). */
#include "base/array.h"
#include "base/error.h"
#include "interpolate/discs.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "interpolate/scatter.h"
#include "stream/stream.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

static bool skip(const void *in, size_t probe)
{
    return !interpolate_has(in, probe);
}

/* The radius of all discs, where the probes have none of their own. */
static struct error *find_radius(const struct interpolate *in, size_t probes, double *radius)
{
    struct scatter *scatter = NULL;
    struct error *err = scatter_create(&scatter, probes, in->position, skip, in);
    *radius = err ? 0 : scatter_spacing(scatter);
    scatter_destroy(scatter);
    return err;
}

/* Radii of the discs, NaN for probes without a value or a radius of their own. */
static struct error *set_radii(const struct interpolate *in, const struct table *table,
                               float *radius)
{
    const struct column *own = table_column(table, "radius");
    const size_t probes = table->rows;
    double all = in->settings.radius;
    struct error *err = NULL;
    if (!(all > 0) && !own)
        err = find_radius(in, probes, &all);
    if (!err && !own && !(all > 0))
        err = error_new("all surface probes are at one place: --radius tells how far it goes");
    for (size_t i = 0; i < probes && !err; i++) {
        const bool by_column = own && !(in->settings.radius > 0);
        const double r = by_column ? 2 * (double)column_f32(own)[i] : all;
        radius[i] = interpolate_has(in, i) ? (float)r : NAN;
        if (isnan(radius[i]) || (r >= (double)FLT_MIN && r <= (double)FLT_MAX))
            continue;
        if (by_column)
            err = error_new("probe %zu: expected a radius from %g to %g, got %g", i,
                            (double)FLT_MIN / 2, (double)FLT_MAX / 2, r / 2);
        else
            err = error_new("expected discs with a radius from %g to %g, got %g", (double)FLT_MIN,
                            (double)FLT_MAX, r);
    }
    return err;
}

static struct error *open_discs(struct interpolate *in, size_t probes)
{
    const struct table *table = stream_table(in->stream, "probe");
    const struct column *normal = table_column(table, "normal");
    struct discs *discs = NULL;
    float *radius = NULL;
    if (!normal)
        return error_new("discs are of surface probes, and these have no column normal: "
                         "probe-place poisson or vertices makes some");
    struct error *err = array_create(&radius, probes, sizeof *radius);
    if (!err)
        err = set_radii(in, table, radius);
    const struct disc_points points = {probes, in->position, column_f32(normal), radius};
    if (!err)
        err = discs_create(&discs, &points);
    free(radius);
    in->own = discs;
    return err;
}

static void close_discs(void *own)
{
    discs_destroy(own);
}

static struct error *surface(const struct interpolate *in, const double point[3], const double n[3],
                             float *out, bool *covered)
{
    const enum discs_answer answer =
        discs_blend(in->own, point, n, 1 + (int)in->settings.falloff, in->value, in->width, out);
    *covered = answer == DISCS_COVERED;
    return answer == DISCS_NONE
               ? error_new("none of the surface probes faces as the point's normal does, %g %g %g",
                           n[0], n[1], n[2])
               : NULL;
}

static void fetch(const struct interpolate *in, size_t count, const double *point, const double *n,
                  size_t stride)
{
    discs_fetch(in->own, count, point, n, stride);
}

/* Points without a normal. */
static struct error *no_surface(const struct interpolate *in, const double point[3],
                                const struct probe_place *place, float *out)
{
    (void)in, (void)point, (void)place, (void)out;
    return error_new("--interpolate discs expects points with a normal, x y z nx ny nz");
}

const struct interpolate_kind interpolate_discs = {.name = "discs",
                                                   .skips_unknown = true,
                                                   .has_radius = true,
                                                   .open = open_discs,
                                                   .close = close_discs,
                                                   .surface = surface,
                                                   .fetch = fetch,
                                                   .at = no_surface};
