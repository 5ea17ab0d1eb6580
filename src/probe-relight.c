/* SPDX-License-Identifier: Apache-2.0 */
/* probe-relight: gives probes other light, as weights of what was captured of groups of lights, of
 * a sky and of suns, without tracing again. */
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "relight/compress.h"
#include "relight/pca.h"
#include "relight/relight_senders.h"
#include "relight/relight_stream.h"
#include "relight/weights.h"
#include "stream/stream.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct arguments {
    struct relight_ask ask; /* texts point into argv */
    size_t setting_capacity;
    bool compress; /* in place of relighting */
    int vectors;   /* 0: a table of what they lose */
    int clusters;
    bool clusters_given;
    struct relight_senders_ask senders; /* in place of groups and other light, where it is given */
    bool bounces_given;
};

static struct error *parse_weights(void *value, const char *text)
{
    struct arguments *a = value;
    struct relight_ask *ask = &a->ask;
    if (!weights_is_setting(text)) {
        if (ask->table)
            return error_usage("--weights: expected one table, got '%s' and '%s'", ask->table,
                               text);
        ask->table = text;
        return NULL;
    }
    struct error *err =
        array_reserve(&ask->setting, &a->setting_capacity, ask->settings + 1, sizeof *ask->setting);
    if (!err)
        ask->setting[ask->settings++] = text;
    return err;
}

static struct error *parse_compress(void *value, const char *text)
{
    struct arguments *a = value;
    a->compress = true;
    a->vectors = 0;
    if (!strcmp(text, "table"))
        return NULL;
    char *end;
    const long vectors = strtol(text, &end, 10);
    if (*end || end == text || vectors < 1 || vectors > PCA_VECTORS_MOST)
        return error_usage("--compress: expected 1 to %d vectors, or table, got '%s'",
                           PCA_VECTORS_MOST, text);
    a->vectors = (int)vectors;
    return NULL;
}

static struct error *compress(const struct arguments *a, const char *input)
{
    const struct common *common = &a->ask.common;
    struct stream *stream = NULL;
    struct error *err = stream_read(&stream, input);
    if (err)
        return err;
    if (a->vectors)
        err = compress_stream(stream, (size_t)a->vectors, (size_t)a->clusters, common->threads);
    else
        err = compress_table(stream, (size_t)a->clusters, stdout, common->threads);
    err = error_wrap(err, "%s", file_input_name(input));
    if (!err && a->vectors) {
        err = header_add_provenance(&stream->header, a->ask.recorded);
        if (!err)
            err = stream_write(stream, common->output, common->encoding);
    } else if (!err && (fflush(stdout) || ferror(stdout))) {
        err = error_system(errno, "stdout");
    }
    stream_destroy(stream);
    return err;
}

static struct error *do_senders(struct arguments *a, const char *input, struct warnings *warnings)
{
    a->senders.keep = a->ask.keep;
    a->senders.recorded = a->ask.recorded;
    a->senders.common = &a->ask.common;
    return relight_senders(&a->senders, input, warnings);
}

/* -- the command line ------------------------------------------------------------------------- */

enum { LIGHT_ROWS = 7 };

/* The rows of the sky and the lights, as the programs that trace have them. */
static void light_rows(struct arguments *a, struct option_row rows[LIGHT_ROWS + 1])
{
    static const char *const names[LIGHT_ROWS] = {"sky",       "sky-map", "sky-turn", "sky-up",
                                                  "sky-scale", "sun",     "point"};
    struct option_row all[SCENE_SETTINGS_ROWS];
    scene_settings_rows(&a->ask.light.settings, all);
    for (size_t i = 0; i < LIGHT_ROWS; i++)
        rows[i] = *option_row(all, names[i]);
    rows[0].help = "the sky, in place of the captured one: one colour, or a\n"
                   "panorama (Radiance .hdr, OpenEXR)";
    rows[0].shown = "none";
    rows[LIGHT_ROWS] = (struct option_row){0};
}

/* That no options were given but these, a list that ends with NULL, and those of all programs. */
static struct error *check_alone(const struct program *program, const char *const *fine,
                                 const char *why)
{
    static const char *const always[] = {"output", "text", "binary", "threads", "quiet", NULL};
    for (size_t i = 0; i < program->given_count; i++) {
        const char *name = program->given[i].row->name;
        bool is_fine = false;
        for (const char *const *k = fine; *k && !is_fine; k++)
            is_fine = !strcmp(name, *k);
        for (const char *const *k = always; *k && !is_fine; k++)
            is_fine = !strcmp(name, *k);
        if (!is_fine)
            return error_usage("%s: expected no --%s", why, name);
    }
    return NULL;
}

static struct error *check_compress(const struct arguments *a, const struct program *program)
{
    static const char *const fine[] = {"compress", "clusters", NULL};
    if (!a->compress)
        return a->clusters_given ? error_usage("--clusters needs --compress") : NULL;
    if (!a->vectors && strcmp(a->ask.common.output, "-"))
        return error_usage("--compress table is written to standard output: expected no --output");
    return check_alone(program, fine, "--compress does not relight");
}

static struct error *check_senders(const struct arguments *a, const struct program *program)
{
    static const char *const fine[] = {"senders", "direct", "bounces", "keep", NULL};
    if (a->senders.senders)
        return check_alone(program, fine, "--senders has all light in its stream");
    if (a->senders.direct || a->bounces_given)
        return error_usage("--%s needs --senders", a->senders.direct ? "direct" : "bounces");
    return NULL;
}

static struct error *check(const struct relight_ask *a)
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
         .value = &a->ask.row,
         .shown = "all",
         .help = "of the table, this row alone, by its name or its number\n"
                 "from 0; without it --output is to have a %s for the name"},
        {0}};
    const struct option_row more[] = {
        {.name = "sky-probe",
         .argument = "STREAM",
         .kind = OPTION_TEXT,
         .value = &a->ask.light.sky_probe,
         .shown = "none",
         .help = "the sky is the light of the one probe of STREAM: that of an\n"
                 "object that stands there"},
        {.name = "time",
         .argument = "T",
         .kind = OPTION_REAL,
         .value = &a->ask.light.time,
         .given = &a->ask.light.time_given,
         .shown = "none",
         .help = "a sun where the path has it at this time"},
        {.name = "sun-path",
         .argument = "FILE",
         .kind = OPTION_TEXT,
         .value = &a->ask.light.sun_path,
         .shown = "none",
         .help = "lines of time, azimuth, elevation (degrees), R G B"},
        {.name = "sun-between",
         .argument = "WAY",
         .kind = OPTION_CHOICE,
         .value = OPTION_ENUM(a->ask.light.between),
         .choices = ways,
         .help = "how the captured suns stand: path, one after the other;\n"
                 "sphere, anywhere"},
        {.name = "senders",
         .argument = "STREAM",
         .kind = OPTION_TEXT,
         .value = &a->senders.senders,
         .shown = "none",
         .help = "the light that surfaces scatter, by --transfer surfaces: its\n"
                 "senders, with light of probe-capture --bounces 0"},
        {.name = "direct",
         .argument = "STREAM",
         .kind = OPTION_TEXT,
         .value = &a->senders.direct,
         .shown = "none",
         .help = "and what comes straight: the probes, with such light"},
        {.name = "bounces",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a->senders.bounces,
         .given = &a->bounces_given,
         .most = CAPTURE_BOUNCES_MOST,
         .help = "of --senders: how often light scatters on its way"},
        {.name = "keep",
         .kind = OPTION_FLAG,
         .value = &a->ask.keep,
         .help = "keep the columns of groups and transfers"},
        {.name = "compress",
         .argument = "K|table",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_compress,
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
        rows, light, more, common_rows(&a->ask.common, COMMON_STREAM | COMMON_THREADS, shared),
        NULL};
    light_rows(a, light);
    struct error *err = options_parse(program, groups, argc, argv);
    if (!err)
        err = check_compress(a, program);
    if (!err)
        err = check_senders(a, program);
    return err ? err : check(&a->ask);
}

int main(int argc, char **argv)
{
    struct arguments a = {.ask = {.light = other_light_default(), .common = common_default()},
                          .clusters = 1,
                          .senders = {.bounces = 64}};
    struct relight_ask *ask = &a.ask;
    struct program program = {
        .name = "probe-relight",
        .usage = "[OPTION]... [STREAM]",
        .summary = "Gives the probes of STREAM (standard input) other light: weights of the groups "
                   "of lights that\n"
                   "probe-capture --groups captured, and a sky, suns and lamps by what --transfer "
                   "did, without tracing.",
        .operands_most = 1};
    struct warnings warnings = {0};
    struct error *err = parse(&program, &a, argc, argv);
    ask->recorded = program.recorded;
    const char *input = !err && program.operand_count ? program.operands[0] : "-";
    if (!err && ask->table)
        err = file_inputs_differ(ask->table, "the weights", input, "the probes");
    if (!err && ask->light.sky_probe)
        err = file_inputs_differ(ask->light.sky_probe, "the sky's probe", input, "the probes");
    if (!err && a.senders.senders)
        err = file_inputs_differ(a.senders.senders, "--senders", input, "the probes");
    if (!err && a.senders.direct)
        err = file_inputs_differ(a.senders.direct, "--direct", input, "the probes");
    if (!relight_is_pattern(ask->common.output)) /* a row's name is no word that its input may go */
        claim_in_place(input);
    if (!err)
        err = a.compress          ? compress(&a, input)
              : a.senders.senders ? do_senders(&a, input, &warnings)
                                  : relight_stream(ask, input, &warnings);
    if (!ask->common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    other_light_clear(&ask->light);
    free(ask->setting);
    program_clear(&program);
    return error_exit(program.name, err);
}
