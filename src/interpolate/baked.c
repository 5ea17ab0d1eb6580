/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/baked.h"
#include "base/error.h"
#include "interpolate/cells_volume.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "light/content.h"
#include "math/angle.h"
#include "math/luminance.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <math.h>

/* -- opening --------------------------------------------------------------------------------- */

struct error *baked_open_probes(struct baked *b, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    struct column *position = NULL, *sh = NULL, *sh_error = NULL;
    *b = (struct baked){0};
    if (!probes || !probes->rows)
        return error_new("there are no probes");
    if (!table_column(probes, "sh"))
        return interpolate_no_light(probes);
    struct error *err = table_require(probes, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (!err && !sh_order_of(sh->width))
        err = error_new("column sh: expected 3 n^2 numbers, got %zu", sh->width);
    if (!err && table_column(probes, "sh_error"))
        err = table_require(probes, "sh_error", COLUMN_F32, sh->width, &sh_error);
    bool convolved = false;
    if (!err)
        err = content_from_header(&stream->header, &convolved);
    if (!err)
        *b = (struct baked){.probe_count = probes->rows,
                            .position = column_f64(position),
                            .sh = column_f32(sh),
                            .sh_error = sh_error ? column_f32(sh_error) : NULL,
                            .width = sh->width,
                            .order = sh_order_of(sh->width),
                            .convolved = convolved};
    return err;
}

/* The cells, where there are any: the interpolation's own, or beside it. */
static struct error *open_cells(struct baked *b, const struct stream *stream)
{
    b->cells = b->in->volume;
    if (!cells_exist(stream))
        return NULL;
    const unsigned flags = b->in->settings.outside;
    struct error *err = cells_volume_mesh(stream, &b->mesh);
    if (!err && !b->cells)
        err = cells_volume_open(stream, &b->mesh, flags, &b->cells);
    if (!err && probe_volume_sees(b->cells))
        err = cells_volume_create(&b->mesh, flags | PROBE_LEAN, &b->blind_cells);
    return err;
}

struct error *baked_open(struct baked *b, const struct stream *stream,
                         const struct interpolate_settings *settings)
{
    struct interpolate_settings of_light = settings ? *settings : (struct interpolate_settings){0};
    of_light.column = "sh";
    struct error *err = baked_open_probes(b, stream);
    if (!err)
        err = interpolate_open(&b->in, stream, &of_light);
    if (!err)
        err = open_cells(b, stream);
    if (err)
        baked_close(b);
    return err;
}

struct error *baked_open_cells(struct baked *b, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    *b = (struct baked){0};
    struct error *err = probes && table_column(probes, "sh") ? baked_open_probes(b, stream) : NULL;
    if (!err)
        err = cells_volume_mesh(stream, &b->mesh);
    if (!err) {
        b->probe_count = b->mesh.probes;
        b->position = b->mesh.position;
        err = cells_volume_open(stream, &b->mesh, PROBE_LEAN, &b->cells);
    }
    if (err)
        baked_close(b);
    return err;
}

void baked_close(struct baked *b)
{
    if (!b->in || b->cells != b->in->volume)
        probe_volume_destroy(b->cells);
    probe_volume_destroy(b->blind_cells);
    interpolate_close(b->in);
    *b = (struct baked){0};
}

struct error *baked_complete(const struct baked *b)
{
    if (b->in && b->in->settings.kind->skips_unknown)
        return NULL;
    for (size_t i = 0; i < b->probe_count; i++) {
        if (isnan(b->sh[b->width * i]))
            return error_new("probe %zu has no light: run probe-capture", i);
        if (b->in && b->in->gradient && isnan(b->in->gradient[3 * b->width * i]))
            return error_new("probe %zu has no gradient: run probe-capture", i);
    }
    return NULL;
}

/* -- light ------------------------------------------------------------------------------------ */

void baked_locate_cell(const struct baked *b, const double p[3], struct probe_place *place)
{
    if (b->cells)
        probe_volume_locate(b->blind_cells ? b->blind_cells : b->cells, p, place);
    else
        interpolate_find(b->in, p, place); /* without cells there is no sight */
}

void baked_locate(const struct baked *b, const double p[3], struct probe_place *place)
{
    const bool sees = b->cells && b->in && b->in->sight.see;
    if (b->cells && !sees)
        probe_volume_locate(b->cells, p, place);
    else
        baked_locate_cell(b, p, place);
    if (sees)
        b->in->sight.see(b->in->sight.own, p, place);
}

bool baked_sees(const struct baked *b)
{
    return b->cells && (probe_volume_sees(b->cells) || (b->in && b->in->sight.see));
}

bool baked_blends(const struct baked *b)
{
    return b->cells && interpolate_kind_is_plain(b->in->settings.kind);
}

struct error *baked_light(const struct baked *b, const double p[3], const struct probe_place *place,
                          double *sh)
{
    float light[3 * SH_COUNT_MAX];
    struct error *err = interpolate_at(b->in, p, place, light);
    for (size_t k = 0; k < b->width && !err; k++)
        sh[k] = (double)light[k];
    return err;
}

static void irradiance(const struct baked *b, const float *sh, const double n[3], double rgb[3])
{
    sh_irradiance(b->order, sh, b->convolved, n, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(rgb[k], 0);
}

void baked_irradiance(const struct baked *b, struct probe_place *place, const double p[3],
                      const double n[3], double rgb[3])
{
    float sh[3 * SH_COUNT_MAX] = {0};
    baked_locate(b, p, place);
    error_destroy(interpolate_at(b->in, p, place, sh)); /* there is none where light is complete */
    irradiance(b, sh, n, rgb);
}

void baked_probe_irradiance(const struct baked *b, size_t probe, const double n[3], double rgb[3])
{
    irradiance(b, b->sh + probe * b->width, n, rgb);
}

double baked_brightness(const struct baked *b, int32_t probe)
{
    const float *c = b->sh + b->width * (size_t)probe;
    return fmax(luminance_f32(c), 0) * (b->convolved ? 1 : sh_cosine(0)) * SH_Y00;
}

double baked_noise(const struct baked *b, const struct probe_place *place)
{
    double sum = 0;
    if (!b->sh_error || !interpolate_kind_is_plain(b->in->settings.kind))
        return (double)NAN;
    for (int k = 0; k < 4; k++) {
        const float *error = b->sh_error + b->width * (size_t)place->probe[k];
        for (int l = 0; l < b->order && place->weight[k] > 0; l++) {
            const double factor = place->weight[k] * (b->convolved ? 1 : sh_cosine(l));
            for (int i = l * l; i < (l + 1) * (l + 1); i++) {
                const double e = luminance_f32(error + 3 * i);
                sum += factor * factor * e * e;
            }
        }
    }
    return sum / (4 * ANGLE_PI);
}
