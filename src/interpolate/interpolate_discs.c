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

/* What the kind has. */
struct own {
    struct discs *discs;           /* owned; NULL: */
    struct probe_surface *surface; /* of a packed file; owned */
};

static const struct discs *discs_of(const struct interpolate *in)
{
    const struct own *own = in->own;
    const float *irradiance;
    return own->surface ? surface_discs(own->surface, &irradiance) : own->discs;
}

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

/* The points of the probes, with radii of the caller's to free. */
static struct error *find_points(const struct interpolate *in, size_t probes, float **radius,
                                 struct disc_points *points)
{
    const struct table *table = stream_table(in->stream, "probe");
    const struct column *normal = table_column(table, "normal");
    *radius = NULL;
    if (!normal)
        return error_new("discs are of surface probes, and these have no column normal: "
                         "probe-place poisson or vertices makes some");
    struct error *err = array_create(radius, probes, sizeof **radius);
    if (!err)
        err = set_radii(in, table, *radius);
    *points = (struct disc_points){probes, in->position, column_f32(normal), *radius};
    return err;
}

static struct error *open_discs(struct interpolate *in, size_t probes)
{
    struct disc_points points;
    struct own *own;
    float *radius = NULL;
    struct error *err = array_create(&own, 1, sizeof *own);
    in->own = own;
    if (!err)
        err = find_points(in, probes, &radius, &points);
    if (!err)
        err = discs_create(&own->discs, &points);
    free(radius);
    return err;
}

static struct error *open_surface(struct interpolate *in)
{
    struct own *own;
    size_t row = 0;
    struct error *err = array_create(&own, 1, sizeof *own);
    in->own = own;
    if (err)
        return err;
    const enum probe_status status =
        probe_surface_open(&own->surface, in->image, in->image_bytes, &row);
    if (status == PROBE_NO_MEMORY)
        return error_memory();
    if (status)
        return error_new(status == PROBE_BAD_DISC ? "%s (probe %zu)" : "%s",
                         probe_status_text(status), row);
    surface_discs(own->surface, &in->value);
    in->width = 3;
    return NULL;
}

static struct error *pack(const struct interpolate *in, enum probe_packing packing, size_t *size,
                          void *image)
{
    const size_t probes = in->stream ? stream_table(in->stream, "probe")->rows : 0;
    struct probe_surface *surface = NULL;
    struct disc_points p;
    float *radius = NULL;
    size_t row = 0;
    if (!in->stream || in->width != 3)
        return error_new("a packed file of discs is made of a stream with irradiance");
    struct error *err = find_points(in, probes, &radius, &p);
    if (!err) {
        const struct probe_discs of = {p.count, p.position, p.normal, p.radius, in->value};
        const enum probe_status status = probe_surface_create(&surface, &of, &row);
        if (status)
            err = error_new("probe %zu: %s", row, probe_status_text(status));
    }
    if (!err)
        *size = probe_surface_pack(surface, packing, image, *size);
    probe_surface_destroy(surface);
    free(radius);
    return err;
}

static void close_discs(void *of)
{
    struct own *own = of;
    discs_destroy(own->discs);
    probe_surface_destroy(own->surface);
    free(own);
}

static struct error *surface(const struct interpolate *in, const double point[3], const double n[3],
                             float *out, bool *covered)
{
    const enum discs_answer answer = discs_blend(
        discs_of(in), point, n, 1 + (int)in->settings.falloff, in->value, in->width, out);
    *covered = answer == DISCS_COVERED;
    return answer == DISCS_NONE
               ? error_new("none of the surface probes faces as the point's normal does, %g %g %g",
                           n[0], n[1], n[2])
               : NULL;
}

static void fetch(const struct interpolate *in, size_t count, const double *point, const double *n,
                  size_t stride)
{
    discs_fetch(discs_of(in), count, point, n, stride);
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
                                                   .open_packed = open_surface,
                                                   .pack = pack,
                                                   .close = close_discs,
                                                   .surface = surface,
                                                   .fetch = fetch,
                                                   .at = no_surface};
