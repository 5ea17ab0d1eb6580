/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/relight_stream.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/warning.h"
#include "relight/compressed.h"
#include "relight/relight.h"
#include "relight/weights.h"
#include "scene/relit.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK_BYTES = 4 << 20, BLOCK_ROWS_MOST = 4096 };

/* -- outputs ---------------------------------------------------------------------------------- */

/* One stream that is written. */
struct output {
    struct stream_writer *writer;
    struct table table; /* of probes */
    char *path;
    double *weight;           /* three a part */
    struct other_light light; /* of this row */
};

struct run {
    const struct relight_ask *ask;
    struct warnings *warnings;
    const char *input; /* its name in messages */
    struct stream_reader *reader;
    struct relight relight;
    struct weights weights;
    struct output *output; /* one a row of weights */
};

/* The place of %s in a pattern; NULL: it has none. */
static const char *find_place(const char *pattern)
{
    return strstr(pattern, "%s");
}

bool relight_is_pattern(const char *output)
{
    return find_place(output);
}

static struct error *name_output(const struct run *run, size_t row, char **path)
{
    const char *pattern = run->ask->common.output, *place = find_place(pattern);
    if (!place) {
        *path = strdup(pattern);
        return *path ? NULL : error_memory();
    }
    char *name = weights_row_name(&run->weights, row);
    struct error *err = name ? NULL : error_memory();
    if (!err && (!*name || strchr(name, '/') || *name == '.'))
        err = error_new("row '%s': expected a name that a file can have, without /", name);
    if (!err && asprintf(path, "%.*s%s%s", (int)(place - pattern), pattern, name, place + 2) < 0) {
        *path = NULL;
        err = error_memory();
    }
    for (size_t r = 0; r < row && !err; r++)
        if (!strcmp(run->output[r].path, *path))
            err = error_new("rows %zu and %zu are both called '%s'", r, row, name);
    free(name);
    return err;
}

static struct error *check_pattern(const struct run *run)
{
    const struct relight_ask *a = run->ask;
    const char *place = find_place(a->common.output);
    if (run->weights.rows > 1 && !place)
        return error_usage("%s has %zu rows: expected --row, or --output with %%s for the name of "
                           "each, as 'evening-%%s.probe'",
                           a->table, run->weights.rows);
    if (place && find_place(place + 2))
        return error_usage("--output: expected one %%s, got '%s'", a->common.output);
    return NULL;
}

/* -- weights of groups ------------------------------------------------------------------------ */

/* Whether the stream was captured under a sky that shines. */
static struct error *captured_sky(const struct stream_header *header, bool *shines)
{
    double rgb[3] = {0};
    struct error *err = header_get_reals(header, "sky", 3, 0, 1e300, rgb);
    *shines = header_key(header, "sky-file") || rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0;
    return err;
}

/* The group that has the sky, and whether it has nothing else. */
static size_t group_of_sky(const struct light_groups *groups, bool *alone)
{
    size_t group = groups->count - 1; /* the rest */
    for (size_t g = groups->count; g-- > 0;)
        for (size_t t = 0; t < groups->list[g].term_count; t++)
            if (groups->list[g].term[t].kind == GROUP_SKY)
                group = g;
    const struct light_group *of = &groups->list[group];
    *alone = of->term_count > 0;
    for (size_t t = 0; t < of->term_count; t++)
        *alone = *alone && of->term[t].kind == GROUP_SKY;
    return group;
}

static bool is_zero(const double weight[3])
{
    return weight[0] == 0 && weight[1] == 0 && weight[2] == 0;
}

/* A scene has one sky: the captured one gives way to the one that is asked for. weight: a row's. */
static struct error *replace_sky(const struct run *run, double *weight)
{
    const struct light_groups *groups = &run->relight.groups;
    bool shines = false, alone = false;
    struct error *err = captured_sky(stream_reader_header(run->reader), &shines);
    if (err || !shines)
        return err;
    if (run->relight.whole)
        return error_new("the light was captured under a sky, and is no group of its own: expected "
                         "a stream of --groups, or of a black sky, to put another in its place");
    const size_t group = group_of_sky(groups, &alone);
    if (!alone && !is_zero(weight + 3 * group))
        return error_new("group %s has the sky of the capture, which --sky replaces, and other "
                         "light: expected weight 0, or a sky in a group of its own",
                         run->weights.group[group]);
    if (alone)
        warnings_add(run->warnings, "sky replaced",
                     "group %s, the sky of the capture, gives way to --sky: its weight is 0",
                     run->weights.group[group]);
    memset(weight + 3 * group, 0, 3 * sizeof *weight);
    return NULL;
}

static void warn_negative(const struct run *run)
{
    const struct weights *w = &run->weights;
    for (size_t i = 0; i < 3 * w->rows * w->groups; i++)
        if (w->weight[i] < 0) {
            warnings_add(run->warnings, "negative",
                         "group %s has a weight below 0: light is taken away, and no truth of it "
                         "can be traced",
                         w->group[i / 3 % w->groups]);
            return;
        }
}

static struct error *weigh_groups(struct run *run)
{
    static char rest[] = "rest", *const only[] = {rest};
    const struct relight_ask *a = run->ask;
    struct relight *r = &run->relight;
    struct error *err =
        weights_init(&run->weights, r->whole ? 1 : r->groups.count, r->whole ? only : r->names);
    if (!err && a->table)
        err = weights_read(&run->weights, a->table);
    for (size_t i = 0; i < a->settings && !err; i++)
        err = weights_set(&run->weights, a->setting[i]);
    if (!err && a->row)
        err = weights_choose(&run->weights, a->row);
    if (!err)
        warn_negative(run);
    return err;
}

/* -- streams ---------------------------------------------------------------------------------- */

static struct error *make_header(const struct run *run, const struct output *out,
                                 struct stream_header *header)
{
    const struct relight_ask *a = run->ask;
    struct error *err = header_copy(header, stream_reader_header(run->reader));
    if (err)
        return err;
    relit_remove(header);
    err = relit_weights_to_header(&run->relight.groups, out->weight, header);
    if (!err)
        err = other_light_to_header(&out->light, &run->relight,
                                    out->weight + 3 * run->weights.groups, header);
    const char *lost = header_key(header, COMPRESSED_ERROR_KEY);
    if (!err && lost)
        err = header_set_key(header, COMPRESSED_RELIT_ERROR_KEY, lost);
    for (size_t k = header->key_count; k-- > 0 && !a->keep;)
        if (light_key_is_split(header->keys[k].name))
            header_remove_key(header, header->keys[k].name);
    return err ? err : header_add_provenance(header, a->recorded);
}

/* Fills what a row of the table, and the command line, say of an output. */
static struct error *weigh_output(struct run *run, size_t row, struct output *out)
{
    const struct weights *w = &run->weights;
    char *const *option = w->option + row * WEIGHTS_OPTIONS;
    struct error *err =
        array_create(&out->weight, 3 * relight_parts(&run->relight), sizeof *out->weight);
    if (err)
        return err;
    memcpy(out->weight, w->weight + 3 * row * w->groups, 3 * w->groups * sizeof(double));
    err = other_light_of_row(&out->light, &run->ask->light, option[WEIGHTS_SKY],
                             option[WEIGHTS_SUN], option[WEIGHTS_POINT], option[WEIGHTS_TIME]);
    if (!err)
        err = other_light_weigh(&out->light, &run->relight, out->weight + 3 * w->groups,
                                run->warnings);
    if (!err && other_light_has_sky(&out->light))
        err = replace_sky(run, out->weight);
    return err;
}

static struct error *open_output(struct run *run, size_t row)
{
    struct output *out = &run->output[row];
    const enum stream_encoding asked = run->ask->common.encoding;
    struct stream_header header = {0};
    struct error *err = weigh_output(run, row, out);
    if (err && run->weights.rows > 1) {
        char *name = weights_row_name(&run->weights, row);
        err = error_wrap(err, "row '%s'", name ? name : "");
        free(name);
    }
    if (!err)
        err = name_output(run, row, &out->path);
    if (!err)
        err = make_header(run, out, &header);
    if (!err)
        err = stream_writer_open(
            &out->writer, out->path,
            asked == STREAM_AS_READ ? stream_reader_encoding(run->reader) : asked, &header);
    header_clear(&header);
    return err;
}

static size_t block_rows(const struct table *schema)
{
    size_t bytes = 1;
    for (size_t c = 0; c < schema->column_count; c++)
        bytes += schema->columns[c].width * column_type_size(schema->columns[c].type);
    const size_t rows = BLOCK_BYTES / bytes;
    return rows < 1 ? 1 : rows > BLOCK_ROWS_MOST ? BLOCK_ROWS_MOST : rows;
}

/* The tables of a block of rows, for each output. */
static struct error *write_rows(struct run *run, const struct table *in, bool probes)
{
    struct error *err = NULL;
    for (size_t r = 0; r < run->weights.rows && !err; r++) {
        struct output *out = &run->output[r];
        if (probes)
            err =
                relight_rows(&run->relight, out->weight, in, &out->table, run->ask->common.threads);
        if (!err)
            err = stream_writer_rows(out->writer, probes ? &out->table : in, 0, in->rows);
    }
    return err;
}

static struct error *start_tables(struct run *run, const struct table *schema, bool probes)
{
    struct error *err = NULL;
    if (probes)
        err = error_wrap(relight_find(&run->relight, schema), "%s", run->input);
    for (size_t r = 0; r < run->weights.rows && !err; r++) {
        struct output *out = &run->output[r];
        /* each says the same */
        struct warnings *warnings = r ? NULL : run->warnings;
        if (probes)
            err = relight_schema(&run->relight, schema, &out->table, warnings);
        if (!err)
            err = stream_writer_table(out->writer, probes ? &out->table : schema);
    }
    return err;
}

static struct error *do_table(struct run *run, struct table *schema)
{
    const bool probes = !strcmp(schema->name, "probe");
    const size_t most = block_rows(schema);
    struct error *err = start_tables(run, schema, probes);
    for (size_t got = 1; got && !err;) {
        err = table_resize(schema, 0);
        if (!err)
            err = stream_reader_rows(run->reader, schema, most, &got);
        if (!err && got)
            err = write_rows(run, schema, probes);
    }
    return err;
}

/* The basis of a compressed stream, which the probes need. */
static struct error *do_basis(struct run *run, struct table *basis)
{
    size_t got;
    struct error *err = stream_reader_rows(run->reader, basis, SIZE_MAX, &got);
    for (size_t r = 0; r < run->weights.rows && run->ask->keep && !err; r++) {
        err = stream_writer_table(run->output[r].writer, basis);
        if (!err)
            err = stream_writer_rows(run->output[r].writer, basis, 0, basis->rows);
    }
    if (!err)
        err =
            error_wrap(relight_take_basis(&run->relight, stream_reader_header(run->reader), basis),
                       "%s", run->input);
    return err;
}

static struct error *do_stream(struct run *run)
{
    struct error *err = array_create(&run->output, run->weights.rows, sizeof *run->output);
    if (!err)
        err = error_wrap(file_make_room(run->weights.rows), "%s",
                         run->ask->table ? run->ask->table : "--weights");
    for (size_t r = 0; r < run->weights.rows && !err; r++)
        err = open_output(run, r);
    for (bool more = true; more && !err;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        const bool basis = !err && more && run->relight.compressed &&
                           !strcmp(schema.name, COMPRESSED_TABLE);
        const bool senders = !err && more && !strcmp(schema.name, LIGHT_SENDERS_TABLE);
        if (!err && more && (!senders || run->ask->keep))
            err = basis ? do_basis(run, &schema) : do_table(run, &schema);
        table_clear(&schema);
    }
    for (size_t r = 0; run->output && r < run->weights.rows; r++) {
        struct output *out = &run->output[r];
        if (!err)
            err = stream_writer_finish(out->writer);
        else
            stream_writer_abandon(out->writer);
        table_clear(&out->table);
        free(out->path);
        free(out->weight);
        other_light_clear(&out->light);
    }
    return err;
}

static struct error *run_all(struct run *run, const char *input)
{
    const struct relight_ask *a = run->ask;
    struct error *err = stream_reader_open(&run->reader, input);
    if (err)
        return err;
    err = relight_from_header(&run->relight, stream_reader_header(run->reader));
    if (!err && a->keep && run->relight.whole)
        err = error_new("--keep needs groups: the light that the stream has is overwritten");
    run->input = file_input_name(input);
    err = error_wrap(err, "%s", run->input);
    run->relight.keep = a->keep;
    if (!err)
        err = weigh_groups(run);
    if (!err)
        err = check_pattern(run);
    return err ? err : do_stream(run);
}

struct error *relight_stream(const struct relight_ask *ask, const char *input,
                             struct warnings *warnings)
{
    struct run run = {.ask = ask, .warnings = warnings};
    struct error *err = run_all(&run, input);
    weights_clear(&run.weights);
    relight_clear(&run.relight);
    stream_reader_close(run.reader);
    free(run.output);
    return err;
}
