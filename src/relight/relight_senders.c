/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/relight_senders.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/threads.h"
#include "capture/capture.h"
#include "capture/senders.h"
#include "libprobe-query/sh.h"
#include "math/angle.h"
#include "relight/radiosity.h"
#include "relight/relight.h"
#include "scene/relit.h"
#include "scene/scene_settings.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024, CHUNK = 64 };

struct run {
    const struct relight_senders_ask *ask;
    struct warnings *warnings;
    struct stream_reader *reader;
    struct senders senders;
    struct stream *lit;           /* the senders, with light */
    double *node;                 /* radiance, 3 a node; owned */
    struct stream_reader *direct; /* NULL: there is none */
    struct stream_writer *writer;
    int rays;     /* of each probe's links */
    bool surface; /* probes are; and then: */
    size_t width; /* of their light: 3 */
    bool convolved;
};

/* -- what is read ------------------------------------------------------------------------------ */

/* That light comes straight from lights: links bring the rest. */
static struct error *check_direct(const struct stream_header *header)
{
    struct capture_settings was = capture_settings_default();
    if (!capture_header_has_settings(header))
        return error_new("expected light that was captured: probe-capture --bounces 0");
    struct error *err = capture_settings_from_header(&was, header);
    if (!err && was.bounces && was.light != CAPTURE_DIRECT)
        err = error_new("expected light that did not scatter (--bounces 0), got --bounces %d",
                        was.bounces);
    if (!err && was.light == CAPTURE_INDIRECT)
        err = error_new("expected light straight from lights, got --light indirect");
    if (!err && was.dering.target != DERING_NONE)
        err = error_new("expected light that was not de-rung (key sh-dering): de-ring what was "
                        "relit");
    return err;
}

/* Whether light is another where these keys differ. */
static bool is_of_light(const char *key)
{
    static const char *const beginnings[] = {"scene-key", "sky", "relit-", "weight-", "rotated"};
    for (size_t i = 0; i < sizeof beginnings / sizeof *beginnings; i++)
        if (!strncmp(key, beginnings[i], strlen(beginnings[i])))
            return strcmp(key, "sky-file") && strcmp(key, "sky-from-scene");
    return false;
}

static struct error *check_same_light(const struct stream_header *senders,
                                      const struct stream_header *direct)
{
    const struct stream_header *const both[] = {senders, direct};
    for (int turn = 0; turn < 2; turn++)
        for (size_t i = 0; i < both[turn]->key_count; i++) {
            const char *name = both[turn]->keys[i].name, *a = header_key(senders, name),
                       *b = header_key(direct, name);
            if (is_of_light(name) && (!a || !b || strcmp(a, b)))
                return error_new("its light is not that of the senders: %s is %s, and theirs is "
                                 "%s",
                                 name, b ? b : "none", a ? a : "none");
        }
    return NULL;
}

static struct error *check_lit(struct run *run)
{
    const struct table *table = stream_table(run->lit, "probe");
    struct column *light = NULL;
    if (!table)
        return error_new("expected table probe");
    struct error *err = check_direct(&run->lit->header);
    if (!err)
        err = table_require(table, "irradiance", COLUMN_F32, 3, &light);
    for (size_t i = 0; i < table->rows && !err; i++)
        if (isnan(column_f32(light)[3 * i]))
            err = error_new("sender %zu has no light: probe-capture captures what is missing", i);
    return err;
}

/* Finds what the senders scatter. */
static struct error *solve(struct run *run, struct table *schema)
{
    const struct table *lit = stream_table(run->lit, "probe");
    size_t got;
    struct error *err = stream_reader_rows(run->reader, schema, SIZE_MAX, &got);
    if (!err)
        err = senders_from_table(&run->senders, schema, stream_reader_header(run->reader));
    err = error_wrap(err, "the probes");
    if (!err)
        err = error_wrap(senders_check_same(&run->senders, lit), "%s", run->ask->senders);
    if (!err)
        err = array_create(&run->node, 3 * run->senders.tree.nodes, sizeof *run->node);
    if (!err)
        err = radiosity_solve(&run->senders, column_f32(table_column(lit, "irradiance")),
                              run->ask->bounces, run->ask->common->threads, run->node);
    return err;
}

/* -- rows -------------------------------------------------------------------------------------- */

/* A block of probes. */
struct block {
    const struct run *run;
    const float *transfer; /* width / 3 values a link */
    const int32_t *of;
    const float *direct, *direct_error; /* NULL: none */
    float *light, *error;
    size_t rows;
};

/* Adds the light of a row's links; power: sum over links of what a ray to it adds, squared. */
static struct error *add_links(const struct block *b, size_t row, double *sum, double power[3])
{
    const struct senders *s = &b->run->senders;
    const size_t functions = b->run->width / 3;
    const float *transfer = b->transfer + row * s->links * functions;
    const int32_t *of = b->of + row * s->links;
    const double solid =
        b->run->surface ? ANGLE_PI : sqrt(4 * ANGLE_PI) / (b->run->convolved ? sh_cosine(0) : 1);
    for (size_t k = 0; k < s->links && of[k]; k++) {
        if (of[k] < 0 || (size_t)of[k] >= s->tree.nodes)
            return error_new("column %s: expected 0 to %zu, got %d", SENDERS_OF, s->tree.nodes - 1,
                             (int)of[k]);
        const double *light = b->run->node + 3 * (size_t)of[k];
        for (size_t f = 0; f < functions; f++)
            for (size_t c = 0; c < 3; c++)
                sum[3 * f + c] += (double)transfer[k * functions + f] * light[c];
        for (size_t c = 0; c < 3; c++)
            power[c] += solid * (double)transfer[k * functions] * light[c] * light[c];
    }
    return NULL;
}

/* Variances of the links' noise, as of rays that are independent. */
static void add_noise(const struct block *b, const double *sum, const double power[3],
                      double *variance)
{
    const int order = b->run->surface ? 1 : sh_order_of(b->run->width);
    for (int l = 0; l < order; l++)
        for (size_t c = 0; c < 3; c++) {
            const double a = b->run->convolved ? sh_cosine(l) : 1;
            double square = 0;
            for (int i = l * l; i < (l + 1) * (l + 1); i++)
                square += sum[3 * (size_t)i + c] * sum[3 * (size_t)i + c] / (2 * l + 1);
            for (int i = l * l; i < (l + 1) * (l + 1); i++)
                variance[3 * (size_t)i + c] = fmax(a * a * power[c] - square, 0) / b->run->rays;
        }
}

static struct error *light_row(const struct block *b, size_t row)
{
    const size_t width = b->run->width;
    double sum[3 * SH_COUNT_MAX] = {0}, variance[3 * SH_COUNT_MAX] = {0}, power[3] = {0};
    float *light = b->light + row * width, *error = b->error ? b->error + row * width : NULL;
    if (isnan(b->transfer[row * b->run->senders.links * width / 3]) ||
        (b->direct && isnan(b->direct[row * width]))) {
        for (size_t i = 0; i < width; i++)
            light[i] = NAN;
        for (size_t i = 0; i < width && error; i++)
            error[i] = NAN;
        return NULL;
    }
    struct error *err = add_links(b, row, sum, power);
    if (err)
        return err;
    add_noise(b, sum, power, variance);
    for (size_t i = 0; i < width; i++)
        light[i] = (float)(sum[i] + (b->direct ? (double)b->direct[row * width + i] : 0));
    for (size_t i = 0; i < width && error; i++) {
        const double of = b->direct_error ? (double)b->direct_error[row * width + i] : 0;
        error[i] = (float)sqrt(variance[i] + of * of);
    }
    return NULL;
}

static struct error *light_rows(void *context, size_t index, int thread)
{
    const struct block *b = context;
    struct error *err = NULL;
    (void)thread;
    for (size_t row = index * CHUNK; row < b->rows && row < (index + 1) * CHUNK && !err; row++)
        err = light_row(b, row);
    return err;
}

/* -- tables ------------------------------------------------------------------------------------ */

static const char *light_name(const struct run *run)
{
    return run->surface ? "irradiance" : "sh";
}

static const char *error_name(const struct run *run)
{
    return run->surface ? "irradiance_error" : "sh_error";
}

static struct error *make_schema(struct run *run, const struct table *schema, struct table *out)
{
    size_t functions = 0;
    struct error *err = senders_find_columns(&run->senders, schema, &functions);
    run->surface = table_column(schema, "normal");
    run->width = 3 * functions;
    if (!err && (run->surface ? functions != 1 : !sh_order_of(run->width)))
        err = error_new("column %s: expected %s values a link, got %zu", SENDERS_TRANSFER,
                        run->surface ? "1" : "n^2", functions);
    if (!err)
        err = table_copy_schema(out, schema);
    if (!err)
        relight_drop_parts(out, run->ask->keep, run->warnings);
    const struct column *light = err ? NULL : table_column(out, light_name(run));
    if (!err && (!light || light->width != run->width))
        err = table_add_column(out, light_name(run), COLUMN_F32, run->width, NULL);
    if (!err && !table_column(out, error_name(run)))
        err = table_add_column(out, error_name(run), COLUMN_F32, run->width, NULL);
    return err;
}

/* Opens table probe of the direct light. */
static struct error *open_direct(struct run *run, struct table *direct)
{
    bool more = true;
    struct column *light = NULL;
    struct error *err = NULL;
    while (!err && more) {
        table_clear(direct);
        err = stream_reader_next_table(run->direct, direct, &more);
        if (!err && more && !strcmp(direct->name, "probe"))
            break;
    }
    if (!err && !more)
        err = error_new("expected table probe");
    return err ? err : table_require(direct, light_name(run), COLUMN_F32, run->width, &light);
}

/* The next rows of the direct light, which are to be the same probes. */
static struct error *read_direct(struct run *run, const struct table *probes, size_t first,
                                 struct table *direct)
{
    size_t got = 1;
    struct error *err = table_resize(direct, 0);
    while (!err && got && direct->rows < probes->rows)
        err = stream_reader_rows(run->direct, direct, probes->rows - direct->rows, &got);
    if (!err && direct->rows < probes->rows)
        err = error_new("expected the same probes, got %zu of them", first + direct->rows);
    for (size_t i = 0; i < probes->rows && !err; i++) {
        const double *p = column_f64(table_column(probes, "position")) + 3 * i,
                     *q = column_f64(table_column(direct, "position")) + 3 * i;
        if (memcmp(p, q, 3 * sizeof *p))
            err = error_new("expected the same probes in the same order: probe %zu is at "
                            "%g,%g,%g, and at %g,%g,%g in the stream to be relit",
                            first + i, q[0], q[1], q[2], p[0], p[1], p[2]);
    }
    return error_wrap(err, "%s", run->ask->direct);
}

static struct error *light_block(const struct run *run, const struct table *in,
                                 const struct table *direct, struct table *out)
{
    const struct column *of = run->direct ? table_column(direct, light_name(run)) : NULL,
                        *error = run->direct ? table_column(direct, error_name(run)) : NULL;
    struct error *err = table_resize(out, in->rows);
    if (err)
        return err;
    table_copy_rows(out, 0, in, 0, in->rows);
    struct block b = {.run = run,
                      .transfer = column_f32(table_column(in, SENDERS_TRANSFER)),
                      .of = column_i32(table_column(in, SENDERS_OF)),
                      .direct = of ? column_f32(of) : NULL,
                      .direct_error = error ? column_f32(error) : NULL,
                      .light = column_f32(table_column(out, light_name(run))),
                      .error = column_f32(table_column(out, error_name(run))),
                      .rows = in->rows};
    return threads_for(run->ask->common->threads, (in->rows + CHUNK - 1) / CHUNK, light_rows, &b);
}

static struct error *do_probes(struct run *run, struct table *in)
{
    struct table out = {0}, direct = {0};
    if (!run->node)
        return error_new("expected table %s before table probe", SENDERS_TABLE);
    struct error *err = make_schema(run, in, &out);
    if (!err && run->direct)
        err = error_wrap(open_direct(run, &direct), "%s", run->ask->direct);
    if (!err)
        err = stream_writer_table(run->writer, &out);
    for (size_t got = 1, first = 0; !err && got; first += got) {
        err = table_resize(in, 0);
        if (!err)
            err = stream_reader_rows(run->reader, in, BLOCK, &got);
        if (!err && run->direct)
            err = read_direct(run, in, first, &direct);
        if (!err)
            err = light_block(run, in, &direct, &out);
        if (!err)
            err = stream_writer_rows(run->writer, &out, 0, got);
    }
    table_clear(&out);
    table_clear(&direct);
    return err;
}

/* Table sender is read, and kept where that is asked for. */
static struct error *do_senders(struct run *run, struct table *schema)
{
    struct error *err = solve(run, schema);
    if (!err && run->ask->keep)
        err = stream_writer_table(run->writer, schema);
    if (!err && run->ask->keep)
        err = stream_writer_rows(run->writer, schema, 0, schema->rows);
    return err;
}

static struct error *do_tables(struct run *run)
{
    struct error *err = NULL;
    for (bool more = true; more && !err;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        if (!err && more)
            err = !strcmp(schema.name, "probe")         ? do_probes(run, &schema)
                  : !strcmp(schema.name, SENDERS_TABLE) ? do_senders(run, &schema)
                  : !strcmp(schema.name, LIGHT_BASIS_TABLE)
                      ? NULL
                      : stream_copy_table(run->reader, run->writer, &schema);
        table_clear(&schema);
    }
    return err;
}

/* -- header ------------------------------------------------------------------------------------ */

/* The header's light is that of the senders; what it says of the probes stays. */
static struct error *make_header(const struct run *run, struct stream_header *header)
{
    const struct stream_header *lit = &run->lit->header;
    const char *key = header_key(lit, "scene-key");
    struct scene_settings settings = scene_settings_default();
    struct error *err = header_copy(header, stream_reader_header(run->reader));
    if (err)
        return err;
    relit_remove(header);
    header_remove_key(header, "sh-dering");
    for (size_t k = header->key_count; k-- > 0;) {
        const char *name = header->keys[k].name;
        const bool of_links = !strcmp(name, SENDERS_KEY) || !strcmp(name, SENDERS_LINKS_KEY);
        if (light_key_is_split(name) && !(of_links && run->ask->keep))
            header_remove_key(header, name);
    }
    err = scene_settings_from_header(&settings, lit);
    if (!err)
        err = scene_settings_to_header(&settings, header);
    scene_settings_clear(&settings);
    for (size_t k = 0; k < lit->key_count && !err; k++)
        if (!strncmp(lit->keys[k].name, "relit-", 6) || !strncmp(lit->keys[k].name, "weight-", 7))
            err = header_set_key(header, lit->keys[k].name, lit->keys[k].value);
    if (!err && key)
        err = header_set_key(header, "scene-key", key);
    if (!err)
        err = header_set_key(header, "capture-light",
                             capture_light_names[run->direct ? CAPTURE_ALL : CAPTURE_INDIRECT]);
    if (!err)
        err = header_set_whole(header, "capture-bounces", run->ask->bounces);
    return err ? err : header_add_provenance(header, run->ask->recorded);
}

static struct error *open_inputs(struct run *run, const char *input)
{
    const struct relight_senders_ask *a = run->ask;
    struct error *err = stream_reader_open(&run->reader, input);
    if (err)
        return err;
    const struct stream_header *header = stream_reader_header(run->reader);
    struct capture_settings was = capture_settings_default();
    if (!header_key(header, SENDERS_KEY))
        err = error_new("the probes have no links to senders (key %s): probe-capture --transfer "
                        "surfaces:SENDERS makes them",
                        SENDERS_KEY);
    if (!err)
        err = capture_settings_from_header(&was, header);
    run->rays = was.rays;
    run->convolved = was.convolved;
    err = error_wrap(err, "%s", file_input_name(input));
    if (!err)
        err = stream_read(&run->lit, a->senders);
    if (!err)
        err = error_wrap(check_lit(run), "%s", a->senders);
    if (err || !a->direct)
        return err;
    err = stream_reader_open(&run->direct, a->direct);
    if (err)
        return err;
    const struct stream_header *direct = stream_reader_header(run->direct);
    struct capture_settings also = was;
    err = check_direct(direct);
    if (!err)
        err = capture_settings_from_header(&also, direct);
    if (!err && also.convolved != was.convolved)
        err = error_new("its sh-content is %s, and that of the stream to be relit another",
                        header_key(direct, "sh-content"));
    if (!err)
        err = check_same_light(&run->lit->header, direct);
    return error_wrap(err, "%s", a->direct);
}

static struct error *run_all(struct run *run, const char *input)
{
    const enum stream_encoding asked = run->ask->common->encoding;
    struct stream_header header = {0};
    struct error *err = open_inputs(run, input);
    if (!err)
        err = make_header(run, &header);
    if (!err)
        err = stream_writer_open(
            &run->writer, run->ask->common->output,
            asked == STREAM_AS_READ ? stream_reader_encoding(run->reader) : asked, &header);
    header_clear(&header);
    return err ? err : do_tables(run);
}

struct error *relight_senders(const struct relight_senders_ask *ask, const char *input,
                              struct warnings *warnings)
{
    struct run run = {.ask = ask, .warnings = warnings};
    struct error *err = run_all(&run, input);
    if (!err)
        err = stream_writer_finish(run.writer);
    else
        stream_writer_abandon(run.writer);
    senders_clear(&run.senders);
    stream_destroy(run.lit);
    stream_reader_close(run.reader);
    stream_reader_close(run.direct);
    free(run.node);
    return err;
}
