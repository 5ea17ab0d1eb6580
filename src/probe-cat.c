/* SPDX-License-Identifier: Apache-2.0 */
/* probe-cat: converts, merges, selects and describes probe streams, and converts their light. */
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "base/file.h"
#include "libprobe-query/sh.h"
#include "light/blend.h"
#include "light/convert.h"
#include "light/light_options.h"
#include "light/product.h"
#include "light/rotate.h"
#include "light/visibility.h"
#include "stream/common_options.h"
#include "stream/stream.h"
#include "stream/stream_edit.h"
#include "stream/stream_gather.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

static struct error *parse_rows(void *value, const char *text)
{
    return stream_selection_rows(value, text);
}

static struct error *parse_condition(void *value, const char *text)
{
    return stream_selection_add(value, text);
}

/* What is to be done with the streams. */
struct arguments {
    struct stream_selection selection;
    struct convert_settings convert;
    double matrix[9];          /* by which to turn */
    const char *product;       /* a column; NULL: none */
    bool rotate, rotate_light; /* all, or the light alone */
    double blend;              /* the weight of the second of two streams */
    bool blend_given;
    struct stream_sources from; /* names point into argv */
    size_t fill_capacity;
    bool info, no_provenance, occlusion;
    struct common common;
};

static struct error *parse_basis(void *value, const char *text)
{
    return basis_parse(value, text);
}

static struct error *parse_rotate(void *value, const char *text)
{
    struct arguments *a = value;
    a->rotate = true;
    return rotation_parse(a->matrix, "--rotate", text);
}

static struct error *parse_rotate_light(void *value, const char *text)
{
    struct arguments *a = value;
    a->rotate_light = true;
    return rotation_parse(a->matrix, "--rotate-light", text);
}

static struct error *parse_fill(void *value, const char *text)
{
    struct arguments *a = value;
    struct stream_sources *from = &a->from;
    struct error *err =
        array_reserve(&from->fills, &a->fill_capacity, from->fill_count + 1, sizeof *from->fills);
    if (!err)
        from->fills[from->fill_count++] = text;
    return err;
}

/* A stream as it is: block by block. */
static struct error *describe_all(const char *path)
{
    struct stream_reader *reader = NULL;
    struct error *err = stream_reader_open(&reader, path);
    if (!err)
        err = stream_describe(reader, stdout);
    stream_reader_close(reader);
    return err;
}

/* What is chosen of a stream. */
static struct error *describe_chosen(const char *path, const struct stream_selection *s,
                                     struct warnings *warnings)
{
    struct stream *stream = NULL;
    struct error *err = stream_read(&stream, path);
    if (!err)
        err = stream_select(stream, s, warnings);
    if (!err)
        err = stream_describe_whole(stream, stdout);
    stream_destroy(stream);
    return err;
}

static struct error *describe_one(const char *path, const struct stream_selection *s,
                                  struct warnings *warnings)
{
    const bool chosen = s->tables || s->columns || s->drop || stream_selection_is_whole(s);
    struct error *err = chosen ? describe_chosen(path, s, warnings) : describe_all(path);
    if (!err && (fflush(stdout) || ferror(stdout)))
        err = error_system(errno, "stdout");
    return err;
}

static struct error *describe(const struct arguments *a, struct warnings *warnings)
{
    struct error *err = NULL;
    for (size_t i = 0; i < a->from.count && !err; i++) {
        if (a->from.count > 1)
            printf("%s%s:\n", i ? "\n" : "", a->from.paths[i]);
        err = describe_one(a->from.paths[i], &a->selection, warnings);
    }
    return err;
}

static enum stream_encoding encoding_for(const struct common *common, enum stream_encoding read)
{
    return common->encoding == STREAM_AS_READ ? read : common->encoding;
}

static struct error *change_provenance(struct stream_header *header, const struct arguments *a,
                                       const char *recorded)
{
    if (!a->no_provenance)
        return header_add_provenance(header, recorded);
    for (size_t i = 0; i < header->provenance_count; i++)
        free(header->provenance[i]);
    header->provenance_count = 0;
    return NULL;
}

static bool is_converted(const struct arguments *a)
{
    return convert_is_asked(&a->convert) || a->rotate || a->rotate_light || a->blend_given ||
           a->product || a->occlusion;
}

/* One stream all of whose rows pass, as they are. */
static bool passes(const struct arguments *a)
{
    return a->from.count == 1 && !a->from.fill_count && !a->from.salvage &&
           !stream_selection_is_whole(&a->selection) && !is_converted(a);
}

/* That one: block by block. */
static struct error *pass(const struct arguments *a, const char *recorded)
{
    struct stream_reader *reader = NULL;
    struct stream_writer *writer = NULL;
    struct stream_header header = {0};
    struct error *err = stream_reader_open(&reader, a->from.paths[0]);
    if (!err)
        err = header_copy(&header, stream_reader_header(reader));
    if (!err)
        err = change_provenance(&header, a, recorded);
    if (!err)
        err = stream_writer_open(&writer, a->common.output,
                                 encoding_for(&a->common, stream_reader_encoding(reader)), &header);
    if (!err)
        err = stream_filter(reader, writer, &a->selection);
    if (!err)
        err = stream_writer_finish(writer);
    else
        stream_writer_abandon(writer);
    header_clear(&header);
    stream_reader_close(reader);
    return err;
}

/* The light of a stream and of another of its probes, as one. */
static struct error *blend(struct stream *all, const struct arguments *a, struct warnings *warnings)
{
    struct stream *other = NULL;
    if (!a->blend_given)
        return NULL;
    const char *path = a->from.paths[1];
    struct error *err = stream_read(&other, path);
    if (!err)
        err = error_wrap(blend_streams(all, other, a->blend, warnings), "--blend: %s and %s",
                         file_input_name(a->from.paths[0]), file_input_name(path));
    stream_destroy(other);
    return err;
}

static struct error *rotate(struct stream *all, const struct arguments *a,
                            struct warnings *warnings)
{
    struct rotation rotation;
    if (!a->rotate && !a->rotate_light)
        return NULL;
    struct error *err = rotation_init(&rotation, a->matrix);
    return err ? err : rotate_stream(all, &rotation, a->rotate_light, warnings);
}

static struct error *convert(struct stream *all, const struct arguments *a, const char *program,
                             struct warnings *warnings)
{
    struct convert_outcome outcome;
    struct error *err = convert_stream(all, &a->convert, a->common.threads, &outcome, warnings);
    if (!err && !a->common.quiet)
        convert_report(&a->convert, &outcome, program, stderr);
    return err;
}

/* Streams that are merged, filled, salvaged, blended or turned, whose light is converted, whose
 * rows are chosen or whose tables are put in order: in memory. */
static struct error *gather(const struct arguments *a, const struct program *program,
                            struct warnings *warnings)
{
    struct stream *all = NULL;
    struct stream_sources from = a->from;
    from.count = a->blend_given ? 1 : from.count;
    struct error *err = stream_gather(&all, &from, warnings);
    if (!err)
        err = blend(all, a, warnings);
    if (!err)
        err = rotate(all, a, warnings);
    if (!err && a->product)
        err = product_stream(all, a->product, warnings);
    if (!err && a->occlusion)
        err = error_wrap(visibility_derive(all), "--occlusion");
    if (!err)
        err = convert(all, a, program->name, warnings);
    if (!err)
        err = stream_select(all, &a->selection, warnings);
    if (!err)
        err = change_provenance(&all->header, a, program->recorded);
    if (!err)
        err = stream_write(all, a->common.output, encoding_for(&a->common, all->encoding));
    stream_destroy(all);
    return err;
}

/* What excludes each other. */
static struct error *check(const struct arguments *a)
{
    const struct convert_settings *c = &a->convert;
    struct error *err = light_dering_check(&c->dering);
    bool basis = false;
    for (int i = 0; i < BASIS_COUNT; i++)
        basis = basis || c->basis[i];
    if (!err && c->report && !basis)
        err = error_usage("--report is of --basis");
    if (!err)
        err = stream_selection_check(&a->selection);
    if (!err && a->rotate && a->rotate_light)
        err = error_usage("expected one of --rotate and --rotate-light, got both");
    if (!err && a->blend_given && a->from.count != 2)
        err = error_usage("--blend: expected two streams, got %zu", a->from.count);
    if (!err && a->info && (a->from.salvage || a->from.fill_count || is_converted(a)))
        err = error_usage("--info describes streams as they are: without --fill and --salvage, "
                          "and without conversions");
    return err;
}

static struct error *parse(struct program *program, struct arguments *a, int argc, char **argv)
{
    static const char *const contents[] = {[CONVERT_AS_IS] = "as-is",
                                           [CONVERT_RADIANCE] = "radiance",
                                           [CONVERT_IRRADIANCE] = "irradiance",
                                           NULL};
    struct stream_selection *s = &a->selection;
    const struct option_row rows[] = {
        {.name = "info",
         .letter = 'i',
         .kind = OPTION_FLAG,
         .value = &a->info,
         .help = "print what the streams hold instead (or what is chosen of them): tables,\n"
                 "columns, ranges, history"},
        {.name = "tables",
         .argument = "LIST",
         .kind = OPTION_TEXT,
         .value = &s->tables,
         .help = "keep these tables alone (probe, tet), in this order"},
        {.name = "columns",
         .argument = "LIST",
         .kind = OPTION_TEXT,
         .value = &s->columns,
         .help = "keep these columns alone, in this order"},
        {.name = "drop",
         .argument = "LIST",
         .kind = OPTION_TEXT,
         .value = &s->drop,
         .help = "drop these columns"},
        {.name = "rows",
         .argument = "FIRST:END[:STEP]",
         .kind = OPTION_CALL,
         .value = s,
         .parse = parse_rows,
         .shown = "all",
         .help = "keep these probes, counted from 0, END not included"},
        {.name = "captured",
         .kind = OPTION_SET,
         .count = ROWS_CAPTURED,
         .value = OPTION_ENUM(s->captured),
         .help = "keep the probes that have light"},
        {.name = "uncaptured",
         .kind = OPTION_SET,
         .count = ROWS_UNCAPTURED,
         .value = OPTION_ENUM(s->captured),
         .help = "keep the probes that have no light yet"},
        {.name = "where",
         .argument = "CONDITION",
         .kind = OPTION_CALL,
         .value = s,
         .parse = parse_condition,
         .help = "keep the probes for which CONDITION holds, as 'validity < 0.9' or 'position[1] "
                 ">= 2';\n"
                 "one of < <= > >= = !=; given more than once, all must hold"},
        {.name = "fill",
         .argument = "FILE",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_fill,
         .shown = "none",
         .help = "take what probes lack (light, columns) from the same probes in\n"
                 "the stream FILE; may repeat"},
        {.name = "salvage",
         .kind = OPTION_FLAG,
         .value = &a->from.salvage,
         .help = "of streams that were cut short, keep the probes up to the damage"},
        {.name = "blend",
         .argument = "W",
         .kind = OPTION_REAL,
         .value = &a->blend,
         .most = 1,
         .given = &a->blend_given,
         .shown = "none",
         .help = "of two streams of the same probes, make the light of the first\n"
                 "1 - W times its own plus W times that of the second"},
        {.name = "rotate",
         .argument = "X,Y,Z,DEGREES|MATRIX",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_rotate,
         .shown = "as it is",
         .help = "turn probes and light about the origin, by an axis and an angle, or\n"
                 "by nine numbers, a row of the matrix after the other"},
        {.name = "rotate-light",
         .argument = "X,Y,Z,DEGREES|MATRIX",
         .kind = OPTION_CALL,
         .value = a,
         .parse = parse_rotate_light,
         .shown = "as it is",
         .help = "turn the light alone: what comes to each probe, where it is"},
        {.name = "product",
         .argument = "COLUMN",
         .kind = OPTION_TEXT,
         .value = &a->product,
         .shown = "none",
         .help = "multiply the light of each probe by SH of its own, as of the sky\n"
                 "that it sees: column visibility"},
        {.name = "order",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &a->convert.order,
         .least = 1,
         .most = SH_ORDER_MAX,
         .shown = "as it is",
         .help = "cut SH to this order"},
        {0}};
    const struct option_row more[] = {
        {.name = "content",
         .argument = "WHAT",
         .kind = OPTION_CHOICE,
         .choices = contents,
         .value = OPTION_ENUM(a->convert.content),
         .help = "turn SH into those of radiance or irradiance"},
        {.name = "basis",
         .argument = "LIST",
         .kind = OPTION_CALL,
         .value = a->convert.basis,
         .parse = parse_basis,
         .shown = "none",
         .help = "add irradiance in other bases: cube, dice, dice-cubic, ahd"},
        {.name = "occlusion",
         .kind = OPTION_FLAG,
         .value = &a->occlusion,
         .help = "add ao, bent_normal, bent_length and cone of column visibility"},
        {.name = "report",
         .kind = OPTION_FLAG,
         .value = &a->convert.report,
         .help = "say on standard error how far each is from the SH"},
        {.name = "no-provenance",
         .kind = OPTION_FLAG,
         .value = &a->no_provenance,
         .help = "leave out the command lines that made the stream"},
        {0}};
    struct option_row dering[LIGHT_DERING_ROWS], shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, light_dering_rows(&a->convert.dering, dering), more,
        common_rows(&a->common, COMMON_STREAM | COMMON_THREADS, shared), NULL};
    option_row(dering, "dering")->help = /* as wide as the rest of this program's */
        "window each probe as little as keeps its irradiance, or its radiance,\n"
        "above --dering-floor in all directions";
    static const char *standard[] = {"-"};
    struct error *err = options_parse(program, groups, argc, argv);
    a->from.paths = program->operand_count ? program->operands : standard;
    a->from.count = program->operand_count ? (size_t)program->operand_count : 1;
    return err ? err : check(a);
}

int main(int argc, char **argv)
{
    struct arguments a = {.selection = {.step = 1, .end = -1}, .common = common_default()};
    struct program program = {
        .name = "probe-cat",
        .usage = "[OPTION]... [STREAM]...",
        .summary = "Converts probe streams between text and binary, merges several into one, fills "
                   "one from\n"
                   "others, salvages what was cut short, converts light, selects tables, columns "
                   "and probes,\n"
                   "or describes streams. Without STREAM reads standard input.",
        .operands_most = -1};
    struct warnings warnings = {0};
    struct error *err = parse(&program, &a, argc, argv);
    for (size_t i = 0; i < a.from.count; i++)
        claim_in_place(a.from.paths[i]);
    for (size_t i = 0; i < a.from.fill_count; i++)
        claim_in_place(a.from.fills[i]);
    if (!err && a.info)
        err = describe(&a, &warnings);
    else if (!err && passes(&a))
        err = pass(&a, program.recorded);
    else if (!err)
        err = gather(&a, &program, &warnings);
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    stream_selection_clear(&a.selection);
    free(a.from.fills);
    program_clear(&program);
    return error_exit(program.name, err);
}
