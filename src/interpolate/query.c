/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/query.h"
#include "interpolate/occluders.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "base/threads.h"
#include "interpolate/interpolate.h"
#include "math/vec.h"
#include "stream/points.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum {
    /* points of a block whose points are near one another: what comes out stays in the second-level
     * cache */
    BLOCK_NEAR = 4096,
    /* of one whose points are not: the more, the nearer they come when they are sorted */
    BLOCK_FAR = 512 * 1024,
    WAIT = 50, /* milliseconds */
    AHEAD = 1, /* blocks that are answered before their turn, beside one a thread */
};

struct query {
    struct query_settings settings;
    const struct interpolate *in;
    struct file_output out;
    struct stream_writer *writer;
    size_t point_width; /* 0 before the first point */
    size_t normal_at;   /* of a point's numbers: where its normal begins; 0: it has none */
    /* 3 a probe, where surface probes are asked by points with a normal; else NULL */
    const float *normal;
    struct points *points;
    /* What the threads share, under the lock. A block has a ticket, its number; blocks are written
     * in the order of their tickets. Who has answered one before its turn leaves it, and goes on
     * with the next: nobody waits for another's answer. */
    pthread_mutex_t lock, reading;
    pthread_cond_t freed;
    struct job *job, *free; /* job: owned, `jobs` of them */
    struct job **answered;  /* by ticket % jobs; NULL: not yet */
    size_t jobs, ticket, turn;
    atomic_size_t block_most;
    bool ended, failed, writing;
    size_t outside;
};

/* A block and its answers. */
struct job {
    /* of those that are free: the one used last comes first, and is in the cache */
    struct job *next;
    size_t ticket;
    struct points_block block;
    float *light; /* of the block's points, or their irradiance */
    size_t light_capacity;
    struct probe_place *place; /* explain: of each point */
    size_t place_capacity;
    char *text;
    size_t text_bytes, text_capacity;
    struct table rows; /* QUERY_STREAM */
    size_t outside;
    struct error *err;
};

/* What a thread has of its own. */
struct worker {
    struct query *query;
    struct job *job;
    uint32_t *order;
    uint64_t *room;
    size_t order_capacity, room_capacity;
    int32_t last; /* the cell in which the next walk begins */
    float *blend; /* of a run of points, before their irradiance is made */
};

struct error *query_open(struct query **query, const struct interpolate *in,
                         const struct query_settings *settings)
{
    struct query *q = NULL;
    *query = NULL;
    struct error *err = array_create(&q, 1, sizeof *q);
    if (err)
        return err;
    *q = (struct query){
        .settings = *settings, .in = in, .out = {.fd = -1}, .block_most = BLOCK_NEAR};
    pthread_mutex_init(&q->lock, NULL);
    pthread_mutex_init(&q->reading, NULL);
    pthread_cond_init(&q->freed, NULL);
    if (settings->format == QUERY_STREAM && !in->stream)
        err = error_new("a packed file has no stream's header: --to stream needs a stream");
    else if (settings->format != QUERY_STREAM)
        err = file_output_open(&q->out, settings->output, false);
    if (err)
        query_abandon(q);
    else
        *query = q;
    return err;
}

/* -- what comes out --------------------------------------------------------------------------- */

static size_t result_width(const struct query *q)
{
    return q->normal_at ? 3 : q->in->width;
}

/* A stream like the baked one's, of points in place of probes. */
static struct error *make_rows(const struct query *q, struct table *rows)
{
    struct column *column = NULL;
    struct error *err = table_init(rows, "probe");
    if (!err)
        err = table_add_column(rows, "position", COLUMN_F64, 3, &column);
    if (!err && q->in->settings.along)
        err = table_add_column(rows, q->in->settings.along, COLUMN_F64, 1, &column);
    if (!err && q->normal_at)
        err = table_add_column(rows, "normal", COLUMN_F32, 3, &column);
    if (!err && q->normal_at)
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
    const char *what = q->normal_at ? "irradiance:3" : q->in->settings.column;
    char *room;
    struct error *err = file_output_room(&q->out, strlen(what) + 80, &room);
    if (!err)
        q->out.count += (size_t)(stpcpy(stpcpy(stpcpy(room, "# "), what),
                                        " cell probe:4 weight:4 inside distance\n") -
                                 room);
    return err ? err : file_output_flush(&q->out, true);
}

/* Points with a normal ask for irradiance: of SH, or of surface probes that have it. */
static struct error *check_normals(struct query *q)
{
    const struct table *probes = q->in->stream ? stream_table(q->in->stream, "probe") : NULL;
    const struct column *normal = probes ? table_column(probes, "normal") : NULL;
    if (q->in->order || (!q->in->stream && interpolate_of_surfaces(q->in)))
        return NULL; /* SH, or a packed file of discs */
    struct light_column what = {.surface = false};
    const struct column *column = probes ? table_column(probes, q->in->settings.column) : NULL;
    if (!normal || !column || !light_column_of(column, 0, &what) || what.transfer ||
        what.role != LIGHT_VALUE)
        return error_new("points with a normal ask for irradiance, which is made of the column sh "
                         "or of a group's, not of %s",
                         q->in->settings.column);
    if (q->in->settings.kind != &interpolate_barycentric && !interpolate_of_surfaces(q->in))
        return error_new("surface probes are asked with a normal by --interpolate discs or "
                         "barycentric alone; x y z alone takes every other way");
    q->normal = column_f32(normal);
    return NULL;
}

/* The first point says what comes out. */
static struct error *start(struct query *q, size_t point_width)
{
    const size_t least = q->in->settings.along ? 1 : 3;
    struct error *err = point_width > least ? check_normals(q) : NULL;
    if (err)
        return err;
    q->point_width = point_width;
    q->normal_at = point_width > least ? least : 0;
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
    at = place->distance < (double)FLT_MAX ? number_write_f32(at, (float)place->distance)
                                           : number_write_f64(at, place->distance);
    *at++ = ' ';
    return at;
}

static struct error *make_text(const struct query *q, struct job *job)
{
    const size_t width = result_width(q), line = (width + 11) * (NUMBER_ROOM + 1);
    job->text_bytes = 0;
    for (size_t i = 0; i < job->block.count; i++) {
        struct error *err =
            array_reserve(&job->text, &job->text_capacity, job->text_bytes + line, 1);
        if (err)
            return err;
        char *at = job->text + job->text_bytes;
        for (size_t k = 0; k < width; k++) {
            at = number_write_f32(at, job->light[i * width + k]);
            *at++ = ' ';
        }
        if (q->settings.explain)
            at = explain(at, &job->place[i]);
        at[-1] = '\n';
        job->text_bytes = (size_t)(at - job->text);
    }
    return NULL;
}

static struct error *make_stream(const struct query *q, struct job *job)
{
    struct error *err = job->rows.column_count ? NULL : make_rows(q, &job->rows);
    if (!err)
        err = table_resize(&job->rows, job->block.count);
    if (err)
        return err;
    const size_t width = job->block.width;
    struct column *along = q->in->settings.along ? table_column(&job->rows, q->in->settings.along)
                                                 : NULL,
                  *normal = q->normal_at ? table_column(&job->rows, "normal") : NULL;
    for (size_t i = 0; i < job->block.count; i++) {
        const double *point = job->block.value + i * width;
        double *position = column_f64(&job->rows.columns[0]) + 3 * i;
        if (along) {
            struct probe_place place;
            interpolate_find(q->in, point, &place);
            interpolate_along_position(q->in, &place, position);
            column_f64(along)[i] = *point;
        } else {
            memcpy(position, point, 3 * sizeof *point);
        }
        for (size_t k = 0; k < 3 && normal; k++)
            column_f32(normal)[3 * i + k] = (float)point[q->normal_at + k];
    }
    memcpy(job->rows.columns[job->rows.column_count - 1].data, job->light,
           job->block.count * result_width(q) * sizeof *job->light);
    return NULL;
}

/* Writes a block whose turn it is; a pipe is answered while it runs. */
static struct error *write_block(struct query *q, const struct job *job)
{
    if (!job->block.count)
        return NULL;
    switch (q->settings.format) {
    case QUERY_STREAM: return stream_writer_rows(q->writer, &job->rows, 0, job->block.count);
    case QUERY_TEXT: return file_output_write(&q->out, job->text, job->text_bytes);
    default:
        return file_output_write(&q->out, job->light,
                                 job->block.count * result_width(q) * sizeof *job->light);
    }
}

/* -- the light at points ---------------------------------------------------------------------- */

static struct error *make_irradiance(const struct query *q, const float *sh, const double *normal,
                                     float rgb[3])
{
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(length > 0) || !(length < INFINITY))
        return error_new("expected a normal with a length, got %g %g %g", normal[0], normal[1],
                         normal[2]);
    const double scale = 1 / length;
    const float n[3] = {(float)(normal[0] * scale), (float)(normal[1] * scale),
                        (float)(normal[2] * scale)};
    (q->in->convolved ? probe_irradiance_convolved : probe_irradiance)(q->in->order, sh, n, rgb);
    return NULL;
}

/* Irradiance from those surface probes of a place that face as the point does, each by its weight
 * times the cosine between the normals: a probe at a right angle has no say, and what is between
 * two walls of a corner turns from one to the other. */
static struct error *blend_surfaces(const struct query *q, const double n[3],
                                    const struct probe_place *place, float rgb[3])
{
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    double sum[3] = {0}, all = 0;
    if (!(length > 0) || !(length < INFINITY))
        return error_new("expected a normal with a length, got %g %g %g", n[0], n[1], n[2]);
    for (int i = 0; i < 4; i++) {
        if (place->probe[i] < 0 || !(place->weight[i] > 0))
            continue;
        const float *normal = q->normal + 3 * (size_t)place->probe[i],
                    *light = q->in->value + 3 * (size_t)place->probe[i];
        const double weight =
            place->weight[i] *
            fmax(n[0] * (double)normal[0] + n[1] * (double)normal[1] + n[2] * (double)normal[2],
                 0) /
            length;
        if (isnan(light[0]))
            return error_new("probe %d has no irradiance: run probe-capture", place->probe[i]);
        all += weight;
        for (int c = 0; c < 3; c++)
            sum[c] += weight * (double)light[c];
    }
    if (!(all > 1e-9))
        return error_new("none of the surface probes around the point faces as its normal does; "
                         "x y z alone asks for them all the same");
    for (int c = 0; c < 3; c++)
        rgb[c] = (float)(sum[c] / all);
    return NULL;
}

/* Irradiance from the discs of surface probes (interpolate.h). What none covers is outside. */
static struct error *blend_discs(struct worker *w, const double *point, float rgb[3])
{
    const struct query *q = w->query;
    const struct vec3 n = vec3_normalize(vec3_load(point + q->normal_at));
    const double *given = point + q->normal_at;
    bool covered = true;
    if (!(fabs(vec3_length(n) - 1) < 1e-6))
        return error_new("expected a normal with a length, got %g %g %g", given[0], given[1],
                         given[2]);
    struct error *err =
        interpolate_surface(q->in, point, (const double[3]){n.x, n.y, n.z}, rgb, &covered);
    if (err || covered)
        return err;
    w->job->outside++;
    if (q->settings.outside == QUERY_ERROR)
        return error_new("no disc of a surface probe covers the point");
    if (q->settings.outside == QUERY_ZERO)
        memset(rgb, 0, 3 * sizeof *rgb);
    return NULL;
}

/* Whether points with a normal are answered by discs. */
static bool asks_discs(const struct query *q)
{
    return q->normal_at && !q->in->order && interpolate_of_surfaces(q->in);
}

/* The column's values at a point whose place is known. */
static struct error *light_point(struct worker *w, const double *point,
                                 const struct probe_place *place, float *light)
{
    const struct query *q = w->query;
    if (asks_discs(q))
        return blend_discs(w, point, light);
    if (!place->inside) {
        w->job->outside++;
        if (q->settings.outside == QUERY_ERROR)
            return q->in->settings.along
                       ? error_new(
                             "expected a number from the first probe's to the last one's, from "
                             "which it is %g away",
                             place->distance)
                       : error_new(
                             "the point is outside of the hull of the probes, %g away from it",
                             place->distance);
        if (q->settings.outside == QUERY_ZERO) {
            memset(light, 0, q->in->width * sizeof *light);
            return NULL;
        }
    }
    struct error *err = q->normal ? blend_surfaces(q, point + q->normal_at, place, light)
                                  : interpolate_at(q->in, point, place, light);
    if (!err && q->settings.occluders)
        occluders_shade(q->settings.occluders, q->in->order, point, light);
    return err;
}

/* The error of a block's point, to be told if it is the first that has one. */
struct wrong {
    struct error *err;
    size_t point;
};

static void take_error(struct wrong *wrong, struct error *err, size_t point)
{
    if (!err)
        return;
    error_destroy(wrong->err);
    *wrong = (struct wrong){err, point};
}

/* points whose places are found before their light; of these, how far memory is asked ahead */
enum { RUN = 256, NEXT = 8, DISCS = 64 /* points whose discs are asked for at once */ };

/* Brings nearer what the discs of the next points are read from. */
static void fetch_discs(const struct query *q, size_t left, const double *point)
{
    interpolate_fetch_surfaces(q->in, left < DISCS ? left : DISCS, point, point + q->normal_at,
                               q->point_width);
}

/* Answers n points of the block: those that order names, or those behind `first`. Light is made of
 * all before the irradiance of any: what was just stored cannot be read at once. */
static void light_run(struct worker *w, size_t n, const uint32_t *order, size_t first,
                      struct wrong *wrong)
{
    const struct query *q = w->query;
    const struct points_block *block = &w->job->block;
    const bool discs = asks_discs(q), irradiance = q->normal_at && !q->normal && !discs;
    const size_t width = q->in->width;
    struct probe_place place[RUN];
    place[0].cell = w->last;
    interpolate_find_many(q->in, n, block->value + (order ? 0 : first * block->width), block->width,
                          order, place);
    w->last = place[n - 1].cell;
    for (size_t j = 0; j < n; j++) {
        const size_t i = order ? order[j] : first + j;
        if (discs && j % DISCS == 0) /* without a volume there is no order */
            fetch_discs(q, n - j, block->value + i * block->width);
        if (j + NEXT < n && (order || place[j + NEXT].cell != place[j + NEXT - 1].cell))
            interpolate_fetch(q->in, &place[j + NEXT]);
        if (i < wrong->point)
            take_error(wrong,
                       light_point(w, block->value + i * block->width, &place[j],
                                   irradiance ? w->blend + j * width : w->job->light + i * width),
                       i);
        if (w->job->place)
            w->job->place[i] = place[j];
    }
    for (size_t j = 0; j < n && irradiance; j++) {
        const size_t i = order ? order[j] : first + j;
        if (i < wrong->point)
            take_error(wrong,
                       make_irradiance(q, w->blend + j * width,
                                       block->value + i * block->width + q->normal_at,
                                       w->job->light + 3 * i),
                       i);
    }
}

/* Answers the block's points, in the given order or as they come. The error is that of the first
 * point that has one. */
static struct error *light_block(struct worker *w, const uint32_t *order)
{
    const size_t count = w->job->block.count;
    struct wrong wrong = {.point = count};
    for (size_t k = 0; k < count && (order || !wrong.err); k += RUN)
        light_run(w, count - k < RUN ? count - k : RUN, order ? order + k : NULL, k, &wrong);
    return points_block_place(w->query->points, &w->job->block, wrong.point, wrong.err);
}

/* Finds an order for a block whose points are far from one another; NULL: they are answered as they
 * come. */
static struct error *find_order(struct worker *w, const uint32_t **order)
{
    const size_t count = w->job->block.count;
    const bool scattered = w->query->in->volume &&
                           probe_volume_scattered(w->query->in->volume, count, w->job->block.value,
                                                  w->job->block.width);
    *order = NULL;
    /* of what comes next */
    atomic_store_explicit(&w->query->block_most, scattered ? BLOCK_FAR : BLOCK_NEAR,
                          memory_order_relaxed);
    if (!scattered)
        return NULL;
    struct error *err = array_reserve(&w->order, &w->order_capacity, count, sizeof *w->order);
    if (!err)
        err = array_reserve(&w->room, &w->room_capacity, 3 * count, sizeof *w->room);
    if (err)
        return err;
    probe_volume_order(w->query->in->volume, count, w->job->block.value, w->job->block.width,
                       w->order, w->room);
    *order = w->order;
    return NULL;
}

static struct error *answer(struct worker *w)
{
    struct query *q = w->query;
    const uint32_t *order;
    struct error *err = points_parse(q->points, &w->job->block);
    if (!err)
        err = array_reserve(&w->job->light, &w->job->light_capacity,
                            w->job->block.count * result_width(q), sizeof *w->job->light);
    if (!err && q->settings.explain)
        err = array_reserve(&w->job->place, &w->job->place_capacity, w->job->block.count,
                            sizeof *w->job->place);
    if (!err && !w->blend)
        err = array_create(&w->blend, RUN * q->in->width, sizeof *w->blend);
    if (!err)
        err = find_order(w, &order);
    if (!err)
        err = light_block(w, order);
    if (!err && q->settings.format == QUERY_TEXT)
        err = make_text(q, w->job);
    if (!err && q->settings.format == QUERY_STREAM && w->job->block.count)
        err = make_stream(q, w->job);
    return err;
}

/* -- threads ---------------------------------------------------------------------------------- */

/* Waits for a job that is free. */
static struct job *find_job(struct query *q)
{
    pthread_mutex_lock(&q->lock);
    while (!q->free)
        pthread_cond_wait(&q->freed, &q->lock);
    struct job *job = q->free;
    q->free = job->next;
    pthread_mutex_unlock(&q->lock);
    return job;
}

static void free_job(struct query *q, struct job *job) /* the lock is held */
{
    job->next = q->free;
    q->free = job;
    pthread_cond_signal(&q->freed);
}

/* Takes the next block and its ticket; false when there is none, or another thread has failed.
 * Reading may wait for a pipe: nobody else does meanwhile. */
static bool take(struct query *q, struct job *job)
{
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
        job->err = points_take(q->points, q->block_most, &job->block);
        if (!job->err && job->block.width && !q->point_width)
            job->err = start(q, job->block.width);
        more = job->err || job->block.bytes;
        q->ended = !more || job->err;
        job->ticket = more ? q->ticket++ : 0;
    }
    pthread_mutex_unlock(&q->reading);
    return more;
}

/* Writes what is answered, as long as its turn has come; nothing behind a block that has failed.
 * Returns the failed one's error. */
static struct error *write_answered(struct query *q, struct job *answered)
{
    struct error *err = NULL;
    pthread_mutex_lock(&q->lock);
    q->answered[answered->ticket % q->jobs] = answered;
    for (struct job *job; !q->writing && (job = q->answered[q->turn % q->jobs]); q->turn++) {
        q->answered[q->turn % q->jobs] = NULL;
        q->writing = true; /* nobody else's turn meanwhile */
        if (!q->failed && !job->err) {
            pthread_mutex_unlock(&q->lock);
            job->err = write_block(q, job);
            pthread_mutex_lock(&q->lock);
        }
        q->outside += job->outside;
        job->outside = 0;
        if (q->failed)
            error_destroy(job->err);
        else
            err = job->err;
        q->failed = q->failed || job->err;
        job->err = NULL;
        q->writing = false;
        free_job(q, job);
    }
    pthread_mutex_unlock(&q->lock);
    return err;
}

static struct error *work(void *context, size_t index, int thread)
{
    struct query *q = context;
    struct worker w = {.query = q, .last = PROBE_COLD};
    struct error *err = NULL;
    (void)index;
    (void)thread;
    while (!err) {
        w.job = find_job(q);
        if (!take(q, w.job))
            break;
        if (!w.job->err)
            w.job->err = answer(&w);
        err = write_answered(q, w.job);
        w.job = NULL;
    }
    if (w.job) {
        pthread_mutex_lock(&q->lock);
        free_job(q, w.job);
        pthread_mutex_unlock(&q->lock);
    }
    free(w.order);
    free(w.room);
    free(w.blend);
    return err;
}

struct error *query_run(struct query *q, struct points *points)
{
    const size_t threads = q->settings.threads > 1 ? (size_t)q->settings.threads : 1;
    q->points = points;
    q->jobs = threads > 1 ? threads + AHEAD : 1;
    struct error *err = array_create(&q->job, q->jobs, sizeof *q->job);
    if (!err)
        err = array_create(&q->answered, q->jobs, sizeof *q->answered);
    for (size_t i = 0; i < q->jobs && !err; i++)
        free_job(q, &q->job[i]);
    return err ? err : threads_for((int)threads, threads, work, q);
}

size_t query_outside(const struct query *q)
{
    return q->outside;
}

struct error *query_finish(struct query *q)
{
    struct error *err = NULL;
    if (q->settings.format == QUERY_STREAM && !q->writer)
        err = start(q, q->in->settings.along ? 1 : 3); /* no point at all: an empty table */
    if (!err && q->writer) {
        err = stream_writer_finish(q->writer);
        q->writer = NULL;
    } else if (!err) {
        err = file_output_finish(&q->out);
    }
    query_abandon(q);
    return err;
}

void query_abandon(struct query *q)
{
    if (!q)
        return;
    stream_writer_abandon(q->writer);
    file_output_abandon(&q->out);
    for (size_t i = 0; q->job && i < q->jobs; i++) {
        struct job *job = &q->job[i];
        points_block_clear(&job->block);
        table_clear(&job->rows);
        free(job->light);
        free(job->place);
        free(job->text);
        error_destroy(job->err);
    }
    free(q->job);
    free(q->answered);
    pthread_mutex_destroy(&q->lock);
    pthread_mutex_destroy(&q->reading);
    pthread_cond_destroy(&q->freed);
    free(q);
}
