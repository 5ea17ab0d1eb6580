#include "lookup.h"
#include "content.h"
#include "error.h"
#include "locate.h"
#include "sh.h"
#include "stream.h"

#include <math.h>

static struct error *find_light(struct lookup *l, const struct stream *stream, const struct table *probes)
{
    struct column *sh = NULL;
    if (!table_column(probes, "sh"))
        return error_new("the probes have no light (no column sh): run probe-capture");
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (err)
        return err;
    l->sh = column_f32(sh);
    l->width = sh->width;
    l->probes = probes->rows;
    l->order = sh_order_of(sh->width);
    if (!l->order)
        return error_new("column sh: expected 3 n^2 numbers, got %zu", sh->width);
    err = content_from_header(&stream->header, &l->convolved);
    if (err)
        return err;
    for (size_t i = 0; i < l->probes; i++)
        if (isnan(l->sh[i * l->width]))
            return error_new("probe %zu has no light: run probe-capture", i);
    return NULL;
}

static struct error *find_cells(struct lookup *l, const struct stream *stream, const struct table *probes)
{
    const struct table *cells = stream_table(stream, "tet");
    struct column *vertex = NULL, *neighbour = NULL;
    if (!cells)
        return error_new("there are no cells: run probe-tet");
    struct error *err = table_require(cells, "vertex", COLUMN_I32, 4, &vertex);
    if (!err)
        err = table_require(cells, "neighbour", COLUMN_I32, 4, &neighbour);
    return err ? err : locate_create(&l->locate, probes->rows, column_f64(table_column(probes, "position")), cells->rows,
                                     column_i32(vertex), column_i32(neighbour));
}

struct error *lookup_create(struct lookup *l, const struct stream *stream, bool cells)
{
    const struct table *probes = stream_table(stream, "probe");
    *l = (struct lookup){0};
    if (!probes || !probes->rows)
        return error_new("there are no probes");
    struct error *err = find_light(l, stream, probes);
    return err || !cells ? err : find_cells(l, stream, probes);
}

void lookup_clear(struct lookup *l)
{
    locate_destroy(l->locate);
    *l = (struct lookup){0};
}

static void irradiance(const struct lookup *l, const float *sh, const double n[3], double rgb[3])
{
    sh_irradiance(l->order, sh, l->convolved, n, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(rgb[k], 0);
}

void lookup_irradiance(const struct lookup *l, int32_t *cell, const double p[3], const double n[3], double rgb[3])
{
    struct locate_weights weights = {.cell = *cell};
    float sh[3 * SH_COUNT_MAX];
    locate_point(l->locate, p, &weights);
    locate_blend(&weights, l->sh, l->width, sh);
    irradiance(l, sh, n, rgb);
    *cell = weights.cell;
}

void lookup_probe(const struct lookup *l, size_t probe, const double n[3], double rgb[3])
{
    irradiance(l, l->sh + probe * l->width, n, rgb);
}
