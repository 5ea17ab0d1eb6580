#include "baked.h"
#include "angle.h"
#include "content.h"
#include "error.h"
#include "locate.h"
#include "stream.h"

#include <math.h>
#include <string.h>

struct error *baked_open(struct baked *b, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe"), *cells = stream_table(stream, "tet");
    struct column *position = NULL, *vertex = NULL, *neighbour = NULL, *sh = NULL, *sh_error = NULL;
    *b = (struct baked){0};
    if (!probes)
        return error_new("there is no table probe");
    if (!table_column(probes, "sh"))
        return error_new("the probes have no light (no column sh): run probe-capture");
    if (!cells)
        return error_new("there are no cells: run probe-tet");
    struct error *err = table_require(probes, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (!err && table_column(probes, "sh_error"))
        err = table_require(probes, "sh_error", COLUMN_F32, sh->width, &sh_error);
    if (!err)
        err = table_require(cells, "vertex", COLUMN_I32, 4, &vertex);
    if (!err)
        err = table_require(cells, "neighbour", COLUMN_I32, 4, &neighbour);
    bool convolved = false;
    if (!err)
        err = content_from_header(&stream->header, &convolved);
    if (err)
        return err;
    *b = (struct baked){.probe_count = probes->rows, .cell_count = cells->rows, .position = column_f64(position),
                        .vertex = column_i32(vertex), .sh = column_f32(sh), .width = sh->width,
                        .sh_error = sh_error ? column_f32(sh_error) : NULL,
                        .order = sh_order_of(sh->width), .convolved = convolved};
    return locate_create(&b->locate, probes->rows, b->position, cells->rows, b->vertex, column_i32(neighbour));
}

void baked_close(struct baked *b)
{
    locate_destroy(b->locate);
    *b = (struct baked){0};
}

void baked_locate(const struct baked *b, const double p[3], int32_t cell, struct baked_at *at)
{
    struct locate_weights w = {.cell = cell >= 0 ? cell : LOCATE_COLD};
    locate_point(b->locate, p, &w);
    *at = (struct baked_at){.cell = w.cell, .inside = w.inside};
    for (int i = 0; i < 4; i++) {
        if (!(w.weight[i] > 0))
            continue;
        at->probe[at->count] = w.vertex[i];
        at->weight[at->count++] = w.weight[i];
    }
}

struct error *baked_light(const struct baked *b, const struct baked_at *at, double *sh)
{
    memset(sh, 0, b->width * sizeof *sh);
    for (int i = 0; i < at->count; i++) {
        const float *c = b->sh + b->width * (size_t)at->probe[i];
        if (isnan(c[0]))
            return error_new("probe %d has no light: run probe-capture", at->probe[i]);
        for (size_t k = 0; k < b->width; k++)
            sh[k] += at->weight[i] * (double)c[k];
    }
    return NULL;
}

double baked_brightness(const struct baked *b, int32_t probe)
{
    const float *c = b->sh + b->width * (size_t)probe; /* Y00 = sqrt(1 / 4 pi) */
    const double luminance = 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
    return fmax(luminance, 0) * (b->convolved ? 1 : sh_cosine(0)) * 0.28209479177387814;
}

double baked_noise(const struct baked *b, const struct baked_at *at)
{
    double sum = b->sh_error ? 0 : (double)NAN;
    for (int k = 0; k < at->count && b->sh_error; k++) {
        const float *error = b->sh_error + b->width * (size_t)at->probe[k];
        for (int l = 0; l < b->order; l++) {
            const double factor = at->weight[k] * (b->convolved ? 1 : sh_cosine(l));
            for (int i = l * l; i < (l + 1) * (l + 1); i++) {
                const double e = 0.2126 * (double)error[3 * i] + 0.7152 * (double)error[3 * i + 1] + 0.0722 * (double)error[3 * i + 2];
                sum += factor * factor * e * e;
            }
        }
    }
    return sum / (4 * ANGLE_PI);
}
