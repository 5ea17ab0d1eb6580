/* SPDX-License-Identifier: Apache-2.0 */
/* The method `unlit` of probe-place: of a captured stream, the probes that have light, and of the
 * black ones those that stand for their areas (unlit.h). All that the stream says of them stays.
 */
#include "adapt/unlit.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "libprobe-query/sh.h"
#include "math/luminance.h"
#include "place/place.h"
#include "place/place_inside.h"
#include "place/place_method.h"
#include "stream/cells.h"
#include "stream/stream.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WANTED_MOST = 1000 };

static struct option_row *rows(struct place_options *options, struct option_row *row)
{
    *row++ = (struct option_row){
        .name = "unlit",
        .argument = "K",
        .kind = OPTION_INT,
        .value = &options->unlit,
        .given = &options->unlit_given,
        .least = 1,
        .most = WANTED_MOST,
        .shown = "one an area, 64 at the most",
        .help = "unlit, ascent: probes that stand for those without light, in the\n"
                "largest areas"};
    return row;
}

/* A stream's probes, of which some are black. */
struct parting {
    struct stream *stream;
    struct table *probes; /* borrowed from it */
    const double *position;
    uint32_t *list; /* of black ones, in order of position; owned */
    size_t dark;
    double *at; /* their positions, 3 each; owned */
};

static struct error *find_light(const struct parting *p, struct column **sh)
{
    *sh = table_column(p->probes, "sh");
    if (table_column(p->probes, "normal"))
        return error_new("expected probes in space, got probes with normals");
    if (!*sh || !sh_order_of((*sh)->width))
        return error_new("expected captured probes, got none with a column sh");
    for (size_t i = 0; i < p->probes->rows; i++)
        if (isnan(column_f32(*sh)[(*sh)->width * i]))
            return error_new("expected captured probes, but probe %zu is not", i);
    return NULL;
}

struct order {
    double at[3];
    uint32_t row;
};

static int compare(const void *left, const void *right)
{
    const struct order *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a->at[k] != b->at[k])
            return a->at[k] < b->at[k] ? -1 : 1;
    return (a->row > b->row) - (a->row < b->row);
}

/* air[i]: the probe is in the air and sees a surface; without a scene all do. */
static struct error *find_air(const struct parting *p, const struct tracer *tracer,
                              const struct place_world *world, bool *air)
{
    const size_t count = p->probes->rows;
    struct place place = {.count = count};
    enum place_side *side = NULL;
    struct error *err = array_create(&place.position, 3 * count, sizeof *place.position);
    if (!err)
        err = array_create(&side, count, sizeof *side);
    if (!err && tracer) {
        memcpy(place.position, p->position, 3 * count * sizeof *place.position);
        err = place_inside(&place, tracer, &world->inside, side, world->warnings);
    }
    for (size_t i = 0; i < count && !err; i++)
        air[i] = !tracer ||
                 (side[i] == PLACE_AIR && unlit_sees_surface(tracer, p->position + 3 * i));
    place_clear(&place);
    free(side);
    return err;
}

/* Lists the black ones that are in the air. */
static struct error *part(struct parting *p, const struct tracer *tracer,
                          const struct place_world *world, bool *lit)
{
    const size_t count = p->probes->rows;
    struct column *sh = NULL;
    struct order *order = NULL;
    bool *air = NULL;
    double sum = 0;
    struct error *err = find_light(p, &sh);
    if (!err)
        err = array_create(&order, count, sizeof *order);
    if (!err)
        err = array_create(&air, count, sizeof *air);
    if (!err)
        err = find_air(p, tracer, world, air);
    for (size_t i = 0; i < count && !err; i++)
        sum += luminance_f32(column_f32(sh) + sh->width * i);
    for (size_t i = 0; i < count && !err; i++) {
        const double bright = luminance_f32(column_f32(sh) + sh->width * i);
        lit[i] = bright > 0 && bright * (double)count >= UNLIT_SHARE * sum;
        if (lit[i] || !air[i])
            continue;
        memcpy(order[p->dark].at, p->position + 3 * i, sizeof order->at);
        order[p->dark++].row = (uint32_t)i;
    }
    if (!err) {
        qsort(order, p->dark, sizeof *order, compare);
        err = array_create(&p->list, p->dark, sizeof *p->list);
    }
    if (!err)
        err = array_create(&p->at, 3 * p->dark, sizeof *p->at);
    for (size_t i = 0; i < p->dark && !err; i++) {
        p->list[i] = order[i].row;
        memcpy(p->at + 3 * i, order[i].at, sizeof order->at);
    }
    free(order);
    free(air);
    return err;
}

/* Columns that place tells itself. */
static bool is_own(const char *name)
{
    return !strcmp(name, "position") || !strcmp(name, "origin") || !strcmp(name, "cluster") ||
           !strcmp(name, "inside");
}

/* Appends these rows. size: of the cluster that each stands for; 0: it is lit. */
static struct error *give(struct place *place, const struct parting *p, size_t count,
                          const uint32_t *row, const int32_t *size)
{
    const struct column *origin = table_column(p->probes, "origin");
    struct column *cluster = NULL;
    struct error *err = array_create(&place->origin, count, sizeof *place->origin);
    for (size_t i = 0; i < count && !err; i++) {
        place->origin[i] = size[i]  ? place_method_unlit.origin
                           : origin ? column_i32(origin)[row[i]]
                                    : -1;
        err = place_append(place, p->position + 3 * (size_t)row[i]);
    }
    for (size_t i = 0; i < p->probes->column_count && !err; i++) {
        const struct column *c = &p->probes->columns[i];
        if (!is_own(c->name))
            err = place_add_column(place, c->name, c->type, c->width, NULL);
    }
    if (!err)
        err = place_add_column(place, "cluster", COLUMN_I32, 1, &cluster);
    for (size_t i = 0; i < count && !err; i++) {
        table_copy_rows(&place->columns, i, p->probes, row[i], 1);
        column_i32(cluster)[i] = size[i];
    }
    return err;
}

/* Finds who stands for the black ones, and gives them behind those that are lit. */
static struct error *choose(struct place *place, const struct place_options *o,
                            const struct place_world *world, struct parting *p,
                            const struct tracer *tracer, const bool *lit)
{
    struct unlit_job job = {.count = p->dark,
                            .position = p->at,
                            .tracer = tracer,
                            .wanted = o->unlit,
                            .seed = world->seed};
    struct unlit_cluster *cluster = NULL;
    uint32_t *row = NULL;
    int32_t *size = NULL;
    size_t count = 0, clusters = 0, areas = 0;
    struct error *err = unlit_reach(p->probes->rows, p->position, p->dark, p->at, &job.reach);
    if (!err)
        err = unlit_find(&job, &cluster, &clusters, &areas);
    if (!err)
        err = array_create(&row, p->probes->rows, sizeof *row);
    if (!err)
        err = array_create(&size, p->probes->rows, sizeof *size);
    for (size_t i = 0; i < p->probes->rows && !err; i++)
        if (lit[i])
            row[count++] = (uint32_t)i;
    for (size_t i = 0; i < clusters && !err; i++) {
        size[count] = (int32_t)cluster[i].size;
        row[count++] = p->list[cluster[i].probe];
    }
    if (!err && !count)
        err = error_new("no probe has light, or sees a surface");
    if (!err)
        err = give(place, p, count, row, size);
    if (!err && world->program)
        unlit_tell(world->program, p->dark, areas, clusters);
    free(cluster);
    free(row);
    free(size);
    return err;
}

static struct error *find_probes(struct parting *p)
{
    struct column *position = NULL;
    cells_remove(p->stream);
    p->probes = stream_table(p->stream, "probe");
    if (!p->probes)
        return error_new("there is no table probe");
    struct error *err = table_require(p->probes, "position", COLUMN_F64, 3, &position);
    p->position = err ? NULL : column_f64(position);
    return err;
}

static struct error *thin_out_dark(struct place *place, const struct place_options *o,
                                   const struct place_world *world, struct parting *p)
{
    struct tracer *tracer = NULL;
    bool *lit = NULL;
    struct error *err = find_probes(p);
    if (!err && world->scene)
        err = trace_create(&tracer, world->scene);
    if (!err)
        err = array_create(&lit, p->probes->rows, sizeof *lit);
    if (!err)
        err = part(p, tracer, world, lit);
    if (!err)
        err = choose(place, o, world, p, tracer, lit);
    free(lit);
    trace_destroy(tracer);
    return err;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct parting p = {0};
    struct error *err = stream_read(&p.stream, world->file);
    if (err)
        return err;
    err = thin_out_dark(place, o, world, &p);
    place->from = p.stream;
    free(p.list);
    free(p.at);
    return error_wrap(err, "%s", strcmp(world->file, "-") ? world->file : "stdin");
}

const struct place_method place_method_unlit = {.name = "unlit",
                                                .file_of = "captured probes",
                                                .origin = 8,
                                                .rows = rows,
                                                .place = place_by_options};
