/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/capture_senders.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "libprobe-query/discs.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "math/angle.h"
#include "stream/table.h"
#include "trace/path.h"
#include "trace/trace_local.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A sender is far from what it stands for where its disc ends at half that distance. */
#define FAR 2.0f

/* A ray that met a sender. */
struct met {
    uint32_t place; /* of the sender, in the order of the tree */
    float direction[3];
};

/* A cluster that may be cut. */
struct part {
    double rank; /* share of rays times spread */
    struct sender_node node;
};

/* What a thread works with. */
struct work {
    struct met *met;    /* a ray; owned, and so are: */
    uint32_t *seen;     /* rays that met each node */
    uint32_t *link_of;  /* the link of each place of the order */
    struct part *part;  /* a heap, of the largest rank; at most K */
    struct part *whole; /* such as are not cut further */
    double *sum;        /* values of all links */
    size_t mets;
    uint64_t hits, alone, far;
};

/* A receiver and where its links go. */
struct receiver {
    const double *position;
    const float *normal; /* NULL: a point */
    size_t width;        /* values a link */
    double scale;        /* of each */
    int32_t *link;
    float *value;
};

struct job {
    struct capture_senders *capture;
    const uint32_t *place_of; /* a sender's place in the order */
    struct work *work;        /* a thread */
    struct table *table;      /* NULL: of senders */
    const size_t *row;
    const double *position;
    const float *normal;
    size_t width;
    int32_t *link;
    float *value;
};

/* -- rays -------------------------------------------------------------------------------------- */

/* The sender that stands for a place; UINT32_MAX: none. */
static uint32_t find_sender(const struct capture_senders *c, struct vec3 at, struct vec3f facing,
                            struct work *work)
{
    const double p[3] = {at.x, at.y, at.z},
                 n[3] = {(double)facing.x, (double)facing.y, (double)facing.z};
    float distance;
    const uint32_t sender = discs_nearest(c->discs, p, n, &distance);
    work->hits++;
    work->alone += sender == UINT32_MAX;
    work->far += sender != UINT32_MAX && distance > FAR;
    return sender;
}

/* Turns a wave's hits into senders. */
static void take_hits(const struct job *job, const struct path_tracer *path,
                      const struct path_receiver *receiver, const struct path_rays *rays,
                      const struct path_sample *sample, struct work *work)
{
    for (size_t i = 0; i < rays->count; i++) {
        const struct path_sample *s = &sample[i];
        if (!s->hit)
            continue;
        const struct vec3f facing = vec3f_scale(s->front ? 1 : -1, s->normal),
                           d = rays->direction[i],
                           met = trace_leave(vec3f_fma(receiver->at.position, s->distance, d),
                                             s->distance, facing);
        const uint32_t sender =
            find_sender(job->capture, trace_to_world(path->tracer, met), facing, work);
        if (sender != UINT32_MAX)
            work->met[work->mets++] = (struct met){job->place_of[sender], {d.x, d.y, d.z}};
    }
}

static double wrap(double x)
{
    return x - floor(x);
}

/* The direction of a point of the unit square. */
static struct vec3f direction_of(const struct receiver *r, struct vec3f normal, double x, double y)
{
    if (r->normal)
        return direction_by_cosine(normal, (float)y, (float)x);
    const float z = (float)(2 * y - 1), across = sqrtf(float_most(1 - z * z, 0));
    float c, s;
    angle_turn((float)x, &c, &s);
    return (struct vec3f){across * c, across * s, z};
}

static struct error *look(const struct job *job, const struct receiver *r, struct work *work)
{
    const struct capture_senders *capture = job->capture;
    const double golden = 0.6180339887498949;
    const uint64_t name = random_hash_position(r->position);
    struct random shift = random_start(capture->seed, name, UINT32_MAX);
    const double x0 = random_double(&shift), y0 = random_double(&shift);
    const struct path_tracer *path;
    struct error *err = path_near(capture->path, r->position, &path);
    struct path_receiver receiver = {0};
    work->mets = 0;
    if (err)
        return err;
    if (r->normal)
        receiver.at.normal =
            vec3f_normalize((struct vec3f){r->normal[0], r->normal[1], r->normal[2]});
    receiver.at.position = trace_start(path->tracer, r->position, receiver.at.normal);
    for (int first = 0; first < capture->rays; first += PATH_WAVE) {
        struct vec3f direction[PATH_WAVE];
        struct random random[PATH_WAVE];
        struct path_sample sample[PATH_WAVE];
        struct path_rays rays = {.direction = direction, .random = random, .straight_alone = true};
        for (int i = first; i < capture->rays && rays.count < PATH_WAVE; i++, rays.count++) {
            random[rays.count] = random_start(capture->seed, name, UINT32_MAX - 1 - (uint32_t)i);
            direction[rays.count] = direction_of(r, receiver.at.normal, wrap(x0 + golden * i),
                                                 wrap(y0 + ((double)i + 0.5) / capture->rays));
        }
        path_samples(path, &receiver, &rays, sample);
        take_hits(job, path, &receiver, &rays, sample, work);
    }
    return NULL;
}

/* -- clusters ---------------------------------------------------------------------------------- */

/* Counts the rays that met each node of the tree. */
static void count_rays(const struct senders *s, struct work *work)
{
    memset(work->seen, 0, s->tree.nodes * sizeof *work->seen);
    for (size_t i = 0; i < work->mets; i++) {
        struct sender_node node = sender_tree_root(&s->tree);
        work->seen[node.number]++;
        while (node.count > 1) {
            const struct sender_node left = sender_tree_half(node, 0);
            node = work->met[i].place < left.first + left.count ? left : sender_tree_half(node, 1);
            work->seen[node.number]++;
        }
    }
}

static bool is_before(const struct part *a, const struct part *b)
{
    return a->rank > b->rank || (a->rank >= b->rank && a->node.number < b->node.number);
}

static void push(struct part *heap, size_t *count, struct part part)
{
    size_t at = (*count)++;
    while (at && is_before(&part, &heap[(at - 1) / 2])) {
        heap[at] = heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    heap[at] = part;
}

static struct part pop(struct part *heap, size_t *count)
{
    const struct part first = heap[0], last = heap[--*count];
    size_t at = 0;
    for (size_t down = 1; down < *count; down = 2 * at + 1) {
        down += down + 1 < *count && is_before(&heap[down + 1], &heap[down]);
        if (!is_before(&heap[down], &last))
            break;
        heap[at] = heap[down];
        at = down;
    }
    heap[at] = last;
    return first;
}

/* The smallest node that holds what rays met of this one. */
static struct part shrink(const struct senders *s, const struct work *work, struct sender_node node)
{
    while (node.count > 1) {
        const struct sender_node left = sender_tree_half(node, 0);
        if (work->seen[left.number] == work->seen[node.number])
            node = left;
        else if (!work->seen[left.number])
            node = sender_tree_half(node, 1);
        else
            break;
    }
    return (struct part){(double)work->seen[node.number] * (double)s->tree.spread[node.number],
                         node};
}

static int by_number(const void *a, const void *b)
{
    const struct part *x = a, *y = b;
    return x->node.first < y->node.first ? -1 : x->node.first > y->node.first;
}

/* Cuts what was seen into at most K clusters, work->whole, in the order of the tree. */
static size_t find_clusters(const struct senders *s, struct work *work)
{
    size_t parts = 0, whole = 0;
    if (!work->mets)
        return 0;
    count_rays(s, work);
    push(work->part, &parts, shrink(s, work, sender_tree_root(&s->tree)));
    while (parts) {
        const struct part part = pop(work->part, &parts);
        if (part.node.count == 1 || parts + whole + 2 > s->links) {
            work->whole[whole++] = part;
            continue;
        }
        for (unsigned half = 0; half < 2; half++)
            push(work->part, &parts, shrink(s, work, sender_tree_half(part.node, half)));
    }
    qsort(work->whole, whole, sizeof *work->whole, by_number);
    return whole;
}

/* -- links ------------------------------------------------------------------------------------- */

static void add_links(const struct senders *s, int order, const struct receiver *r,
                      struct work *work)
{
    const size_t links = find_clusters(s, work);
    memset(work->sum, 0, links * r->width * sizeof *work->sum);
    memset(r->value, 0, s->links * r->width * sizeof *r->value);
    for (size_t k = 0; k < s->links; k++)
        r->link[k] = k < links ? (int32_t)work->whole[k].node.number : 0;
    for (size_t k = 0; k < links; k++)
        for (size_t i = 0; i < work->whole[k].node.count; i++)
            work->link_of[work->whole[k].node.first + i] = (uint32_t)k;
    for (size_t i = 0; i < work->mets; i++) {
        const struct met *m = &work->met[i];
        double y[SH_COUNT_MAX] = {1}, *sum = work->sum + work->link_of[m->place] * r->width;
        const double d[3] = {(double)m->direction[0], (double)m->direction[1],
                             (double)m->direction[2]};
        if (!r->normal)
            sh_basis(order, d, y);
        for (size_t k = 0; k < r->width; k++)
            sum[k] += y[k];
    }
    for (size_t k = 0; k < links * r->width; k++)
        r->value[k] = (float)(r->scale * work->sum[k]);
}

/* T as irradiance. */
static void convolve(const struct receiver *r, int order, size_t links)
{
    double factor[SH_ORDER_MAX];
    for (int l = 0; l < order; l++)
        factor[l] = sh_cosine(l);
    for (size_t k = 0; k < links; k++)
        content_scale_bands(order, 1, factor, r->value + k * r->width);
}

static struct error *link_one(void *context, size_t index, int thread)
{
    const struct job *job = context;
    const struct capture_senders *c = job->capture;
    const size_t row = job->row ? job->row[index] : index;
    const double pi = ANGLE_PI;
    const struct receiver r = {.position = job->position + 3 * row,
                               .normal = job->normal ? job->normal + 3 * row : NULL,
                               .width = job->width,
                               .scale = (!job->table   ? 1
                                         : job->normal ? pi
                                                       : 4 * pi) /
                                        c->rays,
                               .link = job->link + row * c->senders->links,
                               .value = job->value + row * c->senders->links * job->width};
    struct error *err = look(job, &r, &job->work[thread]);
    if (err)
        return error_wrap(err, "%s %zu", job->table ? "probe" : "sender", row);
    add_links(c->senders, c->order, &r, &job->work[thread]);
    if (c->convolved && !r.normal)
        convolve(&r, c->order, c->senders->links);
    return NULL;
}

static void clear_work(struct work *w)
{
    free(w->met);
    free(w->seen);
    free(w->link_of);
    free(w->part);
    free(w->whole);
    free(w->sum);
}

static struct error *make_work(struct work *w, const struct senders *s, int rays, size_t width)
{
    struct error *err = array_create(&w->met, (size_t)rays, sizeof *w->met);
    if (!err)
        err = array_create(&w->seen, s->tree.nodes, sizeof *w->seen);
    if (!err)
        err = array_create(&w->link_of, s->count, sizeof *w->link_of);
    if (!err)
        err = array_create(&w->part, s->links + 1, sizeof *w->part);
    if (!err)
        err = array_create(&w->whole, s->links, sizeof *w->whole);
    if (!err)
        err = array_create(&w->sum, s->links * width, sizeof *w->sum);
    return err;
}

size_t capture_senders_bytes(const struct senders *s, int rays)
{
    return (size_t)rays * sizeof(struct met) + (s->tree.nodes + s->count) * sizeof(uint32_t) +
           s->links * (2 * sizeof(struct part) + SH_COUNT_MAX * sizeof(double));
}

/* Links `count` receivers. */
static struct error *link_all(struct job *job, size_t count)
{
    struct capture_senders *c = job->capture;
    const struct senders *s = c->senders;
    uint32_t *place_of = NULL;
    struct error *err = array_create(&place_of, s->count, sizeof *place_of);
    for (size_t i = 0; i < s->count && !err; i++)
        place_of[s->tree.sender[i]] = (uint32_t)i;
    job->place_of = place_of;
    if (!err)
        err = array_create(&job->work, (size_t)c->threads, sizeof *job->work);
    for (int t = 0; t < c->threads && !err; t++)
        err = make_work(&job->work[t], s, c->rays, job->width);
    if (!err)
        err = threads_for(c->threads, count, link_one, job);
    for (int t = 0; t < c->threads && job->work; t++) {
        c->met += job->work[t].hits;
        c->alone += job->work[t].alone;
        c->far += job->work[t].far;
        clear_work(&job->work[t]);
    }
    free(job->work);
    free(place_of);
    return err;
}

struct error *capture_senders_link(struct capture_senders *c, struct senders *s)
{
    enum { SHARE = 8, LEAST = 64 }; /* what many senders tell together needs few rays of each */
    struct capture_senders own = *c;
    own.rays = c->rays / SHARE > LEAST ? c->rays / SHARE : LEAST;
    struct job job = {.capture = &own, .position = s->position, .normal = s->normal, .width = 1};
    struct error *err = array_create(&s->link, s->count * s->links, sizeof *s->link);
    if (!err)
        err = array_create(&s->share, s->count * s->links, sizeof *s->share);
    job.link = s->link;
    job.value = s->share;
    if (!err)
        err = link_all(&job, s->count);
    c->met = own.met;
    c->alone = own.alone;
    c->far = own.far;
    return err;
}

struct error *capture_senders_rows(struct capture_senders *c, struct table *table, size_t first,
                                   size_t count)
{
    struct job job = {.capture = c, .table = table};
    struct column *position = NULL;
    size_t *row = NULL, rows = 0;
    const struct column *normal = table_column(table, "normal"),
                        *light = table_column(table, normal ? "irradiance" : "sh");
    struct error *err = senders_find_columns(c->senders, table, &job.width);
    if (!err)
        err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = array_create(&row, count, sizeof *row);
    if (err)
        return err;
    job.position = column_f64(position);
    job.normal = normal ? column_f32(normal) : NULL;
    job.link = column_i32(table_column(table, SENDERS_OF));
    job.value = column_f32(table_column(table, SENDERS_TRANSFER));
    for (size_t i = first; i < first + count; i++)
        if (isnan(job.value[i * job.width * c->senders->links]) && light &&
            !isnan(column_f32(light)[i * light->width]))
            row[rows++] = i;
    job.row = row;
    err = link_all(&job, rows);
    free(row);
    return err;
}
