#include "query.h"
#include "array.h"
#include "content.h"
#include "error.h"
#include "locate.h"
#include "number.h"
#include "points.h"
#include "sh.h"
#include "stream_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct query {
    struct query_settings settings;
    const struct stream *stream;
    struct locate *locate;
    struct locate_weights weights; /* of the last point: where the next walk begins */
    const float *value;            /* the interpolated column */
    size_t width;
    int order; /* of SH, where the column is sh; else 0 */
    bool convolved;
    float *blend; /* width; owned */
    size_t outside;
    size_t point_width; /* 0 before the first point */
    struct stream_output out;
    struct stream_writer *writer;
    struct table rows; /* QUERY_STREAM: the block that is being filled */
};

static struct error *open_cells(struct query *q)
{
    const struct table *probes = stream_table(q->stream, "probe"), *cells = stream_table(q->stream, "tet");
    struct column *vertex = NULL, *neighbour = NULL;
    if (!probes)
        return error_new("there is no table probe");
    if (!cells)
        return error_new("there are no cells: run probe-tet");
    struct error *err = table_require(cells, "vertex", COLUMN_I32, 4, &vertex);
    if (!err)
        err = table_require(cells, "neighbour", COLUMN_I32, 4, &neighbour);
    if (!err)
        err = locate_create(&q->locate, probes->rows, column_f64(table_column(probes, "position")), cells->rows,
                            column_i32(vertex), column_i32(neighbour));
    return err;
}

static struct error *open_column(struct query *q)
{
    const struct table *probes = stream_table(q->stream, "probe");
    const bool sh = !strcmp(q->settings.column, "sh");
    struct column *column = NULL;
    if (sh && !table_column(probes, "sh"))
        return error_new("the probes have no light (no column sh): run probe-capture");
    struct error *err = table_require(probes, q->settings.column, COLUMN_F32, 0, &column);
    if (err)
        return err;
    q->value = column_f32(column);
    q->width = column->width;
    q->order = sh ? sh_order_of(column->width) : 0;
    err = sh ? content_from_header(&q->stream->header, &q->convolved) : NULL;
    return err ? err : array_create(&q->blend, q->width, sizeof *q->blend);
}

struct error *query_open(struct query **query, const struct stream *stream, const struct query_settings *settings)
{
    struct query *q = NULL;
    *query = NULL;
    struct error *err = array_create(&q, 1, sizeof *q);
    if (err)
        return err;
    q->settings = *settings;
    q->stream = stream;
    q->weights.cell = LOCATE_COLD;
    q->out.fd = -1;
    err = open_cells(q);
    if (!err)
        err = open_column(q);
    if (!err && settings->format != QUERY_STREAM)
        err = output_open(&q->out, settings->output, false);
    if (err)
        query_abandon(q);
    else
        *query = q;
    return err;
}

/* -- what comes out --------------------------------------------------------------------------- */

static struct error *write_text(struct query *q, const float *value, size_t width)
{
    char *room;
    struct error *err = output_room(&q->out, (width + 11) * (NUMBER_ROOM + 1), &room);
    if (err)
        return err;
    char *at = room;
    for (size_t k = 0; k < width; k++) {
        at = number_write_f32(at, value[k]);
        *at++ = ' ';
    }
    if (q->settings.explain) {
        const struct locate_weights *w = &q->weights;
        at = number_write_i32(at, w->cell);
        *at++ = ' ';
        for (int i = 0; i < 4; i++) {
            at = number_write_i32(at, w->vertex[i]);
            *at++ = ' ';
        }
        for (int i = 0; i < 4; i++) {
            at = number_write_f32(at, (float)w->weight[i]);
            *at++ = ' ';
        }
        at = stpcpy(at, w->inside ? "inside " : "outside ");
        at = number_write_f32(at, (float)w->distance);
        *at++ = ' ';
    }
    at[-1] = '\n';
    q->out.count += (size_t)(at - room);
    return output_flush(&q->out, false);
}

static struct error *write_binary(struct query *q, const float *value, size_t width)
{
    char *room;
    struct error *err = output_room(&q->out, width * sizeof *value, &room);
    if (err)
        return err;
    memcpy(room, value, width * sizeof *value);
    q->out.count += width * sizeof *value;
    return output_flush(&q->out, false);
}

static struct error *write_legend(struct query *q, size_t point_width)
{
    const char *what = point_width == 6 ? "irradiance:3" : q->settings.column;
    char *room;
    struct error *err = output_room(&q->out, strlen(what) + 80, &room);
    if (!err)
        q->out.count += (size_t)(stpcpy(stpcpy(stpcpy(room, "# "), what), " cell probe:4 weight:4 inside distance\n") - room);
    return err;
}

/* A stream like the baked one's, of points in place of probes. */
static struct error *start_stream(struct query *q, size_t point_width)
{
    struct stream_header header = {0};
    struct column *column = NULL;
    struct error *err = header_copy(&header, &q->stream->header);
    if (!err)
        err = header_add_provenance(&header, q->settings.recorded);
    if (!err)
        err = table_init(&q->rows, "probe");
    if (!err)
        err = table_add_column(&q->rows, "position", COLUMN_F64, 3, &column);
    if (!err && point_width == 6)
        err = table_add_column(&q->rows, "normal", COLUMN_F32, 3, &column);
    if (!err && point_width == 6)
        err = table_add_column(&q->rows, "irradiance", COLUMN_F32, 3, &column);
    else if (!err)
        err = table_add_column(&q->rows, q->settings.column, COLUMN_F32, q->width, &column);
    if (!err)
        err = stream_writer_open(&q->writer, q->settings.output, q->stream->encoding, &header);
    if (!err)
        err = stream_writer_table(q->writer, &q->rows);
    header_clear(&header);
    return err;
}

static struct error *start(struct query *q, size_t point_width)
{
    if (point_width == 6 && !q->order)
        return error_new("points with a normal ask for irradiance, which is made of the column sh, not of %s", q->settings.column);
    q->point_width = point_width;
    if (q->settings.format == QUERY_STREAM)
        return start_stream(q, point_width);
    return q->settings.explain ? write_legend(q, point_width) : NULL;
}

static void write_row(struct query *q, size_t i, const double *point, const float *value, size_t width)
{
    memcpy(column_f64(&q->rows.columns[0]) + 3 * i, point, 3 * sizeof *point);
    if (q->point_width == 6)
        for (size_t k = 0; k < 3; k++)
            column_f32(&q->rows.columns[1])[3 * i + k] = (float)point[3 + k];
    memcpy(column_f32(&q->rows.columns[q->rows.column_count - 1]) + width * i, value, width * sizeof *value);
}

/* -- the light at a point --------------------------------------------------------------------- */

static struct error *blend(struct query *q, const double *point)
{
    locate_point(q->locate, point, &q->weights);
    q->outside += !q->weights.inside;
    for (int i = 0; i < 4; i++) {
        const int32_t probe = q->weights.vertex[i];
        if (q->weights.weight[i] > 0 && isnan(q->value[(size_t)probe * q->width]))
            return error_new("probe %d has no %s: run probe-capture", probe, q->order ? "light" : q->settings.column);
    }
    locate_blend(&q->weights, q->value, q->width, q->blend);
    return NULL;
}

static struct error *irradiance(const struct query *q, const double *normal, float rgb[3])
{
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(length > 0) || !isfinite(length))
        return error_new("expected a normal with a length, got %g %g %g", normal[0], normal[1], normal[2]);
    const double n[3] = {normal[0] / length, normal[1] / length, normal[2] / length};
    double e[3];
    sh_irradiance(q->order, q->blend, q->convolved, n, e);
    for (int k = 0; k < 3; k++)
        rgb[k] = (float)e[k];
    return NULL;
}

struct error *query_points(struct query *q, const struct points *points, size_t count, size_t width, const double *value)
{
    struct error *err = !count || q->point_width ? NULL : start(q, width);
    if (!err && q->settings.format == QUERY_STREAM)
        err = table_resize(&q->rows, count);
    for (size_t i = 0; i < count && !err; i++) {
        const double *point = value + i * width;
        float rgb[3];
        err = blend(q, point);
        if (!err && width == 6)
            err = irradiance(q, point + 3, rgb);
        err = points_place(points, i, err);
        const float *result = width == 6 ? rgb : q->blend;
        const size_t result_width = width == 6 ? 3 : q->width;
        if (err)
            break;
        if (q->settings.format == QUERY_TEXT)
            err = write_text(q, result, result_width);
        else if (q->settings.format == QUERY_BINARY)
            err = write_binary(q, result, result_width);
        else
            write_row(q, i, point, result, result_width);
    }
    if (!err && q->settings.format == QUERY_STREAM)
        err = stream_writer_rows(q->writer, &q->rows, 0, count);
    else if (!err) /* a pipe is answered while it runs */
        err = output_flush(&q->out, true);
    return err;
}

size_t query_outside(const struct query *q)
{
    return q->outside;
}

struct error *query_finish(struct query *q)
{
    struct error *err = NULL;
    if (q->settings.format == QUERY_STREAM && !q->writer)
        err = start(q, 3); /* no point at all: an empty table */
    if (!err && q->writer) {
        err = stream_writer_finish(q->writer);
        q->writer = NULL;
    } else if (!err) {
        err = output_finish(&q->out);
    }
    query_abandon(q);
    return err;
}

void query_abandon(struct query *q)
{
    if (!q)
        return;
    stream_writer_abandon(q->writer);
    output_abandon(&q->out);
    table_clear(&q->rows);
    locate_destroy(q->locate);
    free(q->blend);
    free(q);
}
