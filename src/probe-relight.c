/* SPDX-License-Identifier: Apache-2.0 */
/* probe-relight: gives probes other light, as weights of what was captured of groups of lights, of
 * a sky and of suns, without tracing again. */
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "relight/compress.h"
#include "relight/compressed.h"
#include "relight/other_light.h"
#include "relight/pca.h"
#include "relight/relight.h"
#include "relight/weights.h"
#include "scene/relit.h"
#include "stream/common_options.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK_BYTES = 4 << 20, BLOCK_ROWS_MOST = 4096 };

/* What is asked for. Texts point into argv. */
struct arguments {
    const char *table;    /* of weights; NULL: none */
    const char **setting; /* NAME=w; owned */
    size_t settings, setting_capacity;
    const char *row;
    struct other_light light;
    bool keep;
    const char *compress; /* how many vectors, or "table"; NULL: relight */
    int clusters;
    bool clusters_given;
    struct common common;
};

static struct error *parse_weights(void *value, const char *text)
{
    struct arguments *a = value;
    if (!weights_is_setting(text)) {
        if (a->table)
            return error_usage("--weights: expected one table, got '%s' and '%s'", a->table, text);
        a->table = text;
        return NULL;
    }
    struct error *err =
        array_reserve(&a->setting, &a->setting_capacity, a->settings + 1, sizeof *a->setting);
    if (!err)
        a->setting[a->settings++] = text;
    return err;
}

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
    const struct arguments *arguments;
    const struct program *program;
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

static struct error *name_output(const struct run *run, size_t row, char **path)
{
    const char *pattern = run->arguments->common.output, *place = find_place(pattern);
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
    const struct arguments *a = run->arguments;
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
    const struct arguments *a = run->arguments;
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
    const struct arguments *a = run->arguments;
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
    return err ? err : header_add_provenance(header, run->program->recorded);
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
    err = other_light_of_row(&out->light, &run->arguments->light, option[WEIGHTS_SKY],
                             option[WEIGHTS_SUN], option[WEIGHTS_TIME]);
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
    const enum stream_encoding asked = run->arguments->common.encoding;
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
            err = relight_rows(&run->relight, out->weight, in, &out->table,
                               run->arguments->common.threads);
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
    for (size_t r = 0; r < run->weights.rows && run->arguments->keep && !err; r++) {
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
    for (size_t r = 0; r < run->weights.rows && !err; r++)
        err = open_output(run, r);
    for (bool more = true; more && !err;) {
        struct table schema = {0};
        err = stream_reader_next_table(run->reader, &schema, &more);
        const bool basis = !err && more && run->relight.compressed &&
                           !strcmp(schema.name, COMPRESSED_TABLE);
        if (!err && more)
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

static struct error *relight(struct run *run, const char *input)
{
    const struct arguments *a = run->arguments;
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

/* -- compression ------------------------------------------------------------------------------ */

static struct error *compress(const struct run *run, const char *input)
{
    const struct arguments *a = run->arguments;
    struct stream *stream = NULL;
    char *end;
    const size_t vectors = strtoul(a->compress, &end, 10);
    struct error *err = stream_read(&stream, input);
    if (err)
        return err;
    if (!strcmp(a->compress, "table"))
        err = compress_table(stream, (size_t)a->clusters, stdout, a->common.threads);
    else
        err = compress_stream(stream, vectors, (size_t)a->clusters, a->common.threads);
    err = error_wrap(err, "%s", file_input_name(input));
    if (!err && strcmp(a->compress, "table")) {
        err = header_add_provenance(&stream->header, run->program->recorded);
        if (!err)
            err = stream_write(stream, a->common.output, a->common.encoding);
    } else if (!err && (fflush(stdout) || ferror(stdout))) {
        err = error_system(errno, "stdout");
    }
    stream_destroy(stream);
    return err;
}

/* -- the command line ------------------------------------------------------------------------- */

enum { LIGHT_ROWS = 6 };

/* The rows of the sky and the suns, as the programs that trace have them. */
static void light_rows(struct arguments *a, struct option_row rows[LIGHT_ROWS + 1])
{
    static const char *const names[LIGHT_ROWS] = {"sky",    "sky-map",   "sky-turn",
                                                  "sky-up", "sky-scale", "sun"};
    struct option_row all[SCENE_SETTINGS_ROWS];
    scene_settings_rows(&a->light.settings, all);
    for (size_t i = 0; i < LIGHT_ROWS; i++)
        rows[i] = *option_row(all, names[i]);
    rows[0].help = "the sky, in place of the captured one: one colour, or a\n"
                   "panorama (Radiance .hdr, OpenEXR)";
    rows[0].shown = "none";
    rows[LIGHT_ROWS] = (struct option_row){0};
}

static struct error *check_compress(const struct arguments *a, const struct program *program)
{
    static const char *const fine[] = {"compress", "clusters", "output", "text",
                                       "binary",   "threads",  "quiet"};
    if (!a->compress)
        return a->clusters_given ? error_usage("--clusters needs --compress") : NULL;
    char *end;
    const long vectors = strtol(a->compress, &end, 10);
    const bool table = !strcmp(a->compress, "table");
    if (!table && (*end || end == a->compress || vectors < 1 || vectors > PCA_VECTORS_MOST))
        return error_usage("--compress: expected 1 to %d vectors, or table, got '%s'",
                           PCA_VECTORS_MOST, a->compress);
    if (table && strcmp(a->common.output, "-"))
        return error_usage("--compress table is written to standard output: expected no --output");
    for (size_t i = 0; i < program->given_count; i++) {
        bool is_fine = false;
        for (size_t k = 0; k < sizeof fine / sizeof *fine; k++)
            is_fine = is_fine || !strcmp(program->given[i].row->name, fine[k]);
        if (!is_fine)
            return error_usage("--compress does not relight: expected no --%s",
                               program->given[i].row->name);
    }
    return NULL;
}

static struct error *check(const struct arguments *a)
{
    if (a->row && !a->table)
        return error_usage("--row needs a table: --weights FILE");
    if (a->light.sky_probe && a->light.settings.sky_given)
        return error_usage("expected one of --sky and --sky-probe, got both");
    if (a->light.time_given && !a->light.sun_path)
        return error_usage("--time needs --sun-path");
    if (a->light.sun_path && !a->light.time_given && !a->table)
        return error_usage("--sun-path needs --time");
    return NULL;
}

static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    static const char *const ways[] = {[SUN_PATH] = "path", [SUN_SPHERE] = "sphere", NULL};
    const struct option_row rows[] = {
        {.name = "weights",
         .letter = 'w',
         .argument = "NAME=W|NAME=R,G,B|FILE",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_weights,
         .shown = "1 each",
         .help = "what the light of group NAME is multiplied by; may repeat;\n"
                 "or a table of weights, each row of which is an output"},
        {.name = "row",
         .argument = "NAME|N",
         .kind = OPTION_TEXT,
         .value = &a->row,
         .shown = "all",
         .help = "of the table, this row alone, by its name or its number\n"
                 "from 0; without it --output is to have a %s for the name"},
        {0}};
    const struct option_row more[] = {
        {.name = "sky-probe",
         .argument = "STREAM",
         .kind = OPTION_TEXT,
         .value = &a->light.sky_probe,
         .shown = "none",
         .help = "the sky is the light of the one probe of STREAM: that of an\n"
                 "object that stands there"},
        {.name = "time",
         .argument = "T",
         .kind = OPTION_REAL,
         .value = &a->light.time,
         .given = &a->light.time_given,
         .shown = "none",
         .help = "a sun where the path has it at this time"},
        {.name = "sun-path",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->light.sun_path,
         .shown = "none",
         .help = "lines of time, azimuth, elevation (degrees), R G B"},
        {.name = "sun-between",
         .argument = "WAY",
         .kind = OPTION_CHOICE,
         .value = OPTION_ENUM(a->light.between),
         .choices = ways,
         .help = "how the captured suns stand: path, one after the other;\n"
                 "sphere, anywhere"},
        {.name = "keep",
         .kind = OPTION_FLAG,
         .value = &a->keep,
         .help = "keep the columns of groups and transfers"},
        {.name = "compress",
         .argument = "K|table",
         .kind = OPTION_TEXT,
         .value = &a->compress,
         .shown = "none",
         .help = "do not relight: store groups and transfers as K numbers a\n"
                 "probe; table: print what 1, 2, 4 ... lose"},
        {.name = "clusters",
         .argument = "C",
         .kind = OPTION_INT,
         .value = &a->clusters,
         .least = 1,
         .most = PCA_CLUSTERS_MOST,
         .given = &a->clusters_given,
         .help = "with vectors of their own for each of C clusters of probes"},
        {0}};
    struct option_row light[LIGHT_ROWS + 1], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, light, more, common_rows(&a->common, COMMON_STREAM | COMMON_THREADS, shared), NULL};
    light_rows(a, light);
    struct error *err = options_parse(program, groups, argc, argv);
    if (!err)
        err = check_compress(a, program);
    return err ? err : check(a);
}

int main(int argc, char **argv)
{
    struct arguments a = {
        .light = other_light_default(), .clusters = 1, .common = common_default()};
    struct program program = {
        .name = "probe-relight",
        .usage = "[OPTION]... [STREAM]",
        .summary = "Gives the probes of STREAM (standard input) other light: weights of the groups "
                   "of lights that\n"
                   "probe-capture --groups captured, and a sky and suns by what --transfer did, "
                   "without tracing.",
        .operands_most = 1};
    struct warnings warnings = {0};
    struct error *err = parse(&program, &a, argc, argv);
    struct run run = {.arguments = &a, .program = &program, .warnings = &warnings};
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    if (!err && a.table)
        err = file_inputs_differ(a.table, "the weights", input, "the probes");
    if (!err && a.light.sky_probe)
        err = file_inputs_differ(a.light.sky_probe, "the sky's probe", input, "the probes");
    if (!find_place(a.common.output)) /* a row's name is no word that its input may go */
        claim_in_place(input);
    if (!err)
        err = a.compress ? compress(&run, input) : relight(&run, input);
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    weights_clear(&run.weights);
    relight_clear(&run.relight);
    stream_reader_close(run.reader);
    other_light_clear(&a.light);
    free(run.output);
    free(a.setting);
    program_clear(&program);
    return error_exit(program.name, err);
}
