#include "query.h"
#include "array.h"
#include "error.h"
#include "interpolate.h"
#include "number.h"
#include "points.h"
#include "stream_private.h"
#include "threads.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK_NEAR = 4096,       /* points of a block whose points are near one another: what comes out stays in the second-level cache */
    BLOCK_FAR = 512 * 1024,  /* of one whose points are not: the more, the nearer they come when they are sorted */
    WAIT = 50,               /* milliseconds */
};

struct query {
    struct query_settings settings;
    const struct interpolate *in;
    struct stream_output out;
    struct stream_writer *writer;
    size_t point_width; /* 0 before the first point */
    struct points *points;
    /* What the threads share, under the lock. A block has a ticket, its number; blocks are written in the order of their
     * tickets. */
    pthread_mutex_t lock, reading;
    pthread_cond_t turned;
    size_t ticket, turn;
    atomic_size_t block_most;
    bool ended, failed;
    size_t outside;
};

/* What a thread has of its own. */
struct worker {
    struct query *query;
    struct points_block block;
    float *light; /* of the block's points, or their irradiance */
    size_t light_capacity;
    struct probe_place *place; /* explain: of each point */
    size_t place_capacity;
    uint32_t *order;
    uint64_t *room;
    size_t order_capacity, room_capacity;
    int32_t last; /* the cell in which the next walk begins */
    char *text;
    size_t text_bytes, text_capacity;
    struct table rows; /* QUERY_STREAM */
    float *blend;      /* one point's, before its irradiance is made */
    size_t outside;
};

struct error *query_open(struct query **query, const struct interpolate *in, const struct query_settings *settings)
{
    struct query *q = NULL;
    *query = NULL;
    struct error *err = array_create(&q, 1, sizeof *q);
    if (err)
        return err;
    *q = (struct query){.settings = *settings, .in = in, .out = {.fd = -1}, .block_most = BLOCK_NEAR};
    pthread_mutex_init(&q->lock, NULL);
    pthread_mutex_init(&q->reading, NULL);
    pthread_cond_init(&q->turned, NULL);
    if (settings->format == QUERY_STREAM && !in->stream)
        err = error_new("a packed file has no stream's header: --to stream needs a stream");
    else if (settings->format != QUERY_STREAM)
        err = output_open(&q->out, settings->output, false);
    if (err)
        query_abandon(q);
    else
        *query = q;
    return err;
}

/* -- what comes out --------------------------------------------------------------------------- */

static size_t result_width(const struct query *q)
{
    return q->point_width == 6 ? 3 : q->in->width;
}

/* A stream like the baked one's, of points in place of probes. */
static struct error *make_rows(const struct query *q, struct table *rows)
{
    struct column *column = NULL;
    struct error *err = table_init(rows, "probe");
    if (!err)
        err = table_add_column(rows, "position", COLUMN_F64, 3, &column);
    if (!err && q->point_width == 6)
        err = table_add_column(rows, "normal", COLUMN_F32, 3, &column);
    if (!err && q->point_width == 6)
        err = table_add_column(rows, "irradiance", COLUMN_F32, 3, &column);
    else if (!err)
        err = table_add_column(rows, q->in->settings.column, COLUMN_F32, q->in->width, &column);
    return err;
}

static struct error *start_stream(struct query *q)
{
    struct stream_header header = {0};
    struct table rows = {0};
    struct error *err = header_copy(&header, &q->in->stream->header);
    if (!err)
        err = header_add_provenance(&header, q->settings.recorded);
    if (!err)
        err = make_rows(q, &rows);
    if (!err)
        err = stream_writer_open(&q->writer, q->settings.output, q->in->stream->encoding, &header);
    if (!err)
        err = stream_writer_table(q->writer, &rows);
    table_clear(&rows);
    header_clear(&header);
    return err;
}

static struct error *write_legend(struct query *q)
{
    const char *what = q->point_width == 6 ? "irradiance:3" : q->in->settings.column;
    char *room;
    struct error *err = output_room(&q->out, strlen(what) + 80, &room);
    if (!err)
        q->out.count += (size_t)(stpcpy(stpcpy(stpcpy(room, "# "), what), " cell probe:4 weight:4 inside distance\n") - room);
    return err ? err : output_flush(&q->out, true);
}

/* The first point says what comes out. */
static struct error *start(struct query *q, size_t point_width)
{
    if (point_width == 6 && !q->in->order)
        return error_new("points with a normal ask for irradiance, which is made of the column sh, not of %s", q->in->settings.column);
    q->point_width = point_width;
    if (q->settings.format == QUERY_STREAM)
        return start_stream(q);
    return q->settings.explain ? write_legend(q) : NULL;
}

static char *explain(char *at, const struct probe_place *place)
{
    at = number_write_i32(at, place->cell);
    *at++ = ' ';
    for (int i = 0; i < 4; i++) {
        at = number_write_i32(at, place->probe[i]);
        *at++ = ' ';
    }
    for (int i = 0; i < 4; i++) {
        at = number_write_f32(at, (float)place->weight[i]);
        *at++ = ' ';
    }
    at = stpcpy(at, place->inside ? "inside " : "outside ");
    at = number_write_f32(at, (float)place->distance);
    *at++ = ' ';
    return at;
}

static struct error *make_text(struct worker *w)
{
    const struct query *q = w->query;
    const size_t width = result_width(q), line = (width + 11) * (NUMBER_ROOM + 1);
    w->text_bytes = 0;
    for (size_t i = 0; i < w->block.count; i++) {
        struct error *err = array_reserve(&w->text, &w->text_capacity, w->text_bytes + line, 1);
        if (err)
            return err;
        char *at = w->text + w->text_bytes;
        for (size_t k = 0; k < width; k++) {
            at = number_write_f32(at, w->light[i * width + k]);
            *at++ = ' ';
        }
        if (q->settings.explain)
            at = explain(at, &w->place[i]);
        at[-1] = '\n';
        w->text_bytes = (size_t)(at - w->text);
    }
    return NULL;
}

static struct error *make_stream(struct worker *w)
{
    struct error *err = w->rows.column_count ? NULL : make_rows(w->query, &w->rows);
    if (!err)
        err = table_resize(&w->rows, w->block.count);
    if (err)
        return err;
    const size_t width = w->block.width;
    for (size_t i = 0; i < w->block.count; i++) {
        const double *point = w->block.value + i * width;
        memcpy(column_f64(&w->rows.columns[0]) + 3 * i, point, 3 * sizeof *point);
        for (size_t k = 0; k < 3 && width == 6; k++)
            column_f32(&w->rows.columns[1])[3 * i + k] = (float)point[3 + k];
    }
    memcpy(w->rows.columns[w->rows.column_count - 1].data, w->light, w->block.count * result_width(w->query) * sizeof *w->light);
    return NULL;
}

/* Writes a block whose turn it is; a pipe is answered while it runs. */
static struct error *write_block(struct worker *w)
{
    struct query *q = w->query;
    if (!w->block.count)
        return NULL;
    switch (q->settings.format) {
    case QUERY_STREAM: return stream_writer_rows(q->writer, &w->rows, 0, w->block.count);
    case QUERY_TEXT: return output_write(&q->out, w->text, w->text_bytes);
    default: return output_write(&q->out, w->light, w->block.count * result_width(q) * sizeof *w->light);
    }
}

/* -- the light at points ---------------------------------------------------------------------- */

static struct error *make_irradiance(const struct query *q, const float *sh, const double *normal, float rgb[3])
{
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(length > 0) || !(length < INFINITY))
        return error_new("expected a normal with a length, got %g %g %g", normal[0], normal[1], normal[2]);
    const float n[3] = {(float)(normal[0] / length), (float)(normal[1] / length), (float)(normal[2] / length)};
    (q->in->convolved ? probe_irradiance_convolved : probe_irradiance)(q->in->order, sh, n, rgb);
    return NULL;
}

/* The light at a point whose place is known, into its row of w->light. */
static struct error *light_point(struct worker *w, size_t i, const struct probe_place *place)
{
    const struct query *q = w->query;
    const double *point = w->block.value + i * w->block.width;
    float *result = w->light + i * result_width(q), *sh = q->point_width == 6 ? w->blend : result;
    if (!place->inside) {
        w->outside++;
        if (q->settings.outside == QUERY_ERROR)
            return error_new("the point is outside of the hull of the probes, %g away from it", place->distance);
        if (q->settings.outside == QUERY_ZERO) {
            memset(result, 0, result_width(q) * sizeof *result);
            return NULL;
        }
    }
    struct error *err = interpolate_at(q->in, point, place, sh);
    return !err && q->point_width == 6 ? make_irradiance(q, sh, point + 3, result) : err;
}

/* Answers the block's points, in the given order or as they come. The error is that of the first point that has one. */
static struct error *light_block(struct worker *w, const uint32_t *order)
{
    enum { RUN = 512, AHEAD = 8 }; /* points whose places are found before their light; of these, how far memory is asked ahead */
    const size_t count = w->block.count, width = w->block.width;
    struct probe_place place[RUN];
    struct error *err = NULL;
    size_t wrong = count;
    for (size_t k = 0; k < count && (order || !err); k += RUN) {
        const size_t n = count - k < RUN ? count - k : RUN;
        place[0].cell = w->last;
        if (order) {
            interpolate_find_many(w->query->in, n, w->block.value, width, order + k, place);
        } else {
            for (size_t j = 0; j < n; j++) {
                interpolate_find(w->query->in, w->block.value + (k + j) * width, &place[j]);
                place[j + 1 < n ? j + 1 : j].cell = place[j].cell;
            }
        }
        w->last = place[n - 1].cell;
        for (size_t j = 0; j < n; j++) {
            const size_t i = order ? order[k + j] : k + j;
            if (order && j + AHEAD < n)
                interpolate_fetch(w->query->in, &place[j + AHEAD]);
            struct error *here = i < wrong ? light_point(w, i, &place[j]) : NULL;
            if (here) {
                error_destroy(err);
                err = here;
                wrong = i;
            }
            if (w->place)
                w->place[i] = place[j];
        }
    }
    return points_block_place(w->query->points, &w->block, wrong, err);
}

/* Finds an order for a block whose points are far from one another; NULL: they are answered as they come. */
static struct error *find_order(struct worker *w, const uint32_t **order)
{
    const size_t count = w->block.count;
    const bool scattered = w->query->in->volume && probe_volume_scattered(w->query->in->volume, count, w->block.value, w->block.width);
    *order = NULL;
    atomic_store_explicit(&w->query->block_most, scattered ? BLOCK_FAR : BLOCK_NEAR, memory_order_relaxed); /* of what comes next */
    if (!scattered)
        return NULL;
    struct error *err = array_reserve(&w->order, &w->order_capacity, count, sizeof *w->order);
    if (!err)
        err = array_reserve(&w->room, &w->room_capacity, 3 * count, sizeof *w->room);
    if (err)
        return err;
    probe_volume_order(w->query->in->volume, count, w->block.value, w->block.width, w->order, w->room);
    *order = w->order;
    return NULL;
}

static struct error *answer(struct worker *w)
{
    struct query *q = w->query;
    const uint32_t *order;
    struct error *err = points_parse(q->points, &w->block);
    if (!err)
        err = array_reserve(&w->light, &w->light_capacity, w->block.count * result_width(q), sizeof *w->light);
    if (!err && q->settings.explain)
        err = array_reserve(&w->place, &w->place_capacity, w->block.count, sizeof *w->place);
    if (!err && !w->blend)
        err = array_create(&w->blend, q->in->width, sizeof *w->blend);
    if (!err)
        err = find_order(w, &order);
    if (!err)
        err = light_block(w, order);
    if (!err && q->settings.format == QUERY_TEXT)
        err = make_text(w);
    if (!err && q->settings.format == QUERY_STREAM && w->block.count)
        err = make_stream(w);
    return err;
}

/* -- threads ---------------------------------------------------------------------------------- */

/* Takes the next block and its ticket; false when there is none, or another thread has failed. Reading may wait for a pipe:
 * nobody else does meanwhile. */
static bool take(struct worker *w, size_t *ticket, struct error **err)
{
    struct query *q = w->query;
    pthread_mutex_lock(&q->reading);
    pthread_mutex_lock(&q->lock);
    bool more = !q->ended;
    while (more && !q->failed && !points_ready(q->points, 0)) {
        pthread_mutex_unlock(&q->lock);
        points_ready(q->points, WAIT); /* now and then, whether another thread failed */
        pthread_mutex_lock(&q->lock);
    }
    more = more && !q->failed;
    pthread_mutex_unlock(&q->lock);
    if (more) {
        *err = points_take(q->points, q->block_most, &w->block);
        if (!*err && w->block.width && !q->point_width)
            *err = start(q, w->block.width);
        more = *err || w->block.bytes;
        q->ended = !more || *err;
        *ticket = more ? q->ticket++ : 0;
    }
    pthread_mutex_unlock(&q->reading);
    return more;
}

static struct error *work(void *context, size_t index, int thread)
{
    struct query *q = context;
    struct worker w = {.query = q, .last = PROBE_COLD};
    struct error *err = NULL;
    size_t ticket = 0;
    (void)index;
    (void)thread;
    while (!err && take(&w, &ticket, &err)) {
        if (!err)
            err = answer(&w);
        pthread_mutex_lock(&q->lock);
        while (q->turn != ticket)
            pthread_cond_wait(&q->turned, &q->lock);
        if (q->failed) { /* an earlier block did: what comes behind it is not written */
            error_destroy(err);
            err = NULL;
        } else if (!err) {
            pthread_mutex_unlock(&q->lock);
            err = write_block(&w); /* nobody else's turn meanwhile */
            pthread_mutex_lock(&q->lock);
        }
        q->failed = q->failed || err;
        q->outside += w.outside;
        w.outside = 0;
        q->turn++;
        pthread_cond_broadcast(&q->turned);
        pthread_mutex_unlock(&q->lock);
    }
    points_block_clear(&w.block);
    table_clear(&w.rows);
    free(w.light);
    free(w.place);
    free(w.order);
    free(w.room);
    free(w.text);
    free(w.blend);
    return err;
}

struct error *query_run(struct query *q, struct points *points)
{
    q->points = points;
    return threads_for(q->settings.threads, (size_t)q->settings.threads, work, q);
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
    pthread_mutex_destroy(&q->lock);
    pthread_mutex_destroy(&q->reading);
    pthread_cond_destroy(&q->turned);
    free(q);
}
